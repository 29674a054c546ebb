"""A plan on the twin: what the arm does that the plan wants moved."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning import Plan
from hognose.robot.base import joints_on
from hognose.sim.twin import Changes, Twin

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Simulated:
    """What a plan's motion became: arrays of P periods, the start first; fewer than the plan's if it was stopped.

    Attributes
    ----------
    plan
    angles : (P, n, 2) rad
    joints : (P, n+1, 3) m
        Joints and tip in the frame of the task.
    tensions : (P, c) N
    smallest_stiffness : (P,) N m/rad
        Of the arm as it was; below 0 it buckles.
    contact : (P, n) N
        Largest force on every link within the period.
    touched
        Obstacles that were touched, in order.
    stopped
        Why it was stopped before the end; empty if it was not.
    seconds : s
        How long it took to compute.
    """

    plan: Plan
    angles: Array
    joints: Array
    tensions: Array
    smallest_stiffness: Array
    contact: Array
    touched: tuple[str, ...]
    stopped: str
    seconds: float

    @property
    def remarks(self) -> list[str]:
        """What the twin leaves out, in sentences."""
        moving = [each.name for each in self.plan.task.moving]
        return [f"obstacles that move ({', '.join(moving)}) are not there for the twin"] if moving else []

    @property
    def tip_errors(self) -> Array:
        """Distance (P,) m of the tip from where it is planned."""
        plan = self.plan
        wanted = joints_on(plan.task.base, plan.robot, plan.angles, plan.at)[: len(self.joints), -1]
        return np.linalg.norm(self.joints[:, -1] - wanted, axis=1)

    def to_json(self) -> dict[str, object]:
        """The figures, in SI units."""
        off = self.angles - self.plan.angles[: len(self.angles)]
        return {
            "periods": len(self.angles),
            "stopped": self.stopped or None,
            "tip_rms_m": float(np.sqrt(np.mean(self.tip_errors**2))),
            "tip_max_m": float(self.tip_errors.max()),
            "joint_rms_rad": float(np.sqrt(np.mean(off**2))),
            "smallest_tension_N": float(self.tensions.min()),
            "largest_tension_N": float(self.tensions.max()),
            "smallest_stiffness_Nm_rad": float(self.smallest_stiffness.min()),
            "largest_contact_N": float(self.contact.max()),
            "touched": list(self.touched),
            "remarks": self.remarks,
            "real_time_factor": float(self.plan.time[len(self.angles) - 1] / max(self.seconds, 1e-9)),
        }


def simulate(
    plan: Plan, changes: Changes | None = None, progress: Callable[[int, int], None] = lambda done, total: None
) -> Simulated:
    """Move the twin through a plan, with set-points interpolated within the periods.

    It begins at rest at the first step. It is stopped when an axis crosses a surface, or when the arm buckles.

    Parameters
    ----------
    plan
    changes
        How arm and space differ from what was planned with.
    progress
        Called with the periods that are done, and how many there are.

    Raises
    ------
    InputError
        The mechanics of the robot are not known, or the time step is too long for the stiffness.
    MissingExtraError
        MuJoCo is not installed.
    """
    twin = Twin(plan.task, changes)
    twin.put(plan.at[0], plan.angles[0])
    twin.refuse_long_steps()
    begun, rows, touched, stopped = time.perf_counter(), [_row(twin, np.zeros(plan.robot.sections))], [], ""
    lengths, at, last = plan.commanded_lengths, plan.at, len(plan.time) - 1
    for period in range(1, last + 1):
        duration = float(plan.time[period] - plan.time[period - 1])
        count = max(1, round(duration / twin.time_step))
        speeds, moved = (np.diff(x[period - 1 : period + 1], axis=0)[0] / duration for x in (lengths, at))
        shares = (np.arange(1, count + 1) / count)[:, None]
        wanted = lengths[period - 1] + shares * (lengths[period] - lengths[period - 1])
        bases = plan.task.base.settled(at[period - 1] + shares * (at[period] - at[period - 1]))
        pressed = np.zeros(plan.robot.sections)
        for k in range(count):
            twin.step(wanted[k], speeds, bases[k], moved)
            for touch, force in twin.touches:
                pressed[touch.link] = max(pressed[touch.link], force)
                if touch.obstacle not in touched:
                    touched.append(touch.obstacle)
            if twin.crossed:
                break
        rows.append(_row(twin, pressed))
        stopped = _why_stopped(twin, rows[-1], period)
        progress(period, last)
        if stopped:
            break
    angles, joints, tensions, stiff, contact = (np.array(column) for column in zip(*rows, strict=True))
    took = time.perf_counter() - begun
    return Simulated(plan, angles, joints, tensions, stiff, contact, tuple(touched), stopped, took)


def _row(twin: Twin, pressed: Array) -> tuple[Array, Array, Array, float, Array]:
    return twin.angles, twin.joints, twin.tensions, twin.smallest_stiffness(), pressed


def _why_stopped(twin: Twin, row: tuple[Array, Array, Array, float, Array], period: int) -> str:
    if twin.crossed:
        link, obstacle = twin.crossed
        return f"period {period}: the axis of link {link + 1} has crossed the surface of {obstacle}"
    if row[3] < 0:
        return (
            f"period {period}: the arm buckles: the smallest eigenvalue of its stiffness is {row[3]:.3g} N m/rad; take "
            "less pretension, or stiffer cables"
        )
    return ""
