"""Where the joints belong, found without any of the methods that are compared: the judge of their answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.path import Path

Array = NDArray[np.float64]

#: Where the search stops: what the distance may lack of the link, m; and its most passes.
_CLOSE, _MOST_PASSES = 1e-13, 200
#: How far (m) the path's end may be from the last link's length.
_OVERRUN = 1e-9


def first_crossings(path: Path, link_lengths: Array, feeds: Array) -> tuple[Array, Array]:
    """Joints at the first points of the path that are a link away, each from the last.

    From the joint on, the arc length grows by what the distance lacks of the link, again and again. A chord is no
    longer than its arc, so this cannot pass the first crossing, whatever the path does. It uses nothing but
    `path.point`, and every step is solved for itself.

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    feeds : (T,) m

    Returns
    -------
    joints : (T, n+1, 3) m
    arcs : (T, n+1) m

    Raises
    ------
    InfeasibleError
        The path ends before a link does.
    """
    arcs = np.empty((len(feeds), len(link_lengths) + 1))
    joints = np.empty((*arcs.shape, 3))
    arcs[:, 0], joints[:, 0] = feeds, path.point(feeds)
    for link, length in enumerate(link_lengths):
        arcs[:, link + 1], joints[:, link + 1] = _crossing(path, joints[:, link], arcs[:, link], length)
    beyond = arcs[:, -1] - path.length
    if beyond.max(initial=0.0) > _OVERRUN:
        step = int(np.argmax(beyond))
        raise InfeasibleError(f"step {step}: the arm ends {1e3 * beyond[step]:.3g} mm beyond the path")
    return joints, arcs


def off_first_crossing(path: Path, link_lengths: Array, feeds: Array, joints: Array) -> Array:
    """How far every joint is from the first point that is a link away from the joint *before it*, as that one is.

    For joints that should be on the path. Unlike the distance from the reference, it does not add up along the arm,
    so even a small one is telling: a joint on another crossing is off by much of a link. Where links that snap to
    points have pushed the tip beyond the end of the path, the path goes on straight, as its points do.

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    feeds : (T,) m
    joints : (T, n+1, 3) m

    Returns
    -------
    (T, n+1) m
        Of the first joint: from the path at the feed.
    """
    off = np.empty(joints.shape[:2])
    arc, place = np.asarray(feeds, dtype=np.float64), path.point(feeds)
    for link in range(joints.shape[1]):
        if link:
            arc, place = _crossing(path, joints[:, link - 1], arc, link_lengths[link - 1])
        beside = joints[:, link] - place
        off[:, link] = np.linalg.norm(beside, axis=1)
        arc = np.maximum(arc + np.einsum("ij,ij->i", beside, path.tangent(np.minimum(arc, path.length))), 0.0)
    return off


def _crossing(path: Path, centers: Array, arcs: Array, length: float) -> tuple[Array, Array]:
    """Arcs (T,) and places (T, 3) of the first points beyond the arcs at the length from the centres (T, 3).

    Beyond its end the path goes on straight.
    """
    onward = path.tangent(path.length)
    arc = arcs + length
    for _ in range(_MOST_PASSES):
        inside = np.minimum(arc, path.length)
        place = path.point(inside) + (arc - inside)[:, None] * onward
        lacking = length - np.linalg.norm(place - centers, axis=1)
        if np.abs(lacking).max(initial=0.0) <= _CLOSE:
            return arc, place
        arc = arc + lacking
    raise InfeasibleError(f"no point at {1e3 * length:g} mm was found in {_MOST_PASSES} passes")
