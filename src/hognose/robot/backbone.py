"""What a section bends back with by itself: a continuum arm's rod or tube, or flexures as joints.

A section of pitch L and bending stiffness EI holds the energy EI (α² + β²) / (2 L). Along an arc of constant curvature
that is a rod's, with θ² = α² + β². Spread evenly over k joints, each with a spring of k EI / L and 1/k of the angles,
it is the same; and of two hinges, each with EI / L. So one number says it of every kind, and a stack of ever more
joints becomes the arc.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot.robot import Robot


def bending_springs(robot: Robot) -> NDArray[np.float64]:
    """Spring constants EI / L (n,) N m/rad of α and of β of every section; 0 where none is given."""
    groups = [group for group in robot.spec.section for _ in range(group.count)]
    return np.array([(group.bending_stiffness_N_m2 or 0.0) / group.pitch for group in groups])
