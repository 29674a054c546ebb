"""`hognose run`: on emulated drives, with a record; nothing moves without a confirmation."""

import json
import multiprocessing
import os
import pty
import re
import select
import signal
import socket
import subprocess
import sys
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

import hognose
from hognose.cli.operate import _power
from hognose.drive.cia402 import State
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.process import _serve
from hognose.drive.executor import Executor
from hognose.drive.network import emulated_network


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("run") / "boards.parquet"
    hognose.plan(hognose.load_task("obstacle-array")).save(file)
    return file


def test_a_plan_is_run_there_and_back_and_recorded(run, plan_file, tmp_path):
    record = tmp_path / "there.mcap"
    far = ("--until", "6", "--back", "--yes", "--json")
    done = run("run", plan_file, "--emulated", "--fast", *far, "--record", record)
    assert (done.code, done.err) == (0, "")
    said = json.loads(done.out)
    assert (said["good"], said["step"], said["trouble"], said["record"]) == (True, 0.0, None, str(record))
    assert said["commanded_counts"] == said["measured_counts"]
    assert 0.0 <= said["tip_off_m"] < 5e-4
    np.testing.assert_allclose(said["tip_m"], said["tip_planned_m"], atol=5e-4)
    log = run("log", record, "--json")
    assert log.code == 0
    recorded = json.loads(log.out)
    assert recorded["verdict"] == "GOOD: at step 0"
    assert (recorded["cycles"], recorded["pictures"]) == (said["cycles"], said["pictures"])
    assert said["pictures"] > 1


def test_what_happens_is_said(run, plan_file, tmp_path):
    done = run(
        "run",
        plan_file,
        "--emulated",
        "--without-twin",
        "--fast",
        "--until",
        "2",
        "--yes",
        "--record",
        tmp_path / "a.mcap",
    )
    assert done.code == 0
    words = [line.split()[0] for line in done.out.splitlines()]
    assert words[:6] == ["ARMED", "HOLD", "TENSION", "READY", "PREFILL", "RUN"]
    assert done.out.splitlines()[-1] == "GOOD: at step 2"


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        ((), "give either --network FILE, for drives that are there, or --emulated; neither is given"),
        (("--emulated", "--network", "net.toml"), "net.toml"),
        (("--network", "net.toml", "--fast"), "--fast goes with --emulated"),
        (("--network", "net.toml"), "net.toml"),
        (("--emulated", "--fast", "--without-twin", "--yes", "--release"), "--release goes with --back"),
        (("--emulated", "--fast", "--speed", "0"), "speed: expected per cent of the plan's own"),
        (("--emulated", "--fast", "--without-twin"), "moves only after a confirmation at a terminal; give --yes"),
        (("--emulated", "--fast", "--without-twin", "--yes", "--until", "999"), "until: expected a step from 0 to 312"),
    ],
)
def test_wrong_use_is_said(run, plan_file, tmp_path, tokens, said):
    done = run("run", plan_file, "--record", tmp_path / "a.mcap", *tokens)
    assert done.code == 2
    assert said in done.err


def test_a_plan_that_is_not_good_is_not_run(run, tmp_path):
    task = tmp_path / "tight.toml"
    text = hognose.bundled.bundled_tasks()["obstacle-array"].read_text()
    wider = re.sub(r"(?m)^margin = .*$", "margin = 20.0", text)
    task.write_text(wider.replace("[path]\n", "[path]\ndetour = false\n", 1))
    done = run("run", task, "--emulated", "--fast", "--without-twin", "--yes", "--record", tmp_path / "a.mcap")
    assert done.code == 2
    assert "the plan is not good, and is not run" in done.err
    assert not (tmp_path / "a.mcap").exists()


