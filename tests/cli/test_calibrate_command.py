"""`hognose calibrate`: figures, a file, and what it refuses."""

from types import SimpleNamespace
from typing import Any

import pytest

from hognose.calibration import Calibration
from hognose.cli.completers import tasks_and_robots


def test_a_robot_is_calibrated_by_statics(run, tmp_path):
    file = tmp_path / "arm.json"
    done = run("calibrate", "sjtu-25dof", "--statics", "--method", "jig", "-o", file, "--json")
    assert (done.code, done.json["good"], done.json["file"]) == (0, True, str(file))
    assert done.json["readings"] == 2
    assert done.json["tip_error_straight_m"] < 0.3e-3
    found = Calibration.load(file)
    assert found.fit.zeros.tolist() == done.json["zeros_m"]
    assert found.fingerprint == done.json["robot_fingerprint"]
    assert (len(done.json["zeros_sigma_m"]), len(done.json["stiffness_sigma"])) == (36, 12)
    assert len(done.json["calibration_deg"]) == 12


def test_the_twin_of_a_task_is_calibrated(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run("calibrate", "pipe-tank", "--twin", "--method", "jig", "--seed", "3")
    assert done.code == 0
    for words in (
        "calibrated by jig, 2 readings",
        "χ² ",
        "GOOD",
        "[tolerance]\ncalibration_deg = [0.0",
        "cable_zero = 0.0",
    ):
        assert words in done.out
    assert Calibration.load(tmp_path / "pipe-tank-calibration.json").method == "jig"


def test_a_few_poses_are_enough_with_the_tip(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run("calibrate", "obstacle-array", "--statics", "--poses", "3", "--json")
    assert (done.code, done.json["readings"]) == (0, 3)
    assert done.json["tip_error_straight_m"] < 0.5e-3


@pytest.mark.parametrize(
    ("tokens", "code", "reason"),
    [
        (("pipe-tank",), 2, "calibrate: name one of --twin and --statics"),
        (("pipe-tank", "--twin", "--statics"), 2, "calibrate: name one of --twin and --statics"),
        (("pipe-tank", "--statics", "-o", "arm.txt"), 2, "the name of this file must end in .json"),
        (
            ("pipe-tank", "--statics", "--back", "0"),
            1,
            "calibration of pipe tank: before it is calibrated, the arm can",
        ),
        (
            ("pipe-tank", "--statics", "--errors", "0.2", "0", "1"),
            2,
            "accuracy.tip: expected a standard deviation above 0",
        ),
        (("pipe-tank", "--statics", "--seed", "-3"), 2, "seed: expected a whole number from 0 on, got -3"),
        (("pipe-tank", "--statics", "--empty-errors"), 2, "unknown option: --empty-errors"),
        (("pipe-tank", "--statics", "--method", "jig", "--poses", "3"), 2, "in no other pose; leave --poses out"),
        (("sjtu-25dof", "--statics", "--back", "50"), 2, "back: sjtu-25dof is a robot alone; leave --back out"),
        (("pipe-tonk", "--statics"), 2, "did you mean 'pipe-tank'?"),
    ],
)
def test_what_is_refused_says_why(run, tokens, code, reason, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run("calibrate", *tokens)
    assert (done.code, done.out) == (code, "")
    assert reason.lower() in done.err.lower()
    assert list(tmp_path.iterdir()) == []


def test_only_what_is_calibrated_is_offered(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("own.toml", "plan.parquet"):
        (tmp_path / name).touch()
    context: Any = SimpleNamespace(incomplete="")
    offered = tasks_and_robots(context)
    assert {"pipe-tank", "sjtu-25dof", "own.toml"} <= set(offered)
    assert "plan.parquet" not in offered
