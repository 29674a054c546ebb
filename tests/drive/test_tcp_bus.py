"""The bus over TCP: everything arrives, once, in order, at everyone but the sender; and drives in another process."""

import os
import sys
import threading

import can
import pytest
from drive_makers import boards
from hypothesis import given, settings
from hypothesis import strategies as st

from hognose.drive.bus import BusError, CanBus
from hognose.drive.clock import RealClock
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.faults import Fault
from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.executor import Executor
from hognose.drive.frames import Frame
from hognose.drive.motions import counts_of
from hognose.drive.network import Network, emulated_network
from hognose.drive.network_spec import BusSpec
from hognose.drive.settings import Settings
from hognose.drive.tcp_bus import TcpBus
from hognose.drive.tcp_hub import Hub, packed, unpacked
from hognose.errors import InputError, MissingExtraError

FRAMES = st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)).map(lambda both: Frame(*both)), max_size=40)


@given(FRAMES, st.integers(1, 50))
@settings(deadline=None)
def test_frames_come_out_as_they_went_in_however_the_bytes_are_cut(frames, size):
    data, rest, found = packed(frames), b"", []
    for start in range(0, len(data), size):
        some, rest = unpacked(rest + data[start : start + size])
        found += some
    assert (found, rest) == (frames, b"")


def test_every_frame_comes_to_all_others_in_order():
    hub, ended = Hub(), threading.Event()
    heard = []

    def serve():
        while not ended.is_set():
            heard.extend(hub.take(0.01))

    thread = threading.Thread(target=serve)
    thread.start()
    one, other = (CanBus(BusSpec(interface="hognose", channel=f"127.0.0.1:{hub.port}")) for _ in range(2))
    sent = [Frame(k % 0x7FF, bytes([k % 256])) for k in range(3000)]
    try:
        other.send([Frame(0x7FF, b"")])
        while Frame(0x7FF, b"") not in heard:
            pass
        one.send(sent)
        found = []
        while len(found) < len(sent):
            found += other.receive()
        assert found == sent
        while len(heard) <= len(sent):
            pass
        assert [frame for frame in heard if frame.data] == sent
        assert [frame for frame in one.receive() if frame.data] == []
    finally:
        ended.set()
        thread.join()
        one.close()
        other.close()
        hub.close()


def listen_for_ever(bus):
    while True:
        bus.receive()


def test_a_hub_that_is_not_there_or_goes_is_said():
    hub = Hub()
    port = hub.port
    bus = CanBus(BusSpec(interface="hognose", channel=f"127.0.0.1:{port}"))
    hub.take(1.0)
    hub.close()
    with pytest.raises(BusError, match="the hub is gone; is it off, or unplugged"):
        listen_for_ever(bus)
    bus.close()
    for channel in (f"127.0.0.1:{port}", "nowhere", ""):
        with pytest.raises(InputError, match=r"cannot be opened: no hub at .* Is it there, up, and free"):
            CanBus(BusSpec(interface="hognose", channel=channel))
    with pytest.raises(InputError, match="interface 'nonesuch', channel '': cannot be opened"):
        CanBus(BusSpec(interface="nonesuch"))


def test_python_can_knows_it_by_its_own_means():
    hub = Hub()
    bus = TcpBus(f"127.0.0.1:{hub.port}")
    hub.take(1.0)
    bus.send(can.Message(arbitration_id=0x123, data=b"abc", is_extended_id=False))
    assert hub.take(1.0) == [Frame(0x123, b"abc")]
    hub.give([Frame(0x321, b"xyz")])
    message = bus.recv(1.0)
    assert message is not None
    assert (message.arbitration_id, bytes(message.data)) == (0x321, b"xyz")
    assert bus.recv(0.0) is None
    bus.shutdown()
    hub.close()


def patient(channel: str = "") -> Network:
    """A network that a busy machine does not make nervous."""
    made = emulated_network(boards().robot, channel=channel)
    spec = made.spec.model_dump(by_alias=True)
    spec["drives"] |= {"least_records": 55, "most_records": 62, "following_error_counts": 1_000_000}
    spec["slider"] |= {"following_error_counts": 1_000_000}
    spec["watch"] |= {"heartbeat_s": 0.3, "lost_after_s": 1.6, "late_cycles": 50}
    return Network(type(made.spec).model_validate(spec), boards().robot, made.source)


def emulated_boards() -> Emulator:
    """In the process of the drives."""
    network = patient()
    return Emulator(network, start=counts_of(boards(), network)[0].tolist())


@pytest.mark.slow
def test_drives_in_another_process_are_run_in_real_time():
    plan, process = boards(), EmulatorProcess(emulated_boards)
    network = patient(process.channel)
    bus = CanBus(network.spec.bus)
    try:
        run = Executor(plan, network, bus, RealClock(), Settings(watches_tension=False))
        run.arm()
        run.hold()
        run.tension()
        assert run.run(4.0).trouble is None
        assert (abs(run.axes.position - counts_of(plan, network)[4]) <= 20).all()  # it may still creep there
        process.inject(Fault(9, "overcurrent"))
        outcome = run.run(300.0)
        assert outcome.trouble is not None
        assert outcome.trouble.words == "cable 9 (node 9): reports an error, over-current (0x2310)"
    finally:
        bus.close()
        process.close()


@pytest.mark.slow
def test_drives_that_do_not_start_say_why():
    with pytest.raises(InputError, match="the emulated drives did not start: no such thing"):
        EmulatorProcess(failing)


def failing() -> Emulator:
    raise InputError("no such thing")


@pytest.mark.slow
def test_drives_that_end_before_they_begin_are_said():
    with pytest.raises(InputError, match=r"the emulated drives did not start$"):
        EmulatorProcess(ending)


def ending() -> Emulator:
    os._exit(3)


def test_drives_need_a_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "can", None)
    with pytest.raises(MissingExtraError, match=r"drives need the package python-can.*pip install 'hognose\[drive\]'"):
        CanBus(BusSpec(interface="virtual"))


def test_a_bus_of_another_bitrate_gives_error_frames_alone():
    hub = Hub(bitrate=500_000)
    channel = f"127.0.0.1:{hub.port}"
    same, other = (CanBus(BusSpec(interface="hognose", channel=channel, bitrate=rate)) for rate in (500_000, 1_000_000))
    try:
        same.send([Frame(0x701, b"\x05")])
        other.send([Frame(0x702, b"\x05")])
        heard = []
        while Frame(0x701, b"\x05") not in heard:
            heard += hub.take(0.01)
        hub.give([Frame(0x703, b"\x05")])
        while not other.errors:
            heard += hub.take(0.01)
            assert other.receive() == []
        found = []
        while len(found) < 1:
            found += same.receive()
        assert (heard, found) == ([Frame(0x701, b"\x05")], [Frame(0x703, b"\x05")])
        assert "another than bus.bitrate, 1,000,000 bit/s" in other.ailment
        assert same.ailment == ""
    finally:
        same.close()
        other.close()
        hub.close()
