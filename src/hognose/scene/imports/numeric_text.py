"""Text of files and the numbers in it: each row with its line, so that a message can tell where."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError

#: Bytes that are taken apart at a time; the rest of a large file waits as it is.
_CHUNK = 1 << 24
_MARKS = ((b"\xff\xfe\0\0", "utf-32"), (b"\0\0\xfe\xff", "utf-32"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_WITH_COMMA = re.compile(rb"[+-]?\d*,\d+([eE][+-]?\d+)?")


def plain(data: bytes) -> bytes:
    """Return text as UTF-8 (or whatever it was of one byte a letter), without its mark, with lines that end in LF.

    Raises
    ------
    InputError
        There is a NUL in it, or it is UTF-16 and cut within a letter.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            try:
                data = data.decode(encoding).encode()
            except UnicodeError:
                raise InputError(
                    f"damaged or cut: it begins as {encoding.upper()}, but is not; save it as UTF-8"
                ) from None
            break
    nul = data.find(b"\0")
    if nul >= 0:
        line = len(re.findall(rb"\r\n?|\n", data[:nul])) + 1
        raise InputError(
            f"not a text file, or a damaged one: line {line} holds a NUL byte; expected text (if it is UTF-16, save it "
            "as UTF-8)"
        )
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def name(text: bytes) -> str:
    """Return a name from a file, whatever it is encoded in."""
    try:
        return text.decode().strip()
    except UnicodeDecodeError:
        return text.decode("latin-1").strip()


def shown(text: bytes) -> str:
    """Return some of the text of a file for a message, in quotes."""
    text = text.strip()
    return repr(name(text[:40]) + ("…" if len(text) > 40 else ""))


@dataclass(frozen=True, eq=False)
class Rows:
    """The numbers of a text.

    Attributes
    ----------
    numbers : (n,)
        All of them, in order.
    ends : (r,)
        Where each row, a line that is not blank, ends among them.
    lines : (r,)
        The line each row is on, from 1.
    """

    numbers: NDArray[np.float64]
    ends: NDArray[np.int64]
    lines: NDArray[np.int64]

    @property
    def begins(self) -> NDArray[np.int64]:
        """Where each row begins among the numbers, (r,)."""
        return np.append(0, self.ends)[:-1]

    def line_of(self, number: int) -> int:
        """The line that the number of an index is on; the last one for an index behind all."""
        row = int(np.searchsorted(self.ends, number, side="right"))
        return int(self.lines[min(row, len(self.lines) - 1)]) if len(self.lines) else 1


def rows(text: bytes, first_line: int = 1) -> Rows:
    """Return the numbers of a text between white space; its first line is number `first_line` of the file.

    Raises
    ------
    InputError
        Something is not a number; tells its line.
    """
    numbers, ends, lines = [np.empty(0)], [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    held, line = 0, first_line
    for piece in chunks(text):
        fields = fields_per_line(piece)
        numbers.append(_numbers(piece, line))
        used = np.flatnonzero(fields)
        ends.append(held + np.cumsum(fields[used]))
        lines.append(line + used)
        held += len(numbers[-1])
        line += len(fields)
    return Rows(np.concatenate(numbers), np.concatenate(ends), np.concatenate(lines))


def chunks(text: bytes) -> Iterator[bytes]:
    """Cut a text into pieces of whole lines; only the last may lack its LF."""
    begin = 0
    while begin < len(text):
        end = text.rfind(b"\n", begin, begin + _CHUNK) + 1
        if end <= begin:
            end = (text.find(b"\n", begin) + 1) or len(text)
        yield text[begin:end]
        begin = end


def fields_per_line(piece: bytes) -> NDArray[np.int64]:
    """Return how many fields between white space each line has, (lines,)."""
    raw = np.frombuffer(piece, np.uint8)
    space = (raw == 32) | ((raw >= 9) & (raw <= 13))  # as bytes.split has it
    begins = np.flatnonzero(~space & np.append(True, space[:-1]))
    return np.diff(np.searchsorted(begins, _line_ends(raw)), prepend=0)


def per_line(piece: bytes, separator: bytes) -> NDArray[np.int64]:
    """Return how often a letter is on each line, (lines,)."""
    raw = np.frombuffer(piece, np.uint8)
    found = np.flatnonzero(raw == separator[0])
    return np.diff(np.searchsorted(found, _line_ends(raw)), prepend=0)


def _line_ends(raw: NDArray[np.uint8]) -> NDArray[np.int64]:
    breaks = np.flatnonzero(raw == 10)
    return breaks if len(raw) and raw[-1] == 10 else np.append(breaks, len(raw))


def _numbers(piece: bytes, line: int) -> NDArray[np.float64]:
    fields = piece.split()
    try:
        if b"_" in piece:  # which Python takes between digits
            raise ValueError
        return np.array(fields, np.float64)
    except ValueError:
        for number, each in enumerate(piece.split(b"\n"), line):
            for field in each.split():
                if not is_number(field):
                    raise not_a_number(field, number) from None
        raise


def is_number(field: bytes) -> bool:
    """Return whether a field is a number as files have it; NaN and infinity are."""
    try:
        float(field)
    except ValueError:
        return False
    return b"_" not in field


def not_a_number(field: bytes, line: int) -> InputError:
    """Return the error for a field that should be a number."""
    if _WITH_COMMA.fullmatch(field):
        return InputError(f"line {line}: {shown(field)} is written with a decimal comma; export it with decimal points")
    return InputError(f"line {line}: {shown(field)} is not a number; is the file cut, damaged, or of another format?")


def whole(numbers: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Return numbers as whole ones, or None if one is not."""
    fit = np.abs(numbers) < 2.0**53
    if not fit.all() or (numbers != np.floor(numbers)).any():
        return None
    return numbers.astype(np.int64)
