"""The figures of an evaluation; each takes the results, and returns None where they hold nothing for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hognose.evaluation.measure import Row
from hognose.evaluation.subjects import method_of
from hognose.evaluation.suite import Results
from hognose.evaluation.targets import CASES, PAPER_RMSE, row_of
from hognose.report.style import FAINT, INK, SMALL, TEXT, dress, new_figure

if TYPE_CHECKING:
    from matplotlib.colors import Colormap
    from matplotlib.lines import Line2D

#: One colour a method, the same in all figures; methods that are not here take the last ones in turn.
_COLOURS = {
    "exact": "#1b1f23",
    "balanced": "#1f6f8b",
    "prediction": "#e8a33d",
    "interpolation": "#b3202a",
    "iterative": "#4d9a57",
    "bisection": "#6a51a3",
    "optimization": "#0b3c8c",
    "fabrik": "#c05fa5",
    "ccd": "#8a6d3b",
    "jacobian": "#7d93ab",
    "aim": "#2f9e8f",
    "fitted": "#d1495b",
}
_MORE_COLOURS = ("#3fb8af", "#ff6f61", "#9acd32")
#: Marks of methods in charts with few points; published variants have hollow ones and dashed lines.
_MARKS = "osD^vP*XhdpH"
#: Methods that take points of the path, whose error depends on the points' distance.
_SNAPPING = ("prediction", "interpolation", "iterative")
#: Errors below this (mm) are drawn on the lower edge.
_LEAST = 1e-7
_LEVELS = ((0, (5, 3)), (0, (1.5, 2)))
_WIDTH, _HEIGHT = 7.2, 3.5
#: Counts of more letters are in two lines; names of more families than this are smaller.
_WIDE, _MANY = 7, 9
_BESIDE_LEGEND = (0.09, 0.135, 0.625, 0.79)
_ALONE = (0.09, 0.14, 0.88, 0.78)


def time_along(results: Results, case: str = "pipe-tank") -> Figure | None:
    """Time of every step along a case, all methods (paper figure 10a)."""
    rows = [row for row in results.of("cases", case=case) if row.time_series_us]
    if not rows:
        return None
    figure = new_figure(_WIDTH, _HEIGHT)
    axes = dress(figure.add_axes(_BESIDE_LEGEND), "Step", "Time per step (µs)", f"Time along the motion, {case}")
    axes.set_yscale("log")
    for row in rows:
        steps = np.arange(row.all_steps - row.steps, row.all_steps)
        axes.plot(steps, row.time_series_us, **_line(results, row.method), linewidth=1.2)
    _legend(figure, axes)
    return figure


def tip_along(results: Results, case: str = "pipe-tank") -> Figure | None:
    """Tip error of every step along a case, with and without interpolation (paper figure 10b)."""
    rows = [row_of(results, case, method) for method in ("prediction", "interpolation")]
    if not any(row is not None and row.tip_series_mm for row in rows):
        return None
    figure = new_figure(_WIDTH, 2.9)
    axes = dress(figure.add_axes(_ALONE), "Step", "Tip error (mm)", f"Tip error along the motion, {case}")
    axes.set_yscale("log")
    for row in rows:
        if row is not None and row.tip_series_mm:
            steps = np.arange(row.all_steps - row.steps, row.all_steps)
            error = np.maximum(row.tip_series_mm, _LEAST)
            axes.plot(steps, error, **_line(results, row.method), linewidth=1.2)
            _name_line(axes, row.method, steps[-1], float(np.median(error[-40:])), results)
    last = max(row.all_steps for row in rows if row is not None)
    axes.set_xlim(0, 1.14 * last)
    axes.set_xticks(range(0, last + 1, 50))
    axes.set_ylim(_LEAST, 2.0)
    return figure


def body_along(results: Results) -> Figure | None:
    """Largest body deviation of every step, exact beside balanced, on the two cases."""
    pairs = {case: [row_of(results, case, method) for method in ("exact", "balanced")] for case in CASES}
    if not any(row is not None and row.body_series_mm for pair in pairs.values() for row in pair):
        return None
    figure = new_figure(_WIDTH, 2.9)
    for place, (case, pair) in enumerate(pairs.items()):
        box = (0.075 + 0.5 * place, 0.15, 0.41, 0.76)
        axes = dress(figure.add_axes(box), "Step", "" if place else "Largest body deviation (mm)", case)
        for row in pair:
            if row is not None and row.body_series_mm:
                steps = np.arange(row.all_steps - row.steps, row.all_steps)
                axes.plot(steps, row.body_series_mm, **_line(results, row.method), linewidth=1.3)
        axes.set_ylim(0.0, 1.2 * axes.get_ylim()[1])
        axes.legend(loc="upper center", ncols=2, fontsize=SMALL + 0.5, frameon=False)
    return figure


def time_by_links(results: Results) -> Figure | None:
    """Time a step against the number of links, both logarithmic."""
    title = "Time against the number of links"
    return _by(results, results.of("links"), "links", "time_us", "Links", "Time per step (µs)", title)


def time_by_spacing(results: Results) -> Figure | None:
    """Time a step against the distance of the points, both logarithmic."""
    title = "Time against the spacing of the points, pipe-tank"
    return _by(results, results.of("spacing"), "spacing_mm", "time_us", "sd (mm)", "Time per step (µs)", title)


def tip_by_spacing(results: Results) -> Figure | None:
    """Tip RMSE against the distance of the points, with the paper's two figures as lines."""
    title = "Tip error against the spacing of the points, pipe-tank"
    levels = {
        f"paper, {words}: {value} mm": value for words, value in zip(("without", "with"), PAPER_RMSE, strict=True)
    }
    rows = [row for row in results.of("spacing") if row.method in _SNAPPING]
    return _by(results, rows, "spacing_mm", "tip_rmse_mm", "sd (mm)", "Tip RMSE (mm)", title, levels)


