"""Plan files of Hognose 0.1.0: read, completed, judged by the rules of today, and saved as files of today."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from plan_file_makers import at, replaced, rewritten
from planning_makers import assert_same_cells, failed

import hognose
from hognose.files import export
from hognose.planning import Plan, retraction

#: How it was made: tests/data/README.md.
FILE = Path(__file__).parents[1] / "data" / "plan_0_1_0.parquet"


def said(file: Path) -> dict[str, Any]:
    return json.loads(pq.read_schema(file).metadata[b"hognose"])


@pytest.fixture(scope="module")
def plan() -> Plan:
    return Plan.load(FILE)


def changed(tmp_path: Path, *args: Any, **how: Any) -> Path:
    """The file with another table or other metadata, and no digests, as there were none."""
    file = tmp_path / "changed.parquet"
    file.write_bytes(rewritten(FILE, *args, sealed=False, **how))
    return file


def test_the_file_is_what_it_says():
    assert (said(FILE)["schema"], said(FILE)["version"]) == (1, "0.1.0")
    assert b"hognose.sha256" not in pq.read_schema(FILE).metadata
    assert "deviation_01_m" not in pq.read_schema(FILE).names


def test_it_is_read_bit_for_bit_and_verified(plan):
    table = pq.read_table(FILE)
    assert plan.good
    np.testing.assert_array_equal(plan.feed, table["feed_m"].to_numpy())
    np.testing.assert_array_equal(plan.joints[:, 3, 2], table["joint_03_z_m"].to_numpy())
    np.testing.assert_array_equal(plan.angles[:, 1, 0], table["alpha_02_rad"].to_numpy())
    np.testing.assert_array_equal(plan.angles[:, 2, 1], table["beta_03_rad"].to_numpy())
    np.testing.assert_array_equal(plan.motor_counts[:, 8], table["motor_09_counts"].to_numpy())
    assert not plan.retracts
    assert plan.robot.fingerprint == hognose.Robot.from_spec(plan.robot.spec).fingerprint


def test_it_is_the_plan_that_is_made_today(plan):
    """Within what compilers and BLAS leave open."""
    today = hognose.plan(plan.task)
    for name in ("time", "feed", "joints", "angles", "cable_lengths", "clearance"):
        np.testing.assert_allclose(getattr(plan, name), getattr(today, name), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(plan.motor_counts, today.motor_counts)


def test_what_it_lacks_is_said(plan):
    assert plan.remarks == [
        "from a file of Hognose 0.1.0 (schema 1), which has no digests: an alteration of it would not have been "
        "noticed; deviation_NN_m computed anew"
    ]
    assert f"note: {plan.remarks[0]}" in plan.summary()


def test_it_is_saved_as_a_file_of_today(plan, tmp_path):
    plan.save(tmp_path / "today.parquet")
    assert said(tmp_path / "today.parquet")["schema"] == 2
    read = Plan.load(tmp_path / "today.parquet")
    assert_same_cells(read, plan)
    assert read.checks == plan.checks
    assert read.task.spec == plan.task.spec
    altered = rewritten(tmp_path / "today.parquet", replaced("clearance_01_m", lambda v: v + 1e-7), sealed=False)
    (tmp_path / "altered.parquet").write_bytes(altered)
    with pytest.raises(hognose.InputError, match="altered after it was written: column 'clearance_01_m'"):
        Plan.load(tmp_path / "altered.parquet")


def test_what_it_lacks_is_said_of_all_that_is_made_of_it(plan, tmp_path):
    plan.save(tmp_path / "first.parquet")
    again = Plan.load(tmp_path / "first.parquet")
    again.save(tmp_path / "second.parquet")
    assert Plan.load(tmp_path / "second.parquet").notes == again.notes == plan.notes
    export(plan, tmp_path / "plan.json")
    assert json.loads((tmp_path / "plan.json").read_text())["hognose"]["notes"] == list(plan.notes)
    assert retraction(plan).notes == plan.notes


def test_columns_that_0_1_0_did_not_know_either_are_kept(plan, tmp_path):
    file = changed(tmp_path, lambda table: table.append_column("mine", table["motor_01_counts"]))
    read = Plan.load(file)
    assert list(read.extra) == ["mine"]
    assert len(read.remarks) == 2


#: Columns of which a cell is changed, and the checks that say so.
CELLS = {
    "time_s": ("set_points_a_period_apart", 1e-6),
    "feed_m": ("set_points_a_step_apart", 1e-5),
    "joint_02_y_m": ("joints_agree_with_following", 1e-7),
    "alpha_02_rad": ("cables_agree_with_angles", 1e-4),
    "cable_05_m": ("cables_agree_with_angles", 1e-7),
    "motor_05_counts": ("motor_counts_agree_with_cables", 1),
    "clearance_02_m": ("clearance_agrees_with_angles", 1e-7),
}


@pytest.mark.parametrize("name", list(CELLS))
def test_an_altered_cell_fails_a_check(tmp_path, name):
    check, change = CELLS[name]

    def spoilt(values: np.ndarray) -> np.ndarray:
        values[2] += change
        return values

    assert check in failed(Plan.load(changed(tmp_path, replaced(name, spoilt))).checks)


def test_a_rule_of_today_is_not_loosened(tmp_path):
    """0.1.0 did not ask for set-points a step apart."""
    file = changed(tmp_path, lambda table: table.take([0, 1, 3, 4, 5]))
    read = Plan.load(file)
    assert not read.good
    assert {"set_points_a_step_apart", "set_points_a_period_apart"} <= failed(read.checks)
    assert "NOT GOOD" in read.summary()


REFUSED: dict[str, tuple[Any, str]] = {
    "another robot": (at("robot.section.0.pitch", 0.0915), "the robot in the plan's metadata has the fingerprint"),
    "looser limits": (at("robot.limits.joint_speed_deg_s", 70.0), "the robot in the plan's metadata has the fingerp"),
    "another verdict": (at("good", False), "`good` is not what its checks say"),
    "a check that failed": (at("checks.0.ok", False), "`good` is not what its checks say"),
    "no checks": (at("checks", []), "`good` is not what its checks say"),
    "checks of text": (at("checks", "good"), "metadata is damaged"),
    "a key of later files": (at("rows", 6), "plan schema 1 has no key 'rows'"),
    "a key less": (at("clearance_horizon_m", ...), "plan schema 1 has a key 'clearance_horizon_m'"),
    "a task that cannot be": (at("task.motion.step", -1.0), r"0\.1\.0 with plan schema 1, which .*task\.motion\.step"),
    "a task of text": (at("task", "tiny"), "metadata is damaged"),
    "a key of the task more": (at("task.motion.speedup", 2), r"cannot take over: the key 'task\.motion\.speedup'"),
    "a robot of text": (at("robot", "tiny"), "which this version cannot take over: robot"),
}  # fmt: skip


@pytest.mark.parametrize("kind", list(REFUSED))
def test_other_metadata_is_refused(tmp_path, kind):
    change, reason = REFUSED[kind]
    with pytest.raises(hognose.InputError, match=f"{re.escape(str(tmp_path))}.*{reason}"):
        Plan.load(changed(tmp_path, None, change))


def test_the_way_out_is_refused(tmp_path):
    """0.1.0 made insertions only."""

    def turned(table: Any) -> Any:
        back = table.take([5, 4, 3, 2, 1, 0])
        return back.set_column(0, "time_s", table["time_s"])

    with pytest.raises(hognose.InputError, match="says an insertion, but column 'feed_m' is that of a retraction"):
        Plan.load(changed(tmp_path, turned))


def test_digests_beside_an_old_schema_are_refused(tmp_path):
    """Whoever makes a file older does not get round its digests."""
    (tmp_path / "sealed.parquet").write_bytes(rewritten(FILE))
    with pytest.raises(hognose.InputError, match=r"the entry 'hognose\.sha256' of the metadata is unknown"):
        Plan.load(tmp_path / "sealed.parquet")


@pytest.mark.parametrize("name", ["time_s", "joint_03_z_m", "clearance_03_m"])
def test_a_missing_column_is_named(tmp_path, name):
    with pytest.raises(hognose.InputError, match=f"column '{name}' is missing"):
        Plan.load(changed(tmp_path, lambda table: table.drop_columns([name])))


@pytest.mark.parametrize("rows", [0, 1])
def test_no_motion_is_no_plan(tmp_path, rows):
    with pytest.raises(hognose.InputError, match="rows: Input should be greater than or equal to 2"):
        Plan.load(changed(tmp_path, lambda table: table.slice(0, rows)))
