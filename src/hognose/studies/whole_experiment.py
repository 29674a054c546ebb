"""The whole experiment of the paper without its hardware: calibration, plan, drives, twin, tip camera and record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.calibration import Calibration, Hidden, Sensors, Setting, StaticArm, calibrate, start_of, with_stiffness
from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.local_bus import local_bus
from hognose.drive.motions import counts_of
from hognose.drive.network import Network, calibrated_counts, emulated_network
from hognose.drive.record import read_record
from hognose.drive.record.reader import Record
from hognose.drive.record.summary import Summary, summary
from hognose.drive.recorded_run import RecordedRun
from hognose.drive.settings import Settings
from hognose.drive.stream import Cycle
from hognose.errors import InfeasibleError
from hognose.mechanics import Mechanics
from hognose.planning import Plan, Task
from hognose.route import plan as made_plan
from hognose.sim.arm import twin_of
from hognose.studies.rehearsal import TwinPlant
from hognose.studies.senses import TipCamera, TwinSenses

Array = NDArray[np.float64]
#: Called with how far a case is, from 0 to 1, and what it is doing.
Progress = Callable[[float, str], None]

#: The cases of the paper.
CASES = ("obstacle-array", "pipe-tank")
#: What the tip must reach: root mean square off its plan (m).
TIP_RMS = 1e-4
#: The base is drawn back by so much (m) before the entrance while the arm is in its jig.
_BACK = 0.1
#: Emulated motors move on in ticks of this (s), and the camera takes a picture so often (s).
_TICK, _PICTURE_EVERY = 2e-3, 1.0


@dataclass(frozen=True, eq=False)
class Leg:
    """One way of a run: in, or back.

    Attributes
    ----------
    name
    start, end
        Steps.
    places : (K,) steps
        Of the set-points, cycle by cycle.
    off : (K,) m
        How far the tip was off its plan at the end of each.
    trouble
        What ended it, in words; empty if it came to its end.
    """

    name: str
    start: float
    end: float
    places: Array
    off: Array
    trouble: str

    @property
    def rms(self) -> float:
        """Of the tip off its plan, m."""
        return float(np.sqrt(np.mean(self.off**2)))

    @property
    def good(self) -> bool:
        """Whether it came to its end, with the tip where it must be."""
        return not self.trouble and self.rms <= TIP_RMS


@dataclass(frozen=True, eq=False)
class Experiment:
    """A case, run in and back.

    Attributes
    ----------
    name
        Of the bundled task.
    plan
        Made with the stiffness that was calibrated.
    network
        With the zeros that were calibrated.
    hidden, calibration
        How the arm is, and what was found of it.
    legs
    record, summary
        What was recorded, and what `hognose log` says of it.
    """

    name: str
    plan: Plan
    network: Network
    hidden: Hidden
    calibration: Calibration
    legs: tuple[Leg, ...]
    record: Record
    summary: Summary

    @property
    def zero_error(self) -> float:
        """The largest error (m) that is left of a cable's zero."""
        return float(np.abs(self.hidden.zeros - self.calibration.fit.zeros).max())

    @property
    def good(self) -> bool:
        """Whether all of it is as it must be."""
        compared = self.summary.compared
        return all(leg.good for leg in self.legs) and compared.exact == compared.reached and not compared.missing

    def to_json(self) -> dict[str, Any]:
        """The figures, in SI units."""
        return {
            "task": self.name,
            "good": self.good,
            "record": str(self.record.path),
            "bus_load": self.network.load,
            "certified_clearance_m": float(self.plan.clearance.min()),
            "zero_error_left_m": self.zero_error,
            "legs": [
                {
                    "name": leg.name,
                    "from_step": leg.start,
                    "to_step": leg.end,
                    "tip_rms_m": leg.rms,
                    "tip_largest_m": float(leg.off.max()),
                    "trouble": leg.trouble or None,
                }
                for leg in self.legs
            ],
            "log": self.summary.to_json(),
        }


