"""Mechanics of arms with sections of other kinds: derivatives, closed forms, many small links, and MuJoCo."""

import math
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from mechanics_makers import DOWN, poses, random_arm, slopes
from robot_oracles import section
from section_arms import EI, arm_of, mixed_arm, one_arc
from section_makers import dense_line, mixed, of_kind, stretched

from hognose.mechanics import STABLE
from hognose.mechanics.sensitivity import SHARE, lost_by_friction, sensitivity, tip_jacobian

mj: Any = mujoco  # its names are made at run time


def energy(arm, angles, gravity, parts=40):
    """U = -Σ m g·p (J) in one pose (n, 2): masses on a dense centre line, with Simpson's rule on each part."""
    points, ends, _ = dense_line(arm.robot, angles, 2 * parts)
    total = -arm.tool_mass * gravity @ points[-1]
    for i, group in enumerate(each for each in arm.robot.spec.section for _ in range(each.count)):
        line = points[ends[i] : ends[i + 1] + 1].copy()
        at = 0.0
        for number, piece in enumerate(stretched(arm.robot, i)):
            length = min(piece[2], group.pitch - at)  # the tool weighs nothing
            own = line[2 * parts * number : 2 * parts * (number + 1) + 1]
            if length < piece[2]:
                own = own[0] + (own - own[0]) * (length / piece[2])
            weights = np.tile([2.0, 4.0], parts + 1)[: 2 * parts + 1] / (6.0 * parts)
            weights[[0, -1]] = 1.0 / (6.0 * parts)
            if group.centre_of_mass is None:
                total -= group.link_mass * length / group.pitch * gravity @ (weights @ own)
            elif at <= group.centre_of_mass < at + length:
                part = (group.centre_of_mass - at) / length
                turn = piece[:2] * angles[i]
                if piece[3] and np.hypot(*turn) > 0:  # exactly on the arc: on the circle through three of its points
                    total -= group.link_mass * gravity @ _on_arc(own, part)
                else:
                    total -= group.link_mass * gravity @ (own[0] + part * (own[-1] - own[0]))
            at += length
    return total


