"""Tasks with obstacles that move: planned, judged, saved, retracted, refused."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.files.loading import load_task
from hognose.files.task_toml import written
from hognose.planning import Plan, Task, TaskSpec
from hognose.planning.checks.shared import Shared
from hognose.planning.drawn_arms import draw
from hognose.planning.planner import plan_along
from hognose.planning.retraction import retraction
from hognose.scene import MovingObstacle, Scene
from hognose.scene.moving import parts_of
from hognose.scene.rigid_motion import RigidMotion
from hognose.steering import SteeredPath
from hognose.viewer.model.arm_state import ArmState, too_close
from hognose.viewer.model.replanner import share_scene

EXAMPLE = Path(__file__).parents[2] / "examples" / "11_moving_obstacles.toml"
TEXT = EXAMPLE.read_text(encoding="utf-8")
CERTIFIED = ("certified_along_path", "certified_interpolated", "certified_cables")


@pytest.fixture(scope="module")
def plan() -> Plan:
    return plan_along(load_task(EXAMPLE))


def read(folder: Path, *changes: tuple[str, str]) -> Task:
    """The example's task with texts in its file replaced."""
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "task.toml").write_text(text, encoding="utf-8")
    return load_task(folder / "task.toml")


def at_step(plan: Plan, row: int, times: np.ndarray) -> float:
    """The clearance at a row to all obstacles in one scene, as they stand at its time."""
    scene, line = plan.task.scene_at(float(times[row])), plan.centre_line[row]
    return float(scene.clearance(line[None, :-1], line[None, 1:], plan.robot.chord_radii, plan.horizon).value.min())


def test_clearances_are_those_of_the_obstacles_where_they_stand_at_each_step(plan):
    assert plan.good
    for row in range(0, len(plan.time), 9):
        assert plan.clearance[row].min() == pytest.approx(at_step(plan, row, plan.time), abs=1e-9)


def test_the_wheel_is_named_with_the_time_and_its_timing_is_taken_off(plan, tmp_path):
    exactly = plan_along(read(tmp_path, ("timing_s = 0.02", "timing_s = 0.0")))
    for key in CERTIFIED:
        early, on_time = plan.check(key), exactly.check(key)
        assert early.obstacle == on_time.obstacle == "wheel"
        assert "which moves, at 33." in early.detail
        most = 0.02 * np.hypot(0.08, 0.0142) * 2 * np.pi / 6
        assert 0.0 < on_time.value - early.value <= most + 5e-4
        assert on_time.value <= exactly.clearance.min()


def test_a_hatch_that_opens_too_late_is_hit_and_named(tmp_path):
    late = read(tmp_path, ("time_s = 5.0", "time_s = 11.0"), ("time_s = 10.0", "time_s = 16.0"))
    with pytest.raises(InfeasibleError) as caught:
        plan_along(late)
    assert caught.value.plan is not None
    failed = {check.key: check for check in caught.value.plan.checks if check.failed}
    assert set(failed) == {"clearance_at_steps", *CERTIFIED}
    assert {check.obstacle for check in failed.values()} == {"hatch"}
    assert "at 11.10 s" in failed["clearance_at_steps"].detail


def test_a_hatch_whose_timing_is_too_loose_is_only_proven_to_be_too_close(tmp_path):
    loose = read(tmp_path, ("timing_s = 0.5", "timing_s = 4.0"))
    with pytest.raises(InfeasibleError) as caught:
        plan_along(loose)
    assert caught.value.plan is not None
    assert {check.key for check in caught.value.plan.checks if check.failed} == set(CERTIFIED)


def test_what_stands_still_before_the_end_of_the_plan_is_noted(plan):
    noted = plan.check("moving_obstacles")
    assert noted.ok
    assert "hatch stands still from 10 s on" in noted.detail
    assert "wheel moves all the time" in noted.detail


