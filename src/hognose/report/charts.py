"""The numbers of a plan as charts over time: clearance, joint angles, cables, tip error, body deviation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator
from numpy.typing import NDArray

from hognose.planning.link_budgets import clearance_left
from hognose.report.style import (
    BAD,
    FAINT,
    INK,
    MARGIN,
    PATH,
    SMALL,
    clearance_colours,
    dress,
    new_figure,
    section_colours,
)
from hognose.wording import at_least_mm

if TYPE_CHECKING:
    from hognose.planning.plan import Plan

Floats = NDArray[np.float64]

_TIME = "Time (s)"
#: An error below this is nothing but rounding, mm.
_ROUNDING = 1e-12


def clearance_map(plan: Plan) -> Figure:
    """Return how close each link comes to the obstacles over time, as a map.

    Cells at the horizon are grey: there the clearance is only known to be at least that. The smallest value
    is ringed, if it is measured; where clearance falls below the margin, a line runs round it.
    """
    figure = new_figure(7.2, 3.1)
    axes = dress(figure.add_axes((0.075, 0.15, 0.80, 0.75)), _TIME, "Link, from base to tip")
    axes.grid(False)
    links, horizon = plan.clearance.shape[1], plan.horizon * 1e3
    shown = np.where(plan.clearance >= plan.horizon, horizon * 2, plan.clearance * 1e3).T
    mesh = axes.pcolormesh(
        cell_borders(plan.time),
        np.arange(links + 1) + 0.5,
        shown,
        cmap=clearance_colours(),
        vmin=0.0,
        vmax=horizon,
        rasterized=True,
    )
    axes.yaxis.set_major_locator(MaxNLocator(nbins=12, integer=True))
    _below_margin(axes, plan)
    title = f"Smallest clearance {least_clearance(plan)}"
    if has_closest(plan):
        step, link = np.unravel_index(int(np.argmin(plan.clearance)), plan.clearance.shape)
        ring = axes.plot(plan.time[step], link + 1, "o", ms=9, mfc="none", mec=INK, clip_on=False)
        ring[0].set_path_effects([withStroke(linewidth=2.6, foreground="white")])
        title += f", link {link + 1}, at {plan.time[step]:.2f} s"
    axes.set_title(title, fontsize=9, color=INK, loc="left")
    _clearance_bar(figure, mesh, plan)
    return figure


def has_closest(plan: Plan) -> bool:
    """Return whether any link comes so close at any step that its clearance is measured."""
    return float(plan.clearance.min()) < plan.horizon


def least_clearance(plan: Plan) -> str:
    """Return the smallest clearance in words, as what it is: a value, or a lower bound."""
    least = float(plan.clearance.min())
    said = f"{at_least_mm(least)} mm" if has_closest(plan) else f"≥ {plan.horizon * 1e3:g} mm"
    return said if plan.task.budget is None else f"{said} as planned"


def cell_borders(centres: Floats) -> Floats:
    """Return the borders (k + 1,) of cells round increasing centres (k,), half-way between neighbours."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def _extent(time: Floats) -> tuple[float, float]:
    """Return the limits of a time axis, which must not fall together for a plan of one step."""
    return float(time[0]), float(time[-1]) if time[-1] > time[0] else float(time[0]) + 1.0


def _below_margin(axes: Axes, plan: Plan) -> None:
    below = clearance_left(plan) < plan.task.margin
    if not below.any() or below.all() or min(below.shape) < 2:
        return
    axes.contour(
        plan.time,
        np.arange(below.shape[1]) + 1,
        below.T.astype(float),
        levels=[0.5],
        colors=MARGIN,
        linewidths=1.4,
    )


def _clearance_bar(figure: Figure, mappable, plan: Plan) -> None:
    horizon, margin = plan.horizon * 1e3, plan.task.margin * 1e3
    bar = figure.colorbar(mappable, cax=figure.add_axes((0.895, 0.15, 0.016, 0.75)), extend="max")
    ticks = np.linspace(0, horizon, 6)
    bar.set_ticks(list(ticks), labels=[f"{tick:g}" for tick in ticks[:-1]] + [f"≥ {horizon:g}"])
    bar.ax.tick_params(labelsize=SMALL, color=FAINT, labelcolor=INK, length=3)
    bar.set_label("Clearance (mm)", fontsize=8, color=INK)
    bar.ax.axhline(margin, color=MARGIN, linewidth=1.6)
    bar.ax.annotate(
        f"— margin {margin:g} mm",
        (0, 0),
        (-22, -16),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=SMALL,
        color=MARGIN,
    )
    bar.outline.set_visible(False)  # pyright: ignore[reportCallIssue]


