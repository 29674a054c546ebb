"""The page, and the documentation that the command writes."""

import re
import struct
from dataclasses import replace

import numpy as np
import pytest
from evaluation_makers import results, row

from hognose.evaluation.content import PICTURES, content
from hognose.evaluation.families import FAMILIES, statement
from hognose.evaluation.pages import command_for, write_docs, write_page
from hognose.evaluation.subjects import method_of, subjects_of, takes_part
from hognose.evaluation.summary import COLUMNS, weakness


def series(scale):
    return tuple(float(value) for value in scale * (1.0 + np.arange(40) % 7))


def whole(methods=None):
    """A row of every method on a case or two of every family, with made-up figures."""
    labels, rows = methods or subjects_of(), []
    cases = {
        "cases": ["obstacle-array", "pipe-tank"],
        "links": ["3", "1000"],
        "spacing": ["0.05", "3.5"],
        "shapes": ["S 1", "C 1"],
    }
    for family in FAMILIES:
        for place, case in enumerate(cases.get(family, ["a"])):
            for number, label in enumerate(labels):
                if takes_part(label, family):
                    scale = 0.1 * (number + 1) * (place + 1)
                    figures = dict.fromkeys([*COLUMNS, "tip_max_mm"], scale)
                    kept = {name: series(scale) for name in ("tip_series_mm", "body_series_mm", "time_series_us")}
                    more = {"links": int(case)} if family == "links" else {}
                    more |= {"spacing_mm": float(case)} if family == "spacing" else {}
                    more |= {"steps": 40, "all_steps": 45, **kept} if family == "cases" else {}
                    rows.append(row(label, family, case, **figures, **more, on_path=label != "fabrik"))
    race = {label: 0.5 * (number + 1) for number, label in enumerate(labels)}
    return results(rows, {"pipe-tank": race, "obstacle-array": race})


@pytest.fixture(scope="module")
def docs(tmp_path_factory):
    """A page of documentation and its folder."""
    folder = tmp_path_factory.mktemp("made") / "docs"
    folder.mkdir()
    files = write_docs(whole(), folder / "evaluation.md")
    return folder, (folder / "evaluation.md").read_text(), files


def test_docs_hold_every_method_family_and_picture(docs):
    folder, text, files = docs
    for label in subjects_of():
        assert f"| {label} |" in text
    for family in FAMILIES:
        assert f"| {family} | {statement(family)} |" in text
        assert f"**{family}**" in text
    shown = re.findall(r"!\[[^]]+\]\((.+?)\)", text)
    assert sorted(shown) == sorted(f"pictures/evaluation-{name}.png" for name in PICTURES)
    assert {file.relative_to(folder).as_posix() for file in files} == {"evaluation.md", *shown}
    for name in shown:
        data = (folder / name).read_bytes()
        width, height = struct.unpack(">II", data[16:24])
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        assert width > 1000
        assert height > 400


def test_docs_name_no_place_of_this_machine_and_the_command_that_made_them(docs):
    folder, text, _ = docs
    assert str(folder) not in text
    assert str(folder.parent) not in text
    assert not re.search(r"(?<![\w.*])/(?:home|root|tmp|work|usr|var)\b", text)
    assert "\nhognose bench --quick --docs docs/evaluation.md\n" in text
    assert text.startswith("# Evaluation")
    assert text.count("\n# ") == 0, "one title"


def test_docs_tables_are_whole(docs):
    _, text, _ = docs
    tables = re.findall(r"(?:^\|.*\|\n)+", text, re.M)
    assert len(tables) > 12
    for table in tables:
        widths = {line.count("|") - line.count("\\|") for line in table.splitlines()}
        assert len(widths) == 1, table
    assert "None" not in text
    assert "nan" not in re.findall(r"\w+", text)


def test_docs_show_the_targets_with_their_verdicts(docs):
    _, text, _ = docs
    # Made up so that times hardly differ: the time targets are missed, and the page says so.
    assert "| optimization as published / prediction, time | 3.33 × | ≥ 1000 × | MISSED |" in text
    assert re.search(r"\d of 14 targets are reached, \d missed", text)


def test_numbers_in_the_prose_come_from_the_results(docs):
    _, text, _ = docs
    worst = max(found.tip_rmse_mm or 0.0 for found in whole().of("spacing", "interpolation"))
    assert f"ours is largest at 3.5 mm, with {worst:.3g} mm" in text
    assert f"{len(whole().rows)} rows, seed 1" in text
    lookup, search = (whole().of("cases", label, "pipe-tank")[0] for label in ("prediction", "iterative (published)"))
    assert f"Our prediction lookup measures {lookup.evaluations:.3g} distances per step for 12 links" in text
    assert f"as published measures {search.evaluations:.3g}." in text
    assert "for methods that do not (fabrik): " in text
    assert "exact: 40 of 45 on cases obstacle-array" in text


def test_the_page_needs_nothing_but_itself(tmp_path):
    seen = []
    (file,) = write_page(whole(), tmp_path, lambda done, total: seen.append((done, total)))
    text = file.read_text()
    assert file == tmp_path / "evaluation.html"
    assert text.count("<img ") == text.count("data:image/png;base64,") == len(PICTURES)
    assert not re.search(r'(?:src|href)="(?!data:)', text)
    assert all(label in text for label in subjects_of())
    assert seen == [(done, len(PICTURES)) for done in range(len(PICTURES) + 1)]
    for mark in ("**", "`", "<p>|"):
        assert mark not in text


def test_a_page_of_one_method_leaves_out_what_it_has_nothing_for(tmp_path):
    few = whole(["balanced"])
    write_docs(few, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text()
    assert "not measured" in text
    assert "evaluation-tip-sd.png" not in text
    assert not (tmp_path / "pictures" / "evaluation-tip-sd.png").exists()
    assert "hognose bench --quick --method balanced --docs " in text


def test_results_of_nothing_are_a_page_all_the_same(tmp_path):
    write_docs(results([]), tmp_path / "page.md")
    assert [file.name for file in (tmp_path / "pictures").iterdir()] == []


@pytest.mark.parametrize(
    ("more", "docs", "command"),
    [
        ({"quick": False}, None, "hognose bench"),
        ({"seed": 5}, None, "hognose bench --quick --seed 5"),
        ({"quick": False}, "docs/evaluation.md", "hognose bench --docs docs/evaluation.md"),
        ({"quick": False}, "my docs/e.md", "hognose bench --docs 'my docs/e.md'"),
    ],
)
def test_the_command_is_the_one_that_makes_the_page(more, docs, command):
    found = whole()
    assert command_for(results(found.rows, found.races, **more), docs) == command


def test_what_fails_is_said_with_the_weakness_of_the_method():
    found = whole()
    failed = replace(found.rows[-1], valid=False, why="a joint bends by 0.7 rad, its limit is 0.5 rad")
    lists = [block for block in content(results([*found.rows[:-1], failed]), "x") if isinstance(block, list)]
    assert [f"{method_of(failed.method)}: {weakness(failed.method)}"] in lists


def test_where_nothing_fails_the_page_says_so():
    words = [block for block in content(whole(), "x") if isinstance(block, str)]
    assert "No method failed on any case of this suite." in words
