"""Tampering with a plan file: whatever would move a motor otherwise is noticed by every command that hands a plan on.

Every kind is tried twice: with the digests as they were, and by a forger who makes new ones. All commands verify in one
place, so each kind is seen by one of them, in turn.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from plan_file_makers import at, rewritten
from tamperings import ALL, COLUMNS, METADATA, OTHERS, robot_said

import hognose
from hognose.cli import main
from hognose.planning import Task, TaskSpec
from hognose.planning.origin import differences
from hognose.robot import Robot, RobotSpec

pytestmark = pytest.mark.slow  # runs commands

TASK = """
schema = 1
name = "block"
units = "mm"
robot = "sjtu-25dof"
margin = 5.0
[path]
detour = false
way_points = [[0, 0, 0], [30, 95, 430], [-60, -50, 1008.5]]
[motion]
step = 160.0
period_s = 15.0
[[obstacle]]
kind = "mesh"
file = "block.stl"
units = "m"
position = [95, 95, 430]
[[obstacle]]
kind = "board"
center = [0, 0, 1070]
size = [600, 600]
thickness = 10
[[obstacle]]
kind = "sphere"
center = [-90, 95, 430]
diameter = 150
"""


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    """A folder with a task that has a block from a file beside the arm's way, and its plan of eight rows."""
    folder = tmp_path_factory.mktemp("tampered")
    trimesh.creation.box((0.05, 0.05, 0.05)).export(folder / "block.stl")
    (folder / "task.toml").write_text(TASK)
    plan = hognose.plan(hognose.load_task(folder / "task.toml"))
    assert len(plan.time) == 8
    assert (plan.clearance[-1] < plan.horizon).sum() > 2
    plan.save(folder / "plan.parquet")
    return folder