def test_a_plan_with_moving_obstacles_is_saved_and_read(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    again = Plan.load(tmp_path / "plan.parquet")
    assert again.good
    assert [check.value for check in again.checks if check.key in CERTIFIED] == [plan.check(k).value for k in CERTIFIED]
    moved = {"obstacle": tuple(item.model_copy(update={"motion": ()}) for item in plan.task.spec.obstacle)}
    still = Task(plan.task.spec.model_copy(update=moved), plan.robot)
    assert not dataclasses.replace(plan, task=still).verified().good


def test_a_task_with_moving_obstacles_is_written_and_read(plan, tmp_path):
    (tmp_path / "again.toml").write_text(written(plan.task.spec), encoding="utf-8")
    again = load_task(tmp_path / "again.toml")
    for one, other in zip(again.moving, plan.task.moving, strict=True):
        np.testing.assert_allclose(one.motion.places, other.motion.places, atol=1e-9)
        np.testing.assert_allclose(one.motion.spins, other.motion.spins, atol=1e-9)
        assert (one.name, one.timing, one.motion.repeats) == (other.name, other.timing, other.motion.repeats)


def test_a_retraction_meets_obstacles_where_they_are_then(plan, tmp_path):
    out = retraction(plan)
    assert out.good
    np.testing.assert_allclose(out.clock, out.time + plan.time[-1])
    for row in range(0, len(out.time), 9):
        assert out.clearance[row].min() == pytest.approx(at_step(out, row, out.clock), abs=1e-9)
    with pytest.raises(InfeasibleError, match=r"is 0 s, but the insertion ends at 41\.85 s") as caught:
        plan_along(read(tmp_path, ("[motion]", "[motion]\nretraction_start_s = 0.0")))
    early = caught.value.plan
    assert isinstance(early, Plan)
    with pytest.raises(InfeasibleError, match="hatch"):
        retraction(early)


CRANE = """
[[obstacle]]
kind = "sphere"
name = "crane"
center = [0.0, 900.0, 400.0]
diameter = 120.0
[[obstacle.motion]]
time_s = 60.0
[[obstacle.motion]]
time_s = 70.0
position = [0.0, {far}, 0.0]
"""


@pytest.mark.parametrize(
    ("start", "far", "good"), [(100.0, -1800.0, False), (59.0, -1800.0, True), (100.0, -760.0, True)]
)
def test_an_arm_that_waits_inside_is_kept_clear_of_what_moves_meanwhile(tmp_path, start, far, good):
    text = TEXT.replace("[motion]", f"[motion]\nretraction_start_s = {start}") + CRANE.format(far=far)
    (tmp_path / "task.toml").write_text(text, encoding="utf-8")
    task = load_task(tmp_path / "task.toml")
    if good:
        plan = plan_along(task)
    else:
        with pytest.raises(InfeasibleError, match="clearance while waiting") as caught:
            plan_along(task)
        assert isinstance(caught.value.plan, Plan)
        plan = caught.value.plan
    check, line = plan.check("clearance_while_waiting"), plan.centre_line[-1]
    assert check.ok == good
    assert check.value is not None
    dense = []
    looks = np.append(np.linspace(plan.time[-1], start, 20), np.linspace(60.0, 70.0, 80))  # while the crane moves, most
    for time in looks[looks <= start]:
        scene = task.scene_at(float(time))
        dense.append(scene.clearance(line[None, :-1], line[None, 1:], plan.robot.chord_radii, plan.horizon).value.min())
    assert check.value <= max(min(dense), 0.0) + 1e-9


def test_what_moves_past_the_body_behind_the_first_joint_is_seen(tmp_path):
    beside = """
[[obstacle]]
kind = "sphere"
name = "trolley"
center = [900.0, 0.0, -1200.0]
diameter = 100.0
[[obstacle.motion]]
time_s = 1.0
[[obstacle.motion]]
time_s = 2.0
position = [-1800.0, 0.0, 0.0]
"""
    (tmp_path / "task.toml").write_text(TEXT + beside, encoding="utf-8")
    with pytest.raises(InfeasibleError) as caught:
        plan_along(load_task(tmp_path / "task.toml"))
    assert caught.value.plan is not None
    behind = caught.value.plan.check("clearance_of_mount")
    assert behind.failed
    assert behind.obstacle == "trolley"
    assert "trolley" in behind.detail
    assert "'trolley' moves into the way of the mount" in str(caught.value)


@pytest.mark.parametrize(
    ("at", "what"),
    [(-10, "the entrance at (0, 0, 0) mm"), (-500, "the arm at (0, 0, -"), (-1092, "the first joint at")],
)
@pytest.mark.parametrize("way", ["target", "way_points"])
def test_what_covers_the_arm_as_its_clock_begins_is_wrong_input(at, what, way, tmp_path):
    ball = f"""
[[obstacle]]
kind = "sphere"
name = "ball"
center = [0, 0, {at}]
diameter = 60
[[obstacle.motion]]
time_s = 0
[[obstacle.motion]]
time_s = 1
position = [900, 0, 0]
"""
    points = TEXT[TEXT.index("way_points") : TEXT.index("[motion]")]
    text = TEXT.replace(points, "target = [-60, 40, 950]\n") if way == "target" else TEXT
    (tmp_path / "task.toml").write_text(text + ball, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        hognose.plan(load_task(tmp_path / "task.toml"))
    assert str(caught.value).startswith(f"obstacle 'ball' moves, and at 0 s, when the insertion begins, {what}")
    assert "a `time_s` before 0" in str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("time_s = 10.0", "time_s = 5.0"), "the times of its poses must increase: pose 2 is at 5 s"),
        (("timing_s = 0.5", "timing_s = -0.5"), "timing_s: input should be greater than or equal to 0"),
        (("angle_deg = 360.0", "angle_deg = 350.0"), "it would jump there, by 0 mm and 10 deg"),
        (("time_s = 10.0", "time_s = nan"), "motion[2].time_s: input should be a finite number, got nan"),
        (("angle_deg = -110.0", "position = [inf, 0, 0]"), "position[1]: input should be a finite number, got inf"),
        (("time_s = 10.0\n", ""), "motion[2].time_s: is missing"),
        (("time_s = 10.0", "time_s = -1e9"), "greater than or equal to -1000000"),
        (("motion_axis = [0.0, 1.0, 0.0]", "motion_axis = [0, 0, 0]"), "must be a direction"),
        (("motion_pivot", "# motion_pivot"), "give the `motion_pivot`"),
        (("motion_axis", "# motion_axis"), "go together"),
        (("angle_deg = 360.0", "rotation_deg = [0, 0, 0]"), "use one of them in all"),
        (("angle_deg = 360.0", "angle_deg = 360.0\nrotation_deg = [0, 0, 0]"), "not both"),
        (("[[obstacle.motion]]\ntime_s = 10.0\nangle_deg = -110.0\n", ""), "one pose is no motion"),
        (('name = "wall"', 'name = "wall"\ntiming_s = 1.0'), "has no `"),
        (('name = "wall"', 'name = "hatch"'), '2 obstacles are called "hatch"'),
        (("[motion]", '[motion]\nretraction_profile = "fastest"'), "retraction_start_s"),
        (
            ("[motion]", "[[path.keep_out]]\ncenter = [9, 0, 0]\nsize = [1, 1, 1]\n"
             "motion = [{ time_s = 0 }, { time_s = 1 }]\n[motion]"),
            "keep_out 1 moves",
        ),
    ],
)  # fmt: skip
def test_a_motion_that_is_none_is_refused(change, words, tmp_path):
    with pytest.raises(InputError) as caught:
        _ = read(tmp_path, change).moving
    assert words in str(caught.value)


