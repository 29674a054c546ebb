"""What a format of exports is."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from hognose.errors import InputError
from hognose.planning.plan import Plan


@dataclass(frozen=True)
class Export:
    """A format that plans are exported in.

    Attributes
    ----------
    suffix
        Of its files, as in ".csv": small letters and digits after one dot.
    what
        What such a file holds, in a line without its end.
    write
        The content of a file, from a plan that was verified only just now.
    """

    suffix: str
    what: str
    write: Callable[[Plan], bytes]

    def __post_init__(self) -> None:
        if not isinstance(self.suffix, str) or not re.fullmatch(r"\.[a-z0-9]{1,20}", self.suffix):
            raise InputError(f"suffix: expected a dot and small letters, as in '.csv', got {self.suffix!r:.60}")
        if not callable(self.write):
            raise InputError(f"write: expected a function from a plan to bytes, got {type(self.write).__name__}")
