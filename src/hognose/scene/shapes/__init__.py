"""Obstacles that a task file describes itself."""
