"""Task to plan, and the checks a plan must pass."""
