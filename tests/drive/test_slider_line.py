"""What happens to a slider on a serial board when messages are lost, late, or held back, or the line is gone."""

import struct

import numpy as np
import pytest
from slider_makers import NAME, NODE, SLIDER, board, bus, line, rig_of

from hognose.drive.cia402 import State
from hognose.drive.executor import Phase
from hognose.drive.frames import Frame
from hognose.drive.serial_slider.messages import BoardState, Kind

pytestmark = pytest.mark.slow


def test_a_line_that_is_pulled_out_stops_all_and_the_board_holds():
    rig = rig_of().ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 3 and setattr(bus(rig).link.line, "unplugged", True))
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words == NAME + "reports an error, its serial line is gone: is it unplugged? (0x8182)"
    assert "unplugged" in bus(rig).gone
    rig.executor.axes.wait(rig.clock.now() + 0.3)
    assert {drive.state for drive in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}
    assert board(rig).state is BoardState.STOPPED
    place = board(rig).axis.actual
    rig.clock.wait(rig.clock.now() + 0.5)
    assert board(rig).axis.actual == place


def test_where_the_bus_takes_no_more_the_board_is_told_to_stop():
    from hognose.drive.bus import BusError

    rig = rig_of().ready()

    def fail(frames):
        raise BusError("bus: frames are not taken any more")

    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 3 and setattr(bus(rig).can, "send", fail))
    with pytest.raises(BusError):
        rig.executor.run(300.0)
    rig.clock.wait(rig.clock.now() + 0.05)  # sooner than by its watchdog
    assert board(rig).state is BoardState.STOPPED
    assert board(rig).axis.velocity == 0.0


def test_a_stop_that_is_lost_is_said_again():
    rig, lost = rig_of().ready(), []
    its = line(rig)
    write = its.write

    def lose(data):
        if data[2] == 7 and not lost:  # STOP
            lost.append(board(rig).axis.demanded)
        else:
            write(data)

    its.write = lose
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 4 and rig.executor.stop_at_once())
    assert rig.executor.run(300.0).trouble is not None
    rig.executor.axes.wait(rig.clock.now() + 0.09)  # sooner than by its watchdog
    assert board(rig).state is BoardState.STOPPED
    assert board(rig).error == 0
    assert 0 <= board(rig).axis.demanded - lost[0] <= 1.3 * steady(rig) * rig.executor.cycle


def steady(rig):
    """Counts/s of the slider at the plan's own speed."""
    return float(np.abs(np.diff(rig.counts[:8, SLIDER])).max()) / 0.15


def watch_speed(rig, speeds):
    rig.clock.attach(lambda now: speeds.append(abs(board(rig).axis.velocity)))


def test_what_a_line_held_back_is_not_made_up_for_by_a_leap():
    rig, held, speeds, wait = rig_of().ready(), [], [], []
    its = line(rig)
    write = its.write

    def hold_back(data):
        now = rig.clock.now()
        if not wait and rig.executor.axes.position[SLIDER] > 5000:
            wait.append(now + 0.045)
        if wait and now < wait[0]:
            held.append(data)
            return
        write(b"".join([*held, data]))
        held.clear()

    its.write = hold_back
    watch_speed(rig, speeds)
    outcome = rig.executor.run(8.0)
    assert outcome.trouble is None
    assert rig.executor.axes.position[SLIDER] == rig.counts[8, SLIDER]
    assert 1.2 * steady(rig) <= max(speeds) <= 1.26 * steady(rig)


@pytest.mark.parametrize(("kind", "lost"), [(Kind.TARGET, 1), (Kind.TARGET, 2), (Kind.LATCH, 2)])
def test_one_message_that_is_lost_stops_nothing_and_those_of_two_cycles_in_a_row_do(kind, lost):
    rig, dropped, speeds = rig_of().ready(), [], []
    its = line(rig)
    write = its.write

    def drop(data):
        moves = rig.executor.phase is Phase.RUN and rig.executor.axes.position[SLIDER] > 5000
        if data[2] == kind and moves and len(dropped) < lost:
            dropped.append(rig.clock.now())
        else:
            write(data)

    its.write = drop
    watch_speed(rig, speeds)
    outcome = rig.executor.run(5.0)
    assert len(dropped) == lost
    if lost == 1:
        assert outcome.trouble is None
        assert rig.executor.axes.position[SLIDER] == rig.counts[5, SLIDER]
        assert board(rig)._lost == 1
        assert 1.2 * steady(rig) <= max(speeds) <= 1.26 * steady(rig)
    else:
        assert outcome.trouble is not None
        assert "(0x8181)" in outcome.trouble.words
        assert rig.clock.now() - dropped[-1] < 2.1 * rig.executor.cycle


def test_a_latch_waits_until_the_bus_is_through():
    """37 set-points of 8 bytes at 1 Mbit/s take 37 · 135 µs at most; SYNC, 55 µs."""
    rig, told = rig_of(), []
    rig.executor.arm()
    rig.ready()
    real = bus(rig)
    real._bit_s = [1e-6]
    write = real.link.line.write

    def note(data):
        told.append(data)
        write(data)

    real.link.line.write = note
    frames = [*(Frame(0x200 + node, bytes(8)) for node in range(1, 37)), Frame(0x200 + NODE, struct.pack("<i", 0))]
    real._free = [rig.clock.now()]
    real.send(frames)
    real.send([Frame(0x80, b"")])
    target, latch = told
    assert (target[2], latch[2]) == (5, 6)
    number, delay = struct.unpack_from("<BH", latch, 4)
    assert number == target[3]
    assert delay == round(1e4 * 1e-6 * (36 * 135 + 55))
    began = rig.clock.now()
    effect, took = board(rig)._effect, []

    def take_effect(target):
        took.append(rig.clock.now() - began)
        effect(target)

    board(rig)._effect = take_effect
    rig.clock.wait(began + 0.02)
    assert took == [pytest.approx(1e-4 * delay, abs=4e-3)]
