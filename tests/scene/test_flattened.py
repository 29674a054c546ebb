"""What a file places so that nothing of it is left is refused; what it only mirrors or stretches is taken."""

import numpy as np
import pytest
import trimesh

from hognose.errors import InputError
from hognose.scene.imports.content import RawBody, Source, body_at
from hognose.scene.imports.ply import read

CUBE = trimesh.creation.box()


@pytest.mark.parametrize("turn", [np.zeros((3, 3)), np.diag([1.0, 1.0, 0.0]), np.ones((3, 3))], ids=str)
def test_a_body_that_is_flattened_is_refused_by_name(turn):
    with pytest.raises(InputError, match="the body 'lid' is placed by a transformation that flattens it"):
        body_at("lid", CUBE.vertices, CUBE.faces, turn, np.zeros(3))


@pytest.mark.parametrize("seed", range(20))
def test_any_other_keeps_its_volume_and_its_inside(seed):
    rng = np.random.default_rng(seed)
    turn = rng.normal(size=(3, 3)) * 10.0 ** rng.integers(-6, 6)
    made = body_at("", CUBE.vertices, CUBE.faces, turn, rng.normal(size=3))
    assert isinstance(made, RawBody)
    volume = np.linalg.det(made.vertices[made.faces]).sum() / 6
    assert volume == pytest.approx(abs(np.linalg.det(turn)), rel=1e-3)


def ply(elements: str, rows: str, tmp_path) -> Source:
    head = f"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{elements}"
    return Source(tmp_path / "a.ply", f"{head}end_header\n0 0 0\n1 0 0\n0 1 0\n{rows}\n".encode())


def test_a_face_with_two_lists_of_vertices_is_refused(tmp_path):
    lists = "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar int vertex_index\n"
    with pytest.raises(InputError, match=r"`face` has two lists of vertices \(`vertex_indices`, `vertex_index`\)"):
        read(ply(lists, "3 0 1 2 3 0 1 2", tmp_path))


def test_triangles_in_an_element_that_is_not_read_are_refused(tmp_path):
    numbers = "element triangle 1\nproperty int v1\nproperty int v2\nproperty int v3\n"
    with pytest.raises(InputError, match="holds 1 of an element `triangle`"):
        read(ply(numbers, "0 1 2", tmp_path))
