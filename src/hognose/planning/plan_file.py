"""The plan file: Parquet, one row a step, with everything needed to check, show and run the plan inside."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Annotated, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from hognose.errors import InputError
from hognose.planning import embedded
from hognose.planning.checks.check import Check, from_json, good, to_json
from hognose.planning.columns import Column, columns_of, digest_of, from_table, to_arrow
from hognose.planning.motion import Motion
from hognose.planning.task import Task, TaskSpec
from hognose.planning.tolerances import COLUMN_TOLERANCE
from hognose.read_whole import read_whole
from hognose.robot import Robot, RobotSpec
from hognose.units import FileModel, Point
from hognose.version import __version__

#: Version of the columns and the metadata; files of other ones are refused.
SCHEMA_VERSION = 2
METADATA_KEY, DIGESTS_KEY = b"hognose", b"hognose.sha256"
#: No entry of the metadata is larger, and no plan file (bytes).
LARGEST_ENTRY = 1_500_000_000
LARGEST_FILE = 4_000_000_000
#: So many columns are named in a message at most.
_NAMED = 5


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


Checks = tuple[Check, ...]


def metadata(plan: Motion, checks: Checks) -> dict[str, Any]:
    """What a plan file says besides its columns; all lengths in m."""
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
    }


def to_table(plan: Motion, checks: Checks) -> pa.Table:
    """The plan's columns, named as in `docs/plan-file.md`, with the metadata and the digests of both."""
    columns = columns_of(plan.robot.sections, plan.robot.cables)
    table = pa.table({column.name: to_arrow(column.of(plan), column.type) for column in columns})
    said = json.dumps(metadata(plan, checks)).encode()
    digests = {
        METADATA_KEY.decode(): hashlib.sha256(said).hexdigest(),
        "columns": {column.name: digest_of(column.of(plan)) for column in columns},
    }
    return table.replace_schema_metadata({METADATA_KEY: said, DIGESTS_KEY: json.dumps(digests).encode()})


def to_parquet(plan: Motion, checks: Checks) -> bytes:
    """The plan file of a motion and the verdict on it.

    Raises
    ------
    InputError
        A plan that could not be read back.
    """
    table, geometry = to_table(plan, checks), embedded.entries(plan.task.spec)
    _refuse_unreadable(plan, table, geometry)
    buffer = io.BytesIO()
    with pq.ParquetWriter(buffer, table.schema, compression="zstd") as writer:
        writer.write_table(table)
        writer.add_key_value_metadata(geometry)
    return buffer.getvalue()