def test_drives_that_are_there_do_something_only_after_a_confirmation_at_a_terminal(run, plan_file, tmp_path):
    file, nodes = tmp_path / "net.toml", list(range(1, 37))
    file.write_text(
        'schema = 1\nunits = "mm"\nname = "a"\nrobot = "sjtu-25dof"\n[bus]\ninterface = "socketcan"\n'
        f'channel = "can0"\n[drives]\nnodes = {nodes}\nnewton_per_unit = 0.1\n'
        '[slider]\nkind = "epos2"\nnode = 40\ncounts_per_metre = 1e6\n'
    )
    done = run("run", plan_file, "--network", file, "--yes", "--record", tmp_path / "a.mcap")
    assert done.code == 2
    assert "drives on socketcan are not emulated: they do something only after a confirmation at a" in done.err
    assert not (tmp_path / "a.mcap").exists()
    home = run("home", plan_file, "--network", file, "--yes")
    assert (home.code, "only after a confirmation at a terminal, without --yes" in home.err) == (2, True)
    for option, why in (
        ("--without-twin", "are watched"),
        ("--fast", "take their time"),
        ("--fault=9:stuck", "fail by"),
    ):
        refused = run("run", plan_file, "--network", file, option, "--record", tmp_path / "a.mcap")
        assert (refused.code, "goes with" in refused.err, why in refused.err) == (2, True, True)
    attended = run("run", plan_file, "--network", file, "--record", tmp_path / "a.mcap")
    assert (attended.code, "channel 'can0': cannot be opened" in attended.err) == (2, True)


@pytest.mark.parametrize("fast", [True, False])
def test_the_drives_of_a_network_file_are_rehearsed_with_a_slider_on_a_serial_board(run, plan_file, tmp_path, fast):
    file, nodes = tmp_path / "net.toml", list(range(40, 76))
    file.write_text(
        'schema = 1\nunits = "mm"\nname = "a"\nrobot = "sjtu-25dof"\n[bus]\ninterface = "socketcan"\n'
        f'channel = "can0"\n[drives]\nkind = "cia402"\nnodes = {nodes}\nnewton_per_unit = 0.1\n'
        'following_error_counts = 1_000_000\n[slider]\nkind = "serial"\nport = "/dev/ttyUSB0"\n'
        "counts_per_metre = 1e6\nfollowing_error_counts = 1_000_000\n"
        "[watch]\nheartbeat_s = 0.3\nlost_after_s = 3.0\nlate_cycles = 100\n"
    )
    given = ("--until", "2", "--without-twin", "--yes", "--json", "--record", tmp_path / "a.mcap")
    done = run("run", plan_file, "--emulated", "--network", file, *given, *(["--fast"] if fast else []))
    assert (done.code, done.err) == (0, "")
    said = json.loads(done.out)
    assert len(said["commanded_counts"]) == 37
    assert said["commanded_counts"][36] == 7000
    assert abs(said["measured_counts"][36] - 7000) <= 20
    missing = run("run", plan_file, "--network", file, "--yes", "--record", tmp_path / "b.mcap")
    assert "drives on socketcan and /dev/ttyUSB0 are not emulated: they do" in missing.err
    on_hognose = file.read_text().replace("socketcan", "hognose").replace("can0", "127.0.0.1:1")
    file.write_text(on_hognose)
    real = run("run", plan_file, "--network", file, "--yes", "--record", tmp_path / "b.mcap")
    assert "drives on /dev/ttyUSB0 are not emulated" in real.err


def test_emulated_drives_say_what_a_network_file_needs(run, plan_file, tmp_path, monkeypatch):
    monkeypatch.setattr("hognose.drive.emulator.process.serve", lambda emulator, hub, board: None)
    file, nodes = tmp_path / "net.toml", list(range(1, 37))
    text = (
        'schema = 1\nunits = "mm"\nname = "a"\nrobot = "sjtu-25dof"\n[bus]\ninterface = "socketcan"\nchannel = "can0"\n'
        f'[drives]\nkind = "cia402"\nnodes = {nodes}\nnewton_per_unit = 0.1\n'
        '[slider]\nkind = "serial"\nport = "COM3"\ncounts_per_metre = 1e6\n'
    )
    file.write_text(text)
    done = run("emulate", plan_file, "--without-twin", "--network", file)
    assert done.code == 0
    assert done.out.startswith("36 drives and the board of the slider, standing where obstacle array begins.")
    assert re.search(r'\[slider\]\nkind = "serial"\nport = "socket://127\.0\.0\.1:\d+"\n$', done.out)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        file.write_text(text.replace("COM3", f"socket://localhost:{port}"))
        done = run("emulate", plan_file, "--without-twin", "--network", file)
    assert done.code == 2
    assert f"slider.port: port {port} cannot be listened on" in done.err
    assert "37 drives, standing" in run("emulate", plan_file, "--without-twin").out


