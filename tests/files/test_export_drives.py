"""Plans for motor controllers: bags of ROS 2 are read by rosbags, CSVs by the standard library."""

from __future__ import annotations

import csv
import io
import sys
import zipfile
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

import hognose
from hognose.errors import InputError, MissingExtraError
from hognose.files.exports import export
from hognose.files.exports.ros2 import ARM, MOTORS
from hognose.planning import retraction as retraction_of


@pytest.fixture(scope="module", params=["pipe-tank", "drum", "carrier"])
def plan(request) -> hognose.Plan:
    return hognose.plan(hognose.load_task(request.param))


@pytest.fixture(scope="module")
def retraction() -> hognose.Plan:
    return retraction_of(hognose.plan(hognose.load_task("pipe-tank")))


def bag_of(plan, folder):
    """Times, names and positions of both trajectories."""
    export(plan, folder / "plan.mcap")
    found = {}
    with AnyReader([folder / "plan.mcap"]) as bag:
        for connection, stamp, raw in bag.messages():
            message: Any = bag.deserialize(raw, connection.msgtype)
            assert (stamp, message.header.stamp.sec, message.header.stamp.nanosec) == (0, 0, 0)
            times = [each.time_from_start.sec * 10**9 + each.time_from_start.nanosec for each in message.points]
            for each in message.points:
                assert len(each.velocities) == len(each.accelerations) == len(each.effort) == 0
            positions = np.array([each.positions for each in message.points])
            found[connection.topic] = (connection.msgtype, message.joint_names, times, positions)
    return found


def tables_of(plan, folder):
    """Headings and cells of each file of the archive."""
    export(plan, folder / "plan.zip")
    found = {}
    with zipfile.ZipFile(folder / "plan.zip") as packed:
        for name in packed.namelist():
            headings, *rows = csv.reader(io.StringIO(packed.read(name).decode()))
            found[name] = headings, list(zip(*rows, strict=True))
    return found


def fed(plan):
    """Name, unit and positions of what feeds the arm; None on a carrier."""
    kind = plan.task.spec.base.kind if plan.task.spec.base is not None else "slider"
    if kind == "drum":
        return "drum", "rad", plan.feed / plan.task.base.radius
    return None if kind == "arm" else ("slider", "m", plan.feed)


def test_a_bag_has_every_step_of_every_motor(plan, tmp_path):
    kind, names, times, positions = bag_of(plan, tmp_path)[MOTORS]
    robot, feeder = plan.robot, fed(plan)
    assert kind == "trajectory_msgs/msg/JointTrajectory"
    cables = [f"cable_{number:02d}" for number in range(1, robot.cables + 1)]
    assert names == cables + ([] if feeder is None else [feeder[0]])
    np.testing.assert_array_equal(times, np.rint(1e9 * plan.time))
    lengths = robot.straight_cable_lengths + positions[:, : robot.cables]
    np.testing.assert_array_equal(robot.motor_counts(lengths), plan.motor_counts)
    if feeder is not None:
        np.testing.assert_array_equal(positions[:, -1], feeder[2])


def test_a_bag_has_the_joints_of_the_urdf(plan, tmp_path):
    _, names, times, positions = bag_of(plan, tmp_path)[ARM]
    export(plan, tmp_path / "plan.urdf")
    urdf = (tmp_path / "plan.urdf").read_text()
    assert all(f'<joint name="{name}"' in urdf for name in names)
    assert len(set(names)) == len(names) == 2 * plan.robot.sections + (fed(plan) is not None)
    by_name = dict(zip(names, positions.T, strict=True))
    for section in range(plan.robot.sections):
        for axis, angle in enumerate(("alpha", "beta")):
            np.testing.assert_array_equal(by_name[f"{angle}_{section + 1:02d}"], plan.angles[:, section, axis])
    assert len(times) == len(plan.time)


def test_there_is_a_table_for_every_axis(plan, tmp_path):
    tables, robot, feeder = tables_of(plan, tmp_path), plan.robot, fed(plan)
    _, (names, units, scales) = tables.pop("axes.csv")
    assert list(tables) == [f"{name}.csv" for name in names]
    assert len(tables) == robot.cables + (feeder is not None)
    np.testing.assert_array_equal(np.array(scales[: robot.cables], float), robot.travel_per_count)
    for axis, ((headings, cells), unit) in enumerate(zip(tables.values(), units, strict=True)):
        assert headings == ["time_s", f"position_{unit}", f"velocity_{unit}_s"]
        time, positions, velocities = (np.array(column, float) for column in cells)
        np.testing.assert_array_equal(time, plan.time)
        if axis < robot.cables:
            assert unit == "counts"
            assert [str(int(cell)) for cell in cells[1]] == list(cells[1])
            np.testing.assert_array_equal(positions, plan.motor_counts[:, axis])
        else:
            assert feeder is not None
            assert (names[axis], unit) == feeder[:2]
            np.testing.assert_array_equal(positions, feeder[2])
        assert velocities[0] == velocities[-1] == 0
        wanted = (positions[2:] - positions[:-2]) / (time[2:] - time[:-2])
        np.testing.assert_allclose(velocities[1:-1], wanted, rtol=1e-12)


def test_of_a_retraction_the_way_back_is_written(retraction, tmp_path):
    _, _, _, positions = bag_of(retraction, tmp_path)[MOTORS]
    assert positions[0, -1] == retraction.feed[0] > positions[-1, -1] == 0
    cells = tables_of(retraction, tmp_path)["cable_07.csv"][1]
    np.testing.assert_array_equal(np.array(cells[1], int), retraction.motor_counts[:, 6])


def test_the_same_plan_makes_the_same_files(retraction, tmp_path):
    for name in ("plan.mcap", "plan.zip"):
        export(retraction, tmp_path / name)
        before = (tmp_path / name).read_bytes()
        export(retraction, tmp_path / name)
        assert (tmp_path / name).read_bytes() == before


def test_what_is_not_in_them_is_said(plan, tmp_path):
    carried = plan.task.base.follows
    for name, words in (("plan.mcap", "positions only"), ("plan.zip", "means of the two steps around")):
        remarks = export(plan, tmp_path / name).remarks
        assert words in remarks[0]
        assert (len(remarks) == 2) == carried
        assert not carried or "the pose of the carrier is not in it" in remarks[1]


def test_a_task_or_a_robot_is_refused(retraction, tmp_path):
    for source in (retraction.task, retraction.robot):
        for suffix in (".mcap", ".zip"):
            with pytest.raises(InputError, match=f"but {suffix} is written of a plan"):
                export(source, tmp_path / f"plan{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_without_rosbags_it_is_named(retraction, tmp_path, monkeypatch):
    for name in [each for each in sys.modules if each.split(".")[0] == "rosbags"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingExtraError, match=r"need the package rosbags.*hognose\[ros\]"):
        export(retraction, tmp_path / "plan.mcap")
    assert list(tmp_path.iterdir()) == []
