"""Comparing the following methods: a suite of paths, what is measured on them, and the pages that show it.

`hognose bench` runs it. From Python: `suite.run_suite`, then `pages.write_page`.
"""
