"""The text of an array of rows of numbers, changed row by row, so that comments stay beside their rows."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher

Row = Sequence[str]

_COMMENT_AFTER = re.compile(r"(,?)( +)(#[^\n]*)")


@dataclass(frozen=True)
class _Line:
    """A row in the text: what comes before it, itself, and what comes behind it on its line."""

    before: str
    row: str
    behind: str

    @property
    def values(self) -> tuple[float, ...]:
        """The numbers."""
        return tuple(float(word.replace("_", "")) for word in _words(self.row))


def array_of_rows(text: str, rows: Sequence[Row]) -> str:
    """An array that holds some rows.

    Parameters
    ----------
    text
        The array before, or "" for a new one. Rows that stay keep their lines as they are, and changed ones their
        comments.
    rows
        Numbers as they are to be written.
    """
    lines, end = _lines(text)
    if not lines or ("\n" not in text and "#" not in text):
        return _fresh(rows, bool(lines))
    made = []
    old, new = [line.values for line in lines], [tuple(map(float, row)) for row in rows]
    for what, i, past_i, j, past_j in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if what == "equal":
            made += lines[i:past_i]
            continue
        both = min(past_i - i, past_j - j)
        made += [_changed(line, row) for line, row in zip(lines[i : i + both], rows[j : j + both], strict=True)]
        made += [_added(lines[0], row) for row in rows[j + both : past_j]]
    made = [line if line.behind.lstrip().startswith(",") else _with_comma(line) for line in made[:-1]] + made[-1:]
    return "[" + "".join(line.before + line.row + line.behind for line in made) + end


def _fresh(rows: Sequence[Row], flat: bool) -> str:
    made = [f"[{', '.join(row)}]" for row in rows]
    if flat:
        return f"[{', '.join(made)}]"
    return "[\n" + "".join(f"  {row},\n" for row in made) + "]"


def _changed(line: _Line, row: Row) -> _Line:
    """The line with another row; numbers that stay are written as before, and a comment keeps its column."""
    words = _words(line.row)
    if "#" in line.row or len(words) != len(row):
        made = f"[{', '.join(row)}]"
    else:
        kept = [old if float(old.replace("_", "")) == float(new) else new for old, new in zip(words, row, strict=True)]
        parts = re.split(r"[^\s,\[\]]+", line.row)
        made = parts[0] + "".join(word + part for word, part in zip(kept, parts[1:], strict=True))

    def moved(found: re.Match[str]) -> str:
        spaces = max(1, len(found[2]) + len(line.row) - len(made))
        return found[1] + " " * spaces + found[3]

    return replace(line, row=made, behind=_COMMENT_AFTER.sub(moved, line.behind, count=1))


def _added(like: _Line, row: Row) -> _Line:
    indent = like.before.rpartition("\n")[2]
    indent = indent if not indent.strip() else "  "
    return _Line(indent, f"[{', '.join(row)}]", ",\n")


def _with_comma(line: _Line) -> _Line:
    return replace(line, behind="," + line.behind)


def _words(row: str) -> list[str]:
    return re.findall(r"[^\s,\[\]]+", re.sub(r"#[^\n]*", "", row))


def _lines(text: str) -> tuple[list[_Line], str]:
    """The rows of an array's text, and what is left behind the last one."""
    lines: list[_Line] = []
    begin = at = 1

    def gap(past: int) -> str:
        """What stands before the next row; a comma in it is moved behind the row before."""
        found = re.match(r"((?:#[^\n]*|[^#,])*),", text[begin:past])
        if found is None or not lines:
            return text[begin:past]
        lines[-1] = _with_comma(lines[-1])
        return found[1] + text[begin + found.end() : past]

    while at < len(text):
        if text[at] == "#":
            at = _end_of_line(text, at)
        elif text[at] == "[":
            past = _past_row(text, at)
            rest = re.compile(r"[^\S\n]*,?[^\S\n]*(#[^\n]*)?\n?").match(text, past)
            # What follows on the same line belongs to the row, unless that is another row or the end.
            after = past if rest is None else rest.end()
            lines.append(_Line(gap(at), text[at:past], text[past:after]))
            begin = at = after
        else:
            at += 1
    return lines, gap(len(text))


def _past_row(text: str, at: int) -> int:
    while text[at] != "]":
        at = _end_of_line(text, at) if text[at] == "#" else at + 1
    return at + 1


def _end_of_line(text: str, at: int) -> int:
    found = text.find("\n", at)
    return len(text) if found < 0 else found
