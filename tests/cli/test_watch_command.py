"""`hognose watch`: a run in another terminal, with keys; in lines and as JSON where there is none."""

from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from live_makers import OPENING, Watched, address, put_cycle, put_event, row, until

import hognose
from hognose.cli.keys import NoKeys, keys
from hognose.cli.watching import KEYS, screen
from hognose.drive.live.address import Address
from hognose.drive.live.frames import Message
from hognose.drive.live.seen import Seen
from hognose.drive.live.server import Limits, Live
from hognose.drive.record import read_record
from hognose.drive.record.messages import cycle_message
from hognose.drive.wishes import Want, Wishes


def beside(play: Callable[[Live], object], folder: Path, good: bool | None = True) -> threading.Thread:
    """A run in a thread, that goes on once somebody follows it; its file is there when this returns."""
    live = Live(OPENING, Wishes(), Limits(farewell_s=10.0))
    address(live, folder).write()

    def go():
        until(lambda: live.is_followed)
        play(live)
        if good is not None:
            put_event(live, 9.0, "verdict", "GOOD: at step 100" if good else "NOT GOOD: node 12 failed")
        live.close()

    thread = threading.Thread(target=go)
    thread.start()
    return thread


def ten_cycles(live: Live) -> None:
    for number in range(100):
        put_cycle(live, number)
        if number == 50:
            put_event(live, 1.5, "trouble", "cable 2 \x1b[2J pulls too much")


@pytest.mark.parametrize("good", [True, False])
def test_a_run_in_lines(run, tmp_path, good):
    thread = beside(ten_cycles, tmp_path, good)
    done = run("watch")
    thread.join()
    assert (done.code, done.err) == (0 if good else 1, "")
    lines = done.out.splitlines()
    assert lines[0] == "bench, arm: run.mcap"
    assert lines[1].startswith(
        "    0.000 s  RUN, step 0.0 of 100; tensions 40 N (cable 1) to 42 N (cable 3), band ±20 N"
    )
    assert len([line for line in lines if " s  RUN, " in line]) == 3, "one a second"
    assert "    1.500 s  trouble, node 12, step 2.0: cable 2 \\x1b[2J pulls too much" in lines
    verdict = "GOOD: at step 100" if good else "NOT GOOD: node 12 failed"
    assert lines[-3:] == [f"    9.000 s  verdict, node 12, step 2.0: {verdict}", verdict,
                          "`hognose log run.mcap` reads its record"]  # fmt: skip


def test_a_run_as_json(run, tmp_path):
    thread = beside(ten_cycles, tmp_path)
    done = run("watch", "run.mcap", "--json", "--every", "0.3")
    thread.join()
    assert (done.code, done.err) == (0, "")
    said = [json.loads(line) for line in done.out.splitlines()]
    assert said[0]["kind"] == "run"
    assert "token" not in done.out
    cycles = [each for each in said if each["kind"] == "cycle"]
    assert [each["time_s"] for each in cycles] == pytest.approx([0.3 * k for k in range(10)])
    assert cycles[-1] == {
        "kind": "cycle",
        "time_s": pytest.approx(2.7),
        "state": "RUN",
        "step": pytest.approx(18.0),
        "steps": 100,
        "speed": pytest.approx(1.0),
        "least_tension_N": {"value": 40.0, "cable": 1},
        "largest_tension_N": {"value": 42.0, "cable": 3},
        "largest_following_error_counts": {"value": -7.0, "cable": 2, "node": 12},
        "slider_commanded_m": 0.1,
        "slider_measured_m": 0.1001,
        "lateness_s": 4e-4,
        "pictures": 0,
        "left_out": 0,
    }
    assert [each["event"] for each in said if each["kind"] == "event"] == ["trouble", "verdict"]
    assert said[-1] == {
        "kind": "end", "good": True, "verdict": "GOOD: at step 100", "lost": False,
        "words": "GOOD: at step 100\n`hognose log run.mcap` reads its record",
    }  # fmt: skip


