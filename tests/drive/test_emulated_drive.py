"""Emulated drives refuse what real ones refuse, by their object dictionaries."""

import struct

import pytest

from hognose.drive import cia402
from hognose.drive.cia402 import State
from hognose.drive.emulator.drive import EmulatedDrive
from hognose.drive.frames import Frame
from hognose.drive.network_spec import Kind


class Asked:
    """One drive, and what it answers."""

    def __init__(self, kind: Kind = "epos2"):
        self.drive = EmulatedDrive(5, kind)
        self.drive.out.clear()

    def __call__(self, data):
        self.drive.receive(Frame(0x605, data.ljust(8, b"\0")), 0.0)
        ((cob, answer),) = self.drive.out
        self.drive.out.clear()
        assert cob == 0x585
        return answer

    def write(self, index, sub, value, size):
        """The abort code; 0 if it was written."""
        answer = self(struct.pack("<BHB", 0x23 | (4 - size) << 2, index, sub) + value.to_bytes(size, "little"))
        assert struct.unpack_from("<HB", answer, 1) == (index, sub)
        return struct.unpack_from("<I", answer, 4)[0] if answer[0] == 0x80 else 0

    def command(self, word):
        self.drive.receive(Frame(0x000, bytes([1, 0])), 0.0)
        self.write(0x6040, 0, word, 2)
        return self.drive.state


@pytest.mark.parametrize("kind", ["epos2", "cia402"])
def test_mapping_is_refused_where_drives_refuse_it(kind):
    asked = Asked(kind)
    assert asked.write(0x1600, 0, 0, 1) == 0x08000022  # it is enabled
    assert asked.write(0x1400, 1, 0x80000205, 4) == 0
    assert asked.write(0x1600, 0, 0, 1) == 0
    assert asked.write(0x1600, 1, 0x10170010, 4) == 0x06040041  # no such object in a PDO
    assert asked.write(0x1600, 1, 0x77770020, 4) == 0x06040041
    assert asked.write(0x1600, 1, 0x607A0010, 4) == 0x06040041  # another size
    for sub in (1, 2, 3):
        assert asked.write(0x1600, sub, 0x607A0020, 4) == 0
    assert asked.write(0x1600, 0, 3, 1) == 0x06040042
    assert asked.write(0x1600, 0, 2, 1) == 0
    asked.drive.receive(Frame(0x000, bytes([1, 0])), 0.0)
    assert asked.write(0x1400, 1, 0x205, 4) == 0x08000022  # operational


@pytest.mark.parametrize(
    ("index", "sub", "value", "size", "code"),
    [
        (0x6041, 0, 1, 2, 0x06010002),
        (0x6040, 0, 1, 4, 0x06070010),
        (0x20C4, 2, 64, 2, 0x06090031),
        (0x20C4, 9, 1, 2, 0x06090011),
        (0x5555, 0, 1, 2, 0x06020000),
    ],
)
def test_writing_what_cannot_be_written_is_refused(index, sub, value, size, code):
    assert Asked().write(index, sub, value, size) == code


def test_what_is_long_is_read_in_segments():
    asked = Asked()
    assert asked(struct.pack("<BHB", 0x40, 0x1008, 0))[0] == 0x41
    found, toggle = b"", 0
    while True:
        answer = asked(bytes([0x60 | toggle << 4]))
        assert answer[0] >> 4 & 1 == toggle
        found += answer[1 : 8 - (answer[0] >> 1 & 7)]
        if answer[0] & 1:
            break
        toggle ^= 1
    assert found == b"EPOS2 (emulated)"


def test_the_state_machine_is_that_of_cia_402():
    asked = Asked()
    assert asked.drive.state is State.SWITCH_ON_DISABLED
    assert asked.command(cia402.ENABLE) is State.SWITCH_ON_DISABLED  # not in one go
    way = ((cia402.SHUTDOWN, State.READY_TO_SWITCH_ON), (cia402.SWITCH_ON, State.SWITCHED_ON))
    for word, state in (*way, (cia402.ENABLE, State.OPERATION_ENABLED), (cia402.SWITCH_ON, State.SWITCHED_ON)):
        assert asked.command(word) is state
    assert asked.command(cia402.ENABLE) is State.OPERATION_ENABLED
    assert asked.command(cia402.QUICK_STOP) is State.QUICK_STOP_ACTIVE
    assert asked.command(cia402.ENABLE) is State.OPERATION_ENABLED
    asked.drive.fault(0x8611)
    assert asked.drive.state is State.FAULT
    asked.drive.out.clear()
    assert asked.command(cia402.ENABLE) is State.FAULT
    assert asked.command(cia402.FAULT_RESET) is State.SWITCH_ON_DISABLED
    for word in (cia402.SHUTDOWN, cia402.DISABLE_VOLTAGE):
        asked.command(word)
    assert asked.drive.state is State.SWITCH_ON_DISABLED


def test_a_cyclic_position_is_a_jump_without_a_period():
    for milliseconds, share in ((0, 1.0), (20, 0.5)):
        drive = EmulatedDrive(5, "cia402")
        drive.objects[0x6060, 0].value, drive.objects[0x60C2, 1].value = 8, milliseconds
        drive.state = State.OPERATION_ENABLED
        assert drive._written(0x607A, 0, 1000) == 0
        drive.advance(0.01, 0.01)
        assert drive.axis.demanded == pytest.approx(1000 * share)
