"""`hognose` as a process: streams that are closed or full, interrupts at any moment, strange surroundings."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

HOGNOSE = [sys.executable, "-m", "hognose.cli"]
INTERRUPTED = "hognose: interrupted; files written so far are whole\n"
AS_JSON = '{"good": false, "exit_code": 130, "error": "interrupted; files written so far are whole"}\n'
#: Control characters that a terminal obeys, but for the line feed.
OBEYED = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]")


def shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a line of bash in which HOGNOSE is the command."""
    line = "set -o pipefail; " + line.replace("HOGNOSE", f"'{sys.executable}' -m hognose.cli")
    return subprocess.run(
        ["bash", "-c", line],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environment},
        errors="surrogateescape",
    )


#: A command, the code it ends with, whether its output is all there is of it, and whether it complains.
COMMANDS = {
    "robot --json": (0, True, False),
    "--help": (0, True, False),
    "nonsense": (2, False, True),
    "check MADE/tight.parquet": (1, False, False),
}
CLOSED = {"stdout closed": ">&-", "both closed": ">&- 2>&-", "all closed": "<&- >&- 2>&-", "stdout full": "> /dev/full"}
LISTENED = {"stderr closed": "2>&-", "stderr full": "2> /dev/full", "nobody reads": "| true"}


@pytest.fixture(scope="session")
def plans(made, tmp_path_factory) -> Path:
    """A folder with the plan of a task that cannot be done well, beside the good one."""
    import hognose

    folder = tmp_path_factory.mktemp("plans")
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(hognose.load_task(made / "tight.toml"))
    caught.value.plan.save(folder / "tight.parquet")
    (folder / "good.parquet").write_bytes((made / "good.parquet").read_bytes())
    return folder


@pytest.mark.parametrize("command", list(COMMANDS))
def test_the_code_is_true_whatever_becomes_of_the_output(command, plans, tmp_path):
    code, is_all, complains = COMMANDS[command]
    ways = {**CLOSED, **LISTENED}
    if command not in ("--help", "nonsense"):  # they take longest, and end as these do
        ways = {where: ways[where] for where in ("all closed", "stdout full", "nobody reads")}
    for where, redirection in ways.items():
        done = shell(f"HOGNOSE {command.replace('MADE', str(plans))} {redirection}", tmp_path)
        assert done.returncode == (2 if is_all and where in CLOSED else code), (where, done)
        assert "Traceback" not in done.stderr
        lost = where in ("stdout closed", "stdout full") and not complains
        told = "hognose: output: it is closed\n" if where == "stdout closed" else "hognose: output: No space left"
        assert (told in done.stderr) == lost, (where, done.stderr)
    assert not list(tmp_path.iterdir())


def test_a_plan_is_written_though_nobody_listens(made, tmp_path):
    """And no stream's number is given to a file: what is printed would end up in it."""
    loud = shell(f"HOGNOSE plan {made}/tight.toml -o loud.parquet", tmp_path)
    quiet = shell(f"HOGNOSE plan {made}/tight.toml -o quiet.parquet <&- >&- 2>&-", tmp_path)
    assert (loud.returncode, quiet.returncode) == (1, 1)
    assert (tmp_path / "quiet.parquet").read_bytes() == (tmp_path / "loud.parquet").read_bytes()


#: Says through a pipe that Ctrl-C is in the program's hands, which is the first thing that it sees to.
READY = """
import os, signal, sys
install = signal.signal
def told(*given):
    install(*given)
    os.write(int(os.environ["TELL"]), b"R")
signal.signal = told
from hognose.cli import entry_point
entry_point()
"""


