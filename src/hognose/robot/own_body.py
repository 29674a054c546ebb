"""How far apart the parts of one body are: which of them are neighbours, their distance, and a bound without distances.

A body is a chain of straight chords, each the axis of a capsule. Two places of it are neighbours where the arc between
them is less than half a turn as sharp as the body is thick, (π/2)(rᵢ + rⱼ): they always touch, or nearly so, and how
sharply the body bends there is for bend limits to say. All other places must not touch. What is mounted behind the
first joint is one more chord, in front of all others. See docs/certificate.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.kernels import kernel
from hognose.robot.base import Mount
from hognose.robot.robot import Robot
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: The number that stands for the mount where others are those of chords or links.
MOUNT = -1
#: Lines count as parallel where the squared sine of their angle is below this; distances err by 3e-8 of a chord then.
_PARALLEL = 1e-15


@kernel(inline="always")
def _clamped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@kernel(fastmath={"contract"})
def separation(
    vertices: NDArray, row: int, i: int, j: int, first: Any, second: Any, apart: Any
) -> tuple[float, float, float]:
    """Smallest distance of points of chords i < j that are not neighbours, and where they are.

    `vertices` (T, p+1, 3); the chords have arcs `first` and `second`, and `apart` is the arc that the two points must
    have between them besides what lies between the chords. Returns distance, and arcs of the points from the end of
    chord i back and from the start of chord j on. `apart` must not exceed the sum of both arcs.
    """
    # Of points p + u a and q + v b: r + u a - v b, for u and v of at least `apart` together.
    ax = (vertices[row, i, 0] - vertices[row, i + 1, 0]) / first
    ay = (vertices[row, i, 1] - vertices[row, i + 1, 1]) / first
    az = (vertices[row, i, 2] - vertices[row, i + 1, 2]) / first
    bx = (vertices[row, j + 1, 0] - vertices[row, j, 0]) / second
    by = (vertices[row, j + 1, 1] - vertices[row, j, 1]) / second
    bz = (vertices[row, j + 1, 2] - vertices[row, j, 2]) / second
    rx = vertices[row, i + 1, 0] - vertices[row, j, 0]
    ry = vertices[row, i + 1, 1] - vertices[row, j, 1]
    rz = vertices[row, i + 1, 2] - vertices[row, j, 2]
    aa, ab, bb = ax * ax + ay * ay + az * az, ax * bx + ay * by + az * bz, bx * bx + by * by + bz * bz
    ar, br = ax * rx + ay * ry + az * rz, bx * rx + by * ry + bz * rz
    square = aa * bb - ab * ab
    u = _clamped((ab * br - bb * ar) / square, 0.0, first) if square > _PARALLEL * aa * bb else 0.0
    v = (ab * u + br) / bb
    if v < 0.0 or v > second:
        v = _clamped(v, 0.0, second)
        u = _clamped((ab * v - ar) / aa, 0.0, first)
    if u + v < apart:  # the distance is convex: the closest of those that are allowed have just so much between them
        low, high = max(0.0, apart - second), min(first, apart)
        gx, gy, gz = ax + bx, ay + by, az + bz
        gg = gx * gx + gy * gy + gz * gz
        along = gx * (rx - apart * bx) + gy * (ry - apart * by) + gz * (rz - apart * bz)
        u = _clamped(-along / gg, low, high) if gg > _PARALLEL * aa else low
        v = apart - u
    x, y, z = rx + u * ax - v * bx, ry + u * ay - v * by, rz + u * az - v * bz
    return math.sqrt(x * x + y * y + z * z), u, v


@kernel(fastmath={"contract"})
def _closest(
    vertices: NDArray, pairs: NDArray, lengths: NDArray, aparts: NDArray, thick: NDArray, value: NDArray, pair: NDArray
) -> None:
    """The smallest clearance (T,) of all pairs, and which pair (T,) has it."""
    for row in range(vertices.shape[0]):
        value[row], pair[row] = math.inf, -1
        for k in range(pairs.shape[0]):
            i, j = pairs[k, 0], pairs[k, 1]
            found = separation(vertices, row, i, j, lengths[i], lengths[j], aparts[k])[0] - thick[k]
            if found < value[row]:
                value[row], pair[row] = found, k


@kernel(fastmath={"contract"})
def _between(
    vertices: NDArray,
    travel: NDArray,
    pairs: NDArray,
    lengths: NDArray,
    aparts: NDArray,
    thick: NDArray,
    bound: NDArray,
    pair: NDArray,
) -> None:
    """The lower bound (T-1,) of all pairs' clearance between configurations, and whose it is."""
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        before = separation(vertices, 0, i, j, lengths[i], lengths[j], aparts[k])[0]
        for row in range(bound.size):
            after = separation(vertices, row + 1, i, j, lengths[i], lengths[j], aparts[k])[0]
            moved = max(travel[row, i], travel[row, i + 1]) + max(travel[row, j], travel[row, j + 1])
            found = 0.5 * (before + after - moved) - thick[k]
            if found < bound[row]:
                bound[row], pair[row] = found, k
            before = after


