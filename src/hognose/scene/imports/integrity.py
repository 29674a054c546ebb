"""Whether a file is whole: formats that say how long they are, or how they end, are held to it.

Readers take a file that was cut for a smaller one, or for an empty one; here it is refused.
"""

from __future__ import annotations

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
    if b"ISO-10303-21" not in data[:2000]:
        raise InputError("not a STEP file: it does not begin with `ISO-10303-21`")
    if b"END-ISO-10303-21" not in data[-_LAST:]:
        raise InputError("cut: it does not end with `END-ISO-10303-21;`")


_CHECKS = {".glb": _glb, ".3mf": _zip, ".step": _step, ".stp": _step}
