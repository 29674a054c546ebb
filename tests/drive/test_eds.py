"""Data sheets: damaged ones, other ones, and drives that lack what a run needs are said before anything is sent."""

from dataclasses import replace

import pytest
from drive_makers import Rig, boards, network_of

from hognose.drive.bring_up import bring_up
from hognose.drive.eds import load_eds
from hognose.drive.eds_check import refuse_by_data_sheets
from hognose.drive.emulator.objects import PRODUCTS, objects_of
from hognose.drive.local_bus import LocalBus
from hognose.drive.network import load_network
from hognose.errors import InputError

TYPES = {(1, False): 5, (1, True): 2, (2, False): 6, (2, True): 3, (4, False): 7, (4, True): 4, (8, False): 0x1B}


def sheet_of(kind, **changed):
    """The data sheet of an emulated drive; entries as `x6065_0` are changed, or left out where None."""
    lines = [
        "[DeviceInfo]", "VendorName=emulated", "VendorNumber=0x000000FB", f"ProductName={kind} (emulated)",
        f"ProductNumber=0x{PRODUCTS[kind]:08X}", "NrOfRXPDO=4", "NrOfTXPDO=4", "[OptionalObjects]",
    ]  # fmt: skip
    objects = objects_of(kind, 5, 1005, 2000)
    indices = sorted({index for index, _ in objects})
    lines += [f"SupportedObjects={len(indices)}", *(f"{k}=0x{index:04X}" for k, index in enumerate(indices, 1))]
    for index in indices:
        subs = sorted(sub for each, sub in objects if each == index)
        if subs != [0]:
            lines += [f"[{index:04X}]", f"SubNumber={len(subs)}", "ObjectType=0x9"]
        for sub in subs:
            entry = objects[index, sub]
            name = f"{index:04X}" if subs == [0] else f"{index:04X}sub{sub:X}"
            values = {
                "ParameterName": entry.name,
                "ObjectType": "0x7",
                "DataType": hex(TYPES.get((entry.size, entry.signed), 9)),
                "AccessType": entry.access,
                "PDOMapping": str(int(entry.mapped)),
                "LowLimit": "" if entry.low is None else str(entry.low),
                "HighLimit": "" if entry.high is None else hex(entry.high),
            }
            change = changed.get(f"x{index:04X}_{sub}", {})
            if change is not None:
                lines += [f"[{name}]", *(f"{key}={value}" for key, value in (values | change).items())]
    return "\r\n".join(lines) + "\r\n"


def read(tmp_path, text):
    file = tmp_path / "drive.eds"
    file.write_text(text)
    return load_eds(file)


def with_sheet(sheet, kind="epos2"):
    return replace(network_of(boards(), kind, slider=kind), sheets=(sheet, sheet))


@pytest.mark.parametrize("kind", ["epos2", "cia402"])
def test_emulated_drives_have_what_a_run_and_homing_need(tmp_path, kind):
    sheet = read(tmp_path, sheet_of(kind))
    assert (sheet.vendor, sheet.product, sheet.rpdos, sheet.tpdos) == (0xFB, PRODUCTS[kind], 4, 4)
    for key, entry in objects_of(kind, 5, 1005, 2000).items():
        if entry.size:
            found = sheet.entries[key]
            assert (found.size, found.is_signed, found.access) == (entry.size, entry.signed, entry.access)
            assert (found.is_mappable, found.low, found.high) == (entry.mapped, entry.low, entry.high)
    refuse_by_data_sheets(with_sheet(sheet, kind), 0.03)
    rig = Rig(boards(), with_sheet(sheet, kind))
    assert len(bring_up(LocalBus(rig.emulator, rig.clock), rig.clock, rig.network, 0.03)) == 37


