"""Whole-arm fit: the angles with which the body lies closest to the path in the mean, its tip on the path.

What `exact` and `aim` decide section by section is decided here at once: the distance of the body to the path, in a
mean in which large ones count more, is made smallest, on the conditions that the tip is on the path and that no angle
exceeds its limit. For arms of few sections nothing else keeps the body near a bent path.

A pose is a function of the feed alone, to the last bit: at multiples of a stride, keyframes are found one after the
other from the straight run on, and kept for all followers of the same; every pose starts from what the four around it
say. A first pose far along the path needs all keyframes up to it. Where sections extend, how free lengths are is found
first, on the whole path, from where arms would jump. Its weakness: time, some tens of what `exact` takes.

Derivations: docs/following.md. Source: own.
"""

from __future__ import annotations

import math
from copy import copy

import numpy as np

from hognose.errors import InfeasibleError
from hognose.following.fit_freedom import Course, free
from hognose.following.fit_lengths import stretch_of
from hognose.following.fit_model import Chain, Model
from hognose.following.fit_poses import Arm, Stand, advanced, keyed, states_at
from hognose.following.follower import Array, Follower
from hognose.following.keyframes import keyframes_of, without_straight_end
from hognose.following.samples import BASE_SECTIONS, sampled, with_free_base
from hognose.following.sections import SectionFollower
from hognose.path.polynomial import Pieces
from hognose.robot.bends import both_sides
from hognose.robot.sections.chain import ROWS

#: Feed from one keyframe to the next, as a part of the shortest section and as a part of the arm, and at most (m).
_STRIDE_OF_SECTION, _STRIDE_OF_ARM, _STRIDE = 0.25, 0.03, 0.02
#: A free base is no farther from the path than so many mean sections, nor turned from it by more (rad); and what ties
#: it there, in squares of a mean section, so that it has one pose whatever the first section can do.
_FARTHEST, _TURNED, _TIE = 0.25, 1.0, 1e-4


