"""Studies on the twin: what it reached as a motion, its pictures, and the paper's experiments, also on drives."""

from hognose.studies.reached import reached

__all__ = ["reached"]
