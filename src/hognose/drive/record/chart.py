"""The record of a run as charts over time: place along the plan, tensions, following errors."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hognose.drive.record.reader import Record
from hognose.drive.record.writer import VERDICT
from hognose.report.style import BAD, FAINT, INK, PATH, SMALL, dress, new_figure, section_colours


def chart(record: Record) -> Figure:
    """Return progress with the states and events, tensions of all cables, and their following errors."""
    cycles, figure = record.cycles, new_figure(7.2, 6.4)
    time = cycles.time
    top = dress(figure.add_axes((0.09, 0.72, 0.88, 0.22)), "", "Step")
    middle = dress(figure.add_axes((0.09, 0.40, 0.88, 0.24)), "", "Tension (N)")
    low = dress(figure.add_axes((0.09, 0.08, 0.88, 0.24)), "Time (s)", "Counts")
    top.plot(time, cycles.progress, color=PATH, linewidth=1.4)
    top.set_title("Place along the plan, states and events", fontsize=9, color=INK, loc="left")
    changed = [k for k in range(len(time)) if k == 0 or cycles.state[k] != cycles.state[k - 1]]
    for number, cycle in enumerate(changed):
        height = 1.0 - 0.45 * (number % 2)  # so that words of states that are short do not cover each other
        top.axvline(time[cycle], color=FAINT, linewidth=0.6)
        top.annotate(cycles.state[cycle], (time[cycle], height), (2, -8), xycoords=("data", "axes fraction"),
                     textcoords="offset points", fontsize=SMALL, color=FAINT, rotation=90, va="top")  # fmt: skip
    colours = section_colours(cycles.tensions.shape[1])
    for cable, colour in enumerate(colours):
        middle.plot(time, cycles.tensions[:, cable], color=colour, linewidth=0.7)
        low.plot(time, cycles.following[:, cable], color=colour, linewidth=0.7)
    middle.set_title("Tension of every cable, base (dark) to tip", fontsize=9, color=INK, loc="left")
    low.set_title("Following error of every drive", fontsize=9, color=INK, loc="left")
    for axes in (top, middle, low):
        for event in record.events:
            if event.kind != VERDICT:
                axes.axvline(event.time, color=BAD, linewidth=0.8, linestyle=":")
        if len(time) > 1 and np.ptp(time) > 0:
            axes.set_xlim(float(time.min()), float(time.max()))
    return figure
