"""The twin of arms whose sections extend: their backbones hold lengths, whatever the cables do."""

import numpy as np
import pytest
from model_makers import SPRINGS, task_on
from robot_oracles import robot_of
from section_makers import of_kind

import hognose
from hognose.mechanics import postures
from hognose.robot.base import centre_line, joints_on
from hognose.sim import Changes, Twin, simulate
from hognose.sim.cable_forces import CableForces
from hognose.sim.log import cells
from hognose.sim.run import _Run
from hognose.sim.set_points import SetPoints
from hognose.studies.charts import body_errors
from hognose.studies.reached import reached

RANGE = (0.06, 0.13)
KEYS = {"bending_stiffness_N_m2": 0.1, "cable_radius": 0.019, "link_mass": 0.05, "bend_limit_deg": 40.0}
LENGTHS = np.array([0.09, 0.07, 0.12, 0.1])


def arm(lengths=(0.09,) * 4, extend=True):
    """A link, arcs that extend with disks and without, and one that does not."""
    own = {**KEYS, **({"length_range": RANGE} if extend else {})}
    parts = [
        of_kind("link", pitch=lengths[0]),
        of_kind("arc", **own | {"disks": 6, "pitch": lengths[1]}),
        of_kind("arc", **own | {"disks": None, "pitch": lengths[2]}),
        of_kind("arc", **KEYS | {"disks": 6, "pitch": lengths[3]}),
    ]
    return robot_of(parts, cables=SPRINGS, tool_length=0.02, tool_mass=0.03)


@pytest.fixture(scope="module")
def robot():
    return arm((0.09, 0.09, 0.09, 0.1))


def bent(robot, seed=4, swing=0.25):
    return np.random.default_rng(seed).uniform(-swing, swing, (robot.sections, 2))


def extended(robot, lengths=LENGTHS, changes=None, **keys):
    """A twin whose sections are held at lengths, and where its base is."""
    twin = Twin(task_on("slider", robot, 1, **keys), changes)
    if robot.extends:
        twin.extend(np.append(lengths[:-1], robot.link_lengths[-1]), np.zeros(robot.sections))
    return twin, np.array([0.1])


def test_held_at_lengths_it_moves_as_the_twin_of_an_arm_of_these_lengths(robot, monkeypatch):
    """But for damping and armature of joints, which are assumed from lengths at rest; with the finest chains."""
    monkeypatch.setattr("hognose.sim.link_body._WITHIN", 1e-9)
    monkeypatch.setattr("hognose.files.exports.mjcf._DAMPING", 0.0)
    monkeypatch.setattr("hognose.files.exports.mjcf._ARMATURE", 0.0)
    found = []
    for each in (robot, arm(LENGTHS, extend=False)):
        twin, at = extended(each)
        pose, rows = bent(each), []
        twin.put(at, pose)
        twin.time_step = 1e-4
        commanded = each.cable_lengths(0.7 * pose, None if each is not robot else twin.sections) - 2e-4
        for step in range(300):
            twin.step(commanded, np.zeros(each.cables), at + 5e-5 * step, np.array([0.5]))
            rows.append(twin.angles)
        found.append((np.array(rows), twin.joints, twin.tensions, twin.base, np.array(twin.stability())))
    assert np.ptp(found[0][0], axis=0).max() > 0.02
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=0, atol=2e-5)
    for one, other in zip(found[0][1:], found[1][1:], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-3, atol=1e-6)


def test_as_lengths_change_it_comes_to_rest_where_the_energy_is_smallest(robot):
    """Slowly, from lengths at rest to others, with the cables' lengths that hold it in each pose."""
    twin, at = extended(robot, robot.link_lengths)
    task, pose = twin._task, bent(robot)
    final = np.append(LENGTHS[:-1], robot.link_lengths[-1])
    twin.put(at, pose)
    gravity = task.gravity(at[None])[0]

    def told(lengths):
        return twin.mechanics.hold(
            np.concatenate([pose, (lengths / robot.link_lengths)[:, None]], axis=1)[None], gravity
        ).commanded_lengths[0]

    twin.shorten_step()
    count = round(0.6 / twin.time_step)
    ways = [robot.link_lengths + k / count * (final - robot.link_lengths) for k in range(count + 1)]
    commanded = np.array([told(way) for way in ways])
    for k in range(count):
        twin.extend(ways[k], (final - robot.link_lengths) / (count * twin.time_step))
        twin.step(commanded[k], (commanded[k + 1] - commanded[k]) / twin.time_step, at, np.zeros(1))
    assert np.abs(twin.angles - pose).max() < 5e-3
    twin.extend(final, np.zeros(robot.sections))
    for _ in range(round(1.0 / twin.time_step)):
        twin.step(commanded[-1], np.zeros(robot.cables), at, np.zeros(1))
    np.testing.assert_allclose(twin.angles, pose, rtol=0, atol=2e-4)
    np.testing.assert_array_equal(twin.sections, final)
    rest = twin.resting(at, pose, commanded[-1] + 3e-4 * np.cos(np.arange(robot.cables)))
    assert rest is not None
    assert np.abs(rest - pose).max() > 1e-3
    joints = joints_on(task.base, robot, twin.angles[None], twin.base[None], final[None])[0]
    np.testing.assert_allclose(twin.joints, joints, rtol=0, atol=1e-9)
    line = centre_line(task.base, robot, joints[None], twin.base[None], twin.angles[None])[0]
    np.testing.assert_allclose(twin._body.points(), line, rtol=0, atol=1e-9)


