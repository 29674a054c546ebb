"""Where the arm comes to rest with its motors held: the nearest minimum of the energy of cables, weight and bending.

    V(q) = Σ ½ k max(0, ℓ(q) - ℓ_commanded)² - Σ m g·p(q) + Σ ½ b q²

within the joint limits, by a Newton method in a trust region. The motors go from lengths at which the planned pose is
at rest to those that are commanded, so that the arm is followed from pose to pose rather than sought from afar. Where
it buckles, what it ends in depends on the way there: then the verdict is of use, the pose is not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.mechanics.cables import geometric_at, jacobian_at
from hognose.mechanics.gravity import gravity_at, room_for
from hognose.mechanics.postures import LONG, lay_joints, lay_pieces, lay_runs
from hognose.mechanics.stiffness import elastic_at
from hognose.mechanics.tensions import solve_spd

Array = NDArray[np.float64]

#: At rest, joint torques are below this share of the weight's and the cables'.
_EXACT = 1e-11
#: Parts of the way of the motors, and Newton steps for each.
_PARTS = 4
_MOST_STEPS = 200
#: No angle changes by more in one step (rad).
_FARTHEST = 0.1
#: Steps in which the energy is lower by less than this share of its terms are judged by the torques.
_ROUNDED = 1e-13
#: How far (rad) the arm is pushed along the softest way off a pose from which it falls.
_KICK, _MOST_KICKS = 1e-3, 3
#: A trust region smaller than this (rad) cannot be told from a point.
_SMALLEST = 1e-15

#: What `settle` says of a step.
STABLE, AT_LIMIT, UNSETTLED = 0, 1, 2


@kernel()
def _forces(q: NDArray, arm: tuple, load: tuple, state: tuple, room: tuple) -> tuple[float, float]:
    """Fill the state of one pose; returns its energy, and the sum of the magnitudes of the energy's terms.

    Parameters
    ----------
    q : (2n,)
    arm
        Joints (n, 2) or (n, 6), sections (c,), holes (c, 3), straight (c,), pieces (p, 7), tool load, springs (2n,).
    load
        Gravity (3,), spring constants (c,), commanded lengths (c,).
    state
        Jacobian (c, 2n), tensions (c,), torques (2n,), stiffness (2n, 2n) of weight and bending.
    room
        Of `room_for`.
    """
    joints, sections, holes, straight, pieces, tool, springs = arm
    gravity, constants, commanded = load
    jacobian, tensions, torque, weight = state
    angles = q.reshape(joints.shape[0], 2)
    torque[:] = 0.0
    weight[:] = 0.0
    energy = gravity_at(angles, pieces, tool, gravity, room, torque, weight)
    size = abs(energy)
    for a in range(q.size):
        bent = springs[a] * q[a]
        energy += 0.5 * bent * q[a]
        size += 0.5 * bent * q[a]
        torque[a] += bent
        weight[a, a] += springs[a]
    tensions[:] = straight - commanded
    jacobian_at(angles, joints, sections, holes, tensions, jacobian)
    for k in range(sections.size):
        stretch = max(tensions[k], 0.0)
        tensions[k] = constants[k] * stretch
        energy += 0.5 * tensions[k] * stretch
        size += 0.5 * tensions[k] * stretch
        for a in range(2 * sections[k] + 2):
            torque[a] += jacobian[k, a] * tensions[k]
    return energy, size


@kernel()
def _largest_of_free(torque: NDArray, held: NDArray) -> float:
    """The largest magnitude of the torques (2n,) that no limit holds."""
    largest = 0.0
    for a in range(torque.size):
        if not held[a]:
            largest = max(largest, abs(torque[a]))
    return largest


@kernel()
def _held(q: NDArray, torque: NDArray, low: NDArray, high: NDArray, held: NDArray) -> float:
    """Which angles a limit holds; returns the largest torque of the others."""
    for a in range(q.size):
        held[a] = (q[a] <= low[a] and torque[a] > 0.0) or (q[a] >= high[a] and torque[a] < 0.0)
    return _largest_of_free(torque, held)


@kernel()
def _newton_step(stiffness: NDArray, held: NDArray, torque: NDArray, work: NDArray, step: NDArray) -> float:
    """The Newton step of the angles that no limit holds; returns what had to be added to the stiffness for it."""
    n = torque.size
    largest = 0.0
    for a in range(n):
        largest = max(largest, abs(stiffness[a, a]))
    added = 0.0
    while True:
        for a in range(n):
            step[a] = 0.0 if held[a] else -torque[a]
            for b in range(a + 1):
                work[a, b] = 0.0 if held[a] or held[b] else stiffness[a, b]
            work[a, a] = 1.0 if held[a] else work[a, a] + added
        if solve_spd(work, step, 1e-12 * largest) or not added < 1e6 * largest:
            return added
        added = max(2.0 * added, 1e-4 * largest)


@kernel()
def _softest(stiffness: NDArray, held: NDArray, work: NDArray, step: NDArray, softest: NDArray) -> None:
    """The direction in which the arm falls the fastest, scaled to 1: power iterations with the inverse."""
    for a in range(softest.size):
        softest[a] = 0.0 if held[a] else 1.0 / (1.0 + a)
    for _ in range(20):
        _newton_step(stiffness, held, softest, work, step)
        softest[:] = -step / np.abs(step).max()


@kernel()
def _stiffness(q: NDArray, arm: tuple, load: tuple, state: tuple, pulling: NDArray, out: NDArray) -> None:
    """The tangent stiffness (2n, 2n) of one pose; slack cables have none."""
    joints, sections, holes = arm[0], arm[1], arm[2]
    jacobian, tensions, weight = state[0], state[1], state[3]
    for k in range(sections.size):
        pulling[k] = load[1][k] if tensions[k] > 0.0 else 0.0
    out[:] = weight
    elastic_at(jacobian, sections, pulling, out)
    geometric_at(q.reshape(joints.shape[0], 2), joints, sections, holes, tensions, out)


@kernel()
def _take(state: tuple, other: tuple) -> None:
    """Copy a state."""
    state[0][:] = other[0]
    state[1][:] = other[1]
    state[2][:] = other[2]
    state[3][:] = other[3]


@kernel()
def _descend(q: NDArray, low: NDArray, high: NDArray, arm: tuple, load: tuple, state: tuple, other: tuple) -> int:
    """Move q (2n,) to the nearest minimum of the energy, and fill its state. Returns what is said of it."""
    n, c = q.size, arm[1].size
    room, pulling, held = room_for(arm[4], arm[0].shape[0]), np.empty(c), np.empty(n, np.bool_)
    stiffness, work, step, trial, softest = np.empty((n, n)), np.empty((n, n)), np.empty(n), np.empty(n), np.empty(n)
    torque = state[2]
    energy, size = _forces(q, arm, load, state, room)
    exact = _EXACT * (np.abs(state[0]).max() * state[1].max() + np.abs(state[3]).max())
    radius, kicks = _FARTHEST, 0
    for _ in range(_MOST_STEPS):
        largest = _held(q, torque, low, high, held)
        _stiffness(q, arm, load, state, pulling, stiffness)
        added = _newton_step(stiffness, held, torque, work, step)
        at_rest = largest <= exact
        if at_rest:
            if added == 0.0:
                return 1 if held.any() else 0
            if kicks == _MOST_KICKS:
                return 2
            kicks += 1
            _softest(stiffness, held, work, step, softest)
            step[:] = _KICK * softest
        farthest = np.abs(step).max()
        if farthest > radius:
            step *= radius / farthest
        slope = 0.0
        for a in range(n):
            trial[a] = min(max(q[a] + step[a], low[a]), high[a])
            slope += torque[a] * (trial[a] - q[a])
        found, terms = _forces(trial, arm, load, other, room)
        lower = found <= energy + 1e-4 * min(slope, 0.0)
        if not lower and abs(found - energy) <= _ROUNDED * (size + terms):
            lower = _largest_of_free(other[2], held) < largest
        if lower or at_rest:
            q[:] = trial
            energy, size, radius = found, terms, min(2.0 * radius, _FARTHEST)
            _take(state, other)
        else:
            radius = 0.25 * min(radius, farthest)
            if radius < _SMALLEST:
                return 2
    return 2


@kernel()
def _lay(posture: NDArray, arm: tuple, out: tuple) -> None:
    """Write an arm as it is in a posture (n, 3)."""
    joints, sections, _, straight, pieces, _, springs = arm
    lay_joints(posture, joints, out[0])
    lay_runs(posture, joints, sections, straight, out[3])
    lay_pieces(posture, pieces, out[4])
    for a in range(springs.size):
        out[6][a] = springs[a] / posture[a // 2, LONG]


@kernel()
def _settle(
    planned: NDArray,
    limits: NDArray,
    arm: tuple,
    gravity: NDArray,
    constants: NDArray,
    begin: NDArray,
    commanded: NDArray,
    out: NDArray,
    tensions: NDArray,
    status: NDArray,
) -> None:
    c, n = arm[1].size, limits.size // 2
    jacobian, torque, weight = np.zeros((c, n)), np.empty(n), np.empty((n, n))
    other = (np.zeros((c, n)), np.empty(c), np.empty(n), np.empty((n, n)))
    low, high = limits[:, :, 0].copy().reshape(n), limits[:, :, 1].copy().reshape(n)
    laid = (arm[0].copy(), arm[1], arm[2], arm[3].copy(), arm[4].copy(), arm[5], arm[6].copy())
    for t in range(planned.shape[0]):
        if planned.shape[2] > LONG:
            _lay(planned[t], arm, laid)
        q = out[t].reshape(n)
        for a in range(n):
            q[a] = min(max(planned[t, a // 2, a % 2], low[a]), high[a])
        for part in range(1, _PARTS + 1):
            target = begin[t] + (commanded[t] - begin[t]) * (part / _PARTS)
            load = (gravity[t], constants[t], target)
            status[t] = _descend(q, low, high, laid, load, (jacobian, tensions[t], torque, weight), other)


def settle(
    planned: Array,
    limits: Array,
    arm: tuple[Array, NDArray[np.int64], Array, Array, Array, float, Array],
    gravity: Array,
    constants: Array,
    begin: Array,
    commanded: Array,
) -> tuple[Array, Array, NDArray[np.int64]]:
    """Angles (T, n, 2) rad in which the arm comes to rest, tensions (T, c) N there, and what is said of each step.

    Parameters
    ----------
    planned : (T, n, 2) rad
        Where to begin; or (T, n, 3) postures, see `hognose.mechanics.postures`.
    limits : (n, 2, 2) rad
        Lowest and highest angles.
    arm
        Joints (n, 2) or (n, 6), sections (c,), holes (c, 3), straight (c,), pieces (p, 7), tool load, as in
        `jacobians_of` and `gravity_of`; and springs (2n,) N m/rad of bending.
    gravity : (T, 3) m/s²
    constants : (T, c) N/m
    begin, commanded : (T, c) m
        Cable lengths without tension with which the motors begin and end.

    Returns
    -------
    angles, tensions
    status : (T,)
        `STABLE`, `AT_LIMIT`: held by a joint limit, or `UNSETTLED`: no rest was found.
    """
    out, tensions = np.empty((*planned.shape[:2], 2)), np.empty(commanded.shape)
    status = np.empty(len(planned), np.int64)
    _settle(planned, limits, arm, gravity, constants, begin, commanded, out, tensions, status)
    return out, tensions, status
