"""How the arm differs from what was planned with: what is absurd is refused, the rest does what it says."""

import math

import numpy as np
import pytest
from twin_makers import boards, shortened

from hognose.errors import InputError
from hognose.mechanics import Mechanics
from hognose.sim import Changes, Twin, random_zeros, simulate
from hognose.sim.changes import set_zeros


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"stiffness": 0.0}, r"stiffness: expected a factor above 0 and up to 1e\+06, got 0.0"),
        ({"stiffness": math.nan}, "stiffness: expected a factor"),
        ({"stiffness": 1e7}, "stiffness: expected a factor"),
        ({"mass": -1.0}, "mass: expected a factor above 0 and up to 1000, got -1.0"),
        ({"mass": 2000.0}, "mass: expected a factor"),
        ({"friction": -0.1}, "friction: expected a coefficient from 0 to 1, got -0.1"),
        ({"friction": 1.1}, "friction: expected a coefficient"),
        ({"lag": -0.1}, "lag: expected seconds from 0 to 10, got -0.1"),
        ({"lag": 11.0}, "lag: expected seconds"),
        ({"cable_zeros": np.full(36, 0.2)}, "cable_zeros: expected none beyond 100 mm, got 200 mm; they are in m"),
        ({"cable_zeros": np.full(36, np.nan)}, "cable_zeros: .* not finite"),
        ({"shifted": {"board 2": (0.0, math.inf, 0.0)}}, "shifted: board 2: .* not finite"),
        ({"shifted": {"board 2": (0.0, 1e9, 0.0)}}, "shifted: board 2: .* none beyond 10,000 m"),
    ],
)
def test_absurd_values_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        Changes(**given)


@pytest.mark.parametrize(
    ("called", "given", "message"),
    [
        (simulate, {"changes": {"mass": 1.2}}, "changes: expected a hognose.sim.Changes, got a value of type dict"),
        (simulate, {"plan": "plan.parquet"}, "plan: expected a hognose.Plan, got 'plan.parquet'"),
        (simulate, {"progress": 3}, "progress: expected a function of the periods"),
        (Twin, {"task": "x"}, "task: expected a hognose.Task, got 'x'"),
        (Twin, {"changes": 1.2}, "changes: expected a hognose.sim.Changes, got 1.2"),
        (Changes, {"shifted": [1]}, "shifted: expected a dict of the names .*, got a value of type list"),
        (Changes, {"shifted": {2: (0, 0, 0)}}, "shifted: expected the name of an obstacle, got 2"),
    ],
)
def test_what_is_of_another_kind_is_named(called, given, message):
    sound = {simulate: {"plan": boards()}, Twin: {"task": boards().task}, Changes: {}}[called]
    with pytest.raises(InputError, match=message):
        called(**(sound | given))


def test_zeros_of_another_arm_are_refused():
    with pytest.raises(InputError, match="cable_zeros: expected one for each of the 36 cables of sjtu-25dof, got 35"):
        simulate(boards(), Changes(cable_zeros=np.zeros(35)))


@pytest.mark.parametrize(
    ("sigma", "seed", "message"),
    [
        (-1e-3, 0, "zeros: expected a standard"),
        (0.1, 0, "from 0 to 20 mm, got 100 mm"),
        (1e-3, -1, "seed: expected a whole"),
    ],
)
def test_random_zeros_are_refused_if_absurd(sigma, seed, message):
    with pytest.raises(InputError, match=message):
        random_zeros(boards().robot, sigma, seed)


def test_random_zeros_go_with_their_seed():
    robot = boards().robot
    zeros = random_zeros(robot, 1e-3, 5)
    np.testing.assert_array_equal(zeros, random_zeros(robot, 1e-3, 5))
    np.testing.assert_array_equal(random_zeros(robot, 2e-3, 5), 2 * zeros)
    assert (random_zeros(robot, 1e-3, 6) != zeros).all()
    many = np.concatenate([random_zeros(robot, 1e-3, seed) for seed in range(50)])
    assert many.std() == pytest.approx(1e-3, rel=0.1)
    single = set_zeros(robot, zeros, ((1, 2e-3), (36, -1e-3)))
    np.testing.assert_array_equal(single[1:-1], zeros[1:-1])
    assert (single[0], single[-1]) == (2e-3, -1e-3)


