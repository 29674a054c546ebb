"""Bends whose limits differ from side to side: in files, bases, methods, checks, mechanics, steering and exports."""

import math

import numpy as np
import pytest
from pydantic import ValidationError
from robot_oracles import BUNDLED, robot_file, robot_of, section

import hognose
from hognose.errors import InputError
from hognose.following.optimization import Optimization
from hognose.mechanics import Mechanics
from hognose.path import Path
from hognose.robot import Robot, RobotSpec
from hognose.robot.bends import CLOSED, beyond, on_side, used
from hognose.robot.drum import Drum
from hognose.robot.kinematics import angles_of
from hognose.steering.limits import CurvatureLimit

LENGTHS = np.full(6, 0.1)
FEEDS = np.arange(0.3, 0.65, 0.01)


def bounds_of(low, high):
    """Of α; β may bend by a right angle to both sides."""
    return np.tile([[[low, high], [-math.pi / 2, math.pi / 2]]], (len(LENGTHS), 1, 1))


def to_both_sides():
    """A path that bends first to one side, then to the other."""
    z = np.linspace(0, 1.0, 21)
    x = 0.03 * np.sin(3 * np.pi * z)
    return Path.through(np.column_stack([x, 0 * z, z]), 3, [0, 0, 1.0]).with_run(0.65)


def test_sides_are_those_of_the_file():
    arm = robot_of([section(bend_limit_deg=(28.0, 20.0), alpha_range_deg=(-28.0, 5.0), beta_range_deg=(0.0, 12.0))])
    np.testing.assert_allclose(np.degrees(arm.bend_bounds[0]), [[-28, 5], [-math.degrees(CLOSED), 12]], rtol=1e-14)
    np.testing.assert_allclose(np.degrees(arm.bend_limits), [[28, 12]], rtol=1e-14)
    assert arm.fingerprint != robot_of([section(bend_limit_deg=(28.0, 20.0))]).fingerprint


@pytest.mark.parametrize("name", BUNDLED)
def test_of_joints_that_bend_alike_both_sides_are_the_limit(name):
    arm = hognose.load_robot(name)
    np.testing.assert_array_equal(arm.bend_bounds, np.stack([-arm.bend_limits, arm.bend_limits], axis=2))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((-90.0, 90.0), r"alpha_range_deg \[-90, 90\] goes beyond bend_limit_deg 28"),
        ((-29.0, 5.0), r"alpha_range_deg \[-29, 5\] goes beyond bend_limit_deg 28"),
        ((0.0, 0.0), r"alpha_range_deg \[0, 0\] does not let the section bend"),
        ((2.0, 5.0), "alpha_range_deg"),
        ((-5.0, -2.0), "alpha_range_deg"),
    ],
)
def test_ranges_hold_straight_and_keep_within_the_limit(given, words):
    with pytest.raises(ValidationError, match=words):
        RobotSpec.model_validate(robot_file([section(alpha_range_deg=given)]))


def test_how_much_of_a_limit_is_used_is_told_by_its_side():
    bounds = np.array([[[-0.4, 0.1], [-CLOSED, 0.2]]])
    angles = np.array([[[0.05, -1e-10]], [[-0.2, 0.1]], [[0.2, -0.1]]])
    np.testing.assert_allclose(used(angles, bounds)[:, 0], [[0.5, 0.1], [0.5, 0.5], [2.0, 0.1 / CLOSED]])
    np.testing.assert_allclose(beyond(angles, bounds)[:2, 0], [[-0.05, 1e-10 - CLOSED], [-0.2, -0.1]])
    np.testing.assert_allclose(beyond(angles, bounds)[2, 0], [0.1, 0.1 - CLOSED])
    np.testing.assert_array_equal(on_side(angles, bounds)[:, 0], [[0.1, CLOSED], [0.4, 0.2], [0.1, CLOSED]])


def test_a_drum_bends_joints_to_its_own_side():
    def on_drum(*sides):
        arm = robot_of([section(count=6, bend_limit_deg=28.0, alpha_range_deg=sides)])
        return Drum.before(np.zeros(3), arm, 0.25, 0.1, np.eye(3))

    assert on_drum(0.0, 28.0).radius == 0.25
    with pytest.raises(InputError, match=r"joint 2 bends by 20\.97 deg, at most 10 deg"):
        on_drum(-28.0, 10.0)


