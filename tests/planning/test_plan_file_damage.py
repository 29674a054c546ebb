"""A damaged plan file is refused with a reason, or it is a plan; never anything else."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plan_file_makers import at, replaced, rewritten
from planning_makers import assert_same_cells, failed, outcome, variant

import hognose
from hognose.planning import Plan


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("damaged")


@pytest.fixture(scope="module")
def small(tasks, folder) -> Path:
    """A plan of a few rows, so that most of its bytes are not numbers."""
    hognose.plan(variant(tasks["pipe-tank"], {"motion.step": 0.3, "motion.period_s": 30.0})).save(
        folder / "small.parquet"
    )
    return folder / "small.parquet"


def load(folder: Path, content: bytes) -> Plan | str:
    """The plan, or the reason it was refused."""
    file = folder / "damaged.parquet"
    file.write_bytes(content)
    plan = outcome(lambda: hognose.Plan.load(file))
    if isinstance(plan, Plan):
        assert plan.summary()
        return plan
    assert isinstance(plan, hognose.InputError)
    assert re.match(f"{re.escape(str(file))}: .{{10}}", str(plan))
    return str(plan)


def refused(folder: Path, content: bytes) -> str:
    answer = load(folder, content)
    assert isinstance(answer, str)
    return answer


def test_a_file_cut_anywhere_is_refused(folder, small):
    content = small.read_bytes()
    for length in {*range(0, len(content), 331), 0, 1, 3, 4, 7, 8, 12, len(content) - 1}:
        assert "not a plan file, or one that was cut" in refused(folder, content[:length])


@given(content=st.binary(max_size=200), framed=st.booleans())
@settings(max_examples=60, deadline=None)
def test_garbage_is_refused(folder, content, framed):
    assert "not a plan file" in refused(folder, b"PAR1" + content + b"PAR1" if framed else content)


@pytest.mark.slow
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_any_flipped_bytes_give_a_plan_or_a_reason(folder, small, data):
    content = bytearray(small.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    plan = load(folder, bytes(content))
    if isinstance(plan, Plan):  # what was flipped is nothing of ours
        original = hognose.Plan.load(small)
        assert plan.task.spec == original.task.spec
        assert plan.robot.spec == original.robot.spec
        assert_same_cells(plan, original)


def test_what_is_appended_is_refused(folder, small):
    refused(folder, small.read_bytes() + b"more")


def test_another_program_may_write_it(folder, small):
    plan = load(folder, rewritten(small))
    assert isinstance(plan, Plan)
    assert plan.good
    np.testing.assert_array_equal(plan.joints, hognose.Plan.load(small).joints)
    assert isinstance(load(folder, rewritten(small, sealed=False)), Plan)


def test_a_newer_schema_is_refused_with_the_version_that_wrote_it(folder, small):
    def newer(said: Any) -> Any:
        return {**said, "schema": 3, "version": "7.8.9"}

    reason = refused(folder, rewritten(small, change_meta=newer))
    assert "written by Hognose 7.8.9 with plan schema 3" in reason
    assert "Update Hognose" in reason


def test_a_schema_that_never_was_is_refused_with_what_to_do(folder, small):
    reason = refused(folder, rewritten(small, change_meta=lambda said: {**said, "schema": 0, "version": "0.0.1"}))
    assert "written by Hognose 0.0.1 with plan schema 0; this version reads 1 to 2" in reason
    assert "Plan the task anew" in reason


def test_parquet_without_our_metadata_is_refused(folder):
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table({"time_s": [0.0]}), sink)
    assert "not a plan: it has no 'hognose' metadata" in refused(folder, sink.getvalue().to_pybytes())


COLUMNS = [
    "time_s",
    "feed_m",
    "joint_00_x_m",
    "joint_12_z_m",
    "beta_12_rad",
    "cable_36_m",
    "motor_01_counts",
    "clearance_12_m",
]
columns = pytest.mark.parametrize("name", COLUMNS)


@columns
def test_a_missing_column_is_named(folder, small, name):
    content = rewritten(small, lambda table: table.drop_columns([name]))
    assert f"column {name!r} is missing" in refused(folder, content)


WRONG: dict[str, Any] = {
    "text": lambda rows: pa.array(["1.0"] * rows),
    "booleans": lambda rows: pa.array([True] * rows),
    "lists": lambda rows: pa.array([[1.0]] * rows),
    "single precision": lambda rows: pa.array(np.arange(rows, dtype=np.float32)),
    "small integers": lambda rows: pa.array(np.arange(rows, dtype=np.int32)),
    "unsigned": lambda rows: pa.array(np.arange(rows, dtype=np.uint64)),
    "dates": lambda rows: pa.array(np.arange(rows).astype("datetime64[s]")),
    "nothing": lambda rows: pa.nulls(rows, pa.float64()),
    "half of it nothing": lambda rows: pa.array([None, *np.arange(1.0, rows)]),
}


@pytest.mark.parametrize("kind", list(WRONG))
@columns
def test_a_column_of_the_wrong_type_is_named(folder, small, name, kind):
    wrong = replaced(name, lambda values: WRONG[kind](len(values)))
    assert f"column {name!r}" in refused(folder, rewritten(small, wrong))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", [name for name in COLUMNS if not name.startswith("motor")])
def test_a_number_that_is_not_finite_is_named(folder, small, name, value):
    spoilt = replaced(name, lambda values: np.append(values[:-1], value))
    assert f"column {name!r} has values that are not finite" in refused(folder, rewritten(small, spoilt))


def test_a_column_twice_is_refused(folder, small):
    content = rewritten(small, lambda table: table.append_column("feed_m", table.column("feed_m")))
    assert "column 'feed_m' appears 2 times" in refused(folder, content)


@pytest.mark.parametrize("name", ["motor_37_counts", "Feed_m", "feed_m ", ""])
def test_a_column_that_looks_like_another_is_refused(folder, small, name):
    content = rewritten(small, lambda table: table.append_column(name, table.column("motor_01_counts")))
    assert f"column {name!r} is unknown" in refused(folder, content)


@pytest.mark.parametrize("rows", [0, 1])
def test_a_plan_without_motion_is_refused(folder, small, rows):
    cut = rewritten(small, lambda table: table.slice(0, rows), at("rows", rows))
    assert "rows: Input should be greater than or equal to 2" in refused(folder, cut)
    assert f"rows, but there are {rows}" in refused(folder, rewritten(small, lambda table: table.slice(0, rows)))


@pytest.mark.parametrize("order", [[1, 0], [0, 0]])
def test_time_that_does_not_rise_is_refused(folder, small, order):
    taken = rewritten(small, lambda table: table.take(order), at("rows", 2))
    assert "'time_s' does not rise" in refused(folder, taken)


DAMAGED: dict[str, Any] = {
    "not JSON": lambda said: b"{",
    "not text": lambda said: b"\xff\xfe{}",
    "a list": lambda said: [said],
    "a number": lambda said: 7,
    "nothing": lambda said: None,
    "another robot": at("robot.section.0.pitch", 0.0915),
    "another robot's limits": at("robot.limits.joint_speed_deg_s", 70.0),
    "an empty object": lambda said: {},
    "deep nesting": lambda said: b"[" * 100_000,
    "schema of text": at("schema", "1"),
    "schema missing": at("schema", ...),
    "robot missing": at("robot", ...),
    "robot a list": at("robot", []),
    "task of text": at("task", "obstacle-array"),
    "link without length": at("robot.section.0.pitch", 0.0),
    "unknown key": at("robot.colour", "green"),
    "way-points missing": at("way_points_m", ...),
    "way-points of text": at("way_points_m", "abc"),
    "way-points of objects": at("way_points_m", [{}]),
    "way-points ragged": at("way_points_m", [[0, 0, 0], [1, 1]]),
    "horizon of text": at("clearance_horizon_m", "far"),
    "horizon a list": at("clearance_horizon_m", [1]),
    "checks missing": at("checks", ...),
    "checks a number": at("checks", 3),
    "a check of text": at("checks.0", "ok"),
    "a check short of a key": at("checks.0.value", ...),
    "a check's value of text": at("checks.0.value", "twelve"),
    "a check's verdict of text": at("checks.0.ok", "perhaps"),
    "a check's name a number": at("checks.0.name", 3),
    "way-points flat": at("way_points_m", [0.0, 1.0, 2.0]),
    "no way-points": at("way_points_m", []),
    "way-points not finite": at("way_points_m.0.0", float("nan")),
    "horizon not a number": at("clearance_horizon_m", float("nan")),
    "horizon negative": at("clearance_horizon_m", -1.0),
    "two obstacles of one name": at("task.obstacle.1.name", "pipe 2"),
    "a key twice": lambda said: json.dumps(said).replace('"good": true', '"good": true, "good": true').encode(),
    "a key of the robot twice": lambda said: json.dumps(said).replace('"tool_', '"tool_length": 0.1, "tool_').encode(),
}


@pytest.mark.parametrize("damage", list(DAMAGED))
def test_damaged_metadata_is_refused(folder, small, damage):
    refused(folder, rewritten(small, change_meta=DAMAGED[damage]))


@given(data=st.data())
@settings(max_examples=25, deadline=None)
def test_a_damaged_cell_gives_a_verdict_or_a_reason(folder, small, data):
    """However wild the number that somebody wrote, checking says what is wrong."""
    name = data.draw(st.sampled_from([name for name in COLUMNS if not name.startswith("motor")]))
    value = data.draw(st.sampled_from([1e300, -1e300, 1e160, 1e17, -1e9, 1e-300, 0.0]))

    row = data.draw(st.integers(1, 2))

    def spoilt(table: Any) -> Any:
        column = table.column(name).to_numpy().copy()
        assume(abs(column[row] - value) > 1e-3)
        column[row] = value
        return table.set_column(table.column_names.index(name), name, pa.array(column))

    plan = load(folder, rewritten(small, spoilt))
    assert isinstance(plan, str) or failed(plan.checks)


def test_a_missing_file_says_so(tmp_path):
    with pytest.raises(hognose.InputError, match=r"none\.parquet: no such file"):
        hognose.Plan.load(tmp_path / "none.parquet")


def test_a_folder_says_so(tmp_path):
    with pytest.raises(hognose.InputError, match="is a folder, expected a plan file"):
        hognose.Plan.load(tmp_path)


def test_a_loop_of_links_says_so(tmp_path):
    os.symlink(tmp_path / "loop.parquet", tmp_path / "loop.parquet")
    with pytest.raises(hognose.InputError, match="cannot read: Too many levels"):
        hognose.Plan.load(tmp_path / "loop.parquet")


def test_a_name_with_a_null_byte_says_so(tmp_path):
    with pytest.raises(hognose.InputError):
        hognose.Plan.load(str(tmp_path / "a\0b.parquet"))