def _on_arc(points, part):
    """A point of a circular arc (q, 3), a share of the way along it."""
    start, middle, end = points[0], points[len(points) // 2], points[-1]
    chord, rise = end - start, middle - 0.5 * (start + end)
    half = np.linalg.norm(chord) / 2
    bend = 4.0 * math.atan2(np.linalg.norm(rise), half)
    radius = half / math.sin(bend / 2)
    up, along = rise / np.linalg.norm(rise), chord / np.linalg.norm(chord)
    centre = 0.5 * (start + end) - radius * math.cos(bend / 2) * up
    turn = (part - 0.5) * bend
    return centre + radius * (math.sin(turn) * along + math.cos(turn) * up)


@pytest.mark.parametrize(("seed", "passing"), [(0, False), (1, True), (2, False), (3, True)])
def test_derivatives_are_those_of_lengths_and_of_the_energy_of_the_weight(seed, passing):
    arm, rng = mixed_arm(seed, passing=passing), np.random.default_rng(seed)
    assert arm.robot.keeps_circles != passing
    angles, gravity, n = poses(arm, rng, 2, 0.9), rng.normal(size=3) * 9, arm.robot.sections
    J, H = arm.cable_jacobian(angles), arm.cable_hessian(angles)
    np.testing.assert_allclose(J, slopes(arm.robot.cable_lengths, angles, 2e-4), rtol=0, atol=2e-11)
    whole = np.zeros((*H.shape[:2], n, 2, n, 2))
    for j in range(n):
        whole[:, :, j, :, j, :] = H[:, :, j]
    found = slopes(arm.cable_jacobian, angles, 2e-4)
    np.testing.assert_allclose(whole.reshape(found.shape), found, rtol=0, atol=1e-10)
    torque, stiffness = arm.gravity_torque(angles, gravity), arm.gravity_stiffness(angles, gravity)
    by_energy = slopes(lambda many: np.array([energy(arm, one, gravity) for one in many]), angles[:1], 2e-3)
    np.testing.assert_allclose(torque[:1], by_energy, rtol=0, atol=1e-8)
    np.testing.assert_allclose(stiffness, slopes(lambda x: arm.gravity_torque(x, gravity), angles, 1e-3), atol=1e-10)
    np.testing.assert_array_equal(stiffness, np.swapaxes(stiffness, 1, 2))
    tips = slopes(lambda many: arm.robot.joint_positions(many)[:, -1], angles, 1e-3)
    np.testing.assert_allclose(tip_jacobian(arm, angles), tips, rtol=0, atol=1e-11)


def test_the_straight_arm_has_the_derivatives_of_one_that_is_nearly_straight():
    arm = mixed_arm(7, 6)
    straight, nearly = np.zeros((1, 6, 2)), np.full((1, 6, 2), 1e-9)
    for function in (arm.cable_jacobian, arm.cable_hessian, lambda x: arm.gravity_stiffness(x, DOWN)):
        np.testing.assert_allclose(function(straight), function(nearly), rtol=0, atol=1e-8)


@pytest.mark.parametrize("seed", range(2))
def test_cables_of_links_may_change_their_circles(seed):
    arm, rng = random_arm(seed, 5, passing=True), np.random.default_rng(seed)
    assert not arm.robot.keeps_circles
    assert arm.robot.straight_links
    angles = poses(arm, rng, 3, 0.5)
    np.testing.assert_allclose(arm.cable_jacobian(angles), slopes(arm.robot.cable_lengths, angles, 2e-4), atol=2e-11)
    H, found = arm.cable_hessian(angles), slopes(arm.cable_jacobian, angles, 2e-4)
    found = found.reshape(*found.shape[:2], 5, 2, 5, 2)
    for j in range(5):
        np.testing.assert_allclose(H[:, :, j], found[:, :, j, :, j], rtol=1e-7, atol=1e-9)


def test_links_whose_cables_pass_on_another_circle_come_to_rest_where_they_are_held():
    arm = arm_of([section(count=4, cable_azimuth_step_deg=-10.0, passing_cable_radius=0.013)])
    angles = poses(arm, np.random.default_rng(0), 6, 0.6)
    held = arm.hold(angles, DOWN)
    assert held.is_held.all()
    rest = arm.settle(angles, held.commanded_lengths, DOWN)
    assert rest.is_stable.all()
    np.testing.assert_allclose(rest.angles, angles, rtol=0, atol=1e-6)
    others = arm_of([section(count=4, cable_azimuth_step_deg=-10.0)]).hold(angles, DOWN)
    assert np.abs(held.tensions - others.tensions).max() > 1.0


@pytest.mark.parametrize(("made", "passing"), [(mixed_arm, False), (mixed_arm, True), (random_arm, True)])
def test_the_tangent_stiffness_is_the_derivative_of_all_torques(made, passing):
    arm, rng = made(20, 4, passing), np.random.default_rng(1)
    angles, gravity = poses(arm, rng, 1, 0.6), rng.normal(size=3) * 9
    tensions = rng.uniform(10, 90, (1, arm.robot.cables))
    lengths = arm.robot.cable_lengths(angles)
    k = arm.spring_constants(lengths)

    def torques(many):
        pulls = tensions + k * (arm.robot.cable_lengths(many) - lengths)
        return np.einsum("tka,tk->ta", arm.cable_jacobian(many), pulls) + arm.torque(many, gravity)

    elastic, geometric = arm.stiffness(angles, tensions, gravity)
    np.testing.assert_allclose(elastic + geometric, slopes(torques, angles, 1e-4), rtol=1e-8, atol=1e-6)


def test_a_stack_is_as_many_links_that_bend_alike():
    """All torques are those of the links by the principle of virtual work, whatever the pose."""
    count, rng = 4, np.random.default_rng(5)
    around = [(50.0, -70.0, -190.0), (40.0, -80.0, -200.0)]
    stack = arm_of([of_kind("joints", joints=count, half_lengths=(0.003, 0.004), pitch=0.1, cable_azimuths_deg=each,
                            link_mass=0.08) for each in around], tool_mass=0.1)  # fmt: skip
    links = [section(pitch=0.1 / count, half_lengths=(0.003, 0.004), count=count, cable_azimuths_deg=each,
                     link_mass=0.08 / count) for each in around]  # fmt: skip
    chain = arm_of(links, tool_mass=0.1)
    angles, gravity = rng.uniform(-0.8, 0.8, (3, 2, 2)), rng.normal(size=3) * 9
    share = np.kron(np.eye(2), np.kron(np.ones((count, 1)), np.eye(2)) / count)
    small = (angles.reshape(3, 4) @ share.T).reshape(3, 2 * count, 2)
    own = np.isin(chain.robot.cable_sections, [count - 1, 2 * count - 1])
    np.testing.assert_allclose(stack.cable_jacobian(angles), chain.cable_jacobian(small)[:, own] @ share, atol=1e-15)
    torques = chain.gravity_torque(small, gravity) @ share
    np.testing.assert_allclose(stack.gravity_torque(angles, gravity), torques, rtol=0, atol=1e-14)
    stiffness = share.T @ chain.gravity_stiffness(small, gravity) @ share
    np.testing.assert_allclose(stack.gravity_stiffness(angles, gravity), stiffness, rtol=0, atol=1e-14)


def in_planes(kind, joints=None):
    """Two sections of a kind, each of which is bent in one plane; of stacks, cables go from middle to middle."""
    keys = {} if joints is None else {"joints": joints, "half_lengths": (0.0, 0.1 / joints * 0.999)}
    part = {"pitch": 0.1, "link_mass": 0.08, EI: 0.2, **keys}
    return arm_of([of_kind(kind, **{"half_lengths": None, "disks": None} | part if kind == "arc" else part)] * 2,
                  tool_mass=0.05)  # fmt: skip


def test_a_stack_of_ever_more_joints_is_the_arc():
    angles, gravity = np.array([[[0.5, 0.0], [0.0, -0.6]]]), np.array([2.0, -9.0, 3.0])
    few, many, arc = in_planes("joints", 50), in_planes("joints", 100), in_planes("arc")
    for ask, order in (
        (lambda arm: arm.torque(angles, gravity)[:, [0, 3]], 1),
        (lambda arm: arm.gravity_stiffness(angles, gravity)[:, [0, 3]][:, :, [0, 3]], 1),
        (lambda arm: arm.cable_jacobian(angles)[:, :, [0, 3]], 2),
    ):
        values = [ask(arm) for arm in (few, many, arc)]
        near, far = np.abs(values[1] - values[2]).max(), np.abs(values[0] - values[2]).max()
        assert near < 0.6 * far  # the difference goes down as the joints become more
        # Without what goes with 1/k or 1/k², the difference is gone.
        share = 2**order
        beyond = (share * values[1] - values[0]) / (share - 1)
        np.testing.assert_allclose(beyond, values[2], rtol=0, atol=0.02 * far)


def test_a_stack_of_one_joint_is_the_link_beside_other_kinds():
    link, stack = (arm_of([of_kind(kind, half_lengths=(0.0, 0.008), **keys), of_kind("arc", disks=5)], tool_mass=0.1)
                   for kind, keys in (("link", {}), ("joints", {"joints": 1})))  # fmt: skip
    angles = np.random.default_rng(3).uniform(-0.6, 0.6, (4, 2, 2))
    for a, b in zip(_all_of(link.hold(angles, DOWN)), _all_of(stack.hold(angles, DOWN)), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)


def _all_of(held):
    return held.tensions, held.commanded_lengths, held.load_factor


def test_one_cable_bends_an_arc_as_its_moment_does():
    """θ = M L / EI: the moment of a cable beside a rod is the same all along it."""
    arm = arm_of([one_arc()], tension_min_N=0.0, pretension_N=0.0)
    straight, r, L = np.zeros((1, 1, 2)), 0.019, 0.2
    k = arm.spring_constants(arm.robot.cable_lengths(straight))[0, 0]
    pulled = np.array([[L - 0.01, L + 0.1, L + 0.1]])
    found = arm.settle(straight, pulled, (0.0, 0.0, 0.0))
    assert found.status[0] == STABLE
    theta, tension = found.angles[0, 0, 0], found.tensions[0, 0]
    assert found.tensions[0, 1:].tolist() == [0.0, 0.0]
    assert theta == pytest.approx(r * tension * L / 0.05, rel=1e-9)
    assert theta == pytest.approx(k * r * 0.01 / (0.05 / L + k * r * r), rel=1e-9)
    # And held there by hand: of all tensions that bend it so far, those closest to none have a pull at 0 and at 120°.
    held = arm.hold(found.angles, (0.0, 0.0, 0.0))
    assert r * (held.tensions[0] @ [1.0, -0.5, -0.5]) == pytest.approx(0.05 * theta / L, rel=1e-9)


@pytest.mark.parametrize(("load", "own", "share"), [(0.1, 1e-9, 1 / 3), (0.0, 0.1, 1 / 12)])
def test_an_arc_that_stands_buckles_where_its_energy_is_flat(load, own, share):
    """A load m on it: L (1 - θ²/6) is its height, so EI/L = m g L/3; its own weight hangs at L (1/2 - θ²/24)."""
    arm = arm_of([one_arc(link_mass=own)], tool_mass=load, tension_min_N=0.0, pretension_N=0.0)
    held = arm.hold(np.zeros((1, 1, 2)), (0.0, 0.0, -9.81))
    k, L = held.spring_constants[0, 0], 0.2
    assert held.load_factor[0] == pytest.approx(
        (0.05 / L + 1.5 * k * 0.019**2) / ((load + own) * 9.81 * L * share), 1e-6
    )


def test_the_weight_of_a_horizontal_arc_bends_it_by_the_minimum_of_its_energy():
    arm = arm_of([one_arc(link_mass=1e-3)], tension_min_N=0.0, pretension_N=0.0)
    straight = np.zeros((1, 1, 2))
    slack = arm.robot.cable_lengths(straight) + 0.1
    found = arm.settle(straight, slack, (9.81, 0.0, 0.0))
    m, L = 1e-3, 0.2
    assert found.angles[0, 0, 0] == pytest.approx(m * 9.81 * L**2 / (6 * 0.05), rel=1e-4)
    assert found.tip_shift[0, 0] == pytest.approx(m * 9.81 * L**3 / (12 * 0.05), rel=1e-4)


def chain(parts, length, stiff, mass):
    """MuJoCo's tip (3,) of a horizontal rod of so many small links that bends under its own weight along +x."""
    joint = f'<joint type="hinge" axis="0 1 0" stiffness="{stiff * parts / length!r}"/>'
    small = length / parts
    body, close = "", ""
    for i in range(parts):
        place = small / 2 if i == 0 else small
        inertia = f'<inertial pos="0 0 {{}}" mass="{mass / parts!r}" diaginertia="1e-9 1e-9 1e-9"/>'
        # A joint in the middle of each small part of the rod; half a part goes before the first one.
        body += f'<body pos="0 0 {place!r}">{joint}{inertia.format(0.0)}'
        close += "</body>"
    model = mj.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="9.81 0 0"/><worldbody>{body}'
        f'<site name="tip" pos="0 0 {small / 2!r}"/>{close}</worldbody></mujoco>'
    )
    data = mj.MjData(model)
    for _ in range(100):  # the springs give way to the weight, whose levers change little
        data.qvel[:] = 0.0
        mj.mj_forward(model, data)
        before = data.qpos.copy()
        data.qpos[:] = -data.qfrc_bias / model.jnt_stiffness
        if np.abs(data.qpos - before).max() < 1e-12:
            break
    mj.mj_forward(model, data)
    return data.site_xpos[0].copy()


