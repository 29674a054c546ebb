"""`python -m benchmarks.twin`: how close the twin comes to plans, what deviations do to it, and how fast it is."""

from __future__ import annotations

import time

import numpy as np

import hognose
from benchmarks.mechanics import CASES, arm_of
from benchmarks.rows import aside, heading, row
from benchmarks.timing import use_one_core
from hognose.planning import Plan, Task, TaskSpec
from hognose.robot import Robot, RobotSpec
from hognose.sim import Changes, Simulated, random_zeros, simulate
from hognose.studies.experiment import BOARD, HELD_AT, SHIFTS

#: Root mean squares of the tip (mm) and the joints (°) on the same model, and of the tip with EA off by 20 %.
TIP, JOINTS, OTHER_TIP = 0.03, 0.005, 1.5
#: How many times as fast as the real arm: with exact contact and 36 cables, and with 30 sections.
FASTER, FASTER_LONG = 25.0, 5.0
#: Arms of other sections: tip in root mean square (mm), and how many times as fast as the real arm.
OTHER_SECTIONS, FASTER_SECTIONS = 0.15, 3.0
#: [assumed] Cables of arms whose robot files have none (EA, free length, pretension, smallest and largest tension), and
#: the bending stiffness (N m²) of their sections.
CABLES: dict[str, tuple[tuple[float, ...], float | None]] = {
    "baffled-tank": ((), None),
    "test-box": ((200e3, 0.5, 150.0, 30.0, 2000.0), None),
    "engine-stage": ((60e3, 0.3, 30.0, 5.0, 400.0), 0.02),
}


def main(rounds: int = 3) -> None:
    """Print all of it."""
    plans = {name: hognose.plan(hognose.load_task(name)) for name in CASES}
    heading("the same model")
    for name, plan in plans.items():
        same_model(name, plan)
    heading("another arm: tip in root mean square; obstacle array unless said")
    for name in CASES:
        for factor in (0.8, 1.2):
            done = simulate(plans[name], Changes(stiffness=factor))
            row(f"{name}: EA {100 * factor - 100:+.0f} %", tip_rms(done), OTHER_TIP, "mm")
    others(plans["obstacle-array"])
    heading(f"{BOARD} shifted up")
    for shift in SHIFTS:
        shifted(plans["obstacle-array"], shift)
    heading(f"real time factor, {use_one_core()}")
    touching = Changes(shifted={BOARD: (0.0, 0.03, 0.0)})
    row("12 sections, 36 cables, exact contact", faster(plans["obstacle-array"], rounds), FASTER, "x", at_least=True)
    aside("the same, touching a board for most of the way", faster(plans["obstacle-array"], rounds, touching), "x")
    aside("the same, with friction", faster(plans["obstacle-array"], rounds, Changes(friction=0.1)), "x")
    aside("obstacles that move", faster(hognose.plan(hognose.load_task("moving-obstacles")), rounds), "x")
    row("30 sections, 90 cables", faster(long_plan(), rounds), FASTER_LONG, "x", at_least=True)
    heading("arms of other sections")
    for name in CABLES:
        other_sections(name)


def same_model(name: str, plan: Plan) -> None:
    """How close an arm comes that is the one planned with."""
    done = simulate(plan)
    off = np.degrees(np.sqrt(np.mean((done.angles - done.commanded) ** 2)))
    row(f"{name}: tip in root mean square", tip_rms(done), TIP, "mm")
    row(f"{name}: joints in root mean square", float(off), JOINTS, "°")
    row(f"{name}: cables that go slack", float(done.slack.max()), 0.0, "")
    row(f"{name}: largest contact", float(done.contact.max()), 0.0, "N")
    worst = int(done.tip_errors.argmax())
    aside(
        f"{name}: tip at most, in row {worst} of 0 to {len(plan.time) - 1}", 1e3 * float(done.tip_errors[worst]), "mm"
    )
    aside(f"{name}: tip at most before the last row", 1e3 * float(done.tip_errors[:-1].max()), "mm")


