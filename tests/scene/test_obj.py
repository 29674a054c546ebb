"""OBJ: what its statements say is taken, noted, or refused with the line."""

import numpy as np
import pytest
import trimesh
from import_makers import exported
from text_makers import FACES, POINTS, QUADS, VERTICES, as_trimesh_has_it, assert_box, canonical, read, refusal, surface

V = [f"v {point}" for point in POINTS]
F = ["f " + " ".join(str(k + 1) for k in face) for face in FACES]
TEXT = "\n".join([*V, *F, ""])
SURFACE = [
    "v 1000 0 0", "v 1000 500 0", "v 1000 0 500", "v 1000 500 500", "vp 0 0", "cstype rat bspline", "deg 1 1",
    "surf 0 1 0 1 9 10 11 12", "parm u 0 0 1 1", "parm v 0 0 1 1", "end",
]  # fmt: skip


def lines(*rows):
    return "\n".join([*rows, ""])


@pytest.mark.parametrize(
    "text",
    [
        TEXT,
        TEXT.rstrip(),
        TEXT.replace("\n", "\r\n"),
        TEXT.replace("\n", "\r"),
        TEXT.replace(" ", "\t"),
        TEXT.replace(" ", "   "),
        TEXT.replace("\n", "  # more\n"),
        TEXT.replace("\n", "#more f 1 2 3\n"),
        TEXT.replace("\n", "\n \t\n    # indented f 1 2 3\n  "),
        TEXT.replace(" ", " \\\n"),
        TEXT.replace(" ", " \\\r\n"),
        "\ufeff" + TEXT,
        lines(*F, *V),
        lines(*V[:4], *F, *V[4:]),
        lines("mtllib not there.mtl", "g box", "s off", "usemtl red", *V, "vn 0 0 1", "vt 0 0", *F),
        lines(*V, *(f.replace("f ", "fo ") for f in F)),
        lines(*V, *("f " + " ".join(f"{k + 1}/{k + 1}/{k + 1}" for k in face) for face in FACES)),
        lines(*V, *("f " + " ".join(f"{k + 1}//{k + 1}" for k in face) for face in FACES)),
        lines(*V, *("f " + " ".join(f"{k + 1}/{k + 1}" for k in face) for face in FACES)),
        lines(*V, *("f " + " ".join(str(k - 8) for k in face) for face in FACES)),
        lines(*(f"{v} 0.5 0.5 0.5" for v in V), *F),
        lines(*(f"{v} 1.0" for v in V), *F),
        lines(*(f"{v} 1.0 0.5 0.5 0.5" for v in V), *F),
        lines(*(f"{v} 0.1 0.2 0.3 0.4 0.5" for v in V), *F),
    ],
)  # fmt: skip
def test_layouts(text):
    found = read("obj", text)
    assert_box(found)
    assert found.notes == ()


def test_negative_numbers_count_back_from_where_they_stand():
    parts = [row for face in FACES for row in (*(V[k] for k in face), "f -3 -2 -1")]
    found = read("obj", lines(*parts))
    assert_box(found)


def test_polygons():
    quads = ["f " + " ".join(str(k + 1) for k in quad) for quad in QUADS]
    assert_box(read("obj", lines(*V, *quads)), quads=True)
    assert_box(read("obj", lines(*V, F[0], *F[1:])))


