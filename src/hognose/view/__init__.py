"""Looking at a plan: figures, a report, and an animation.

Nothing is imported here: drawing leans on matplotlib, which is slow to import, so take what you need from
`hognose.view.figures`, `hognose.view.report`, `hognose.view.animation` and `hognose.view.render`.
"""
