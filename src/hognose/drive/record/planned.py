"""What the drives were to be told, and how far what they were told is from it."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.drive.record.reader import Cycles
from hognose.errors import InputError
from hognose.planning.motion import Motion

Array = NDArray[np.float64]

#: The state in which commands come from the plan.
RUN = "RUN"


@dataclass(frozen=True, eq=False)
class Planned:
    """The set-points of a plan: time (T,) s, feed (T,) m, counts (T, A)."""

    time: Array
    feed: Array
    counts: NDArray[np.int64]

    @classmethod
    def of(cls, motion: Motion) -> Planned:
        """Those of a plan."""
        return cls(motion.time, motion.feed, motion.motor_counts)

    @classmethod
    def of_plan_file(cls, data: bytes, cables: int) -> Planned:
        """Those of the plan file in a record, read without judging it.

        Raises
        ------
        InputError
            It is damaged.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        names = [f"motor_{number:02d}_counts" for number in range(1, cables + 1)]
        try:
            table = pq.read_table(io.BytesIO(data), columns=["time_s", "feed_m", *names])
            time, feed, *counts = (table.column(name).to_numpy() for name in ("time_s", "feed_m", *names))
        except (pa.ArrowException, OSError, KeyError, ValueError) as error:
            said = (str(error).splitlines() or [type(error).__name__])[0]
            raise InputError(f"the plan in the record is damaged: {said}; name the plan file with --plan") from None
        return cls(time, feed, np.stack(counts, axis=1))

    def at(self, progress: Array) -> tuple[Array, Array]:
        """Counts (K, A), not rounded, and feed (K,) m at places (K,) along the plan, linear between its steps."""
        place = np.clip(progress, 0.0, len(self.time) - 1)
        low = np.minimum(place.astype(np.int64), max(len(self.time) - 2, 0))
        high, share = np.minimum(low + 1, len(self.time) - 1), place - low
        counts = self.counts[low] + share[:, None] * (self.counts[high] - self.counts[low])
        return counts, self.feed[low] + share * (self.feed[high] - self.feed[low])


@dataclass(frozen=True)
class Compared:
    """How a run differs from the plan, while it ran.

    Attributes
    ----------
    first, last
        The steps that it was between; None if it never ran.
    reached
        Steps at which commands were sent.
    exact
        Those at which every axis was commanded exactly what the plan says, each time.
    missing
        Steps between the first and the last at which none were sent.
    off : counts
        The largest difference between a command and the plan, linear between its steps: 0.5 by rounding.
    off_cable, off_time
        Where that was: 0-based, and s.
    slider_off : m
        The same of the slider; None if it was never commanded.
    """

    first: int | None
    last: int | None
    reached: int
    exact: int
    missing: tuple[int, ...]
    off: float
    off_cable: int
    off_time: float
    slider_off: float | None

    @property
    def follows(self) -> bool:
        """Whether commands were those of the plan, at its steps exactly, and none is missing."""
        return self.exact == self.reached > 0 and not self.missing and self.off <= 0.5 + 1e-6

    @property
    def words(self) -> str:
        """The comparison in a sentence."""
        if not self.reached:
            return "no command of the plan was sent"
        begun = f"commands at {self.exact} of {self.reached} steps, {self.first} to {self.last}, are exactly the plan's"
        lacking = f"; {len(self.missing)} steps were left out, the first is {self.missing[0]}" if self.missing else ""
        between = f"at most {self.off:.3g} counts from a straight line between steps"
        where = "" if self.off <= 0.5 + 1e-6 else f", cable {self.off_cable + 1} at {self.off_time:.2f} s"
        return f"{begun}{lacking}; {between}{where}"

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        return {
            "first_step": self.first,
            "last_step": self.last,
            "steps_commanded": self.reached,
            "steps_exact": self.exact,
            "steps_missing": list(self.missing),
            "largest_difference_counts": self.off,
            "largest_difference_slider_m": self.slider_off,
            "follows_plan": self.follows,
        }


def compare(cycles: Cycles, plan: Planned) -> Compared:
    """Compare the commands of all cycles in the state RUN with a plan of as many cables.

    Raises
    ------
    InputError
        The plan has another number of cables.
    """
    if plan.counts.shape[1] != cycles.commanded.shape[1]:
        raise InputError(
            f"the plan has {plan.counts.shape[1]} cables, but the record {cycles.commanded.shape[1]}: it is not of "
            "this arm"
        )
    runs = np.array([state == RUN for state in cycles.state], bool)
    if not runs.any():
        return Compared(None, None, 0, 0, (), 0.0, 0, 0.0, None)
    place, commanded = cycles.progress[runs], cycles.commanded[runs]
    counts, feed = plan.at(place)
    off, slider_off = np.abs(commanded - counts), np.abs(cycles.slider_commanded[runs] - feed)
    cycle, cable = np.unravel_index(int(np.argmax(off)), off.shape)
    whole = place == np.rint(place)
    steps = np.rint(place[whole]).astype(np.int64)
    wrong = set(steps[(off[whole] != 0).any(axis=1)].tolist())
    reached = set(steps.tolist())
    first, last = (min(reached), max(reached)) if reached else (None, None)
    missing = () if first is None or last is None else tuple(sorted(set(range(first, last + 1)) - reached))
    return Compared(
        first, last, len(reached), len(reached - wrong), missing, float(off[cycle, cable]), int(cable),
        float(cycles.time[runs][cycle]), float(np.nanmax(slider_off)) if np.isfinite(slider_off).any() else None,
    )  # fmt: skip
