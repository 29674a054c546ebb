"""A drum on which the arm is coiled, and the nozzle through which it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.robot.base import FORWARD
from hognose.robot.robot import Robot
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: The coil is drawn in pieces of at most this angle (rad); they leave the circle by less than 1e-13 of its radius.
_PIECE = np.radians(4.0)
#: The arm takes no more of the drum's circumference than this, so that its end does not lie on its beginning.
MOST_TURNS = 0.95


@dataclass(frozen=True, eq=False)
class Drum:
    """The arm lies on a circle that rolls it off towards the nozzle; the first joint is fixed to the drum.

    The circle touches the nozzle's line. In the frame of the nozzle, z is where the arm goes and the centre of the drum
    is at +x.

    Attributes
    ----------
    entrance : (3,) m
        The end of the nozzle, where the nose is at feed 0.
    radius : m
        Of the circle through the arm's centre line.
    nozzle : m
        Length of the straight guide between the drum and the entrance.
    coil : rad
        How far round the drum the first joint is at feed 0, from where the nozzle begins.
    R_task_nozzle : (3, 3)
        Axes of the nozzle's frame in those of the task.
    """

    entrance: Array
    radius: float
    nozzle: float
    coil: float
    R_task_nozzle: Array

    @classmethod
    def before(cls, entrance: Array, robot: Robot, radius: float, nozzle: float, R_task_nozzle: Array) -> Drum:
        """The drum from which, at feed 0, the arm has its nose at the entrance (3,) m.

        Raises
        ------
        InputError
            A drum that the joints cannot bend round, that the arm is too long for, or that no joint reaches; or any for
            sections that are no links.
        """
        if isinstance(robot.model, MixedSections):
            raise InputError(
                f"base.kind: {robot.name} has sections that are no rigid links, and how they bend round a drum is not "
                "known; expected a slider, a cart or a carrier: take one of the kinds slider, cart, arm"
            )
        lengths, limits = robot.link_lengths, robot.bend_bounds[:, 0, 1]  # round y, as the drum turns
        if nozzle >= robot.length:
            raise InputError(
                f"base.nozzle: {1e3 * nozzle:g} mm is not shorter than the arm, {1e3 * robot.length:g} mm, so that "
                "nothing of it is on the drum; take a shorter nozzle, or the kind slider"
            )
        half = np.arcsin(np.minimum(lengths / (2 * radius), 1.0))
        bends = np.append(half[0], half[:-1] + half[1:])
        worst = int(np.argmax(bends / limits))
        if bends[worst] > limits[worst] or (lengths > 2 * radius).any():
            fits = _radius_that_fits(lengths, limits)
            raise InputError(
                f"base.radius: round a drum of {1e3 * radius:g} mm joint {worst + 1} bends by "
                f"{np.degrees(bends[worst]):.4g} deg, at most {np.degrees(limits[worst]):.4g} deg; take a radius of "
                f"{1e3 * fits:.4g} mm or more"
            )
        coil = _coil(lengths, radius, nozzle)
        if coil > MOST_TURNS * 2 * np.pi:
            raise InputError(
                f"base.radius: the arm takes {coil / (2 * np.pi):.3g} turns of a drum of {1e3 * radius:g} mm; at most "
                f"{MOST_TURNS:g}, so that it does not lie on itself. Take a larger radius or a longer nozzle"
            )
        return cls(entrance, radius, nozzle, coil, R_task_nozzle)

    @property
    def start(self) -> Array:
        """See `Base.start`."""
        return self._on_circle(np.array([self.coil]))[0]

    @property
    def follows(self) -> bool:
        """See `Base.follows`: it turns on the spot."""
        return False

    @property
    def straight(self) -> bool:
        """See `Base.straight`: the arm lies on the coil."""
        return False

    @property
    def direction(self) -> Array:
        """See `Base.direction`: the nozzle's."""
        return self.R_task_nozzle @ np.array(FORWARD)

    @property
    def run(self) -> float:
        """See `Base.run`: the coil and the nozzle."""
        return self.farthest + self.nozzle

    @property
    def farthest(self) -> float:
        """See `Base.farthest`: where the first joint comes to the nozzle."""
        return self.radius * self.coil

    def feed_limit(self, robot: Robot) -> float:
        """See `Base.feed_limit`: the coil. A slider's travel is none of the drum's."""
        return self.farthest

    def reach(self, robot: Robot) -> float:
        """See `Base.reach`: what is in the nozzle stays there."""
        return robot.length - self.nozzle

    def outside(self, places: Array) -> Array:
        """See `Base.outside`: only the feed is limited."""
        return np.zeros(places.shape)

    @property
    def mount(self) -> None:
        """See `Base.mount`: the first joint is on the drum, which is no part of the arm."""
        return

    def lead(self) -> tuple[Array, Array]:
        """See `Base.lead`: quintics that share place, tangent and curvature with the circle, and the nozzle."""
        count = max(1, int(np.ceil(self.coil / _PIECE)))
        at: Array = self.coil * np.linspace(1.0, 0.0, count + 1)
        places, axes = self._on_circle(at), self._axes(at)
        tangent, curvature = axes[:, :, 2], axes[:, :, 0] / self.radius
        step = self.farthest / count
        breaks: Array = np.append(step * np.arange(count), self.farthest).astype(np.float64)
        arcs = _quintics(places, tangent, curvature, step)
        straight = np.zeros((1, 6, 3))
        straight[0, 0], straight[0, 1] = places[-1], self.direction
        if self.nozzle == 0:
            return breaks, arcs
        longer: Array = np.append(breaks, self.run).astype(np.float64)
        return longer, np.concatenate([arcs, straight])

    def coordinates(self, feeds: Array, joints: Array) -> Array:
        """See `Base.coordinates`: the feed, which turns the drum."""
        return feeds[:, None]

    def settled(self, at: Array) -> Array:
        """See `Base.settled`."""
        return at

    def along(self, at: Array) -> Array:
        """See `Base.along`: the first joint is the origin of the arm's frame."""
        return np.zeros(len(at))

    def placed(self, points: Array, at: Array) -> Array:
        """See `Base.placed`."""
        return self.turned(points, at) + _beside(self._on_circle(self._angles(at)), points)

    def turned(self, vectors: Array, at: Array) -> Array:
        """See `Base.turned`."""
        return np.einsum("txy,t...y->t...x", self._axes(self._angles(at)), vectors)

    def aligned(self, vectors: Array, at: Array) -> Array:
        """See `Base.aligned`."""
        return np.einsum("txy,t...x->t...y", self._axes(self._angles(at)), vectors)

    def spin(self, low: Array, high: Array) -> Array:
        """See `Base.spin`: the drum turns about the y axis of the arm's frame."""
        out = np.zeros((len(low), 3))
        out[:, 1] = (high - low)[:, 0] / self.radius
        return out

    def swing(self, low: Array, high: Array) -> Array:
        """See `Base.swing`: towards the centre of the drum."""
        return ((high - low)[:, 0]) ** 2 / self.radius

    def feed_at(self, point: Array, arc: float) -> tuple[float, float]:
        """See `Base.feed_at`: along the coil."""
        feed = min(arc, self.farthest)
        return arc, float(np.linalg.norm(point - self._on_circle(self._angles(np.array([[feed]])))[0]))

    def behind(self, at: Array) -> tuple[Array, Array, Array]:
        """See `Base.behind`: nothing but the drum, which is no part of the arm."""
        return np.empty((0, 3)), np.empty((0, 3)), np.empty(0)

    def _angles(self, at: Array) -> Array:
        return self.coil - at[:, 0] / self.radius

    def _axes(self, angles: Array) -> Array:
        """Axes (T, 3, 3) of the arm's frame so far round the drum: z along the circle, x towards its centre."""
        c, s, zero = np.cos(angles), np.sin(angles), np.zeros_like(angles)
        local = np.stack([c, zero, -s, zero, zero + 1.0, zero, s, zero, c], axis=1).reshape(-1, 3, 3)
        return self.R_task_nozzle @ local

    def _on_circle(self, angles: Array) -> Array:
        """Places (T, 3) m so far round the drum from where the nozzle begins."""
        r = self.radius
        local = np.stack([r - r * np.cos(angles), np.zeros_like(angles), -r * np.sin(angles)], axis=1)
        return self.entrance - self.nozzle * self.direction + local @ self.R_task_nozzle.T


