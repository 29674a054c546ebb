"""What is measured of one method on one case."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.evaluation import section_measure
from hognose.evaluation.case import Case
from hognose.evaluation.reference import off_first_crossing
from hognose.evaluation.subjects import follower_for
from hognose.evaluation.timing import affordable_steps, step_times
from hognose.extensions import words_of
from hognose.following import Follower, body_deviation
from hognose.robot.kinematics import angles_of, positions_of

Array = NDArray[np.float64]

#: Slack of the bend limit, rad, and of the link lengths, m.
_BEND_SLACK, _LENGTH_SLACK = 1e-9, 1e-9
#: Most link positions whose deviation is measured: more are thinned out, evenly over the steps.
_MOST_LINKS = 4_100


@dataclass(frozen=True)
class Row:
    """Figures of one method on one case; lengths in mm, times in µs a step; None is not measured.

    `time_us` is the mean of a whole motion in one call; median, 95th percentile and worst are of blocks
    of at most `block` steps.

    The body's mean is that of the largest deviations of the links, of other sections of places all along the body; over
    all steps, and at the last, when the arm is wholly in.

    `steps` of the `all_steps` feeds were followed, the last ones; `why` says what was not solved or not valid.
    `allowance_mm` is how far a joint may be from where it belongs and still count as on the first crossing.
    The series, one figure a step, are kept for the two cases only.
    """

    method: str
    family: str
    case: str
    links: int
    spacing_mm: float
    path_m: float
    arm_m: float
    steps: int
    all_steps: int
    solved: bool
    valid: bool
    why: str
    on_path: bool = True
    block: int | None = None
    time_us: float | None = None
    median_us: float | None = None
    p95_us: float | None = None
    worst_us: float | None = None
    evaluations: float | None = None
    tip_rmse_mm: float | None = None
    tip_variance_mm2: float | None = None
    tip_max_mm: float | None = None
    body_max_mm: float | None = None
    body_rms_mm: float | None = None
    body_mean_mm: float | None = None
    body_in_mm: float | None = None
    link_error_mm: float | None = None
    bend_max_rad: float | None = None
    allowance_mm: float | None = None
    tip_series_mm: tuple[float, ...] = ()
    body_series_mm: tuple[float, ...] = ()
    time_series_us: tuple[float, ...] = ()


@dataclass(frozen=True)
class TipError:
    """Distances (T,) m of the tip, by forward kinematics, from where it should be."""

    series: Array

    @property
    def rmse(self) -> float:
        """Root mean square, m."""
        return float(np.sqrt(np.mean(self.series**2)))

    @property
    def variance(self) -> float:
        """The paper's VVE, m²."""
        return float(np.var(self.series))


def measured(label: str, case: Case, budget: float, patience: float) -> Row:
    """Follow a case with a method and measure it; what fails is a row too.

    Parameters
    ----------
    label
        One of `hognose.evaluation.subjects.subjects_of`.
    budget : float, s
        For timing: a fast method is followed again and again for so long.
    patience : float, s
        With a slow method: if following all feeds thrice takes longer, only the last ones are followed.
    """
    steps = len(case.feeds)
    row = Row(
        method=label,
        family=case.family,
        case=case.name,
        links=len(case.link_lengths),
        spacing_mm=1e3 * case.spacing,
        path_m=case.path.length,
        arm_m=float(case.link_lengths.sum()),
        steps=steps,
        all_steps=steps,
        solved=False,
        valid=False,
        why="",
    )
    try:
        return _measured(row, label, case, budget, patience)
    except InfeasibleError as error:
        return replace(row, why=str(error))
    except Exception as error:  # whatever a method under development does is a result, not the end of the suite
        return replace(row, why=words_of(error))


