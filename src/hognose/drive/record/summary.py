"""The record of a run in a few figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.drive.record.messages import Event
from hognose.drive.record.planned import Compared, Planned, compare
from hognose.drive.record.reader import Record
from hognose.drive.record.writer import motion_digest_of
from hognose.planning.motion import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Worst:
    """The largest or smallest of figures of cables over time.

    Attributes
    ----------
    value
        SI units or counts.
    cable
        0-based.
    time : s
    step
        Place along the plan, in steps; None if it was not on it.
    """

    value: float
    cable: int
    time: float
    step: float | None

    @property
    def where(self) -> str:
        """In words."""
        step = "" if self.step is None else f", step {self.step:.1f}"
        return f"cable {self.cable + 1} at {self.time:.2f} s{step}"

    def to_json(self) -> dict[str, Any]:
        """The same for machines; cables count from 1."""
        return {"value": self.value, "cable": self.cable + 1, "time_s": self.time, "step": self.step}


@dataclass(frozen=True, eq=False)
class Summary:
    """What `hognose log` says.

    Attributes
    ----------
    record
    duration : s
    states
        Each state as it came, with how long it lasted in s.
    lateness
        Median, 99.9th percentile and largest, in s; None without cycles.
    following, least_tension, largest_tension, largest_current
        The worst of them; None where nothing was measured.
    compared
        With the plan.
    same_plan
        Whether that is the plan that was run.
    """

    record: Record
    duration: float
    states: tuple[tuple[str, float], ...]
    lateness: tuple[float, float, float] | None
    following: Worst | None
    least_tension: Worst | None
    largest_tension: Worst | None
    largest_current: Worst | None
    compared: Compared
    same_plan: bool

    @property
    def verdict(self) -> str:
        """How the run ended, in a sentence."""
        return self.record.verdict or "none, as the program that ran the plan did not end it"

    @property
    def rows(self) -> list[tuple[str, str, str]]:
        """What is printed as a table: figure, value, where."""
        cycles, found = self.record.cycles, []
        found.append(("duration", f"{self.duration:.2f} s", f"{len(cycles)} cycles"))
        found.append(("states", " → ".join(f"{name} {lasted:.2f} s" for name, lasted in self.states) or "none", ""))
        if self.lateness is not None:
            median, high, largest = (1e3 * value for value in self.lateness)
            words = f"median {median:.2f}, 99.9 % below {high:.2f}, largest {largest:.2f} ms"
            found.append(("lateness of cycles", words, ""))
        for name, worst, unit in (
            ("largest following error", self.following, "counts"),
            ("least tension", self.least_tension, "N"),
            ("largest tension", self.largest_tension, "N"),
            ("largest current", self.largest_current, "A"),
        ):
            if worst is not None:
                found.append((name, f"{worst.value:.4g} {unit}", worst.where))
        kinds = ", ".join(f"{count} {kind}" for kind, count in self.record.counts.items())
        found.append(("events", kinds or "none", ""))
        if self.record.images:
            found.append(("pictures of the tip camera", str(len(self.record.images)), ""))
        return found

    @property
    def remarks(self) -> list[str]:
        """What a person should know, in sentences."""
        other = [] if self.same_plan else ["the plan it is compared with is not the one that was run"]
        return [*self.record.remarks, *other]

    def to_json(self) -> dict[str, Any]:
        """The same for machines, in SI units."""
        record = self.record
        worst = {
            "largest_following_error_counts": self.following,
            "least_tension_N": self.least_tension,
            "largest_tension_N": self.largest_tension,
            "largest_current_A": self.largest_current,
        }
        names = ("median", "p99.9", "largest")
        return {
            "verdict": record.verdict,
            "finished": record.finished,
            "lost_bytes": record.lost,
            "altered": record.altered,
            **{key: record.said[key] for key in ("task", "robot", "version", "motion_sha256") if key in record.said},
            "start": record.start.isoformat(),
            "duration_s": self.duration,
            "cycles": len(record.cycles),
            "states": [{"state": name, "lasted_s": lasted} for name, lasted in self.states],
            "lateness_s": None if self.lateness is None else dict(zip(names, self.lateness, strict=True)),
            **{name: None if each is None else each.to_json() for name, each in worst.items()},
            "pictures": len(record.images),
            "events": [_event(each) for each in record.events],
            "plan": self.compared.to_json() | {"same_plan": self.same_plan},
            "remarks": self.remarks,
        }


def summary(record: Record, plan: Motion | None = None) -> Summary:
    """Summarise a record and compare it with a plan, by default the one in it.

    Raises
    ------
    InputError
        The plan in the record is damaged, or the one given has another number of cables.
    """
    cycles = record.cycles
    planned = Planned.of_plan_file(record.plan_file, int(record.said["cables"])) if plan is None else Planned.of(plan)
    late = cycles.lateness[np.isfinite(cycles.lateness)]
    times = [*cycles.time, *(event.time for event in record.events), *(image.time for image in record.images)]
    return Summary(
        record,
        max(times, default=0.0),
        _states(record),
        None if not len(late) else (float(np.median(late)), float(np.quantile(late, 0.999)), float(late.max())),
        _worst(record, np.abs(cycles.following)),
        _worst(record, cycles.tensions, least=True),
        _worst(record, cycles.tensions),
        _worst(record, np.abs(cycles.currents)),
        compare(cycles, planned),
        motion_digest_of(planned.time, planned.feed, planned.counts) == record.said.get("motion_sha256"),
    )


def _event(event: Event) -> dict[str, Any]:
    return {"time_s": event.time, "kind": event.kind, "text": event.text, "node": event.node, "step": event.step}


def _states(record: Record) -> tuple[tuple[str, float], ...]:
    """Each state with how long it lasted: until the next one began, the last one until the last cycle."""
    time, state = record.cycles.time, record.cycles.state
    begun = [k for k in range(len(state)) if k == 0 or state[k] != state[k - 1]]
    ends = [*begun[1:], len(state) - 1]
    return tuple((state[k], float(time[end] - time[k])) for k, end in zip(begun, ends, strict=False))


def _worst(record: Record, values: Array, least: bool = False) -> Worst | None:
    """The largest of values (K, A), or the smallest; None if nothing is known of any."""
    known = np.isfinite(values)
    if not known.any():
        return None
    filled = np.where(known, values, np.inf if least else -np.inf)
    cycle, cable = np.unravel_index(int(np.argmin(filled) if least else np.argmax(filled)), values.shape)
    time, step = float(record.cycles.time[cycle]), float(record.cycles.progress[cycle])
    return Worst(float(values[cycle, cable]), int(cable), time, step if np.isfinite(step) else None)
