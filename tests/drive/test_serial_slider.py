"""A slider on a serial board is an axis as any other: it goes, stops and fails together with the drives on the bus."""

import struct

import numpy as np
import pytest
from drive_makers import Rig, boards, network_of

from hognose.drive.cia402 import ENABLE, FAULT_RESET, QUICK_STOP, SHUTDOWN, SWITCH_ON, State
from hognose.drive.emulator.board_line import LocalLine
from hognose.drive.emulator.faults import Fault
from hognose.drive.executor import Executor, Phase, Settings
from hognose.drive.frames import Frame
from hognose.drive.serial_slider.adapter import SliderBus, with_slider
from hognose.drive.serial_slider.greeting import set_reference
from hognose.drive.serial_slider.line import LineError
from hognose.drive.serial_slider.messages import BoardState
from hognose.errors import InputError

pytestmark = pytest.mark.slow
NODE, SLIDER = 126, 36
NAME = "the slider (board at socket://127.0.0.1:1): "


def rig_of(kind="epos2", **given):
    return Rig(boards(), network_of(boards(), kind, slider="serial"), **given)


def board(rig):
    assert rig.emulator.board is not None
    return rig.emulator.board


def bus(rig):
    assert isinstance(rig.bus, SliderBus)
    return rig.bus


def line(rig):
    found = bus(rig).link.line
    assert isinstance(found, LocalLine)
    return found


@pytest.mark.parametrize("kind", ["epos2", "cia402"])
def test_there_and_back_it_is_where_the_plan_is_at_every_step(kind):
    rig, demanded = rig_of(kind).ready(), {}
    targets = []
    whole = board(rig)._effect

    def effect(target):
        targets.append(target.position)
        whole(target)

    board(rig)._effect = effect

    def look(cycle):
        demanded.setdefault(cycle.set_point.place, []).append(board(rig).axis.demanded)

    rig.at_cycle.append(look)
    moved_arm = []
    rig.emulator._plant.move = lambda counts, slider, dt: moved_arm.append(slider)
    for there in (5.0, 0.0, 3.0):
        targets.clear()
        begin = rig.executor.place
        assert rig.executor.run(there).trouble is None
        assert rig.executor.axes.position[SLIDER] == rig.counts[int(there), SLIDER]
        assert moved_arm[-1] == pytest.approx(rig.counts[int(there), SLIDER], abs=0.5)
        steps = range(int(min(begin, there)), int(max(begin, there)) + 1)
        assert {int(rig.counts[step, SLIDER]) for step in steps if step != begin} <= set(targets)
        assert sorted(targets, reverse=there < begin) == targets
    moved = np.abs(np.diff(rig.counts[:7, SLIDER])).max() / 5
    for place, found in demanded.items():
        if place == int(place):
            assert max(abs(each - rig.counts[int(place), SLIDER]) for each in found) <= moved + 2


