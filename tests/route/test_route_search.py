"""Routes to a target: found, certified, and clear by an independent check."""

import numpy as np
import pytest
from route_makers import searched, smallest_by_coal

import hognose
from hognose.planning import Task, TaskSpec, run_checks
from hognose.robot import Robot, RobotSpec
from hognose.route import Search

pytestmark = pytest.mark.slow
CASES = ("obstacle-array", "pipe-tank")


@pytest.fixture(scope="module")
def found():
    return {name: hognose.plan(searched(name)) for name in CASES}


def certified(plan):
    return 1e3 * plan.certified_clearance


@pytest.mark.parametrize("name", CASES)
def test_a_route_is_found_from_entrance_and_target_alone(found, name):
    plan = found[name]
    assert plan.good
    assert certified(plan) >= 5
    assert np.array_equal(plan.way_points[[0, -1]], plan.task.way_points)
    assert np.linalg.norm(plan.body[-1, -1] - plan.task.spec.path.target) < 1e-9


def test_a_dense_check_by_another_library_finds_the_certified_clearance(found):
    plan = found["obstacle-array"]
    smallest = 1e3 * smallest_by_coal(plan, 0.0005)
    assert certified(plan) - 1e-3 <= smallest <= certified(plan) + 0.3


def test_a_second_search_gives_the_same_plan(found):
    again = hognose.plan(searched("pipe-tank"))
    assert np.array_equal(again.way_points, found["pipe-tank"].way_points)
    assert np.array_equal(again.angles, found["pipe-tank"].angles)


def test_the_plan_file_needs_no_search_to_be_read(found, tmp_path):
    found["pipe-tank"].save(tmp_path / "plan.parquet")
    loaded = hognose.Plan.load(tmp_path / "plan.parquet")
    assert loaded.task.spec == found["pipe-tank"].task.spec
    assert np.array_equal(loaded.joints, found["pipe-tank"].joints)
    assert all(check.ok for check in run_checks(loaded))


def test_every_plan_of_a_search_is_better_than_the_one_before():
    search = Search(searched("detour", margin=0.012), None, 3)
    search.run()
    clearances = [found.clearance for found in search.found]
    assert len(clearances) > 1
    assert clearances == sorted(set(clearances))
    assert all(found.plan.good for found in search.found)


def test_a_search_that_is_interrupted_keeps_what_it_has():
    def interrupt(stage):
        if "certified" in stage:
            raise KeyboardInterrupt

    search = Search(searched("pipe-tank"), None, 0, interrupt)
    search.run()
    assert search.best is not None
    with pytest.raises(KeyboardInterrupt):
        Search(searched("pipe-tank"), None, 0, lambda stage: interrupt("certified")).run()


def test_the_route_passes_what_is_via():
    via = (0.05, 0.03, 0.2)
    plan = hognose.plan(searched("obstacle-array", via=[via]))
    assert plan.good
    assert plan.path.distance_to(via) < 1e-9
    assert any(np.array_equal(point, via) for point in plan.way_points)


def test_the_route_keeps_out_of_boxes(found):
    middle = found["pipe-tank"].body[-1, 6]
    box = {"center": middle.tolist(), "size": [0.05, 0.05, 0.05]}
    plan = hognose.plan(searched("pipe-tank", keep_out=[box]))
    assert plan.good
    assert "keep-out 1" in plan.scene.names
    away = np.abs(plan.body[:, :, None] - middle).max(axis=-1)
    assert away.min() > 0.025 + plan.robot.body_radii[0]


def test_the_tip_points_where_it_shall(found):
    before = found["pipe-tank"].body[-1, -1] - found["pipe-tank"].body[-1, -2]
    wished = before + 0.3 * np.linalg.norm(before) * np.array([0.0, 1.0, 0.0])
    plan = hognose.plan(searched("pipe-tank", tip_direction=wished.tolist(), tip_cone_deg=5.0))
    tip = plan.body[-1, -1] - plan.body[-1, -2]
    angle = np.degrees(np.arccos(tip @ wished / np.linalg.norm(tip) / np.linalg.norm(wished)))
    assert angle <= 5
    assert plan.check("tip_direction").value == pytest.approx(np.radians(angle))


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ({"way_points": [[0, 0, 0], [0, 0, 1]]}, "not both"),
        ({"target": None}, "are missing"),
        ({"target": None, "way_points": [[0, 0, 0], [0, 0, 1]], "entrance": [0, 0, 0.1]}, "`entrance` goes with"),
        ({"kind": "bspline"}, "is a spline"),
        ({"order": 1}, "is a spline"),
        ({"target": [0, 0, 0]}, "points 1 and 2 are the same"),
        ({"tip_direction": [0, 0, 0]}, "is zero; it must be a direction"),
    ],
)
def test_a_task_asks_for_one_thing(path, message):
    with pytest.raises(ValueError, match=message):
        searched("pipe-tank", **path)


@pytest.mark.parametrize(("key", "place"), [("entrance", [0.2, 0, 0]), ("target", [-0.11, 0.06, 0.8])])
def test_a_place_inside_an_obstacle_is_wrong_input(key, place):
    with pytest.raises(hognose.InputError, match=rf"path\.{key}: .* lies inside"):
        hognose.plan(searched("obstacle-array", **{key: place}))


@pytest.mark.parametrize("target", [(0.025, 0.01, 0.09), (0.0, 0.0, 0.03), (-0.02, 0.03, 0.2)])
def test_a_target_near_the_entrance_is_reached(target):
    spec = TaskSpec.model_validate({"name": "near", "robot": "sjtu-25dof", "path": {"target": target}})
    made = hognose.plan(Task(spec, hognose.load_robot("sjtu-25dof")))
    np.testing.assert_allclose(made.body[-1, -1], target, rtol=0, atol=1e-6)


def test_thick_links_that_stay_outside_close_nothing_off():
    data = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True)
    (section,) = data["section"]
    thick = section | {"count": 6, "body_diameter": 0.06}
    thin = section | {"count": 6, "body_diameter": 0.03, "cable_radius": 0.012}
    robot = Robot.from_spec(RobotSpec.model_validate(data | {"name": "tapered", "section": [thick, thin]}))
    hole = {"kind": "board", "name": "wall", "center": (0, 0, 0.002), "normal": (0, 0, 1), "size": (1.0, 1.0),
            "thickness": 0.004, "hole": [{"center": (0, 0), "diameter": 0.05}]}  # fmt: skip
    spec = TaskSpec.model_validate(
        {"name": "tapered", "robot": "tapered", "path": {"target": (0.0, 0.0, 0.35)}, "obstacle": [hole]}
    )
    assert certified(hognose.plan(Task(spec, robot))) > 5
