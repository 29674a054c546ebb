"""`python -m benchmarks`: what the planning core must reach, measured in one run, compiled warm.

Clearance in large scenes, whole plans and the command use all cores, the rest one. `--docs docs/speed.md` writes
the figures into the documentation as well; `--quick` tries the command out.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks import clearance, docs_page
from benchmarks.rows import as_markdown, aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.following.iterative import Iterative
from hognose.planning.planner import insertion

Array = NDArray[np.float64]
CASES = ("obstacle-array", "pipe-tank")
#: The longest a whole plan of a case of the paper may take (ms).
WHOLE_PLAN = 30
#: Share of the rounds that a quick run takes.
QUICK = 0.05


def main() -> None:
    """Measure, and write the page if it is asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description="Speed and accuracy of the planning core."
    )
    parser.add_argument("--quick", action="store_true", help="few rounds and small scenes, to try the command out")
    docs_page.add_option(parser)
    given = parser.parse_args()
    if given.docs is not None:
        docs_page.found_in(given.docs, "core")  # so that a wrong page is refused before anything is measured
    print(docs_page.measured_with(given.quick))
    share = QUICK if given.quick else 1.0
    clearance.main(share, clearance.LIMITS[:1] if given.quick else clearance.LIMITS)
    planning_speed(share)
    command_speed(share)
    print(f"\nfrom here on {use_one_core()}")
    accuracy()
    following_speed(share)
    scaling(share)
    actuation_speed(share)
    if given.docs is not None:
        docs_page.write_block(given.docs, "core", f"{docs_page.measured_with(given.quick)}\n\n{as_markdown()}")


def rounds(full: int, share: float) -> int:
    """How often a measurement is repeated in a run that takes a share of the full rounds."""
    return max(2, round(share * full))


def case(name: str) -> tuple[hognose.Task, hognose.Path, Array]:
    """A bundled task, its path and its feeds."""
    task = hognose.load_task(name)
    path = task.path_through(task.way_points)
    return task, path, insertion(task, path).feed


def random_path(rng: np.random.Generator, legs: int, leg: float, sideways: float) -> hognose.Path:
    """A spline that winds forward along z."""
    points = np.zeros((legs + 1, 3))
    points[:, 2] = leg * np.arange(legs + 1)
    points[1:, :2] = rng.uniform(-sideways, sideways, (legs, 2))
    return hognose.Path.through(points, 3, (0, 0, 1))


def accuracy() -> None:
    heading("largest errors of the method exact")
    rng = np.random.default_rng(1)
    lengths = hognose.load_robot("sjtu-25dof").link_lengths
    paths = {name: case(name)[1:] for name in CASES}
    for number in range(20):
        path = random_path(rng, 9, 0.25, 0.09)
        paths[f"random path {number + 1}"] = path, np.linspace(0.0, path.length - 1.2, 300)
    link_error, path_error = 0.0, 0.0
    for path, feeds in paths.values():
        joints = hognose.follow(path, lengths, feeds)
        link_error = max(link_error, float(np.abs(np.linalg.norm(np.diff(joints, axis=1), axis=2) - lengths).max()))
        path_error = max(path_error, float(path.distance_to(joints.swapaxes(0, 1)).max()))
    row(f"link lengths, both cases and {len(paths) - 2} random paths", link_error, 1e-12, "m")
    row("distance of the joints from the curve, same paths", path_error, 1e-12, "m")

    turn = np.linspace(0, 4 * np.pi, 1500)
    helix = hognose.Path.through(np.stack([0.3 * np.cos(turn), 0.3 * np.sin(turn), 0.05 * turn], axis=1), 5)
    joints = hognose.follow(helix, np.full(24, 0.091), [0.5])[0]
    angles = np.unwrap(np.arctan2(joints[:, 1], joints[:, 0]))
    steps = np.diff(angles)
    row("helix: spread of the arcs of equal chords, relative", float(np.ptp(steps) / steps.mean()), 1e-9, "")


def following_speed(share: float = 1.0) -> None:
    heading("following: time per step, 12 links (obstacle array)")
    task, path, feeds = case("obstacle-array")
    lengths = task.robot.link_lengths
    calls: dict[str, Callable[[], object]] = {}
    for method, spacing in (
        ("exact", 0.0005),
        ("prediction", 0.0005),
        ("prediction", 0.00005),
        ("interpolation", 0.0005),
        ("interpolation", 0.00005),
    ):
        follower = hognose.follower(path, lengths, method, spacing)
        calls[f"{method}, sd = {1e3 * spacing:g} mm"] = lambda f=follower: f.run(feeds)
    for spacing in (0.0005, 0.00005):
        stepping = Iterative(path, lengths, spacing, as_published=True)
        calls[f"stepping, sd = {1e3 * spacing:g} mm"] = lambda f=stepping: f.run(feeds)
    times = best_times(calls, rounds(200, share))
    for name, seconds in times.items():
        aside(name, 1e6 * seconds / len(feeds), "µs")
    fast, fine = times["prediction, sd = 0.5 mm"], times["prediction, sd = 0.05 mm"]
    row("stepping / prediction at sd = 0.5 mm", times["stepping, sd = 0.5 mm"] / fast, 20, "x", at_least=True)
    row("prediction at sd = 0.05 mm / at 0.5 mm", fine / fast, 2, "x")
    row("exact / prediction at sd = 0.5 mm", times["exact, sd = 0.5 mm"] / fast, 6, "x")

    follower = hognose.follower(path, lengths)
    online = best_times({"step": lambda: [follower.step(feed) for feed in feeds]}, rounds(20, share))["step"]
    aside("one step(feed) of a follower, called from Python", 1e6 * online / len(feeds), "µs")


