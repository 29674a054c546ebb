"""What fits on a screen is read: functions and files do not grow beyond it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import hognose

ROOT = Path(hognose.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
FUNCTION, FILE = 60, 350


def compiled(node):
    """Whether a function is a kernel: those may be as long as their loop is."""
    names = (each.func if isinstance(each, ast.Call) else each for each in node.decorator_list)
    return any(isinstance(name, ast.Name) and name.id == "kernel" for name in names)


def lengths(text):
    """Lines of every function that is no kernel, by name; decorators do not count, docstrings do."""
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    return [(node.name, (node.end_lineno or 0) - node.lineno + 1) for node in functions if not compiled(node)]


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_functions_and_files_are_short(file):
    text = file.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= FILE
    assert [each for each in lengths(text) if each[1] > FUNCTION] == []


def test_lengths_are_counted():
    body = "    pass\n" * 60
    text = f"def short():\n{body}@kernel(fastmath=True)\ndef fast():\n{body}@kernel\ndef faster():\n{body}"
    assert lengths(text) == [("short", 61)]
    assert lengths("class A:\n    async def inner(\n        self\n    ):\n        return\n") == [("inner", 4)]
