"""Where a task that is edited is kept: its file, the files of its plans, and a draft of what is not saved."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path as FilePath

from hognose.planning import Plan, TaskSpec
from hognose.viewer.model.drafts import Draft
from hognose.viewer.model.saving import Original, below, moved, save_plan, save_task


class Keeping:
    """The files of a task. Any thread may use it.

    Parameters
    ----------
    spec
        What the task says as it was opened.
    source
        The file it was read from; None if it comes from elsewhere.
    folder
        Files are written below it only; unless given the source's, or the current one.
    seen
        Plan files that were read, with `hognose.viewer.saving.digest` of their content: they may be written over as
        long as they are the same.

    Attributes
    ----------
    source
        The file it was read from or last saved to.
    home
        The folder that relative paths in the task start from.
    folder
        The folder below which files are written.
    recovered
        Edits that were left unsaved the last time: what the task said then. None if there are none, or the file is
        newer.
    """

    def __init__(
        self,
        spec: TaskSpec,
        source: FilePath | None,
        folder: FilePath | None = None,
        seen: Mapping[FilePath, bytes | None] | None = None,
    ) -> None:
        self.source = source
        self.home = FilePath() if source is None else source.parent
        self.folder = folder or self.home
        self._writing = threading.Lock()
        self._original = Original.of(source)
        self._saved = spec
        self._plans = {file.resolve(): content for file, content in (seen or {}).items()}
        self._draft = Draft(source, spec)
        self.recovered = self._draft.read()

    @property
    def draft(self) -> FilePath | None:
        """The file where unsaved edits are kept; None if nothing is."""
        return self._draft.file if self._draft.kept else None

    @property
    def draft_fault(self) -> str:
        """Why unsaved edits cannot be kept as a draft; empty if they can."""
        return self._draft.fault

    def is_saved(self, spec: TaskSpec) -> bool:
        """Whether the task's file says this."""
        return spec == self._saved

    def save(self, spec: TaskSpec, name: str, force: bool) -> FilePath:
        """Write the task file of a name below `folder`; see `Workbench.save`."""
        file = below(self.folder, name)
        with self._writing:
            self._original = save_task(spec, file, self._original, self.home, force)
            self._draft.remove()
            self.source, self._saved, self._draft = file, spec, Draft(file, spec)
        return file

    def plan_file(self, name: str) -> FilePath:
        """The plan file that a name means."""
        return below(self.folder, name, ".parquet")

    def save_plan(self, plan: Plan, file: FilePath, force: bool) -> None:
        """Write a plan; see `hognose.viewer.saving.save_plan`."""
        with self._writing:
            self._plans[file] = save_plan(plan, file, self._plans.get(file), force)

    def took_up(self) -> None:
        """What was recovered is the task now, so its draft is ours."""
        self._draft.kept, self.recovered = True, None

    def keep_draft(self, now: Callable[[], TaskSpec]) -> None:
        """Write what the task says now if it is not saved; throw the draft away if it is."""
        with self._writing:
            spec = now()
            if self.is_saved(spec):
                self._draft.remove()
            else:
                self._draft.keep(spec if self.source is None else moved(spec, self.home, self.source.parent))
