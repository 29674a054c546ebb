"""The plan file: Parquet, one row a step, with everything needed to check, show and run the plan inside."""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from hognose.errors import InputError
from hognose.planning import embedded
from hognose.planning.plan import Check, Plan
from hognose.planning.storage import write_whole
from hognose.planning.task import Task, TaskSpec
from hognose.read_whole import read_whole
from hognose.robot import Robot, RobotSpec
from hognose.version import __version__

#: Version of the columns and the metadata; a file of a higher one is refused.
SCHEMA_VERSION = 1
METADATA_KEY = b"hognose"
#: No entry of the metadata is larger, and no plan file (bytes).
LARGEST_ENTRY = 1_500_000_000
LARGEST_FILE = 4_000_000_000


#: Figures of a plan (s, m, rad) beyond this are damage.
_LARGEST_VALUE = 1e6
_CHECKS = TypeAdapter(tuple[Check, ...])


def to_table(plan: Plan) -> pa.Table:
    """The plan's columns, named as in `docs/plan-file.md`, with the metadata."""
    columns: dict[str, NDArray[Any]] = {"time_s": plan.time, "feed_m": plan.feed}
    for joint in range(plan.joints.shape[1]):
        for axis, letter in enumerate("xyz"):
            columns[f"joint_{joint:02d}_{letter}_m"] = plan.joints[:, joint, axis]
    for name, axis in (("alpha", 0), ("beta", 1)):
        for section in range(plan.angles.shape[1]):
            columns[f"{name}_{section + 1:02d}_rad"] = plan.angles[:, section, axis]
    for kind, values in (("cable_{:02d}_m", plan.cable_lengths), ("motor_{:02d}_counts", plan.motor_counts)):
        for cable in range(values.shape[1]):
            columns[kind.format(cable + 1)] = values[:, cable]
    for link in range(plan.clearance.shape[1]):
        columns[f"clearance_{link + 1:02d}_m"] = plan.clearance[:, link]
    for link in range(plan.body_deviation.shape[1]):
        columns[f"deviation_{link + 1:02d}_m"] = plan.body_deviation[:, link]
    table = pa.table({name: _arrow(values) for name, values in columns.items()})
    return table.replace_schema_metadata({METADATA_KEY: json.dumps(metadata(plan)).encode()})


def _arrow(values: NDArray[Any]) -> pa.Array:
    """A column of float64 or int64. Arrow's own conversion would import pandas, which takes half a second."""
    kind = pa.int64() if values.dtype == np.int64 else pa.float64()
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(np.ascontiguousarray(values))])


def metadata(plan: Plan) -> dict[str, Any]:
    """What a plan file says besides its columns; all lengths in m."""
    return {
        "schema": SCHEMA_VERSION,
        "version": __version__,
        "good": plan.good,
        "robot": plan.robot.spec.model_dump(by_alias=True),
        "robot_fingerprint": plan.robot.fingerprint,
        "task": plan.task.spec.model_dump(by_alias=True),
        "geometry": embedded.digests(plan.task.spec),
        "way_points_m": plan.way_points.tolist(),
        "clearance_horizon_m": plan.horizon,
        "checks": [dataclasses.asdict(check) for check in plan.checks],
    }


def save(plan: Plan, path: FilePath | str) -> None:
    """Write a plan; see `Plan.save`."""
    buffer = io.BytesIO()
    table = to_table(plan)
    with pq.ParquetWriter(buffer, table.schema, compression="zstd") as writer:
        writer.write_table(table)
        writer.add_key_value_metadata(embedded.entries(plan.task.spec))
    write_whole(path, buffer.getvalue())


def load(path: FilePath | str) -> Plan:
    """Read a plan; see `Plan.load`."""
    path = FilePath(path)
    data = read_whole(path, LARGEST_FILE, "a plan file")
    try:
        file = pq.ParquetFile(pa.BufferReader(data), thrift_string_size_limit=LARGEST_ENTRY)
        table, held = file.read(), _texts(file.metadata.metadata or {})
    except (pa.ArrowException, OSError, ValueError) as error:
        raise InputError(f"{path}: not a plan file, or one that was cut: {_first_line(error)}") from None
    raw = (table.schema.metadata or {}).get(METADATA_KEY)
    if raw is None:
        raise InputError(f"{path}: a Parquet file, but not a plan: it has no {METADATA_KEY.decode()!r} metadata")
    try:
        return _from_table(table, json.loads(raw), held)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValidationError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: the plan's metadata is damaged: {_first_line(error)}") from None