@kernel()
def _cleared(summed: NDArray, pairs: NDArray, most: NDArray) -> bool:
    """Whether the bends between both chords of every pair sum up to no more than `most` (q,) at any step."""
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        for row in range(summed.shape[0]):
            if not summed[row, j] - summed[row, i] <= most[k]:
                return False
    return True


@dataclass(frozen=True, eq=False)
class OwnBody:
    """The pairs of chords of a body of which some places are no neighbours.

    Attributes
    ----------
    lengths : (p,) m
        Arc that each chord stands for.
    pairs : (q, 2) int
        Chords i < j, 0-based.
    aparts : (q,) m
        Arc that two points of a pair must at least have between them besides what lies between the chords.
    arcs : (q,) m
        The shortest arc between two points of a pair that are no neighbours.
    thick : (q,) m
        Distance of axes at which bodies touch: the sum of both radii.
    horizon : m
        A clearance beyond this says nothing: the straight arm has about twice as much, from what is beside neighbours.
    mounts
        How many chords are those of the mount, 0 or 1. It is the first one; `mounted` makes the bodies that have it.
    radii : (p,) m
        Of the chords.
    """

    lengths: Array
    pairs: NDArray[np.int64]
    aparts: Array
    arcs: Array
    thick: Array
    horizon: float
    mounts: int
    radii: Array

    @classmethod
    def of(cls, robot: Robot, mount: Mount | None = None, lengths: Array | None = None) -> OwnBody:
        """The pairs of a robot's chords, and of what it is mounted on; with sections of lengths (n,) m, or at rest."""
        lengths = robot.link_lengths if lengths is None else lengths
        return cls.chain(robot.model.arcs(lengths), robot.chord_radii, mount)

    @classmethod
    def chain(cls, lengths: Array, radii: Array, mount: Mount | None = None) -> OwnBody:
        """The pairs of chords that stand for arcs (p,) m and have radii (p,) m, and of a mount in front of them."""
        mounts = 0 if mount is None else 1
        if mount is not None:
            lengths, radii = np.append(mount.length, lengths), np.append(mount.radius, radii)
        ends = np.append(0.0, np.cumsum(lengths))
        i, j = np.triu_indices(lengths.size, 1)
        thick = radii[i] + radii[j]
        neighbours, gap = 0.5 * math.pi * thick, ends[j] - ends[i + 1]
        aparts = np.maximum(neighbours - gap, 0.0)
        kept = aparts < lengths[i] + lengths[j]
        return cls(
            np.array(lengths),  # that can be written to, as all others are: kernels are compiled once
            np.stack([i, j], axis=1)[kept],
            aparts[kept],
            np.maximum(neighbours, gap)[kept],
            thick[kept],
            0.5 * float(radii[mounts:].min()),
            mounts,
            np.array(radii),
        )

    def left_out(self, bends: Array, varies: NDArray[np.bool_]) -> float:
        """The clearance (m) that places keep which are neighbours here, but not where sections are longer.

        Summed bends φ up to those (p,) rad in and before each chord keep them s cos(φ/2) apart. Only pairs count
        between which lengths vary (p,). Infinite if there are none.
        """
        summed = np.concatenate([np.zeros(self.mounts), np.cumsum(bends)])
        varying = np.concatenate([np.zeros(self.mounts, np.int64), np.cumsum(varies)])
        ends = np.append(0.0, np.cumsum(self.lengths))
        radii, i, j = self.radii, *np.triu_indices(self.lengths.size, 1)
        thick = radii[i] + radii[j]
        neighbours = 0.5 * (math.pi * thick)
        close = (ends[j] - ends[i + 1] < neighbours) & (varying[j] > np.where(i > 0, varying[i - 1], 0))
        bent = summed[j] - np.where(i > 0, summed[i - 1], 0.0)
        kept = neighbours * np.cos(0.5 * np.minimum(bent, math.pi)) - thick
        return float(kept[close].min(initial=math.inf))

    @cached_property
    def most_bent(self) -> Array:
        """Summed bends (q,) rad up to which a pair is at least `horizon` clear without looking; -1 if it never is.

        Two points with arc s and summed bends φ < π between them are at least s cos(φ/2) apart.
        """
        needed = (self.thick + self.horizon) / self.arcs
        return np.where(needed <= 1.0, 2.0 * np.arccos(np.minimum(needed, 1.0)), -1.0)

    def cleared_by_bends(self, bends: Array) -> bool:
        """Whether bends (T, n) rad at the joints of straight links alone show every pair at least `horizon` clear."""
        return bool(_cleared(self.summed(bends), self.pairs, self.most_bent))

    def summed(self, bends: Array) -> Array:
        """The bends (T, p) rad in front of every chord, summed up, of those (T, n) rad at the joints."""
        out = np.zeros((len(bends), self.lengths.size))
        np.cumsum(bends, axis=1, out=out[:, self.mounts :])
        return out

    def closest(self, vertices: Array) -> tuple[Array, NDArray[np.int64]]:
        """The smallest clearance (T,) m within each body (T, p+1, 3) m, and the pair (T,) that has it; -1 for none."""
        value, pair = np.empty(len(vertices)), np.empty(len(vertices), np.int64)
        _closest(vertices, self.pairs, self.lengths, self.aparts, self.thick, value, pair)
        return value, pair

    def between(self, vertices: Array, travel: Array) -> tuple[Array, NDArray[np.int64]]:
        """What clearance (T-1,) m within the body is proven from configuration to configuration, and whose it is.

        Parameters
        ----------
        vertices : (T, p+1, 3) m
        travel : (T-1, p+1) m
            How far each vertex goes at most.
        """
        bound, pair = np.full(len(travel), math.inf), np.full(len(travel), -1)
        _between(vertices, travel, self.pairs, self.lengths, self.aparts, self.thick, bound, pair)
        return bound, pair

    def names(self, pair: int) -> tuple[int, int]:
        """Both chords (0-based) of a pair; the first one may be `MOUNT`."""
        first, second = self.pairs[pair].tolist()
        return first - self.mounts, second - self.mounts

    def apart(self, vertices: Array, first: int, second: int) -> tuple[float, Array]:
        """The clearance (m) between two chords of a body (p+1, 3) m, and the place (3,) m half way between them.

        The numbers are those that `names` gives.
        """
        first, second = first + self.mounts, second + self.mounts
        (pair,) = np.flatnonzero((self.pairs == (first, second)).all(axis=1))
        lengths, between = (float(self.lengths[first]), float(self.lengths[second])), float(self.aparts[pair])
        away, u, v = separation(np.ascontiguousarray(vertices[None]), 0, first, second, *lengths, between)
        on_first = vertices[first + 1] + u / lengths[0] * (vertices[first] - vertices[first + 1])
        on_second = vertices[second] + v / lengths[1] * (vertices[second + 1] - vertices[second])
        return away - float(self.thick[pair]), 0.5 * (on_first + on_second)


def clearance_of_neighbours(robot: Robot, mount: Mount | None = None) -> float:
    """The clearance (m) within the body that is kept by places which count as neighbours only where it is shortest.

    Infinite of arms that keep their length.
    """
    if not (robot.extends and isinstance(robot.model, MixedSections)):
        return math.inf
    body = OwnBody.of(robot, mount, robot.length_bounds[:, 0])
    return body.left_out(robot.model.chord_bends, robot.model.extends[robot.chord_sections])


def bends_of(angles: Array) -> Array:
    """At least the bend (..., n) rad at every joint of angles (..., n, 2) rad, and convex in them.

    The bend is the hypotenuse of a right-angled triangle on the sphere, which is shorter than that in the plane.
    """
    return np.hypot(angles[..., 0], angles[..., 1])


def part_of_body(number: int, kind: str) -> str:
    """A link (0-based) or `MOUNT` in a sentence that calls links so: `section 3`, `the mount`."""
    return "the mount" if number == MOUNT else f"{kind} {number + 1}"
