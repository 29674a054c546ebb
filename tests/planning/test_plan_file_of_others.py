"""Plan files from where more is installed, or from before a robot file had further keys."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from planning_makers import altered, assert_same_cells

import hognose
from hognose.following import METHODS
from hognose.following.exact import Exact
from hognose.planning import Plan, Task, plan_file
from hognose.report.report import write_report
from hognose.robot import RobotSpec


class Elsewhere(Exact):
    """A following method of another package."""

    name = "elsewhere"


@pytest.fixture
def file(tmp_path: Path, boards: Plan, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A plan that was made where the method is installed, by a package."""
    METHODS["elsewhere"] = Elsewhere
    homes = {"elsewhere": "snake-methods"}
    monkeypatch.setattr(plan_file, "home", lambda group, name: homes.get(name, "hognose"))
    try:
        task = Task(altered(boards.task.spec, {"motion.method": "elsewhere"}), boards.robot)
        hognose.plan(task).save(tmp_path / "elsewhere.parquet")
    finally:
        homes.clear()
        del METHODS["elsewhere"]
    return tmp_path / "elsewhere.parquet"


def test_a_plan_of_a_method_that_is_not_installed_is_loaded_and_says_so(file, boards):
    read = Plan.load(file)
    for name in ("time", "feed", "joints", "angles", "clearance"):
        np.testing.assert_array_equal(getattr(read, name), getattr(boards, name))
    assert read.missing_method == "elsewhere"
    assert not read.good
    (check,) = read.checks
    assert (check.key, check.ok) == ("feed_on_path", None)
    why = "feed on path: not judged (nothing can be checked: the task's method 'elsewhere' is not installed)"
    assert check.sentence == why
    assert read.summary().endswith(f"NOT GOOD: nothing was judged\n  {why}")
    (said,) = [words for words in read.remarks if "elsewhere" in words]
    assert "can be shown, but neither checked nor planned anew; install the package snake-methods, or" in said
    assert said in read.summary()


def test_it_is_shown_and_saved_and_good_again_where_the_method_is(file, tmp_path):
    read = Plan.load(file)
    assert read.tip_error.max() < 1e-6
    page, *_ = write_report(read, tmp_path / "page.html", animation=False)
    assert "snake-methods" in page.read_text()
    assert "Nothing was judged. Not judged: feed on path." in page.read_text()
    read.save(tmp_path / "again.parquet")
    again = Plan.load(tmp_path / "again.parquet")
    assert_same_cells(again, read)
    assert again.remarks == read.remarks
    METHODS["elsewhere"] = Elsewhere
    try:
        there = Plan.load(tmp_path / "again.parquet")
        assert there.good
        assert there.remarks == []
    finally:
        del METHODS["elsewhere"]


@pytest.mark.parametrize(
    "command", [["check"], ["check", "--json"], ["export", "-o", "a.csv"], ["export", "-o", "a.csv", "--json"]]
)
def test_commands_end_with_1_and_say_why(file, monkeypatch, capfd, command):
    from hognose.cli import main

    monkeypatch.chdir(file.parent)
    with pytest.raises(SystemExit) as ended:
        main([command[0], str(file), *command[1:]])
    assert ended.value.code == 1
    assert "nothing can be checked: the task's method 'elsewhere' is not installed" in capfd.readouterr().out


def test_it_does_not_lead_back_either(file):
    with pytest.raises(hognose.InfeasibleError, match=r"no good retraction\.\n  feed on path: not judged"):
        hognose.planning.retraction(Plan.load(file))


def test_it_cannot_be_planned_anew(file):
    with pytest.raises(hognose.InputError, match="method 'elsewhere' is unknown"):
        hognose.plan(Plan.load(file).task)


def test_a_task_with_a_method_that_is_not_installed_is_refused_as_ever(boards):
    with pytest.raises(ValueError, match="method 'elsewhere' is unknown"):
        altered(boards.task.spec, {"motion.method": "elsewhere"})


def test_files_say_nothing_of_methods_and_notes_that_need_no_word(boards, tmp_path):
    boards.save(tmp_path / "plan.parquet")
    said = json.loads(pq.read_schema(tmp_path / "plan.parquet").metadata[b"hognose"])
    assert not {"notes", "method_package"} & set(said)


class LaterSpec(RobotSpec):
    """A robot file with a key that a later version brings."""

    weight_compensation: bool = False


class LaterSaid(plan_file.Said):
    """What a plan file says in that version."""

    robot: LaterSpec  # pyright: ignore[reportIncompatibleVariableOverride]


def test_a_file_of_today_is_read_where_robots_have_further_keys(boards, tmp_path, monkeypatch):
    boards.save(tmp_path / "plan.parquet")
    monkeypatch.setattr(plan_file, "Said", LaterSaid)
    read = Plan.load(tmp_path / "plan.parquet")
    assert read.good
    assert isinstance(read.robot.spec, LaterSpec)
    assert read.robot.fingerprint == boards.robot.fingerprint