def others(plan: Plan) -> None:
    """What deviations do to the tip."""
    changes = {
        "mass +20 %": Changes(mass=1.2),
        "base 0.05 s late": Changes(lag=0.05),
        "friction 0.1": Changes(friction=0.1),
    }
    for what, change in changes.items():
        aside(what, tip_rms(simulate(plan, change)), "mm")
    zeros = [simulate(plan, Changes(cable_zeros=random_zeros(plan.robot, 1e-4, seed))) for seed in range(6)]
    aside("zeros, sigma 0.1 mm, six arms", float(np.sqrt(np.mean([tip_rms(each) ** 2 for each in zeros]))), "mm")
    done = simulate(plan, Changes(friction=0.1))
    share = done.end_tensions / done.tensions
    aside("friction 0.1: tension lost by the end of a cable at most", 100 * float(1 - share.min()), "%")


def shifted(plan: Plan, shift: float) -> None:
    """When contact starts, how hard it gets, and what a contact stop does."""
    changes, what = Changes(shifted={BOARD: (0.0, shift, 0.0)}), f"{1e3 * shift:g} mm"
    done, stop = simulate(plan, changes), simulate(plan, changes, stop_at_contact=HELD_AT).contact_stop
    if done.first_contact is None:
        aside(f"{what}: largest contact", 0.0, "N")
        return
    aside(f"{what}: contact starts", done.first_contact, "s")
    aside(f"{what}: largest contact{' until it buckles' if done.stopped else ''}", float(done.contact.max()), "N")
    aside(f"{what}: tip off at most", 1e3 * float(done.tip_errors.max()), "mm")
    if stop is not None:
        aside(f"{what}: stopped above {HELD_AT:g} N", stop.time, "s")
        aside(f"{what}: largest contact after that", stop.peak, "N")
        aside(f"{what}: contact after {stop.settled:g} s", stop.remaining, "N")
        aside(f"{what}: tip off then", 1e3 * stop.tip_error, "mm")


def other_sections(name: str) -> None:
    """How close an arm comes whose sections are no links, and how fast its twin is."""
    task, (cables, stiffness) = hognose.load_task(name), CABLES[name]
    if cables:
        keys = ("axial_stiffness_N", "free_length", "pretension_N", "tension_min_N", "tension_max_N")
        given = task.robot.spec.model_dump(by_alias=True)
        # Mechanics are not known of cables that change their circle: here they keep it.
        changed = {"bending_stiffness_N_m2": stiffness, "passing_cable_radius": None}
        sections = [section | changed for section in given["section"]]
        given |= {"cables": dict(zip(keys, cables, strict=True)), "section": sections}
        task = Task(task.spec, Robot.from_spec(RobotSpec.model_validate(given)))
    plan = hognose.plan(task)
    done = simulate(plan)
    row(f"{name}: tip in root mean square", tip_rms(done), OTHER_SECTIONS, "mm")
    aside(f"{name}: tip at most", 1e3 * float(done.tip_errors.max()), "mm")
    row(f"{name}: cables that go slack", float(done.slack.max()), 0.0, "")
    row(f"{name}: real time factor", faster(plan, 1), FASTER_SECTIONS, "x", at_least=True)


def tip_rms(done: Simulated) -> float:
    """How far the tip is off in root mean square, mm."""
    return 1e3 * float(np.sqrt(np.mean(done.tip_errors**2)))


def faster(plan: Plan, rounds: int, changes: Changes | None = None) -> float:
    """How many times as fast as the real arm the best of some runs is, by the processor's time."""
    factors = []
    for _ in range(rounds + 1):
        begin = time.process_time()
        done = simulate(plan, changes)
        factors.append(float(done.time[-1]) / (time.process_time() - begin))
    return max(factors)


def long_plan() -> Plan:
    """An arm of 30 sections on stiff cables, which slides into the open and bends to a side."""
    spec = arm_of(hognose.load_robot("sjtu-25dof"), 30).robot.spec
    assert spec.cables is not None, "the bundled arm has cables"
    stiff = spec.cables.model_copy(update={"axial_stiffness_N": 300e3})
    robot = Robot.from_spec(spec.model_copy(update={"cables": stiff}))
    points = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.2), (0.08, 0.02, 0.5), (0.2, 0.0, 0.8)]
    task = TaskSpec.model_validate({"name": "long", "robot": robot.name, "path": {"way_points": points}})
    return hognose.plan(Task(task, robot))


if __name__ == "__main__":
    main()
