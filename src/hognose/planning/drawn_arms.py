"""How likely a motion is to lose its margin: clearances of drawn arms, by linear sensitivities.

The clearance of a link changes with the errors as its closest point moves along the line to the obstacle: it is
d₀ - (bounded parts) + gᵀ z, with z drawn from independent standard normal distributions. Only places matter that come
close enough to be the closest of a drawn arm, and of neighbouring steps, which move alike, only the closest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.motion import Motion
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.jacobian import joint_axes
from hognose.robot.cable_gains import angles_per_length

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: A place is left out that is farther, though closer by so many standard deviations, than another is …
NEARER = 4.5
#: … though farther by so many.
FARTHER = 3.0
#: A place is left out if another one is closer but for changes of the difference beyond so many standard deviations.
ALIKE = 3.0
#: So many arms are drawn unless said otherwise.
DRAWS = 10_000


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
    """

    clearance: Array
    margin: float
    places: int

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


def draw(motion: Motion, budget: Budget, taken: Array, count: int = DRAWS, seed: int = 0) -> Draws:
    """Draw arms and find their smallest clearances.

    Parameters
    ----------
    motion
        Of straight links; a link's closest point is that of its axis.
    budget
    taken : (T, n) m
        What tolerances take of every link's clearance at the steps, as of `Allowance.at_steps`.
    count
        Arms.
    seed
        Of the random numbers: the same arms are drawn for the same seed.
    """
    bounded = budget.bounded
    steps, links = _places(motion.clearance - bounded, 0.5 * (taken - bounded))
    gradient = _gradients(motion, budget, steps, links)
    base = (motion.clearance - bounded)[steps, links]
    kept = _without_neighbours(base, gradient)
    random = np.random.default_rng(seed)
    errors = random.standard_normal((count, gradient.shape[1]), dtype=np.float32)
    change = gradient[kept].astype(np.float32) @ errors.T
    change += base[kept, None].astype(np.float32)
    return Draws(change.min(axis=0).astype(np.float64), motion.task.margin, len(kept))


def _places(left: Array, spread: Array) -> tuple[Indices, Indices]:
    """Steps and links that may be the closest of a drawn arm, of clearances and their spreads (T, n) m."""
    possible = np.argwhere(left - NEARER * spread <= (left + FARTHER * spread).min())
    return possible[:, 0], possible[:, 1]


def _without_neighbours(base: Array, gradient: Array) -> Indices:
    """Of places with clearances (q,) m and gradients (q, e) m, those that another is not always closer than."""
    kept: list[int] = []
    left = np.argsort(base, kind="stable")
    while len(left):
        first, left = left[0], left[1:]
        kept.append(int(first))
        apart = gradient[left] - gradient[first]
        beyond = (base[left] - base[first]) / ALIKE
        left = left[np.einsum("qe,qe->q", apart, apart) > beyond * beyond]
    return np.array(kept)


def _gradients(motion: Motion, budget: Budget, steps: Indices, links: Indices) -> Array:
    """How clearances at places change (q, e) m with each error of one standard deviation."""
    joints, base, robot = motion.body[steps], motion.task.base, motion.robot
    rows = np.arange(len(steps))
    starts, ends = joints[rows, links], joints[rows, links + 1]
    far = float((motion.clearance[steps, links] + robot.body_radii[links]).max()) + 1e-6
    found = motion.scene.distance(starts, ends, upper=far)
    near = (found.triangle >= 0)[:, None]
    points = np.where(near, found.on_segment, 0.5 * (starts + ends))
    away = np.where(near, points - found.on_mesh, 0.0)
    size = np.linalg.norm(away, axis=1, keepdims=True)
    away = np.divide(away, size, out=np.zeros_like(away), where=size > 0)
    parts = [budget.shift * away, budget.turn * np.cross(points - budget.pivot, away)]
    if budget.joints.any() or budget.zero:
        which, row = np.unique(steps, return_inverse=True)
        angles = motion.angles[which]
        axes = joint_axes(base, angles, motion.at[which])[row]
        lever = np.cross(points[:, None] - joints[:, :-1], away[:, None])
        lever *= (np.arange(robot.sections) <= links[:, None])[:, :, None]
        turned = np.einsum("qjka,qja->qjk", axes, lever)
        parts.append((turned * budget.joints[:, None]).reshape(len(steps), -1))
        if budget.zero:
            gains = angles_per_length(robot, angles).reshape(len(which), -1, robot.cables)[row]
            parts.append(budget.zero * (turned.reshape(len(steps), 1, -1) @ gains)[:, 0])
    return np.concatenate(parts, axis=1)
