"""What a STEP file says it holds, read from its text: how many faces, and what OpenCASCADE says nothing of."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from hognose.errors import InputError

_FACES = {b"ADVANCED_FACE", b"FACE_SURFACE", b"FACE"}
_ALIASES = {b"ORIENTED_FACE", b"SUBFACE"}
_CLOSED = {b"CLOSED_SHELL"}
_OPEN = {b"OPEN_SHELL", b"CONNECTED_FACE_SET", b"CONNECTED_FACE_SUB_SET"}
#: Surfaces that are shapes of their own, without a face.
_LOOSE_SURFACES = {b"CURVE_BOUNDED_SURFACE", b"RECTANGULAR_TRIMMED_SURFACE"}
#: Shapes that OpenCASCADE does not make triangles of.
_NOT_MADE = {
    b"CSG_SOLID", b"BOOLEAN_RESULT", b"BLOCK", b"RIGHT_CIRCULAR_CYLINDER", b"RIGHT_CIRCULAR_CONE",
    b"RIGHT_ANGULAR_WEDGE", b"SPHERE", b"TORUS", b"EXTRUDED_AREA_SOLID", b"REVOLVED_AREA_SOLID", b"EXTRUDED_FACE_SOLID",
    b"REVOLVED_FACE_SOLID", b"SWEPT_DISK_SOLID", b"HALF_SPACE_SOLID", b"BOXED_HALF_SPACE",
}  # fmt: skip
_TESSELLATED = {b"TRIANGULATED_FACE", b"COMPLEX_TRIANGULATED_FACE", b"TRIANGULATED_SURFACE_SET",
                b"COMPLEX_TRIANGULATED_SURFACE_SET"}  # fmt: skip
#: Drawn beside the shape: dimensions and notes, whose letters may be triangles.
_DRAWN = {b"TESSELLATED_ANNOTATION_OCCURRENCE", b"ANNOTATION_OCCURRENCE"}
_SETS = {b"TESSELLATED_GEOMETRIC_SET", b"REPOSITIONED_TESSELLATED_GEOMETRIC_SET"}
_DOCUMENTS = {b"DOCUMENT_FILE"}
#: That one product is a part of another one, at a place.
_PLACED = {b"NEXT_ASSEMBLY_USAGE_OCCURRENCE"}
_WANTED = (_FACES | _ALIASES | _CLOSED | _OPEN | _LOOSE_SURFACES | _NOT_MADE | _TESSELLATED | _DRAWN | _SETS
           | _DOCUMENTS | _PLACED)  # fmt: skip

# Nothing is tried in two ways, and what is not closed goes on to the end, so that no text can take long.
_QUOTED = rb"'[^']*+'?|/\*(?:[^*]++|\*(?!/))*+(?:\*/)?"
# An instance, or what stands between them.
_INSTANCE = re.compile(
    rb"#(\d{1,18})\s*+=\s*+((?:[^;'/]++|" + _QUOTED + rb"|/)*+)|DATA\s*+\((?:[^;']++|'[^']*+')*+|" + _QUOTED
)
# Where the instances begin, what may stand between two of them, and a string that was never closed.
_DATA = re.compile(rb"\bENDSEC\s*+;\s*+(?:/\*(?:[^*]++|\*(?!/))*+\*/\s*+)*+(?=DATA\s*+[;(])")
_BETWEEN = re.compile(rb"(?:[\s;]++|ENDSEC\b|DATA\b)*+")
_OVERRUN = re.compile(rb";\s*+#\d++\s*+=\s*+[A-Z(]")
_STRING_OR_COMMENT = re.compile(_QUOTED)
_STRING = re.compile(rb"'((?:[^']++|'')*+)'")
_KEYWORD = re.compile(rb"(?<![A-Z0-9_])([A-Z][A-Z0-9_]*+)\s*+\(")
_REFERENCE = re.compile(rb"#(\d{1,18})")
# What the third edition of part 21 has before the data: names of instances in other files.
_SECTION = re.compile(rb"\bREFERENCE\s*+;")
_ADDRESS = re.compile(rb"<([^<>#]++)")


@dataclass(frozen=True)
class StepText:
    """What the text of a STEP file says.

    Attributes
    ----------
    faces
        How many faces it has, each counted once, however often its part is used.
    closed
        Whether all that it has are faces of closed shells.
    tessellated
        How many faces it has as triangles, without a surface.
    not_made
        Kinds of solids in it that OpenCASCADE makes nothing of.
    places
        How often a product is a part of another one, counted at every place of that.
    documents
        Names of other files that it refers to.
    says_unit
        Whether it names a unit of length.
    """

    faces: int
    closed: bool
    tessellated: int
    not_made: tuple[str, ...]
    places: int
    documents: tuple[str, ...]
    says_unit: bool


def step_text(data: bytes) -> StepText:
    """Return what a STEP file says it holds.

    Raises
    ------
    InputError
        It has no data section, text that is no instance in it, or a product that is a part of itself.
    """
    if b"DATA" not in data:
        raise InputError("not a STEP file, or one that was cut: it has no DATA section; export it again")
    found: dict[bytes, set[int]] = {kind: set() for kind in _WANTED}
    in_shells: dict[bool, set[int]] = {True: set(), False: set()}
    aliases: dict[int, int] = {}
    sets: dict[int, list[int]] = {}
    drawn: set[int] = set()
    documents = _addresses(data)
    parts: list[tuple[int, int]] = []
    for match in _instances(data):
        number, text = int(match[1]), match[2]
        for kind in _kinds(text) & _WANTED:
            found[kind].add(number)
            if kind in _CLOSED | _OPEN:
                in_shells[kind in _CLOSED].update(_references(text))
            elif kind in _ALIASES:
                aliases[number] = next(iter(_references(text)), number)
            elif kind in _PLACED and len(references := _references(text)) >= 2:
                parts.append((references[0], references[1]))
            elif kind in _SETS:
                sets[number] = _references(text)
            elif kind in _DRAWN:
                drawn.update(_references(text))
            elif kind in _DOCUMENTS:
                documents.append(_first_string(text))
    closed, opened = ({aliases.get(k, k) for k in in_shells[way]} for way in (True, False))
    faces = closed | opened
    for kind in _FACES | _LOOSE_SURFACES:
        faces |= found[kind]
    in_drawings = {k for number in drawn for k in (number, *sets.get(number, ()))}
    tessellated = {k for kind in _TESSELLATED for k in found[kind]} - in_drawings
    return StepText(
        faces=len(faces),
        closed=bool(faces) and faces <= closed and not tessellated,
        tessellated=len(tessellated),
        not_made=tuple(sorted(kind.decode() for kind in _NOT_MADE if found[kind])),
        places=_places(parts),
        documents=tuple(dict.fromkeys(name for name in documents if name.strip())),
        says_unit=b"LENGTH_UNIT" in data,
    )


def _instances(data: bytes) -> Iterator[re.Match[bytes]]:
    """The instances, one after the other; a slip in one would hide others, so that nothing else may stand there."""
    start = _DATA.search(data)
    begin, strict = (start.end(), True) if start else (0, False)
    for match in _INSTANCE.finditer(data, begin):
        if strict:
            gap = data[begin : match.start()]
            if b"END-ISO-10303-21" in gap:
                return
            overrun = b";" in match[0] and any(
                text[:1] == b"'" and _OVERRUN.search(text) for text in _STRING_OR_COMMENT.findall(match[0])
            )
            if not _BETWEEN.fullmatch(gap) or overrun or match[0][:1] == b"'":
                line = data.count(b"\n", 0, begin) + 1
                raise InputError(
                    f"damaged at line {line:,} or after: there is something that is no entity; export it again"
                )
            begin = match.end()
        if match[1] is not None:
            yield match


def _kinds(text: bytes) -> set[bytes]:
    """The types of an instance; a complex one has several."""
    text = text.lstrip()
    if text[:1] not in (b"(", b"/"):
        return {text.partition(b"(")[0].rstrip()}
    return set(_KEYWORD.findall(_bare(text)))


def _references(text: bytes) -> list[int]:
    return [int(number) for number in _REFERENCE.findall(_bare(text))]


def _bare(text: bytes) -> bytes:
    """Without its strings and comments."""
    return _STRING_OR_COMMENT.sub(b"", text)


def _places(parts: list[tuple[int, int]]) -> int:
    """How many places there are, of pairs of a whole and a part of it."""
    within: dict[int, list[int]] = {}
    waiting: Counter[int] = Counter()
    for whole, part in parts:
        within.setdefault(whole, []).append(part)
        waiting[part] += 1
    times = dict.fromkeys((whole for whole in within if not waiting[whole]), 1)
    ready, total, done = list(times), 0, 0
    while ready:
        whole = ready.pop()
        for part in within.get(whole, ()):
            done += 1
            total += times[whole]
            times[part] = times.get(part, 0) + times[whole]
            waiting[part] -= 1
            if not waiting[part]:
                ready.append(part)
    if done < len(parts):
        raise InputError("damaged: a product in it is a part of itself; export it again")
    return total


def _addresses(data: bytes) -> list[str]:
    head = data[: data.find(b"DATA;") + 1]
    found = _SECTION.search(head)
    section = head[found.end() :].partition(b"ENDSEC")[0] if found else b""
    return [name.decode("utf-8", "replace").strip() for name in _ADDRESS.findall(section)]


def _first_string(text: bytes) -> str:
    found = _STRING.search(text)
    return found[1].replace(b"''", b"'").decode("utf-8", "replace") if found else ""
