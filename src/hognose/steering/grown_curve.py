"""A curve that grows behind a steered nose, piece by piece, and the joints of an arm on it.

Each piece is the Taylor polynomial of a curve whose curvature changes linearly and that does not twist: a clothoid in
space. With t the tangent, k = t′ the curvature vector and j what the steering adds to it, a curve without twist has
t′ = k, k′ = j - (k·k) t and j′ = -(j·k) t, which gives all further derivatives. Pieces are short, so that the parameter
may be taken for the arc length: what the polynomial leaves out is below a millionth of its speed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, segment_at

Array = NDArray[np.float64]

_DEGREE = 5
_FACTORIALS = np.array([math.factorial(j) for j in range(_DEGREE + 1)], dtype=np.float64)
#: A chord of the gentlest curve for which joints glide (curvature × chord ≤ √2) is reached within this many chords.
LONGEST_ARC = 1.12
#: Newton's method on a link is done after a step (m) this small, whose square is below rounding.
_LAST_STEP = 1e-9
#: Depths of the nose are multiples of this (m), so that moves add up and cancel without rounding.
_GRID = 2.0**-40
#: The curve's parameter is its arc length but for less than this part.
ARC_SLACK = 1e-6


@kernel()
def _placed(breaks: NDArray, coefficients: NDArray, lengths: NDArray, tips: NDArray, at: NDArray, out: NDArray) -> None:
    """From the tip at each parameter (T,) back: parameters (T, n+1) and positions (T, n+1, 3) of the joints.

    Nothing is remembered from one tip to the next, so that the same place always gives the same joints, bit for bit.
    """
    links = lengths.size
    for t in range(tips.size):
        u = tips[t]
        segment = segment_at(breaks, u)
        x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
        at[t, links] = u
        out[t, links, 0], out[t, links, 1], out[t, links, 2] = x, y, z
        for i in range(links - 1, -1, -1):
            length = lengths[i]
            low, high, v = u - LONGEST_ARC * length, u, u - length
            for _ in range(60 if u > 0.0 else 0):  # on the straight run the chord is the arc, without rounding
                segment = segment_at(breaks, v)
                px, py, pz, vx, vy, vz, _, _, _ = evaluate(coefficients, segment, v - breaks[segment])
                dx, dy, dz = px - x, py - y, pz - z
                lacking = length * length - (dx * dx + dy * dy + dz * dz)
                if lacking > 0.0:
                    high = v
                else:
                    low = v
                slope = 2.0 * (dx * vx + dy * vy + dz * vz)
                step = lacking / slope if slope < 0.0 else 0.5 * (low + high) - v
                if not low <= v + step <= high:
                    step = 0.5 * (low + high) - v
                v += step
                if abs(step) < _LAST_STEP:
                    break
            u, segment = v, segment_at(breaks, v)
            x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
            at[t, i] = u
            out[t, i, 0], out[t, i, 1], out[t, i, 2] = x, y, z


@kernel()
def _derivatives(breaks: NDArray, coefficients: NDArray, u: float, out: NDArray) -> None:
    """Position, first and second derivative (3, 3) at a parameter, which may be the end of the last piece."""
    segment = segment_at(breaks, u)
    x, y, z, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
    out[0, 0], out[0, 1], out[0, 2] = x, y, z
    out[1, 0], out[1, 1], out[1, 2] = vx, vy, vz
    out[2, 0], out[2, 1], out[2, 2] = 2.0 * ax, 2.0 * ay, 2.0 * az


class GrownCurve:
    """The slider's straight run and what has grown behind the nose; the parameter (m) is 0 at the entrance.

    Parameters
    ----------
    entrance : (3,) m
        Where the run ends and the curve begins to grow.
    direction : (3,)
        Of the run.
    link_lengths : (n,) m
        Of the arm, which is as long as the run.
    """

    def __init__(self, entrance: Array, direction: Array, link_lengths: Array) -> None:
        self._lengths = link_lengths
        # Taken off link by link as in following, so that the straight arm's feed is 0 without rounding.
        first = 0.0
        for length in link_lengths[::-1]:
            first -= float(length)
        self._breaks = np.array([first, 0.0])
        self._coefficients = np.zeros((1, _DEGREE + 1, 3))
        self._coefficients[0, :2] = entrance + first * direction, direction
        self._pieces = 1

    @property
    def start(self) -> float:
        """Parameter (m) of the straight arm's first joint."""
        return float(self._breaks[0])

    @property
    def end(self) -> float:
        """Parameter (m) to which the curve has grown."""
        return float(self._breaks[self._pieces])

    def path(self) -> Path:
        """The curve as a path of its own, which goes on unchanged when this one grows."""
        return Path(self._breaks[: self._pieces + 1].copy(), self._coefficients[: self._pieces].copy())

    def place(self, tips: Array) -> tuple[Array, Array]:
        """Parameters (T, n+1) m and positions (T, n+1, 3) m of the joints with the tip at parameters (T,) m."""
        joints = self._lengths.size + 1
        at, positions = np.empty((tips.size, joints)), np.empty((tips.size, joints, 3))
        _placed(*self.pieces, self._lengths, tips, at, positions)
        return at, positions

    def travel(self, at: Array, positions: Array) -> Array:
        """How far (T-1, n+1) m joints glide at most from each place to the next, of what `place` gives."""
        return np.diff(at, axis=0) * (1 + ARC_SLACK)

    @property
    def pieces(self) -> tuple[Array, Array]:
        """Breaks (S+1,) and coefficients (S, k+1, 3), which are good until it grows or is cut."""
        return self._breaks[: self._pieces + 1], self._coefficients[: self._pieces]

    def derivatives(self, u: float) -> Array:
        """Position, first and second derivative (3, 3) by the parameter u (m)."""
        out = np.empty((3, 3))
        _derivatives(*self.pieces, u, out)
        return out

    def cut(self, u: float) -> None:
        """Drop what is beyond the parameter u (m), at least 0."""
        self._pieces = int(np.searchsorted(self._breaks[1 : self._pieces + 1], u)) + 1
        self._breaks[self._pieces] = u

    def grow(self, position: Array, u: float, curvature: Array, slew: float) -> Array:
        """Append one piece up to the parameter u, on which the curvature goes towards the one that is wished.

        Parameters
        ----------
        position : (3,) m
            The end of the curve, as it was placed, so that the tip is there to the last bit ever after.
        u : m
            Beyond the end by no more than a small part of the radius of curvature.
        curvature : (3,) 1/m
            Wished, across the tangent at the end.
        slew : 1/m²
            How fast the curvature may change.

        Returns
        -------
        (3,) 1/m
            The wish carried along to the new end, across the tangent there.
        """
        self._make_room()
        span = u - self.end
        _, first, second = self.derivatives(self.end)
        t = first / math.sqrt(first @ first)
        k = second - (second @ t) * t
        j = curvature - k
        j *= min(1.0, slew * span / max(math.sqrt(j @ j), 1e-300)) / span
        kk, jk, jj = k @ k, j @ k, j @ j
        higher = (j - kk * t, -3.0 * jk * t - kk * k, (kk * kk - 3.0 * jj) * t - 5.0 * jk * k - kk * j)
        self._coefficients[self._pieces] = np.array([position, t, k, *higher]) / _FACTORIALS[:, None]
        self._breaks[self._pieces + 1] = u
        self._pieces += 1
        return carried(curvature, t, self.derivatives(u)[1])

    def _make_room(self) -> None:
        """Twice the room when it is full, so that growing costs the same however long the curve is."""
        if self._pieces == len(self._coefficients):
            self._breaks = np.concatenate([self._breaks, np.zeros(self._pieces)])
            self._coefficients = np.concatenate([self._coefficients, np.zeros_like(self._coefficients)])


def carried(vectors: Array, start: Array, end: Array) -> Array:
    """Vectors (..., 3) turned the shortest way that turns the unit direction start (3,) into end (3,)."""
    end = end / math.sqrt(end @ end)
    axis = np.array(
        [
            start[1] * end[2] - start[2] * end[1],
            start[2] * end[0] - start[0] * end[2],
            start[0] * end[1] - start[1] * end[0],
        ]
    )
    x, y, z = axis
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return vectors @ (np.eye(3) + across + across @ across / (1.0 + start @ end)).T


def on_grid(lengths: ArrayLike) -> Array:
    """The next lower multiples of the grid on which depths lie; about a picometre."""
    return np.floor(np.asarray(lengths) / _GRID) * _GRID
