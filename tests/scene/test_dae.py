"""COLLADA: one box in every way that the format can say it; all else is refused or noted in words."""

import numpy as np
import pytest
from content_oracles import CORNERS, FACES, QUADS, VOLUME, assert_is_the_box, of_body, volume
from dae_maker import (
    INPUT,
    NORMAL,
    collada,
    geometry,
    mesh,
    node,
    numbers,
    positions,
    primitive,
    read,
    triangles,
)
from scipy.spatial.transform import Rotation

from hognose.errors import InputError
from hognose.scene import Mesh
from hognose.scene.imports import dae

AXIS, ANGLE, SHIFT, SCALE = np.array([1.0, -2, 0.5]), 70.0, np.array([0.3, -1, 2]), np.array([2, 0.5, 1.5])
TURN = Rotation.from_rotvec(np.radians(ANGLE) * AXIS / np.linalg.norm(AXIS))
BEFORE = geometry(mesh(source=positions(TURN.inv().apply(CORNERS - SHIFT) / SCALE)))
MATRIX = np.eye(4)
MATRIX[:3, :3], MATRIX[:3, 3] = TURN.as_matrix() * SCALE, SHIFT
MOVED = f"<matrix>{numbers(MATRIX)}</matrix>"
TRS = (
    f"<translate>{numbers(SHIFT)}</translate><rotate>{numbers([*AXIS, ANGLE])}</rotate><scale>{numbers(SCALE)}</scale>"
)
WIDE = INPUT.replace('offset="0"', 'offset="1"') + NORMAL
POLYLIST = f"<vcount>{' 4' * 6}</vcount>"
MIXED = f"<vcount>4 4 4 {' 3' * 6}</vcount>"
MIXED_ROW = np.concatenate([QUADS[:3].ravel(), QUADS[3:][:, [0, 1, 2, 0, 2, 3]].ravel()])
HALVES = [triangles(FACES[:5]), triangles(FACES[5:])]
TWO = geometry(mesh(triangles(FACES[:5])), "a") + geometry(mesh(triangles(FACES[5:])), "b")
MIRRORED = geometry(mesh(triangles(FACES[:, ::-1]), source=positions(CORNERS * [-1, 1, 1])))
LIBRARY = f"<library_nodes>{node(moves=MOVED)}</library_nodes>"

ELSEWHERE = [c for q in QUADS for c in (q[1], q[1], q[2], q[0], q[3], q[3])][1:-1]