def _refuse_unreadable(plan: Motion, table: pa.Table, geometry: dict[str, str]) -> None:
    """What `load` would refuse is not written."""
    try:
        Said.model_validate(json.loads(table.schema.metadata[METADATA_KEY]))
    except ValidationError as error:
        raise InputError(f"the plan cannot be written, as it could not be read: {_fault(error)}") from None
    from_table(table, columns_of(plan.robot.sections, plan.robot.cables))
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
    deviation : (T, n) m
        The column `deviation`.
    """

    path: FilePath
    motion: Motion
    deviation: NDArray[np.float64]

    def refuse_other_deviation(self, plan: Motion) -> None:
        """Raise an InputError that names the column whose figures are not those of the angles."""
        off = np.abs(self.deviation - plan.body_deviation)
        step, link = np.unravel_index(np.argmax(off), off.shape)
        if off[step, link] > COLUMN_TOLERANCE:
            columns = columns_of(plan.robot.sections, plan.robot.cables)
            name = next(c.name for c in columns if (c.attribute, c.place) == ("body_deviation", (link,)))
            raise InputError(
                f"{self.path}: column {name!r} is {1e3 * off[step, link]:.3g} mm off at step {step} from what the "
                "angles give: the file was altered. Plan anew."
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
        raise InputError(f"{path}: the plan's metadata is damaged: {_fault(error)}") from None
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: the plan's metadata is damaged: {_first_line(error)}") from None


def _texts(entries: dict[bytes, bytes]) -> dict[str, str]:
    """Entries of the metadata as text; those that are none are damaged."""
    return {key.decode("latin-1"): value.decode("latin-1") for key, value in entries.items()}


def _from_table(table: pa.Table, held: dict[str, str]) -> tuple[Motion, NDArray[np.float64]]:
    raw = held.get(METADATA_KEY.decode())
    if raw is None:
        raise InputError(f"a Parquet file, but not a plan: it has no {METADATA_KEY.decode()!r} metadata")
    said = Said.model_validate(_of_this_schema(_parsed(raw)))
    robot = Robot.from_spec(said.robot)
    if said.robot_fingerprint != robot.fingerprint:
        raise InputError(
            f"the robot in the plan's metadata has the fingerprint {robot.fingerprint}, but the plan was made for "
            f"{said.robot_fingerprint}: the file was altered. Plan anew."
        )
    columns = columns_of(robot.sections, robot.cables)
    arrays: dict[str, Any] = from_table(table, columns)
    _refuse_altered(raw, held, columns, table)
    _refuse_unknown_entries(held, said)
    deviation = arrays.pop("body_deviation")
    task = Task(embedded.restored(said.task, said.geometry, held), robot)
    way_points = np.array(said.way_points_m, dtype=np.float64)
    motion = Motion(task, way_points, horizon=said.clearance_horizon_m, **arrays)
    _refuse_contradictions(said, motion)
    return motion, deviation


def _parsed(raw: str) -> Any:
    """The JSON of an entry, in which no key may be there twice: programs differ in which of the two they take."""

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            raise ValueError(f"a key is there twice among {', '.join(sorted(found))[:60]}")
        return found

    return json.loads(raw.encode("latin-1"), object_pairs_hook=once)


def _of_this_schema(said: Any) -> Any:
    schema = said.get("schema") if isinstance(said, dict) else None
    if not isinstance(schema, int) or isinstance(schema, bool):
        raise InputError("the plan's metadata names no schema version")
    written = f"written by Hognose {said.get('version', '?')} with plan schema {schema}"
    if schema > SCHEMA_VERSION:
        raise InputError(f"{written}; this version reads {SCHEMA_VERSION}. Update Hognose.")
    if schema < SCHEMA_VERSION:
        raise InputError(
            f"{written}; this version reads {SCHEMA_VERSION}, whose files say what they held when they were written. "
            "Plan the task anew."
        )
    return said


def _refuse_altered(raw: str, held: dict[str, str], columns: tuple[Column, ...], table: pa.Table) -> None:
    """Raise an InputError that names what is not as it was written: metadata, columns."""
    if DIGESTS_KEY.decode() not in held:
        raise InputError(f"the file was altered: its entry {DIGESTS_KEY.decode()!r}, the digests, is gone. Plan anew.")
    digests = _parsed(held[DIGESTS_KEY.decode()])
    if set(digests) != {METADATA_KEY.decode(), "columns"} or set(digests["columns"]) != {c.name for c in columns}:
        raise InputError("the file was altered: its digests are not those of these columns. Plan anew.")
    altered = [name for name, digest in digests["columns"].items() if digest_of(table[name].to_numpy()) != digest]
    words = [f"column {name!r}" for name in altered[:_NAMED]]
    words += [f"{len(altered) - _NAMED} more columns"] if len(altered) > _NAMED else []
    if hashlib.sha256(raw.encode("latin-1")).hexdigest() != digests[METADATA_KEY.decode()]:
        words.insert(0, f"the metadata {METADATA_KEY.decode()!r}")
    if words:
        raise InputError(f"the file was altered after it was written: {', '.join(words)}. Plan anew.")


def _refuse_unknown_entries(held: dict[str, str], said: Said) -> None:
    known = {METADATA_KEY.decode(), DIGESTS_KEY.decode(), *(f"{embedded.PREFIX}{digest}" for digest in said.geometry)}
    for key in held:
        if key.startswith(METADATA_KEY.decode()) and key not in known:
            raise InputError(f"the entry {key[:80]!r} of the metadata is unknown: the file was altered. Plan anew.")


def _refuse_contradictions(said: Said, plan: Motion) -> None:
    """Raise an InputError where metadata and columns, or two entries, do not say the same."""
    if said.rows != len(plan.time):
        raise InputError(f"the metadata says {said.rows} rows, but there are {len(plan.time)}: the file was altered")
    if not (np.diff(plan.time) > 0).all():
        raise InputError("time_s does not rise from step to step")
    if said.retracts != plan.retracts:
        ways = {True: "a retraction", False: "an insertion"}
        raise InputError(
            f"the metadata says {ways[said.retracts]}, but feed_m is that of {ways[plan.retracts]}: "
            "the file was altered"
        )
    if said.good != good(from_json(said.checks)):
        raise InputError("the metadata's `good` is not what its checks say: the file was altered")


def _fault(error: ValidationError) -> str:
    """The first fault, with the key it is at."""
    first = error.errors(include_url=False)[0]
    return f"{'.'.join(map(str, first['loc'])) or 'it'}: {first['msg']}"


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
