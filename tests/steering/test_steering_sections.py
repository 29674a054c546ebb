"""Steering arms whose sections are no links: what they do between two moves, each against many places in between."""

import itertools
import math
import re

import numpy as np
import pytest
from robot_oracles import robot_of
from section_makers import THIN, WIDE, dense_line, of_kind, thin_arm

import hognose
from hognose.errors import InputError
from hognose.planning import Task
from hognose.planning.checks import run_checks
from hognose.robot.base import Slider
from hognose.robot.carrier import Carrier
from hognose.scene import Board, Box, Hole, Scene, Sphere
from hognose.steering import SteeredPath
from hognose.steering.clearance import RESERVE
from hognose.steering.section_way import SectionWay
from hognose.steering.stand import nearest_method
from hognose.viewer.model.arm_state import ArmState

MARGIN, STEP = 0.005, 0.004
EMPTY = Scene.from_obstacles([])
ARMS = {
    "arcs": thin_arm(*["arc"] * 6),
    "stacks": thin_arm(*["joints"] * 6),
    "mixed": thin_arm("hinges", "arc", "joints", "link", "arc", "joints"),
}


def a_space(robot, seed=0):
    """Balls round the entrance's axis, and in its way."""
    rng = np.random.default_rng(seed)
    turn, away, ahead = rng.uniform(0, 2 * math.pi, 30), rng.uniform(0.02, 0.2, 30), rng.uniform(0.2, 0.9, 30)
    centres = np.stack([away * np.cos(turn), away * np.sin(turn), ahead * robot.length], axis=1)
    return Scene.from_obstacles([Sphere(center=tuple(each), diameter=0.05) for each in centres.tolist()])


def least_between(steered, before, after, places=5, parts=8):
    """The least clearance of points of the centre line, by small turns and steps, while feed and angles go linearly."""
    robot, least = steered.robot, math.inf
    (feed, angles), (feed_after, angles_after) = before, after
    for part in np.linspace(0, 1, places):
        line, ends, _ = dense_line(robot, angles + part * (angles_after - angles), parts)
        line += np.array([0.0, 0.0, feed + part * (feed_after - feed) - robot.length])
        radii = robot.body_radii[np.searchsorted(ends[1:], np.arange(len(line)))]
        least = min(least, steered.scene.clearance(line[None], line[None], radii).value.min())
    return least


def stand(steered):
    return steered.feed, steered.angles


def held_at(steered, turn=None, moves=200):
    """What holds the first of some moves that is held."""
    for _ in range(moves):
        held = steered.advance(STEP, turn).held_by
        if held is not None:
            return held
    pytest.fail("nothing holds the arm")


@pytest.mark.parametrize("name", ARMS)
def test_what_is_passed_keeps_the_margin_at_many_more_places_than_were_looked_at(name):
    robot = ARMS[name]
    steered, rng, turn = SteeredPath(robot, a_space(robot), margin=MARGIN), np.random.default_rng(1), np.zeros(2)
    reasons = []
    for _ in range(90):
        turn = 0.9 * turn + rng.normal(size=2) * 0.3 * steered.sharpest
        before = stand(steered)
        move = steered.advance(STEP, turn)
        assert (np.abs(steered.angles) <= robot.bend_limits).all()
        if steered.clearance.min() < MARGIN + 0.5 * STEP:
            assert least_between(steered, before, stand(steered)) >= MARGIN + RESERVE - 1e-6
        if move.held_by:
            reasons.append(move.held_by.reason)
            steered.retreat(rng.uniform(0.02, 0.08))
    assert "clearance" in reasons


