"""Repairs are safe, and what is inside is told in groups as it is triangle by triangle."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_oracles import brute_distance

from hognose.scene import Scene
from hognose.scene.imports.repair import merged_vertices, repaired
from hognose.scene.winding import _FAR, _winding

seeds = st.integers(0, 2**32 - 1)


def soup(mesh):
    """A mesh as STL has it: three vertices of its own for each triangle."""
    return np.array(mesh.triangles).reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3)


@given(seed=seeds, integers=st.booleans())
@settings(max_examples=50, deadline=None)
def test_merging_keeps_every_corner_where_it_is(seed, integers):
    rng = np.random.default_rng(seed)
    vertices = rng.integers(-2, 3, (60, 3)).astype(float) if integers else rng.normal(size=(60, 3)).astype(np.float32)
    vertices = vertices.astype(np.float64) * rng.choice([1, -0.0, 1e-3])
    faces = rng.integers(0, 50, (40, 3))
    places, index, merged = merged_vertices(vertices, faces)
    np.testing.assert_array_equal(places[index], vertices[faces])
    used = np.unique(vertices[np.unique(faces)] + 0.0, axis=0)
    assert len(places) == len(used)
    assert merged == len(np.unique(faces)) - len(used)
    # In the order of their first use in the file.
    _, first = np.unique(index, return_index=True)
    assert len(np.unique(places, axis=0)) == len(places)
    assert len(first) == len(places)


@given(seed=seeds)
@settings(max_examples=30, deadline=None)
def test_no_surface_vanishes_and_none_is_added(seed):
    rng = np.random.default_rng(seed)
    vertices = rng.integers(-2, 3, (25, 3)).astype(float)
    faces = rng.integers(0, 25, (30, 3))
    made = repaired(vertices, faces)
    before, after = vertices[faces], made.vertices[made.faces]
    points = rng.uniform(-3, 3, (40, 3))
    here, there = (brute_distance(points, points, t).min(axis=1) for t in (before, after))
    np.testing.assert_allclose(here, there, atol=1e-12)


@pytest.mark.parametrize("flip", ["none", "all", "cavity", "outside", "other"])
def test_shells_are_turned_as_they_must_be(flip):
    outer, inner = trimesh.creation.box((4, 4, 4)), trimesh.creation.icosphere(2, 1.0)
    other = trimesh.creation.cylinder(0.5, 2).apply_translation([5, 0, 0])
    inner.invert()
    for name, meshes in {
        "all": (outer, inner, other),
        "cavity": (inner,),
        "outside": (outer,),
        "other": (other,),
    }.items():
        if name == flip:
            for mesh in meshes:
                mesh.invert()
    made = repaired(*soup(trimesh.util.concatenate([outer, inner, other])))
    assert not made.open_edges
    assert not made.twisted_edges
    # A ball that is wound like the box around it may be one on purpose: it stays, and all is solid there.
    solid = flip in ("cavity", "outside")
    volume = abs(outer.volume) + abs(other.volume) + (1 if solid else -1) * abs(inner.volume)
    assert made.volume == pytest.approx(volume, rel=1e-9)
    told = {"none": [], "cavity": [], "all": ["3 shells"], "outside": ["2 shells"], "other": ["1 shell"]}[flip]
    assert [words.split(" wound")[0] for words in made.repairs if "turned" in words] == told
    scene = Scene.from_meshes(["body"], [made.vertices[made.faces]])
    assert scene.inside([[1.5, 1.5, 1.5], [5, 0, 0.5], [3, 0, 0]]).tolist() == [0, 0, -1]
    assert scene.inside([[0.1, 0, 0]]).tolist() == [0 if solid else -1]


def test_open_and_twisted_edges_are_counted():
    mesh = trimesh.creation.box()
    missing = repaired(mesh.vertices, np.delete(mesh.faces, [4], axis=0))
    assert (missing.open_edges, missing.twisted_edges) == (3, 0)
    ball = trimesh.creation.icosphere(1)
    faces = np.array(ball.faces)
    far = int((ball.triangles_center @ ball.triangles_center[0]).argmin())
    faces[far] = faces[far][::-1]
    turned = repaired(ball.vertices, faces[1:])
    assert (turned.open_edges, turned.twisted_edges) == (3, 3)
    assert not any("turned" in words for words in turned.repairs)


def test_doubles_are_kept_once_and_the_count_of_what_is_dropped_is_said():
    """A doubled triangle would count twice in the winding number, and its edges as wound against each other."""
    mesh = trimesh.creation.box()
    faces = np.concatenate([mesh.faces, np.roll(mesh.faces[3:5], 1, axis=1), mesh.faces[:1]])
    made = repaired(mesh.vertices, faces)
    np.testing.assert_array_equal(made.vertices[made.faces], mesh.triangles)
    assert (made.open_edges, made.twisted_edges, made.repairs) == (0, 0, ("3 triangles dropped as doubles",))
    assert made.volume == pytest.approx(1.0)


@pytest.mark.parametrize(("sides", "inside"), [(2, False), (4, True)])
def test_of_an_open_box_more_than_half_must_be_there_for_its_middle_to_be_inside(sides, inside):
    """From the middle of a cube every side is a sixth of all that is seen."""
    mesh = trimesh.creation.box()
    normals = np.round(mesh.face_normals).astype(int)
    kept = [tuple(normal) for normal in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))[:sides]]
    triangles = np.array(
        [corners for corners, normal in zip(mesh.triangles, normals, strict=True) if tuple(normal) in kept]
    )
    assert len(triangles) == 2 * sides
    found = Scene.from_meshes(["open"], [triangles]).inside([[0.0, 0.0, 0.0], [0.01, 0.02, 0.03]])
    assert found.tolist() == [0 if inside else -1] * 2


@given(seed=seeds, missing=st.sampled_from([0.0, 0.1]))
@settings(max_examples=15, deadline=None)
def test_what_is_inside_agrees_with_the_sum_over_all_triangles(seed, missing):
    rng = np.random.default_rng(seed)
    balls = [trimesh.creation.icosphere(3, rng.uniform(0.2, 0.6)) for _ in range(3)]
    meshes = [np.array(ball.triangles) * rng.uniform(0.3, 1, 3) + rng.uniform(-1, 1, 3) for ball in balls]
    meshes = [mesh[rng.uniform(size=len(mesh)) >= missing] for mesh in meshes]
    scene = Scene.from_meshes(["a", "b", "c"], meshes)
    points = rng.uniform(-1.5, 1.5, (40, 3))
    turns = np.stack([_turns(mesh, points) for mesh in meshes])
    expected = np.where((turns > 0.5).any(axis=0), (turns > 0.5).argmax(axis=0), -1)
    clear_cut = (np.abs(turns - 0.5) > 1e-6).all(axis=0)
    np.testing.assert_array_equal(scene.inside(points)[clear_cut], expected[clear_cut])


def test_far_groups_leave_the_winding_number_right_within_a_hundredth():
    rng = np.random.default_rng(4)
    ball = np.array(trimesh.creation.icosphere(3).triangles)
    foam = np.concatenate([ball * rng.uniform(0.05, 0.3) + rng.uniform(-1, 1, 3) for _ in range(30)])
    scene = Scene.from_meshes(["foam"], [foam])
    groups = scene._groups
    points = rng.uniform(-1, 1, (100, 3))
    found = [
        _winding(foam, groups.order, groups.start, groups.plates, 0, len(groups.plates), _FAR**2, *point)
        for point in points
    ]
    np.testing.assert_allclose(found, _turns(foam, points), atol=0.01)


def _turns(triangles, points):
    """Winding numbers (p,), by l'Huilier's formula for the solid angle from the arcs between the corners."""
    total = np.zeros(len(points))
    for start in range(0, len(points), 10):
        rays = triangles[None] - points[start : start + 10, None, None]
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        a, b, c = np.moveaxis(rays, 2, 0)
        arcs = [
            np.arctan2(np.linalg.norm(np.cross(p, q), axis=-1), (p * q).sum(axis=-1))
            for p, q in ((b, c), (c, a), (a, b))
        ]
        s = sum(arcs) / 2
        inner = np.tan(s / 2) * np.prod([np.tan(np.maximum(s - arc, 0) / 2) for arc in arcs], axis=0)
        sign = np.sign(np.einsum("pmi,pmi->pm", a, np.cross(b, c)))
        total[start : start + 10] = (sign * 4 * np.arctan(np.sqrt(np.maximum(inner, 0)))).sum(axis=1) / (4 * np.pi)
    return total
