"""A route from the entrance to a target: passages are searched, a spline is fitted to each, the planner verifies it."""

from hognose.route.planning import plan
from hognose.route.search.search import Found, Search

__all__ = ["Found", "Search", "plan"]
