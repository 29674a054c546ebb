"""`hognose plan` on a task that gives a target instead of way-points, and the way out again."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest

import hognose

TASK = """
name = "behind the ball"
units = "mm"
robot = "sjtu-25dof"

[path]
target = [0, 40, 700]

[[obstacle]]
kind = "sphere"
name = "ball"
center = [0, 0, 380]
diameter = 120
"""


@pytest.fixture
def task(tmp_path):
    (tmp_path / "behind.toml").write_text(TASK)
    return tmp_path / "behind.toml"


def test_a_target_alone_is_enough_and_the_way_out_is_the_way_in_backwards(run, task, tmp_path):
    done = run("plan", task, "--out-again", "--report", "--json")
    assert (done.code, done.err) == (0, "")
    assert done.json["report_file"] == "behind.html"
    assert "behind the ball" in (tmp_path / "behind.html").read_text()
    assert (done.json["good"], done.json["file"]) == (True, "behind.parquet")
    there, back = hognose.Plan.load(tmp_path / "behind.parquet"), hognose.Plan.load(tmp_path / "behind-out.parquet")
    assert done.json["retraction_file"] == "behind-out.parquet"
    np.testing.assert_allclose(there.body[-1, -1], [0, 0.04, 0.7], rtol=0, atol=1e-6)
    assert there.way_points.shape[0] > 2
    assert there.clearance.min() > 0.005
    assert back.good
    np.testing.assert_array_equal(back.motor_counts, there.motor_counts[::-1])
    # Both files are judged anew from what they hold.
    assert run("check", tmp_path / "behind.parquet").code == 0
    assert run("check", tmp_path / "behind-out.parquet").code == 0


def test_a_search_is_the_same_for_the_same_seed(run, task, tmp_path):
    for name in ("one", "two"):
        assert run("plan", task, "--seed", "3", "-o", tmp_path / f"{name}.parquet").code == 0
    one, two = (hognose.Plan.load(tmp_path / f"{name}.parquet") for name in ("one", "two"))
    np.testing.assert_array_equal(one.angles, two.angles)


WALL = """
[[obstacle]]
kind = "board"
name = "wall"
center = [0, 0, 500]
size = [4000, 4000]
thickness = 10
"""


def test_the_bundled_search_is_comfortably_clear(run):
    done = run("plan", "find-a-way", "--json")
    assert (done.code, done.err) == (0, "")
    assert done.json["good"] is True
    assert done.json["certified_clearance_m"] > 0.015


NO_ROUTE = "behind the ball: there is no route to the target.\n  the target is closed off"


def test_where_no_route_is_it_says_why_and_writes_how_far_the_arm_gets(run, task, tmp_path):
    task.write_text(TASK + WALL)
    done = run("plan", task, "--json")
    assert (done.code, done.err) == (1, "")
    part = hognose.Plan.load(tmp_path / "behind.parquet")
    assert part.good
    assert 0.1 < part.body[-1, -1, 2] < 0.495
    assert done.json["error"].startswith(NO_ROUTE)
    assert "'wall' is in the way" in done.json["error"]
    assert (done.json["good"], done.json["file"]) == (False, "behind.parquet")


def test_an_insertion_that_ends_early_is_never_passed_off_as_the_motion(run, task, tmp_path):
    task.write_text(TASK.replace("[path]", "[report]\ntimes_s = [0, 46]\n\n[path]") + WALL)
    done = run("plan", task, "--report")
    assert (done.code, done.err) == (1, "")
    assert done.out.startswith(NO_ROUTE)
    assert "'wall' is in the way" in done.out
    assert "\nwritten to behind.parquet so that it can be looked at\nreport: behind.html\n" in done.out
    assert "GOOD" not in done.out
    done = run("export", task, "-o", tmp_path / "motion.csv")
    assert done.code == 1
    assert "there is no route to the target" in done.err
    assert not (tmp_path / "motion.csv").exists()


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_while_it_finds_out_why_keeps_what_is_known(run, task, tmp_path, monkeypatch, as_json):
    def interrupt(stage):
        if stage.startswith("trying"):
            raise KeyboardInterrupt

    hole = "[[obstacle.hole]]\ncenter = [0, 90]\ndiameter = 30\n"
    task.write_text(TASK + WALL + hole)
    monkeypatch.setattr("hognose.cli.console.stages", lambda title, quiet: nullcontext(interrupt))
    done = run("plan", task, *(["--json"] if as_json else []))
    assert done.code == 130
    said = done.json["error"] if as_json else done.err
    assert (done.out == "") != as_json
    assert "behind the ball: there is no route to the target" in said
    assert "beside 'wall'" in said
    assert "\n  interrupted before all was tried" in said
    written = "written to behind.parquet so that it can be looked at" in said
    assert written == (tmp_path / "behind.parquet").exists()
    assert not written or hognose.Plan.load(tmp_path / "behind.parquet").good


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--time", "0"], "time"), (["--time", "-1"], "time"), (["--time", "nan"], "time"), (["--seed", "-1"], "seed")],
)
def test_wrong_values_are_named(run, task, tmp_path, arguments, words):
    done = run("plan", task, *arguments)
    assert done.code == 2
    assert done.err.startswith("hognose: ")
    assert words in done.err
    assert not list(tmp_path.glob("*.parquet"))


def test_way_points_and_a_target_together_are_refused(run, task):
    task.write_text(TASK.replace("target =", "way_points = [[0, 0, 0], [0, 0, 500]]\ntarget ="))
    done = run("plan", task)
    assert done.code == 2
    assert "not both" in done.err
