"""The mechanics of a plan as charts over time: tensions, safety against buckling, where the tip would be otherwise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hognose.mechanics.sensitivity import ASSUMED_FRICTION, SHARE, ZERO
from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.loads import Loads
from hognose.report.style import BAD, INK, LINKS, MARGIN, PATH, SMALL, dress, new_figure, section_colours
from hognose.robot import Robot

Array = NDArray[np.float64]


def mechanics(found: Loads) -> Figure:
    """Return tensions by section, load factor and sag, one above the other; nothing where no tensions hold the arm.

    Parameters
    ----------
    found
        Of `hognose.planning.loads.loads`.
    """
    motion, held, arm = found.motion, found.held, found.motion.task.mechanics
    assert arm is not None, "loads"
    time, tensions = motion.time, found.where_held(held.tensions)
    figure = new_figure(7.2, 6.4)
    top = dress(figure.add_axes((0.09, 0.56, 0.88, 0.38)), "", "Tension (N)")
    draw_tensions(top, motion.robot, time, tensions, {"largest": arm.tension_max, "least": arm.tension_min})
    middle = dress(figure.add_axes((0.09, 0.33, 0.88, 0.15)), "", "Load factor")
    needed, factor = arm.load_factor_min, found.where_held(np.minimum(held.load_factor, LARGEST_LOAD_FACTOR))
    middle.plot(time, factor, color=PATH, linewidth=1.4)
    middle.axhline(needed, color=MARGIN, linewidth=1.2, linestyle="--")
    middle.set_ylim(0.0, 1.15 * float(np.nanmax([*factor, needed])))
    middle.set_title(f"Load factor of buckling, at least {needed:g}", fontsize=9, color=INK, loc="left")
    low = dress(figure.add_axes((0.09, 0.075, 0.88, 0.17)), "Time (s)", "Tip off by (mm)")
    off, friction = found.sensitivity, arm.friction or ASSUMED_FRICTION
    for values, words, colour in (
        (found.sag, "not compensated", BAD),
        (off.zero, f"cable zeros ±{1e3 * ZERO:g} mm (1σ)", PATH),
        (off.share, f"EA or masses off by {100 * SHARE:g} %", INK),
        (off.friction, f"friction {friction:g}{'' if arm.friction else ' (assumed)'}", LINKS[0]),
    ):
        low.plot(time, 1e3 * found.where_held(values), color=colour, linewidth=1.2, label=words)
    low.set_ylim(0.0, None)
    low.legend(fontsize=SMALL, frameon=False, ncols=4, loc="lower left", bbox_to_anchor=(-0.02, 0.98),
               columnspacing=1.2, handlelength=1.4)  # fmt: skip
    for axes in (top, middle, low):
        axes.set_xlim(float(time[0]), float(time[-1]))
    return figure


def draw_tensions(axes: Axes, robot: Robot, time: Array, tensions: Array, bounds: Mapping[str, float]) -> None:
    """Draw tensions (T, c) N of all cables over time (T,) s, and dashed what they must keep, by what it is called."""
    colours = section_colours(robot.sections)
    for cable, section in enumerate(robot.cable_sections):
        axes.plot(time, tensions[:, cable], color=colours[section], linewidth=0.9)
    for words, bound in bounds.items():
        axes.axhline(bound, color=MARGIN, linewidth=1.2, linestyle="--")
        axes.annotate(f"{words} {bound:g} N", (time[-1], bound), (-2, -9 if words == "least" else 3),
                      textcoords="offset points", fontsize=SMALL, color=MARGIN, ha="right")  # fmt: skip
    axes.set_title("Tension of every cable, base (dark) to tip", fontsize=9, color=INK, loc="left")
