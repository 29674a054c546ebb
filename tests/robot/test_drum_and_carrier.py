"""A drum and a carrier: where they put the arm, and how fast they turn it, against rotations of SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_oracles import robot_of, section, tapered_robot
from scipy.spatial.transform import Rotation, Slerp

import hognose
from hognose.errors import InputError
from hognose.path import Path
from hognose.robot.base import angles_on, axes_of, joints_on
from hognose.robot.carrier import Carrier
from hognose.robot.drum import Drum

seeds = st.integers(0, 2**32 - 1)
ARM = hognose.load_robot("sjtu-25dof")


def a_drum(seed):
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(rng=rng).as_matrix()
    return Drum.before(rng.normal(size=3), ARM, rng.uniform(0.19, 0.3), rng.uniform(0.0, 0.2), rotation), rng


def a_carrier(seed):
    rng = np.random.default_rng(seed)
    robot = tapered_robot(seed % 50)
    carrier = Carrier.before(rng.normal(size=3), robot, Rotation.random(rng=rng).as_matrix())
    tangents = Rotation.from_matrix(carrier.R_task_start) * Rotation.from_rotvec(rng.normal(0, 0.4, (6, 3)))
    firsts = np.cumsum(rng.normal(0, 0.02, (6, 3)), axis=0)
    joints = np.cumsum(np.concatenate([firsts[:, None], rng.normal(size=(6, robot.sections, 3))], axis=1), axis=1)
    joints[:, 1] = joints[:, 0] + robot.link_lengths[0] * tangents.as_matrix()[:, :, 2]
    return robot, carrier, joints


@given(seed=seeds)
def test_on_a_drum_the_arm_lies_on_the_circle_and_its_nose_at_the_entrance(seed):
    drum, _ = a_drum(seed)
    path = Path(*drum.lead())
    assert path.length == pytest.approx(drum.run, abs=1e-11)  # quintics are not quite circles
    joints = hognose.follow(
        Path.through([drum.entrance, drum.entrance + drum.direction], 1).with_lead(path),
        ARM.link_lengths,
        [0.0],
    )
    np.testing.assert_allclose(joints[0, 0], drum.start, atol=1e-12)
    np.testing.assert_allclose(joints[0, -1], drum.entrance, atol=1e-9)
    centre = drum.entrance - drum.nozzle * drum.direction + drum.radius * drum.R_task_nozzle[:, 0]
    away = np.linalg.norm(path.point(np.linspace(0, drum.farthest, 500)) - centre, axis=1)
    np.testing.assert_allclose(away, drum.radius, atol=1e-11)
    tangents = path.tangent(np.array([drum.farthest, path.length]))
    np.testing.assert_allclose(tangents, [drum.direction, drum.direction], atol=1e-9)


@given(seed=seeds)
def test_a_drum_turns_at_a_steady_rate_about_its_axis(seed):
    drum, rng = a_drum(seed)
    at = np.sort(rng.uniform(0, drum.farthest, (2, 1)), axis=0)
    at[1] = np.minimum(at[1], at[0] + 3 * drum.radius)  # less than half a turn
    axes = Rotation.from_matrix(axes_of(drum, at))
    spin = drum.spin(at[:1], at[1:])[0]
    np.testing.assert_allclose((axes[0].inv() * axes[1]).as_rotvec(), spin, atol=1e-9)
    zero = np.zeros((2, 1, 3))
    along = np.diff(drum.placed(zero, np.concatenate([at[:1], at[:1] + 1e-7]))[:, 0], axis=0)[0] / 1e-7
    np.testing.assert_allclose(along, axes.as_matrix()[0, :, 2], atol=1e-5)
    # Between two feeds the way is a part of the circle, whose sagitta the acceleration bounds.
    ends = drum.placed(zero, at)[:, 0]
    off = np.linalg.norm(drum.placed(zero[:1], at.mean(axis=0, keepdims=True))[0, 0] - ends.mean(axis=0))
    assert off <= drum.swing(at[:1], at[1:])[0] / 8 + 1e-15


@given(seed=seeds)
def test_a_carrier_points_along_the_first_link_and_turns_the_shortest_way(seed):
    robot, carrier, joints = a_carrier(seed)
    at = carrier.coordinates(np.zeros(6), joints)
    axes = axes_of(carrier, at)
    first = joints[:, 1] - joints[:, 0]
    np.testing.assert_allclose(axes[:, :, 2], first / np.linalg.norm(first, axis=1, keepdims=True), atol=1e-12)
    turns = Rotation.from_matrix(carrier.R_task_start.T @ axes)
    np.testing.assert_allclose(turns.as_rotvec()[:, 2], 0, atol=1e-9)  # no turn about the arm
    np.testing.assert_allclose(np.linalg.norm(at[:, 3:], axis=1), 1, atol=1e-12)
    assert ((at[1:, 3:] * at[:-1, 3:]).sum(axis=1) >= 0).all()
    angles = angles_on(carrier, robot, joints, at)
    np.testing.assert_allclose(angles[:, 0], 0, atol=1e-9)
    lengths = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    scaled = joints_on(carrier, robot, angles, at)
    np.testing.assert_allclose(
        np.diff(scaled, axis=1) / robot.link_lengths[:, None], np.diff(joints, axis=1) / lengths[..., None], atol=1e-9
    )


@given(seed=seeds)
def test_between_two_poses_a_carrier_goes_straight_and_turns_at_a_steady_rate(seed):
    _, carrier, joints = a_carrier(seed)
    at = carrier.coordinates(np.zeros(6), joints)
    low, high = at[:-1], at[1:]
    middle = carrier.settled(0.5 * (low + high))
    quarter = carrier.settled(0.5 * (low + middle))
    np.testing.assert_allclose(middle[:, :3], 0.5 * (low[:, :3] + high[:, :3]), atol=1e-15)
    for k in range(5):
        both = Rotation.from_matrix(axes_of(carrier, at[k : k + 2]))
        between = Slerp([0.0, 1.0], both)
        for part, pose in ((0.5, middle), (0.25, quarter)):
            np.testing.assert_allclose(axes_of(carrier, pose[k : k + 1])[0], between(part).as_matrix(), atol=1e-9)
        np.testing.assert_allclose(
            carrier.spin(low[k : k + 1], high[k : k + 1])[0], (both[0].inv() * both[1]).as_rotvec(), atol=1e-9
        )


@given(seed=seeds)
def test_capsules_behind_a_carrier_contain_its_mount_all_the_time(seed):
    _, carrier, joints = a_carrier(seed)
    carrier = Carrier(carrier.start, carrier.run, 0.3, 0.02, carrier.R_task_start)
    at = carrier.coordinates(np.zeros(6), joints)
    starts, ends, radii = carrier.behind(at)
    for k in range(5):
        both = Rotation.from_matrix(axes_of(carrier, at[k : k + 2]))
        for part in np.linspace(0, 1, 9):
            axes = Slerp([0.0, 1.0], both)(part).as_matrix()
            first = (1 - part) * at[k, :3] + part * at[k + 1, :3]
            for back in np.linspace(0, 0.3, 5):
                place = first - back * axes[:, 2]
                away = min(distance(place, starts[i], ends[i]) - radii[i] for i in (k, k + 5))
                assert away <= -0.02 + 1e-12  # with all of the mount's radius round it


def distance(place, start, end):
    along = end - start
    part = np.clip((place - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(place - start - part * along)


@pytest.mark.parametrize(
    ("radius", "nozzle", "words"),
    [
        (0.1, 0.0, r"joint 2 bends by 54\.1. deg, at most 28\.65 deg; take a radius of 183\.9 mm or more"),
        (0.03, 0.0, "take a radius of 183.9 mm or more"),
        (0.25, 1.2, "is not shorter than the arm"),
    ],
)
def test_a_drum_that_does_not_suit_the_arm_is_refused(radius, nozzle, words):
    with pytest.raises(InputError, match=words):
        Drum.before(np.zeros(3), ARM, radius, nozzle, np.eye(3))


def test_an_arm_that_lies_on_itself_on_its_drum_is_refused():
    long = robot_of([section(count=20)])
    with pytest.raises(InputError, match=r"takes 1\.\d+ turns of a drum of 200 mm; at most 0\.95"):
        Drum.before(np.zeros(3), long, 0.2, 0.0, np.eye(3))


def test_the_radius_that_a_message_names_suits():
    assert Drum.before(np.zeros(3), ARM, 0.1839 + 5e-5, 0.1, np.eye(3)).coil > 0
