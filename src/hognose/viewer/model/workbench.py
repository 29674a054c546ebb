"""A task at work: edits that are planned at once, undone, searched for a route, saved, and never lost."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path as FilePath
from types import TracebackType

from hognose.errors import InputError
from hognose.files import load_robot
from hognose.planning import Plan, Task, TaskSpec
from hognose.viewer.model import edits
from hognose.viewer.model.background_search import Finding
from hognose.viewer.model.history import History
from hognose.viewer.model.replanner import Array, Question, Replanner, Verdict, share_scene
from hognose.viewer.model.task_files import Keeping

__all__ = ["Verdict", "Workbench"]

#: How long (s) saving a plan waits for the newest one.
_PATIENCE = 60.0


class Workbench:
    """A task that is edited, and the newest verdict on it.

    Any thread may use it. Two threads of its own plan and search; `close` ends them.

    Every edit makes another version of the task, with a number of its own; undoing makes one too. What was made of a
    version (a verdict, a search, an arm that is steered) is good for no other: `is_current` decides that.

    Parameters
    ----------
    task
    source, folder, seen
        See `hognose.viewer.model.task_files.Keeping`.
    restore
        Take up edits that were left unsaved the last time, as one step that can be undone.
    """

    def __init__(
        self,
        task: Task,
        source: FilePath | None = None,
        restore: bool = False,
        folder: FilePath | None = None,
        seen: Mapping[FilePath, bytes | None] | None = None,
    ) -> None:
        self._lock = threading.RLock()
        self._kept = Keeping(task.spec, source, folder, seen)
        self._history = History(task)
        self._number = 0
        self._route: Array | None = None
        self._finding: Finding | None = None
        self._replanner = Replanner(self._keep_draft)
        self._ask()
        if restore and self.recovered is not None:
            with suppress(InputError):  # its robot is gone; `recovered` stays
                self.restore()

    def __enter__(self) -> Workbench:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def task(self) -> Task:
        """The task as edited."""
        with self._lock:
            return self._history.now

    @property
    def spec(self) -> TaskSpec:
        """What the task says, as edited."""
        return self.task.spec

    @property
    def recovered(self) -> TaskSpec | None:
        """Edits that were left unsaved the last time: what the task said then; None if there are none to take up."""
        return self._kept.recovered

    @property
    def source(self) -> FilePath | None:
        """The file it was read from or last saved to."""
        return self._kept.source

    @property
    def folder(self) -> FilePath:
        """The folder below which files are written."""
        return self._kept.folder

    @property
    def number(self) -> int:
        """Of the version that counts; it only grows, and undoing counts as an edit."""
        return self._number

    def is_current(self, number: int) -> bool:
        """Whether what was made of the version of this number is about the task as it is now."""
        return number == self._number

    @property
    def verdict(self) -> Verdict | None:
        """The newest verdict, which may be on a version before; None before the first."""
        return self._replanner.verdict

    @property
    def current(self) -> Verdict | None:
        """The verdict on the task as it is now; None while that is planned."""
        verdict = self._replanner.verdict
        return verdict if verdict is not None and self.is_current(verdict.number) else None

    @property
    def verdicts(self) -> int:
        """How many verdicts there were."""
        return self._replanner.made

    @property
    def dirty(self) -> bool:
        """Whether there is something to be saved."""
        return not self._kept.is_saved(self.spec)

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to be undone."""
        with self._lock:
            return self._history.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone edit."""
        with self._lock:
            return self._history.can_redo

    @property
    def searching(self) -> bool:
        """Whether a search is on."""
        finding = self._finding
        return finding is not None and finding.active

    @property
    def search_said(self) -> str:
        """How the search goes, or how the last one went and that this was before an edit; empty before the first."""
        finding = self._finding
        if finding is None:
            return ""
        return finding.said if self.is_current(finding.number) else f"before the last edit: {finding.said}"

    @property
    def draft(self) -> FilePath | None:
        """The file where unsaved edits are kept; None if nothing is."""
        return self._kept.draft

    @property
    def draft_fault(self) -> str:
        """Why unsaved edits cannot be kept as a draft; empty if they can."""
        return self._kept.draft_fault

    def edit(self, change: Callable[[TaskSpec], TaskSpec], merge: str = "", made_of: int | None = None) -> None:
        """Make an edit; it is planned at once, and a search is ended.

        Parameters
        ----------
        change
            What the task says then, from what it says now; see `hognose.viewer.model.edits`.
        merge
            Successive edits of the same name, not empty, are undone together.
        made_of
            Number of the version that the change was made of, if it makes no sense on another.

        Raises
        ------
        InputError
            It would be no valid task, its robot is not found, or the task is not of that version any more; nothing was
            changed.
        """
        with self._lock:
            if made_of is not None and not self.is_current(made_of):
                raise InputError("the task was edited meanwhile; nothing was changed")
            now = self._history.now
            spec = edits.validated(change(now.spec), self._called(now))
            if spec == now.spec:
                return
            self._push(self._task(spec, now), merge)
            self._end_search()

    def undo(self) -> None:
        """Go back to what was before the last edit; nothing happens if there is none."""
        self._go(-1)

    def redo(self) -> None:
        """Take an undone edit up again; nothing happens if there is none."""
        self._go(1)

    def restore(self) -> None:
        """Take up what `recovered` says, as an edit.

        Raises
        ------
        InputError
            There is nothing, or its robot is not found.
        """
        recovered = self.recovered
        if recovered is None:
            raise InputError("no unsaved edits were found; there is nothing to restore")
        self.edit(lambda _: recovered)
        self._kept.took_up()

    def settle(self, timeout: float) -> Verdict:
        """Wait for the verdict on the newest edit, and return it, or one on a later one.

        Raises
        ------
        HognoseError
            It did not come within `timeout` seconds.
        """
        return self._replanner.settle(self._number, timeout)

    def search(self, seconds: float) -> None:
        """Search a route from the entrance to the target, in the background.

        Each one that is better than those before, and than the present way, becomes the task's way-points; all together
        are one step to undo. Any edit ends the search.

        Raises
        ------
        InputError
            The time makes no sense, or a search is on.
        """
        if not 0 < seconds < 1e6:
            raise InputError(f"time: expected a number of seconds above 0, got {seconds:g}")
        with self._lock:
            if self.searching:
                raise InputError("a search is running already; stop it first")
            now = self._history.now
            spec = edits.validated(edits.ask_for_route(now.spec), self._called(now))
            task = self._task(spec, now)
            self._history.seal()
            self._finding = Finding(task, self._number, seconds, self._found)

    def stop_search(self) -> None:
        """End the search; what it found so far stays."""
        with self._lock:
            self._end_search()

    def save(self, name: str, force: bool = False) -> FilePath:
        """Write the task file; see `hognose.viewer.saving.save_task`. From then on it is the task's file.

        Parameters
        ----------
        name
            Of a file below `folder`.
        force
            Write over a file that somebody else wrote or changed.

        Raises
        ------
        InputError
            It was not written: says why and what to do.
        """
        file = self._kept.save(self.spec, name, force)
        with self._lock:
            self._history.seal()
        return file

    def save_plan(self, name: str, force: bool = False) -> FilePath:
        """Write the plan of the newest edit, good or not, as a plan file; the name is as for `save`.

        Raises
        ------
        InputError
            There is no motion to be written, the file cannot be, the task was edited meanwhile, or the file is there
            and is not as this workbench read or wrote it, unless forced.
        """
        file, number = self._kept.plan_file(name), self._number
        verdict = self._replanner.settle(number, _PATIENCE)
        if verdict.number != number:
            raise InputError("the task was edited before it was planned; nothing was written. Save again.")
        if verdict.plan is None:
            raise InputError(f"there is no motion to save: {verdict.headline}")
        self._kept.save_plan(verdict.plan, file, force)
        return file

    def close(self) -> None:
        """End all threads; what is not saved is kept as a draft. May be called again."""
        finding = self._finding
        if finding is not None:
            finding.close()
        self._replanner.close()
        self._keep_draft()

    def _task(self, spec: TaskSpec, before: Task) -> Task:
        robot = before.robot if spec.robot == before.spec.robot else load_robot(spec.robot, self._kept.home)
        task = Task(spec, robot)
        share_scene(task, before)
        return task

    def _push(self, task: Task, merge: str) -> None:
        self._number += 1  # first: what was made of the version before is not taken for one of this
        self._history.push(task, merge)
        self._ask()

    def _go(self, by: int) -> None:
        with self._lock:
            if self._history.can_go(by):
                self._end_search()
                self._number += 1
                self._history.go(by)
                self._ask()

    def _ask(self) -> None:
        self._replanner.ask(Question(self._number, self._history.now, self._route))

    def _end_search(self) -> None:
        if self._finding is not None:
            self._finding.stop()

    def _found(self, finding: Finding, plan: Plan) -> None:
        """Take a route up, unless something else was done meanwhile or the present way is as good."""
        with self._lock:
            if finding is not self._finding or not finding.active:
                return
            if self._has_better(plan):
                return
            spec = edits.validated(edits.take_route_of(plan)(plan.task.spec), plan.task.name)
            self._route = plan.way_points
            self._push(self._task(spec, self._history.now), f"search {id(finding)}")
            finding.number = self._number

    def _has_better(self, plan: Plan) -> bool:
        """Whether the present way is known to keep as much clearance as a plan."""
        verdict = self.current
        if verdict is None or not verdict.good or verdict.plan is None:
            return False
        known, found = (made.certified_clearance or 0.0 for made in (verdict.plan, plan))
        return self.spec.path.target is None and known >= found

    def _keep_draft(self) -> None:
        self._kept.keep_draft(lambda: self.spec)

    def _called(self, task: Task) -> str:
        """What messages call the task."""
        return str(self._kept.source or task.name)
