"""The header of a PLY file: which elements it has, and what each of their rows holds."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hognose.errors import InputError
from hognose.scene.imports.numeric_text import shown

#: Types of numbers, by their names in files, as NumPy has them without the order of bytes.
TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_END = re.compile(rb"^[ \t]*end_header[ \t]*(\r\n|\n|\r|\Z)", re.MULTILINE)
_OLD_END = re.compile(rb"(?<=\r)[ \t]*end_header[ \t]*(\r|\Z)")


@dataclass(frozen=True)
class Property:
    """One column of an element: its name, the type of its numbers, and that of their count if it is a list."""

    name: str
    type: str
    count: str | None = None


@dataclass(frozen=True)
class Element:
    """A table of the file: its name, how many rows it has, and their properties."""

    name: str
    rows: int
    properties: tuple[Property, ...]

    def index(self, *names: str) -> int | None:
        """The place of the first property called one of these, or None."""
        return next((k for k, each in enumerate(self.properties) if each.name.lower() in names), None)


@dataclass(frozen=True)
class Header:
    """What a header says.

    Attributes
    ----------
    order
        Of the bytes: "<" or ">", or empty for a text.
    elements
        In the order of the file.
    begin
        Where the rows begin in the file.
    lines
        How many lines the header has.
    """

    order: str
    elements: tuple[Element, ...]
    begin: int
    lines: int


def header(data: bytes) -> Header:
    """Return the header of a PLY file.

    Raises
    ------
    InputError
        It is cut, or a line is not what it should be; tells its number.
    """
    magic = re.match(rb"ply[ \t]*(\r\n|\n|\r)", data)
    if magic is None:
        raise InputError("not a PLY file: it does not begin with a line `ply`")
    end = (_OLD_END if magic[1] == b"\r" else _END).search(data)  # a binary one may go on with what looks like an LF
    if end is None:
        raise InputError("cut, or not a PLY file: its header has no `end_header`")
    lines = re.split(rb"\r\n|\n|\r", data[: end.start()])
    elements: list[tuple[str, int, list[Property]]] = []
    order = None
    for number, line in enumerate(lines[1:], 2):
        words = line.decode("latin-1").split()
        match [word.lower() for word in words[:1]] + words[1:]:
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", str(form), _] if form in _ORDERS:
                order = _ORDERS[form]
            case ["element", str(name), str(count)] if count.isascii() and count.isdigit() and len(count) < 16:
                elements.append((name, int(count), []))
            case ["property", "list", str(count), str(kind), str(name)] if elements and {count, kind} <= TYPES.keys():
                elements[-1][2].append(Property(name, TYPES[kind], TYPES[count]))
            case ["property", str(kind), str(name)] if elements and kind in TYPES:
                elements[-1][2].append(Property(name, TYPES[kind]))
            case _:
                raise InputError(
                    f"line {number} of its header is {shown(line)}, expected `format`, `element NAME COUNT`, "
                    "`property TYPE NAME`, `property list TYPE TYPE NAME` or `comment`: damaged, or not a PLY file"
                )
    if order is None:
        raise InputError("damaged: its header has no line `format` with ascii or binary")
    begin = end.end()
    return Header(order, tuple(Element(name, rows, tuple(each)) for name, rows, each in elements), begin, len(lines))