@pytest.mark.parametrize("turned", ["[0, 180, 0]", "[0, 350, 0]", "[180, 0, 0]", "[0, -179.95, 0]"])
def test_half_a_turn_between_rotations_has_no_shortest_way(turned, tmp_path):
    door = f"""
[[obstacle]]
kind = "box"
center = [900.0, 0.0, 0.0]
size = [9.0, 9.0, 9.0]
motion_pivot = [0.0, 0.0, 0.0]
[[obstacle.motion]]
time_s = 0
[[obstacle.motion]]
time_s = 1
rotation_deg = {turned}
"""
    (tmp_path / "task.toml").write_text(TEXT + door, encoding="utf-8")
    with pytest.raises(InputError, match="half a turn or more"):
        load_task(tmp_path / "task.toml")


def test_steering_past_moving_obstacles_is_refused(plan):
    with pytest.raises(InputError, match="'hatch' moves"):
        SteeredPath.of(plan.task)


def as_one_that_moves(task: Task) -> Task:
    """The same task whose obstacles are one that is placed elsewhere and comes back, at a stand there."""
    turned = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
    pivot, place = np.array([0.1, 0.2, -0.3]), np.array([-0.5, 0.4, 0.9])
    parts = [
        dataclasses.replace(part, triangles=(part.triangles - place) @ turned + pivot) for part in parts_of(task.scene)
    ]
    motion = RigidMotion(np.array([0.0, 1.0]), pivot, np.stack([place] * 2), np.stack([turned] * 2), np.zeros((1, 3)))
    return task.with_obstacles(Scene.from_parts([]), (MovingObstacle("all", Scene.from_parts(parts), motion, 0.0),))


