"""STL: every layout of text and binary files is the box that was written, or is refused in words."""

import re
import struct

import numpy as np
import pytest
from import_makers import content
from text_makers import FACES, POINTS, VERTICES, assert_box, canonical, read, refusal, surface

from hognose.scene.imports import stl

FACETS = [
    f"facet normal 0 0 1\n outer loop\n{''.join(f'  vertex {POINTS[k]}{chr(10)}' for k in face)} endloop\nendfacet\n"
    for face in FACES
]
TEXT = f"solid a\n{''.join(FACETS)}endsolid a\n"
BINARY = content("stl")


def test_the_quads_and_texts_here_are_the_box():
    assert_box(read("stl", TEXT))
    assert_box(read("stl", BINARY))


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (lambda t: t.upper(), ["A"]),
        (lambda t: t.title(), ["A"]),
        (lambda t: t.replace("\n", "\r\n"), ["a"]),
        (lambda t: t.replace("\n", "\r"), ["a"]),
        (lambda t: t.replace("endsolid", "end solid"), ["a"]),
        (lambda t: t.replace("endsolid", "END\tSOLID"), ["a"]),
        (lambda t: t.replace("endloop", "end loop").replace("endfacet", "end facet"), ["a"]),
        (lambda t: t.replace("endsolid a\n", "endsolid"), ["a"]),
        (lambda t: t.replace("solid a", "solid"), [""]),
        (lambda t: t.replace("solid a", "solid a lid with facets of steel"), ["a lid with facets of steel"]),
        (lambda t: t.replace("normal 0 0 1", "normal -nan(ind) -nan(ind) nan"), ["a"]),
        (lambda t: t.replace(" normal 0 0 1", ""), ["a"]),
        (lambda t: t.replace("\n", "\n\n \t\n"), ["a"]),
        (lambda t: t.replace("\n", " ").replace(" endsolid", "\nendsolid"), ["a"]),
        (lambda t: t.replace("\n", " "), ["a"]),
        (lambda t: "\n  \n" + t.replace("solid a", "  solid   a "), ["a"]),
        (lambda t: "\ufeff" + t, ["a"]),
        (lambda t: t.replace("vertex ", "vertex +").replace("+-", "-"), ["a"]),
        (lambda t: t.replace("vertex -90", "vertex -9.0E+01").replace("vertex 110", "vertex 1100.00e-1"), ["a"]),
        (lambda t: t.replace("vertex 110", "vertex 110."), ["a"]),
        (lambda t: t.replace("solid a", "solid größe"), ["größe"]),
    ],
)
def test_layouts_of_text(change, names):
    found = read("stl", change(TEXT))
    assert_box(found)
    assert [body.name for body in found.bodies] == names
    assert found.notes == ()


def test_utf_16_and_names_that_are_not_utf_8():
    assert_box(read("stl", TEXT.encode("utf-16")))
    assert read("stl", TEXT.replace("solid a", "solid größe").encode("latin-1")).bodies[0].name == "größe"


@pytest.mark.parametrize("chunk", [700, 1000, 4000])
def test_text_is_read_the_same_in_pieces(chunk, monkeypatch):
    whole = surface(read("stl", TEXT))
    monkeypatch.setattr(stl, "_CHUNK", chunk)
    np.testing.assert_array_equal(surface(read("stl", TEXT)), whole)
    np.testing.assert_array_equal(surface(read("stl", TEXT.replace(" normal 0 0 1", ""))), whole)
    assert "line 79: 'facet" in refusal("stl", "\n".join([*TEXT.split("\n")[:82], "x", *TEXT.split("\n")[82:]]))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda t: t.replace("endsolid a\n", ""), "cut, or not an STL file: `endsolid` is missing, it does not end"),
        (lambda t: t[: t.rindex("endfacet")] + "endsolid", "line 79: 'facet normal 0 0 1' is not the begin of a whole"),
        (lambda t: t[:200], "`endsolid` is missing"),
        (lambda t: t.replace("endsolid a", "solid b"), "line 86 begins another solid before it"),
        (lambda t: t + "facet normal 0 0 1", "line 87 is 'facet normal 0 0 1', expected `solid`"),
        (lambda t: t + "more", "line 87 is 'more', expected `solid`"),
        (
            lambda t: t.replace("endsolid a\n", "endsolid a solid b " + FACETS[0] + "endsolid b"),
            "goes on after `endsolid`",
        ),
        (
            lambda t: t.replace(" endloop", f"  vertex {POINTS[0]}\n endloop", 1),
            "line 2: a facet of more than three corners",
        ),
        (lambda t: t.replace(f"  vertex {POINTS[FACES[1][0]]}\n", "", 1), "is not the begin of a whole facet"),
        (lambda t: t.replace("110", "110,0"), "is written with a decimal comma"),
        (lambda t: t.replace("vertex 110", "vertex abc", 1), "'abc' is not a number"),
        (lambda t: t.replace("vertex 110", "vertex 1_10", 1), "holds _"),
        (lambda t: t.replace("vertex 110", "vertex 110 0", 1), "is not the begin of a whole facet"),
        (lambda t: t.replace("outer loop", "outer\0loop", 1), "line 3 holds a NUL byte"),
        (lambda t: "colour\n" + t, "not an STL file"),
    ],
)
def test_texts_that_are_refused(change, complaint):
    assert complaint in refusal("stl", change(TEXT))


@pytest.mark.parametrize("number", [4, 34, 83])
def test_the_line_of_what_is_wrong_is_told(number):
    lines = TEXT.split("\n")
    assert "vertex" in lines[number - 1]
    lines[number - 1] = "vertex 12,5 0 0"
    assert f"line {number}: '12,5' is written with a decimal comma" in refusal("stl", "\n".join(lines))


def test_solids_are_bodies_unless_they_are_parts_of_one_surface():
    apart = TEXT + TEXT.replace("solid a", "solid b").replace("230", "2300")
    assert [body.name for body in read("stl", apart).bodies] == ["a", "b"]
    patches = "".join(f"solid side {k}\n{FACETS[2 * k]}{FACETS[2 * k + 1]}endsolid side {k}\n" for k in range(6))
    found = read("stl", patches)
    assert_box(found)
    (body,) = found.bodies
    assert body.name == "side 0 + 5 more"
    assert found.notes == ("6 solids that are parts of one surface put together: one body",)
    empty = read("stl", "solid nothing\nendsolid nothing\n" + TEXT)
    assert [body.name for body in empty.bodies] == ["a"]


@pytest.mark.parametrize("head", [b"solid box", b"SOLID of facets", b"COLOR=\1\2\3\4", b"facet", b"\xff\xfe"])
def test_binary_files_whatever_they_begin_with(head):
    data = bytearray(head.ljust(80, b" ") + BINARY[80:])
    data[84 + 48 : 84 + 50] = b"\x1f\x80"  # a colour
    np.testing.assert_array_equal(canonical(surface(read("stl", bytes(data)))), canonical(VERTICES[FACES]))


@pytest.mark.parametrize("head", [b"solid box", b"binary"])
@pytest.mark.parametrize("said", [0, 6, 11, 13, 2**32 - 1])
def test_a_count_that_is_not_that_of_the_file_is_refused(head, said):
    data = head.ljust(80, b"\0") + struct.pack("<I", said) + BINARY[84:]
    message = refusal("stl", data)
    assert f"it says it has {said:,} triangles" in message
    assert re.search(r"\b12\b", message)


def test_a_rest_that_is_no_triangle_is_said():
    found = read("stl", BINARY + b"made with")
    assert_box(found)
    assert found.notes == ("9 bytes after the last triangle left out",)
