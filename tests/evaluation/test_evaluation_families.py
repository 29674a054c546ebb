"""The suite's cases: the same for a seed, as gentle as they say, and really solvable."""

import dataclasses
import math

import numpy as np
import pytest
from evaluation_makers import bends, marched, ring_case, small_case

from hognose.errors import InfeasibleError
from hognose.evaluation import section_families
from hognose.evaluation.case import LIMIT
from hognose.evaluation.families import FAMILIES, confirm, sharpest_allowed, statement, suite_of_cases
from hognose.evaluation.subjects import follower_for


@pytest.fixture(scope="module")
def every():
    """All cases but for most of the drawn shapes, which take seconds to draw."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(section_families, "SHOWN", 3)
        return suite_of_cases(1)


@pytest.fixture(scope="module")
def cases(every):
    """Those of rigid links."""
    return [case for case in every if case.model is None]


@pytest.fixture(scope="module")
def quick():
    """Those of a quick run."""
    return suite_of_cases(1, quick=True)


def test_the_suite_covers_what_it_promises(every, cases):
    assert len({(case.family, case.name) for case in every}) == len(every), "two cases of a family have the same name"
    assert list(dict.fromkeys(case.family for case in every)) == list(FAMILIES)
    assert {case.family for case in every if case.model is not None} == set(section_families.MAKERS)
    links = [len(case.link_lengths) for case in cases if case.family == "links"]
    spacings = [case.spacing for case in cases if case.family == "spacing"]
    assert (min(links), max(links)) == (3, 1000)
    assert (min(spacings), max(spacings)) == (5e-5, 3.5e-3)


def test_the_same_seed_makes_the_same_paths_and_another_seed_others(quick):
    for case, again in zip(quick, suite_of_cases(1, quick=True), strict=True):
        assert (case.family, case.name) == (again.family, again.name)
        assert np.array_equal(case.path.coefficients, again.path.coefficients)
        assert np.array_equal(case.feeds, again.feeds)
    pairs = zip(quick, suite_of_cases(2, quick=True), strict=True)
    changed = {case.family for case, other in pairs if not same_curve(case, other)}
    assert changed == {"s-curve", "helix", "long", "arcs", "stacks", "shapes"}


def same_curve(case, other):
    return np.array_equal(case.path.coefficients, other.path.coefficients)


def test_quick_cases_are_some_of_the_full_ones(every, quick):
    whole = {(case.family, case.name): case for case in every}
    assert {case.family for case in quick} == set(FAMILIES)
    assert len(quick) < (len(every) + 3 * (section_families.EACH - 3)) / 2
    assert all(same_curve(case, whole[case.family, case.name]) for case in quick)


@pytest.mark.parametrize(
    "family", [family for family in FAMILIES if family not in ("spacing", *section_families.MAKERS)]
)
def test_every_case_is_feasible_by_a_march_of_its_own(cases, family):
    own = [case for case in cases if case.family == family]
    assert own
    for case in own:
        assert_feasible_by_a_march(case)


def assert_feasible_by_a_march(case):
    confirm(case)
    joints, arcs = case.reference
    assert bends(joints).max() < math.pi / 2
    chosen = [0, len(case.feeds) // 2, len(case.feeds) - 1]
    links = np.unique(np.linspace(0, len(case.link_lengths) - 1, 8).astype(int))
    for step in chosen:
        assert arcs[step, 0] == case.feeds[step]
        for link in links:
            length = float(case.link_lengths[link])
            found = marched(case.path, arcs[step, link], joints[step, link], length - 1e-9, length / 1000)
            assert found == pytest.approx(arcs[step, link + 1], abs=length / 900)
            assert np.allclose(joints[step, link + 1], case.path.point(min(found, case.path.length)), atol=length / 800)


def test_drawn_paths_bend_no_more_than_their_joints_can(cases):
    for case in (case for case in cases if case.family != "wiggly"):
        curvature = case.path.curvature(np.linspace(0.0, case.path.length, 20_001))
        allowed = sharpest_allowed(float(case.link_lengths.max()))
        assert curvature.max() <= allowed * 1.000001
        # Joints bend by at most the angle that joints on the sharpest circle do, so the limit holds.
        assert bends(case.reference[0]).max() <= 2.0 * math.asin(curvature.max() * case.link_lengths.max() / 2) + 1e-4
        assert bends(case.reference[0]).max() <= LIMIT + 1e-9


def test_tight_cases_are_tight_and_near_itself_comes_near_itself(cases):
    for case in cases:
        joints, arcs = case.reference
        if case.family == "tight":
            assert bends(joints).max() > 0.96 * LIMIT
        if case.family == "near-itself":
            away = np.linalg.norm(joints[-1, :, None] - joints[-1, None], axis=2)
            apart = arcs[-1, None, :] - arcs[-1, :, None]
            assert away[apart > 1.0].min() < case.link_lengths[0]


def test_the_sharpest_circle_bends_its_joints_by_the_limit():
    radius = 1.0 / sharpest_allowed(0.091, 0.5)
    angle = 2.0 * math.asin(0.091 / 2.0 / radius)
    assert angle == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"bend_limit": 0.05}, "a joint bends by .* its limit is 0.05 rad"),
        ({"link_lengths": np.full(3, 0.2)}, "the arm ends .* mm beyond the path"),
    ],
)
def test_a_case_without_a_solution_is_not_confirmed(change, reason):
    confirm(small_case())
    with pytest.raises(InfeasibleError, match=reason):
        confirm(dataclasses.replace(small_case(), **change))


def test_joints_on_another_crossing_are_not_confirmed():
    """The right distances and small bends prove nothing if the path was a link away before."""
    case = dataclasses.replace(ring_case(0.06, links=1), bend_limit=math.pi)
    confirm(case)
    joints, arcs = (np.array(values) for values in case.reference)
    later = np.arange(arcs[-1, 1] + 1e-3, case.path.length, 1e-7)
    second = later[np.linalg.norm(case.path.point(later) - joints[-1, 0], axis=1) <= 0.091][0]
    arcs[-1, 1], joints[-1, 1] = second, case.path.point(second)
    joints[-1, 1] += (0.091 / math.dist(joints[-1, 1], joints[-1, 0]) - 1.0) * (joints[-1, 1] - joints[-1, 0])
    vars(case)["reference"] = joints, arcs
    with pytest.raises(InfeasibleError, match="ring, ring: a joint is not on the first crossing"):
        confirm(case)


def test_wiggly_paths_turn_by_more_than_a_right_angle_within_a_link(cases):
    for case in cases:
        assert (case.path.sharpest[0] * 0.091 > math.pi / 2) == (case.family == "wiggly")


def test_every_family_says_how_its_solution_is_known():
    for family in FAMILIES:
        words = statement(family)
        assert words.endswith(".")
        assert "solvable" in words


def test_sections_of_the_reference_end_where_followers_put_them(every):
    """The march in closed form and Newton's method know nothing of each other; stacks leave the plane a little."""
    for case in every:
        if case.family in ("arcs", "stacks"):
            some = dataclasses.replace(case, feeds=case.feeds[::50])
            angles = case.model.angles(follower_for("exact", some).run(some.feeds))
            off = section_families.bends(some) - np.hypot(*angles.transpose(2, 0, 1))
            assert np.abs(off).max() < (1e-9 if case.family == "arcs" else 4e-3)


def test_sections_that_cannot_bend_so_far_are_not_confirmed(every):
    for family in section_families.MAKERS:
        case = next(case for case in every if case.family == family)
        confirm(case)
        with pytest.raises(
            InfeasibleError, match=f"^{family}, {case.name}: a section bends by .* its limit is 0.1 rad"
        ):
            confirm(dataclasses.replace(case, bend_limit=0.1))


def test_forty_shapes_of_each_published_kind_are_drawn():
    assert (section_families.EACH, section_families.PUBLISHED_KINDS) == (40, ("S", "C", "robot"))
