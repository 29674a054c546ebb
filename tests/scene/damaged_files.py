"""Damaged files of every format that is read: `make damaged` tries 10,000 of them and prints what became of them.

A damaged file is read with all that the whole one holds, read with a note, or refused with a reason; where its damage
can make it another whole file (a number less in a list without a count), with other content. Everything else is wrong:
another error, triangles that cannot be used, and content that is missing without a word.
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import re
import sys
import tempfile
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dae_maker
import gltf_boxes
import numpy as np
import threemf_maker
from gltf_maker import Gltf, glb_of
from import_makers import EXAMPLES, content
from step_makers import block, step
from test_ply import LIST, MIXED, STRIPS, VERTEX, ply
from test_scan_texts import ptx, table
from test_scans import XYZ, columns, e57, las, pcd

from hognose.errors import InputError
from hognose.scene.imports.content import Content, ScanOptions, Source
from hognose.scene.imports.formats import BY_SUFFIX

#: How far the triangles of a curved surface may lie off it, m.
TOLERANCE = 5e-5

Damage = Callable[[random.Random], bytes]


@dataclass(frozen=True)
class Kind:
    """A format in one of its layouts.

    Attributes
    ----------
    ending
        Of such a file, without the dot.
    whole
        An undamaged file.
    damage
        Makes a damaged one.
    tells
        Whether such a file says itself how much it holds, so that less of it is a loss.
    slow
        Whether it is read in a process of its own.
    """

    ending: str
    whole: bytes
    damage: Damage
    tells: bool = True
    slow: bool = False


def _bytes_of(data: bytes, rng: random.Random) -> bytes:
    """Some bytes changed, cut out, or there twice; half of the changes in the first 300 bytes, where the counts are."""
    made = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 3))):
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


def plain(ending: str, data: bytes | str, tells: bool = True, slow: bool = False) -> Kind:
    """A format whose bytes are damaged as they are."""
    whole = data if isinstance(data, bytes) else data.encode()
    return Kind(ending, whole, lambda rng: _bytes_of(whole, rng), tells, slow)


JUNK = (None, -1, 0, 1, 2, 7, 5121, 5126, 10**9, 10**400, "", "x", [], {}, [[]], {"a": 1}, True, 0.5, [0], "POSITION")


def _spoiled(tree: Any, rng: random.Random) -> Any:
    """A copy of some JSON with one value at random replaced or dropped."""
    tree = copy.deepcopy(tree)
    holder = tree
    while True:
        keys = list(holder) if isinstance(holder, dict) else range(len(holder))
        if not keys:
            return tree
        key = rng.choice(keys)
        if not isinstance(holder[key], dict | list) or not holder[key] or rng.random() < 0.15:
            break
        holder = holder[key]
    if rng.random() < 0.05:
        del holder[key]
    else:
        holder[key] = rng.choice(JUNK)
    return tree


def glb(make: Callable[[Gltf], Any]) -> Kind:
    """A GLB of one of the boxes; its bytes or the values of its JSON are damaged."""
    made = Gltf()
    make(made)
    whole = made.glb()
    tree = {**made.tree, "buffers": [{"byteLength": len(made.blob)}]}

    def damage(rng: random.Random) -> bytes:
        if rng.random() < 0.5:
            return _bytes_of(whole, rng)
        return glb_of(json.dumps(_spoiled(tree, rng)).encode(), made.blob)

    return Kind("glb", whole, damage, tells=False)


def threemf(root: str, inner: str) -> Kind:
    """A 3MF of two parts; the archive or one of its parts is damaged."""
    parts = {"_rels/.rels": threemf_maker.relations("/r.model"), "r.model": root, "a.model": inner}
    whole = threemf_maker.archive(parts)

    def damage(rng: random.Random) -> bytes:
        if rng.random() < 0.3:
            return _bytes_of(whole, rng)
        name = rng.choice(list(parts))
        return threemf_maker.archive({**parts, name: _bytes_of(parts[name].encode(), rng)}, zipfile.ZIP_STORED)

    return Kind("3mf", whole, damage, tells=False)


def stepped(data: bytes) -> Kind:
    """A STEP file: entities, which begin after its head, have bits, numbers, keywords or pieces changed."""
    begin = data.index(b"DATA;")

    def damage(rng: random.Random) -> bytes:
        made = bytearray(data)
        way = rng.choice(["flip", "number", "cut", "keyword"])
        for _ in range(rng.randint(1, 8)):
            at = rng.randrange(begin, len(made) - 30)
            if way == "flip":
                made[at] ^= 1 << rng.randrange(8)
            elif way == "cut":
                del made[at : min(at + rng.randint(1, 60), len(made) - 25)]
            else:
                _another_token(made, rng, begin, way)
        return bytes(made)

    return Kind("step", data, damage, slow=True)


def _another_token(made: bytearray, rng: random.Random, begin: int, way: str) -> None:
    pattern = rb"\d+" if way == "number" else rb"[A-Z]{4,}"
    spots = list(re.finditer(pattern, bytes(made[begin:-25])))
    spot = rng.choice(spots)
    other = str(rng.choice([0, 1, 7, 12, 10**9, -5])).encode() if way == "number" else rng.choice(spots)[0]
    made[begin + spot.start() : begin + spot.end()] = other


def _e57() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return e57(Path(folder), [(columns(XYZ), np.array([1.0, 0, 0, 0]), np.zeros(3))])


def kinds() -> dict[str, Kind]:
    """Every kind of file, by name."""
    outer = threemf_maker.model(
        threemf_maker.solid(),
        threemf_maker.group(2, 'objectid="1"', 'objectid="7" p:path="/a.model"'),
        items=['objectid="2"'],
    )
    inner = threemf_maker.model(threemf_maker.solid(7, name="inner"), items=())
    boxes = (
        gltf_boxes.six_materials_with_corners_of_their_own,
        gltf_boxes.sparse_over_a_base,
        gltf_boxes.one_instance,
        gltf_boxes.three_nodes_deep,
        gltf_boxes.strips,
        gltf_boxes.morphed_by_weights_of_the_mesh,
        gltf_boxes.another_scene,
        gltf_boxes.rows_with_gaps_and_a_shift,
    )
    nested = dae_maker.collada(
        dae_maker.node(dae_maker.node(moves="<translate>0 0 1</translate>"), 'id="up"', "<scale>2 2 2</scale>")
    )
    return {
        "stl": plain("stl", content("stl")),
        "stl ascii": plain("stl", content("stl ascii")),
        "obj": plain("obj", content("obj"), tells=False),
        "ply": plain("ply", content("ply")),
        "ply ascii": plain("ply", content("ply ascii")),
        "ply mixed": plain("ply", ply("binary_big_endian", VERTEX, ("face", LIST, MIXED))),
        "ply strips": plain("ply", ply("binary_little_endian", VERTEX, ("tristrips", LIST, [(s,) for s in STRIPS]))),
        "off": plain("off", content("off")),
        **{f"glb {make.__name__.replace('_', ' ')}": glb(make) for make in boxes},
        "3mf": threemf(outer, inner),
        "dae": plain("dae", dae_maker.collada(), tells=False),
        "dae nodes": plain("dae", nested, tells=False),
        "pcd ascii": plain("pcd", pcd("ascii")),
        "pcd binary": plain("pcd", pcd("binary")),
        "pcd packed": plain("pcd", pcd("binary_compressed")),
        "csv": plain("csv", table(",", "i,x,y,z", "ixyz"), tells=False),
        "csv comma": plain("csv", table(";", "i;x;y;z", "ixyz").replace(".", ","), tells=False),
        "pts": plain("pts", "3\n" + table(columns="xyzi")),
        "ptx": plain("ptx", ptx([XYZ[:5]])),
        "las": plain("las", las("las"), slow=True),
        "laz": plain("laz", las("laz"), slow=True),
        "e57": plain("e57", _e57(), slow=True),
        "step": stepped(step(block()).encode()),
        "step tank": stepped((EXAMPLES / "step_tank.step").read_bytes()),
    }


AS_BEFORE, NOTED, OTHER, REFUSED, LESS, WRONG = OUTCOMES = (
    "as before",
    "with a note",
    "other content",
    "refused",
    "LESS WITHOUT A WORD",
    "ANOTHER ERROR",
)


def taken(kind: Kind, data: bytes, drop_invalid: bool = False) -> Content:
    """What a file holds."""
    source = Source(Path(f"file.{kind.ending}"), data, TOLERANCE, ScanOptions(drop_invalid=drop_invalid))
    return BY_SUFFIX[f".{kind.ending}"].read(source)


def held(kind: Kind, found: Content) -> tuple[int, ...]:
    """Bodies, triangles and points of a file; a damaged curve has other triangles, so those of STEP do not count."""
    triangles = 0 if kind.ending == "step" else sum(len(body.faces) for body in found.bodies)
    return len(found.bodies), triangles, len(found.points)


def usable(found: Content) -> bool:
    """Whether every triangle is one of vertices that are there."""
    return all(body.faces.min() >= 0 and body.faces.max() < len(body.vertices) for body in found.bodies)


def outcome(kind: Kind, whole: tuple[int, ...], data: bytes, drop_invalid: bool) -> str:
    """What becomes of one damaged file."""
    try:
        with np.errstate(all="ignore"):
            found = taken(kind, data, drop_invalid)
    except InputError:
        return REFUSED
    except Exception as error:
        return f"{WRONG}: {error!r}"
    if not usable(found):
        return f"{WRONG}: triangles without corners"
    now = held(kind, found)
    if now == whole:
        return AS_BEFORE
    if found.notes:
        return NOTED
    lost = any(there < before for there, before in zip(now, whole, strict=True))
    return LESS if kind.tells and lost else OTHER


def tried(kind: Kind, number: int, seed: str) -> Counter[str]:
    """What becomes of a number of files of a kind; what is wrong is printed with its seed."""
    whole = held(kind, taken(kind, kind.whole))
    counted: Counter[str] = Counter()
    for turn in range(number):
        rng = random.Random(f"{seed} {turn}")
        became = outcome(kind, whole, kind.damage(rng), rng.random() < 0.5)
        if became.startswith((LESS, WRONG)):
            print(f"{seed} {turn}: {became}", flush=True)
        counted[became.partition(":")[0]] += 1
    return counted


def main() -> int:
    """Try as many as were asked for, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=10_000, help="how many damaged files")
    parser.add_argument("--seed", default="1", help="any word; the same word makes the same files")
    chosen = parser.parse_args()
    table_of = kinds()
    slow = [name for name, kind in table_of.items() if kind.slow]
    each_slow = min(60, chosen.files // len(table_of))
    each = -(-(chosen.files - each_slow * len(slow)) // (len(table_of) - len(slow)))
    widest = max(map(len, table_of))
    total: Counter[str] = Counter()
    print(f"{'':{widest}}  {'files':>6}  " + "  ".join(OUTCOMES))
    for name, kind in table_of.items():
        counted = tried(kind, each_slow if kind.slow else each, f"{chosen.seed} {name}")
        total += counted
        print(_row(name, widest, counted), flush=True)
    print(_row("all", widest, total))
    return int(total[LESS] + total[WRONG] > 0)


def _row(name: str, widest: int, counted: Counter[str]) -> str:
    cells = "  ".join(f"{counted[each]:{len(each)}d}" for each in OUTCOMES)
    return f"{name:{widest}}  {counted.total():6d}  {cells}"


if __name__ == "__main__":
    sys.exit(main())
