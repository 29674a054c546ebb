"""An arm whose truth is hidden, calibrated as a real one is: what its plans and its drives take from that."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.calibration import (
    Accuracy,
    Calibration,
    Hidden,
    Prior,
    Sensors,
    Setting,
    calibrate,
    start_of,
    true_errors,
    with_stiffness,
)
from hognose.drive.calibrated import calibrated_counts
from hognose.drive.network import Network, emulated_network
from hognose.mechanics import Mechanics
from hognose.planning import Plan, Task
from hognose.sim import Twin
from hognose.sim.arm import TwinArm, twin_of

Array = NDArray[np.float64]

#: How far (m) the base stands before the start of its task while the arm is in its jig.
_BACK = 0.1


@dataclass(frozen=True, eq=False)
class CalibratedArm:
    """An emulated arm, and what its calibration in a jig has found.

    Attributes
    ----------
    hidden
        How it is.
    calibration
        What was found.
    """

    hidden: Hidden
    calibration: Calibration

    @classmethod
    def drawn(
        cls, task: Task, seed: int = 0, progress: Callable[[int, int], None] = lambda done, total: None
    ) -> CalibratedArm:
        """Draw the truth of a task's arm, and calibrate its twin, clamped in a jig before the entrance.

        Raises
        ------
        InputError
            The mechanics of the robot are not known, or the seed is none.
        InfeasibleError
            The arm cannot be pretensioned.
        MissingExtraError
            MuJoCo is not installed.
        """
        mechanics, accuracy = Mechanics.of(task.robot), Accuracy()
        at = start_of(task, _BACK if task.base.straight else 0.0)
        hidden = Hidden.drawn(mechanics, seed)
        setting = Setting(mechanics, task.gravity(at[None])[0], at, accuracy, Prior())
        arm = TwinArm(task, hidden, Sensors(accuracy, seed, sees_tip=False), accuracy.jig, at)
        return cls(hidden, calibrate(arm, setting, "jig", progress=progress))

    def task(self, nominal: Task) -> Task:
        """A task with the stiffness that was found: what it is planned with."""
        self.calibration.refuse_another(nominal.robot)
        return with_stiffness(nominal, self.calibration.fit.stiffness)

    def network(self, plan: Plan) -> Network:
        """Emulated drives of its plans, with the zeros that were found."""
        made = emulated_network(plan.robot)
        return replace(made, calibrated=calibrated_counts(self.calibration, plan.robot))

    def twin(self, nominal: Task) -> Twin:
        """Its twin, as it is."""
        return twin_of(nominal, self.hidden)

    @property
    def uncalibrated(self) -> CalibratedArm:
        """The same arm, of which nothing was found."""
        fit = self.calibration.fit
        nothing = replace(fit, zeros=np.zeros_like(fit.zeros), stiffness=np.ones_like(fit.stiffness))
        return replace(self, calibration=replace(self.calibration, fit=nothing))

    def errors(self, nominal: Task, plan: Plan) -> Array:
        """How far (T,) m its tip would be off along a plan, by statics, commanded with what was found."""
        mechanics, gravity = Mechanics.of(nominal.robot), plan.task.gravity(plan.at)
        return true_errors(self.calibration, mechanics, self.hidden, plan.angles, gravity)

    @property
    def words(self) -> str:
        """How well it is known, in a line."""
        told = self.to_json()
        return (
            f"calibrated in a jig: zeros within {1e3 * told['largest_zero_error_m']:.3f} mm, "
            f"stiffness within {100 * told['largest_stiffness_error']:.2f} % of what is hidden"
        )

    def to_json(self) -> dict[str, Any]:
        """What was hidden, and what was found, in SI units."""
        fit = self.calibration.fit
        return {
            "method": self.calibration.method,
            "readings": self.calibration.readings,
            "fits": bool(fit.fits),
            "chi2": fit.chi2,
            "degrees_of_freedom": fit.degrees,
            "hidden_zeros_m": self.hidden.zeros.tolist(),
            "found_zeros_m": fit.zeros.tolist(),
            "largest_zero_error_m": float(np.abs(fit.zeros - self.hidden.zeros).max()),
            "hidden_stiffness_factors": self.hidden.stiffness.tolist(),
            "found_stiffness_factors": fit.stiffness.tolist(),
            "largest_stiffness_error": float(np.abs(fit.stiffness / self.hidden.stiffness - 1.0).max()),
        }
