"""Published methods that are faster here: `as_published` gives them as their authors describe them."""

from __future__ import annotations

from numpy.typing import ArrayLike

from hognose.following.follower import Follower, Limits
from hognose.path import Path


class Tuned(Follower):
    """A published method with additions that make it faster and leave its answer as it is.

    Parameters
    ----------
    path, link_lengths, spacing, bend_limits
        As in `Follower`.
    as_published
        Leave the additions out.
    """

    def __init__(
        self,
        path: Path,
        link_lengths: ArrayLike,
        spacing: float = 0.0005,
        bend_limits: Limits = None,
        as_published: bool = False,
    ) -> None:
        self.as_published = as_published
        super().__init__(path, link_lengths, spacing, bend_limits)