def test_all_that_drives_lack_is_listed_and_nothing_is_sent(tmp_path):
    text = sheet_of(
        "epos2",
        x6065_0={"DataType": "0x6"},
        x6007_0={"AccessType": "ro"},
        x20C4_2={"HighLimit": "4"},
        x6085_0={"PDOMapping": "0"},
        x20C1_0=None,
        x20F4_0={"AccessType": "wo"},
    ).replace("NrOfTXPDO=4", "NrOfTXPDO=1")
    text = text.replace(f"{sorted({i for i, _ in objects_of('epos2', 5, 5, 2000)}).index(0x20C1) + 1}=0x20C1\r\n", "")
    rig = Rig(boards(), with_sheet(read(tmp_path, text)))
    sent = []
    rig.emulator.receive = lambda frames, now, bus=0: sent.extend(frames)
    with pytest.raises(InputError) as caught:
        rig.executor.arm()
    words = str(caught.value)
    for said in (
        'drive.eds describes epos2 (emulated), which cannot be run as kind = "epos2"; is it the right file?',
        "it sends 1 PDOs, and 2 are needed",
        "0x6065:0 (following error window) has 2 bytes there, and 4 are written",
        "0x6007:0 (abort connection option code) can only be read there, and is written",
        "0x20C4:2 (interpolation buffer underflow warning) is at most 4 there, and 5 is written",
        "0x6085:0 (quick stop deceleration) cannot be in a PDO there, and is to be",
        '0x20C1:0 is not in it: needed to take records of position, velocity and time, as kind = "epos2" does',
        "0x20F4:0 (following error actual value) is 'wo' there, and is read by a PDO",
    ):
        assert said in words
    assert len(words.splitlines()) == 8
    assert sent == []


def test_the_data_sheet_of_the_other_kind_is_refused(tmp_path):
    with pytest.raises(InputError, match="0x20C1:0 is not in it: needed to take records"):
        refuse_by_data_sheets(with_sheet(read(tmp_path, sheet_of("cia402")), "epos2"), 0.03)
    with pytest.raises(InputError, match="0x605A:0 is not in it: needed to hold the position after a stop"):
        refuse_by_data_sheets(with_sheet(read(tmp_path, sheet_of("epos2")), "cia402"), 0.03)


def test_another_device_than_that_of_the_data_sheet_is_named(tmp_path):
    text = sheet_of("epos2").replace("ProductNumber=0x64200000", "ProductNumber=0x63200000")
    rig = Rig(boards(), with_sheet(read(tmp_path, text)))
    with pytest.raises(InputError) as caught:
        rig.executor.arm()
    assert "37 drives (nodes 1 to 37): is 'EPOS2 (emulated)', product 0x64200000, but " in str(caught.value)
    assert "describes 'epos2 (emulated)', product 0x63200000" in str(caught.value)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (
            lambda text: text[: text.index("[6065]")],
            r"is listed, but not described by a section \[\w+\]; is the file whole",
        ),
        (lambda text: "", r"is no electronic data sheet .*there is no section \[DeviceInfo\]"),
        (lambda text: "\x7fELF\0\0", "is no electronic data sheet .*line 1 is before any section"),
        (lambda text: text.replace("AccessType=wo", "AccessType=xx", 1), "AccessType: expected one of ro, wo"),
        (lambda text: text.replace("0x000000FB", "maxon"), r"VendorNumber: expected a whole number, got 'maxon'"),
        (lambda text: text + "[6040]\r\n", r"\[6040\] is there twice; is the file whole"),
        (lambda text: text.replace("DataType=0x7", "DataTyp=0x7", 1), "`DataType` is missing"),
        (lambda text: text + "garbage\r\n", "expected `Key=Value` or `.Section.`, got 'garbage"),
    ],
)
def test_damaged_data_sheets_are_refused(tmp_path, spoil, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, spoil(sheet_of("epos2")))


def test_compact_objects_limits_as_bits_and_octal_numbers_are_read(tmp_path):
    text = sheet_of("epos2") + (
        "[3333]\nParameterName=list\nObjectType=8\nCompactSubObj=010\nDataType=0x0003\nAccessType=rw\n"
        "LowLimit=0x8000\nHighLimit=0x7FFF\nPDOMapping=0\n"
    )
    entries = read(tmp_path, text).entries
    assert (entries[0x3333, 8].low, entries[0x3333, 8].high, entries[0x3333, 0].size) == (-32768, 32767, 1)
    assert (0x3333, 9) not in entries


def test_network_files_name_data_sheets_beside_them(tmp_path):
    file = tmp_path / "bench.toml"
    file.write_text(
        'schema = 1\nunits = "mm"\nname = "bench"\nrobot = "sjtu-25dof"\n[bus]\ninterface = "virtual"\n'
        f'[drives]\nnodes = {list(range(1, 37))}\nnewton_per_unit = 0.1\neds = "drive.eds"\n'
        '[slider]\nkind = "cia402"\nnode = 40\ncounts_per_metre = 1e6\n'
    )
    with pytest.raises(InputError, match=r"bench\.toml: drives\.eds: .*drive\.eds: no such file"):
        load_network(file)
    (tmp_path / "drive.eds").write_text(sheet_of("epos2"))
    network = load_network(file)
    assert network.sheet(35) is not None
    assert network.sheet(36) is None
