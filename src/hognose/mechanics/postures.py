"""What of an arm changes with the lengths of its sections, where these extend.

A posture of such an arm has a third column beside α and β: how many times as long as at rest each section is, 1 of all
that do not extend. Lengths are held by the backbones, which are taken as rigid along themselves: they are no
coordinates of the energy, but they change what cables run along, where masses are, and what backbones bend back with.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import floats
from hognose.errors import InputError
from hognose.kernels import kernel
from hognose.robot import Robot
from hognose.robot.extension import as_long

Array = NDArray[np.float64]

#: The column of a posture that says how long sections are, and that of a `CableLaw` with the length of an arc.
LONG, _ARC = 2, 4


@kernel()
def lay_joints(posture: NDArray, joints: NDArray, out: NDArray) -> None:
    """Write how cables run through the sections of an arm, its `CableLaw`s (n, 6), in a posture (n, 3)."""
    for j in range(joints.shape[0]):
        out[j, _ARC] = joints[j, _ARC] * posture[j, LONG]


@kernel()
def lay_runs(posture: NDArray, joints: NDArray, sections: NDArray, straight: NDArray, out: NDArray) -> None:
    """Write what (c,) m of the cables of an arm is between joints in a posture (n, 3); joints are those at rest."""
    for k in range(sections.size):
        out[k] = straight[k]
        for j in range(sections[k] + 1):
            out[k] += joints[j, _ARC] * (posture[j, LONG] - 1.0)


@kernel()
def lay_pieces(posture: NDArray, pieces: NDArray, out: NDArray) -> None:
    """Write pieces (p, 7) of an arm, each a `Weight`, as they are in a posture (n, 3)."""
    for p in range(pieces.shape[0]):
        times = posture[int(pieces[p, 0]), LONG]
        out[p, 3] = pieces[p, 3] * times
        if pieces[p, 6] > 0.0:
            out[p, 6] = pieces[p, 6] * times


def postures(robot: Robot, angles: ArrayLike, lengths: ArrayLike | None) -> Array:
    """Postures (T, n, 3) of angles (T, n, 2) rad and section lengths (T, n) m; angles alone of robots of one length.

    Without lengths sections are as long as at rest.

    Raises
    ------
    InputError
        Wrong shapes, values that are not finite, or lengths that the robot's sections cannot have.
    """
    bent, rest = floats("angles", angles, f"(T, {robot.sections}, {LONG})", "rad"), robot.link_lengths
    own = None if lengths is None else as_long(robot.name, lengths, bent.shape[:1], rest, robot.length_bounds)
    if not robot.extends:
        return bent
    times = np.ones(bent.shape[:2])
    if own is not None:
        np.divide(own, rest, out=times, where=robot.extending)
    return np.concatenate([bent, times[..., None]], axis=2)


def angles_of(postures: Array) -> Array:
    """Angles (T, n, 2) rad of postures."""
    return postures if postures.shape[2] == LONG else np.ascontiguousarray(postures[..., :LONG])


def times_of(postures: Array) -> Array:
    """How many times as long as at rest (T, n) sections are; 1 of arms that do not extend."""
    return np.ones(postures.shape[:2]) if postures.shape[2] == LONG else postures[..., LONG]


def checked(robot: Robot, given: ArrayLike) -> Array:
    """Angles (T, n, 2) rad or postures (T, n, 3) of a robot.

    Raises
    ------
    InputError
        Wrong shape, values that are not finite, or postures whose third column no section of the robot can have.
    """
    if not (robot.extends and np.ndim(given) == LONG + 1 and np.shape(given)[-1] == LONG + 1):
        return floats("angles", given, f"(T, {robot.sections}, {LONG})", "rad")
    postures = floats("angles", given, f"(T, {robot.sections}, {LONG + 1})", "")
    if not (postures[..., LONG] > 0.0).all() or (postures[:, ~robot.extending, LONG] != 1.0).any():
        raise InputError(
            "angles: the third column of postures says how many times as long as at rest sections are: above 0, and 1 "
            f"of those of {robot.name} that keep their length; `hognose.mechanics.postures` makes them"
        )
    return postures
