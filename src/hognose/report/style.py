"""Colours, sizes and the making of figures: what all pictures have in common.

Figures are made without pyplot: nothing global, no window system, and safe to make in threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

INK, FAINT, GRID = "#2b3138", "#6b747d", "#dfe3e8"
#: The links' two tones, and the joints between them.
LINKS, JOINT = ("#e8a33d", "#f6d59a"), "#5a5148"
#: One tone an obstacle, in turn.
OBSTACLES = ("#7d93ab", "#8fa38a", "#a592a8", "#a89a80", "#7fa3a6", "#9a8f8a")
EDGE, EDGE_BEHIND, ARM_EDGE = "#3d4650", "#8d98a4", "#5c4a2c"
PATH, POINT, TIP = "#1f6f8b", "#174a5e", "#b3202a"
BAD, MARGIN = "#b3202a", "#0b3c8c"
SMALL, TEXT, HEAD = 7.0, 8.0, 9.0


def rgb(colours: Sequence[str]) -> Floats:
    """Return named or hexadecimal colours as (k, 3), 0 to 1."""
    from matplotlib.colors import to_rgb

    return np.array([to_rgb(colour) for colour in colours])


def new_figure(width: float, height: float, dpi: float = 160.0) -> Figure:
    """Return an empty white figure, width and height in inches, that can draw itself."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=dpi, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def dress(axes: Axes, across: str, up: str, title: str = "") -> Axes:
    """Give a chart its labels and the plain look all charts share; returns the same axes."""
    axes.set_xlabel(across, fontsize=TEXT, color=INK)
    axes.set_ylabel(up, fontsize=TEXT, color=INK)
    axes.set_title(title, fontsize=HEAD, color=INK, loc="left")
    axes.tick_params(labelsize=SMALL, color=FAINT, labelcolor=INK, length=3)
    axes.grid(True, color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(FAINT)
    return axes


def section_colours(sections: int) -> Floats:
    """Return one colour a section (sections, 3), running evenly from base to tip."""
    from matplotlib import colormaps

    return colormaps["viridis"](np.linspace(0.0, 0.9, max(sections, 1)))[:, :3]


def clearance_colours() -> Colormap:
    """Return the colours of clearance: dark red is close, pale is far, grey is beyond what is measured."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    scale = ListedColormap(colormaps["YlOrRd_r"](np.linspace(0.0, 0.97, 256)), name="clearance")
    return scale.with_extremes(over="#e3e8ee", under="#3a0010")


def png(figure: Figure, dpi: float | None = None) -> bytes:
    """Return a figure as PNG."""
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=dpi or "figure", metadata={"Software": None})
    return stream.getvalue()


def svg(figure: Figure) -> bytes:
    """Return a figure as SVG, the same bytes for the same figure."""
    from matplotlib import rc_context

    stream = BytesIO()
    with rc_context({"svg.hashsalt": "hognose"}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()
