"""Every command: what it says, what it writes, and the code it ends with."""

from __future__ import annotations

import csv
import dataclasses
import json
import re

import numpy as np
import pytest

import hognose
import hognose.planning
from hognose.bundled import OWN_ROBOTS
from hognose.cli.exit_codes import GOOD, INTERRUPTED, NOT_FEASIBLE, WRONG_INPUT
from hognose.files import bundled_robots, bundled_tasks
from hognose.following import OF_SECTIONS
from hognose.planning.checks.check import to_json
from hognose.planning.checks.clearance import CERTIFIED

COMMANDS = ["new", "plan", "check", "view", "export", "report", "robot", "methods", "bench", "demo"]


def test_the_codes_are_those_of_the_design():
    assert (GOOD, NOT_FEASIBLE, WRONG_INPUT, INTERRUPTED) == (0, 1, 2, 130)


def test_plan_writes_the_plan_and_says_it_is_good(run, tmp_path):
    done = run("plan", "pipe-tank")
    assert (done.code, done.err) == (0, "")
    plan = hognose.Plan.load(tmp_path / "pipe-tank.parquet")
    assert plan.good
    assert done.out == f"{plan.summary()}\nwritten to pipe-tank.parquet\n"
    assert [file.name for file in tmp_path.iterdir()] == ["pipe-tank.parquet"]


@pytest.mark.parametrize("flag", ["-o", "--output"])
def test_plan_writes_where_it_is_told(run, made, tmp_path, flag):
    (tmp_path / "deep").mkdir()
    assert run("plan", made / "good.toml", flag, tmp_path / "deep" / "mine.parquet").code == 0
    assert hognose.Plan.load(tmp_path / "deep" / "mine.parquet").good
    assert [file.name for file in tmp_path.iterdir()] == ["deep"]


def test_plan_says_its_figures_as_json(run, made, tmp_path):
    done = run("plan", made / "good.toml", "--json")
    assert (done.code, done.err) == (0, "")
    plan = hognose.Plan.load(tmp_path / "good.parquet")
    said = done.json
    checks = said.pop("checks")
    assert checks == [to_json(check) for check in plan.checks]
    proven = min(plan.check(key).value for key in CERTIFIED)
    assert said == {
        "good": True,
        "task": "pipe tank",
        "robot": "sjtu-25dof",
        "robot_fingerprint": plan.robot.fingerprint,
        "base": {"kind": "slider", "direction": [0.0, 0.0, 1.0], "words": "slider along +z"},
        "profile": {"kind": "constant", "period_s": 0.15, "step": 0.0035, "words": "constant: 3.5 mm every 150 ms"},
        "method": "exact",
        "steps": 303,
        "duration_s": plan.time[-1],
        "feed_m": plan.feed[-1],
        "clearance_m": plan.clearance.min(),
        "body_deviation_m": plan.body_deviation.max(),
        "body_deviation_rms_m": pytest.approx(np.sqrt(np.mean(plan.body_deviation**2)), rel=1e-12),
        "clearance_is_lower_bound": False,
        "certified_clearance_m": proven,
        "remarks": [],
        "file": "good.parquet",
    }


@pytest.mark.parametrize("as_json", [False, True])
def test_an_infeasible_task_ends_with_1_and_still_writes_the_plan(run, made, tmp_path, as_json):
    done = run("plan", made / "tight.toml", *(["--json"] if as_json else []))
    assert (done.code, done.err) == (1, "")
    plan = hognose.Plan.load(tmp_path / "tight.parquet")
    assert not plan.good
    wanting = [check.sentence for check in plan.checks if check.failed]
    assert wanting
    if as_json:
        assert done.json["good"] is False
        assert all(sentence in done.json["error"] for sentence in wanting)
    else:
        assert all(sentence in done.out for sentence in wanting)
        assert "NOT GOOD" in done.out
        assert "written to tight.parquet so that it can be looked at" in done.out


def test_a_task_without_any_motion_writes_nothing(run, made, tmp_path):
    done = run("plan", made / "far.toml")
    assert (done.code, done.out) == (1, "")
    assert done.err.startswith("hognose: ")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("method", list(hognose.METHODS))