@pytest.mark.parametrize("method", ["jacobian", "optimization", "as published"])
def test_methods_keep_to_the_side_that_is_open(method):
    path, low = to_both_sides(), -0.125
    free = angles_of(hognose.follow(path, LENGTHS, FEEDS))[..., 0]
    assert free.min() == pytest.approx(-free.max(), rel=0.01)
    assert free.min() < 2 * low
    if method == "as published":
        joints = Optimization(path, LENGTHS, bend_limits=bounds_of(low, 1.0), as_published=True).run(FEEDS)
    else:
        joints = hognose.follow(path, LENGTHS, FEEDS, method, bend_limits=bounds_of(low, 1.0))
    found = angles_of(joints)[..., 0]
    assert found.min() == pytest.approx(low, abs=1e-12)
    assert found.max() > -1.3 * low  # the other side is open


def test_the_whole_arm_fit_keeps_to_the_side_that_is_open():
    arm = robot_of([section(kind="arc", half_lengths=None, pitch=0.1, count=6, bend_limit_deg=60.0)])
    path = to_both_sides()
    free, bound = (
        arm.angles(hognose.follow(path, arm.link_lengths, FEEDS, "fitted", bend_limits=limits, model=arm.model))
        for limits in (None, bounds_of(-0.18, 1.0))
    )
    assert free[..., 0].min() < -0.25
    assert bound[..., 0].min() == pytest.approx(-0.18, abs=1e-12)
    assert bound[..., 0].max() > 0.25


@pytest.mark.parametrize("method", ["fabrik", "ccd"])
def test_methods_that_know_cones_only_say_so(method):
    with pytest.raises(InputError, match=f"method '{method}' keeps joints within cones"):
        hognose.follower(to_both_sides(), LENGTHS, method, bend_limits=bounds_of(-0.1, 0.2))


@pytest.mark.parametrize("bad", [np.zeros((6, 2, 2)), np.ones((6, 2, 2)), np.ones((5, 2, 2))])
def test_sides_hold_straight_for_methods_too(bad):
    with pytest.raises(InputError, match=r"expected \[below 0, above 0\] of α and β of each joint, \(6, 2, 2\)"):
        hognose.follower(to_both_sides(), LENGTHS, "jacobian", bend_limits=bad)


def sided(name, **changes):
    spec = hognose.load_robot(name).spec
    return Robot.from_spec(
        spec.model_copy(update={"section": tuple(group.model_copy(update=changes) for group in spec.section)})
    )


def test_a_plan_that_bends_to_a_closed_side_fails_and_says_where():
    task = hognose.load_task("obstacle-array")
    largest = np.degrees(hognose.plan(task).angles[..., 0])
    low, high = float(largest.min()), float(largest.max())
    wide = hognose.plan(hognose.Task(task.spec, sided("sjtu-25dof", alpha_range_deg=(low - 0.01, high + 0.01))))
    assert wide.check("bend_limits").ok
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(hognose.Task(task.spec, sided("sjtu-25dof", alpha_range_deg=(low / 2, high + 0.01))))
    check = caught.value.plan.check("bend_limits")
    assert (check.failed, check.detail) == (True, "alpha")
    assert np.degrees(check.value) == pytest.approx(-low, rel=1e-9)
    assert np.degrees(check.limit) == pytest.approx(-low / 2, rel=1e-9)


def test_an_arm_that_slumps_rests_where_its_side_is_closed():
    tired = {"axial_stiffness_N": 1e3, "pretension_N": 0.0, "tension_min_N": 0.0, "tension_max_N": 45.0}
    given = tired | {"free_length": 0.3, "friction": 0.0, "load_factor_min": 1.5}
    for sides in ((-20.0, 20.0), (-4.0, 20.0), (-20.0, 4.0)):
        arm = robot_of([section(count=3, alpha_range_deg=sides)], cables=given, tool_mass=5.0)
        rest = np.degrees(Mechanics.of(arm).uncompensated(np.zeros((1, 3, 2)), (9.81, 0.0, 0.0)).angles[0, :, 0])
        assert rest.max() == pytest.approx(sides[1], rel=1e-12)  # it hangs towards +x
        assert rest.min() >= sides[0] - 1e-9


def test_steering_turns_no_sharper_than_the_narrower_side():
    arm, narrow, wide = (
        sided("sjtu-25dof", alpha_range_deg=sides) for sides in ((-5.0, 20.0), (-5.0, 5.0), (-20.0, 20.0))
    )
    base = hognose.load_task("obstacle-array").base
    found = [CurvatureLimit(robot, base).at(0.3) for robot in (arm, narrow, wide)]
    assert found[0] == found[1]
    assert found[0][0] < found[2][0]
