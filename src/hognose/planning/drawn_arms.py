"""How likely a motion is to lose its margin: clearances of drawn arms, by linear sensitivities.

The clearance of a link changes with the errors as its closest point moves along the line to the obstacle: it is
d₀ - (bounded parts) + gᵀ z, with z drawn from independent standard normal distributions. Only places matter that come
close enough to be the closest of a drawn arm, and of neighbouring steps, which move alike, only the closest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.planning.motion import Motion
from hognose.planning.near_places import Near, gradients
from hognose.planning.penetration import closest_chords, nearest
from hognose.planning.tolerance.budget import Budget

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: A place is left out that is farther, though closer by so many standard deviations, than another is …
NEARER = 4.0
#: … though farther by so many.
FARTHER = 2.0
#: A place is left out if another one is closer but for changes of the difference beyond so many standard deviations.
ALIKE = 3.0
#: Of the errors that change a clearance, this part of the largest change is left out.
NEGLIGIBLE = 1e-2
#: Links are moved sideways by so many standard deviations to find what else is close.
SIDEWAYS = (-1.75, 1.75)
#: So many arms are drawn unless said otherwise.
DRAWS = 10_000
#: … and so many at once, with so many errors together: what is read stays in the cache.
_AT_ONCE, _TOGETHER = 256, 4
#: Clearances of drawn arms are found this closely (m).
_ROUNDED = 1e-8


@kernel(fastmath={"contract"})
def _least(base: NDArray, slopes: NDArray, drawn: NDArray, out: NDArray) -> None:
    """The smallest (b,) of base + slopes z over rows (q,), (q, e), for columns z of `drawn` (e, b); e a multiple of 4.

    A product of matrices would share this little work among threads, which takes longer where cores are busy.
    """
    size = out.size
    row = np.empty_like(out)
    for q in range(base.size):
        first = base[q]
        for b in range(size):
            row[b] = first
        for e in range(0, slopes.shape[1], 4):
            s0, s1, s2, s3 = slopes[q, e], slopes[q, e + 1], slopes[q, e + 2], slopes[q, e + 3]
            z0, z1, z2, z3 = drawn[e], drawn[e + 1], drawn[e + 2], drawn[e + 3]
            for b in range(size):
                row[b] += (s0 * z0[b] + s1 * z1[b]) + (s2 * z2[b] + s3 * z3[b])
        if q == 0:
            out[:] = row
        else:
            for b in range(size):
                out[b] = row[b] if row[b] < out[b] else out[b]


@kernel(fastmath={"contract"})
def _foremost(base: NDArray, gradient: NDArray, alike: float, kept: NDArray) -> int:
    """Fill `kept` with rows of gradients (q, e), in the order of base (q,), and return how many there are.

    A row is left out if one before it is closer but for so many standard deviations of the difference.
    """
    count = 0
    for row in range(gradient.shape[0]):
        alone = True
        for k in range(count):
            beyond = (base[row] - base[kept[k]]) / alike
            beyond *= beyond
            apart = 0.0
            for e in range(gradient.shape[1]):
                apart += (gradient[row, e] - gradient[kept[k], e]) ** 2
                if apart > beyond:
                    break
            if apart <= beyond:
                alone = False
                break
        if alone:
            kept[count] = row
            count += 1
    return count


@kernel(fastmath={"contract"})
def _turned(rest: NDArray, negligible: float, out: NDArray) -> int:
    """Fill `out` with the parts of rows (q, e) along directions at right angles, and return how many those are.

    The next direction is that of the longest row of what is left, until that is negligible; `rest` is used up.
    """
    rows, errors = rest.shape
    sizes, direction = np.empty(rows), np.empty(errors)
    least, count = 0.0, 0
    while count < errors:
        for q in range(rows):
            sizes[q] = 0.0
            for e in range(errors):
                sizes[q] += rest[q, e] * rest[q, e]
        longest = np.argmax(sizes)
        size = math.sqrt(sizes[longest])
        if count == 0:
            least = negligible * size
        if size <= least:
            break
        for e in range(errors):
            direction[e] = rest[longest, e] / size
        for q in range(rows):
            along = 0.0
            for e in range(errors):
                along += rest[q, e] * direction[e]
            out[q, count] = along
            for e in range(errors):
                rest[q, e] -= along * direction[e]
        count += 1
    return count


@dataclass(frozen=True, eq=False)
class Draws:
    """Smallest clearances of drawn arms over a whole motion, at its steps.

    Attributes
    ----------
    clearance : (k,) m
        The smallest clearance of each, bounded parts taken off.
    margin : m
        That of the task.
    places : int
        Steps and links that were looked at.
    ceiling : m
        Clearances of so much are those of places beyond the horizon, which may be farther; infinite without such.
    """

    clearance: Array
    margin: float
    places: int
    ceiling: float = math.inf

    @property
    def loses(self) -> float:
        """The share of arms that come closer than the margin somewhere."""
        return float(np.mean(self.clearance < self.margin))

    @property
    def touches(self) -> float:
        """The share of arms that touch an obstacle somewhere."""
        return float(np.mean(self.clearance <= 0.0))

    def quantile(self, share: float) -> float:
        """The clearance (m) that this share of arms falls below."""
        return float(np.quantile(self.clearance, share))

    def is_lower_bound(self, share: float) -> bool:
        """Whether that clearance is only known not to be less."""
        return self.quantile(share) >= self.ceiling - _ROUNDED


def draw(motion: Motion, budget: Budget, taken: Array, count: int = DRAWS, seed: int = 0) -> Draws:
    """Draw arms and find their smallest clearances.

    Parameters
    ----------
    motion
        Of sections of straight pieces; a link's closest point is that of its axis, or of an axis of its outline.
    budget
    taken : (T, n) m
        What tolerances take of every link's clearance at the steps, as of `Allowance.at_steps`.
    count
        Arms.
    seed
        Of the random numbers: the same arms are drawn for the same seed.
    """
    bounded = budget.cad + budget.sag
    spread = 0.5 * (taken - bounded)
    places = _places(motion.clearance - bounded, spread)
    near = _closest(motion, *places)
    gradient = gradients(motion, budget, near)
    kept = _without_neighbours(near.clearance - bounded[near.links], gradient)
    beside = _beside(motion, near.chosen(kept), spread)
    found = near.chosen(kept).joined(beside)
    gradient = np.concatenate([gradient[kept], gradients(motion, budget, beside)])
    base = found.clearance - bounded[found.links]
    last = _without_neighbours(base, gradient)
    smallest = _smallest(base[last], _of_few(gradient[last]), count, seed)
    ceiling = base[last][found.clearance[last] >= motion.horizon].min(initial=math.inf)
    return Draws(smallest, motion.task.margin, len(kept), float(ceiling))


def _smallest(base: Array, gradient: Array, count: int, seed: int) -> Array:
    """The smallest (count,) m of base + gradient z over places (q,), (q, e), for normally distributed z (e,).

    In single precision, which is good to 1e-9 m for clearances of millimetres.
    """
    random, out = np.random.default_rng(seed), np.empty(count)
    errors = -(-gradient.shape[1] // _TOGETHER) * _TOGETHER
    slopes = np.zeros((len(base), errors), np.float32)
    slopes[:, : gradient.shape[1]] = gradient
    found = np.empty(_AT_ONCE, np.float32)
    for first in range(0, count, _AT_ONCE):
        drawn = random.standard_normal((errors, _AT_ONCE), dtype=np.float32)
        _least(base.astype(np.float32), slopes, drawn, found)
        out[first : first + _AT_ONCE] = found[: count - first]
    return out


def _closest(motion: Motion, steps: Indices, links: Indices) -> Near:
    """Where links are closest to obstacles; clearances at the horizon and of links inside solids are the motion's."""
    clearance, outline = motion.clearance[steps, links], motion.robot.outline
    chords = links
    if len(outline.sections) > motion.robot.sections:
        chords = closest_chords(motion.scene, motion.task.moving, outline, motion.outline, steps, links, motion.clock)
    starts, ends = motion.outline[steps, chords], motion.outline[steps, chords + 1]
    far = float((clearance + outline.radii[chords]).max()) + 1e-6
    found = nearest(motion.scene, motion.task.moving, starts, ends, motion.clock[steps], far)
    near = np.isfinite(found.on_mesh[:, :1])
    points = np.where(near, found.on_segment, 0.5 * (starts + ends))
    away = np.where(near, points - found.on_mesh, 0.0)
    size = np.linalg.norm(away, axis=1, keepdims=True)
    away = np.divide(away, size, out=np.zeros_like(away), where=size > 0)
    return Near(steps, links, chords, points, away, clearance)