def test_plan_takes_any_method(run, tmp_path, method):
    assert run("plan", "pipe-tank", "--method", method, "--json").json["method"] == method
    assert hognose.Plan.load(tmp_path / "pipe-tank.parquet").task.spec.motion.method == method


def test_an_unknown_method_says_the_nearest(run, tmp_path):
    done = run("plan", "pipe-tank", "--method", "predicton")
    assert (done.code, done.out) == (2, "")
    assert "'predicton' is unknown; did you mean 'prediction'?" in done.err
    assert not list(tmp_path.iterdir())


def test_check_of_a_good_plan_shows_every_check(run, made):
    done = run("check", made / "good.parquet")
    assert (done.code, done.err) == (0, "")
    plan = hognose.Plan.load(made / "good.parquet")
    rows = done.out.splitlines()[1 : 1 + len(plan.checks)]
    for row, check in zip(rows, plan.checks, strict=True):
        assert re.match(rf"ok +{re.escape(check.name)}  ", row)
        assert f"  {check.comparison}  " in row
    assert done.out.endswith(plan.summary() + "\n")


def test_check_plans_a_task_first(run, made, tmp_path):
    assert run("check", "pipe-tank").code == 0
    done = run("check", made / "tight.toml")
    assert done.code == 1
    assert "FAILED" in done.out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("column", "check"),
    [("cable_lengths", "cables agree with angles"), ("clearance", "clearance agrees with angles")],
)
def test_check_finds_a_tampered_plan_out(run, made, tmp_path, column, check):
    """The plan in hand still says that it is good."""
    plan = hognose.Plan.load(made / "good.parquet")
    values = getattr(plan, column).copy()
    values[100, 5] += 1e-4
    tampered = dataclasses.replace(plan, **{column: values})
    assert tampered.good
    tampered.save(tmp_path / "tampered.parquet")
    assert not hognose.Plan.load(tmp_path / "tampered.parquet").good
    done = run("check", tmp_path / "tampered.parquet")
    assert done.code == 1
    assert re.search(rf"^FAILED +{check}", done.out, re.MULTILINE)
    said = run("check", tmp_path / "tampered.parquet", "--json")
    assert said.code == 1
    assert said.json["good"] is False
    assert [item["name"] for item in said.json["checks"] if item["ok"] is False] == [check]


def test_export_writes_csv_and_json(run, made, tmp_path):
    plan = hognose.Plan.load(made / "good.parquet")
    done = run("export", made / "good.parquet", "-o", "plan.csv", "--json")
    assert done.code == 0
    size = (tmp_path / "plan.csv").stat().st_size
    assert done.json == {"good": True, "file": "plan.csv", "bytes": size, "steps": 303}
    with (tmp_path / "plan.csv").open(newline="") as file:
        feeds = [float(row["feed_m"]) for row in csv.DictReader(file)]
    np.testing.assert_array_equal(feeds, plan.feed)
    assert run("export", made / "good.parquet", "-o", "plan.json").code == 0
    assert json.loads((tmp_path / "plan.json").read_text())["columns"]["feed_m"] == plan.feed.tolist()


def test_export_of_a_plan_that_is_none_says_so(run, made, tmp_path):
    run("plan", made / "tight.toml")
    done = run("export", "tight.parquet", "-o", "tight.csv")
    assert done.code == 1
    assert "NOT a good plan" in done.out
    assert "clearance at steps: " in done.out
    assert (tmp_path / "tight.csv").stat().st_size > 100_000


def test_export_to_an_unknown_format_says_which_there_are(run, made, tmp_path):
    done = run("export", made / "good.parquet", "-o", "plan.xls")
    assert (done.code, done.out) == (2, "")
    assert "unknown format '.xls'; expected .csv, .json, .parquet" in done.err
    assert not list(tmp_path.iterdir())


