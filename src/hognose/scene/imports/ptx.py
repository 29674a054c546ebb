"""Reading PTX: scans as text, each with the place of its scanner."""

from __future__ import annotations

import re

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import Content
from hognose.scene.imports.numeric_text import rows, whole

#: Rows before the points of a scan: columns, rows, the scanner's place and axes (3 numbers each), and a matrix (4).
_HEAD = np.array([1, 1, 3, 3, 3, 3, 4, 4, 4, 4])
_BEGIN = re.compile(rb"\s*\d+[ \t]*\n\s*\d+[ \t]*\n[ \t]*\S+[ \t]+\S+[ \t]+\S+[ \t]*\n")


def is_ptx(text: bytes) -> bool:
    """Return whether a text begins as PTX: two whole numbers on lines of their own, and three numbers."""
    return _BEGIN.match(text) is not None


def read(text: bytes) -> Content:
    """Return the points of all scans, where their matrices put them; 0 0 0, for no return, becomes NaN.

    Raises
    ------
    InputError
        It is cut, or goes on after the points that it says it has.
    """
    table = rows(text)
    width = np.diff(table.ends, prepend=0)
    points, at = [], 0
    while at < len(width):
        if len(width) < at + len(_HEAD) or (width[at : at + len(_HEAD)] != _HEAD).any():
            raise InputError(
                f"line {table.lines[at]}: expected the head of a PTX scan (columns, rows, four lines of three numbers "
                "and four of four); is the file cut, or does it hold more points than it says?"
            )
        head = table.numbers[table.begins[at] : table.ends[at + len(_HEAD) - 1]]
        size = whole(head[:2])
        if size is None or (size < 0).any():
            raise InputError(f"line {table.lines[at]}: expected the numbers of columns and rows of a PTX scan")
        count, at = int(size[0]) * int(size[1]), at + len(_HEAD)
        there = width[at : at + count]
        if len(there) < count:
            raise InputError(f"cut: a scan says it has {count:,} points, but ends after {len(there):,}")
        wrong = np.flatnonzero((there != there[0]) | (there < 3)) if count else np.empty(0)
        if wrong.size:
            raise InputError(
                f"line {table.lines[at + wrong[0]]}: expected x y z and as many numbers as on the other lines"
            )
        if count:
            local = table.numbers[table.begins[at] : table.ends[at + count - 1]].reshape(count, -1)[:, :3].copy()
            local[~local.any(axis=1)] = np.nan
            matrix = head[14:30].reshape(4, 4)  # for rows: x y z 1 times the matrix
            points.append(local @ matrix[:3, :3] + matrix[3, :3])
        at += count
    return Content(points=np.concatenate(points) if points else np.empty((0, 3)))
