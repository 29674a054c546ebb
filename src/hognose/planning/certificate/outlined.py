"""The same motion with the ends of the chords of an outline, of an arm whose body is flat.

A point at a lever beside the centre line goes with it, and comes round with the link: its way and its bulge are those
of the centre line and the lever times what the link turns. Derived in `docs/certificate.md`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hognose.planning.certificate.moving import Array, Moving, Pieces, coordinates_of
from hognose.robot import Robot
from hognose.robot.base import Base, angles_on, outline

#: A turn (rad) of a link of which nothing is known: more than any that can be proven.
_UNKNOWN = 1e9


def outlined(moving: Moving, robot: Robot, base: Base) -> Moving:
    """A motion of the centre line's p+1 vertices, as one of the V vertices of the outline; of round bodies the same."""
    lines = robot.outline.lines
    if lines is None:
        return moving
    arcs = robot.model.arcs(robot.link_lengths)
    joints = np.append(np.searchsorted(robot.chord_sections, np.arange(robot.sections)), len(arcs))

    def place(parameters: Array) -> tuple[Array, Array]:
        parameters, line = moving.place(parameters)
        return parameters, outline(base, robot, line[:, joints], coordinates_of(moving, base, parameters, line))

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        low, high = lines.centre(pieces.low_body), lines.centre(pieces.high_body)
        gone, bulge = moving.travel(replace(pieces, low_body=low, high_body=high))
        if moving.straight:
            return pieces.gone, lines.bulges(bulge, arcs)
        low_at, high_at = (
            coordinates_of(moving, base, parameters, body)
            for parameters, body in ((pieces.low, low), (pieces.high, high))
        )
        before, after = angles_on(base, robot, low, low_at), angles_on(base, robot, high, high_at)
        turned = _turned(gone, moving.turn, before, after, base.spin(low_at, high_at))
        return gone[:, lines.vertices] + lines.levers * turned[:, lines.pieces], np.zeros(pieces.low_body.shape[:2])

    return replace(moving, place=place, travel=travel)


def _turned(gone: Array, turn: Array, low: Array, high: Array, spin: Array) -> Array:
    """How far (m, n) rad links turn at most, about their own axes and across them, while joints glide.

    Ends of links go (m, n+1) m, a link's direction turns by `turn` (n,) rad/m times both its ends' ways, angles are
    (m, n, 2) rad at both ends of the way, and the base turns by `spin` (m, 3) rad in the arm's own axes.
    """
    across, rolled = np.hypot(spin[:, 0], spin[:, 1]), np.abs(spin[:, 2])
    out = np.empty((len(gone), len(turn)))
    for link, rate in enumerate(turn.tolist()):
        next_across = rate * (gone[:, link] + gone[:, link + 1])
        change = next_across + across + rolled
        beta = 0.5 * (np.abs(low[:, link, 1]) + np.abs(high[:, link, 1]) + change)
        known = beta < 0.5 * math.pi - 1e-3
        cosine = np.where(known, np.cos(beta), 1.0)
        alpha = 0.5 * (np.abs(low[:, link, 0]) + np.abs(high[:, link, 0]) + change / cosine)
        sine = np.sin(np.minimum(alpha, 0.5 * math.pi))
        rolled = (rolled + sine * across) / cosine + np.tan(np.where(known, beta, 0.0)) * next_across
        rolled = np.where(known, rolled, _UNKNOWN)
        across = next_across
        out[:, link] = rolled + across
    return out