def test_a_run_that_ends_without_a_verdict_is_not_good(run, tmp_path):
    thread = beside(ten_cycles, tmp_path, None)
    done = run("watch")
    thread.join()
    assert done.code == 1
    assert "NOT GOOD: the run ended without a verdict" in done.out


CHILD = """
import os, time
from pathlib import Path
from live_makers import OPENING, put_cycle, until
from hognose.drive.live.address import Address
from hognose.drive.live.server import Live
from hognose.drive.wishes import Wishes
live = Live(OPENING, Wishes())
Address(live.port, live.token, os.getpid(), Path("run.mcap")).write()
print("there", flush=True)
until(lambda: live.is_followed)
put_cycle(live, 1)
until(lambda: all(each.is_idle for each in live._visitors))
print("followed", flush=True)
time.sleep(600)
"""


def test_a_program_that_was_killed_is_said_to_be_gone(run, tmp_path):
    source, makers = Path(hognose.__file__).parents[1], Path(__file__).parents[1] / "drive"
    environment = os.environ | {"PYTHONPATH": f"{source}{os.pathsep}{makers}"}
    child = subprocess.Popen([sys.executable, "-c", CHILD], stdout=subprocess.PIPE, text=True, env=environment)
    assert child.stdout is not None
    assert child.stdout.readline() == "there\n"

    def kill():
        assert child.stdout is not None
        assert child.stdout.readline() == "followed\n"
        child.kill()
        child.wait()

    thread = threading.Thread(target=kill)
    thread.start()
    done = run("watch")
    thread.join()
    child.stdout.close()
    assert done.code == 1
    assert "the program of the run is gone, and said no verdict. Drives that miss its heartbeats for 100 ms" in done.out
    again = run("watch", "run.mcap")
    assert again.code == 2
    assert f"its program (process {child.pid}) is gone; its end was not recorded" in again.err


def test_a_connection_that_was_lost_is_told_from_a_run_that_is_gone(run, tmp_path):
    def cut(live: Live) -> None:
        for visitor in live._visitors:
            visitor.socket.shutdown(socket.SHUT_RDWR)
        until(lambda: live._came == 2)

    thread = beside(cut, tmp_path, None)
    done = run("watch")
    thread.join()
    assert done.code == 1
    assert done.out.splitlines()[-1] == "the connection to the run was lost, but it goes on: `hognose watch run.mcap`"


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        ((), "nothing runs in this folder"),
        (("none.mcap",), "none.mcap.live.json: no run can be followed there"),
        (("--every", "-1"), "every: expected seconds, 0 or more"),
    ],
)
def test_wrong_use_is_said(run, tokens, said):
    done = run("watch", *tokens)
    assert (done.code, done.out) == (2, "")
    assert said in done.err


def test_a_run_is_found_behind_one_that_is_gone(run, tmp_path):
    thread = beside(ten_cycles, tmp_path)
    newer = Address(1, "t", 1, tmp_path / "newer.mcap")
    newer.write()
    os.utime(newer.file, (4e9, 4e9))
    done = run("watch")
    thread.join()
    assert (done.code, done.out.splitlines()[-2]) == (0, "GOOD: at step 100")


def test_a_run_on_emulated_drives_is_followed(run, tmp_path):
    rig = Watched()

    def go():
        with rig.recorded(tmp_path / "rig.mcap", Wishes()) as (writer, live):
            there.set()
            until(lambda: live.is_followed)
            rig.ready().executor.run(2.0)
            writer.close("GOOD: at step 2")

    there = threading.Event()
    thread = threading.Thread(target=go)
    thread.start()
    there.wait(60.0)
    done = run("watch", "rig.mcap", "--every", "0")
    thread.join()
    assert (done.code, done.err) == (0, "")
    words = re.findall(r"(?m)^ *[0-9.]+ s  (\w+)", done.out)
    events = [each for each in words if each.islower()]
    assert events[:7] == ["armed", "hold", "tension", "ready", "prefill", "run", "held"]
    assert words.count("RUN") == len(read_record("rig.mcap").cycles) - words.count("TENSION") > 10
    assert done.out.splitlines()[-2] == "GOOD: at step 2"


