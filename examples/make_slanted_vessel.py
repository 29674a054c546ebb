"""Writes `slanted_vessel.stl`, the vessel of example 7: `python examples/make_slanted_vessel.py`.

A box in the frame of its plant, in mm: y points up, and the origin is a column of the building. The roof has a nozzle
that is 30 degrees off the vertical; a ledge and a beam are inside.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

#: The middle of the nozzle in the roof, and the direction in which the arm enters: down, and towards +x.
ENTRANCE, DIRECTION = np.array([4200.0, 2600.0, 1500.0]), np.array([0.5, -np.sqrt(0.75), 0.0])
LOW, HIGH, WALL = np.array([3900.0, 1450.0, 1100.0]), np.array([5300.0, 2600.0, 1900.0]), 8.0


def vessel() -> trimesh.Trimesh:
    """Shell with its nozzle, ledge and beam."""
    shell = box(LOW, HIGH).difference(box(LOW + WALL, HIGH - WALL))
    nozzle = cylinder(73.0, -150.0, 60.0).difference(box(LOW - 900.0, HIGH + np.array([900.0, -WALL, 900.0])))
    opened = shell.union(nozzle).difference(cylinder(65.0, -250.0, 60.0))
    ledge = box([3908.0, 2080.0, 1108.0], [4320.0, 2100.0, 1892.0])
    beam = box([4620.0, 2080.0, 1108.0], [4700.0, 2160.0, 1892.0])
    made = trimesh.util.concatenate([opened, ledge, beam])
    assert isinstance(made, trimesh.Trimesh)
    return made


def box(low: np.typing.ArrayLike, high: np.typing.ArrayLike) -> trimesh.Trimesh:
    """A box between two corners."""
    return trimesh.creation.box(bounds=np.array([low, high]))


def cylinder(radius: float, start: float, end: float) -> trimesh.Trimesh:
    """Round the line on which the arm enters, between two places on it (mm behind the entrance)."""
    ends = ENTRANCE + np.array([[start], [end]]) * DIRECTION
    return trimesh.creation.cylinder(radius, segment=ends, sections=64)


if __name__ == "__main__":
    file = Path(__file__).with_name("slanted_vessel.stl")
    vessel().export(file)
    print(f"written to {file}")
