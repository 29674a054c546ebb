"""Clearance between the steps: a lower bound for the continuous motion, not a denser sampling.

Three motions lie between two set-points: the joints glide along the path (what the method means), or feed and joint
angles are interpolated linearly, or feed and cable lengths are (what drives do that pull cables). In each, a point of a
link moves from where it is at one step to where it is at the next along nearly a straight line. With d₀, d₁ the
clearances at the two steps, m the largest distance an end of the link travels and E how far its motion can bulge from
the straight line, no point of the link comes closer to an obstacle in between than

    (d₀ + d₁ - m) / 2 - E .

Where that is not good enough the step is halved. Derivation of the bound and of E: `docs/certificate.md`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.certificate.moving import Array, Moving, OneChord, Pieces
from hognose.planning.tolerance.allowance import Allowance, OnBase
from hognose.robot import Robot
from hognose.scene import Scene
from hognose.ties import first_smallest

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
        No link comes closer to an obstacle than this, at any time. Below zero it is no bound but the smallest that was
        seen, or a bound that was not proven to be tight.
    step, link
        Where it is worst: at or after this row of the plan, on this link (0-based).
    halvings
        Configurations that were looked at besides the steps.
    """

    clearance: float
    step: int
    link: int
    halvings: int


def certify(
    moving: Moving,
    body: Robot | OneChord,
    scene: Scene,
    vertices: Array,
    clearance: Array,
    horizon: float,
    margin: float = math.inf,
    allowance: Allowance | OnBase | None = None,
) -> Certificate:
    """The certificate of a motion: where only a tighter bound proves the margin, it is tightened so far.

    Branch and bound: the steps of chords whose bound is worst are halved until it is tight. Where the body is inside
    an obstacle, no bound is worth that, and one that is not tight would say nothing: what was seen is the answer.

    Parameters
    ----------
    moving
    body
        A robot, or the mount.
    scene
    vertices, clearance : (T, p+1, 3) m, (T, n) m
        Ends of the chords of the outline and clearance of the sections at the set-points.
    horizon, margin : m
    allowance
        What tolerances take of clearances: what is proven and seen is of what they leave.
    """
    sections, radii = body.outline.sections, body.outline.radii
    clearance = np.where(radii > 0.0, clearance[:, sections], math.inf)  # what only connects chords is no body
    left = clearance if allowance is None else clearance - allowance.at_steps(vertices)
    seen, (step, chord) = float(left.min()), first_smallest(left)
    if len(vertices) < 2 or seen < 0:
        return Certificate(seen, step, int(sections[chord]), 0)
    pieces = Pieces.between(moving.parameters, vertices, clearance)
    worst, worst_step, worst_chord, looked_at = math.inf, 0, 0, 0
    for halving in range(MOST_HALVINGS + 1):
        motion, bulge = moving.travel(pieces)
        if halving == 0 and moving.straight and allowance is not None:
            allowance = allowance.with_bulge(bulge)
        taken = _taken(allowance, pieces, None if moving.straight else motion, bulge)
        bound = _bound(pieces, motion, bulge) - taken
        loose = bound < (-math.inf if halving == MOST_HALVINGS else wanted(seen, margin))
        settled = np.where(loose, math.inf, bound)
        row, chord = first_smallest(settled)
        lowest = float(settled.min())
        if math.isnan(lowest) or lowest < worst:
            worst, worst_step, worst_chord = lowest, int(pieces.step[row]), chord
        if not loose.any():
            break
        halved = np.any(loose, axis=1)
        # What is farther away than this cannot bring the bound down to what was seen already.
        enough = min(horizon, seen + float(motion[halved].max() + 2 * bulge[halved].max() + np.max(taken)))
        measured = functools.partial(_clearance_of, loose[halved], scene, radii=radii, enough=enough)
        pieces, left = _halved(pieces.chosen(halved), moving, measured, allowance)
        looked_at += len(left)
        seen = min(seen, float(left.min()))
        if seen < 0:
            row, chord = first_smallest(left)
            return Certificate(seen, int(pieces.step[2 * row]), int(sections[chord]), looked_at)
    return Certificate(min(worst, seen), worst_step, int(sections[worst_chord]), looked_at)


def _halved(
    pieces: Pieces,
    moving: Moving,
    measured: Callable[[Array], Array],
    allowance: Allowance | OnBase | None,
) -> tuple[Pieces, Array]:
    """Both halves of intervals, and what tolerances leave (m, p) m of the clearances in their middles."""
    middle, body = moving.place(0.5 * (pieces.low + pieces.high))
    clearance = measured(body)
    left = clearance if allowance is None else clearance - allowance.within(body, pieces.step)
    return pieces.halved(middle, body, clearance), left


def _clearance_of(links: NDArray[np.bool_], scene: Scene, body: Array, radii: Array, enough: float) -> Array:
    """Clearance (m, p) of the chosen ones of chords, or at least `enough`; infinite for the others, settled ones."""
    link, row = np.nonzero(links.T)  # link by link, which keeps the distance queries warm
    reach = enough + float(radii.max())
    found = scene.clearance(body[row, link][:, None], body[row, link + 1][:, None], np.zeros(1), reach).value[:, 0]
    out = np.full(links.shape, math.inf)
    out[row, link] = found - radii[link]
    return out


def wanted(seen: float, margin: float) -> float:
    """The bound (m) that is worth halving for, where this is the smallest clearance that was seen."""
    return max(margin, seen - TIGHTNESS) if seen - margin > TIGHTEST else seen - TIGHTNESS


def _taken(allowance: Allowance | OnBase | None, pieces: Pieces, motion: Array | None, bulge: Array) -> Array | float:
    """What tolerances take (m, p) m of the clearance of each chord in each interval."""
    if allowance is None:
        return 0.0
    return allowance.between(pieces.low_body, pieces.high_body, pieces.step, motion, bulge)


def _bound(pieces: Pieces, motion: Array, bulge: Array) -> Array:
    """The lower bound (m, p) of each chord's clearance over each interval."""
    moved = np.maximum(motion[:, :-1], motion[:, 1:])
    out = np.maximum(bulge[:, :-1], bulge[:, 1:])
    return 0.5 * (pieces.low_clearance + pieces.high_clearance - moved) - out