def test_the_screen():
    seen = Seen(OPENING)
    assert screen(seen)[2] == "no cycle yet"
    for number in range(40, 51):
        seen.add(Message("/state", 0, cycle_message(0, row(number))))
    seen.add({"kind": "left out", "cycles": 3, "pictures": 0})
    seen.add(Message("/tip_camera", 0, b""))
    assert screen(seen) == [
        "bench, arm: run.mcap",
        "[###...........................] 1.5 s",
        "RUN, step 10.0 of 100 at 100 % of the plan's speed",
        "tensions 40 N (cable 1) to 42 N (cable 3), band ±20 N around the plan's",
        "largest following error -7 counts (cable 2), node 12",
        "slider 100.00 mm, measured 100.10 mm",
        "0.40 ms late, 3 cycles were not seen here",
        "1 pictures of the tip camera",
        "",
    ]
    assert seen.good is False


posix = sys.platform != "win32"


@pytest.mark.skipif(not posix, reason="a terminal of POSIX")
def test_keys_ask_for_things_and_the_terminal_is_as_it_was(tmp_path):
    import pty
    import termios

    wishes, live_file = Wishes(), tmp_path / "run.mcap.live.json"
    live = Live(OPENING, wishes, Limits(farewell_s=0.2))
    address(live, tmp_path).write()
    put_cycle(live, 5)
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    command = [sys.executable, "-m", "hognose.cli", "watch", str(live_file)]
    source = str(Path(hognose.__file__).parents[1])
    environment = os.environ | {"PYTHONPATH": source, "COLUMNS": "200"}
    child = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=environment, start_new_session=True)
    shown = b""

    def see(words: str) -> None:
        nonlocal shown
        while words.encode() not in shown:
            shown += os.read(master, 1 << 16)

    see(KEYS)
    see("RUN, step 1.0 of 100")
    assert not termios.tcgetattr(slave)[3] & termios.ICANON
    for key, want in (("p", Want.PAUSE), (" ", Want.STOP), ("s", Want.STOP), ("r", Want.RETRACT)):
        os.write(master, key.encode())
        came = []
        until(lambda came=came: came.extend([wish] if (wish := wishes.take()) else []) or came)
        assert [(wish.want, wish.who) for wish in came] == [(want, "follower 1 (hognose watch)")]
    see("retract: asked for; it has to be confirmed at the terminal of the run")
    os.write(master, b"xq")
    see("left: the run goes on")
    assert child.wait(60.0) == 0
    assert termios.tcgetattr(slave) == before
    assert wishes.take() is None
    until(lambda: not live.is_followed)
    live.close()
    os.close(master)
    os.close(slave)


@pytest.mark.skipif(not posix, reason="a terminal of POSIX")
def test_the_terminal_is_as_it_was_also_after_an_error(monkeypatch):
    import pty
    import termios

    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)

    def fail():
        with keys() as keyboard:
            assert keyboard.works
            os.write(master, b"ab")
            assert keyboard.pressed() == "ab"
            assert keyboard.pressed() == ""
            raise ZeroDivisionError

    with os.fdopen(slave, closefd=False) as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        with pytest.raises(ZeroDivisionError):
            fail()
    assert termios.tcgetattr(slave) == before
    os.close(slave)
    os.close(master)


def test_without_a_keyboard_no_key_is_pressed(monkeypatch):
    with open(os.devnull) as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        with keys() as keyboard:
            assert type(keyboard) is NoKeys
            assert (keyboard.pressed(), keyboard.sources, keyboard.works) == ("", [], False)
