"""Closed bodies written with triangles both ways, or wound this way here and that way there, have their inside."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from hognose.scene import Scene
from hognose.scene.imports.repair import repaired

seeds = st.integers(0, 2**32 - 1)


def both_ways(faces, which):
    """Faces with those of `which` there the other way as well."""
    return np.concatenate([faces, faces[which][:, ::-1]])


def spoilt(rng, faces, flips, doubles):
    """Faces of which some are flipped, some are there both ways, in another order, from other corners."""
    faces = np.array(faces)
    flip = rng.uniform(size=len(faces)) < flips
    faces[flip] = faces[flip][:, ::-1]
    faces = rng.permutation(both_ways(faces, rng.uniform(size=len(faces)) < doubles))
    return np.stack([np.roll(face, rng.integers(3)) for face in faces])


def together(*meshes):
    """Vertices and faces of several meshes as one."""
    offset = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [np.array(mesh.faces) + first for mesh, first in zip(meshes, offset[:-1], strict=True)]
    return np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces)


def inside(made, points):
    return (Scene.from_meshes(["body"], [made.vertices[made.faces]]).inside(points) >= 0).tolist()


@given(seed=seeds, flips=st.sampled_from([0.0, 0.1, 0.5, 1.0]), doubles=st.sampled_from([0.0, 0.3, 1.0]))
@settings(max_examples=40, deadline=None)
def test_of_a_closed_body_every_triangle_is_there_once_and_faces_outwards(seed, flips, doubles):
    rng = np.random.default_rng(seed)
    shapes = [
        trimesh.creation.box(rng.uniform(0.5, 2, 3)),
        trimesh.creation.icosphere(1, 0.7),
        trimesh.creation.cylinder(0.6, 1.5, sections=9),
    ]
    apart = [mesh.apply_translation([4.0 * k, 0, 0]) for k, mesh in enumerate(shapes)]
    vertices, faces = together(*apart)
    made = repaired(vertices, spoilt(rng, faces, flips, doubles))
    assert (made.open_edges, made.twisted_edges) == (0, 0)
    assert len(made.faces) == len(faces)
    assert made.volume == pytest.approx(sum(mesh.volume for mesh in apart), rel=1e-9)
    points = rng.uniform(vertices.min(axis=0) - 0.1, vertices.max(axis=0) + 0.1, (200, 3))
    behind = [((points[:, None] - m.triangles[:, 0]) * m.face_normals).sum(axis=2) < 0 for m in apart]  # all convex
    assert inside(made, points) == np.any([planes.all(axis=1) for planes in behind], axis=0).tolist()


@given(seed=seeds, flips=st.sampled_from([0.0, 0.3, 0.5]), doubles=st.sampled_from([0.0, 0.3, 1.0]))
@settings(max_examples=20, deadline=None)
def test_a_cavity_stays_one_whatever_the_wall_round_it_is_like(seed, flips, doubles):
    rng = np.random.default_rng(seed)
    outer, ball = trimesh.creation.box((4, 4, 4)), trimesh.creation.icosphere(1, 1.0)
    ball.invert()
    ball_faces = np.array(ball.faces)
    few = rng.choice(len(ball_faces), 3, replace=False)
    ball_faces[few] = ball_faces[few][:, ::-1]
    faces = np.concatenate([spoilt(rng, outer.faces, flips, doubles), ball_faces + len(outer.vertices)])
    made = repaired(np.concatenate([outer.vertices, ball.vertices]), faces)
    assert (made.open_edges, made.twisted_edges) == (0, 0)
    assert made.volume == pytest.approx(outer.volume - abs(ball.volume), rel=1e-9)
    assert inside(made, [[0.1, 0.2, 0.1], [1.5, 1.4, 1.3], [2.1, 0, 0]]) == [False, True, False]


@given(seed=seeds)
@settings(max_examples=20, deadline=None)
def test_a_ball_in_a_box_that_may_be_either_is_solid(seed):
    """Nothing tells a cavity from a solid if its triangles are there both ways: an arm in it is not let through."""
    rng = np.random.default_rng(seed)
    outer, ball = trimesh.creation.box((4, 4, 4)), trimesh.creation.icosphere(1, 1.0)
    vertices, faces = together(outer, ball)
    made = repaired(vertices, spoilt(rng, faces, 0.5, 1.0))
    assert (made.open_edges, made.twisted_edges) == (0, 0)
    assert inside(made, [[0.1, 0.2, 0.1], [1.5, 1.4, 1.3], [2.1, 0, 0]]) == [True, True, False]


def test_what_was_done_is_told():
    mesh = trimesh.creation.box()
    faces = np.array(mesh.faces)
    assert repaired(mesh.vertices, faces).repairs == ()
    made = repaired(mesh.vertices, both_ways(faces, np.arange(12)))
    assert made.repairs == ("12 triangles that were there both ways kept once",)
    assert repaired(mesh.vertices, both_ways(faces, [4])).repairs == ("1 triangle that was there both ways kept once",)
    faces[::2] = faces[::2][:, ::-1]
    assert repaired(mesh.vertices, faces).repairs == ("6 triangles turned round so that all face outwards",)


@pytest.mark.parametrize(
    ("name", "faces"),
    [
        ("a sheet", [[0, 1, 2], [0, 2, 3]]),
        ("one triangle", [[0, 1, 2]]),
    ],
)
def test_a_sheet_that_is_there_both_ways_is_not_watertight(name, faces):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    made = repaired(corners, both_ways(np.array(faces), np.arange(len(faces))))
    assert made.open_edges == len(faces) * 2 + 1, name
    assert len(made.faces) == 2 * len(faces)
    assert made.repairs == ()


def test_a_body_both_ways_with_a_fin_is_a_defect():
    mesh = trimesh.creation.box()
    a, b = mesh.faces[0][:2]
    faces = np.concatenate([mesh.faces, [[a, b, 8]]])
    vertices = np.concatenate([mesh.vertices, [[3.0, 3.0, 3.0]]])
    made = repaired(vertices, both_ways(faces, np.arange(13)))
    assert made.open_edges == 20
    assert len(made.faces) == 26


def test_a_fin_both_ways_on_a_body_is_none():
    """Fans of polygons with a slit cover it there and back, too."""
    mesh = trimesh.creation.box()
    a, b = mesh.faces[0][:2]
    faces = np.concatenate([mesh.faces, [[a, b, 8], [b, a, 8]]])
    made = repaired(np.concatenate([mesh.vertices, [[3.0, 3.0, 3.0]]]), faces)
    assert (made.open_edges, made.twisted_edges, made.repairs) == (0, 0, ())
    assert made.volume == pytest.approx(1.0)
    np.testing.assert_array_equal(inside(made, [[0.1, 0.2, 0.3], [1.0, 1.1, 1.2]]), [True, False])


def test_a_surface_with_one_side_stays_as_it_is():
    """The projective plane of six vertices: two triangles at every edge, and no way to wind them alike."""
    faces = np.array(
        [
            [0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1],
            [1, 2, 4], [2, 3, 5], [3, 4, 1], [4, 5, 2], [5, 1, 3],
        ]
    )  # fmt: skip
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert np.unique(edges, axis=0, return_counts=True)[1].tolist() == [2] * 15
    vertices = np.random.default_rng(1).normal(size=(6, 3))
    made = repaired(vertices, faces)
    np.testing.assert_array_equal(made.vertices[made.faces], vertices[faces])
    assert made.twisted_edges > 0
    assert made.repairs == ()
