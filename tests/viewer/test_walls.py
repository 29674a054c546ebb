"""Walls that are seen through: what is drawn is the obstacle, and which ones they are."""

import io

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

import hognose
from hognose.viewer.walls import Walls, blended


class Drawn:
    """A scene that only notes what is drawn."""

    def __init__(self):
        self.nodes = {}

    def add_mesh_simple(self, name, vertices, faces, **options):
        return self._add(name, ("solid", vertices[faces]))

    def add_glb(self, name, data, **options):
        return self._add(name, ("shell", data))

    def _add(self, name, what):
        assert name not in self.nodes
        self.nodes[name] = what
        return Handle(self.nodes, name)


class Handle:
    def __init__(self, nodes, name):
        self._nodes, self._name, self.visible = nodes, name, True

    def remove(self):
        del self._nodes[self._name]


@pytest.fixture
def tank():
    task = hognose.load_task("pipe-tank")
    return task.scene, task.path_through(task.way_points).point(np.linspace(1.1, 1.9, 50))


@pytest.mark.parametrize("opacity", [0.25, 1.0])
def test_a_shell_is_the_same_triangles_in_a_file_that_others_read(opacity):
    triangles = np.random.default_rng(1).normal(size=(7, 3, 3))
    mesh = trimesh.load(
        io.BytesIO(blended(triangles, (255, 128, 0), opacity)), file_type="glb", force="mesh", process=False
    )
    assert isinstance(mesh, trimesh.Trimesh)
    np.testing.assert_allclose(mesh.triangles, triangles, atol=1e-6)
    assert isinstance(mesh.visual, TextureVisuals)
    material = mesh.visual.material
    assert isinstance(material, PBRMaterial)
    assert material.alphaMode == ("BLEND" if opacity < 1 else "OPAQUE")
    np.testing.assert_allclose(np.asarray(material.baseColorFactor), [255, 56, 0, round(255 * opacity)], atol=1)


def test_what_stands_round_the_way_is_seen_through_and_all_is_drawn(tank):
    drawn = Drawn()
    walls = Walls(drawn)  # pyright: ignore[reportArgumentType]
    walls.show(*tank)
    assert list(walls.shells) == ["tank"]
    assert set(walls.parts) == set(tank[0].names)
    kinds = [kind for kind, _ in drawn.nodes.values()]
    assert (kinds.count("shell"), kinds.count("solid")) == (1, len(kinds) - 1)
    walls.show(*tank)
    assert len(drawn.nodes) == len(kinds)


def test_a_thin_wall_between_two_places_of_the_way_is_seen_through():
    scene = hognose.load_task("find-a-way").scene
    walls = Walls(Drawn())  # pyright: ignore[reportArgumentType]
    walls.show(scene, np.array([[0, 0, 0], [0, 0, 0.9]]))
    assert {"boiler", "baffle 1", "baffle 2"} <= set(walls.shells)


def test_hidden_parts_stay_hidden_when_the_opacity_changes_and_in_another_space(tank):
    walls = Walls(Drawn())  # pyright: ignore[reportArgumentType]
    walls.show(*tank)
    walls.hide(("tank", "pipe 2"))
    before = walls.parts["tank"]
    walls.see_through(0.7)
    assert walls.parts["tank"] is not before
    walls.show(*tank)
    assert [name for name, part in walls.parts.items() if not part.visible] == ["tank", "pipe 2"]


@pytest.mark.parametrize("time", [0.0, 7.5, 12.3])
def test_what_moves_is_put_where_it_is_at_a_time_and_stays_there_when_drawn_anew(time):
    task = hognose.load_task("moving-obstacles")
    walls = Walls(Drawn())  # pyright: ignore[reportArgumentType]
    walls.show(task.placed_scene, task.way_points)
    walls.move(task.moving, time)
    walls.see_through(0.7)
    for each in task.moving:
        handle = walls.parts[each.name]
        turned = Rotation.from_quat(np.roll(handle.wxyz, -1)).apply(each.scene.triangles.reshape(-1, 3))
        (moved,) = each.parts_at(time)
        np.testing.assert_allclose(turned + handle.position, moved.triangles.reshape(-1, 3), atol=1e-12)
    assert not hasattr(walls.parts["wall"], "wxyz")
