"""The twin of arms whose sections are no rigid links."""

import numpy as np
import pytest
from model_makers import SPRINGS, task_on
from robot_oracles import random_angles, robot_of, section
from section_makers import mixed_robot, of_kind

import hognose
from hognose.errors import InputError
from hognose.files import load_robot
from hognose.mechanics.sensitivity import bends_of_cables
from hognose.planning import Task, TaskSpec
from hognose.robot.base import centre_line, joints_on
from hognose.sim import Changes, Twin, simulate
from hognose.sim.cable_forces import CableForces
from hognose.sim.contact import Touch

ROD = {"bending_stiffness_N_m2": 0.6, "cable_radius": 0.019}


def soft_robot(ranges=None, **changes):
    """A link, a stack and two arcs, whose cables are springs and whose other sections bend back."""
    own = ranges or {}
    parts = [section(**own), of_kind("joints", **ROD, **own), of_kind("arc", count=2, disks=6, **ROD, **own)]
    return robot_of(parts, **{"cables": SPRINGS, "tool_length": 0.02, "tool_mass": 0.03, **changes})


def bent(robot):
    """A pose (n, 2) rad well within the limits."""
    return 0.5 * random_angles(robot, np.random.default_rng(4))


def stand(task, at=0.1):
    return np.array([at]), task.gravity(np.array([[at]]))[0]


def test_the_arm_of_arcs_goes_where_it_is_planned_to():
    plan = hognose.plan(hognose.load_task("baffled-tank"))
    done = simulate(plan)
    assert done.good
    assert done.plan.held is not None
    assert done.tip_errors.max() < 0.05e-3
    assert np.degrees(np.abs(done.angles - done.commanded).max()) < 0.3
    np.testing.assert_allclose(done.tensions[0], done.plan.held.tensions[0], rtol=1e-9)
    np.testing.assert_allclose(done.smallest_stiffness, done.plan.held.smallest_stiffness, rtol=0.05)


