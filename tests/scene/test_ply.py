"""PLY: what a header can say, as text and in both orders of bytes, is read as written, or refused in words."""

import struct

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from import_makers import exported
from text_makers import FACES, QUADS, VERTICES, as_trimesh_has_it, assert_box, canonical, read, refusal, surface

from hognose.scene.imports.ply_header import TYPES

FORMS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
XYZ = [("float", "x"), ("float", "y"), ("float", "z")]
LIST = [("list uchar int", "vertex_indices")]
LETTERS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q", "f4": "f", "f8": "d"}


def ply(form, *elements, head=()):
    """A file of elements (name, properties, rows); a property is a type and a name."""
    lines = ["ply", f"format {form} 1.0", *head]
    body = b""
    for name, properties, rows in elements:
        lines += [f"element {name} {len(rows)}", *(f"property {kind} {called}" for kind, called in properties)]
        for row in rows:
            values = []
            for (kind, _), item in zip(properties, row, strict=True):
                *count, kind = kind.removeprefix("list ").split()
                items = list(item) if count else [item]
                values += ([(count[0], len(items))] if count else []) + [(kind, each) for each in items]
            if form == "ascii":
                body += (" ".join(f"{value:.9g}" for _, value in values) + "\n").encode()
            for kind, value in values if form != "ascii" else ():
                letter = LETTERS[TYPES[kind]]
                body += struct.pack(FORMS[form] + letter, value if letter in "fd" else int(value))
    return "\n".join([*lines, "end_header", ""]).encode() + body


VERTEX = ("vertex", XYZ, VERTICES)
FACE = ("face", LIST, [(face,) for face in FACES])
MIXED = [(QUADS[0][:3],), (QUADS[0][[0, 2, 3]],), *((quad,) for quad in QUADS[1:])]
EDGE = ("edge", [("int", "vertex1"), ("int", "vertex2")], [(0, 1), (1, 2)])
CAMERA = ("camera", [("float", "view_px"), ("list uchar float", "k")], [(1.5, [1, 2, 3])])
#: The box as six strips of two triangles; in one list, with a negative number between each two.
STRIPS = [[q[0], q[1], q[3], q[2]] for q in QUADS.tolist()]
ONE_STRIP = [k for strip in STRIPS for k in [*strip, -1]]


def flipped(column):
    """A vertex element with its properties in another order."""
    order = np.roll([0, 1, 2], column)
    return ("vertex", [XYZ[k] for k in order], VERTICES[:, order])


