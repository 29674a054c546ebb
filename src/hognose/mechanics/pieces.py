"""What of an arm has a weight: the pieces of its sections, see `hognose.robot.sections.kind.Piece`.

The mass of a section is spread evenly along its pitch, unless `centre_of_mass` says at which place of the centre line
all of it is. Along a link that is the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: The centre of mass of a piece whose mass is spread along a curve; the column of masses.
SPREAD, MASS = -1.0, 5


class Weight(NamedTuple):
    """A piece with its mass; lengths in m.

    Attributes
    ----------
    section
        To which it belongs, 0-based.
    alpha, beta
        Its shares of the section's angles.
    length
    curved
        1 where it is an arc, else 0.
    mass : kg
    centre
        How far along it the mass is; `SPREAD` where it is spread along an arc.
    """

    section: float
    alpha: float
    beta: float
    length: float
    curved: float
    mass: float
    centre: float


def weights_of(robot: Robot, links: Array) -> Array:
    """The pieces (p, 7) of an arm, each a `Weight`, from lengths, masses and centres of mass (n, 3) of its sections."""
    if not isinstance(robot.model, MixedSections):
        rows = [Weight(i, 1.0, 1.0, length, 0.0, mass, centre) for i, (length, mass, centre) in enumerate(links)]
        return np.array(rows, dtype=np.float64)
    model, rows = robot.model, []
    groups = [group for group in robot.spec.section for _ in range(group.count)]
    for i, group in enumerate(groups):
        begin, mass = 0.0, float(links[i, 1])
        for alpha, beta, length, curved in model.table[model.first[i] : model.first[i + 1]].tolist():
            own = min(length, group.pitch - begin)  # without the tool
            if group.centre_of_mass is None:
                share, centre = own / group.pitch, (SPREAD if curved else own / 2)
            else:
                centre = float(links[i, 2]) - begin
                last = begin + own >= group.pitch * (1.0 - 1e-12)
                share = float((0.0 <= centre < own) or (last and centre >= own))
            rows.append(Weight(i, alpha, beta, length, curved, share * mass, centre if share else 0.0))
            begin += own
    return np.array(rows, dtype=np.float64)
