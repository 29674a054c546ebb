"""Stiffness, buckling and where the arm comes to rest."""

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from mechanics_makers import DOWN, paper_arm, poses, random_arm, slopes
from robot_oracles import mjcf

from hognose.mechanics import AT_LIMIT, STABLE, UNSETTLED

mj: Any = mujoco

NONE = np.zeros(3)


def torques_of(arm, angles, commanded, constants, gravity):
    """All joint torques (T, 2n) with the motors held, from the definitions."""
    tensions = constants * np.maximum(arm.robot.cable_lengths(angles) - commanded, 0.0)
    return np.einsum("tka,tk->ta", arm.cable_jacobian(angles), tensions) + arm.gravity_torque(angles, gravity)


@pytest.mark.parametrize("seed", range(5))
def test_tangent_stiffness_is_the_derivative_of_the_torques(seed):
    rng = np.random.default_rng(seed)
    arm = random_arm(seed, 4) if seed else paper_arm()
    angles, gravity = poses(arm, rng, 1, 0.5), rng.normal(size=3) * 6
    tensions = rng.uniform(10, 100, (1, arm.robot.cables))
    constants = arm.spring_constants(arm.robot.cable_lengths(angles))
    commanded = arm.robot.cable_lengths(angles) - tensions / constants
    elastic, geometric = arm.stiffness(angles, tensions, gravity)
    found = slopes(lambda many: torques_of(arm, many, commanded, constants, gravity), angles, 1e-4)
    np.testing.assert_allclose(elastic + geometric, found, rtol=0, atol=1e-8)


@pytest.mark.parametrize("cables", [3, 4, 7])
@pytest.mark.parametrize("share", [0.5, 0.999, 1.001, 2.0])
def test_a_straight_joint_buckles_at_the_tension_of_the_closed_form(cables, share):
    """A cable of tension T has the stiffness -T h1 h2 / (h1 + h2) at a straight joint, and k r² / 2 on average."""
    from mechanics_makers import SPRINGS
    from robot_oracles import robot_of, section

    from hognose.mechanics import Mechanics

    h1, h2, r = 0.0105, 0.02, 0.019
    part = section(half_lengths=(h1, h2), cable_azimuths_deg=tuple(np.arange(cables) * 360.0 / cables))
    springs = {**SPRINGS, "axial_stiffness_N": 20e3}
    arm = Mechanics.of(robot_of([part], cables=springs))
    straight = np.zeros((1, 1, 2))
    constant = arm.spring_constants(arm.robot.cable_lengths(straight))[0, 0]
    critical = constant * r**2 * (h1 + h2) / (2 * h1 * h2)
    arm = replace(arm, pretension=np.full(cables, share * critical), tension_min=0.0, tension_max=1e4)
    held = arm.hold(straight, NONE)
    np.testing.assert_allclose(held.load_factor, 1 / share, rtol=1e-12)
    assert (held.smallest_stiffness[0] > 0) == (share < 1)
    expected = cables * (constant * r**2 / 2 - share * critical * h1 * h2 / (h1 + h2))
    np.testing.assert_allclose(held.smallest_stiffness, expected, rtol=1e-9)


@pytest.mark.parametrize(("stiffness", "critical"), [(25e3, 40.0), (50e3, 80.0), (100e3, 161.0)])
def test_the_straight_arm_of_the_paper_buckles_at_the_measured_pretensions(stiffness, critical):
    arm = paper_arm(axial_stiffness_N=stiffness, tension_max_N=1000.0)
    held = arm.hold(np.zeros((1, 12, 2)), NONE)
    assert held.load_factor[0] * 40.0 == pytest.approx(critical, rel=0.01)


@pytest.mark.parametrize("seed", range(8))
def test_load_factor_and_smallest_eigenvalue_are_of_one_mind(seed):
    rng = np.random.default_rng(seed)
    arm = random_arm(seed, 5, tension_max_N=2000.0)
    angles, gravity = poses(arm, rng, 6, 0.5), rng.normal(size=3) * 6
    arm = replace(arm, pretension=np.full(arm.robot.cables, rng.uniform(20, 1500)))
    held = arm.hold(angles, gravity)
    np.testing.assert_array_equal(held.load_factor > 1, held.smallest_stiffness > 0)
    elastic, geometric = arm.stiffness(angles, held.tensions, gravity)
    for t, factor in enumerate(held.load_factor):
        assert np.isfinite(factor)
        values = np.linalg.eigvalsh(elastic[t] + factor * geometric[t])
        assert abs(values[0]) < 1e-10 * values[-1]
        assert np.linalg.eigvalsh(elastic[t] + 0.99 * factor * geometric[t])[0] > 0


def test_an_arm_without_tension_and_weight_never_buckles():
    arm = paper_arm(pretension_N=0.0, tension_min_N=0.0)
    assert arm.hold(np.zeros((1, 12, 2)), NONE).load_factor[0] == np.inf