FEATURES = {
    "triangles": (VERTEX, FACE),
    "vertex_index": (VERTEX, ("face", [("list uint8 uint32", "vertex_index")], FACE[2])),
    "ushort counts": (VERTEX, ("face", [("list ushort uint", "vertex_indices")], FACE[2])),
    "int counts, short": (VERTEX, ("face", [("list int short", "vertex_indices")], FACE[2])),
    "char indices": (VERTEX, ("face", [("list char char", "vertex_indices")], FACE[2])),
    "float indices": (VERTEX, ("face", [("list uchar float", "vertex_indices")], FACE[2])),
    "double": (("vertex", [("double", a) for a in "xyz"], VERTICES), FACE),
    "short": (("vertex", [("short", a) for a in "xyz"], VERTICES), FACE),
    "mixed types": (("vertex", [("int32", "x"), ("float64", "y"), ("int16", "z")], VERTICES), FACE),
    "order z x y": (flipped(1), FACE),
    "order y z x": (flipped(2), FACE),
    "capitals": (("vertex", [("float", a) for a in "XYZ"], VERTICES), FACE),
    "normals first": (
        ("vertex", [("float", "nx"), *XYZ[:2], ("uchar", "red"), XYZ[2]], [(7, *v[:2], 255, v[2]) for v in VERTICES]),
        FACE,
    ),
    "list in vertices": (
        ("vertex", [("list uchar int", "n"), *XYZ], [([k] * (k % 3), *v) for k, v in enumerate(VERTICES)]),
        FACE,
    ),
    "faces first": (FACE, VERTEX),
    "face colours": (VERTEX, ("face", [("uchar", "r"), *LIST, ("float", "q")], [(9, f, 0.5) for f in FACES])),
    "texture lists": (
        VERTEX,
        ("face", [*LIST, ("list uchar float", "texcoord")], [(f, [0.5] * (k % 7)) for k, f in enumerate(FACES)]),
    ),
    "camera": (CAMERA, VERTEX, FACE),
    "no faces of strips": (VERTEX, FACE, ("tristrips", LIST, [])),
}
QUAD_FEATURES = {
    "quads": (VERTEX, ("face", LIST, [(quad,) for quad in QUADS])),
    "triangles and quads": (VERTEX, ("face", LIST, MIXED)),
    "quads first": (VERTEX, ("face", LIST, MIXED[::-1])),
    "mixed with more": (VERTEX, ("face", [("short", "a"), *LIST, ("uchar", "b")], [(1, f[0], 2) for f in MIXED])),
    "strips": (VERTEX, ("tristrips", [("list int int", "vertex_indices")], [(strip,) for strip in STRIPS])),
    "one strip": (VERTEX, ("tristrips", [("list int int", "vertex_indices")], [(ONE_STRIP,)])),
    "strips and faces": (
        VERTEX,
        ("face", LIST, [(quad,) for quad in QUADS[:2]]),
        ("tristrips", [("list uint int", "vertex_index")], [(strip,) for strip in STRIPS[2:]]),
    ),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("feature", [*FEATURES, *QUAD_FEATURES])
def test_what_is_taken(form, feature):
    elements = FEATURES.get(feature) or QUAD_FEATURES[feature]
    found = read("ply", ply(form, *elements))
    assert_box(found, quads=feature in QUAD_FEATURES)
    assert found.notes == ()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_headers_in_other_layouts(form, end):
    head = ["comment made by hand", "obj_info 12", "", "comment property float x"]
    data = ply(form, VERTEX, EDGE, FACE, head=head)
    begin = data.index(b"end_header\n") + 11
    other = data[:begin].replace(b"\n", end.encode()).replace(b"property ", b" property\t ")
    body = data[begin:].replace(b"\n", end.encode() + b"\n") if form == "ascii" else data[begin:]
    found = read("ply", other + body)
    assert_box(found)
    assert found.notes == ("2 rows of `edge` left out",)


def test_a_binary_body_that_begins_like_a_line_end():
    vertices = VERTICES.copy()
    vertices[0, 0] = struct.unpack("<f", b"\n\r\n\x41")[0]
    for end in ("\n", "\r\n", "\r"):
        data = ply("binary_little_endian", ("vertex", XYZ, vertices), FACE)
        begin = data.index(b"end_header\n") + 11
        found = read("ply", data[:begin].replace(b"\n", end.encode()) + data[begin:])
        np.testing.assert_allclose(surface(found), vertices[FACES], rtol=1e-6)


def test_strips_that_are_tied_together_by_triangles_without_area():
    tied = [k for strip, after in zip(STRIPS, [*STRIPS[1:], [0]], strict=True) for k in [*strip, strip[-1], after[0]]]
    found = read("ply", ply("ascii", VERTEX, ("tristrips", LIST, [(tied,)])))
    assert_box(found, quads=True)
    assert found.notes == ("22 triangles of strips without area left out",)


def test_utf_16_and_a_mark():
    text = ply("ascii", VERTEX, FACE)
    assert_box(read("ply", text.decode().encode("utf-16")))
    assert_box(read("ply", b"\xef\xbb\xbf" + text))


@pytest.mark.parametrize("form", FORMS)
def test_points_without_triangles_and_rest_of_strips(form):
    more = np.concatenate([VERTICES, [[500, 0, 0], [600, 0, 0], [700, 0, 0]]])
    found = read("ply", ply(form, ("vertex", XYZ, more), FACE))
    np.testing.assert_array_equal(found.points, more[8:])
    cloud = read("ply", ply(form, ("vertex", XYZ, more)))
    np.testing.assert_array_equal(cloud.points, more)
    assert not cloud.bodies
    named = ("vertex", [("float", "a"), ("float", "b"), ("float", "c"), ("uchar", "d")], [(*p, 3) for p in more])
    np.testing.assert_array_equal(read("ply", ply(form, named), columns=("c", 1, "B")).points, more[:, [2, 0, 1]])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("elements", "complaint"),
    [
        ((("vertex", XYZ[:2], VERTICES[:, :2]), FACE), "properties of `vertex` are 1 'x', 2 'y': none seems to be z"),
        ((FACE,), "no element `vertex`"),
        ((VERTEX, VERTEX, FACE), "more than one element `vertex`"),
        ((VERTEX, ("face", [("list uchar int", "corners")], FACE[2])), "`face` has no list `vertex_indices`"),
        ((VERTEX, ("face", [("int", "vertex_indices")], [(3,)])), "`face` has no list `vertex_indices`"),
        ((VERTEX, ("face", LIST, [([0, 1],), *FACE[2]])), "face 1 has 2 corners, expected three or more"),
        ((VERTEX, ("face", LIST, [*FACE[2], ([],)])), "face 13 has 0 corners, expected three or more"),
        ((VERTEX, ("face", LIST, [*FACE[2], ([0, 1, 8],)])), "face 13 names the vertex 8, but there are 8"),
        ((VERTEX, ("face", LIST, [([0, 1, -1],), *FACE[2]])), "face 1 names the vertex -1, but there are 8"),
        ((VERTEX, ("face", [("list uchar float", "vertex_index")], [([0, 1, 1.5],)])), "not whole numbers"),
        ((VERTEX, ("tristrips", LIST, [([0, 1, 2],), ([],)])), "a strip of triangles has 0 vertices"),
        ((VERTEX, ("tristrips", LIST, [([0, 1, -1, 2, 3, 4],)])), "a strip of triangles has 2 vertices"),
        ((VERTEX, ("tristrips", LIST, [([0, 1, 3, -2, 4, 5, 6],)])), "a strip names the vertex -2, but there are 8"),
        ((VERTEX, ("tristrips", LIST, [([0, 1, 99],)])), "a strip names the vertex 99, but there are 8"),
        ((VERTEX, FACE, ("cell", LIST, [([0, 1, 2, 3],)])), "holds 1 of an element `cell` with `vertex_indices`"),
        ((VERTEX, FACE, ("more_vertices", XYZ, VERTICES)), "holds 8 of an element `more_vertices` with `x`, `y`, `z`"),
    ],
)
def test_what_is_refused(form, elements, complaint):
    assert complaint in refusal("ply", ply(form, *elements))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["vertex", "face"])
