"""The mechanics of a plan as charts over time: tensions, safety against buckling, where the tip would be otherwise."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.loads import Loads
from hognose.report.style import BAD, INK, MARGIN, PATH, SMALL, dress, new_figure, section_colours


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
    colours = section_colours(motion.robot.sections)
    for cable, section in enumerate(motion.robot.cable_sections):
        top.plot(time, tensions[:, cable], color=colours[section], linewidth=0.9)
    for bound, words, above in ((arm.tension_max, "largest", 3), (arm.tension_min, "least", -9)):
        top.axhline(bound, color=MARGIN, linewidth=1.2, linestyle="--")
        top.annotate(f"{words} {bound:g} N", (time[-1], bound), (-2, above), textcoords="offset points",
                     fontsize=SMALL, color=MARGIN, ha="right")  # fmt: skip
    top.set_title("Tension of every cable, base (dark) to tip", fontsize=9, color=INK, loc="left")
    middle = dress(figure.add_axes((0.09, 0.33, 0.88, 0.15)), "", "Load factor")
    needed, factor = arm.load_factor_min, found.where_held(np.minimum(held.load_factor, LARGEST_LOAD_FACTOR))
    middle.plot(time, factor, color=PATH, linewidth=1.4)
    middle.axhline(needed, color=MARGIN, linewidth=1.2, linestyle="--")
    middle.set_ylim(0.0, 1.15 * float(np.nanmax([*factor, needed])))
    middle.set_title(f"Load factor of buckling, at least {needed:g}", fontsize=9, color=INK, loc="left")
    low = dress(figure.add_axes((0.09, 0.075, 0.88, 0.17)), "Time (s)", "Tip off by (mm)")
    low.plot(time, 1e3 * found.where_held(found.sag), color=BAD, linewidth=1.4, label="weight not compensated")
    low.plot(
        time,
        1e3 * found.where_held(found.sensitivity.zero),
        color=PATH,
        linewidth=1.2,
        label="cable zeros ±0.1 mm (1σ)",
    )
    low.plot(
        time,
        1e3 * found.where_held(found.sensitivity.share),
        color=INK,
        linewidth=1.2,
        label="EA or masses off by 10 %",
    )
    low.set_ylim(0.0, None)
    low.legend(fontsize=SMALL, frameon=False, ncols=3, loc="best")
    for axes in (top, middle, low):
        axes.set_xlim(float(time[0]), float(time[-1]))
    return figure
