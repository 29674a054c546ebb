"""Reading STL, binary and text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.content import Content, RawBody, Source
from hognose.scene.imports.joining import joined
from hognose.scene.imports.numeric_text import is_number, name, not_a_number, plain, shown

Floats = NDArray[np.float64]

#: Bytes of text that are cut into words at a time.
_CHUNK = 1 << 22
#: A letter for each word of a facet, and one for all others, as a rule numbers: the grammar of facets is an expression.
_CODES = {
    b"facet": ord("F"), b"normal": ord("N"), b"outer": ord("O"), b"loop": ord("L"), b"vertex": ord("V"),
    b"endloop": ord("X"), b"endfacet": ord("Y"), b"end": ord("E"),
}  # fmt: skip
_OTHER = ord("n")
#: The words of a facet; normals are not read, since some are not even numbers.
_FACET = b"facet normal * * * outer loop vertex * * * vertex * * * vertex * * * endloop endfacet".replace(
    b"*", b""
).split(b" ")
_FACETS = re.compile(rb"(?:F(?:Nnnn)?OL(?:Vnnn){3}(?:X|EL)(?:Y|EF))*")
_MORE_CORNERS = re.compile(rb"F(?:Nnnn)?OL(?:Vnnn){4}")
_LONGEST_FACET = 24  # words
_LETTER = re.compile(rb"\S")
_FACET_BEGINS = re.compile(rb"(?<!\S)facet\s+(?:normal|outer)(?!\S)")
_AFTER_NAME = re.compile(_FACET_BEGINS.pattern + rb"|(?<!\S)end\s*solid(?!\S)")


def read(source: Source) -> Content:
    """Return the content of an STL file; the solids of a text are bodies, unless they are parts of one surface.

    Raises
    ------
    InputError
        It is cut, holds more than it says, or is not what it should be.
    """
    if is_binary(source.data):
        return _binary(source.data)
    bodies = list(_solids(plain(source.data)))
    whole, notes = joined([body for body in bodies if len(body.faces)], "solids")
    return Content(whole, notes=notes)


def is_binary(data: bytes) -> bool:
    """Whether an STL file is a binary one; its first bytes do not tell, since those of some begin with "solid"."""
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return True
    begin = data[:1000].lower()
    if begin[:2] in (b"\xff\xfe", b"\xfe\xff"):  # UTF-16
        return False
    text = begin.removeprefix(b"\xef\xbb\xbf").lstrip()
    return not text.startswith(b"solid") or (b"\0" in begin and b"facet" not in begin)


def _binary(data: bytes) -> Content:
    if len(data) < 84:
        raise InputError("not an STL file, or one that was cut: it ends within its header")
    said, there = int.from_bytes(data[80:84], "little"), (len(data) - 84) // 50
    if said > there:
        raise InputError(
            f"not an STL file, or one that was cut: it says it has {said:,} triangles, and ends after {there:,}"
        )
    if said < there:
        raise InputError(f"damaged: it says it has {said:,} triangles, but goes on for {there:,}; export it again")
    left = len(data) - 84 - 50 * said
    notes = (f"{left} bytes after the last triangle left out",) if left else ()
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    with np.errstate(invalid="ignore"):  # numbers that signal are refused with the others that are not finite
        corners = np.frombuffer(data, row, said, 84)["corners"].astype(np.float64).reshape(-1, 3)
    body = RawBody("", corners, np.arange(3 * said).reshape(-1, 3))
    return Content((body,) if said else (), notes=notes)


def _solids(text: bytes) -> Iterator[RawBody]:
    lower = text.lower()  # as long as the text: only ASCII letters change
    at = 0
    while found := _LETTER.search(text, at):
        begin = found.start()
        if not lower.startswith(b"solid", begin):
            junk = text[begin : begin + 60].split(b"\n")[0]
            raise InputError(
                f"line {_line(text, begin)} is {shown(junk)}, expected `solid`: damaged, or not an STL file"
            )
        called, first = _named(text, lower, begin + 5)
        end, at = _end(lower, first)
        corners = _corners(lower, first, end)
        yield RawBody(name(called), corners, np.arange(len(corners)).reshape(-1, 3))


def _named(text: bytes, lower: bytes, begin: int) -> tuple[bytes, int]:
    """The name of a solid, and where its facets begin: on the next line, or after the name on the same one."""
    end = lower.find(b"\n", begin)
    end = len(lower) if end < 0 else end
    here = _AFTER_NAME.search(lower, begin, end)
    end = here.start() if here else end
    return text[begin:end], end


def _end(lower: bytes, first: int) -> tuple[int, int]:
    """Where the facets of a solid end, and where what follows the line of its `endsolid` begins."""
    word = lower.find(b"solid", first)
    before = lower[max(first, word - 80) : max(word, first)].rstrip()
    if word < 0 or not before.endswith(b"end"):
        where = f"line {_line(lower, word)} begins another solid before it" if word >= 0 else "it does not end with it"
        raise InputError(f"cut, or not an STL file: `endsolid` is missing, {where}; export it again")
    line = lower.find(b"\n", word)
    line = len(lower) if line < 0 else line
    if _FACET_BEGINS.search(lower, word, line):
        raise InputError(
            f"line {_line(lower, word)} goes on after `endsolid`; expected the next solid on a line of its own"
        )
    return max(first, word - 80) + len(before) - 3, line


def _corners(lower: bytes, begin: int, end: int) -> Floats:
    """The corners (3 m, 3) of the facets between two places of a text."""
    found, held, passed, at = [np.empty((0, 3))], [], 0, begin
    if lower.find(b"_", begin, end) >= 0:  # which Python takes between digits
        raise InputError(f"line {_line(lower, lower.find(b'_', begin, end))} holds _, which is in no number: damaged?")
    while at < end:
        stop = _blank_before(lower, at, end)
        words = held + lower[at:stop].split()
        numbers, used = _regular(words) or _parsed(words)
        if len(words) - used > _LONGEST_FACET or (stop == end and used < len(words)):
            raise _no_facet(words[used : used + _LONGEST_FACET], _line_of_word(lower, begin, end, passed + used))
        try:
            found.append(np.array(numbers, np.float64).reshape(-1, 3))
        except ValueError:
            wrong = next(number for number in numbers if not is_number(number))
            word = next(k for k in range(used) if words[k] is wrong)
            raise not_a_number(wrong, _line_of_word(lower, begin, end, passed + word)) from None
        held, passed, at = words[used:], passed + used, stop
    return np.concatenate(found)


def _regular(words: list[bytes]) -> tuple[list[bytes], int] | None:
    """The coordinates among the words of facets as all programs write them, and how many words those are; else None."""
    facets = len(words) // len(_FACET)
    used = facets * len(_FACET)
    if not all(words[k : used : len(_FACET)] == [word] * facets for k, word in enumerate(_FACET) if word):
        return None
    numbers = [b""] * (9 * facets)
    for place, k in enumerate((8, 9, 10, 12, 13, 14, 16, 17, 18)):
        numbers[place::9] = words[k : used : len(_FACET)]
    return numbers, used


def _parsed(words: list[bytes]) -> tuple[list[bytes], int]:
    """The same for facets without normals, or with `end loop` in two words."""
    codes = bytes(map(_CODES.get, words, repeat(_OTHER)))
    match = _FACETS.match(codes)
    used = match.end() if match else 0
    vertex = np.flatnonzero(np.frombuffer(codes[:used], np.uint8) == _CODES[b"vertex"])
    return [words[k] for k in (vertex[:, None] + [1, 2, 3]).reshape(-1).tolist()], used


def _no_facet(words: list[bytes], line: int) -> InputError:
    if _MORE_CORNERS.match(bytes(map(_CODES.get, words, repeat(_OTHER)))):
        return InputError(f"line {line}: a facet of more than three corners; STL files hold triangles only")
    rest = b" ".join(words[:5])
    return InputError(f"line {line}: {shown(rest)} is not the begin of a whole facet; is the file cut or damaged?")


def _blank_before(text: bytes, at: int, end: int) -> int:
    """Where a chunk from `at` on can be cut without cutting a word."""
    stop = at + _CHUNK
    if stop >= end:
        return end
    cut = max(text.rfind(blank, at + 1, stop) for blank in (b"\n", b" ", b"\t"))
    return end if cut < 0 else cut


def _line(text: bytes, place: int) -> int:
    return text.count(b"\n", 0, place) + 1


def _line_of_word(text: bytes, begin: int, end: int, number: int) -> int:
    """The line that a word is on, counted from `begin`."""
    line = _line(text, begin)
    for each in text[begin:end].split(b"\n"):
        number -= len(each.split())
        if number < 0:
            break
        line += 1
    return line
