import re
import runpy
from collections import Counter
from graphlib import TopologicalSorter

import grimp
import pytest
from docs_pages import DOCS

from benchmarks.docs_page import block

ROOMS = runpy.run_path(str(DOCS / "make_rooms.py"))
AGAIN = "run `python docs/make_rooms.py` and commit what it writes"


@pytest.fixture(scope="module")
def edges():
    return ROOMS["imports"]()


def test_the_picture_has_the_imports_that_an_independent_reader_of_the_source_finds():
    graph = grimp.build_graph("hognose", cache_dir=None)
    known, found = set(ROOMS["rooms"]()), Counter()
    for importer in graph.modules:
        for imported in graph.find_modules_directly_imported_by(importer):
            rooms = tuple(f"{module}.".split(".")[1] for module in (importer, imported))
            found[rooms] += rooms[0] != rooms[1] and known.issuperset(rooms)
    picture = ROOMS["PICTURE"].read_text(encoding="utf-8")
    drawn = re.findall(r'data-from="(\w+)" data-to="(\w+)".*?stroke-width="([\d.]+)"', picture)
    widths = {(a, b): float(width) for a, b, width in drawn}
    assert len(drawn) == len(widths)
    assert widths == {pair: ROOMS["width_of"](count) for pair, count in found.items() if count}, AGAIN


def test_picture_and_table_are_what_the_command_writes(edges):
    assert ROOMS["PICTURE"].read_text(encoding="utf-8") == ROOMS["drawing"](edges), AGAIN
    page = ROOMS["PAGE"].read_text(encoding="utf-8")
    assert block(page, "rooms")[1].strip() == ROOMS["table"](edges), AGAIN


def test_every_room_is_drawn_once_and_every_arrow_leads_down(edges):
    rows = ROOMS["layers"](edges)
    level = {name: depth for depth, row in enumerate(rows) for name in row}
    assert sorted(level) == ROOMS["rooms"]()
    assert sum(map(len, rows)) == len(level)
    assert all(level[importer] < level[imported] for importer, imported in edges)


def test_no_module_imports_itself_by_way_of_others():
    """The linter compares neighbours only; here a package and its own modules count, too."""
    imports = {
        ROOMS["module_of"](file): set(ROOMS["imported_by"](file)) for file in sorted(ROOMS["PACKAGE"].rglob("*.py"))
    }
    TopologicalSorter(imports).prepare()  # CycleError names the circle
    assert imports["hognose.cli"] >= {"hognose.cli.running", "hognose.cli.exit_codes"}


def test_a_room_that_the_contract_does_not_name_stands_above_what_it_imports(monkeypatch):
    monkeypatch.setitem(ROOMS["layers"].__globals__, "rooms", lambda: ["new", "path", "planning", "scene"])
    assert ROOMS["layers"](Counter({("new", "path"): 2})) == [["planning"], ["new"], ["path"], ["scene"]]


def test_an_edge_is_implied_if_another_way_leads_there():
    found = ROOMS["implied"](dict.fromkeys([("a", "b"), ("b", "c"), ("a", "c"), ("c", "d"), ("a", "d"), ("e", "d")], 1))
    assert found == {("a", "c"), ("a", "d")}
