"""`python -m benchmarks.calibration`: how exactly the tip goes where it shall after a calibration.

Arms are emulated: their zeros (1σ 0.5 mm) and the EA of every section (within 20 %) are hidden. All but the last
figures are of an arm that comes to rest as statics say, another one for every seed. `--docs docs/calibration.md` writes
them into the documentation.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks import docs_page
from benchmarks.rows import as_markdown, aside, heading, row
from hognose.calibration import (
    TROUGH,
    Calibration,
    Fit,
    Hidden,
    Sensors,
    Setting,
    StaticArm,
    calibrate,
    start_of,
    true_errors,
)
from hognose.mechanics import Mechanics
from hognose.planning import Plan
from hognose.sim.arm import TwinArm, twin_of

Array = NDArray[np.float64]

CASES = ("obstacle-array", "pipe-tank")
#: How many arms are calibrated, and how many of them as MuJoCo twins.
SEEDS, TWINS = 20, 2
#: What the tip must reach straight and along the cases (mm), by method.
LIMITS = {"jig": (0.3, 0.5), "tip": (0.3, 0.5), "tensions": (5.0, 5.0)}
WORDS = {"jig": "clamped in a jig", "tip": "tensions and tip", "tensions": "tensions alone"}
#: How far the base is drawn back (m) while the twin is calibrated.
BACK = 0.1


@dataclass(frozen=True, eq=False)
class Bench:
    """The arm of the cases, and where it is calibrated."""

    plans: list[Plan]
    setting: Setting

    @classmethod
    def of_cases(cls) -> Bench:
        """Both cases have the same arm."""
        plans = [hognose.plan(hognose.load_task(name)) for name in CASES]
        task = plans[0].task
        at = start_of(task, BACK)
        return cls(plans, Setting(Mechanics.of(task.robot), task.gravity(at[None])[0], at))

    def calibrated(
        self, method: str, seed: int, setting: Setting, true: Mechanics, gain: float = 0.0
    ) -> tuple[Calibration, Hidden]:
        """An emulated arm whose masses are those of `true`, calibrated; `gain` is that of its sensors of tension."""
        hidden, accuracy = Hidden.drawn(true, seed), setting.accuracy
        off = accuracy.jig if method == "jig" else TROUGH
        arm = StaticArm(true, setting.gravity, hidden, Sensors(accuracy, seed, method == "tip", gain), off)
        return calibrate(arm, setting, method), hidden

    def errors(self, found: Calibration, hidden: Hidden, true: Mechanics | None = None) -> list[float]:
        """Largest errors of the tip (mm), straight and along the cases."""
        setting = self.setting
        parts = [(np.zeros((1, setting.mechanics.robot.sections, 2)), setting.gravity)]
        parts += [(plan.angles, plan.task.gravity(plan.at)) for plan in self.plans]
        nominal = setting.mechanics
        return [1e3 * float(true_errors(found, nominal, hidden, *part, true).max()) for part in parts]


def main(seeds: int = SEEDS, twins: int = TWINS) -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description="Calibration of the cables.")
    parser.add_argument("--quick", action="store_true", help="few arms, to try the command out")
    docs_page.add_option(parser)
    given = parser.parse_args()
    if given.quick:
        seeds, twins = 3, 1
    bench = Bench.of_cases()
    mechanics = bench.setting.mechanics
    heading(f"largest error of the tip before, {seeds} arms")
    none = [bench.errors(_nominal(bench.setting), Hidden.drawn(mechanics, seed)) for seed in range(seeds)]
    for place, off in zip(("straight", *CASES), np.array(none).T, strict=True):
        aside(f"{place}, median", float(np.median(off)), "mm")
        aside(f"{place}, worst", float(off.max()), "mm")
    for method in LIMITS:
        after(bench, method, seeds)
    for method in LIMITS:
        if_wrong(bench, method, max(3, seeds // 2), "with masses 5 % above those of the file", mass=1.05)
        if_wrong(bench, method, max(3, seeds // 2), "with sensors of tension that read 1 % off (1σ)", gain=0.01)
    with_mujoco(bench, twins)
    if given.docs is not None:
        docs_page.write_block(given.docs, "calibration", as_markdown())


def after(bench: Bench, method: str, seeds: int) -> None:
    """Errors after a calibration by one method."""
    setting, off, chi2, said, readings = bench.setting, [], [], [], 0
    for seed in range(seeds):
        found, hidden = bench.calibrated(method, seed, setting, setting.mechanics)
        off.append(bench.errors(found, hidden))
        chi2.append(found.fit.chi2 / found.fit.degrees)
        readings = found.readings
        straight = np.zeros((1, setting.mechanics.robot.sections, 2))
        said.append(1e3 * float(found.tip_spread(setting.mechanics, straight, setting.gravity)[0]))
    accuracy = setting.accuracy
    heading(
        f"{WORDS[method]}: {readings} readings, {seeds} arms; tension ±{accuracy.tension:g} N"
        + (f", tip ±{1e3 * accuracy.tip:g} mm" if method == "tip" else "")
        + (f", jig ±{1e3 * accuracy.jig:g} mm" if method == "jig" else "")
    )
    for place, each in zip(("straight", *CASES), np.array(off).T, strict=True):
        limit = LIMITS[method][place != "straight"]
        aside(f"{place}, median", float(np.median(each)), "mm")
        row(f"{place}, worst", float(each.max()), limit, "mm")
    aside("straight, as the covariance says (1σ)", float(np.median(said)), "mm")
    aside("χ² over the number of values, median", float(np.median(chi2)), "")


def if_wrong(bench: Bench, method: str, seeds: int, words: str, mass: float = 1.0, gain: float = 0.0) -> None:
    """Errors where the model itself is wrong: masses, or what sensors of tension read."""
    mechanics, setting = bench.setting.mechanics, bench.setting
    heading(f"{WORDS[method]}, {words}, {seeds} arms")
    true = replace(mechanics, links=mechanics.links * [1.0, mass, 1.0], tool_mass=mass * mechanics.tool_mass)
    off, chi2 = [], []
    for seed in range(seeds):
        found, hidden = bench.calibrated(method, seed, setting, true, gain)
        off.append(max(bench.errors(found, hidden, true)))
        chi2.append(found.fit.chi2 / found.fit.degrees)
    aside("straight or along a case, median", float(np.median(off)), "mm")
    aside("straight or along a case, worst", float(max(off)), "mm")
    aside("χ² over the number of values, median", float(np.median(chi2)), "")


def with_mujoco(bench: Bench, twins: int) -> None:
    """The same on the MuJoCo twin: calibrated there, and moved there through both cases."""
    setting, mechanics = bench.setting, bench.setting.mechanics
    for method in LIMITS:
        heading(f"{WORDS[method]}, on the MuJoCo twin, {twins} arms")
        apart, moved = [], []
        for seed in range(twins):
            hidden, accuracy = Hidden.drawn(mechanics, seed), setting.accuracy
            off = accuracy.jig if method == "jig" else TROUGH
            sensors = Sensors(accuracy, seed, method == "tip")
            found = calibrate(TwinArm(bench.plans[0].task, hidden, sensors, off, setting.at), setting, method)
            still = bench.errors(found, hidden)
            static = bench.errors(bench.calibrated(method, seed, setting, mechanics)[0], hidden)
            apart.append(max(abs(a - b) for a, b in zip(still, static, strict=True)))
            moved.append([_moved(plan, found, hidden, mechanics) for plan in bench.plans])
        row("tip against a calibration by statics, worst difference", max(apart), 0.05, "mm")
        for name, each in zip(CASES, np.array(moved).T, strict=True):
            row(f"{name}, moved, at rest at the end, worst", float(each.max()), LIMITS[method][1], "mm")


def _moved(plan: Plan, found: Calibration, hidden: Hidden, mechanics: Mechanics) -> float:
    """How far (mm) the tip of the twin is off where a plan ends, commanded as calibrated."""
    twin = twin_of(plan.task, hidden)
    lengths = found.motors(mechanics, plan.angles, plan.task.gravity(plan.at))
    twin.put(plan.at[0], plan.angles[0])
    for step in range(1, len(plan.time)):
        span = float(plan.time[step] - plan.time[step - 1])
        count = max(1, round(span / twin.time_step))
        speeds, ahead = (lengths[step] - lengths[step - 1]) / span, (plan.at[step] - plan.at[step - 1]) / span
        for k in range(1, count + 1):
            share = k / count
            wanted = lengths[step - 1] + share * (lengths[step] - lengths[step - 1])
            twin.step(wanted, speeds, plan.at[step - 1] + share * (plan.at[step] - plan.at[step - 1]), ahead)
    still = np.zeros_like(lengths[-1]), np.zeros_like(plan.at[-1])
    for _ in range(round(20.0 / twin.time_step)):
        twin.step(lengths[-1], still[0], plan.at[-1], still[1])
    return 1e3 * float(np.linalg.norm(twin.joints[-1] - plan.joints[-1, -1]))


def _nominal(setting: Setting) -> Calibration:
    """A calibration that has found nothing."""
    c, n = setting.mechanics.robot.cables, setting.mechanics.robot.sections
    nothing = Fit(np.zeros(c), np.ones(n), np.zeros((c + n, c + n)), 0.0, 0, 0)
    return Calibration.made(setting.mechanics.robot, "tensions", nothing, setting.accuracy, setting.prior, 0)


if __name__ == "__main__":
    main()
