"""What a plan's motion became on the twin."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.cached import read_only
from hognose.planning import Plan
from hognose.robot.base import joints_on
from hognose.robot.tension import AT_LIMIT
from hognose.sim.changes import Changes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Touched:
    """How an obstacle was touched.

    Attributes
    ----------
    first : s
        When it first was.
    largest : N
        The largest force on one link.
    link
        That link, 0-based.
    """

    first: float
    largest: float
    link: int

    def to_json(self) -> dict[str, object]:
        """The figures, in SI units; links count from 1."""
        return {"first_contact_s": self.first, "largest_N": self.largest, "link": self.link + 1}


@dataclass(frozen=True)
class ContactStop:
    """A contact that stopped all motors, and what was left of it when the arm had settled.

    Attributes
    ----------
    time : s
    link
        0-based.
    obstacle
    limit, force : N
        What stopped them, and what it was at that moment.
    peak : N
        The largest afterwards.
    settled : s
        How long the motors held.
    remaining : N
        The largest force on one link at the end.
    tip_error : m
        How far the tip is at the end from where the plan has it at the stop.
    """

    time: float
    link: int
    obstacle: str
    limit: float
    force: float
    peak: float = 0.0
    settled: float = 0.0
    remaining: float = 0.0
    tip_error: float = 0.0

    @property
    def sentence(self) -> str:
        """What happened, without its end."""
        return (
            f"link {self.link + 1} pressed {self.obstacle} with {self.force:.1f} N, more than {self.limit:g} N, at "
            f"{self.time:.2f} s and all motors held; after {self.settled:.2g} s {self.remaining:.1f} N are left, and "
            f"the tip is {1e3 * self.tip_error:.2f} mm off"
        )

    def to_json(self) -> dict[str, object]:
        """The figures, in SI units; links count from 1."""
        return {
            "time_s": self.time,
            "link": self.link + 1,
            "obstacle": self.obstacle,
            "limit_N": self.limit,
            "force_N": self.force,
            "peak_N": self.peak,
            "settled_s": self.settled,
            "remaining_N": self.remaining,
            "tip_error_m": self.tip_error,
        }


@dataclass(frozen=True, eq=False)
class Simulated:
    """What a plan's motion became: arrays of P rows, one a control period, the start first.

    There are fewer than the plan has if it was stopped, and some for the time in which motors held after a contact.

    Attributes
    ----------
    plan, changes
    time : (P,) s
    commanded : (P, n, 2) rad
        The plan's angles at these times, or when the motors were stopped.
    at : (P, k)
        The plan's coordinates of the base, likewise.
    section_lengths : (P, n) m
        How long sections are held, which changes where they extend.
    angles : (P, n, 2) rad
    joints : (P, n+1, 3) m
        Joints and tip in the frame of the task.
    tensions, lowest_tensions, highest_tensions : (P, c) N
        At the motors: at that time, and the smallest and the largest since the row before.
    end_tensions : (P, c) N
        Where the cables are fixed.
    smallest_stiffness : (P,) N m/rad
        Of the arm as it was; below 0 it buckles.
    load_factor : (P,)
        Of buckling; infinite where no load would do it.
    contact : (P, n) N
        Largest force on every link within the period.
    pressing : (P, n) of text
        The obstacle that pressed it most.
    touches
        How obstacles were touched, by name, in order.
    stopped
        Why it was stopped before the end; empty if it was not.
    contact_stop
        If a contact stopped the motors.
    seconds : s
        How long it took to compute.
    """

    plan: Plan
    changes: Changes
    time: Array
    commanded: Array
    at: Array
    section_lengths: Array
    angles: Array
    joints: Array
    tensions: Array
    lowest_tensions: Array
    highest_tensions: Array
    end_tensions: Array
    smallest_stiffness: Array
    load_factor: Array
    contact: Array
    pressing: NDArray[Any]
    touches: Mapping[str, Touched]
    stopped: str
    contact_stop: ContactStop | None
    seconds: float

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, field.name, read_only(value))

    @property
    def touched(self) -> tuple[str, ...]:
        """Obstacles that were touched, in order."""
        return tuple(self.touches)

    @property
    def good(self) -> bool:
        """Whether it came to the end, touched nothing, and no cable went slack or was pulled too much.

        And whether no check of the plan itself had failed.
        """
        return not (self.stopped or self.touches or self.slack.any() or self.overloaded.any() or self.plan_failed)

    @property
    def plan_failed(self) -> list[str]:
        """Checks of the plan itself that failed, in sentences."""
        return [check.sentence for check in self.plan.checks if check.failed]

    @property
    def verdict(self) -> str:
        """Whether it is good, and why not, in a line."""
        whys = [self.stopped] if self.stopped else ["contact"] if self.touches else []
        if self.slack.any():
            whys.append(self.slackest)
        if self.overloaded.any():
            whys.append(f"cables pulled with up to {self.highest_tensions.max():.4g} N, above tension_max_N")
        if self.plan_failed:
            whys.append("the plan itself")
        return f"{'GOOD' if self.good else 'NOT GOOD'}: {'; '.join(whys) or 'to the end'}"

    @property
    def slackest(self) -> str:
        """How many cables were slack at most, in words."""
        most = int(self.slack.max())
        return f"up to {most} {'cable' if most == 1 else 'cables'} slack"

    @property
    def assumed(self) -> list[str]:
        """Keys of the robot file that the twin rests on and nobody measured."""
        of_the_twin, of_motors = ("cables", "section", "tool_mass"), "section.transmission"
        keys = self.plan.robot.assumed
        return [key for key in keys if key.split(".")[0] in of_the_twin and not key.startswith(of_motors)]

    @property
    def tips(self) -> Array:
        """Where the plan has the tip: (P, 3) m."""
        base, robot = self.plan.task.base, self.plan.robot
        return joints_on(base, robot, self.commanded, self.at, self.section_lengths)[:, -1]

    @property
    def tip_errors(self) -> Array:
        """Distance (P,) m of the tip from where it is planned."""
        return np.linalg.norm(self.joints[:, -1] - self.tips, axis=1)

    @property
    def slack(self) -> NDArray[np.int64]:
        """How many cables were slack within the period: (P,)."""
        return np.count_nonzero(self.lowest_tensions <= 0, axis=1)

    @property
    def overloaded(self) -> NDArray[np.int64]:
        """How many cables were pulled within the period with more than the robot allows: (P,)."""
        mechanics = self.plan.task.mechanics
        assert mechanics is not None, "it was simulated"
        return np.count_nonzero(self.highest_tensions > AT_LIMIT * mechanics.tension_max, axis=1)

    @property
    def factor(self) -> float:
        """How many times as fast as the real arm it was."""
        return float(self.time[-1] / max(self.seconds, 1e-9))

    @property
    def first_contact(self) -> float | None:
        """When anything was first touched (s), or None."""
        return min((each.first for each in self.touches.values()), default=None)

    def to_json(self) -> dict[str, object]:
        """The figures, in SI units."""
        off = self.angles - self.commanded
        lasting = float(self.load_factor.min())
        return {
            "periods": len(self.angles),
            "duration_s": float(self.time[-1]),
            "stopped": self.stopped or None,
            "tip_rms_m": float(np.sqrt(np.mean(self.tip_errors**2))),
            "tip_max_m": float(self.tip_errors.max()),
            "joint_rms_rad": float(np.sqrt(np.mean(off**2))),
            "smallest_tension_N": float(self.lowest_tensions.min()),
            "largest_tension_N": float(self.highest_tensions.max()),
            "slack_cables": int(self.slack.max()),
            "overloaded_cables": int(self.overloaded.max()),
            "smallest_stiffness_Nm_rad": float(self.smallest_stiffness.min()),
            "buckling_load_factor": lasting if np.isfinite(lasting) else None,
            "largest_contact_N": float(self.contact.max()),
            "first_contact_s": self.first_contact,
            "touched": list(self.touched),
            "contacts": {name: each.to_json() for name, each in self.touches.items()},
            "contact_stop": None if self.contact_stop is None else self.contact_stop.to_json(),
            "plan_failed": self.plan_failed,
            "assumed": self.assumed,
            "real_time_factor": self.factor,
        }