@pytest.mark.parametrize("off", [-1, 1, 5])
@pytest.mark.parametrize("faces", [FACE, ("face", LIST, MIXED)], ids=["triangles", "mixed"])
def test_counts_that_are_not_those_of_the_file_are_refused(form, name, off, faces):
    data = ply(form, VERTEX, faces)
    said = 8 if name == "vertex" else len(faces[2])
    wrong = data.replace(f"element {name} {said}".encode(), f"element {name} {said + off}".encode())
    assert wrong != data
    assert any(words in refusal("ply", wrong) for words in ("cut", "damaged", "corners", "names the vertex"))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("faces", [FACE, ("face", LIST, MIXED)], ids=["triangles", "mixed"])
def test_every_cut_is_refused(form, faces):
    data = ply(form, VERTEX, faces)
    for end in range(len(data) - 2, 3, -1):  # without its last LF a text is whole
        if form == "ascii" and end > data.rindex(b"\n", 0, -1) + 1:
            continue  # the cut may leave numbers that are right
        refusal("ply", data[:end])


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda t: t.replace("-90", "-90,5"), "line 10: '-90,5' is written with a decimal comma"),
        (lambda t: t.replace("-90 ", "", 1), "line 10 has more or fewer numbers than its header says of `vertex`"),
        (lambda t: t.replace("-90", "-90 1", 1), "line 10 has more or fewer numbers"),
        (lambda t: t.replace("\n3 ", "\n4 ", 1), "line 18 has more or fewer numbers than its header says of `face`"),
        (lambda t: t.replace("\n3 ", "\n-3 ", 1), "no whole number of items"),
        (lambda t: t + "0 0 0\n", "its header says 20 rows (vertices, faces and others), but there are 21"),
        (lambda t: t.replace("-90", "left", 1), "line 10: 'left' is not a number"),
        (lambda t: t.replace("-90", "-90\0", 1), "NUL"),
        (lambda t: t.replace("float y", "floot y"), "line 5 of its header is 'property floot y'"),
        (lambda t: t.replace("element vertex 8", "element vertex eight"), "line 3 of its header"),
        (lambda t: t.replace("element vertex 8", "element vertex 8.5"), "line 3 of its header"),
        (lambda t: t.replace("format ascii", "format assy"), "line 2 of its header"),
        (lambda t: t.replace("format ascii 1.0\n", ""), "no line `format`"),
        (lambda t: t.replace("end_header", "ende"), "no `end_header`"),
        (lambda t: "\n" + t, "does not begin with a line `ply`"),
    ],
)
def test_texts_that_are_refused(change, complaint):
    assert complaint in refusal("ply", change(ply("ascii", VERTEX, FACE).decode()))


def test_blank_lines_between_rows():
    data = ply("ascii", VERTEX, FACE)
    begin = data.index(b"end_header\n") + 11
    assert_box(read("ply", data[:begin] + data[begin:].replace(b"\n", b"\n\n \t\n")))


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_any_polygons_are_the_same_in_every_form_and_as_trimesh_has_them(seed):
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(rng.integers(3, 30), 3)).astype(np.float32)
    faces = [rng.choice(len(vertices), rng.integers(3, min(9, len(vertices) + 1)), replace=False) for _ in range(20)]
    elements = (("vertex", XYZ, vertices), ("face", LIST, [(face,) for face in faces]))
    expected = np.concatenate([[vertices[[f[0], f[k], f[k + 1]]] for k in range(1, len(f) - 1)] for f in faces])
    for form in FORMS:
        found = surface(read("ply", ply(form, *elements)))
        np.testing.assert_allclose(found, expected, atol=1e-6 if form == "ascii" else 0)
    mesh = trimesh.Trimesh(vertices, faces=[face[:3] for face in faces], process=False)
    for encoding in ("ascii", "binary"):
        theirs = exported(mesh, "ply", encoding=encoding)
        ours = canonical(surface(read("ply", theirs)))
        np.testing.assert_allclose(ours, canonical(as_trimesh_has_it("ply", theirs)), atol=2e-4)
