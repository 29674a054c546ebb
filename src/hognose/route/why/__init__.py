"""Why there is no route, and what would help."""