SAME = {
    "triangles": collada(),
    "version 1.5": collada(space="http://www.collada.org/2008/03/COLLADASchema"),
    "UTF-16": collada().replace("utf-8", "utf-16").encode("utf-16"),
    "strips": collada(geometries=geometry(mesh(primitive("tristrips", QUADS[:, [1, 2, 0, 3]])))),
    "a strip that goes on elsewhere": collada(
        geometries=geometry(
            mesh(primitive("tristrips", [ELSEWHERE]))
        )
    ),
    "fans": collada(geometries=geometry(mesh(primitive("trifans", QUADS)))),
    "polygons": collada(geometries=geometry(mesh(primitive("polygons", QUADS)))),
    "a polylist": collada(geometries=geometry(mesh(primitive("polylist", [QUADS], more=POLYLIST, count=6)))),
    "a mixed polylist": collada(geometries=geometry(mesh(primitive("polylist", [MIXED_ROW], more=MIXED, count=9)))),
    "other columns": collada(
        geometries=geometry(
            mesh(primitive("triangles", [[n for c in FACES.ravel() for n in (99, c, 77)]], inputs=WIDE, count=12))
        )
    ),
    "several materials": collada(geometries=geometry(mesh(*HALVES))),
    "wide rows": collada(
        geometries=geometry(
            mesh(
                source=positions(np.insert(CORNERS, 0, 9, axis=1), accessor='stride="4"', params="-XYZ")
            )
        )
    ),
    "rows in another order": collada(
        geometries=geometry(mesh(source=positions(CORNERS[:, [2, 0, 1]], accessor='stride="3"', params="ZXY")))
    ),
    "an offset": collada(
        geometries=geometry(mesh(source=positions(accessor='stride="3" offset="2"', before="7 7")))
    ),
    "two meshes of one node": collada(
        node('<instance_geometry url="#a"/><instance_geometry url="#b"/>'), geometries=TWO
    ),
    "matrix": collada(node(moves=MOVED), geometries=BEFORE),
    "translate, rotate, scale": collada(node(moves=TRS), geometries=BEFORE),
    "nodes in nodes": collada(
        node(node(moves=f"<rotate>{numbers([*AXIS, ANGLE])}</rotate><scale>{numbers(SCALE)}</scale>"),
             'name="above"', f"<translate>{numbers(SHIFT)}</translate>"),
        geometries=BEFORE,
    ),
    "a node of the library": collada(
        node('<instance_node url="#n"/>', 'id="m" name="above"'), geometries=BEFORE, more=LIBRARY
    ),
    "mirrored": collada(node(moves="<scale>-1 1 1</scale>"), geometries=MIRRORED),
    "named by its mesh": collada(node(name=""), geometries=geometry(more='name="box"')),
    "named by its id": collada(node(name='id="box"')),
    "no scene said": collada(scene=""),
    "looks and cameras": collada(
        node(), node('<instance_camera url="#c"/>', 'id="c"', "<lookat>0 0 0 1 1 1 0 0 1</lookat>"),
        more="<library_effects><effect/></library_effects><library_images><image/></library_images>",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_the_box_is_the_same_in_every_way_to_say_it(name):
    content = read(SAME[name])
    assert_is_the_box(content)
    assert (content.metres, content.notes) == (1.0, ())


def test_its_unit_is_what_it_says(tmp_path):
    for said, metres in (('<unit meter="0.0254" name="inch"/>', 0.0254), ("<unit/>", 1.0), ("", 1.0)):
        assert read(collada(asset=said)).metres == metres
    (tmp_path / "file.dae").write_text(collada(asset='<unit meter="0.001"/>'))
    item = Mesh(file=str(tmp_path / "file.dae"))
    np.testing.assert_allclose(np.ptp(item.triangles(), axis=(0, 1)), 1e-3 * np.ptp(CORNERS, axis=0))


def test_a_mesh_that_is_placed_often_is_a_body_each_time():
    right = node(name='name="right"', moves="<translate>1 0 0</translate>")
    top = node('<instance_node url="#n"/>', 'name="top"', "<translate>0 5 0</translate>")
    content = read(collada(node(), right, top))
    assert [body.name for body in content.bodies] == ["box", "right", "box"]
    lows = np.array([body.vertices.min(axis=0) for body in content.bodies]) - CORNERS.min(0)
    np.testing.assert_allclose(lows, [[0, 0, 0], [1, 0, 0], [0, 5, 0]], atol=1e-12)
    np.testing.assert_allclose([volume(body) for body in content.bodies], VOLUME)


def test_halves_of_a_box_in_nodes_of_their_own_are_one_body():
    nodes = [node(f'<instance_geometry url="#{name}"/>', f'name="{name}"') for name in "ab"]
    content = read(collada(*nodes, geometries=TWO))
    assert_is_the_box(content, "a + b")
    assert content.notes == ("2 nodes that are parts of one surface put together: one body",)


def test_a_polygon_that_is_not_convex_is_covered():
    corners = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0]]
    shape = mesh(primitive("polygons", [range(5)]), source=positions(corners))
    (body,) = read(collada(geometries=geometry(shape))).bodies
    corner = of_body(body)
    areas = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] / 2
    assert len(areas) == 3
    assert areas.sum() == pytest.approx(4 - 1.5)  # the border is that of the polygon


