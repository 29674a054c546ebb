"""What the mechanics of a robot are made of, and what they refuse."""

from dataclasses import replace
from typing import Any, cast
from unittest.mock import patch

import numpy as np
import pytest
from mechanics_makers import DOWN, SPRINGS, paper_arm, poses, random_arm
from robot_oracles import robot_of, section

import hognose
from hognose.errors import InputError
from hognose.mechanics import Mechanics, mechanics, why_unknown
from hognose.robot import Robot, RobotSpec


def test_values_are_those_of_the_robot_file_cable_by_cable():
    parts = [section(count=2), section(pitch=0.05, link_mass=0.03, cable_azimuths_deg=(0.0, 90.0, 180.0, 270.0))]
    springs = {**SPRINGS, "axial_stiffness_N": (1e5, 2e5, 3e5), "pretension_N": (40.0, 30.0, 20.0), "friction": 0.1}
    arm = Mechanics.of(robot_of(parts, cables=springs, tool_mass=0.2, tool_length=0.01))
    np.testing.assert_array_equal(arm.axial_stiffness, [1e5] * 3 + [2e5] * 3 + [3e5] * 4)
    np.testing.assert_array_equal(arm.pretension, [40.0] * 3 + [30.0] * 3 + [20.0] * 4)
    np.testing.assert_allclose(arm.links, [[0.091, 0.062, 0.0455]] * 2 + [[0.06, 0.03, 0.025]], rtol=1e-14)
    assert (arm.tension_min, arm.tension_max, arm.free_length, arm.friction) == (10.0, 195.0, 0.3, 0.1)
    assert arm.tool_mass == 0.2


def test_a_cable_is_as_stiff_as_it_is_short():
    arm = paper_arm(2)
    lengths = arm.robot.straight_cable_lengths
    np.testing.assert_allclose(arm.spring_constants(lengths), 100e3 / (lengths + 0.3), rtol=1e-15)


def test_commanded_lengths_are_shorter_by_the_stretch():
    arm = random_arm(1)
    angles = poses(arm, np.random.default_rng(0), 5, 0.3)
    held = arm.hold(angles, DOWN)
    stretch = held.tensions * (held.cable_lengths + arm.free_length) / arm.axial_stiffness
    np.testing.assert_allclose(held.stretch, stretch, rtol=1e-13)
    np.testing.assert_allclose(held.commanded_lengths, held.cable_lengths - stretch, rtol=1e-14)
    np.testing.assert_allclose(
        held.cable_lengths, arm.robot.cable_lengths(poses(arm, np.random.default_rng(0), 5, 0.3))
    )


def test_a_plan_in_parts_is_the_same():
    arm = random_arm(2)
    angles = poses(arm, np.random.default_rng(1), 20, 0.3)
    whole = arm.hold(angles, DOWN)
    with patch.object(mechanics, "_LARGEST_PART", 1000):
        parts = arm.hold(angles, DOWN)
    for name in ("tensions", "cable_lengths", "left", "smallest_stiffness", "load_factor"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(parts.is_held, ~parts.cannot_be_held)
    assert arm.hold(angles[:0], DOWN).tensions.shape == (0, arm.robot.cables)


def test_tensions_do_not_depend_on_the_stiffness_and_the_load_factor_is_proportional_to_it():
    arm = paper_arm()
    angles = poses(arm, np.random.default_rng(2), 6, 0.3)
    one = arm.hold(angles, DOWN)
    other = replace(arm, axial_stiffness=2.5 * arm.axial_stiffness).hold(angles, DOWN)
    np.testing.assert_allclose(other.tensions, one.tensions, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.load_factor, 2.5 * one.load_factor, rtol=1e-12)


def test_the_arm_hangs_the_same_way_whichever_way_it_is_turned_with_gravity():
    """An arm on its side with gravity turned with it: a rotation about z that carries every hole to another one."""
    arm = Mechanics.of(robot_of([section(count=3, cable_azimuths_deg=(0.0, 90.0, 180.0, 270.0))], cables=SPRINGS))
    angles = np.zeros((1, 3, 2))
    down, aside = arm.hold(angles, (0.0, -9.8, 0.0)), arm.hold(angles, (9.8, 0.0, 0.0))
    np.testing.assert_allclose(aside.load_factor, down.load_factor, rtol=1e-12)
    np.testing.assert_allclose(np.roll(aside.tensions.reshape(3, 4), 3, axis=1), down.tensions.reshape(3, 4), rtol=1e-9)


def test_a_robot_that_does_not_say_its_cables_has_no_mechanics():
    robot = robot_of()
    assert "no table [cables]" in why_unknown(robot)
    with pytest.raises(InputError, match=r"mechanics of test arm: the robot file has no table \[cables\]; give axial"):
        Mechanics.of(robot)


def test_an_arm_of_too_many_sections_is_refused():
    parts = [section(count=mechanics.MOST_SECTIONS + 1, pitch=0.0211)]
    with pytest.raises(InputError, match="301 sections are too many; at most 300"):
        Mechanics.of(robot_of(parts, cables=SPRINGS))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda arm: arm.hold(np.zeros((2, 3)), DOWN), r"angles: expected numbers in rad of shape \(T, 12, 2\)"),
        (lambda arm: arm.hold(np.full((1, 12, 2), np.nan), DOWN), "angles: .* 24 values are not finite"),
        (lambda arm: arm.hold(np.zeros((2, 12, 2)), np.zeros((3, 3))), r"gravity: expected shape \(3,\) or \(2, 3\)"),
        (lambda arm: arm.gravity_torque(np.zeros((2, 12, 2)), 9.8), "gravity: expected numbers in m/s²"),
        (lambda arm: arm.gravity_torque(np.zeros((2, 12, 2)), (0, -98066.5, 0)), "none beyond 10,000 m/s²"),
        (lambda arm: arm.settle(np.zeros((2, 12, 2)), np.zeros((2, 3)), DOWN), r"commanded: .* shape \(2, 36\)"),
        (lambda arm: arm.stiffness(np.zeros((2, 12, 2)), np.zeros(36), DOWN), r"tensions: .* shape \(2, 36\)"),
        (lambda arm: arm.spring_constants(np.zeros(3)), r"cable_lengths: .* shape \(..., 36\)"),
        (lambda arm: Mechanics.of(cast("Any", "sjtu-25dof")), "robot: expected a hognose.Robot"),
    ],
)
def test_wrong_arguments_are_named(call, words):
    with pytest.raises(InputError, match=words):
        call(paper_arm())


def test_the_bundled_arms_can_be_given_cables():
    robot = hognose.load_robot("sjtu-25dof")
    spec = robot.spec.model_dump(by_alias=True) | {"cables": SPRINGS}
    arm = Mechanics.of(Robot.from_spec(RobotSpec.model_validate(spec)))
    assert arm.hold(np.zeros((1, 12, 2)), DOWN).load_factor[0] == pytest.approx(4.04, abs=0.01)


def test_arrays_of_an_arm_cannot_be_written_to():
    stiff = np.full(6, 1e5)
    arm = replace(paper_arm(2), axial_stiffness=stiff)
    for name in ("links", "axial_stiffness", "pretension"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(arm, name)[:] = 0.0
    stiff[:] = 1.0  # still its owner's
    assert (arm.axial_stiffness == 1e5).all()
