"""Splines through way-points, Bézier and B-spline curves, all as piecewise polynomials."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import floats, whole
from hognose.errors import InputError
from hognose.path.bspline import (
    basis,
    clamped_knots,
    energy,
    power_coefficients,
)
from hognose.units import LARGEST_LENGTH
from hognose.wording import point

Array = NDArray[np.float64]
Pieces = tuple[Array, Array]

#: A single Bézier curve of a higher degree cannot be evaluated exactly as powers.
MOST_BEZIER_POINTS = 16
HIGHEST_ORDER = 9
#: The linear system of a spline grows with the square of its points.
MOST_POINTS = 2000


def spline(points: ArrayLike, order: int, start_direction: ArrayLike | None) -> Pieces:
    """Pieces of the smoothest spline of this order through (m, 3) points; see `Path.through`."""
    way_points = checked_points(points)
    order = _checked_order(order)
    chords = np.linalg.norm(np.diff(way_points, axis=0), axis=1)
    mean = chords.mean()
    sites = np.concatenate([[0.0], np.cumsum(chords)]) / mean
    if order == 1:
        return sites * mean, np.stack([way_points[:-1], np.diff(way_points, axis=0) / chords[:, None]], axis=1)
    breaks, fixed = sites, way_points[:1]
    if start_direction is not None:
        breaks = _with_knots_for_the_start(sites, order)
        fixed = _straight_control_points(breaks, order, way_points[0], _unit(start_direction) * mean)
    knots = clamped_knots(breaks, order)
    control_points = _smoothest(knots, order, sites[1:], way_points[1:], fixed)
    coefficients = power_coefficients(knots, order, control_points)
    return breaks * mean, coefficients / mean ** np.arange(order + 1)[:, None]


def sensitivity(points: ArrayLike, order: int) -> Pieces:
    """How the pieces of a spline with a start direction move with its way-points, the breaks held.

    Parameters
    ----------
    points : (m, 3) m
    order
        At least 2.

    Returns
    -------
    breaks : (S+1,)
        Those of `spline`.
    rates : (S, order+1, m-1)
        By how much the coefficients of an axis grow with the coordinates of way-points 2 … m on that axis.
    """
    way_points = checked_points(points)
    chords = np.linalg.norm(np.diff(way_points, axis=0), axis=1)
    mean = chords.mean()
    sites = np.concatenate([[0.0], np.cumsum(chords)]) / mean
    breaks = _with_knots_for_the_start(sites, order)
    knots = clamped_knots(breaks, order)
    control_points = _smoothest(knots, order, sites[1:], np.eye(len(chords)), np.zeros((order, len(chords))))
    rates = power_coefficients(knots, order, control_points)
    return breaks * mean, rates / mean ** np.arange(order + 1)[:, None]


def bezier(points: ArrayLike, start_direction: ArrayLike | None) -> Pieces:
    """Pieces of one Bézier curve with this control polygon; see `Path.bezier`."""
    polygon = checked_points(points)
    if start_direction is not None:
        polygon = _straightened(polygon, 2, _unit(start_direction))
    if len(polygon) > MOST_BEZIER_POINTS:
        raise InputError(
            f"path: a Bézier curve with {len(polygon)} control points is too stiff to be exact "
            f"(at most {MOST_BEZIER_POINTS}); use a B-spline or a spline through the points"
        )
    return _from_polygon(polygon, len(polygon) - 1)


def bspline(points: ArrayLike, order: int, start_direction: ArrayLike | None) -> Pieces:
    """Pieces of a clamped B-spline with this control polygon; see `Path.bspline`."""
    polygon = checked_points(points)
    order = _checked_order(order)
    if start_direction is not None:
        polygon = _straightened(polygon, order - 1, _unit(start_direction))
    return _from_polygon(polygon, min(order, len(polygon) - 1))


def checked_points(points: ArrayLike) -> Array:
    """Way-points as (m, 3) m, or an InputError that says which one is wrong."""
    array = floats("way-points", points, "(m, 3)", finite=False)
    if len(array) < 2:
        raise InputError(f"way-points: expected at least two points of three coordinates, got shape {array.shape}")
    if len(array) > MOST_POINTS:
        raise InputError(f"way-points: {len(array):,} are too many for one curve; at most {MOST_POINTS:,}")
    if not np.isfinite(array).all():
        bad = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InputError(f"way-points: point {bad + 1} is not finite: {array[bad].tolist()}")
    if (np.abs(array) > LARGEST_LENGTH).any():
        bad = int(np.flatnonzero((np.abs(array) > LARGEST_LENGTH).any(axis=1))[0])
        raise InputError(
            f"way-points: point {bad + 1} is out of range (at most {LARGEST_LENGTH:,.0f} m): {array[bad].tolist()} m"
        )
    gaps = np.linalg.norm(np.diff(array, axis=0), axis=1)
    if (gaps < 1e-9).any():
        same = int(np.flatnonzero(gaps < 1e-9)[0])
        raise InputError(
            f"way-points: points {same + 1} and {same + 2} are the same, {point(array[same], 'g')}; remove one of them"
        )
    return array


def _smoothest(knots: Array, order: int, sites: Array, targets: Array, fixed: Array) -> Array:
    """Control points that start with `fixed`, pass the sites, and bend as little as possible (KKT system)."""
    # Through m points, ∫|r⁽ᵖ⁾|² has one minimiser only if p does not exceed m.
    gram = energy(knots, order, min(max(2, (order + 1) // 2), len(targets) + 1))
    rows = basis(knots, order, sites)
    held = len(fixed)
    free, count = gram.shape[0] - held, len(sites)
    system = np.zeros((free + count, free + count))
    system[:free, :free] = gram[held:, held:]
    system[free:, :free] = rows[:, held:]
    system[:free, free:] = rows[:, held:].T
    right = np.concatenate([-gram[held:, :held] @ fixed, targets - rows[:, :held] @ fixed])
    solution = np.linalg.solve(system, right)
    correction = np.linalg.solve(system, right - system @ solution)
    return np.concatenate([fixed, (solution + correction)[:free]])


def _with_knots_for_the_start(sites: Array, order: int) -> Array:
    """The breaks of a spline that leaves a straight run.

    A junction that is smooth to order k - 1 takes k - 1 freedoms; as many inner knots give them back.
    """
    return np.concatenate([np.linspace(0.0, sites[1], order + 1)[:-1], sites[1:]])


def _straight_control_points(breaks: Array, order: int, start: Array, velocity: Array) -> Array:
    """The first `order` control points of a spline that leaves `start` on a straight line.

    A spline reproduces a straight line where its control points sit at the Greville abscissae.
    """
    knots = clamped_knots(breaks, order)
    greville = np.array([knots[i + 1 : i + order + 1].mean() for i in range(order)])
    return start + (greville - breaks[0])[:, None] * velocity


def _straightened(polygon: Array, extra: int, direction: Array) -> Array:
    """The control polygon with `extra` points put in after the first, along the direction."""
    reach = np.linalg.norm(polygon[1] - polygon[0]) / (extra + 2)
    steps = reach * np.arange(1, extra + 1)[:, None]
    return np.concatenate([polygon[:1], polygon[0] + steps * direction, polygon[1:]])


def _from_polygon(polygon: Array, order: int) -> Pieces:
    """A clamped B-spline; its parameter is scaled to run at about the speed of arc length."""
    spans = len(polygon) - order
    length = np.linalg.norm(np.diff(polygon, axis=0), axis=1).sum()
    breaks = np.arange(spans + 1, dtype=np.float64)
    coefficients = power_coefficients(clamped_knots(breaks, order), order, polygon)
    scale = length / spans
    return breaks * scale, coefficients / scale ** np.arange(order + 1)[:, None]


def _checked_order(order: int) -> int:
    return whole("order", order, 1, HIGHEST_ORDER)


def _unit(direction: ArrayLike) -> Array:
    array = floats("start_direction", direction, "(3,)", unit="")
    largest = np.abs(array).max()
    if largest == 0:
        raise InputError("start_direction: expected three numbers, not all zero")
    array = array / largest  # so that no square overflows or vanishes
    return array / np.linalg.norm(array)
