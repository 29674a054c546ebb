"""What is wrong with the words of a command, in ours."""

from __future__ import annotations

import inspect
from collections.abc import Sequence

from cyclopts import CycloptsError, MissingArgumentError

_COUNTS = {2: "two", 3: "three", 4: "four"}


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
        lines = [f"{name}: expected {_COUNTS.get(count, count)} numbers, got {got or 'none'}"]
    return lines + [f"{option} is missing" for option in required]


def _required(error: CycloptsError) -> list[str]:
    """Options that a command cannot do without."""
    if error.target is None:
        return []
    given = inspect.signature(error.target).parameters.values()
    needed = [each for each in given if each.kind is each.KEYWORD_ONLY and each.default is each.empty]
    return [f"--{each.name.replace('_', '-')}" for each in needed]


def _given(option: str, tokens: Sequence[str]) -> bool:
    return any(token == option or token.startswith(f"{option}=") for token in tokens)
