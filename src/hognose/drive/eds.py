"""Electronic data sheets of drives (CiA 306: EDS, and DCF, which says the values of one device as well)."""

from __future__ import annotations

import configparser
import re
from dataclasses import dataclass
from pathlib import Path

from hognose.errors import InputError
from hognose.read_whole import read_whole

#: No data sheet is larger (bytes).
_LARGEST = 8_000_000
#: Bytes of a value by its data type (CiA 301, table 44), and whether it may be below zero.
_SIZES = {
    0x01: 1, 0x02: 1, 0x03: 2, 0x04: 4, 0x05: 1, 0x06: 2, 0x07: 4, 0x08: 4, 0x10: 3, 0x11: 8, 0x12: 5, 0x13: 6,
    0x14: 7, 0x15: 8, 0x16: 3, 0x18: 5, 0x19: 6, 0x1A: 7, 0x1B: 8,
}  # fmt: skip
_SIGNED = (0x02, 0x03, 0x04, 0x10, 0x12, 0x13, 0x14, 0x15)
_ACCESS = ("ro", "wo", "rw", "rwr", "rww", "const")
#: Kinds of objects that have sub-indices.
_ARRAY, _RECORD = 0x8, 0x9
_INDEX = re.compile(r"([0-9a-f]{4})(?:sub([0-9a-f]{1,2}))?", re.IGNORECASE)


@dataclass(frozen=True)
class EdsEntry:
    """An entry of an object dictionary as its data sheet says it.

    Attributes
    ----------
    name
    size
        In bytes; None where it is text or has no fixed length.
    is_signed
    access
        `ro`, `wo`, `rw`, `rwr` (may be read in PDOs), `rww` (may be written in PDOs) or `const`.
    is_mappable
        Whether it can be in a PDO.
    low, high
        What may be written, where it is said.
    """

    name: str
    size: int | None
    is_signed: bool
    access: str
    is_mappable: bool
    low: int | None = None
    high: int | None = None


@dataclass(frozen=True)
class Eds:
    """A data sheet.

    Attributes
    ----------
    source
        Its file.
    product_name
    vendor, product
        Numbers, as a device says them in 0x1018; None where the file does not say them.
    rpdos, tpdos
        How many PDOs it receives and sends; None where the file does not say it.
    entries
        By index and sub-index.
    """

    source: str
    product_name: str
    vendor: int | None
    product: int | None
    rpdos: int | None
    tpdos: int | None
    entries: dict[tuple[int, int], EdsEntry]


def load_eds(path: Path) -> Eds:
    """A data sheet from its file (.eds or .dcf).

    Raises
    ------
    InputError
        There is no such file, or it is damaged, or no data sheet: says where and what was expected.
    """
    text = read_whole(path, _LARGEST).decode("utf-8", "replace")
    parser = configparser.RawConfigParser(
        strict=True, interpolation=None, comment_prefixes=(";",), inline_comment_prefixes=None, delimiters=("=",)
    )
    try:
        parser.read_string(text, str(path))
    except configparser.DuplicateSectionError as error:
        raise InputError(f"{path}: line {error.lineno}: [{error.section}] is there twice; is the file whole?") from None
    except configparser.DuplicateOptionError as error:
        raise InputError(
            f"{path}: line {error.lineno}: {error.option!r} is there twice in [{error.section}]; is the file whole?"
        ) from None
    except configparser.MissingSectionHeaderError as error:
        raise _no_sheet(path, f"line {error.lineno} is before any section") from None
    except configparser.ParsingError as error:
        line, content = error.errors[0]
        raise InputError(
            f"{path}: line {line}: expected `Key=Value` or `[Section]`, got {content}; is the file whole?"
        ) from None
    sections = {name.lower(): dict(parser[name]) for name in parser.sections()}
    if "deviceinfo" not in sections:
        raise _no_sheet(path, "there is no section [DeviceInfo]")
    entries = _entries(path, sections)
    if not entries:
        raise _no_sheet(path, "it describes no objects")
    _refuse_cut(path, sections)
    device = sections["deviceinfo"]
    vendor, product, rpdos, tpdos = (
        _number(path, "DeviceInfo", key, device.get(key.lower()))
        for key in ("VendorNumber", "ProductNumber", "NrOfRXPDO", "NrOfTXPDO")
    )
    return Eds(str(path), device.get("productname", "").strip(), vendor, product, rpdos, tpdos, entries)


