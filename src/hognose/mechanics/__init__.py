"""Will the arm hold it: cables as springs, weight, stiffness, buckling, and the pose in which an arm comes to rest."""

from hognose.mechanics.mechanics import Mechanics, why_unknown
from hognose.mechanics.postures import postures
from hognose.mechanics.states import Held, Settled
from hognose.mechanics.statics import AT_LIMIT, STABLE, UNSETTLED
from hognose.mechanics.tensions import HELD, NOT_HELD, UNDECIDED

__all__ = [
    "AT_LIMIT",
    "HELD",
    "NOT_HELD",
    "STABLE",
    "UNDECIDED",
    "UNSETTLED",
    "Held",
    "Mechanics",
    "Settled",
    "postures",
    "why_unknown",
]
