"""How arms with sections of any kinds stand on a base while they follow: with which axes, and at which coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hognose.errors import InputError
from hognose.following.follower import Array, Follower
from hognose.following.sections import SectionFollower
from hognose.robot.base import Base, Slider
from hognose.robot.carrier import Carrier


def section_base(base: Base) -> tuple[Array, bool]:
    """The arguments `axes` and `carried` of `follower` for sections on a base; an InputError where none are known.

    On a base that coils an arm nothing says how its sections bend.
    """
    if isinstance(base, Slider):
        return np.eye(3) if base.R_task_base is None else base.R_task_base, False
    if isinstance(base, Carrier):
        return base.R_task_start, True
    raise InputError(
        f"base: sections that are no rigid links are followed from a slider, a cart or a carrier, not from a base of "
        f"type {type(base).__name__}; take one of the kinds slider, cart, arm"
    )


def run_on(base: Base, method: Follower, feeds: ArrayLike) -> tuple[Array, Array]:
    """Joints (T, n+1, 3) m at feeds (T,) m, and coordinates (T, k) of the base; errors of `Follower.run`.

    Links say by their joints how a carrier holds them; where other sections begin, their method says it.
    """
    if isinstance(base, Carrier) and isinstance(method, SectionFollower):
        joints, axes = method.run_with_axes(feeds)
        return joints, base.posed(joints[:, 0], axes)
    joints = method.run(feeds)
    return joints, base.coordinates(np.asarray(feeds, dtype=np.float64), joints)
