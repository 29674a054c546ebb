"""The search for arms whose sections bend along their length, each part against an independent computation."""

import numpy as np
import pytest
from route_makers import searched

import hognose
from hognose.planning import Task
from hognose.robot import Robot, RobotSpec
from hognose.route import Search
from hognose.route.fit.motion import insertion
from hognose.route.fit.objective import Objective, judge
from hognose.route.fit.section_rows import section_frames
from hognose.route.lengths import Lengths

WINDING = np.array([[0, 0, 0], [0.03, 0.01, 0.2], [0.12, 0.04, 0.4], [0.05, 0.05, 0.6], [-0.08, 0.06, 0.95]])


def arcs(sections, **more):
    """The bundled arm with so many arcs in place of its links, as long as it is."""
    data = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True, exclude_none=True)
    section = data["section"][0] | {"kind": "arc", "count": sections, "pitch": 1.092 / sections, **more}
    section.pop("half_lengths")
    section["bend_limit_deg"] = 28.6 * 12 / sections
    data["section"] = [section]
    data["limits"].update(joint_speed_deg_s=60.0, joint_acceleration_deg_s2=2000.0, cable_speed=1.0)
    data["limits"]["cable_travel"] = (-1.0, 1.0)
    data.pop("cables", None)
    return Robot.from_spec(RobotSpec.model_validate(data))


def task_of(robot, method):
    task = searched("obstacle-array")
    motion = task.spec.motion.model_copy(update={"method": method})
    return Task(task.spec.model_copy(update={"motion": motion, "robot": robot.name}), robot)


@pytest.mark.parametrize(("sections", "method"), [(12, "aim"), (4, "fitted")])
def test_an_insertion_is_what_the_method_makes_of_the_path(sections, method):
    robot = arcs(sections)
    task = task_of(robot, method)
    path = task.path_through(WINDING)
    motion = insertion(path, robot, task.base, method)
    assert motion is not None
    assert np.linalg.norm(motion.joints[-1, -1] - WINDING[-1]) < 1e-5
    axes = np.eye(3)
    made = hognose.follow(
        path.with_end(1.0), robot.link_lengths, motion.feeds, method, 0.0005, robot.bend_limits, robot.model, axes
    )
    assert np.abs(made - motion.joints).max() < 1e-9
    assert np.abs(robot.model.vertices(made - made[:, :1]) + made[:, :1] - motion.line).max() < 1e-9
    beside = np.linalg.norm(path.point(path.arc_length(motion.feet)) - motion.line, axis=2)
    assert beside.max() < 0.05
    _, tips = robot.model.positions(motion.angles, motion.feeds, robot.link_lengths)
    frames = section_frames(motion.angles, np.broadcast_to(axes, (len(motion.feeds), 3, 3)))
    assert np.abs(frames[:, -1] - tips).max() < 1e-12


@pytest.mark.parametrize(("sections", "method"), [(12, "aim"), (4, "fitted")])
def test_residuals_fall_the_way_that_their_derivatives_say(sections, method):
    """A guess where the body leaves the path: it leads down, and by about as much as it says."""
    robot = arcs(sections)
    task = task_of(robot, method)
    path = task.path_through(WINDING)
    guide = path.point(np.linspace(robot.length, path.length, 200))
    free = np.array([True, True, True, False])
    objective = Objective(
        robot, task.base, task.scene, task.path_through, 3, 0.05, 0.005, guide, free, method=task.spec.motion.method
    )
    judged = judge(objective, WINDING)
    assert judged is not None
    residuals, rows = judged.residuals(0.05, 2.0)
    assert residuals @ residuals == pytest.approx(judged.merit(0.05, 2.0))
    slope = 2 * rows.T @ residuals
    step = 1e-5 * (slope / np.linalg.norm(slope)).reshape(3, 3)
    both = [judge(objective, WINDING + np.pad(sign * step, ((1, 1), (0, 0)))) for sign in (1, -1)]
    merits = [one.merit(0.05, 2.0) for one in both if one is not None]
    assert merits[0] - merits[1] == pytest.approx(2 * slope @ step.ravel(), rel=0.6)


@pytest.mark.slow
def test_a_route_is_found_for_four_arcs_and_is_good():
    robot = arcs(4)
    search = Search(task_of(robot, "fitted"), None, 0, most=6)
    search.run()
    assert search.best is not None
    assert search.best.plan.good
    assert search.best.plan.task.spec.motion.method == "fitted"


def test_tapered_arms_are_searched_on_a_grid_for_the_middle_of_the_body_and_links_as_ever():
    robot = hognose.load_robot("on-wing-taper")
    lengths = Lengths.of(robot, 0.001, 1.2)
    assert lengths.half == pytest.approx(0.0075)
    assert lengths.body == pytest.approx(0.5 * (0.0065 + 0.020) + 0.001, abs=1e-4)
    assert lengths.turn == pytest.approx(0.12)  # it could bend to 64 mm, with too many headings
    links = Lengths.of(hognose.load_robot("sjtu-25dof"), 0.005, 1.0)
    assert links.body == links.half
