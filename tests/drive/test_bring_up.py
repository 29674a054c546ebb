"""Finding drives: all at once, each with its own sentence if something is wrong."""

import pytest
from drive_makers import REALISTIC, Rig, boards, network_of

from hognose.drive.bring_up import bring_up
from hognose.drive.emulator.emulator import Delays
from hognose.drive.emulator.faults import Fault
from hognose.drive.local_bus import LocalBus
from hognose.drive.network import Network
from hognose.errors import InputError


def test_all_drives_are_found_at_once_and_written_only_once():
    rig, seen = Rig(boards(), delays=Delays(2e-3, 3e-3)), []
    bus = LocalBus(rig.emulator, rig.clock)
    found = bring_up(bus, rig.clock, rig.network, 0.03, progress=lambda done, total: seen.append((done, total)))
    assert [each.node for each in found] == list(range(1, 38))
    assert all(each.written > 40 for each in found)
    assert seen[-1] == (37, 37)
    assert rig.clock.now() < 1.0
    before = rig.clock.now()
    again = bring_up(bus, rig.clock, rig.network, 0.03)
    assert all(each.written == 0 for each in again)
    assert [each.serial for each in again] == [each.serial for each in found]
    assert rig.clock.now() - before < 0.5


def test_drives_without_room_for_a_hash_are_asked_for_all_that_they_have():
    """Also in another run, while they exchange PDOs, in which nothing about these can be written."""
    rig = Rig(boards(), network_of(boards(), "cia402", slider="cia402"))
    bus = LocalBus(rig.emulator, rig.clock)
    assert all(each.written > 30 for each in bring_up(bus, rig.clock, rig.network, 0.03))
    rig.ready()
    assert all(each.written == 0 for each in bring_up(bus, rig.clock, rig.network, 0.03))
    rig.drive(3).objects[0x6065, 0].value = 5000
    with pytest.raises(InputError, match=r"cable 4 \(node 4\): 0x1400:1: it cannot in its present state"):
        bring_up(bus, rig.clock, rig.network, 0.03)


def test_a_configuration_that_was_not_written_whole_is_written_again():
    rig = Rig(boards())
    bus = LocalBus(rig.emulator, rig.clock)
    bring_up(bus, rig.clock, rig.network, 0.03)
    drive = rig.drive(3)
    written = drive._written
    drive._sdo._written = lambda index, sub, number: 0x08000022 if index == 0x1400 else written(index, sub, number)
    wider = rig.network.spec.drives.model_copy(update={"following_error_counts": 5000})
    other = Network(rig.network.spec.model_copy(update={"drives": wider}), boards().robot, "other")
    with pytest.raises(InputError, match="0x1400:1"):
        bring_up(bus, rig.clock, other, 0.03)
    drive._sdo._written = written
    assert drive.objects[0x6065, 0].value == 5000
    assert bring_up(bus, rig.clock, rig.network, 0.03)[3].written > 40
    assert drive.objects[0x6065, 0].value == 200


@pytest.mark.parametrize("nodes", [(7,), (1, 20, 36)])
def test_a_drive_that_is_silent_is_named(nodes):
    rig = Rig(boards())
    for node in nodes:
        rig.emulator.inject(Fault(node, "frozen"))
    with pytest.raises(InputError) as caught:
        rig.executor.arm()
    for node in nodes:
        assert f"cable {node} (node {node}): 0x1000:0: no answer in 750 ms" in str(caught.value)
    assert str(caught.value).count("no answer") == len(nodes)
    assert "are the node ids right?" in str(caught.value)


def test_what_is_the_same_of_many_drives_is_said_once():
    rig = Rig(boards())
    for node in (2, 3, 4, 9, 11, 12):
        rig.drive(node - 1).objects[0x1000, 0].value = 0x191
    rig.drive(19).objects[0x1000, 0].value = 0
    with pytest.raises(InputError) as caught:
        rig.executor.arm()
    assert str(caught.value).splitlines() == [
        f"{rig.network.source}: 6 drives (nodes 2 to 4, 9, 11 to 12): is no drive: its device type says profile 401, "
        "expected 402",
        "  cable 20 (node 20): is no drive: its device type says profile 0, expected 402.",
    ]


def test_a_bus_on_which_nobody_answers_is_said_in_one_sentence():
    rig = Rig(boards())
    for node in rig.network.nodes:
        rig.emulator.inject(Fault(node, "bus_off"))
    with pytest.raises(InputError, match=r"none of the 37 drives answers\. Is it on, is the bitrate"):
        rig.executor.arm()


def test_another_kind_of_drive_than_the_file_says_is_named():
    plan = boards()
    rig = Rig(plan, network_of(plan, "cia402"))
    other = Rig(plan)
    with pytest.raises(InputError, match=r"36 drives \(nodes 1 to 36\): is 'EPOS4 \(emulated\)' .*, expected an EPOS2"):
        bring_up(LocalBus(rig.emulator, rig.clock), rig.clock, other.network, 0.03)
    rig = Rig(plan, delays=REALISTIC)
    rig.emulator.drives[3].objects[0x1000, 0].value = 0x191
    with pytest.raises(InputError, match=r"cable 3 \(node 3\): is no drive: its device type says profile 401"):
        rig.executor.arm()