@pytest.mark.parametrize("name", ARMS)
def test_certified_clearance_is_no_more_than_that_of_many_places(name):
    """The bound of stretches that are so long that it takes off a lot, against the motion sampled 33 times in each."""
    robot = ARMS[name]
    steered = SteeredPath(robot, a_space(robot, 2), margin=0.0)
    assert isinstance(steered._way, SectionWay)
    for k in range(70):
        if steered.advance(0.006, (2.0 * math.cos(0.1 * k), 1.5)).held_by:
            break
    assert steered.depth > 0.1, "the way is long enough to say something"
    depths = np.linspace(0.5 * steered.depth, steered.depth, 7)
    marks, vertices = steered._way.place(depths)
    travel, found = steered._way.travel(marks, vertices), steered._surroundings.clearance(vertices)
    bound = 0.5 * (found[:-1] + found[1:] - np.maximum(travel[:, :-1], travel[:, 1:]))
    for k, part in itertools.product(range(6), np.linspace(0, 1, 33)):
        low, high = (marks[j, 1:].reshape(-1, 2) for j in (k, k + 1))
        feed = marks[k, 0] + part * (marks[k + 1, 0] - marks[k, 0])
        place = robot.model.vertices(robot.joint_positions((low + part * (high - low))[None], np.array([feed])))
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
    held = held_at(steered)
    assert (held.reason, held.section, held.obstacle) == ("clearance", 6, "a wall")
    assert "would come too close: the margin is 5.00 mm" in held.sentence
    # The nose is a round cap of the last section's radius; besides, that arc leaves its chords a little.
    thickness = robot.chord_radii[-1]
    assert 0.29 - thickness - MARGIN - RESERVE - 1.5e-4 < steered.depth <= 0.29 - thickness - MARGIN - RESERVE + 1e-9
    assert steered.advance(STEP).advanced < 1e-4
    assert steered.retreat(0.1).advanced == pytest.approx(-0.1, abs=1e-11)


def test_a_section_behind_the_nose_is_held_by_its_own_clearance_and_named():
    """The last section passes a hole that the thicker one behind it does not; where that one's round end is held."""
    parts = [of_kind("joints", **THIN) | {"body_diameter": thick} for thick in (0.05, 0.05, 0.026)]
    hole = (Hole(center=(0.0, 0.0), diameter=0.045),)
    board = Board(name="a board", center=(0.0, 0.0, 0.04), size=(0.6, 0.6), thickness=0.01, hole=hole)
    steered = SteeredPath(robot_of(parts, **WIDE), Scene.from_obstacles([board]), margin=MARGIN)
    held = held_at(steered)
    assert (held.reason, held.section, held.obstacle) == ("clearance", 2, "a board")
    away = 0.025 + MARGIN + RESERVE
    end = 0.035 - math.sqrt(away**2 - 0.0225**2)
    assert end + 0.091 - 1.5e-4 < steered.depth <= end + 0.091 + 1e-9


@pytest.mark.parametrize(("turn", "name"), [((-1.0, 0.0), "alpha"), ((0.0, 1.0), "beta")])
def test_bends_are_held_on_the_side_to_which_they_go(turn, name):
    """Limits of 12 degrees to one side, of which the turn knows nothing, and of 35 degrees to the other."""
    robot = thin_arm(*["arc"] * 6, alpha_range_deg=(-12.0, 35.0), beta_range_deg=(-12.0, 35.0))
    steered = SteeredPath(robot, EMPTY)
    assert steered.sharpest == pytest.approx(0.85 * math.radians(35) / 0.091)
    to_close, to_wide = (steered.sharpest * 0.7 * np.array(turn) * side for side in (1, -1))
    held = held_at(steered, to_close)
    assert (held.reason, held.unit) == ("bend limit", "deg")
    assert held.limit == pytest.approx(12.0)
    assert re.match(rf"{name} of section {held.section} would be -1[234]\.?\d* deg, limit -12 deg", held.sentence)
    axis = ("alpha", "beta").index(name)
    assert steered.angles[int(held.section or 0) - 1, axis] == pytest.approx(math.radians(-12), abs=1e-4)
    assert (steered.angles >= robot.bend_bounds[..., 0]).all()
    steered.retreat(steered.depth)
    for _ in range(100):
        assert steered.advance(STEP, to_wide).held_by is None
    assert steered.angles[:, axis].max() > math.radians(20)


def test_an_arm_that_bends_to_one_side_only_is_steered_to_that_side():
    robot = thin_arm(*["joints"] * 4, alpha_range_deg=(0.0, 35.0))
    steered = SteeredPath(robot, EMPTY, method="exact")
    assert steered.advance(0.08, (2.0, 0.0)).advanced > 0.05
    assert (steered.angles >= robot.bend_bounds[..., 0]).all()


def test_the_body_does_not_touch_itself():
    robot = thin_arm(*["arc"] * 8, pitch=0.06, bend_limit_deg=80.0)
    steered = SteeredPath(robot, EMPTY)
    held = held_at(steered, (0.85 * steered.sharpest, 0.0))
    assert (held.reason, held.other_section) == ("own body", 8)
    assert "would come too close: the body must not touch itself" in held.sentence
    line, ends, _ = dense_line(robot, steered.angles, 40)
    touched = int(held.section or 0)
    first, last = line[ends[touched - 1] : ends[touched] + 1], line[ends[7] :]
    apart = np.linalg.norm(first[:, None] - last[None], axis=2).min() - 0.03
    assert RESERVE < apart < RESERVE + 2e-3


