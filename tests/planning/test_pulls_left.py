"""What tolerances leave of tensions and load factors, what is advised, and what tensions are between steps."""

import re

import numpy as np
import pytest
from planning_makers import outcome, retasked, variant

import hognose
from hognose.mechanics.stiffness import load_factors
from hognose.planning.checks.between_steps import tensions_between
from hognose.planning.checks.mechanics import buckling, peak_tension, slack
from hognose.planning.checks.shared import Shared
from hognose.sim import simulate

#: An arm with softer cables: good if all is exact.
SOFT = {"cables.axial_stiffness_N": 50e3, "cables.pretension_N": 50.0}
ZERO, MASS, EA = "tolerance.cable_zero", "tolerance.mass_percent", "tolerance.axial_stiffness_percent"


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


def judged(plan, criterion, spec, robot=None):
    """The verdict of a criterion on the same motion with other tolerances and another robot."""
    other = retasked(plan, spec, robot=robot)
    (check,) = criterion(other, Shared(other))
    return check


@pytest.mark.parametrize("spec", [{}, {"tolerance.registration": 1e-4}, {"tolerance.calibration_deg": 0.1}])
def test_tolerances_of_other_things_take_nothing(plan, spec):
    for criterion in (peak_tension, slack, buckling):
        assert judged(plan, criterion, spec) == judged(plan, criterion, {})
        assert judged(plan, criterion, spec).detail == ""


def test_an_arm_that_buckles_with_what_it_is_said_to_be_off_by_is_not_good(plan):
    """As the twin does with these: a cable goes slack, then it buckles."""
    spec = {ZERO: 1e-4, EA: 10.0}
    for criterion, digits in ((slack, "0.0"), (buckling, "0.0")):
        assert judged(plan, criterion, {}, SOFT).ok
        check = judged(plan, criterion, spec, SOFT)
        assert check.failed
        assert "cable zeros 0.1 mm" in check.detail
        assert f"know cable zeros to {digits}" in check.detail


@pytest.mark.parametrize(
    ("criterion", "spec"),
    [(slack, {ZERO: 2e-5}), (slack, {ZERO: 1e-5, MASS: 10.0, EA: 5.0}), (buckling, {ZERO: 5e-5, MASS: 5.0})],
)
def test_what_is_left_is_what_is_planned_less_what_is_taken(plan, criterion, spec):
    exact, tolerant = judged(plan, criterion, {}, SOFT), judged(plan, criterion, spec, SOFT)
    assert tolerant.ok
    assert 0 < tolerant.value < exact.value
    largest = max((judged(plan, criterion, {key: value}, SOFT) for key, value in spec.items()), key=lambda c: -c.value)
    assert tolerant.value <= largest.value


def test_what_is_left_of_drawn_arms_is_seldom_less(plan):
    """Slack and load factor of arms that are at rest with errors of all three kinds, at the worst step."""
    spec, rng, count = {ZERO: 2e-5, MASS: 5.0}, np.random.default_rng(3), 300
    other = retasked(plan, spec, robot=SOFT)
    tension, factor = (judged(plan, criterion, spec, SOFT) for criterion in (slack, buckling))
    arm, held = other.task.mechanics, other.held
    assert arm is not None
    assert held is not None
    for check in (tension, factor):
        assert check.step is not None
        assert check.cable is not None
        row = slice(check.step, check.step + 1)
        angles = np.repeat(other.angles[row], count, axis=0)
        commanded = np.repeat(held.commanded_lengths[row], count, axis=0)
        commanded += 2e-5 * rng.standard_normal(commanded.shape)
        weight = 1.0 + 0.05 * rng.standard_normal((count, 1))
        gravity = weight * other.task.gravity(other.at)[row]
        rest = arm.settle(angles, commanded, gravity)
        if check is tension:
            found = rest.tensions[:, check.cable - 1]
        else:
            found = load_factors(*arm.stiffness(rest.angles, rest.tensions, gravity))
        assert np.mean(found < check.value) < 0.05
        assert (found > check.value).any()


@pytest.mark.slow
def test_what_is_advised_against_slack_is_enough(plan):
    rng, seen = np.random.default_rng(1), set()
    for _ in range(5):
        robot = SOFT | {"cables.tension_min_N": float(rng.uniform(2, 9)), "cables.pretension_N": 20.0}
        robot["cables.tension_max_N"] = 300.0
        spec = {ZERO: float(rng.uniform(4e-5, 1e-4)), MASS: float(rng.uniform(0, 5))}
        check = judged(plan, slack, spec, robot)
        assert check.failed
        tighter = re.search(r"raise tension_min_N to ([\d.]+) N", check.detail)
        if tighter:
            tension = float(tighter[1])
            more = robot | {"cables.tension_min_N": tension, "cables.pretension_N": max(20.0, tension)}
            for criterion in (slack, buckling, peak_tension):
                assert judged(plan, criterion, spec, more).ok
            seen.add("tighter")
        known = re.search(r"know cable zeros to ([\d.]+) mm", check.detail)
        if known:
            assert judged(plan, slack, spec | {ZERO: 1e-3 * float(known[1])}, robot).ok
            assert judged(plan, slack, spec | {ZERO: 1.05e-3 * float(known[1])}, robot).failed
            seen.add("known")
    assert seen == {"tighter", "known"}


