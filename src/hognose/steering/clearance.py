"""How far a steered arm is proven to stay clear, and what it would come too close to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance
from hognose.errors import InputError
from hognose.planning.motion import HORIZON
from hognose.planning.penetration import per_section
from hognose.planning.tolerance.budget import Budget
from hognose.robot import Robot
from hognose.robot.base import Base, mounted
from hognose.robot.own_body import MOUNT, OwnBody
from hognose.scene import Scene
from hognose.steering.grown_curve import on_grid
from hognose.steering.limits import Held
from hognose.steering.way import Way
from hognose.ties import first_smallest
from hognose.wording import mm, point

Array = NDArray[np.float64]

#: Clearance (m) kept beyond the margin: for what drives that interpolate joints between moves, and a spline through
#: way-points, differ from gliding on the path.
RESERVE = 5e-5
#: Moves are not halved below this (m) to prove them: so close to the margin the arm is held.
FINEST = 5e-5


class Surroundings:
    """A scene round an arm that must keep a margin (m) from it.

    Attributes
    ----------
    least : (n,) m
        What is kept from every section: the margin, what tolerances take of the straight arm, and a reserve.
    horizon : m
        Clearances are exact below this and lower bounds at it.
    """

    def __init__(
        self, robot: Robot, base: Base, scene: Scene, margin: float, taken: Array, budget: Budget | None = None
    ) -> None:
        self._robot, self._base, self._scene, self._margin, self._taken = robot, base, scene, margin, taken
        what = "a hognose.planning.tolerance.budget.Budget, or None"
        self._budget = None if budget is None else instance("budget", budget, Budget, what)
        self.least = margin + taken + RESERVE
        # So far that a clearance that is cut off there never looks like too little.
        self.horizon = max(HORIZON, margin + float(taken.max()) + 0.01)
        self._least, self._radii = self.least[robot.chord_sections], robot.chord_radii
        self._own_body = OwnBody.of(robot, base.mount)
        # The first link turns at most so far (rad) for each metre of both its ends, on paths that are gentle enough.
        sharpest = float(robot.model.sharpest(robot.link_lengths, robot.bend_limits).max())
        self._turn = min(0.5 * sharpest, 1.0 / float(robot.link_lengths[0]))

    def clearance(self, vertices: Array) -> Array:
        """Clearance (T, p) m of the chords of arms, which end at vertices (T, p+1, 3) m."""
        starts, ends = vertices[:, :-1], vertices[:, 1:]
        return self._scene.clearance(starts, ends, self._radii, self.horizon, threads=1).value

    def of_sections(self, clearance: Array) -> Array:
        """The clearance (n,) m of every section, of that (p,) m of chords."""
        return per_section(self._robot.chord_sections, clearance[None], np.minimum)[0]

    def proven(
        self, way: Way, start: float, clearance: Array, end: float
    ) -> tuple[float, int | tuple[int, int] | None]:
        """How far the nose may go along its way from one depth towards another; what it passes is proven clear.

        Parameters
        ----------
        way
        start, end : m
        clearance : (p,) m
            Of chords, at the start.

        Returns
        -------
        depth : m
        chord
            The one (0-based) that prevents more, or the two that would touch each other, the first of which may be
            `MOUNT`; None at the end.
        """
        depths = np.array([start, end])
        marks, vertices = way.place(depths)
        found = np.concatenate([clearance[None], self.clearance(vertices[1:])])
        while True:
            travel = way.travel(marks, vertices)
            bound = 0.5 * (found[:-1] + found[1:] - np.maximum(travel[:, :-1], travel[:, 1:]))
            bodies = self._mounted(vertices)
            own, pair = self._own_body.between(bodies, self._gone(bodies, travel))
            loose = (bound < self._least).any(axis=1) | (own < RESERVE)
            if not loose.any():
                return float(depths[-1]), None
            first = int(np.argmax(loose))
            if depths[first + 1] - depths[first] < FINEST:
                touching = own[first] < RESERVE
                return float(depths[first]), self._own_body.names(pair[first]) if touching else int(
                    np.argmin(bound[first] - self._least)
                )
            # Beyond the first place that is too close nothing is to be proven.
            close = (found[1:] < self._least).any(axis=1) | (self._own_body.closest(bodies[1:])[0] < RESERVE)
            count = int(np.argmax(close)) + 2 if close.any() else len(depths)
            after = np.flatnonzero(loose[: count - 1]) + 1
            middles = on_grid(0.5 * (depths[after - 1] + depths[after]))
            middle_marks, middle_vertices = way.place(middles)
            depths = np.insert(depths[:count], after, middles)
            marks = np.insert(marks[:count], after, middle_marks, axis=0)
            vertices = np.insert(vertices[:count], after, middle_vertices, axis=0)
            found = np.insert(found[:count], after, self.clearance(middle_vertices), axis=0)

    def held(self, vertices: Array, chord: int | tuple[int, int]) -> Held:
        """Why a chord (0-based), or two that would touch, of the arm with vertices (p+1, 3) m go no farther."""
        if isinstance(chord, tuple):
            return self._held_by_itself(vertices, *chord)
        section, radius = int(self._robot.chord_sections[chord]), float(self._radii[chord])
        obstacle, away, place = self._closest(vertices[chord], vertices[chord + 1], radius)
        words = f"section {section + 1} is {mm(away)} from {obstacle}, at {place}"
        return self._too_close(words, away, float(self._taken[section]), section + 1, obstacle)

    def _too_close(self, words: str, away: float, taken: float, section: int | None, obstacle: str | None) -> Held:
        """Of what is so far (m) away from an obstacle, with what tolerances take (m) of it."""
        words += f", and would come too close: the margin is {mm(self._margin)}"
        if taken:
            words += f", and tolerances take up to {mm(taken)}"
        return Held("clearance", words, 1e3 * away, 1e3 * (self._margin + taken), "mm", section, obstacle)

    def _held_by_itself(self, vertices: Array, first: int, second: int) -> Held:
        away, place = self._own_body.apart(self._mounted(vertices[None])[0], first, second)
        far = int(self._robot.chord_sections[second]) + 1
        near = None if first == MOUNT else int(self._robot.chord_sections[first]) + 1
        both = f"the mount and section {far}" if near is None else f"sections {near} and {far}"
        words = (
            f"{both} are {mm(away)} from each other, at {point(place)}, and would come too close: the body must not "
            f"touch itself"
        )
        section, other = (far, None) if near is None else (near, far)
        return Held("own body", words, 1e3 * away, 1e3 * RESERVE, "mm", section, other_section=other)

    def _mounted(self, vertices: Array) -> Array:
        """Ends of chords (T, p+1, 3) m, with the far end of the mount in front of them."""
        return mounted(self._base, vertices, self._base.coordinates(np.zeros(len(vertices)), vertices))

    def _gone(self, bodies: Array, travel: Array) -> Array:
        """How far (T-1, p+1) m ends of chords go, with the far end of the mount in front of them."""
        mount = self._base.mount
        if mount is None:
            return travel
        far = travel[:, 0]
        if mount.turns:
            far = far + mount.length * self._turn * travel[:, :2].sum(axis=1)
        return np.column_stack([far, travel])

    def mount_held(self, at: Array) -> Held | None:
        """Why the mount behind the first joint does not go from a pose to another, (2, k); None if clear."""
        starts, ends, radii = self._base.behind(at)
        if not len(radii):
            return None
        taken = self._of_mount(starts, ends, radii)
        least = self._margin + taken + RESERVE
        far = max(self.horizon, float(least.max()) + 0.01)
        short = self._scene.clearance(starts[None], ends[None], radii, far, threads=1).value[0] - least
        if short.min() >= 0:
            return None
        (piece,) = first_smallest(short)
        obstacle, away, place = self._closest(starts[piece], ends[piece], float(radii[piece]))
        words = f"the mount, or what it sweeps, is {mm(away)} from {obstacle}, at {place}"
        return self._too_close(words, away, float(taken[piece]), None, obstacle)

    def _of_mount(self, starts: Array, ends: Array, radii: Array) -> Array:
        """What tolerances take (q,) m of capsules of the mount; as of the first link where no budget is known."""
        if self._budget is None:
            return np.full(len(radii), self._taken[0])
        return self._budget.of_mount(self._base, starts, ends, radii)

    def refuse_start(self, joints: Array) -> None:
        """Raise an InputError unless the straight arm and the mount behind it are outside and far enough away."""
        for what, start, end, radius, least in self._start_bodies(joints):
            inside = int(self._scene.inside(0.5 * (start + end)[None])[0])
            if inside >= 0:
                trouble = f"lies inside {self._scene.names[inside]!r}"
            else:
                obstacle, away, place = self._closest(start, end, radius)
                if away >= least:
                    continue
                trouble = f"is {mm(away)} from {obstacle!r}, at {place}"
            raise InputError(
                f"start: {what} of the straight arm with its nose at the entrance {trouble}; expected at least "
                f"{mm(least)}, the margin{', tolerances' if self._taken.any() else ''} and a reserve. Move the "
                "entrance or lower the margin."
            )

    def _start_bodies(self, joints: Array) -> Iterator[tuple[str, Array, Array, float, float]]:
        """Name, ends (3,) m, radius and what is kept (m) of all that is there at the start."""
        thickest = per_section(self._robot.chord_sections, self._radii[None], np.maximum)[0]
        for section, (radius, least) in enumerate(zip(thickest.tolist(), self.least.tolist(), strict=True)):
            yield f"section {section + 1}", joints[section], joints[section + 1], radius, least
        # What the mount passes later, the first link has passed before it.
        behind = self._base.behind(self._base.coordinates(np.zeros(1), joints[None]))
        for start, end, radius, taken in zip(*behind, self._of_mount(*behind), strict=True):
            yield "the mount", start, end, float(radius), self._margin + float(taken) + RESERVE

    def _closest(self, start: Array, end: Array, radius: float) -> tuple[str | None, float, str]:
        """The obstacle closest to a body of a radius (m), its clearance (m), and where that is in words."""
        witness = self._scene.witness(start, end)
        return witness.obstacle, witness.distance - radius, point(witness.on_mesh)