@pytest.fixture
def run(capfd, monkeypatch, tmp_path) -> Callable[..., tuple[int, str]]:
    """Run a command without drawing figures; its code and all that it said."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.setattr("hognose.report.report._figures", lambda *_: [])

    def command(*tokens: str | Path) -> tuple[int, str]:
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            main([str(token) for token in tokens])
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        assert isinstance(ended.value.code, int)
        return ended.value.code, out + err

    return command


COMMANDS = {
    "check": ("check", "p.parquet"),
    "report": ("report", "p.parquet", "--no-animation"),
    "csv": ("export", "p.parquet", "-o", "o.csv"),
    "json": ("export", "p.parquet", "-o", "o.json"),
    "parquet": ("export", "p.parquet", "-o", "o.parquet"),
}


def in_turn(name: str) -> str:
    """The command that sees a kind of tampering."""
    return [*COMMANDS][list(ALL).index(name) % len(COMMANDS)]


def test_there_are_70_kinds_and_more():
    assert len({key.split(": ")[1] for key in COLUMNS}) + len(OTHERS) + len(METADATA) >= 90


def test_the_plan_itself_passes_everywhere(run, source, tmp_path):
    (tmp_path / "p.parquet").write_bytes(rewritten(source / "plan.parquet"))
    for command in COMMANDS.values():
        assert run(*command)[0] == 0
    assert run("check", "p.parquet", "--task", source / "task.toml")[0] == 0


@pytest.mark.parametrize("name", list(ALL))
def test_it_is_noticed(run, source, tmp_path, name):
    """A forger, who makes new digests, is found out by what the columns and the metadata say."""
    tampering = ALL[name]
    (tmp_path / "p.parquet").write_bytes(
        rewritten(source / "plan.parquet", tampering.table, tampering.meta, change_entries=tampering.entries)
    )
    which = in_turn(name)
    code, said = run(*COMMANDS[which])
    assert code in (1, 2), which
    assert re.search(tampering.named, said), (which, said)
    # What was written says that it is no good; what was refused left nothing.
    assert len(list(tmp_path.iterdir())) == (2 if code == 1 and which != "check" else 1)
    if (tmp_path / "p.html").exists():
        assert "Not good." in (tmp_path / "p.html").read_text("utf-8")
    if (tmp_path / "o.json").exists():
        assert json.loads((tmp_path / "o.json").read_text())["hognose"]["good"] is False
    if (tmp_path / "o.parquet").exists():
        assert not hognose.Plan.load(tmp_path / "o.parquet").good


@pytest.mark.parametrize("command", ["check", "export", "report"])
def test_machines_are_told_too(run, source, tmp_path, command):
    tampering = ALL["motor_36_counts: a little more"]
    (tmp_path / "p.parquet").write_bytes(rewritten(source / "plan.parquet", tampering.table))
    more = {"check": (), "export": ("-o", "o.csv"), "report": ("--no-animation",)}[command]
    code, said = run(command, "p.parquet", *more, "--json")
    assert code == 1
    assert json.loads(said)["good"] is False


@pytest.mark.parametrize("name", [name for name, tampering in ALL.items() if tampering.table or tampering.meta])
def test_whoever_makes_no_new_digests_is_refused(run, source, tmp_path, name):
    tampering = ALL[name]
    (tmp_path / "p.parquet").write_bytes(
        rewritten(source / "plan.parquet", tampering.table, tampering.meta, sealed=False)
    )
    code, said = run(*COMMANDS[in_turn(name)])
    assert code == 2
    assert re.search(r"altered|column '|metadata|schema", said)
    assert [file.name for file in tmp_path.iterdir()] == ["p.parquet"]


#: What agrees with itself when the digests are new, and moves no motor otherwise or is a plan of its own: only the
#: source shows it.
CONSISTENT = {
    "margin lowered": (at("task.margin", 0.001), r"task\.margin: 0\.001 against 0\.005"),
    "bend limits loosened": (
        robot_said(lambda r: r["section"][0].update(bend_limit_deg=80.0)),
        r"bend_limit_deg: 80\.0",
    ),
    "speed loosened": (robot_said(lambda r: r["limits"].update(joint_speed_deg_s=70.0)), r"joint_speed_deg_s: 70\.0"),
    "tip tolerance": (at("task.motion.tip_tolerance", 0.001), r"tip_tolerance: 0\.001 against None"),
    "name": (at("task.name", "another"), "task.name: 'another' against 'block'"),
    "obstacle's name": (at("task.obstacle.1.name", "door"), "'door'"),
    "way-point on the path": (lambda said: _with_way_point(said), r"way_points: 4 against 3"),
    "a far obstacle more": (lambda said: _with_ball(said), r"obstacle: 4 against 3"),
}


def _with_way_point(said: Any) -> Any:
    """The entrance's neighbour: the run's end, where the spline is straight."""
    robot = Robot.from_spec(RobotSpec.model_validate(said["robot"]))
    path = Task(TaskSpec.model_validate(said["task"] | {"obstacle": []}), robot).path_through(
        np.array(said["way_points_m"])
    )
    between = path.point(robot.length + 0.2).tolist()
    said["task"]["path"]["way_points"].insert(1, between)
    return said


def _with_ball(said: Any) -> Any:
    said["task"]["obstacle"].append({"kind": "sphere", "name": "far", "center": [2.0, 0.0, 0.0], "diameter": 0.1})
    said["geometry"].append(None)
    return said


@pytest.mark.parametrize("name", list(CONSISTENT))
def test_what_agrees_with_itself_is_shown_by_the_source_only(run, source, tmp_path, name):
    change, named = CONSISTENT[name]
    (tmp_path / "p.parquet").write_bytes(rewritten(source / "plan.parquet", change_meta=change))
    assert run("check", "p.parquet")[0] == 0
    code, said = run("check", "p.parquet", "--task", source / "task.toml")
    assert code == 1
    assert re.search(r"FAILED +made for this task", said)
    assert re.search(named, said)
    # And whoever makes no new digests is refused without it.
    (tmp_path / "p.parquet").write_bytes(rewritten(source / "plan.parquet", change_meta=change, sealed=False))
    assert run("check", "p.parquet")[0] == 2


def test_a_task_that_says_the_same_in_other_words_is_the_same(run, source, tmp_path):
    """Comments, units, descriptions and where files lie do not matter."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "b.stl").write_bytes((source / "block.stl").read_bytes())
    text = TASK.replace('"block.stl"', '"parts/b.stl"').replace('name = "block"', 'name = "block" # the same')
    (tmp_path / "other.toml").write_text(text.replace("margin = 5.0", 'margin = 5\ndescription = "new"'))
    plan = hognose.Plan.load(source / "plan.parquet")
    found = differences(plan, hognose.load_task(tmp_path / "other.toml"))
    assert found == []


def test_another_mesh_of_the_same_name_is_another_task(source, tmp_path):
    trimesh.creation.box((0.05, 0.05, 0.0501)).export(tmp_path / "block.stl")
    (tmp_path / "task.toml").write_text(TASK)
    found = differences(hognose.Plan.load(source / "plan.parquet"), hognose.load_task(tmp_path / "task.toml"))
    assert len(found) == 1
    assert found[0].startswith("task.obstacle[1].content: ")


def test_another_robot_is_named_value_by_value(source):
    plan = hognose.Plan.load(source / "plan.parquet")
    found = differences(plan, Task(plan.task.spec, hognose.load_robot("sjtu-25dof-99")))
    assert any(words.startswith("robot.section[1].pitch: 0.091 against ") for words in found)
    assert all(words.startswith("robot.") for words in found)