def test_what_moves_is_pointed_out_as_what_stands():
    """Beside a plate, through it, and deep inside the block behind it."""
    boxes = [
        {"kind": "box", "name": "plate", "center": [0, 0, 0.2], "size": [0.5, 0.5, 0.01]},
        {"kind": "box", "name": "block", "center": [0, 0, 0.6], "size": [0.5, 0.5, 0.4]},
    ]
    path = {"way_points": [[0, 0, 0], [0, 0, 0.95]], "detour": False}
    spec = TaskSpec.model_validate({"name": "through", "robot": "sjtu-25dof", "path": path, "obstacle": boxes})
    task = Task(spec, hognose.load_robot("sjtu-25dof"))
    with pytest.raises(InfeasibleError) as caught:
        plan_along(task)
    standing = caught.value.plan
    assert standing is not None
    moving = dataclasses.replace(standing, task=as_one_that_moves(task))
    depths = set()
    for row in range(0, len(standing.time), 16):
        link = int(standing.clearance[row].argmin())
        one, other = (ArmState.of_plan(each, row).contact(link) for each in (standing, moving))
        assert (one.moves, other.moves) == (False, True)
        assert one.obstacle == other.obstacle
        assert one.inside == other.inside
        assert one.distance == pytest.approx(other.distance, abs=1e-9)
        if one.inside:
            np.testing.assert_allclose(one.place, other.place, atol=1e-9)
            assert one.distance == pytest.approx(standing.clearance[row, link] + task.robot.body_radii[link], abs=1e-9)
        depths.add((one.obstacle, one.inside))
    assert depths >= {("plate", False), ("block", True)}
    dots, others = too_close(standing), too_close(moving)
    assert len(dots) == len(others)
    assert np.abs(dots - others)[:, 2].max() < 1e-9


def test_what_is_only_drawn_needs_no_tree(plan):
    assert "tree" not in vars(plan.task.scene_at(1.23))
    assert "tree" not in vars(plan.task.placed_scene)


def test_tasks_share_obstacles_but_not_their_timing(plan, tmp_path):
    again = load_task(EXAMPLE)
    share_scene(again, plan.task)
    assert again.scene is plan.task.scene
    assert again.moving is plan.task.moving
    later = load_task(EXAMPLE)
    tolerance = later.spec.tolerance.model_copy(update={"timing_s": 0.7})
    later = Task(later.spec.model_copy(update={"tolerance": tolerance}), later.robot)
    share_scene(later, plan.task)
    assert later.scene is plan.task.scene
    assert [each.timing for each in later.moving] == [each.timing for each in Task(later.spec, later.robot).moving]


def test_arms_are_drawn_past_what_moves_as_past_what_stands():
    task = hognose.load_task("tolerances")
    budget = task.budget
    assert budget is not None
    still = hognose.plan(task)
    moving = dataclasses.replace(still, task=as_one_that_moves(task))
    # Of places that are equally close, rounding decides which are drawn for: the arms are others, equally likely.
    one, other = (draw(each, budget, Shared(each).taken, 20_000, seed=1) for each in (still, moving))
    assert one.quantile(0.75) - one.quantile(0.05) > 3e-3
    for share in (0.05, 0.25, 0.5, 0.75):
        assert abs(one.quantile(share) - other.quantile(share)) < 2e-4


@pytest.mark.slow
def test_a_route_is_found_through_a_hatch_that_opens_in_time(tmp_path):
    way = TEXT[TEXT.index("way_points") : TEXT.index("[motion]")]
    task = read(tmp_path, (way, "entrance = [0, 0, 0]\ntarget = [-60, 40, 950]\n"))
    assert hognose.plan(task).good
