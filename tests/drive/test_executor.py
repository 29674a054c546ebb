"""Runs on emulated drives: every count of the plan, in order; stops; faults; back on the same way."""

import numpy as np
import pytest
from drive_makers import Rig, boards, network_of

from hognose.drive import executor
from hognose.drive.cia402 import State
from hognose.drive.emulator.axis import Record
from hognose.drive.emulator.drive import PRE_OPERATIONAL, EmulatedDrive
from hognose.drive.emulator.emulator import Delays
from hognose.drive.emulator.faults import Fault
from hognose.drive.executor import Executor
from hognose.drive.local_bus import LocalBus
from hognose.drive.settings import Phase, Settings
from hognose.errors import InfeasibleError, InputError

#: Nothing here depends on how a processor rounds.
pytestmark = pytest.mark.slow
#: Steps of the plan that a test goes through.
FAR = 12.0


@pytest.mark.parametrize("seed", range(2))
def test_every_drive_gets_every_count_of_the_plan_in_order(seed, monkeypatch):
    rig = Rig(boards(), delays=Delays(2e-4, 3e-3), seed=seed).ready()
    got = {}
    whole = EmulatedDrive._record

    def record(self, number):
        data = (number % (1 << 64)).to_bytes(8, "little")
        got.setdefault(self.node, []).append(int.from_bytes(data[:4], "little", signed=True))
        return whole(self, number)

    monkeypatch.setattr(EmulatedDrive, "_record", record)
    outcome = rig.executor.run(FAR)
    assert (outcome.trouble, outcome.place) == (None, FAR)
    places = [cycle.set_point.place for cycle in rig.cycles]
    for axis, node in enumerate(rig.network.nodes):
        sent = got[node]
        assert len(sent) == len({*range(len(sent))})
        met = [sent[k] for k, place in enumerate(places[: len(sent)]) if place == int(place)]
        steps = list(dict.fromkeys(int(place) for place in places[: len(sent)] if place == int(place)))
        assert steps == list(range(int(FAR) + 1))
        expected = [int(rig.counts[int(place), axis]) for place in places[: len(sent)] if place == int(place)]
        assert met == expected
        assert rig.drive(axis).axis.underflows == 0
    np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[int(FAR)])


@pytest.mark.parametrize("kind", ["epos2", "cia402"])
def test_all_axes_are_where_the_plan_is_at_each_of_its_steps(kind):
    rig = Rig(boards(), network_of(boards(), kind)).ready()
    off = []

    def look(cycle):
        place = cycle.set_point.place
        if place == int(place):
            demanded = [drive.axis.demanded for drive in rig.emulator.drives.values()]
            off.append(np.abs(np.array(demanded) - rig.counts[int(place)]).max())

    rig.at_cycle.append(look)
    assert rig.executor.run(FAR).trouble is None
    # `seen` is called when the cycle is over, in which they went on by a part of a step.
    moved = np.abs(np.diff(rig.counts[: int(FAR) + 2], axis=0)).max() / 5
    assert max(off) <= moved + 2


def test_it_comes_back_on_the_same_way_from_wherever_it_was_stopped():
    rig = Rig(boards()).ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 5.3 and rig.executor.stop())
    assert rig.executor.run(FAR).trouble is None
    rig.at_cycle.clear()
    stopped = rig.executor.place
    assert 5.3 < stopped < FAR
    assert rig.executor.phase is Phase.HELD
    rig.executor.run(0.0)
    assert rig.executor.place == 0.0
    np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[0])
    rig.executor.run(3.0)
    np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[3])


