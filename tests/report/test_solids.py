"""What is drawn of a scene."""

import numpy as np
import pytest
import trimesh

from hognose.report.solids import MOST_POINTS, drawable
from hognose.scene import Box, Scene
from hognose.scene.part import Part


@pytest.mark.parametrize("count", [3, MOST_POINTS * 2 + 1])
def test_points_are_drawn_as_octahedra_and_not_too_many(count):
    points = np.random.default_rng(0).uniform(-1, 1, (count, 3))
    cloud = Part("scan", np.repeat(points[:, None], 3, axis=1), 0.01)
    scene = Scene.from_parts([Part("box", Box(center=(3, 0, 0), size=(1, 1, 1)).triangles()), cloud])
    triangles, owner, edged = drawable(scene)
    assert edged == 12
    np.testing.assert_array_equal(owner, np.repeat([0, 1], [12, len(triangles) - 12]))
    every = 1 if count == 3 else 3
    balls = triangles[12:].reshape(-1, 8, 3, 3)
    assert len(balls) == -(-count // every) <= MOST_POINTS
    first = trimesh.Trimesh(**trimesh.triangles.to_kwargs(balls[0]))
    first.merge_vertices()
    assert first.is_watertight
    radius = 0.01 * np.sqrt(every)
    assert first.volume == pytest.approx(4 / 3 * radius**3, rel=1e-9)
    np.testing.assert_allclose(balls.mean(axis=(1, 2)), points[::every], atol=1e-12)


def test_a_scene_without_points_is_drawn_as_it_is():
    scene = Scene.from_obstacles([Box(center=(0, 0, 0), size=(1, 1, 1))])
    triangles, owner, edged = drawable(scene)
    assert triangles is scene.triangles
    assert owner is scene.owner
    assert edged == 12
