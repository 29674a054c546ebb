"""The log of a simulation: one row a control period, its columns declared once."""

from __future__ import annotations

import io
import itertools
import json
import string
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import file_name
from hognose.errors import InputError
from hognose.files.exports.csv import of_cells as csv_of
from hognose.files.exports.json import of_cells as json_of
from hognose.planning.columns import LABELS, LARGEST_LOAD_FACTOR
from hognose.planning.plan_table import to_table
from hognose.robot import Robot
from hognose.sim.simulated import Simulated
from hognose.version import __version__
from hognose.write_whole import write_whole

#: The key of what a Parquet file says besides its columns.
METADATA_KEY = b"hognose_simulation"


@dataclass(frozen=True)
class Logged:
    """Something of which every row has figures.

    Attributes
    ----------
    pattern
        The names of its columns, as in `tension_{cable}_N`; what stands first in it varies slowest.
    unit
        SI; empty for names.
    meaning
        What it is, without an end.
    of
        Its figures (P, …).
    each
        Axes of the array behind the rows, as keys of `hognose.planning.columns.LABELS`.
    """

    pattern: str
    unit: str
    meaning: str
    of: Callable[[Simulated], NDArray[Any]]
    each: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The pattern for people, as in `tension_NN_N`."""
        special = {"xyz": "xyz", "angle": "{alpha,beta}"}
        return self.pattern.format(**{name: special.get(name, "NN") for name in self._named})

    @property
    def _named(self) -> list[str]:
        return [name for _, name, _, _ in string.Formatter().parse(self.pattern) if name is not None]

    def cells(self, done: Simulated, robot: Robot) -> dict[str, NDArray[Any]]:
        """Its columns (P,) by name."""
        values, named, found = self.of(done), self._named, {}
        for labels in itertools.product(*(enumerate(LABELS[name](robot)) for name in named)):
            at = {name: place for name, (place, _) in zip(named, labels, strict=True)}
            words = {name: label for name, (_, label) in zip(named, labels, strict=True)}
            found[self.pattern.format(**words)] = values[(slice(None), *(at[name] for name in self.each))]
        return found


#: All columns, in the order of the file.
COLUMNS: tuple[Logged, ...] = (
    Logged("time_s", "s", "end of the control period, 0 at the start", lambda done: done.time),
    Logged(
        "commanded_{angle}_{section}_rad", "rad", "what the plan has there",
        lambda done: done.commanded, ("section", "angle"),
    ),
    Logged(
        "reached_{angle}_{section}_rad", "rad", "what the arm did",
        lambda done: done.angles, ("section", "angle"),
    ),
    Logged(
        "length_{extending section}_m", "m", "how long a section that extends is held",
        lambda done: done.section_lengths[:, done.plan.robot.extending], ("extending section",),
    ),
    Logged(
        "planned_tip_{xyz}_m", "m", "where the plan has the tip, in the task's frame",
        lambda done: done.tips, ("xyz",),
    ),
    Logged("tip_{xyz}_m", "m", "where it is", lambda done: done.joints[:, -1], ("xyz",)),
    Logged("tip_error_m", "m", "how far these are apart", lambda done: done.tip_errors),
    Logged("tension_{cable}_N", "N", "tension at the motor", lambda done: done.tensions, ("cable",)),
    Logged(
        "end_tension_{cable}_N", "N", "tension where the cable is fixed; friction makes the difference",
        lambda done: done.end_tensions, ("cable",),
    ),
    Logged("slack_cables", "", "how many cables were slack within the period", lambda done: done.slack),
    Logged("overloaded_cables", "", "how many were pulled with more than tension_max_N", lambda done: done.overloaded),
    Logged(
        "contact_{link}_N", "N", "the largest force on the link within the period",
        lambda done: done.contact, ("link",),
    ),
    Logged(
        "contact_{link}_obstacle", "", "the obstacle that pressed it most, or nothing",
        lambda done: done.pressing, ("link",),
    ),
    Logged(
        "buckling_load_factor", "1",
        "by how much tensions and weight would have to grow until the arm buckles, 1000 at most",
        lambda done: np.minimum(done.load_factor, LARGEST_LOAD_FACTOR),
    ),
    Logged(
        "smallest_stiffness_Nm_rad", "N m/rad", "smallest eigenvalue of the arm's stiffness; it buckles below 0",
        lambda done: done.smallest_stiffness,
    ),
)  # fmt: skip


def cells(done: Simulated) -> dict[str, NDArray[Any]]:
    """The columns (P,) by name."""
    found: dict[str, NDArray[Any]] = {}
    for each in COLUMNS:
        found |= each.cells(done, done.plan.robot)
    return found


def metadata(done: Simulated) -> dict[str, Any]:
    """What JSON and Parquet say besides the columns: what was simulated, and the figures."""
    return {
        "version": __version__,
        "task": done.plan.task.name,
        "robot": done.plan.robot.name,
        "robot_fingerprint": done.plan.robot.fingerprint,
        "changes": done.changes.to_json(),
        **done.to_json(),
    }


def _csv(done: Simulated) -> bytes:
    return csv_of(cells(done))


def _json(done: Simulated) -> bytes:
    return json_of(metadata(done), cells(done))


def _parquet(done: Simulated) -> bytes:
    import pyarrow.parquet as pq

    table = to_table(cells(done)).replace_schema_metadata({METADATA_KEY: json.dumps(metadata(done)).encode()})
    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
    return buffer.getvalue()


#: What writes a log, by the suffix of its file.
WRITERS: dict[str, Callable[[Simulated], bytes]] = {".csv": _csv, ".parquet": _parquet, ".json": _json}


def refuse_log(path: Path | str) -> Path:
    """The file of a log, before anything is simulated for it.

    Raises
    ------
    InputError
        No such format, or no such folder.
    """
    file = file_name("log", path)
    if file.suffix.lower() not in WRITERS:
        raise InputError(f"{file}: unknown format {file.suffix!r} of a log; expected {', '.join(WRITERS)}")
    if not file.parent.is_dir():
        raise InputError(f"{file}: cannot write: there is no folder {file.parent}; make it first")
    return file


def write_log(done: Simulated, path: Path | str) -> None:
    """Write the log of a simulation, whole or not at all; the suffix determines the format.

    Raises
    ------
    InputError
        No such format, or the file cannot be written.
    """
    file = refuse_log(path)
    write_whole(file, WRITERS[file.suffix.lower()](done))