def joint_angles(plan: Plan) -> Figure:
    """Return the two bend angles of each section over time, with the bend limits."""
    figure = new_figure(7.2, 4.2)
    colours = section_colours(plan.angles.shape[1])
    bounds = np.degrees(plan.robot.bend_bounds)
    for k, name in enumerate(("α", "β")):
        axes = _half(figure, plan, k, f"{name} (deg)")
        for i, angle in enumerate(np.degrees(plan.angles[:, :, k]).T):
            axes.plot(plan.time, angle, color=colours[i], linewidth=1.1)
        for limit in np.unique(bounds[:, k]):
            axes.axhline(limit, color=BAD, linewidth=0.9, linestyle=(0, (5, 3)))
        for limit in np.unique(bounds[:, k, 1]):
            note = axes.annotate(
                f"limit {limit:.1f}°", (plan.time[0], limit), (3, -9), textcoords="offset points", color=BAD
            )
            note.set_fontsize(SMALL)
    _section_bar(figure, len(colours))
    return figure


def cable_lengths(plan: Plan) -> Figure:
    """Return how far each cable moves from its first length, and how fast, over time.

    The first step is the straight pose, so this is the length to pull in (negative) or to pay out.
    """
    figure = new_figure(7.2, 4.2)
    change = (plan.cable_lengths - plan.cable_lengths[0]) * 1e3
    speed = np.gradient(change, plan.time, axis=0) if len(plan.time) > 1 else np.zeros_like(change)
    sections = np.asarray(plan.robot.cable_sections)
    colours = section_colours(int(sections.max()) + 1)
    for k, (values, label) in enumerate(((change, "Change of length (mm)"), (speed, "Speed (mm/s)"))):
        axes = _half(figure, plan, k, label)
        for section, cable in zip(sections, values.T, strict=True):
            axes.plot(plan.time, cable, color=colours[section], linewidth=0.8)
        axes.axhline(0, color=FAINT, linewidth=0.6)
    _section_bar(figure, len(colours))
    return figure


def _half(figure: Figure, plan: Plan, k: int, label: str) -> Axes:
    """The upper (0) or the lower (1) of two axes over the same time."""
    axes = dress(figure.add_axes((0.085, 0.56 - 0.45 * k, 0.79, 0.38)), _TIME if k else "", label)
    axes.set_xlim(*_extent(plan.time))
    axes.tick_params(labelbottom=bool(k))
    return axes


def tip_error(plan: Plan) -> Figure:
    """Return the distance of the tip from where it should be over time, on a logarithmic scale."""
    figure = new_figure(7.2, 2.5)
    axes = dress(figure.add_axes((0.105, 0.18, 0.87, 0.68)), _TIME, "Tip error (mm)")
    error = np.asarray(plan.tip_error, dtype=float) * 1e3
    axes.set_yscale("log")
    axes.plot(plan.time, np.maximum(error, _ROUNDING), color=PATH, linewidth=1.1)
    top = max(10 ** np.ceil(np.log10(max(error.max(), _ROUNDING)) + 0.2), 1e-9)
    axes.set_ylim(_ROUNDING / 2, top)
    axes.set_xlim(*_extent(plan.time))
    axes.yaxis.set_major_locator(LogLocator(numticks=8))
    axes.minorticks_off()
    if (error <= _ROUNDING).any():
        note = f"at the lower edge: {_ROUNDING:g} mm or less, which is rounding"
        axes.text(0.995, 0.03, note, transform=axes.transAxes, fontsize=SMALL, color=FAINT, ha="right")
    rms = float(np.sqrt(np.mean(error**2)))
    axes.set_title(f"Largest {error.max():.3g} mm, root mean square {rms:.3g} mm", fontsize=9, color=INK, loc="left")
    return figure


def body_deviation(plan: Plan) -> Figure:
    """Return how far each link leaves the path over time, with the largest of every step."""
    figure = new_figure(7.2, 2.9)
    axes = dress(figure.add_axes((0.085, 0.16, 0.79, 0.70)), _TIME, "Body off the path (mm)")
    away = plan.body_deviation * 1e3
    colours = section_colours(away.shape[1])
    for link, values in enumerate(away.T):
        axes.plot(plan.time, values, color=colours[link], linewidth=0.8)
    axes.plot(plan.time, away.max(axis=1), color=INK, linewidth=1.2, linestyle=(0, (4, 2)))
    axes.set_xlim(*_extent(plan.time))
    axes.set_ylim(0.0, max(1.08 * float(away.max()), _ROUNDING))
    step, link = np.unravel_index(int(np.argmax(away)), away.shape)
    title = f"Largest {away.max():.3g} mm, link {link + 1}, at {plan.time[step]:.2f} s"
    axes.set_title(title, fontsize=9, color=INK, loc="left")
    _section_bar(figure, len(colours))
    return figure


def _section_bar(figure: Figure, sections: int) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap

    colours = ListedColormap(section_colours(sections), name="sections")
    norm = BoundaryNorm(np.arange(sections + 1) + 0.5, sections)
    bar = figure.colorbar(ScalarMappable(norm, colours), cax=figure.add_axes((0.905, 0.11, 0.016, 0.83)))
    shown = np.unique(np.linspace(1, sections, min(sections, 12)).astype(int))
    bar.set_ticks(list(shown), labels=[str(i) for i in shown])
    bar.ax.tick_params(labelsize=SMALL, length=0, labelcolor=INK)
    bar.outline.set_visible(False)  # pyright: ignore[reportCallIssue]
    bar.set_label("Section, from base to tip", fontsize=8, color=INK)
