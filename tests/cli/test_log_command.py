"""`hognose log`: a record in words, as JSON and as a figure, also if it was cut off."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest

import hognose
from hognose.drive.record import CycleRow, RecordWriter, read_record


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("pipe-tank"))


@pytest.fixture(scope="module")
def record(plan, tmp_path_factory):
    """Of a run of nine steps that a fault ends."""
    file, cables = tmp_path_factory.mktemp("log") / "run.mcap", plan.robot.cables
    with RecordWriter(file, plan, {"name": "bench"}, datetime(2026, 11, 27, 14, tzinfo=UTC)) as writer:
        for step in range(10):
            errors = np.zeros(cables)
            errors[4] = -11.0 * step
            counts, feed = plan.motor_counts[step], float(plan.feed[step])
            writer.cycle(
                CycleRow(
                    0.15 * step, "RUN", float(step), counts, counts, np.full(cables, 40.0 + step),
                    np.full(cables, 0.5), errors, np.full(cables, 0x1637, np.uint16), feed, feed, 1e-4 * step,
                )
            )  # fmt: skip
        writer.event(1.4, "fault", "node 5: following error, 0x8611", node=5, step=9.0)
        writer.close("stopped at step 9 by a fault of node 5")
    return file


def test_it_says_what_happened(run, record):
    done = run("log", record)
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert lines[0] == f"{record}: pipe tank, sjtu-25dof, 2026-11-27 14:00:00 UTC"
    rows = {line.split("  ")[0]: line for line in lines if "  " in line}
    assert rows["duration"].split() == ["duration", "1.40", "s", "10", "cycles"]
    assert "99 counts" in rows["largest following error"]
    assert "cable 5 at 1.35 s, step 9.0" in rows["largest following error"]
    assert "49 N" in rows["largest tension"]
    assert "1 fault" in rows["events"]
    assert "      1.400 s  fault, node 5, step 9.0: node 5: following error, 0x8611" in lines
    assert any(line.startswith("plan: commands at 10 of 10 steps, 0 to 9, are exactly the plan's") for line in lines)
    assert lines[-1] == "verdict: stopped at step 9 by a fault of node 5"


def test_json_says_the_same(run, record):
    said = run("log", record, "--json").json
    assert said["verdict"] == "stopped at step 9 by a fault of node 5"
    assert (said["cycles"], said["finished"], said["lost_bytes"], said["altered"]) == (10, True, 0, False)
    worst = {"value": 99.0, "cable": 5, "time_s": pytest.approx(1.35), "step": 9.0}
    assert said["largest_following_error_counts"] == worst
    assert said["lateness_s"]["largest"] == pytest.approx(9e-4)
    assert said["plan"]["follows_plan"] is said["plan"]["same_plan"] is True
    fault = {"time_s": 1.4, "kind": "fault", "text": "node 5: following error, 0x8611", "node": 5, "step": 9.0}
    assert said["events"][0] == fault
    assert said["remarks"] == []


def test_a_cut_record_is_read_and_recovered(run, record, tmp_path):
    data = record.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) - 9000])
    done = run("log", "cut.mcap", "--recover", "whole.mcap")
    assert (done.code, done.err) == (0, "")
    assert "note: the record was not closed" in done.out
    assert "bytes behind the last whole message are lost" in done.out
    assert "verdict: none, as the program that ran the plan did not end it" in done.out
    assert done.out.splitlines()[-1] == "whole.mcap: recovered"
    cut, whole = read_record(tmp_path / "cut.mcap"), read_record(tmp_path / "whole.mcap")
    assert 0 < len(cut.cycles) < 10
    assert len(whole.cycles) == len(cut.cycles)
    assert (cut.finished, whole.finished) == (False, True)
    assert run("log", "whole.mcap", "--json").json["cycles"] == len(cut.cycles)


def test_it_draws_a_figure(run, record, tmp_path):
    for suffix, begin in ((".png", b"\x89PNG"), (".svg", b"<?xml")):
        done = run("log", record, "--figure", f"run{suffix}", "--json")
        assert done.json["figure"] == f"run{suffix}"
        assert (tmp_path / f"run{suffix}").read_bytes().startswith(begin)


def test_it_compares_with_another_plan(run, record, plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    assert run("log", record, "--plan", "plan.parquet", "--json").json["plan"]["same_plan"] is True
    hognose.plan(hognose.load_task("obstacle-array")).save(tmp_path / "other.parquet")
    done = run("log", record, "--plan", "other.parquet")
    assert done.code == 0
    assert "note: the plan it is compared with is not the one that was run" in done.out


@pytest.mark.parametrize(
    ("tokens", "reason"),
    [
        (("none.mcap",), "none.mcap: no such file"),
        (("text.mcap",), "text.mcap: not a record of a run"),
        (("RECORD", "--figure", "run.pdf"), "run.pdf: the name of this file must end in .png or .svg"),
        (("RECORD", "--recover", "run.parquet"), "run.parquet: the name of this file must end in .mcap"),
        (("RECORD", "--recover", "RECORD"), "would replace what it is made from"),
        (("RECORD", "--figure", "no/run.png"), "there is no folder no"),
        (("RECORD", "--plan", "none.parquet"), "none.parquet: no such file"),
    ],
)
def test_wrong_files_are_named(run, record, tmp_path, tokens, reason):
    (tmp_path / "text.mcap").write_text("not a record")
    before = record.read_bytes()
    done = run("log", *(record if token == "RECORD" else token for token in tokens))
    assert (done.code, done.out) == (2, "")
    assert reason in done.err
    assert record.read_bytes() == before
