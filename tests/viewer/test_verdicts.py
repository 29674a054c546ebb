"""What the page says of checks: all of them in its model, and those not judged beside the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from own_criteria import FLOOR, HIGH_FLOOR, LOAD, appended
from workbench_makers import LONG, small

from hognose.viewer.model.freshness import Standing
from hognose.viewer.model.workbench import Verdict, Workbench
from hognose.viewer.verdict_panel import VerdictPanel


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))


class Panel:
    """What the panel draws with, and what it then shows."""

    def __init__(self) -> None:
        self.words = SimpleNamespace(content="")
        self.button = SimpleNamespace(visible=False, on_click=lambda call: call)

    def add_markdown(self, text: str) -> SimpleNamespace:
        self.words.content = text
        return self.words

    def add_button(self, label: str, visible: bool, hint: str) -> SimpleNamespace:
        return self.button


@pytest.fixture
def bench() -> Iterator[Workbench]:
    with Workbench(small()) as made:
        yield made


def shown(bench: Workbench) -> tuple[Verdict, Panel]:
    """The verdict, and the panel on it."""
    drawn: Any = Panel()
    panel, standing = VerdictPanel(drawn, bench, lambda step: None), Standing(bench)
    verdict = bench.settle(LONG)
    standing.look(1.0)
    panel.show(standing, steered=False, motion=True)
    return verdict, drawn


def test_a_criterion_of_a_script_is_among_the_checks():
    with appended(FLOOR, LOAD), Workbench(small()) as bench:
        verdict, panel = shown(bench)
        assert verdict.good
        assert [check.key for check in verdict.checks[-2:]] == ["height_above_floor", "payload"]
        assert "payload: not judged (the robot names no payload)" in panel.words.content
        assert not panel.button.visible


def test_where_it_fails_can_be_looked_at():
    with appended(HIGH_FLOOR, LOAD), Workbench(small()) as bench:
        verdict, panel = shown(bench)
        assert not verdict.good
        (problem,) = verdict.problems
        assert verdict.plan is not None
        failed = verdict.plan.check("high_floor")
        assert (problem, verdict.step) == (failed.sentence, failed.step)
        assert failed.sentence in panel.words.content
        assert "not judged" in panel.words.content
        assert panel.button.visible


def test_nothing_is_said_of_what_is_not_judged_where_all_is(bench):
    verdict, panel = shown(bench)
    assert verdict.plan is not None
    assert verdict.checks == verdict.plan.checks
    assert "not judged" not in panel.words.content