LINES = mesh(triangles(), primitive("lines", [[0, 1]]), primitive("linestrips", [[0, 1, 2]]))
OTHER = '<library_visual_scenes><visual_scene id="other"/></library_visual_scenes>'
NOTED = {
    "lines": (collada(geometries=geometry(LINES)), "2 primitives of lines left out"),
    "a spline": (
        collada(node('<instance_geometry url="#shape"/><instance_geometry url="#s"/>'),
                geometries=geometry() + geometry("<spline/>", "s")),
        "1 primitive of lines left out",
    ),
    "a mesh that is not placed": (
        collada(geometries=geometry() + geometry(name="b")), "1 mesh that no node places left out",
    ),
    "animations": (
        collada(more="<library_animations><animation/></library_animations>"),
        "animations left out: everything is where it is at rest",
    ),
    "physics": (
        collada(more="<library_physics_models><physics_model/></library_physics_models>"),
        "shapes of its physics models left out",
    ),
    "another axis up": (
        collada(asset='<unit meter="1"/>'), "its axis that points up is Y: its axes are taken as they are, not turned",
    ),
    "another scene": (collada(more=OTHER), "1 scene that it does not show left out"),
    "no scene of two": (collada(more=OTHER, scene=""), "does not say which of its 2 scenes is meant: all are taken"),
}  # fmt: skip


@pytest.mark.parametrize("name", NOTED)
def test_what_is_left_out_is_noted(name):
    text, note = NOTED[name]
    content = read(text)
    assert_is_the_box(content)
    assert content.notes == (note,)


