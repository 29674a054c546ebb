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


def _step(data: bytes) -> None:
    if data[:2] in (b"\x1f\x8b", b"PK"):
        raise InputError("a packed STEP file; unpack it with gzip or unzip")
    if b"ISO-10303-21" not in data[:2000]:
        raise InputError("not a STEP file: it does not begin with `ISO-10303-21`")
    if b"END-ISO-10303-21" not in data[-_LAST:]:
        raise InputError("cut: it does not end with `END-ISO-10303-21;`")


_CHECKS = {".step": _step, ".stp": _step}