@pytest.mark.parametrize(
    ("kind", "words", "node"),
    [
        ("following_error", "reports an error, following error (0x8611)", 1),
        ("overcurrent", "reports an error, over-current (0x2310)", 36),
        ("emergency", "reports an error, generic error (0x1000)", 2),
        ("heartbeat_lost", "no heartbeat for", 7),
        ("frozen", "no heartbeat for", 23),
        ("bus_off", "reports an error, bus off (0x81FD)", 12),
        ("stuck", "reports an error, following error (0x8611)", 34),
        ("power_lost", "has started anew: was its supply cut?", 30),
        ("underflow", "reports an error, interpolated position mode", 5),
        ("encoder_jump", "reports an error, following error (0x8611)", 19),
    ],
)
def test_a_fault_of_one_drive_stops_all_together(kind, words, node):
    rig = Rig(boards()).ready()
    began = {}

    def break_it(cycle):
        if cycle.set_point.place > 4.0 and not began:
            began["time"] = rig.clock.now()
            rig.emulator.inject(Fault(node, kind))

    rig.at_cycle.append(break_it)
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert words in outcome.trouble.words
    assert outcome.trouble.axis == node - 1
    assert outcome.trouble.words.startswith(f"cable {node} (node {node}): ")
    assert rig.executor.phase is Phase.STOPPED
    with pytest.raises(InputError, match="all axes were stopped at once"):
        rig.executor.run(0.0)
    rig.executor.axes.wait(rig.clock.now() + 0.1)
    others = [drive for each, drive in rig.emulator.drives.items() if each != node]
    assert all(drive.state is State.QUICK_STOP_ACTIVE for drive in others)
    assert all(drive.axis.velocity == 0.0 for drive in others)
    # All others went on along the plan alike: they are closest to one place of it.
    place = rig.executor.place
    ahead = np.array([drive.axis.actual for drive in others])
    kept = [axis for axis, each in enumerate(rig.network.nodes) if each != node]
    low = int(place)
    reach = np.abs(np.diff(rig.counts[low : low + 3], axis=0)).max()
    assert np.abs(ahead - rig.counts[low, kept]).max() <= 2 * reach + 20


def test_after_a_fault_it_returns_to_the_plan_where_it_is_and_retracts():
    rig = Rig(boards()).ready()
    fault = Fault(5, "following_error")
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 4.0 and rig.emulator.inject(fault))
    assert rig.executor.run(FAR).trouble is not None
    rig.at_cycle.clear()
    rig.emulator.repair(5)
    place = rig.executor.recover()
    assert 3.5 < place < 6.0
    assert rig.executor.run(0.0).trouble is None
    np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[0])


def test_after_it_was_told_to_stop_at_once_it_returns_to_the_plan():
    rig = Rig(boards()).ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 4.0 and rig.executor.stop_at_once())
    assert rig.executor.run(FAR).trouble is not None
    rig.at_cycle.clear()
    rig.executor.recover()
    assert rig.executor.run(0.0).trouble is None
    np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[0])


def test_what_another_program_left_in_a_buffer_is_not_gone_through():
    rig, left = Rig(boards()).ready(), []
    axis = rig.drive(3).axis
    axis.records.append(Record(round(axis.actual) + 5000, 0.0, 0.03))
    rig.at_cycle.append(lambda cycle: left.append(axis.demanded))
    assert rig.executor.run(3.0).trouble is None
    between = sorted(rig.counts[[0, 3], 3].tolist())
    assert between[0] - 2 <= min(left) <= max(left) <= between[1] + 2


def test_a_drive_that_does_not_begin_with_the_others_is_named_at_once():
    rig = Rig(boards()).ready()
    rig.drive(20)._go = lambda goes, was: None
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.words == "cable 21 (node 21): did not begin to move with the others"
    moved = [
        abs(drive.axis.actual - count) for drive, count in zip(rig.emulator.drives.values(), rig.counts[0], strict=True)
    ]
    assert max(moved) <= np.abs(rig.counts[2] - rig.counts[0]).max()


def test_a_buffer_that_cannot_be_emptied_is_said_before_anything_moves():
    rig = Rig(boards()).ready()
    rig.emulator.inject(Fault(9, "frozen"))
    before = [drive.axis.demanded for drive in rig.emulator.drives.values()]
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.words.startswith("cable 9 (node 9): ")
    assert [drive.axis.demanded for drive in rig.emulator.drives.values()] == before


def test_drives_stop_by_themselves_when_the_master_is_gone():
    rig = Rig(boards()).ready()

    dead = kill(rig, 5.0)
    stopped, drives = [], rig.emulator.drives.values()
    while rig.clock.now() < dead + 0.5:
        rig.clock.wait(rig.clock.now() + 0.005)
        if all(each.state is State.QUICK_STOP_ACTIVE and each.axis.velocity == 0 for each in drives):
            stopped.append(rig.clock.now() - dead)
    assert stopped
    assert stopped[0] <= 0.15