def scaling(share: float = 1.0) -> None:
    heading("exact: time per link, 12 to 1,200 links of 10 mm")
    path = random_path(np.random.default_rng(2), 50, 0.3, 0.05).with_run(2.0)
    feeds = np.linspace(0.0, 2.0, 300)
    counts = (12, 120, 1200)
    calls = {}
    for count in counts:
        follower = hognose.follower(path, np.full(count, 0.01))
        calls[str(count)] = lambda f=follower: f.run(feeds)
    times = best_times(calls, rounds(30, share))
    per_link = [times[str(count)] / count / len(feeds) for count in counts]
    for count, seconds in zip(counts, per_link, strict=True):
        aside(f"{count:,} links", 1e9 * seconds, "ns per link and step")
    row("time per link, 1,200 / 12 links", per_link[-1] / per_link[0], 1.3, "x")


def actuation_speed(share: float = 1.0) -> None:
    heading("angles, cable lengths and motor counts: time per step (obstacle array)")
    task, path, feeds = case("obstacle-array")
    robot = task.robot
    follower = hognose.follower(path, robot.link_lengths)
    joints = follower.run(feeds)
    angles = robot.angles(joints)
    cables = robot.cable_lengths(angles)
    times = best_times(
        {
            "exact": lambda: follower.run(feeds),
            "angles": lambda: robot.angles(joints),
            "cable lengths": lambda: robot.cable_lengths(angles),
            "motor counts": lambda: robot.motor_counts(cables),
        },
        rounds(300, share),
    )
    for name, seconds in times.items():
        aside(name, 1e6 * seconds / len(feeds), "µs")
    together = sum(times[name] for name in ("angles", "cable lengths", "motor counts"))
    row("angles, cable lengths and motor counts / exact", together / times["exact"], 5, "x")


def planning_speed(share: float = 1.0) -> None:
    heading(f"whole plans with all checks and certificates, warm, {os.cpu_count()} cores")
    for name in (*CASES, "detour"):
        task = hognose.load_task(name)
        assert task.scene.names
        best, stages = float("inf"), {}
        for _ in range(rounds(15, share)):
            marks: list[tuple[str, float]] = []
            begin = time.perf_counter()
            hognose.plan(task, lambda stage, m=marks: m.append((stage, time.perf_counter())))
            end = time.perf_counter()
            if end - begin < best:
                best = end - begin
                ends = [at for _, at in marks[1:]] + [end]
                stages = {stage: until - at for (stage, at), until in zip(marks, ends, strict=True)}
        if name in CASES:
            row(f"{name}: whole plan", 1e3 * best, WHOLE_PLAN, "ms")
        else:
            aside(f"{name}: whole plan", 1e3 * best, "ms")
        plan = hognose.plan(task)
        begin = time.perf_counter()
        assert plan.body_deviation.size
        deviating = time.perf_counter() - begin
        for stage, seconds in stages.items():
            aside(f"{name}: {stage}", 1e3 * seconds, "ms")
        aside(f"{name}: body deviation, only when shown or saved", 1e3 * deviating, "ms")
    row("moving-obstacles: whole plan / with all obstacles standing as at its end", *moving_costs(share), "x")


def moving_costs(share: float = 1.0) -> tuple[float, float]:
    """How many times as long planning takes where obstacles move, and how many times it may."""
    task = hognose.load_task("moving-obstacles")
    standing = task.with_obstacles(task.scene_at(float(hognose.plan(task).time[-1])))
    calls: dict[str, Callable[[], object]] = {
        "moving": lambda: hognose.plan(task),
        "standing": lambda: hognose.plan(standing),
    }
    times = best_times(calls, rounds(15, share), time.process_time)
    return times["moving"] / times["standing"], 8.0


def command_speed(share: float = 1.0) -> None:
    heading("the command `hognose plan obstacle-array`, compared with importing its libraries")
    with tempfile.TemporaryDirectory() as folder:
        plan = [
            sys.executable,
            "-m",
            "hognose.cli",
            "plan",
            "obstacle-array",
            "-o",
            str(FilePath(folder) / "p.parquet"),
        ]
        imports = [sys.executable, "-c", "import numpy, scipy, numba, pyarrow"]
        # As installed: modules are not compiled from their sources each time, whatever this shell says.
        as_installed = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        as_installed["PYTHONPYCACHEPREFIX"] = folder
        times = best_times(
            {
                "plan": lambda: subprocess.run(plan, check=True, capture_output=True, env=as_installed),
                "imports": lambda: subprocess.run(imports, check=True, capture_output=True, env=as_installed),
            },
            rounds(8, share),
        )
    aside("hognose plan", times["plan"], "s")
    aside("importing numpy, scipy, numba and pyarrow", times["imports"], "s")
    row("hognose plan / imports", times["plan"] / times["imports"], 3, "x")


if __name__ == "__main__":
    main()
