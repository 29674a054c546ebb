"""What checks of mechanics advise is enough: random arms that do not stand, stand once it is done."""

import dataclasses
import re

import numpy as np
import pytest
from planning_makers import outcome, retasked, variant

import hognose
from hognose.planning.checks.mechanics import buckling, peak_tension, slack, why_it_cannot_begin
from hognose.planning.checks.shared import Shared
from hognose.route.why import partial


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


def judged(plan, criterion, robot):
    """The verdict of a criterion on the same motion of a robot with other values, by their keys."""
    other = retasked(plan, robot=robot)
    (check,) = criterion(other, Shared(other))
    return check


def number(pattern, text):
    """The number that a pattern finds in a text; None if there is none."""
    found = re.search(pattern, text)
    return None if found is None else float(found[1])


def sure_number(pattern, text):
    """The same, where there must be one."""
    found = number(pattern, text)
    assert found is not None, text
    return found


def random_springs(rng, alike):
    """An arm whose cables and masses are random; alike for all sections, or different for each."""
    least = rng.uniform(1.0, 12.0)

    def each(low, high):
        return float(rng.uniform(low, high)) if alike else [float(x) for x in rng.uniform(low, high, 12)]

    return {
        "cables.axial_stiffness_N": each(6e3, 60e3),
        "cables.pretension_N": each(least, 110.0),
        "cables.tension_min_N": float(least),
        "cables.tension_max_N": 240.0,
        "cables.free_length": float(rng.uniform(0.0, 0.6)),
        "cables.load_factor_min": float(rng.uniform(1.0, 2.5)),
        "tool_mass": float(rng.uniform(0.0, 0.3)),
    }


def times(value, factor):
    return [factor * x for x in value] if isinstance(value, list) else factor * value


def cures(robot, detail):
    """Robots with what a sentence on buckling advises, by what is changed."""
    found = {}
    stiff, often = number(r"EA ≥ ([\d.e+]+) kN", detail), number(r"take ([\d.e+]+) times the EA", detail)
    pretension = number(r"is above ([\d.e+]+) N", detail)
    share = number(r"lower all to ([\d.e+]+) %", detail)
    lighter = number(r"lighter, to ([\d.e+]+) %", detail)
    if stiff:
        found["EA"] = {"cables.axial_stiffness_N": 1e3 * stiff}
    if often:
        found["EA"] = {"cables.axial_stiffness_N": times(robot["cables.axial_stiffness_N"], often)}
    if pretension:
        found["pretension"] = {"cables.pretension_N": pretension}
    if share:
        least = robot["cables.tension_min_N"]
        lowered = times(robot["cables.pretension_N"], share / 100)
        found["pretension"] = {"cables.pretension_N": [max(least, x) for x in lowered]}
    if lighter:
        found["mass"] = {"section.0.link_mass": 0.062 * lighter / 100, "tool_mass": robot["tool_mass"] * lighter / 100}
    return {name: robot | change for name, change in found.items()}


@pytest.mark.parametrize("alike", [True, False])
def test_arms_that_buckle_stand_once_what_is_advised_is_done(plan, alike):
    rng, seen = np.random.default_rng(5), []
    for _ in range(14):
        robot = random_springs(rng, alike)
        check = judged(plan, buckling, robot)
        if check.ok:
            continue
        assert check.section is not None
        assert check.cable is not None
        assert f"section {check.section} " in check.detail
        advised = cures(robot, check.detail)
        assert "EA" in advised, check.detail
        for name, cured in advised.items():
            assert judged(plan, buckling, cured).ok, (check.detail, name)
            assert judged(plan, peak_tension, cured).ok, (check.detail, name)
        seen += advised
    assert {"EA", "pretension"} <= set(seen)
    assert len(seen) > 14


def test_no_more_is_advised_than_it_takes(plan):
    rng, seen = np.random.default_rng(6), 0
    for _ in range(10):
        robot = random_springs(rng, alike=True)
        check = judged(plan, buckling, robot)
        for name, cured in {} if check.ok else cures(robot, check.detail).items():
            if name == "EA":
                less = cured | {"cables.axial_stiffness_N": 0.985 * cured["cables.axial_stiffness_N"]}
            elif name == "pretension" and cured["cables.pretension_N"] > 1.1 * robot["cables.tension_min_N"]:
                less = cured | {"cables.pretension_N": 1.03 * cured["cables.pretension_N"]}
            else:
                continue
            assert judged(plan, buckling, less).failed, (check.detail, name)
            seen += 1
    assert seen > 8


