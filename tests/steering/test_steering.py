"""Driving an arm by its nose: what it does is safe, exact, reversible, and can be made a task of."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import altered

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.planning import Task
from hognose.robot import Robot
from hognose.scene import Board, Box, Hole, Scene, Sphere
from hognose.steering import SteeredPath

ARM = hognose.load_robot("sjtu-25dof")
EMPTY = Scene.from_obstacles([])
STEP = 0.0035
MARGIN = 0.005
STRAIGHT = (0.0, 0.0)


def a_space(seed):
    """Balls on all sides of the entrance's axis, some of them in the way of a nose that strays."""
    rng = np.random.default_rng(seed)
    angles, away = rng.uniform(0, 2 * np.pi, 40), rng.uniform(0.0, 0.25, 40)
    centres = np.stack([away * np.cos(angles), away * np.sin(angles), rng.uniform(0.12, 0.9, 40)], axis=1)
    return Scene.from_obstacles([Sphere(center=tuple(c), diameter=0.06) for c in centres.tolist()])


def densely(steered, low, high):
    """Joints (T, n+1, 3) by the project's forward following at feeds 0.035 mm apart: an oracle for what was passed."""
    feeds = np.linspace(low, high, 2 + math.ceil((high - low) / (STEP / 100)))
    return hognose.follow(steered.path, steered.robot.link_lengths, feeds)


def assert_safe(steered, low, high, margin=MARGIN):
    """All that was passed between two feeds keeps margin and bend limits."""
    robot, joints = steered.robot, densely(steered, low, high)
    found = steered.scene.clearance(joints[:, :-1], joints[:, 1:], robot.body_radii)
    assert found.value.min() >= margin - 1e-9
    assert (np.abs(robot.angles(joints)) <= robot.bend_limits * (1 + 1e-9)).all()


def assert_exact(steered):
    """The arm is where forward following puts it: on the path, its links as long as they are."""
    joints, path = steered.joints, steered.path
    lengths = np.linalg.norm(np.diff(joints, axis=0), axis=1)
    assert np.abs(lengths - steered.robot.link_lengths).max() <= 1e-12
    assert path.distance_to(joints).max() <= 1e-12
    assert np.abs(hognose.follow(path, steered.robot.link_lengths, [steered.feed])[0] - joints).max() <= 1e-12
    placed = steered.robot.joint_positions(steered.angles, steered.feed) + joints[0] - [0, 0, steered.feed]
    assert np.abs(placed - joints).max() <= 1e-9


def wander(steered, seed, moves, sharpest=6.0):
    """Steer about at random, back off where held; everything passed is looked at before it is forgotten."""
    rng, turn = np.random.default_rng(seed), np.zeros(2)
    since, reasons = steered.feed, set()
    for _ in range(moves):
        turn = 0.9 * turn + rng.normal(size=2) * sharpest / 2
        move = steered.advance(STEP, turn)
        assert 0 <= move.advanced <= STEP
        assert (move.held_by is None) == (move.advanced > STEP - 1e-11)
        if move.held_by or rng.random() < 0.02:
            reasons.add(move.held_by.reason if move.held_by else "")
            assert_safe(steered, since, steered.feed)
            assert_exact(steered)
            back, depth = rng.uniform(0, 0.1), steered.depth
            assert steered.retreat(back).advanced == pytest.approx(-min(back, depth), abs=1e-11)
            since = steered.feed
    assert_safe(steered, since, steered.feed)
    return reasons


@pytest.mark.parametrize("seed", range(6))
def test_whatever_the_operator_does_the_whole_motion_is_clear_and_within_bend_limits(seed):
    steered = SteeredPath(ARM, a_space(seed), margin=MARGIN)
    assert "clearance" in wander(steered, seed, 500)


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank"])
def test_the_bundled_spaces_hold_the_arm_back_too(name, tasks):
    assert "clearance" in wander(SteeredPath.of(tasks[name]), 1, 300)


