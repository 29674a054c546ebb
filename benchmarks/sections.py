"""`python -m benchmarks.sections`: how close arms of arcs keep to paths, and what following them costs.

Times are the processor's, on one core, and of one run; bounds on them are ratios, but for that of a whole plan.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.errors import InfeasibleError
from hognose.evaluation.shapes import SHAPES, shape
from hognose.following.sections import SectionFollower
from hognose.planning import Plan, Task
from hognose.planning.planner import plan_along
from hognose.robot import Robot, RobotSpec
from hognose.robot.sections import KINDS, Geometry, MixedSections

Array = NDArray[np.float64]

CASES = ("obstacle-array", "pipe-tank")
#: The largest body deviation (mm) of 12 arcs on the obstacle array, by method.
DEVIATION = {"aim": 1.2, "fitted": 0.7}
#: Mean deviation of three sections on a slider and with a free base, in % of the arm's length.
MEAN_OF_THREE = {False: 1.0, True: 0.7}
#: The arms of few sections: sections, joints of each if they are stacks, and whether their base is free.
FEW = ((2, None, False), (3, None, False), (3, 6, False), (4, None, False), (6, None, False), (12, None, False))
FEW += ((2, None, True), (3, None, True), (3, 6, True), (4, None, True))
#: Feeds at which shapes are looked at, and shapes of each kind.
POSES, SHAPES_OF_A_KIND = 30, 40
#: How short and how long sections that extend get, in parts of their length at rest.
EXTENSION = (0.55, 4 / 3)
#: Runs that are timed at once, of the fast methods.
REPEATS = 20
#: Times the time of the rigid exact method; ms of a whole certified plan.
TIMES_RIGID, PLAN = 4.0, 80.0
#: What is published of following with a continuum arm whose base moves freely [sb-ftl 2026, abstract].
PUBLISHED = 1.9


def main(rounds: int = 15) -> None:
    """Print all of it."""
    print(use_one_core())
    on_cases()
    on_shapes()
    on_extension()
    times(rounds)


def arc_arm() -> Robot:
    """The bundled arm with arcs in place of its links, and limits of speed that no method comes to."""
    spec = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True, exclude_none=True)
    for section in spec["section"]:
        section["kind"] = "arc"
        section.pop("half_lengths", None)
    spec["name"] = "12 arcs of 91 mm"
    spec["limits"].update(joint_speed_deg_s=60.0, joint_acceleration_deg_s2=2000.0)
    return Robot.from_spec(RobotSpec.model_validate(spec))


def task_of(name: str, method: str, robot: Robot) -> Task:
    """A bundled task for another arm."""
    task = hognose.load_task(name)
    motion = task.spec.motion.model_copy(update={"method": method})
    return replace(task, robot=robot, spec=task.spec.model_copy(update={"motion": motion}))


def on_cases() -> None:
    """Deviations of whole plans."""
    robot = arc_arm()
    heading("body deviation of 12 arcs of 91 mm, largest of a whole plan")
    for name in CASES:
        for method in ("exact", "aim", "fitted"):
            plan = plan_along(task_of(name, method, robot))
            away = 1e3 * plan.follower.path.distance_to(robot.model.vertices(plan.joints))
            what = f"{name}, {method}"
            if name == "obstacle-array" and method in DEVIATION:
                row(f"{what}: largest", float(away.max()), DEVIATION[method], "mm")
            else:
                aside(f"{what}: largest", float(away.max()), "mm")
            aside(f"{what}: root mean square", float(np.sqrt(np.mean(away**2))), "mm")


def on_shapes(each: int = SHAPES_OF_A_KIND) -> None:
    """Mean deviations of few sections on drawn shapes, and the published figure, of other shapes, beside them."""
    heading(f"mean deviation, % of length, fitted, {each} shapes of each kind")
    both: dict[str, Array] = {}
    for arm in FEW:
        sections, joints, free = arm
        name = f"{sections} arcs" if joints is None else f"{sections} stacks of {joints} joints"
        name += ", free base" if free else ", slider only"
        found = {
            kind: np.array([deviations(kind, np.random.default_rng([number, seed]), *arm) for seed in range(each)])
            for number, kind in enumerate(SHAPES)
        }
        for kind, figures in found.items():
            if sections == 3:
                row(f"{name}, {kind}: mean of all poses", float(np.nanmean(figures[:, 0])), MEAN_OF_THREE[free], "%")
            else:
                aside(f"{name}, {kind}: mean of all poses", float(np.nanmean(figures[:, 0])), "%")
        every = np.concatenate(list(found.values()))
        aside(f"{name}: shapes with poses for which none was found", int(np.isnan(every[:, 0]).sum()), "")
        aside(f"{name}: worst pose", float(np.nanmax(every[:, 1])), "%")
        row(f"{name}: tip off the path", float(np.nanmax(every[:, 3])), 1e-9, "%")
        if free:
            aside(f"{name}: first joint off the path, at most", float(np.nanmax(every[:, 4])), "%")
        both[name] = np.nanmean(np.concatenate([found["C"], found["S"]]), axis=0)
    heading("beside a published figure; the shapes are not the same, these are drawn from words")
    for name, means in both.items():
        aside(f"{name}, S and C: all poses of the way in", float(means[0]), "%")
        aside(f"{name}, S and C: wholly in", float(means[2]), "%")
    aside("published: S, C and robot shapes, base with six degrees of freedom", PUBLISHED, "%")


def on_extension() -> None:
    """What it helps that sections extend, of three arcs on a slider as of `metabot-3arc` with a pitch of 30 mm."""
    heading("mean deviation of three arcs that extend from 0.55 to 1.33 of their length, in % of the arm")
    for number, kind in enumerate(SHAPES):
        means, lost = [], []
        for extension in (None, EXTENSION):
            rngs = (np.random.default_rng([number, seed]) for seed in range(SHAPES_OF_A_KIND))
            found = np.array([deviations(kind, rng, 3, None, False, extension)[0] for rng in rngs])
            means.append(found)
            lost.append(int(np.isnan(found).sum()))
        both = ~np.isnan(np.sum(means, axis=0))
        fixed, able = (float(each[both].mean()) for each in means)
        aside(f"{kind}: sections that keep their length", fixed, "%")
        row(f"{kind}: sections that extend", able, fixed, "%")
        for what, count in zip(("that keep their length", "that extend"), lost, strict=True):
            aside(
                f"{kind}: shapes of {SHAPES_OF_A_KIND} with poses for which none was found, sections {what}", count, ""
            )


def deviations(
    kind: str,
    rng: np.random.Generator,
    sections: int,
    joints: int | None,
    free: bool,
    extension: tuple[float, float] | None = None,
) -> Array:
    """Mean over body and poses, worst pose's mean, last pose's, the tip's and the first joint's largest; or NaN.

    In % of the arm's length.
    """
    path = shape(kind, 1.0, rng)
    between = None if extension is None else (extension[0] / sections, extension[1] / sections)
    section = Geometry(1.0 / sections, 0.0, 0.0, 0.01, (1.5, 1.5), joints, length_range=between)
    model = MixedSections([KINDS["joints" if joints else "arc"]] * sections, [section] * sections, 0.0)
    lengths, feeds = np.full(sections, 1.0 / sections), np.linspace(0.0, 1.0, POSES)
    try:
        method = hognose.follower(path, lengths, "fitted", model=model, axes=np.eye(3), carried=free)
        assert isinstance(method, SectionFollower)
        ends, axes = method.run_with_axes(feeds)
    except InfeasibleError:
        return np.full(5, np.nan)
    line = np.einsum("tij,tnj->tni", axes, model.vertices(ends @ axes))
    away = 100.0 * path.distance_to(line)
    poses = away.mean(axis=1)
    return np.array([poses.mean(), poses.max(), poses[-1], away[:, -1].max(), away[:, 0].max()])


def times(rounds: int) -> None:
    """What following and planning cost."""
    robot, rigid = arc_arm(), hognose.load_robot("sjtu-25dof")
    for name in CASES:
        plan = plan_along(task_of(name, "exact", robot))
        feeds = plan.feed
        heading(f"time of {len(feeds)} steps of {name}, 12 sections, one core")
        # The rigid arm, whose body is longer on the path, would come to its end a little earlier.
        shared = feeds[feeds < feeds[-1] - 0.01]
        runs = {"rigid": follower_of(plan, rigid, "exact").run}
        runs |= {method: follower_of(plan, robot, method).run for method in ("exact", "aim", "fitted")}
        repeats = dict.fromkeys(runs, 1) | {"rigid": REPEATS, "exact": REPEATS}
        took = best_times(
            {what: partial(repeated, run, shared, repeats[what]) for what, run in runs.items()},
            rounds,
            time.process_time,
        )
        a_step = {what: seconds / repeats[what] / len(shared) for what, seconds in took.items()}
        row("exact, arcs to rigid links", a_step["exact"] / a_step["rigid"], TIMES_RIGID, "x")
        for what, seconds in a_step.items():
            aside(f"{what}, a step", 1e6 * seconds, "us")
        plans = {method: partial(plan_along, task_of(name, method, robot)) for method in ("exact", "aim", "fitted")}
        plans["rigid links, exact"] = partial(plan_along, hognose.load_task(name))
        took = best_times({**plans}, max(rounds // 3, 1), time.process_time)
        for method, seconds in took.items():
            if method not in ("exact", "aim"):
                aside(f"whole certified plan, {method}", 1e3 * seconds, "ms")
            else:
                row(f"whole certified plan, {method}", 1e3 * seconds, PLAN, "ms")
        for method in ("exact", "aim", "fitted"):
            follower = follower_of(plan, robot, method)
            there, back = follower.run(feeds), follower.run(feeds[::-1])[::-1]
            row(f"{method}: forward and backward differ by", float(np.abs(there - back).max()), 1e-12, "m")


def repeated(run: Callable[[Array], Array], feeds: Array, times: int) -> None:
    """Run so many times: one run of a fast method is too short for the clock."""
    for _ in range(times):
        run(feeds)


def follower_of(plan: Plan, robot: Robot, method: str) -> hognose.following.Follower:
    """A follower of a plan's path for a robot."""
    path = plan.follower.path.with_end(0.05)
    if not isinstance(robot.model, MixedSections):
        return hognose.following.follower(path, robot.link_lengths, method)
    return hognose.following.follower(path, robot.link_lengths, method, model=robot.model, axes=np.eye(3))


if __name__ == "__main__":
    main()
