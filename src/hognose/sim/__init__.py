"""The twin: the arm with its cables, its weight and what it runs into, moving as MuJoCo integrates it."""

from hognose.sim.changes import Changes, random_zeros
from hognose.sim.log import write_log
from hognose.sim.run import SimulationInterrupted, simulate
from hognose.sim.simulated import ContactStop, Simulated, Touched
from hognose.sim.twin import Twin

__all__ = [
    "Changes",
    "ContactStop",
    "Simulated",
    "SimulationInterrupted",
    "Touched",
    "Twin",
    "random_zeros",
    "simulate",
    "write_log",
]
