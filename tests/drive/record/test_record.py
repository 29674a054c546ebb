"""What is written is what is read, by us, by the package mcap and by rosbags."""

from __future__ import annotations

import errno
import json
import os
import sys

import numpy as np
import pytest
from mcap.reader import make_reader
from record_makers import NETWORK, START, assert_same_row, row_at, write
from rosbags.highlevel import AnyReader

from hognose.drive.record import Event, Image, RecordWriter, read_record, record_file
from hognose.drive.record.writer import cycle_bytes, motion_digest
from hognose.errors import InputError, MissingExtraError
from hognose.planning import plan_file


def test_every_value_is_read_as_it_was_written(plan, made):
    record = read_record(made.file)
    assert len(record.cycles) == len(made.rows) == 40
    for k, row in enumerate(made.rows):
        assert_same_row(record.cycles.row(k), row)
    assert record.events == (
        Event(1.75, "fault", "cable 7 pulls 31 N more than planned", 7, 6.25),
        Event(1.8, "note", "märchenhaft"),
        Event(made.rows[-1].time, "verdict", "held at step 6.6"),
    )
    assert record.images == (Image(1.5, b"\xff\xd8 not quite a JPEG \xff\xd9"),)
    assert (record.start, record.network, record.verdict) == (START, NETWORK, "held at step 6.6")
    assert (record.finished, record.lost, record.altered, record.remarks) == (True, 0, False, [])
    assert record.counts == {"fault": 1, "note": 1}
    assert record.said["motion_sha256"] == motion_digest(plan)
    assert record.said["robot_fingerprint"] == plan.robot.fingerprint


def test_the_plan_is_inside(plan, made, tmp_path):
    (tmp_path / "plan.parquet").write_bytes(read_record(made.file).plan_file)
    held = plan_file.read(tmp_path / "plan.parquet").motion
    np.testing.assert_array_equal(held.motor_counts, plan.motor_counts)
    assert motion_digest(held) == motion_digest(plan)


def test_the_package_mcap_reads_it(plan, made):
    with made.file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        counts = summary.statistics.channel_message_counts
        by_topic = {channel.topic: counts[number] for number, channel in summary.channels.items()}
        assert by_topic == {"/state": 40, "/commanded": 40, "/measured": 40, "/events": 3, "/tip_camera": 1}
        assert {each.encoding for each in summary.schemas.values()} == {"ros2msg"}
        stamps = [message.log_time for _, _, message in reader.iter_messages(topics=["/state"])]
        assert reader.get_header().profile == "ros2"
        files = {each.name: each.data for each in reader.iter_attachments()}
    zero = round(START.timestamp() * 1e6) * 1000
    assert stamps == [zero + round(1e9 * row.time) for row in made.rows]
    assert json.loads(files["network.json"]) == NETWORK


def test_rosbags_reads_it(plan, made):
    robot = plan.robot
    names = [*(f"cable_{number:02d}" for number in range(1, robot.cables + 1)), "slider"]
    with AnyReader([made.file]) as bag:
        found = {"/commanded": [], "/measured": [], "/state": []}
        for connection, _, raw in bag.messages():
            if connection.topic in found:
                found[connection.topic].append(bag.deserialize(raw, connection.msgtype))
    for row, commanded, measured, state in zip(made.rows, *found.values(), strict=True):
        assert commanded.name == measured.name == names
        np.testing.assert_array_equal(state.commanded, row.commanded)
        for said, counts, slider in (
            (commanded, row.commanded, row.slider_commanded),
            (measured, row.measured, row.slider_measured),
        ):
            lengths = robot.straight_cable_lengths + said.position[:-1]
            np.testing.assert_array_equal(robot.motor_counts(lengths), counts)
            assert said.position[-1] == slider
        assert len(commanded.effort) == len(commanded.velocity) == 0
        np.testing.assert_array_equal(measured.effort, [*row.tensions, np.nan])


def test_a_call_leaves_nothing_in_memory(plan, tmp_path):
    with RecordWriter(tmp_path / "run.mcap", plan, NETWORK, START) as writer:
        assert writer.fault is None
        for k in range(5):
            writer.cycle(row_at(plan, 0.1 * k, "RUN", k / 4, k))
            assert len(read_record(tmp_path / "run.mcap").cycles) == k + 1
            writer.event(0.1 * k, "note", f"the {k}th")
            writer.image(0.1 * k, bytes(100_000))
            record = read_record(tmp_path / "run.mcap")
            assert (len(record.events), len(record.images), record.lost) == (k + 1, k + 1, 0)
    record = read_record(tmp_path / "run.mcap")
    assert (record.finished, record.verdict) == (True, None)