def _no_sheet(path: Path, why: str) -> InputError:
    return InputError(f"{path}: is no electronic data sheet (EDS or DCF, CiA 306): {why}")


def _refuse_cut(path: Path, sections: dict[str, dict[str, str]]) -> None:
    """Raise an InputError if an object that the lists of the file name is not described, as where it was cut off."""
    for listing in ("mandatoryobjects", "optionalobjects", "manufacturerobjects"):
        for key, value in sections.get(listing, {}).items():
            index = _number(path, listing, key, value)
            if key.isdecimal() and index is not None and f"{index:04x}" not in sections:
                raise InputError(
                    f"{path}: 0x{index:04X} is listed, but not described by a section [{index:04X}]; is the file whole?"
                )


def _entries(path: Path, sections: dict[str, dict[str, str]]) -> dict[tuple[int, int], EdsEntry]:
    found: dict[tuple[int, int], EdsEntry] = {}
    for name, section in sections.items():
        match = _INDEX.fullmatch(name)
        if match is None:
            continue
        index, sub = int(match[1], 16), int(match[2] or "0", 16)
        kind = _number(path, name, "ObjectType", section.get("objecttype"))
        if match[2] is None and kind in (_ARRAY, _RECORD):
            if compact := _number(path, name, "CompactSubObj", section.get("compactsubobj")):
                entry = _entry(path, name, section)
                found |= {(index, k): entry for k in range(1, compact + 1)}
                found[index, 0] = EdsEntry("number of entries", 1, False, "ro", False)
            continue
        found[index, sub] = _entry(path, name, section)
    return found


def _entry(path: Path, name: str, section: dict[str, str]) -> EdsEntry:
    data_type = _number(path, name, "DataType", section.get("datatype"))
    if data_type is None:
        raise InputError(f"{path}: [{name}]: `DataType` is missing; is the file whole?")
    access = section.get("accesstype", "").strip().lower()
    if access not in _ACCESS:
        got = f"got {access!r}" if access else "it is missing"
        raise InputError(f"{path}: [{name}]: AccessType: expected one of {', '.join(_ACCESS)}; {got}")
    size = _SIZES.get(data_type)
    is_signed = data_type in _SIGNED
    low, high = (
        _limit(path, name, key, section.get(key.lower()), 8 * (size or 8) if is_signed else 0)
        for key in ("LowLimit", "HighLimit")
    )
    mapping = _number(path, name, "PDOMapping", section.get("pdomapping")) or 0
    return EdsEntry(section.get("parametername", "").strip(), size, is_signed, access, bool(mapping), low, high)


def _limit(path: Path, section: str, key: str, value: str | None, signed_bits: int) -> int | None:
    """A limit; those of signed types may be written as their bits."""
    if value is None or "$NODEID" in value.upper():
        return None
    number = _number(path, section, key, value)
    if number is not None and signed_bits and number >= 1 << (signed_bits - 1):
        number -= 1 << signed_bits
    return number


def _number(path: Path, section: str, key: str, value: str | None) -> int | None:
    """A whole number: decimal, 0x for hexadecimal, a leading 0 for octal (CiA 306); None where there is none."""
    text = (value or "").strip()
    if not text:
        return None
    try:
        octal = len(text) > 1 and text[0] == "0" and text.isdecimal()
        return int(text, 8) if octal else int(text, 0)
    except ValueError:
        raise InputError(f"{path}: [{section}]: {key}: expected a whole number, got {text!r}") from None