def kill(rig, place):
    """Let the program end as by `kill -9` at a place, with nothing sent any more; when that was."""

    class KilledError(Exception):
        pass

    def die(cycle):
        if cycle.set_point.place > place:
            rig.executor.axes.control_all = rig.executor.axes.send = lambda *frames: None
            raise KilledError

    rig.at_cycle.append(die)
    with pytest.raises(KilledError):
        rig.executor.run(300.0)
    return rig.clock.now()


def test_another_program_goes_on_from_where_the_arm_stands_after_a_crash():
    plan = boards()
    rig = Rig(plan).ready()
    kill(rig, 8.0)
    rig.clock.wait(rig.clock.now() + 1.0)
    stands = [drive.axis.actual for drive in rig.emulator.drives.values()]
    bus = LocalBus(rig.emulator, rig.clock)
    after = Executor(plan, rig.network, bus, rig.clock, Settings(watches_tension=False))
    found = after.arm()
    assert all(each.written == 0 for each in found)
    assert [drive.axis.actual for drive in rig.emulator.drives.values()] == stands
    assert 8.0 < after.recover() < 12.0
    assert after.run(0.0).trouble is None
    np.testing.assert_array_equal(after.axes.position, rig.counts[0])


def test_an_error_in_the_program_itself_stops_all_axes():
    rig = Rig(boards()).ready()

    def fail(cycle):
        if cycle.set_point.place > 5.0:
            raise ZeroDivisionError

    rig.at_cycle.append(fail)
    with pytest.raises(ZeroDivisionError):
        rig.executor.run(300.0)
    assert {drive.state for drive in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


def test_nothing_moves_if_an_axis_is_not_where_the_motion_begins():
    rig = Rig(boards()).ready()
    rig.drive(4).axis.actual += 100.0
    rig.drive(4).axis.demanded += 100.0
    before = [drive.axis.demanded for drive in rig.emulator.drives.values()]
    outcome = rig.executor.run(5.0)
    assert outcome.trouble is not None
    assert "cable 5 (node 5): is " in outcome.trouble.words
    assert outcome.trouble.words.endswith("from where the motion begins; nothing was moved")
    assert [drive.axis.demanded for drive in rig.emulator.drives.values()] == before


def test_what_is_not_to_be_run_is_refused():
    plan = boards()
    rig = Rig(plan)
    with pytest.raises(InputError, match="run: it is off; bring it to ready first"):
        rig.executor.run()
    rig.ready()
    with pytest.raises(InputError, match="until: expected a step from 0 to 312, got 400"):
        rig.executor.run(400)
    elsewhere = Rig(plan)
    elsewhere.drive(6).axis.actual = elsewhere.drive(6).axis.demanded = 50_000.0
    elsewhere.executor.arm()
    elsewhere.executor.hold()
    with pytest.raises(InfeasibleError, match=r"cable 7 \(node 7\) is off by [\d.]+ mm, at most 5 mm are taken up"):
        elsewhere.executor.tension()


def test_a_run_to_where_it_stands_leaves_nothing_behind():
    rig = Rig(boards()).ready()
    assert rig.executor.run(0.0).place == 0.0
    for step in (4.0, 4.0, 6.0):
        assert rig.executor.run(step).trouble is None
        np.testing.assert_array_equal(rig.executor.axes.position, rig.counts[int(step)])


def test_an_axis_that_does_not_hear_where_to_go_stops_all():
    rig = Rig(boards()).ready()
    whole = rig.emulator.receive
    rig.emulator.receive = lambda frames, now, bus=0: whole([each for each in frames if each.cob != 0x200 + 1], now)
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.axis == 0
    assert outcome.place < 300.0
    rig.executor.axes.wait(rig.clock.now() + 0.1)
    others = [drive for node, drive in rig.emulator.drives.items() if node != 1]
    assert {drive.state for drive in others} == {State.QUICK_STOP_ACTIVE}


def test_a_drive_that_misses_the_start_costs_nobody_the_power():
    rig = Rig(boards()).ready()
    rig.drive(35).axis.begin = lambda: False
    outcome = rig.executor.run(200.0)
    assert outcome.trouble is not None
    assert outcome.trouble.axis == 35
    rig.executor.axes.wait(rig.clock.now() + 1.0)
    assert State.FAULT not in {drive.state for node, drive in rig.emulator.drives.items() if node != 36}


def test_steps_are_taken_in_their_order():
    rig = Rig(boards())
    with pytest.raises(InputError, match="hold: it is off; arm it first"):
        rig.executor.hold()
    rig.executor.arm()
    with pytest.raises(InputError, match="tension: it is armed; hold it first"):
        rig.executor.tension()
    rig = Rig(boards()).ready()
    with pytest.raises(InputError, match="rate: expected a share"):
        rig.executor.run(4.0, rate=5.0)
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 2 and rig.executor.stop_at_once())
    assert rig.executor.run(FAR).trouble is not None
    with pytest.raises(InputError, match="tension: it is stopped"):
        rig.executor.tension(2.0)


