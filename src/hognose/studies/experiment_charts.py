"""A run in and out as charts and pictures: tip, clearance and tensions along the path, and what the tip camera saw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hognose.planning import Plan
from hognose.report.mechanics import draw_tensions
from hognose.report.style import BAD, HEAD, INK, LINKS, MARGIN, PATH, SMALL, dress, new_figure
from hognose.robot.base import angles_on
from hognose.studies.there_and_back import ThereAndBack, Way, planned_at

Array = NDArray[np.float64]

#: Of both ways.
_COLOURS = {"in": PATH, "out": LINKS[0]}
#: Pictures of the tip camera beside each other, and the width (inches) of each.
_PICTURES, _WIDE = 4, 2.35


def along_the_path(ran: ThereAndBack, bound: float) -> Figure:
    """Return the tip's error and the least clearance over the feed, both ways; the bound of its root mean square, m."""
    plan, figure = ran.plan, new_figure(7.2, 4.6)
    tip = dress(figure.add_axes((0.09, 0.565, 0.88, 0.36)), "", "Tip off its plan (mm)")
    clear = dress(figure.add_axes((0.09, 0.1, 0.88, 0.36)), "Feed (mm)", "Least clearance (mm)")
    feed = 1e3 * plan.feed
    for way in ran.ways:
        at, colour = 1e3 * planned_at(plan.feed, way.place), _COLOURS[way.name]
        tip.plot(at, 1e3 * way.tip_errors, color=colour, linewidth=1.2, label=way.name)
        clear.plot(at, 1e3 * way.clearance, color=colour, linewidth=1.4, label=f"twin, {way.name}")
    most = max([bound, *(float(way.tip_errors.max()) for way in ran.ways)])
    _line(tip, feed, 1e3 * bound, "bound of the root mean square")
    tip.set_ylim(0.0, 1.15e3 * most)
    clear.plot(feed, 1e3 * plan.clearance.min(axis=1), color=INK, linewidth=0.9, linestyle=(0, (4, 2)), label="planned")
    _line(clear, feed, 1e3 * plan.task.margin, "required")
    if plan.certified_clearance is not None:
        _line(clear, feed, 1e3 * plan.certified_clearance, "certified for the whole motion")
    clear.set_ylim(0.0, 1.1e3 * float(plan.clearance.min(axis=1).max()))
    for axes in (tip, clear):
        axes.set_xlim(feed[0], feed[-1])
        axes.legend(fontsize=SMALL, frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(-0.01, 0.98))
    return figure


def tensions(ran: ThereAndBack) -> Figure:
    """Return the tensions of all cables as drives measured them over time, both ways one after the other."""
    arm, plan = ran.plan.task.mechanics, ran.plan
    assert arm is not None, "it moved a twin"
    figure = new_figure(7.2, 3.0)
    axes = dress(figure.add_axes((0.09, 0.155, 0.88, 0.73)), "Time since the way in began (s)", "Tension (N)")
    begin = float(ran.ways[0].cycles.time[0])
    times = np.concatenate([way.cycles.time for way in ran.ways]) - begin
    pulls = np.concatenate([way.cycles.tensions for way in ran.ways])
    draw_tensions(axes, plan.robot, times, pulls, {"least": arm.tension_min})
    turned = float(ran.ways[-1].cycles.time[0]) - begin
    if len(ran.ways) > 1:
        axes.axvline(turned, color=INK, linewidth=0.8, linestyle=":")
        axes.annotate("out again", (turned, 1.0), (3, -9), xycoords=("data", "axes fraction"), fontsize=SMALL,
                      textcoords="offset points", color=INK)  # fmt: skip
    axes.set_xlim(0.0, float(times[-1]))
    axes.set_ylim(0.0, 1.12 * float(pulls.max()))
    return figure


def tip_camera(ran: ThereAndBack, times: Sequence[float] | None) -> Figure:
    """Return pictures of the record beside each other, a row a way: those closest to instants (s) of the plan.

    Spread evenly unless instants are given; out again those closest to the same places.
    """
    from PIL import Image

    plan, reached = ran.plan, max(float(way.place.max()) for way in ran.ways)
    if times is None or not len(times):
        steps = np.linspace(0.0, reached, _PICTURES)
    else:
        steps = np.minimum(np.interp(times, plan.time, np.arange(len(plan.time))), reached)
    shown = [way for way in ran.ways if way.images]
    foot, title, high = 0.04, 0.22, 0.75 * _WIDE
    width, tall = foot + (_WIDE + foot) * len(steps), (high + title + foot) * len(shown)
    figure = new_figure(width, max(tall, 0.1), 136.0)
    for row, way in enumerate(shown):
        places = np.interp([image.time for image in way.images], way.cycles.time, way.place)
        for column, step in enumerate(steps):
            image = way.images[int(np.argmin(np.abs(places - step)))]
            left, low = foot + column * (_WIDE + foot), tall - (row + 1) * (high + title + foot) + foot
            axes = figure.add_axes((left / width, low / tall, _WIDE / width, high / tall))
            with Image.open(BytesIO(image.jpeg)) as picture:
                axes.imshow(np.asarray(picture.convert("RGB")), aspect="auto")
            axes.set_axis_off()
            at = float(np.interp(image.time, way.cycles.time, way.place))
            figure.text(left / width, (low + high + 0.06) / tall, f"{way.name}, step {at:.0f}, {image.time:.1f} s",
                        fontsize=HEAD - 1.0, color=INK)  # fmt: skip
    return figure


def reached(plan: Plan, way: Way) -> Plan:
    """The motion that the twin made on its way in, at the steps of its plan; not judged."""
    count = int(way.place.max()) + 1
    rows = [int(np.argmin(np.abs(way.place - step))) for step in range(count)]
    columns = {name: getattr(plan, name)[:count] for name in ("time", "feed", "motor_counts", "clearance")}
    pose = None if plan.base_pose is None else plan.base_pose[:count]
    joints = way.joints[rows]
    angles = angles_on(plan.task.base, plan.robot, joints, plan.at[:count])
    lengths = plan.robot.cable_lengths(angles)
    moved = replace(plan, joints=joints, angles=angles, cable_lengths=lengths, base_pose=pose, extra={}, checks=(),
                    **columns)  # fmt: skip
    return replace(moved, clearance=moved.clearance_now())


def _line(axes: Axes, feed: Array, value: float, words: str) -> None:
    """Draw a limit over the feed, with its words at the left, below it, where the curves are not."""
    colour = BAD if words == "required" else MARGIN
    axes.axhline(value, color=colour, linewidth=1.0, linestyle="--")
    axes.annotate(f"{words}, {value:.3g} mm", (feed[0], value), (3, -9), textcoords="offset points", fontsize=SMALL,
                  color=colour)  # fmt: skip