def test_drives_that_interpolate_joints_between_moves_stay_clear_too():
    steered = SteeredPath(ARM, a_space(3))
    wander(steered, 3, 250)
    steered.retreat(steered.depth)
    feeds, angles = [0.0], [steered.angles]
    while steered.depth < steered.path.length - ARM.length - STEP:
        steered.advance(STEP)
        feeds.append(steered.feed)
        angles.append(steered.angles)
    part = np.linspace(0, 1, 20)[:, None, None]
    between = np.concatenate([a + part * (b - a) for a, b in itertools.pairwise(angles)])
    fed = np.concatenate([a + part[:, 0, 0] * (b - a) for a, b in itertools.pairwise(feeds)])
    joints = ARM.joint_positions(between, fed) - [0, 0, ARM.length]
    assert steered.scene.clearance(joints[:, :-1], joints[:, 1:], ARM.body_radii).value.min() >= MARGIN


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.05, 0.2), st.floats(4, 80), st.floats(4, 80)), min_size=2, max_size=6),
    st.integers(0, 2**32 - 1),
)
def test_no_section_of_any_arm_is_ever_asked_to_bend_too_far(sections, seed):
    spec = ARM.spec.model_dump(mode="json", by_alias=True)["section"][0] | {"count": 1}
    made = [spec | {"pitch": pitch, "bend_limit_deg": [alpha, beta]} for pitch, alpha, beta in sections]
    robot = Robot.from_spec(altered(ARM.spec, {"section": made, "feed.max": 5.0, "limits.cable_travel": [-1.0, 1.0]}))
    steered, rng = SteeredPath(robot, EMPTY), np.random.default_rng(seed)
    for _ in range(12):
        move = steered.advance(robot.length / 12, rng.normal(size=2) * 100)
        assert move.held_by is None or move.held_by.reason == "feed range"
        assert move.limited_by is None or move.limited_by.reason == "bend limit"
    assert_exact(steered)
    assert_safe(steered, 0.0, steered.feed)


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 0.02), st.floats(-8, 8), st.floats(-8, 8)), min_size=1, max_size=60),
    st.floats(1e-4, 0.05),
)
def test_the_way_back_has_the_same_joints_bit_for_bit_and_so_has_the_way_in_again(moves, other_step):
    steered, poses = SteeredPath(ARM, a_space(1)), []
    for distance, x, y in moves:
        poses.append((steered.depth, steered.feed, steered.joints, steered.angles, steered.clearance))
        steered.advance(distance, (x, y))
    end, path = (steered.depth, steered.joints), steered.path
    for depth, feed, joints, angles, clearance in reversed(poses):
        steered.retreat(steered.depth - depth)
        assert (steered.depth, steered.feed) == (depth, feed)
        for now, then in ((steered.joints, joints), (steered.angles, angles), (steered.clearance, clearance)):
            assert np.array_equal(now, then)
    assert steered.depth == steered.feed == 0.0
    assert not steered.angles.any()
    while steered.depth < end[0] and steered.advance(min(other_step, end[0] - steered.depth)).advanced:
        pass
    assert (steered.depth, steered.joints.tolist()) == (end[0], end[1].tolist())
    assert np.array_equal(steered.path.coefficients, path.coefficients), "nothing has grown anew"


def test_growing_leaves_paths_alone_that_were_asked_for_and_steering_anew_drops_what_is_beyond():
    steered = SteeredPath(ARM, EMPTY)
    steered.advance(0.3, (1.0, 0.5))
    before = steered.path
    kept = before.coefficients.copy()
    steered.retreat(0.2)
    assert steered.path.length == pytest.approx(ARM.length + 0.3)
    steered.advance(0.0, (-1.0, 0.0))
    assert steered.path.length == pytest.approx(ARM.length + 0.3), "not moved, not steered"
    steered.advance(0.05, (-1.0, 0.0))
    assert steered.path.length == pytest.approx(ARM.length + 0.15)
    assert np.array_equal(before.coefficients, kept)
    assert np.abs(before.point(ARM.length + 0.09) - steered.path.point(ARM.length + 0.09)).max() < 1e-12


def test_the_path_is_smooth_and_its_parameter_is_its_arc():
    steered, rng = SteeredPath(ARM, EMPTY), np.random.default_rng(5)
    for _ in range(150):
        steered.advance(rng.uniform(0, 0.008), rng.normal(size=2) * 6)
    path = steered.path
    breaks = path.break_arcs[1:-1]
    assert np.abs(path.break_arcs - path.breaks + path.breaks[0]).max() < 1e-6
    left, right = path.frame(breaks - 1e-9), path.frame(breaks + 1e-9)
    assert np.abs(left - right).max(axis=(0, 2)) == pytest.approx([0, 0, 0], abs=1e-5)
    assert path.sharpest[0] <= 2 * math.sin(0.25) / 0.091


