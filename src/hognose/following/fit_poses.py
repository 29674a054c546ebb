"""Postures of the whole-arm fit, each from the keyframes around it, and keyframes, each from those before it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.crossing import OVERRUN
from hognose.following.fit_lengths import Stretch
from hognose.following.fit_model import Chain, Model
from hognose.following.fit_solver import fitted
from hognose.following.samples import FEET_ROWS, Body, foot
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces, evaluate_at

#: Between keyframes that differ by more (rad) a pose starts from the one before it.
_APART = 0.2
#: The smallest freedom that ties are divided by: with it, lengths are those at rest but for rounding.
_HELD = 1e-6

#: Of every keyframe (m, w) its angles, how far its feet are ahead of the base, and its multiplier; NaN if it has none.
Keys = NDArray
#: Places of the base on the curve (T,) and its axes (1 or T, 3, 3), in rows.
Stand = tuple[NDArray, NDArray]
#: Of an arm: its samples, the lowest and highest angles (n, 2, 2) rad, what ties unknowns to 0, (w,) m², lowest and
#: highest unknowns (w, 2), which sections extend, and at keyframes (m,) how free lengths are, from 0, at rest, to 1.
#: Unknowns are the angles and how much longer sections are.
Arm = tuple[Body, NDArray, NDArray, NDArray, Stretch, NDArray]


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
def _tied(arm: Arm, place: float) -> NDArray:
    """What ties unknowns to 0, (w,) m², at a place among keyframes: lengths the more, the less free they are."""
    ties, freedom, extending = arm[2], arm[5], arm[4][0].size
    if extending == 0:
        return ties
    at = min(int(place), freedom.size - 1)
    after, part = min(at + 1, freedom.size - 1), place - int(place)
    free = max((1.0 - part) * freedom[at] + part * freedom[after], _HELD)
    tied = ties.copy()
    tied[ties.size - extending :] /= free * free
    return tied


@kernel(fastmath={"contract"})
def _posed(
    pieces: Pieces,
    arm: Arm,
    base: float,
    ties: NDArray,
    state: NDArray,
    chain: Chain,
    model: Model,
    evaluations: NDArray,
) -> bool:
    """Change a guess (w,) to the posture of a base at a place on the curve; whether there is one."""
    body, _, _, bounds, stretch, _ = arm
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
def keyed(
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
        if not _posed(pieces, arm, bases[m], _tied(arm, m), keys[m], chain, model, evaluations):
            keys[m] = math.nan
            return m
    return last


@kernel(fastmath={"contract"})
def _posed_among(
    pieces: Pieces,
    arm: Arm,
    stand: Stand,
    t: int,
    place: float,
    keys: Keys,
    room: tuple[Chain, Model, NDArray],
    state: NDArray,
) -> bool:
    """Find the posture of the t-th base, at a place among the keyframes, from those around it; whether there is one."""
    bases, axes = stand
    chain, model, evaluations = room
    chain[1][0] = axes[min(t, axes.shape[0] - 1)]
    at, ties = int(place), _tied(arm, place)
    for way in range(3):
        if way == 0:
            _blended(keys, place, arm[1].size, state)
        else:
            state[:] = keys[at + way - 1]
        if _posed(pieces, arm, bases[t], ties, state, chain, model, evaluations):
            return True
    return False


@kernel(fastmath={"contract"})
def advanced(
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
    bases = stand[0]
    chain = room[0]
    sections, state = joints.shape[1] - 1, np.empty(keys.shape[1])
    in_front = arm[1].shape[0] - sections
    for t in range(bases.size):
        posed = _posed_among(pieces, arm, stand, t, places[t], keys, room, state)
        tips[t] = bases[t] + state[state.size - 4] if posed else math.nan
        joints[t], frames[t] = chain[0][in_front:], chain[1][in_front]
        if not tips[t] <= end + OVERRUN:
            return t, sections - 1
    return -1, -1


@kernel(fastmath={"contract"})
def states_at(
    pieces: Pieces,
    arm: Arm,
    stand: Stand,
    places: NDArray,
    keys: Keys,
    room: tuple[Chain, Model, NDArray],
    states: NDArray,
) -> None:
    """Fill states (T, w) of bases, each at a place (T,) among the keyframes; NaN where there is none."""
    for t in range(places.size):
        if not _posed_among(pieces, arm, stand, t, places[t], keys, room, states[t]):
            states[t] = math.nan
