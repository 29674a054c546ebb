"""The plan: a whole motion, step by step, with the verdict of every check."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path as FilePath

import numpy as np

from hognose.arguments import file_name
from hognose.errors import InputError
from hognose.following import METHODS
from hognose.planning import extra_columns, plan_file
from hognose.planning.checks.check import Check, good, tally
from hognose.planning.checks.clearance import CERTIFIED
from hognose.planning.checks.criterion import Criterion
from hognose.planning.checks.run import run_checks
from hognose.planning.motion import Motion
from hognose.wording import at_least_mm, at_most
from hognose.write_whole import write_whole


def _from(feed: float) -> str:
    return f"{1e3 * feed:.1f}" if feed else "0"


@dataclass(frozen=True, eq=False)
class Plan(Motion):
    """A motion with the verdicts on it.

    Attributes
    ----------
    checks
        The verdicts; none of a motion that was not judged.
    """

    checks: tuple[Check, ...] = field(default=())

    @staticmethod
    def of(motion: Motion) -> Plan:
        """A motion as a plan that was not checked."""
        return Plan(**{each.name: getattr(motion, each.name) for each in fields(Motion)})

    @property
    def good(self) -> bool:
        """Whether checks were made and none failed; those that could not be judged count for nothing."""
        return good(self.checks)

    @property
    def remarks(self) -> list[str]:
        """What a person should know of the files that the plan and its obstacles come from, in sentences."""
        further = extra_columns.unknown(self.extra, self.robot)
        return [*self.task.remarks, *self.notes, *self._lacking, *([extra_columns.note(further)] if further else [])]

    @property
    def _lacking(self) -> list[str]:
        """What is not installed, and what follows from that, in a sentence."""
        if self.missing_method is None:
            return []
        package = f"the package {self.method_package}" if self.method_package else "the package that adds it"
        return [
            f"made with the following method {self.missing_method!r}, which is not installed: the plan can be shown, "
            f"but neither checked nor planned anew; install {package}, or plan with one of these: {', '.join(METHODS)}"
        ]

    @property
    def _step(self) -> str:
        """What a step is, in words: so much feed, or so much time of a feed that varies."""
        motion = self.task.spec.motion
        if motion.profile_of(self.retracts) == "fastest":
            return f"{1e3 * motion.period_s:g} ms, as fast as the limits allow,"
        return f"{1e3 * motion.step:g} mm"

    @property
    def certified_clearance(self) -> float | None:
        """Clearance (m) that is proven of the whole motion, however the joints move between steps.

        None if nothing was proven: the plan was not checked, or the checks came no further than the feed.
        """
        proven = [check.value for check in self.checks if check.key in CERTIFIED]
        return min(proven) if proven else None

    def check(self, key: str) -> Check:
        """The check of this key, as `bend_limits`; an InputError lists the keys there are."""
        for check in self.checks:
            if isinstance(key, str) and check.key == key:
                return check
        keys = ", ".join(check.key for check in self.checks)
        raise InputError(f"key: no check has the key {key!r:.60}; there are {keys or 'none, as nothing was checked'}")

    def summary(self) -> str:
        """A few lines that say what the plan does and whether it is good."""
        robot, limit = self.robot, self.horizon
        smallest = float(self.clearance.min())
        at_least = "≥ " if smallest >= limit else ""
        planned = "" if self.task.budget is None else " as planned"  # tolerances leave less
        away = 1e3 * self.body_deviation
        way = ", on its way out" if self.retracts else ""
        lines = [
            f"{self.task.name}: {robot.name}, {robot.sections} sections, {robot.cables} cables{way}",
            f"{len(self.time) - 1} steps of {self._step} in {self.time[-1]:.1f} s; "
            f"feed {_from(self.feed[0])} to {1e3 * self.feed[-1]:.1f} mm; "
            f"smallest clearance at the steps {at_least}{at_least_mm(smallest)} mm{planned}",
            f"body at most {at_most(away.max())} mm off the path, "
            f"{np.sqrt(np.mean(away**2)):.2f} mm in root mean square",
            *(f"note: {words}" for words in self.remarks),
        ]
        if self.checks:
            lines.append(f"{'GOOD' if self.good else 'NOT GOOD'}: {tally(self.checks)}")
            lines += [f"  {check.sentence}" for check in self.checks if check.failed]
            lines += [f"  {check.sentence}" for check in self.checks if not check.judged]
        else:
            lines.append("NOT CHECKED")
        return "\n".join(lines)

    def verified(self, progress: Callable[[str], None] = lambda stage: None, more: Iterable[Criterion] = ()) -> Plan:
        """The same motion with every check made anew from its columns, whatever `checks` said.

        Whatever reads a plan or hands one on does this first; it takes about as long as planning.

        Parameters
        ----------
        progress
            Called with the name of each stage.
        more
            Criteria for this time only; `hognose.planning.checks.ALL` has those for every time, also for when the plan
            is saved or shown.

        Raises
        ------
        InputError
            A task that contradicts itself, so that nothing can be checked; what is no criterion in `more`.
        """
        if not callable(progress):
            raise InputError("progress: expected a function that takes the name of a stage")
        return replace(self, checks=run_checks(self, progress, more=more))

    def save(self, path: FilePath | str) -> None:
        """Verify the plan and write it as a Parquet file that holds everything needed to check, show and run it.

        Raises
        ------
        InputError
            If the file cannot be written, or could not be read back; nothing is left half-written.
        """
        path = file_name("path", path)
        verified = self.verified()
        write_whole(path, plan_file.to_parquet(verified, verified.checks))

    @staticmethod
    def load(path: FilePath | str, progress: Callable[[str], None] = lambda stage: None) -> Plan:
        """Read a plan file and verify the plan: its `checks` are made anew, not those that the file holds.

        Parameters
        ----------
        path
        progress
            Called with the name of each stage.

        Raises
        ------
        InputError
            If the file is missing, cut, altered, not a plan, or of a newer schema.
        """
        recorded = plan_file.read(file_name("path", path))
        try:
            plan = Plan.of(recorded.motion).verified(progress)
        except InputError as error:
            raise InputError(f"{recorded.path}: {error}") from None
        if plan.good:  # else it is said already what is wrong
            recorded.refuse_other_figures(plan)
        return plan
