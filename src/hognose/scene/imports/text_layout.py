"""How a text of points is laid out: separator, headings, decimal commas, and where the first point is."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from hognose.errors import InputError
from hognose.scene.imports.columns import Asked, names_axes
from hognose.scene.imports.numeric_text import is_number, name, shown

_WITH_COMMA = re.compile(rb"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_COMMENT = (b"#", b"//", b"%", b"!")
#: A comma that can be no separator of thousands: behind nothing, a zero or more than three digits, or before a number
#: of digits that is not three.
_DECIMAL = re.compile(rb"(?<!\d)(?:|0\d*|\d{4,}),\d|\d,(?:\d{1,2}|\d{4,})(?!\d)|\d,\d+[eE]")
_BOTH = re.compile(rb"\d\.\d+,\d|\d,\d+\.\d|\d,\d+,\d")
_POINT = re.compile(rb"(?:^|(?<=[;\s]))[+-]?\d*\.\d+(?=[;\s]|\Z)")
_NUMERIC = re.compile(rb"\s*[+-]?[\d.,']*\d[\d.,']*(?:[eE][+-]?\d+)?\s*")
_TRAILING = re.compile(rb"[ \t](?:#|//)")
_HEAD = 1000  # lines in which the first point is looked for


@dataclass(frozen=True)
class Layout:
    """How a text of points is laid out.

    Attributes
    ----------
    separator
        Of the columns; None for white space.
    width
        How many columns there are.
    first_line
        The line of the first point, from 1.
    headings
        Of the columns; empty if they have none.
    title
        A line before the first point that is no heading, if there is one.
    count, count_line
        How many points a line before the first says there are, and which line; or None.
    """

    separator: bytes | None
    width: int
    first_line: int
    headings: tuple[str, ...] = ()
    title: bytes = b""
    count: int | None = None
    count_line: int = 0


def layout(text: bytes, asked: Asked) -> Layout | None:
    """Return how a text is laid out, or None if it holds no line but comments and headings.

    Parameters
    ----------
    text
        As `plain` returns it, without quotes.
    asked
        The columns that hold x, y and z, if they are given.

    Raises
    ------
    InputError
        The first lines are not headings, or how many points there are, and then points.
    """
    comment, before = b"", []
    for number, line in enumerate(text.split(b"\n", _HEAD)[:_HEAD], 1):
        if not line.strip():
            continue
        mark = next((mark for mark in _COMMENT if line.lstrip().startswith(mark)), None)
        line = line if mark else _TRAILING.split(line, maxsplit=1)[0]
        separator = _separator(line)
        row = fields(line, separator)
        if mark is not None:
            comment = line.lstrip().lstrip(mark)
        elif _is_row(row, asked):
            return _layout(Layout(separator, len(row), number), before, comment, asked)
        else:
            before.append((number, line))
    if before and (len(before) > 1 or _has_numbers(before[0][1])):
        number, line = before[0] if _has_numbers(before[0][1]) and not _is_count(before[0][1]) else before[-1]
        raise InputError(f"line {number} is {shown(line)}; expected x y z; is the file cut, or of another format?")
    return None


def _layout(form: Layout, before: list[tuple[int, bytes]], comment: bytes, asked: Asked) -> Layout:
    """The layout with what the lines before the first point say."""
    if before and _is_count(before[-1][1]):
        line, count = before.pop()
        form = replace(form, count=int(count), count_line=line)
    if len(before) > 1:
        number, line = before[1]
        raise InputError(f"line {number} is {shown(line)}; expected one line of headings and then x y z")
    if not before:
        named = _headings(comment, form)
        return replace(form, headings=named) if names_axes(named) else form
    number, line = before[0]
    named = _headings(line, form)
    if named and not asked and (_has_numbers(line) or any(_NUMERIC.fullmatch(each.encode()) for each in named)):
        raise InputError(
            f"line {number} is {shown(line)}, expected x y z, or the headings of {form.width} columns; `columns` "
            "chooses three"
        )
    if named:
        return replace(form, headings=named)
    several = [name(field) for field in fields(line, _separator(line))]
    if names_axes(several):
        raise InputError(
            f"the headings, {shown(line)}, are {len(several)}, but line {form.first_line} has {form.width} columns; "
            "are its commas decimal points? Export it with decimal points, and a heading for each column"
        )
    return replace(form, title=line)


def unquoted(text: bytes) -> bytes:
    """Return a text without quotation marks; within them, separators become _ except those of numbers."""
    if b'"' not in text:
        return text
    return re.sub(rb'"([^"\n]*)"', lambda m: m[1] if _NUMERIC.fullmatch(m[1]) else re.sub(rb"[,;\t]", b"_", m[1]), text)


def fields(line: bytes, separator: bytes | None) -> list[bytes]:
    """Return the fields of a line, without blanks round them."""
    return line.split() if separator is None else [field.strip() for field in line.split(separator)]


def refuse_doubtful_commas(body: bytes, form: Layout) -> None:
    """Raise an InputError if the commas of a text may be separators of thousands as well as decimal points."""
    both = _BOTH.search(body)
    mixed = both or _POINT.search(body)
    if mixed:
        line = body.count(b"\n", 0, mixed.start()) + 1
        raise InputError(
            f"line {line}: {shown(mixed[0])}: commas and points are both used in numbers, so that it cannot be told "
            "which is the decimal one; export it with decimal points and without separators of thousands"
        )
    if not _DECIMAL.search(body):
        raise InputError(
            f"line {form.first_line}: each comma has three digits behind it, so that it cannot be told whether it is a "
            "decimal point or separates thousands; export it with decimal points"
        )


def _headings(line: bytes, form: Layout) -> tuple[str, ...]:
    """The headings on a line, one for each column; empty if there are more or fewer."""
    for separator in (form.separator, b",", b";", b"\t", None):
        joined = re.sub(rb"\s+(?=[\[(])", b"", line) if separator is None else line  # X [m]
        named = fields(joined, separator)
        if len(named) == form.width:
            return tuple(name(field) for field in named)
    return ()


def _separator(line: bytes) -> bytes | None:
    for separator in (b"\t", b";"):
        if line.count(separator) >= 2:
            return separator
    if line.count(b",") >= 2:
        words = line.split()
        if len(words) >= 3 and all(_is_number(word) for word in words):
            return None  # decimal commas between blanks
        return b","
    return None


def _is_row(row: list[bytes], asked: Asked) -> bool:
    """Whether the fields of a line are those of a point: numbers where they are asked for, or three anywhere."""
    numbers = [_is_number(field) or not field for field in row]
    if asked and all(isinstance(each, int) and each <= len(row) for each in asked):
        return any(row) and all(numbers[int(each) - 1] for each in asked)
    return any(row) and sum(numbers) >= 3


def _is_number(field: bytes) -> bool:
    return is_number(field) or bool(_WITH_COMMA.fullmatch(field))


def _has_numbers(line: bytes) -> bool:
    return any(field and _is_number(field) for field in fields(line, _separator(line)))


def _is_count(line: bytes) -> bool:
    return line.strip().isdigit()
