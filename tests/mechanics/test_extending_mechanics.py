"""Mechanics of arms whose sections extend: in each posture those of an arm whose sections keep these lengths."""

import dataclasses

import numpy as np
import pytest
from mechanics_makers import SPRINGS
from robot_oracles import robot_of
from section_makers import of_kind

import hognose
from hognose.errors import InputError
from hognose.mechanics import Mechanics, postures
from hognose.mechanics.pulls import pulls
from hognose.mechanics.rubbing import rubbing
from hognose.mechanics.sensitivity import sensitivity, turned_by
from hognose.planning.loads import loads
from hognose.robot import Robot, RobotSpec

EI = "bending_stiffness_N_m2"
RANGE = (0.06, 0.13)
KEYS = {"pitch": 0.09, "link_mass": 0.05, "bend_limit_deg": 50.0, EI: 0.05}
PULLED = {**SPRINGS, "tension_max_N": 2000.0}


def parts(lengths=None, extend=True):
    """A link, arcs that extend with disks, without, and with their mass at one place, and an arc that does not."""
    long = [0.09] * 5 if lengths is None else lengths
    own = {**KEYS, "length_range": RANGE if extend else None}
    return [
        of_kind("link", pitch=long[0], link_mass=0.1),
        of_kind("arc", **own | {"disks": 5, "pitch": long[1]}),
        of_kind("arc", **own | {"disks": None, "pitch": long[2]}),
        of_kind("arc", **KEYS | {"disks": 3, "pitch": long[3]}),
        of_kind("arc", **own | {"disks": 4, "pitch": long[4], "centre_of_mass": 0.05 * long[4] / 0.09}),
    ]


def arm(friction=0.0, **given):
    return Mechanics.of(robot_of(parts(**given), cables={**PULLED, "friction": friction}, tool_mass=0.04))


def some(mechanics, count=6, seed=0):
    """Angles (T, n, 2), lengths (T, n), and gravity (T, 3)."""
    rng, robot = np.random.default_rng(seed), mechanics.robot
    low, high = robot.length_bounds.T
    angles, lengths = rng.uniform(-0.25, 0.25, (count, robot.sections, 2)), rng.uniform(low, high, (count, low.size))
    return angles, lengths, rng.uniform(-8.0, 8.0, (count, 3))


@pytest.fixture(scope="module")
def able():
    return arm()


@pytest.fixture(scope="module")
def poses(able):
    angles, lengths, gravity = some(able)
    fixed = [arm(lengths=row.tolist(), extend=False) for row in lengths]
    return angles, lengths, gravity, fixed


def close(found, expected, off=1e-9):
    np.testing.assert_allclose(found, expected, rtol=off, atol=off * max(1.0, np.abs(expected).max()))


def test_cables_weight_and_stiffness_are_those_of_an_arm_of_these_lengths(able, poses):
    angles, lengths, gravity, fixed = poses
    both = postures(able.robot, angles, lengths)
    tensions = np.random.default_rng(1).uniform(5.0, 60.0, (len(angles), able.robot.cables))
    close(able.cable_lengths(both), able.robot.cable_lengths(angles, lengths))
    for t, other in enumerate(fixed):
        own, down = angles[t : t + 1], gravity[t : t + 1]
        row = slice(t, t + 1)
        for ask in ("cable_lengths", "cable_jacobian", "cable_hessian"):
            close(getattr(able, ask)(both[row]), getattr(other, ask)(own))
        for ask in ("gravity_torque", "gravity_stiffness", "torque"):
            close(getattr(able, ask)(both[row], down), getattr(other, ask)(own, down))
        for found, expected in zip(
            able.stiffness(both[row], tensions[row], down), other.stiffness(own, tensions[row], down), strict=True
        ):
            close(found, expected)


def test_it_is_held_and_rests_as_an_arm_of_these_lengths(able, poses):
    angles, lengths, gravity, fixed = poses
    both = postures(able.robot, angles, lengths)
    held = able.hold(both, gravity)
    assert held.is_held.all()
    commanded = held.commanded_lengths - 1e-4 * np.arange(able.robot.cables) / able.robot.cables
    settled, sagging = able.settle(both, commanded, gravity), able.uncompensated(both, gravity)
    for t, other in enumerate(fixed):
        own, down = angles[t : t + 1], gravity[t : t + 1]
        there = other.hold(own, down)
        for name in ("tensions", "cable_lengths", "spring_constants", "load_factor", "smallest_stiffness"):
            close(getattr(held, name)[t], getattr(there, name)[0], 1e-7)
        pairs = (settled, other.settle(own, commanded[t : t + 1], down)), (sagging, other.uncompensated(own, down))
        for found, expected in pairs:
            assert found.status[t] == expected.status[0] == 0
            close(found.angles[t], expected.angles[0], 1e-8)
            close(found.tip_shift[t], expected.tip_shift[0], 1e-8)
    assert np.abs(settled.tip_shift).max() > 1e-4
    back = able.settle(both, held.commanded_lengths, gravity, start=angles + 0.02)
    close(back.angles, angles, 1e-8)