def test_a_stop_at_once_takes_it_no_longer_than_the_others():
    rig = rig_of("cia402").ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 4 and rig.executor.stop_at_once())
    speeds = []
    control_all = rig.executor.axes.control_all

    def stop(word):
        speeds.append(board(rig).axis.velocity)
        began.append(rig.clock.now())
        control_all(word)

    began = []
    rig.executor.axes.control_all = lambda word: stop(word) if word == QUICK_STOP else control_all(word)
    assert rig.executor.run(300.0).trouble is not None
    drives, rested = rig.emulator.drives.values(), {}
    before = board(rig).axis.demanded
    while rig.clock.now() < began[0] + 0.1:
        rig.clock.wait(rig.clock.now() + 1e-3)
        moving = {"board": board(rig).axis.velocity, **{drive.node: drive.axis.velocity for drive in drives}}
        for who, speed in moving.items():
            if speed == 0.0:
                rested.setdefault(who, rig.clock.now() - began[0])
    stop_s = rig.network.spec.watch.stop_s
    assert speeds[0] > 10_000
    assert 0.5 * stop_s < rested["board"] <= stop_s + 0.004  # with the way over the line
    assert len(rested) == 37
    assert max(rested.values()) <= stop_s + 0.004
    assert board(rig).state is BoardState.STOPPED
    assert board(rig).axis.demanded - before == pytest.approx(0.5 * speeds[0] * stop_s, rel=0.2)
    rig.at_cycle.clear()
    rig.executor._stream.halted = False
    assert rig.executor.recover() > 4.0
    assert rig.executor.run(0.0).trouble is None
    assert rig.executor.axes.position[SLIDER] == rig.counts[0, SLIDER]


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("following_error", "reports an error, following error (0x8611)"),
        ("overcurrent", "reports an error, over-current (0x2310)"),
        ("emergency", "reports an error, generic error (0x1000)"),
        ("heartbeat_lost", "no heartbeat for 120 ms"),
        ("frozen", "no heartbeat for 120 ms"),
        ("stuck", "counts from where it is to be"),  # it lags more than an axis may, less than its own window
        ("power_lost", "has started anew: was its supply cut?"),
        ("encoder_jump", "reports an error, following error (0x8611)"),
        ("late", "counts from where it is to be"),
        ("garbage", "no heartbeat for 120 ms"),
        ("bad_checksums", "reports an error, messages on its serial line are damaged or lost (0x8181)"),
    ],
)
def test_whatever_is_wrong_with_it_all_axes_stop_at_once(kind, words):
    rig, began = rig_of().ready(), []

    def break_it(cycle):
        if cycle.set_point.place > 3.0 and not began:
            began.append(rig.clock.now())
            rig.emulator.inject(Fault(NODE, kind))

    rig.at_cycle.append(break_it)
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words.startswith(NAME)
    assert outcome.trouble.words.endswith(words)
    assert outcome.trouble.axis == SLIDER
    assert rig.executor.phase is Phase.STOPPED
    assert rig.clock.now() - began[0] < (0.5 if kind in ("stuck", "late") else 0.2 if kind != "bad_checksums" else 1.0)
    rig.executor.axes.wait(rig.clock.now() + 0.25)
    assert {drive.state for drive in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}
    assert all(drive.axis.velocity == 0.0 for drive in rig.emulator.drives.values())
    assert board(rig).axis.velocity == 0.0
    assert board(rig).state is not BoardState.ENABLED


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


def test_a_fault_of_a_cable_s_drive_stops_it():
    rig = rig_of().ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 3 and rig.emulator.inject(Fault(9, "overcurrent")))
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.axis == 8
    rig.executor.axes.wait(rig.clock.now() + 0.06)
    assert board(rig).state is BoardState.STOPPED
    assert board(rig).axis.velocity == 0.0
    assert board(rig).error == 0


def test_where_the_bus_takes_no_more_the_board_is_told_to_stop():
    from hognose.drive.bus import BusError

    rig = rig_of().ready()

    def fail(frames):
        raise BusError("bus: frames are not taken any more")

    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 3 and setattr(bus(rig)._bus, "send", fail))
    with pytest.raises(BusError):
        rig.executor.run(300.0)
    rig.clock.wait(rig.clock.now() + 0.05)  # sooner than by its watchdog
    assert board(rig).state is BoardState.STOPPED
    assert board(rig).axis.velocity == 0.0


class DeadError(Exception):
    pass


def test_without_a_host_it_stops_and_holds_and_another_one_goes_on_from_there():
    rig = rig_of().ready()

    def die(cycle):
        if cycle.set_point.place > 3:
            rig.executor.axes.control_all = lambda word: None
            raise DeadError

    rig.at_cycle.append(die)
    with pytest.raises(DeadError):
        rig.executor.run(300.0)
    dead = rig.clock.now()
    while board(rig).state is not BoardState.STOPPED or board(rig).axis.velocity:
        rig.clock.wait(rig.clock.now() + 1e-3)
    watch = rig.network.spec.watch
    assert rig.clock.now() - dead <= watch.lost_after_s + watch.stop_s
    rig.clock.wait(rig.clock.now() + 1.0)
    place = board(rig).axis.actual
    after = Executor(boards(), rig.network, rig.bus, rig.clock, Settings(watches_tension=False))
    found = after.arm()
    assert found[SLIDER].name == "slider board (emulated)"
    assert all(each.written == 0 for each in found)
    assert board(rig).axis.actual == place
    assert after.recover() > 3.0
    assert after.run(0.0).trouble is None
    assert after.axes.position[SLIDER] == rig.counts[0, SLIDER]


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


