"""A run of the twin over time: how far it was from its plan and from the path, and how its cables pulled."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hognose.planning import Plan
from hognose.report.mechanics import draw_tensions
from hognose.report.style import BAD, INK, LINKS, PATH, SMALL, dress, new_figure
from hognose.robot.base import joints_on
from hognose.sim import Simulated

#: Less (mm) is drawn as this: rounding, and the rest before the start.
_LEAST = 1e-4


def run_over_time(done: Simulated, motion: Plan) -> Figure:
    """Return errors of tip and body, and tensions, one above the other.

    Parameters
    ----------
    done
    motion
        What it reached.
    """
    figure = new_figure(7.2, 5.6)
    _errors(dress(figure.add_axes((0.09, 0.56, 0.88, 0.38)), "", "Off by (mm)"), done, motion)
    _tensions(dress(figure.add_axes((0.09, 0.085, 0.88, 0.38)), "Time (s)", "Tension (N)"), done)
    return figure


def body_errors(done: Simulated) -> np.ndarray:
    """The largest distance (P,) m of a joint or the tip from where it is planned."""
    plan = done.plan
    planned = joints_on(plan.task.base, plan.robot, done.commanded, done.at, done.section_lengths)
    return np.linalg.norm(done.joints - planned, axis=2).max(axis=1)


def tip_off_path(motion: Plan) -> np.ndarray:
    """Distance (P,) m of the tip from the path."""
    return motion.path.distance_to(motion.body[:, -1])


def _errors(axes: Axes, done: Simulated, motion: Plan) -> None:
    lines = (
        (motion.body_deviation.max(axis=1), "body off the path (links are chords of it)", LINKS[0], "-"),
        (tip_off_path(motion), "tip off the path", BAD, "-"),
        (body_errors(done), "body off the plan", PATH, "-"),
        (done.tip_errors, "tip off the plan", INK, (0, (4, 2))),
    )
    for values, words, colour, dashes in lines:
        axes.plot(
            motion.time, np.maximum(1e3 * values, _LEAST), color=colour, linestyle=dashes, linewidth=1.2, label=words
        )
    axes.set_yscale("log")
    axes.set_ylim(_LEAST, 300.0 if done.tip_errors.max() > 5e-3 else 30.0)
    axes.set_xlim(float(motion.time[0]), float(done.plan.time[-1]))
    axes.minorticks_off()
    axes.legend(fontsize=SMALL, frameon=False, ncols=2, loc="upper left")
    rms = 1e3 * float(np.sqrt(np.mean(done.tip_errors**2)))
    axes.set_title(f"Tip {rms:.3f} mm off its plan in root mean square, {1e3 * done.tip_errors.max():.2f} mm at most",
                   fontsize=9, color=INK, loc="left")  # fmt: skip


def _tensions(axes: Axes, done: Simulated) -> None:
    plan, arm = done.plan, done.plan.task.mechanics
    assert arm is not None, "it was simulated"
    draw_tensions(axes, plan.robot, done.time, done.tensions, {"least": arm.tension_min})
    axes.set_xlim(float(plan.time[0]), float(plan.time[-1]))
    axes.set_ylim(min(0.0, float(done.tensions.min())), None)