def test_how_much_less_than_a_rod_arcs_of_constant_curvature_sag():
    """Under its own weight one arc sags by 2/3 of the rod, two by 11/12: the figures of docs/mechanics.md."""
    length, stiff, mass = 0.6, 0.05, 0.006
    rod = chain(160, length, stiff, mass)[0]
    assert rod == pytest.approx(mass * 9.81 * length**3 / (8 * stiff), rel=0.02)  # that of slender beams
    sags = []
    for count in (1, 2, 3, 6):
        arm = arm_of([one_arc(pitch=length / count, link_mass=mass / count, count=count, cable_azimuth_step_deg=-10.0)],
                     tension_min_N=0.0, pretension_N=0.0)  # fmt: skip
        straight = np.zeros((1, count, 2))
        found = arm.settle(straight, arm.robot.cable_lengths(straight) + 0.4, (9.81, 0.0, 0.0))
        assert found.status[0] == STABLE
        sags.append(found.tip_shift[0, 0] / rod)
    np.testing.assert_allclose(sags, [0.667, 0.917, 0.963, 0.991], rtol=0, atol=0.01)


@pytest.mark.parametrize("seed", [31, 38])
def test_arms_of_all_kinds_come_to_rest_where_they_are_commanded(seed):
    arm = mixed_arm(seed, 4, tension_max_N=2000.0)
    angles = poses(arm, np.random.default_rng(seed), 3, 0.4)
    held = arm.hold(angles, DOWN)
    assert held.is_held.all()
    assert (held.load_factor > 1).all()
    balance = np.einsum("tka,tk->ta", arm.cable_jacobian(angles), held.tensions) + arm.torque(angles, DOWN)
    np.testing.assert_allclose(balance, 0.0, atol=1e-9)
    found = arm.settle(angles, held.commanded_lengths, DOWN, start=0.9 * angles)
    assert (found.status == STABLE).all()
    np.testing.assert_allclose(found.angles, angles, rtol=0, atol=1e-9)
    assert np.linalg.norm(arm.uncompensated(angles, DOWN).tip_shift, axis=1).min() > 1e-4


