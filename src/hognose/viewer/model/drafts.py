"""Edits that were not saved yet, kept so that they outlive whatever ends the program."""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Any

from hognose.cache_folder import state_folder
from hognose.errors import InputError
from hognose.files.toml_source import validate
from hognose.planning import TaskSpec
from hognose.write_whole import write_whole


def folder() -> FilePath | None:
    """Where drafts are kept, or None if that is switched off."""
    kept = state_folder()
    return None if kept is None else kept / "drafts"


class Draft:
    """The draft of one task.

    Parameters
    ----------
    source
        The task's file; None if it has none: then it is known by what it says.
    spec
        What the task says as it was opened.

    Attributes
    ----------
    file
        Where the draft is kept, if there is one; None if drafts are switched off.
    kept
        Whether this object wrote it or took it up, so that it may throw it away.
    fault
        Why it could not be kept; empty if it could.
    """

    def __init__(self, source: FilePath | None, spec: TaskSpec) -> None:
        self._source, self._spec = source, spec
        self.kept, self.fault = False, ""
        where = str(source.resolve()) if source else json.dumps(_dump(spec), sort_keys=True)
        place, digest = folder(), hashlib.sha256(where.encode()).hexdigest()[:16]
        self.file = None if place is None else place / f"{source.stem[:40] if source else 'unnamed'}-{digest}.json"

    def keep(self, spec: TaskSpec) -> None:
        """Write it, whole or not at all."""
        if self.file is None:
            return
        held = {"source": str(self._source.resolve()) if self._source else None, "task": _dump(spec)}
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self.file.parent.chmod(0o700)  # one of before may be open to others
            write_whole(self.file, json.dumps(held, indent=1).encode(), private=True)
            self.kept, self.fault = True, ""
        except (OSError, InputError) as error:
            self.fault = f"edits cannot be kept as a draft: {error}. Save them."

    def read(self) -> TaskSpec | None:
        """What it says, if it is newer than the task's file and another task; None too if it is damaged."""
        if self.file is None:
            return None
        with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):  # an InputError is a ValueError
            kept = self.file.stat().st_mtime_ns
            if self._source is not None and self._source.exists() and kept <= self._source.stat().st_mtime_ns:
                return None
            held = json.loads(self.file.read_bytes())["task"]
            beside = None if self._source is None else self._source.parent
            data = held | {"obstacle": self._obstacles(held), "units": "m"}
            spec = validate(data, TaskSpec, str(self.file), folder=beside)
            return None if spec == self._spec else spec
        return None

    def remove(self) -> None:
        """Throw it away, if it was written or taken up here."""
        if self.file is not None and self.kept:
            self.kept = False
            with suppress(OSError):
                self.file.unlink()

    def _obstacles(self, held: dict[str, Any]) -> tuple[Any, ...]:
        """Those of the task as it was opened where they are the same: they have their files' content with them."""
        there = {json.dumps(item.model_dump(mode="json", by_alias=True)): item for item in self._spec.obstacle}
        return tuple(there.get(json.dumps(item), item) for item in held.get("obstacle", ()))


def _dump(spec: TaskSpec) -> dict[str, Any]:
    return spec.model_dump(mode="json", by_alias=True)
