"""What a bus that is there asks for: time for frames, room in its queue, nobody else who commands, and a warning."""

import struct
from collections import Counter

import numpy as np
import pytest
from drive_makers import Rig, boards, network_of

from hognose.drive.bus_load import frame_bits
from hognose.drive.cia402 import State
from hognose.drive.emulator.faults import Fault
from hognose.drive.frames import Frame
from hognose.drive.network import Network
from hognose.drive.real_drives import refuse_unattended, untested
from hognose.drive.switching import Switching
from hognose.drive.watch import Stop
from hognose.errors import InfeasibleError, InputError

FAR = 300.0


def real_network(bitrate=1_000_000, **changed) -> Network:
    made = network_of(boards())
    spec = made.spec.model_dump(by_alias=True) | changed
    spec["bus"] |= {"interface": "socketcan", "channel": "can0", "bitrate": bitrate, "most_load": 1.0}
    return Network(type(made.spec).model_validate(spec), boards().robot, "bench.toml")


@pytest.mark.parametrize("bitrate", [1_000_000, 500_000])
def test_answers_are_waited_for_as_long_as_the_bus_needs_for_them(bitrate):
    an_axis = frame_bits(8) + frame_bits(5)
    network = real_network(bitrate, cycle_s=0.06)
    assert network.answer_s == pytest.approx(5e-3 + 37 * an_axis / bitrate)
    assert network_of(boards()).answer_s == 5e-3  # frames of an emulated bus take no time
    second = {"interface": "socketcan", "channel": "can1", "nodes": list(range(19, 38)), "most_load": 1.0}
    assert real_network(bitrate, cycle_s=0.06, bus2=second).answer_s == pytest.approx(5e-3 + 19 * an_axis / bitrate)


def test_no_more_than_a_record_of_every_axis_is_sent_at_a_time():
    rig, sizes = Rig(boards()).ready(), Counter()
    send = rig.bus.send

    def count(frames):
        sizes[len(frames)] += 1
        send(frames)

    rig.bus.send = count
    assert rig.executor.run(5.0).trouble is None
    axes = len(rig.executor.axes)
    assert axes <= max(sizes) <= 2 * axes + 1  # a record and a deceleration of each, and a heartbeat


def test_where_drives_go_on_all_the_same_the_master_is_silent_before_buffers_run_empty():
    rig = Rig(boards(), real_network()).ready()
    drive, began = rig.drive(34), []
    whole = drive.receive
    drive.receive = lambda frame, now: whole(frame, now) if frame.data[:1] != b"\x02" else None

    def stop(cycle):
        if cycle.set_point.place > 5.0 and not began:
            began.append(cycle.time)
            rig.executor.stop_at_once()

    rig.at_cycle.append(stop)
    assert rig.executor.run(FAR).trouble is not None
    assert rig.executor.axes.mute_for
    assert rig.clock.now() - began[0] < rig.executor.cycle + 0.035
    rig.executor.axes.wait(rig.clock.now() + 0.2)
    assert {each.state for each in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


@pytest.mark.parametrize(
    ("frame", "does"),
    [
        (Frame(0x000, b"\x01\x00"), "starts, stops or resets nodes"),
        (Frame(0x080, b""), "sends SYNC"),
        (Frame(0x77F, b"\x05"), "sends the heartbeats of node 127"),
        (Frame(0x1FF, b"\x0f\x00"), "tells drives what to do"),
        (Frame(0x203, struct.pack("<q", 7)), "tells drives what to do"),
        (Frame(0x603, bytes(8)), "tells drives what to do"),
        (Frame(0x660, bytes(8)), "tells drives what to do"),  # a node that is none of ours: who is it?
    ],
)
def test_somebody_else_who_comes_to_command_drives_stops_all(frame, does):
    rig = Rig(boards()).ready()
    receive, came = rig.bus.receive, []

    def also():
        found = receive()
        if rig.cycles and rig.cycles[-1].set_point.place > 3.0 and not came:
            came.append(frame)
            return [*found, frame]
        return found

    rig.bus.receive = also
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    assert outcome.trouble.stop is Stop.AT_ONCE
    assert f"there is another master on the bus: somebody {does}" in outcome.trouble.words
    assert 3.0 < outcome.place < 4.5
    assert rig.executor.recover() == pytest.approx(outcome.place, abs=1.5)  # once that program has ended
    assert rig.executor.run(20.0).trouble is None


def test_what_others_on_the_bus_say_is_no_command():
    rig = Rig(boards()).ready()
    for cob in (0x180 + 99, 0x700 + 99, 0x580 + 99, 0x080 + 99, 0x200 + 99):
        rig.executor.axes.take(Frame(cob, bytes(8)))
    assert rig.executor.axes.foreign_commands == 0


def test_an_axis_that_says_nothing_is_not_taken_to_rest():
    rig = Rig(boards()).ready()
    switching, silent = Switching(rig.executor.axes), rig.drive(3)
    switching.rest()
    take = rig.executor.axes.take
    rig.executor.axes.take = lambda frame: None if frame.cob & 0x7F == silent.node else take(frame)
    with pytest.raises(InfeasibleError, match=r"every drive rests; still: cable 4 \(node 4\)"):
        switching.rest()


def test_a_cable_may_pull_with_a_current_below_zero():
    spec = network_of(boards()).spec.model_dump(by_alias=True)
    spec["drives"]["newton_per_unit"] = -0.1
    network = Network(type(network_of(boards()).spec).model_validate(spec), boards().robot, "bench.toml")
    axes = Rig(boards(), network).executor.axes
    axes.load[:] = -300.0
    np.testing.assert_allclose(axes.tensions, 30.0)
    spec["drives"]["newton_per_unit"] = 0.0
    with pytest.raises(ValueError, match="no tension would be seen"):
        type(network.spec).model_validate(spec)


def test_each_axis_is_judged_by_its_own_window():
    network = network_of(boards())
    assert network.following_windows.tolist() == [200] * 37  # 0.2 mm of a slider with 1,000,000 counts a metre
    spec = network.spec.model_dump(by_alias=True)
    spec["slider"] |= {"counts_per_metre": 1e5}
    other = Network(type(network.spec).model_validate(spec), boards().robot, "bench.toml")
    assert other.following_windows.tolist() == [200] * 36 + [20]


def test_drives_that_are_there_are_said_to_be_and_are_not_moved_unattended():
    network = real_network()
    assert untested(network).startswith("The drives on socketcan are real, and no version of Hognose has been tested")
    refuse_unattended(network, yes=False)
    with pytest.raises(InputError, match="only after a confirmation at a terminal, without --yes"):
        refuse_unattended(network, yes=True)
    emulated = network_of(boards())
    assert untested(emulated) == ""
    refuse_unattended(emulated, yes=True)


@pytest.mark.parametrize("kind", ["heartbeat_lost", "frozen"])
def test_a_drive_that_was_silent_is_heard_again_before_it_is_judged(kind):
    rig = Rig(boards()).ready()

    def break_it(cycle):
        if cycle.set_point.place > 3.0:
            rig.emulator.inject(Fault(7, kind))

    rig.at_cycle.append(break_it)
    outcome = rig.executor.run(FAR)
    assert outcome.trouble is not None
    rig.clock.wait(rig.clock.now() + 1.0)
    with pytest.raises(InfeasibleError, match=r"says its status and sends heartbeats; still: cable 7 \(node 7\)"):
        rig.executor.recover()
    rig.at_cycle.clear()
    rig.emulator.repair(7)
    rig.executor.recover()
    assert rig.executor.run(0.0).trouble is None