def test_a_port_that_is_taken_is_said(run, plan_file):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        done = run("emulate", plan_file, "--without-twin", "--port", port)
    assert done.code == 2
    assert f"port {port}: cannot be listened on: " in done.err
    assert "port 99999: expected a number from 1 to 65535" in run("emulate", plan_file, "--port", "99999").err


def test_at_a_terminal_every_motion_is_confirmed(plan_file, tmp_path):
    answers = [("their tensions. Type yes to go: ", "yes"), (" s. Type yes to go: ", "yes")]
    answers += [("step 1.00. g: go on, s: one step, r: retract, e: end here? ", "s")]
    answers += [("step 2.00. g: go on, s: one step, r: retract, e: end here? ", "r")]
    code, said = typed(answers, plan_file, "--until", "3", "--step", "--record", tmp_path / "a.mcap")
    assert code == 1
    assert [line.split("RUN  ")[1] for line in said.splitlines() if "RUN  " in line] == [
        "from step 0.0 to 1 at 100 % of the plan's speed",
        "from step 1.0 to 2 at 100 % of the plan's speed",
        "from step 2.0 to 0 at 100 % of the plan's speed",
    ]
    assert said.splitlines()[-1] == "NOT GOOD: retracted from step 2.00, as it was asked to"


def test_what_is_not_confirmed_does_not_move(plan_file, tmp_path):
    code, said = typed([("Type yes to go: ", "y")], plan_file, "--record", tmp_path / "a.mcap")
    assert code == 2
    assert said.splitlines()[-1].endswith("not confirmed; the arm was left where it is")
    assert "HOLD" not in said


def test_what_was_typed_before_a_question_is_no_answer_to_it():
    ours, theirs = pty.openpty()
    os.write(ours, b"yes\n")
    code = (
        "from hognose.cli.terminal import TypedLines; lines = TypedLines(1.0); lines.ask('now? ')\n"
        "while (said := lines.answer()) is None: pass\nprint(said)"
    )
    source = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=source) as asks:
        os.close(theirs)
        assert asks.stdout is not None
        assert asks.stderr is not None
        assert asks.stderr.read(5) == b"now? "
        os.write(ours, b"no\n")
        assert asks.stdout.read() == b"no\n"
    os.close(ours)