@pytest.mark.parametrize(("turn", "axis", "sign"), [((2, 0), 0, 1), ((0, 2), 1, 1), ((-2, 0), 0, -1), ((0, -2), 1, -1)])
def test_the_nose_turns_where_it_is_steered(turn, axis, sign):
    steered = SteeredPath(ARM, EMPTY)
    steered.advance(0.1, STRAIGHT)
    steered.advance(0.1, (1.0, 1.0))
    frame = steered.frame
    assert np.abs(frame.T @ frame - np.eye(3)).max() < 1e-12
    assert np.linalg.det(frame) == pytest.approx(1)
    steered.advance(0.15, STRAIGHT)
    heading, frame = steered.heading, steered.frame
    move = steered.advance(0.15, turn)
    assert move.turn == turn
    turned = frame.T @ steered.heading
    assert turned[axis] * sign == pytest.approx(math.sin(2 * 0.15), abs=0.03)
    assert abs(turned[1 - axis]) < 0.03
    assert abs(frame.T @ heading)[2] == pytest.approx(1)


def pursue(steered, way, ahead=0.04):
    """Drive along a path as an operator who looks a little ahead would; True at its end, False if held."""
    arcs = np.linspace(0, way.length, 4000)
    points = way.point(arcs)
    for _ in range(1000):
        here = arcs[np.argmin(np.linalg.norm(points - steered.tip, axis=1))]
        left = way.length - here
        if left < 5e-4:
            return True
        beyond = max(0.0, here + ahead - way.length)
        goal = way.point(min(here + ahead, way.length)) + beyond * way.tangent(way.length)
        aim = steered.frame.T @ (goal - steered.tip)
        move = steered.advance(min(STEP, left), 2 * aim[:2] / (aim @ aim))
        if move.held_by:
            return False
    return False


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank", "detour"])
def test_what_is_steered_to_the_target_is_a_task_that_plans_good(name, tasks, plans):
    steered, way = SteeredPath.of(tasks[name]), plans[name].path
    assert pursue(steered, way)
    assert np.linalg.norm(steered.tip - way.point(way.length)) < 0.003
    assert_safe(steered, 0.0, steered.feed)
    made = steered.task("steered")
    assert made.plan.good
    assert made.spec.name == "steered"
    assert made.spec.margin == tasks[name].margin
    assert made.spec.obstacle == tasks[name].spec.obstacle
    again = hognose.plan(Task(made.spec, ARM))
    samples = steered.path.point(np.linspace(0, steered.path.length, 3000))
    assert again.path.distance_to(samples).max() <= made.deviation + 1e-6 <= 0.0005 + 1e-6
    assert np.abs(again.joints[-1] - steered.joints).max() < 0.001
    steered.retreat(0.5)
    assert steered.task("after retreat").deviation == made.deviation, "of all that has grown"


def test_a_hard_turn_becomes_a_task_that_is_driven_more_slowly():
    steered = SteeredPath(ARM, EMPTY)
    for turn in ((9.0, 0.0), (-9.0, 0.0), (0.0, 9.0)):
        steered.advance(0.2, turn)
    made = steered.task("slalom", tolerance=0.0001)
    assert made.plan.good
    assert made.deviation <= 0.0001
    assert made.spec.motion.period_s > 0.15
    short = SteeredPath(ARM, EMPTY)
    short.advance(0.05, (2.0, 0.0))
    with pytest.raises(InfeasibleError, match=r"mm wished.*\n.*raise the tolerance") as caught:
        short.task("slalom", tolerance=1e-12)
    assert caught.value.plan is not None


def test_a_task_needs_something_steered_its_obstacles_and_a_name():
    ball = Sphere(center=(0.2, 0.0, 0.2), diameter=0.1)
    steered = SteeredPath(ARM, Scene.from_obstacles([ball]))
    with pytest.raises(InputError, match="nothing has been steered"):
        steered.task("x", [ball])
    steered.advance(0.1, (0.5, 0.0))
    with pytest.raises(InputError, match=r"obstacles: .*SteeredPath.of\(task\)"):
        steered.task("x")
    with pytest.raises(InputError, match="1 to 80 characters"):
        steered.task("", [ball])
    with pytest.raises(InputError, match="tolerance: expected"):
        steered.task("x", [ball], tolerance=0.0)
    assert steered.task("x", [ball]).spec.obstacle == (ball,)