class FittedSections(SectionFollower):
    """The body as close to the path as the whole arm allows, in the mean, within the limits; the tip on the path."""

    name = "fitted"
    glides = False
    grows = False  # keyframes are found one after the other from feed 0 on, on a path that stays as it is

    def _prepare(self) -> None:
        super()._prepare()
        body, bounds, ties = sampled(self.model), self.bend_bounds, np.zeros(2 * self.link_lengths.size)
        length = float(self.link_lengths.sum())
        pitches = np.add.reduceat(self.model.table[:, 2], self.model.first[:-1])
        before = np.concatenate([[0.0], np.cumsum(self.model.table[:, 2])])[:-1]
        self._ends = np.cumsum(pitches)
        self._arcs = np.append(before[body[3]] + body[4] * self.model.table[body[3], 2], length)
        if self.carried:
            of_base = both_sides(np.repeat([[_FARTHEST], [_TURNED]], 2, axis=1))
            held = np.full(2 * BASE_SECTIONS, _TIE * (length / self.link_lengths.size) ** 2)
            body = with_free_base(body)
            bounds, ties = np.concatenate([of_base, bounds]), np.concatenate([held, ties])
        stretch, held = stretch_of(self.model, len(bounds) - self.link_lengths.size)
        ties, every = np.concatenate([ties, held]), np.concatenate([bounds.reshape(-1, 2), stretch[3]])
        if held.size:  # sections of the body are made as long as they are in each pose
            body = (body[0].copy(), *body[1:])
        sections, samples, size = len(bounds), body[4].size, ties.size
        self._stride = min(_STRIDE, _STRIDE_OF_SECTION * float(self.link_lengths.min()), _STRIDE_OF_ARM * length)
        bent, straight = without_straight_end(self.curve)
        longest = length + float((stretch[4] * stretch[3][:, 1]).sum())
        self._long = bent.with_end(straight + 1.5 * longest + 4.0 * self._stride)
        self._pieces: Pieces = self._long.breaks, self._long.coefficients
        self._fit, self._stretch = (body, bounds, ties), stretch
        # A base whose direction is given goes along the run and no farther.
        held_from = math.inf if self.carried or self.axes is None else self._run_length
        freedom = free(bent.length, held_from, self._stride, stretch[4]) if held.size else np.ones(1)
        self._fitted_arm: Arm = body, bounds, ties, every, stretch, freedom
        self._freest = freedom.copy()
        chain: Chain = (
            np.empty((sections + 1, 3)),
            np.empty((sections + 1, 3, 3)),
            np.empty((2 * sections, 6)),
            np.empty((3, sections, ROWS, 3)),
            np.empty((3, samples, 3, 3)),
        )
        model: Model = np.empty(size), np.zeros((size, size)), np.empty(2), np.empty((2, size)), np.empty((2, 3))
        self._room = (chain, model, self._evaluations)
        # With the model's table, the samples, too, are the same.
        of_arm = (body[0], body[1], bounds, ties, self._start, np.array(self.axes is None), *stretch[:4])
        self._keyframes = keyframes_of(size + samples + 4, bent.breaks, bent.coefficients, *of_arm)

    def _bases(self, feeds: Array) -> Stand:
        """Places of the base on the curve, and its axes; each of its own feed, whatever the others are."""
        on_run = feeds <= self._run_length
        bases = self.curve.breaks[0] + feeds
        if on_run.all():
            return bases, self._start
        bases = np.where(on_run, bases, self._long.parameter(feeds))
        axes = self._axes_off_run(self._long, feeds)
        return bases, axes if len(axes) == 1 else np.where(on_run[:, None, None], self._start, axes)

    def _guess(self, feed: float, base: float, axes: Array) -> Array:
        """The state (w,) in which every section ends in the direction of the path at its arc length."""
        reach = self._long.length
        ahead = self._long.tangent(np.minimum(feed + self._ends, reach))
        angles, frame = np.empty_like(self.bend_limits), axes
        for i, tangent in enumerate(ahead):
            x, y, z = frame @ tangent
            beside = math.hypot(x, y)
            bend = math.atan2(beside, z) / beside if beside > 0.0 else 0.0
            angles[i] = np.clip([bend * x, -bend * y], self.bend_bounds[i, :, 0], self.bend_bounds[i, :, 1])
            _, turned = self.model.positions(_only(angles, i)[None], np.zeros(1), self.link_lengths)
            frame = turned[0].T @ frame
        feet = self._long.parameter(np.minimum(feed + self._arcs, reach)) - base
        in_front, longer = 2 * len(self._fit[1]) - angles.size, np.zeros(len(self._stretch[0]))
        return np.concatenate([np.zeros(in_front), angles.ravel(), longer, feet, np.zeros(3)])

    def _known(self, count: int) -> Array:
        """The keyframes up to so many at least, which are found and kept if they are not there yet."""
        if self._stretch[0].size:
            if not self._keyframes.freedom.size:
                keys = self._freed()
                self._keyframes.found, self._keyframes.freedom = (keys, len(keys)), self._fitted_arm[5].copy()
            self._fitted_arm[5][:] = self._keyframes.freedom
        before, known = self._keyframes.found
        if count <= known:
            return before
        keys = self._keyed(before, count)
        self._keyframes.found = keys, count
        return keys

    def _freed(self) -> Array:
        """Find how free lengths are at keyframes; returns these."""
        model = copy(self.model)
        model.extends = np.zeros_like(model.extends)
        axes = None if self.axes is None else self.axes[0].T
        rest = FittedSections(self.path, model, self.link_lengths, self.spacing, self.bend_bounds, axes, self.carried)
        freedom, turns, size = self._fitted_arm[5], 2 * len(self._fit[1]), self._fit[2].size
        freedom[:] = self._freest  # whatever an interrupted search has left there
        keys = rest._known(freedom.size)[: freedom.size]

        def at_rest(places: Array, _: Array) -> Array:
            return _without_lengths(rest._states(places, keys), turns, size)

        of_rest = _without_lengths(keys[:-1], turns, size), at_rest
        course = Course(self._keyed, self._states, turns, size, self._stride / self._stretch[4], freedom, of_rest)
        return course.freed(self._keyframes.found[0][:0])

    def _keyed(self, before: Array, count: int) -> Array:
        """Keyframes up to so many, from the first ones (m, w)."""
        known = len(before)
        if count <= known:
            return before
        feeds = self._stride * np.arange(count, dtype=np.float64)
        bases, axes = self._bases(feeds)
        keys = np.full((count, before.shape[1]), math.nan)
        keys[:known] = before
        first, renewed = known, known == 0
        while first < count:
            if renewed:
                keys[first] = self._guess(feeds[first], bases[first], axes[min(first, len(axes) - 1)])
            failed = keyed(self._pieces, self._fitted_arm, (bases, axes), keys, first, count, self._room)
            # One that cannot be found from those before it is begun anew; if it was, it has no posture.
            first = failed + 1 if renewed and failed == first else failed
            renewed = first < count
        return keys

    def _states(self, places: Array, keys: Array) -> Array:
        """States (T, w) at places (T,) among keyframes; NaN where there is none."""
        states = np.empty((places.size, keys.shape[1]))
        stand = self._bases(places * self._stride)
        states_at(self._pieces, self._fitted_arm, stand, places, keys, self._room, states)
        return states

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        places = feeds / self._stride
        keys = self._known(int(places.max(initial=0.0)) + 3)
        self._parameters = np.full((feeds.size, 1), math.nan)
        self._stood = np.empty((feeds.size, 3, 3))
        rest = (places, keys, float(self.curve.breaks[-1]), self._room, self._parameters[:, 0], self._stood)
        return advanced(self._pieces, self._fitted_arm, self._bases(feeds), *rest, joints)

    def _unreachable(self, feeds: Array, joints: Array, step: int, link: int) -> InfeasibleError:
        if not math.isnan(self._parameters[step, 0]):
            return Follower._unreachable(self, feeds, joints, step, link)  # the path ends before the tip
        return InfeasibleError(
            f"step {step}, feed {1e3 * feeds[step]:.2f} mm: no posture within the bend limits was found that has the "
            "tip on the path and the body near it. Make the path gentler, take more sections, or raise bend_limit_deg"
        )


def _without_lengths(states: Array, turns: int, size: int) -> Array:
    """The angles (T, turns) of states with zeros (T, size) in the place of lengths."""
    return np.pad(states[:, :turns], ((0, 0), (0, size - turns)))


def _only(angles: Array, i: int) -> Array:
    """The angles (n, 2) with all but those of section i straight."""
    alone = np.zeros_like(angles)
    alone[i] = angles[i]
    return alone
