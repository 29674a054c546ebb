"""The twin: it does what the plan wants where it should, and fails as a real arm does."""

import re

import numpy as np
import pytest
from model_makers import Mujoco, random_poses, sprung_robot, task_on
from twin_makers import shortened

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.files.exports import export
from hognose.files.exports.mjcf_cables import DAMPING
from hognose.mechanics import Mechanics
from hognose.planning import Task
from hognose.robot import Robot
from hognose.robot.base import joints_on
from hognose.scene import Board, Hole, Scene
from hognose.sim import Changes, Twin, simulate
from hognose.sim.cable_forces import CableForces
from hognose.sim.contact import PARTS, Contact


@pytest.fixture(scope="module")
def boards():
    return hognose.plan(hognose.load_task("obstacle-array"))


def sprung(task: Task, **cables) -> Task:
    """The same task for an arm with other cables."""
    spec = task.robot.spec
    assert spec.cables is not None
    return Task(task.spec, Robot.from_spec(spec.model_copy(update={"cables": spec.cables.model_copy(update=cables)})))


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank"])
def test_the_arm_goes_where_it_is_planned_to(name):
    done = simulate(hognose.plan(hognose.load_task(name)))
    told = done.to_json()
    assert (done.stopped, done.touched, told["largest_contact_N"]) == ("", (), 0.0)
    assert len(done.angles) == len(done.plan.time)
    assert np.sqrt(np.mean(done.tip_errors**2)) < 0.03e-3
    off = done.angles - done.plan.angles
    assert np.degrees(np.sqrt(np.mean(off**2))) < 0.005
    assert done.tensions.min() > 5.0
    assert done.plan.held is not None
    np.testing.assert_allclose(done.tensions[0], done.plan.held.tensions[0], rtol=1e-9)
    assert done.smallest_stiffness.min() > 5.0
    np.testing.assert_allclose(done.smallest_stiffness, done.plan.held.smallest_stiffness, rtol=0.05)


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_other_cables_cost_millimetres(boards, factor):
    done = simulate(boards, Changes(stiffness=factor))
    assert not any(array.flags.writeable for array in (done.time, done.angles, done.tensions, done.pressing))
    assert 0.3e-3 < np.sqrt(np.mean(done.tip_errors**2)) < 1.5e-3
    assert not done.stopped


def test_cables_pull_as_those_of_the_exported_model_do(tmp_path):
    robot = sprung_robot()
    task = task_on("slider", robot, 1)
    export(task, tmp_path / "model.xml")
    model, forces, rng = Mujoco((tmp_path / "model.xml").read_bytes()), CableForces.of(Mechanics.of(robot)), np.random
    rates = rng.default_rng(0).normal(size=2 * robot.sections)
    for at, angles in zip(*random_poses(task, 4), strict=True):
        model.set(task, at, angles)
        lengths = robot.cable_lengths(angles)
        speeds = forces.mechanics.cable_jacobian(angles[None])[0] @ rates
        torques = forces.pull(angles, rates, lengths - 1e-4, speeds)
        np.testing.assert_allclose(forces.lengths, model.data.ten_length, rtol=0, atol=1e-12)
        k = forces.mechanics.spring_constants(lengths)
        np.testing.assert_allclose(forces.tensions, 1e-4 * k, rtol=1e-9)  # paid out as fast as they are stretched
        np.testing.assert_allclose(torques, -forces.jacobian.T @ forces.tensions, atol=1e-12)
        forces.pull(angles, rates, lengths - 1e-4, speeds - 0.01)
        np.testing.assert_allclose(forces.tensions, 1e-4 * k + 0.01 * DAMPING, rtol=1e-9)
        forces.pull(angles, rates, lengths + 1e-3, speeds)
        np.testing.assert_array_equal(forces.tensions, 0)  # slack


@pytest.mark.parametrize("kind", ["slider", "cart", "drum", "arm"])
def test_every_base_moves_the_arm(kind):
    plan = hognose.plan(task_on(kind, sprung_robot(), 3))
    done = simulate(plan)
    assert not done.stopped
    assert done.tip_errors.max() < 0.3e-3
    wanted = joints_on(plan.task.base, plan.robot, plan.angles, plan.at)
    np.testing.assert_allclose(done.joints[-1], wanted[-1], rtol=0, atol=0.1e-3)


def test_it_comes_to_rest_where_statics_say(boards):
    """Pretension alone, without regard to the weight: the arm hangs as the mechanics find by continuation."""
    task, step = boards.task, 250
    twin, mechanics = Twin(task), Mechanics.of(boards.robot)
    angles, at = boards.angles[step], boards.at[step]
    rest = mechanics.uncompensated(angles[None], task.gravity(at[None]))
    assert rest.is_stable.all()
    lengths = boards.robot.cable_lengths(angles)
    commanded = lengths - mechanics.pretension / mechanics.spring_constants(lengths)
    twin.put(at, rest.angles[0])
    for _ in range(2500):
        twin.step(commanded, np.zeros(boards.robot.cables), at, np.zeros(1))
    reached = joints_on(task.base, boards.robot, rest.angles, at[None])[0, -1]
    assert np.linalg.norm(twin.joints[-1] - reached) < 0.1e-3


@pytest.mark.parametrize(("shift", "touches"), [(0.02, False), (0.03, True)])
def test_a_board_that_stands_elsewhere_is_touched_from_some_shift_on(boards, shift, touches):
    done = simulate(boards, Changes(shifted={"board 2": (0.0, shift, 0.0)}))
    assert done.touched == (("board 2",) if touches else ())
    assert (done.contact.max() > 1.0) == touches
    assert (np.sqrt(np.mean(done.tip_errors**2)) > 1e-3) == touches
    if touches:  # before the first touch it is where it is planned
        first = int(np.flatnonzero(done.contact.max(axis=1))[0])
        assert first > 50
        assert done.tip_errors[5:first].max() < 0.05e-3


