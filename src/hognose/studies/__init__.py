"""Studies on the twin: what it reached as a motion, its pictures, and both experiments of the paper."""

from hognose.studies.reached import reached

__all__ = ["reached"]
