"""Whether drives are what their data sheets say, and have all that a run needs: said before anything is sent."""

from __future__ import annotations

from collections.abc import Iterator

from hognose.drive.configuration import Entry, configuration, verification
from hognose.drive.eds import Eds, EdsEntry
from hognose.drive.network import Network
from hognose.errors import InputError

#: What a run needs an object for: to do this.
_ROLES = {
    0x1016: "notice that the program is gone",
    0x1017: "say that the drive is there",
    0x1018: "say what the drive is",
    0x1020: "keep a proof of the configuration",
    0x2081: "declare a position when homing",
    0x20C1: 'take records of position, velocity and time, as kind = "epos2" does',
    0x20C4: "say how full the buffer of records is",
    0x20F4: "say the following error",
    0x30B0: "declare a position when homing",
    0x30B1: "home without moving",
    0x6007: "stop and hold when the program is gone",
    0x6040: "enable, start and stop",
    0x6041: "say the state, and whether the drive is homed",
    0x605A: "hold the position after a stop",
    0x6060: "choose the mode of operation",
    0x6061: "say the mode of operation",
    0x6064: "say the position",
    0x6065: "notice that the motor lags behind",
    0x6077: "say the tension of the cable",
    0x6078: "say the tension of the cable",
    0x607A: 'take a position every cycle, as kind = "cia402" does',
    0x607C: "home without moving",
    0x6085: "stop all axes in the same time",
    0x6098: "home",
    0x60C2: "interpolate between positions, and not jump",
    0x60F4: "say the following error",
}
#: What is read of every drive, with its size in bytes.
_READ = ((0x1000, 0, 4), (0x1018, 1, 4), (0x1018, 2, 4), (0x6041, 0, 2), (0x6064, 0, 4))
#: What homing writes, by vendor and by what of the two is there: maxon's EPOS2 and EPOS4.
_MAXON, _HOMING = 0xFB, {"epos2": (0x2081, 0x607C), "cia402": (0x30B0, 0x30B1)}
#: No more differences are said.
_MOST_SAID = 12


def refuse_by_data_sheets(network: Network, cycle: float) -> None:
    """Raise an InputError that lists what drives do not have by their data sheets, for cycles of so long (s)."""
    cables = len(network.spec.drives.nodes)
    for table, axis, sheet in zip(("drives", "slider"), (0, cables), network.sheets, strict=True):
        if sheet is None:
            continue
        found = list(dict.fromkeys(_differences(network, axis, cycle, sheet)))
        if found:
            told = found[:_MOST_SAID] + ([f"and {len(found) - _MOST_SAID} more"] if len(found) > _MOST_SAID else [])
            raise InputError(
                f"{network.source}: {table}.eds: {sheet.source} describes {sheet.product_name or 'a device'}, which "
                f'cannot be run as kind = "{network.kinds[axis]}"; is it the right file?\n  ' + "\n  ".join(told)
            )


def another_device(sheet: Eds | None, vendor: int, product: int) -> str:
    """What is wrong, in words, if a drive with these numbers is not the one of a data sheet; empty if it is."""
    if sheet is None:
        return ""
    expected, got = [], []
    for name, said, has in (("vendor", sheet.vendor, vendor), ("product", sheet.product, product)):
        if said and said != has:
            expected.append(f"{name} 0x{said:X}")
            got.append(f"{name} 0x{has:X}")
    if not expected:
        return ""
    return f"{' and '.join(got)}, but {sheet.source} describes {sheet.product_name!r}, {' and '.join(expected)}"


def _differences(network: Network, axis: int, cycle: float, sheet: Eds) -> Iterator[str]:
    """What of a run differs from a data sheet, in words."""
    kind = network.kinds[axis]
    entries = configuration(network, axis, cycle)
    yield from _too_few_pdos(entries, sheet)
    if kind == "epos2":
        entries += verification(entries)
    for index, sub, size in _READ:
        yield from _wrong_to_read(sheet, index, sub, size)
    for entry in entries:
        is_mapping = bool(entry.object_index & 0x200 and 0x1400 <= entry.object_index < 0x1C00 and entry.sub)
        yield from _wrong_to_write(sheet, entry, not is_mapping)
        if is_mapping:
            yield from _wrong_to_map(sheet, entry)
    if sheet.vendor == _MAXON and not network.is_absolute[axis]:
        for index, size in ((0x6098, 1), *((each, 4) for each in _HOMING[kind])):
            yield from _wrong_to_write(sheet, Entry(index, 0, bytes(size)), False)


def _found(sheet: Eds, index: int, sub: int) -> tuple[str, EdsEntry | None]:
    """What an entry is called, and the entry itself if there is one."""
    role = _ROLES.get(index, "exchange PDOs" if 0x1400 <= index < 0x1C00 else "answer at all")
    entry = sheet.entries.get((index, sub))
    name = f"0x{index:04X}:{sub}"
    return (f"{name} is not in it: needed to {role}" if entry is None else f"{name} ({entry.name})"), entry


def _wrong_to_read(sheet: Eds, index: int, sub: int, size: int) -> Iterator[str]:
    name, entry = _found(sheet, index, sub)
    if entry is None:
        yield name
    elif entry.access == "wo":
        yield f"{name} can only be written there, and is read"
    elif entry.size != size:
        yield f"{name} has {_bytes(entry)} there, and {size} are expected"


def _wrong_to_write(sheet: Eds, written: Entry, checks_limits: bool) -> Iterator[str]:
    name, entry = _found(sheet, written.object_index, written.sub)
    if entry is None:
        yield name
        return
    if entry.access in ("ro", "const"):
        yield f"{name} can only be read there, and is written"
    if entry.size != len(written.value):
        yield f"{name} has {_bytes(entry)} there, and {len(written.value)} are written"
        return
    value = int.from_bytes(written.value, "little", signed=entry.is_signed)
    if checks_limits and entry.low is not None and value < entry.low:
        yield f"{name} is at least {entry.low:,} there, and {value:,} is written"
    if checks_limits and entry.high is not None and value > entry.high:
        yield f"{name} is at most {entry.high:,} there, and {value:,} is written"


def _wrong_to_map(sheet: Eds, written: Entry) -> Iterator[str]:
    value = int.from_bytes(written.value, "little")
    index, sub, size = value >> 16, value >> 8 & 0xFF, (value & 0xFF) // 8
    is_received = written.object_index < 0x1800
    name, entry = _found(sheet, index, sub)
    if entry is None:
        yield name
        return
    if not entry.is_mappable:
        yield f"{name} cannot be in a PDO there, and is to be"
    if entry.size != size:
        yield f"{name} has {_bytes(entry)} there, and {size} are in a PDO"
    if entry.access in (("ro", "const", "rwr") if is_received else ("wo",)):
        yield f"{name} is {entry.access!r} there, and is {'written' if is_received else 'read'} by a PDO"


def _too_few_pdos(entries: list[Entry], sheet: Eds) -> Iterator[str]:
    for words, base, has in (("receives", 0x1400, sheet.rpdos), ("sends", 0x1800, sheet.tpdos)):
        needed = len({entry.object_index for entry in entries if base <= entry.object_index < base + 0x200})
        if has is not None and has < needed:
            yield f"it {words} {has} PDOs, and {needed} are needed"


def _bytes(entry: EdsEntry) -> str:
    return "no fixed length" if entry.size is None else f"{entry.size} byte{'s' if entry.size > 1 else ''}"
