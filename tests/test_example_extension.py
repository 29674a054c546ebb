"""The example package, installed without a network: its method, check, column and robot are everywhere ours are."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from extension_makers import installed
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import hognose
from hognose.errors import InfeasibleError
from hognose.following import Follower

ROOT = Path(__file__).parents[1]
PROJECT = ROOT / "examples" / "extension"
pytestmark = pytest.mark.slow

#: A task for the robot of the package, which follows with the method of the package.
TASK = """\
schema = 1
units = "mm"
name = "round a corner"
robot = "slim-8"

[path]
way_points = [[0, 0, 0], [0, 30, 150], [0, 80, 290], [0, 100, 430]]

[motion]
method = "marching"

[[obstacle]]
kind = "box"
name = "corner"
center = [0, -100, 300]
size = [100, 100, 100]
"""


#: Runs commands, which end with 0.
SAYING = """
import sys
from hognose.cli import main
for command in sys.argv[1:]:
    try:
        main([*command.split(), "--json"])
    except SystemExit as ended:
        assert ended.code == 0, command
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder in which the package is installed."""
    return installed(PROJECT, tmp_path_factory.mktemp("site"))


@pytest.fixture
def python(site, tmp_path):
    """Run Python with the package in an empty folder; what it prints."""

    def run(*arguments: str) -> str:
        places = [str(site), str(ROOT / "src"), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places)), "COLUMNS": "200"}
        done = subprocess.run(
            [sys.executable, "-W", "error", *arguments],
            cwd=tmp_path, env=environment, capture_output=True, text=True, encoding="utf-8", check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run


@pytest.fixture
def said(python):
    """What commands say as JSON, with the package, one after another in one process."""

    def run(*commands: str) -> list[dict[str, Any]]:
        return [json.loads(line) for line in python("-c", SAYING, *commands).splitlines()]

    return run


def test_importing_hognose_loads_no_other_package(python):
    lines = python(
        "-c",
        "import sys, hognose\n"
        "def there(): print(*(name for name in sys.modules if name.startswith('hognose_example')), sep=' ')\n"
        "there(); hognose.METHODS; there(); list(hognose.METHODS); there()",
    ).splitlines()
    assert lines[:2] == ["", ""]
    assert lines[2].split() == ["hognose_example", "hognose_example.marching"]


def test_the_lists_name_what_is_added_behind_ours(said, python):
    methods, robots, robot = said("methods", "robot", "robot slim-8")
    assert list(methods["methods"]) == [*hognose.METHODS, "marching"]
    assert methods["default"] == "exact"
    assert methods["methods"]["marching"].startswith("Marching along the path")
    assert robots["robots"][-1] == "slim-8"
    assert robot["name"] == "slim-8"
    code = "from hognose.evaluation.subjects import subjects_of; print(*subjects_of(), *subjects_of(['marching']))"
    *subjects, last = python("-c", code).split()
    behind = [name for name in hognose.following.OF_SECTIONS if name not in hognose.METHODS]
    assert (subjects[-len(behind) - 1 :], last) == (["marching", *behind], "marching")


def test_a_plan_is_made_with_the_method_and_judged_by_the_check(said, tmp_path):
    made, checked = said("plan pipe-tank --method marching", "check pipe-tank.parquet")
    assert (made["good"], made["method"]) == (True, "marching")
    found = {check["key"]: check for check in checked["checks"]}
    plain = hognose.plan(hognose.load_task("pipe-tank"))
    assert list(found) == [*(check.key for check in plain.checks), "total_bend"]
    bends = np.arccos(np.cos(plain.angles).prod(axis=-1)).sum(axis=-1)
    bend = found["total_bend"]
    assert (bend["ok"], bend["name"], bend["unit"], bend["limit"]) == (True, "total bend", "rad", np.pi)
    assert bend["value"] == pytest.approx(bends.max(), abs=1e-8)
    assert bend["step"] == bends.argmax()


def test_the_column_is_known_before_a_plan_file_is_read(said, python, tmp_path):
    """Whatever else is loaded: a file that was made without the package is not told to lack it, nor the other way."""
    said("plan pipe-tank")
    checked, _ = said("check pipe-tank.parquet", "export pipe-tank.parquet -o plan.csv")  # in a process of their own
    with (tmp_path / "plan.csv").open() as file:
        assert next(file).strip().split(",")[-1] == "total_bend_rad"
    there = hognose.Plan.load(tmp_path / "pipe-tank.parquet")
    bends = np.arccos(np.cos(there.angles).prod(axis=-1)).sum(axis=-1)
    np.testing.assert_allclose(there.extra["total_bend_rad"], bends, rtol=0, atol=1e-12)
    assert "1 column that Hognose does not know is kept: total_bend_rad" in there.remarks
    assert not any("does not know" in words for words in checked["remarks"])


def test_a_task_file_names_robot_and_method(said, tmp_path):
    (tmp_path / "task.toml").write_text(TASK)
    made, checked = said("plan task.toml", "check task.parquet")
    assert (made["good"], made["method"]) == (True, "marching")
    assert checked["good"] is True


@pytest.fixture(scope="module")
def marching():
    """The method itself, from the sources."""
    sys.path.insert(0, str(PROJECT / "src"))
    try:
        found = importlib.import_module("hognose_example.marching").Marching
    finally:
        sys.path.remove(str(PROJECT / "src"))
    assert issubclass(found, Follower)
    return found


def _refused(follower: Follower, feeds: NDArray[np.float64]) -> str:
    """What is said of the first link that finds no place, without coordinates; nothing if all do."""
    try:
        follower.run(feeds)
    except InfeasibleError as error:
        return str(error).split("(")[0]
    return ""


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), bend=st.sampled_from([0.05, 0.3]))
def test_marching_is_exact_within_its_tolerance(marching, seed, bend):
    """On paths that bend within a link, too: both find the first crossing. Where there is none, both say the same."""
    rng = np.random.default_rng(seed)
    points = np.concatenate(
        [[[0, 0, 0], [0, 0, 0.3]], rng.normal(0, bend, (4, 3)) + [[0, 0, 0.3 * k] for k in range(2, 6)]]
    )
    path, lengths = hognose.Path.through(points), rng.uniform(0.03, 0.1, 6)
    follower = marching(path, lengths)
    feeds = np.linspace(0.0, path.length, 60)
    exact = hognose.follower(path, lengths)
    if lost := _refused(exact, feeds):
        assert _refused(follower, feeds) == lost
        feeds = feeds[: int(lost.split(",")[0].removeprefix("step "))]
    joints = follower.run(feeds)
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(lengths, links.shape), rtol=0, atol=follower.tolerance)
    assert path.distance_to(joints).max(initial=0.0) <= follower.tolerance
    np.testing.assert_array_equal(joints, [follower.step(float(feed)) for feed in feeds])
    if exact.tracks:
        np.testing.assert_allclose(joints, exact.run(feeds), rtol=0, atol=1e-8)