def _beside(places: Array, points: Array) -> Array:
    """Places (T, 3) with the axes of points (T, ..., 3) between."""
    return places.reshape(len(places), *(1,) * (points.ndim - 2), 3)


def _radius_that_fits(lengths: Array, limits: Array) -> float:
    """The smallest radius (m), to a micrometre above, round which all joints can bend."""
    low, high = float(lengths.max()) / 2, float(lengths.max()) / float(np.sin(min(limits.min(), np.pi / 2) / 2))
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        half = np.arcsin(lengths / (2 * middle))
        fits = (np.append(half[0], half[:-1] + half[1:]) <= limits).all()
        low, high = (low, middle) if fits else (middle, high)
    return high


def _coil(lengths: Array, radius: float, nozzle: float) -> float:
    """How far round the drum (rad) the first joint is, with the nose at the nozzle's end: link by link from there."""
    place, angle, left = np.array([0.0, nozzle]), None, lengths[::-1]
    for length in left:  # place: (x, z) before the drum, z counted from where the nozzle begins
        if angle is not None:
            angle += 2 * np.arcsin(length / (2 * radius))
        elif length <= place[1]:
            place = np.array([0.0, place[1] - length])
        else:
            # From (0, z) to the circle: |(r - r cos a, -r sin a) - (0, z)| = length.
            r, z = radius, place[1]
            low, high = 0.0, np.pi / 2  # the distance grows so far, and no joint bends by more
            while high - low > 1e-15 * max(1.0, high):
                middle = 0.5 * (low + high)
                if middle in (low, high):
                    break
                away = np.hypot(r - r * np.cos(middle), z + r * np.sin(middle))
                low, high = (middle, high) if away < length else (low, middle)
            angle = 0.5 * (low + high)
    return float(0.0 if angle is None else angle)


def _quintics(places: Array, tangents: Array, curvatures: Array, step: float) -> Array:
    """Coefficients (m, 6, 3) of the quintics of length `step` m between places with these first two derivatives."""
    p, v, a = places, step * tangents, step**2 * curvatures
    d, dv, da = np.diff(p, axis=0), np.diff(v, axis=0), np.diff(a, axis=0)
    e = d - v[:-1] - a[:-1] / 2  # what the last three terms have to give: value, slope, second derivative at 1
    f, g = dv - a[:-1], da
    unit = [p[:-1], v[:-1], a[:-1] / 2, 10 * e - 4 * f + g / 2, -15 * e + 7 * f - g, 6 * e - 3 * f + g / 2]
    return np.stack([term / step**k for k, term in enumerate(unit)], axis=1)
