"""A stop, a pause or an end is not lost, whenever it is asked for; and nothing goes on behind it."""

import numpy as np
import pytest
from drive_makers import Rig, boards, network_of
from test_conductor import Run, Typist

from hognose.drive.cia402 import QUICK_STOP, State
from hognose.drive.frames import Frame
from hognose.drive.network import Network
from hognose.drive.settings import Phase
from hognose.drive.watch import Stop
from hognose.drive.wishes import Want
from hognose.errors import InfeasibleError, InputError

#: Nothing here depends on how a processor rounds.
pytestmark = pytest.mark.slow
FAR = 300.0


def changed(**tables) -> Network:
    made = network_of(boards())
    spec = made.spec.model_dump(by_alias=True)
    for table, values in tables.items():
        if isinstance(values, dict):
            spec[table] |= values
        else:
            spec[table] = values
    return Network(type(made.spec).model_validate(spec), boards().robot, "bench.toml")


def deaf(drive, times=10**9):
    """A drive that does not hear that it is to stop, so many times."""
    whole, left = drive.receive, [times]

    def receive(frame, now):
        if frame.cob in (0x1FF, 0x500 + drive.node) and frame.data[0] == QUICK_STOP and left[0]:
            left[0] -= 1
            return
        whole(frame, now)

    drive.receive = receive


def stop_at(rig, place):
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > place and rig.executor.stop_at_once())