@pytest.mark.parametrize(
    ("number", "length", "message"),
    [(0, 1e-3, "no cable 0"), (37, 1e-3, "cables 1 to 36"), (1, 0.2, "100 mm at most"), (1, math.nan, "cable 1")],
)
def test_single_zeros_are_refused_if_absurd(number, length, message):
    with pytest.raises(InputError, match=message):
        set_zeros(boards().robot, np.zeros(36), ((number, length),))


@pytest.mark.parametrize("what", ["mass", "stiffness", "cable_zeros"])
def test_another_arm_begins_at_rest_where_statics_say(what):
    plan = shortened(boards(), 3)
    zeros = random_zeros(plan.robot, 1e-4, 1)
    made = {
        "mass": Changes(mass=1.3),
        "stiffness": Changes(stiffness=0.7),
        "cable_zeros": Changes(cable_zeros=zeros),
    }[what]
    lengths, downward = plan.commanded_lengths[:1] + made.zeros(plan.robot), plan.task.gravity(plan.at[:1])
    rest = made.applied(Mechanics.of(plan.robot)).settle(plan.angles[:1], lengths, downward)
    done = simulate(plan, made)
    np.testing.assert_array_equal(done.angles[0], rest.angles[0])
    assert done.tip_errors[0] > 0.3e-3
    twin = Twin(plan.task, made)
    twin.put(plan.at[0], done.angles[0], plan.commanded_lengths[0])
    for _ in range(300):
        twin.step(plan.commanded_lengths[0], np.zeros(plan.robot.cables), plan.at[0], np.zeros(1))
    assert np.linalg.norm(twin.joints[-1] - done.joints[0, -1]) < 0.02e-3


def test_an_arm_that_would_buckle_begins_where_it_is_planned_to():
    plan = shortened(boards(), 3)
    done = simulate(plan, Changes(stiffness=0.05))
    np.testing.assert_array_equal(done.angles[0], plan.angles[0])
    assert "period 1: the arm buckles" in done.stopped


@pytest.mark.parametrize("lag", [0.05, 0.4])
def test_a_base_that_is_late_is_where_it_should_have_been_before(lag):
    plan = shortened(boards(), 30)
    done = simulate(plan, Changes(lag=lag))
    behind = np.interp(plan.time - lag, plan.time, plan.at[:, 0])
    np.testing.assert_allclose(done.joints[1:, 0, 2] - plan.joints[0, 0, 2], behind[1:], atol=2e-5)
    assert done.tip_errors[-1] == pytest.approx(lag * 0.0035 / 0.15, rel=0.02)


def test_a_cable_that_goes_slack_is_not_good():
    plan = shortened(boards(), 3)
    assert (simulate(plan).good, simulate(plan).verdict) == (True, "GOOD: to the end")
    done = simulate(plan, Changes(cable_zeros=set_zeros(plan.robot, np.zeros(36), ((12, 0.001),))))
    assert (done.stopped, done.touched, done.slack.max()) == ("", (), 1)
    assert (done.good, done.verdict) == (False, "NOT GOOD: up to 1 cable slack")


def test_cables_that_are_pulled_too_much_are_not_good():
    """Six times as stiff, they are pulled about six times as much by what motors command."""
    plan = shortened(boards(), 30)
    assert simulate(plan).good
    done = simulate(plan, Changes(stiffness=6.0))
    largest = done.highest_tensions.max()
    assert largest > 1.01 * 195.0
    assert not done.good
    assert not done.slack.any()
    assert done.verdict == f"NOT GOOD: cables pulled with up to {largest:.4g} N, above tension_max_N"
    assert done.to_json()["overloaded_cables"] == (done.highest_tensions > 1.01 * 195.0).sum(axis=1).max()
