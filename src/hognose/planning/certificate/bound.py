"""Clearance between the steps: a lower bound for the continuous motion, not a denser sampling.

Two motions lie between two set-points: the joints glide along the path (what the method means), or feed and
joint angles are interpolated linearly (what drives do). For both, a point of a link moves from where it is at
one step to where it is at the next along nearly a straight line. With d₀, d₁ the clearances at the two steps, m
the largest distance an end of the link travels and E how far its motion can bulge from the straight line, no
point of the link comes closer to an obstacle in between than

    (d₀ + d₁ - m) / 2 - E .

Where that is not good enough the step is halved. Derivation of the bound and of E: `docs/certificate.md`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.following.exact import Exact
from hognose.kernels import kernel
from hognose.path import Path
from hognose.robot import Robot
from hognose.robot.kinematics import turned
from hognose.scene import Scene
from hognose.ties import first_smallest

Array = NDArray[np.float64]

#: The bound is tightened until it is this close (m) to the smallest clearance that was seen …
TIGHTNESS = 2.5e-4
#: … or closer, down to this (m), where that proves that the margin is kept.
TIGHTEST = 2e-5
#: A step is halved at most this often.
MOST_HALVINGS = 16


@dataclass(frozen=True)
class Certificate:
    """A proven lower bound of the clearance over a whole continuous motion.

    Attributes
    ----------
    clearance : m
        No link comes closer to an obstacle than this, at any time.
    step, link
        Where the bound is worst: after this row of the plan, on this link (0-based).
    halvings
        Configurations that were looked at besides the steps.
    """

    clearance: float
    step: int
    link: int
    halvings: int


@dataclass(frozen=True)
class _Pieces:
    """Intervals of the motion: parameters (m, p), positions (m, n+1, 3), clearances (m, n) at both ends."""

    step: NDArray[np.int64]
    low: Array
    high: Array
    low_body: Array
    high_body: Array
    low_clearance: Array
    high_clearance: Array

    def chosen(self, rows: NDArray[np.bool_]) -> _Pieces:
        return _Pieces(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


def certify_gliding(
    path: Path,
    robot: Robot,
    scene: Scene,
    feeds: Array,
    joints: Array,
    clearance: Array,
    horizon: float,
    margin: float = math.inf,
) -> Certificate | None:
    """The certificate of the joints gliding along the path between feeds (T,), joints (T, n+1, 3) on it.

    Where only a tighter bound proves the margin (m), it is tightened so far. None where the path turns so sharply
    within a link that the joints may jump.
    """
    exact = Exact(path, robot.link_lengths)
    if not exact.tracks:
        return None
    arcs = exact.run_with_arcs(feeds)[1]

    def place(parameters: Array) -> tuple[Array, Array]:
        order = np.argsort(parameters[:, 0])
        body, on_path = np.empty((len(order), robot.sections + 1, 3)), np.empty((len(order), robot.sections + 1))
        body[order], on_path[order] = exact.run_with_arcs(parameters[order, 0])
        return on_path, body

    def travel(pieces: _Pieces) -> tuple[Array, Array]:
        return np.abs(pieces.high - pieces.low), np.zeros_like(pieces.low)

    return _certify(place, travel, scene, robot.body_radii, arcs, joints, clearance, horizon, margin)


def certify_interpolated(
    robot: Robot,
    scene: Scene,
    start: Array,
    feeds: Array,
    angles: Array,
    body: Array,
    clearance: Array,
    horizon: float,
    margin: float = math.inf,
) -> Certificate:
    """The certificate of feed and joint angles interpolated linearly between the steps.

    Where only a tighter bound proves the margin (m), it is tightened so far.
    """
    sections = robot.sections
    parameters = np.concatenate([feeds[:, None], angles.reshape(len(feeds), -1)], axis=1)

    def place(parameters: Array) -> tuple[Array, Array]:
        body = robot.joint_positions(parameters[:, 1:].reshape(-1, sections, 2), parameters[:, 0])
        return parameters, body + start

    def travel(pieces: _Pieces) -> tuple[Array, Array]:
        bulge = np.empty(pieces.low_body.shape[:2])
        low, high = (np.ascontiguousarray(side[:, 1:]).reshape(-1, sections, 2) for side in (pieces.low, pieces.high))
        _bulges(low, high, robot.link_lengths, bulge)
        return np.linalg.norm(pieces.high_body - pieces.low_body, axis=2), bulge

    return _certify(place, travel, scene, robot.body_radii, parameters, body, clearance, horizon, margin)


@kernel()
def _bulges(low: NDArray, high: NDArray, lengths: NDArray, out: NDArray) -> None:
    """How far (m) each joint can leave its straight line while angles (m, n, 2) go linearly from low to high.

    A motion leaves the chord of its ends by at most an eighth of its largest acceleration, which is summed up
    along the arm from bounds of each link's angular speed and acceleration (docs/certificate.md).
    """
    for m in range(low.shape[0]):
        xx, xy, xz = 1.0, 0.0, 0.0
        yx, yy, yz = 0.0, 1.0, 0.0
        zx, zy, zz = 0.0, 0.0, 1.0
        spin_x, spin_y, spin_z = 0.0, 0.0, 0.0
        angular_acceleration, angular_speed, acceleration = 0.0, 0.0, 0.0
        out[m, 0] = 0.0
        for i in range(lengths.size):
            alpha, beta = low[m, i, 0], low[m, i, 1]
            a, b = high[m, i, 0] - alpha, high[m, i, 1] - beta
            # alpha turns about the old y axis, beta about the new x axis.
            spin_x, spin_y, spin_z = spin_x + a * yx, spin_y + a * yy, spin_z + a * yz
            xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, alpha, beta)
            spin_x, spin_y, spin_z = spin_x + b * xx, spin_y + b * xy, spin_z + b * xz
            angular_acceleration += angular_speed * math.sqrt(a * a + b * b) + abs(a * b)
            spin = math.sqrt(spin_x * spin_x + spin_y * spin_y + spin_z * spin_z)
            angular_speed = spin + angular_acceleration
            acceleration += lengths[i] * (angular_acceleration + angular_speed * angular_speed)
            out[m, i + 1] = acceleration / 8.0


def _certify(
    place: Callable[[Array], tuple[Array, Array]],
    travel: Callable[[_Pieces], tuple[Array, Array]],
    scene: Scene,
    radii: Array,
    parameters: Array,
    body: Array,
    clearance: Array,
    horizon: float,
    margin: float,
) -> Certificate:
    """Branch and bound: halve the steps of links whose bound is worst, until it is tight or the arm touches.

    `place` makes parameters and joint positions of the middle of intervals, `travel` how far joints move and bulge.
    """
    seen = float(clearance.min())
    if len(parameters) < 2:
        step, link = first_smallest(clearance)
        return Certificate(seen, step, link, 0)
    pieces = _Pieces(
        np.arange(len(parameters) - 1),
        parameters[:-1],
        parameters[1:],
        body[:-1],
        body[1:],
        clearance[:-1],
        clearance[1:],
    )
    worst, worst_step, worst_link, looked_at = math.inf, 0, 0, 0
    for halving in range(MOST_HALVINGS + 1):
        motion, bulge = travel(pieces)
        bound = _bound(pieces, motion, bulge)
        final = halving == MOST_HALVINGS or seen <= 0
        loose = np.zeros(bound.shape, bool) if final else bound < _wanted(seen, margin)
        settled = np.where(loose, math.inf, bound)
        row, link = first_smallest(settled)
        lowest = float(settled.min())
        if math.isnan(lowest) or lowest < worst:
            worst, worst_step, worst_link = lowest, int(pieces.step[row]), link
        if not loose.any():
            break
        halved = np.any(loose, axis=1)
        # What is farther away than this cannot bring the bound down to what was seen already.
        enough = min(horizon, seen + float(motion[halved].max() + 2 * bulge[halved].max()))
        pieces = pieces.chosen(halved)
        middle, middle_body = place(0.5 * (pieces.low + pieces.high))
        middle_clearance = _clearance_of(loose[halved], scene, middle_body, radii, enough)
        looked_at += len(middle)
        seen = min(seen, float(middle_clearance.min()))
        pieces = _Pieces(
            *(
                _interleaved(first, second)
                for first, second in (
                    (pieces.step, pieces.step),
                    (pieces.low, middle),
                    (middle, pieces.high),
                    (pieces.low_body, middle_body),
                    (middle_body, pieces.high_body),
                    (pieces.low_clearance, middle_clearance),
                    (middle_clearance, pieces.high_clearance),
                )
            )
        )
    return Certificate(min(worst, seen), worst_step, worst_link, looked_at)


def _clearance_of(links: NDArray[np.bool_], scene: Scene, body: Array, radii: Array, enough: float) -> Array:
    """Clearance (m, n) of the chosen ones of links, or at least `enough`; infinite for the others, settled ones."""
    link, row = np.nonzero(links.T)  # link by link, which keeps the distance queries warm
    reach = enough + float(radii.max())
    found = scene.clearance(body[row, link][:, None], body[row, link + 1][:, None], np.zeros(1), reach).value[:, 0]
    out = np.full(links.shape, math.inf)
    out[row, link] = found - radii[link]
    return out


def _wanted(seen: float, margin: float) -> float:
    """The bound (m) that is worth halving for, where this is the smallest clearance that was seen."""
    return max(margin, seen - TIGHTNESS) if seen - margin > TIGHTEST else seen - TIGHTNESS


def _interleaved(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """First halves and second halves in the order of time, which keeps the distance queries warm."""
    return np.stack([first, second], axis=1).reshape(-1, *first.shape[1:])


def _bound(pieces: _Pieces, motion: Array, bulge: Array) -> Array:
    """The lower bound (m, n) of each link's clearance over each interval."""
    moved = np.maximum(motion[:, :-1], motion[:, 1:])
    out = np.maximum(bulge[:, :-1], bulge[:, 1:])
    return 0.5 * (pieces.low_clearance + pieces.high_clearance - moved) - out