def typed(answers, plan_file, *tokens):
    """Run it on emulated drives at a terminal, where answers are typed once their questions are there."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "hognose.cli", "run", plan_file, "--emulated", "--without-twin", "--fast", *tokens]
    said = b""
    with subprocess.Popen(command, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as done:
        os.close(theirs)
        assert done.stdout is not None
        for question, answer in answers:
            asked = said.count(question.encode())
            while said.count(question.encode()) == asked:
                ready, _, _ = select.select([done.stdout], [], [], 120.0)
                part = os.read(done.stdout.fileno(), 65536) if ready else b""
                if not part:
                    done.kill()
                    pytest.fail(f"{question!r} was not asked: {said.decode()}")
                said += part
            os.write(ours, f"{answer}\n".encode())
        said += done.stdout.read()
        os.close(ours)
    return done.returncode, said.decode()


def test_a_run_that_cannot_go_on_says_so_in_its_record(run, plan_file, tmp_path):
    record = tmp_path / "a.mcap"
    code, _ = typed([("Type yes to go: ", "no")], plan_file, "--record", record)
    assert code == 2
    told = json.loads(run("log", record, "--json").out)
    assert told["verdict"] == "NOT GOOD: not confirmed; the arm was left where it is. No drive has power"


def test_what_cannot_be_is_said_before_there_is_a_record(run, plan_file, tmp_path):
    record = tmp_path / "a.mcap"
    for tokens in (("--until", "400", "--yes"), ("--release", "--yes"), ()):
        assert run("run", plan_file, "--emulated", "--fast", "--without-twin", *tokens, "--record", record).code == 2
    assert not record.exists()
    done = run("run", plan_file, "--emulated", "--fast", "--without-twin", "--yes", "--record", tmp_path / "a.txt")
    assert (done.code, "must end in .mcap" in done.err) == (2, True)


def test_two_buses_are_rehearsed_in_this_program(run, plan_file, tmp_path):
    file = tmp_path / "two.toml"
    file.write_text(
        'schema = 1\nunits = "mm"\nname = "two"\nrobot = "sjtu-25dof"\n'
        '[bus]\ninterface = "socketcan"\nchannel = "can0"\n'
        f'[bus2]\ninterface = "socketcan"\nchannel = "can1"\nnodes = {list(range(19, 37))}\n'
        f"[drives]\nnodes = {list(range(1, 37))}\nnewton_per_unit = 0.1\n"
        '[slider]\nkind = "epos2"\nnode = 40\ncounts_per_metre = 1e6\n'
    )
    given = ("--until", "2", "--without-twin", "--yes", "--record", tmp_path / "a.mcap")
    done = run("run", plan_file, "--emulated", "--fast", "--network", file, *given)
    assert (done.code, done.out.splitlines()[-1]) == (0, "GOOD: at step 2")


def test_ctrl_c_at_the_terminal_does_not_reach_emulated_drives():
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(emulated_boards, theirs), daemon=True)
    process.start()
    theirs.close()
    assert ours.poll(120.0)
    ours.recv()
    assert process.pid is not None
    os.kill(process.pid, signal.SIGINT)
    ours.send(None)
    assert ours.poll(120.0)
    assert ours.recv() is None
    ours.close()
    process.join(120.0)
    assert process.exitcode == 0


def emulated_boards():
    return Emulator(emulated_network(hognose.load_robot("sjtu-25dof")))


def test_a_drive_that_is_made_to_fail_ends_the_run_and_the_arm_comes_back(run, plan_file, tmp_path):
    given = ("--emulated", "--fast", "--without-twin", "--yes", "--json", "--record", tmp_path / "a.mcap")
    done = run("run", plan_file, *given, "--until", "20", "--fault", "9:overcurrent:4", "--fault", "5:stuck:300")
    said = json.loads(done.out)
    assert done.code == 1
    assert said["trouble"] == "cable 9 (node 9): reports an error, over-current (0x2310)"
    assert 4.0 <= said["step"] < 5.5
    for text, why in (
        ("9", "kind: expected one of"), ("9:overcurrent:x", "expected NODE:KIND:WHEN"), ("77:stuck:3", "no node 77"),
        ("9:overcurrent:-1", "expected NODE:KIND:WHEN"), ("9:garbage:1", "one of a slider's board"),
    ):  # fmt: skip
        wrong = run("run", plan_file, *given[:-1], tmp_path / "b.mcap", "--until", "2", "--fault", text)
        assert (wrong.code, why in wrong.out) == (2, True), wrong


def test_power_is_said_only_of_drives_that_say_it():
    clock = SimpleNamespace(now=lambda: 100.0)
    network = SimpleNamespace(axis_name=lambda axis: f"cable {axis + 1}")
    enabled = [State.OPERATION_ENABLED] * 3

    class Axes(SimpleNamespace):
        def __len__(self):
            return 3

    axes = Axes(heard=np.full(3, -np.inf), clock=clock, network=network, mute_for="", states=lambda: enabled)
    executor = cast("Executor", SimpleNamespace(axes=axes))
    assert "not known: none said so" in _power(executor)
    axes.heard[:] = 99.9
    assert _power(executor) == "All drives hold, with power"
    axes.heard[1] = 90.0
    assert _power(executor) == "Whether 1 of 3 drives have power is not known: cable 2 said nothing for long"
    axes.mute_for = "the bus took no frames"
    assert "not known: the bus took no frames, and the master fell silent" in _power(executor)
