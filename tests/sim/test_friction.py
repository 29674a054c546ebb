"""Cables that rub in their holes: the rope on a drum, in closed form, and what it costs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from twin_makers import boards, robot_of

from hognose.mechanics import Mechanics
from hognose.mechanics.sensitivity import sensitivity
from hognose.sim import Changes, Twin, simulate
from hognose.sim.cable_forces import PRESLIDING, CableForces


def rubbing(sections: int, friction: float) -> CableForces:
    return CableForces.of(Changes(friction=friction).applied(Mechanics.of(robot_of(sections))))


def moved(forces: CableForces, angles, rates, step=1.0):
    """One step with cables that are short enough to pull."""
    lengths = forces.mechanics.robot.cable_lengths(angles)
    return forces.pull(angles, rates, lengths - 1e-3, np.zeros(len(lengths)), step).copy()


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 1.0))
def test_shares_are_those_of_a_rope_on_drums(seed, friction):
    rng, n = np.random.default_rng(seed), 4
    forces = rubbing(n, friction)
    robot = forces.mechanics.robot
    angles = rng.uniform(-1, 1, (n, 2)) * robot.bend_limits
    for _ in range(3):
        moved(forces, angles, rng.normal(0, 3e-3, 2 * n))
    assert np.abs(forces.grip).max() <= 1.0
    bends = np.arccos(np.cos(angles).prod(axis=1))
    for k, last in enumerate(robot.cable_sections):
        turns = friction * (bends * forces.grip[k])[: last + 1]
        after = np.exp(np.cumsum(turns))
        np.testing.assert_allclose(forces.shares[k, : last + 1], after * np.exp(-turns / 2), rtol=1e-12)
        np.testing.assert_allclose(forces.shares[k, -1], after[-1], rtol=1e-12)
        np.testing.assert_allclose(forces.means[k], np.average(after, weights=robot.pitches[: last + 1]), rtol=1e-12)
    torques = moved(forces, angles, np.zeros(2 * n))
    shares = np.repeat(forces.shares[:, :-1], 2, axis=1) * forces.tensions[:, None]
    np.testing.assert_allclose(torques, -(forces.jacobian * shares).sum(axis=0), rtol=1e-9, atol=1e-12)
    stretched = forces.mechanics.axial_stiffness * 1e-3
    np.testing.assert_allclose(
        forces.tensions, stretched / (forces.lengths * forces.means + forces.mechanics.free_length), rtol=1e-9
    )


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_a_cable_that_slides_far_loses_or_gains_what_the_capstan_formula_says(way):
    """In an arm of one section nothing lies behind the joint, so that the cable slides by half of what it grows."""
    forces = rubbing(1, 0.1)
    angles = np.array([[0.3, 0.2]])
    bend = np.arccos(np.cos(0.3) * np.cos(0.2))
    rates = np.array([1e-4, 0.0])
    moved(forces, angles, 0 * rates)
    sliding = 0.5 * forces.jacobian @ rates * way
    for count in (20, 1000):
        forces.loosen()
        for _ in range(count):
            moved(forces, angles, way * rates)
        gone = count * sliding
        np.testing.assert_allclose(forces.grip[:, 0], np.clip(gone / PRESLIDING, -1, 1), atol=1e-9)
    np.testing.assert_allclose(forces.shares[:, -1], np.exp(np.sign(gone) * 0.1 * bend), rtol=1e-9)


def test_a_cable_that_stands_still_keeps_its_grip():
    forces = rubbing(3, 0.2)
    angles = np.full((3, 2), 0.2)
    moved(forces, angles, np.full(6, 1e-2))
    before = forces.shares.copy()
    assert np.abs(before - 1).max() > 0.01
    for _ in range(10):
        moved(forces, angles, np.zeros(6))
    np.testing.assert_array_equal(forces.shares, before)
    forces.loosen()
    moved(forces, angles, np.zeros(6))
    np.testing.assert_array_equal(forces.shares, 1.0)


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_friction_takes_energy_out_of_a_cycle_and_springs_do_not(seed):
    rng, n, count = np.random.default_rng(seed), 2, 200
    middle, swing = rng.uniform(-0.25, 0.25, (n, 2)), rng.uniform(-0.2, 0.2, (2, n, 2))
    turn = 2 * np.pi * (np.arange(3 * count) + 0.5) / count
    work = {}
    for friction in (0.0, 0.2):
        forces = rubbing(n, friction)
        held, total = forces.mechanics.robot.cable_lengths(middle) - 0.03, 0.0
        for at in turn:
            angles = middle + np.cos(at) * swing[0] + np.sin(at) * swing[1]
            rates = (2 * np.pi / count * (np.cos(at) * swing[1] - np.sin(at) * swing[0])).ravel()
            forces.pull(angles, rates, held, forces.jacobian @ rates, 1.0)  # paid out as fast: no damping
            forces.pull(angles, rates, held, forces.jacobian @ rates, 0.0)
            total += float(forces.torques @ rates) if at > 2 * np.pi else 0.0
        work[friction] = total
    assert abs(work[0.0]) < 1e-6
    assert work[0.2] < -1e-3


def test_friction_of_a_tenth_loses_what_was_measured_elsewhere_and_moves_the_tip_little():
    plan = boards()
    done, smooth = simulate(plan, Changes(friction=0.1)), simulate(plan)
    np.testing.assert_array_equal(smooth.end_tensions, smooth.tensions)
    bends = np.arccos(np.cos(plan.angles).prod(axis=2)).sum(axis=1)
    share = done.end_tensions / done.tensions
    assert (np.abs(np.log(share)) <= 0.1 * bends[:, None] + 1e-3).all()
    assert 0.08 < 1 - share.min() < 0.14
    assert not done.slack.any()
    apart = np.linalg.norm(done.joints[:, -1] - smooth.joints[:, -1], axis=1)
    assert 0.05e-3 < apart.max() < 0.7e-3
    assert not done.stopped


def test_the_arm_rests_elsewhere_after_another_way_and_stays_there():
    """Hysteresis: the same set-points, come to from two sides."""
    plan, tips = boards(), []
    for way in (-1, 1):
        twin = Twin(plan.task, Changes(friction=0.3))
        twin.put(plan.at[250], plan.angles[250 + 4 * way])
        lengths = plan.commanded_lengths
        for k in range(1500):
            share = max(0.0, 1 - k / 500)
            twin.step(
                lengths[250] + share * (lengths[250 + 4 * way] - lengths[250]),
                (lengths[250] - lengths[250 + 4 * way]) * (k < 500),
                plan.at[250],
                np.zeros(1),
            )
        before = twin.joints[-1]
        for _ in range(500):
            twin.step(lengths[250], np.zeros(plan.robot.cables), plan.at[250], np.zeros(1))
        assert np.linalg.norm(twin.joints[-1] - before) < 0.1e-3
        tips.append(before)
    assert 0.1e-3 < np.linalg.norm(tips[1] - tips[0]) < 3e-3


def test_friction_moves_the_tip_no_farther_than_its_sensitivity_says():
    """All cables rub the way they go, as first-order mechanics assume; the twin comes to rest there."""
    plan, step = boards(), 200
    changed = Changes(friction=0.1).applied(Mechanics.of(plan.robot))
    ways = np.sign(np.gradient(plan.commanded_lengths, axis=0))
    assert plan.held is not None
    expected = sensitivity(changed, plan.angles, plan.held, plan.task.gravity(plan.at), ways).friction[step]
    twin = Twin(plan.task, Changes(friction=0.1))
    twin.put(plan.at[step], plan.angles[step])
    twin._forces.grip[:] = ways[step][:, None]
    tips = []
    for _ in range(2000):
        twin.step(plan.commanded_lengths[step], np.zeros(36), plan.at[step], np.zeros(1))
        tips.append(twin.joints[-1])
    moved = np.linalg.norm(np.mean(tips[1000:], axis=0) - plan.body[step, -1])
    assert expected > 0.1e-3
    assert 0.6 * expected < moved < expected  # where a cable slides back, its grip gives way
