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

from hognose.following.crossing import OVERRUN, REACH, bracketed, fastest_on_segments, halved
from hognose.following.follower import Array, Follower
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, segment_at

#: A Newton step so small, in m and in link lengths, that the expansion carries u and the position the rest of the
#: way: what it leaves out is of the order step⁴/L³ in the length and step³ κ′ on the curve.
_LAST_STEP, _LAST_PART = 1e-5, 1e-3


@kernel(fastmath={"contract"})
def _advance(
    breaks: NDArray,
    coefficients: NDArray,
    fastest: NDArray,
    lengths: NDArray,
    tracks: bool,
    bases: NDArray,
    feeds: NDArray,
    memory: NDArray,
    segments: NDArray,
    parameters: NDArray,
    evaluations: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every feed; `memory` holds Δu, its rate, and the last feed (NaN before the first)."""
    links = lengths.size
    last = coefficients.shape[0] - 1
    top_speed = fastest.max()
    for t in range(feeds.size):
        change = feeds[t] - memory[0, links]
        remembers = tracks and not math.isnan(change)
        per_feed = 1.0 / change if remembers and abs(change) > 1e-9 else 0.0
        before = bases[t]
        segment = segment_at(breaks, before)
        x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, before - breaks[segment])
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        parameters[t, 0] = before
        for i in range(links):
            length = lengths[i]
            delta = memory[0, i] + memory[1, i] * change
            u, segment, found = before + delta, segments[i], False
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
                low, u = bracketed(breaks, coefficients, fastest, before, x, y, z, length, evaluations)
                if math.isnan(u):
                    memory[0, links] = math.nan
                    return t, i
                u = halved(breaks, coefficients, low, u, 0.0, x, y, z, length, evaluations)
                segment = segment_at(breaks, u)
                px, py, pz, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
            delta = u - before
            memory[1, i] = (delta - memory[0, i]) * per_feed
            memory[0, i] = delta
            segments[i] = segment
            x, y, z, before = px, py, pz, u
            parameters[t, i + 1] = u
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
        memory[0, links] = feeds[t]
    return -1, -1


class Exact(Follower):
    """Predicted Newton on the spline: link lengths and joints on the path to rounding."""

    name = "exact"

    def __init__(
        self, path: Path, link_lengths: ArrayLike, spacing: float = 0.0005, bend_limits: ArrayLike | None = None
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        links = self.link_lengths.size
        self._memory = np.zeros((2, links + 1))
        self._memory[0, links] = math.nan
        self._segments = np.zeros(links, np.int64)
        self._parameters = np.empty((1, links + 1))
        self._fastest = fastest_on_segments(self.curve)
        self._run_length = straight_start(self.curve)

    @property
    def tolerance(self) -> float:
        """Rounding only."""
        return 1e-12

    def run_with_arcs(self, feeds: ArrayLike) -> tuple[Array, Array]:
        """Joint positions (T, n+1, 3) m and their arc lengths (T, n+1) m on the curve; errors as in `run`."""
        joints = self.run(feeds)
        return joints, self.curve.arc_length(np.minimum(self._parameters, self.curve.breaks[-1]))

    def _base_parameters(self, feeds: Array) -> Array:
        return self.curve.parameter(feeds)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        curve = self.curve
        if len(self._parameters) != feeds.size:
            self._parameters = np.empty((feeds.size, self.link_lengths.size + 1))
        furthest = feeds[0] if feeds.size == 1 else feeds.max(initial=0.0)
        return _advance(
            curve.breaks,
            curve.coefficients,
            self._fastest,
            self.link_lengths,
            self.tracks,
            curve.breaks[0] + feeds if furthest <= self._run_length else self._base_parameters(feeds),
            feeds,
            self._memory,
            self._segments,
            self._parameters,
            self._evaluations,
            joints,
        )


def straight_start(path: Path) -> float:
    """Length (m) of the first segment if its parameter is its arc length, as on the slider's run; else 0."""
    first = path.coefficients[0]
    runs = abs(math.hypot(*first[1]) - 1.0) < 1e-14 and not first[2:].any()
    return float(path.breaks[1] - path.breaks[0]) if runs else 0.0
