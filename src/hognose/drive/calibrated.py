"""What the calibration of an arm adds to the counts of its drives."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hognose.calibration import Calibration
from hognose.errors import InputError
from hognose.robot import Robot


def calibrated_by(path: Path, file: str, robot: Robot) -> tuple[int, ...]:
    """What is added to the counts of every cable for the calibration that a network file names."""
    if not file:
        return ()
    try:
        found = Calibration.load(path.parent / file)
        _refuse_another(found, robot)
    except InputError as error:
        raise InputError(f"{path}: drives.calibration: {error}") from None
    if not found.fit.fits:
        raise InputError(
            f"{path}: drives.calibration: {file}: its readings do not fit the arm (χ² "
            f"{found.fit.chi2:.0f} of {found.fit.degrees} values), so its zeros cannot be trusted; calibrate again"
        )
    return calibrated_counts(found, robot)


def _refuse_another(calibration: Calibration, robot: Robot) -> None:
    """Raise an InputError if a calibration is of another robot; EA of each section may be what it found."""
    spec = robot.spec.cables
    if spec is None or not isinstance(spec.axial_stiffness_N, tuple) or calibration.robot != robot.name:
        calibration.refuse_another(robot)
    elif len(calibration.fit.zeros) != robot.cables:
        raise InputError(f"it is of {len(calibration.fit.zeros)} cables, and {robot.name} has {robot.cables}")


def calibrated_counts(calibration: Calibration, robot: Robot) -> tuple[int, ...]:
    """What is added to the counts of every cable for a calibration's zeros.

    A cable that is longer than its motor says is paid out by so much less.
    """
    return tuple(np.rint(-calibration.fit.zeros / robot.travel_per_count).astype(np.int64).tolist())
