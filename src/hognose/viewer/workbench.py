"""A task at work: edits that are planned at once, undone, searched for a route, saved, and never lost."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path as FilePath
from types import TracebackType

from hognose.errors import InputError
from hognose.files import load_robot
from hognose.planning import Plan, Task, TaskSpec
from hognose.viewer import edits
from hognose.viewer.drafts import Draft
from hognose.viewer.finding import Finding
from hognose.viewer.history import History, State
from hognose.viewer.replanner import Array, Question, Replanner, Verdict, share_scene
from hognose.viewer.saving import Original, moved, save_task

__all__ = ["Verdict", "Workbench"]

#: How long (s) saving a plan waits for the newest one.
_PATIENCE = 60.0


class Workbench:
    """A task that is edited, and the newest verdict on it.

    Any thread may use it. Two threads of its own plan and search; `close` ends them.

    Parameters
    ----------
    task
    source
        The file the task was read from; None if it comes from elsewhere.
    restore
        Take up edits that were left unsaved the last time, as one step that can be undone.

    Attributes
    ----------
    recovered
        Edits that were left unsaved the last time: what the task said then. None if there are none, or the file is
        newer.
    """

    def __init__(self, task: Task, source: FilePath | None = None, restore: bool = False) -> None:
        self._lock = threading.RLock()
        self._writing = threading.Lock()  # of files; taken before the other one
        self._source = source
        self._folder = FilePath() if source is None else source.parent
        self._original = Original.of(source)
        self._history = History(State(task))
        self._saved = task.spec
        self._plans: set[FilePath] = set()  # files that it wrote
        self._number = 0
        self._route: Array | None = None
        self._finding: Finding | None = None
        self._draft = Draft(source, task.spec)
        self.recovered: TaskSpec | None = self._draft.read()
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
            return self._history.now.task

    @property
    def spec(self) -> TaskSpec:
        """What the task says, as edited."""
        return self.task.spec

    @property
    def source(self) -> FilePath | None:
        """The file it was read from or last saved to."""
        return self._source

    @property
    def number(self) -> int:
        """Of the newest edit; it only grows, and undoing counts as one."""
        return self._number

    @property
    def verdict(self) -> Verdict | None:
        """The newest verdict, on the newest edit if it has its number; None before the first."""
        return self._replanner.verdict

    @property
    def verdicts(self) -> int:
        """How many verdicts there were."""
        return self._replanner.made

    @property
    def dirty(self) -> bool:
        """Whether there is something to be saved."""
        return self.spec != self._saved

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
        """How the search goes, or how the last one went, in words; empty before the first."""
        finding = self._finding
        return "" if finding is None else finding.said

    @property
    def draft(self) -> FilePath | None:
        """The file where unsaved edits are kept; None if nothing is."""
        return self._draft.file if self._draft.kept else None

    @property
    def draft_fault(self) -> str:
        """Why unsaved edits cannot be kept as a draft; empty if they can."""
        return self._draft.fault

    def edit(self, change: Callable[[TaskSpec], TaskSpec], merge: str = "") -> None:
        """Make an edit; it is planned at once, and a search is ended.

        Parameters
        ----------
        change
            What the task says then, from what it says now; see `hognose.viewer.edits`.
        merge
            Successive edits of the same name, not empty, are undone together.

        Raises
        ------
        InputError
            It would be no valid task, or its robot is not found; nothing was changed.
        """
        with self._lock:
            state = self._history.now
            spec = edits.validated(change(state.task.spec), str(self._source or state.task.name))
            if spec == state.task.spec:
                return
            self._push(State(self._task(spec, state.task), state.wished), merge)
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
            raise InputError("no unsaved edits were found; there is nothing to be restored")
        self.edit(lambda _: recovered)
        self._draft.kept = True
        self.recovered = None

    def settle(self, timeout: float) -> Verdict:
        """Wait for the verdict on the newest edit, and return it.

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
                raise InputError("a search is on already; stop it first")
            state = self._history.now
            asked = edits.ask_for_route(state.wished)(state.task.spec)
            spec = edits.validated(asked, str(self._source or state.task.name))
            task = self._task(spec, state.task)
            self._history.seal()
            self._finding = Finding(task, seconds, self._found)

    def stop_search(self) -> None:
        """End the search; what it found so far stays."""
        with self._lock:
            self._end_search()

    def save(self, file: FilePath, force: bool = False) -> None:
        """Write the task file; see `hognose.viewer.saving.save_task`. From then on it is the task's file.

        Raises
        ------
        InputError
            It was not written: says why and what to do.
        """
        with self._writing:
            spec = self.spec
            self._original = save_task(spec, FilePath(file), self._original, self._folder, force)
            self._draft.remove()
            with self._lock:
                self._source, self._saved = FilePath(file), spec
                self._history.seal()
            self._draft = Draft(self._source, spec)

    def save_plan(self, file: FilePath, force: bool = False) -> None:
        """Write the plan of the newest edit, good or not, as a plan file.

        Raises
        ------
        InputError
            There is no motion to be written, the file cannot be, or it is there and was not written by this workbench,
            unless forced.
        """
        file = FilePath(file).resolve()
        if file.exists() and file not in self._plans and not force:
            raise InputError(f"{file}: there is such a file already; choose another name, or allow writing over it")
        plan = self.settle(_PATIENCE).plan
        if plan is None:
            raise InputError(f"there is no motion to be saved: {self.settle(_PATIENCE).headline}")
        plan.save(file)
        self._plans.add(file)

    def close(self) -> None:
        """End all threads; what is not saved is kept as a draft. May be called again."""
        finding = self._finding
        if finding is not None:
            finding.close()
        self._replanner.close()
        self._keep_draft()

    def _task(self, spec: TaskSpec, before: Task) -> Task:
        robot = before.robot if spec.robot == before.spec.robot else load_robot(spec.robot, self._folder)
        task = Task(spec, robot)
        share_scene(task, before)
        return task

    def _push(self, state: State, merge: str) -> None:
        self._history.push(state, merge)
        self._number += 1
        self._ask()

    def _go(self, by: int) -> None:
        with self._lock:
            if self._history.go(by):
                self._end_search()
                self._number += 1
                self._ask()

    def _ask(self) -> None:
        self._replanner.ask(Question(self._number, self._history.now.task, self._route))

    def _end_search(self) -> None:
        if self._finding is not None:
            self._finding.stop()

    def _found(self, finding: Finding, plan: Plan) -> None:
        """Take a route up, unless something else was done meanwhile or the present way is as good."""
        with self._lock:
            if finding is not self._finding or not finding.active:
                return
            state = self._history.now
            if self._has_better(plan):
                return
            spec = edits.validated(edits.take_route(plan.way_points)(plan.task.spec), plan.task.name)
            self._route = plan.way_points
            self._push(State(self._task(spec, state.task), plan.task.spec.path), f"search {id(finding)}")

    def _has_better(self, plan: Plan) -> bool:
        """Whether the present way is known to keep as much clearance as a plan."""
        verdict = self.verdict
        if verdict is None or verdict.number != self._number or not verdict.good or verdict.plan is None:
            return False
        known, found = (made.certified_clearance or 0.0 for made in (verdict.plan, plan))
        return self.spec.path.target is None and known >= found

    def _keep_draft(self) -> None:
        """Write what is not saved; throw the draft away if all is."""
        with self._writing:
            spec = self.spec
            if spec == self._saved:
                self._draft.remove()
            else:
                self._draft.keep(self._portable(spec))

    def _portable(self, spec: TaskSpec) -> TaskSpec:
        """What a task in the source's folder says."""
        return spec if self._source is None else moved(spec, self._folder, self._source.parent)