def experiment(
    name: str,
    task: Task,
    folder: Path,
    seed: int = 1,
    until: float | None = None,
    calibrates: bool = True,
    progress: Progress = lambda share, words: None,
) -> Experiment:
    """Run a case in and back, on an arm whose zeros and stiffness are hidden.

    Parameters
    ----------
    name
        Of the files in the folder: plan (.parquet), record (.mcap) and calibration (.json).
    task
    folder
        Made already. A record of before is replaced.
    seed
        Of the hidden truth, and of the noise of its sensors.
    until
        The step to turn round at; the last one unless given.
    calibrates
        Without it, motors are commanded as if the arm were as its file says.
    progress

    Raises
    ------
    InfeasibleError
        The plan is not good.
    """
    mechanics, at = Mechanics.of(task.robot), start_of(task, _BACK)
    progress(0.0, "calibrating in the jig")
    setting = Setting(mechanics, task.gravity(at[None])[0], at)
    hidden, accuracy = Hidden.drawn(mechanics, seed), setting.accuracy
    arm = StaticArm(mechanics, setting.gravity, hidden, Sensors(accuracy, seed, False), accuracy.jig)
    found = calibrate(arm, setting, "jig")
    found.save(folder / f"{name}-calibration.json")
    progress(0.02, "planning")
    plan = made_plan(with_stiffness(task, found.fit.stiffness) if calibrates else task)
    if not plan.good:
        raise InfeasibleError(f"{name}: {plan.summary().splitlines()[-1]}")
    plan.save(folder / f"{name}.parquet")
    network = emulated_network(plan.robot)
    if calibrates:
        network = replace(network, calibrated=calibrated_counts(found, plan.robot))
    run = _Run(plan, network, TwinPlant(plan, network, twin_of(task, hidden)), folder / f"{name}.mcap", progress)
    legs = run.there_and_back(until)
    record = read_record(run.file)
    return Experiment(name, plan, network, hidden, found, legs, record, summary(record))


class _Run:
    """Emulated drives that move a twin, and a recorded run of a plan on them."""

    def __init__(self, plan: Plan, network: Network, plant: TwinPlant, file: Path, progress: Progress) -> None:
        clock = SimulatedClock(_TICK)
        emulator = Emulator(network, plant, counts_of(plan, network)[0].tolist())
        file.unlink(missing_ok=True)
        senses = TwinSenses(plant.twin, TipCamera(plan), _PICTURE_EVERY)
        bus = local_bus(emulator, clock)
        self.file, self._plan, self._twin, self._progress = file, plan, plant.twin, progress
        self._run = RecordedRun(plan, network, bus, clock, file, Settings(), senses=senses)
        self._run.at_cycle.append(self._look)
        self._places: list[float] = []
        self._tips: list[Array] = []
        self._says = ""

    def there_and_back(self, until: float | None) -> tuple[Leg, ...]:
        """In to a step, and back to the first."""
        executor, legs = self._run.executor, []
        with self._run.writer as writer:
            executor.arm()
            executor.hold()
            executor.tension()
            for name, goal in (("in", executor.end(until)), ("back", 0.0)):
                legs.append(self._leg(name, goal))
                if legs[-1].trouble:
                    break
            trouble = legs[-1].trouble
            writer.close(f"NOT GOOD: {trouble}" if trouble else f"GOOD: at step {executor.place:g}")
        return tuple(legs)

    def _leg(self, name: str, goal: float) -> Leg:
        executor, body = self._run.executor, self._plan.body[:, -1]
        start, self._says = executor.place, f"{name}, step "
        self._places.clear()
        self._tips.clear()
        outcome = executor.run(goal)
        # A cycle is over when the next one's set-point takes effect.
        at, tips = np.array(self._places[1:]), np.array(self._tips[:-1])
        low = np.minimum(at.astype(int), len(body) - 2)
        planned = body[low] + (at - low)[:, None] * (body[low + 1] - body[low])
        words = "" if outcome.trouble is None else outcome.trouble.words
        return Leg(name, start, outcome.place, at, np.linalg.norm(tips - planned, axis=1), words)

    def _look(self, cycle: Cycle) -> None:
        place = cycle.set_point.place
        self._places.append(place)
        self._tips.append(self._twin.joints[-1])
        share = place / (len(self._plan.body) - 1)
        if self._says:
            done = 0.5 * (share if self._says.startswith("in") else 2.0 - share)
            self._progress(0.05 + 0.95 * done, f"{self._says}{place:.0f}")


def verdict(cases: Sequence[Experiment]) -> str:
    """One sentence for all."""
    for case in cases:
        for leg in case.legs:
            if leg.trouble:
                return f"NOT GOOD: {case.name}, {leg.name}: {leg.trouble}"
            if not leg.good:
                return (
                    f"NOT GOOD: {case.name}, {leg.name}: the tip is {1e3 * leg.rms:.3f} mm off its plan in root mean "
                    f"square, more than {1e3 * TIP_RMS:g} mm"
                )
        if not case.good:
            return f"NOT GOOD: {case.name}: {case.summary.compared.words}"
    worst = max(leg.rms for case in cases for leg in case.legs)
    return f"GOOD: the tip is {1e3 * worst:.3f} mm off its plan at most, in root mean square over each way"
