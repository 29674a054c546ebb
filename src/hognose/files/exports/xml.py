"""Models as XML: numbers that read back bit for bit, and names and comments that any reader takes."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike

Element = ElementTree.Element

#: Characters that no XML may have, not even written as a number.
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
_WIDTH = 110


def numbers(values: ArrayLike) -> str:
    """Numbers with a space between them; they read back bit for bit, but for the sign of zero."""
    return " ".join(map(repr, (np.asarray(values, np.float64).ravel() + 0.0).tolist()))


def integers(values: ArrayLike) -> str:
    """Whole numbers with a space between them."""
    return " ".join(map(str, np.asarray(values).ravel().tolist()))


def element(parent: Element | None, tag: str, **attributes: Any) -> Element:
    """A new element below a parent; attributes are texts, numbers or arrays of them, and None is left out.

    A `_` at the end of a name, which a word of Python needs, is taken away.
    """
    texts = {
        name.rstrip("_"): text(value) if isinstance(value, str) else numbers(value)
        for name, value in attributes.items()
        if value is not None
    }
    return Element(tag, texts) if parent is None else ElementTree.SubElement(parent, tag, texts)


def comment(parent: Element, paragraphs: Sequence[str]) -> None:
    """A comment of some paragraphs."""
    lines = [line for paragraph in paragraphs for line in textwrap.wrap(text(paragraph), _WIDTH)]
    inside = "\n    ".join(lines)
    while "--" in inside:
        inside = inside.replace("--", "- -")
    parent.append(ElementTree.Comment(f"\n    {inside}\n  "))


def text(given: str) -> str:
    """A text without the characters that XML forbids."""
    return _FORBIDDEN.sub("\ufffd", given)


def distinct(names: Iterable[str]) -> list[str]:
    """The same names, those that come again with a number behind them."""
    out: list[str] = []
    for name in map(text, names):
        number, new = 2, name
        while new in out:
            number, new = number + 1, f"{name} ({number})"
        out.append(new)
    return out


def document(root: Element) -> bytes:
    """The whole file."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"
