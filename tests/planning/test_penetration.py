"""Links inside solids: how deep, in which one, and what the plan's figures make of it."""

import numpy as np
import pytest

import hognose
from hognose.planning import Task, TaskSpec
from hognose.planning.penetration import clearance_of, penetration
from hognose.scene import Box, Scene, Sphere
from hognose.viewer.model.arm_state import too_close

RADIUS = np.array([0.02])


def scene(*obstacles):
    return Scene.from_obstacles(obstacles)


def block(name="block", center=(0.0, 0.0, 0.5), size=(0.4, 0.4, 0.4)):
    return Box(name=name, center=center, size=size)


def clearance(scene, start, end):
    return float(clearance_of(scene, np.array([[start, end]]), RADIUS, 0.05)[0, 0])


@pytest.mark.parametrize("x", [0.0, 0.05, -0.12, 0.19])
def test_a_link_inside_a_block_is_as_deep_as_its_axis_and_its_radius(x):
    assert clearance(scene(block()), (x, 0, 0.45), (x, 0, 0.55)) == pytest.approx(-(0.2 - abs(x)) - 0.02, abs=1e-12)


def test_a_link_through_a_ball_is_as_deep_as_its_middle():
    ball = Sphere(name="ball", center=(0, 0, 0.5), diameter=0.06)
    through = clearance(scene(ball), (0, 0, 0.4), (0, 0, 0.6))
    assert through == pytest.approx(-0.03 - 0.02, abs=3e-4)  # the ball's mesh lies round the ball by so much


def test_the_depth_is_that_in_the_solid_not_to_what_else_is_in_there():
    """A bolt in a block: its surface is near, and no way out."""
    bolt = block("bolt", (0.03, 0, 0.5), (0.02, 0.02, 0.02))
    found = clearance(scene(block(), bolt), (0, 0, 0.45), (0, 0, 0.55))
    assert found == pytest.approx(-0.2 - 0.02, abs=1e-12)


def test_clearance_changes_no_faster_than_the_link_moves():
    random = np.random.default_rng(0)
    here = scene(block())
    for _ in range(20):
        start = random.uniform(-0.4, 0.4, 3) + np.array([0, 0, 0.5])
        end = start + random.normal(scale=0.08, size=3)
        move = random.normal(size=3)
        move *= 0.004 / np.linalg.norm(move)
        # From outside, as a whole motion of one link.
        body = np.stack([[start, end] + k * move for k in range(-100, 101)])
        values = clearance_of(here, body, RADIUS, 10.0)[:, 0]
        assert np.abs(np.diff(values)).max() <= 0.004 + 1e-9


def test_links_that_are_outside_are_not_deep():
    found = penetration(scene(block()), np.array([[0.3, 0, 0.5]]), np.array([[0.3, 0, 0.6]]))
    assert (found.depth[0], found.obstacle[0]) == (0.0, -1)


def test_the_obstacle_that_the_arm_is_deepest_in_is_the_one_named():
    """A plate is cut first; in the block behind it the arm is deeper, and its surface is far from the deepest link."""
    plate = {"kind": "box", "name": "plate", "center": [0, 0, 0.2], "size": [0.5, 0.5, 0.01]}
    thick = {"kind": "box", "name": "block", "center": [0, 0, 0.6], "size": [0.5, 0.5, 0.4]}
    spec = TaskSpec.model_validate(
        {
            "name": "through",
            "robot": "sjtu-25dof",
            "path": {"way_points": [[0, 0, 0], [0, 0, 0.95]], "detour": False},
            "obstacle": [plate, thick],
        }
    )
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(Task(spec, hognose.load_robot("sjtu-25dof")))
    plan = caught.value.plan
    assert plan is not None
    check = plan.check("clearance_at_steps")
    assert check.obstacle == "block"
    assert "inside block, deepest at (0.0, 0.0, " in check.detail
    assert check.value == pytest.approx(-0.2 - 0.0225, abs=0.006)
    assert plan.clearance.min() == pytest.approx(check.value)
    for proven in ("certified_along_path", "certified_interpolated", "certified_cables"):
        assert plan.check(proven).value <= check.value + 1e-12
    dots = too_close(plan)
    assert len(dots)
    assert np.all((np.abs(dots[:, 2] - 0.2) < 0.03) | (np.abs(dots[:, 2] - 0.6) < 0.2301))
    assert (np.abs(dots[:, 2] - 0.6) < 0.05).any()
