"""How free lengths are to leave those at rest, at each keyframe: less where an arm that extends would jump.

Where a posture ceases to be a minimum, an arm jumps to another one. The more freely lengths leave those at rest, the
more minima there are; with lengths held at rest, they are those of an arm that does not extend. So intervals between
keyframes are gone through one after the other. Where angles or lengths change too fast, lengths are made less free,
step by step down to not at all, and less so around it by a slope, and what this changes is gone through again. How
fast is too fast is measured by the arm at rest.

What comes out is a function of the path and the arm alone. Derivation: docs/following.md. Source: own.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: What finds states (T, w) at places (T,) among keyframes (m, w).
States = Callable[[Array, Array], Array]

#: How much angles (rad) and lengths (mean sections) may change in a feed of a mean section; or so much of how much
#: those of the arm at rest do within so many mean sections around, at most so many times as much. That is also how much
#: they may where no slider gets.
_TURN, _LENGTHEN, _AS_AT_REST, _NEAR, _FASTEST = 2.0, 0.5, 1.05, 0.25, 6.0
#: What is left of the freedom each time, and what is as good as none.
_LEFT, _NONE = 0.4, 0.08
#: In how many mean sections of feed lengths go from held to free.
_REACH = 1.0
#: Intervals that are found at once, and parts of each.
_AT_ONCE, _PARTS = 6, 4
#: If more than so many times as much changes in one part of an interval as in any other, it is halved, so often, as
#: long as one half has such a part of the change. The arm at rest may be fast: it is halved until only jumps are left.
_UNEVEN, _HALVED, _MOST_OF_IT, _HALVED_AT_REST = 1.3, 9, 0.6, 20

#: What an interval between keyframes is: all right, too fast, or with a jump or without a posture.
STEADY, FAST, BROKEN = 0, 1, 2


def free(length: float, held_from: float, stride: float, unit: float) -> Array:
    """Freedom (m,) at all keyframes of a path of a length (m), a stride (m) apart: 1, and less behind some feed (m).

    `unit` is a mean section (m). Behind the last one it stays what it is there.
    """
    count = math.ceil(min(length, held_from + _REACH * unit) / stride) + 2
    feeds = stride * np.arange(count, dtype=np.float64)
    return np.clip(1.0 - (feeds - held_from) / (_REACH * unit), 0.0, 1.0)


def places_between(first: int, last: int) -> Array:
    """Where the parts (T,) of the intervals from the first keyframe to the last one meet, but for keyframes."""
    inner = np.arange(1, _PARTS, dtype=np.float64) / _PARTS
    return (np.arange(first, last, dtype=np.float64)[:, None] + inner).ravel()


def _in_parts(keys: Array, between: Array) -> Array:
    """States (m, _PARTS + 1, w) at the ends of all parts of intervals, of keyframes (m+1, w) and those between."""
    inner = between.reshape(len(keys) - 1, _PARTS - 1, -1)
    return np.concatenate([keys[:-1, None], inner, keys[1:, None]], axis=1)


class Course:
    """What is asked of an arm on its path.

    Parameters
    ----------
    keyed
        Finds the keyframes up to so many, given the first ones (m, w).
    states
        Finds states (T, w) at places (T,) among keyframes (m, w).
    turns, size
        The first `turns` of a state are angles, those behind, up to `size`, lengths.
    stride
        Feed from keyframe to keyframe, in mean sections.
    freedom : (m,)
        As of `free`; it is changed in place, and `keyed` and `states` go by it.
    at_rest
        Keyframes (m-1, size) of the arm at rest, and what finds its states, as `states` does.
    """

    def __init__(
        self,
        keyed: Callable[[Array, int], Array],
        states: States,
        turns: int,
        size: int,
        stride: float,
        freedom: Array,
        at_rest: tuple[Array, States],
    ) -> None:
        self._keyed, self._states, self._turns, self._size = keyed, states, turns, size
        self._stride, self._freedom, self._at_rest = stride, freedom, at_rest
        keys, rested = at_rest
        found = _in_parts(keys, rested(places_between(0, len(keys) - 1), keys))
        steps = np.abs(np.diff(found[..., :turns], axis=1)).max(axis=(1, 2))
        rates = np.nan_to_num(steps, nan=math.inf) / (stride / _PARTS * _TURN)
        near = round(_NEAR / stride)
        around = np.lib.stride_tricks.sliding_window_view(np.pad(rates, near, mode="edge"), 2 * near + 1)
        self._on_run = freedom[1:-1] == 1.0
        self._lost: dict[int, bool] = {}
        self._allowed = np.clip(_AS_AT_REST * around.max(axis=1), np.where(self._on_run, 1.0, _FASTEST), _FASTEST)

    def freed(self, known: Array) -> Array:
        """Find how free lengths are, and the keyframes with that; `known` (0, w) are none of them."""
        count, first = self._freedom.size - 2, 0
        while first < count:
            last = min(first + _AT_ONCE, count)
            known = self._keyed(known, last + 2)
            bad, what = self._judged(self._states, known, first, last)
            if what == STEADY:
                first = last
                continue
            changed = self._less_free(bad, what)
            first = bad + 1 if changed < 0 else max(changed - 2, 0)
            if changed >= 0:
                known = known[:changed]
        return known

    def _judged(self, states: States, keys: Array, first: int, last: int) -> tuple[int, int]:
        """The first of some intervals that is not steady, and what it is; (last, STEADY) if all are."""
        found = _in_parts(keys[first : last + 1], states(places_between(first, last), keys))
        steps = self._apart(found[:, :-1], found[:, 1:])
        for i, (*_, next_largest, largest) in enumerate(np.sort(steps, axis=1)):
            most = self._stride / _PARTS * self._allowed[first + i]
            if largest > most or largest > _UNEVEN * next_largest + 0.01 * most:
                part = int(np.argmax(steps[i]))
                broken = self._broken(states, keys, (first + i, part), found[i, part], found[i, part + 1])
                if broken or largest > most:
                    return first + i, BROKEN if broken else FAST
        return last, STEADY

    def _broken(self, states: States, keys: Array, where: tuple[int, int], before: Array, after: Array) -> bool:
        """Whether what changes in an interval, in a part of it, does so at one feed, or a posture is missing."""
        interval, part = where
        place, width, whole = interval + part / _PARTS, 1.0 / _PARTS, float(self._apart(before, after))
        for _ in range(_HALVED if states is self._states else _HALVED_AT_REST):
            width *= 0.5
            (middle,) = states(np.array([place + width]), keys)
            one, other = float(self._apart(before, middle)), float(self._apart(middle, after))
            if math.isinf(max(one, other)):
                return True
            if max(one, other) < _MOST_OF_IT * whole:
                return False
            if one > other:
                after, whole = middle, one
            else:
                before, whole, place = middle, other, place + width
        return whole > width * self._stride * self._allowed[interval]

    def _apart(self, before: Array, after: Array) -> Array:
        """How much states (..., w) differ, as a part of what they may in a feed of a mean section; inf if not there."""
        apart = np.abs(after - before)
        turned, longer = apart[..., : self._turns].max(axis=-1), apart[..., self._turns : self._size].max(axis=-1)
        return np.nan_to_num(np.maximum(turned / _TURN, longer / _LENGTHEN), nan=math.inf)

    def _lost_at_rest(self, interval: int) -> bool:
        """Whether the arm at rest, too, jumps or has no posture in an interval: less freedom is no cure."""
        if interval not in self._lost:
            keys, states = self._at_rest
            self._lost[interval] = self._judged(states, keys, interval, interval + 1)[1] == BROKEN
        return self._lost[interval]

    def _less_free(self, interval: int, what: int) -> int:
        """Make lengths less free in an interval; returns the first keyframe where they are, or -1 if nothing helps."""
        if self._lost_at_rest(interval):
            return -1
        freedom = self._freedom
        before, here = freedom.copy(), freedom[interval : interval + 2].max()
        if here > 0.0:
            left = _LEFT * here if _LEFT * here > _NONE else 0.0
            places = np.arange(freedom.size)
            away = np.maximum(np.maximum(interval - places, places - interval - 1), 0)
            np.minimum(freedom, left + self._stride / _REACH * away, out=freedom)
        elif what == BROKEN and self._on_run[interval]:
            # The posture is another one than that of the arm at rest. With lengths held from feed 0 on, it is the same.
            freedom[:interval] = 0.0
        changed = np.flatnonzero(freedom != before)
        return int(changed[0]) if changed.size else -1
