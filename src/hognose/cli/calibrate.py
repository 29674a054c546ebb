"""`hognose calibrate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter, validators

from hognose.cli.completers import tasks_and_robots
from hognose.cli.options import Flag, OptionalOutput

if TYPE_CHECKING:
    from hognose.calibration import Arm, Calibration, Hidden, Setting
    from hognose.planning import Task

#: How far the base is drawn back unless said otherwise (mm).
_BACK = 100.0


def calibrate(
    source: Annotated[str, Parameter(completer=tasks_and_robots)],
    /,
    output: OptionalOutput = None,
    *,
    twin: Flag = False,
    statics: Flag = False,
    method: Literal["tensions", "tip", "jig"] = "tip",
    poses: Annotated[int | None, Parameter(validator=validators.Number(gte=1, lte=1000))] = None,
    back: Annotated[float | None, Parameter(validator=validators.Number(gte=0))] = None,
    errors: Annotated[tuple[float, float, float], Parameter(negative="")] = (0.2, 0.2, 0.02),
    seed: int = 0,
    json: Flag = False,
) -> int:
    """Pretension an arm, and find the zeros and the stiffness of its cables with their covariance.

    Drives are not connected in this version: the arm is an emulated one, whose zeros (1σ 0.5 mm) and EA (within 20 %,
    each section's its own) are hidden. The exit code is 1 if no pretension holds, or if what was read does not fit.

    Parameters
    ----------
    source
        A robot (name or .toml), or a task, whose obstacles are kept clear of.
    output
        The calibration file to write; by default the source's name with -calibration.json, in this folder.
    twin
        Calibrate the MuJoCo twin of the arm.
    statics
        Calibrate an arm that is at rest at once, in free space: faster, and without MuJoCo.
    method
        From tensions alone; with the place of the tip as well; or clamped straight in a jig, at two levels of tension.
    poses
        In how many it is read; 24 for tensions, 12 with the tip. In a jig there are none.
    back
        How far before the start of its task the base stands meanwhile, mm; 100 unless given.
    errors
        How exactly tensions (N), the tip (mm, each coordinate) and joints in the jig (mm, across) are known, 1σ.
    seed
        Of what is hidden, and of the noise.
    json
        Print the figures as JSON, in SI units.
    """
    from hognose.calibration import calibrate as calibrated
    from hognose.cli import compile_ahead
    from hognose.cli.console import counting

    _refuse(twin, statics, method, poses, seed)
    target = _target(source, output)
    compile_ahead.when_needed()
    arm, setting, hidden = _emulated(source, twin, method, errors, back, seed)
    with counting(f"calibrating {source}", json) as progress:
        found = calibrated(arm, setting, method, poses, progress)
    found.save(target)
    _say(found, setting, hidden, target, json)
    return 0 if found.fit.fits else 1


def _refuse(twin: bool, statics: bool, method: str, poses: int | None, seed: int) -> None:
    from hognose.arguments import whole
    from hognose.errors import InputError

    if twin == statics:
        raise InputError(
            "calibrate: name one of --twin and --statics, which stands for the arm; a real one is calibrated from "
            "Python, with a class that implements hognose.calibration.Arm"
        )
    whole("seed", seed, 0)
    if poses is not None and method == "jig":
        raise InputError("poses: in a jig the arm is read straight, in no other pose; leave --poses out")


def _target(source: str, output: Path | None) -> Path:
    from hognose.cli.console import output_file

    name = Path(source)
    stem = name.stem if name.suffix == ".toml" else name.name
    return output_file(output or Path(f"{stem}-calibration.json"), source, ".json")


def _emulated(
    source: str, twin: bool, method: str, errors: tuple[float, float, float], back: float | None, seed: int
) -> tuple[Arm, Setting, Hidden]:
    """An arm, what it is calibrated with, and how it is."""
    from hognose.calibration import (
        TROUGH,
        Accuracy,
        Hidden,
        Model,
        Prior,
        Sensors,
        Setting,
        StaticArm,
        clear_of,
        start_of,
    )
    from hognose.errors import InputError
    from hognose.files import describes_robot, load_task
    from hognose.mechanics import Mechanics

    alone = describes_robot(source)
    task = _straight_ahead(source) if alone else load_task(source)
    if back is not None and (alone or not task.base.straight):
        why = f"{source} is a robot alone" if alone else f"the base of {source} is not drawn back along a line"
        raise InputError(f"back: {why}; leave --back out")
    mechanics, prior = Mechanics.of(task.robot), Prior()
    accuracy = Accuracy(errors[0], errors[1] / 1e3, errors[2] / 1e3)
    at = start_of(task, (_BACK if back is None else back) / 1e3 if task.base.straight else 0.0)
    gravity = task.gravity(at[None])[0]
    is_free = None if alone or method == "jig" else clear_of(task, Model(mechanics, gravity), prior, at)
    setting = Setting(mechanics, gravity, at, accuracy, prior, is_free=is_free)
    hidden, sensors = Hidden.drawn(mechanics, seed), Sensors(accuracy, seed, method == "tip")
    off = accuracy.jig if method == "jig" else TROUGH
    if not twin:
        return StaticArm(mechanics, gravity, hidden, sensors, off), setting, hidden
    from hognose.sim.arm import TwinArm

    return TwinArm(task, hidden, sensors, off, at), setting, hidden


def _straight_ahead(source: str) -> Task:
    """A task of a robot alone: on a slider along +z, with nothing around it."""
    from hognose.files import load_robot
    from hognose.planning import Task, TaskSpec

    robot = load_robot(source)
    path = {"way_points": [(0.0, 0.0, 0.001), (0.0, 0.0, 0.1)]}
    return Task(TaskSpec.model_validate({"name": robot.name, "robot": robot.name, "path": path}), robot)


def _say(found: Calibration, setting: Setting, hidden: Hidden, target: Path, as_json: bool) -> None:
    from hognose.cli.console import say, say_json

    told = _told(found, setting, hidden)
    if as_json:
        say_json({**told, "file": str(target)})
    else:
        say(_summary(found, setting, told))
        say(f"{target}: zeros, EA and their covariance")


def _told(found: Calibration, setting: Setting, hidden: Hidden) -> dict[str, Any]:
    """The figures, in SI units."""
    import numpy as np

    from hognose.calibration import joint_errors, true_errors

    straight = np.zeros((1, setting.mechanics.robot.sections, 2))
    fit = found.fit
    return {
        "good": bool(fit.fits),
        "robot": found.robot,
        "robot_fingerprint": found.fingerprint,
        "method": found.method,
        "readings": found.readings,
        "chi2": fit.chi2,
        "degrees_of_freedom": fit.degrees,
        "zeros_m": fit.zeros.tolist(),
        "zeros_sigma_m": found.zero_errors.tolist(),
        "stiffness_factors": fit.stiffness.tolist(),
        "stiffness_sigma": found.stiffness_errors.tolist(),
        "tip_sigma_straight_m": float(found.tip_spread(setting.mechanics, straight, setting.gravity)[0]),
        "tip_error_straight_m": float(true_errors(found, setting.mechanics, hidden, straight, setting.gravity)[0]),
        "calibration_deg": np.degrees(joint_errors(found, setting.model)).tolist(),
    }


def _summary(found: Calibration, setting: Setting, told: dict[str, Any]) -> str:
    from hognose.calibration import tolerance_lines

    fit = found.fit
    verdict = "GOOD" if told["good"] else "NOT GOOD: the readings do not fit; is the arm touched, or its file wrong?"
    return "\n".join(
        [
            f"{found.robot}: calibrated by {found.method}, {found.readings} readings",
            f"zeros {1e3 * fit.zeros.min():+.2f} to {1e3 * fit.zeros.max():+.2f} mm, known to "
            f"{1e3 * found.zero_errors.max():.3f} mm (1σ)",
            f"EA {fit.stiffness.min():.3f} to {fit.stiffness.max():.3f} times what the file says, known to "
            f"{100 * found.stiffness_errors.max():.2f} % (1σ)",
            f"tip of the straight arm known to {1e3 * told['tip_sigma_straight_m']:.3f} mm (1σ); of this emulated arm, "
            f"it is off by {1e3 * told['tip_error_straight_m']:.3f} mm",
            f"χ² {fit.chi2:.0f} of {fit.degrees} values",
            verdict,
            "for the robot file, or the task:",
            tolerance_lines(found, setting.model),
        ]
    )