def _texts(entries: dict[bytes, bytes]) -> dict[str, str]:
    """Entries of the metadata as text; those that are none are damaged."""
    return {key.decode("latin-1"): value.decode("latin-1") for key, value in entries.items()}


def _from_table(table: pa.Table, meta: dict[str, Any], held: dict[str, str]) -> Plan:
    if not isinstance(meta, dict) or not isinstance(meta.get("schema"), int):
        raise InputError("the plan's metadata names no schema version")
    if meta["schema"] > SCHEMA_VERSION:
        raise InputError(
            f"written by Hognose {meta.get('version', '?')} with plan schema {meta['schema']}; this version reads "
            f"up to {SCHEMA_VERSION}. Update Hognose."
        )
    robot = Robot.from_spec(RobotSpec.model_validate(meta["robot"]))
    if meta["robot_fingerprint"] != robot.fingerprint:
        raise InputError(
            f"the robot in the plan's metadata has the fingerprint {robot.fingerprint}, but the plan was made for "
            f"{meta['robot_fingerprint']}: the file was altered. Plan anew."
        )
    spec = TaskSpec.model_validate(meta["task"])
    # Plans of before there were obstacles from files have no such list.
    said = meta.get("geometry", [None] * len(spec.obstacle))
    task = Task(embedded.restored(spec, said, held), robot)
    n, cables = robot.sections, robot.cables
    joints = [[f"joint_{j:02d}_{x}_m" for x in "xyz"] for j in range(n + 1)]
    angles = [[f"{name}_{i + 1:02d}_rad" for name in ("alpha", "beta")] for i in range(n)]
    plan = Plan(
        task=task,
        way_points=np.array(meta["way_points_m"], dtype=np.float64),
        time=_column(table, "time_s"),
        feed=_column(table, "feed_m"),
        joints=np.stack([_columns(table, names) for names in joints], axis=1),
        angles=np.stack([_columns(table, names) for names in angles], axis=1),
        cable_lengths=_columns(table, [f"cable_{k + 1:02d}_m" for k in range(cables)]),
        motor_counts=_columns(table, [f"motor_{k + 1:02d}_counts" for k in range(cables)], np.int64),
        clearance=_columns(table, [f"clearance_{i + 1:02d}_m" for i in range(n)]),
        checks=_CHECKS.validate_python(meta["checks"]),
        horizon=float(meta["clearance_horizon_m"]),
    )
    if len(plan.time) < 2:
        raise InputError(f"the plan has {len(plan.time)} rows; a motion needs at least two")
    if not (np.diff(plan.time) > 0).all():
        raise InputError("time_s does not rise from step to step")
    task.path_through(plan.way_points)  # so that way-points without a path are refused here
    return plan


def _columns(table: pa.Table, names: list[str], dtype: Any = np.float64) -> NDArray[Any]:
    return np.ascontiguousarray(np.stack([_column(table, name, dtype) for name in names], axis=1))


def _column(table: pa.Table, name: str, dtype: Any = np.float64) -> NDArray[Any]:
    if name not in table.column_names:
        raise InputError(f"column {name!r} is missing; the plan's robot needs it")
    column = table.column(name)
    if column.null_count:
        raise InputError(f"column {name!r} has {column.null_count} empty cells")
    values = column.to_numpy()
    if values.dtype != dtype:
        raise InputError(f"column {name!r} holds {values.dtype}, expected {np.dtype(dtype)}")
    if not np.isfinite(values).all():
        raise InputError(f"column {name!r} has values that are not finite")
    if dtype == np.float64 and np.abs(values).max(initial=0.0) > _LARGEST_VALUE:
        raise InputError(f"column {name!r} holds {np.abs(values).max():g}, more than any plan can")
    return values


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
