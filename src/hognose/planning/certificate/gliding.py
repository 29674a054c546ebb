"""The motion of joints that glide along the path, as the method means it."""

from __future__ import annotations

import numpy as np

from hognose.errors import InputError
from hognose.following.exact import Exact
from hognose.path import Path
from hognose.planning.certificate.moving import Array, Moving, Pieces
from hognose.robot import Robot

#: The largest curvature of a path is taken as this times that of samples.
_SAMPLED = 1.1


def gliding_motion(path: Path, robot: Robot, feeds: Array) -> Moving | None:
    """The motion of joints that glide along a path between feeds (T,) m; None where they may jump.

    They may where the path turns sharply within a link.
    """
    if not robot.straight_links:  # how far a vertex between two joints travels is not known from the path alone
        raise InputError("gliding is proven for straight links only; sections of several chords need another proof")
    exact = Exact(path, robot.link_lengths)
    if not exact.tracks:
        return None
    arcs = exact.run_with_arcs(feeds)[1]

    def place(parameters: Array) -> tuple[Array, Array]:
        order = np.argsort(parameters[:, 0])
        body, on_path = np.empty((len(order), robot.sections + 1, 3)), np.empty((len(order), robot.sections + 1))
        body[order], on_path[order] = exact.run_with_arcs(parameters[order, 0])
        return on_path, body

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        return np.abs(pieces.high - pieces.low), np.zeros_like(pieces.low)

    # At either end, a chord L is beside the tangent by no more than asin(κL/2); κ is sampled, so a little is added.
    turn = np.minimum(0.5 * _SAMPLED * exact.curve.sharpest[0], 1.0 / robot.link_lengths)
    gone = np.abs(np.diff(arcs, axis=0))
    turned = turn * (gone[:, :-1] + gone[:, 1:])
    slack = 0.5 * turned  # half a bend's change: counted from that end of the step to which less of the sum changes
    slack[:, 1:] += 0.5 * turned[:, :-1]
    return Moving(arcs, place, travel, straight=False, turn=turn, bend_slack=slack)
