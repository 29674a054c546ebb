"""Feed over time, from rest to rest, within limits of speed, acceleration and jerk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.profile.limits import FeedLimits

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FeedProfile:
    """The fastest feed within limits, averaged over time so that its acceleration changes gradually.

    Between its places the acceleration is constant. What is asked for with `at` is the moving average over
    `smoothing_time`; its jerk is at most twice the acceleration limit by `smoothing_time`.

    Attributes
    ----------
    limits
        Those that speed and acceleration keep, with the averaging already allowed for.
    smoothing_time : s
    time, feed, speed : (G,) s, m, m/s
        When every place is passed, and how fast, without the averaging.
    """

    limits: FeedLimits
    smoothing_time: float
    time: Array
    feed: Array
    speed: Array

    @classmethod
    def within(cls, limits: FeedLimits, smoothing_time: float) -> FeedProfile:
        """The fastest one that keeps given limits everywhere.

        An average over `smoothing_time` mixes places at most the longest way in that time apart. Each place is given
        the smallest limits so far around it, so the average keeps the limits of the place where it is.
        """
        kept = limits.eroded(float(limits.speed.max()) * smoothing_time)
        speed = _double_pass(kept)
        time = np.concatenate([[0.0], np.cumsum(2 * np.diff(kept.feeds) / (speed[1:] + speed[:-1]))])
        return cls(kept, smoothing_time, time, kept.feeds, speed)

    @property
    def duration(self) -> float:
        """From rest to rest, s."""
        return float(self.time[-1]) + self.smoothing_time

    def at(self, times: Array) -> Array:
        """Feeds (k,) m at times (k,) s: 0 up to time 0, and the whole way from `duration` on."""
        return (self._way(times) - self._way(times - self.smoothing_time)) / self.smoothing_time

    def _pieces(self, times: Array) -> tuple[NDArray[np.intp], Array, Array]:
        """The piece that each time is in, the time since it began, and its acceleration (m/s²)."""
        inside = np.clip(times, 0.0, self.time[-1])
        piece = np.clip(np.searchsorted(self.time, inside, "right") - 1, 0, len(self.time) - 2)
        changes = np.diff(self.speed) / np.diff(self.time)
        return piece, inside - self.time[piece], changes[piece]

    def _place(self, times: Array) -> Array:
        """Feed (k,) m without the averaging."""
        piece, since, change = self._pieces(times)
        return self.feed[piece] + since * (self.speed[piece] + since * change / 2)

    def _way(self, times: Array) -> Array:
        """The integral (k,) m s of the feed over time, without the averaging."""
        piece, since, change = self._pieces(times)
        took = np.diff(self.time)
        whole = took * (self.feed[:-1] + took * (self.speed[:-1] / 2 + np.diff(self.speed) / 6))
        before = np.concatenate([[0.0], np.cumsum(whole)])
        part = since * (self.feed[piece] + since * (self.speed[piece] / 2 + since * change / 6))
        return before[piece] + part + np.maximum(times - self.time[-1], 0.0) * self.feed[-1]


def _double_pass(limits: FeedLimits) -> Array:
    """The largest speeds (G,) m/s within limits, from rest to rest.

    v² grows by at most 2 a ds a place. Forwards, v²[k] is therefore the smallest, over all places j up to k, of the
    limit at j and what can be gained from there to k; backwards alike.
    """
    hardest = np.minimum(limits.acceleration[1:], limits.acceleration[:-1])
    gained = np.concatenate([[0.0], np.cumsum(2 * hardest * np.diff(limits.feeds))])
    square = limits.speed**2
    square[0] = square[-1] = 0.0
    square = np.minimum.accumulate(square - gained) + gained
    square = (np.minimum.accumulate((square + gained)[::-1]) - gained[::-1])[::-1]
    square[0] = square[-1] = 0.0
    return np.sqrt(np.maximum(square, 0.0))
