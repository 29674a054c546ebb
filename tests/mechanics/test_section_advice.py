"""Advice for arms whose sections bend back by themselves, and what is not known of them."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_makers import DOWN, SPRINGS, poses
from robot_oracles import robot_of, section
from section_arms import EI, arm_of, one_arc
from section_makers import of_kind

from hognose.calibration.model import Model
from hognose.errors import InputError
from hognose.mechanics.advice import stiffer_or_looser, stronger
from hognose.mechanics.remedies import Poses, rounded_up, stiffness_needed
from hognose.planning.tolerance.budget import Budget, ToleranceSpec
from hognose.robot.sections import RigidLink


def bent(arm, share=1.0):
    """The poses of an arm of which each bends a little more, up to a share of the limits."""
    angles = np.linspace(0.0, share, 5)[:, None, None] * arm.robot.bend_limits
    return Poses(angles, np.tile(DOWN, (5, 1)), 4)


def test_advice_for_a_backbone_that_is_too_stiff_is_enough():
    arm = arm_of([one_arc(**{EI: 0.4})], tension_max_N=120.0)
    poses_of_it = bent(arm)
    held = arm.hold(poses_of_it.angles, poses_of_it.gravity)
    assert held.cannot_be_held[-1]
    needed, said = stronger(arm, poses_of_it, 0)
    assert said.startswith(
        f"no tensions hold section 1: raise tension_max_N to {needed:g} N, or lower bending_stiffness"
    )
    share = 0.01 * float(said.split(" to ")[-1].split(" %")[0])
    for enough, short in (
        (replace(arm, tension_max=needed), replace(arm, tension_max=0.98 * needed)),
        (replace(arm, bending=share * arm.bending), replace(arm, bending=1.02 * share * arm.bending)),
    ):
        assert enough.hold(poses_of_it.angles, DOWN).is_held.all()
        assert not short.hold(poses_of_it.angles, DOWN).is_held.all()


def test_advice_for_cables_that_are_too_soft_is_enough():
    """Load factors of an arm that bends back are not proportional to EA."""
    parts = [
        of_kind("joints", joints=5, half_lengths=(0.008, 0.008), cable_azimuth_step_deg=-10.0, count=3, **{EI: 0.02})
    ]
    arm = arm_of(parts, axial_stiffness_N=9e3, pretension_N=60.0, load_factor_min=25.0, tension_max_N=400.0)
    poses_of_it = bent(arm, 0.0)
    held = arm.hold(poses_of_it.angles, DOWN)
    factor = float(held.load_factor.min())
    assert held.is_held.all()
    assert 0 < factor < 25.0
    times = stiffness_needed(arm, poses_of_it, 25.0)
    said = stiffer_or_looser(arm, poses_of_it, 0, factor)
    assert f"take EA ≥ {rounded_up(9.0 * times):g} kN" in said

    def factors(share):
        return replace(arm, axial_stiffness=share * arm.axial_stiffness).hold(poses_of_it.angles, DOWN).load_factor

    assert factors(times).min() >= 25.0 > factors(0.98 * times).min()
    assert times > 25.0 / factor  # as if there were no backbone, it would not be enough


def test_what_is_not_known_of_such_arms_is_refused():
    arm = arm_of([of_kind("arc"), of_kind("joints")])
    with pytest.raises(InputError, match="calibration of test arm: expected an arm of rigid links"):
        Model(arm, DOWN)
    flexures = {"kind": "joints", "joints": 1, EI: 0.05}
    with pytest.raises(InputError, match="of those that bend back, are not sought"):
        Model(arm_of([section(count=3, **flexures)]), DOWN)
    robot = robot_of([section(count=3, **flexures)], cables=SPRINGS)
    with pytest.raises(
        InputError, match=r"mass_percent: what is left .* not known of sections with `bending_stiffness_N"
    ):
        Budget.of(ToleranceSpec(mass_percent=5.0), robot, np.zeros(3))
    with pytest.raises(
        ValueError, match="bending_stiffness_N_m2 is for sections of kind 'hinges' or 'joints' or 'arc'"
    ):
        robot_of([section(**{EI: 0.05})])


def test_links_that_bend_back_are_stiffer_by_their_springs():
    """A stack of one joint has the kernels of links, and the springs of its joints."""
    free, stiff = (arm_of([section(count=3, kind="joints", joints=1, **keys)]) for keys in ({}, {EI: 0.0091}))
    angles = poses(free, np.random.default_rng(2), 2, 0.5)
    assert isinstance(stiff.robot.model, RigidLink)
    np.testing.assert_allclose(stiff.springs, 0.1, rtol=1e-12)
    np.testing.assert_allclose(stiff.torque(angles, DOWN) - free.torque(angles, DOWN), 0.1 * angles.reshape(2, 6))
    tensions = np.full((2, 9), 40.0)
    (more, same), (less, other) = stiff.stiffness(angles, tensions, DOWN), free.stiffness(angles, tensions, DOWN)
    np.testing.assert_allclose(more - less, np.broadcast_to(0.1 * np.eye(6), (2, 6, 6)), rtol=0, atol=1e-10)
    np.testing.assert_array_equal(same, other)
