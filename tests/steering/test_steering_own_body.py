"""A steered arm does not touch itself: the nose is held before, and both links are named."""

import numpy as np
import pytest

import hognose
from hognose.robot import Robot, RobotSpec
from hognose.robot.carrier import Carrier
from hognose.robot.own_body import OwnBody
from hognose.scene import Scene
from hognose.steering import SteeredPath
from hognose.steering.clearance import RESERVE
from tests.own_body_oracles import dense_clearance

EMPTY = Scene.from_obstacles([])


def long_arm(links: int, **more: float) -> Robot:
    """The bundled arm with more links that bend more."""
    spec = hognose.load_robot("sjtu-25dof").spec.model_dump(mode="json", by_alias=True)
    spec["section"][0] |= {"count": links, "bend_limit_deg": 35.0}
    spec["feed"]["max"], spec["limits"]["cable_travel"] = 0.091 * links, [-1.0, 1.0]
    return Robot.from_spec(RobotSpec.model_validate(spec | more))


def steered_in_a_circle(links: int, axis: int) -> tuple[SteeredPath, list]:
    """An arm whose nose turns as sharply as it can towards the tip's x or y until it is held."""
    steered = SteeredPath(long_arm(links), EMPTY)
    turn = steered.sharpest * np.eye(2)[axis]
    moves = []
    while not moves or moves[-1].held_by is None:
        moves.append(steered.advance(0.02, turn))
        assert len(moves) < 200
    return steered, moves


@pytest.mark.parametrize("axis", [0, 1])
def test_a_nose_that_turns_back_upon_its_body_is_held_and_both_links_are_named(axis):
    steered, moves = steered_in_a_circle(24, axis)
    held = moves[-1].held_by
    assert held.reason == "own body"
    own = OwnBody.of(steered.robot)
    value, pair = own.closest(steered.joints[None])
    assert 0 < value[0] == pytest.approx(1e-3 * held.value, abs=1e-12)
    assert value[0] < 2 * RESERVE + 1e-4
    first, second = own.names(int(pair[0]))
    assert (held.section, held.other_section) == (first + 1, second + 1)
    assert f"sections {first + 1} and {second + 1} are " in held.sentence
    assert held.obstacle is None


def test_a_steered_arm_never_touches_itself_on_its_way():
    steered, _ = steered_in_a_circle(24, 0)
    depths = np.linspace(0.0, steered.depth, 2000)
    assert OwnBody.of(steered.robot).closest(steered._curve.place(depths)[1])[0].min() > 0


def test_a_held_nose_goes_on_where_it_turns_away_and_can_always_retreat():
    steered, _ = steered_in_a_circle(24, 0)
    depth = steered.depth
    held = steered.advance(0.02, (0.0, 0.0)).held_by
    assert held is not None
    assert held.reason == "own body"
    assert steered.retreat(0.3).held_by is None
    assert steered.advance(0.1, (0.0, steered.sharpest)).held_by is None
    assert steered.retreat(depth).advanced == pytest.approx(-(depth - 0.2), abs=1e-9)


@pytest.mark.parametrize("kind", ["slider", "carrier"])
def test_a_nose_that_turns_back_upon_its_mount_is_held_and_both_are_named(kind):
    robot = long_arm(10, base_length=0.7)
    base = Carrier.before(np.zeros(3), robot, np.eye(3)) if kind == "carrier" else None
    steered = SteeredPath(robot, EMPTY, base=base)
    moves = []
    while not moves or moves[-1].held_by is None:
        moves.append(steered.advance(0.02, (steered.sharpest, 0.0)))
        assert len(moves) < 100
    held = moves[-1].held_by
    assert (held.reason, held.section, held.other_section) == ("own body", 10, None)
    assert "the mount and section 10 are " in held.sentence
    depths, lengths = np.linspace(0.0, steered.depth, 300), np.append(0.7, robot.link_lengths)
    joints = steered._curve.place(depths)[1]
    along = (joints[:, 1] - joints[:, 0]) / robot.link_lengths[0] if base else np.array([0.0, 0.0, 1.0])
    bodies = np.concatenate([joints[:, :1] - 0.7 * np.broadcast_to(along, (300, 3))[:, None], joints], axis=1)
    radii = np.append(robot.body_radii[0], robot.body_radii)
    dense, links = min(dense_clearance(body, lengths, radii, 0.005) for body in bodies)
    assert links == (0, 10)
    assert 0 < dense == pytest.approx(1e-3 * held.value, abs=5e-4)
    free = SteeredPath(long_arm(10, base_length=0.0), EMPTY)
    assert all(free.advance(0.02, (free.sharpest, 0.0)).held_by is None for _ in moves)
