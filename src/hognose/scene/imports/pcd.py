"""Reading PCD, the point clouds of PCL: as text, binary, or binary and compressed."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.kernels import kernel
from hognose.scene.imports.columns import axes
from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.numeric_text import is_number, name, plain, rows, shown

_DATA = re.compile(rb"(?mi)^[ \t]*DATA[ \t]+(\w+)[ \t]*(?:\r\n|\n|\Z)")
_KEYS = ("VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS")
_KINDS = {"F4": "<f4", "F8": "<f8"} | {
    f"{letter}{size}": f"<{letter.lower()}{size}" for letter in "IU" for size in (1, 2, 4, 8)
}
_NO_TURN = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]


@dataclass(frozen=True)
class _Header:
    """Fields with the type and the number of the items of each; how many points; and where the sensor was."""

    fields: tuple[str, ...]
    kinds: tuple[np.dtype, ...]
    counts: tuple[int, ...]
    points: int
    viewpoint: tuple[float, ...]

    @property
    def row(self) -> np.dtype:
        """One point of a binary file."""
        each = enumerate(zip(self.kinds, self.counts, strict=True))
        return np.dtype([(str(k), kind, (count,)) for k, (kind, count) in each])


def read(source: Source) -> Content:
    """Return the points of a PCD file, as they are written: its viewpoint, which programs apply or not, is not applied.

    Raises
    ------
    InputError
        It is cut, goes on after its points, or is not what its header says.
    """
    found = _DATA.search(source.data)
    if found is None:
        raise InputError("not a PCD file, or one that was cut: its header has no line `DATA`")
    head = _header(plain(source.data[: found.start()]))
    places = axes(head.fields, source.scan.columns, "fields")
    body, form = source.data[found.end() :], found[1].lower()
    if form == b"ascii":
        points = _text(body, head, places, source.data.count(b"\n", 0, found.end()) + 1)
    elif form == b"binary":
        points = _binary(body, head, places)
    elif form == b"binary_compressed":
        points = _compressed(body, head, places)
    else:
        raise InputError(f"its DATA are {shown(form)}, expected ascii, binary or binary_compressed")
    notes = ("taken as written: its VIEWPOINT is not applied",) if list(head.viewpoint) != _NO_TURN else ()
    return Content(points=points, notes=notes)


def _header(text: bytes) -> _Header:
    said: dict[str, list[bytes]] = {}
    for number, line in enumerate(text.split(b"\n"), 1):
        words = line.split(b"#")[0].split()
        if not words:
            continue
        key = words[0].decode("latin-1").upper()
        if key not in _KEYS or key in said:
            raise InputError(
                f"line {number} is {shown(line)}, expected one of {', '.join(_KEYS)}, each once; is it PCD?"
            )
        said[key] = words[1:]
    names = said.get("FIELDS", said.get("COLUMNS", []))
    sizes, types = said.get("SIZE", []), said.get("TYPE", [])
    kinds = [_KINDS.get((kind + size).decode("latin-1").upper()) for kind, size in zip(types, sizes, strict=False)]
    if not names or not len(names) == len(sizes) == len(types) or None in kinds:
        raise InputError("damaged: FIELDS, SIZE and TYPE of its header do not say one type of number for each field")
    counts = _whole(said.get("COUNT", [b"1"] * len(names)), "COUNT")
    if len(counts) != len(names) or 0 in counts:
        raise InputError("damaged: COUNT of its header does not say one number for each field")
    size = [_whole(said.get(key, [b"1"]), key) for key in ("WIDTH", "HEIGHT")]
    points = _whole(said.get("POINTS", []), "POINTS") if "POINTS" in said else [size[0][0] * size[1][0]]
    if len(points) != 1 or ("WIDTH" in said and size[0][0] * size[1][0] != points[0]):
        raise InputError("damaged: POINTS of its header is not WIDTH times HEIGHT")
    viewpoint = said.get("VIEWPOINT", [b"%g" % number for number in _NO_TURN])
    if len(viewpoint) != 7 or not all(is_number(each) for each in viewpoint):
        raise InputError("damaged: VIEWPOINT of its header is not seven numbers")
    fields, types = tuple(map(name, names)), tuple(np.dtype(kind) for kind in kinds)
    return _Header(fields, types, tuple(counts), points[0], tuple(float(each) for each in viewpoint))


def _whole(words: list[bytes], key: str) -> list[int]:
    if not words or not all(word.isdigit() and len(word) < 13 for word in words):
        raise InputError(f"damaged: {key} of its header is {shown(b' '.join(words))}, expected whole numbers")
    return [int(word) for word in words]


def _text(body: bytes, head: _Header, places: tuple[int, ...], line: int) -> NDArray[np.float64]:
    table = rows(plain(body), line)
    width = sum(head.counts)
    wrong = np.flatnonzero(np.diff(table.ends, prepend=0) != width)
    if wrong.size:
        raise InputError(
            f"line {table.lines[wrong[0]]} has not the {width} numbers that its header says; is the file cut?"
        )
    if len(table.ends) != head.points:
        raise _miscounted(head, len(table.ends))
    begins = np.append(0, np.cumsum(head.counts))
    return table.numbers.reshape(-1, width)[:, [int(begins[k]) for k in places]].copy()


def _miscounted(head: _Header, there: int) -> InputError:
    wrong = "cut" if there < head.points else "damaged"
    return InputError(f"{wrong}: its header says {head.points:,} points, but there are {there:,}")


def _binary(body: bytes, head: _Header, places: tuple[int, ...]) -> NDArray[np.float64]:
    there, left = divmod(len(body), head.row.itemsize)
    if there != head.points or left > 2 or body[len(body) - left :].strip(b"\r\n"):
        raise _miscounted(head, there if there != head.points else there + 1)
    table = np.frombuffer(body, head.row, head.points)
    return np.stack([table[str(k)][:, 0].astype(np.float64) for k in places], axis=1)


def _compressed(body: bytes, head: _Header, places: tuple[int, ...]) -> NDArray[np.float64]:
    sizes = np.frombuffer(body[:8].ljust(8, b"\0"), "<u4")
    packed, size = int(sizes[0]), int(sizes[1])
    if size != head.points * head.row.itemsize:
        raise InputError(
            f"damaged: its header says {head.points:,} points of {head.row.itemsize} bytes, but {size:,} are packed"
        )
    left = body[8 + packed :]
    if len(body) < 8 + packed or left.strip(b"\r\n"):
        raise InputError(f"cut or damaged: it says that {packed:,} bytes are packed, but there are {len(body) - 8:,}")
    if size > 300 * max(packed, 1):  # more than the format can pack
        raise InputError(f"damaged: {packed:,} bytes cannot be {size:,} bytes unpacked")
    whole = np.empty(size, np.uint8)
    if _unpack(np.frombuffer(body, np.uint8, packed, 8), whole) != size:
        raise InputError("damaged: its packed points cannot be unpacked")
    columns, at = [], 0
    begins = np.cumsum([0, *(kind.itemsize * count for kind, count in zip(head.kinds, head.counts, strict=True))])
    for k in places:
        at, kind = int(begins[k]) * head.points, head.kinds[k]
        many = head.counts[k]
        columns.append(whole[at : at + head.points * kind.itemsize * many].view(kind)[::many].astype(np.float64))
    return np.stack(columns, axis=1)


@kernel(error_model="numpy")
def _unpack(packed, whole):
    """Unpack LZF: runs of bytes as they are, and pieces that were there before; return the length, or -1 if damaged."""
    at, to = 0, 0
    while at < len(packed):
        control = packed[at]
        at += 1
        if control < 32:
            length = control + 1
            if at + length > len(packed) or to + length > len(whole):
                return -1
            whole[to : to + length] = packed[at : at + length]
            at += length
        else:
            length = control >> 5
            if length == 7:
                if at >= len(packed):
                    return -1
                length += packed[at]
                at += 1
            length += 2
            if at >= len(packed):
                return -1
            begin = to - ((control & 31) << 8) - packed[at] - 1
            at += 1
            if begin < 0 or to + length > len(whole):
                return -1
            for k in range(length):  # one by one: it may repeat what it has just written
                whole[to + k] = whole[begin + k]
        to += length
    return to