def test_export_to_a_named_format_takes_its_suffix(run, made, tmp_path):
    assert run("export", made / "good.parquet", "--to", "csv").code == 0
    assert run("export", made / "good.parquet", "-o", "same.csv").code == 0
    assert (tmp_path / "good.csv").read_bytes() == (tmp_path / "same.csv").read_bytes()
    done = run("export", made / "good.parquet", "--to", "mjcf", "--json")
    assert (done.code, done.json["good"], done.json["steps"], done.json["file"]) == (0, True, 303, "good.xml")
    assert '<key name="step_303"' in (tmp_path / "good.xml").read_text()
    for tokens, reason in (
        (("--to", "stl"), "--to: unknown format 'stl'; expected csv, json, parquet, mjcf, urdf, ros2, axes"),
        (("--to", "mjcf", "-o", "model.csv"), "model.csv: the name of this file must end in .xml"),
        ((), "name the file to write with --output, as in -o plan.csv, or its format with --to, as in mjcf"),
    ):
        done = run("export", made / "good.parquet", *tokens)
        assert (done.code, done.out) == (2, "")
        assert reason in done.err


def test_export_of_a_task_or_a_robot_as_a_model_plans_nothing(run, made, tmp_path, monkeypatch):
    monkeypatch.setattr("hognose.cli.console.plan_of", None)
    done = run("export", "moving-obstacles", "--to", "urdf", "--json")
    assert (done.code, done.json["good"], done.json["file"]) == (0, None, "moving-obstacles.urdf")
    assert "steps" not in done.json
    assert sorted(done.json["beside"]) == sorted(f"meshes/{file.name}" for file in (tmp_path / "meshes").iterdir())
    said = "obstacles that move in the task (hatch, wheel) stand here where they are at time 0"
    assert done.json["remarks"][0] == said
    told = run("export", "moving-obstacles", "-o", "model.xml")
    assert told.out.splitlines()[1] == f"note: {said}"
    assert run("export", made / "tight.toml", "--to", "mjcf").code == 0  # a space, whether it can be planned or not
    run("robot", "sjtu-25dof", "--write", "arm.toml")
    for source in ("sjtu-25dof", "arm.toml"):
        assert run("export", source, "--to", "urdf").code == 0
    assert (tmp_path / "arm.urdf").read_bytes() == (tmp_path / "sjtu-25dof.urdf").read_bytes()
    done = run("export", "arm.toml", "-o", "arm.csv")
    assert (done.code, done.out) == (2, "")
    assert "sjtu-25dof: is a robot, but .csv is written of a plan; plan first, or take one of .xml, .urdf" in done.err


def test_robot_lists_the_bundled_ones(run):
    done = run("robot")
    assert (done.code, done.err) == (0, "")
    listed = [line.split()[0] for line in done.out.splitlines()[1:]]
    assert listed == list(bundled_robots())
    assert run("robot", "--json").json == {"robots": list(bundled_robots())}


@pytest.mark.parametrize("name", bundled_robots())
def test_robot_marks_what_is_assumed(run, name):
    robot, done = hognose.load_robot(name), run("robot", name)
    assert (done.code, done.err) == (0, "")
    assert "* marks values that nobody published and that are assumed" in done.out
    rows = {line.split("  ")[0]: line for line in done.out.splitlines() if line}
    assumed = {
        "base length": "base_length", "tool length": "tool_length", "slider travel": "feed", "feed speed": "feed",
        "joint speed": "limits", "cable travel": "limits", "motor counts": "limits",
        "mass of the links": "section.link_mass",
    }  # fmt: skip
    for row, key in assumed.items():
        assert ("*" in rows[row]) == (key in robot.assumed), row
    sections = [line for line in done.out.splitlines() if re.match(r" *\d+  ", line)]
    assert len(sections) == 2 * robot.sections
    bodies = [line.split()[1:] for line in sections[: robot.sections]]
    assert all(("*" in row[0]) == ("section.pitch" in robot.assumed) for row in bodies)
    assert all(("*" in " ".join(row[1:3])) == ("section.half_lengths" in robot.assumed) for row in bodies)
    assert all(("*" in row[3]) == ("section.body_diameter" in robot.assumed) for row in bodies)
    assert all("*" in line for line in sections[robot.sections :])


@pytest.mark.parametrize("name", bundled_robots())
def test_robot_says_its_values_as_json_in_metres(run, name):
    robot, said = hognose.load_robot(name), run("robot", name, "--json").json
    assert said.pop("units") == "m"
    assert said.pop("fingerprint") == robot.fingerprint
    assert said == json.loads(robot.spec.model_dump_json(by_alias=True))


