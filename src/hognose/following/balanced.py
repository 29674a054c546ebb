"""Joints beside the path, so that joints and mid-links leave it equally far.

Links are chords. With its joints on the path a link leaves it on one side only, by the whole sagitta, about
κL²/8. Here the joints follow, exactly as in `exact`, a curve q(s) = r(s) + e(s) beside the path whose offset e makes
the largest of these distances smallest: |e(s)| of the joints, and of the points between them

    |(1 - x) q(s - h) + x q(s + h) - r(s + (2x - 1) h)|,   x = 1/4, 1/2, 3/4,

across the path, with h half the mean link length. Their p-norm, p = 10, stands for their maximum; it is convex in e and
minimised by reweighted least squares at eight nodes a link, with a little weight on the second differences of e. The
offset is zero on the slider's run and at the target: the base stays on the slider and the tip ends on the target. The
curve does not depend on time: links keep their lengths, the motion is as smooth as that of `exact`, and every joint
repeats the motion of the next one.

Chords of q bend by up to an eighth more than chords of r. Where that exceeds a bend limit, a smaller part of the offset
is taken, down to none.

Cost a step: that of `exact`; the curve is made once, in time proportional to its length. Known weakness: one offset for
all links, so arms of unequal links gain less, and an arm of one or two long links may gain nothing; on the way the tip
is beside the path by up to half the sagitta, and a little behind, because q is longer than r. Source: own;
docs/following.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError, InputError
from hognose.following.chain import angles_in_frame, base_frames
from hognose.following.exact import Exact, straight_start
from hognose.following.follower import Array
from hognose.kernels import kernel
from hognose.path import Path
from hognose.robot.bends import used

#: Nodes of the curve in half a link.
_HALF = 4
#: A curve of more pieces takes too long to make.
_MOST_PIECES = 200_000
#: The parts of the best offset that are tried until the bends are within their limits, but for what is between the
#: feeds at which they are looked at, so many a link, at most so many.
_PARTS, _WITHIN, _FEEDS_A_LINK, _MOST_FEEDS = (1.0, 0.8, 0.6, 0.4, 0.2), 0.995, 16, 2000
#: The norm that stands for the maximum, and the steps in which it grows from least squares.
_NORM, _ROUNDS = 10.0, 12
#: Weight of the offset's second differences from node to node.
_SMOOTHING = 10.0
#: Distances below this part of the largest one weigh no less than it.
_FLOOR = 0.01


class Balanced(Exact):
    """Exact following of a curve beside the path that halves how far the body leaves it."""

    name = "balanced"

    def _curve(self) -> Path:
        link, free = float(self.link_lengths.mean()), (np.abs(self.bend_bounds) >= math.pi / 2).all()
        for part in _PARTS:
            curve = balanced_curve(self.path, link, part)
            if free or _largest_bend(curve, self.link_lengths, self.bend_bounds) <= _WITHIN:
                return curve
        return balanced_curve(self.path, link, 0.0)

    def _base_parameters(self, feeds: Array) -> Array:
        return feeds


def balanced_curve(path: Path, link: float, part: float = 1.0) -> Path:
    """The curve q(s) beside a path for links of a length in m, with the path's arc length s as its parameter.

    Quintic pieces that agree with q, q′ and q″ at their ends. `part` of the best offset is taken.

    Raises
    ------
    InputError
        The path is more than 25,000 links long.
    """
    # Straight to the end but for rounding, half a link is made of pieces all the same.
    run = min(straight_start(path), path.length - 0.5 * min(link, path.length))
    rest = path.length - run
    count = math.ceil(max(2.0, 2 * _HALF * rest / link))
    if count > _MOST_PIECES:
        raise InputError(
            f"link_lengths: {1e3 * link:g} mm on a path of {path.length:.4g} m; the method balanced takes at most "
            f"{_MOST_PIECES // (2 * _HALF):,} links of path. Use method exact, whose body is close to the path here"
        )
    stride = rest / count
    nodes: Array = run + stride * np.arange(-2 * _HALF, count + 2 * _HALF + 1, dtype=np.float64)
    around = _along(path, nodes)
    offset = part * _offset(around[0], around[1])
    inner = slice(2 * _HALF, 2 * _HALF + count + 1)
    first = np.gradient(offset, stride, axis=0)
    second = np.zeros_like(offset)
    second[1:-1] = (offset[2:] - 2 * offset[1:-1] + offset[:-2]) / stride**2
    curve = around[:, inner] + np.stack([offset, first, second])[:, inner]
    curve[1:, [0, -1]] = around[1:, inner][:, [0, -1]]
    breaks = nodes[inner].copy()
    breaks[-1] = path.length
    if run > 0:
        breaks = np.append(0.0, breaks)
        curve = np.concatenate([_along(path, np.zeros(1)), curve], axis=1)
        curve[2, :2] = 0.0
    coefficients = _quintic(breaks, curve)
    if run > 0:
        coefficients[0, 2:] = 0.0  # straight without rounding, so that the feed is the parameter there
    return Path(breaks, coefficients)


def _largest_bend(curve: Path, lengths: Array, bounds: Array) -> float:
    """The largest angle of joints that glide on a curve, as a part of its limit, at some feeds a link apart."""
    stride = max(float(lengths.min()) / _FEEDS_A_LINK, curve.length / _MOST_FEEDS)
    feeds = np.arange(0.0, curve.length, stride)
    follower, angles, largest = Exact(curve, lengths), np.empty((lengths.size, 2)), 0.0
    for feed, frame in zip(feeds, base_frames(curve, feeds), strict=True):
        try:
            joints = follower.step(feed)
        except InfeasibleError:
            break
        angles_in_frame(joints, frame, angles)
        largest = max(largest, float(used(angles, bounds).max()))
    return largest


def _offset(places: Array, tangents: Array) -> Array:
    """The offset e (N, 3) m at nodes of the path; zero at the first and last 2 _HALF + 2 of them."""
    nodes, fixed = len(places), 2 * _HALF + 2
    parts = np.arange(2, 2 * _HALF, 2) / (2 * _HALF)
    starts = np.arange(nodes - 2 * _HALF)
    ends = starts + 2 * _HALF
    gaps = np.empty((len(parts), len(starts), 3))
    for gap, part in zip(gaps, parts, strict=True):
        between = starts + round(2 * _HALF * part)
        away = (1 - part) * places[starts] + part * places[ends] - places[between]
        gap[:] = away - np.einsum("ij,ij->i", away, tangents[between])[:, None] * tangents[between]
    offset, free = np.zeros((nodes, 3)), slice(fixed, nodes - fixed)
    on_joints, on_links = np.ones(nodes), np.ones(gaps.shape[:2])
    x = parts[:, None]
    norm = 2.0
    for _ in range(_ROUNDS):
        bands, pull = np.zeros((2 * _HALF + 1, nodes)), np.zeros((nodes, 3))
        bands[0] = on_joints + 6.0 * _SMOOTHING
        bands[1], bands[2] = -4.0 * _SMOOTHING, _SMOOTHING
        bands[0, starts] += (on_links * (1 - x) ** 2).sum(axis=0)
        bands[0, ends] += (on_links * x**2).sum(axis=0)
        bands[2 * _HALF, starts] += (on_links * x * (1 - x)).sum(axis=0)
        weighted = on_links[..., None] * gaps
        pull[starts] -= ((1 - x[..., None]) * weighted).sum(axis=0)
        pull[ends] -= (x[..., None] * weighted).sum(axis=0)
        solved = pull[free].copy()
        _solve_banded(bands[:, free].copy(), solved)
        offset[free] += (solved - offset[free]) / (norm - 1.0)
        norm = min(_NORM, 1.5 * norm)
        joints = np.linalg.norm(offset, axis=1)
        links = np.linalg.norm((1 - x[..., None]) * offset[starts] + x[..., None] * offset[ends] + gaps, axis=2)
        largest = max(joints.max(), links.max())
        if largest < 1e-12:
            break
        on_joints = np.maximum(joints / largest, _FLOOR) ** (norm - 2.0)
        on_links = np.maximum(links / largest, _FLOOR) ** (norm - 2.0)
    return offset


@kernel()
def _solve_banded(bands: NDArray, right: NDArray) -> None:
    """Solve a positive definite system in place by Cholesky's method; `bands[k, i]` holds entry (i, i + k)."""
    width, size = bands.shape[0] - 1, bands.shape[1]
    for i in range(size):
        bands[0, i] = math.sqrt(bands[0, i])
        reach = min(width, size - 1 - i)
        for k in range(1, reach + 1):
            bands[k, i] /= bands[0, i]
        for k in range(1, reach + 1):
            for m in range(k, reach + 1):
                bands[m - k, i + k] -= bands[k, i] * bands[m, i]
    for axis in range(right.shape[1]):
        for i in range(size):
            right[i, axis] /= bands[0, i]
            for k in range(1, min(width, size - 1 - i) + 1):
                right[i + k, axis] -= bands[k, i] * right[i, axis]
        for i in range(size - 1, -1, -1):
            for k in range(1, min(width, size - 1 - i) + 1):
                right[i, axis] -= bands[k, i] * right[i + k, axis]
            right[i, axis] /= bands[0, i]


