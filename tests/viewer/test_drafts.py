"""Edits that were not saved are not lost."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from workbench_makers import LONG, ROBOT, ours, small

import hognose
from hognose.errors import InputError
from hognose.planning import Task
from hognose.viewer.model import edits
from hognose.viewer.model.workbench import Workbench


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder for drafts, and no thread left behind."""
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    yield
    assert not ours()


@pytest.fixture
def source(tmp_path: Path) -> Path:
    file = tmp_path / "mine.toml"
    file.write_text(
        'name = "mine"\nunits = "mm"\nrobot = "sjtu-25dof"\n[path]\nway_points = [[0, 0, 0], [0, 10, 200]]\n'
        "[motion]\nstep = 20\nperiod_s = 1\n"
    )
    os.utime(file, (1e9, 1e9))
    return file


def drafts(folder: Path) -> list[Path]:
    return [*(folder / "cache" / "drafts").glob("*")]


def test_unsaved_edits_are_kept_by_the_worker_and_taken_up_again(source, tmp_path):
    bench = Workbench(hognose.load_task(source), source)
    assert bench.recovered is None
    bench.edit(edits.set_margin(0.0012345678901))
    bench.settle(LONG)
    for _ in range(int(LONG / 0.05)):
        if bench.draft is None:
            time.sleep(0.05)
    assert drafts(tmp_path) == [bench.draft]
    spec = bench.spec
    with Workbench(hognose.load_task(source), source) as other:  # as if the first one had been killed
        assert other.recovered == spec
        assert not other.dirty
        other.restore()
        assert other.spec == spec
        assert other.can_undo
        with pytest.raises(InputError, match="nothing to restore"):
            other.restore()
    bench.close()
    with Workbench(hognose.load_task(source), source, restore=True) as other:
        assert other.spec == spec
        other.save(source.name)
        assert drafts(tmp_path) == []
    assert drafts(tmp_path) == []


def test_a_close_keeps_what_is_unsaved_and_only_that(source, tmp_path):
    for restore in (False, True):
        with Workbench(hognose.load_task(source), source, restore) as bench:
            bench.edit(edits.set_margin(0.001))
        assert len(drafts(tmp_path)) == 1
    with Workbench(hognose.load_task(source), source):
        pass
    assert len(drafts(tmp_path)) == 1  # nobody has looked at it
    with Workbench(hognose.load_task(source), source, restore=True) as bench:
        while bench.can_undo:
            bench.undo()
    assert drafts(tmp_path) == []


def test_a_draft_older_than_the_file_or_damaged_is_not_taken_up(source, tmp_path):
    with Workbench(hognose.load_task(source), source) as bench:
        bench.edit(edits.set_margin(0.001))
    (draft,) = drafts(tmp_path)
    os.utime(draft, (1e8, 1e8))
    with Workbench(hognose.load_task(source), source, restore=True) as bench:
        assert bench.recovered is None
        assert not bench.dirty
    for content in (b"", b"{}", b"\xff", b'{"task": {"name": 1}}', b"[]", b'{"task": []}'):
        draft.write_bytes(content)
        with Workbench(hognose.load_task(source), source, restore=True) as bench:
            assert bench.recovered is None


def test_drafts_can_be_switched_off_and_failing_ones_are_told(source, tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", "off")
    with Workbench(hognose.load_task(source), source) as bench:
        bench.edit(edits.set_margin(0.001))
    assert bench.draft is None
    assert bench.draft_fault == ""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "file"))
    with Workbench(hognose.load_task(source), source) as bench:
        bench.edit(edits.set_margin(0.001))
    assert "cannot be kept" in bench.draft_fault


def test_drafts_of_tasks_without_a_file_are_told_apart(tmp_path):
    tasks = [small(), Task(small().spec.model_copy(update={"name": "other"}), ROBOT)]
    for task, margin in zip(tasks, (0.001, 0.002), strict=True):
        with Workbench(task) as bench:
            bench.edit(edits.set_margin(margin))
    for task, margin in zip(tasks, (0.001, 0.002), strict=True):
        with Workbench(task, restore=True) as bench:
            assert bench.spec.margin == margin


def test_a_draft_brings_the_content_of_meshes_with_it(tmp_path):
    task = hognose.load_task("step-tank")
    with Workbench(task) as bench:
        bench.edit(edits.set_margin(0.004))
    with Workbench(task, restore=True) as bench:
        assert bench.spec.margin == 0.004
        assert all(a is b for a, b in zip(bench.spec.obstacle, task.spec.obstacle, strict=True))
