"""`hognose scene`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from hognose.cli.options import Flag, TaskOrSpace

if TYPE_CHECKING:
    from hognose.files.inspection import Inspection, Item

_FROM = {"file": "as the file says", "asked": "as asked", "guess": "assumed: the file does not say"}


def scene(
    file: TaskOrSpace,
    /,
    *,
    units: str | None = None,
    notes: Flag = False,
    json: Flag = False,
) -> int:
    """Inspect a mesh, STEP or point file, or the obstacles of a task: sizes, bodies and defects.

    Parameters
    ----------
    file
        STL, OBJ, PLY, OFF, GLB, glTF, DAE, 3MF, STEP; points as PLY, XYZ, TXT, CSV, ASC, PTS, PTX, PCD, LAS, LAZ, E57;
        a task file, or a bundled task.
    units
        Unit of the numbers in the file, for formats that do not state it: mm, cm, m or in.
    notes
        Print a note for each body, instead of one for all bodies with the same defect.
    json
        Print the result as JSON, in SI units.
    """
    from hognose.cli.console import say_json
    from hognose.files.inspection import inspect

    found = inspect(file, units, notes)
    if json:
        say_json(to_json(found))
    else:
        say_inspection(found)
    return 0


def say_inspection(found: Inspection) -> None:
    """Print what a file holds: its size, a row for each body, notes."""
    from hognose.cli.console import say, table
    from hognose.wording import point

    triangles, points = (sum(getattr(item, what) for item in found.items) for what in ("triangles", "points"))
    held = ", ".join(f"{number:,} {what}" for number, what in ((triangles, "triangles"), (points, "points")) if number)
    unit = f"; numbers in {found.units}, {_FROM[found.units_from]}" if found.units else ""
    say(f"{found.source}: {held or 'no obstacles'}{unit}")
    if found.items:
        sides = (top - bottom for bottom, top in zip(found.low, found.high, strict=True))
        say(f"size {_mm(sides)} mm, from {point(found.low, '.5g')} to {point(found.high, '.5g')}\n")
        headings = ("name", "kind", "size mm", "triangles", "points", "watertight", "repairs")
        table(headings, [_row(item) for item in found.items])
    for remark in found.remarks:
        say(f"note: {remark}")


def _row(item: Item) -> list[str]:
    closed = "" if item.watertight is None else "yes" if item.watertight else "NO"
    counts = [str(number) if number else "" for number in (item.triangles, item.points)]
    # That vertices had to be merged is so with most formats, and no defect.
    repairs = [words for words in item.repairs if not words.endswith("merged")]
    kind = f"{item.kind}, moves" if item.moves else item.kind
    return [item.name, kind, _mm(item.size), *counts, closed, "; ".join(repairs)]


def _mm(lengths: Iterable[float]) -> str:
    return " × ".join(f"{1e3 * length:.5g}" for length in lengths)


def to_json(found: Inspection) -> dict[str, object]:
    """The same for machines, in SI units."""
    return {
        "file": found.source,
        "units": found.units,
        "units_from": found.units_from,
        "low_m": found.low,
        "high_m": found.high,
        "items": [
            {
                "name": item.name,
                "kind": item.kind,
                "size_m": item.size,
                "low_m": item.low,
                "high_m": item.high,
                "triangles": item.triangles,
                "points": item.points,
                "watertight": item.watertight,
                "volume_m3": item.volume,
                "repairs": item.repairs,
                "defects": item.defects,
                "moves": item.moves,
            }
            for item in found.items
        ],
        "remarks": found.remarks,
    }
