"""The last two steps predict the next one: the change Δu of the curve's parameter over each link, and its rate."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.follower import Array
from hognose.kernels import kernel


@kernel(inline="always")
def recalled(memory: NDArray, feed: float, tracks: bool) -> tuple[bool, float, float]:
    """Whether the last step predicts this one, the change of feed since then, and one over it, or 0 for no rates.

    `memory` (2, n+1) holds each link's Δu and its rate, and behind them the last feed (NaN before the first step).
    """
    change = feed - memory[0, memory.shape[1] - 1]
    remembers = tracks and not math.isnan(change)
    return remembers, change, 1.0 / change if remembers and abs(change) > 1e-9 else 0.0


@kernel(inline="always")
def remember(memory: NDArray, link: int, delta: float, per_feed: float) -> None:
    """Keep a link's Δu for `recalled`, and its rate."""
    memory[1, link] = (delta - memory[0, link]) * per_feed
    memory[0, link] = delta


def blank_memory(links: int) -> Array:
    """The `memory` of `recalled` before the first step."""
    memory = np.zeros((2, links + 1))
    memory[0, links] = math.nan
    return memory
