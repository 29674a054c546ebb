"""Draws the pictures of the documentation: `python docs/make_pictures.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch, Polygon, Rectangle

import hognose

FOLDER = Path(__file__).parent / "pictures"
INK, SOFT, ACCENT = "#1d2733", "#8a97a6", "#c2410c"


def conventions() -> None:
    """Frames, feed and angles: two sections in the x–z plane, where only alpha turns."""
    figure = Figure(figsize=(9.2, 4.0), dpi=150)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_xlim(-1.4, 7.8)
    axes.set_ylim(-1.2, 2.8)
    axes.plot([-1.2, 7.6], [0, 0], color=SOFT, lw=1, ls=(0, (6, 4)), zorder=0)
    axes.text(7.6, -0.22, "straight run of the slider, +z", ha="right", color=SOFT, fontsize=9)
    axes.add_patch(Rectangle((-0.75, -0.28), 0.75, 0.56, fc="#e6ebf1", ec=INK, lw=1.2))
    axes.text(-0.375, 0.5, "slider", ha="center", fontsize=9, color=INK)
    tilts = np.radians([15.0, 33.0])
    joints = np.zeros((3, 2))
    for i, tilt in enumerate(tilts):
        joints[i + 1] = joints[i] + 3.0 * np.array([np.cos(tilt), np.sin(tilt)])
        _link(axes, joints[i], tilt)
        middle = joints[i] + 1.5 * np.array([np.cos(tilt), np.sin(tilt)])
        axes.text(
            middle[0],
            middle[1],
            f"link {i + 1}",
            ha="center",
            va="center",
            rotation=np.degrees(tilt),
            fontsize=9,
            color=INK,
        )
    for i, (x, y) in enumerate(joints):
        axes.plot(x, y, "o", ms=7, mfc="white", mec=ACCENT, mew=1.8, zorder=5)
        axes.text(
            x + (0.2 if i == 2 else 0.05),
            y - 0.4,
            f"joints[{i}]" + (" = tip" if i == 2 else ""),
            ha="left" if i == 2 else "center",
            fontsize=9,
            color=ACCENT,
        )
    previous = 0.0
    for i, tilt in enumerate(tilts):
        start, reach = joints[i], 2.1
        end = start + reach * 1.2 * np.array([np.cos(previous), np.sin(previous)])
        axes.plot(*zip(start, end, strict=True), color=INK, lw=0.8, ls=":", zorder=4)
        axes.add_patch(
            Arc(
                tuple(start),
                2 * reach,
                2 * reach,
                theta1=np.degrees(previous),
                theta2=np.degrees(tilt),
                lw=1.4,
                color=INK,
                zorder=6,
            )
        )
        bisector = previous + 0.3 * (tilt - previous)
        place = start + (reach + 0.22) * np.array([np.cos(bisector), np.sin(bisector)])
        axes.text(place[0], place[1], rf"$\alpha_{i + 1}$", ha="center", va="center", fontsize=11, color=INK, zorder=7)
        previous = tilt
    _arrow(axes, (-1.2, -0.62), (0.0, -0.62), ACCENT)
    axes.text(-1.2, -0.95, "feed: position of joints[0] on the run", fontsize=9, color=ACCENT)
    origin = (-1.0, 1.55)
    _arrow(axes, origin, (origin[0] + 0.75, origin[1]), INK)
    _arrow(axes, origin, (origin[0], origin[1] + 0.75), INK)
    axes.plot(*origin, "o", ms=8, mfc="white", mec=INK)
    axes.plot(*origin, ".", ms=4, color=INK)
    for text, dx, dy in (("z", 0.9, 0.0), ("x", 0.0, 0.9), ("y, towards you", 0.42, -0.25)):
        axes.text(origin[0] + dx, origin[1] + dy, text, ha="center", va="center", fontsize=10, color=INK)
    axes.text(
        0.45,
        2.3,
        r"$R_y(\alpha_i)\,R_x(\beta_i)$ turns link $i$ against link $i-1$;"
        "\n"
        r"$\alpha > 0$ bends towards +x, $\beta > 0$ towards −y",
        fontsize=9.5,
        color=INK,
        va="center",
    )
    figure.savefig(FOLDER / "conventions.png")


def _link(axes: Axes, start: np.ndarray, tilt: float) -> None:
    along, across = np.array([np.cos(tilt), np.sin(tilt)]), np.array([-np.sin(tilt), np.cos(tilt)])
    corners = [start + a * along + b * across for a, b in ((0.25, -0.2), (2.75, -0.2), (2.75, 0.2), (0.25, 0.2))]
    axes.add_patch(Polygon(corners, closed=True, fc="#f3ede6", ec=INK, lw=1.2, zorder=2))
    axes.plot(*zip(start, start + 3.0 * along, strict=True), color=INK, lw=1.0, zorder=1)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    axes.add_patch(
        FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=11, lw=1.4, color=color, shrinkA=0, shrinkB=0)
    )


def cases() -> None:
    """The bundled tasks at the instants of their reports."""
    from hognose.view.figures import instants

    for name in ("obstacle-array", "pipe-tank"):
        plan = hognose.plan(hognose.load_task(name))
        instants(plan, plan.task.spec.report.times_s).savefig(FOLDER / f"{name}.png")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    conventions()
    cases()
