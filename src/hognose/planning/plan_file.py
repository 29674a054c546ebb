"""The plan file: Parquet, one row a step, with everything needed to check, show and run the plan inside."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Annotated, Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import Field, ValidationError

from hognose.errors import InputError
from hognose.extensions import home
from hognose.planning import embedded, older_files
from hognose.planning.checks.check import Check, from_json, good, to_json
from hognose.planning.damage import ALTERED, REMEDY
from hognose.planning.motion import Motion
from hognose.planning.motion_spec import PLANNED
from hognose.planning.plan_table import Figures, all_cells, digest_of, from_table, to_table
from hognose.planning.task import Task, TaskSpec
from hognose.read_whole import read_whole
from hognose.robot import Robot, RobotSpec
from hognose.units import FileModel, Point
from hognose.version import __version__

#: Version of the columns and the metadata; files of newer ones are refused, older ones are read and written as this.
SCHEMA_VERSION = 2
METADATA_KEY, DIGESTS_KEY = b"hognose", b"hognose.sha256"
#: No entry of the metadata is larger, and no plan file (bytes).
LARGEST_ENTRY = 1_500_000_000
LARGEST_FILE = 4_000_000_000
#: So many columns are named in a message at most.
_NAMED = 5
#: A plan keeps so many notes, and so many letters of each.
MOST_NOTES, LONGEST_NOTE = 20, 1000
Note = Annotated[str, Field(min_length=1, max_length=LONGEST_NOTE)]


class Said(FileModel):
    """What the entry `hognose` of a plan file says; all lengths in m."""

    schema_version: Annotated[int, Field(alias="schema", ge=SCHEMA_VERSION, le=SCHEMA_VERSION)]
    version: str
    good: bool
    rows: Annotated[int, Field(ge=2)]
    retracts: bool
    robot: RobotSpec
    robot_fingerprint: str
    task: TaskSpec
    geometry: tuple[str | None, ...]
    way_points_m: Annotated[tuple[Point, ...], Field(min_length=2)]
    clearance_horizon_m: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    checks: tuple[dict[str, Any], ...]
    notes: Annotated[tuple[Note, ...], Field(max_length=MOST_NOTES)] = ()
    method_package: Annotated[str, Field(max_length=LONGEST_NOTE)] = ""

    @classmethod
    def of(cls, said: Any) -> Self:
        """What was read, validated; the following method need not be installed."""
        return cls.model_validate(said, context={PLANNED: True})


Checks = tuple[Check, ...]


def metadata(plan: Motion, checks: Checks) -> dict[str, Any]:
    """What a plan file says besides its columns; all lengths in m.

    The last two keys are only there where they say something.
    """
    package = method_package(plan)
    return {
        "schema": SCHEMA_VERSION,
        "version": __version__,
        "good": good(checks),
        "rows": len(plan.time),
        "retracts": plan.retracts,
        "robot": plan.robot.spec.model_dump(by_alias=True),
        "robot_fingerprint": plan.robot.fingerprint,
        "task": plan.task.spec.model_dump(by_alias=True),
        "geometry": embedded.digests(plan.task.spec),
        "way_points_m": plan.way_points.tolist(),
        "clearance_horizon_m": plan.horizon,
        "checks": [to_json(check) for check in checks],
        **({"notes": list(plan.notes)} if plan.notes else {}),
        **({"method_package": package} if package else {}),
    }


def method_package(plan: Motion) -> str:
    """The package that adds the plan's following method, or added it where it was planned; empty for Hognose's own."""
    found = home("methods", plan.task.spec.motion.method)
    return plan.method_package if found == "hognose" else found


def to_parquet(plan: Motion, checks: Checks) -> bytes:
    """The plan file of a motion and the verdict on it.

    Raises
    ------
    InputError
        A plan that could not be read back.
    """
    cells, said, geometry = all_cells(plan), metadata(plan, checks), embedded.entries(plan.task.spec)
    raw = json.dumps(said).encode()
    digests = {
        METADATA_KEY.decode(): hashlib.sha256(raw).hexdigest(),
        "columns": {name: digest_of(values) for name, values in cells.items()},
    }
    table = to_table(cells).replace_schema_metadata({METADATA_KEY: raw, DIGESTS_KEY: json.dumps(digests).encode()})
    _refuse_unreadable(plan, table, geometry)
    buffer = io.BytesIO()
    with pq.ParquetWriter(buffer, table.schema, compression="zstd") as writer:
        writer.write_table(table)
        writer.add_key_value_metadata(geometry)
    return buffer.getvalue()


def _refuse_unreadable(plan: Motion, table: pa.Table, geometry: dict[str, str]) -> None:
    """What `load` would refuse is not written."""
    try:
        Said.of(json.loads(table.schema.metadata[METADATA_KEY]))
    except ValidationError as error:
        raise InputError(f"the plan cannot be written, as it could not be read: {_fault(error)}") from None
    from_table(table, plan.robot, SCHEMA_VERSION)
    for entry in geometry.values():
        if len(entry) > LARGEST_ENTRY:
            raise InputError(
                f"the obstacles' files hold {len(entry) / 1e9:.1f} GB packed, and a plan file at most "
                f"{LARGEST_ENTRY / 1e9:g} GB of each: simplify the meshes"
            )


@dataclass(frozen=True)
class Recorded:
    """What a plan file holds: the motion, and figures that follow from it, which nothing but a reader uses.

    Attributes
    ----------
    path
        The file.
    motion
        Not judged yet.
    figures
        All that the columns hold.
    """

    path: FilePath
    motion: Motion
    figures: Figures

    def refuse_other_figures(self, plan: Motion) -> None:
        """Raise an InputError that names a column whose figures do not follow from the others."""
        found = self.figures.differing(plan)
        if found is None:
            return
        column, step, off = found
        quantity = column.quantity
        amount = f"{1e3 * off:.3g} mm" if quantity.unit == "m" else f"{off:.3g} {quantity.unit}"
        why = "the file was altered" + ("" if quantity.since else ", or these figures are computed differently today")
        raise InputError(
            f"{self.path}: column {column.name!r} is {amount} off at step {step} from what the other columns give: "
            f"{why}. {REMEDY}"
        )


def read(path: FilePath | str) -> Recorded:
    """Read a plan file; errors as of `Plan.load`. Nothing in it is judged."""
    path = FilePath(path)
    data = read_whole(path, LARGEST_FILE, "a plan file")
    try:
        file = pq.ParquetFile(pa.BufferReader(data), thrift_string_size_limit=LARGEST_ENTRY)
        table, held = file.read(), _texts(file.metadata.metadata or {})
    except (pa.ArrowException, OSError, ValueError) as error:
        raise InputError(f"{path}: not a plan file, or one that was cut: {_first_line(error)}") from None
    try:
        return Recorded(path, *_from_table(table, held))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except ValidationError as error:
        raise InputError(f"{path}: the plan's metadata is damaged: {_fault(error)}. {REMEDY}") from None
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: the plan's metadata is damaged: {_first_line(error)}. {REMEDY}") from None


def _texts(entries: dict[bytes, bytes]) -> dict[str, str]:
    """Entries of the metadata as text; those that are none are damaged."""
    return {key.decode("latin-1"): value.decode("latin-1") for key, value in entries.items()}


def _from_table(table: pa.Table, held: dict[str, str]) -> tuple[Motion, Figures]:
    raw = held.get(METADATA_KEY.decode())
    if raw is None:
        raise InputError(f"a Parquet file, but not a plan: it has no {METADATA_KEY.decode()!r} metadata")
    parsed = _parsed(raw)
    schema = _schema_of(parsed)
    older = schema < SCHEMA_VERSION
    said = _said_today(parsed, table.num_rows, schema) if older else Said.of(parsed)
    robot = Robot.from_spec(said.robot)
    written = older_files.fingerprint_as_written(parsed["robot"]) if older else robot.fingerprint
    if said.robot_fingerprint != written:
        raise InputError(
            f"the robot in the plan's metadata has the fingerprint {written}, but the plan was made for "
            f"{said.robot_fingerprint}: {ALTERED}"
        )
    figures = from_table(table, robot, schema)
    if not older:
        _refuse_altered(raw, held, figures)
        _refuse_other_verdict(said)
    _refuse_unknown_entries(held, said, older)
    motion = Motion(
        Task(embedded.restored(said.task, said.geometry, held), robot),
        np.array(said.way_points_m, dtype=np.float64),
        horizon=said.clearance_horizon_m,
        extra=figures.extra,
        notes=(older_files.note(said.version, schema, figures.lacking),) if older else said.notes,
        method_package=said.method_package,
        **figures.stored,
    )
    _refuse_contradictions(said, motion)
    return motion, figures


def _said_today(parsed: dict[str, Any], rows: int, schema: int) -> Said:
    """What a file of an older schema says."""
    try:
        return Said.of(older_files.said_today(parsed, rows, SCHEMA_VERSION))
    except ValidationError as error:
        raise InputError(
            f"{_written(parsed, schema)}, which this version cannot take over: {_fault(error)}. Plan the task anew."
        ) from None


def _parsed(raw: str) -> Any:
    """The JSON of an entry, in which no key may be there twice: programs differ in which of the two they take."""

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            raise ValueError(f"a key appears twice among {', '.join(sorted(found))[:60]}")
        return found

    return json.loads(raw.encode("latin-1"), object_pairs_hook=once)


def _schema_of(said: Any) -> int:
    """The schema version of a file's metadata; an InputError if it is none that is read."""
    schema = said.get("schema") if isinstance(said, dict) else None
    if not isinstance(schema, int) or isinstance(schema, bool):
        raise InputError(f"the plan's metadata names no schema version: {ALTERED}")
    if not older_files.OLDEST <= schema <= SCHEMA_VERSION:
        todo = "Update Hognose." if schema > SCHEMA_VERSION else "Plan the task anew."
        raise InputError(
            f"{_written(said, schema)}; this version reads {older_files.OLDEST} to {SCHEMA_VERSION}. {todo}"
        )
    return schema


