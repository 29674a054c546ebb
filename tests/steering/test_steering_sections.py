"""Steering arms whose sections are no links: what they do between two moves, each against many places in between."""

import itertools
import math

import numpy as np
import pytest
from robot_oracles import robot_of
from section_makers import dense_line, of_kind

import hognose
from hognose.errors import InputError
from hognose.robot.base import Slider
from hognose.scene import Board, Box, Hole, Scene, Sphere
from hognose.steering import SteeredPath
from hognose.steering.clearance import RESERVE
from hognose.steering.section_way import SectionWay

MARGIN, STEP = 0.005, 0.004
EMPTY = Scene.from_obstacles([])
WIDE = {
    "feed": {"min": 0.0, "max": 5.0, "speed": 1.0},
    "limits": {
        "joint_speed_deg_s": 60.0,
        "joint_acceleration_deg_s2": 2000.0,
        "cable_speed": 1.0,
        "cable_travel": (-1.0, 1.0),
    },
}
THIN = {"body_diameter": 0.03, "cable_radius": 0.012}


def arm(*kinds, **changes):
    """An arm of sections of these kinds that is held by nothing but bends, unless changed; some values of sections."""
    of_arm = {name: changes.pop(name) for name in ("feed", "limits", "base_length") if name in changes}
    return robot_of([of_kind(kind, **THIN, **changes) for kind in kinds], **{**WIDE, **of_arm})


ARMS = {
    "arcs": arm(*["arc"] * 6),
    "stacks": arm(*["joints"] * 6),
    "mixed": arm("hinges", "arc", "joints", "link", "arc", "joints"),
}


def a_space(robot, seed=0):
    """Balls round the entrance's axis, and in its way."""
    rng = np.random.default_rng(seed)
    turn, away, ahead = rng.uniform(0, 2 * math.pi, 30), rng.uniform(0.02, 0.2, 30), rng.uniform(0.2, 0.9, 30)
    centres = np.stack([away * np.cos(turn), away * np.sin(turn), ahead * robot.length], axis=1)
    return Scene.from_obstacles([Sphere(center=tuple(each), diameter=0.05) for each in centres.tolist()])


def least_between(steered, before, after, places=9, parts=12):
    """The least clearance while feed and angles go linearly, by small turns and steps along the centre line."""
    robot, least = steered.robot, math.inf
    (feed, angles), (feed_after, angles_after) = before, after
    for part in np.linspace(0, 1, places):
        line, ends, _ = dense_line(robot, angles + part * (angles_after - angles), parts)
        line = line + [0, 0, feed + part * (feed_after - feed) - robot.length]
        radii = robot.body_radii[np.searchsorted(ends[1:], np.arange(1, len(line)))]
        least = min(least, steered.scene.clearance(line[None, :-1], line[None, 1:], radii).value.min())
    return least


def stand(steered):
    return steered.feed, steered.angles


@pytest.mark.parametrize("name", ARMS)
def test_what_is_passed_keeps_the_margin_at_many_more_places_than_were_looked_at(name):
    robot = ARMS[name]
    steered, rng, turn = SteeredPath(robot, a_space(robot), margin=MARGIN), np.random.default_rng(1), np.zeros(2)
    reasons = []
    for _ in range(160):
        turn = 0.9 * turn + rng.normal(size=2) * 0.3 * steered.sharpest
        before = stand(steered)
        move = steered.advance(STEP, turn)
        assert (np.abs(steered.angles) <= robot.bend_limits).all()
        if steered.clearance.min() < MARGIN + STEP:
            assert least_between(steered, before, stand(steered)) >= MARGIN + RESERVE - 1e-6
        if move.held_by:
            reasons.append(move.held_by.reason)
            steered.retreat(rng.uniform(0.02, 0.08))
    assert "clearance" in reasons


@pytest.mark.parametrize("name", ARMS)
def test_certified_clearance_is_no_more_than_that_of_many_places(name):
    """The bound of a single stretch, of a length at which it takes off a lot, against the motion sampled 200 times."""
    robot = ARMS[name]
    steered = SteeredPath(robot, a_space(robot, 2), margin=0.0)
    assert isinstance(steered._way, SectionWay)
    for k in range(70):
        steered.advance(0.006, (2.0 * math.cos(0.1 * k), 1.5))
    assert steered.depth > 0.3, "the way is long enough to say something"
    depths = np.linspace(0.5 * steered.depth, steered.depth, 7)
    marks, vertices = steered._way.place(depths)
    travel, found = steered._way.travel(marks, vertices), steered._surroundings.clearance(vertices)
    bound = 0.5 * (found[:-1] + found[1:] - np.maximum(travel[:, :-1], travel[:, 1:]))
    for k, part in itertools.product(range(6), np.linspace(0, 1, 33)):
        low, high = (marks[j, 1:].reshape(-1, 2) for j in (k, k + 1))
        feed = marks[k, 0] + part * (marks[k + 1, 0] - marks[k, 0])
        place = robot.model.vertices(robot.joint_positions(low + part * (high - low), feed)[None])
        between = steered._surroundings.clearance(place - [0, 0, robot.length])[0]
        near = between < steered.horizon
        assert (bound[k][near] <= between[near] + 1e-9).all()


