"""A slider on a serial board is an axis as any other: it goes, stops and fails together with the drives on the bus."""

import numpy as np
import pytest
from drive_makers import boards
from slider_makers import NAME, NODE, SLIDER, board, rig_of

from hognose.drive.cia402 import QUICK_STOP, State
from hognose.drive.emulator.faults import Fault
from hognose.drive.executor import Executor
from hognose.drive.serial_slider.messages import BoardState
from hognose.drive.settings import Phase, Settings

pytestmark = pytest.mark.slow


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
    for there in (4.0, 0.0):
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
        demanded.append(board(rig).axis.demanded)
        control_all(word)

    began, demanded = [], []
    rig.executor.axes.control_all = lambda word: stop(word) if word == QUICK_STOP else control_all(word)
    assert rig.executor.run(300.0).trouble is not None
    drives, rested = rig.emulator.drives.values(), {}
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
    assert board(rig).axis.demanded - demanded[0] == pytest.approx(0.5 * speeds[0] * stop_s, rel=0.2)
    rig.at_cycle.clear()
    assert rig.executor.recover() > 4.0
    assert rig.executor.run(0.0).trouble is None
    assert rig.executor.axes.position[SLIDER] == rig.counts[0, SLIDER]


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("following_error", "reports an error, following error (0x8611)"),
        ("emergency", "reports an error, generic error (0x1000)"),
        ("heartbeat_lost", "no heartbeat for 120 ms"),
        ("frozen", "no heartbeat for 120 ms"),
        ("stuck", "reports an error, following error (0x8611)"),
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
        if cycle.set_point.place > 2.0 and not began:
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


def test_a_target_beyond_its_axis_is_refused_and_stops_all():
    rig = rig_of()
    rig.executor.arm()
    limits = board(rig)._limits
    assert limits is not None
    assert (limits.watchdog, limits.window) == (100, 200)
    rig.ready()
    board(rig)._limits = type(limits)(limits.watchdog, limits.window, -10, int(rig.counts[2, SLIDER]))
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words == NAME + "reports an error, it refused what it was told (0x8183)"
    assert board(rig).axis.actual <= rig.counts[2, SLIDER]
