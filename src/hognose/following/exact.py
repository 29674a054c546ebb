"""Joints exactly on the spline: predicted arc length, then Newton's method on the curve.

For each link the parameter step Δu_i of the last moment, moved on by its rate of change, predicts the next one
(the continuous form of paper eq. 5). Newton's method on ‖r(u) - C_i‖² = L_i² then takes one or two
evaluations of the spline; the last, tiny step is carried out on its second-order expansion.

Cost a step: O(n), independent of any spacing. Weakness: none known within the bend limits of real joints;
where the path turns by more than a right angle within one link, every step searches from the joint on, which
is slower by about an order of magnitude. Source: own; the first crossing by sphere tracing, after Hart (1996).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.following.crossing import OVERRUN, REACH, Sphere, Traced, bracketed, halved, traced
from hognose.following.follower import Array, Follower
from hognose.following.recall import blank_memory, recalled, remember
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, evaluate_at, segment_at

#: What steps leave behind: what `recalled` takes; segments (n,); parameters (T, n+1) of the joints of the last call.
Memory = tuple[NDArray, NDArray, NDArray]

#: A Newton step so small, in m and in link lengths, that the expansion carries u and the position the rest of the
#: way: what it leaves out is of the order step⁴/L³ in the length and step³ κ′ on the curve.
_LAST_STEP, _LAST_PART = 1e-5, 1e-3


@kernel(fastmath={"contract"})
def _advance(
    curve: Traced, lengths: NDArray, tracks: bool, bases: NDArray, feeds: NDArray, memory: Memory, joints: NDArray
) -> tuple[int, int]:
    """Place the joints for every feed."""
    breaks, coefficients, fastest, evaluations = curve
    steps, segments, parameters = memory
    last = coefficients.shape[0] - 1
    top_speed = fastest.max()
    for t in range(feeds.size):
        remembers, change, per_feed = recalled(steps, feeds[t], tracks)
        before = bases[t]
        x, y, z, _, _, _, _, _, _ = evaluate_at(breaks, coefficients, before)
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        parameters[t, 0] = before
        for i in range(lengths.size):
            length = lengths[i]
            u, segment, found = before + (steps[0, i] + steps[1, i] * change), segments[i], False
            px, py, pz = 0.0, 0.0, 0.0
            if remembers:
                for _ in range(8):
                    evaluations[0] += 1
                    while segment < last and u >= breaks[segment + 1]:
                        segment += 1
                    while segment > 0 and u < breaks[segment]:
                        segment -= 1
                    px, py, pz, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
                    dx, dy, dz = px - x, py - y, pz - z
                    slope = dx * vx + dy * vy + dz * vz
                    if slope <= 0.0:
                        break
                    step = 0.5 * (length * length - (dx * dx + dy * dy + dz * dz)) / slope
                    if abs(step) < min(_LAST_STEP, _LAST_PART * length):
                        bend = 0.5 * (vx * vx + vy * vy + vz * vz) + dx * ax + dy * ay + dz * az
                        part = bend / slope * step
                        step -= step * part * (1.0 - 2.0 * part)
                        px += step * (vx + step * ax)
                        py += step * (vy + step * ay)
                        pz += step * (vz + step * az)
                        u, found = u + step, True
                        break
                    u += step
                near = u > before and (u - before) * top_speed < REACH * length
                found = found and near and u <= breaks[last + 1] + OVERRUN
            if not found:
                sphere = Sphere(x, y, z, length)
                low, u = bracketed(curve, before, sphere)
                if math.isnan(u):
                    steps[0, lengths.size] = math.nan
                    return t, i
                u = halved(curve, low, u, 0.0, sphere)
                segment = segment_at(breaks, u)
                px, py, pz, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
            remember(steps, i, u - before, per_feed)
            segments[i] = segment
            x, y, z, before = px, py, pz, u
            parameters[t, i + 1] = u
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
        steps[0, lengths.size] = feeds[t]
    return -1, -1


class Exact(Follower):
    """Predicted Newton on the spline: link lengths and joints on the path to rounding."""

    name = "exact"

    def _prepare(self) -> None:
        links = self.link_lengths.size
        self._memory: Memory = blank_memory(links), np.zeros(links, np.int64), np.empty((1, links + 1))
        self._traced = traced(self.curve, self._evaluations)
        self._run_length = straight_start(self.curve)

    @property
    def tolerance(self) -> float:
        """Rounding only."""
        return 1e-12

    def run_with_arcs(self, feeds: ArrayLike) -> tuple[Array, Array]:
        """Joint positions (T, n+1, 3) m and their arc lengths (T, n+1) m on the curve; errors as in `run`."""
        joints = self.run(feeds)
        return joints, self.curve.arc_length(np.minimum(self._memory[2], self.curve.breaks[-1]))

    def _base_parameters(self, feeds: Array) -> Array:
        return self.curve.parameter(feeds)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        if len(self._memory[2]) != feeds.size:
            self._memory = *self._memory[:2], np.empty((feeds.size, self.link_lengths.size + 1))
        furthest = feeds[0] if feeds.size == 1 else feeds.max(initial=0.0)
        on_run = furthest <= self._run_length
        bases = self.curve.breaks[0] + feeds if on_run else self._base_parameters(feeds)
        return _advance(self._traced, self.link_lengths, self.tracks, bases, feeds, self._memory, joints)


def straight_start(path: Path) -> float:
    """Length (m) of the first segment if its parameter is its arc length, as on the slider's run; else 0."""
    first = path.coefficients[0]
    runs = abs(math.hypot(*first[1]) - 1.0) < 1e-14 and not first[2:].any()
    return float(path.breaks[1] - path.breaks[0]) if runs else 0.0
