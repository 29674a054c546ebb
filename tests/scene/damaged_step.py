"""Damaged STEP files by the hundred: `python tests/scene/damaged_step.py 300` tries as many as it can in 300 s.

It tells how many were read, how many refused, and with which message; and ends with 1 if something else happened, or if
a part of a body was missing without a word.
"""

import random
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from hognose.errors import HognoseError
from hognose.scene import Mesh, Scene


def damaged(whole: bytes, rng: random.Random) -> bytes:
    """Bytes flipped, numbers or keywords made others, or a piece cut out; its beginning and end are there."""
    data = bytearray(whole)
    begin = data.index(b"DATA;")
    way = rng.choice(["flip", "number", "cut", "keyword"])
    for _ in range(rng.randint(1, 8)):
        at = rng.randrange(begin, len(data) - 30)
        if way == "flip":
            data[at] ^= 1 << rng.randrange(8)
        elif way == "cut":
            del data[at : min(at + rng.randint(1, 60), len(data) - 25)]
        else:
            spots = list(re.finditer(rb"\d+" if way == "number" else rb"[A-Z]{4,}", bytes(data[begin:-25])))
            spot = rng.choice(spots)
            other = str(rng.choice([0, 1, 7, 12, 10**9, -5])).encode() if way == "number" else rng.choice(spots)[0]
            data[begin + spot.start() : begin + spot.end()] = other
    return bytes(data)


def outcome(file: Path) -> str | Mesh:
    """A mesh that can be planned with, or the message that refuses it."""
    try:
        item = Mesh(file=str(file))
        scene = Scene.from_obstacles([item])
    except HognoseError as error:
        said = str(error)
        return said if str(file) in said else f"file not named: {said}"
    return item if len(scene.triangles) and np.isfinite(scene.triangles).all() else "unusable triangles"


def main(seconds: float, files: list[Path]) -> int:
    """Try damaged copies of some files for a time."""
    kinds: Counter[str] = Counter()
    wrong = 0
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "damaged.step"
        bodies = {}
        for seed in range(10**9):
            if time.monotonic() > end:
                break
            source = files[seed % len(files)]
            if source not in bodies:
                bodies[source] = len(Mesh(file=str(source)).geometry.bodies)
            file.write_bytes(damaged(source.read_bytes(), random.Random(seed)))
            found = outcome(file)
            if isinstance(found, Mesh):
                lost = len(found.geometry.bodies) < bodies[source] and not found.remarks()
                kinds["READ, BUT A BODY IS MISSING WITHOUT A WORD" if lost else "read"] += 1
                wrong += lost
                if lost:
                    print(f"seed {seed} of {source.name}", flush=True)
            else:
                # Two messages of a kind differ in their numbers and names only.
                kind = re.sub(r"'[^']*'|[-+.\d,]+", "…", found.removeprefix(f"{file}: "))[:70]
                kinds[kind] += 1
                wrong += found.startswith(("file not named", "unusable"))
            if found and kinds.total() % 50 == 0:
                print(f"{kinds.total()} files, {wrong} wrong", flush=True)
    for kind, times in kinds.most_common():
        print(f"{times:6d}  {kind}")
    print(f"{kinds.total()} files, {wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    given = [Path(name) for name in sys.argv[2:]]
    sys.exit(main(float(sys.argv[1]), given or [Path(__file__).parents[2] / "examples" / "step_tank.step"]))
