"""What inverse-kinematics methods have in common: only the tip has a goal."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError, InputError
from hognose.following.chain import base_frames, laid_along
from hognose.following.exact import Exact
from hognose.following.follower import SOLVED, Array, Follower
from hognose.kernels import kernel

#: How close (m) the tip must come to its goal, and the passes over the arm that it may take.
TIP_TOLERANCE = 1e-5
MOST_PASSES = 10_000
#: Feed (m) from one kept posture to the next, and the part of the shortest link that it is at most.
STRIDE, STRIDE_OF_LINK = 0.0035, 0.4
#: Feeds this close (m) are one.
_SAME = 1e-12

#: What an arm is to reach: at every step, places (T, 3) and frames (T, 3, 3) of its base, and goals (T, 3) of its tip.
Goals = tuple[NDArray, NDArray, NDArray]
#: The last posture (n+1, 3); the step and its passes so far (2,), -1 before it begins; distances measured (1,).
Progress = tuple[NDArray, NDArray, NDArray]
#: Lengths (n,) of the links, and the cones within both bend limits of every joint, as cosines and sines (n,).
Cones = tuple[NDArray, NDArray, NDArray]


@kernel()
def under_way(goals: Goals, progress: Progress, least: int, joints: NDArray) -> bool:
    """Whether another pass is needed, over the joints of the step in `progress`.

    A step begins with the last posture, moved to the new base, and takes `least` passes or more. The next step begins
    when the tip has reached its goal. If it has not after `MOST_PASSES`, the motion ends at this step.
    """
    bases, _, tips = goals
    posture, count, evaluations = progress
    while count[0] < tips.shape[0]:
        t = count[0]
        chain = joints[t]
        if count[1] < 0:
            chain[:] = posture + (bases[t] - posture[0])
            count[1] = 0
        last = chain.shape[0] - 1
        gx, gy, gz = tips[t, 0] - chain[last, 0], tips[t, 1] - chain[last, 1], tips[t, 2] - chain[last, 2]
        evaluations[0] += 1
        if count[1] < least or not math.sqrt(gx * gx + gy * gy + gz * gz) <= TIP_TOLERANCE:
            count[1] += 1
            return count[1] <= MOST_PASSES
        posture[:] = chain
        count[0], count[1] = t + 1, -1
    return False


class _Stall(NamedTuple):
    """Where the motion ends early: feed (m), joints there, the link, and the distance (m) of the tip from its goal."""

    feed: float
    joints: Array
    link: int
    miss: float


class TipOnly(Follower):
    """The base runs on the slider and the tip is where exact following puts it; the body is not bound to the path.

    Such methods are what a user might try instead of following. `body_deviation` measures how far the body leaves the
    path.

    A posture depends on the postures before it. So that it depends on the feed alone, all start from the arm laid along
    the path at feed 0 and go on in strides. The postures at the strides are kept; every feed starts from the last of
    them before it. A first step far along the path needs all strides up to it: some tens of milliseconds with a dozen
    links.
    """

    glides = False
    #: Fills joints (T, n+1, 3), with a pass whenever `under_way` asks for one: (arm, goals, progress, joints).
    _kernel: ClassVar[Callable[..., None]]

    def _prepare(self) -> None:
        self._guide = Exact(self.path, self.link_lengths)
        self._arm = self._bounded_arm()
        self._stride = min(STRIDE, STRIDE_OF_LINK * float(self.link_lengths.min()))
        self._stall = _Stall(0.0, self._joints[0], 0, 0.0)
        self.begin(0.0)

    def begin(self, feed: float) -> None:
        """Begin at a feed (m) other than 0, with the arm laid along the path there."""
        self._origin = feed
        self._postures: list[Array] = []

    @property
    def tolerance(self) -> float:
        """Of the tip: how far it may be from where exact following puts it. Link lengths are off by rounding only."""
        return TIP_TOLERANCE

    def _bounded_arm(self) -> tuple[Array, ...]:
        """What the kernel takes of the links and the bend limits: `Cones`, unless the method says otherwise."""
        if (self.bend_bounds[..., 0] != -self.bend_bounds[..., 1]).any():
            raise InputError(
                f"method {self.name!r} keeps joints within cones, and some bend farther to one side than to the other: "
                "take jacobian, or exact"
            )
        cones = self.bend_limits.min(axis=1)
        return self.link_lengths, np.cos(cones), np.sin(cones)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        if feeds.size and feeds.min() < self._origin:
            self.begin(0.0)
        strides = np.floor((feeds - self._origin + _SAME) / self._stride).astype(np.int64)
        for step, stride in enumerate(strides.tolist()):
            if stride >= len(self._postures):  # as many as will be asked for, in one go
                self._take_strides(int(strides[step:].max()))
            found = stride < len(self._postures)
            if found and abs(feeds[step] - (self._origin + self._stride * stride)) <= _SAME:
                joints[step] = self._postures[stride]
                continue
            if found:
                found = self._go_on(self._postures[stride], feeds[step : step + 1], joints[step : step + 1]) == 1
            if not found:
                joints[step] = self._stall.joints
                return step, self._stall.link
        return SOLVED

    def _take_strides(self, last: int) -> None:
        """Find and keep the postures up to a stride, or up to the one that stalls."""
        known = len(self._postures)
        feeds = self._origin + self._stride * np.arange(known, last + 1, dtype=np.float64)
        joints = np.empty((feeds.size, self.link_lengths.size + 1, 3))
        before = self._postures[-1] if known else laid_along(self.path, self.link_lengths, self._origin)
        self._postures.extend(joints[: self._go_on(before, feeds, joints)])

    def _go_on(self, posture: Array, feeds: Array, joints: Array) -> int:
        """Fill joints (T, n+1, 3) for feeds (T,), each from the last; how many were found before one stalled."""
        guided = np.empty_like(joints)
        step, link = self._guide._advance(feeds, guided)
        if step >= 0:  # the path ends there
            found = self._go_on(posture, feeds[:step], joints[:step]) if step else 0
            if found == step:
                self._stall = _Stall(float(feeds[step]), guided[step], link, 0.0)
            return found
        tips, count = guided[:, -1].copy(), np.array([0, -1])
        goals = self.path.point(feeds), base_frames(self.path, feeds), tips
        self._kernel(self._arm, goals, (posture.copy(), count, self._evaluations), joints)
        step = int(count[0])
        if step < feeds.size:
            miss = float(np.linalg.norm(tips[step] - joints[step, -1]))
            self._stall = _Stall(float(feeds[step]), joints[step].copy(), self.link_lengths.size - 1, miss)
        return step

    def _unreachable(self, feeds: Array, joints: Array, step: int, link: int) -> InfeasibleError:
        feed, _, _, miss = self._stall
        if miss == 0.0:
            return super()._unreachable(feeds, joints, step, link)
        before = "" if abs(feed - feeds[step]) <= _SAME else f" on the way there, at feed {1e3 * feed:.2f} mm,"
        return InfeasibleError(
            f"step {step}, feed {1e3 * feeds[step]:.2f} mm:{before} {self.name} left the tip {1e3 * miss:.3g} mm from "
            f"its goal on the path after {MOST_PASSES:,} passes. From this posture and within the bend limits it finds "
            "no way there; follow the path instead (method exact)."
        )
