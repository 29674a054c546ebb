"""How close a body comes to itself, by densely sampled points of its axis: nothing in common with the sources."""

from __future__ import annotations

import math

import numpy as np


def dense_clearance(
    joints: np.ndarray, lengths: np.ndarray, radii: np.ndarray, spacing: float
) -> tuple[float, tuple[int, int]]:
    """The smallest distance of points of a body (n+1, 3) that are no neighbours less both radii, and their links.

    Points are `spacing` apart at most, so that the figure is at most so much too large. Infinite if all are neighbours.
    """
    points, arcs, links = [], [], []
    starts = np.append(0.0, np.cumsum(lengths))
    for k, length in enumerate(lengths):
        share = np.linspace(0.0, 1.0, math.ceil(length / spacing) + 1)
        points.append(joints[k] + share[:, None] * (joints[k + 1] - joints[k]))
        arcs.append(starts[k] + share * length)
        links.append(np.full(len(share), k))
    point, arc, link = np.concatenate(points), np.concatenate(arcs), np.concatenate(links)
    off = np.linalg.norm(point[:, None] - point[None], axis=2)
    thick = radii[link][:, None] + radii[link][None]
    neighbours = np.abs(arc[:, None] - arc[None]) < 0.5 * math.pi * thick
    clearance = np.where(neighbours | (link[:, None] == link[None]), math.inf, off - thick)
    a, b = np.unravel_index(int(np.argmin(clearance)), clearance.shape)
    return float(clearance[a, b]), (int(min(link[a], link[b])), int(max(link[a], link[b])))