def _measured(row: Row, label: str, case: Case, budget: float, patience: float) -> Row:
    steps = affordable_steps(label, case, patience)
    feeds = case.feeds[-steps:]
    follower = follower_for(label, case, float(feeds[0]))
    joints = follower.run(feeds)
    if not np.isfinite(joints).all():
        return replace(row, steps=steps, why="positions that are not finite")
    times = step_times(label, case, feeds, budget)
    judge = objections if case.model is None else section_measure.objections
    why, allowance = judge(case, follower, joints, feeds)
    row = replace(
        row,
        steps=steps,
        solved=True,
        valid=not why,
        why=why,
        on_path=follower.keeps_to_path,
        block=int(times.sizes.max()),
        time_us=1e6 * times.whole,
        median_us=1e6 * float(np.median(times.blocks)),
        p95_us=1e6 * float(np.percentile(times.blocks, 95)),
        worst_us=1e6 * float(times.blocks.max()),
        evaluations=follower.evaluations / steps,
        allowance_mm=1e3 * allowance,
        time_series_us=tuple(1e6 * times.steps) if case.family == "cases" else (),
    )
    return replace(row, **accuracy(case, joints, feeds))


def tip_error(case: Case, joints: Array, feeds: Array) -> TipError:
    """The tip's error as the paper takes it: joint angles, forward kinematics, distance from where it should be."""
    base = case.path.point(feeds)
    reached, _ = positions_of(angles_of(joints), np.zeros(len(feeds)), case.link_lengths)
    return TipError(np.linalg.norm(reached[:, -1] + base - case.reference[0][-len(feeds) :, -1], axis=1))


def accuracy(case: Case, joints: Array, feeds: Array) -> dict[str, Any]:
    """The accuracy figures of a row, by their names there, of joints (T, n+1, 3) m at a case's last T feeds."""
    every = max(1, math.ceil(joints.shape[0] * joints.shape[1] / _MOST_LINKS))
    if case.model is not None:
        series, body, off, bend = section_measure.errors(case, joints, feeds)
        tip = TipError(series)
    else:
        tip, body = tip_error(case, joints, feeds), body_deviation(case.path, joints[::-1][::every])[::-1]
        off, bend = link_error(joints, case.link_lengths), float(np.abs(angles_of(joints)).max())
    keeps_series = case.family == "cases"
    return {
        "tip_rmse_mm": 1e3 * tip.rmse,
        "tip_variance_mm2": 1e6 * tip.variance,
        "tip_max_mm": 1e3 * float(tip.series.max()),
        "body_max_mm": 1e3 * float(body.max()),
        "body_rms_mm": 1e3 * float(np.sqrt(np.mean(body**2))),
        "body_mean_mm": 1e3 * float(np.mean(body)),
        "body_in_mm": 1e3 * float(np.mean(body[-1])),
        "link_error_mm": 1e3 * off,
        "bend_max_rad": bend,
        "tip_series_mm": tuple(map(float, 1e3 * tip.series)) if keeps_series else (),
        "body_series_mm": tuple(map(float, 1e3 * body.max(axis=1))) if keeps_series else (),
    }


def link_error(joints: Array, lengths: Array) -> float:
    """The largest difference (m) between the distance of two joints and their link's length."""
    return float(np.abs(np.linalg.norm(np.diff(joints, axis=1), axis=2) - lengths).max())


def objections(case: Case, follower: Follower, joints: Array, feeds: Array) -> tuple[str, float]:
    """What makes joints not valid, empty if nothing does, and how far (m) they may be from where they belong.

    Joints that keep to the path belong on the first crossing from the joint before them. Both may be off by the
    method's tolerance, and the path may lie askew to the link, so thrice the tolerance is allowed. Joints that leave
    the path may be up to half a link from those of the reference; on another crossing they would be further off.
    """
    found = []
    off, allowed = link_error(joints, case.link_lengths), max(follower.tolerance, _LENGTH_SLACK)
    if off > allowed:
        found.append(f"a link is off by {1e3 * off:.3g} mm, more than {1e3 * allowed:.3g} mm")
    bend = float(np.abs(angles_of(joints)).max())
    if bend > case.bend_limit + _BEND_SLACK:
        found.append(f"a joint bends by {bend:.4f} rad, its limit is {case.bend_limit:g} rad")
    if follower.keeps_to_path:
        allowance = 3.0 * allowed
        away = float(off_first_crossing(case.path, case.link_lengths, feeds, joints).max())
    else:
        allowance = 0.5 * float(case.link_lengths.min())
        away = float(np.linalg.norm(joints - case.reference[0][-len(feeds) :], axis=2).max())
    if away > allowance:
        found.append(f"a joint is {1e3 * away:.3g} mm from where it belongs, more than {1e3 * allowance:.3g} mm")
    return "; ".join(found), allowance
