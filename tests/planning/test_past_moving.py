"""Detours past obstacles that move."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hognose.errors import InfeasibleError
from hognose.files.loading import load_task
from hognose.planning import Plan, Task
from hognose.planning.past_moving import APART, MOST_PLACES, _met, _places, _Timetable
from hognose.planning.planner import plan_along
from hognose.scene import Box, MovingObstacle
from hognose.scene.moving import parted

pytestmark = pytest.mark.slow

TEXT = (Path(__file__).parents[2] / "examples" / "11_moving_obstacles.toml").read_text(encoding="utf-8")
HEAD = TEXT[: TEXT.index("[[obstacle]]")]
SPHERE = """
[[obstacle]]
kind = "sphere"
name = "hook"
center = [30, 200, 500]
diameter = 60
timing_s = {timing}
[[obstacle.motion]]
time_s = {down}
[[obstacle.motion]]
time_s = {stays}
position = [0, -150, 0]
[[obstacle.motion]]
time_s = {up}
position = [0, 0, 0]
"""
WHEEL = TEXT[TEXT.rindex("[[obstacle]]") :]


def task_of(folder: Path, text: str) -> Task:
    (folder / "task.toml").write_text(text, encoding="utf-8")
    return load_task(folder / "task.toml")


def densely(plan: Plan) -> float:
    """The smallest clearance (m) of the body at many times between the set-points, angles and feed linear."""
    smallest = np.inf
    for row, (before, after) in enumerate(zip(plan.time[:-1], plan.time[1:], strict=True)):
        for share in (0.0, 0.5):
            scene = plan.task.scene_at(float(before + share * (after - before)))
            line = (1 - share) * plan.centre_line[row] + share * plan.centre_line[row + 1]
            value = scene.clearance(line[None, :-1], line[None, 1:], plan.robot.chord_radii).value
            smallest = min(smallest, float(value.min()))
    return smallest


@pytest.mark.parametrize(
    "obstacle",
    [SPHERE.format(timing=1.0, down=20, stays=30, up=40), WHEEL.replace("140.0, 620.0", "100.0, 620.0")],
    ids=["hook", "wheel"],
)
def test_a_detour_leads_past_what_moves_and_keeps_the_way_points(obstacle, tmp_path):
    with pytest.raises(InfeasibleError, match=r"detours are switched off \(path.detour\)"):
        plan_along(task_of(tmp_path, HEAD.replace("order = 3", "order = 3\ndetour = false") + obstacle))
    task = task_of(tmp_path, HEAD + obstacle)
    plan = plan_along(task)
    assert plan.good
    assert len(plan.way_points) > len(task.way_points)
    given_ones = [np.flatnonzero((plan.way_points == place).all(axis=1)) for place in task.way_points]
    assert all(len(found) == 1 for found in given_ones)
    assert list(np.concatenate(given_ones)) == sorted(np.concatenate(given_ones))
    proven = plan.certified_clearance
    assert proven is not None
    assert densely(plan) >= proven >= task.margin


@pytest.mark.parametrize("when", [{"down": 2, "stays": 5, "up": 9}, {"down": 90, "stays": 95, "up": 99}])
def test_what_is_gone_before_the_arm_comes_or_comes_after_it_is_not_evaded(when, tmp_path):
    task = task_of(tmp_path, HEAD + SPHERE.format(timing=0.0, **when))
    plan = plan_along(task)
    np.testing.assert_array_equal(plan.way_points, task.way_points)
    assert _Timetable(plan).hits(plan.path).count == 0


def test_where_no_detour_leads_past_the_error_says_what_to_do(tmp_path):
    late = TEXT.replace("time_s = 5.0", "time_s = 11.0").replace("time_s = 10.0", "time_s = 16.0")
    with pytest.raises(InfeasibleError) as caught:
        plan_along(task_of(tmp_path, late))
    said = str(caught.value).splitlines()[-1]
    assert said.startswith("  'hatch' moves into the arm's way, and no detour leads past it. Put a way-point beside")
    assert "`target`" in said
    assert caught.value.plan is not None
    np.testing.assert_array_equal(caught.value.plan.way_points, load_task(tmp_path / "task.toml").way_points)


def test_a_plan_that_fails_otherwise_is_told_nothing_of_what_moves(tmp_path):
    hook = SPHERE.format(timing=0.0, down=20, stays=30, up=40)
    fast = (HEAD + hook).replace("period_s = 0.15", "period_s = 0.02")  # too fast for the joints, and before the hook
    with pytest.raises(InfeasibleError) as caught:
        plan_along(task_of(tmp_path, fast))
    assert "joint speed" in str(caught.value)
    assert "moves into" not in str(caught.value)


angles = st.lists(st.floats(-400, 400), min_size=2, max_size=5)


@st.composite
def obstacles(draw: st.DrawFn) -> MovingObstacle:
    """A box that goes and turns anyhow, again and again or once."""
    turned = draw(angles)
    repeats = draw(st.booleans())
    turned = [*turned, turned[0]] if repeats else turned
    axis = draw(st.tuples(*[st.floats(0.1, 1.0)] * 3))
    times = np.cumsum([draw(st.floats(0.1, 4.0)) for _ in turned])
    places = [tuple(draw(st.floats(-0.3, 0.3)) for _ in range(3)) for _ in turned]
    places = [*places[:-1], places[0]] if repeats else places
    motion = [
        {"time_s": t, "angle_deg": a, "position": p} for t, a, p in zip(times.tolist(), turned, places, strict=True)
    ]
    box = Box.model_validate(
        {
            "kind": "box",
            "center": (0, 0, 0),
            "size": (0.05, 0.1, 0.2),
            "motion": motion,
            "motion_axis": axis,
            "motion_pivot": (0.02, 0.0, 0.05),
            "motion_repeats": repeats,
            "timing_s": draw(st.sampled_from([0.0, 0.3])),
        }
    )
    return parted([box])[1][0]


@settings(max_examples=60, deadline=None)
@given(obstacles(), st.floats(0.0, 5.0), st.floats(0.1, 9.0))
def test_between_looks_no_point_goes_farther_than_is_said(obstacle, first, lasts):
    times, apart = _places(obstacle, first, first + lasts)
    assert apart <= APART * (1 + 1e-9) or len(times) == MOST_PLACES + 1
    corners = obstacle.scene.triangles.reshape(-1, 3)
    for before, after in pairwise(times):
        went = obstacle.motion.out_of_frame(corners, after) - obstacle.motion.out_of_frame(corners, before)
        assert np.linalg.norm(went, axis=1).max() <= apart * (1 + 1e-6) + 1e-9


@settings(max_examples=60, deadline=None)
@given(obstacles(), st.lists(st.tuples(*[st.floats(-0.4, 0.4)] * 3), min_size=1, max_size=6), st.floats(0.0, 8.0))
def test_no_obstacle_comes_deeper_at_any_time_than_is_said(obstacle, places, until):
    points, body = np.array(places), np.full(len(places), 0.03)
    since = np.linspace(0.0, until, len(places))
    said = _met(obstacle, points, body, since, until)
    for index, begin in enumerate(since):
        early = np.array([[-obstacle.timing], [0.0], [obstacle.timing]])
        times = (np.linspace(begin, until, 80) + early).ravel()
        seen = obstacle.motion.into_frame(np.tile(points[index], (times.size, 1, 1)), times)[:, 0]
        distances = obstacle.scene.distance(seen, seen).value
        distances = np.where(obstacle.scene.inside(seen) >= 0, -distances, distances)
        assert (body[index] - distances <= max(float(said[index]), 0.0) + 1e-9).all()
