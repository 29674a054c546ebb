"""OFF: its legal layouts are the box that was written, or refused in words."""

import struct

import numpy as np
import pytest
import trimesh
from import_makers import exported
from text_makers import FACES, POINTS, QUADS, VERTICES, as_trimesh_has_it, assert_box, canonical, read, refusal, surface

CORNERS = [" ".join(map(str, face)) for face in FACES]
HEAD = "OFF\n8 12 18\n"


def off(head=HEAD, vertex="{}", face="3 {}", faces=CORNERS, between="\n", end="\n"):
    """A file of the box; `vertex` and `face` say what stands round the coordinates and the corners."""
    rows = [*(vertex.format(point) for point in POINTS), *(face.format(each) for each in faces)]
    return head + between.join(rows) + end


@pytest.mark.parametrize(
    "text",
    [
        off(),
        off(end=""),
        off("OFF8 12 18\n"),
        off("OFF 8 12 18\n"),
        off("OFF 8 12\n"),
        off("OFF\n8\n12\n18\n"),
        off("OFF\n8 12\n"),
        off("\n  OFF # a box\n# counts\n8 12 18 # edges do not matter\n\n"),
        off("OFF\n8 12 0\n", between="  # note\n\n"),
        off(between=" "),
        off("OFF 8 12 18 ", between=" "),
        off(between="\r\n"),
        off("OFF\r8 12 18\r", between="\r"),
        "\ufeff" + off(),
        off(face="3\n{}"),
        off("COFF\n8 12 18\n", "{} 1 0 0 1"),
        off("COFF\n8 12 18\n", "{} 255 0 0"),
        off("OFF\n8 12 18\n", "{} 255 0 0"),
        off("OFF\n8 12 18\n", "{} 0.1 0.2 0.3 1"),
        off("NOFF\n8 12 18\n", "{} 0 0 1"),
        off("CNOFF\n8 12 18\n", "{} 0 0 1 0.5 0.5 0.5 1"),
        off("STOFF\n8 12 18\n", "{} 0.5 0.5"),
        off("STCNOFF\n8 12 18\n", "{} 0 0 1 1 1 1 1 0.5 0.5", between=" "),
        off("nOFF\n3\n8 12 18\n"),
        off("nOFF 3 8 12 18\n"),
        off(face="3 {} 7"),
        off(face="3 {} 255 0 0"),
        off(face="3 {} 1.0 0.5 0.0 0.75"),
        off(face="3\n {} 0.5 0.5 0.5"),
        off("COFF\n8 12 18\n", "{} 255 0 0 255", "3  {}  10 20 30"),
    ],
)
def test_layouts(text):
    found = read("off", text)
    assert_box(found)
    assert found.notes == ()


def test_faces_of_some_lines_and_colours_of_others():
    faces = [f"3 {corners}" + ["", " 3", " 0 1 0", " 1 1 1 0.5"][k % 4] for k, corners in enumerate(CORNERS)]
    assert_box(read("off", off(face="{}", faces=faces)))


