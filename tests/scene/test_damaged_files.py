"""Files damaged at random: content or a reason, never anything else, and a count that was hit loses nothing."""

import random
from contextlib import suppress

import numpy as np
import pytest
from import_makers import content
from test_ply import LIST, MIXED, STRIPS, VERTEX, ply
from test_scan_texts import ptx, table
from test_scans import XYZ, las, pcd
from text_makers import read

from hognose.errors import InputError

#: Each format with what it holds: whether how much that is can be told from the file itself.
FILES = {
    "stl": (content("stl"), True),
    "stl ascii": (content("stl ascii"), True),
    "obj": (content("obj"), False),
    "ply": (content("ply"), True),
    "ply ascii": (content("ply ascii"), True),
    "ply mixed": (ply("binary_big_endian", VERTEX, ("face", LIST, MIXED)), True),
    "ply strips": (ply("binary_little_endian", VERTEX, ("tristrips", LIST, [(s,) for s in STRIPS])), True),
    "off": (content("off"), True),
    "pcd ascii": (pcd("ascii"), True),
    "pcd binary": (pcd("binary"), True),
    "pcd packed": (pcd("binary_compressed"), True),
    "csv": (table(",", "i,x,y,z", "ixyz").encode(), False),
    "csv comma": (table(";", "i;x;y;z", "ixyz").replace(".", ",").encode(), False),
    "pts": (b"3\n" + table(columns="xyzi").encode(), True),
    "ptx": (ptx([XYZ[:5]]).encode(), True),
}


def held(found):
    return sum(len(body.faces) for body in found.bodies), len(found.points)


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Some bytes changed, cut out, or there twice; half of the changes in the first 300 bytes, where the counts are."""
    made = bytearray(data)
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(min(len(made), 300) if rng.random() < 0.5 else len(made))
        way = rng.random()
        if way < 0.4:
            made[at] = rng.randrange(256)
        elif way < 0.8:
            made[at] = rng.choice(b"0123456789 \n,.-#ex")
        elif way < 0.9:
            del made[at : at + rng.randint(1, 30)]
        else:
            made[at:at] = made[at : at + rng.randint(1, 30)]
        made = made or bytearray(data)
    return bytes(made)


@pytest.mark.parametrize("kind", FILES)
def test_damaged_files_give_content_or_a_reason(kind):
    data, tells = FILES[kind]
    ending, rng = kind.split()[0], random.Random(kind)
    whole, taken = held(read(ending, data)), 0
    with np.errstate(all="ignore"):
        for _ in range(700):
            made = damaged(data, rng)
            try:
                found = read(ending, made, drop_invalid=rng.random() < 0.5)
            except InputError:
                continue
            taken += 1
            assert not tells or found.notes or held(found) == whole, made
    assert 0 < taken < 700


@pytest.mark.parametrize("kind", FILES)
def test_a_number_that_was_hit_loses_nothing(kind):
    """Every digit of the first 300 bytes changed to every other one: as much is read, it is said, or it is refused."""
    data, tells = FILES[kind]
    ending = kind.split()[0]
    whole = held(read(ending, data))
    for at in range(min(len(data), 300)):
        if not data[at : at + 1].isdigit():
            continue
        for digit in b"0123456789":
            try:
                found = read(ending, data[:at] + bytes([digit]) + data[at + 1 :])
            except InputError:
                continue
            assert not tells or found.notes or held(found) == whole, (at, digit)


@pytest.mark.parametrize("ending", ["las", "laz"])
def test_damaged_files_of_packages_give_content_or_a_reason(ending):
    data, rng = las(ending), random.Random(ending)
    for _ in range(4):
        with suppress(InputError):
            assert read(ending, damaged(data, rng)).points.shape == (40, 3)
