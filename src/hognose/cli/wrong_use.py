"""What is wrong with the words of a command, in ours."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any, get_args

from cyclopts import CycloptsError, MissingArgumentError

_COUNTS = {0: "no", 1: "one", 2: "two", 3: "three", 4: "four"}


def told(error: CycloptsError, tokens: Sequence[str]) -> str:
    """A message for people: what is missing or too little by name, all of it, and where help is."""
    chain = error.command_chain or ()
    lines = _lacking(error, tokens) if isinstance(error, MissingArgumentError) else [str(error)]
    return "\n".join([*lines, f"Try: {' '.join(['hognose', *chain, '--help'])}"])


def _lacking(error: MissingArgumentError, tokens: Sequence[str]) -> list[str]:
    assert error.argument is not None
    name, (count, _) = error.keyword or error.argument.name, error.argument.token_count()
    required = [option for option in _required(error) if not _given(option, tokens)]
    if not error.argument.field_info.is_keyword or name in required:
        lines = [] if name in required else [f"{name} is missing"]
    elif count == 1:
        lines = [f"{name}: expected a value, got none"]
    else:
        got = len(error.tokens_so_far) % count
        if _begins_with_name(error.argument.hint, count):
            had = f"a name and {_numbers(got - 1)}" if got else "none"
            lines = [f"{name}: expected a name and {_numbers(count - 1)}, got {had}"]
        else:
            lines = [f"{name}: expected {_numbers(count)}, got {got or 'none'}"]
    return lines + [f"{option} is missing" for option in required]


def _numbers(count: int) -> str:
    """So many numbers, in words."""
    return f"{_COUNTS.get(count, count)} number{'' if count == 1 else 's'}"


def _begins_with_name(hint: Any, count: int) -> bool:
    """Whether a value of so many tokens, of a type or in a list of such, is a name and numbers."""
    kinds = [kind for kind in get_args(hint) if kind is not Ellipsis]
    if len(kinds) == 1 < count:
        return _begins_with_name(kinds[0], count)
    return len(kinds) == count and kinds[0] is str and str not in kinds[1:]


def _required(error: CycloptsError) -> list[str]:
    """Options that a command cannot do without."""
    if error.target is None:
        return []
    given = inspect.signature(error.target).parameters.values()
    needed = [each for each in given if each.kind is each.KEYWORD_ONLY and each.default is each.empty]
    return [f"--{each.name.replace('_', '-')}" for each in needed]


def _given(option: str, tokens: Sequence[str]) -> bool:
    return any(token == option or token.startswith(f"{option}=") for token in tokens)
