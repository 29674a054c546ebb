"""The plan file: every bit comes back, any program can read it, and it is enough to check the plan."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from planning_makers import failed, variant, with_cell

import hognose
from hognose.planning import Plan, run_checks
from hognose.planning.checks.check import to_json
from hognose.planning.columns import cells_of

COLUMNS = ("way_points", "time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")
names = pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank", "detour"])


@pytest.fixture(scope="module")
def files(plans, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plans")
    for name, plan in plans.items():
        plan.save(folder / f"{name}.parquet")
    return folder


def our_columns(plan: Plan) -> list[str]:
    """As design.md says. More may be added."""
    n, c = plan.robot.sections, plan.robot.cables
    return [
        "time_s",
        "feed_m",
        *(f"joint_{j:02d}_{axis}_m" for j in range(n + 1) for axis in "xyz"),
        *(f"alpha_{i:02d}_rad" for i in range(1, n + 1)),
        *(f"beta_{i:02d}_rad" for i in range(1, n + 1)),
        *(f"cable_{k:02d}_m" for k in range(1, c + 1)),
        *(f"motor_{k:02d}_counts" for k in range(1, c + 1)),
        *(f"clearance_{i:02d}_m" for i in range(1, n + 1)),
        *(f"deviation_{i:02d}_m" for i in range(1, n + 1)),
    ]


def assert_same_bits(one: np.ndarray, other: np.ndarray) -> None:
    assert one.dtype == other.dtype
    assert one.shape == other.shape
    assert np.ascontiguousarray(one).tobytes() == np.ascontiguousarray(other).tobytes()


@names
def test_every_column_comes_back_bit_for_bit(plans, files, name):
    plan, read = plans[name], hognose.Plan.load(files / f"{name}.parquet")
    for column in COLUMNS:
        assert_same_bits(getattr(read, column), getattr(plan, column))
    assert read.checks == plan.checks
    assert read.horizon == plan.horizon


@names
def test_robot_and_task_come_back_whole(plans, files, name):
    plan, read = plans[name], hognose.Plan.load(str(files / f"{name}.parquet"))
    assert read.task.spec == plan.task.spec
    assert read.robot.spec == plan.robot.spec
    assert read.robot.fingerprint == plan.robot.fingerprint
    assert_same_bits(read.scene.triangles, plan.scene.triangles)
    assert_same_bits(read.body, plan.body)


@pytest.mark.parametrize("oddity", [5e-324, -0.0, np.nextafter(1.0, 2), 999999.9999999999, -2.2250738585072014e-308])
def test_no_number_is_too_odd_to_come_back(boards, tmp_path, oddity):
    clearance, counts = boards.clearance.copy(), boards.motor_counts.copy()
    clearance[7, 3], counts[7, 3], counts[8, 3] = oddity, 2**63 - 1, -(2**63)
    odd = dataclasses.replace(boards, clearance=clearance, motor_counts=counts)
    odd.save(tmp_path / "odd.parquet")
    read = hognose.Plan.load(tmp_path / "odd.parquet")
    assert_same_bits(read.clearance, clearance)
    assert_same_bits(read.motor_counts, counts)


@names
def test_columns_are_those_of_the_design(plans, files, name):
    plan = plans[name]
    table = pq.read_table(files / f"{name}.parquet")
    assert table.column_names == list(cells_of(plan))
    ours = our_columns(plan)
    assert [name for name in table.column_names if name in ours] == ours
    assert table.num_rows == len(plan.time)
    for column in table.schema:
        if column.name in ours:
            assert str(column.type) == ("int64" if column.name.startswith("motor_") else "double")
        assert table.column(column.name).null_count == 0


def test_pandas_reads_it_with_no_help_from_us(boards, files):
    frame = pd.read_parquet(files / "obstacle-array.parquet")
    assert list(frame.columns) == pq.read_schema(files / "obstacle-array.parquet").names
    np.testing.assert_array_equal(frame["feed_m"], boards.feed)
    np.testing.assert_array_equal(frame["joint_12_z_m"], boards.joints[:, 12, 2])
    np.testing.assert_array_equal(frame["joint_00_x_m"], boards.joints[:, 0, 0])
    np.testing.assert_array_equal(frame["alpha_03_rad"], boards.angles[:, 2, 0])
    np.testing.assert_array_equal(frame["beta_12_rad"], boards.angles[:, 11, 1])
    np.testing.assert_array_equal(frame["cable_36_m"], boards.cable_lengths[:, 35])
    np.testing.assert_array_equal(frame["motor_01_counts"], boards.motor_counts[:, 0])
    np.testing.assert_array_equal(frame["clearance_05_m"], boards.clearance[:, 4])


def test_the_metadata_is_one_json_object_that_says_it_all(boards, files):
    metadata = pq.read_schema(files / "obstacle-array.parquet").metadata
    said = json.loads(metadata[b"hognose"])
    assert said["schema"] == 2
    assert said["version"] == hognose.__version__
    assert said["good"] is True
    assert said["rows"] == len(boards.time)
    assert said["retracts"] is False
    assert said["robot"]["name"] == "sjtu-25dof"
    assert said["robot"]["section"][0]["pitch"] == boards.robot.link_lengths[0]
    assert said["robot_fingerprint"] == boards.robot.fingerprint
    assert said["task"]["path"]["way_points"] == boards.task.way_points.tolist()
    assert said["checks"] == [to_json(check) for check in boards.checks]


CHECK_ALONE = """
import dataclasses, sys, hognose
from hognose.planning import run_checks
plan = hognose.Plan.load(sys.argv[1])
assert run_checks(dataclasses.replace(plan, checks=())) == plan.checks
assert plan.good
"""


def test_a_plan_can_be_checked_from_the_file_alone(files, tmp_path):
    """In another process, in an empty folder."""
    copy = tmp_path / "alone.parquet"
    copy.write_bytes((files / "detour.parquet").read_bytes())
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", CHECK_ALONE, copy.name],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


def test_a_plan_of_a_robot_file_needs_no_robot_file(tasks, tmp_path):
    plan = hognose.plan(variant(tasks["pipe-tank"], {"robot": "gone/my-arm.toml"}, {"name": "my arm"}))
    plan.save(tmp_path / "own.parquet")
    read = hognose.Plan.load(tmp_path / "own.parquet")
    assert read.robot.name == "my arm"
    assert run_checks(read) == plan.checks


def test_a_plan_that_is_no_good_is_kept_as_such(tasks, tmp_path):
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(variant(tasks["pipe-tank"], robot={"limits.joint_speed_deg_s": 1.0}))
    caught.value.plan.save(tmp_path / "bad.parquet")
    read = hognose.Plan.load(tmp_path / "bad.parquet")
    assert not read.good
    assert read.checks == caught.value.plan.checks
    assert json.loads(pq.read_schema(tmp_path / "bad.parquet").metadata[b"hognose"])["good"] is False


def test_an_unchecked_plan_is_verified_when_it_is_written(boards, files, tmp_path):
    dataclasses.replace(boards, checks=()).save(tmp_path / "unchecked.parquet")
    assert (tmp_path / "unchecked.parquet").read_bytes() == (files / "obstacle-array.parquet").read_bytes()


def test_a_verdict_that_is_not_so_is_neither_written_nor_read(boards, tmp_path):
    """A plan whose angles were changed in Python still carries the verdict of the one it was made from."""
    liar = with_cell(boards, "angles", (200, 3, 0), 1e-3)
    assert liar.good
    liar.save(tmp_path / "liar.parquet")
    said = json.loads(pq.read_schema(tmp_path / "liar.parquet").metadata[b"hognose"])
    assert said["good"] is False
    wrong = {check["key"] for check in said["checks"] if not check["ok"]}
    assert wrong == failed(liar.verified().checks) == failed(hognose.Plan.load(tmp_path / "liar.parquet").checks)


def test_saving_twice_gives_the_same_bytes(boards, files, tmp_path):
    boards.save(tmp_path / "again.parquet")
    assert (tmp_path / "again.parquet").read_bytes() == (files / "obstacle-array.parquet").read_bytes()


def test_saving_what_was_loaded_gives_the_same_bytes(files, tmp_path):
    for file in files.iterdir():
        hognose.Plan.load(file).save(tmp_path / file.name)
        assert (tmp_path / file.name).read_bytes() == file.read_bytes()
