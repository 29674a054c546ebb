"""What inverse-kinematics methods have in common: only the tip has a goal."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from hognose.errors import InfeasibleError
from hognose.following.exact import Exact
from hognose.following.follower import SOLVED, Array
from hognose.following.warm_started import WarmStarted
from hognose.path import Path

#: How close (m) the tip must come to its goal, and the passes over the arm that it may take.
TIP_TOLERANCE = 1e-5
MOST_PASSES = 10_000


class TipOnly(WarmStarted):
    """The base runs on the slider, the tip goes where exact following puts it; nothing holds the body on the path.

    Such methods are what a user might try instead of following. `body_deviation` tells how far the body strays.
    """

    glides = False
    #: Fills joints (T, n+1, 3) for goals (T, 3); returns the step that failed and its tip's distance (m), or (-1, 0).
    _kernel: ClassVar[Callable[..., tuple[int, float]]]

    def __init__(
        self, path: Path, link_lengths: ArrayLike, spacing: float = 0.0005, bend_limits: ArrayLike | None = None
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        self._guide = Exact(path, link_lengths)
        self._miss = 0.0

    @property
    def tolerance(self) -> float:
        """Of the tip: how far it may be from where exact following puts it. Link lengths are off by rounding only."""
        return TIP_TOLERANCE

    def _bounds(self) -> tuple[Array, ...]:
        """What the kernel takes of the bend limits: the cones within both angles of every joint, as cosine and sine."""
        cones = self.bend_limits.min(axis=1)
        return np.cos(cones), np.sin(cones)

    def _continue(self, feeds: Array, bases: Array, frames: Array, joints: Array) -> tuple[int, int]:
        guided = np.empty_like(joints)
        failed = self._guide._advance(feeds, guided)
        if failed[0] >= 0:
            joints[failed[0]] = guided[failed[0]]
            self._miss = 0.0
            return failed
        step, self._miss = self._kernel(
            self.link_lengths,
            *self._bounds(),
            bases,
            frames,
            guided[:, -1].copy(),
            TIP_TOLERANCE,
            MOST_PASSES,
            self._memory,
            self._evaluations,
            joints,
        )
        return (step, self.link_lengths.size - 1) if step >= 0 else SOLVED

    def _unreachable(self, feeds: Array, joints: Array, step: int, link: int) -> InfeasibleError:
        if self._miss == 0.0:
            return super()._unreachable(feeds, joints, step, link)
        return InfeasibleError(
            f"step {step}, feed {1e3 * feeds[step]:.2f} mm: {self.name} left the tip {1e3 * self._miss:.3g} mm from "
            f"its goal on the path after {MOST_PASSES:,} passes. From this posture and within the bend limits it finds "
            "no way there; follow the path instead (method exact)."
        )
