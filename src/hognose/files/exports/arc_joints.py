"""An arc as a chain of small universal joints: in which order they turn, how many there are, and how far that is off.

Each joint stands in the middle of its part of the arc, so that the links are tangents of the arc and the directions at
both ends are right. In one plane such a chain ends in the direction of the arc's end, nearer by (x / tan x) with
x = θ/2k for k joints of a bend θ [derived: the links are the tangents of a circle of the radius L/θ x/tan x].

Out of one plane R_y(a) R_x(b) is not exp(a e_y + b e_x), and k of them twist by about αβ/2k in all. So joints of both
orders alternate, as y x, x y, x y, y x: what the first two are off by, to the second order and partly to the third, the
next two take away. At ±75° and k = 20 that is 0.04° instead of 2.1° in the same order throughout.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hognose.robot.sections.arc import ARC
from hognose.robot.sections.kind import Geometry

Array = NDArray[np.float64]

#: An arc is never fewer joints than this, and never more than this unless it has more disks.
FEWEST, MOST = 4, 64
#: Errors are looked for at so many angles of each axis, to both limits.
_ANGLES = 9
#: And at so many lengths of what extends.
_LENGTHS = 5


def alpha_first(joint: int) -> bool:
    """Whether a joint (from 0) of a chain turns about y first and then about x, or the other way round."""
    return joint % 4 in (0, 3)


def counts_of(disks: int | None) -> range:
    """How many joints an arc may have: a multiple of its disks, so that these stand in the middles of links."""
    step = FEWEST if disks is None else disks
    return range(step * -(-FEWEST // step), max(MOST, step) + 1, step)


@lru_cache(maxsize=512)
def errors_of(pitch: float, limits: tuple[float, float], count: int) -> tuple[float, float]:
    """How far (m) a point of the chain is from that of the arc at the same length, and how far (rad) its end is turned.

    The largest of both at angles within the limits (rad).
    """
    alpha, beta = (grid.ravel() for grid in np.meshgrid(*(np.linspace(-most, most, _ANGLES) for most in limits)))
    places, ends = chain_points(alpha, beta, pitch, count)
    shares = np.arange(2 * count + 1) / (2 * count)
    off = np.linalg.norm(places - arc_points(alpha, beta, pitch, shares), axis=-1).max()
    turned = _turns(beta, alpha).transpose(0, 2, 1) @ ends
    skew = np.stack([turned[:, i, j] - turned[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1)
    return float(off), float(np.arcsin(np.minimum(0.5 * np.linalg.norm(skew, axis=-1), 1.0)).max())


def chain_points(alpha: Array, beta: Array, pitch: float, count: int) -> tuple[Array, Array]:
    """Joints, and ends of their parts, (T, 2k+1, 3) m of the chain at angles (T,) rad; frames (T, 3, 3) of its end."""
    half = pitch / (2 * count)
    frame = np.repeat(np.eye(3)[None], len(alpha), axis=0)
    about_y, about_x = _turns(0 * beta, alpha / count), _turns(beta / count, 0 * alpha)
    orders = about_x @ about_y, about_y @ about_x
    places = [np.zeros((len(alpha), 3))]
    for joint in range(count):
        places.append(places[-1] + half * frame[:, :, 2])
        frame = frame @ orders[alpha_first(joint)]
        places.append(places[-1] + half * frame[:, :, 2])
    return np.stack(places, axis=1), frame


def arc_points(alpha: Array, beta: Array, pitch: float, shares: Array) -> Array:
    """Points (T, s, 3) m of the arc at angles (T,) rad and at shares (s,) of its length."""
    bend = np.maximum(np.hypot(alpha, beta)[:, None] * shares, 1e-12)
    aside = pitch * shares**2 * 0.5 * np.sinc(bend / (2 * np.pi)) ** 2
    along = pitch * shares * np.sinc(bend / np.pi)
    return np.stack([alpha[:, None] * aside, -beta[:, None] * aside, along], axis=-1)


def cable_error(section: Geometry, count: int, radii: Array, azimuths: Array) -> Array:
    """How far (c,) m lengths of cables through a chain are from those through the arc, at the worst angles and lengths.

    From disk to disk a cable of a chain is |L a + b| at a length L, with a and b of the angles, and one of the arc is
    linear in L [derived]. So their difference is convex in L: it may be largest at either end, or lowest in between.
    """
    alpha, beta = (g.ravel() for g in np.meshgrid(*(np.linspace(-most, most, _ANGLES) for most in section.bend_limits)))
    cosine, sine = np.cos(azimuths), np.sin(azimuths)
    holes = radii * np.stack([cosine, sine, np.zeros_like(radii)])
    worst = np.zeros(radii.size)
    for length in np.linspace(*section.lengths, _LENGTHS if section.length_range else 1).tolist():
        found = _through_chain(section, length, count, alpha, beta, holes)
        angles = np.column_stack([alpha, beta])
        exact = length + ARC.cables_at(section, length, angles, radii, cosine, sine, radii)
        worst = np.maximum(worst, np.abs(found - exact).max(axis=0))
    return worst


def _through_chain(section: Geometry, length: float, count: int, alpha: Array, beta: Array, holes: Array) -> Array:
    """Lengths (T, c) m of cables through holes (3, c) m of a chain that is so long (m), at angles (T,) rad."""
    step = count // section.disks if section.disks else 1
    frame, found = np.repeat(np.eye(3)[None], len(alpha), axis=0), np.zeros((len(alpha), holes.shape[1]))
    places = chain_points(alpha, beta, length, count)[0]
    about_y, about_x = _turns(0 * beta, alpha / count), _turns(beta / count, 0 * alpha)
    orders = about_x @ about_y, about_y @ about_x
    last = np.broadcast_to(holes, (len(alpha), *holes.shape))
    for joint in range(count):
        frame = frame @ orders[alpha_first(joint)]
        if (joint + 1) % step == 0:
            here = places[:, 2 * joint + 2, :, None] + frame @ holes
            found += np.linalg.norm(here - last, axis=1)
            last = here
    return found


def _turns(about_x: Array, about_y: Array) -> Array:
    """Rotations (T, 3, 3) by the vectors (about_x, about_y, 0) rad."""
    angle = np.hypot(about_x, about_y)
    a, b = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    zero = np.zeros_like(angle)
    skew = np.stack([zero, zero, about_y, zero, zero, -about_x, -about_y, about_x, zero], axis=-1).reshape(-1, 3, 3)
    return np.eye(3) + a[:, None, None] * skew + b[:, None, None] * (skew @ skew)
