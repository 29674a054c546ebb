"""`python -m benchmarks.clearance`: how long it takes to check the clearance of a whole plan in large scenes.

The scenes are the obstacles of the bundled tasks, cut into many triangles and made bumpy, so that the mesh is as
irregular as a scanned one: no two triangles that meet lie in one plane. Coal measures the same in the same run.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks.by_coal import Obstacles
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times
from hognose.planning import Plan
from hognose.planning.motion import HORIZON
from hognose.scene import Scene
from hognose.scene.tree_cache import WORTH_KEEPING

Array = NDArray[np.float64]

THREADS = 2
#: Triangles of the scenes, and the longest time (ms) that the check of the obstacle array may take.
LIMITS = ((20_000, 16.0), (1_000_000, 100.0))
#: Coal measures at most so many queries of a plan; its time is scaled to all of them.
SAMPLE = {20_000: 10_000, 1_000_000: 300}
#: How high the bumps are (m), and how far apart.
BUMP, BUMP_PITCH = 1e-3, 0.04


@dataclass(frozen=True)
class Rough:
    """A finely cut, bumpy copy of a plan's obstacles, and how long (s) its scene takes to build."""

    scene: Scene
    first_build: float
    second_build: float


def main(share: float = 1.0, limits: Sequence[tuple[int, float]] = LIMITS) -> None:
    """Print all of it, from a share of the rounds."""
    for task in ("obstacle-array", "pipe-tank"):
        plan = hognose.plan(hognose.load_task(task))
        for count, limit in limits:
            rough = built(plan, count)
            queries = plan.clearance.size
            heading(f"clearance of the plan of {task}: {queries:,} links, {len(rough.scene.triangles):,} triangles")
            aside("building the scene, without a cache", 1e3 * rough.first_build, "ms")
            if len(rough.scene.triangles) >= WORTH_KEEPING:
                aside("building the scene, with its tree in the cache", 1e3 * rough.second_build, "ms")
            compare(plan, rough.scene, SAMPLE[count], limit, max(2, round(30 * share)))


def compare(plan: Plan, scene: Scene, sample: int, limit: float, rounds: int = 30) -> None:
    """Time and values of the check, by Hognose and by Coal."""
    starts, ends, radii = plan.body[:, :-1], plan.body[:, 1:], plan.robot.body_radii

    def check(threads: int) -> Array:
        return scene.clearance(starts, ends, radii, HORIZON, threads).value

    with ThreadPoolExecutor(THREADS) as pool:
        calls = {
            "threads": lambda: check(THREADS),
            "one thread": lambda: check(1),
            "at once": lambda: [*pool.map(check, [1] * THREADS)],
        }
        times = best_times(calls, rounds)
    one = times["one thread"]
    row(
        f"whole plan, {THREADS} threads, warm, distances up to {1e3 * HORIZON:g} mm",
        1e3 * times["threads"],
        limit,
        "ms",
    )
    aside("the same in one thread", 1e3 * one, "ms")
    # Near 1 if that many cores are free, and near their number if something else keeps all but one of them busy.
    aside(f"{THREADS} at once / one alone, each in one thread", times["at once"] / one, "x")

    value = check(THREADS)
    queries = np.arange(value.size)
    if value.size > sample:
        queries = np.sort(np.random.default_rng(0).choice(value.size, sample, replace=False))
    step, link = np.unravel_index(queries, value.shape)
    obstacles = Obstacles(scene.triangles)
    begin = time.perf_counter()
    found = [obstacles.distance(starts[t, i], ends[t, i], float(radii[i])) for t, i in zip(step, link, strict=True)]
    by_coal = (time.perf_counter() - begin) * value.size / len(queries)
    scaled = "" if len(queries) == value.size else f", scaled up from {len(queries)}"
    aside(f"the same by Coal in one thread{scaled}", 1e3 * by_coal, "ms")
    aside("Coal / Hognose, one thread each", by_coal / one, "x")
    ours = value[step, link]
    off = np.abs(
        np.minimum(found, HORIZON) - ours
    )  # from the horizon on ours is a bound, which Coal must not fall below
    near = int((ours < HORIZON).sum())
    row(
        f"largest difference from Coal ({near:,} links within reach, {len(ours) - near:,} beyond)",
        float(off.max()),
        1e-6,
        "m",
    )


def built(plan: Plan, count: int) -> Rough:
    """The rough copy of a plan's obstacles, built twice: without anything on disk, and again."""
    fine = finely_cut(plan.scene.triangles, count)
    mesh = [fine + bumps(fine)]
    with empty_cache():
        Scene.from_meshes(["warm"], [plan.scene.triangles])
        begin = time.perf_counter()
        scene = Scene.from_meshes(["rough"], mesh)
        between = time.perf_counter()
        Scene.from_meshes(["rough"], mesh)
        end = time.perf_counter()
    return Rough(scene, between - begin, end - between)


@contextmanager
def empty_cache() -> Iterator[None]:
    """For a while, the disk cache is a temporary folder, empty at first."""
    before = os.environ.get("HOGNOSE_CACHE")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HOGNOSE_CACHE"] = folder
        try:
            yield
        finally:
            del os.environ["HOGNOSE_CACHE"]
            if before is not None:
                os.environ["HOGNOSE_CACHE"] = before


def finely_cut(triangles: Array, count: int) -> Array:
    """Triangles (m, 3, 3) cut across their longest edges until there are at least `count`.

    Every edge longer than a length is cut in the middle, by both of its triangles: no gaps arise.
    """
    longest = float(_edges(triangles).max())
    while len(triangles) < count:
        longest *= min(0.98, (len(triangles) / count) ** 0.5)
        triangles = _cut_to(triangles, longest)
    return triangles


def _cut_to(triangles: Array, longest: float) -> Array:
    """Triangles none of whose edges is longer (m)."""
    done = []
    while len(triangles):
        edges = _edges(triangles)
        long = edges.max(axis=1) > longest
        done.append(triangles[~long])
        rows, first = np.flatnonzero(long), edges[long].argmax(axis=1)
        a, b, c = (triangles[rows, (first + k) % 3] for k in range(3))
        middle = 0.5 * (a + b)
        triangles = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)


def _edges(triangles: Array) -> Array:
    """Lengths (m, 3) of the edges from each corner to the next, as if space were stretched here and there.

    So meshes of many equal triangles are not all cut at once, and become finer in some places than in others. What
    seems longest must be two thirds of what is, or triangles of three corners in a row were cut for ever.
    """
    following = np.roll(triangles, -1, axis=1)
    stretch = 1.0 + 0.15 * np.sin((triangles + following) @ np.array([23.0, 29.0, 31.0]))
    return np.linalg.norm(following - triangles, axis=2) * stretch


def bumps(places: Array) -> Array:
    """A smooth displacement (..., 3) m at places (..., 3) m, about `BUMP` high, that varies over `BUMP_PITCH`."""
    random = np.random.default_rng(0)
    out = np.zeros_like(places)
    waves = 6
    for _ in range(waves):
        wave, shift = random.normal(scale=np.pi / BUMP_PITCH, size=3), random.uniform(0, 2 * np.pi, 3)
        out += np.sin((places @ wave)[..., None] + shift)
    return out * BUMP / np.sqrt(waves * 3 / 2)


if __name__ == "__main__":
    print(f"Hognose {hognose.__version__}, up to {THREADS} threads on {os.cpu_count()} cores")
    main()
