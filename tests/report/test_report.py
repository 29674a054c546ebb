"""The report: one page, well formed, that needs nothing beside it and repeats no text unescaped."""

from __future__ import annotations

import re
from base64 import b64decode
from dataclasses import replace
from html.parser import HTMLParser
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

import hognose
from hognose.errors import InputError
from hognose.planning.motion_spec import MotionSpec
from hognose.report import report
from hognose.report.report import write_report

EMPTY = {"meta", "img", "br", "link", "input", "hr"}
NASTY = '<script>alert("x")</script>'


class Page(HTMLParser):
    """Collects tags, attributes and text, and complains of tags that do not close in order."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.words, self.cells = [], [], [], [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, *attr) for attr in attrs]
        if tag not in EMPTY:
            self.open.append(tag)
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)
        if self.open and self.open[-1] in ("td", "th"):
            self.cells[-1] += data

    @property
    def text(self):
        return " ".join(self.words)

    def images(self):
        return [value for tag, name, value in self.attributes if (tag, name) == ("img", "src")]


@pytest.fixture(scope="module")
def written(stand_in, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    calls = []
    few = stand_in("boards", 6)
    files = write_report(few, path, progress=lambda done, total: calls.append((done, total)))
    return few, path, files, calls


def test_it_is_one_file_and_well_formed(written):
    _, path, files, _ = written
    assert files == [path]
    assert list(path.parent.iterdir()) == [path]
    page = Page(path.read_text("utf-8"))
    assert path.read_text("utf-8").startswith("<!DOCTYPE html>")
    assert {"title", "h1", "table", "figure", "figcaption"} <= set(page.tags)


def test_it_asks_nothing_of_the_network(written):
    text = written[1].read_text("utf-8")
    page = Page(text)
    assert not re.search(r"https?://", text)
    assert "url(" not in text
    assert "@import" not in text
    assert not {"script", "link", "iframe", "object"} & set(page.tags)
    assert all(source.startswith("data:") for source in page.images())
    assert all(name not in ("href", "srcset") for _, name, _ in page.attributes)


def test_its_images_are_what_they_say_and_have_words_for_those_who_do_not_see_them(written):
    plan, path, _, _ = written
    page = Page(path.read_text("utf-8"))
    kinds = []
    for source in page.images():
        kind, _, inside = source.removeprefix("data:").partition(";base64,")
        data = b64decode(inside, validate=True)
        kinds.append(kind)
        if kind == "image/svg+xml":
            assert b"<svg" in data
            # Nothing within is fetched: links point into the drawing itself.
            assert all(target.startswith(b"#") for target in re.findall(rb'xlink:href="([^"]*)"', data))
            assert b"<image" not in data
        else:
            with Image.open(BytesIO(data)) as image:
                assert f"image/{image.format}".lower() == kind
                if kind == "image/gif":
                    assert getattr(image, "n_frames", 0) == len(plan.time)
    assert sorted(kinds) == ["image/gif", "image/png", "image/png", *["image/svg+xml"] * 4]
    assert all(value for tag, name, value in page.attributes if (tag, name) == ("img", "alt"))
    assert len([1 for tag in page.tags if tag == "img"]) == page.tags.count("figcaption")


def test_progress_runs_to_the_end(written):
    plan, _, _, calls = written
    total = 6 + len(plan.time)
    assert calls == [(k, total) for k in range(1, total + 1)]


def test_every_check_and_assumption_is_there(boards, tmp_path):
    write_report(boards, tmp_path / "a.html", animation=False)
    page = Page((tmp_path / "a.html").read_text("utf-8"))
    for check in boards.checks:
        at = page.cells.index(check.name)
        value, limit, where, verdict = page.cells[at + 1 : at + 5]
        assert value == check.figures[0]
        assert limit == f"{'≥' if check.at_least else '≤'} {check.figures[1]}"
        assert check.detail in where
        assert (f"section {check.section}" in where) == (check.section is not None)
        assert verdict == "passed"
    for assumption in boards.robot.assumed:
        assert assumption in page.text
    assert "image/gif" not in "".join(page.images())


def test_the_verdict_is_in_words(boards, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "_figures", lambda *_: [])  # drawn by other tests
    failed = replace(boards.checks[0], ok=False)
    verdicts = {
        "Good. All 4 checks passed.": boards,
        "Not good. 1 of 4 checks failed: clearance.": replace(boards, checks=(failed, *boards.checks[1:])),
        "Not checked. No check was made": replace(boards, checks=()),
    }
    for words, plan in verdicts.items():
        write_report(plan, tmp_path / "a.html", animation=False)
        text = re.sub(r"\s+", " ", Page((tmp_path / "a.html").read_text("utf-8")).text)
        assert words in text


def test_key_figures_have_units_and_the_plan_s_numbers(boards):
    figures = dict(report.key_figures(boards))
    assert figures["Arm, length and diameter"] == "1092 mm, 45 mm"
    assert figures["Duration"] == "9.0 s in 60 steps"
    assert figures["Certified clearance of the whole motion"] == "none"
    proven = dict(report.key_figures(replace(boards, certified_clearance=0.0049996)))
    assert proven["Certified clearance of the whole motion"] == "≥ 4.99 mm"
    least, bend = boards.clearance.min() * 1e3, np.degrees(np.abs(boards.angles)).max()
    clearance, angle = (figures[name].split() for name in ("Smallest clearance at the steps", "Largest bend angle"))
    assert (clearance[1], angle[1]) == ("mm", "deg")
    assert least - 0.01 < float(clearance[0]) <= least
    assert bend <= float(angle[0]) < bend + 0.1


def test_hostile_names_are_shown_not_run(stand_in, tmp_path):
    plan = stand_in("boards", 4, names=(NASTY, "a & b", "'\"><img src=x onerror=y>"))
    plan = replace(
        plan,
        task=replace(plan.task, name=NASTY),
        robot=replace(plan.robot, name=NASTY + "$x^2$", assumed=(NASTY, "a < b & c")),
        checks=(*plan.checks, replace(plan.checks[0], name=NASTY, unit=NASTY, detail=NASTY, ok=False)),
    )
    write_report(plan, tmp_path / "a.html", animation=False)
    page = Page((tmp_path / "a.html").read_text("utf-8"))
    assert "script" not in page.tags
    assert not any(name.startswith("on") for _, name, _ in page.attributes)
    assert page.text.count(NASTY) >= 7
    assert "a < b & c" in page.text


def test_a_moving_picture_too_large_for_the_page_is_laid_beside_it(tank, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "EMBED_LIMIT", 10)
    monkeypatch.setattr(report, "_figures", lambda *_: [])
    monkeypatch.setattr(report, "_FRAMES", 2)
    files = write_report(tank, tmp_path / "a.html")
    assert files == [tmp_path / "a.html", tmp_path / "a.gif"]
    assert set(tmp_path.iterdir()) == set(files)
    page = Page(files[0].read_text("utf-8"))
    assert "a.gif" in page.text
    assert not any("image/gif" in source for source in page.images())


@pytest.mark.parametrize("stop", [KeyboardInterrupt, RuntimeError])
def test_being_stopped_leaves_the_old_page_and_nothing_else(stop, tank, tmp_path):
    path = tmp_path / "a.html"
    path.write_text("old")

    def stopping(done, total):
        if done == 3:
            raise stop

    with pytest.raises(stop):
        write_report(tank, path, animation=False, progress=stopping)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_writer_that_fails_leaves_nothing(tank, tmp_path, monkeypatch):
    def full(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    monkeypatch.setattr(report, "_figures", lambda *_: [])
    with pytest.raises(InputError, match="No space left"):
        write_report(tank, tmp_path / "a.html", animation=False)
    assert not list(tmp_path.iterdir())


def test_a_time_outside_the_plan_is_refused_before_anything_is_written(tank, tmp_path):
    with pytest.raises(InputError, match="99 s lies outside"):
        write_report(tank, tmp_path / "a.html", times=[0, 99])
    assert not list(tmp_path.iterdir())


def test_figures_are_of_what_motors_command_and_of_lengths_of_sections():
    """The same cables as the checks judge."""
    plan = hognose.plan(hognose.load_task("baffled-tank"))
    figures = dict(report.key_figures(plan))
    assert figures["Sections, their lengths"] == "37.5 to 38.6 mm, of 16.5 to 40 mm"
    travel = 1e3 * plan.check("cable_travel").value
    assert figures["Cables, largest change of what motors command"] == f"{np.ceil(10 * travel) / 10:.1f} mm"
    assert travel > 1.5e3 * np.abs(plan.cable_lengths - plan.robot.straight_cable_lengths).max()


def test_the_base_is_said_and_the_profile_where_it_is_not_constant(boards):
    figures = dict(report.key_figures(boards))
    assert figures["Base"] == "slider along +z"
    assert "Profile" not in figures
    fast = replace(boards.task.spec, motion=MotionSpec(profile="fastest"))
    figures = dict(report.key_figures(replace(boards, task=replace(boards.task, spec=fast))))
    assert figures["Profile"].startswith("fastest: from rest to rest, a set-point every 150 ms")
