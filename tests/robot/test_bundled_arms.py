"""The figures of the bundled arms, against those that were published."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InputError
from hognose.robot import Robot, RobotSpec
from hognose.robot.drum import Drum


def bent(robot, section, alpha, beta=0.0):
    """Angles (n, 2) rad of an arm that bends in one section."""
    out = np.zeros((robot.sections, 2))
    out[section] = alpha, beta
    return out


@pytest.mark.parametrize(
    ("name", "kinds", "sections", "cables", "length", "diameters"),
    [
        ("zju-24cable", {"hinges"}, 8, 24, 1.225, (90, 90)),
        ("casia-coiled", {"link"}, 12, 36, 2.4, (78, 50)),
        ("on-wing-taper", {"joints"}, 12, 36, 1.2, (40, 13)),
        ("safire-18dof", {"link"}, 9, 27, 2.2, (55.9, 55.9)),
        ("metabot-3arc", {"arc"}, 3, 9, 0.114, (7, 7)),
    ],
)
def test_sizes_are_those_of_the_sources(name, kinds, sections, cables, length, diameters):
    arm = hognose.load_robot(name)
    assert {group.kind for group in arm.spec.section} == kinds
    assert (arm.sections, arm.cables) == (sections, cables)
    assert arm.length == pytest.approx(length, rel=1e-12)
    assert (2e3 * arm.body_radii[[0, -1]]).round(1).tolist() == list(diameters)
    assert {"feed", "limits", "base_length"} <= set(arm.assumed)
    assert (arm.spec.cables is not None) == (name == "metabot-3arc")
    # No two cables have the same hole.
    assert len({round(azimuth, 6) for azimuth in np.degrees(arm.cable_azimuths) % 360}) == cables


def software_length(first, second, hole):
    """Length (mm) of a cable through a section of the 24-cable arm as its software has it: x forward, z up."""
    start = np.array([0.0, -40 * math.sin(hole * math.pi / 12), 40 * math.cos(hole * math.pi / 12)])
    end = Rotation.from_rotvec([0.0, -second, 0.0]).apply(start) + np.array([61.0, 0.0, 0.0])
    return np.linalg.norm(Rotation.from_rotvec([0.0, 0.0, first]).apply(end) - start)


def test_the_24_cable_arm_pulls_its_cables_as_its_software_does():
    arm, angles = hognose.load_robot("zju-24cable"), np.random.default_rng(0).uniform(-0.52, 0.52, (8, 2))
    changes = 1e3 * (arm.cable_lengths(angles) - arm.cable_lengths(np.zeros((8, 2))))
    for section in range(8):
        for which in range(3):
            hole = section + 8 * which
            passed = [software_length(first, -second, hole) - 61.0 for first, second in angles[: section + 1]]
            assert changes[3 * section + which] == pytest.approx(sum(passed), abs=1e-9)


def test_the_24_cable_arm_winds_its_cables_as_its_software_does():
    arm = hognose.load_robot("zju-24cable")
    drums, ratios = (27, 39, 55, 67, 67, 67, 64, 67), (25, 28, 28, 25, 16, 7, 4, 4)
    for section, (drum, ratio) in enumerate(zip(drums, ratios, strict=True)):
        degrees_per_mm = 360 * ratio / math.sqrt(6**2 + (math.pi * (drum + 2.5)) ** 2)
        counts_per_mm = 1e-3 / arm.travel_per_count[arm.cable_sections == section]
        np.testing.assert_allclose(counts_per_mm, 100 * degrees_per_mm, rtol=2e-6)
    assert {group.transmission.counts_per_turn for group in arm.spec.section} == {36_000}
    # From the last hinge to the tip.
    second = arm.joint_positions(np.zeros((8, 2)))[-2, 2] + 0.061
    assert arm.length - second == pytest.approx(0.114, rel=1e-12)


def test_the_coiled_arm_bends_on_its_drum_by_more_than_its_description_allows():
    arm = hognose.load_robot("casia-coiled")
    assert 2 * math.degrees(math.asin(0.2 / 0.84)) == pytest.approx(27.55, abs=5e-3)
    assert Drum.before(np.zeros(3), arm, 0.42, 0.3, np.eye(3)).radius == 0.42
    spec = arm.spec.model_dump(by_alias=True)
    described = [{**group, "bend_limit_deg": math.degrees(0.34888)} for group in spec["section"]]
    assert arm.spec.section[0].bend_ranges == ((0.0, 19.989), (-28.07, 28.07))  # the side to which the drum bends it
    strict = Robot.from_spec(RobotSpec.model_validate({**spec, "section": described}))
    with pytest.raises(InputError, match=r"bends by 27\.55 deg, at most 19\.99 deg; take a radius of 576"):
        Drum.before(np.zeros(3), strict, 0.42, 0.3, np.eye(3))
    assert arm.cable_radii[::3].round(5).tolist() == [0.035, 0.02875, *[0.0225] * 10]
    assert arm.joint_before.tolist() == [0.025, *[0.01] * 11]
    # A distal cable runs on the circle of the disk that it passes, and changes by that.
    assert arm.cable_circles[-1].tolist() == [0.035, 0.035, 0.02875, *[0.0225] * 10]
    azimuths, at = np.radians([110, 230, 350]), math.radians(-20)
    pulled = np.abs(arm.straight_cable_lengths - arm.cable_lengths(bent(arm, 0, at)))[-3:]
    for radius, change, azimuth in zip([0.035] * 3, pulled, azimuths, strict=True):
        hole = radius * np.array([math.cos(azimuth), math.sin(azimuth)])
        behind = (hole[0] * math.cos(at) + 0.01 * math.sin(at), 0.01 * math.cos(at) - hole[0] * math.sin(at))
        assert change == pytest.approx(abs(0.035 - math.hypot(behind[0] - hole[0], behind[1] + 0.025)), abs=1e-15)


def test_the_on_wing_arm_tapers_evenly_and_turns_by_a_right_angle_in_one_section():
    arm = hognose.load_robot("on-wing-taper")
    np.testing.assert_allclose(2e3 * arm.body_radii, np.linspace(40, 13, 12), atol=5e-3)
    np.testing.assert_allclose(np.degrees(arm.bend_limits), 90.0, rtol=1e-12)
    assert (np.diff(arm.cable_radii) <= 0).all()
    assert (np.diff(arm.cable_circles[-1]) <= 0).all()
    np.testing.assert_array_equal(arm.cable_circles[-1, 1:], arm.cable_radii[::3])
    for alpha, beta, ahead in ((90, 0, (1, 0, 0)), (0, -90, (0, 1, 0))):
        pose = arm.tip_pose(bent(arm, 5, math.radians(alpha), math.radians(beta)))
        np.testing.assert_allclose(pose[:3, 2], ahead, atol=1e-12)


def test_the_round_body_of_the_flat_arm_contains_it_and_no_more():
    arm = hognose.load_robot("safire-18dof")
    corner = math.hypot(0.0125, 0.025)
    assert (arm.body_radii >= corner).all()
    assert (arm.body_radii < corner + 1e-6).all()
    assert arm.cable_radii.max() < 0.0125  # cables are within the flat body


def test_tendons_of_the_continuum_arm_run_straight_from_disk_to_disk():
    arm, bend = hognose.load_robot("metabot-3arc"), math.radians(60)
    change = arm.cable_lengths(bent(arm, 0, bend)) - arm.cable_lengths(np.zeros((3, 2)))
    # Ten times the chord of a circle of the backbone's radius less the tendon's, by 6 degrees.
    for cable, azimuth in enumerate(np.radians([0, 120, 240, 40, 160, 280, 80, 200, 320])):
        circle = 0.038 / bend - 0.0025 * math.cos(azimuth)
        assert change[cable] == pytest.approx(20 * circle * math.sin(bend / 20) - 0.038, abs=1e-15)
    np.testing.assert_allclose(np.degrees(arm.bend_limits), 75.0, rtol=1e-12)
