"""The whole experiment of the paper: an arm is calibrated, and run in and out on emulated drives and the twin."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import hognose
from hognose.errors import InputError
from hognose.planning import Plan, Task
from hognose.planning.assumed import assumed_values
from hognose.studies.calibrated_arm import Array, CalibratedArm
from hognose.studies.there_and_back import ThereAndBack, Way, there_and_back
from hognose.studies.way_figures import figures
from hognose.version import __version__
from hognose.write_whole import write_whole

#: Both cases of the paper, as bundled tasks.
CASES = ("obstacle-array", "pipe-tank")
#: What names of files begin with, and those of the files beside the records, the plans and what was measured.
PREFIX = "experiment-"
RESULTS, TABLE, CALIBRATION = "experiment.json", "experiment.csv", f"{PREFIX}calibration.json"


@dataclass(frozen=True, eq=False)
class Case:
    """A case of the paper as it was run.

    Attributes
    ----------
    nominal
        The task, with the arm as its file says.
    ran
        The plan with the calibrated arm, in and out.
    before, after : (T,) m
        How far the tip would be off along the plan, by statics: not calibrated, and calibrated.
    """

    nominal: Task
    ran: ThereAndBack
    before: Array
    after: Array

    @property
    def name(self) -> str:
        """Of its files."""
        return self.ran.record.path.stem

    @property
    def plan_file(self) -> Path:
        """Of the plan that was run."""
        return self.ran.record.path.with_suffix(".parquet")

    @property
    def troubles(self) -> list[str]:
        """What is not as it must be, in sentences; empty if all is well."""
        title, ran = self.nominal.name, self.ran
        said = [f"{title}: {ran.trouble}"] if ran.trouble else []
        for way in ran.ways:
            said += [f"{title}, {way.name}: {way.trouble}"] if way.trouble else []
            missed = [each for each in figures(ran, way) if not each.is_met]
            said += [f"{title}, {way.name}: {each.words}: {each.shown}, must be {each.bound}" for each in missed]
        return said

    def to_json(self) -> dict[str, Any]:
        """All figures, in the units that their names say."""
        ran = self.ran
        return {
            "task": self.nominal.name,
            "good": not self.troubles,
            "plan": self.plan_file.name,
            "record": ran.record.path.name,
            "steps": len(ran.plan.time) - 1,
            "duration_s": float(ran.plan.time[-1]),
            "certified_clearance_m": ran.plan.certified_clearance,
            "bus_load": ran.network.load,
            "tip_rms_not_calibrated_m": _rms(self.before),
            "tip_rms_calibrated_by_statics_m": _rms(self.after),
            "ways": [{"way": way.name} | {each.key: each.value for each in figures(ran, way)} for way in ran.ways],
            "troubles": self.troubles,
        }


@dataclass(eq=False)
class Experiment:
    """What came of it, as far as it came.

    Attributes
    ----------
    folder
        Where its files are.
    seed
        Of what is hidden.
    wanted
        The cases that were asked for.
    arm
        None before it is calibrated.
    cases
        Those that are done.
    seconds
        How long it took.
    """

    folder: Path
    seed: int
    wanted: tuple[str, ...]
    arm: CalibratedArm | None = None
    cases: list[Case] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def troubles(self) -> list[str]:
        """What is not as it must be, in sentences; empty if all is well."""
        fits = self.arm is None or self.arm.calibration.fit.fits
        said = [] if fits else ["the calibration: its readings do not fit the arm"]
        said += [words for case in self.cases for words in case.troubles]
        return said

    @property
    def left(self) -> tuple[str, ...]:
        """The cases that are not run yet."""
        return self.wanted[len(self.cases) :]

    @property
    def good(self) -> bool:
        """Whether all cases were run, and every figure is within its bound."""
        return not self.troubles and not self.left

    @property
    def verdict(self) -> str:
        """Whether it is good, and why not, in a line."""
        if not self.good:
            return f"NOT GOOD: {'; '.join([*self.troubles, *(f'{name}: not run' for name in self.left)])}"
        worst = max(way.tip_rms for case in self.cases for way in case.ran.ways)
        return (
            f"GOOD: the tip is off its plan by {1e3 * worst:.3f} mm at most, in root mean square over each way, and "
            "every other figure is within its bound"
        )

    @property
    def assumed(self) -> list[str]:
        """What nobody gave or measured, in words."""
        found: dict[str, None] = {}
        for case in self.cases:
            said = [f"network: {key}" for key in case.ran.network.spec.assumed]
            found |= dict.fromkeys([*assumed_values(case.ran.plan), *said])
        return [*found, "twin: stiffness and damping of contacts", "drives: a time constant of 2 ms"]

    def to_json(self) -> dict[str, Any]:
        """All figures, in the units that their names say."""
        return {
            "good": self.good,
            "verdict": self.verdict,
            "version": __version__,
            "seed": self.seed,
            "seconds": self.seconds,
            "calibration": None if self.arm is None else self.arm.to_json(),
            "cases": [case.to_json() for case in self.cases],
            "troubles": self.troubles,
            "not_run": list(self.left),
            "assumed": self.assumed,
        }

    def save(self) -> list[Path]:
        """Write the figures as JSON and CSV, and what was measured in every cycle as CSV; the files."""
        files = [self.folder / RESULTS, self.folder / TABLE]
        write_whole(files[0], (json.dumps(self.to_json(), indent=1) + "\n").encode())
        ways = [(case, way) for case in self.cases for way in case.ran.ways]
        rows = [(case.nominal.name, way.name, figures(case.ran, way)) for case, way in ways]
        head = ["task", "way", *(each.key for each in (rows[0][2] if rows else ()))]
        write_whole(files[1], _csv(head, ([task, way, *(each.value for each in found)] for task, way, found in rows)))
        for case, way in ways:
            files.append(self.folder / f"{case.name}-{way.name}.csv")
            write_whole(files[-1], _csv(_CYCLE, _cycles(way)))
        return files


def whole_experiment(
    folder: Path,
    names: Iterable[str] = CASES,
    seed: int = 0,
    until: float | None = None,
    progress: Callable[[float, float], None] = lambda done, total: None,
    said: Callable[[str], None] = lambda words: None,
    done: Callable[[Experiment], None] = lambda experiment: None,
) -> Experiment:
    """Calibrate an arm with a hidden truth, and run cases in and out with it.

    Records, plans and the calibration are written into a folder, which must be there, over those of an earlier one.

    Parameters
    ----------
    folder
    names
        Of bundled tasks, of the same robot.
    seed
        Of the truth.
    until
        The step at which the way out begins; the last one unless given.
    progress
        Called with the steps that are gone, and how many there are.
    said
        Called with sentences on what is done.
    done
        Called after every case.

    Raises
    ------
    InputError
        A task is unknown, of another robot than the first, or a file cannot be written.
    InfeasibleError
        The arm cannot be calibrated, or there is no plan.
    MissingExtraError
        What the twin or records need is not installed.
    """
    begun, made = time.perf_counter(), Experiment(folder, seed, tuple(names))
    tasks = [hognose.load_task(name) for name in made.wanted]
    if not tasks:
        raise InputError("names: expected one task at least")
    made.arm = arm = CalibratedArm.drawn(tasks[0], seed)
    arm.calibration.save(folder / CALIBRATION)
    said(arm.words)
    plans = [hognose.plan(arm.task(task)) for task in tasks]
    ways = [2.0 * (len(plan.time) - 1 if until is None else until) for plan in plans]
    for k, (name, task, plan) in enumerate(zip(made.wanted, tasks, plans, strict=True)):
        gone = sum(ways[:k])
        case = _run(
            arm, task, plan, folder / f"{PREFIX}{name}.mcap", until, lambda x, gone=gone: progress(gone + x, sum(ways))
        )
        made.cases.append(case)
        made.seconds = time.perf_counter() - begun
        said(_words(case))
        done(made)
    return made


def _run(
    arm: CalibratedArm, task: Task, plan: Plan, file: Path, until: float | None, progress: Callable[[float], None]
) -> Case:
    """A case with its plan and its record in files."""
    plan.save(file.with_suffix(".parquet"))
    file.unlink(missing_ok=True)
    ran = there_and_back(plan, arm.network(plan), arm.twin(task), file, until, progress)
    return Case(task, ran, arm.uncalibrated.errors(task, plan), arm.errors(task, plan))


def _words(case: Case) -> str:
    """How a case went, in a line."""
    ways = "; ".join(f"{way.name}: tip off by {1e3 * way.tip_rms:.3f} mm RMS" for way in case.ran.ways)
    return "\n".join([f"{case.nominal.name}: {ways or 'did not move'}", *(f"  {words}" for words in case.troubles)])


_CYCLE = ("time_s", "step", "tip_x_m", "tip_y_m", "tip_z_m", "tip_error_m", "clearance_m", "least_tension_N",
          "largest_tension_N", "largest_following_error_counts")  # fmt: skip


def _cycles(way: Way) -> Iterable[list[float]]:
    """Rows of what was measured at the end of every cycle."""
    cycles, tips = way.cycles, way.joints[:, -1]
    columns = (cycles.time, way.place, *tips.T, way.tip_errors, way.clearance, cycles.tensions.min(axis=1),
               cycles.tensions.max(axis=1), np.abs(cycles.following).max(axis=1))  # fmt: skip
    return (list(map(float, row)) for row in zip(*columns, strict=True))


def _csv(head: Iterable[str], rows: Iterable[Iterable[object]]) -> bytes:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue().encode()


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