def _beside(motion: Motion, near: Near, spread: Array) -> Near:
    """Further points of obstacles that links are closest to once errors have moved them sideways.

    Round a hole they make the clearance smaller than the one closest point of the plan does.
    """
    starts, ends = motion.outline[near.steps, near.chords], motion.outline[near.steps, near.chords + 1]
    sideways = np.cross(near.away, ends - starts)
    size = np.linalg.norm(sideways, axis=1, keepdims=True)
    sideways = np.divide(sideways, size, out=np.zeros_like(sideways), where=size > 0)
    shift = sideways * spread[near.steps, near.links][:, None]
    shifts = np.concatenate([times * shift for times in SIDEWAYS])
    steps, chords = (np.tile(rows, len(SIDEWAYS)) for rows in (near.steps, near.chords))
    far = float((near.clearance + motion.robot.outline.radii[near.chords]).max() + 2.0 * np.abs(shifts).max()) + 1e-6
    starts, ends = np.tile(starts, (len(SIDEWAYS), 1)) + shifts, np.tile(ends, (len(SIDEWAYS), 1)) + shifts
    found = nearest(motion.scene, motion.task.moving, starts, ends, motion.clock[steps], far)
    seen = np.flatnonzero(np.isfinite(found.on_mesh[:, 0]) & (found.value > 0) & (shifts != 0).any(axis=1))
    return Near.of(motion, steps[seen], chords[seen], found.on_mesh[seen])


def _places(left: Array, spread: Array) -> tuple[Indices, Indices]:
    """Steps and links that may be the closest of a drawn arm, of clearances and their spreads (T, n) m."""
    possible = np.argwhere(left - NEARER * spread <= (left + FARTHER * spread).min())
    return possible[:, 0], possible[:, 1]


def _without_neighbours(base: Array, gradient: Array) -> Indices:
    """Of places with clearances (q,) m and gradients (q, e) m, those that another is not always closer than."""
    order = np.argsort(base, kind="stable")
    kept = np.empty(len(base), np.int64)
    count = _foremost(base[order], np.ascontiguousarray(gradient[order]), ALIKE, kept)
    return order[kept[:count]]


def _of_few(gradient: Array) -> Array:
    """Gradients (q, r) of fewer errors (q, e) that change clearances alike: along directions at right angles.

    Of independent errors of unit standard deviation, the parts along such directions are independent, too.
    """
    found = np.zeros_like(gradient)
    count = _turned(gradient.copy(), NEGLIGIBLE, found)
    return found[:, :count]
