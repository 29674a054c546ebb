"""A plan run in and out on emulated drives that move a twin, in simulated time, measured cycle by cycle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.emulator import Delays, Emulator
from hognose.drive.executor import Executor
from hognose.drive.local_bus import local_bus
from hognose.drive.motions import counts_of
from hognose.drive.network import Network
from hognose.drive.record import Record, read_record
from hognose.drive.record.planned import Compared, Planned, compare
from hognose.drive.record.reader import Cycles, Image
from hognose.drive.recorded_run import RecordedRun, Said
from hognose.drive.settings import Settings
from hognose.drive.stream import Cycle
from hognose.errors import InfeasibleError, InputError
from hognose.planning import Plan
from hognose.sim import Twin
from hognose.studies.rehearsal import TwinPlant
from hognose.studies.senses import TipCamera, TwinSenses

Array = NDArray[np.float64]

#: Simulated time goes on in ticks (s) of so much, and drives take so long to answer.
_TICK, _DELAYS = 2e-3, Delays(2e-4, 5e-4)
#: A picture of the tip camera is taken so often (s).
EVERY = 1.0


class _Seen(NamedTuple):
    """The twin at the end of a cycle: joints and tip (n+1, 3) m, and the largest force (N) on a link."""

    joints: Array
    pressed: float


@dataclass(frozen=True, eq=False)
class Way:
    """A plan's motion one way: what was commanded, measured and reached in K cycles.

    Attributes
    ----------
    name
        "in" or "out".
    cycles
        Of the record.
    place : (K,)
        Along the plan (steps), at the end of every cycle.
    joints : (K, n+1, 3) m
        Of the twin, then.
    tip_errors : (K,) m
        How far its tip was from where the plan has it.
    clearance : (K,) m
        The least of all its links; at the horizon of the plan a lower bound.
    contact : N
        The largest force on a link at the end of a cycle.
    compared
        Commands with the plan.
    images
        That the tip camera took on this way.
    trouble
        What ended it before its end, in words; empty if nothing did.
    """

    name: str
    cycles: Cycles
    place: Array
    joints: Array
    tip_errors: Array
    clearance: Array
    contact: float
    compared: Compared
    images: tuple[Image, ...]
    trouble: str

    @property
    def tip_rms(self) -> float:
        """The tip's error (m) in root mean square."""
        return float(np.sqrt(np.mean(self.tip_errors**2)))


@dataclass(frozen=True, eq=False)
class ThereAndBack:
    """Both ways of a plan.

    Attributes
    ----------
    plan, network
    record
        With everything that drives said, and the pictures.
    ways
        In, and out again; fewer if something ended a way before its end.
    trouble
        What kept the arm from moving at all, in words; empty if nothing did.
    """

    plan: Plan
    network: Network
    record: Record
    ways: tuple[Way, ...]
    trouble: str


def there_and_back(
    plan: Plan,
    network: Network,
    twin: Twin,
    file: Path,
    until: float | None = None,
    progress: Callable[[float], None] = lambda steps: None,
    said: Said = lambda kind, words: None,
) -> ThereAndBack:
    """Run a plan in, to a step (its last unless given), and out again.

    Parameters
    ----------
    plan, network
    twin
        What the motors move.
    file
        The record to write.
    until
    progress
        Called with how many steps were gone, both ways together.
    said
        Called with what happens.

    Raises
    ------
    InputError
        The plan cannot be run, or not be recorded.
    MissingExtraError
        A package for records is not installed.
    """
    clock, plant = SimulatedClock(_TICK), TwinPlant(plan, network, twin)
    emulator = Emulator(network, plant, counts_of(plan, network)[0].tolist(), _DELAYS)
    senses = TwinSenses(twin, TipCamera(plan), EVERY)
    run = RecordedRun(plan, network, local_bus(emulator, clock), clock, file, Settings(), said, senses)
    executor, seen = run.executor, []
    end, ways = executor.end(until), _Ways()

    def look(cycle: Cycle) -> None:
        seen.append(_Seen(twin.joints, float(twin.pressed.max())))
        progress(2.0 * end - cycle.set_point.place if ways.done else cycle.set_point.place)

    run.at_cycle.append(look)
    with run.writer:
        ways.go(executor, end, lambda: len(seen))
        why = ways.trouble
        run.writer.close(f"NOT GOOD: {why}" if why else f"GOOD: at step {executor.place:g}")
    if run.writer.fault is not None:
        raise InputError(run.writer.fault)
    record = read_record(file)
    made = tuple(_way(plan, record, seen, *each) for each in ways.done)
    return ThereAndBack(plan, network, record, made, "" if made else ways.trouble)


class _Ways:
    """The ways that are done: name, first cycle, the one behind the last, and what ended it; and what ended all."""

    def __init__(self) -> None:
        self.done: list[tuple[str, int, int, str]] = []
        self.trouble = ""

    def go(self, executor: Executor, end: float, cycles: Callable[[], int]) -> None:
        """Bring an arm to where its plan begins, and go in to a step and out again, until something ends it."""
        try:
            executor.arm()
            executor.hold()
            executor.tension()
        except InfeasibleError as error:
            self.trouble = str(error)
        for name, goal in (("in", end), ("out", 0.0)):
            if self.trouble:
                return
            first, outcome = cycles(), executor.run(goal)
            self.trouble = "" if outcome.trouble is None else outcome.trouble.words
            self.done.append((name, first, cycles(), self.trouble))


def planned_at(values: Array, place: Array) -> Array:
    """Values (T, ...) of the steps of a plan at places (K,), linear between steps."""
    low = np.clip(place.astype(np.int64), 0, max(len(values) - 2, 0))
    share = (place - low).reshape(-1, *(1,) * (values.ndim - 1))
    return values[low] + share * (values[np.minimum(low + 1, len(values) - 1)] - values[low])


def _way(plan: Plan, record: Record, seen: list[_Seen], name: str, first: int, end: int, trouble: str) -> Way:
    """What cycles from a first one to before an end come to."""
    cycles = _between(record.cycles, first, end)
    joints = np.array([each.joints for each in seen[first:end]])
    # A cycle is over when the set-point of the next one takes effect.
    place = np.append(cycles.progress[1:], cycles.progress[-1:])
    off = joints[:, -1] - planned_at(plan.body[:, -1], place)
    scene, radii = plan.task.scene, plan.robot.body_radii
    clear = scene.clearance(joints[:, :-1], joints[:, 1:], radii, horizon=plan.horizon).value.min(axis=1)
    ended = cycles.time[-1] + float(np.diff(cycles.time).max(initial=0.0))
    images = tuple(image for image in record.images if cycles.time[0] < image.time <= ended)
    compared = compare(cycles, Planned.of(plan))
    pressed = max(each.pressed for each in seen[first:end])
    return Way(name, cycles, place, joints, np.linalg.norm(off, axis=1), clear, pressed, compared, images, trouble)


def _between(cycles: Cycles, first: int, end: int) -> Cycles:
    return Cycles(**{each.name: getattr(cycles, each.name)[first:end] for each in fields(Cycles)})
