"""What a robot file says of masses, and of cables as springs."""

import numpy as np
import pytest
from pydantic import ValidationError
from robot_oracles import robot_file, robot_of, section

from hognose.robot import Robot, RobotSpec

SPRINGS = {
    "axial_stiffness_N": 100e3,
    "free_length": 0.3,
    "pretension_N": 40.0,
    "tension_min_N": 10.0,
    "tension_max_N": 195.0,
}


def with_cables(**changes):
    return RobotSpec.model_validate(robot_file(cables={**SPRINGS, **changes}))


def test_masses_and_their_centres_are_those_of_the_groups():
    parts = [section(count=2, link_mass=0.1), section(pitch=0.05, link_mass=0.03, centre_of_mass=0.01)]
    robot = robot_of(parts, tool_mass=0.2, tool_length=0.04)
    np.testing.assert_array_equal(robot.link_masses, [0.1, 0.1, 0.03])
    np.testing.assert_array_equal(robot.centres_of_mass, [0.0455, 0.0455, 0.01])
    assert robot.tool_mass == 0.2
    assert (robot_of().tool_mass, robot_of(tool_length=0.04).centres_of_mass[-1]) == (0.0, 0.0455)


def test_one_value_holds_for_all_sections_or_there_is_one_for_each():
    cables = with_cables(pretension_N=(40.0, 30.0, 20.0)).cables
    assert cables is not None
    owners = np.array([0, 0, 0, 1, 1, 1, 2, 2, 2])
    np.testing.assert_array_equal(cables.for_cables("pretension_N", owners), np.repeat([40.0, 30.0, 20.0], 3))
    np.testing.assert_array_equal(cables.for_cables("axial_stiffness_N", owners), np.full(9, 100e3))
    assert cables.friction == 0.0


def test_a_robot_without_cables_has_none():
    assert robot_of().spec.cables is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"axial_stiffness_N": 0.0}, "axial_stiffness_N"),
        ({"axial_stiffness_N": 1e12}, "axial_stiffness_N"),
        ({"axial_stiffness_N": (100e3, 100e3)}, "cables.axial_stiffness_N: 2 values, but the arm has 3 sections"),
        ({"axial_stiffness_N": (100e3, 100e3, 100.0)}, "of axial_stiffness_N 100 N by 195 %, expected 5 % at most"),
        ({"pretension_N": (40.0,) * 4}, "cables.pretension_N: 4 values, but the arm has 3 sections"),
        ({"pretension_N": 5.0}, "pretension_N 5 N is outside of tension_min_N to tension_max_N, 10 to 195 N"),
        ({"pretension_N": (40.0, 40.0, 200.0)}, "pretension_N 200 N is outside"),
        ({"tension_min_N": -1.0, "pretension_N": 0.0}, "tension_min_N"),
        ({"tension_max_N": 10.0}, "tension_min_N 10 N must be below tension_max_N, which is 10 N"),
        ({"free_length": -0.1}, "free_length"),
        ({"friction": 1.1}, "friction"),
        ({"friction": float("nan")}, "friction"),
        ({"damping": 1.0}, "damping"),
    ],
)
def test_springs_that_cannot_be_are_refused(changes, words):
    with pytest.raises(ValidationError) as caught:
        with_cables(**changes)
    assert words in str(caught.value)


@pytest.mark.parametrize("key", ["axial_stiffness_N", "free_length", "pretension_N", "tension_min_N", "tension_max_N"])
def test_no_property_of_the_springs_is_assumed_silently(key):
    with pytest.raises(ValidationError, match=key):
        RobotSpec.model_validate(robot_file(cables={k: v for k, v in SPRINGS.items() if k != key}))


def test_a_centre_of_mass_lies_on_its_link():
    robot_of([section(centre_of_mass=0.091)])
    with pytest.raises(ValidationError, match=r"centre_of_mass 91\.1 mm lies beyond the link, whose pitch is 91 mm"):
        robot_of([section(centre_of_mass=0.0911)])


@pytest.mark.parametrize(
    "changes",
    [
        {"cables": SPRINGS},
        {"tool_mass": 0.1},
        {"section": (section(count=3, centre_of_mass=0.0455),)},
    ],
)
def test_what_is_given_counts_in_the_fingerprint(changes):
    given = Robot.from_spec(RobotSpec.model_validate(robot_file() | changes))
    assert given.fingerprint != robot_of().fingerprint
