"""Looking at a plan: figures, a report, and an animation.

Nothing is imported here: drawing leans on matplotlib, which is slow to import, so take what you need from
`hognose.report.figures`, `hognose.report.report`, `hognose.report.animation` and `hognose.report.render`.
"""
