"""Set-points of the fastest motion: a control period apart, at feeds of their own."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.following import Follower
from hognose.following.on_base import run_on
from hognose.planning.base_limits import BaseLimits
from hognose.planning.followed import followed_on_base
from hognose.planning.motion_spec import LONGEST_MOTION
from hognose.planning.profile.between import overruns, overruns_in_space
from hognose.planning.profile.feed_profile import FeedProfile
from hognose.planning.profile.limits import FeedLimits
from hognose.planning.profile.moved import Moved
from hognose.planning.task import Task
from hognose.planning.timing import SetPoints
from hognose.robot.base import angles_on, lengths_on, turns
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: Limits are looked at in so many places along the shortest link, and in so many along the whole way at least and most.
_ALONG_LINK, _FEWEST, _MOST = 50, 200, 4000
#: The parts of the limits of speed and acceleration that are used at first, as derivatives are differences; and those
#: where acceleration builds up in so few periods that cubics between the set-points overshoot.
_USED, _USED_OF_COARSE, _FEW_PERIODS = (0.9995, 0.995), (0.998, 0.96), 3
#: By how much more each time limits are lowered because set-points, or the cubics between them, exceed them: set-points
#: fall elsewhere then, and may exceed them again.
_FURTHER = (1.0005, 1.001, 1.002, 1.004, 1.008, 1.016)


class Fastest:
    """The fastest motion of a task along a curve, from rest at feed 0 to rest where the tip is on the target.

    Parameters
    ----------
    task
    method
        The task's following method on the path.
    length
        Feed (m) at which the tip is on the target.

    Raises
    ------
    InfeasibleError
        The joints cannot be followed along the curve.
    """

    def __init__(self, task: Task, method: Follower, length: float) -> None:
        self.task, self.method, self.length = task, method, length
        shortest = float(task.robot.link_lengths.min())
        count = min(max(math.ceil(_ALONG_LINK * length / shortest), _FEWEST), _MOST)
        self._feeds = np.linspace(0.0, length, count + 1)
        # Methods that look joints up among points make them jump a little; exact following of their curve does not.
        # None does so with sections of other kinds than links.
        if isinstance(task.robot.model, MixedSections):
            joints, at = run_on(task.base, method, self._feeds)
        else:
            joints, at = followed_on_base(task, method.curve, self._feeds, "exact")
        said = task.robot.spec.limits
        angles, sections, cables = self._actuated(joints, at)
        if said.cable_acceleration is not None:  # stretch changes slowly, but abruptly where cables come to a limit
            cables = task.commanded_lengths(angles, at, sections)
        hardest_turn = math.radians(said.joint_acceleration_deg_s2)
        self._moved = (
            *Moved.by_the_base(task, self._feeds, joints, at),
            Moved.along(self._feeds, angles, math.radians(said.joint_speed_deg_s), hardest_turn),
            Moved.along(self._feeds, cables, said.cable_speed, said.cable_acceleration),
        )

    def profile(self, of_speed: float, of_change: float) -> FeedProfile:
        """The fastest profile within so much of all limits of speed, and so much of all of acceleration."""
        limits = FeedLimits.of(self._feeds, self._moved, of_speed, of_change)
        return FeedProfile.within(limits, self.task.spec.motion.smoothing_time)

    def set_points(self, most: int) -> SetPoints:
        """Set-points a period apart that keep all limits themselves, and so do cubics between them.

        Where a following method lets joints jump, no feed is slow enough, and the checks of the plan say so.

        Parameters
        ----------
        most
            Number of set-points that a plan may have.

        Raises
        ------
        InputError
            There would be more, or the motion would take too long.
        """
        motion = self.task.spec.motion
        used = np.array(_USED if motion.smoothing_time >= _FEW_PERIODS * motion.period_s else _USED_OF_COARSE)
        best = (math.inf, SetPoints(np.empty(0), np.empty(0)))
        for further in _FURTHER:
            points = self._at_periods(self.profile(*used.tolist()), most)
            parts = np.array(self._overruns(points))
            best = min(best, (float(parts.max()), points), key=lambda each: each[0])
            if best[0] <= 1:
                break
            used /= np.where(parts > 1, parts * further, 1.0)
        return best[1]

    def _at_periods(self, profile: FeedProfile, most: int) -> SetPoints:
        """A whole number of periods, so that the profile is run through a little more slowly than it could be."""
        period = self.task.spec.motion.period_s
        duration = profile.duration
        if not (duration <= LONGEST_MOTION and duration / period <= most):
            where = "in the robot file and in [base]" if self.task.base.follows else "in the robot file"
            raise InputError(
                f"motion.profile: the fastest motion within the robot's limits takes {duration:.3g} s, which is "
                f"{duration / period:,.3g} control periods of {period:g} s; expected at most {LONGEST_MOTION:,.0f} s "
                f"and {most:,} periods. Are the limits of speed and acceleration {where} right? If they are, take a "
                "longer motion.period_s"
            )
        count = max(1, math.ceil(duration / period * (1 - 1e-12)))
        rows = np.arange(count + 1, dtype=np.float64)
        feed = np.maximum.accumulate(np.clip(profile.at(rows * (duration / count)), 0.0, self.length))
        feed[0], feed[-1] = 0.0, self.length
        return SetPoints(feed, period * rows)

    def _overruns(self, points: SetPoints) -> tuple[float, float]:
        """The largest parts of limits of speed and of acceleration that set-points and cubics between them use."""
        said, period = self.task.robot.spec.limits, self.task.spec.motion.period_s
        base = BaseLimits.of(self.task)
        found = [overruns(points.feed[:, None], period, base.speed, base.acceleration)]
        if max(found[0]) > 1:
            return found[0]
        joints, at = followed_on_base(self.task, self.method.path, points.feed)
        angles, sections, cables = self._actuated(joints, at)
        speed, acceleration = math.radians(said.joint_speed_deg_s), math.radians(said.joint_acceleration_deg_s2)
        found.append(overruns(angles.reshape(len(angles), -1), period, speed, acceleration))
        if max(max(parts) for parts in found) <= 1:  # else they are only about to be lowered
            cables = self.task.commanded_lengths(angles, at, sections)
        found.append(overruns(cables, period, said.cable_speed, said.cable_acceleration or math.inf))
        if self.task.base.follows:
            turned = np.concatenate([np.zeros((1, 3)), np.cumsum(turns(self.task.base, at), axis=0)])
            found.append(overruns_in_space(joints[:, 0], period, base.speed, base.acceleration))
            found.append(overruns_in_space(turned, period, base.turn_speed, base.turn_acceleration))
        return max(part for part, _ in found), max(part for _, part in found)

    def _actuated(self, joints: Array, at: Array) -> tuple[Array, Array, Array]:
        """Angles (T, n, 2) rad, section lengths (T, n) m and cable lengths (T, c) m."""
        base, robot = self.task.base, self.task.robot
        angles, sections = angles_on(base, robot, joints, at), lengths_on(base, robot, joints, at)
        return angles, sections, robot.cable_lengths(angles, sections)
