"""Reading OFF: counts, vertices, and faces of any number of corners."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.content import Content, RawBody, Source
from hognose.scene.imports.numeric_text import Rows, plain, rows, shown, whole
from hognose.scene.imports.polygons import gathered, loose, triangles

Ints = NDArray[np.int64]

_HEAD = re.compile(rb"\s*((?:ST)?C?N?(4?)(n?)OFF)(?=[\s\d]|\Z)")
_BINARY = re.compile(rb"(?:\s|#[^\n\r]*[\n\r])*[A-Za-z0-9]*OFF[ \t]+BINARY")
#: Numbers that may follow the corners of a face as its colour: none, a place in a list, grey levels, RGB, RGBA.
_COLOURS = (0, 1, 3, 4)


@dataclass(frozen=True, eq=False)
class _Reading:
    """One way to read the numbers: where each vertex begins, and where the corners of each face do, and how many."""

    vertices: Ints
    faces: Ints
    corners: Ints

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Reading) and all(
            np.array_equal(getattr(self, each), getattr(other, each)) for each in ("vertices", "faces", "corners")
        )


class _NotSoError(Exception):
    """The numbers cannot be read this way; says why."""


def read(source: Source) -> Content:
    """Return the content of an OFF file; normals, colours and places in pictures are left out.

    Lines mean nothing for corners, and only they tell where the colour of a face ends; so there are several ways to
    read a file. That which takes every number in it is right.

    Raises
    ------
    InputError
        It is cut, goes on after its last face, is binary or not in space, or can be read in more than one way.
    """
    if _BINARY.match(source.data):
        raise InputError("is a binary OFF file, which is not read; export it as text, or as PLY or STL")
    text = re.sub(rb"#[^\n]*", b"", plain(source.data))
    head = _HEAD.match(text)
    if head is None:
        raise InputError(f"not an OFF file: it does not begin with `OFF`, but with {shown(text.strip()[:20])}")
    begin = head.end()
    table = rows(text[begin:], text.count(b"\n", 0, begin) + 1)
    vertices, faces, first = _counts(table, head)
    found, complaints = [], []
    for way in _ways(table, vertices, faces, first, head[1]):
        if isinstance(way, str):
            complaints.append(way)
        elif way not in found:
            found.append(way)
            if _one_a_line(table, way):
                break  # lines or not, it is the same
    if not found:
        # What is wrong by lines, if it has those; the last one tried.
        raise InputError(complaints[-1] if len(table.ends) > vertices else complaints[0])
    if len(found) > 1:
        raise InputError(
            "can be read in more than one way: it is not clear which numbers are colours; export it without colours, "
            "or with one vertex and one face on each line"
        )
    way = found[0]
    places = table.numbers[way.vertices[:, None] + [0, 1, 2]]
    index = whole(table.numbers[gathered(way.faces, way.corners)])
    assert index is not None  # as it was read so
    made, notes = triangles(places, index, way.corners)
    if not len(made):
        return Content(points=places, notes=notes)
    return Content((RawBody("", places, made),), loose(places, made), notes=notes)


def _counts(table: Rows, head: re.Match[bytes]) -> tuple[int, int, int]:
    """How many vertices and faces there are, and which number comes after the counts."""
    at = 0
    if head[3]:
        dimensions = table.numbers[0] if table.numbers.size else 0
        if dimensions != 3:
            raise InputError(f"is {head[1].decode()} of {dimensions:g} dimensions; expected 3: a shape in space")
        at = 1
    if head[2]:
        raise InputError(
            f"is {head[1].decode()}: its vertices have four coordinates; export it as OFF with three, a shape in space"
        )
    line_end = table.ends[table.ends > at]
    both = bool(line_end.size) and line_end[0] == at + 2  # some leave out the number of edges
    counts = whole(table.numbers[at : at + (2 if both else 3)])
    if counts is None or len(counts) < 2 + (not both) or (counts < 0).any():
        raise InputError("cut, or not an OFF file: it does not say how many vertices and faces it has")
    return int(counts[0]), int(counts[1]), at + len(counts)


def _ways(table: Rows, vertices: int, faces: int, first: int, kind: bytes) -> Iterator[_Reading | str]:
    """Every way to read the numbers, or why it is none: vertices and faces one after the other, or by lines."""
    line_end = np.repeat(table.ends, np.diff(table.ends, prepend=0))
    places = list(_places(table, vertices, first, kind))
    if not places:
        yield (
            f"cut or damaged: it says it has {vertices:,} vertices and {faces:,} faces, which is not what its "
            f"{len(table.numbers):,} numbers on {len(table.ends):,} lines are"
        )
    for begins, last in places:
        for lines in (None, line_end):
            try:
                yield _Reading(begins, *_faces(table, last, faces, vertices, lines))
            except _NotSoError as error:
                yield str(error)


def _one_a_line(table: Rows, way: _Reading) -> bool:
    """Whether each face fills a line, and each vertex begins one."""
    ends = way.faces + way.corners
    return np.array_equal(ends, table.ends[len(table.ends) - len(ends) :]) and bool(
        np.isin(way.vertices, table.begins).all()
    )


def _places(table: Rows, vertices: int, first: int, kind: bytes) -> Iterator[tuple[Ints, int]]:
    """Where each vertex may begin, and where the last one ends: one after the other, or one on each line."""
    width = 3 + 3 * (b"N" in kind) + 4 * (b"C" in kind) + 2 * kind.startswith(b"ST")
    last = first + width * vertices
    if last <= len(table.numbers):
        yield first + width * np.arange(vertices), last
    # Some write colours without saying so, or without a last number.
    widths = {width, width - 1} if b"C" in kind else {width} if kind != b"OFF" else {3, 6, 7}
    begins = np.unique(np.append(table.begins, first))
    begins = begins[np.searchsorted(begins, first) :]
    found = np.diff(np.append(begins, len(table.numbers)))[:vertices]
    if vertices and len(found) == vertices and (found == found[0]).all() and int(found[0]) in widths:
        yield begins[:vertices], int(begins[vertices - 1] + found[0])


def _faces(table: Rows, at: int, faces: int, vertices: int, line_end: Ints | None) -> tuple[Ints, Ints]:
    """Where the corners of each face begin, and how many there are; with `line_end`, a colour follows up to there."""
    said = f"it says it has {vertices:,} vertices and {faces:,} faces"
    begins, corners, end = _equal(table, at, faces) if line_end is None else (None, None, 0)
    if begins is None or corners is None:
        begins, corners, end = _each(table, at, faces, said, line_end)
    if end < len(table.numbers):
        raise _NotSoError(f"damaged: {said}, but line {table.line_of(end)} goes on after these")
    index = table.numbers[gathered(begins, corners)]
    wrong = np.flatnonzero((index % 1 != 0) | (index < 0) | (index >= vertices))
    if wrong.size:
        raise _NotSoError(f"damaged: a face names the vertex {index[wrong[0]]:.12g}, but there are {vertices:,}")
    return begins, corners


def _equal(table: Rows, at: int, faces: int) -> tuple[Ints | None, Ints | None, int]:
    """The same for faces that all have as many corners as the first one, and no colour."""
    count = table.numbers[at] if faces and at < len(table.numbers) else np.nan
    if not (3 <= count < len(table.numbers) and count % 1 == 0):
        return None, None, 0
    begins = at + (int(count) + 1) * np.arange(faces)
    end = int(begins[-1]) + int(count) + 1
    if end > len(table.numbers) or (table.numbers[begins] != count).any():
        return None, None, 0
    return begins + 1, np.full(faces, int(count)), end


def _each(table: Rows, at: int, faces: int, said: str, line_end: Ints | None) -> tuple[Ints, Ints, int]:
    """The same for any faces, one after the other."""
    numbers = table.numbers.tolist()
    total = len(numbers)
    begins, corners = [], []
    for face in range(faces):
        count = numbers[at] if at < total else 0
        if at >= total or at + 1 + count > total:
            raise _NotSoError(f"cut: {said}, but ends after {face:,} faces")
        if not (count >= 3 and count % 1 == 0):
            raise _NotSoError(
                f"line {table.line_of(at)}: a face begins with {count:g}, expected how many corners it has; damaged?"
            )
        begins.append(at + 1)
        corners.append(int(count))
        at += 1 + int(count)
        if line_end is not None:
            rest = int(line_end[at - 1]) - at
            if rest not in _COLOURS:
                raise _NotSoError(
                    f"line {table.line_of(at - 1)}: {rest} numbers follow the corners of a face; expected a colour of "
                    "1, 3 or 4"
                )
            at += rest
    return np.array(begins, np.int64), np.array(corners, np.int64), at
