"""Properties that are computed once, without a lock."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any, TypeVar

Value = TypeVar("Value")


class cached_property(functools.cached_property[Value]):  # noqa: N801
    """As in `functools`, where before Python 3.12 all objects of a class share a lock.

    With it, threads that plan different tasks wait for each other, and in a process that was forked while one of them
    held it nobody ever lets go of it. Two threads that ask the same object at the same time compute the value twice.
    """

    def __init__(self, func: Callable[[Any], Value]) -> None:
        super().__init__(func)
        self.lock = nullcontext()