def valid_map(results: Results) -> Figure | None:
    """How many of each family's cases every method solved, and solved validly, as a map."""
    methods, families = results.methods, results.families
    if not methods:
        return None
    share = np.full((len(methods), len(families)), np.nan)
    figure = new_figure(_WIDTH, 0.75 + 0.235 * len(methods))
    height = figure.get_figheight()
    axes = dress(figure.add_axes((0.24, 0.08 / height, 0.75, 1.0 - 0.62 / height)), "", "")
    for i, method in enumerate(methods):
        for j, family in enumerate(families):
            rows = results.of(family, method)
            if rows:
                share[i, j] = np.mean([row.valid for row in rows])
                _count(axes, j, i, rows)
    axes.imshow(share, cmap=_shades(), vmin=0.0, vmax=1.0, aspect="auto")
    axes.grid(False)
    axes.set_xticks(range(len(families)), families)
    axes.set_yticks(range(len(methods)), methods)
    axes.tick_params(labelsize=TEXT, length=0, labeltop=True, labelbottom=False)
    axes.tick_params(axis="x", labelsize=TEXT - (1.0 if len(families) > _MANY else 0.0))
    for edge in range(1, max(len(methods), len(families))):
        axes.axhline(edge - 0.5, color="white", linewidth=1.2)
        axes.axvline(edge - 0.5, color="white", linewidth=1.2)
    axes.set_xlim(-0.5, len(families) - 0.5)
    axes.set_ylim(len(methods) - 0.5, -0.5)
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.text(0.01, 1.0 - 0.17 / height, "Valid of all cases (solved, if more)", fontsize=TEXT, color=INK)
    return figure


def _count(axes: Axes, across: int, down: int, rows: Sequence[Row]) -> None:
    valid, solved = sum(row.valid for row in rows), sum(row.solved for row in rows)
    words = f"{valid}/{len(rows)}" + (f" ({solved})" if solved > valid else "")
    size = SMALL + 0.5 if len(words) <= _WIDE else SMALL - 1.5
    axes.text(across, down, words if len(words) <= _WIDE else words.replace(" ", "\n"), ha="center", va="center",
              fontsize=size, linespacing=0.95, color=INK)  # fmt: skip


def _shades() -> Colormap:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("valid", ["#f2b8b5", "#fbe9c6", "#bfe3cb"]).with_extremes(bad="#f3f5f7")


def _by(
    results: Results,
    rows: Sequence[Row],
    across: str,
    up: str,
    label: str,
    label_up: str,
    title: str,
    levels: Mapping[str, float] | None = None,
) -> Figure | None:
    """A figure of rows against one of their properties, both logarithmic, a line a method and one a level."""
    rows = sorted((row for row in rows if getattr(row, up) is not None), key=lambda row: getattr(row, across))
    if not rows:
        return None
    figure = new_figure(_WIDTH, _HEIGHT)
    axes = dress(figure.add_axes(_BESIDE_LEGEND), label, label_up, title)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for method in results.methods:
        mine = [row for row in rows if row.method == method]
        places, values = [getattr(row, across) for row in mine], [getattr(row, up) for row in mine]
        if mine:
            style = _line(results, method)
            inside = style["color"] if method == method_of(method) else "white"
            axes.plot(places, values, **style, marker=_mark(results, method), ms=4, markerfacecolor=inside)
    for number, (words, value) in enumerate((levels or {}).items()):
        axes.axhline(value, color=FAINT, linewidth=1.0, linestyle=_LEVELS[number % 2], label=words)
    _ticks(axes, sorted({getattr(row, across) for row in rows}))
    _legend(figure, axes)
    return figure


def _ticks(axes: Axes, places: Sequence[float]) -> None:
    """The measured places as ticks, those left out that would touch their neighbour."""
    kept = [places[0]]
    reach = np.log(places[-1] / places[0]) if len(places) > 1 else 1.0
    for place in places[1:]:
        if np.log(place / kept[-1]) > 0.06 * reach:
            kept.append(place)
    axes.set_xticks(kept, [f"{place:,.4g}" if place < 1000 else f"{place:,.0f}" for place in kept])
    axes.minorticks_off()


def _legend(figure: Figure, axes: Axes) -> None:
    """A legend right of the chart, in the order in which the lines end."""
    lines: list[Line2D] = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    lines.sort(key=lambda line: -float(np.asarray(line.get_ydata(), dtype=float)[-1]))
    legend = figure.legend(
        handles=lines,
        loc="upper left",
        bbox_to_anchor=(0.728, 0.945),
        fontsize=SMALL + 0.5,
        frameon=False,
        handlelength=2.2,
        labelspacing=0.45,
        borderaxespad=0.0,
    )
    for text in legend.get_texts():
        text.set_color(INK)


def _name_line(axes: Axes, method: str, across: float, up: float, results: Results) -> None:
    colour = _line(results, method)["color"]
    axes.annotate(method, (across, up), (5, 0), textcoords="offset points", va="center", fontsize=TEXT, color=colour)


def _line(results: Results, label: str) -> dict[str, Any]:
    """Colour, dashes and name of a method's line."""
    method = method_of(label)
    others = [name for name in dict.fromkeys(map(method_of, results.methods)) if name not in _COLOURS]
    colour = _COLOURS.get(method) or _MORE_COLOURS[others.index(method) % len(_MORE_COLOURS)]
    return {"color": colour, "linestyle": "-" if label == method else (0, (4, 2)), "label": label}


def _mark(results: Results, label: str) -> str:
    return _MARKS[list(dict.fromkeys(map(method_of, results.methods))).index(method_of(label)) % len(_MARKS)]