CIRCLE = node('<instance_node url="#m"/>', 'id="n"') + node('<instance_node url="#n"/>', 'id="m"')
HOLES = f"<polygons count='1'>{INPUT}<ph><p>0 1 3 2</p><h>4 5 6</h></ph></polygons>"
DEEP = "<node>" * 600 + "</node>" * 600
DOUBLES = "".join(node(f'<instance_node url="#n{k - 1}"/>' * 2, f'id="n{k}"') for k in range(1, 60))
REFUSED = {
    "another root": ("<a/>", "not a COLLADA file of version 1.4 or 1.5: it begins with <a>"),
    "an old version": (collada(space="http://www.collada.org/2004/COLLADASchema"), "not a COLLADA file of version"),
    "entities": (collada().replace("<COLLADA", "<!DOCTYPE a><COLLADA"), "has a document type declaration"),
    "cut": (collada()[:-20], "cut or damaged: line 1"),
    "skin": (
        collada(node('<instance_controller url="#c"/>')), "node 'box' has the mesh '#c', which is bent by a skeleton",
    ),
    "convex": (collada(geometries=geometry('<convex_mesh convex_hull_of="#a"/>')), "'shape' is a <convex_mesh>, which"),
    "surfaces": (collada(geometries=geometry("<brep/>")), "geometry 'shape' is a <brep>, which is not read"),
    "holes": (collada(geometries=geometry(mesh(HOLES))), "'shape' has polygons with holes .<ph>., which are not read"),
    "an unknown primitive": (collada(geometries=geometry(mesh("<patches/>"))), "geometry 'shape' has <patches>, which"),
    "another file": (
        collada(node('<instance_geometry url="other.dae#a"/>')),
        "<instance_geometry> refers to another file, 'other.dae', which is not read",
    ),
    "no url": (collada(node("<instance_geometry/>")), "<instance_geometry> has the url '', expected #id"),
    "a mesh that is not there": (
        collada(node('<instance_geometry url="#a"/>')), "refers to the geometry 'a', which is not there",
    ),
    "a node that is not there": (collada(node('<instance_node url="#scene"/>')), "refers to the node 'scene', which"),
    "a scene that is not there": (
        collada(scene='<scene><instance_visual_scene url="#a"/></scene>'), "refers to the visual_scene 'a', which",
    ),
    "an id twice": (collada(geometries=geometry() * 2), "damaged: has the id 'shape' twice"),
    "a circle": (collada(CIRCLE), "node 'n' has itself as an instance, directly or through others"),
    "deep nodes": (collada(DEEP), "has nodes within nodes, over 500 deep"),
    "a skew": (collada(node(moves="<skew>1 1 0 0 0 1 0</skew>")), "node 'box' is placed by <skew>, which is not read"),
    "a short matrix": (collada(node(moves="<matrix>1 2</matrix>")), "<matrix> of node 'box' is not 16 numbers"),
    "a matrix of perspective": (
        collada(node(moves=f"<matrix>{numbers(np.ones(16))}</matrix>")), "does not end in 0, 0, 0, 1",
    ),
    "a place that is no number": (collada(node(moves="<translate>1 nan 0</translate>")), "is not 3 numbers"),
    "no axis": (collada(node(moves="<rotate>0 0 0 90</rotate>")), "<rotate> of node 'box' has no axis"),
    "no unit": (collada(asset='<unit meter="0"/>'), "its unit is '0' metres"),
    "two units": (
        collada(geometries=geometry('<asset><unit meter="0.01"/></asset>' + mesh())), "has parts in different units",
    ),
    "no axis up": (collada(asset="<up_axis>UP</up_axis>"), "its axis 'UP', expected e.g. 0.001, Z_UP"),
    "no positions": (
        collada(geometries=geometry(mesh(source=positions(name="a")))), "geometry 'shape' has no positions .'pos'.",
    ),
    "positions in a plane": (
        collada(geometries=geometry(mesh(source=positions(params="XY")))), "have no X, Y and Z",
    ),
    "fewer numbers than said": (
        collada(geometries=geometry(mesh(source=positions(count=30)))), "'shape' are 24 numbers, fewer than it says",
    ),
    "fewer rows than said": (
        collada(geometries=geometry(mesh(source=positions(accessor='stride="4"')))), "24 numbers, fewer than it says",
    ),
    "no inputs": (
        collada(geometries=geometry(mesh(primitive("triangles", [[0, 1, 2]], inputs="")))), "where its vertices are",
    ),
    "a decimal comma": (
        collada(geometries=geometry(mesh(source=positions().replace("0.4", "0,4", 1)))), "has '0,4', expected a number",
    ),
    "a vertex that is not there": (
        collada(geometries=geometry(mesh(triangles(FACES + 1)))), "names a vertex that is not there; it has 8 of them",
    ),
    "a negative vertex": (collada(geometries=geometry(mesh(triangles(FACES - 1)))), "names a vertex that is not there"),
    "a triangle short": (
        collada(geometries=geometry(mesh(primitive("triangles", [[0, 1, 2]], count=2)))), "says it has 2 triangles",
    ),
    "half a corner": (
        collada(geometries=geometry(mesh(primitive("triangles", [range(4)], inputs=WIDE)))), "no multiple of 3",
    ),
    "a polygon short": (collada(geometries=geometry(mesh(primitive("polygons", QUADS, count=7)))), "has not 7 rows"),
    "a strip of two": (collada(geometries=geometry(mesh(primitive("tristrips", [[0, 1]])))), "has not 1 rows of three"),
    "a polylist short": (
        collada(geometries=geometry(mesh(primitive("polylist", [QUADS[:5]], more=POLYLIST, count=6)))),
        "have not the 20 corners that they name",
    ),
    "fractions of vertices": (
        collada(geometries=geometry(mesh(triangles(FACES / 2)))), "has '0.0', expected a number",
    ),
    "a huge vertex": (
        collada(geometries=geometry(mesh(triangles(FACES.astype(object) * 10**30)))), "'10*', expected a number",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_taken_is_refused_in_words(name):
    text, complaint = REFUSED[name]
    with pytest.raises(InputError, match=complaint):
        read(text)


def test_what_is_placed_too_often_is_refused_before_it_is_made(monkeypatch):
    monkeypatch.setattr(dae, "MOST_ELEMENTS", 1000)
    with pytest.raises(InputError, match="holds more than 1,000 triangles, counting all instances"):
        read(collada(node('<instance_node url="#n59"/>', 'id="top"'), node(name='id="n0"'), DOUBLES))
