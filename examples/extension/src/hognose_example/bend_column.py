"""A column of plan files: the sum of all bends at every step."""

from __future__ import annotations

from hognose.planning.columns import Quantity
from hognose_example.total_bend import bends

COLUMN = Quantity("total_bend_rad", "rad", "sum of the bends of all joints", bends)
