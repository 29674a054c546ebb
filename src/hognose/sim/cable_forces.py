"""What the cables pull while the arm moves: springs with a damper that only pull, and the torques of the joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.mjcf_cables import DAMPING
from hognose.kernels import kernel
from hognose.mechanics import Mechanics
from hognose.mechanics.cables import jacobian_at

Array = NDArray[np.float64]


@kernel()
def _pull(
    angles: NDArray,
    rates: NDArray,
    joints: NDArray,
    sections: NDArray,
    holes: NDArray,
    straight: NDArray,
    stiff: NDArray,
    free: float,
    damping: float,
    commanded: NDArray,
    speeds: NDArray,
    lengths: NDArray,
    jacobian: NDArray,
    tensions: NDArray,
    torques: NDArray,
) -> None:
    """Fill lengths (c,), their derivatives (c, 2n), tensions (c,) and torques (2n,) of a pose and its rates."""
    lengths[:] = straight
    jacobian_at(angles, joints, sections, holes, lengths, jacobian)
    torques[:] = 0.0
    for k in range(sections.size):
        passed = 2 * (sections[k] + 1)
        faster = -speeds[k]
        for i in range(passed):
            faster += jacobian[k, i] * rates[i]
        pull = stiff[k] * (lengths[k] - commanded[k]) / (lengths[k] + free) + damping * faster
        tensions[k] = max(pull, 0.0)
        for i in range(passed):
            torques[i] -= jacobian[k, i] * tensions[k]


@dataclass(frozen=True, eq=False)
class CableForces:
    """The cables of an arm, and what they do at the moment.

    Attributes
    ----------
    mechanics
    lengths : (c,) m
    jacobian : (c, 2n) m/rad
    tensions : (c,) N
    torques : (2n,) N m
        All four are written anew by `pull`.
    """

    mechanics: Mechanics
    lengths: Array
    jacobian: Array
    tensions: Array
    torques: Array

    @classmethod
    def of(cls, mechanics: Mechanics) -> CableForces:
        """The cables of an arm."""
        c, n = mechanics.robot.cables, mechanics.robot.sections
        return cls(mechanics, np.zeros(c), np.zeros((c, 2 * n)), np.zeros(c), np.zeros(2 * n))

    def pull(self, angles: Array, rates: Array, commanded: Array, speeds: Array) -> Array:
        """Torques (2n,) N m at angles (n, 2) rad that change at rates (2n,) rad/s.

        The motors hold the cables at lengths (c,) m without tension, which change at speeds (c,) m/s.
        """
        mechanics = self.mechanics
        springs = (mechanics.axial_stiffness, mechanics.free_length, DAMPING, commanded, speeds)
        out = (self.lengths, self.jacobian, self.tensions, self.torques)
        _pull(angles, rates, *mechanics.layout, *springs, *out)
        return self.torques
