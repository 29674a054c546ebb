"""How the tip moves with errors: against arms that have them, brought to rest."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_makers import DOWN, paper_arm, poses, random_arm, slopes

from hognose.mechanics.sensitivity import SHARE, ZERO, _lost, sensitivity, tip_jacobian


def of(arm, angles, ways=None):
    held = arm.hold(angles, DOWN)
    still = np.zeros((len(angles), arm.robot.cables)) if ways is None else ways
    return held, sensitivity(arm, angles, held, np.broadcast_to(DOWN, (len(angles), 3)), still)


@pytest.mark.parametrize("make", [paper_arm, lambda: random_arm(3, 5)])
def test_the_jacobian_of_the_tip_is_its_derivative(make):
    arm = make()
    angles = poses(arm, np.random.default_rng(0), 3)
    expected = slopes(lambda many: arm.robot.joint_positions(many)[:, -1], angles, 1e-3)
    np.testing.assert_allclose(tip_jacobian(arm, angles), expected, rtol=0, atol=1e-10)


def test_larger_masses_and_softer_cables_lower_the_tip_by_what_is_said():
    arm = paper_arm()
    angles = poses(arm, np.random.default_rng(1), 4, 0.3)
    held, found = of(arm, angles)
    share = 1e-3
    heavier = replace(arm, links=arm.links * [1.0, 1.0 + share, 1.0], tool_mass=arm.tool_mass * (1 + share))
    softer = replace(arm, axial_stiffness=arm.axial_stiffness * (1 - share))
    for other in (heavier, softer):
        moved = other.settle(angles, held.commanded_lengths, DOWN).tip_shift
        np.testing.assert_allclose(np.linalg.norm(moved, axis=1), found.share * share / SHARE, rtol=5e-3)


def test_errors_of_zeros_move_the_tip_by_what_is_said():
    """The mean square over independent errors is the sum over the cables one by one."""
    arm = random_arm(4, 4)
    angles = poses(arm, np.random.default_rng(2), 2, 0.3)
    held, found = of(arm, angles)
    assert held.is_held.all()
    squares, error = np.zeros(2), 1e-7
    for k in range(arm.robot.cables):
        commanded = held.commanded_lengths.copy()
        commanded[:, k] += error
        squares += (arm.settle(angles, commanded, DOWN).tip_shift ** 2).sum(axis=1)
    np.testing.assert_allclose(found.zero, np.sqrt(squares) * ZERO / error, rtol=1e-4)


def test_friction_leaves_the_mean_of_the_tension_and_falls_towards_the_tip():
    arm = paper_arm()
    angles = poses(arm, np.random.default_rng(3), 3, 0.4)
    held = arm.hold(angles, DOWN)
    lost = _lost(arm, angles, held.tensions, 0.1)
    assert (np.diff(lost[:, -3:], axis=2) < 0).all()
    assert (lost[:, -3:, 0] > 0).all()
    assert (lost[:, -3:, -1] < 0).all()
    np.testing.assert_allclose(_lost(arm, angles, held.tensions, 0.0), 0.0, atol=1e-13)


def test_cables_that_stand_still_rub_nowhere_and_the_way_back_is_the_mirror_image():
    arm = paper_arm(friction=0.2)
    rng = np.random.default_rng(4)
    angles, ways = poses(arm, rng, 3, 0.4), rng.normal(size=(3, 36))
    np.testing.assert_array_equal(of(arm, angles)[1].friction, 0.0)
    there, back = of(arm, angles, ways)[1], of(arm, angles, -ways)[1]
    np.testing.assert_allclose(there.friction, back.friction, rtol=1e-12)
    assert (there.friction > of(replace(arm, friction=0.1), angles, ways)[1].friction).all()


def test_an_arm_that_buckles_has_no_sensitivity():
    arm = paper_arm(axial_stiffness_N=25e3, pretension_N=80.0)
    _, found = of(arm, np.zeros((1, 12, 2)))
    assert np.isnan([found.zero, found.share, found.friction]).all()
