"""The fastest feed along a path that keeps every limit of the robot: `[motion] profile = "fastest"`."""

from __future__ import annotations

from hognose.planning.profile.fastest import Fastest
from hognose.planning.profile.feed_profile import FeedProfile
from hognose.planning.profile.limits import FeedLimits
from hognose.planning.profile.moved import Moved

__all__ = ["Fastest", "FeedLimits", "FeedProfile", "Moved"]