@pytest.mark.parametrize(("assumed", "marked"), [((), ""), (("tolerance.sag",), "sag"), (("tolerance",), "czs")])
def test_robot_says_the_tolerances_that_its_file_gives(run, tmp_path, assumed, marked):
    text = OWN_ROBOTS["sjtu-25dof"].read_text()
    told = "[tolerance]\ncalibration_deg = 0.1\ncable_zero = 0.2\nsag = 1.5\n\n[feed]"
    named = "".join(f'"{key}", ' for key in assumed)
    (tmp_path / "arm.toml").write_text(text.replace("[feed]", told).replace("assumed = [", f"assumed = [{named}"))
    out = run("robot", "arm.toml").out
    for line in ("calibration of a joint, 1σ 0.1 deg", "zero of a cable, 1σ 0.2 mm", "sag left, at most 1.5 mm"):
        name, value, unit = line.rsplit(" ", 2)
        mark = r"\*" if name[0] in marked else ""
        assert re.search(rf"^{name} +{re.escape(value)}{mark} +{unit} *$", out, re.MULTILINE)
    assert "sag" not in run("robot", "sjtu-25dof").out


@pytest.mark.parametrize("name", bundled_robots())
def test_robot_copies_a_bundled_file_as_it_is(run, tmp_path, name):
    done = run("robot", name, "--write", "my arm.toml")
    assert (done.code, done.err) == (0, "")
    assert "written to my arm.toml: a copy of " + name in done.out
    assert "hognose robot 'my arm.toml'" in done.out
    assert 'robot = "my arm.toml"' in done.out
    assert (tmp_path / "my arm.toml").read_bytes() == OWN_ROBOTS[name].read_bytes()
    assert run("robot", "my arm.toml").code == 0
    again = run("robot", name, "--write", "my arm.toml", "--json")
    assert again.code == 2
    assert "is there already and was left as it is" in again.json["error"]
    (tmp_path / "my arm.toml").write_text("")
    assert run("robot", name, "--write", "my arm.toml", "--force", "--json").json == {
        "good": True,
        "file": "my arm.toml",
    }
    assert hognose.load_robot("my arm.toml").fingerprint == hognose.load_robot(name).fingerprint


@pytest.mark.parametrize(
    ("tokens", "reason"),
    [
        (("--write", "a.toml"), "--write: which robot? Name one: hognose robot sjtu-25dof --write a.toml"),
        (("sjtu-25dof", "--write", "a.txt"), "a.txt: the name of a robot file must end in .toml"),
        (("sjtu-25dof", "--write", "none/a.toml"), "there is no folder none; make it first"),
        (("sjtu", "--write", "a.toml"), "no bundled robot of that name"),
        (("arm.toml", "--write", "a.toml"), "arm.toml: is a file, expected a bundled robot: sjtu-25dof"),
    ],
)
def test_a_copy_that_cannot_be_made_is_said(run, tmp_path, tokens, reason):
    (tmp_path / "arm.toml").write_bytes(OWN_ROBOTS["sjtu-25dof"].read_bytes())
    done = run("robot", *tokens)
    assert done.code == 2
    assert reason in done.err
    assert [file.name for file in tmp_path.iterdir()] == ["arm.toml"]


def test_methods_lists_all(run):
    done = run("methods")
    assert done.code == 0
    names = [line.split()[0] for line in done.out.splitlines()]
    assert names == ["method", *hognose.METHODS, "method", *OF_SECTIONS]
    said = run("methods", "--json").json
    assert said["default"] == "exact"
    assert list(said["methods"]) == list(hognose.METHODS)
    assert list(said["of_other_sections"]) == list(OF_SECTIONS)
    assert all(len(text) > 20 for text in said["methods"].values())


@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_names_every_command(run, flag):
    done = run(flag)
    assert done.code == 0
    assert all(command in done.out for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(run, command):
    done = run(command, "--help")
    assert (done.code, done.err) == (0, "")
    assert "--json" in done.out
    assert f"hognose {command}" in done.out


def test_the_version_is_said(run):
    assert run("--version").out.strip() == hognose.__version__


def test_the_message_about_an_unknown_name_lists_every_bundled_task(run):
    done = run("plan", "pipe-tonk")
    assert done.code == 2
    assert all(name in done.err for name in bundled_tasks())