def test_arms_that_no_tensions_hold_are_held_with_what_is_advised(plan):
    rng, seen = np.random.default_rng(7), []
    for _ in range(10):
        robot = {
            "tool_mass": float(rng.uniform(0.3, 3.0)),
            "cables.tension_max_N": float(rng.uniform(60.0, 200.0)),
            "cables.tension_min_N": float(rng.uniform(1.0, 20.0)),
        }
        check = judged(plan, peak_tension, robot)
        if check.ok:
            continue
        assert check.section is not None
        assert check.cable is not None
        assert f"no tensions hold section {check.section}: " in check.detail
        more, lighter = number(r"tension_max_N to ([\d.e+]+) N", check.detail), number(r"to ([\d.e+]+) %", check.detail)
        assert more or lighter
        if more:
            assert judged(plan, peak_tension, robot | {"cables.tension_max_N": more}).ok
            assert judged(plan, peak_tension, robot | {"cables.tension_max_N": 0.985 * more}).failed
            seen.append("more")
        if lighter:
            mass = {"section.0.link_mass": 0.062 * lighter / 100, "tool_mass": robot["tool_mass"] * lighter / 100}
            assert judged(plan, peak_tension, robot | mass).ok
            seen.append("lighter")
    assert min(seen.count("more"), seen.count("lighter")) > 2


def test_slack_cables_are_tensioned_with_what_is_advised(plan):
    rng, seen = np.random.default_rng(8), 0
    for _ in range(8):
        robot = {
            "cables.tension_min_N": 0.0,
            "cables.pretension_N": float(rng.uniform(0.0, 25.0)),
            "tool_mass": float(rng.uniform(0.0, 0.2)),
        }
        check = judged(plan, slack, robot)
        if check.ok:
            continue
        assert check.cable is not None
        assert f"nothing keeps cable {check.cable} tensioned" in check.detail
        least = sure_number(r"tension_min_N to ([\d.]+) N", check.detail)
        pretension = robot["cables.pretension_N"]
        assert ("pretension_N with it" in check.detail) == (least > pretension)
        cured = robot | {"cables.tension_min_N": least, "cables.pretension_N": max(pretension, least)}
        assert judged(plan, slack, cured).ok, check.detail
        assert judged(plan, peak_tension, cured).ok, check.detail
        seen += 1
    assert seen > 3


def test_an_arm_that_buckles_by_its_weight_alone_stands_once_it_is_lighter(plan):
    robot = {"cables.axial_stiffness_N": 13e3, "cables.pretension_N": 10.0, "tool_mass": 0.1}
    check = judged(plan, buckling, robot)
    assert "under the weight: take EA ≥ " in check.detail
    advised = cures(robot, check.detail)
    assert set(advised) == {"EA", "mass"}
    assert all(judged(plan, buckling, cured).ok for cured in advised.values())


def test_a_plan_is_found_once_what_its_refusal_advises_is_done(plan):
    soft = {"cables.axial_stiffness_N": 40e3, "cables.pretension_N": 90.0}
    error = outcome(lambda: hognose.plan(variant(plan.task, robot=soft)))
    assert isinstance(error, hognose.InfeasibleError)
    for cured in cures(soft, str(error)).values():
        assert hognose.plan(variant(plan.task, robot=cured)).good


def test_no_route_is_searched_for_an_arm_that_does_not_stand_where_it_begins(monkeypatch):
    monkeypatch.setattr(partial, "nearest", lambda search: pytest.fail("no insertion can begin, and one is sought"))
    task = hognose.load_task("find-a-way")
    assert why_it_cannot_begin(task) == ""
    soft = {"cables.axial_stiffness_N": 25e3, "cables.pretension_N": 80.0}
    heavy = {"tool_mass": 3.0}
    for robot, said in ((soft, "buckles: pretension 80 N is above "), (heavy, "no tensions hold section ")):
        error = outcome(lambda robot=robot: hognose.plan(variant(task, robot=robot)))
        assert isinstance(error, hognose.InfeasibleError)
        assert "the arm does not stand where every route begins, straight before the entrance: section" in str(
            error
        ).replace("no tensions hold ", "")
        assert said in str(error)


def test_an_arm_that_cannot_be_helped_is_told_so(plan):
    heavy = {"section.0.link_mass": 62.0}  # grams for kilograms
    check = judged(plan, peak_tension, heavy)
    assert "more tension_max_N does not help; make links and tool lighter, to " in check.detail
    assert check.detail.endswith("(are they in kg?)")


def test_advice_holds_where_another_step_is_the_worst_then(plan):
    """The last steps alone, as well as all of them: what is said holds for what was judged."""
    robot = {"cables.axial_stiffness_N": 20e3, "cables.pretension_N": 60.0}
    ends = {name: getattr(plan, name)[-40:] for name in ("time", "feed", "joints", "angles", "cable_lengths")}
    ends |= {name: getattr(plan, name)[-40:] for name in ("motor_counts", "clearance")}
    whole = judged(plan, buckling, robot)
    part = judged(dataclasses.replace(plan, **ends), buckling, robot)
    pattern = r"is above ([\d.e+]+) N"
    assert sure_number(pattern, part.detail) >= sure_number(pattern, whole.detail)
