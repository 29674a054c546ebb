"""Tampering with a plan file: whatever would move a motor otherwise is noticed by every command that hands a plan on.

Every kind is tried twice: with the digests as they were, and by a forger who makes new ones.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh
from plan_file_makers import rewritten
from tamperings import ALL, COLUMNS, METADATA, OTHERS

import hognose
from hognose.cli import main
from hognose.files import bundled_tasks


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    """A folder with a task that has a block from a file beside the arm's way, and its plan of eight rows."""
    folder = tmp_path_factory.mktemp("tampered")
    trimesh.creation.box((0.1, 0.1, 0.1)).export(folder / "block.stl")
    text = bundled_tasks()["pipe-tank"].read_text()
    for slow, fast in (("step = 3.5", "step = 160.0"), ("period_s = 0.15", "period_s = 15.0")):
        assert slow in text
        text = text.replace(slow, fast)
    block = '\n[[obstacle]]\nkind = "mesh"\nfile = "block.stl"\nunits = "m"\nposition = [200.0, 0.0, 500.0]\n'
    (folder / "task.toml").write_text(text + block)
    plan = hognose.plan(hognose.load_task(folder / "task.toml"))
    assert len(plan.time) == 8
    plan.save(folder / "plan.parquet")
    return folder


@pytest.fixture
def run(capfd, monkeypatch, tmp_path) -> Callable[..., tuple[int, str]]:
    """Run a command without drawing figures; its code and all that it said."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.setattr("hognose.view.report._figures", lambda *_: [])

    def command(*tokens: str | Path) -> tuple[int, str]:
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            main([str(token) for token in tokens])
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        assert isinstance(ended.value.code, int)
        return ended.value.code, out + err

    return command


COMMANDS = {
    "check": ("check", "p.parquet"),
    "check --json": ("check", "p.parquet", "--json"),
    "csv": ("export", "p.parquet", "-o", "o.csv"),
    "json": ("export", "p.parquet", "-o", "o.json"),
    "parquet": ("export", "p.parquet", "-o", "o.parquet"),
    "report": ("report", "p.parquet", "--no-animation"),
    "report --json": ("report", "p.parquet", "--no-animation", "--json"),
}


def test_there_are_70_kinds_and_more():
    assert len(COLUMNS) >= 150
    assert len(OTHERS) >= 30
    assert len(METADATA) >= 45


def test_the_plan_itself_passes_everywhere(run, source, tmp_path):
    (tmp_path / "p.parquet").write_bytes(rewritten(source / "plan.parquet"))
    for command in COMMANDS.values():
        assert run(*command)[0] == 0
    assert run("check", "p.parquet", "--task", source / "task.toml")[0] == 0


@pytest.mark.parametrize("name", list(ALL))
def test_it_is_noticed_by_all_commands(run, source, tmp_path, name):
    """A forger, who makes new digests, is found out by what the columns and the metadata say."""
    tampering = ALL[name]
    (tmp_path / "p.parquet").write_bytes(
        rewritten(source / "plan.parquet", tampering.table, tampering.meta, change_entries=tampering.entries)
    )
    for which, command in COMMANDS.items():
        code, said = run(*command)
        assert code in (1, 2), which
        if which != "report --json":
            assert re.search(tampering.named, said), (which, said)
    if (tmp_path / "o.json").exists():  # written, and said to be no good
        assert json.loads((tmp_path / "o.json").read_text())["hognose"]["good"] is False
        assert not hognose.Plan.load(tmp_path / "o.parquet").good
        assert "Not good." in (tmp_path / "p.html").read_text("utf-8")
    else:
        assert [file.name for file in tmp_path.iterdir()] == ["p.parquet"]


@pytest.mark.parametrize("name", [name for name, tampering in ALL.items() if tampering.table or tampering.meta])
def test_whoever_makes_no_new_digests_is_refused_by_all_commands(run, source, tmp_path, name):
    tampering = ALL[name]
    (tmp_path / "p.parquet").write_bytes(
        rewritten(source / "plan.parquet", tampering.table, tampering.meta, sealed=False)
    )
    for which in ("check --json", "csv", "report"):
        code, said = run(*COMMANDS[which])
        assert code == 2
        assert re.search(r"altered|column '|metadata|schema", said)
    assert [file.name for file in tmp_path.iterdir()] == ["p.parquet"]