@pytest.mark.parametrize("at_once", [True, False])
def test_a_stop_that_is_asked_for_as_a_run_begins_counts(at_once):
    rig = Rig(boards()).ready()

    def said(kind, words, axis):
        if kind == "run":
            (rig.executor.stop_at_once if at_once else rig.executor.stop)()

    rig.executor._said = said
    outcome = rig.executor.run(FAR)
    assert (outcome.trouble is not None) == at_once
    assert outcome.place < 1.0


def test_cyclic_positions_do_not_catch_up_after_the_program_was_late():
    rig, fastest = Rig(boards(), network_of(boards(), "cia402", slider="cia402")).ready(), []

    def be_late(cycle):
        if cycle.set_point.place == 5.0:
            rig.clock.wait(rig.clock.now() + 0.05)
        fastest.append(abs(rig.drive(36).axis.velocity))

    rig.at_cycle.append(be_late)
    assert rig.executor.run(FAR).trouble is None
    assert max(fastest) <= 1.01 * np.diff(rig.counts[:14, 36]).max() / 0.15


def test_drives_of_both_kinds_stop_when_the_program_is_late():
    rig = Rig(boards(), network_of(boards(), "cia402")).ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 5.0 and rig.clock.wait(rig.clock.now() + 0.05))
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert "ms late with set-points for drives of both kinds" in outcome.trouble.words


def test_slack_is_taken_up_section_by_section_before_tensions_are_judged():
    rig = Rig(boards(), watches_tension=True)
    for axis in (8, 35):
        slack = rig.drive(axis).axis
        slack.actual = slack.demanded = float(rig.counts[0, axis]) + 1000.0
    rig.executor.arm()
    rig.executor.hold()
    came = {}

    def look(cycle):
        for axis in (8, 35):
            if abs(rig.drive(axis).axis.actual - rig.counts[0, axis]) < 1.0:
                came.setdefault(axis, rig.clock.now())

    rig.at_cycle.append(look)
    rig.executor.tension()
    assert rig.executor.phase is Phase.READY
    assert rig.plan.robot.cable_sections[8] < rig.plan.robot.cable_sections[35]
    assert came[8] < came[35]
    rig.at_cycle.clear()
    assert rig.executor.run(2.0).trouble is None


def test_a_drive_that_fails_while_others_are_enabled_ends_that():
    rig = Rig(boards())
    rig.executor.arm()
    whole = rig.executor._switching.enable

    def enable(axis, look):
        whole(axis, look)
        if axis == 20:
            rig.emulator.inject(Fault(4, "overcurrent"))

    rig.executor._switching.enable = enable
    with pytest.raises(InfeasibleError, match=r"while drives were enabled: cable 4 \(node 4\): reports an error"):
        rig.executor.hold()
    assert rig.executor.phase is Phase.STOPPED
    assert sum(drive.state.has_power for drive in rig.emulator.drives.values()) < 25


def test_a_stop_that_one_drive_did_not_hear_is_said_again():
    rig, lost = Rig(boards()).ready(), []
    drive = rig.drive(34)
    whole = drive.receive

    def receive(frame, now):
        if frame.cob == 0x1FF and frame.data[0] == 0x02 and not lost:
            lost.append(now)
            return
        whole(frame, now)

    drive.receive = receive
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 5.0 and rig.executor.stop_at_once())
    assert rig.executor.run(FAR).trouble is not None
    assert len(lost) == 1
    rig.executor.axes.wait(rig.clock.now() + 0.06)
    assert {each.state for each in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}
    assert not any(each.axis.velocity for each in rig.emulator.drives.values())
    assert not rig.executor.axes.mute_for


