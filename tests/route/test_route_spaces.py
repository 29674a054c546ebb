"""Spaces with a known way through: the claim is proven, and a route is found."""

import pytest
from route_makers import smallest_by_coal

import hognose
from benchmarks.planted_arms import ARMS, arm, planted_clearance
from benchmarks.planted_spaces import FAMILIES, space
from hognose.planning import Task, TaskSpec
from hognose.route import Search

pytestmark = pytest.mark.slow


class First(Search):
    """A search that ends at its first route."""

    def goes_on(self):
        """Whether there is none yet."""
        return self.best is None


@pytest.fixture(scope="module")
def robot():
    return hognose.load_robot("sjtu-25dof")


@pytest.mark.parametrize("family", FAMILIES)
def test_a_space_is_solvable_as_planted_and_a_route_is_found(robot, family):
    made = space(robot, family, 1, planted=0.010, margin=0.005)
    proof = made.proof()
    assert proof.good
    assert proof.check("certified_along_path").value == pytest.approx(0.0102, abs=0.0003)
    assert made.task.spec.path.way_points == ()
    search = First(made.task, None, 0)
    search.run()
    assert search.best is not None
    assert search.best.clearance >= 0.005


@pytest.mark.parametrize("number", [0, 8, 12, 20])  # `benchmarks.arms` searches for all of them, and more
def test_arms_of_all_sizes_find_their_way(number):
    """5 to 60 links of 20 to 300 mm, to 10 to 60 degrees; found by passages tried, not by time."""
    arm_, family = arm(*ARMS[number]), FAMILIES[number % len(FAMILIES)]
    planted = planted_clearance(arm_)
    made = space(arm_, family, 0, planted, 0.5 * planted)
    proof = made.proof()
    assert proof.good
    assert proof.certified_clearance is not None
    assert proof.certified_clearance >= planted
    search = First(made.task, None, 0, most=8)
    search.run()
    assert search.best is not None
    assert search.best.plan.good
    assert search.best.clearance >= made.task.margin


@pytest.mark.parametrize("diameter", [0.3, 1.2])
def test_long_links_that_bend_little_go_round_a_ball(diameter):
    """The larger the ball, the farther round; none is missed."""
    robot = arm(12, 200, 20, 45)
    ball = {"kind": "sphere", "name": "ball", "center": (0.1, 0.05, 1.0), "diameter": diameter}
    spec = {"name": "ball", "robot": robot.name, "path": {"target": (-0.0157, 0.1891, 1.8396)}, "obstacle": [ball]}
    search = First(Task(TaskSpec.model_validate(spec), robot), None, 0)
    search.run()
    assert search.best is not None
    assert search.passages <= 3


def test_the_range_of_arms_is_what_it_says():
    links, lengths, limits, _ = (sorted(values) for values in zip(*ARMS, strict=True))
    assert len(ARMS) >= 20
    assert [values[k] for values in (links, lengths, limits) for k in (0, -1)] == [5, 60, 20, 300, 10, 60]


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