def test_its_chain_of_small_joints_is_as_long(robot):
    """Masses and touches are those of the chain: its tip is where the sections have it."""
    twin, at = extended(robot)
    twin.put(at, bent(robot, swing=0.5))
    chain = twin._body.data.xpos[twin._body.bodies[-1]]
    assert np.linalg.norm(chain - twin.joints[-1]) < 5e-3 * robot.length
    twin.put(at, np.zeros((robot.sections, 2)))
    np.testing.assert_allclose(twin._body.data.xpos[twin._body.bodies[-1]], twin.joints[-1], rtol=0, atol=1e-12)


def test_a_plan_whose_lengths_change_goes_where_it_is_planned_to():
    plan = hognose.plan(hognose.load_task("baffled-tank"))
    assert np.ptp(plan.section_lengths, axis=0).min() > 1e-4
    done = simulate(plan)
    assert done.good
    assert done.tip_errors.max() < 0.02e-3
    np.testing.assert_allclose(done.section_lengths, plan.section_lengths, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(cells(done)["length_02_m"], done.section_lengths[:, 1])
    assert body_errors(done).max() < 0.02e-3
    reaching = reached(done)
    np.testing.assert_allclose(reaching.section_lengths, plan.section_lengths, rtol=0, atol=1e-5)
    np.testing.assert_allclose(reaching.cable_lengths, plan.cable_lengths, rtol=0, atol=2e-5)


def test_set_points_have_lengths_between_those_of_the_plan():
    plan, period = hognose.plan(hognose.load_task("baffled-tank")), 60
    given, (before, after) = SetPoints.of(plan, period, 0.01, 0.0), plan.section_lengths[period - 1 : period + 1]
    assert np.abs(after - before).max() > 1e-6
    parts = np.arange(len(given.lengths) + 1)[:, None] / len(given.lengths)
    np.testing.assert_allclose(given.sections, before + parts * (after - before), rtol=0, atol=1e-15)
    np.testing.assert_allclose(given.section_speeds, (after - before) / 0.15, rtol=1e-9)
    held = given.held(3, 0.05)
    np.testing.assert_array_equal(held.sections, np.tile(given.sections[2], (len(held.lengths) + 1, 1)))
    np.testing.assert_array_equal(held.section_speeds, 0.0)


def test_friction_along_cables_is_that_of_an_arm_of_these_lengths(robot):
    found, pose = [], bent(robot)
    for each in (robot, arm(LENGTHS, extend=False)):
        twin, _ = extended(each, changes=Changes(friction=0.3))
        forces, lengths = CableForces.of(twin.mechanics), twin.sections
        forces.grip[:] = 1.0
        still = np.zeros(2 * each.sections), each.cable_lengths(pose, lengths) - 1e-3, np.zeros(each.cables)
        forces.pull(postures(each, pose[None], lengths[None])[0], *still)
        found.append(forces)
    assert np.ptp(found[0].means) > 1e-3
    for name in ("lengths", "means", "shares", "tensions"):
        np.testing.assert_allclose(getattr(found[0], name), getattr(found[1], name), rtol=1e-9)


def test_the_time_step_is_for_the_shortest_sections_on_the_way(monkeypatch):
    """These are lighter and stiffer than at the start, where steps that are too long for them would do."""
    plan, seen, shorten = hognose.plan(hognose.load_task("baffled-tank")), [], Twin.shorten_step
    monkeypatch.setattr(Twin, "shorten_step", lambda twin, bends: (seen.append(twin.sections), shorten(twin, bends)))
    _Run(plan, Changes(), None)
    np.testing.assert_allclose(np.min(seen, axis=0), plan.section_lengths.min(axis=0), rtol=1e-12)
    np.testing.assert_allclose(np.max(seen, axis=0), plan.section_lengths.max(axis=0), rtol=1e-12)
    np.testing.assert_allclose(seen[-1], plan.section_lengths[0], rtol=1e-12)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_cables_feel_how_fast_sections_get_longer(robot, friction):
    """Against differences of lengths in time: what damps, and which way cables slide."""
    twin, _ = extended(robot, changes=Changes(friction=friction))
    pose, speeds, still = bent(robot), np.array([0.0, 0.02, -0.03, 0.0]), np.zeros(robot.cables)
    ahead, step = np.append(LENGTHS[:-1], robot.link_lengths[-1]), 1e-6
    forces = CableForces.of(twin.mechanics)
    commanded = robot.cable_lengths(pose, ahead) - 1e-3
    posture = np.concatenate([pose, (ahead / robot.link_lengths)[:, None]], axis=1)
    forces.pull(posture, np.zeros(2 * robot.sections), commanded, still, 0.0)
    at_rest = forces.tensions.copy()
    np.testing.assert_allclose(forces.lengths, robot.cable_lengths(pose, ahead), rtol=0, atol=1e-14)
    forces.pull(posture, np.zeros(2 * robot.sections), commanded, still, 0.0, speeds)
    faster = (robot.cable_lengths(pose, ahead + step * speeds) - robot.cable_lengths(pose, ahead)) / step
    np.testing.assert_allclose(forces.tensions - at_rest, 30.0 * faster, rtol=1e-6, atol=1e-9)
    for _ in range(1000):
        forces.pull(posture, np.zeros(2 * robot.sections), commanded, still, 0.1, speeds)
    if friction:
        last = robot.cable_sections
        np.testing.assert_array_equal(forces.grip[last == 1, 1], 1.0)  # paid out beside what gets longer
        np.testing.assert_array_equal(forces.grip[last == 2, 2], -1.0)
        np.testing.assert_array_equal(forces.grip[last == 1, 0], 1.0)
        np.testing.assert_array_equal(forces.grip[last == 3, 0], -1.0)
