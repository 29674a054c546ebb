"""The certificate of a motion past an obstacle that moves, too.

Distances are measured in the obstacle's own frame. There a place of a link comes along by its own way, by that of the
obstacle's pivot, and by the obstacle's turn times its distance from the pivot. With m the sum of the three over a step,
the bound is that of `certificate.bound`. What the obstacle may be early or late is taken off each clearance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.planning.certificate.bound import MOST_HALVINGS, TIGHTNESS, wanted
from hognose.planning.certificate.moving import Array, Moving, OneChord, Pieces
from hognose.planning.penetration import clearance_of
from hognose.planning.tolerance.allowance import Allowance, OnBase
from hognose.robot import Robot
from hognose.scene import MovingObstacle
from hognose.ties import first_smallest

#: A row, a chord and a time (s).
_Place = tuple[int, int, float]
#: Configurations that are looked at besides the steps, before what is proven until then is the answer.
MOST_LOOKED_AT = 200_000


@dataclass(frozen=True)
class Passing:
    """A proven lower bound of the clearance to a moving obstacle over a whole continuous motion.

    Attributes
    ----------
    clearance : m
        No link comes closer to the obstacle than this at any time; at most the horizon. Below zero it is no bound but
        the smallest that was seen, or a bound that was not proven to be tight.
    step, link
        Where it comes closest: at or after this row of the plan, on this link (0-based).
    time : s
        When it does, on the obstacle's clock.
    obstacle
        Its name.
    halvings
        Configurations that were looked at besides the steps.
    """

    clearance: float
    step: int
    link: int
    time: float
    obstacle: str
    halvings: int


def certify_passing(
    moving: Moving,
    body: Robot | OneChord,
    obstacle: MovingObstacle,
    times: Array,
    vertices: Array,
    horizon: float,
    margin: float,
    allowance: Allowance | OnBase | None = None,
) -> Passing:
    """The certificate of a motion past a moving obstacle.

    Parameters
    ----------
    moving
        The motion between the set-points; steady in time from each to the next.
    body
        A robot, or the mount.
    obstacle
    times : (T,) s
        Of the set-points, on the obstacle's clock; increasing.
    vertices : (T, p+1, 3) m
        Ends of the chords of the outline at the set-points.
    horizon, margin : m
    allowance
        What tolerances take of clearances: what is proven is of what they leave.
    """
    if allowance is not None and moving.straight and len(times) > 1:
        every = np.zeros((len(times), 0))
        allowance = allowance.with_bulge(moving.travel(Pieces.between(moving.parameters, vertices, every))[1])
    proof = _Proof(moving, body.outline.radii, body.outline.sections, obstacle, horizon, margin, allowance)
    return proof.found(times, vertices)


@dataclass(frozen=True)
class _Proof:
    """What stays as it is while steps are halved."""

    moving: Moving
    radii: Array
    sections: NDArray[np.int64]
    obstacle: MovingObstacle
    horizon: float
    margin: float
    allowance: Allowance | OnBase | None

    def found(self, times: Array, vertices: Array) -> Passing:
        late = self._late(times, self._away(times, vertices))
        every = np.zeros((len(times), 0))
        pieces = Pieces.between(self.moving.parameters, vertices, every)
        spans, reach = np.stack([times[:-1], times[1:]], axis=1), self.horizon
        if len(spans):
            way, beside, shifted = self._ways(pieces, spans, *self.moving.travel(pieces))
            reach += float((0.5 * way + beside + shifted).max())
        clearance = self._at_steps(times, vertices, reach + float(late.max())) - late
        left = clearance if self.allowance is None else clearance - self.allowance.at_steps(vertices)
        row, chord = first_smallest(left)
        seen, closest = min(float(left.min()), self.horizon), (row, chord, float(times[row]))
        if not len(spans) or seen < 0:
            return self._named(seen, *closest, 0)
        pieces = Pieces.between(self.moving.parameters, vertices, clearance)
        return self._halved(pieces, spans, seen, closest)

    def _halved(self, pieces: Pieces, spans: Array, seen: float, closest: _Place) -> Passing:
        worst, where, looked_at = math.inf, closest, 0
        for halving in range(MOST_HALVINGS + 1):
            motion, bulge = self.moving.travel(pieces)
            way, beside, late = self._ways(pieces, spans, motion, bulge)
            taken = self._taken(pieces, motion, bulge)
            low, high = pieces.low_clearance, pieces.high_clearance
            lateness = self._late(spans[:, 0], self._away(spans[:, 0], pieces.low_body))
            lateness = lateness + self._late(spans[:, 1], self._away(spans[:, 1], pieces.high_body))
            bound = 0.5 * (low + high - way) - beside - np.maximum(late - 0.5 * lateness, 0.0) - taken
            final = halving == MOST_HALVINGS or looked_at > MOST_LOOKED_AT
            loose = np.zeros(bound.shape, bool) if final else bound < wanted(seen, self.margin)
            settled = np.where(loose, math.inf, bound)
            row, chord = first_smallest(settled)
            lowest = float(settled.min())
            if math.isnan(lowest) or lowest < worst:
                worst, where = lowest, (int(pieces.step[row]), chord, float(spans[row].mean()))
            if not loose.any():
                break
            chosen = np.any(loose, axis=1)
            # What is farther away than this cannot bring the bound down to what was seen already.
            enough = seen + float((way + 2.0 * (beside + late))[chosen].max() + np.max(taken))
            pieces, spans = pieces.chosen(chosen), spans[chosen]
            middle, body = self.moving.place(0.5 * (pieces.low + pieces.high))
            times = spans.mean(axis=1)
            clearance = self._of_chords(loose[chosen], times, body, enough)
            looked_at += len(middle)
            left = clearance if self.allowance is None else clearance - self.allowance.within(body, pieces.step)
            if left.min() < seen:
                row, chord = first_smallest(left)
                seen, closest = float(left.min()), (int(pieces.step[row]), chord, float(times[row]))
            if seen < 0:
                return self._named(seen, *closest, looked_at)
            pieces = pieces.halved(middle, body, clearance)
            spans = np.stack([spans[:, 0], times, times, spans[:, 1]], axis=1).reshape(-1, 2)
        return self._named(min(worst, seen), *(where if worst < seen - 2.0 * TIGHTNESS else closest), looked_at)

    def _named(self, clearance: float, step: int, chord: int, time: float, looked_at: int) -> Passing:
        link = int(self.sections[chord])
        return Passing(clearance, step, link, time, self.obstacle.name, looked_at)

    def _away(self, times: Array, body: Array) -> Array:
        """How far (m, p) the points of chords are from the obstacle's pivot at most."""
        return _larger(np.linalg.norm(body - self.obstacle.motion.poses(times)[1][:, None], axis=2))

    def _taken(self, pieces: Pieces, motion: Array, bulge: Array) -> Array | float:
        if self.allowance is None:
            return 0.0
        known = None if self.moving.straight else motion
        return self.allowance.between(pieces.low_body, pieces.high_body, pieces.step, known, bulge)

    def _ways(self, pieces: Pieces, spans: Array, motion: Array, bulge: Array) -> tuple[Array, Array, Array]:
        """Of chords over intervals (m, p) m: m of the bound, E of the bound, and what the timing takes off at most."""
        went, beside, obstacle = _larger(motion), _larger(bulge), self.obstacle
        before, after = obstacle.motion.gone(spans[:, 0]), obstacle.motion.gone(spans[:, 1])
        slid, turned = ((until - since)[:, None] for since, until in zip(before, after, strict=True))
        ends = self._away(spans[:, 0], pieces.low_body) + self._away(spans[:, 1], pieces.high_body)
        # Between two places the way through a third is longer by no more than what was gone.
        away = 0.5 * (ends + went + slid) + beside
        # However much it turns, a point gets no farther from where it was at either end than across its circle.
        way = went + slid + np.minimum(turned, 4.0) * np.minimum(away, obstacle.reach)
        return way, beside, self._late(spans, away)

    def _late(self, spans: Array, away: Array) -> Array:
        """How far (m, p) the timing can shift the obstacle, seen from chords so far (m, p) m away from its pivot.

        At times (m,), or at any time of intervals (m, 2).
        """
        timing, motion = self.obstacle.timing, self.obstacle.motion
        if not timing:
            return np.zeros_like(away)
        first, last = (spans, spans) if spans.ndim == 1 else spans.T
        early, late, before, after = (motion.gone(t) for t in (first, last + timing, first - timing, last))
        most = [
            np.minimum(np.maximum(late[k] - early[k], after[k] - before[k]), timing * motion.fastest[k])[:, None]
            for k in (0, 1)
        ]
        return most[0] + np.minimum(most[1], 2.0) * np.minimum(away + most[0], self.obstacle.reach)

    def _at_steps(self, times: Array, vertices: Array, reach: float) -> Array:
        """Clearance (T, p) m at the set-points, before the timing."""
        seen = np.ascontiguousarray(self.obstacle.motion.into_frame(vertices, times))
        return clearance_of(self.obstacle.scene, seen, self.radii, reach)

    def _of_chords(self, chosen: NDArray[np.bool_], times: Array, body: Array, enough: float) -> Array:
        """Clearance (m, p) less the timing, or at least `enough`, of some chords; infinite for the others."""
        late = self._late(times, self._away(times, body))
        seen = self.obstacle.motion.into_frame(body, times)
        chord, row = np.nonzero(chosen.T)  # chord by chord, which keeps the distance queries warm
        reach = enough + float(self.radii.max() + late.max())
        starts, ends = seen[row, chord][:, None], seen[row, chord + 1][:, None]
        found = self.obstacle.scene.clearance(starts, ends, np.zeros(1), reach).value[:, 0]
        out = np.full(chosen.shape, math.inf)
        out[row, chord] = found - self.radii[chord] - late[row, chord]
        return out


def _larger(values: NDArray[Any]) -> NDArray[Any]:
    """Of values (m, p+1) at the ends of p chords, the larger of both."""
    return np.maximum(values[:, :-1], values[:, 1:])
