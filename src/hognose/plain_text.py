"""Text that a terminal shows as it stands: nothing in it moves the cursor, changes colours or turns the line round."""

from __future__ import annotations

import re

#: Control characters but tab and line feed, what separates lines or reverses their direction, and halves of characters.
_COMMANDS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def is_plain(text: str, lines: bool = False) -> bool:
    """Whether a text holds no such character; `lines` says whether it may have several lines and tabs."""
    return _COMMANDS.search(text) is None and (lines or not ("\n" in text or "\t" in text))


def plain(text: str) -> str:
    r"""The text with every such character written out, as in `\x1b`."""
    return _COMMANDS.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)
