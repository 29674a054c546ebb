"""What a calibration comes to in a budget of tolerances: the lines that a robot or task file takes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.calibration import Calibration
from hognose.calibration.model import Model
from hognose.calibration.poses import candidates
from hognose.robot.kinematics import axes_of_joints

Array = NDArray[np.float64]


def joint_errors(calibration: Calibration, model: Model) -> Array:
    """Standard deviations (n,) rad of each joint's angles that cover what is left after a calibration.

    Those of the straight arm, about the worse axis of each joint. A budget takes joints to be independent, which they
    are not: where that would say less than the covariance says of any link's end, straight or in the poses of a
    calibration, all are enlarged alike.
    """
    arm, poses = calibration.applied(model.nominal), candidates(model)
    held = arm.hold(poses, model.gravity)
    turned = model.derived(arm, poses, held.tensions, held.load_factor > 1.0).by_angles
    root = np.linalg.cholesky(calibration.fit.covariance)
    spread = turned @ root  # (T, 2n, p)
    errors = np.sqrt((spread[0] ** 2).sum(axis=1)).reshape(-1, 2).max(axis=1)
    joints, axes, largest = arm.robot.joint_positions(poses), axes_of_joints(poses), 1.0
    for link in range(1, joints.shape[1]):
        arms = joints[:, link, None] - joints[:, :link]
        J = np.cross(axes[:, :link], arms[:, :, None]).reshape(len(poses), -1, 3)
        moved = np.swapaxes(J, 1, 2) @ spread[:, : 2 * link]
        true = np.linalg.eigvalsh(moved @ np.swapaxes(moved, 1, 2))[:, -1]
        said = (errors[:link] ** 2 * (arms**2).sum(axis=2)).sum(axis=1)
        largest = max(largest, float(np.sqrt((true / said).max())))
    return largest * errors


def tolerance_lines(calibration: Calibration, model: Model) -> str:
    """Lines of TOML for the table `[tolerance]` of a robot or a task."""
    degrees = ", ".join(f"{value:.4f}" for value in np.degrees(joint_errors(calibration, model)) + 5e-5)
    return (
        "[tolerance]\n"
        f"calibration_deg = [{degrees}] # 1 σ, of cable zeros and EA together\n"
        "cable_zero = 0.0 # is in calibration_deg already"
    )
