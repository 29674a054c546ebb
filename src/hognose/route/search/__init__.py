"""From a target to passages, and from passages to routes."""