@pytest.mark.parametrize("make", [paper_arm, lambda: random_arm(1), lambda: random_arm(2, 9)])
def test_commanded_lengths_bring_the_arm_to_the_planned_pose(make):
    """The round trip: pose, tensions, commanded lengths, and back to the pose and the tensions."""
    arm, rng = make(), np.random.default_rng(0)
    angles = poses(arm, rng, 8, 0.3)
    held = arm.hold(angles, DOWN)
    sound = held.is_held & (held.load_factor > 1.2)
    assert sound.sum() >= 4
    elsewhere = angles[sound] + rng.uniform(-0.02, 0.02, angles[sound].shape)
    found = arm.settle(angles[sound], held.commanded_lengths[sound], DOWN, elsewhere)
    np.testing.assert_array_equal(found.status, STABLE)
    np.testing.assert_allclose(found.angles, angles[sound], rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.tensions, held.tensions[sound], rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.tip_shift, 0.0, atol=1e-10)


def settled(arm, angles, gravity=DOWN):
    lengths = arm.robot.cable_lengths(angles)
    constants = arm.spring_constants(lengths)
    commanded = lengths - arm.pretension / constants
    return arm.uncompensated(angles, gravity), commanded, constants


@pytest.mark.parametrize("stiffness", [50e3, 100e3])
@pytest.mark.parametrize("pretension", [0.0, 10.0, 30.0])
def test_an_arm_at_rest_is_in_equilibrium(stiffness, pretension):
    arm = paper_arm(axial_stiffness_N=stiffness, pretension_N=pretension, tension_min_N=0.0)
    angles = poses(arm, np.random.default_rng(1), 12, 0.3)
    found, commanded, constants = settled(arm, angles)
    assert (found.status == STABLE).all()
    torques = torques_of(arm, found.angles, commanded, constants, DOWN)
    np.testing.assert_allclose(torques, 0.0, atol=1e-9)
    pulled = constants * np.maximum(arm.robot.cable_lengths(found.angles) - commanded, 0.0)
    np.testing.assert_allclose(found.tensions, pulled, rtol=0, atol=1e-8)
    stiff = slopes(lambda many: torques_of(arm, many, commanded, constants, DOWN), found.angles, 1e-7)
    assert (np.linalg.eigvalsh(stiff)[:, 0] > 0).all()


@pytest.mark.parametrize("pretension", [0.0, 20.0])
def test_mujoco_finds_the_same_rest(pretension):
    """With tendons as springs that only pull, nothing accelerates in MuJoCo where our arm rests."""
    arm = paper_arm(6, axial_stiffness_N=50e3, pretension_N=pretension, tension_min_N=0.0, tool_mass=0.1)
    angles = poses(arm, np.random.default_rng(2), 6, 0.5)
    found, commanded, constants = settled(arm, angles)
    assert (found.status == STABLE).all()
    model = mj.MjModel.from_xml_string(mjcf(arm.robot))
    data = mj.MjData(model)
    model.opt.gravity[:] = DOWN
    for t in range(len(angles)):
        model.tendon_stiffness[:] = constants[t]
        model.tendon_lengthspring[:, 0], model.tendon_lengthspring[:, 1] = 0.0, commanded[t]
        data.qpos[:], data.qvel[:] = found.angles[t].ravel(), 0.0
        mj.mj_forward(model, data)
        np.testing.assert_allclose(data.qfrc_passive, data.qfrc_bias, rtol=0, atol=1e-9)


def test_the_tip_hangs_by_what_was_measured():
    arm = paper_arm(axial_stiffness_N=50e3, pretension_N=10.0, tension_min_N=0.0)
    sag = arm.uncompensated(np.zeros((1, 12, 2)), DOWN).tip_shift[0]
    assert -0.016 < sag[1] < -0.008
    assert abs(sag[0]) < 1e-3


def test_too_much_pretension_makes_the_arm_collapse():
    arm = paper_arm(axial_stiffness_N=25e3, pretension_N=60.0)
    straight = np.zeros((1, 12, 2))
    assert arm.hold(straight, DOWN).load_factor[0] < 1
    found = arm.uncompensated(straight, DOWN)
    assert not found.is_stable[0]
    assert np.linalg.norm(found.tip_shift) > 0.05
    upright = arm.uncompensated(straight, (0.0, 0.0, -9.8))  # exactly in balance, and still it falls
    assert not upright.is_stable[0]
    assert np.abs(upright.angles).max() == arm.robot.bend_limits.max()


def test_joint_limits_hold_an_arm_that_slumps():
    arm = paper_arm(3, axial_stiffness_N=1e3, pretension_N=0.0, tension_min_N=0.0, tension_max_N=45.0, tool_mass=5.0)
    found = arm.uncompensated(np.zeros((1, 3, 2)), DOWN)
    assert found.status[0] == AT_LIMIT
    assert not found.is_stable[0]
    assert (np.abs(found.angles) <= arm.robot.bend_limits).all()
    assert np.isclose(np.abs(found.angles), arm.robot.bend_limits, rtol=1e-14).any()


def test_what_is_said_of_steps_is_told_apart():
    assert len({STABLE, AT_LIMIT, UNSETTLED}) == 3
