"""Polygons cut into triangles cover what they covered; parts of one surface are put together."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from text_makers import FACES, QUADS, VERTICES, read

from hognose.scene import Mesh, Scene
from hognose.scene.imports.content import RawBody
from hognose.scene.imports.joining import joined
from hognose.scene.imports.polygons import fans, gathered, triangles
from hognose.scene.imports.repair import repaired

seeds = st.integers(0, 2**32 - 1)


def turns(corners, points):
    """How often plane polygons (n, 2) run round points (p, 2), by the sum of the angles."""
    to = corners[None] - points[:, None]
    angle = np.arctan2(to[..., 1], to[..., 0])
    step = np.diff(angle, axis=1, append=angle[:, :1])
    return np.round((np.mod(step + np.pi, 2 * np.pi) - np.pi).sum(axis=1) / (2 * np.pi)).astype(int)


@given(seed=seeds, corners=st.integers(3, 12))
@settings(max_examples=150, deadline=None)
def test_a_fan_covers_its_polygon_whatever_its_shape_and_as_often_one_way_more(seed, corners):
    rng = np.random.default_rng(seed)
    polygon = rng.normal(size=(corners, 2))
    points = rng.normal(size=(400, 2))
    parts = polygon[fans(np.arange(corners), np.array([corners]))]
    each = np.array([turns(part, points) for part in parts])
    np.testing.assert_array_equal(each.sum(axis=0), turns(polygon, points))
    assert (each != 0).any(axis=0)[turns(polygon, points) != 0].all()


@given(counts=st.lists(st.integers(3, 7), min_size=1, max_size=20))
def test_fans_of_many_polygons_are_those_of_each(counts):
    index = np.arange(sum(counts)) * 3
    ends = np.cumsum(counts)
    one_by_one = [fans(index[end - count : end], np.array([count])) for end, count in zip(ends, counts, strict=True)]
    np.testing.assert_array_equal(fans(index, np.array(counts)), np.concatenate(one_by_one))
    begins = ends - counts
    flat = [k for begin, count in zip(begins, counts, strict=True) for k in range(begin, begin + count)]
    np.testing.assert_array_equal(gathered(begins, np.array(counts)), flat)


@pytest.mark.parametrize("first", range(6))
@pytest.mark.parametrize("ending", ["obj", "off"])
def test_a_body_with_caps_that_are_not_convex_keeps_its_inside(first, ending, tmp_path):
    outline = np.roll([[0, 0], [300, 0], [300, 100], [100, 100], [100, 300], [0, 300]], first, axis=0)
    vertices = [[*corner, z] for z in (0, 50) for corner in outline.tolist()]
    faces = [list(range(5, -1, -1)), list(range(6, 12)), *([k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6))]
    if ending == "obj":
        rows = ["v {} {} {}".format(*v) for v in vertices] + ["f " + " ".join(str(k + 1) for k in f) for f in faces]
    else:
        rows = ["OFF 12 8 0", *("{} {} {}".format(*v) for v in vertices)]
        rows += [f"{len(f)} {' '.join(map(str, f))}" for f in faces]
    file = tmp_path / f"corner.{ending}"
    file.write_text("\n".join(rows))
    item = Mesh(file=str(file), units="mm")
    assert item.geometry.watertight
    assert item.remarks() == []
    (body,) = item.geometry.bodies
    assert body.volume == pytest.approx(50 * (300 * 300 - 200 * 200))
    xy = np.stack(np.meshgrid(np.arange(-25, 330, 50), np.arange(-25, 330, 50)), axis=-1).reshape(-1, 2)
    inside = (xy > 0).all(axis=1) & (xy < 300).all(axis=1) & (xy < 100).any(axis=1)
    points = np.column_stack([xy, np.full(len(xy), 25.0)]) / 1e3
    np.testing.assert_array_equal(Scene.from_obstacles([item]).inside(points) == 0, inside)


@pytest.mark.parametrize("height", [0.0, 1e-5, 30.0])
def test_polygons_that_are_not_flat_are_noted(height):
    bent = np.array([[0, 0, 0], [100, 0, height], [100, 100, 0], [0, 100, height], [500, 0, 0], [500, 1, 0]])
    index = np.array([0, 1, 2, 3, 0, 1, 2, 0, 4, 5, 3])
    faces, notes = triangles(bent, index, np.array([4, 3, 4]))
    assert len(faces) == 5
    if height < 1:
        assert notes == () if height == 0 else not notes or "1e-05" in notes[0]
    else:
        assert "of more than three corners not flat" in notes[0]
    assert triangles(VERTICES, QUADS.reshape(-1), np.full(6, 4))[1] == ()


def test_how_far_a_polygon_is_not_flat_is_said_in_the_unit_of_the_file():
    text = "v 0 0 0\nv 100 0 8\nv 100 100 0\nv 0 100 8\nf 1 2 3 4\n"
    (note,) = read("obj", text).notes
    assert note.startswith("1 polygon of more than three corners not flat, by up to 8 in the file's unit")


@given(seed=seeds, parts=st.integers(1, 6), shared=st.booleans())
@settings(max_examples=60, deadline=None)
def test_parts_of_a_closed_surface_become_one_whole_and_bodies_stay_apart(seed, parts, shared):
    rng = np.random.default_rng(seed)
    of = rng.integers(0, parts, 12)
    other = VERTICES + np.array([1000, 0, 0])
    bodies = []
    for k in range(parts):
        faces = FACES[of == k]
        if len(faces):
            used, own = np.unique(faces, return_inverse=True)
            bodies.append(
                RawBody(f"part {k}", VERTICES, faces)
                if shared
                else RawBody(f"part {k}", VERTICES[used], own.reshape(-1, 3))
            )
    found, notes = joined([*bodies, RawBody("other", other, FACES)], "groups")
    assert len(found) == 2
    assert len(found[0].faces) == 12
    assert found[1].name == "other"
    edges = np.sort(
        found[0].vertices[found[0].faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 6).view([("", float)] * 6), axis=0
    )
    assert len(edges) == 36
    assert bool(notes) == (len(bodies) > 1)


def test_parts_that_are_wound_against_each_other_are_put_together():
    sides = [RawBody(f"{k}", VERTICES, FACES[k::6][:, :: 1 if k % 2 else -1]) for k in range(6)]
    found, _ = joined(sides, "groups")
    assert len(found) == 1
    made = repaired(found[0].vertices, found[0].faces)
    assert (made.open_edges, made.twisted_edges) == (0, 0)
    assert made.volume > 0


def test_sheets_that_do_not_close_each_other_stay_apart():
    sheet = np.array([[0, 1, 2], [0, 2, 3]])
    flat = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    apart = [
        RawBody("a", flat, sheet),
        RawBody("b", flat + np.array([0, 0, 1]), sheet),
        RawBody("c", flat + np.array([5, 0, 0]), sheet),
    ]
    assert joined(apart, "groups") == (tuple(apart), ())
    beside = [apart[0], RawBody("b", flat + np.array([1, 0, 0]), sheet)]
    found, notes = joined(beside, "solids")
    assert [body.name for body in found] == ["a + b"]
    assert notes == ("2 solids that are parts of one surface put together: one body",)
