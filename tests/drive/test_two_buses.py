"""Drives on two buses move as those on one do; nodes on the wrong bus, and files that make no sense, are said."""

import numpy as np
import pytest
from drive_makers import Rig, boards, network_of

from hognose.drive.alike import in_ranges
from hognose.drive.bring_up import bring_up
from hognose.drive.bus import BusError
from hognose.drive.bus_load import bus_loads
from hognose.drive.buses import Buses
from hognose.drive.cia402 import State
from hognose.drive.emulator.faults import Fault
from hognose.drive.frames import Frame
from hognose.drive.local_bus import LocalBus
from hognose.drive.network import Network
from hognose.drive.settings import Phase
from hognose.errors import InputError

SECOND = tuple(range(19, 38))


def on_two(kind="epos2", nodes=SECOND, **changed):
    made = network_of(boards(), kind, slider=kind)
    spec = made.spec.model_dump(by_alias=True)
    spec["bus"]["channel"] = "one"
    spec["bus2"] = {"interface": "hognose", "channel": "two", "nodes": list(nodes), "most_load": 1.0}
    spec |= changed
    return Network(type(made.spec).model_validate(spec), boards().robot, "bench.toml")


class Heard(LocalBus):
    """A bus that keeps what was sent on it."""

    def __init__(self, *given, **named):
        super().__init__(*given, **named)
        self.sent = []

    def send(self, frames):
        self.sent += frames
        super().send(frames)


def rig_on(network, as_file_says=True):
    """A rig with two buses; drives may be on others than the file says."""
    rig = Rig(boards(), network)
    if not as_file_says:
        rig.emulator._bus_of[19] = 0
    buses = [Heard(rig.emulator, rig.clock, number=k) for k in (0, 1)]
    both = Buses(buses, network.bus_of, network.bus_names)
    rig.executor._bus = rig.executor.axes._bus = both
    return rig, buses, both


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["epos2", "cia402"])
def test_all_axes_are_where_the_plan_is_at_the_same_sync(kind):
    rig, buses, _ = rig_on(on_two(kind))
    rig.ready()
    for bus in buses:
        bus.sent.clear()
    off = []

    def look(cycle):
        place = cycle.set_point.place
        if place == int(place):
            demanded = np.array([drive.axis.demanded for drive in rig.emulator.drives.values()])
            off.append(np.abs(demanded - rig.counts[int(place)]).max())

    rig.at_cycle.append(look)
    assert rig.executor.run(6.0).trouble is None
    assert max(off) <= np.abs(np.diff(rig.counts[:8], axis=0)).max() / 5 + 2
    np.testing.assert_allclose(rig.executor.axes.position, rig.counts[6], atol=1)
    for k, bus in enumerate(buses):
        theirs = {frame.cob & 0x7F for frame in bus.sent} - {0, 127}
        assert theirs == {node for node, on in rig.network.bus_of.items() if on == k}
    shared = [[frame for frame in bus.sent if frame.cob & 0x7F in (0, 127)] for bus in buses]
    assert shared[0] == shared[1]
    assert Frame(0x080, b"") in shared[0]


@pytest.mark.slow
def test_a_fault_on_one_bus_stops_the_other():
    rig, buses, _ = rig_on(on_two())
    rig.ready()
    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 2.0 and rig.emulator.inject(Fault(30, "overcurrent")))
    outcome = rig.executor.run(50.0)
    assert outcome.trouble is not None
    assert outcome.trouble.axis == 29
    rig.executor.axes.wait(rig.clock.now() + 0.1)
    assert all(drive.axis.velocity == 0.0 for drive in rig.emulator.drives.values())
    assert all(bus.sent.count(Frame(0x1FF, b"\x02\0")) >= 1 for bus in buses)


@pytest.mark.slow
@pytest.mark.parametrize("dead", [0, 1])
def test_where_one_bus_dies_the_other_gets_the_stop(dead):
    rig, buses, _ = rig_on(on_two())
    rig.ready()

    def die(frames):
        raise BusError("bus: unplugged")

    rig.at_cycle.append(lambda cycle: cycle.set_point.place > 2.0 and setattr(buses[dead], "send", die))
    with pytest.raises(BusError, match="unplugged"):
        rig.executor.run(50.0)
    assert rig.executor.phase is Phase.STOPPED
    assert Frame(0x1FF, b"\x02\0") in buses[1 - dead].sent
    rig.clock.wait(rig.clock.now() + 0.2)  # the others miss the master
    assert {drive.state for drive in rig.emulator.drives.values()} == {State.QUICK_STOP_ACTIVE}


def test_a_drive_on_the_other_bus_than_the_file_says_is_named():
    rig, _, both = rig_on(on_two(), as_file_says=False)
    with pytest.raises(InputError, match="node 19 is on the bus 'one', but the file has it on the bus 'two'"):
        bring_up(both, rig.clock, rig.network, 0.03)


def test_a_bus_of_another_bitrate_is_named():
    network = on_two()
    rig = Rig(boards(), network)
    buses = [LocalBus(rig.emulator, rig.clock), LocalBus(rig.emulator, rig.clock, bitrate=250_000, number=1)]
    with pytest.raises(InputError) as caught:
        bring_up(Buses(buses, network.bus_of, network.bus_names), rig.clock, network, 0.03)
    assert f"{len(SECOND)} drives (nodes {in_ranges(sorted(SECOND))}): 0x1000:0: no answer" in str(caught.value)
    assert "the bus 'two': " in str(caught.value)
    assert "another than bus.bitrate, 250,000 bit/s" in str(caught.value)


def test_the_load_is_that_of_each_bus():
    one, two = network_of(boards()), on_two()
    (whole,), halves = bus_loads(one.spec, 5), bus_loads(two.spec, 5)
    assert max(halves) < 0.55 * whole
    assert sum(halves) == pytest.approx(whole, rel=0.02)
    few = {"cycle_s": 0.005, "drives": two.spec.drives.model_dump() | {"least_records": 25, "most_records": 40}}
    with pytest.raises(InputError, match=r"the bus 'one' would be taken for \d+ % .*move nodes to the other bus"):
        on_two(**few)


@pytest.mark.parametrize(
    ("nodes", "said"),
    [
        ((19, 19), "bus2.nodes: node 19 is there twice"),
        ((19, 99), "bus2.nodes: node 99 is no drive of this file"),
        ((), "bus2.nodes: give some drives, not all"),
        (range(1, 38), "bus2.nodes: give some drives, not all"),
    ],
)
def test_files_with_two_buses_that_make_no_sense_are_refused(nodes, said):
    with pytest.raises(ValueError, match=said):
        on_two(nodes=nodes)


def test_two_buses_are_two():
    second = {"interface": "hognose", "channel": "one", "nodes": [19]}
    with pytest.raises(ValueError, match=r"bus2\.channel: 'one' is the channel of `bus` already"):
        on_two(bus2=second)