@pytest.mark.parametrize(("name", "method"), [("arcs", "aim"), ("stacks", "exact"), ("mixed", "aim")])
def test_the_way_back_has_the_same_joints_bit_for_bit_and_so_has_the_way_in_again(name, method):
    robot = ARMS[name]
    steered, rng, poses = SteeredPath(robot, a_space(robot), method=method), np.random.default_rng(3), []

    def pose():
        return steered.depth, steered.feed, steered.joints.tolist(), steered.angles.tolist(), steered.clearance.tolist()

    for k in range(60):
        poses.append(pose())
        steered.advance(rng.uniform(0.0, 0.012), rng.normal(size=2) * 4)
        if k % 20 == 19:  # back between two of the places, and on another way
            steered.retreat(0.013)
            poses = [each for each in poses if each[0] <= steered.depth]
    end = pose()
    for each in reversed(poses):
        steered.retreat(steered.depth - each[0])
        assert pose() == each
    assert steered.depth == steered.feed == 0.0
    assert not steered.angles.any()
    while steered.depth < end[0]:
        steered.advance(min(0.005, end[0] - steered.depth))
    assert pose() == end


@pytest.mark.parametrize("method", ["aim", "exact"])
@pytest.mark.parametrize("name", ARMS)
def test_the_body_follows_the_grown_path_as_the_method_places_it(name, method):
    """Against the follower of plans, on the finished path; the tip is on the path and the base where it should be."""
    robot = ARMS[name]
    steered = SteeredPath(robot, EMPTY, method=method)
    for k in range(60):
        steered.advance(STEP, (2.0 * math.sin(0.1 * k), 1.0))
    path, tip = steered.path, steered.tip
    assert np.linalg.norm(path.point(robot.length + steered.depth) - tip) < 1e-8
    way = [path.with_end(robot.length), robot.link_lengths, [steered.feed]]
    placed = hognose.follow(*way, method=method, model=robot.model, axes=np.eye(3))[0]
    assert np.abs(placed - steered.joints).max() < 1e-7


def test_a_wall_ahead_holds_the_nose_at_the_margin_and_is_named():
    robot = ARMS["arcs"]
    wall = Box(name="a wall", center=(0.0, 0.0, 0.3), size=(1.0, 1.0, 0.02))
    steered = SteeredPath(robot, Scene.from_obstacles([wall]), margin=MARGIN)
    for _ in range(120):
        move = steered.advance(STEP)
    assert move.held_by is not None
    assert (move.held_by.reason, move.held_by.section, move.held_by.obstacle) == ("clearance", 6, "a wall")
    assert "would come too close: the margin is 5.00 mm" in move.held_by.sentence
    # The nose is a round cap of the last section's radius; besides, that arc leaves its chords a little.
    thickness = robot.chord_radii[-1]
    assert 0.29 - thickness - MARGIN - RESERVE - 1.5e-4 < steered.depth <= 0.29 - thickness - MARGIN - RESERVE + 1e-9
    assert steered.advance(STEP).advanced < 1e-4
    assert steered.retreat(0.1).advanced == pytest.approx(-0.1, abs=1e-11)


def test_a_hole_that_the_nose_passes_holds_the_body_which_swings_out():
    """A section behind the nose is held where the nose is free: by its own clearance, and named."""
    robot = ARMS["stacks"]
    board = Board(name="a board", center=(0, 0, 0.12), size=(0.6, 0.6), thickness=0.01, holes=[Hole(diameter=0.05)])
    steered, held = SteeredPath(robot, Scene.from_obstacles([board]), margin=MARGIN), None
    for _ in range(150):
        held = steered.advance(STEP, (steered.sharpest, 0.0)).held_by
        if held:
            break
    assert held is not None
    assert held.section is not None
    assert (held.reason, held.obstacle) == ("clearance", "a board")
    assert held.section < 6
    assert held.value == pytest.approx(1e3 * steered.clearance[held.section - 1], abs=0.02)


def test_bends_are_held_on_the_side_to_which_they_go():
    """Limits differ from side to side: the arm is held at the closer one, and not on the other side."""
    robot = arm(*["arc"] * 6, alpha_range_deg=(-12.0, 40.0), bend_limit_deg=None, beta_range_deg=(-40.0, 40.0))
    low, high = robot.bend_bounds[0, 0]
    assert (low, high) == pytest.approx((math.radians(-12), math.radians(40)))
    steered = SteeredPath(robot, EMPTY)
    assert steered.sharpest == pytest.approx(0.98 * math.radians(12) / 0.091)
    assert steered.advance(0.1, (9.0, 0.0)).limited_by.reason == "bend limit"
    # A path that is gentle enough for a circle, and so crooked that sections behind the nose bend more than that.
    reasons, rng = [], np.random.default_rng(0)
    for _ in range(200):
        move = steered.advance(STEP, steered.sharpest * np.array([rng.choice([-1.0, 1.0]), 0.0]))
        assert (steered.angles >= robot.bend_bounds[..., 0]).all()
        assert (steered.angles <= robot.bend_bounds[..., 1]).all()
        if move.held_by:
            reasons.append(move.held_by.reason)
            steered.retreat(0.05)
    assert set(reasons) <= {"bend limit"}
