"""What methods of other authors have in common that are sped up here: they can also be had as published."""

from __future__ import annotations

from numpy.typing import ArrayLike

from hognose.following.follower import Follower, Limits
from hognose.path import Path


class Tuned(Follower):
    """A published method with additions that make it faster and leave its answer as it is.

    Parameters
    ----------
    path, link_lengths, spacing, bend_limits
        As of every follower.
    as_published
        Without the additions.
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
