"""A record that is cut at any byte is read up to the last whole message, and says what is lost."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from record_makers import assert_same_row, row_at
from rosbags.highlevel import AnyReader

from hognose.drive.record import read_record, recover
from hognose.errors import InputError

CHILD = """
import sys
from pathlib import Path
from hognose.drive.record import RecordWriter
from hognose.planning import plan_file
from hognose.planning.plan import Plan
from record_makers import NETWORK, START, row_at
plan = Plan.of(plan_file.read(sys.argv[1]).motion)
writer = RecordWriter(sys.argv[2], plan, NETWORK, START)
for k in range(10**9):
    writer.cycle(row_at(plan, 0.05 * k, "RUN", (k % 40) / 4, k))
    print(k, flush=True)
"""


@pytest.fixture(scope="module")
def ends(made) -> list[tuple[int, str]]:
    """Where each record ends and what it is, by the package mcap."""
    stream = BytesIO(made.file.read_bytes())
    topics, found = {}, []
    record: Any
    for record in StreamReader(stream).records:
        kind = type(record).__name__
        if kind == "Channel":
            topics[record.id] = record.topic
        found.append((stream.tell(), topics[record.channel_id] if kind == "Message" else kind))
    return found


def cuts(ends, count: int) -> list[int]:
    """Places to cut at: around the end of every record, and drawn ones."""
    beginning = next(end for end, kind in ends if kind == "Message" or kind.startswith("/"))
    last = ends[-1][0] + 8  # behind the footer there are eight bytes more
    around = {end + shift for end, _ in ends for shift in (-1, 0, 1, 9) if beginning <= end + shift <= last}
    return sorted(around | set(np.random.default_rng(1).integers(beginning, last + 1, count).tolist()))


def test_a_cut_at_any_byte_loses_what_is_not_whole_and_nothing_more(made, ends, tmp_path):
    data, file = made.file.read_bytes(), tmp_path / "cut.mcap"
    data_end = next(end for end, kind in ends if kind == "DataEnd")
    for cut in cuts(ends, 60):
        file.write_bytes(data[:cut])
        record = read_record(file)
        whole = [(end, kind) for end, kind in ends if end <= cut]
        kinds = [kind for _, kind in whole]
        assert len(record.cycles) == kinds.count("/state")
        assert len(record.events) == kinds.count("/events")
        assert len(record.images) == kinds.count("/tip_camera")
        assert record.finished == (cut == len(data))
        assert record.lost == (0 if record.finished else cut - max(end for end, _ in whole)), cut
        assert not record.altered
        if len(record.cycles):
            assert_same_row(record.cycles.row(-1), made.rows[len(record.cycles) - 1])
        if cut < data_end:
            assert "the program was killed, or the file was cut" in record.remarks[0]


def test_a_cut_before_the_plan_is_whole_is_said(made, ends, tmp_path):
    data, file = made.file.read_bytes(), tmp_path / "cut.mcap"
    beginning = next(end for end, kind in ends if kind == "Schema")
    network = [end for end, kind in ends if kind == "Attachment"][1]
    assert network < beginning
    for cut in (*range(100), *np.linspace(100, network - 1, 40).astype(int)):
        file.write_bytes(data[:cut])
        with pytest.raises(InputError, match=r"cut before anything was recorded|does not begin as an MCAP file does"):
            read_record(file)
    file.write_bytes(data[:network])
    assert len(read_record(file).cycles) == 0


def test_zeros_behind_a_cut_are_lost_bytes(made, ends, tmp_path):
    """As some file systems leave them when the power fails."""
    data, file = made.file.read_bytes(), tmp_path / "cut.mcap"
    for cut in cuts(ends, 5)[::40]:
        file.write_bytes(data[:cut])
        clean = read_record(file)
        file.write_bytes(data[:cut] + bytes(5000))
        record = read_record(file)
        if not clean.finished and clean.lost == 0:
            assert (len(record.cycles), record.lost) == (len(clean.cycles), 5000)


def test_damage_is_told_or_refused(made, ends, tmp_path):
    data, file = made.file.read_bytes(), tmp_path / "damaged.mcap"
    drawn, refused = np.random.default_rng(2), []
    data_end = next(end for end, kind in ends if kind == "DataEnd")
    for at in drawn.integers(0, data_end - 13, 150).tolist():
        damaged = bytearray(data)
        damaged[at] ^= int(drawn.integers(1, 256))
        file.write_bytes(damaged)
        try:
            record = read_record(file)
        except InputError as error:
            refused.append(str(error))
            continue
        assert record.altered or not record.finished, at
    assert all(words.startswith(f"{file}: ") for words in refused)


def test_a_recovered_record_is_read_by_everybody(made, ends, tmp_path):
    data, file, whole = made.file.read_bytes(), tmp_path / "cut.mcap", tmp_path / "whole.mcap"
    for cut in [cuts(ends, 5)[place] for place in (60, 120, 300, -1)]:
        file.write_bytes(data[:cut])
        count, before = recover(file, whole), read_record(file)
        record = read_record(whole)
        assert (record.finished, record.lost, record.altered) == (True, 0, False)
        assert (record.said, record.network, record.plan_file) == (before.said, before.network, before.plan_file)
        assert (record.events, record.images) == (before.events, before.images)
        assert len(record.cycles) == len(before.cycles)
        for k in range(len(record.cycles)):
            assert_same_row(record.cycles.row(k), made.rows[k])
        with whole.open("rb") as stream:
            found = [(c.topic, m.log_time, m.sequence, m.data) for _, c, m in make_reader(stream).iter_messages()]
        theirs = StreamReader(BytesIO(data[:cut]))
        topics, expected = {}, []
        for each in messages_of(theirs):
            if hasattr(each, "topic"):
                topics[each.id] = each.topic
            else:
                expected.append((topics[each.channel_id], each.log_time, each.sequence, each.data))
        assert sorted(found) == sorted(expected[:count])
        assert len(found) == count
        with AnyReader([whole]) as bag:
            assert sum(1 for _ in bag.messages()) == count


def messages_of(reader) -> Iterator[Any]:
    """Channels and messages until the reader gives up, as it does at the end of a cut file."""
    try:
        for record in reader.records:
            if type(record).__name__ in ("Channel", "Message"):
                yield record
    except Exception:
        return


def test_what_is_no_record_is_refused(tmp_path):
    (tmp_path / "text.mcap").write_text("hello")
    for name, words in (("text.mcap", "does not begin as an MCAP file does"), ("none.mcap", "no such file")):
        with pytest.raises(InputError, match=words):
            read_record(tmp_path / name)
        with pytest.raises(InputError, match=words):
            recover(tmp_path / name, tmp_path / "whole.mcap")


def test_bags_of_others_are_refused(made, tmp_path):
    from mcap.writer import Writer

    with (tmp_path / "other.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()
    with pytest.raises(InputError, match="an MCAP file, but not a record of Hognose"):
        read_record(tmp_path / "other.mcap")
    data = made.file.read_bytes().replace(b"schema\x01\x00\x00\x001", b"schema\x01\x00\x00\x009", 1)
    (tmp_path / "newer.mcap").write_bytes(data)
    with pytest.raises(InputError, match=r"record schema 9; this version reads 1\. Update Hognose"):
        read_record(tmp_path / "newer.mcap")


@pytest.mark.slow
def test_kill_9_loses_no_cycle_whose_call_returned(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    drawn = np.random.default_rng(3)
    for run, until in enumerate(drawn.integers(1, 400, 2).tolist()):
        file = tmp_path / f"run{run}.mcap"
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, "-c", CHILD, str(tmp_path / "plan.parquet"), str(file)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True) as child:
            assert child.stdout is not None
            for line in child.stdout:
                if int(line) >= until:
                    child.send_signal(signal.SIGKILL)
                    break
            said = [until, *map(int, child.stdout.read().split("\n")[:-1])]
        record = read_record(file)
        assert (record.finished, record.verdict) == (False, None)
        assert len(record.cycles) >= said[-1] + 1, "a line is written when the call has returned"
        assert len(record.cycles) <= said[-1] + 2
        for k in {0, len(record.cycles) // 2, len(record.cycles) - 1}:
            assert_same_row(record.cycles.row(k), row_at(plan, 0.05 * k, "RUN", (k % 40) / 4, k))


@pytest.mark.slow
def test_a_file_that_may_not_grow_is_a_fault_and_no_crash(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    limit = """
import json, resource
most = 600_000
resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
"""
    ends = CHILD.replace("    print(k, flush=True)", "    if writer.fault:\n        break") + (
        "writer.close('no record')\nprint(json.dumps([k, writer.fault]))\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    file = tmp_path / "run.mcap"
    command = [sys.executable, "-c", limit + ends, str(tmp_path / "plan.parquet"), str(file)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    cycles, fault = json.loads(done.stdout)
    assert "File too large" in fault
    assert done.stderr == ""
    record = read_record(file)
    assert (len(record.cycles), record.lost, record.finished) == (cycles, 0, False)
    assert Path(file).stat().st_size <= 600_000
