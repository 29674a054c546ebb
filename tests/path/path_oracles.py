"""Random way-points, and slow second opinions on curves."""

import itertools
import math
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from hognose.path import Path

SLIDER = (0.0, 0.0, 1.0)


def way_points(rng, count, straight=0.3):
    """Way-points decimetres apart on a random walk; `straight` is how much of it is bends."""
    steps = rng.normal(size=(count - 1, 3)) * straight + np.array(SLIDER)
    steps *= rng.uniform(0.1, 0.5, (count - 1, 1)) / np.linalg.norm(steps, axis=1)[:, None]
    return np.concatenate([[[0.0, 0.0, 0.0]], np.cumsum(steps, axis=0)]) + rng.uniform(-1, 1, 3)


def derivatives(path, u, highest, side="right"):
    """Derivatives 0 … highest (highest+1, 3) by the parameter, from the piece on this side of u."""
    pieces = len(path.coefficients)
    before = np.searchsorted(path.breaks, u, "left") if side == "left" else np.searchsorted(path.breaks, u, "right")
    segment = int(np.clip(before - 1, 0, pieces - 1))
    powers, h = np.arange(path.degree + 1), u - path.breaks[segment]
    rows = []
    for k in range(highest + 1):
        factors = [math.perm(j, k) for j in powers]
        rows.append(factors * np.where(powers >= k, h ** np.maximum(powers - k, 0), 0.0) @ path.coefficients[segment])
    return np.array(rows)


def at_parameter(path, u):
    u = np.atleast_1d(u)
    segment = np.clip(np.searchsorted(path.breaks, u, "right") - 1, 0, len(path.coefficients) - 1)
    powers = (u - path.breaks[segment])[:, None] ** np.arange(path.degree + 1)
    return np.einsum("qj,qjx->qx", powers, path.coefficients[segment])


def arc_length(path, start, end):
    """Arc length between two parameters by adaptive quadrature, piece by piece."""
    inner = path.breaks[(path.breaks > start) & (path.breaks < end)]
    edges = np.concatenate([[start], inner, [end]])

    def speed(u):
        return float(np.linalg.norm(derivatives(path, u, 1)[1]))

    pieces = itertools.pairwise(edges)
    return sum(quad(speed, a, b, epsabs=1e-15, epsrel=1e-13, limit=400)[0] for a, b in pieces)


def closest_distance(path, point, count=4001):
    """Distance of a point: every local minimum among dense samples is refined, the least one is taken."""
    arcs = np.union1d(np.linspace(0, path.length, count), path.break_arcs)
    gaps = np.linalg.norm(path.point(arcs) - point, axis=1)
    padded = np.concatenate([[np.inf], gaps, [np.inf]])
    valleys = np.flatnonzero((gaps <= padded[:-2]) & (gaps <= padded[2:]))
    # Only valleys that a refinement of one spacing could make the deepest.
    valleys = valleys[gaps[valleys] <= gaps.min() + arcs[1]]
    best = float(gaps.min())
    for valley in valleys:
        low, high = arcs[max(valley - 1, 0)], arcs[min(valley + 1, len(arcs) - 1)]
        for a, b in ((low, arcs[valley]), (arcs[valley], high)):
            if b > a:
                found: Any = minimize_scalar(
                    lambda s: float(np.sum((path.point(s) - point) ** 2)),
                    bounds=(a, b),
                    method="bounded",
                    options={"xatol": 1e-12},
                )
                best = min(best, float(np.sqrt(found.fun)))
    return best


def loop():
    """A curve that crosses over itself 30 mm away, with straight and tightly bent parts."""
    points = [[0, 0, 0], [0, 0, 0.3], [0.2, 0.03, 0.5], [0.3, 0.05, 0.3], [0, 0.03, 0.15], [-0.3, 0, 0.2]]
    return Path.through(points, 3, SLIDER).with_run(0.2)
