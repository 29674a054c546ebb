"""Edges as a draughtsman draws them: sharp ones, outlines of what is round, nothing across a flat face."""

from __future__ import annotations

import manifold3d as m3
import numpy as np
import pytest

from hognose.report.arm import joint_balls, link_bodies, link_edges
from hognose.report.edges import drawn, edges_of, normals_of, runs


def triangles_of(solid):
    mesh = solid.to_mesh()
    return np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts)].astype(float)


def lines_of(solid, eye=(5.0, 4.0, 3.0)):
    triangles = triangles_of(solid)
    return drawn(edges_of(triangles, np.zeros(len(triangles), int)), triangles, np.array(eye))


def test_a_cube_has_its_twelve_edges_and_no_diagonals():
    lines = lines_of(m3.Manifold.cube((1, 1, 1), True))
    assert len(lines) == 12
    np.testing.assert_allclose(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1), 1.0)


def test_two_cubes_that_touch_keep_their_own_edges():
    cube = triangles_of(m3.Manifold.cube((1, 1, 1), True))
    both, owner = np.concatenate([cube, cube + np.array([1, 0, 0])]), np.repeat([0, 1], len(cube))
    assert len(drawn(edges_of(both, owner), both, np.array([5.0, 4.0, 3.0]))) == 24


def test_a_cylinder_shows_its_rims_and_two_lines_of_outline():
    sides = 64
    lines = lines_of(m3.Manifold.cylinder(2.0, 0.5, circular_segments=sides, center=True), eye=(9.0, 1.0, 0.3))
    along = np.abs(lines[:, 1, 2] - lines[:, 0, 2]) > 1.0
    assert along.sum() == 2
    assert (~along).sum() == 2 * sides


def test_the_rim_of_an_open_sheet_is_an_edge():
    sheet = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]], dtype=float)
    assert len(drawn(edges_of(sheet, np.zeros(2, int)), sheet, np.array([0.2, 0.1, 4.0]))) == 4


def test_nothing_has_no_edges():
    empty = np.empty((0, 3, 3))
    assert drawn(edges_of(empty, np.empty(0, int)), empty, np.zeros(3)).shape == (0, 2, 3)


def test_runs_cover_each_line_without_gaps():
    first, last = runs(np.array([2, 2, 0, 0, 2, 2, 2, 1]), np.array([0, 0, 0, 0, 0, 1, 1, 1]))
    assert first.tolist() == [0, 2, 4, 5, 7]
    assert last.tolist() == [2, 4, 4, 7, 7]


@pytest.mark.parametrize("bend", [0.0, 0.4])
def test_link_bodies_have_true_diameter_and_length_and_face_outwards(bend):
    joints = np.array([[0, 0, 0], [0, 0, 0.1], [0.1 * np.sin(bend), 0, 0.1 + 0.1 * np.cos(bend)]])
    radii = np.array([0.02, 0.03])
    for body, start, end, radius in zip(link_bodies(joints, radii), joints, joints[1:], radii, strict=False):
        axis = (end - start) / 0.1
        along = (body - start) @ axis
        across = np.linalg.norm(body - start - along[..., None] * axis, axis=-1)
        assert along.min() == pytest.approx(0, abs=1e-12)
        assert along.max() == pytest.approx(0.1)
        assert across.max() == pytest.approx(radius)
        outwards = np.einsum("ij,ij->i", normals_of(body), body.mean(axis=1) - (start + end) / 2)
        assert (outwards > 0).all()


def test_joint_balls_sit_in_the_inner_joints_and_are_thinner_than_the_links():
    joints = np.array([[0, 0, 0.0], [0, 0, 0.1], [0, 0, 0.2]])
    balls = joint_balls(joints, np.array([0.02, 0.03]))
    assert len(balls) == 1
    away = np.linalg.norm(balls[0] - joints[1], axis=-1)
    assert 0.012 < away.min() <= away.max() < 0.02


def test_what_bends_along_its_length_is_closed_and_has_no_seams():
    joints = np.array([[0, 0, 0.0], [0, 0, 0.1], [0, 0.03, 0.2], [0, 0.09, 0.3]])
    balls = joint_balls(joints, np.full(3, 0.02), [True, False])
    away = np.linalg.norm(balls - joints[1:3, None, None], axis=-1).max(axis=(1, 2))
    np.testing.assert_allclose(away, [0.02, 0.86 * 0.02], rtol=1e-12)
    bodies, eye, rim = link_bodies(joints, np.full(3, 0.02)).reshape(-1, 3, 3), np.array([1.0, -0.5, 0.15]), 40
    lines = [drawn(edges, bodies, eye) for edges in (link_edges(3), link_edges(3, [True, False]))]
    for place, seam in ((0, True), (1, False), (2, True), (3, True)):
        beside = [joints[k + 1] - joints[k] for k in (place - 1, place) if 0 <= k < 3]
        rims = [sum(_in_plane(found, joints[place], normal) for normal in beside) for found in lines]
        assert rims == [rim * len(beside), rim * len(beside) if seam else 0]


def _in_plane(lines, point, normal):
    """How many lines (d, 2, 3) lie in a plane."""
    return int((np.abs((lines - point) @ (normal / np.linalg.norm(normal))) < 1e-9).all(axis=1).sum())


def test_the_edges_of_straight_links_are_those_of_each_link():
    one, three = link_edges(1), link_edges(3)
    assert len(three.corners) == 3 * len(one.corners)
