"""Whether a file is whole: formats that say how long they are, or how they end, are held to it.

Readers take a file that was cut for a smaller one, or for an empty one; here it is refused.
"""

from __future__ import annotations

import re

from hognose.errors import InputError

_LAST = 400  # bytes in which the end of a text file is looked for


def refuse_cut(data: bytes, suffix: str) -> None:
    """Raise an InputError, without the file's name, if the content of a mesh file is cut or something else.

    Parameters
    ----------
    data
        All of the file.
    suffix
        With its dot, in lower case.
    """
    check = _CHECKS.get(suffix)
    if check:
        check(data)


def is_binary_stl(data: bytes) -> bool:
    """Whether an STL file is a binary one; its first bytes do not tell, since those of some begin with "solid"."""
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return True
    return data.lstrip()[:5].lower() != b"solid" or b"\0" in data[:1000]


def _stl(data: bytes) -> None:
    if is_binary_stl(data):
        if len(data) < 84:
            raise InputError("not an STL file, or one that was cut: it ends within its header")
        said, there = int.from_bytes(data[80:84], "little"), (len(data) - 84) // 50
        if said > there:
            raise InputError(
                f"not an STL file, or one that was cut: it says it has {said:,} triangles, and ends after {there:,}"
            )
        if said == 0 and there:
            raise InputError(f"damaged: it says it has no triangles, but goes on for {there:,}; export it again")
    elif b"endsolid" not in data[-_LAST:].lower():
        raise InputError("cut, or not an STL file: it does not end with `endsolid`")


def _ply(data: bytes) -> None:
    if not data.startswith(b"ply"):
        raise InputError("not a PLY file: it does not begin with `ply`")
    head, found, body = data.partition(b"end_header")
    if not found:
        raise InputError("cut, or not a PLY file: its header has no `end_header`")
    if re.search(rb"^\s*format\s+ascii", head, re.MULTILINE):
        said = sum(int(number) for number in re.findall(rb"^\s*element\s+\S+\s+(\d+)", head, re.MULTILINE))
        there = sum(1 for line in body.splitlines() if line.strip())
        if there < said:
            raise InputError(f"cut: its header says {said:,} vertices, faces and others, but there are {there:,}")


def _glb(data: bytes) -> None:
    if data[:4] != b"glTF":
        raise InputError("not a GLB file: it does not begin with `glTF`")
    said = int.from_bytes(data[8:12], "little")
    if len(data) < 20 or said > len(data):
        raise InputError(f"cut: it says it is {said:,} bytes long, but it is {len(data):,}")


def _zip(data: bytes) -> None:
    if data[:2] != b"PK":
        raise InputError("not a 3MF file: it is no ZIP archive")
    if b"PK\x05\x06" not in data[-70_000:]:
        raise InputError("cut: the archive has no end")


def _step(data: bytes) -> None:
    if data[:2] in (b"\x1f\x8b", b"PK"):
        raise InputError("a packed STEP file; unpack it with gzip or unzip")
    if b"ISO-10303-21" not in data[:2000]:
        raise InputError("not a STEP file: it does not begin with `ISO-10303-21`")
    if b"END-ISO-10303-21" not in data[-_LAST:]:
        raise InputError("cut: it does not end with `END-ISO-10303-21;`")


_CHECKS = {".stl": _stl, ".ply": _ply, ".glb": _glb, ".3mf": _zip, ".step": _step, ".stp": _step}
