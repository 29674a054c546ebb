"""The errors Hognose raises.

Every message says what is wrong, where, what was expected and what to try; the command line prints it as
it stands, without a traceback.
"""

from __future__ import annotations

from typing import Any


class HognoseError(Exception):
    """The root of all errors that Hognose raises on purpose."""


class InputError(HognoseError, ValueError):
    """A file, an argument or a combination of them is wrong; nothing was computed (exit code 2)."""


class InfeasibleError(HognoseError):
    """The input is sound, but no good motion exists or was found for it (exit code 1).

    Attributes
    ----------
    plan
        The plan as far as it could be made, so that it can be looked at, or None. It is a
        `hognose.Plan`; its failed checks say what is wrong and where.
    """

    def __init__(self, message: str, plan: Any = None) -> None:
        super().__init__(message)
        self.plan = plan


class MissingExtraError(HognoseError, ImportError):
    """An optional part is used whose packages are not installed."""
