"""Before it is used, an arm is pretensioned and calibrated: zeros and stiffness of its cables, and how well known."""

from hognose.calibration.arm import Accuracy, Arm, Reading, read
from hognose.calibration.budget import joint_errors, tolerance_lines
from hognose.calibration.calibrate import POSES, Setting, calibrate
from hognose.calibration.calibration import METHODS, Calibration
from hognose.calibration.clear import clear_of, start_of
from hognose.calibration.emulated import TROUGH, Hidden, Sensors, StaticArm, true_errors
from hognose.calibration.fit import Fit, Prior, fit
from hognose.calibration.model import Model
from hognose.calibration.pretension import Pretensioned, pretension
from hognose.calibration.stiffened import with_stiffness

__all__ = [
    "METHODS",
    "POSES",
    "TROUGH",
    "Accuracy",
    "Arm",
    "Calibration",
    "Fit",
    "Hidden",
    "Model",
    "Pretensioned",
    "Prior",
    "Reading",
    "Sensors",
    "Setting",
    "StaticArm",
    "calibrate",
    "clear_of",
    "fit",
    "joint_errors",
    "pretension",
    "read",
    "start_of",
    "tolerance_lines",
    "true_errors",
    "with_stiffness",
]
