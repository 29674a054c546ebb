import re

import pytest
from docs_pages import DOCS

from benchmarks import rows
from benchmarks.docs_page import block, found_in, write_block
from hognose.errors import InputError

PAGE = (
    "before\n<!-- begin one: a command -->\nold\n<!-- end one -->\nbetween\n<!-- begin two: b -->\n<!-- end two -->\n"
)


def test_a_block_is_replaced_and_nothing_else(tmp_path):
    file = tmp_path / "page.md"
    file.write_text(PAGE)
    write_block(file, "one", "new\nlines")
    assert file.read_text() == PAGE.replace("\nold\n", "\n\nnew\nlines\n\n")
    written = file.read_text()
    write_block(file, "one", "new\nlines")
    assert file.read_text() == written
    write_block(file, "two", "more")
    assert block(file.read_text(), "one")[1].strip() == "new\nlines"
    assert block(file.read_text(), "two")[1].strip() == "more"


@pytest.mark.parametrize("text", [PAGE.replace("one", "three"), PAGE + PAGE])
def test_a_page_without_the_block_or_with_two_is_left_alone(tmp_path, text):
    file = tmp_path / "page.md"
    file.write_text(text)
    with pytest.raises(InputError, match=r"page\.md: expected one block 'one', found [02]"):
        write_block(file, "one", "new")
    assert file.read_text() == text
    with pytest.raises(InputError, match="cannot read"):
        found_in(tmp_path / "missing.md", "one")


def test_rows_are_kept_as_printed(monkeypatch, capsys):
    monkeypatch.setattr(rows, "_SECTIONS", [])
    rows.heading("some times")
    rows.row("fast enough", 12.345, 20, "ms")
    rows.row("too few", 3, 5, "x", at_least=True)
    rows.aside("by the way", 123456.0, "ns")
    assert rows.as_markdown().splitlines() == [
        "### Some times",
        "",
        "| | measured | must be |",
        "|---|---:|---:|",
        "| fast enough | 12.3 ms | ≤ 20 ms |",
        "| too few | 3 × | ≥ 5 ×, **missed** |",
        "| by the way | 123,456 ns |  |",
    ]
    printed = capsys.readouterr().out
    assert re.search(r"ok +fast enough +12\.3 <= 20 ms", printed)
    assert re.search(r"MISSED too few +3 >= 5 x", printed)


@pytest.mark.parametrize("name", ["core", "viewer", "routes", "arms"])
def test_the_page_has_a_block_for_each_command(name):
    assert re.search(r"^\| ?---", block((DOCS / "speed.md").read_text(encoding="utf-8"), name)[1], re.MULTILINE)