def _written(said: dict[str, Any], schema: int) -> str:
    return f"written by Hognose {said.get('version', '?')} with plan schema {schema}"


def _refuse_altered(raw: str, held: dict[str, str], figures: Figures) -> None:
    """Raise an InputError that names what is not as it was written: metadata, columns."""
    if DIGESTS_KEY.decode() not in held:
        raise InputError(f"the entry {DIGESTS_KEY.decode()!r} with the digests is missing: {ALTERED}")
    digests = _parsed(held[DIGESTS_KEY.decode()])
    if set(digests) != {METADATA_KEY.decode(), "columns"} or not isinstance(digests["columns"], dict):
        raise InputError(f"the entry {DIGESTS_KEY.decode()!r} does not hold the digests: {ALTERED}")
    _refuse_other_columns(digests["columns"], figures)
    altered = [name for name, digest in digests["columns"].items() if digest_of(figures.cells[name]) != digest]
    words = [_columns(altered)] if altered else []
    if hashlib.sha256(raw.encode("latin-1")).hexdigest() != digests[METADATA_KEY.decode()]:
        words.insert(0, f"the metadata {METADATA_KEY.decode()!r}")
    if words:
        raise InputError(f"the file was altered after it was written: {', '.join(words)}. {REMEDY}")


def _refuse_other_columns(digests: dict[str, str], figures: Figures) -> None:
    """Raise an InputError that names columns without a digest, or digests without a column."""
    bare = [name for name in figures.cells if name not in digests]
    if bare:
        raise InputError(
            f"{_columns(bare)} {'has' if len(bare) == 1 else 'have'} no digest. A program that adds a column must add "
            f"its digest to the entry {DIGESTS_KEY.decode()!r}, as docs/plan-file.md describes; in Python, put the "
            f"column into `extra` of the plan and save it. Otherwise {ALTERED}"
        )
    lost = [name for name in digests if name not in figures.cells]
    if lost:
        raise InputError(f"there are digests of {_columns(lost)}, but no such cells: {ALTERED}")