def test_too_much_pretension_buckles(boards):
    task = sprung(boards.task, axial_stiffness_N=25e3, pretension_N=60.0)
    with pytest.raises(InfeasibleError, match="buckles") as caught:
        hognose.plan(task)
    done = simulate(caught.value.plan)
    assert "the arm buckles: the smallest eigenvalue of its stiffness is -" in done.stopped
    assert re.search(r"N m/rad; section \d+ turns most; `hognose mechanics` says", done.stopped)
    assert len(done.angles) < len(done.plan.time)


def test_an_axis_that_crosses_a_surface_stops_it(boards, monkeypatch):
    at_the_nose = Changes(shifted={"board 1": (0.07, 0.0, 0.0)})
    assert simulate(boards, at_the_nose).stopped == "start: link 12 is inside board 1"
    monkeypatch.setattr(Twin, "inside", lambda self, time: None)
    done = simulate(boards, at_the_nose)
    assert done.stopped == "period 1: the axis of link 12 has crossed the surface of board 1"
    assert len(done.angles) == 2
    contact = Contact(boards.robot, boards.scene)
    contact.touches(boards.joints[200])
    assert contact.crossed is None
    contact.touches(boards.joints[200] + [0.0, 0.1, 0.0])
    assert contact.crossed is not None
    assert contact.crossed[1].startswith("board")


def test_an_arm_that_is_pushed_against_a_board_buckles(boards):
    done = simulate(boards, Changes(shifted={"board 2": (0.12, 0.0, 0.0)}))
    assert "the arm buckles" in done.stopped
    assert done.touched == ("board 2",)
    assert re.search(r"section \d+ turns most(, link \d+ touches board 2)+, \d+ cables? (is|are) slack;", done.stopped)
    assert 100 < len(done.angles) < len(done.plan.time)


def test_a_step_is_as_short_as_the_stiffness_needs(boards):
    """Stiff cables and much friction need shorter steps, and the arm goes as planned all the same."""
    stiff = shortened(hognose.plan(sprung(boards.task, axial_stiffness_N=1e6)), 12)
    for plan, changes in ((stiff, Changes()), (shortened(boards, 12), Changes(friction=1.0))):
        done = simulate(plan, changes)
        assert not done.stopped
        assert done.tip_errors.max() < 1e-3


def test_a_step_that_is_too_long_for_the_stiffness_is_refused(boards):
    with pytest.raises(InputError, match=r"time step: 0.0625 ms, the shortest, is too long for cables of EA 1e\+09 N"):
        simulate(boards, Changes(stiffness=1e4))


def test_what_is_missing_or_unknown_is_named(boards):
    with pytest.raises(InputError, match=r"no obstacle is called 'bord 2'; there are board 1, board 2, board 3"):
        simulate(boards, Changes(shifted={"bord 2": (0.0, 0.0, 0.0)}))
    spec = boards.robot.spec.model_copy(update={"cables": None})
    plan = hognose.plan(Task(boards.task.spec, Robot.from_spec(spec)))
    with pytest.raises(InputError, match=r"mechanics of sjtu-25dof: the robot file has no table \[cables\]"):
        simulate(plan)


@pytest.mark.parametrize(("smaller", "count"), [(0.001, 0), (-0.001, 1)])
def test_a_hole_stays_a_hole(boards, smaller, count):
    robot, thickness = boards.robot, 0.004
    hole = Hole(center=(0.0, 0.0), diameter=2 * (float(robot.body_radii[0]) + smaller / 2))
    board = Board(center=(0, 0, 0.14), size=(0.5, 0.5), thickness=thickness, hole=(hole,))
    contact = Contact(robot, Scene.from_obstacles([board], tolerance=1e-5))
    joints = robot.joint_positions(np.zeros((robot.sections, 2)))
    touches = contact.touches(joints)
    assert len(touches) == count
    for touch in touches:
        assert touch.link == 1
        assert touch.obstacle == "board 1"
        assert touch.depth == pytest.approx(-smaller / 2, abs=2e-5)
        assert abs(touch.normal[2]) < 1e-9
    assert contact.crossed is None


def test_contact_is_that_of_the_scene_wherever_the_arm_goes(boards):
    """What is remembered leaves nothing out: the touches are those of a contact that never saw another pose."""
    robot, scene, rng = boards.robot, boards.scene, np.random.default_rng(2)
    contact, seen = Contact(robot, scene), 0
    for step in range(0, 313, 3):
        shift = np.array([0.0, 0.03 * np.sin(step / 20), 0.0]) + rng.normal(0, 1e-3, 3)
        joints = boards.joints[step] + shift
        found, fresh = contact.touches(joints), Contact(robot, scene).touches(joints)
        assert [(t.link, t.obstacle) for t in found] == [(t.link, t.obstacle) for t in fresh]
        for one, other in zip(found, fresh, strict=True):
            np.testing.assert_array_equal(one.place, other.place)
            assert one.depth == other.depth
        seen += len(found)
        share = np.linspace(0, 1, PARTS + 1)[:, None]
        places = joints[:-1, None] + share * np.diff(joints, axis=0)[:, None]
        ends = places[:, :-1].reshape(-1, 3), places[:, 1:].reshape(-1, 3)
        deep = np.repeat(robot.body_radii, PARTS) - scene.distance(*ends).value
        np.testing.assert_allclose([t.depth for t in found], deep[(deep > 0)], atol=1e-12)
    assert seen > 10