def test_what_is_advised_against_buckling_and_too_much_tension_is_enough(plan):
    soft = SOFT | {"cables.load_factor_min": 3.0, "cables.pretension_N": 25.0}
    weak = SOFT | {"cables.tension_max_N": 110.0}
    for criterion, robot, zero in ((buckling, soft, 1e-4), (peak_tension, weak, 4e-5)):
        spec = {ZERO: zero, MASS: 1.0}
        check = judged(plan, criterion, spec, robot)
        assert check.failed
        known = re.search(r"know cable zeros to ([\d.]+) mm", check.detail)
        assert known is not None, check.detail
        assert judged(plan, criterion, spec | {ZERO: 1e-3 * float(known[1])}, robot).ok
    more = re.search(r"raise tension_max_N to ([\d.]+) N", check.detail)
    assert more is not None
    assert judged(plan, peak_tension, spec, robot | {"cables.tension_max_N": float(more[1])}).ok


def stiff_in_steps_of(step):
    """A task of an arm with very stiff cables, in steps so far apart."""
    task = hognose.load_task("obstacle-array")
    slow = {"motion.step": step, "motion.period_s": 100 * step}
    return variant(task, slow, {"cables.axial_stiffness_N": 1e6, "cables.free_length": 0.0})


def test_a_cable_that_goes_slack_between_steps_is_found():
    """Settled in the middle of every step, without the estimate that leaves most of them out."""
    for step, is_slack in ((0.09, True), (0.0035, False)):
        found = outcome(lambda step=step: hognose.plan(stiff_in_steps_of(step)))
        motion = found.plan if isinstance(found, hognose.InfeasibleError) else found
        assert isinstance(motion, hognose.Plan)
        arm, held = motion.task.mechanics, motion.held
        assert arm is not None
        assert held is not None
        rows = (motion.angles, held.commanded_lengths, motion.task.gravity(motion.at))
        angles, commanded, gravity = (0.5 * (values[1:] + values[:-1]) for values in rows)
        tensions = arm.settle(angles, commanded, gravity).tensions
        between, check = tensions_between(motion), next(iter(slack(motion, Shared(motion))))
        assert (tensions.min() <= 0) == is_slack == check.failed
        if is_slack:
            assert between.least == pytest.approx(tensions.min(), abs=1e-9)
            assert between.largest == pytest.approx(tensions.max(), rel=1e-6)
            assert check.detail == "on the way from this step to the next; take smaller steps (motion.step)"
            (peak,) = peak_tension(motion, Shared(motion))
            assert peak.failed
            assert peak.value == pytest.approx(tensions.max(), rel=1e-6)


def test_between_coarse_steps_the_least_tension_is_seldom_in_the_middle():
    """A plan whose cables are tight at the steps and in their middles, and slack between them."""
    task = hognose.load_task("obstacle-array")
    slow = {"motion.step": 0.12, "motion.period_s": 12.0}
    robot = {"cables.axial_stiffness_N": 300e3, "cables.pretension_N": 35.0}
    found = outcome(lambda: hognose.plan(variant(task, slow, robot)))
    motion = found.plan if isinstance(found, hognose.InfeasibleError) else found
    assert isinstance(motion, hognose.Plan)
    (check,) = slack(motion, Shared(motion))
    assert check.failed
    assert check.detail.startswith("on the way from this step to the next")


def test_friction_takes_of_tensions_even_without_tolerances(plan):
    """As on the twin: with a coefficient of 0.2 a cable goes slack, with 0.05 none does."""
    exact = judged(plan, slack, {})
    for friction, good in ((0.05, True), (0.2, False)):
        robot = {"cables.friction": friction}
        check = judged(plan, slack, {}, robot)
        assert check.ok is good
        assert check.value < exact.value
        assert check.detail.startswith(f"friction {friction:g} (assumed) takes ")
        assert simulate(retasked(plan, robot=robot)).slack.any() != good
        assert judged(plan, buckling, {}, robot).value < judged(plan, buckling, {}).value
        assert judged(plan, peak_tension, {}, robot).value > judged(plan, peak_tension, {}).value


def test_what_tolerances_take_is_taken_between_the_steps_too():
    stiff = {"cables.axial_stiffness_N": 1e6, "cables.free_length": 0.0}
    motion = hognose.plan(variant(hognose.load_task("obstacle-array"), {}, stiff))
    shares = [0.0, 1.0, 5.0]
    least = [tensions_between(motion, np.full_like(motion.cable_lengths, share)).least for share in shares]
    assert np.isfinite(least[0])
    np.testing.assert_allclose(np.diff(least), -np.diff(shares), atol=0.5)
