"""Serial lines that are there: pseudo-terminals and sockets; and what is said of those that are not."""

import contextlib
import os
import socket
import sys
import threading
import time

import pytest
import serial
from drive_makers import boards, network_of

from hognose.drive.bus_load import line_load
from hognose.drive.clock import RealClock
from hognose.drive.emulator.board import EmulatedBoard
from hognose.drive.emulator.board_line import BoardServer, port_of
from hognose.drive.network import Network
from hognose.drive.serial_slider.line import LineError, SerialLine
from hognose.drive.serial_slider.link import Link
from hognose.drive.serial_slider.messages import VERSION, Kind
from hognose.errors import InputError, MissingExtraError


@contextlib.contextmanager
def terminal():
    """Both ends of a serial line of this machine: a number, and the name of a port."""
    ours, theirs = os.openpty()
    try:
        yield ours, os.ttyname(theirs)
    finally:
        os.close(theirs)
        with contextlib.suppress(OSError):
            os.close(ours)


def read_until(line, count):
    found = b""
    while len(found) < count:
        found += line.read()
    return found


def test_bytes_go_both_ways_over_a_port_and_nothing_waits():
    whole = bytes(range(256))
    with terminal() as (ours, name):
        line = SerialLine(name, 115200)
        line.open()
        assert line.read() == b""
        line.write(whole)
        assert os.read(ours, 1000) == whole
        os.write(ours, whole)
        assert read_until(line, 256) == whole
        line.close()
        with pytest.raises(LineError, match="is not open"):
            line.read()
        os.write(ours, b"old")
        line.open()  # what came before is not the board's answer
        assert line.read() == b""
        line.close()


def test_a_port_that_is_open_elsewhere_is_busy():
    with terminal() as (_, name):
        one, other = SerialLine(name, 9600), SerialLine(name, 9600)
        one.open()
        with pytest.raises(LineError, match=rf"port '{name}' is busy: another program has it open"):
            other.open()
        one.close()
        other.open()
        other.close()


def test_a_port_that_is_unplugged_is_gone():
    with terminal() as (ours, name):
        line = SerialLine(name, 9600)
        line.open()
        os.close(ours)
        with pytest.raises(LineError, match=rf"its line at {name} is gone: .*; is it unplugged\?"):
            line.read()
        with pytest.raises(LineError, match=rf"its line at {name} takes nothing any more: .*is it unplugged\?"):
            line.write(b"x")
        line.close()


def write_much(line):
    for _ in range(100_000):
        line.write(bytes(1000))


@pytest.mark.parametrize("kind", ["port", "socket"])
def test_a_line_that_nobody_reads_is_stuck_and_waits_for_nobody(kind):
    """pyserial alone would try for ever here."""
    with terminal() as (_, name), socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        line = SerialLine(name if kind == "port" else f"socket://127.0.0.1:{port}", 115200)
        line.open()
        with pytest.raises(LineError, match=r"is stuck: [0-9]+ bytes wait to be sent"):
            write_much(line)
        line.close()


@pytest.mark.parametrize(
    ("port", "said"),
    [
        (
            "/dev/nonesuch",
            r"no port '/dev/nonesuch'\. Is the board plugged in, and `slider.port` right\? Ports:",
        ),
        ("socket://127.0.0.1:1", r"port 'socket://127\.0\.0\.1:1' cannot be opened: .*Does anything listen there\?"),
        ("socket://nowhere", "port 'socket://nowhere' cannot be opened"),
        ("nonesuch://1", "port 'nonesuch://1' cannot be opened: invalid URL, protocol 'nonesuch' not known"),
        ("/dev/null", "port '/dev/null' cannot be opened"),
    ],
)
def test_a_port_that_is_none_is_said(port, said):
    with pytest.raises(LineError, match=said):
        SerialLine(port, 115200).open()


def test_who_may_not_open_a_port_is_told_what_to_do(monkeypatch):
    def refuse(*args, **given):
        raise serial.SerialException(13, "could not open port /dev/ttyUSB0: permission denied")

    monkeypatch.setattr(serial, "serial_for_url", refuse)
    with pytest.raises(LineError, match=r"may not be opened .*join the group `dialout`"):
        SerialLine("/dev/ttyUSB0", 115200).open()


def test_a_looped_line_gives_back_what_was_said():
    link = Link(SerialLine("loop://", 115200), RealClock(), 1.0)
    link.open()
    link.send(Kind.HELLO, bytes([VERSION]))
    while not link.echoed:
        link.receive()
    assert (link.echoed, link.valid, link.garbage) == (1, 0, 0)


def test_a_board_needs_a_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(MissingExtraError, match=r"needs the package pyserial.*pip install 'hognose\[drive\]'"):
        SerialLine("COM3", 115200)


@pytest.mark.parametrize(
    ("url", "port"),
    [
        ("socket://127.0.0.1:7782", 7782), ("socket://localhost:5", 5), ("socket://10.0.0.1:7782", 0), ("COM3", 0),
        ("socket://127.0.0.1:99999", 0), ("/dev/ttyUSB0", 0), ("socket://127.0.0.1", 0),
    ],
)  # fmt: skip
def test_ports_of_this_machine_are_known(url, port):
    assert port_of(url) == port


def test_an_emulated_board_answers_one_host_after_another():
    ended = threading.Event()
    server = BoardServer(EmulatedBoard(1234))

    def serve():
        began = time.monotonic()
        while not ended.is_set():
            server.serve(time.monotonic() - began)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        for _ in range(2):
            link = Link(SerialLine(server.url, 115200), RealClock(), 60.0)
            link.open()
            link.send(Kind.HELLO, bytes([VERSION]))
            while link.welcome is None:
                link.receive()
            assert (link.welcome.name, link.welcome.position) == ("slider board (emulated)", 1234)
            link.line.close()
        with pytest.raises(InputError, match=rf"slider\.port: port {port_of(server.url)} cannot be listened on"):
            BoardServer(EmulatedBoard(), port_of(server.url))
    finally:
        ended.set()
        thread.join()
        server.close()


def test_a_line_that_is_too_slow_is_refused():
    spec = network_of(boards(), slider="serial").spec
    assert spec.slider is not None
    assert 0.1 < line_load(spec) < 0.2
    assert line_load(network_of(boards()).spec) == 0.0
    slow = spec.model_copy(update={"slider": spec.slider.model_copy(update={"baud": 9600})})
    with pytest.raises(InputError, match=r"its serial line would be taken for \d+ % of the time at 9,600 baud, more"):
        Network(slow, boards().robot, "bench")
