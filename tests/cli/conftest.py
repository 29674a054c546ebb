"""Running commands in this process, as `hognose` would."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import hognose
import hognose.files
from hognose.cli import main


@dataclass(frozen=True)
class Ran:
    """What a command left behind."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one JSON object on standard output."""
        assert self.out.endswith("\n")
        assert self.out.count("\n") == 1
        found = json.loads(self.out)
        assert isinstance(found, dict)
        return found


@pytest.fixture
def run(capfd, monkeypatch, tmp_path) -> Callable[..., Ran]:
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    # Of a moving picture's many frames a few are drawn: the view's own tests draw more.
    monkeypatch.setattr("hognose.report.report._FRAMES", 4)

    def command(*tokens: str | Path) -> Ran:
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            main([str(token) for token in tokens])
        out, err = capfd.readouterr()
        code = ended.value.code
        assert isinstance(code, int)
        assert "Traceback" not in out + err
        return Ran(code, out, err)

    return command


@pytest.fixture(scope="session")
def made(tmp_path_factory) -> Path:
    """A folder with a good plan, one that is none, and tasks of each outcome."""
    folder = tmp_path_factory.mktemp("made")
    plan = hognose.plan(hognose.load_task("pipe-tank"))
    plan.save(folder / "good.parquet")
    text = hognose.files.bundled_tasks()["pipe-tank"].read_text()
    (folder / "good.toml").write_text(text)
    (folder / "tight.toml").write_text(
        text.replace("margin = 5.0", "margin = 24.45").replace("[path]", "[path]\ndetour = false")
    )
    (folder / "far.toml").write_text(text.replace("1008.5", "2008.5"))
    (folder / "wrong.toml").write_text(text.replace("margin = 5.0", "margin = -5.0"))
    (folder / "cut.parquet").write_bytes((folder / "good.parquet").read_bytes()[:5000])
    return folder