def test_boxes_that_a_search_keeps_out_of_become_obstacles_of_the_task(tasks):
    spec = tasks["detour"].spec
    path = {
        "target": (0.0, 0.0, 1.0),
        "keep_out": ({"kind": "box", "center": (0.3, 0.3, 0.2), "size": (0.1, 0.1, 0.1)},),
    }
    searched = Task(altered(spec, {"path": {"order": 3, **path}}), ARM)
    steered = SteeredPath.of(searched)
    steered.advance(0.1, (0.2, 0.0))
    assert [item.name for item in steered.task("x").spec.obstacle][-1] == "keep-out 1"


def wall_at(z):
    return Scene.from_obstacles([Box(name="wall", center=(0.0, 0.0, z + 0.01), size=(2.0, 2.0, 0.02))])


@pytest.mark.parametrize("step", [0.0001, STEP, 0.5])
def test_a_wall_ahead_holds_the_nose_at_the_margin(step):
    steered, held = SteeredPath(ARM, wall_at(0.1)), None
    while held is None:
        held = steered.advance(step, STRAIGHT).held_by
    nose = 0.1 - steered.tip[2] - ARM.body_radii[-1]
    assert MARGIN + 5e-5 - 1e-9 <= nose < MARGIN + 0.0002  # a reserve is kept for drives that interpolate
    assert (held.reason, held.obstacle, held.section) == ("clearance", "wall", 12)
    assert held.value == pytest.approx(1e3 * nose)
    assert held.limit == 5.0
    assert "section 12 is 5.0" in held.sentence
    assert "from wall, at (0.0, 0.0, 100.0) mm" in held.sentence
    depth = steered.depth
    for _ in range(50):  # pushing does not creep
        assert steered.advance(STEP, (5.0, 0.0)).held_by
    assert steered.depth - depth < 2e-4
    assert steered.clearance.min() == pytest.approx(0.1 - steered.tip[2] - ARM.body_radii[-1], abs=1e-6)
    assert steered.retreat(0.05).held_by is None


def test_a_hole_with_hardly_more_than_the_margin_is_passed():
    hole = Hole(center=(0.0, 0.0), diameter=0.045 + 2 * (MARGIN + 0.0002))
    board = Board(center=(0.0, 0.0, 0.05), size=(1.0, 1.0), thickness=0.01, hole=(hole,))
    steered = SteeredPath(ARM, Scene.from_obstacles([board]))
    for _ in range(100):
        assert steered.advance(STEP, STRAIGHT).held_by is None
    assert steered.clearance.min() < MARGIN + 0.0003
    steered.retreat(steered.depth - 0.02)
    assert steered.advance(0.1, (3.0, 0.0)).held_by


def test_a_turn_is_limited_to_what_the_joints_can_bend():
    steered = SteeredPath(ARM, EMPTY)
    move = steered.advance(0.4, (30.0, 40.0))
    assert move.advanced == pytest.approx(0.4)
    assert move.held_by is None
    assert move.limited_by is not None
    assert (move.limited_by.reason, move.limited_by.section) == ("bend limit", 2)
    assert move.turn == pytest.approx(np.array([0.6, 0.8]) * move.limited_by.limit)
    assert "50 rad/m was asked" in move.limited_by.sentence
    assert "at most 28.65 deg" in move.limited_by.sentence
    bends = np.degrees(np.arccos(np.cos(steered.angles[:, 0]) * np.cos(steered.angles[:, 1])))
    assert 0.97 * 28.65 < bends.max() < 28.65
    assert steered.sharpest == move.limited_by.limit
    assert steered.advance(0.01, (0.0, steered.sharpest)).limited_by is None


def test_the_feed_ends_where_the_slider_does_or_the_first_joint_is_at_the_entrance():
    for most, words in ((0.5, "the slider ends there"), (2.0, "the first joint is at the entrance")):
        robot = Robot.from_spec(altered(ARM.spec, {"feed.max": most}))
        steered = SteeredPath(robot, EMPTY)
        held = steered.advance(3.0, (0.5, 0.0)).held_by
        assert held is not None
        assert held.reason == "feed range"
        assert words in held.sentence
        limit = min(most, robot.length)
        assert limit - 2e-6 < steered.feed <= limit
        assert steered.task("to the end").plan.good
    before = SteeredPath(ARM, EMPTY).retreat(0.01)
    assert before.advanced == 0
    assert before.held_by is not None
    assert "straight at the entrance" in before.held_by.sentence


