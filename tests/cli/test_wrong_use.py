"""Wrong input, full disks, interrupts and closed pipes: one message, the right code, nothing half-written."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import hognose
from hognose.cli import main

HOGNOSE = Path(sys.executable).with_name("hognose")

WRONG: dict[str, tuple[list[str], str]] = {
    "an unknown command": (["plam", "pipe-tank"], "plam"),
    "an unknown option": (["plan", "pipe-tank", "--colour"], "--colour"),
    "no task": (["plan"], "TASK"),
    "too many arguments": (["check", "a.parquet", "b.parquet"], "b.parquet"),
    "an option without value": (["plan", "pipe-tank", "-o"], "-o"),
    "an unknown task": (["plan", "pipetank"], "Did you mean 'pipe-tank'?"),
    "an unknown task to check": (["check", "detur"], "Did you mean 'detour'?"),
    "a missing plan": (["check", "none.parquet"], "none.parquet: no such file"),
    "a missing plan to export": (["export", "none.parquet", "-o", "x.csv"], "none.parquet: no such file"),
    "a missing task": (["plan", "none.toml"], "none.toml: no such file"),
    "no output to export": (["export", "none.parquet"], "output"),
    "an unknown robot": (["robot", "sjtu"], "no bundled robot of that name"),
    "a missing robot": (["robot", "none.toml"], "none.toml: no such file"),
    "an empty name": (["plan", ""], "expected the name of a file"),
    "a folder": (["plan", "."], "is a folder"),
    "a faulty task": (["plan", "MADE/wrong.toml"], "margin: input should be greater than or equal to 0, got -5.0"),
    "a cut plan": (["check", "MADE/cut.parquet"], "not a plan file, or one that was cut"),
    "a cut plan to export": (["export", "MADE/cut.parquet", "-o", "x.csv"], "not a plan file, or one that was cut"),
    "a missing plan to report": (["report", "none.parquet"], "none.parquet: no such file"),
    "an unknown method": (["plan", "pipe-tank", "--method", "exakt"], "did you mean 'exact'"),
    "no such folder": (["plan", "pipe-tank", "-o", "none/plan.parquet"], "cannot write: there is no folder"),
    "no such folder to export": (["export", "MADE/good.parquet", "-o", "none/x.csv"], "cannot write: No such file"),
    "a device that is full": (
        ["plan", "pipe-tank", "-o", "/dev/full/plan.parquet"],
        "cannot write: there is no folder",
    ),
    "a read-only folder": (["plan", "pipe-tank", "-o", "/proc/plan.parquet"], "/proc/plan.parquet: cannot write"),
    "a folder as output": (["plan", "pipe-tank", "-o", "."], "must end in .parquet"),
    "a name too long": (["plan", "n" * 300], "n" * 300),
    "a name too long as output": (["plan", "pipe-tank", "-o", "n" * 300 + ".parquet"], "File name too long"),
    "a name too long for a robot": (["robot", "n" * 300], "n" * 300),
}


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("use", list(WRONG))
def test_wrong_input_ends_with_2_and_one_message(run, made, tmp_path, use, as_json):
    tokens, reason = WRONG[use]
    tokens = [token.replace("MADE", str(made)) for token in tokens]
    done = run(*tokens[:1], *(["--json"] if as_json else []), *tokens[1:])
    assert done.code == 2
    if as_json:
        assert done.err == ""
        assert set(done.json) == {"good", "exit_code", "error"}
        assert (done.json["good"], done.json["exit_code"]) == (False, 2)
        assert reason in done.json["error"]
    else:
        assert done.out == ""
        assert done.err.startswith("hognose: ")
        assert reason in done.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("command", ["plan", "check", "export"])
def test_what_cannot_be_reached_ends_with_1_and_one_message(run, made, tmp_path, command, as_json):
    more = ["-o", "x.csv"] if command == "export" else []
    done = run(command, made / "far.toml", *more, *(["--json"] if as_json else []))
    assert done.code == 1
    if as_json:
        assert (done.json["good"], done.json["exit_code"], done.err) == (False, 1, "")
    else:
        assert (done.out, done.err[:9]) == ("", "hognose: ")
    assert not list(tmp_path.iterdir())


def test_export_of_a_task_that_cannot_be_planned_well_ends_with_1(run, made, tmp_path):
    done = run("export", made / "tight.toml", "-o", "x.csv", "--json")
    assert (done.code, done.json["good"]) == (1, False)


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("command", ["plan", "check", "export"])
def test_an_interrupt_ends_with_130(run, made, tmp_path, monkeypatch, command, as_json):
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("hognose.planning.planner.method_of", interrupted)
    more = ["-o", "x.csv"] if command == "export" else []
    done = run(command, made / "good.toml", *more, *(["--json"] if as_json else []))
    assert done.code == 130
    if as_json:
        assert done.json == {"good": False, "exit_code": 130, "error": "interrupted; files written so far are whole"}
    else:
        assert (done.out, done.err) == ("", "hognose: interrupted; files written so far are whole\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("as_json", [False, True])
def test_a_full_disk_ends_with_2_and_leaves_the_old_file(run, made, tmp_path, monkeypatch, as_json):
    (tmp_path / "good.parquet").write_bytes(b"old")

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    done = run("plan", made / "good.toml", *(["--json"] if as_json else []))
    assert done.code == 2
    assert "No space left on device. Nothing was written." in (done.json["error"] if as_json else done.err)
    assert (tmp_path / "good.parquet").read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["good.parquet"]


def test_arguments_come_from_the_command_line_by_default(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["hognose", "methods"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    assert "exact" in capsys.readouterr().out


#: With and without a buffer between the program and its output: they fail at different places.
buffers = pytest.mark.parametrize("buffered", [True, False])


def shell(script: str, folder: Path, buffered: bool = True) -> subprocess.CompletedProcess[str]:
    """Run a line of bash in which HOGNOSE is the installed program; its code is that of the first that fails."""
    environment = {**os.environ, "COLUMNS": "200", "PYTHONUNBUFFERED": "" if buffered else "1"}
    line = f"set -o pipefail; {script.replace('HOGNOSE', str(HOGNOSE))}"
    return subprocess.run(
        ["bash", "-c", line], cwd=folder, capture_output=True, text=True, check=False, env=environment
    )


@buffers
@pytest.mark.parametrize(
    ("command", "reader"),
    [("robot sjtu-25dof", "head -1"), ("robot sjtu-25dof", "true"), ("plan none.toml --json", "true")],
)
def test_a_pipe_that_closes_is_no_error(tmp_path, command, reader, buffered):
    done = shell(f"HOGNOSE {command} | {reader}", tmp_path, buffered)
    assert done.stderr in ("", "hognose: none.toml: no such file\n" if "none" in command else "")
    assert done.returncode == (2 if "none" in command else 0)
    assert done.stdout.count("\n") == (1 if reader == "head -1" else 0)


@buffers
@pytest.mark.parametrize("command", ["robot sjtu-25dof", "robot --json"])
def test_output_that_goes_nowhere_is_told(tmp_path, command, buffered):
    done = shell(f"HOGNOSE {command} > /dev/full", tmp_path, buffered)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "--json" in command or "No space left on device" in done.stderr


@pytest.mark.parametrize("command", ["methods", "methods --json", "robot none", "plan none.toml --json", "plan --json"])
def test_the_installed_program_says_the_same_as_main(run, tmp_path, command):
    here = run(*command.split())
    there = shell(f"HOGNOSE {command}", tmp_path)
    assert (there.returncode, there.stdout, there.stderr) == (here.code, here.out, here.err)


def test_the_module_runs_as_the_program_does(tmp_path):
    done = shell(f"{sys.executable} -m hognose.cli --version", tmp_path)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, hognose.__version__, "")


def test_a_real_interrupt_ends_with_130(tmp_path, made):
    """Sent as soon as the planning has begun, which the program shows by its stage."""
    script = (
        "import signal, threading, hognose.planning.planner as p\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # which is ignored below a shell's background job
        "def slowly(*a):\n"
        "    print('begun', flush=True)\n"
        "    threading.Event().wait()\n"
        "p.method_of = slowly\n"
        "from hognose.cli import main\n"
        f"main(['plan', {str(made / 'good.toml')!r}])\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate()
    assert process.returncode == 130
    assert err == "hognose: interrupted; files written so far are whole\n"
    assert not list(tmp_path.iterdir())
