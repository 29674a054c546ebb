"""Sides of one body that meet only to rounding enclose together what none of them does."""

import numpy as np
import pytest
import trimesh

from hognose.errors import InputError
from hognose.scene import Box, Mesh, Scene


def sides(tmp_path, noise: float, seed: int = 0, **more) -> Mesh:
    """A box of 200 mm as an OBJ of six groups, whose corners are off by the noise (mm)."""
    rng = np.random.default_rng(seed)
    box = trimesh.creation.box((200, 200, 200))
    lines, count = [], 0
    for k in range(6):
        outwards = np.sign(k % 2 - 0.5) * np.eye(3)[k // 2]
        faces = box.faces[box.face_normals @ outwards > 0.5]
        corners = box.vertices[faces].reshape(-1, 3) + rng.uniform(-noise, noise, (6, 3))
        lines += [f"g side{k}", *(f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in corners)]
        lines += [f"f {count + 1} {count + 2} {count + 3}", f"f {count + 4} {count + 5} {count + 6}"]
        count += 6
    (tmp_path / "box.obj").write_text("\n".join(lines))
    return Mesh(file=str(tmp_path / "box.obj"), units="mm", name="block", **more)


@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-3, 0.1])
def test_what_is_inside_of_the_box_is_inside_of_its_sides(tmp_path, noise):
    scene = Scene.from_obstacles([Box(center=(9, 0, 0), size=(1, 1, 1)), sides(tmp_path, noise)])
    points = np.random.default_rng(1).uniform(-0.15, 0.15, (500, 3))
    wanted = (np.abs(points) < 0.0995).all(axis=1)
    clear = (np.abs(points) > 0.1005).any(axis=1)
    found = scene.inside(points)
    assert (found[wanted] >= 1).all()
    assert (found[clear] < 0).all()
    assert scene.names[found[wanted][0]].startswith("block")


def test_surfaces_without_an_inside_stay_so(tmp_path):
    scene = Scene.from_obstacles([sides(tmp_path, 1e-3, solid=False)])
    assert scene.inside(np.zeros((1, 3))) == [-1]


def test_sides_of_two_files_are_not_one_body(tmp_path):
    """Half a box each, in two obstacles: nothing says that they belong together."""
    whole = sides(tmp_path, 1e-3)
    half = [whole.model_copy(update={"name": name, "position": (0.0, 0.0, z)}) for name, z in (("a", 0.0), ("b", 0.5))]
    found = Scene.from_obstacles(half).inside(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.0, 0.0, 0.25]]))
    assert found.tolist()[2] == -1
    assert (found[:2] >= 0).all()
    assert found[0] != found[1]


def test_a_target_in_a_block_of_loose_sides_is_refused(tmp_path):
    import hognose

    sides(tmp_path, 1e-4)
    (tmp_path / "task.toml").write_text(
        'name = "loose"\nunits = "mm"\nrobot = "sjtu-25dof"\nmargin = 5.0\n'
        "[path]\nway_points = [[0, 0, 0], [0, 0, 500]]\n"
        '[[obstacle]]\nkind = "mesh"\nfile = "box.obj"\nunits = "mm"\nposition = [0, 0, 500]\n'
    )
    with pytest.raises(InputError, match="lies inside the obstacle 'box"):
        hognose.plan(hognose.load_task(tmp_path / "task.toml"))