@pytest.mark.parametrize(
    ("limits", "reason"),
    [
        ({"cable_travel": (-0.004, 0.004)}, "cable travel"),
        ({"joint_speed_deg_s": 5.0}, "joint speed"),
        ({"cable_speed": 0.002}, "cable speed"),
    ],
)
def test_cables_and_speeds_hold_a_move(limits, reason):
    robot = thin_arm(*["arc"] * 4, limits={**WIDE["limits"], **limits})
    steered, held = SteeredPath(robot, EMPTY, period_s=0.1), None
    for _ in range(60):
        angles, cables = steered.angles, robot.cable_lengths(steered.angles)
        held = steered.advance(STEP, (5.0, 0.0)).held_by
        assert np.degrees(np.abs(steered.angles - angles).max()) <= robot.spec.limits.joint_speed_deg_s * 0.1 + 1e-9
        now = robot.cable_lengths(steered.angles)
        assert np.abs(now - cables).max() <= robot.spec.limits.cable_speed * 0.1 + 1e-12
        assert np.abs(now - robot.straight_cable_lengths).max() <= robot.spec.limits.cable_travel[1] + 1e-12
        if held:
            break
    assert held is not None
    assert held.reason == reason


def test_what_is_steered_is_a_task_whose_file_checks_good(tmp_path):
    robot = ARMS["mixed"]
    wall = Box(name="a wall", center=(0.12, 0.0, 0.25), size=(0.1, 0.2, 0.1))
    steered = SteeredPath(robot, Scene.from_obstacles([wall]), margin=MARGIN, method="aim")
    for k in range(50):
        steered.advance(STEP, (-1.5 if k < 25 else 1.5, 0.5))
    made = steered.task("by hand", [wall])
    assert (made.plan.good, made.spec.motion.method) == (True, "aim")
    assert made.deviation <= 0.0005
    made.plan.save(tmp_path / "plan.parquet")
    loaded = hognose.Plan.load(tmp_path / "plan.parquet")
    assert run_checks(loaded)
    assert not [check.sentence for check in run_checks(loaded) if check.failed]
    assert np.abs(loaded.body[-1, -1] - steered.tip).max() < 0.0006


def test_methods_and_bases_that_do_not_steer_are_refused_in_words():
    arcs = ARMS["arcs"]
    with pytest.raises(InputError, match=r"fitted finds each pose from those before it.* steered with exact or aim"):
        SteeredPath(arcs, EMPTY, method="fitted")
    with pytest.raises(InputError, match="fabrik is for rigid links; test arm is steered with exact or aim"):
        SteeredPath(arcs, EMPTY, method="fabrik")
    with pytest.raises(InputError, match="links are steered with their joints on the path, by exact; got 'aim'"):
        SteeredPath(hognose.load_robot("sjtu-25dof"), EMPTY, method="aim")
    at = Slider.before(np.zeros(3), arcs)
    carrier = Carrier(at.start, arcs.length, 0.0, 0.01, np.eye(3))
    with pytest.raises(
        InputError, match="followed from a slider or a cart so far; expected one of these, got a Carrier"
    ):
        SteeredPath(arcs, EMPTY, base=carrier)
    fitted = hognose.load_task("baffled-tank")
    motion = fitted.spec.motion.model_copy(update={"method": "aim"})
    task = Task(fitted.spec.model_copy(update={"motion": motion}), fitted.robot)
    with pytest.raises(InputError, match=r"motion\.method in the task"):
        SteeredPath.of(fitted)
    assert SteeredPath.of(fitted, method="exact").method == "exact"
    assert nearest_method(task.robot, "fitted") == SteeredPath.of(task).method == "aim"


def test_a_slider_in_any_direction_has_the_arm_in_its_own_axes():
    """The same turns on a slider along +x make the same angles, and the same body turned."""
    robot = ARMS["mixed"]
    turned = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    plain = SteeredPath(robot, EMPTY)
    other = SteeredPath(robot, EMPTY, base=Slider.before(np.zeros(3), robot, turned))
    for k in range(30):
        for each in (plain, other):
            each.advance(STEP, (2.0, 0.1 * k))
    assert np.abs(plain.angles - other.angles).max() < 1e-9
    assert np.abs(plain.vertices @ turned.T - other.vertices).max() < 1e-9
    state = ArmState.of_steered(other)
    assert state.vertices.shape == (len(robot.chord_radii) + 1, 3)
    assert np.abs(state.joints[-1] - other.tip).max() == 0.0