def test_a_master_that_fell_silent_sends_heartbeats_again_before_anything_moves():
    rig = Rig(boards()).ready()
    drive = rig.drive(34)
    hears = drive.receive
    deaf(drive)
    stop_at(rig, 5.0)
    assert rig.executor.run(FAR).trouble is not None
    assert rig.executor.axes.mute_for == "cable 35 (node 35) went on"
    assert rig.events[-1][:2] == (
        "stopped",
        f"at step {rig.executor.place:.1f}; cable 35 (node 35) went on, so the master fell silent: drives stop by "
        "themselves",
    )
    drive.receive = hears
    rig.at_cycle.clear()
    rig.clock.wait(rig.clock.now() + 1.0)
    rig.executor.recover()
    assert rig.executor.axes.mute_for == ""
    rig.at_cycle.append(lambda cycle: 1 / 0 if cycle.set_point.place > 12.0 else None)
    rig.executor._stream.stop_at_once = lambda: None  # the program dies
    with pytest.raises(ZeroDivisionError):
        rig.executor.run(FAR)
    rig.clock.wait(rig.clock.now() + 0.3)
    assert {each.state for each in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


def test_a_stop_is_said_again_on_a_slow_bus_too():
    bus = {"interface": "socketcan", "channel": "can0", "bitrate": 500_000, "most_load": 1.0}
    rig = Rig(boards(), changed(bus=bus, cycle_s=0.06)).ready()
    deaf(rig.drive(34), times=1)
    stop_at(rig, 5.0)
    assert rig.executor.run(FAR).trouble is not None
    assert rig.executor.axes.mute_for == ""
    assert {each.state for each in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


def test_a_bus_on_which_no_stop_can_be_said_again_is_refused():
    bus = {"interface": "socketcan", "channel": "can0", "bitrate": 250_000, "most_load": 1.0}
    with pytest.raises(
        InputError, match=r"a stop that one of them misses could not be said again .*drives.least_records \(4\)"
    ):
        changed(bus=bus, cycle_s=0.08, watch={"heartbeat_s": 0.1, "lost_after_s": 0.24}, drives={"least_records": 4})


def test_drives_that_take_the_bit_that_starts_records_for_a_level_wait_until_all_are_filled():
    rig = Rig(boards()).ready()
    begun = []
    for axis in range(37):
        drive = rig.drive(axis)
        begin = drive.axis.begin

        def note(begin=begin, node=drive.node):
            if begin():
                begun.append((rig.executor.phase, node))
                return True
            return False

        drive.axis.begin = note
    for end in (4.0, 7.0, 2.0):
        begun.clear()
        assert rig.executor.run(end).trouble is None
        assert len(begun) == 37
        assert {phase for phase, _ in begun} == {Phase.RUN}


@pytest.mark.parametrize("when", ["asked", "emptied", "filled"])
def test_a_pause_before_it_moves_is_kept_and_costs_no_power(when):
    rig = Rig(boards()).ready()
    axes, executor = rig.executor.axes, rig.executor
    named = {"asked": "ask", "emptied": "empty_buffers", "filled": "set_points"}[when]
    whole = getattr(axes, named)

    def pause(*given, **named):
        executor.stop()
        return whole(*given, **named)

    setattr(axes, named, pause)
    outcome = executor.run(FAR)
    assert outcome.trouble is None
    assert outcome.place < 0.5
    assert {drive.state for drive in rig.emulator.drives.values()} == {State.OPERATION_ENABLED}
    assert not any(drive.errors for drive in rig.emulator.drives.values())
    setattr(axes, named, whole)
    assert executor.run(3.0).trouble is None


@pytest.mark.parametrize("at_once", [False, True])
def test_who_interrupts_a_question_has_answered_no(at_once):
    run = Run(Typist("yes"))
    assert run.conductor.confirmed("it goes") is True

    class Interrupts(Typist):
        def answer(self):
            if self._waited == 1:
                run.conductor.interrupt(at_once)
            return super().answer()

    run.conductor._terminal = Interrupts("yes")
    assert run.conductor.confirmed("it goes") is False


@pytest.mark.parametrize(
    ("want", "ends"), [(Want.END, True), (Want.PAUSE, True), (Want.STOP, True), (Want.STEP, False)]
)
def test_what_comes_after_the_last_cycle_is_kept_for_the_end(want, ends):
    run = Run(Typist("e"))
    leg = run.conductor._leg

    def late(end):
        outcome = leg(end)
        run.wishes.put(want, "a follower")
        return outcome

    run.conductor._leg = late
    outcome = run.conductor.go(4.0)
    assert outcome.place == 4.0
    assert bool(run.conductor.turned) == ends
    assert (run.wishes.take() is None) == ends


def test_a_tension_that_gets_far_worse_stops_all_at_once():
    rig = Rig(boards(), watches_tension=True).ready()
    rig.tighten_on_the_way(11, newton=40.0, step=3.0)
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.stop is Stop.AT_ONCE
    assert outcome.place < 5.2  # along the path it would be 6.1
    place = rig.executor.recover()  # the way back is open, the way in is not
    assert rig.events[-1][1].endswith("; only the way back is open")
    stands = [drive.axis.demanded for drive in rig.emulator.drives.values()]
    again = rig.executor.run(FAR)
    assert again.trouble is not None
    assert again.trouble.words.endswith("; only the way back is open")
    assert [drive.axis.demanded for drive in rig.emulator.drives.values()] == stands
    assert again.place == place
    assert (rig.executor.run(0.0).trouble, rig.executor.place) == (None, 0.0)


def test_a_cable_that_says_that_it_pushes_is_not_pulled_in():
    rig = Rig(boards(), watches_tension=True)
    rig.executor.axes.network = changed(drives={"newton_per_unit": -0.1})
    rig.executor.arm()
    rig.executor.hold()
    with pytest.raises(
        InfeasibleError, match=r"says that it pushes with .* N, .* has drives.newton_per_unit the right sign"
    ):
        rig.executor.tension()


@pytest.mark.parametrize("when", ["arm", "recover"])
def test_another_master_while_drives_are_found_or_recovered_is_not_forgotten(when, monkeypatch):
    rig = Rig(boards()) if when == "arm" else Rig(boards()).ready()
    if when == "recover":
        stop_at(rig, 2.0)
        rig.executor.run(FAR)
    until = rig.executor._switching.until

    def also(left, wanted, *rest):
        rig.executor.axes.take(Frame(0x1FF, bytes([6, 0])))
        until(left, wanted, *rest)

    monkeypatch.setattr(rig.executor._switching, "until", also)
    with pytest.raises(
        (InputError, InfeasibleError), match="there is another master on the bus: somebody tells drives"
    ):
        getattr(rig.executor, when)()


def test_a_coarse_axis_may_not_leap():
    network = changed(slider={"counts_per_metre": 1e4})
    assert network.following_windows[36] == 2
    rig = Rig(boards(), network)
    np.testing.assert_array_equal(rig.executor._stream._arrived, [20] * 36 + [2])


def test_a_tension_that_leaves_its_band_while_somebody_thinks_is_said_once():
    rig = Rig(boards(), watches_tension=True).ready()
    plant, left = rig.emulator._plant, [30]
    whole = plant.move

    def move(counts, slider, dt):
        whole(counts, slider, dt)
        plant.tensions[11] += 60.0

    def done():
        left[0] -= 1
        return not left[0]

    plant.move = move
    rig.events.clear()
    assert rig.executor.wait(done) is None
    assert len(rig.events) == 1
    assert rig.events[0][1].startswith("cable 12 (node 12): pulls ")
