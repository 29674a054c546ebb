"""The twin: the arm with its cables, its weight and what it runs into, moving as MuJoCo integrates it."""

from hognose.sim.run import Simulated, simulate
from hognose.sim.twin import Changes, Twin

__all__ = ["Changes", "Simulated", "Twin", "simulate"]