@pytest.mark.parametrize("colour", ["", " 1.000 0.000 0.000 0.75"])
def test_polygons(colour):
    quads = [" ".join(map(str, quad)) for quad in QUADS]
    assert_box(read("off", off("OFF 8 6 12\n", face="4 {}" + colour, faces=quads)), quads=True)
    first = [f"4 {quads[0]}{colour}", f"3 {CORNERS[0]}{colour}"]
    assert len(surface(read("off", off("OFF 8 2 0\n", face="{}", faces=first)))) == 3


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (off("OFF\n8 11 18\n"), "8 vertices and 11 faces, but line 22 goes on after these"),
        (off("OFF\n8 13 18\n"), "8 vertices and 13 faces, but ends after 12 faces"),
        (off("OFF\n7 12 18\n"), "7 vertices and 12 faces"),
        (off("OFF\n9 12 18\n"), "line 11: a face begins with 0"),
        (off("OFF\n8 11 18\n", face="3 {} 1 0 0"), "8 vertices and 11 faces"),
        (off("OFF\n8 13 18\n", face="3 {} 1 0 0"), "8 vertices and 13 faces"),
        (off(end="\n3 0 1 2\n"), "line 23 goes on after these"),
        (off() + "0\n", "goes on after these"),
        (off(face="3 {} 1 0"), "2 numbers follow the corners of a face"),
        (off().replace(f"3 {CORNERS[11]}\n", f"3 {CORNERS[11][:3]}\n"), "ends after 11 faces"),
        (off().replace(f"3 {CORNERS[3]}", "2 0 1 2"), "a face begins with 2, expected how many corners"),
        (off().replace(f"3 {CORNERS[3]}", "3 0 1 8"), "names the vertex 8, but there are 8"),
        (off().replace(f"3 {CORNERS[3]}", "3 0 1 -1"), "names the vertex -1, but there are 8"),
        (off().replace(f"3 {CORNERS[3]}", "3 0 1 1.5"), "names the vertex 1.5, but there are 8"),
        (off().replace(POINTS[0], "0,5 1,5 2,5"), "line 3: '0,5' is written with a decimal comma"),
        (off().replace(POINTS[2], "a b c"), "line 5: 'a' is not a number"),
        (off().replace(POINTS[2], "1\0 2 3"), "line 5 holds a NUL byte"),
        (off("4OFF\n8 12 18\n", "{} 1"), "is 4OFF: its vertices have four coordinates"),
        (off("nOFF\n4\n8 12 18\n", "{} 1"), "is nOFF of 4 dimensions; expected 3"),
        (off("4nOFF\n3\n8 12 18\n", "{} 1"), "is 4nOFF"),
        (off("SOFF\n8 12 18\n"), "does not begin with `OFF`"),
        (off("8 12 18\n"), "does not begin with `OFF`"),
        (off("OFFICE\n8 12 18\n"), "does not begin with `OFF`"),
        ("OFF", "does not say how many"),
        ("OFF\n8.5 12 18\n", "does not say how many"),
        ("OFF\n-8 12 18\n", "does not say how many"),
        ("OFF\n8 12 18\n", "cut"),
    ],
)
def test_what_is_refused(text, complaint):
    assert complaint in refusal("off", text)


@pytest.mark.parametrize("kind", ["OFF", "COFF"])
def test_binary_files_are_refused_as_such(kind):
    data = f"# by hand\n{kind} BINARY\n".encode() + struct.pack(">3i", 8, 12, 18) + VERTICES.astype(">f4").tobytes()
    assert "is a binary OFF file, which is not read; export it as text" in refusal("off", data)


def test_what_can_be_read_in_two_ways_is_refused():
    """A triangle with the colour 4 and another one; or a triangle and one of four corners, 3 0 1 2."""
    two = "\n".join([*POINTS, "3 0 1 2 4", "3 0 1 2"])
    assert "can be read in more than one way" in refusal("off", "OFF 8 2 0\n" + two)
    assert len(surface(read("off", "OFF 8 2 0\n" + two.replace("3 0 1 2 4", "3 0 1 2 5")))) == 2
    assert len(surface(read("off", "OFF 8 2 0\n" + two.replace("\n3 0 1 2", " 3 0 1 2")))) == 3


def test_vertices_alone_are_points_and_unused_ones_are_kept_apart():
    np.testing.assert_array_equal(read("off", off("OFF 8 0 0\n", faces=[])).points, VERTICES)
    found = read("off", off("OFF 8 1 0\n", faces=["0 1 2"]))
    np.testing.assert_array_equal(found.points, VERTICES[3:])


def test_what_trimesh_writes_is_what_it_reads():
    mesh = trimesh.creation.icosphere(3, 100)
    data = exported(mesh, "off")
    np.testing.assert_allclose(
        canonical(surface(read("off", data))), canonical(as_trimesh_has_it("off", data)), atol=2e-4
    )
