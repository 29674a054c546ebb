"""The twin as an arm that can be calibrated: motors, sensors, and a hidden truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.calibration import TROUGH, Hidden, Sensors, start_of, with_stiffness
from hognose.calibration.emulated import held_pose, held_tensions
from hognose.errors import InfeasibleError
from hognose.mechanics import Mechanics
from hognose.planning import Task
from hognose.sim.twin import Changes, Twin

Array = NDArray[np.float64]

#: The arm is at rest when no angle varies by more than this (rad) within a time (s); it is waited so often at most. A
#: swing that small moves tensions by 0.02 N.
_AT_REST, _WAITED, _MOST_WAITS = 1e-6, 0.5, 120
#: Steps between two looks at the angles.
_LOOK = 10


def twin_of(task: Task, hidden: Hidden) -> Twin:
    """The twin of a task's arm as it is, with a hidden truth; raises as `TwinArm`."""
    return Twin(with_stiffness(task, hidden.stiffness), Changes(cable_zeros=hidden.zeros))


class TwinArm:
    """A twin whose motors and sensors are what a calibration has of an arm; it implements `hognose.calibration.Arm`.

    Attributes
    ----------
    twin
        With its hidden truth.
    clamped
        Whether it is held straight.
    """

    twin: Twin
    clamped: bool

    def __init__(
        self, task: Task, hidden: Hidden, sensors: Sensors, off: float | None = TROUGH, at: Array | None = None
    ) -> None:
        """A twin that is straight, with its motors where a nominal arm's are, and its base at (k,).

        The base is where the task begins unless it is given. The arm is held on a
        straight line but for a standard deviation `off` (m) of every joint; None for one that hangs.

        Raises
        ------
        InputError
            The mechanics of the robot are not known, or the hidden truth is another robot's.
        MissingExtraError
            MuJoCo is not installed.
        """
        nominal = Mechanics.of(task.robot)
        self.twin = twin_of(task, hidden)
        self._hidden, self._sensors, self._task = hidden, sensors, task
        self._at = start_of(task) if at is None else at
        self.clamped, self._angles = off is not None, held_pose(nominal, hidden, off or 0.0)
        gravity = task.gravity(self._at[None])
        self._motors = nominal.hold(np.zeros((1, task.robot.sections, 2)), gravity).commanded_lengths[0]
        self.twin.put(self._at, self._angles)
        self.twin.shorten_step()

    def release(self) -> None:
        """See `Arm.release`."""
        if self.clamped:
            self.twin.put(self._at, self._angles)
        self.clamped = False

    def command(self, lengths: Array, at: Array, pace: float) -> None:
        """See `Arm.command`.

        Raises
        ------
        InfeasibleError
            The arm touches something.
        """
        begin, final = (self._motors, self._at), (np.array(lengths), np.array(at, np.float64))
        if not self.clamped:
            duration = max(float(np.abs(final[0] - begin[0]).max()) / pace, self.twin.time_step)
            count = max(1, round(duration / self.twin.time_step))
            speeds = [(b - a) / (count * self.twin.time_step) for a, b in zip(begin, final, strict=True)]
            for k in range(1, count + 1):
                where = [a + k / count * (b - a) for a, b in zip(begin, final, strict=True)]
                base = self._task.base.settled(where[1][None])[0]
                self.twin.step(where[0], speeds[0], base, speeds[1])
                self._refuse_contact()
        self._motors, self._at = final

    def settle(self) -> None:
        """See `Arm.settle`.

        Raises
        ------
        InfeasibleError
            It does not come to rest, or touches something.
        """
        if self.clamped:
            return
        still = np.zeros_like(self._motors), np.zeros_like(self._at)
        for _ in range(_MOST_WAITS):
            seen = []
            for step in range(round(_WAITED / self.twin.time_step)):
                self.twin.step(self._motors, still[0], self._at, still[1])
                self._refuse_contact()
                if step % _LOOK == 0:
                    seen.append(self.twin.angles)
            if np.ptp(seen, axis=0).max() < _AT_REST:
                return
        raise InfeasibleError(
            f"calibration: after {_WAITED * _MOST_WAITS:g} s the arm still moves; does it buckle, or is its "
            "pretension low?"
        )

    def tensions(self) -> Array:
        """See `Arm.tensions`."""
        if self.clamped:
            true = held_tensions(self.twin.mechanics, self._angles, self._motors + self._hidden.zeros)
        else:
            true = self.twin.tensions
        return self._sensors.tensions(true)

    def motors(self) -> Array:
        """See `Arm.motors`."""
        return self._motors.copy()

    def tip(self) -> Array | None:
        """See `Arm.tip`."""
        if self.clamped:
            return self._sensors.tip(self._task.robot.joint_positions(self._angles)[-1])
        joints = self.twin.joints
        return self._sensors.tip(self._task.base.aligned((joints[-1] - joints[0])[None], self._at[None])[0])

    def _refuse_contact(self) -> None:
        if self.twin.touches:
            touch, force = self.twin.touches[0]
            raise InfeasibleError(
                f"calibration: link {touch.link + 1} touches {touch.obstacle} with {force:.3g} N; move the base back "
                "before the arm is calibrated"
            )
