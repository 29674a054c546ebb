"""A plan in the browser: a scene that can be turned, and the plan's numbers beside it."""
