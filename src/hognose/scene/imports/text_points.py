"""Reading point clouds written as text: a point on each line, in columns that may have headings."""

from __future__ import annotations

import io
import re

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports import ptx
from hognose.scene.imports.columns import Asked, axes, names_axes, unit_of
from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.numeric_text import chunks, fields_per_line, is_number, not_a_number, per_line, plain, shown
from hognose.scene.imports.text_layout import Layout, fields, layout, refuse_doubtful_commas, unquoted

Floats = NDArray[np.float64]

_COUNT = re.compile(rb"(?m)^[ \t]*\d+[ \t]*$")
_BLANK = re.compile(rb"(?m)^[ \t]+$")
_DECIMAL_COMMA = re.compile(rb"\d,\d|(?<!\S),\d")
_POINT = re.compile(rb"[.eE]")
#: So many whole numbers between commas may be half as many, or somewhat more, with decimal commas.
_DOUBTFUL = 6
_COMMENT = re.compile(rb"(?m)(?:^[ \t]*|[ \t])(?:#|//)[^\n]*")


def read(source: Source) -> Content:
    """Return the points of a text with one a line, between blanks, tabs, commas or semicolons.

    Columns are found by their headings if there are any that name x, y and z; else they are the first three. The rest
    of each line is left out, and so are empty lines and comments after # or //. A line with one whole number says how
    many points follow (PTS); two of them begin a scan with its place (PTX).

    Raises
    ------
    InputError
        It cannot be told which columns are x, y and z, or whether a comma is a decimal point; a line is not like the
        others, or not of numbers; tells its number.
    """
    asked = source.scan.columns
    text = unquoted(plain(source.data))
    if ptx.is_ptx(text):
        if asked:
            raise InputError("a PTX file has its columns in a fixed order; leave `columns` out")
        return ptx.read(text)
    form = layout(text, asked)
    if form is None:
        return Content()
    body = _without_counts(_body(text, form), form)
    places = _places(form, asked)
    if _DECIMAL_COMMA.search(body) and form.separator != b",":
        refuse_doubtful_commas(body, form)
        body = body.replace(b",", b".")
    elif form.separator == b"," and form.width >= _DOUBTFUL and not (asked or form.headings or _POINT.search(body)):
        fewer = "fewer" if form.width % 2 else form.width // 2
        raise InputError(
            f"line {form.first_line} has {form.width} whole numbers between commas: columns, or {fewer} "
            "numbers with decimal commas? Say which hold x, y and z, `columns = [1, 2, 3]`, or export it with points"
        )
    points = _numbers(body, form, places, source.scan.drop_invalid)
    if form.width > 3 and not (asked or form.headings):
        _refuse_index(points[:, 0], form)
    metres = unit_of([form.headings[k] for k in places]) if form.headings else None
    notes = (f"{shown(form.title)} before its points taken for a title",) if form.title else ()
    if form.count is None and source.path.suffix.lower() == ".pts":
        notes += ("does not say how many points it holds, as PTS files do: is it whole?",)
    return Content(points=points, metres=metres, notes=notes)


def _body(text: bytes, form: Layout) -> bytes:
    """The text with its head and its comments blanked, so that lines keep their numbers."""
    lines = text.split(b"\n", form.first_line - 1)
    body = b"\n" * (form.first_line - 1) + lines[-1]
    if b"#" in body or b"//" in body:
        body = _COMMENT.sub(b"", body)
    return body


def _without_counts(body: bytes, form: Layout) -> bytes:
    """The text without lines that say how many rows follow; refused if they do not."""
    if form.count is None:
        _refuse_uneven(body, form)
        return body
    said = [(form.count_line, form.count)]
    for found in _COUNT.finditer(body):
        said.append((body.count(b"\n", 0, found.start()) + 1, int(found[0])))
    body = _COUNT.sub(b"", body)
    lines = _refuse_uneven(body, form)
    begins = np.searchsorted(lines, [line for line, _ in said])
    for (line, count), there in zip(said, np.diff(np.append(begins, len(lines))).tolist(), strict=True):
        if count != there:
            wrong = "cut" if count > there else "damaged"
            raise InputError(f"{wrong}: line {line} says that {count:,} points follow, but there are {there:,}")
    return body


def _refuse_uneven(body: bytes, form: Layout) -> NDArray[np.int64]:
    """The numbers of lines that are not blank; refused unless all have as many fields as the first."""
    lines, line = [], 1
    for piece in chunks(body):
        words = fields_per_line(piece)
        used = np.flatnonzero(words)
        width = words if form.separator is None else per_line(piece, form.separator) + 1
        wrong = used[width[used] != form.width]
        if wrong.size:
            there = piece.split(b"\n")[wrong[0]]
            raise InputError(
                f"line {line + wrong[0]} is {shown(there)}; expected x y z in {form.width} columns, as on line "
                f"{form.first_line}; is the file cut, or are there decimal commas?"
            )
        lines.append(line + used)
        line += len(words)
    return np.concatenate(lines)


def _places(form: Layout, asked: Asked) -> tuple[int, int, int]:
    """The columns of x, y and z."""
    if form.headings:
        if asked or names_axes(form.headings):
            return axes(form.headings, asked)
        there = ", ".join(f"{k} {name!r}" for k, name in enumerate(form.headings, 1))
        raise InputError(
            f"its columns are {there}: none seems to be x, y or z; say which hold them, by name or number: "
            "`columns = [1, 2, 3]`"
        )
    if asked is None and form.title and form.width > 3:
        raise InputError(
            f"line {form.first_line} has {form.width} columns, and {shown(form.title)} before it does not name them; "
            "say which hold x, y and z by their numbers: `columns = [1, 2, 3]`"
        )
    return axes([""] * form.width, asked or (1, 2, 3))


def _refuse_index(first: Floats, form: Layout) -> None:
    """Refuse a first column that counts the lines: it is hardly x."""
    if len(first) > 1 and first[0] in (0, 1) and np.array_equal(first, first[0] + np.arange(len(first))):
        raise InputError(
            f"the first of its {form.width} columns counts the lines, {first[0]:.0f}, {first[1]:.0f}, …: is it x, or "
            "their number? Say which hold x, y and z: `columns = [2, 3, 4]`, or `columns = [1, 2, 3]` if it is x"
        )


def _numbers(body: bytes, form: Layout, places: tuple[int, int, int], gaps: bool) -> Floats:
    """The numbers (p, 3) of three columns; empty fields are NaN if they may be."""
    if form.separator is not None:
        body = _BLANK.sub(b"", body)
    if gaps and form.separator is not None:
        body = re.sub(rb"(?<![^\n%s]) *(?=%s)|(?<=%s) *(?=\n|\Z)" % ((form.separator,) * 3), b"nan", body)
    try:
        separator = form.separator.decode() if form.separator else None
        stream = io.BytesIO(body)
        return np.loadtxt(stream, comments=None, delimiter=separator, usecols=places, ndmin=2, encoding="latin-1")
    except ValueError as error:
        for number, line in enumerate(body.split(b"\n"), 1):
            there = fields(line, form.separator) if line.strip() else []
            for place in places if there else ():
                if not there[place]:
                    raise InputError(
                        f"line {number} is {shown(line)}: a coordinate is missing; `drop_invalid = true` drops these"
                    ) from None
                if not is_number(there[place]):
                    raise not_a_number(there[place], number) from None
        raise InputError(f"cannot be read as columns of numbers: {error}") from None
