"""The curve that a motion follows: a piecewise polynomial, evaluated by arc length."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, instance, positive, real
from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.kernels import kernel
from hognose.path import arc_length, constructors, nearest
from hognose.units import LARGEST_LENGTH

Array = NDArray[np.float64]

#: Tangents whose cosine is closer to 1 than this are the same: they differ by at most 1e-6 rad.
_STRAIGHT_ON = 5e-13


@kernel()
def _derivatives(breaks: NDArray, coefficients: NDArray, u: NDArray, out: NDArray) -> None:
    """Position, first and second derivative (q, 3, 3) at the parameters u (q,)."""
    segments, width = coefficients.shape[0], coefficients.shape[1]
    for q in range(u.size):
        segment = min(max(np.searchsorted(breaks, u[q], side="right") - 1, 0), segments - 1)
        h = u[q] - breaks[segment]
        for axis in range(3):
            value, first, second = 0.0, 0.0, 0.0
            for j in range(width - 1, -1, -1):
                second = second * h + 2.0 * first
                first = first * h + value
                value = value * h + coefficients[segment, j, axis]
            out[q, 0, axis], out[q, 1, axis], out[q, 2, axis] = value, first, second


@dataclass(frozen=True, eq=False)
class Path:
    """A curve r(u), piecewise polynomial; unless said otherwise, methods take the arc length s in m.

    Attributes
    ----------
    breaks : (S+1,)
        Parameter u where the segments meet.
    coefficients : (S, k+1, 3)
        Ascending powers of u - breaks[h] on segment h: the a_hj of paper eq. (1).
    """

    breaks: Array
    coefficients: Array

    def __post_init__(self) -> None:
        breaks, coefficients = self.breaks, self.coefficients
        if not (
            isinstance(breaks, np.ndarray)
            and isinstance(coefficients, np.ndarray)
            and breaks.dtype == coefficients.dtype == np.float64
            and breaks.ndim == 1
            and coefficients.shape[:1] == (len(breaks) - 1,)
            and coefficients.shape[2:] == (3,)
            and coefficients.size
        ):
            raise InputError("path: expected breaks (S+1,) and coefficients (S, k+1, 3); `Path.through` makes them")
        if not (np.isfinite(coefficients).all() and (breaks[1:] > breaks[:-1]).all()):
            raise InputError("path: expected finite coefficients and breaks that rise")

    @classmethod
    def through(cls, points: ArrayLike, order: int = 3, start_direction: ArrayLike | None = None) -> Path:
        """The smoothest spline of any order through way-points (eqs. 1–3 are the case order = 3).

        Parameters
        ----------
        points : (m, 3) m
            At least two way-points, no two consecutive ones equal.
        order
            Degree k of the pieces, which meet with k - 1 continuous derivatives; 1 is a polyline.
        start_direction : (3,), optional
            Tangent at the first point. With it, the derivatives 2 … k - 1 vanish there, so that a straight
            run in front (see `with_run`) joins with k - 1 continuous derivatives.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            Fewer than two points, equal neighbours, values that are not finite, an order below 1.

        Notes
        -----
        Of all splines of that order with knots at the way-points, the one with the least ∫|r⁽ᵖ⁾|² du,
        p = max(2, ⌈k/2⌉) but at most m: for odd k and no start direction that is the natural spline. The parameter
        is the chord length. Derivation: `docs/path.md`.
        """
        return cls(*constructors.spline(points, order, start_direction))

    @classmethod
    def bezier(cls, points: ArrayLike, start_direction: ArrayLike | None = None) -> Path:
        """One Bézier curve with the given control polygon (m, 3) m, m at most 16 (paper's remark, sec. 3.1).

        With a start direction, two control points are put in front so that it starts straight.
        """
        return cls(*constructors.bezier(points, start_direction))

    @classmethod
    def bspline(cls, points: ArrayLike, order: int = 3, start_direction: ArrayLike | None = None) -> Path:
        """A clamped B-spline with the given control polygon (m, 3) m (paper's remark, sec. 3.1).

        With a start direction, order - 1 control points are put in front so that it starts straight.
        """
        return cls(*constructors.bspline(points, order, start_direction))

    def with_run(self, length: float) -> Path:
        """The same path with a straight run of `length` m in front, along its first tangent."""
        length = real("length", length, f"a length above 0 m and up to {LARGEST_LENGTH:,.0f} m", _is_length)
        start, tangent = self.point(0.0), self.tangent(0.0)
        run = np.zeros((1, *self.coefficients.shape[1:]))
        run[0, 0], run[0, 1] = start - length * tangent, tangent
        return Path(np.concatenate([[self.breaks[0] - length], self.breaks]), np.concatenate([run, self.coefficients]))

    def with_end(self, length: float) -> Path:
        """The same path with a straight way of `length` m behind it, along its last tangent."""
        length = real("length", length, f"a length above 0 m and up to {LARGEST_LENGTH:,.0f} m", _is_length)
        way = np.zeros((1, *self.coefficients.shape[1:]))
        way[0, 0], way[0, 1] = self.point(self.length), self.tangent(self.length)
        return Path(np.append(self.breaks, self.breaks[-1] + length), np.concatenate([self.coefficients, way]))

    def with_lead(self, lead: Path) -> Path:
        """The same path with another one in front, which ends where it starts."""
        front = instance("lead", lead, Path, "a hognose.Path")
        both = (front.coefficients, self.coefficients)
        width = max(each.shape[1] for each in both)
        pieces = np.concatenate([np.pad(each, ((0, 0), (0, width - each.shape[1]), (0, 0))) for each in both])
        return Path(np.concatenate([front.breaks[:-1] - front.breaks[-1] + self.breaks[0], self.breaks]), pieces)

    def reversed(self) -> Path:
        """The same curve from its end to its start."""
        spans = np.diff(self.breaks)[::-1]
        breaks = np.concatenate([[0.0], np.cumsum(spans)])
        powers = range(self.degree + 1)
        shift = np.array([[math.comb(j, i) if j >= i else 0 for j in powers] for i in powers], dtype=float)
        # r(h - v) as powers of v: Taylor's expansion at the far end of each segment, odd powers turned round.
        grown = self.coefficients[::-1, :, :]
        out = np.zeros_like(grown)
        for i in powers:
            for j in range(i, self.degree + 1):
                out[:, i] += ((-1) ** i * shift[i, j]) * spans[:, None] ** (j - i) * grown[:, j]
        return Path(breaks, out)

    def distance_to(self, points: ArrayLike) -> Array:
        """Distance (...) m of each of points (..., 3) m to the closest point of the path.

        Searched among samples 2 mm apart, then refined on the curve to rounding. Fastest if consecutive points are
        close to each other.
        """
        array = coordinates("points", points, "(..., 3)")
        flat = array.reshape(-1, 3)
        pieces = np.maximum(1, np.ceil(np.diff(self.break_arcs) / 0.002)).astype(np.int64)
        edges = zip(self.breaks[:-1], np.diff(self.breaks), pieces, strict=True)
        samples = np.concatenate([start + span * np.arange(k) / k for start, span, k in edges] + [self.breaks[-1:]])
        places = self._at_parameter(samples)[:, 0].copy()
        away = nearest.distances(self.breaks, self.coefficients, samples, places, flat)
        return away.reshape(array.shape[:-1])

    @cached_property
    def _cells(self) -> arc_length.Cells:
        return arc_length.table(self.breaks, self.coefficients)

    @property
    def degree(self) -> int:
        """Degree k of the polynomial pieces."""
        return self.coefficients.shape[1] - 1

    @property
    def length(self) -> float:
        """Arc length of the whole path, m."""
        return float(self._cells[2][-1])

    @cached_property
    def break_arcs(self) -> Array:
        """Arc length (S+1,) m at the breaks."""
        _, start, arc = self._cells
        return np.append(arc[:-1][start[:-1] == 0.0], arc[-1])

    def parameter(self, s: ArrayLike) -> Array:
        """Parameter u (...) at arc lengths s (...) m."""
        arcs = self._arcs(s)
        u = arc_length.parameters(self.breaks, self.coefficients, self._cells, arcs.ravel())
        return u.reshape(arcs.shape)

    def arc_length(self, u: ArrayLike) -> Array:
        """Arc length s (...) m at parameters u (...) between the first and the last break."""
        array = floats("u", u, "(...)", unit="")
        first, last = self.breaks[0], self.breaks[-1]
        slack = 1e-12 * (last - first)
        if not ((array >= first - slack) & (array <= last + slack)).all():
            raise InputError(f"u: expected parameters within {first:g} … {last:g}, the breaks of the path")
        return arc_length.arcs(self.breaks, self.coefficients, self._cells, array.ravel()).reshape(array.shape)

    def point(self, s: ArrayLike) -> Array:
        """Position (..., 3) m at arc lengths s (...) m; s outside 0 … length is an InputError."""
        return self._at(s)[..., 0, :]

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangent (..., 3) at arc lengths s (...) m."""
        first = self._at(s)[..., 1, :]
        return first / np.linalg.norm(first, axis=-1, keepdims=True)

    def frame(self, s: ArrayLike) -> Array:
        """Position and its first two derivatives by the parameter u (..., 3, 3) at arc lengths s (...) m."""
        return self._at(s)

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature (...) 1/m at arc lengths s (...) m."""
        return _curvature(self._at(s))

    def equal_distance_points(self, spacing: float) -> Array:
        """The points M(In) of paper section 3.2: (N, 3) m, `spacing` m of arc apart, from the start.

        The last point is the last multiple of the spacing that lies on the path.
        """
        spacing = positive("spacing", spacing)
        if spacing > self.length * (1 + 1e-12):
            raise InputError(f"spacing: expected above 0 and at most the path's {self.length:.4g} m, got {spacing} m")
        pieces = self.length / spacing
        if pieces > 20_000_000:
            raise InputError(f"spacing: {spacing} m would make {pieces:,.4g} points on {self.length:.4g} m of path")
        count = math.floor(pieces * (1 + 1e-12)) + 1
        return self.point(np.minimum(spacing * np.arange(count), self.length))

    @cached_property
    def sharpest(self) -> tuple[float, float]:
        """The largest curvature (1/m) and its arc length (m), sampled 64 times a segment.

        A kink where two segments meet, as in a polyline, counts as infinite curvature; straight on is no kink.
        """
        kinks = self._kinks
        if kinks.any():
            return math.inf, float(self.break_arcs[1 + np.argmax(kinks)])
        fractions = np.linspace(0.0, 1.0, 65)
        u = (self.breaks[:-1, None] + np.diff(self.breaks)[:, None] * fractions).ravel()
        derivatives = self._at_parameter(np.minimum(u, self.breaks[-1]))
        curvature = _curvature(derivatives)
        # Where the curve stands still, or turns back between two samples, it is a kink.
        first = derivatives[:, 1]
        kinked = np.linalg.norm(first, axis=1) < 1e-9
        kinked[1:] |= np.einsum("ij,ij->i", first[1:], first[:-1]) < 0
        curvature[kinked] = math.inf
        worst = int(np.argmax(curvature))
        arcs = self.break_arcs
        segment, fraction = divmod(worst, 65)
        return float(curvature[worst]), float(arcs[segment] + (arcs[segment + 1] - arcs[segment]) * fractions[fraction])

    @property
    def _kinks(self) -> NDArray[np.bool_]:
        """Whether (S-1,) the tangents of two segments differ where they meet."""
        spans, pieces = np.diff(self.breaks)[:-1, None], self.coefficients
        arriving, leaving = self.degree * pieces[:-1, -1], pieces[1:, 1]
        for power in range(self.degree - 1, 0, -1):
            arriving = arriving * spans + power * pieces[:-1, power]
        along = (arriving * leaving).sum(axis=1)
        sizes = (arriving * arriving).sum(axis=1) * (leaving * leaving).sum(axis=1)
        return along < (1.0 - _STRAIGHT_ON) * np.sqrt(sizes)

    def _at(self, s: ArrayLike) -> Array:
        return self._at_parameter(self.parameter(s))

    def _at_parameter(self, u: Array) -> Array:
        out = np.empty((u.size, 3, 3))
        _derivatives(self.breaks, self.coefficients, u.ravel(), out)
        return out.reshape(*u.shape, 3, 3)

    def _arcs(self, s: ArrayLike) -> Array:
        arcs = floats("s", s, "(...)")
        slack = 1e-12 * self.length
        if not ((arcs >= -slack) & (arcs <= self.length + slack)).all():
            raise InputError(f"s: expected arc lengths within 0 … {self.length:.6g} m of the path")
        return np.clip(arcs, 0.0, self.length)


def _is_length(value: float) -> bool:
    return 0 < value <= LARGEST_LENGTH


def _curvature(derivatives: Array) -> Array:
    first, second = derivatives[..., 1, :], derivatives[..., 2, :]
    speed = np.linalg.norm(first, axis=-1)
    return np.linalg.norm(np.cross(first, second), axis=-1) / np.maximum(speed, 1e-300) ** 3
