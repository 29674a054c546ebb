"""`hognose plan` on a task that gives a target instead of way-points, and the way out again."""

from __future__ import annotations

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
    done = run("plan", task, "--out-again", "--json")
    assert (done.code, done.err) == (0, "")
    assert (done.json["good"], done.json["file"]) == (True, "behind.parquet")
    there, back = hognose.Plan.load(tmp_path / "behind.parquet"), hognose.Plan.load(tmp_path / "behind-out.parquet")
    assert done.json["retraction_file"] == "behind-out.parquet"
    np.testing.assert_allclose(there.body[-1, -1], [0, 0.04, 0.7], rtol=0, atol=1e-6)
    assert there.way_points.shape[0] > 2
    assert there.clearance.min() > 0.005
    assert back.good
    np.testing.assert_array_equal(back.motor_counts, there.motor_counts[::-1])
    assert not back.motor_counts[-1].any()
    # Both files are judged anew from what they hold.
    assert run("check", tmp_path / "behind.parquet").code == 0
    assert run("check", tmp_path / "behind-out.parquet").code == 0


def test_a_search_is_the_same_for_the_same_seed(run, task, tmp_path):
    for name in ("one", "two"):
        assert run("plan", task, "--seed", "3", "-o", tmp_path / f"{name}.parquet").code == 0
    one, two = (hognose.Plan.load(tmp_path / f"{name}.parquet") for name in ("one", "two"))
    np.testing.assert_array_equal(one.angles, two.angles)


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
