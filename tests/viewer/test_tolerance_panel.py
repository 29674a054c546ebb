"""The folder with the budget of tolerances: what it shows, and that it is only made when nobody edits."""

from __future__ import annotations

import re
from html import unescape
from types import SimpleNamespace
from typing import Any

import pytest
from workbench_makers import LONG, move, small

import hognose
from hognose.errors import InputError
from hognose.planning import Plan, Task, tolerances
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.report.tolerance_section import CAPTION
from hognose.viewer import tolerance_panel
from hognose.viewer.model import edits
from hognose.viewer.model.freshness import CALM, Standing
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.tolerance_panel import LARGEST, TolerancePanel, links_html, links_table
from hognose.viewer.verdict_panel import plain


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))


class Panel:
    """What the folder is drawn with, and what it then shows."""

    def __init__(self) -> None:
        self.folder = SimpleNamespace(visible=True)
        self.texts: list[Any] = []

    def add_folder(self, label: str, expand_by_default: bool, visible: bool) -> Any:
        assert (label, expand_by_default) == ("tolerances", False)
        self.folder = _Folder(visible)
        return self.folder

    def add_markdown(self, text: str, visible: bool = True) -> SimpleNamespace:
        self.texts.append(SimpleNamespace(content=text, visible=visible))
        return self.texts[-1]

    add_html = add_markdown

    @property
    def seen(self) -> list[str]:
        """What is read in the folder, part by part; nothing if it is not there."""
        return [each.content for each in self.texts if each.visible and self.folder.visible]


class _Folder:
    def __init__(self, visible: bool) -> None:
        self.visible = visible

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        pass


def budgeted(**values: Any) -> Task:
    """The small task, with tolerances."""
    task = small()
    spec = task.spec.model_copy(update={"tolerance": ToleranceSpec(**values)})
    return Task(spec, task.robot)


class Shown:
    """A panel on a bench."""

    def __init__(self, bench: Workbench) -> None:
        drawn: Any = Panel()
        self.drawn: Panel = drawn
        self.bench, self.standing, self.panel = bench, Standing(bench), TolerancePanel(drawn)

    def look(self, seconds: float, steered: bool = False) -> list[str]:
        self.standing.look(seconds)
        self.panel.show(self.standing, steered)
        return self.drawn.seen

    def plan(self) -> Plan:
        plan = self.bench.settle(LONG).plan
        assert plan is not None
        return plan


@pytest.fixture(scope="module")
def plan() -> Plan:
    return hognose.plan(hognose.load_task("tolerances"))


def test_each_row_names_the_largest_part_as_the_budget_has_it(plan):
    found = tolerances(plan)
    assert found.budget is not None
    headings, rows = links_table(found)
    assert set(headings) - set(found.headings) == set(LARGEST)
    assert len(rows) == len(found.links) == plan.robot.sections
    for link, whole, row in zip(found.links, found.rows, rows, strict=True):
        cells, all_cells = dict(zip(headings, row, strict=True)), dict(zip(found.headings, whole, strict=True))
        worst = max(link.parts, key=lambda name: link.parts[name])
        assert cells[LARGEST[0]] == found.budget.label(worst)
        assert cells[LARGEST[1]] == all_cells[cells[LARGEST[0]]]
        assert {name: cells[name] for name in headings if name not in LARGEST} == {
            name: all_cells[name] for name in headings if name not in LARGEST
        }
    assert found.budget.words(found.links[-1].taken, found.links[-1].parts).startswith(f"{rows[-1][1]} is ")


def test_the_html_holds_every_cell_in_order(plan):
    found = tolerances(plan)
    headings, rows = links_table(found)
    cells = re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", links_html(found))
    assert [unescape(cell) for cell in cells] == [*headings, *(cell for row in rows for cell in row)]


def test_it_says_what_the_command_says_but_what_the_verdict_says_already():
    with Workbench(budgeted(cad=1e-3, registration_deg=0.05)) as bench:
        shown = Shown(bench)
        found = tolerances(shown.plan())
        words, table, sums = shown.look(1.0)
        assert words == "\n\n".join([*map(plain, (found.taken_for_exact, found.chances)), f"*{plain(CAPTION)}*"])
        assert table == links_html(found)
        assert sums == f"*{plain(found.sums)}*"
        assert found.headline not in words


def test_without_tolerances_there_is_no_folder():
    with Workbench(small()) as bench:
        shown = Shown(bench)
        shown.plan()
        assert shown.look(1.0) == []
        assert not shown.drawn.folder.visible


def test_of_what_moves_there_are_sentences_alone():
    with Workbench(hognose.load_task("moving-obstacles")) as bench:
        shown = Shown(bench)
        found = tolerances(shown.plan())
        assert shown.look(1.0) == ["\n\n".join(plain(each.words) for each in found.timings)]
        assert len(found.timings) == 2


def test_while_somebody_edits_nothing_is_made_and_what_is_seen_is_called_the_one_before(monkeypatch):
    made: list[Plan] = []
    monkeypatch.setattr(tolerance_panel, "tolerances", lambda plan: made.append(plan) or tolerances(plan))
    with Workbench(budgeted(cad=1e-3)) as bench:
        shown = Shown(bench)
        first = shown.plan()
        before = shown.look(1.0)
        for _ in range(3):
            shown.look(1.0)
        assert made == [first]
        last = first
        for k in range(5):
            bench.edit(move(1, 0.021 + 1e-3 * k, 0.01, 0.2))
            last = shown.plan()
            seen = shown.look(0.5 * CALM)
            assert seen == [tolerance_panel.BEFORE, *before]
        assert made == [first]
        now = shown.look(1.0)
        assert made == [first, last]
        assert len(now) == len(before)
        assert now != before


def test_while_an_arm_is_steered_it_is_not_there():
    with Workbench(budgeted(cad=1e-3)) as bench:
        shown = Shown(bench)
        shown.plan()
        assert shown.look(1.0, steered=True) == []
        assert shown.look(1.0) != []


def test_a_motion_that_is_not_good_has_a_budget_too():
    with Workbench(budgeted(cad=1e-3)) as bench:
        shown = Shown(bench)
        bench.edit(edits.set_margin(0.045))
        found = tolerances(shown.plan())
        assert not bench.settle(LONG).good
        shown.look(0.0)
        assert links_html(found) in shown.look(1.0)


def test_what_cannot_be_made_is_said(monkeypatch):
    def refused(plan: Plan) -> None:
        raise InputError("no <budget>")

    with Workbench(budgeted(cad=1e-3)) as bench:
        shown = Shown(bench)
        shown.plan()
        monkeypatch.setattr(tolerance_panel, "tolerances", refused)
        assert shown.look(1.0) == [plain("no <budget>")]