def test_a_small_change_of_stiffness_moves_the_tip_as_is_said():
    """EA that is smaller moves an arm that bends back, too, against which its cables pull."""
    arm = mixed_arm(31, 4, tension_max_N=2000.0)
    angles = poses(arm, np.random.default_rng(1), 2, 0.4)
    held, gravity = arm.hold(angles, DOWN), np.tile(DOWN, (2, 1))
    off = 1e-4
    softer = replace(arm, axial_stiffness=(1 - off) * arm.axial_stiffness)
    heavier = replace(arm, links=arm.links * [1, 1 + off, 1], tool_mass=(1 + off) * arm.tool_mass)
    moved = [np.linalg.norm(each.settle(angles, held.commanded_lengths, DOWN).tip_shift, axis=1)
             for each in (softer, heavier)]  # fmt: skip
    found = sensitivity(arm, angles, held, gravity, np.zeros_like(held.tensions))
    np.testing.assert_allclose(found.share / SHARE, np.maximum(*moved) / off, rtol=5e-3)


def test_cables_lose_tension_by_all_that_they_bend():
    arm = arm_of([of_kind("arc"), of_kind("joints", joints=3), of_kind("hinges"), of_kind("link")])
    angles = np.array([[[0.3, 0.4], [0.6, 0.0], [0.2, -0.1], [0.0, 0.5]]])
    bends = [0.5, 0.6, 0.3, 0.5]
    expected = np.exp(-0.2 * np.cumsum(bends))
    pitches = arm.robot.pitches
    mean = (0.3 + np.cumsum(expected * pitches)) / (0.3 + np.cumsum(pitches))
    found = lost_by_friction(arm, angles, 0.2)[0][0]
    np.testing.assert_allclose(found, (1 / mean - 1)[arm.robot.cable_sections], rtol=1e-12)
    assert mixed(arm.robot).table.shape == (7, 4)


@pytest.mark.parametrize(
    ("load", "own", "rod", "above"),
    [(1.0, 1e-9, math.pi**2 / 4, [1.216, 1.052, 1.023, 1.006]), (0.0, 1.0, 7.8373, [1.531, 1.076, 1.034, 1.009])],
)
def test_by_how_much_arcs_buckle_later_than_a_rod(load, own, rod, above):
    """A rod buckles under a load of π²/4 EI/L², and under its own weight of 7.837 EI/L²: docs/mechanics.md."""
    length, found = 0.6, []
    for count in (1, 2, 3, 6):
        part = one_arc(pitch=length / count, link_mass=max(own / count, 1e-9), count=count)
        arm = arm_of([part], tool_mass=load, tension_min_N=0.0, pretension_N=0.0)
        weight = arm.gravity_stiffness(np.zeros((1, count, 2)), (0.0, 0.0, -9.81))[0, ::2, ::2]
        critical = arm.springs[0] / np.linalg.eigvalsh(-weight)[-1]
        found.append(critical * 9.81 * length**2 / 0.05 / rod)
    np.testing.assert_allclose(found, above, rtol=0, atol=6e-4)
