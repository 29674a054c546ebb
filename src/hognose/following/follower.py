"""The one protocol of all following methods."""

from __future__ import annotations

import abc
import math
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, instance, positive, real
from hognose.errors import InfeasibleError, InputError
from hognose.following.contract import checked_outcome, checked_tolerance, faults_named, is_own
from hognose.path import Path
from hognose.robot.bends import both_sides
from hognose.units import SMALLEST_SIZE
from hognose.wording import point

Array = NDArray[np.float64]

#: Largest |α| and |β| (rad) of every joint, (n, 2) or anything that broadcasts to it; π/2 if None.
Limits = ArrayLike | None

#: What a kernel reports when every link found its place.
SOLVED = (-1, -1)


class Follower(abc.ABC):
    """Places the joints of an arm on a path, step after step (paper eq. 4).

    Given the first joint's arc length (the feed), every next joint is the *first* point further along the
    path at its link's length. A follower remembers its last step, which makes the next one cheap. The answer depends on
    the feed alone, to within the method's tolerance: the feed may go forward or backward, or jump. (For `optimization`
    this holds only on paths so gentle that `tracks` is true.)

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    spacing : float, m
        Distance sd of the points M(In), for the methods that use them.
    bend_limits : rad
        Largest |α| and |β| of every joint, (n, 2) or anything that broadcasts to it, or the lowest and highest of each,
        (n, 2, 2); π/2 unless given. Only used by some methods.

    Attributes
    ----------
    curve : Path
        The curve on which the joints glide: the path, unless the method says otherwise.
    bend_limits : (n, 2) rad
    bend_bounds : (n, 2, 2) rad
        Largest |α| and |β|; lowest and highest α and β.
    tracks : bool
        Whether the curve is gentle enough for the links that every joint moves steadily with the feed.

    Raises
    ------
    InputError
        Lengths or limits that are not positive numbers, or a spacing that does not suit the path.
    """

    #: Name in `METHODS` and on the command line.
    name: ClassVar[str]
    #: Whether every joint glides along `curve`, so that every joint repeats the motion of the next one.
    glides: ClassVar[bool] = True
    #: Whether it is a method of Hognose. What other methods return is checked.
    _own: ClassVar[bool] = True

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls._own = is_own(cls)

    def __init__(
        self, path: Path, link_lengths: ArrayLike, spacing: float = 0.0005, bend_limits: Limits = None
    ) -> None:
        self.path = instance("path", path, Path, "a hognose.Path")
        self._path_length = self.path.length
        self.link_lengths = _checked_lengths(link_lengths)
        self.bend_bounds = _checked_bounds(bend_limits, self.link_lengths.size)
        self.bend_limits = np.abs(self.bend_bounds).max(axis=2)
        self.spacing = positive("spacing", spacing)
        if self.spacing >= self.link_lengths.min():
            raise InputError(
                f"spacing: {1e3 * self.spacing:g} mm is not below the shortest link, "
                f"{1e3 * self.link_lengths.min():g} mm; expected points that are much closer"
            )
        # A chord L under an arc of curvature at most κ belongs to one crossing only while the arc turns by no
        # more than a right angle, 2 asin(κL/2) ≤ π/2 (docs/following.md); beyond that every step searches anew.
        self.curve = self._curve()
        self.tracks = bool(self.curve.sharpest[0] * self.link_lengths.max() <= math.sqrt(2.0))
        self._feeds = np.empty(1)
        self._evaluations = np.zeros(1, np.int64)
        self._joints = np.empty((1, self.link_lengths.size + 1, 3))
        self._prepare()

    def _prepare(self) -> None:  # noqa: B027 -- not every method needs more
        """Make what the method itself needs. Called once, at the end of the constructor."""

    def _curve(self) -> Path:
        return self.path

    @property
    def keeps_to_path(self) -> bool:
        """Whether the joints are on the path, as closely as the tolerance says."""
        return self.glides and self.curve is self.path

    @property
    def evaluations(self) -> int:
        """How many distances it has measured since it was made: what a step costs on any machine."""
        return int(self._evaluations[0])

    @property
    @abc.abstractmethod
    def tolerance(self) -> float:
        """How far (m) link lengths and joints on the path may be off by the nature of the method."""

    def begin(self, feed: float) -> None:
        """Begin the motion at a feed (m) other than 0. Only methods whose postures depend on earlier ones use it."""
        del feed

    @abc.abstractmethod
    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        """Fill joints (T, n+1, 3) for feeds (T,); the (step, link) that failed, or SOLVED."""

    def step(self, feed: float) -> Array:
        """Joint positions (n+1, 3) m at one feed (m). Takes a few microseconds.

        Raises
        ------
        InputError
            A feed outside the path.
        InfeasibleError
            A link that cannot reach the path.
        """
        self._feeds[0] = feed = feed if type(feed) is float else real("feed", feed, "a number in m", _any)
        if not 0.0 <= feed <= self._path_length:
            self._refuse_feeds(self._feeds)
        failed = (self._advance if self._own else self._judged)(self._feeds, self._joints)
        if failed[0] >= 0:
            raise self._unreachable(self._feeds, self._joints, *failed)
        return self._joints[0].copy()

    def run(self, feeds: ArrayLike) -> Array:
        """Joint positions (T, n+1, 3) m at feeds (T,) m; errors as in `step`."""
        array = floats("feeds", feeds, "(T,)", finite=False)
        if not ((array >= 0.0) & (array <= self.path.length)).all():
            self._refuse_feeds(array)
        joints = np.empty((array.size, self.link_lengths.size + 1, 3))
        failed = (self._advance if self._own else self._judged)(array, joints)
        if failed[0] >= 0:
            raise self._unreachable(array, joints, *failed)
        return joints

    def _judged(self, feeds: Array, joints: Array) -> tuple[int, int]:
        """As `_advance`, checked: a fault of the method is an InputError that names it and its package."""
        with faults_named(type(self)):
            tolerance = checked_tolerance(self.tolerance, self.link_lengths)
            joints.fill(math.nan)
            outcome = self._advance(feeds.copy(), joints)
            return checked_outcome(outcome, feeds, joints, self.link_lengths, tolerance)

    def _refuse_feeds(self, feeds: Array) -> None:
        bad = int(np.flatnonzero(~((feeds >= 0.0) & (feeds <= self.path.length)))[0])
        raise InputError(
            f"feeds: step {bad} is {1e3 * float(feeds[bad]):g} mm; expected 0 to {1e3 * self.path.length:.3f} mm, "
            "the length of the path"
        )

    def _unreachable(self, feeds: Array, joints: Array, step: int, link: int) -> InfeasibleError:
        end = self.path.point(self.path.length)
        away = float(np.linalg.norm(end - joints[step, link]))
        length = float(self.link_lengths[link])
        return InfeasibleError(
            f"step {step}, feed {1e3 * feeds[step]:.2f} mm: link {link + 1} ({1e3 * length:g} mm) cannot reach "
            f"the path: from its joint at {point(joints[step, link], 'g')} the path ends after {1e3 * away:.2f} "
            "mm of straight distance, and no point before is far enough. Feed less, or lengthen the path."
        )


def _checked_bounds(bend_limits: Limits, links: int) -> Array:
    given = floats("bend_limits", math.pi / 2 if bend_limits is None else bend_limits, "(...)", "rad")
    if given.ndim == 3:
        if given.shape != (links, 2, 2) or not ((given[..., 0] < 0) & (given[..., 1] > 0)).all():
            raise InputError(f"bend_limits: expected [below 0, above 0] of α and β of each joint, ({links}, 2, 2) rad")
        bounds = given.copy()
    else:
        try:
            bounds = both_sides(np.broadcast_to(given, (links, 2)))
        except ValueError:
            raise InputError(f"bend_limits: expected angles in rad that broadcast to shape ({links}, 2)") from None
    if not ((bounds[..., 1] > 0) & (np.abs(bounds) <= math.pi / 2).all(axis=2)).all():
        raise InputError("bend_limits: expected angles above 0 and at most π/2 rad")
    return bounds


def _checked_lengths(link_lengths: ArrayLike) -> Array:
    lengths = coordinates("link_lengths", link_lengths, "(n,)")
    if lengths.size == 0 or (lengths < SMALLEST_SIZE).any():
        raise InputError("link_lengths: expected at least one length, all above 0 m")
    return lengths


def _any(value: float) -> bool:
    return True