def test_what_errors_do_is_what_they_do_to_an_arm_of_these_lengths(poses):
    angles, lengths, gravity, _ = poses
    rubbing_arm = arm(friction=0.1)
    both, ways = (
        postures(rubbing_arm.robot, angles, lengths),
        np.where(np.arange(rubbing_arm.robot.cables) % 2, 1.0, -1.0),
    )
    ways = np.tile(ways, (len(angles), 1))
    held = rubbing_arm.hold(both, gravity)
    found = sensitivity(rubbing_arm, both, held, gravity, ways)
    deviations = (1e-4, 0.05, 0.05)
    pulled, turned = (
        pulls(rubbing_arm, both, held, gravity, deviations, 2.0),
        turned_by(rubbing_arm, both, held, gravity, 0.1),
    )
    rubbed = rubbing(rubbing_arm, both, held, gravity, ways)
    for t, row in enumerate(lengths):
        other = arm(friction=0.1, lengths=row.tolist(), extend=False)
        own, down, way = angles[t : t + 1], gravity[t : t + 1], ways[t : t + 1]
        there = other.hold(own, down)
        expected = sensitivity(other, own, there, down, way)
        for name in ("zero", "share", "friction"):
            close(getattr(found, name)[t], getattr(expected, name)[0], 1e-6)
        of_fixed = pulls(other, own, there, down, deviations, 2.0)
        for each in dataclasses.fields(of_fixed):
            close(getattr(pulled, each.name)[t], getattr(of_fixed, each.name)[0], 1e-6)
        close(turned[t], turned_by(other, own, there, down, 0.1)[0], 1e-6)
        for mine, theirs in zip(rubbed, rubbing(other, own, there, down, way), strict=True):
            close(mine[t], theirs[0], 1e-6)


def test_a_longer_section_springs_back_with_less_and_weighs_more_about_its_beginning():
    """By hand: one arc bent by θ holds the moment EI θ / L, and straight across gravity the moment m g L / 2."""
    single = Mechanics.of(robot_of([of_kind("arc", **KEYS | {"length_range": RANGE})], cables=PULLED))
    for length in RANGE:
        bent = postures(single.robot, np.array([[[0.3, 0.0]]]), np.array([[length]]))
        close(single.torque(bent, (0.0, 0.0, 0.0))[0], [0.05 * 0.3 / length, 0.0], 1e-12)
        straight = postures(single.robot, np.zeros((1, 1, 2)), np.array([[length]]))
        # Its centre moves by L/6 per angle, as x = L θ s²/2 along it.
        close(single.torque(straight, (-10.0, 0.0, 0.0))[0], [0.05 * 10.0 * length / 6.0, 0.0], 1e-12)


def test_angles_alone_are_of_sections_as_long_as_at_rest(able):
    angles, _, gravity = some(able)
    both = postures(able.robot, angles, np.tile(able.robot.link_lengths, (len(angles), 1)))
    np.testing.assert_array_equal(both[..., 2], 1.0)
    np.testing.assert_array_equal(postures(able.robot, angles, None), both)
    np.testing.assert_array_equal(able.hold(angles, gravity).tensions, able.hold(both, gravity).tensions)
    fixed = arm(extend=False)
    np.testing.assert_array_equal(postures(fixed.robot, angles, None), angles)


def test_postures_that_no_arm_has_are_refused(able):
    angles, lengths, gravity = some(able)
    with pytest.raises(InputError, match=r"angles: expected numbers in rad of shape \(T, 5, 2\)"):
        postures(able.robot, angles[0].tolist(), lengths[0])
    with pytest.raises(InputError, match=r"lengths: expected shape"):
        postures(able.robot, angles, lengths[:2])
    both = postures(able.robot, angles, lengths)
    for section, value in ((0, 1.1), (1, 0.0), (2, -1.0)):
        wrong = both.copy()
        wrong[2, section, 2] = value
        with pytest.raises(InputError, match="third column of postures says how many times as long as at rest"):
            able.hold(wrong, gravity)
    with pytest.raises(InputError, match=r"angles: expected numbers in rad of shape \(T, 5, 2\)"):
        arm(extend=False).hold(both, gravity)


def test_the_mechanics_of_a_plan_are_those_of_its_lengths():
    """At some steps against an arm whose sections keep the lengths of that step."""
    plan = hognose.plan(hognose.load_task("baffled-tank"))
    assert plan.held is not None
    found, gravity = loads(plan), plan.task.gravity(plan.at)
    for step in (40, 85, 112):
        said = plan.robot.spec.model_dump(by_alias=True, exclude_none=True)
        (section,) = said["section"]
        del section["length_range"]
        section |= {"count": 1, "cable_azimuth_step_deg": 0.0}
        turned = [np.add(section["cable_azimuths_deg"], 40.0 * i).tolist() for i in range(3)]
        lengths = plan.section_lengths[step].tolist()
        said["section"] = [
            section | {"pitch": length, "cable_azimuths_deg": at} for length, at in zip(lengths, turned, strict=True)
        ]
        fixed = Mechanics.of(Robot.from_spec(RobotSpec.model_validate(said)))
        pose, down = plan.angles[step : step + 1], gravity[step : step + 1]
        sag = np.linalg.norm(fixed.uncompensated(pose, down).tip_shift, axis=1)
        close(found.sag[step], sag[0], 1e-6)
        there = fixed.hold(pose, down)
        close(plan.held.tensions[step], there.tensions[0], 1e-6)
        close(found.sensitivity.zero[step], sensitivity(fixed, pose, there, down, np.ones((1, 9))).zero[0], 1e-6)
        assert abs(sag[0] / found_at_rest(plan, step) - 1.0) > 1e-4


def found_at_rest(plan, step):
    """The sag (m) of the same pose with sections as long as at rest."""
    arm, gravity = plan.task.mechanics, plan.task.gravity(plan.at)
    shift = arm.uncompensated(plan.angles[step : step + 1], gravity[step : step + 1]).tip_shift
    return float(np.linalg.norm(shift))