@pytest.mark.parametrize(
    ("more", "notes"),
    [
        (["l 1 2 3", "l 4 5"], ["2 lines left out"]),
        (["p 1", "p 2 3"], ["2 lists of points left out"]),
        (SURFACE, ["1 free-form surfaces left out"]),
        (["curv 0 1 1 2 3", "curv2 1 2", "end"], ["2 free-form curves left out"]),
        (["bzp 1 2 3 4", "surf 0 1 0 1 1 2 3 4"], ["2 free-form surfaces left out"]),
        (["v 0 0 0 2", "v 0 0 1 0.5"], ["2 vertices have a weight that is not 1: it means nothing for polygons"]),
    ],
)
def test_what_is_noted(more, notes):
    found = read("obj", lines(*V, *F, *more))
    np.testing.assert_array_equal(canonical(surface(found)), canonical(VERTICES[FACES]))
    assert list(found.notes) == notes
    assert len(found.points) == sum(row.startswith("v ") for row in more)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (
            lines(*V, *SURFACE),
            "holds no polygons, but 1 free-form surfaces left out: export it as polygons, or as STEP",
        ),
        (lines(*V, "f 1 2"), "line 9 is '1 2', expected three vertices or more"),
        (lines(*V, "", "f 1 2 9"), "line 10: a face names the vertex 9, but there are 8"),
        (lines(*V, "f 1 2 0"), "line 9: a face names the vertex 0"),
        (lines(*V, "f -9 2 1"), "line 9: a face names the vertex -9"),
        (lines(*V, "f 1 2 99999999999999999999999"), "line 9: a face names the vertex 1e+23"),
        (lines(*V, "f 1 2 1.5"), "line 9: a face names the vertex 1.5"),
        (lines(*V, "f 1 2 nan"), "line 9: a face names the vertex nan"),
        (lines(*V, "f 1 2 three"), "line 9: 'three' is not a number"),
        (lines("# x", *V, "v 1 2", *F), "line 10 is '1 2', expected three numbers"),
        (lines(*V, "v 1 2 3 4 5", *F), "line 9 is a vertex of 5 numbers"),
        (lines(*V, "v", *F), "line 9 is '', expected three numbers"),
        (lines("# x", *V[:2], "", "v 1,5 2,5 3,5", *V[2:], *F), "line 5: '1,5' is written with a decimal comma"),
        (lines(*V, *F, "call other.obj 1"), "line 21: `call` takes in another file, which is not done"),
        (lines(*V, *F, "csh rm -r ."), "line 21: `csh` runs a command, which is not done"),
        (lines(*V, *F, "polygon 1 2 3"), "line 21 is 'polygon 1 2 3', which is no statement of OBJ"),
        (lines("solid a", *V, *F), "line 1 is 'solid a', which is no statement of OBJ"),
        (lines(*V, *F).replace("f 1", "f \0001", 1), "NUL"),
        (lines(*V[:3], "v 1_0 2 3", *V[3:], *F), "line 4: '1_0' is not a number"),
    ],
)
def test_what_is_refused(text, complaint):
    assert complaint in refusal("obj", text)


def test_objects_and_groups_are_bodies_those_of_one_name_one():
    far = [f"v {float(v.split()[1]) + 1000} {' '.join(v.split()[2:])}" for v in V]
    later = ["f " + " ".join(str(k + 9) for k in face) for face in FACES]
    text = lines(
        "o lid #2", *V, *F[:5], "o größe # my wall", *far, *later[:7], "o lid #2", *F[5:], "g größe", *later[7:]
    )
    found = read("obj", text)
    assert [(body.name, len(body.faces)) for body in found.bodies] == [("lid", 12), ("größe", 12)]
    assert read("obj", text.encode("latin-1")).bodies[1].name == "größe"
    assert [body.name for body in read("obj", lines("g part#2", *V, *F)).bodies] == ["part#2"]


def test_groups_that_are_sides_of_one_body_are_one_body():
    sides = [row for k in range(6) for row in (f"g side{k}", F[2 * k], F[2 * k + 1])]
    found = read("obj", lines(*V, *sides))
    assert_box(found)
    assert [body.name for body in found.bodies] == ["side0 + 5 more"]
    assert found.notes == ("6 groups that are parts of one surface put together: one body",)


def test_vertices_alone_are_points():
    np.testing.assert_array_equal(read("obj", lines(*V)).points, VERTICES)


def test_what_trimesh_writes_is_what_it_reads():
    mesh = trimesh.creation.icosphere(3, 100)
    data = exported(mesh, "obj", include_normals=True)
    np.testing.assert_allclose(
        canonical(surface(read("obj", data))), canonical(as_trimesh_has_it("obj", data)), atol=2e-4
    )