def test_cables_end_too():
    robot = Robot.from_spec(altered(ARM.spec, {"limits.cable_travel": [-0.005, 0.03]}))
    steered = SteeredPath(robot, EMPTY)
    held = steered.advance(1.0, (3.0, 0.0)).held_by
    assert held is not None
    assert (held.reason, held.limit) == ("cable travel", 5.0)
    travel = robot.cable_lengths(steered.angles) - robot.straight_cable_lengths
    assert -0.005 <= travel.min() < -0.00499
    assert steered.retreat(0.1).held_by is None


@pytest.mark.parametrize(
    ("changes", "reason"),
    [({}, "joint speed"), ({"limits.cable_speed": 0.001}, "cable speed"), ({"feed.speed": 0.001}, "feed speed")],
)
def test_speeds_hold_moves_of_a_given_time_both_ways(changes, reason):
    robot, period = Robot.from_spec(altered(ARM.spec, changes)), 0.02
    steered, reasons = SteeredPath(robot, EMPTY, period_s=period), set()
    for drive in [lambda: steered.advance(0.003, (5.0, 0.0))] * 120 + [lambda: steered.retreat(0.003)] * 120:
        was = steered.angles, steered.feed, robot.cable_lengths(steered.angles)
        move = drive()
        assert move.advanced or steered.depth == 0
        reasons.add(move.held_by.reason if move.held_by else "")
        assert np.degrees(np.abs(steered.angles - was[0]).max()) <= 7.0 * period * (1 + 1e-9)
        assert abs(steered.feed - was[1]) <= robot.spec.feed.speed * period * (1 + 1e-9)
        assert (
            np.abs(robot.cable_lengths(steered.angles) - was[2]).max() <= robot.spec.limits.cable_speed * period + 1e-12
        )
    assert reason in reasons


@pytest.mark.parametrize(
    ("center", "words"),
    [
        ((0.0, 0.0, 0.05), r"section 12 .* is 2\.\d+ mm from 'ball'"),
        ((0.0, 0.0, -0.5), r"section 6 .* from 'ball'|section 6 .* inside 'ball'"),
        ((0.0, 0.0, -1.2), r"the mount .*'ball'"),
    ],
)
def test_a_start_too_close_to_an_obstacle_is_refused(center, words):
    scene = Scene.from_obstacles([Sphere(name="ball", center=center, diameter=0.05)])
    with pytest.raises(InputError, match=words):
        SteeredPath(ARM, scene)
    assert SteeredPath(ARM, scene, entrance=(0.2, 0.0, 0.0)).tip.tolist() == [0.2, 0.0, 0.0]


def test_a_start_inside_a_solid_is_refused():
    scene = Scene.from_obstacles([Box(name="block", center=(0.0, 0.0, 0.0), size=(9.0, 9.0, 9.0))])
    with pytest.raises(InputError, match=r"section 1 .* lies inside 'block'"):
        SteeredPath(ARM, scene)


def test_wrong_numbers_are_refused_and_change_nothing():
    steered = SteeredPath(ARM, EMPTY, margin=0.1)
    steered.advance(0.1, (1.0, 0.0))
    joints = steered.joints
    assert steered.clearance.min() == steered.horizon > 0.1
    for wrong in (
        lambda: steered.advance(-0.1, (0.0, 0.0)),
        lambda: steered.advance(math.nan),
        lambda: steered.advance("far"),  # pyright: ignore[reportArgumentType]
        lambda: steered.retreat(-0.1),
        lambda: steered.advance(0.1, (1.0, math.inf)),
        lambda: steered.advance(0.1, (1.0, 0.0, 0.0)),
        lambda: SteeredPath(ARM, EMPTY, entrance=(0.0, 0.0)),
        lambda: SteeredPath(ARM, EMPTY, margin=-1),
        lambda: SteeredPath(ARM, EMPTY, period_s=0.0),
    ):
        with pytest.raises(InputError, match="expected"):
            wrong()
    steered.joints[:] = 0
    assert np.array_equal(steered.joints, joints)
