"""3MF: one box in every way that the format can say it; all else is refused or noted in words."""

import io
import re
import zipfile

import numpy as np
import pytest
import trimesh
from content_oracles import CORNERS, FACES, VOLUME, assert_is_the_box, of_body, volume
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from threemf_maker import archive, group, mesh, model, package, read, relations, solid

TURN, SHIFT, SCALE = Rotation.from_euler("xyz", [20, -50, 130], degrees=True), np.array([0.3, -1, 2]), 1.7
UNITS = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}


def transform(matrix, shift=(0, 0, 0)):
    """The attribute of a linear map of columns and a shift: in the file, points are rows."""
    numbers = [*np.asarray(matrix, float).T.ravel(), *shift]
    return f'transform="{" ".join(map(repr, map(float, numbers)))}"'


PLACED = transform(SCALE * TURN.as_matrix(), SHIFT)
BEFORE = mesh(TURN.inv().apply(CORNERS - SHIFT) / SCALE)
PARTS = {"3D/Objects/a.model": model(solid(7), items=())}

PREFIXED = re.sub(r"<(/?)(?=\w)", r"<\1c:", model(solid()).replace("xmlns=", "xmlns:c="))
VERTICES, TRIANGLES = mesh()[6:-7].split("<triangles>")
FIRST_TRIANGLES = f"<mesh><triangles>{TRIANGLES}{VERTICES}</mesh>"
SETS = '<t:trianglesets><t:triangleset name="a"><t:ref index="0"/></t:triangleset></t:trianglesets>'
MATERIALS = '<basematerials id="3"><base name="a" displaycolor="#FF0000"/></basematerials><m:colorgroup id="4"/>'
SLICES = '<s:slicestack id="9"><s:slice ztop="1"/></s:slicestack>'
ITEM_2 = ('objectid="2"',)

MODELS = {
    "plain": model(solid()),
    "UTF-16": model(solid()).replace("UTF-8", "UTF-16").encode("utf-16"),
    "BOM": model(solid()).encode("utf-8-sig"),
    "another prefix": PREFIXED,
    "triangles before vertices": model(solid(shape=FIRST_TRIANGLES)),
    "item placed": model(solid(shape=BEFORE), items=[f'objectid="1" {PLACED}']),
    "component placed": model(solid(shape=BEFORE), group(2, f'objectid="1" {PLACED}'), items=ITEM_2),
    "both placed": model(
        solid(shape=BEFORE),
        group(2, f'objectid="1" {transform(TURN.as_matrix())}', name="above"),
        items=[f'objectid="2" {transform(SCALE * np.eye(3), SHIFT)}'],
    ),
    "mirrored": model(
        solid(shape=mesh(CORNERS * [1, -1, 1], FACES[:, ::-1])),
        items=[f'objectid="1" {transform(np.diag([1, -1, 1]))}'],
    ),
    "mirrored twice": model(
        solid(shape=mesh(CORNERS * [-1, -1, 1])),
        group(2, f'objectid="1" {transform(np.diag([-1, 1, 1]))}'),
        items=[f'objectid="2" {transform(np.diag([1, -1, 1]))}'],
    ),
    "named by its part number": model(solid(name=None, more='partnumber="box"')),
    "named by its item": model(solid(name=None), items=['objectid="1" partnumber="box"']),
    "named by its group": model(solid(name=None), group(2, 'objectid="1"', name="box"), items=ITEM_2),
    "a component ahead": model(group(2, 'objectid="1"'), solid(), items=ITEM_2),
    "solid support": model(solid(more='type="solidsupport"')),
    "a surface": model(solid(more='type="surface"')),
    "materials and sets": model(
        solid(shape=mesh(more='pid="3" p1="0"', inside=SETS)), resources=MATERIALS, head='requiredextensions="m t"'
    ),
    "metadata": model(solid(shape=mesh() + '<metadatagroup><metadata name="a">b</metadata></metadatagroup>')),
    "slices beside triangles": model(solid(more='s:slicestackid="9"'), resources=SLICES, head='requiredextensions="s"'),
}
PACKAGES = {
    "a part of any name": package(model(solid()), name="other/Root part.XML"),
    "names in other letters": archive({"_RELS/.rels": relations("3d/MODEL.model"), "3D/model.Model": model(solid())}),
    "stored": archive({"_rels/.rels": relations("/a.model"), "a.model": model(solid())}, zipfile.ZIP_STORED),
    "another part by an item": package(
        model(items=['objectid="7" p:path="/3D/Objects/a.model"'], head='requiredextensions="p"'), PARTS
    ),
    "another part by a component": package(model(group(1, 'objectid="7" p:path="/3d/objects/A.model"')), PARTS),
}
SAME = {**{name: package(each) for name, each in MODELS.items()}, **PACKAGES}


@pytest.mark.parametrize("name", SAME)
def test_the_box_is_the_same_in_every_way_to_say_it(name):
    content = read(SAME[name])
    assert_is_the_box(content)
    assert (content.metres, content.notes) == (1.0, ())