def _columns(names: list[str]) -> str:
    """Columns by name, the first few of them."""
    words = [f"column {name!r:.100}" for name in names[:_NAMED]]
    return ", ".join(words + ([f"{len(names) - _NAMED} more columns"] if len(names) > _NAMED else []))


def _refuse_unknown_entries(held: dict[str, str], said: Said, older: bool) -> None:
    known = {METADATA_KEY.decode(), *(f"{embedded.PREFIX}{digest}" for digest in said.geometry)}
    known |= set() if older else {DIGESTS_KEY.decode()}
    for key in held:
        if key.startswith(METADATA_KEY.decode()) and key not in known:
            raise InputError(f"the entry {key[:80]!r} of the metadata is unknown: {ALTERED}")


def _refuse_other_verdict(said: Said) -> None:
    if said.good != good(from_json(said.checks)):
        raise InputError(f"the metadata's `good` is not what its checks say: {ALTERED}")


def _refuse_contradictions(said: Said, plan: Motion) -> None:
    """Raise an InputError where metadata and columns, or two entries, do not say the same."""
    if said.rows != len(plan.time):
        raise InputError(f"the metadata says {said.rows} rows, but there are {len(plan.time)}: {ALTERED}")
    if not (np.diff(plan.time) > 0).all():
        step = int(np.argmin(np.diff(plan.time) > 0)) + 1
        raise InputError(f"column 'time_s' does not rise at step {step}, as it must from step to step: {ALTERED}")
    if said.retracts != plan.retracts:
        ways = {True: "a retraction", False: "an insertion"}
        raise InputError(
            f"the metadata says {ways[said.retracts]}, but column 'feed_m' is that of {ways[plan.retracts]}: {ALTERED}"
        )


def _fault(error: ValidationError) -> str:
    """The first fault, with the key it is at."""
    first = error.errors(include_url=False)[0]
    key = ".".join(map(str, first["loc"])) or "it"
    if first["type"] == "extra_forbidden":
        return f"the key {key!r} is unknown to this version, Hognose {__version__}"
    return f"{key}: {first['msg'].removeprefix('Value error, ')}"


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
