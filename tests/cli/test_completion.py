"""Shell completion: the scripts, and what they ask the program."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hognose.bundled import OWN_ROBOTS
from hognose.files import bundled_robots, bundled_tasks

FOLDER = Path(sys.executable).parent


@pytest.fixture
def home(tmp_path, monkeypatch) -> Path:
    """A home of its own, with some files in the current folder."""
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    (tmp_path / "far" / "away").mkdir(parents=True)
    for name in ("mine.toml", "my plan.parquet", "tank.STEP", "notes.txt", "far/away/deep.toml", ".hidden.toml"):
        (tmp_path / name).touch()
    return tmp_path / "home"


def completed(script: Path, *words: str) -> set[str]:
    """What bash would complete the last of some words to."""
    line = (
        f'source "{script}"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _hognose; '
        'for word in "${COMPREPLY[@]}"; do printf "%s\\n" "$word"; done'
    )
    environment = {**os.environ, "PATH": f"{FOLDER}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "--norc", "-c", line, "bash", "hognose", *words],
        capture_output=True, text=True, check=True, env=environment,
    )  # fmt: skip
    assert done.stderr == ""
    return set(done.stdout.splitlines())


def test_bash_completes_commands_options_names_and_files(run, home):
    assert run("--install-completion", "--shell", "bash").code == 0
    script = home / ".local/share/bash-completion/completions/hognose"
    sjtu = {name for name in bundled_robots() if name.startswith("sjtu")}
    assert completed(script, "pl") == {"plan"}
    assert {"new", "plan", "check", "robot"} <= completed(script, "")
    assert completed(script, "new", "a.toml", "--sp") == {"--space", "--space-units"}
    assert completed(script, "new", "a.toml", "--units", "") == {"mm", "cm", "m", "in"}
    assert completed(script, "new", "a.toml", "--entrance", "0", "0", "-1", "--robot", "sjtu") == sjtu
    assert completed(script, "plan", "") == {*bundled_tasks(), "mine.toml", "far/", "home/"}
    assert completed(script, "plan", "fa") == {"far/away/deep.toml"}
    assert completed(script, "check", "m") == {"moving-obstacles", "mine.toml", "my\\ plan.parquet"}
    assert completed(script, "scene", "t") == {"tank.STEP", "tolerances"}
    assert completed(script, "robot", "s") == sjtu
    assert completed(script, "plan", "none/") == set()


@pytest.mark.parametrize(
    ("shell", "file", "begin"),
    [
        ("bash", ".local/share/bash-completion/completions/hognose", "# Bash completion for hognose"),
        ("zsh", ".zsh/completions/_cyclopts_hognose", "#compdef hognose"),
        ("fish", ".config/fish/completions/hognose.fish", "# Fish completion for hognose"),
    ],
)
def test_a_script_is_put_where_its_shell_looks_for_it(run, home, monkeypatch, shell, file, begin):
    monkeypatch.setenv("SHELL", f"/usr/bin/{shell}")
    done = run("--install-completion")
    assert (done.code, done.err) == (0, "")
    assert f"written to {home / file}" in done.out
    text = (home / file).read_text()
    assert text.startswith(begin)
    assert "__complete" in text
    assert run("--install-completion", "--shell", shell, "-o", "here").code == 0
    assert Path("here").read_text() == text
    assert [each.name for each in home.iterdir()] == [Path(file).parts[0]], "nothing else in the home is touched"


def test_zsh_calls_the_function_by_the_name_of_its_file(run, home):
    assert run("--install-completion", "--shell", "zsh").code == 0
    (file,) = (home / ".zsh" / "completions").iterdir()
    assert f"\n{file.name}() {{\n" in file.read_text()


@pytest.mark.parametrize(("named", "said"), [("/bin/tcsh", "tcsh"), ("", "no shell")])
def test_a_shell_that_is_not_known_is_asked_for(run, home, monkeypatch, named, said):
    monkeypatch.setenv("SHELL", named)
    done = run("--install-completion")
    assert done.code == 2
    assert f"--shell: $SHELL names {said}, expected one of bash, zsh, fish; give --shell" in done.err
    assert not list(home.iterdir())


def test_a_script_that_cannot_be_written_is_said(run, home):
    done = run("--install-completion", "--shell", "bash", "-o", "mine.toml/script")
    assert done.code == 2
    assert "mine.toml/script: cannot write: there is no folder mine.toml; make it first" in done.err


def test_the_names_are_known_without_loading_what_plans():
    """Else every key press would take a second."""
    script = (
        "import sys; from hognose.cli.running import run; "
        "assert run(['__complete', 'plan', 'pipe']) == 0; "
        "print(*sorted({'numpy', 'numba', 'pydantic'} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert set(bundled_tasks()) <= set(done.stdout.split())
    assert done.stderr.split() == []


def test_own_robots_are_the_bundled_ones():
    assert tuple(OWN_ROBOTS) == bundled_robots()


def test_a_folder_that_was_named_is_not_made(run, tmp_path):
    done = run("--install-completion", "--shell", "bash", "-o", "none/script")
    assert done.code == 2
    assert "none/script: cannot write: there is no folder none; make it first" in done.err
    assert not (tmp_path / "none").exists()
