"""Spaces with a known way through: the claim is proven, and a route is found."""

import pytest
from route_makers import smallest_by_coal

import hognose
from hognose.route import Search
from hognose.route.spaces import FAMILIES, space

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def robot():
    return hognose.load_robot("sjtu-25dof")


@pytest.mark.parametrize("family", FAMILIES)
def test_a_space_is_solvable_as_planted_and_a_route_is_found(robot, family):
    made = space(robot, family, 1, planted=0.010, margin=0.005)
    proof = made.proof()
    assert proof.good
    assert proof.check("certified clearance, along the path").value == pytest.approx(10.2, abs=0.3)
    assert made.task.spec.path.way_points == ()
    search = Search(made.task, None, 0)
    search.run()
    assert search.best is not None
    assert search.best.clearance >= 0.005


def test_the_same_seed_makes_the_same_space(robot):
    first, again, other = (space(robot, "plates", seed).task.spec.obstacle for seed in (4, 4, 5))
    assert first == again
    assert first != other


def test_another_library_finds_the_planted_motion_clear(robot):
    proof = space(robot, "boards", 2).proof()
    assert smallest_by_coal(proof, 0.002) >= 0.010


def test_an_unknown_family_is_wrong_input(robot):
    with pytest.raises(hognose.InputError, match="Families: boards, pillars"):
        space(robot, "caves", 1)  # pyright: ignore[reportArgumentType]
