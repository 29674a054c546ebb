"""Finding a board, and what is said of one that is not as it should be."""

import pytest
from drive_makers import boards, network_of
from slider_makers import NAME, NODE, SLIDER, board, bus, line, rig_of

from hognose.drive.cia402 import ENABLE, FAULT_RESET, QUICK_STOP, SHUTDOWN, SWITCH_ON, State
from hognose.drive.emulator.faults import Fault
from hognose.drive.executor import Executor
from hognose.drive.serial_slider.adapter import with_slider
from hognose.drive.serial_slider.greeting import set_reference
from hognose.drive.serial_slider.line import LineError
from hognose.drive.serial_slider.messages import BoardState
from hognose.drive.settings import Settings
from hognose.errors import InputError

pytestmark = pytest.mark.slow


def test_it_is_enabled_in_three_steps_as_a_drive_is():
    rig = rig_of()
    rig.executor.arm()
    axes = rig.executor.axes

    def say(word):
        axes.control_all(word)
        axes.sync()
        axes.wait(rig.clock.now() + 0.02)
        return axes.states()[SLIDER], board(rig).state

    assert say(ENABLE) == (State.SWITCH_ON_DISABLED, BoardState.DISABLED)
    assert say(SWITCH_ON) == (State.SWITCH_ON_DISABLED, BoardState.DISABLED)
    assert say(SHUTDOWN) == (State.READY_TO_SWITCH_ON, BoardState.DISABLED)
    assert say(SWITCH_ON) == (State.SWITCHED_ON, BoardState.DISABLED)
    assert say(ENABLE) == (State.OPERATION_ENABLED, BoardState.ENABLED)
    assert say(QUICK_STOP) == (State.QUICK_STOP_ACTIVE, BoardState.STOPPED)
    assert say(ENABLE) == (State.OPERATION_ENABLED, BoardState.ENABLED)
    assert say(0) == (State.SWITCH_ON_DISABLED, BoardState.DISABLED)
    rig.emulator.inject(Fault(NODE, "emergency"))
    assert say(SHUTDOWN) == (State.FAULT, BoardState.ERROR)
    assert say(FAULT_RESET) == (State.SWITCH_ON_DISABLED, BoardState.DISABLED)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (
            lambda rig: rig.emulator.inject(Fault(NODE, "frozen")),
            r"no answer in 750 ms at 'socket.*115,200 baud\. Is the",
        ),
        (
            lambda rig: rig.emulator.inject(Fault(NODE, "garbage")),
            r"bytes came at 115,200 baud, and no message in them",
        ),
        (lambda rig: setattr(board(rig), "version", 2), "speaks version 2 of the protocol, expected 1"),
        (
            lambda rig: setattr(board(rig), "referenced", False),
            r"does not know where it is \(0 counts are from nowhere\)",
        ),
        (lambda rig: setattr(bus(rig).link.line, "unplugged", True), "its line is gone"),
        (lambda rig: setattr(board(rig).axis, "velocity", 1.0), "refuses its configuration: it cannot in its present"),
        (
            lambda rig: setattr(line(rig), "write", lambda data: line(rig)._back.append((0.0, data))),
            "comes back, and no answer: are its lines looped",
        ),
    ],
)
def test_what_is_wrong_with_a_board_is_said_before_anything_moves(spoil, said):
    rig = rig_of()
    spoil(rig)
    with pytest.raises(InputError, match=said) as caught:
        rig.executor.arm()
    assert NAME in str(caught.value)
    assert "cable" not in str(caught.value)


def test_its_sentence_is_in_one_list_with_those_of_drives():
    rig = rig_of()
    rig.emulator.inject(Fault(4, "frozen"))
    rig.emulator.inject(Fault(NODE, "frozen"))
    with pytest.raises(InputError, match=r"cable 4 \(node 4\): 0x1000:0: no answer(.|\n)*\n  the slider \(board at"):
        rig.executor.arm()
    rig = rig_of()
    for node in rig.network.nodes[:SLIDER]:
        rig.emulator.inject(Fault(node, "frozen"))
    rig.emulator.inject(Fault(NODE, "garbage"))
    with pytest.raises(InputError, match=r"none of the 36 drives answers\n  the slider .*: \d+ bytes came"):
        rig.executor.arm()


def test_after_power_was_lost_it_has_to_be_told_where_it_is():
    rig = rig_of().ready()
    assert rig.executor.run(2.0).trouble is None
    stands = board(rig).place
    rig.emulator.inject(Fault(NODE, "power_lost"))
    assert board(rig).place == stands
    again = Executor(boards(), rig.network, rig.bus, rig.clock, Settings(watches_tension=False))
    with pytest.raises(InputError, match="does not know where it is"):
        again.arm()
    status = set_reference(bus(rig), rig.clock, round(stands))
    assert status.position == rig.counts[2, SLIDER]
    again.arm()
    assert again.recover() == pytest.approx(2.0, abs=0.05)
    assert again.run(0.0).trouble is None
    assert board(rig).place == pytest.approx(rig.counts[0, SLIDER], abs=0.5)
    with pytest.raises(LineError, match="does not take 5 counts for its position: it cannot in its present state"):
        set_reference(bus(rig), rig.clock, 5)


def test_a_bus_without_a_board_stays_as_it_is_and_a_board_needs_its_bus():
    rig = rig_of()
    whole = bus(rig).can
    assert with_slider(whole, rig.clock, network_of(boards())) is whole
    bare = Executor(boards(), rig.network, whole, rig.clock, Settings(watches_tension=False))
    with pytest.raises(InputError, match="the bus was opened without its board; open it by `with_slider`"):
        bare.arm()
