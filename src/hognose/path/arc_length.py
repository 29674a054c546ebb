"""Arc length of piecewise polynomials, and the parameter at a given arc length."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.path.quadrature import gauss_legendre

Array = NDArray[np.float64]
#: Cells of the arc-length table: segment (N+1,), local parameter (N+1,) and arc length (N+1,) m of their starts.
Cells = tuple[NDArray[np.int64], Array, Array]

#: Relative accuracy of the arc length.
ACCURACY = 1e-14
#: Nodes and weights of the quadrature.
Rule = tuple[Array, Array]
_RULE = gauss_legendre(10)


def table(breaks: Array, coefficients: Array) -> Cells:
    """Cells so small that one quadrature over each is exact to `ACCURACY`."""
    return _arc_table(breaks, coefficients, ACCURACY, _RULE)


def parameters(breaks: Array, coefficients: Array, cells: Cells, arcs: Array) -> Array:
    """Parameters (q,) at arc lengths (q,) m."""
    out = np.empty(arcs.size)
    _parameters(breaks, coefficients, cells, _RULE, arcs, out)
    return out


def arcs(breaks: Array, coefficients: Array, cells: Cells, parameters: Array) -> Array:
    """Arc lengths (q,) m at parameters (q,)."""
    segment, start, _ = cells
    out = np.empty(parameters.size)
    _arcs(breaks, coefficients, cells, breaks[segment] + start, _RULE, parameters, out)
    return out


@kernel(inline="always")
def _speed_squared(coefficients: NDArray, segment: int, h: float) -> float:
    """‖r′‖² at a local parameter of one segment."""
    squared = 0.0
    for axis in range(3):
        first = 0.0
        for j in range(coefficients.shape[1] - 1, 0, -1):
            first = first * h + j * coefficients[segment, j, axis]
        squared += first * first
    return squared


@kernel()
def _arc(coefficients: NDArray, segment: int, start: float, end: float, rule: Rule) -> float:
    """Arc length between two local parameters of one segment by Gauss–Legendre quadrature."""
    nodes, weights = rule
    half = 0.5 * (end - start)
    total = 0.0
    for k in range(nodes.size):
        total += weights[k] * math.sqrt(_speed_squared(coefficients, segment, start + half * (nodes[k] + 1.0)))
    return half * total


@kernel()
def _arc_table(breaks: NDArray, coefficients: NDArray, accuracy: float, rule: Rule) -> tuple[NDArray, NDArray, NDArray]:
    """Cells (segment, start parameter, arc length of start) so small that one quadrature is exact."""
    # Filled and emptied, so that the compiler knows what the lists hold.
    segment_of, start_of, arc_of = [0], [0.0], [0.0]
    segment_of.clear()
    start_of.clear()
    arc_of.clear()
    arc = 0.0
    for segment in range(coefficients.shape[0]):
        span = breaks[segment + 1] - breaks[segment]
        start, width = 0.0, span
        while start < span:
            width = min(width, span - start)
            whole = _arc(coefficients, segment, start, start + width, rule)
            middle = start + 0.5 * width
            halves = _arc(coefficients, segment, start, middle, rule)
            halves += _arc(coefficients, segment, middle, start + width, rule)
            if abs(whole - halves) > accuracy * (halves + 1e-3) and width > 1e-6 * span:
                width *= 0.5
                continue
            segment_of.append(segment)
            start_of.append(start)
            arc_of.append(arc)
            arc += halves
            start = start + width if span - start - width > 1e-12 * span else span
            width *= 2.0
    segment_of.append(coefficients.shape[0] - 1)
    start_of.append(breaks[-1] - breaks[-2])
    arc_of.append(arc)
    return np.array(segment_of), np.array(start_of), np.array(arc_of)


@kernel()
def _parameters(breaks: NDArray, coefficients: NDArray, cells: Cells, rule: Rule, arcs: NDArray, out: NDArray) -> None:
    """The parameter at each arc length: Newton's method inside the cell that holds it."""
    cell_segment, cell_start, cell_arc = cells
    last = cell_arc.size - 1
    cell = 0
    for q in range(arcs.size):
        s = arcs[q]
        if not (cell_arc[cell] <= s <= cell_arc[cell + 1]):
            cell = min(max(np.searchsorted(cell_arc, s, side="right") - 1, 0), last - 1)
        segment, start = cell_segment[cell], cell_start[cell]
        last_of_segment = cell_segment[cell + 1] != segment or cell + 1 == last
        end = breaks[segment + 1] - breaks[segment] if last_of_segment else cell_start[cell + 1]
        wanted = s - cell_arc[cell]
        length = cell_arc[cell + 1] - cell_arc[cell]
        h = start + (end - start) * wanted / length
        low, high = start, end
        for _ in range(60):
            squared = _speed_squared(coefficients, segment, h)
            missing = wanted - _arc(coefficients, segment, start, h, rule)
            if missing > 0.0:
                low = h
            else:
                high = h
            guess = h + missing / math.sqrt(squared) if squared > 0.0 else 0.5 * (low + high)
            if not low <= guess <= high:  # only where the curve almost stands still
                guess = 0.5 * (low + high)
            step = guess - h
            h = guess
            if abs(step) <= 4e-16 * (abs(h) + abs(breaks[segment + 1])):
                break
        out[q] = breaks[segment] + min(max(h, start), end)


@kernel()
def _arcs(
    breaks: NDArray, coefficients: NDArray, cells: Cells, cell_at: NDArray, rule: Rule, u: NDArray, out: NDArray
) -> None:
    """The arc length at each parameter: up to its cell from the table, within it by quadrature."""
    cell_segment, cell_start, cell_arc = cells
    for q in range(u.size):
        cell = min(max(int(np.searchsorted(cell_at, u[q], side="right")) - 1, 0), cell_at.size - 2)
        segment = cell_segment[cell]
        within = u[q] - breaks[segment]
        out[q] = cell_arc[cell] + _arc(coefficients, segment, cell_start[cell], within, rule)
