"""Finding all drives of a network, writing what they need, and what is wrong with each in a sentence."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from hognose.drive.alike import sentences
from hognose.drive.bus import Bus, ailment_of
from hognose.drive.clock import Clock
from hognose.drive.configuration import Entry, configuration, verification
from hognose.drive.eds_check import another_device, refuse_by_data_sheets
from hognose.drive.frames import Frame
from hognose.drive.neighbours import refuse_others
from hognose.drive.network import Network
from hognose.drive.sdo import Request, Script, SdoError, run_scripts
from hognose.drive.serial_slider.greeting import greet
from hognose.drive.serial_slider.line import LineError
from hognose.errors import InputError

#: What the device type of a drive ends with (CiA 402).
_CIA_402 = 402
#: The vendor of an `epos2`, and where the product code says that it is one.
MAXON, EPOS2_PRODUCTS = 0xFB, range(0x6200_0000, 0x6500_0000)
#: What is said of a drive that is not there.
_NO_ANSWER = "0x1000:0: no answer"


@dataclass
class Found:
    """A drive that answered.

    Attributes
    ----------
    node
    name
        What it calls itself.
    vendor, product, revision, serial
    written
        How many entries had to be written; 0 if it had its configuration.
    """

    node: int
    name: str = ""
    vendor: int = 0
    product: int = 0
    revision: int = 0
    serial: int = 0
    written: int = 0


def bring_up(
    bus: Bus,
    clock: Clock,
    network: Network,
    cycle: float,
    others: Callable[[Frame], None] = lambda frame: None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Found]:
    """Find the drives of all axes, check what they are, and write their configuration where it is not there yet.

    Set-points will come in cycles of so long (s). Nothing is enabled, no node is reset, and a drive that holds its
    position goes on holding it.

    Raises
    ------
    InputError
        Somebody else is on the bus; or drives do not answer, are no drives, are others than the network file or their
        data sheet says, or refuse what is written: a sentence for each, or one for many of which the same is said. By
        their data sheet, they have not what is needed: then nothing was sent.
    """
    refuse_by_data_sheets(network, cycle)
    refuse_others(bus, clock, network, others)
    found = {node: Found(node) for node in network.nodes}
    scripts = {
        node: _script(network, axis, cycle, found[node])
        for axis, node in enumerate(network.nodes)
        if node != network.board_node
    }
    faults = run_scripts(bus, clock, scripts, others, progress)
    if network.board_node is not None:
        faults |= _greet(bus, clock, network, cycle, found[network.board_node], others)
    if faults:
        silent = sum(_NO_ANSWER in words for words in faults.values())
        told: list[str] = []
        if silent == len(scripts):
            told = [f"none of the {silent} drives answers"]
            faults = {node: words for node, words in faults.items() if _NO_ANSWER not in words}
        told += sentences(faults, lambda node: network.axis_name(network.nodes.index(node)), "drives")
        hint = ". Is it on, is the bitrate the drives', and are the node ids right?" if silent else "."
        ails = ailment_of(bus) if silent else ""
        raise InputError(f"{network.source}: " + "\n  ".join(told) + hint + (f"\n  {ails}" if ails else ""))
    return list(found.values())


def _greet(
    bus: Bus, clock: Clock, network: Network, cycle: float, found: Found, others: Callable[[Frame], None]
) -> dict[int, str]:
    """Find and configure the board of a slider; what is wrong, by node, if anything is."""
    try:
        welcome, is_new = greet(bus, clock, network, cycle, others)
    except LineError as error:
        return {found.node: str(error)}
    found.name, found.serial, found.written = welcome.name, welcome.serial, int(is_new)
    return {}


def _script(network: Network, axis: int, cycle: float, found: Found) -> Script:
    """What is done with one drive."""
    kind = network.kinds[axis]
    (device,) = struct.unpack("<I", (yield Request(0x1000, 0)))
    if device & 0xFFFF != _CIA_402:
        raise SdoError(f"is no drive: its device type says profile {device & 0xFFFF}, expected {_CIA_402}")
    found.name = (yield Request(0x1008, 0)).decode("ascii", "replace").strip("\0 ")
    for sub, name in ((1, "vendor"), (2, "product"), (3, "revision"), (4, "serial")):
        setattr(found, name, struct.unpack("<I", (yield Request(0x1018, sub)))[0])
    is_epos2 = found.vendor == MAXON and found.product in EPOS2_PRODUCTS
    if kind == "epos2" and not is_epos2:
        raise SdoError(
            f"is {found.name!r} (vendor 0x{found.vendor:X}, product 0x{found.product:08X}), expected an EPOS2; give "
            'kind = "cia402" for drives with cyclic positions'
        )
    if differs := another_device(network.sheet(axis), found.vendor, found.product):
        raise SdoError(f"is {found.name!r}, {differs}")
    entries = configuration(network, axis, cycle)
    proof = verification(entries)
    if (yield from _has(proof if kind == "epos2" else _final(entries))):
        mode = [entry for entry in entries if entry[:2] == (0x6060, 0)]
        if not (yield from _has(mode)):  # homing changes it, and may have been cut off
            yield Request(*mode[0])
            found.written = 1
        return
    if kind == "epos2":  # until all is written, nothing is proven
        for index, sub, value in proof:
            yield Request(index, sub, bytes(len(value)))
    for entry in entries:
        yield Request(*entry)
    found.written = len(entries)
    if kind == "epos2":
        for entry in proof:
            yield Request(*entry)


def _final(entries: Iterable[Entry]) -> list[Entry]:
    """What is in the end where entries are written: a PDO is written more than once."""
    return list({entry[:2]: entry for entry in entries}.values())


def _has(entries: Iterable[Entry]) -> Script:
    """Whether a drive has these values; drives that keep no proof of their configuration are asked for all of it."""
    for index, sub, value in entries:
        if (yield Request(index, sub)) != value:
            return False
    return True
