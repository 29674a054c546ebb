"""The curve through way-points, its equal-distance points, and the detour round a collision."""

from hognose.path.path import Path

__all__ = ["Path"]
