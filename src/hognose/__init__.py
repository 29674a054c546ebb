"""Hognose."""
