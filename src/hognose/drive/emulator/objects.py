"""The object dictionary of an emulated drive: the objects of maxon's EPOS2 and EPOS4 that a run uses.

Indices, sizes, access, and whether they can be mapped are those of maxon's EDS files of the EPOS2 70/10 and the EPOS4
Module 50/5. So are defaults, but for PDOs, which are not mapped at first, and hold 8 objects on both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hognose.drive.network_spec import Kind

Access = Literal["ro", "rw", "wo", "const"]

#: maxon motor ag, as CiA lists vendors.
VENDOR = 0xFB
#: Product codes of the two EDS files.
PRODUCTS: dict[Kind, int] = {"epos2": 0x64200000, "cia402": 0x61500000}
#: Where drives keep what position they declare, and how far they move then; and the method that needs no switch.
HOME_POSITION: dict[Kind, int] = {"epos2": 0x2081, "cia402": 0x30B0}
MOVE_DISTANCE: dict[Kind, int] = {"epos2": 0x607C, "cia402": 0x30B1}
ACTUAL_POSITION: dict[Kind, int] = {"epos2": 35, "cia402": 37}
#: How many records the buffer of an EPOS2 holds.
RECORDS = 64


@dataclass
class Entry:
    """An entry of an object dictionary.

    Attributes
    ----------
    name
    size
        In bytes; 0 for text.
    access
    value
        The number it holds.
    text
        What it says instead, if it is text.
    signed
        Whether it may be below zero.
    mapped
        Whether it can be in a PDO.
    low, high
        What may be written.
    """

    name: str
    size: int
    access: Access
    value: int = 0
    signed: bool = False
    mapped: bool = False
    low: int | None = None
    high: int | None = None
    text: str = ""

    def bytes(self) -> bytes:
        """The value as it goes over the bus."""
        if self.text:
            return self.text.encode("ascii")
        return (self.value % (1 << 8 * self.size)).to_bytes(self.size, "little")

    def number_of(self, data: bytes) -> int:
        """The number that bytes say."""
        return int.from_bytes(data, "little", signed=self.signed)


Objects = dict[tuple[int, int], Entry]


def objects_of(kind: Kind, node: int, serial: int, counts_per_turn: int) -> Objects:
    """The dictionary of a new drive."""
    name = "EPOS2" if kind == "epos2" else "EPOS4"
    found: Objects = {
        (0x1000, 0): Entry("device type", 4, "ro", 0x00020192),
        (0x1001, 0): Entry("error register", 1, "ro"),
        (0x1005, 0): Entry("COB-ID SYNC", 4, "rw", 0x80),
        (0x1008, 0): Entry("device name", 0, "const", text=f"{name} (emulated)"),
        (0x1016, 0): Entry("consumer heartbeat times", 1, "ro", 2),
        (0x1016, 1): Entry("consumer heartbeat time 1", 4, "rw"),
        (0x1016, 2): Entry("consumer heartbeat time 2", 4, "rw"),
        (0x1017, 0): Entry("producer heartbeat time", 2, "rw"),
        (0x1018, 0): Entry("identity", 1, "ro", 4),
        (0x1018, 1): Entry("vendor", 4, "ro", VENDOR),
        (0x1018, 2): Entry("product code", 4, "ro", PRODUCTS[kind]),
        (0x1018, 3): Entry("revision", 4, "ro", 0x21220000 if kind == "epos2" else 0x01500000),
        (0x1018, 4): Entry("serial number", 4, "ro", serial),
        (0x6007, 0): Entry("abort connection option code", 2, "rw", 0 if kind == "epos2" else 3, signed=True),
        (0x605E, 0): Entry("fault reaction option code", 2, "rw", 2, signed=True),
        (0x6040, 0): Entry("controlword", 2, "rw", mapped=True),
        (0x6041, 0): Entry("statusword", 2, "ro", mapped=True),
        (0x6060, 0): Entry("mode of operation", 1, "rw", 1, signed=True, mapped=True),
        (0x6061, 0): Entry("mode of operation display", 1, "ro", signed=True, mapped=True),
        (0x6064, 0): Entry("position actual value", 4, "ro", signed=True, mapped=True),
        (0x6065, 0): Entry("following error window", 4, "rw", 2000, mapped=True),
        (0x607A, 0): Entry("target position", 4, "rw", signed=True, mapped=True),
        (0x6098, 0): Entry("homing method", 1, "rw", 7, signed=True, mapped=True),
        (HOME_POSITION[kind], 0): Entry("home position", 4, "rw", signed=True, mapped=True),
        (MOVE_DISTANCE[kind], 0): Entry("home offset", 4, "rw", signed=True, mapped=kind == "epos2"),
        (0x6085, 0): Entry("quick stop deceleration", 4, "rw", 10000, mapped=True),
    }
    if kind == "epos2":
        found |= _of_epos2(counts_per_turn)
    else:
        found |= _of_epos4(counts_per_turn)
    for k in range(4):
        found |= _pdo(0x1400 + k, 0x200 + 0x100 * k + node, 8)
        found |= _pdo(0x1800 + k, (0x80000000 if k else 0) | 0x180 + 0x100 * k + node, 8)
    return found


def _of_epos2(counts_per_turn: int) -> Objects:
    return {
        (0x1020, 0): Entry("verify configuration", 1, "ro", 2),
        (0x1020, 1): Entry("configuration date", 4, "rw"),
        (0x1020, 2): Entry("configuration time", 4, "rw"),
        (0x20C1, 0): Entry("interpolation data record", 8, "wo", mapped=True),
        (0x20C4, 0): Entry("interpolation buffer", 1, "ro", 3),
        (0x20C4, 1): Entry("interpolation buffer status", 2, "ro", mapped=True),
        (0x20C4, 2): Entry("interpolation buffer underflow warning", 2, "rw", 4, low=0, high=63),
        (0x20C4, 3): Entry("interpolation buffer overflow warning", 2, "rw", 60, low=1, high=64),
        (0x20F4, 0): Entry("following error actual value", 2, "ro", signed=True, mapped=True),
        (0x2210, 1): Entry("pulses of the encoder", 4, "rw", counts_per_turn // 4, low=16, high=2500000),
        (0x6078, 0): Entry("current actual value", 2, "ro", signed=True, mapped=True),
        (0x60C4, 1): Entry("maximum buffer size", 4, "ro", RECORDS),
        (0x60C4, 2): Entry("actual buffer size", 4, "ro", RECORDS),
        (0x60C4, 6): Entry("buffer clear", 1, "wo", mapped=True, low=0, high=1),
    }


def _of_epos4(counts_per_turn: int) -> Objects:
    return {
        (0x605A, 0): Entry("quick stop option code", 2, "rw", 6, signed=True),
        (0x3010, 1): Entry("pulses of the encoder", 4, "rw", counts_per_turn // 4, low=16, high=2500000),
        (0x6077, 0): Entry("torque actual value", 2, "ro", signed=True, mapped=True),
        (0x60C2, 1): Entry("interpolation time period", 1, "rw", low=0, high=100, mapped=True),
        (0x60F4, 0): Entry("following error actual value", 4, "ro", signed=True, mapped=True),
    }


def _pdo(index: int, cob: int, most: int) -> Objects:
    mapping = index + 0x200
    return {
        (index, 0): Entry("PDO parameter", 1, "ro", 2),
        (index, 1): Entry("COB-ID", 4, "rw", cob),
        (index, 2): Entry("transmission type", 1, "rw", 255),
        (mapping, 0): Entry("number of mapped objects", 1, "rw", 0, low=0, high=most),
        **{(mapping, k): Entry(f"mapped object {k}", 4, "rw") for k in range(1, most + 1)},
    }
