"""`python -m benchmarks.viewer`: how fast a way-point that is dragged gets its verdict, and what the page costs.

The whole plan is made with all checks. A way-point is dragged along a small circle, as a browser would do it, on as
many cores as there are.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks import docs_page, page
from benchmarks.clearance import bumps, empty_cache, finely_cut
from benchmarks.rows import as_markdown, aside, heading, row
from hognose.planning import Task
from hognose.scene import Mesh
from hognose.viewer.model.edits import move_way_point
from hognose.viewer.model.workbench import Workbench

Array = NDArray[np.float64]

EDITS = 200
RADIUS = 0.004
#: Triangles of the large scene.
TRIANGLES = 20_000
#: How often a person's hand (a mouse at rest, a mouse at its fastest) edits, 1/s.
SLOW, FAST = 20.0, 200.0


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.viewer", description="Speed of the viewer.")
    docs_page.add_option(parser)
    given = parser.parse_args()
    if given.docs is not None:
        docs_page.found_in(given.docs, "viewer")  # so that a wrong page is refused before anything is measured
    print(docs_page.measured_with())
    with empty_cache(), tempfile.TemporaryDirectory() as folder:
        for name, fewest in (("obstacle-array", 30.0), ("pipe-tank", 30.0)):
            measure(name, hognose.load_task(name), fewest)
        large = finely_meshed(hognose.load_task("obstacle-array"), FilePath(folder) / "large.off")
        measure("obstacle-array, bumpy", large, 15.0)
    page.main()
    if given.docs is not None:
        docs_page.write_block(given.docs, "viewer", f"{docs_page.measured_with()}\n\n{as_markdown()}")


def measure(name: str, task: Task, fewest: float) -> None:
    """Print what a drag of the middle way-point is like; `fewest` plans a second are wanted."""
    heading(f"{name}: {len(task.scene.triangles):,} triangles, {EDITS} edits of a way-point")
    with opened(task) as bench:
        begin = time.perf_counter()
        times = np.array([drag_on(bench, place) for place in circle(task)])
        row(
            "edits, each as soon as the last has its verdict",
            EDITS / (time.perf_counter() - begin),
            fewest,
            "plans/s",
            at_least=True,
        )
        aside("of this, planning", 1e3 * float(np.median(times[:, 1])), "ms")
        rest = float(np.median(times[:, 0] - times[:, 1]))
        aside("of this, verification and hand-over", 1e3 * rest, "ms")
    with opened(task) as bench:
        latencies = [seconds for seconds, _ in paced(bench, circle(task))]
        row(f"input to verdict at {SLOW:g} edits/s, median", 1e3 * float(np.median(latencies)), 50, "ms")
        aside("the same, 95th percentile", 1e3 * float(np.percentile(latencies, 95)), "ms")
    with opened(task) as bench:
        flood(bench, circle(task))


def flood(bench: Workbench, places: Array) -> None:
    """Edits that come faster than they can be planned must not queue up."""
    before, begin = bench.verdicts, time.perf_counter()
    for k, place in enumerate(places):
        time.sleep(max(0.0, begin + k / FAST - time.perf_counter()))
        bench.edit(move_way_point(1, place), "drag")
    last = time.perf_counter()
    verdict = bench.settle(60.0)
    row(f"plans made for {EDITS} edits at {FAST:g}/s", bench.verdicts - before, EDITS - 1, "")
    assert verdict.plan is not None
    off = float(np.abs(verdict.plan.task.way_points[1] - places[-1]).max())
    row("difference between the last edit and the last verdict", off, 0.0, "m")
    aside("from the last edit to its verdict", 1e3 * (time.perf_counter() - last), "ms")


def drag_on(bench: Workbench, place: Array) -> tuple[float, float]:
    """Seconds from an edit to its verdict, and those of planning in them."""
    begin = time.perf_counter()
    bench.edit(move_way_point(1, place), "drag")
    verdict = bench.settle(60.0)
    assert verdict.number == bench.number
    assert verdict.good, verdict
    return time.perf_counter() - begin, verdict.seconds


def paced(bench: Workbench, places: Array) -> Iterator[tuple[float, float]]:
    """Drag on at a person's pace."""
    begin = time.perf_counter()
    for k, place in enumerate(places):
        time.sleep(max(0.0, begin + k / SLOW - time.perf_counter()))
        yield drag_on(bench, place)


def circle(task: Task) -> Array:
    """Places (EDITS, 3) m on a circle through the second way-point, nearer to the z axis, where the way is shorter."""
    start = task.way_points[1]
    out = start * (1, 1, 0) / np.linalg.norm(start[:2])
    turn = (2 * np.pi * np.arange(1, EDITS + 1) / 40)[:, None]
    return start + RADIUS * ((np.cos(turn) - 1) * out + np.sin(turn) * np.cross(out, (0, 0, 1)))


@contextmanager
def opened(task: Task) -> Iterator[Workbench]:
    """A workbench whose first verdict is there."""
    with Workbench(task) as bench:
        bench.settle(600.0)
        yield bench


def finely_meshed(task: Task, file: FilePath) -> Task:
    """The same task with its obstacles as one bumpy mesh of many triangles, from a file."""
    fine = finely_cut(task.scene.triangles, TRIANGLES)
    corners = np.round(fine + bumps(fine), 9).reshape(-1, 3)
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    lines = [f"OFF\n{len(vertices)} {len(fine)} 0"]
    lines += [" ".join(map(repr, vertex)) for vertex in vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in index.reshape(-1, 3).tolist()]
    file.write_text("\n".join(lines))
    obstacles = (Mesh(file=str(file), units="m"),)
    return Task(task.spec.model_copy(update={"obstacle": obstacles}), task.robot)


if __name__ == "__main__":
    main()