@pytest.mark.parametrize("unit", UNITS)
def test_every_unit(unit):
    assert read(package(model(solid(), unit=f'unit="{unit}"'))).metres == UNITS[unit]


def test_millimetres_unless_said():
    assert read(package(model(solid(), unit=""))).metres == 1e-3


def test_equal_ids_in_different_parts_are_different_objects():
    big = mesh(CORNERS * 3)
    more = {"3D/a.model": model(solid(1, name="a"), items=()), "3D/b.model": model(solid(1, big, "b"), items=())}
    parts = ['objectid="1" p:path="/3D/a.model"', 'objectid="1" p:path="/3D/b.model"', 'objectid="1"']
    content = read(
        package(model(group(2, *parts), solid(1, name="root"), items=['objectid="2"', 'objectid="1"']), more)
    )
    assert [body.name for body in content.bodies] == ["a", "b", "root", "root"]
    np.testing.assert_allclose([volume(body) for body in content.bodies], np.array([1, 27, 1, 1]) * VOLUME)


def test_an_object_that_is_placed_often_is_a_body_each_time():
    places = [f'objectid="2" {transform(np.eye(3), (k, 0, 0))}' for k in range(3)]
    pair = group(2, 'objectid="1"', f'objectid="1" {transform(np.eye(3), (0, 5, 0))}')
    content = read(package(model(solid(), pair, items=places)))
    assert [body.name for body in content.bodies] == ["box"] * 6
    lows = np.array([body.vertices.min(axis=0) for body in content.bodies])
    np.testing.assert_allclose(lows - CORNERS.min(0), [(k, y, 0) for k in range(3) for y in (0, 5)], atol=1e-12)


def test_halves_of_a_box_in_objects_of_their_own_are_one_body():
    halves = solid(1, mesh(faces=FACES[:5]), "a"), solid(2, mesh(faces=FACES[5:]), "b")
    content = read(package(model(*halves, items=['objectid="1"', 'objectid="2"'])))
    assert_is_the_box(content, "a + b")
    assert content.notes == ("2 objects that are parts of one surface put together: one body",)


EMPTY = "<mesh><vertices/><triangles/></mesh>"
NOTED = {
    "objects that are not placed": (
        package(model(solid(), solid(2, name="left"), solid(3, name=None), group(4, 'objectid="3"'))),
        "2 objects that the build does not place left out ('left', …)",
    ),
    "parts that nothing names": (
        package(model(solid()), PARTS),
        "1 model part that nothing refers to left out",
    ),
    "objects without triangles": (
        package(model(solid(), solid(2, EMPTY), solid(3, ""), items=[f'objectid="{k}"' for k in (1, 2, 3)])),
        "2 objects without triangles left out",
    ),
    "support": (
        package(model(solid(more='type="support"'))),
        "1 object of the type 'support' taken like the others",
    ),
    "other": (
        package(model(solid(more='type="other"'))),
        "1 object of the type 'other' taken like the others",
    ),
    "a vendor's data": (
        package(model(solid(shape=mesh(inside="<x:paint><x:a/></x:paint>") + "<x:b/>"))),
        "holds data that are not read: urn:vendor:more",
    ),
    "recommended extensions": (
        package(model(solid(), head='recommendedextensions="m b"')),
        "recommends extensions that are not read: beamlattice/2017/02",
    ),
}


@pytest.mark.parametrize("name", NOTED)
def test_what_is_left_out_is_noted(name):
    data, note = NOTED[name]
    content = read(data)
    assert_is_the_box(content)
    assert content.notes == (note,)


def middle(triangles):
    return triangles.mean(axis=(0, 1)).round(6).tolist()


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_trimesh_agrees_on_components_within_components(seed):
    rng = np.random.default_rng(seed)

    def place(number):
        return f'objectid="{number}" {transform(rng.uniform(-1, 1, (3, 3)), rng.uniform(-2, 2, 3))}'

    solids = [
        solid(k, mesh(rng.uniform(-1, 1, (5, 3)), np.argsort(rng.random((4, 5)))[:, :3]), f"s{k}") for k in (1, 2)
    ]
    groups = [group(k, *(place(int(rng.integers(1, k))) for _ in range(rng.integers(1, 3)))) for k in (3, 4, 5)]
    data = package(model(*solids, *groups, items=[place(5), place(3)]))
    ours = [of_body(body) for body in read(data).bodies]
    theirs = trimesh.load_scene(io.BytesIO(data), file_type="3mf", process=False)
    expected = []
    for node in theirs.graph.nodes_geometry:
        matrix, shape = theirs.graph[node]
        corners = theirs.geometry[shape].vertices @ matrix[:3, :3].T + matrix[:3, 3]
        faces = theirs.geometry[shape].faces
        expected.append(corners[faces if np.linalg.det(matrix[:3, :3]) > 0 else faces[:, ::-1]])
    assert len(ours) == len(expected)
    for mine, its in zip(sorted(ours, key=middle), sorted(expected, key=middle), strict=True):
        np.testing.assert_allclose(mine, its, atol=1e-9)
