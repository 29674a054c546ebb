"""The distribution of tensions: optimality, an independent solver, and proofs that none hold."""

import daqp
import numpy as np
import pytest
from mechanics_makers import DOWN, paper_arm, poses, random_arm
from scipy.optimize import linprog

import hognose
from hognose.mechanics import HELD, NOT_HELD, Mechanics
from hognose.mechanics.tensions import distribute


def of(arm, angles, gravity=DOWN, **changes):
    """Arguments of `distribute` for poses of an arm."""
    count = arm.robot.cables
    bounds = changes.get("low", arm.tension_min), changes.get("high", arm.tension_max)
    low, high = (np.full(count, float(bound)) for bound in bounds)
    wanted = np.full(count, float(changes["wanted"])) if "wanted" in changes else arm.pretension
    J, torques = arm.cable_jacobian(angles), arm.gravity_torque(angles, gravity)
    return J, torques, arm.robot.cable_sections, wanted, low, high


def by_daqp(J, torque, wanted, low, high):
    """The same quadratic program by another method, and whether it is feasible."""
    count = wanted.size
    A = np.ascontiguousarray(-J.T)
    upper, lower = np.concatenate([high, torque]), np.concatenate([low, torque])
    sense = np.concatenate([np.zeros(count), np.full(torque.size, 5)]).astype(np.int32)
    x, _, flag, _ = daqp.solve(np.eye(count), -wanted, A, upper, lower, sense)
    return x, flag


CASES = [
    (seed, share, low, high, wanted)
    for seed in range(12)
    for share, low, high, wanted in [(0.2, 10, 195, 40), (0.6, 10, 195, 40), (1.0, 0, 400, 0), (0.6, 5, 60, 20)]
]


@pytest.mark.parametrize(("seed", "share", "low", "high", "wanted"), CASES)
def test_tensions_are_those_of_daqp(seed, share, low, high, wanted):
    rng = np.random.default_rng(seed)
    arm = paper_arm() if seed < 6 else random_arm(seed, int(rng.integers(1, 9)))
    given = of(arm, poses(arm, rng, 20, share), rng.normal(size=3) * 6, low=low, high=high, wanted=wanted)
    J, torques, _, preferred, least, most = given
    tensions, left, status = distribute(*given)
    assert set(status) <= {HELD, NOT_HELD}
    for t in range(len(J)):
        expected, flag = by_daqp(J[t], torques[t], preferred, least, most)
        assert (flag > 0) == (status[t] == HELD), t
        if status[t] == HELD:
            np.testing.assert_allclose(tensions[t], expected, rtol=0, atol=1e-5)
            np.testing.assert_allclose(-J[t].T @ tensions[t], torques[t], rtol=0, atol=1e-10)
            np.testing.assert_allclose(left[t], 0.0, atol=1e-10)


@pytest.mark.parametrize("seed", range(10))
def test_tensions_are_optimal(seed):
    """At the optimum, of the free cables T - T0 is a combination of the rows of J, and at bounds it points outwards."""
    rng = np.random.default_rng(seed)
    arm = random_arm(seed, 5)
    given = of(arm, poses(arm, rng, 10, 0.4))
    J, _, _, wanted, low, high = given
    tensions, _, status = distribute(*given)
    assert (status == HELD).any()
    for t in np.flatnonzero(status == HELD):
        T = tensions[t]
        free = (low < T) & (high > T)
        y = np.linalg.lstsq(-J[t][free], (T - wanted)[free], rcond=None)[0]
        np.testing.assert_allclose((T - wanted)[free], -J[t][free] @ y, rtol=0, atol=1e-9)
        if np.linalg.matrix_rank(J[t][free]) == J.shape[2]:
            np.testing.assert_allclose(np.clip(wanted - J[t] @ y, low, high), T, rtol=0, atol=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_no_tensions_are_found_exactly_where_there_are_none(seed):
    rng = np.random.default_rng(seed)
    arm = paper_arm(tool_mass=rng.uniform(0, 3.0))
    given = of(arm, poses(arm, rng, 15, 0.8), rng.normal(size=3) * 8, low=10, high=rng.uniform(60, 200), wanted=40)
    J, torques, _, wanted, low, high = given
    tensions, left, status = distribute(*given)
    for t in range(len(J)):
        bounds = np.column_stack([low, high])
        feasible = linprog(np.zeros(wanted.size), A_eq=-J[t].T, b_eq=torques[t], bounds=bounds).status == 0
        assert feasible == (status[t] == HELD)
        assert ((tensions[t] >= low) & (tensions[t] <= high)).all()
        np.testing.assert_allclose(left[t], -J[t].T @ tensions[t] - torques[t], rtol=0, atol=1e-9)


def test_both_outcomes_occur_in_one_plan_and_do_not_touch_each_other():
    rng = np.random.default_rng(3)
    arm = paper_arm(tool_mass=0.2)
    angles = poses(arm, rng, 60, 0.7)
    together = distribute(*of(arm, angles, high=120))
    assert {HELD, NOT_HELD} == set(together[2])
    backwards = distribute(*of(arm, angles[::-1], high=120))
    np.testing.assert_array_equal(together[2], backwards[2][::-1])
    for one, other in zip(together[:2], backwards[:2], strict=True):
        np.testing.assert_array_equal(one, other[::-1])  # to the bit: a way back is commanded as the way there


def test_a_straight_arm_without_weight_keeps_its_pretension():
    arm = paper_arm(4)
    tensions, _, status = distribute(*of(arm, np.zeros((2, 4, 2)), np.zeros(3)))
    np.testing.assert_array_equal(status, HELD)
    np.testing.assert_allclose(tensions, 40.0, rtol=1e-13)


def test_with_pretension_at_the_least_tension_the_other_cables_take_the_weight():
    arm = paper_arm(pretension_N=10.0)
    held = arm.hold(np.zeros((1, 12, 2)), DOWN)
    assert held.is_held.all()
    assert held.tensions.min() == 10.0
    assert held.tensions.max() > 40.0


def test_cables_that_all_lie_at_the_least_tension_are_held():
    """Nothing is to spare there, and rounding decides which cables are at their bound."""
    task = hognose.load_task("obstacle-array")
    angles, arm = hognose.plan(task).angles[:60], Mechanics.of(task.robot)
    for least in np.linspace(3.0, 4.0, 21):
        given = of(arm, angles, np.array([0.0, 0.0, 9.8]), low=least, high=300.0, wanted=least)
        _, left, status = distribute(*given)
        assert (status == HELD).all()
        assert np.abs(left).max() < 1e-9
