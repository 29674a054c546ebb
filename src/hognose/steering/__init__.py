"""Driving the arm by its nose: the path grows behind it."""

from hognose.steering.limits import Held
from hognose.steering.move import Move
from hognose.steering.steered_path import SteeredPath
from hognose.steering.steered_task import SteeredTask

__all__ = ["Held", "Move", "SteeredPath", "SteeredTask"]
