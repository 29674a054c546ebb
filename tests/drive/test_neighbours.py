"""Others on the bus, another bitrate, a queue that is full: said before anything is written to a drive."""

import errno

import can
import pytest
from drive_makers import Rig, boards, network_of

from hognose.drive.bring_up import bring_up
from hognose.drive.bus import BusError, CanBus, ailment_words
from hognose.drive.frames import Frame
from hognose.drive.homing import Homing
from hognose.drive.local_bus import LocalBus
from hognose.drive.network import Network
from hognose.drive.network_spec import BusSpec
from hognose.errors import InputError


class Shared(LocalBus):
    """A bus on which somebody else says something again and again, or answers when asked."""

    def __init__(self, rig, says=(), answers=None):
        super().__init__(rig.emulator, rig.clock)
        self.says, self.answers, self.sent, self._due = list(says), answers or {}, [], []

    def send(self, frames):
        self.sent += frames
        self._due += [self.answers[frame.cob] for frame in frames if frame.cob in self.answers]
        super().send(frames)

    def receive(self):
        found, self._due = [*super().receive(), *self.says, *self._due], []
        return found


def with_bus(**changed):
    made = network_of(boards())
    spec = made.spec.model_dump(by_alias=True)
    spec["bus"] |= changed
    return Network(type(made.spec).model_validate(spec), boards().robot, "bench.toml")


def refused(says=(), answers=None, network=None):
    """What is said, after it was made sure that nothing was written."""
    rig = Rig(boards(), network or with_bus())
    bus = Shared(rig, says, answers)
    with pytest.raises(InputError) as caught:
        bring_up(bus, rig.clock, rig.network, 0.03)
    assert {(frame.cob & 0x780, frame.data[0]) for frame in bus.sent} == {(0x600, 0x40)}  # only read
    return str(caught.value)


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        (Frame(0x080, b""), "somebody sends SYNC (0x080)"),
        (Frame(0x77F, b"\x05"), "somebody sends the heartbeats of node 127, the master's (0x77F)"),
        (Frame(0x605, bytes(8)), "somebody tells drives what to do (0x605)"),
        (Frame(0x205, bytes(8)), "somebody tells drives what to do (0x205)"),
        (Frame(0x1FF, b"\x02\0"), "somebody tells drives what to do (0x1FF)"),
        (Frame(0x000, b"\x01\0"), "somebody starts, stops or resets nodes (0x000)"),
    ],
)
def test_another_master_is_refused(frame, said):
    words = refused([frame])
    assert words.startswith("bench.toml: there is another master on the bus: ")
    assert said in words
    assert words.endswith("End the other program first")


def test_all_that_another_master_does_is_one_sentence():
    words = refused([Frame(0x080, b""), Frame(0x77F, b"\x05"), Frame(0x601, bytes(8))])
    assert len(words.splitlines()) == 1
    assert words.count("(0x") == 3


@pytest.mark.parametrize(
    ("says", "answers", "how"),
    [
        ([Frame(0x729, b"\x05")], {}, "sends heartbeats"),
        ([Frame(0x1A9, bytes(8)), Frame(0x0A9, bytes(8))], {}, "reports errors, sends PDOs"),
        ([], {0x629: Frame(0x5A9, bytes.fromhex("4318100401000000"))}, "answers"),
    ],
)
def test_a_node_that_the_file_does_not_know_is_named_unless_it_is_one_of_the_others(says, answers, how):
    words = refused(says, answers)
    assert f"bench.toml: node 41: on the bus, but not in the file: {how}." in words
    rig = Rig(boards(), with_bus(others=[41]))
    assert len(bring_up(Shared(rig, says, answers), rig.clock, rig.network, 0.03)) == 37


def test_drives_that_were_left_out_of_the_file_are_all_named():
    """The slider's drive is on the bus, and the file does not have it."""
    rig = Rig(boards())
    spec = rig.network.spec.model_copy(update={"slider": None})
    with pytest.raises(InputError) as caught:
        bring_up(LocalBus(rig.emulator, rig.clock), rig.clock, Network(spec, boards().robot, "bench.toml"), 0.03)
    assert "bench.toml: node 37: on the bus, but not in the file" in str(caught.value)


def test_two_drives_with_one_node_id_are_named():
    words = refused(answers={0x607: Frame(0x587, bytes.fromhex("43181004EFBEADDE"))})
    assert words == "bench.toml: two drives answer as node 7: give each a node id of its own"


def test_homing_is_refused_among_others():
    rig = Rig(boards())
    with pytest.raises(InputError, match="there is another master on the bus"):
        Homing(rig.network, rig.counts[0]).declare(Shared(rig, [Frame(0x080, b"")]), rig.clock)


def test_others_are_no_drives():
    with pytest.raises(ValueError, match=r"bus\.others: node 7 is a drive of this file"):
        with_bus(others=[7])


def test_another_bitrate_is_said():
    rig = Rig(boards())
    bus = LocalBus(rig.emulator, rig.clock, bitrate=500_000)
    with pytest.raises(InputError) as caught:
        bring_up(bus, rig.clock, rig.network, 0.03)
    assert "none of the 37 drives answers. Is it on, is the bitrate the drives'" in str(caught.value)
    assert "error frames came from the bus: its bitrate is probably another than bus.bitrate, 500,000 bit/s" in str(
        caught.value
    )


def test_what_error_frames_mean_is_said():
    assert ailment_words(0, 0x20, 500_000) == ""
    assert "1 error frame came from the bus: nobody acknowledges what is sent" in ailment_words(1, 0x24, 500_000)
    assert "2 error frames came from the bus: its bitrate is probably another" in ailment_words(2, 0x28, 500_000)
    assert "the controller took itself off the bus: its bitrate" in ailment_words(2, 0x4C, 500_000)


@pytest.fixture
def virtual():
    bus = CanBus(BusSpec(interface="virtual", channel="vcan-test", bitrate=250_000))
    yield bus
    bus.close()


def test_error_frames_of_an_interface_are_counted(virtual):
    other = can.Bus(interface="virtual", channel="vcan-test")
    try:
        other.send(can.Message(arbitration_id=0x88, is_error_frame=True, data=bytes(8), is_extended_id=False))
        other.send(can.Message(arbitration_id=0x701, data=b"\x05", is_extended_id=False))
        assert virtual.receive() == [Frame(0x701, b"\x05")]
    finally:
        other.shutdown()
    assert virtual.errors == 1
    assert "another than bus.bitrate, 250,000 bit/s" in virtual.ailment


@pytest.mark.parametrize(
    "error",
    [
        can.CanOperationError("Failed to transmit: No buffer space available", errno.ENOBUFS),
        can.CanOperationError("Transmit buffer full"),
        OSError(errno.ENOBUFS, "No buffer space available"),
    ],
)
def test_a_queue_that_is_full_is_said_with_what_to_do(virtual, error, monkeypatch):
    def full(message):
        raise error

    monkeypatch.setattr(virtual._bus, "send", full)
    with pytest.raises(BusError, match=r"vcan-test: its queue is full.*`sudo ip link set vcan-test txqueuelen 1000`"):
        virtual.send([Frame(0x80, b"")])
    error = OSError(errno.ENETDOWN, "Network is down")
    with pytest.raises(BusError, match=r"frames are not taken any more: .*Network is down; is it off, or unplugged"):
        virtual.send([Frame(0x80, b"")])
