"""Kernels: whichever source changes, nothing old is run; where nothing can be kept, that is said and nothing fails."""

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from numba.core.event import trigger_event

import hognose
from hognose import kernels

PACKAGE = Path(hognose.__file__).parent
SOURCES = {file: file.read_text() for file in sorted(PACKAGE.rglob("*.py"))}
WITH_KERNELS = {file for file, text in SOURCES.items() if "@kernel" in text}
INNER = """
from hognose.kernels import kernel

@kernel()
def inner(x: float) -> float:
    return x + {more}
"""
OUTER = """
from hognose.inner import inner
from hognose.kernels import kernel

@kernel(fastmath={"contract"})
def outer(x: float) -> float:
    return 2.0 * inner(x)
"""
Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Runs `outer(1.0)` of a small package with our decorator, in a process of its own."""
    package = tmp_path / "hognose"
    package.mkdir()
    for name in ("kernels.py", "cache_folder.py", "forks.py"):
        shutil.copy(PACKAGE / name, package)
    (package / "__init__.py").write_text("")
    (package / "outer.py").write_text(OUTER)
    code = "import logging; logging.basicConfig(level=20); from hognose.outer import outer; print(outer(1.0))"

    def once(more: float = 1.0, **environment: str) -> subprocess.CompletedProcess[str]:
        (package / "inner.py").write_text(INNER.format(more=more))
        os.utime(package / "inner.py", (1, 1))  # nor does the time of the file say that it is another
        kept = {name: value for name, value in os.environ.items() if name not in ("NUMBA_CACHE_DIR", "PYTHONPATH")}
        environment = {"HOGNOSE_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path), **environment}
        return subprocess.run(
            [sys.executable, "-B", "-c", code], env=kept | environment, capture_output=True, text=True, check=True
        )

    return once


def test_a_change_in_a_kernel_that_another_file_calls_is_noticed(run: Run):
    first, again, changed = run(1.0), run(1.0), run(1.25)
    assert [float(done.stdout) for done in (first, again, changed)] == [4.0, 4.0, 4.5]
    # What is compiled is said; what was kept is not compiled.
    assert ["compiling" in done.stderr for done in (first, again, changed)] == [True, False, True]


@pytest.mark.parametrize("variable", ["HOGNOSE_CACHE", "NUMBA_CACHE_DIR"])
def test_a_folder_that_cannot_be_written_is_said_and_nothing_fails(run: Run, tmp_path: Path, variable: str):
    file = tmp_path / "file"
    file.write_text("not a folder")
    for _ in range(2):
        done = run(1.0, **{variable: str(file)})
        assert float(done.stdout) == 4.0
        assert done.stderr.count("cannot be kept") == 1
        assert "HOGNOSE_CACHE" in done.stderr
        assert "Traceback" not in done.stderr
    assert file.read_text() == "not a folder"


def test_without_a_home_nothing_is_kept_and_that_is_said(run: Run, tmp_path: Path):
    done = run(1.0, HOGNOSE_CACHE="off")
    assert (float(done.stdout), done.stderr.count("cannot be kept: HOGNOSE_CACHE is off")) == (4.0, 1)
    assert not (tmp_path / "cache").exists()


def test_folders_of_other_sources_are_thrown_away_when_long_unused(run: Run, tmp_path: Path):
    run(1.0)
    kernels = tmp_path / "cache" / "kernels"
    (old,) = kernels.iterdir()
    run(1.25)
    assert old in kernels.iterdir()
    os.utime(old, (1, 1))
    run(1.5)
    assert old not in kernels.iterdir()


def test_there_is_one_decorator_only():
    assert [str(file) for file, text in SOURCES.items() if "njit" in text] == [str(PACKAGE / "kernels.py")]


def _kernels(tree: ast.Module) -> list[ast.FunctionDef]:
    def marked(decorator: ast.expr) -> bool:
        return isinstance(decorator, ast.Call) and getattr(decorator.func, "id", "") == "kernel"

    return [each for each in tree.body if isinstance(each, ast.FunctionDef) and any(map(marked, each.decorator_list))]


def test_what_kernels_take_from_other_files_is_in_files_whose_sources_count():
    """numba freezes the constants that a kernel names; one from a file without kernels could change unnoticed."""
    taken = 0
    for file in WITH_KERNELS:
        tree = ast.parse(SOURCES[file])
        origin = {
            alias.asname or alias.name: f"{each.module}"
            for each in tree.body
            if isinstance(each, ast.ImportFrom)
            for alias in each.names
        }
        for function in _kernels(tree):
            body = ast.Module(function.body, [])
            for name in {each.id for each in ast.walk(body) if isinstance(each, ast.Name)} & set(origin):
                if origin[name].startswith("hognose"):
                    taken += 1
                    home = PACKAGE.joinpath(*origin[name].split(".")[1:]).with_suffix(".py")
                    assert home in WITH_KERNELS, f"{file}: {function.name} takes {name} from {origin[name]}"
    assert taken > 10


def test_a_clock_stands_still_while_anything_is_compiled(monkeypatch: pytest.MonkeyPatch):
    now = [100.0]
    monkeypatch.setattr(kernels.time, "perf_counter", lambda: now[0])
    monkeypatch.setattr(kernels._compilations, "has_been", True)  # it has been said
    begin = kernels.time_without_compiling()

    def passes(seconds: float) -> float:
        now[0] += seconds
        return kernels.time_without_compiling() - begin

    assert passes(1.0) == pytest.approx(1.0)
    with suppress(ValueError), trigger_event("numba:compile"):
        assert passes(2.0) == pytest.approx(1.0)
        with trigger_event("numba:compile"):  # one that is called by it
            assert passes(4.0) == pytest.approx(1.0)
        assert passes(8.0) == pytest.approx(1.0)
        raise ValueError("it cannot be compiled")
    assert passes(16.0) == pytest.approx(17.0)
    assert kernels._compilations.seconds >= 14.0
