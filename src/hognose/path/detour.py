"""The detour (paper section 3.1, figure 2): a spline that collides is led round what it hits.

Where a spline segment collides for a body of the arm's radius, its first and last colliding point B_h and
B_h+1 are moved along their normals by s_max + s (the deepest penetration between them plus the feed step) and
become way-points; the spline is drawn again, until nothing collides. Two things are ours, because the method
stalls without them: of a normal only the part across the path counts (along it a way-point does not evade),
and way-points of an earlier detour in the same stretch are replaced, not joined.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.path.path import Path
from hognose.scene import Scene
from hognose.ties import first_largest, first_smallest
from hognose.wording import point

Array = NDArray[np.float64]

#: Distance (m) of the points at which a path is tested; between them it is covered by a larger radius.
SAMPLE_SPACING = 0.002
#: Rounds before the detour gives up.
MOST_ROUNDS = 40
#: A normal whose part across the path is shorter than this says nothing about the side to evade to.
_CLEAR_SIDE = 0.2
_DIRECTIONS_TRIED = 16


@dataclass(frozen=True)
class _Samples:
    """A path at equal distances: where it is, and how deep a body round it sinks into obstacles."""

    arcs: Array
    points: Array
    tangents: Array
    depth: Array
    away: Array
    triangle: NDArray[np.int32]


def lead_round(
    draw: Callable[[Array], Path],
    way_points: Array,
    scene: Scene,
    radii: Array,
    link_lengths: Array,
    step: float,
    start: float = 0.0,
    longest: float = math.inf,
) -> tuple[Array, Path]:
    """Way-points and path of a spline led round the obstacles.

    Parameters
    ----------
    draw
        Makes the path through way-points (m, 3) m.
    way_points : (m, 3) m
        Kept as they are; the detour puts others between them.
    scene
    radii : (n,) m
        The radius of each link's body, with whatever margin is wanted.
    link_lengths : (n,) m
        With the tip at the path's end, they say which links come how far in.
    step : float, m
        The feed step s that is added to every move.
    start : float, m
        Arc length before which the path is not looked at (the slider's run).
    longest : float, m
        A path that detours make longer than this behind `start` is given up.

    Returns
    -------
    (way_points, path)
        The given ones, bit for bit, if nothing collides.

    Raises
    ------
    InfeasibleError
        A way-point is too close to an obstacle, or the path does not come clear; says which obstacle and where.
    """
    given = way_points
    kept = np.ones(len(way_points), dtype=bool)
    path = draw(way_points)
    if not scene.names:
        return way_points, path
    for _ in range(MOST_ROUNDS):
        samples = _sample(path, scene, radii, link_lengths, start)
        colliding = samples.depth > 0
        if not colliding.any():
            return way_points, path
        _refuse_tight_way_points(given, scene, float(radii[-1]))
        way_points, kept = _evade(path, way_points, kept, samples, scene, float(radii.max()), step)
        path = draw(way_points)
        _refuse_endless_way(path.length - start, longest, samples, scene)
    _refuse_collision(_sample(path, scene, radii, link_lengths, start), scene)
    return way_points, path


def _refuse_collision(samples: _Samples, scene: Scene) -> None:
    """After the last round."""
    (deepest,) = first_largest(samples.depth)
    if samples.depth[deepest] <= 0:
        return
    raise InfeasibleError(
        f"the path does not come clear of {scene.obstacle_of(int(samples.triangle[deepest]))!r} after {MOST_ROUNDS} "
        f"detours: at {point(samples.points[deepest])} the body, margin included, is "
        f"{1e3 * samples.depth[deepest]:.1f} mm too close. Put a way-point where the arm can pass, ask for less "
        "margin, or set path.detour = false to see the motion as it is."
    )


def _refuse_endless_way(length: float, longest: float, samples: _Samples, scene: Scene) -> None:
    """Before a path is sampled that no arm can take, and that grows with every round."""
    if length <= longest:
        return
    deepest = int(np.argmax(samples.depth))
    obstacle, place = scene.obstacle_of(int(samples.triangle[deepest])), point(samples.points[deepest])
    raise InfeasibleError(
        f"the detour round {obstacle!r} at {place} makes the way {1e3 * length:,.0f} mm long, more than "
        f"{1e3 * longest:,.0f} mm. Put a way-point where the arm can pass, ask for less margin, or set "
        "path.detour = false to see the motion as it is."
    )


def _sample(path: Path, scene: Scene, radii: Array, link_lengths: Array, start: float) -> _Samples:
    # Not one more for the last bit of a length that is a multiple of the spacing.
    count = max(2, int(np.ceil((path.length - start) / SAMPLE_SPACING * (1 - 1e-9))) + 1)
    arcs = np.linspace(start, path.length, count)
    derivatives = path.frame(arcs)
    points, first = derivatives[:, 0], derivatives[:, 1]
    # A link comes as far in as the links before it leave room; chords are no longer than arcs.
    furthest = path.length - np.append(np.cumsum(link_lengths[:0:-1])[::-1], 0.0)
    thickest = np.where(furthest[:, None] >= arcs, radii[:, None], 0.0).max(axis=0)
    reach = thickest + (arcs[1] - arcs[0]) / 2
    found = scene.distance(points, points)
    inside = _inside(scene, points, found.value, arcs[1] - arcs[0])
    sign = np.where(inside, -1.0, 1.0)
    away = (points - found.on_mesh) * sign[:, None]
    return _Samples(
        arcs=arcs,
        points=points,
        tangents=first / np.linalg.norm(first, axis=1)[:, None],
        depth=reach - sign * found.value,
        away=away,
        triangle=found.triangle,
    )


def _inside(scene: Scene, points: Array, distance: Array, spacing: float) -> NDArray[np.bool_]:
    """Which samples (m, 3) m of a path lie in solids, given their distances to surfaces and their spacing, m.

    A path changes sides only next to a sample that is within a spacing of a surface: those are asked, and of each run
    between them one.
    """
    near = distance <= spacing
    asked = near | np.append(True, near[:-1])
    inside = np.zeros(len(points), np.bool_)
    inside[asked] = scene.inside(points[asked]) >= 0
    return inside[np.maximum.accumulate(np.where(asked, np.arange(len(points)), 0))]


def _refuse_tight_way_points(way_points: Array, scene: Scene, radius: float) -> None:
    found = scene.distance(way_points, way_points)
    value = np.where(scene.inside(way_points) >= 0, -found.value, found.value)
    (worst,) = first_smallest(value)
    if value[worst] < radius:
        raise InfeasibleError(
            f"way-point {worst + 1} at {point(way_points[worst])} is {1e3 * value[worst]:.1f} mm from "
            f"{scene.obstacle_of(int(found.triangle[worst]))!r}; half the body with its margin needs "
            f"{1e3 * radius:g} mm and does not fit. "
            "Move the way-point."
        )


def _evade(
    path: Path,
    way_points: Array,
    kept: NDArray[np.bool_],
    samples: _Samples,
    scene: Scene,
    radius: float,
    step: float,
) -> tuple[Array, NDArray[np.bool_]]:
    """Way-points with B_h* and B_h+1* put in for every stretch between kept way-points that collides."""
    at = arcs_of(path, way_points)
    anchors = at[kept]
    arcs, points, flags = list(at), list(way_points), list(kept)
    for low, high in pairwise(anchors):
        within = np.flatnonzero((samples.arcs >= low) & (samples.arcs <= high) & (samples.depth > 0))
        if not within.size:
            continue
        first, last = int(within[0]), int(within[-1])
        move = float(samples.depth[first : last + 1].max()) + step
        reach = (samples.arcs[first] - 2 * radius, samples.arcs[last] + 2 * radius)
        stays = [flag or not reach[0] < arc < reach[1] for arc, flag in zip(arcs, flags, strict=True)]
        arcs, points, flags = (
            [item for item, stay in zip(items, stays, strict=True) if stay] for items in (arcs, points, flags)
        )
        ends = (first, last) if first < last else (first,)
        for index, side in zip(ends, _sides(samples, first, last, scene, move + radius), strict=False):
            arcs.append(float(samples.arcs[index]))
            points.append(samples.points[index] + move * side)
            flags.append(False)
    order = np.argsort(arcs, kind="stable")
    return np.array(points)[order], np.array(flags)[order]


def _sides(samples: _Samples, first: int, last: int, scene: Scene, reach: float) -> tuple[Array, Array]:
    """Unit directions across the path in which the first and the last colliding point are moved."""
    deepest = first + first_largest(samples.depth[first : last + 1])[0]
    at_first, at_last, common = (_across(samples, index) for index in (first, last, deepest))
    if at_first is not None and at_last is not None and at_first @ at_last > 0:
        return at_first, at_last
    if common is None:
        common = _widest(samples, deepest, scene, reach)
    return common, common


def _across(samples: _Samples, index: int) -> Array | None:
    """The obstacle's normal less its part along the path, or None where too little is left."""
    normal = samples.away[index]
    size = np.linalg.norm(normal)
    if size == 0:
        return None
    normal = normal / size
    side = normal - (normal @ samples.tangents[index]) * samples.tangents[index]
    width = np.linalg.norm(side)
    return side / width if width > _CLEAR_SIDE else None


def _widest(samples: _Samples, index: int, scene: Scene, reach: float) -> Array:
    """Of several directions across the path, the one that ends farthest from all obstacles."""
    tangent = samples.tangents[index]
    e1 = np.cross(tangent, np.eye(3)[first_smallest(np.abs(tangent))])
    e1 /= np.linalg.norm(e1)
    angles = np.arange(_DIRECTIONS_TRIED) * (2 * np.pi / _DIRECTIONS_TRIED)
    sides = np.cos(angles)[:, None] * e1 + np.sin(angles)[:, None] * np.cross(tangent, e1)
    ends = samples.points[index] + reach * sides
    room = scene.distance(ends, ends).value * np.where(scene.inside(ends) >= 0, -1.0, 1.0)
    return sides[first_largest(room)]


def arcs_of(path: Path, way_points: Array) -> Array:
    """Arc length of each way-point, in order (the closest point of the path behind the one before)."""
    arcs = np.linspace(0.0, path.length, max(2, int(path.length / SAMPLE_SPACING)))
    points = path.point(arcs)
    found, begin = [], 0
    for way_point in way_points:
        begin += int(np.argmin(np.linalg.norm(points[begin:] - way_point, axis=1)))
        found.append(arcs[begin])
    return np.array(found)
