"""`hognose run`: on emulated drives, with a record; nothing moves without a confirmation."""

import json
import re

import pytest

import hognose


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("run") / "boards.parquet"
    hognose.plan(hognose.load_task("obstacle-array")).save(file)
    return file


def test_a_plan_is_run_there_and_back_and_recorded(run, plan_file, tmp_path):
    record = tmp_path / "there.mcap"
    far = ("--until", "6", "--back", "--yes", "--json")
    done = run("run", plan_file, "--emulated", "--fast", *far, "--record", record)
    assert (done.code, done.err) == (0, "")
    said = json.loads(done.out)
    assert (said["good"], said["step"], said["trouble"], said["record"]) == (True, 0.0, None, str(record))
    assert said["commanded_counts"] == said["measured_counts"]
    log = run("log", record, "--json")
    assert log.code == 0
    assert json.loads(log.out)["verdict"] == "GOOD: at step 0"


def test_what_happens_is_said(run, plan_file, tmp_path):
    done = run(
        "run",
        plan_file,
        "--emulated",
        "--without-twin",
        "--fast",
        "--until",
        "2",
        "--yes",
        "--record",
        tmp_path / "a.mcap",
    )
    assert done.code == 0
    words = [line.split()[0] for line in done.out.splitlines()]
    assert words[:6] == ["ARMED", "HOLD", "TENSION", "READY", "RUN", "HELD"]
    assert done.out.splitlines()[-1] == "GOOD: at step 2"


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        ((), "give either --network FILE, for drives that are there, or --emulated; neither is given"),
        (("--emulated", "--network", "net.toml"), "both are given"),
        (("--network", "net.toml", "--fast"), "--fast goes with --emulated"),
        (("--network", "net.toml"), "net.toml"),
        (("--emulated", "--fast", "--speed", "0"), "rate: expected a share of the plan's speed"),
        (("--emulated", "--fast", "--without-twin"), "moves only after a confirmation at a terminal; give --yes"),
        (("--emulated", "--fast", "--without-twin", "--yes", "--until", "999"), "until: expected a step from 0 to 312"),
    ],
)
def test_wrong_use_is_said(run, plan_file, tmp_path, tokens, said):
    done = run("run", plan_file, "--record", tmp_path / "a.mcap", *tokens)
    assert done.code == 2
    assert said in done.err


def test_a_plan_that_is_not_good_is_not_run(run, tmp_path):
    task = tmp_path / "tight.toml"
    text = hognose.bundled.bundled_tasks()["obstacle-array"].read_text()
    wider = re.sub(r"(?m)^margin = .*$", "margin = 20.0", text)
    task.write_text(wider.replace("[path]\n", "[path]\ndetour = false\n", 1))
    done = run("run", task, "--emulated", "--fast", "--without-twin", "--yes", "--record", tmp_path / "a.mcap")
    assert done.code == 2
    assert "the plan is not good, and is not run" in done.err
    assert not (tmp_path / "a.mcap").exists()
