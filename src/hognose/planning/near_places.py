"""Places of the body that are close to obstacles, and how errors change how close they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.sensitivity import turned_by
from hognose.planning.motion import Motion
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.jacobian import joint_axes
from hognose.planning.tolerance.left_over import EVEN, ways_of
from hognose.robot.cable_gains import angles_per_length
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Near:
    """Points of links, and points of obstacles close to them: steps, links, chords of the outline (q,).

    `points` (q, 3) m are those of links, `away` (q, 3) leads to them from the obstacle, and `clearance` (q,) m is how
    far the body is from that.
    """

    steps: Indices
    links: Indices
    chords: Indices
    points: Array
    away: Array
    clearance: Array

    @classmethod
    def of(cls, motion: Motion, steps: Indices, chords: Indices, on_mesh: Array) -> Near:
        """The points of chords (q,) that are closest to points of obstacles (q, 3) m."""
        starts, ends = motion.outline[steps, chords], motion.outline[steps, chords + 1]
        along = ends - starts
        share = np.einsum("qa,qa->q", on_mesh - starts, along) / np.einsum("qa,qa->q", along, along)
        points = starts + np.clip(share, 0.0, 1.0)[:, None] * along
        away = points - on_mesh
        size = np.linalg.norm(away, axis=1)
        away = np.divide(away, size[:, None], out=np.zeros_like(away), where=size[:, None] > 0)
        outline = motion.robot.outline
        return cls(steps, outline.sections[chords], chords, points, away, size - outline.radii[chords])

    def chosen(self, rows: Indices) -> Near:
        """Some of them."""
        return Near(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    def joined(self, other: Near) -> Near:
        """These and others."""
        return Near(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in self.__dataclass_fields__))


def _left_over(motion: Motion, budget: Budget) -> Array:
    """How joints turn (T, n, 2, 2) rad by errors of EA and masses, and by friction against the ways of cables."""
    mechanics, held = budget.mechanics, motion.held
    assert mechanics is not None, "the caller"
    assert held is not None, "a budget has mechanics"
    turned = turned_by(mechanics, motion.angles, held, motion.task.gravity(motion.at), budget.friction)
    weight = math.hypot(budget.stiffness, budget.mass) * turned[..., :1]
    if not budget.friction:
        return np.concatenate([weight, np.zeros_like(weight)], axis=3)
    against = -ways_of(motion.commanded_lengths)[:, None, :, None]
    return np.concatenate([weight, EVEN * (turned[..., 1:] @ against)], axis=3)


def _turned_pieces(motion: Motion, model: MixedSections, near: Near) -> Array:
    """How clearances change (q, n, 2) m/rad with the angles of sections of straight pieces, each with its own joint."""
    outline, sections = motion.robot.outline, motion.robot.chord_sections
    piece = near.chords if outline.lines is None else outline.lines.chords[near.chords]
    shares = model.table[:, :2]
    axes = joint_axes(motion.task.base, motion.angles[near.steps][:, sections] * shares, motion.at[near.steps])
    lever = np.cross(near.points[:, None] - motion.centre_line[near.steps, :-1], near.away[:, None])
    lever *= (np.arange(len(shares)) <= piece[:, None])[:, :, None]
    return np.add.reduceat(np.einsum("qjka,qja->qjk", axes, lever) * shares, model.first[:-1], axis=1)


def gradients(motion: Motion, budget: Budget, near: Near) -> Array:
    """How clearances change (q, e) m with each error of one standard deviation."""
    robot, points, away = motion.robot, near.points, near.away
    parts = [budget.shift * away, budget.turn * np.cross(points - budget.pivot, away)]
    if budget.joints.any() or budget.zero or budget.mechanics is not None:
        which, row = np.unique(near.steps, return_inverse=True)
        angles = motion.angles[which]
        if isinstance(robot.model, MixedSections):
            turned = _turned_pieces(motion, robot.model, near)
        else:
            axes = joint_axes(motion.task.base, angles, motion.at[which])[row]
            lever = np.cross(points[:, None] - motion.body[near.steps, :-1], away[:, None])
            lever *= (np.arange(robot.sections) <= near.links[:, None])[:, :, None]
            turned = np.einsum("qjka,qja->qjk", axes, lever)
        parts.append((turned * budget.joints[:, None]).reshape(len(points), 2 * robot.sections))
        if budget.zero:
            gains = angles_per_length(robot, angles).reshape(len(which), 2 * robot.sections, robot.cables)[row]
            parts.append(budget.zero * (turned.reshape(len(points), 1, 2 * robot.sections) @ gains)[:, 0])
        if budget.mechanics is not None:
            left = _left_over(motion, budget)[which].reshape(len(which), 2 * robot.sections, 2)[row]
            parts.append((turned.reshape(len(points), 1, 2 * robot.sections) @ left)[:, 0])
    return np.concatenate(parts, axis=1)
