"""Cable lengths and weight: derivatives against finite differences, NumPy twins and MuJoCo."""

from typing import Any

import mujoco
import numpy as np
import pytest
from mechanics_makers import DOWN, energy_of_weight, length_derivatives, paper_arm, poses, random_arm, slopes
from robot_oracles import mjcf

mj: Any = mujoco  # its names are made at run time

ARMS = [paper_arm, lambda: paper_arm(30), lambda: paper_arm(tool_mass=0.3, tool_length=0.05), lambda: random_arm(1),
        lambda: random_arm(2, 1), lambda: random_arm(3, 9)]  # fmt: skip
arms = pytest.mark.parametrize("make", ARMS)


@arms
def test_the_jacobian_of_lengths_is_their_derivative(make):
    arm, rng = make(), np.random.default_rng(0)
    angles = poses(arm, rng, 4)
    J = arm.cable_jacobian(angles)
    np.testing.assert_allclose(J, slopes(arm.robot.cable_lengths, angles, 1e-3), rtol=0, atol=1e-11)


@arms
def test_the_hessian_of_lengths_is_the_derivative_of_the_jacobian(make):
    arm, rng = make(), np.random.default_rng(1)
    angles = poses(arm, rng, 3)
    H, n = arm.cable_hessian(angles), arm.robot.sections
    whole = np.zeros((*H.shape[:2], n, 2, n, 2))
    for j in range(n):
        whole[:, :, j, :, j, :] = H[:, :, j]
    found = slopes(arm.cable_jacobian, angles, 1e-3)
    np.testing.assert_allclose(whole.reshape(found.shape), found, rtol=0, atol=1e-10)


@arms
def test_kernels_agree_with_vectors_between_holes(make):
    arm, rng = make(), np.random.default_rng(2)
    angles = poses(arm, rng, 5)
    J, H = arm.cable_jacobian(angles), arm.cable_hessian(angles)
    for t, pose in enumerate(angles):
        first, second = length_derivatives(arm.robot, pose)
        np.testing.assert_allclose(J[t].reshape(first.shape), first, rtol=0, atol=1e-15)
        np.testing.assert_allclose(H[t], second, rtol=0, atol=1e-15)


def test_cables_that_end_before_a_joint_do_not_change_with_it():
    arm = random_arm(4)
    J = arm.cable_jacobian(poses(arm, np.random.default_rng(3), 2))
    for k, section in enumerate(arm.robot.cable_sections):
        assert (J[:, k, 2 * section + 2 :] == 0.0).all()
        assert (J[:, k, : 2 * section + 2] != 0.0).all()


@arms
@pytest.mark.parametrize("gravity", [DOWN, np.array([3.0, -2.0, 8.0])])
def test_torques_of_the_weight_are_the_derivative_of_its_energy(make, gravity):
    arm, rng = make(), np.random.default_rng(4)
    angles = poses(arm, rng, 3)

    def energy(many):
        return np.array([energy_of_weight(arm, one, gravity) for one in many])

    torque = arm.gravity_torque(angles, gravity)
    np.testing.assert_allclose(torque, slopes(energy, angles, 1e-3), rtol=0, atol=2e-10)


@arms
def test_the_stiffness_of_the_weight_is_the_derivative_of_its_torques(make):
    arm, rng = make(), np.random.default_rng(5)
    angles, gravity = poses(arm, rng, 3), np.array([3.0, -9.0, 2.0])
    found = arm.gravity_stiffness(angles, gravity)
    expected = slopes(lambda many: arm.gravity_torque(many, gravity), angles, 1e-3)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-10)
    np.testing.assert_array_equal(found, np.swapaxes(found, 1, 2))


@arms
def test_lengths_jacobians_and_torques_are_mujocos(make):
    arm, rng = make(), np.random.default_rng(6)
    model = mj.MjModel.from_xml_string(mjcf(arm.robot))
    data = mj.MjData(model)
    gravity = np.array([1.0, -9.0, 3.0])
    model.opt.gravity[:] = gravity
    angles = poses(arm, rng, 6)
    lengths, J = arm.robot.cable_lengths(angles), arm.cable_jacobian(angles)
    torque = arm.gravity_torque(angles, gravity)
    for t, pose in enumerate(angles):
        data.qpos[:], data.qvel[:] = pose.ravel(), 0.0
        mj.mj_forward(model, data)
        np.testing.assert_allclose(lengths[t], data.ten_length, rtol=0, atol=1e-12)
        np.testing.assert_allclose(torque[t], data.qfrc_bias, rtol=0, atol=1e-12)
        np.testing.assert_allclose(J[t], dense(model, data), rtol=0, atol=1e-12)


def dense(model, data):
    """The Jacobian of the tendons as a matrix."""
    out = np.zeros((model.ntendon, model.nv))
    if np.size(data.ten_J) == out.size:
        return np.array(data.ten_J).reshape(out.shape)
    for k in range(model.ntendon):
        start, count = model.ten_J_rowadr[k], model.ten_J_rownnz[k]
        out[k, model.ten_J_colind[start : start + count]] = data.ten_J[start : start + count]
    return out


def test_gravity_may_differ_from_step_to_step():
    arm, rng = random_arm(7), np.random.default_rng(7)
    angles, gravity = poses(arm, rng, 4), rng.normal(size=(4, 3))
    together = arm.gravity_torque(angles, gravity)
    for t in range(4):
        np.testing.assert_array_equal(together[t], arm.gravity_torque(angles[t : t + 1], gravity[t])[0])


def test_an_arm_that_stands_upright_needs_no_torque():
    arm = paper_arm(tool_mass=0.1)
    straight = np.zeros((1, 12, 2))
    np.testing.assert_allclose(arm.gravity_torque(straight, (0.0, 0.0, -9.8)), 0.0, atol=1e-15)
    weight = arm.gravity_stiffness(straight, (0.0, 0.0, -9.8))[0]
    assert np.linalg.eigvalsh(weight)[-1] < 0 < np.linalg.eigvalsh(-weight)[0]
