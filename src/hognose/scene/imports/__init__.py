"""Obstacles from files: one file a format, and what becomes of what they hold."""