@pytest.mark.parametrize("command", ["methods --json", "check MADE/good.parquet"])
def test_an_interrupt_at_any_moment_is_one_line_and_130(command, plans, tmp_path):
    tokens = command.replace("MADE", str(plans)).split()
    for number in range(5):
        heard, tell = os.pipe()
        with subprocess.Popen(
            [sys.executable, "-c", READY, *tokens], cwd=tmp_path, pass_fds=[tell],
            env={**os.environ, "TELL": str(tell)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        ) as process:  # fmt: skip
            os.close(tell)
            assert os.read(heard, 1) == b"R"
            os.close(heard)
            time.sleep(0.05 * number**1.7)  # anywhere in its life, or after it
            process.send_signal(signal.SIGINT)
            out, err = process.communicate()
        assert process.returncode in (0, 130), err
        if process.returncode == 0:
            assert err == ""
        elif "--json" in tokens:
            assert (out, err) == (AS_JSON, "")
        else:
            assert err == INTERRUPTED


#: Where an interrupt may strike, as a module that stands for one of the libraries.
STRUCK = {
    "in an import": "import os, signal; os.kill(os.getpid(), signal.SIGINT)\nwhile True: pass",
    "where a library takes any exception for its own": (
        "try:\n    import os, signal; os.kill(os.getpid(), signal.SIGINT)\n    while True: pass\n"
        "except BaseException:\n    raise ImportError('numpy.core.multiarray failed to import')"
    ),
    "in a destructor": (
        "import os, signal\nclass A:\n    def __del__(self):\n        os.kill(os.getpid(), signal.SIGINT)\n"
        "        while True: pass\ndef App(*a, **k):\n    A()\n    while True: pass\n"
        "class CycloptsError(Exception): pass\ndef Parameter(*a, **k): pass\nclass validators: Number = Parameter"
    ),
}


@pytest.mark.parametrize("options", [[], ["--json"]])
@pytest.mark.parametrize("where", list(STRUCK))
def test_libraries_do_not_get_to_see_an_interrupt(where, options, tmp_path):
    (tmp_path / "cyclopts.py").write_text(STRUCK[where])
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [*HOGNOSE, "robot", *options], capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, "PYTHONPATH": path},
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (130, *((AS_JSON, "") if options else ("", INTERRUPTED)))


#: What a machine may look like that is nothing like ours.
SURROUNDINGS: dict[str, dict[str, str]] = {
    "no home, plain C": {
        "HOME": "/dev/null",
        "XDG_CACHE_HOME": "/dev/null",
        "XDG_CONFIG_HOME": "/dev/null",
        "TMPDIR": "/dev/null",
        "LANG": "C",
        "LC_ALL": "C",
        "PYTHONUTF8": "0",
        "PYTHONCOERCECLOCALE": "0",
        "TERM": "dumb",
    },
    "warnings are errors": {"PYTHONWARNINGS": "error", "PYTHONDEVMODE": "1"},
    "settings for others": {"MPLBACKEND": "nonsense", "COLUMNS": "0", "MATPLOTLIBRC": "rc", "FORCE_COLOR": "1"},
}


@pytest.mark.parametrize("surroundings", list(SURROUNDINGS))
def test_nothing_but_ours_is_said_on_any_machine(surroundings, plans, tmp_path):
    (tmp_path / "rc").write_text("nonsense.key : 3\nfont.family : nothing\nfigure.dpi : abc\n")
    environment = {**SURROUNDINGS[surroundings]}
    if "MATPLOTLIBRC" in environment:
        environment["MATPLOTLIBRC"] = str(tmp_path / "rc")
    for command in ("--help", f"report {plans}/good.parquet --no-animation -o page.html"):
        done = shell(f"HOGNOSE {command}", tmp_path, **environment)
        assert (done.returncode, done.stderr) == (0, "")
        assert len(done.stdout) > 10


def test_a_narrow_terminal_shows_all_of_it(tmp_path):
    for columns in ("1",):
        child, terminal = pty.fork()
        if not child:
            os.environ.update(COLUMNS=columns, TERM="dumb")
            os.execv(sys.executable, [*HOGNOSE, "robot"])
        shown = b""
        try:
            while part := os.read(terminal, 65536):
                shown += part
        except OSError:  # how a terminal ends on Linux
            pass
        os.close(terminal)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert "sjtu-25dof-99" in shown.decode()


RED = "\x1b[31mred\x9b1m\x7f\r\u202e"


def test_nothing_that_is_printed_steers_the_terminal(run, tmp_path):
    (tmp_path / f"{RED}.toml").write_text('name = "x"\n')
    (tmp_path / f"{RED}.off").write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    keys = RED.replace("\x1b", "\\u001b").replace("\x9b", "\\u009b").replace("\x7f", "\\u007f").replace("\r", "\\r")
    (tmp_path / "keys.toml").write_text(f'units = "mm"\n"{keys}" = 1\n[["{keys}".x]]\nkind = "{keys}"\n', "utf-8")
    uses = [
        ["plan", f"{RED}.toml"], ["plan", RED], ["robot", RED], [RED], ["plan", "x", f"--{RED}"], ["plan", "keys.toml"],
        ["robot", "keys.toml"], ["check", f"{RED}.parquet"], ["scene", f"{RED}.off", "--units", "mm"],
        ["scene", f"{RED}.stl"], ["export", "detour", "-o", f"{RED}.x"], ["plan", "detour", "--method", RED],
        ["view", RED, "--no-browser"], ["view", f"{RED}.off", "--no-browser"],
    ]  # fmt: skip
    for use in uses:
        for options in ([], ["--json"]):
            done = run(*use, *options)
            said = done.out + done.err
            assert said
            assert not OBEYED.search(said), (use, said)
            assert "\u202e" not in said