def test_after_it_was_closed_nothing_is_written(plan, tmp_path):
    made = write(plan, tmp_path / "run.mcap", 3)
    with RecordWriter(tmp_path / "other.mcap", plan, NETWORK, START) as writer:
        writer.close("done")
        size = (tmp_path / "other.mcap").stat().st_size
        writer.cycle(made.rows[0])
        writer.event(1.0, "note", "too late")
        writer.image(1.0, b"")
        writer.close("done again")
    assert (tmp_path / "other.mcap").stat().st_size == size
    assert read_record(tmp_path / "other.mcap").verdict == "done"


def test_a_cycle_takes_what_is_foretold(plan, made):
    grown = {after - before for before, after in zip(made.sizes[1:], made.sizes[2:], strict=False)}
    assert len(grown) <= 2  # the state's name is longer or shorter
    assert abs(max(grown) - cycle_bytes(plan.robot.cables)) <= 8  # or the place where it is aligned


def test_what_cannot_be_recorded_is_refused(plan, made, tmp_path):
    with pytest.raises(InputError, match="is there already; records are never written over"):
        RecordWriter(made.file, plan, NETWORK, START)
    with pytest.raises(InputError, match=r"no/run\.mcap: cannot write: No such file"):
        RecordWriter(tmp_path / "no" / "run.mcap", plan, NETWORK, START)
    with RecordWriter(tmp_path / "run.mcap", plan, NETWORK, START) as writer:
        row = made.rows[0]
        with pytest.raises(ValueError, match=r"tensions: expected shape \(36,\), got \(35,\)"):
            writer.cycle(row._replace(tensions=row.tensions[1:]))
    assert len(read_record(tmp_path / "run.mcap").cycles) == 0


def test_without_room_on_the_disk_nothing_is_begun(plan, tmp_path, monkeypatch):
    monkeypatch.setattr(record_file.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": 70_000_000})())
    with pytest.raises(InputError, match=r"may take \d+ MB, but the disk has 70 MB free.*make room"):
        RecordWriter(tmp_path / "run.mcap", plan, NETWORK, START)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("left", [0, 1, 1000, 5000])
def test_a_disk_that_becomes_full_is_no_crash(plan, tmp_path, monkeypatch, left):
    file, whole_write = tmp_path / "run.mcap", os.write
    with RecordWriter(file, plan, NETWORK, START) as writer:
        for k in range(3):
            writer.cycle(row_at(plan, 0.1 * k, "RUN", k / 4, k))
        whole = file.stat().st_size
        room = [left]

        def full(number, data):
            if not room[0]:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            done = whole_write(number, bytes(data)[: room[0]])
            room[0] -= done
            return done

        monkeypatch.setattr(record_file.os, "write", full)
        for k in range(3, 9):
            writer.cycle(row_at(plan, 0.1 * k, "RUN", k / 4, k))
        assert writer.fault is not None
        assert "cannot be written any more: No space left on device" in writer.fault
        kept = 3 if left < 4000 else 4
        assert (file.stat().st_size == whole) == (kept == 3), "what is not whole was cut off"
        writer.close("ended without a record")
    record = read_record(file)
    assert (len(record.cycles), record.lost, record.finished, record.verdict) == (kept, 0, False, None)


def test_a_disk_that_fails_to_sync_is_told(plan, tmp_path, monkeypatch):
    def fails(number):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    writer = RecordWriter(tmp_path / "run.mcap", plan, NETWORK, START)
    monkeypatch.setattr(record_file.os, "fsync", fails)
    writer.close("done")
    assert writer.fault is not None
    assert "Input/output error" in writer.fault


@pytest.mark.parametrize(("package", "of"), [("foxglove", "foxglove-sdk"), ("mcap", "mcap")])
def test_missing_packages_are_named(plan, made, tmp_path, monkeypatch, package, of):
    for name in [each for each in sys.modules if each == package or each.startswith(f"{package}.")]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"need the package {of}.*hognose\[drive\]"):
        RecordWriter(tmp_path / "run.mcap", plan, NETWORK, START) if package == "foxglove" else read_record(made.file)
    assert list(tmp_path.iterdir()) == []
