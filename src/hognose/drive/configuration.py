"""What is written to every drive before it moves: modes, PDOs, watchdogs, limits; and a hash of it that it keeps.

Objects and their sizes are those of the EDS files of maxon's EPOS2 and EPOS4, of CiA 301 and of CiA 402.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Sequence
from typing import NamedTuple

from hognose.drive.cia402 import CYCLIC_POSITION, INTERPOLATED_POSITION
from hognose.drive.network import FEEDBACK_EVERY, Network
from hognose.drive.network_spec import MASTER

#: Identifiers of PDOs; the node is added, except for the controlword that all drives listen to.
SET_POINT, DECELERATION, ALL_CONTROL, CONTROL, STATUS, FEEDBACK = 0x200, 0x300, 0x1FF, 0x500, 0x180, 0x280
#: Transmission types: as soon as it comes, and with every SYNC.
_AT_ONCE, _EVERY_SYNC = 255, 1
_DISABLED = 1 << 31
#: Where a drive keeps what verifies its configuration: a date and a time for CiA 301, half a hash each here.
VERIFICATION = 0x1020
#: What a drive does when the master is lost: a quick stop, after which it holds its position.
_QUICK_STOP_WHEN_LOST = 3
_HOLDS_AFTER_A_STOP = 6


class Entry(NamedTuple):
    """A value of an object dictionary, in as many bytes as it has."""

    object_index: int
    sub: int
    value: bytes

    @classmethod
    def of(cls, index: int, sub: int, value: int, size: int) -> Entry:
        """A whole number of so many bytes."""
        return cls(index, sub, (value % (1 << 8 * size)).to_bytes(size, "little"))


def configuration(network: Network, axis: int, cycle: float) -> list[Entry]:
    """Everything that is written to the drive of an axis (0-based), in order, for cycles of so long (s)."""
    spec, node, kind = network.spec, network.nodes[axis], network.kinds[axis]
    window = int(network.following_windows[axis])
    lost, beat = round(1e3 * spec.watch.lost_after_s), round(1e3 * spec.watch.heartbeat_s)
    mode = INTERPOLATED_POSITION if kind == "epos2" else CYCLIC_POSITION
    entries = [
        Entry.of(0x6060, 0, mode, 1),
        Entry.of(0x6065, 0, window, 4),
        Entry.of(0x6007, 0, _QUICK_STOP_WHEN_LOST, 2),
        Entry.of(0x1016, 1, MASTER << 16 | lost, 4),
        Entry.of(0x1017, 0, beat, 2),
    ]
    if kind == "epos2":
        entries += [Entry.of(0x20C4, 2, spec.drives.least_records, 2), Entry.of(0x20C4, 3, spec.drives.most_records, 2)]
        set_point, when, current = (0x20C1, 0, 64), _AT_ONCE, (0x6078, 0, 16)
        feedback = [(0x20F4, 0, 16), (0x20C4, 1, 16), (0x6061, 0, 8)]
    else:
        # With a period of 0 an EPOS4 does not interpolate, but jumps from position to position.
        entries.append(Entry.of(0x60C2, 1, round(1e3 * cycle), 1))
        entries.append(Entry.of(0x605A, 0, _HOLDS_AFTER_A_STOP, 2))  # by CiA 402's default, a stop cuts the power
        set_point, when, current = (0x607A, 0, 32), _EVERY_SYNC, (0x6077, 0, 16)
        feedback = [(0x60F4, 0, 32), (0x6061, 0, 8)]
    entries += _pdo(0x1400, SET_POINT + node, when, [set_point])
    entries += _pdo(0x1401, DECELERATION + node, _AT_ONCE, [(0x6085, 0, 32)])
    entries += _pdo(0x1402, ALL_CONTROL, _AT_ONCE, [(0x6040, 0, 16)])
    entries += _pdo(0x1403, CONTROL + node, _AT_ONCE, [(0x6040, 0, 16)])
    entries += _pdo(0x1800, STATUS + node, _EVERY_SYNC, [(0x6041, 0, 16), (0x6064, 0, 32), current])
    entries += _pdo(0x1801, FEEDBACK + node, FEEDBACK_EVERY, feedback)
    return entries


def verification(entries: Sequence[Entry]) -> tuple[Entry, Entry]:
    """What a drive keeps so that it is known to have this configuration: the first eight bytes of its hash."""
    whole = b"".join(struct.pack("<HBB", *entry[:2], len(entry.value)) + entry.value for entry in entries)
    digest = hashlib.sha256(whole).digest()
    return Entry(VERIFICATION, 1, digest[:4]), Entry(VERIFICATION, 2, digest[4:8])


def _pdo(index: int, cob: int, when: int, mapped: Sequence[tuple[int, int, int]]) -> list[Entry]:
    """A PDO that is disabled, mapped and enabled again (CiA 301, 7.5.2.36)."""
    mapping = index + 0x200
    return [
        Entry.of(index, 1, cob | _DISABLED, 4),
        Entry.of(index, 2, when, 1),
        Entry.of(mapping, 0, 0, 1),
        *(Entry.of(mapping, k, i << 16 | sub << 8 | bits, 4) for k, (i, sub, bits) in enumerate(mapped, 1)),
        Entry.of(mapping, 0, len(mapped), 1),
        Entry.of(index, 1, cob, 4),
    ]
