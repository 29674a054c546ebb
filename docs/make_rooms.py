"""Draw the rooms of the package and the imports between them: `python docs/make_rooms.py`.

Writes `pictures/rooms.svg` and the table of `architecture.md`. A room is a package in `src/hognose`; its row comes from
the contract of layers in `pyproject.toml`. An import is counted once for each pair of modules.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks.docs_page import write_block
from hognose.write_whole import write_whole

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "hognose"
PICTURE, PAGE = ROOT / "docs" / "pictures" / "rooms.svg", ROOT / "docs" / "architecture.md"
#: The former name of `report`, which goes with the next version.
LEFT_OUT = {"view"}
#: Imports from which on a line is drawn thicker, and how thick, in pixels.
WIDTHS = {1: 1.0, 4: 2.0, 10: 3.2}

_INK, _SOFT, _BOX = "#1d2733", "#b4bdc9", "#f3ede6"
_WIDTH, _ROW, _TOP = 860, 66, 24
_BOX_WIDTH, _BOX_HEIGHT, _APART = 132, 36, 168

Edges = Counter[tuple[str, str]]


def rooms() -> list[str]:
    """The packages of `hognose`, sorted."""
    return sorted(file.parent.name for file in PACKAGE.glob("*/__init__.py") if file.parent.name not in LEFT_OUT)


def imports() -> Edges:
    """How many pairs of modules, by room that imports and room that is imported."""
    known = set(rooms())
    pairs = {(module_of(file), target) for file in PACKAGE.rglob("*.py") for target in imported_by(file)}
    found = Counter((_room(importer), _room(target)) for importer, target in pairs)
    return Counter({(a, b): n for (a, b), n in sorted(found.items()) if a != b and {a, b} <= known})


def module_of(file: Path) -> str:
    """The dotted name of a module, `hognose.path` for the package itself."""
    parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_by(file: Path) -> Iterator[str]:
    """The modules of `hognose` that are imported anywhere in a file, also where only types are checked."""
    module = module_of(file)
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.startswith("hognose."))
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(module.split(".")[: -node.level]) + "." if node.level else ""
            source = f"{base}{node.module or ''}".strip(".")
            if source.split(".")[0] == "hognose":
                yield from (f"{source}.{n.name}" if _is_module(f"{source}.{n.name}") else source for n in node.names)


def _is_module(name: str) -> bool:
    place = PACKAGE.parent.joinpath(*name.split("."))
    return place.with_suffix(".py").is_file() or (place / "__init__.py").is_file()


def _room(module: str) -> str:
    return f"{module}.".split(".")[1]


def layers(edges: Edges) -> list[list[str]]:
    """The rooms from top to bottom; one that the contract does not name stands above all that it imports."""
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    rows = [[part.strip().removeprefix("hognose.") for part in row.split("|")] for row in contract[0]["layers"]]
    rows = [kept for row in rows if (kept := [name for name in row if name in rooms()])]
    for name in rooms():
        if not any(name in row for row in rows):
            below = [i for i, row in enumerate(rows) if any(edges[name, other] for other in row)]
            rows.insert(min(below, default=len(rows)), [name])
    return rows


def implied(edges: Edges) -> set[tuple[str, str]]:
    """The edges between rooms that are also joined by way of others."""
    reached = dict[str, set[str]]()

    def below(room: str) -> set[str]:
        if room not in reached:
            reached[room] = set()  # so that a circle ends
            direct = {b for a, b in edges if a == room}
            reached[room] = direct.union(*(below(other) for other in direct))
        return reached[room]

    return {(a, b) for a, b in edges if any(b in below(c) for d, c in edges if d == a and c != b)}


def drawing(edges: Edges) -> str:
    """The picture as SVG: what is joined by way of other rooms, too, is drawn in a lighter colour."""
    rows = layers(edges)
    places = {
        name: (0.5 * _WIDTH + _APART * (k - 0.5 * (len(row) - 1)), _TOP + _ROW * (i + 0.5))
        for i, row in enumerate(rows)
        for k, name in enumerate(row)
    }
    height = 2 * _TOP + _ROW * (len(rows) + 1)
    lighter = implied(edges)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" font-family="sans-serif">',
        "<title>Rooms of Hognose and the imports between them</title>",
        "<!-- written by docs/make_rooms.py -->",
        f'<rect width="{_WIDTH}" height="{height}" fill="white"/>',
        *(_marker(name, colour) for name, colour in (("dark", _INK), ("light", _SOFT))),
    ]
    for edge in sorted(edges, key=lambda edge: (edge not in lighter, edge)):
        lines.append(_line(edge, width_of(edges[edge]), edge in lighter, places))
    lines += [_box(name, *place) for name, place in places.items()]
    lines += [_foundation(_TOP + _ROW * (len(rows) + 0.5)), "</svg>"]
    return "\n".join(lines) + "\n"


def width_of(count: int) -> float:
    """How thick the line of so many imports is."""
    return max(width for fewest, width in WIDTHS.items() if count >= fewest)


def _marker(name: str, colour: str) -> str:
    return (
        f'<marker id="{name}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto" '
        f'markerUnits="userSpaceOnUse"><path d="M0 0L8 4L0 8z" fill="{colour}"/></marker>'
    )


def _line(edge: tuple[str, str], width: float, lighter: bool, places: dict[str, tuple[float, float]]) -> str:
    (x, y), (to_x, to_y) = (places[name] for name in edge)
    spanned = round((to_y - y) / _ROW)
    if spanned == 1 and not lighter:
        shape = f"M{x:g} {y + _BOX_HEIGHT / 2:g}L{to_x:g} {to_y - _BOX_HEIGHT / 2:g}"
    else:
        # A box beside another one is met from its free side.
        beside = [at - _WIDTH / 2 for at in (to_x, x) if at != _WIDTH / 2]
        side = -1 if (beside[0] < 0 if beside else lighter) else 1
        x, to_x = x + side * _BOX_WIDTH / 2, to_x + side * _BOX_WIDTH / 2
        beyond = (min if side < 0 else max)(x, to_x) + side * (14 + 30 * spanned)
        # Lines leave a box a little below its middle and arrive a little above it, so that both can be told apart.
        shape = f"M{x:g} {y + 7:g}C{beyond:g} {y + 7:g} {beyond:g} {to_y - 7:g} {to_x:g} {to_y - 7:g}"
    colour, marker = (_SOFT, "light") if lighter else (_INK, "dark")
    return (
        f'<path data-from="{edge[0]}" data-to="{edge[1]}" d="{shape}" fill="none" stroke="{colour}" '
        f'stroke-width="{width:g}" marker-end="url(#{marker})"/>'
    )


def _box(name: str, x: float, y: float) -> str:
    return (
        f'<rect x="{x - _BOX_WIDTH / 2:g}" y="{y - _BOX_HEIGHT / 2:g}" width="{_BOX_WIDTH}" height="{_BOX_HEIGHT}" '
        f'rx="5" fill="{_BOX}" stroke="{_INK}"/>'
        f'<text x="{x:g}" y="{y + 5:g}" text-anchor="middle" font-size="15" fill="{_INK}">{name}</text>'
    )


def _foundation(y: float) -> str:
    """The modules that every room may import, as one box without arrows."""
    names = sorted(file.stem for file in PACKAGE.glob("*.py") if file.stem != "__init__")
    half = (len(names) + 1) // 2
    words = "".join(
        f'<text x="{_WIDTH / 2:g}" y="{y + dy:g}" text-anchor="middle" font-size="13" fill="{_INK}">'
        f"{', '.join(part)}</text>"
        for part, dy in ((names[:half], -4), (names[half:], 15))
    )
    return (
        f'<rect x="110" y="{y - 26:g}" width="{_WIDTH - 220}" height="54" rx="5" fill="white" stroke="{_SOFT}"/>{words}'
    )


def table(edges: Edges) -> str:
    """What each room is for, by the first line of its docstring, and what it imports, as Markdown."""
    lines = ["| room | what is in it | imports |", "|---|---|---|"]
    for row in layers(edges):
        for name in row:
            said = ast.get_docstring(ast.parse((PACKAGE / name / "__init__.py").read_text(encoding="utf-8"))) or ""
            used = ", ".join(other for lower in layers(edges) for other in lower if edges[name, other])
            lines.append(f"| `{name}` | {said.splitlines()[0] if said else ''} | {used} |")
    return "\n".join(lines)


if __name__ == "__main__":
    found = imports()
    write_whole(PICTURE, drawing(found).encode())
    write_block(PAGE, "rooms", table(found))
