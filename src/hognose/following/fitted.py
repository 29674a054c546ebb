"""Whole-arm fit: the angles with which the body lies closest to the path in the mean, its tip on the path.

What `exact` and `aim` decide section by section is decided here at once: the distance of the body to the path, in a
mean in which large ones count more, is made smallest, on the conditions that the tip is on the path and that no angle
exceeds its limit. For arms of few sections nothing else keeps the body near a bent path.

A pose is a function of the feed alone, to the last bit: at multiples of a stride, keyframes are found one after the
other from the straight run on, and kept for all followers of the same; every pose starts from what the four around it
say. A first pose far along the path needs all keyframes up to it. Its weakness: time, some tens of what `exact` takes.

Derivations: docs/following.md. Source: own.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.following.crossing import OVERRUN
from hognose.following.fit_lengths import Stretch, stretch_of
from hognose.following.fit_model import Chain, Model
from hognose.following.fit_solver import fitted
from hognose.following.follower import Array, Follower
from hognose.following.keyframes import keyframes_of, without_straight_end
from hognose.following.samples import BASE_SECTIONS, FEET_ROWS, Body, foot, sampled, with_free_base
from hognose.following.sections import SectionFollower
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces, evaluate_at
from hognose.robot.bends import both_sides
from hognose.robot.sections.chain import ROWS

#: Feed from one keyframe to the next, as a part of the shortest section and as a part of the arm, and at most (m).
_STRIDE_OF_SECTION, _STRIDE_OF_ARM, _STRIDE = 0.25, 0.03, 0.02
#: A free base is no farther from the path than so many mean sections, nor turned from it by more (rad); and what ties
#: it there, in squares of a mean section, so that it has one pose whatever the first section can do.
_FARTHEST, _TURNED, _TIE = 0.25, 1.0, 1e-4
#: Between keyframes that differ by more (rad) a pose starts from the one before it.
_APART = 0.2


#: Of every keyframe (m, w) its angles, how far its feet are ahead of the base, and its multiplier; NaN if it has none.
Keys = NDArray
#: Places of the base on the curve (T,) and its axes (1 or T, 3, 3), in rows.
Stand = tuple[NDArray, NDArray]
#: Of an arm: its samples, the lowest and highest angles (n, 2, 2) rad, what ties unknowns to 0, (w,) m², lowest and
#: highest unknowns (w, 2), and which sections extend. Unknowns are the angles and how much longer sections are.
Arm = tuple[Body, NDArray, NDArray, NDArray, Stretch]


@kernel(fastmath={"contract"})
def _blended(keys: Keys, place: float, size: int, state: NDArray) -> None:
    """A guess (w,) at a place among keyframes, by the cubic through four of them; the first `size` of it are angles."""
    at = int(place)
    part = place - at
    state[:] = keys[at]
    if part == 0.0:
        return
    gap = 0.0
    for k in range(size):
        gap = max(gap, abs(keys[at + 1, k] - keys[at, k]))
    if not gap < _APART:
        if math.isnan(state[0]):
            state[:] = keys[at + 1]
        return
    if at == 0 or math.isnan(keys[at - 1, 0]) or math.isnan(keys[at + 2, 0]):
        state += part * (keys[at + 1] - keys[at])
        return
    before, after, further = part + 1.0, part - 1.0, part - 2.0
    for k in range(state.size):
        near = before * further * (after * keys[at, k] - part * keys[at + 1, k])
        far = part * after * (before * keys[at + 2, k] / 3.0 - further * keys[at - 1, k] / 3.0)
        state[k] = 0.5 * (near + far)


@kernel(fastmath={"contract"})
def _posed(
    pieces: Pieces, arm: Arm, base: float, state: NDArray, chain: Chain, model: Model, evaluations: NDArray
) -> bool:
    """Change a guess (w,) to the posture of a base at a place on the curve; whether there is one."""
    body, _, ties, bounds, stretch = arm
    size = ties.size
    if math.isnan(state[0]):
        return False
    origin = np.empty(3)
    origin[0], origin[1], origin[2], _, _, _, _, _, _ = evaluate_at(pieces[0], pieces[1], base)
    flat, feet, pull = state[:size], state[size : state.size - 3], state[state.size - 3 :]
    feet += base
    done = fitted(pieces, body, origin, bounds, ties, stretch, flat, feet, pull, chain, model, evaluations)
    chain[0][:] += origin
    # The tip's foot once more: the last step has moved the tip, by little, and feeds are found by where it is.
    tip = chain[0][-1]
    feet[-1] = foot(pieces, feet[-1], tip[0], tip[1], tip[2], np.empty((FEET_ROWS, 3)))
    feet -= base
    return done


@kernel(fastmath={"contract"})
def _keyed(
    pieces: Pieces, arm: Arm, stand: Stand, keys: Keys, first: int, last: int, room: tuple[Chain, Model, NDArray]
) -> int:
    """Fill keyframes from the first to before the last, each from those before it; returns the first that failed.

    Keyframe `first` holds a guess unless it is NaN.
    """
    bases, axes = stand
    chain, model, evaluations = room
    for m in range(first, last):
        if math.isnan(keys[m, 0]):
            keys[m] = keys[m - 1]
            if m > 2 and not math.isnan(keys[m - 2, 0]) and not math.isnan(keys[m - 3, 0]):
                keys[m] += 2.0 * keys[m - 1] - 3.0 * keys[m - 2] + keys[m - 3]
        chain[1][0] = axes[min(m, axes.shape[0] - 1)]
        if not _posed(pieces, arm, bases[m], keys[m], chain, model, evaluations):
            keys[m] = math.nan
            return m
    return last


@kernel(fastmath={"contract"})
def _advance(
    pieces: Pieces,
    arm: Arm,
    stand: Stand,
    places: NDArray,
    keys: Keys,
    end: float,
    room: tuple[Chain, Model, NDArray],
    tips: NDArray,
    frames: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every base, each at a place (T,) among the keyframes.

    Parameters of the tip come into `tips`, and the axes (T, 3, 3) from which the first section begins into `frames`.
    """
    bases, axes = stand
    chain, model, evaluations = room
    sections, state = joints.shape[1] - 1, np.empty(keys.shape[1])
    in_front = arm[1].shape[0] - sections
    for t in range(bases.size):
        chain[1][0] = axes[min(t, axes.shape[0] - 1)]
        at, posed = int(places[t]), False
        for way in range(3):
            if way == 0:
                _blended(keys, places[t], arm[1].size, state)
            else:
                state[:] = keys[at + way - 1]
            posed = _posed(pieces, arm, bases[t], state, chain, model, evaluations)
            if posed:
                break
        tips[t] = bases[t] + state[state.size - 4] if posed else math.nan
        joints[t], frames[t] = chain[0][in_front:], chain[1][in_front]
        if not tips[t] <= end + OVERRUN:
            return t, sections - 1
    return -1, -1


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
        self._fitted_arm: Arm = body, bounds, ties, every, stretch
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
        before, known = self._keyframes.found
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
            failed = _keyed(self._pieces, self._fitted_arm, (bases, axes), keys, first, count, self._room)
            # One that cannot be found from those before it is begun anew; if it was, it has no posture.
            first = failed + 1 if renewed and failed == first else failed
            renewed = first < count
        self._keyframes.found = keys, count
        return keys

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        places = feeds / self._stride
        keys = self._known(int(places.max(initial=0.0)) + 3)
        self._parameters = np.full((feeds.size, 1), math.nan)
        self._stood = np.empty((feeds.size, 3, 3))
        rest = (places, keys, float(self.curve.breaks[-1]), self._room, self._parameters[:, 0], self._stood)
        return _advance(self._pieces, self._fitted_arm, self._bases(feeds), *rest, joints)

    def _unreachable(self, feeds: Array, joints: Array, step: int, link: int) -> InfeasibleError:
        if not math.isnan(self._parameters[step, 0]):
            return Follower._unreachable(self, feeds, joints, step, link)  # the path ends before the tip
        held = "leave out length_range, or " if self.model.extends.any() else "or "
        return InfeasibleError(
            f"step {step}, feed {1e3 * feeds[step]:.2f} mm: no posture within the bend limits was found that has the "
            f"tip on the path and the body near it. Make the path gentler, take more sections, {held}"
            "raise bend_limit_deg"
        )


def _only(angles: Array, i: int) -> Array:
    """The angles (n, 2) with all but those of section i straight."""
    alone = np.zeros_like(angles)
    alone[i] = angles[i]
    return alone