def test_hinges_that_all_but_meet_move_as_links_do_in_mujocos_integration():
    """Two ways to integrate one arm: MuJoCo's, and the equations of motion of two angles a section."""
    links = robot_of([section(count=3)], cables=SPRINGS, tool_mass=0.02)
    hinges = robot_of([section(count=3, kind="hinges", axis_offset=1e-8)], cables=SPRINGS, tool_mass=0.02)
    found = []
    for robot in (links, hinges):
        task = task_on("slider", robot, 1)
        twin, start, (at, _) = Twin(task), bent(robot), stand(task)
        twin.put(at, start)
        commanded = robot.cable_lengths(0.8 * start) - 2e-4
        rows = []
        for step in range(60):
            twin.step(commanded, np.zeros(robot.cables), at + 0.001 * step, np.array([0.5]))
            rows.append(twin.angles)
        found.append((np.array(rows), twin.joints, twin.tensions, twin.base))
    assert np.ptp(found[0][0], axis=0).max() > 0.02
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=0, atol=1e-6)
    for one, other in zip(found[0][1:], found[1][1:], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(("mass", "own"), [(1.0, None), (1.6, None), (1.0, {"passing_cable_radius": 0.012})])
def test_it_comes_to_rest_where_the_energy_is_smallest(mass, own):
    """Statics know nothing of MuJoCo, nor of chains of small joints."""
    robot = soft_robot(own)
    task = task_on("slider", robot, 2)
    twin, pose, (at, gravity) = Twin(task, Changes(mass=mass)), bent(robot), stand(task)
    commanded = twin.mechanics.hold(pose[None], task.gravity(at[None])).commanded_lengths[0]
    commanded = commanded + np.random.default_rng(0).normal(0.0, 2e-4, robot.cables)
    rest = twin.resting(at, pose, commanded)
    assert rest is not None
    assert np.isfinite(gravity).all()
    twin.put(at, pose, commanded)
    twin.shorten_step()
    for _ in range(round(1.2 / twin.time_step)):
        twin.step(commanded, np.zeros(robot.cables), at, np.zeros(1))
    assert np.abs(rest - pose).max() > 2e-3
    np.testing.assert_allclose(twin.angles, rest, rtol=0, atol=2e-4)
    joints = joints_on(task.base, robot, twin.angles[None], twin.base[None])[0]
    np.testing.assert_allclose(twin.joints, joints, rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", ["slider", "arm"])
def test_what_touches_pushes_along_the_way_of_the_place_that_it_touches(kind):
    """Against differences of points of the body's own line."""
    robot = mixed_robot(8, cables=SPRINGS)
    task = task_on(kind, robot, 3)
    twin, angles = Twin(task), bent(robot)
    at = np.array([0.1]) if kind == "slider" else np.array([0.1, -0.2, 0.3, 0.5, 0.5, -0.5, 0.5])
    body = twin._body
    twin.put(at, angles)

    def line(q):
        joints = joints_on(task.base, robot, q.reshape(1, -1, 2), at[None])
        return centre_line(task.base, robot, joints, at[None])[0]

    np.testing.assert_allclose(body.line, line(angles.ravel()), rtol=0, atol=1e-9)
    for chord in (0, len(robot.chord_sections) // 2, len(robot.chord_sections) - 1):
        place = 0.6 * body.line[chord] + 0.4 * body.line[chord + 1]
        normal = np.array([0.6, -0.48, 0.64])
        way = body.way(Touch(0, "", chord, place, normal, 0.0, np.zeros(3)))
        aside, wanted = 1e-6, np.zeros(2 * robot.sections)
        for a in range(wanted.size):
            step = aside * np.eye(wanted.size)[a]
            high, low = line(angles.ravel() + step), line(angles.ravel() - step)
            moved = 0.6 * (high[chord] - low[chord]) + 0.4 * (high[chord + 1] - low[chord + 1])
            wanted[a] = normal @ moved / (2 * aside)
        np.testing.assert_allclose(way[body.first :], wanted, rtol=0, atol=0.02 * robot.length)
        if body.first:
            assert way[0] == pytest.approx(normal @ task.base.direction)


@pytest.mark.parametrize("ranges", [None, {"alpha_range_deg": (-20.0, 12.0)}])
def test_limits_of_bends_are_stops(ranges):
    robot = soft_robot(ranges)
    limits = robot.bend_bounds[:, 0, 1]
    task = task_on("slider", robot, 2, gravity_m_s2=(0, 0, 0))
    twin, (at, _) = Twin(task), stand(task)
    wanted = np.zeros((robot.sections, 2))
    wanted[:, 0] = 1.2 * limits
    twin.put(at, wanted / 1.3)
    commanded = robot.cable_lengths(wanted)
    for _ in range(200):
        twin.step(commanded, np.zeros(robot.cables), at, np.zeros(1))
    beyond = twin.angles[1:, 0] / limits[1:]
    assert (beyond > 0.99).all()
    assert (beyond < 1.05).all()


def test_a_body_of_arcs_touches_a_hole_that_is_too_narrow():
    robot = robot_of([of_kind("arc", count=3, disks=6, **ROD)], cables=SPRINGS)
    radius = float(robot.body_radii[0])
    for wider, touches in ((1e-3, False), (-1e-3, True)):
        hole = {"center": (0.0, 0.0), "diameter": 2 * (radius + wider)}
        board = {"kind": "board", "center": (0, 0, 0.06), "size": (0.3, 0.3), "thickness": 0.004, "hole": [hole]}
        spec = {
            "name": "hole",
            "robot": robot.name,
            "margin": 0.0,
            "gravity_m_s2": (0, 0, 0),
            "path": {"way_points": [(0, 0, 0), (0, 0, 0.06), (0, 0, 0.15)], "detour": False},
            "obstacle": [board],
        }
        twin, straight = Twin(Task(TaskSpec.model_validate(spec), robot)), np.zeros((3, 2))
        commanded = robot.cable_lengths(straight) - 2e-4
        twin.put(np.array([0.09]), straight, commanded)
        for k in range(100):
            twin.step(commanded, np.zeros(robot.cables), np.array([0.09 + 1e-4 * k]), np.array([0.05]))
        assert {touch.link for touch, _ in twin.touches} == ({2} if touches else set())
        assert not twin.fell_apart
        assert np.abs(twin.angles).max() < 0.02


def test_friction_is_that_of_the_bends_on_the_way_of_a_cable():
    robot = soft_robot()
    twin = Twin(task_on("slider", robot, 2), Changes(friction=0.2))
    pose = bent(robot)
    forces = CableForces.of(twin.mechanics)
    forces.grip[:] = 1.0
    still = np.zeros(2 * robot.sections)
    commanded = robot.cable_lengths(pose) - 1e-3
    forces.pull(pose, still, commanded, np.zeros(robot.cables), 1e-3)
    total = np.cumsum(bends_of_cables(robot, pose[None])[0])[robot.cable_sections]
    np.testing.assert_allclose(forces.shares[:, -1], np.exp(0.2 * total), rtol=1e-9)


@pytest.mark.parametrize("name", ["zju-24cable", "on-wing-taper"])
def test_an_arm_without_cables_is_refused(name):
    robot = load_robot(name)
    with pytest.raises(InputError, match=f"mechanics of {name}: the robot file has no table \\[cables\\]; give"):
        Twin(task_on("slider", robot, 0))