def test_one_message_that_is_lost_stops_nothing_and_the_targets_of_two_cycles_in_a_row_do():
    for lost, stops in ((1, False), (2, True)):
        rig, dropped = rig_of().ready(), []
        its, speeds = line(rig), []
        write = its.write

        def drop(data, rig=rig, dropped=dropped, write=write, lost=lost):
            moves = rig.executor.phase is Phase.RUN and rig.executor.axes.position[SLIDER] > 5000
            if data[2] == 5 and moves and len(dropped) < lost:  # a TARGET
                dropped.append(data)
            else:
                write(data)

        its.write = drop
        watch_speed(rig, speeds)
        outcome = rig.executor.run(5.0)
        assert len(dropped) == lost
        assert (outcome.trouble is not None) == stops
        if outcome.trouble is None:
            assert rig.executor.axes.position[SLIDER] == rig.counts[5, SLIDER]
            assert board(rig)._lost == 1
            assert 1.2 * steady(rig) <= max(speeds) <= 1.26 * steady(rig)
        else:
            assert "(0x8181)" in outcome.trouble.words


def test_after_a_fault_it_returns_to_the_plan():
    rig = rig_of().ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 3 and rig.emulator.inject(Fault(NODE, "overcurrent")))
    assert rig.executor.run(300.0).trouble is not None
    rig.at_cycle.clear()
    assert board(rig).state is BoardState.ERROR
    rig.emulator.repair(NODE)
    assert 2.5 < rig.executor.recover() < 5.0
    assert rig.executor.run(0.0).trouble is None
    assert rig.executor.axes.position[SLIDER] == rig.counts[0, SLIDER]


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


def test_a_target_beyond_its_axis_is_refused_and_stops_all():
    rig = rig_of()
    rig.executor.arm()
    limits = board(rig)._limits
    assert limits is not None
    assert (limits.watchdog, limits.window) == (100, 5000)
    rig.ready()
    board(rig)._limits = type(limits)(limits.watchdog, limits.window, -10, int(rig.counts[2, SLIDER]))
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words == NAME + "reports an error, it refused what it was told (0x8183)"
    assert board(rig).axis.actual <= rig.counts[2, SLIDER]


def test_a_latch_waits_until_the_bus_is_through():
    """37 set-points of 8 bytes at 1 Mbit/s take 37 · 135 µs at most; SYNC, 55 µs."""
    rig, told = rig_of(), []
    rig.executor.arm()
    rig.ready()
    real = bus(rig)
    real._bit_s = 1e-6
    write = real.link.line.write

    def note(data):
        told.append(data)
        write(data)

    real.link.line.write = note
    frames = [*(Frame(0x200 + node, bytes(8)) for node in range(1, 37)), Frame(0x200 + NODE, struct.pack("<i", 0))]
    real._free = rig.clock.now()
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


def test_a_bus_without_a_board_stays_as_it_is_and_a_board_needs_its_bus():
    rig = rig_of()
    whole = bus(rig)._bus
    assert with_slider(whole, rig.clock, network_of(boards())) is whole
    bare = Executor(boards(), rig.network, whole, rig.clock, Settings(watches_tension=False))
    with pytest.raises(InputError, match="the bus was opened without its board; open it by `with_slider`"):
        bare.arm()


@pytest.mark.parametrize(
    ("node", "kind", "said"),
    [
        (NODE, "underflow", "'underflow' is none of a slider's board; those are following_error,"),
        (3, "garbage", "'garbage' is one of a slider's board, and node 3 is none"),
        (40, "stuck", r"there is no node 40; nodes are \[1, 2, .*36, 126\]"),
    ],
)
def test_faults_that_cannot_be_are_refused(node, kind, said):
    with pytest.raises(InputError, match=said):
        rig_of().emulator.inject(Fault(node, kind))