def test_a_drive_that_stops_for_nothing_makes_the_master_fall_silent():
    rig = Rig(boards()).ready()
    drive = rig.drive(34)
    whole = drive.receive
    drive.receive = lambda frame, now: whole(frame, now) if frame.data[:1] != b"\x02" else None
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 5.0 and rig.executor.stop_at_once())
    assert rig.executor.run(FAR).trouble is not None
    assert rig.executor.axes.mute_for
    rig.executor.axes.wait(rig.clock.now() + 0.2)
    assert {each.state for each in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


def test_a_drive_that_is_no_longer_operational_is_noticed_and_stopped_with_the_others():
    rig = Rig(boards()).ready()
    drive = rig.drive(6)
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 5.0 and setattr(drive, "nmt", PRE_OPERATIONAL))
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words.startswith("cable 7 (node 7): is not operational any more")
    rig.executor.axes.wait(rig.clock.now() + 0.1)
    assert {each.state for each in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


def test_a_drive_in_another_mode_of_operation_stops_all():
    rig = Rig(boards()).ready()
    mode = rig.drive(11).objects[0x6060, 0]
    rig.at_cycle.append(lambda cycle: cycle.set_point.place == 5.0 and setattr(mode, "value", 6))
    outcome = rig.executor.run(300.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words == "cable 12 (node 12): is in mode 6 of operation, expected 7"


def test_a_drive_that_was_left_in_homing_mode_is_configured_anew():
    rig = Rig(boards())
    rig.executor.arm()
    rig.drive(11).objects[0x6060, 0].value = 6
    found = rig.executor.arm()
    assert [each.node for each in found if each.written] == [12]
    assert rig.drive(11).objects[0x6060, 0].value == 7


@pytest.mark.parametrize(("lost", "is_noticed"), [(0, False), (2, True), (3, True)])
def test_records_that_are_lost_are_noticed_before_an_axis_is_far_ahead(lost, is_noticed, monkeypatch):
    rig, left = Rig(boards()).ready(), [lost]
    slider, whole = rig.drive(36), EmulatedDrive._record

    def record(self, number):
        if self is slider and len(rig.cycles) > 30 and left[0]:
            left[0] -= 1
            return 0
        return whole(self, number)

    monkeypatch.setattr(EmulatedDrive, "_record", record)
    outcome = rig.executor.run(30.0)
    assert (outcome.trouble is not None) == is_noticed
    assert outcome.trouble is None or outcome.trouble.axis == 36


def test_a_stop_while_the_last_axis_settles_is_a_stop():
    rig = Rig(boards()).ready()

    def seen(cycle):
        if cycle.set_point.place == 4.0:
            rig.executor.axes.position[0] += 100  # it is still on its way
            rig.executor.stop_at_once()

    rig.at_cycle.append(seen)
    outcome = rig.executor.run(4.0)
    assert outcome.trouble is not None
    assert outcome.trouble.words == "it was told to stop at once"
    assert rig.executor.phase is Phase.STOPPED


def test_an_arm_is_not_released_from_where_nobody_knows_where_it_is():
    rig = Rig(boards())
    rig.executor.arm()
    rig.executor.hold()
    with pytest.raises(InputError, match="release: it is hold; only an arm that holds along its plan can be released"):
        rig.executor.release()


def test_what_closes_the_way_in_leaves_the_way_back_open():
    rig = Rig(boards()).ready()
    rig.executor.run(3.0)
    rig.executor.obstructed = "the record cannot be written any more"
    assert rig.executor.run(FAR).place == 3.0
    assert rig.executor.run(0.0).place == 0.0


def test_power_is_taken_only_from_slack_cables_from_the_tip_to_the_base(monkeypatch):
    rig = Rig(boards(), watches_tension=True).ready()
    order, whole = [], EmulatedDrive._power_off

    def power_off(self):
        order.append(rig.network.nodes.index(self.node))
        whole(self)

    monkeypatch.setattr(EmulatedDrive, "_power_off", power_off)
    monkeypatch.setattr(executor, "MOST_SLACK", 5e-4)  # enough for these springs, and sooner paid out
    rig.executor.release()
    assert order == list(range(36, -1, -1))
    assert rig.executor.phase is Phase.ARMED
    assert not any(drive.state.has_power for drive in rig.emulator.drives.values())
    rig.executor.hold()  # and it can be used again


def test_a_cable_that_still_pulls_keeps_the_power_of_all(monkeypatch):
    monkeypatch.setattr(executor, "MOST_SLACK", 5e-4)
    rig = Rig(boards(), watches_tension=True).ready()
    plant = rig.emulator._plant
    whole = plant.move

    def move(counts, slider, dt):
        whole(counts, slider, dt)
        plant.tensions[6] = 31.0

    plant.move = move
    with pytest.raises(InfeasibleError, match=r"cable 7 \(node 7\) still pulls 31 N with 0.5 mm of slack"):
        rig.executor.release()
    assert all(drive.state.has_power for drive in rig.emulator.drives.values())
    with pytest.raises(InputError, match="release: it is off"):
        Rig(boards()).executor.release()
    inside = Rig(boards()).ready()
    inside.executor.run(2.0)
    with pytest.raises(InputError, match="release: the arm is at step 2; it is released at step 0, outside"):
        inside.executor.release()


def test_stages_pay_out_first_and_then_pull_in_from_the_base():
    rig = Rig(boards())
    axes, robot = rig.executor.axes, rig.plan.robot
    end = rig.counts[0]
    away = np.zeros(len(end), np.int64)
    away[[3, 20, 30, 31, 36]] = np.array([-50, 700, 40, -60, 9])  # below zero: pulled in too far
    axes.position = end + away
    stages = rig.executor._approach.stages(end)
    moved = [
        np.flatnonzero(now != before).tolist()
        for before, now in zip([axes.position, *stages[:-1]], stages, strict=True)
    ]
    assert moved == [[3, 31, 36], [20], [30]]
    np.testing.assert_array_equal(stages[-1], end)
    assert (robot.travel_per_count > 0).all()
    axes.position = end.copy()
    assert len(rig.executor._approach.stages(end)) == 1


def test_a_cable_that_pulls_too_much_while_slack_is_taken_up_stops_all():
    rig = Rig(boards(), watches_tension=True)
    slack = rig.drive(8).axis
    slack.actual = slack.demanded = float(rig.counts[0, 8]) + 1000.0
    rig.executor.arm()
    rig.executor.hold()
    plant = rig.emulator._plant
    whole = plant.move

    def move(counts, slider, dt):
        whole(counts, slider, dt)
        if counts[8] < rig.counts[0, 8] + 500:
            plant.tensions[20] += 35.0

    plant.move = move
    with pytest.raises(InfeasibleError, match=r"cable 21 \(node 21\): pulls \d+ N, .* more than 20 N apart"):
        rig.executor.tension()
    assert rig.executor.phase is Phase.STOPPED


def test_what_it_refused_for_is_named_before_what_followed():
    rig = Rig(boards(), watches_tension=True).ready()
    plant = rig.emulator._plant
    whole = plant.move

    def move(counts, slider, dt):
        whole(counts, slider, dt)
        if rig.executor.refuses:
            plant.tensions[11] += 30.0

    def look(cycle):
        if cycle.set_point.place > 1.0:
            rig.executor.refuse_to_go_on("contact: link 3 is pressed")

    plant.move = move
    rig.at_cycle.append(look)
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.axis == 11
    assert outcome.trouble.words.startswith("contact: link 3 is pressed; cable 12 (node 12): pulls ")
    rig.at_cycle.clear()
    assert rig.executor.run(0.0).trouble is None
    assert not rig.executor.refuses


def test_after_a_stop_for_a_tension_the_way_back_is_open():
    rig = Rig(boards(), watches_tension=True).ready()
    rig.tighten_on_the_way(11, newton=8.0, step=1.0)
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.words.startswith("cable 12 (node 12): pulls ")
    assert rig.executor.phase is Phase.HELD
    stands = [drive.axis.demanded for drive in rig.emulator.drives.values()]
    for _ in range(3):  # the way in is closed: nothing moves
        again = rig.executor.run(FAR)
        assert again.trouble is not None
        assert again.trouble.words.endswith("; only the way back is open")
    assert [drive.axis.demanded for drive in rig.emulator.drives.values()] == stands
    after = Executor(boards(), rig.network, LocalBus(rig.emulator, rig.clock), rig.clock)
    after.arm()
    place = after.recover()  # also by another program
    assert place > 2.0
    assert after.run(FAR).place == place
    assert after.run(0.0).place == 0.0
