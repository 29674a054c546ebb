"""`hognose simulate`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hognose.cli.options import Flag, PlanOrTask

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from hognose.planning import Plan
    from hognose.robot import Robot
    from hognose.sim import Changes, Simulated


@dataclass(frozen=True)
class Files:
    """Files to write, besides what is printed.

    Attributes
    ----------
    log
        Write one row a control period into this file, .csv, .parquet or .json. What was done is written, too, if the
        twin is stopped or the command is interrupted.
    video
        Write the arm on its way, with what a camera on its tip sees, into this file: .gif, or .mp4 if imageio-ffmpeg
        is installed.
    camera
        Write what a camera on the tip sees into this file: .png at the instants of the task, .gif or .mp4 all the way.
    """

    log: Path | None = None
    video: Path | None = None
    camera: Path | None = None

    def refuse(self, source: str) -> None:
        """Raise an InputError, before anything is computed, if one cannot be written or would replace another."""
        from hognose.cli.console import refuse_target
        from hognose.errors import InputError
        from hognose.sim.log import refuse_log

        if self.log is not None:
            refuse_log(self.log)
        if self.video is not None or self.camera is not None:
            from hognose.studies.pictures import refuse_names

            refuse_names(self.video, self.camera)
        taken: dict[Path, str] = {}
        for option, file in (("--log", self.log), ("--video", self.video), ("--camera", self.camera)):
            if file is None:
                continue
            refuse_target(file, source)
            other = taken.setdefault(file.resolve(), option)
            if other != option:
                raise InputError(f"{file}: {other} and {option} name the same file; give each another name")

    @property
    def pictures(self) -> list[Path]:
        """Those that are drawn."""
        return [file for file in (self.video, self.camera) if file is not None]

    def draw(self, done: Simulated, quiet: bool) -> None:
        """Write the pictures."""
        if not self.pictures:
            return
        from hognose.cli.console import counting
        from hognose.studies.pictures import write_pictures

        with counting("drawing", quiet) as progress:
            write_pictures(done, self.video, self.camera, progress)

    def to_json(self) -> dict[str, object]:
        """Names of those that were written."""
        told: dict[str, object] = {} if self.log is None else {"file": str(self.log)}
        return {**told, "pictures": [str(file) for file in self.pictures]} if self.pictures else told

    def lines(self, done: Simulated) -> list[str]:
        """What was written, a line a file."""
        rows = [] if self.log is None else [f"{self.log}: {len(done.time)} rows"]
        return rows + [f"{file}: {file.stat().st_size / 1e3:.0f} kB" for file in self.pictures]


def simulate(
    plan: PlanOrTask,
    /,
    *,
    stiffness: float = 1.0,
    mass: float = 1.0,
    friction: float | None = None,
    lag: float = 0.0,
    zeros: float = 0.0,
    seed: int = 0,
    zero: Annotated[tuple[tuple[int, float], ...], Parameter(negative="")] = (),
    shift: Annotated[tuple[tuple[str, float, float, float], ...], Parameter(negative="")] = (),
    stop_at_contact: float | None = None,
    files: Annotated[Files | None, Parameter(name="*")] = None,
    json: Flag = False,
) -> int:
    """Move a twin of the arm through a plan: cables that only pull, weight, and contact, integrated by MuJoCo.

    The exit code is 1 if the twin was stopped, because the arm buckled or an axis crossed a surface, if it touched
    something, if a cable went slack or was pulled too much, or if the plan itself is not good.

    Parameters
    ----------
    stiffness
        Factor of the cables' EA, against what was planned with.
    mass
        Factor of all masses.
    friction
        Coefficient of friction of the cables in their holes; as the robot file says unless given.
    lag
        By how much the base is later than the cables, in s.
    zeros
        Standard deviation of the cables' zeros, in mm: each cable is longer or shorter than its motor says.
    seed
        Of the random numbers for these.
    zero
        A single cable that is longer than its motor says: its number, and by how much in mm.
    shift
        An obstacle that stands elsewhere: its name, and how far along x, y and z in mm.
    stop_at_contact
        Where a link is pressed with more than this (N) all motors hold; the arm then has 1 s to settle.
    json
        Print the figures as JSON, in SI units.
    """
    from hognose.cli.console import plan_of
    from hognose.sim.changes import Changes

    files = Files() if files is None else files
    files.refuse(plan)
    found = plan_of(plan, json)
    off = _zeros(found.robot, zeros, seed, zero)
    shifted = {name: (x / 1e3, y / 1e3, z / 1e3) for name, x, y, z in shift}
    changes = Changes(stiffness, mass, off, shifted, friction, lag)
    done = _simulated(found, changes, stop_at_contact, files.log, json)
    files.draw(done, json)
    _say(done, files, json)
    return 0 if done.good else 1


def _zeros(robot: Robot, sigma: float, seed: int, single: tuple[tuple[int, float], ...]) -> NDArray[np.float64] | None:
    """By how much (c,) m cables are longer than their motors say, of figures in mm; None if none is."""
    from hognose.sim.changes import random_zeros, set_zeros

    off = set_zeros(robot, random_zeros(robot, sigma / 1e3, seed), tuple((nr, length / 1e3) for nr, length in single))
    return off if off.any() else None


def _simulated(plan: Plan, changes: Changes, limit: float | None, log: Path | None, quiet: bool) -> Simulated:
    """What the plan's motion becomes, logged also if that is interrupted."""
    from hognose.cli.console import counting
    from hognose.sim import SimulationInterrupted, write_log
    from hognose.sim import simulate as simulated

    try:
        with counting(f"simulating {plan.task.name}", quiet) as progress:
            done = simulated(plan, changes, progress, limit)
    except SimulationInterrupted as stop:
        if log is None:
            raise
        write_log(stop.done, log)
        raise KeyboardInterrupt(f"{stop}; what was done is in {log}, {len(stop.done.time)} rows") from None
    if log is not None:
        write_log(done, log)
    return done


def _say(done: Simulated, files: Files, as_json: bool) -> None:
    from hognose.cli.console import say, say_json

    if as_json:
        say_json({"good": done.good, "task": done.plan.task.name, **files.to_json(), **done.to_json()})
    else:
        say("\n".join([_summary(done), *files.lines(done)]))


def _summary(done: Simulated) -> str:
    off, load = 1e3 * done.tip_errors, float(done.load_factor.min())
    lines = [
        f"{done.plan.task.name}: {done.time[-1]:.1f} of {done.plan.time[-1]:.1f} s, {done.factor:.0f} x real time",
        f"tip off the plan by {(off**2).mean() ** 0.5:.3f} mm in root mean square, {off.max():.3f} mm at most",
        f"tensions {done.lowest_tensions.min():.1f} to {done.highest_tensions.max():.1f} N, "
        f"load factor of buckling {load:.2f}",
    ]
    if done.slack.any():
        lines[-1] += f", {done.slackest}"
    for name, each in done.touches.items():
        lines.append(
            f"touched {name} from {each.first:.2f} s on, with up to {each.largest:.1f} N on link {each.link + 1}"
        )
    if done.plan_failed:
        more = f" (and {len(done.plan_failed) - 1} more)" if len(done.plan_failed) > 1 else ""
        lines.append(f"the plan itself is NOT GOOD: {done.plan_failed[0]}{more}")
    if done.assumed:
        lines.append(f"assumed: {', '.join(done.assumed)}")
    return "\n".join([*lines, done.verdict])