def _along(path: Path, s: Array) -> Array:
    """r, r′ and r″ by arc length (3, q, 3); straight on beyond both ends."""
    inside = np.clip(s, 0.0, path.length)
    point, first, second = np.moveaxis(path.frame(inside), -2, 0)
    speed = np.linalg.norm(first, axis=1, keepdims=True)
    tangent = first / np.maximum(speed, 1e-300)
    bend = (second - np.einsum("ij,ij->i", second, tangent)[:, None] * tangent) / np.maximum(speed, 1e-300) ** 2
    beyond = (s - inside)[:, None]
    return np.stack([point + beyond * tangent, tangent, np.where(beyond == 0.0, bend, 0.0)])


def _quintic(nodes: Array, q: Array) -> Array:
    """Coefficients (S, 6, 3) of quintic Hermite pieces through q, q′, q″ (3, S+1, 3) at the nodes."""
    h = np.diff(nodes)[:, None]
    start, end = q[:, :-1], q[:, 1:]
    gap = end[0] - (start[0] + h * (start[1] + h * start[2] / 2))
    slope = h * (end[1] - (start[1] + h * start[2]))
    bend = h**2 * (end[2] - start[2])
    third = 10 * gap - 4 * slope + bend / 2
    fourth = -15 * gap + 7 * slope - bend
    fifth = 6 * gap - 3 * slope + bend / 2
    return np.stack([start[0], start[1], start[2] / 2, third / h**3, fourth / h**4, fifth / h**5], axis=1)
