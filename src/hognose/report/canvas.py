"""A rendered view on matplotlib axes, with the path, the way-points, the tip and the scale drawn over it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist, allow_rasterization
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.image import AxesImage
from matplotlib.patheffects import AbstractPathEffect, withStroke
from numpy.typing import ArrayLike, NDArray

from hognose.report.base_lines import mount_at, standing_lines, workspace_lines
from hognose.report.camera import THREE_QUARTER, Camera
from hognose.report.render import Lines, Picture, Stage, in_sight, sampled, set_stage, shoot
from hognose.report.style import (
    ARM_EDGE,
    EDGE,
    EDGE_BEHIND,
    FAINT,
    INK,
    PATH,
    POINT,
    SMALL,
    TIP,
    clearance_colours,
)

if TYPE_CHECKING:
    from hognose.planning.plan import Plan

Floats = NDArray[np.float64]

_DOT = 3.4
#: Numbers stand so far from their way-points (points).
_ASIDE = 8.5
#: Width and height of a digit of such a number (points).
_DIGIT = (5.0, 7.0)
#: Round words and dots that stand on a picture.
HALO: list[AbstractPathEffect] = [withStroke(linewidth=2.2, foreground="white")]


def prepare(
    axes: Axes,
    plan: Plan,
    *,
    camera: Camera | None = None,
    towards_eye: ArrayLike = THREE_QUARTER,
    steps: Sequence[int] = (0, -1),
    density: float = 1.0,
) -> Stage:
    """Return the stage for axes, and make their coordinates the picture's pixels."""
    size = (max(round(axes.bbox.width), 8), max(round(axes.bbox.height), 8))
    stage = set_stage(plan, size, camera=camera, towards_eye=towards_eye, steps=steps, density=density)
    place(axes, stage)
    return stage


def place(axes: Axes, stage: Stage) -> None:
    """Make the coordinates of axes the pixels of a stage's picture, and take away their frame."""
    axes.set_axis_off()
    axes.set_xlim(0, stage.size[0])
    axes.set_ylim(stage.size[1], 0)


def draw_step(axes: Axes, stage: Stage, plan: Plan, step: int, *, colour: str = "links") -> list[Artist]:
    """Draw the space and the arm at one step; returns what was drawn, so that it can be taken away again."""
    if plan.task.moving:
        stage = set_stage(plan, stage.size, camera=stage.camera, density=stage.density, at=step)
    colours = None if colour == "links" else link_colours(plan, step)
    picture = shoot(stage, plan.centre_line[step], plan.robot.chord_radii, colours, _across(plan, step))
    width, height = stage.size
    image = _Bitmap(axes, extent=(0, width, height, 0), interpolation="nearest", origin="upper", zorder=0)
    image.set_data(_bytes(picture.image))
    axes.add_image(image)
    drawn: list[Artist] = [image]
    for strokes, tone, breadth in (
        (picture.edges_behind, EDGE_BEHIND, 0.5),
        (picture.arm_edges, ARM_EDGE, 0.45),
        (picture.edges, EDGE, 0.6),
    ):
        line = axes.plot(*_broken(strokes).T, color=tone, linewidth=breadth, zorder=1)
        line[0].set_solid_capstyle("round")
        drawn += line
    drawn += _base(axes, stage, plan, step, picture)
    return [*drawn, *_path(axes, stage, plan, picture), *_tip(axes, stage, plan, step)]


def _across(plan: Plan, step: int) -> Floats | None:
    """Half the width and half the height (p, 2, 3) m of flat chords, as vectors; None without any."""
    outline = plan.robot.outline
    if outline.lines is None:
        return None
    return 0.5 * outline.sides[plan.robot.chord_sections][..., None] * outline.lines.axes(plan.outline[step])


class _Bitmap(AxesImage):
    """An image that goes straight onto a canvas whose pixels are its own, without being resampled."""

    @allow_rasterization
    def draw(self, renderer: RendererBase) -> None:
        pixels, box = np.asarray(self.get_array()), self.axes.bbox
        matches = (round(box.height), round(box.width)) == pixels.shape[:2]
        if not (matches and isinstance(renderer, RendererAgg)):
            super().draw(renderer)
            return
        context = renderer.new_gc()
        renderer.draw_image(context, round(box.x0), round(box.y0), pixels[::-1])
        context.restore()
        self.stale = False


def _bytes(image: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return colours 0 to 1 (h, w, 3) as opaque RGBA bytes (h, w, 4), which matplotlib draws fastest."""
    opaque = np.full((*image.shape[:2], 4), 255, np.uint8)
    np.multiply(image, 255, out=opaque[..., :3], casting="unsafe")
    return opaque


def _broken(strokes: Floats) -> Floats:
    """Return strokes (d, 2, 2) as one line (3 d, 2) with gaps between them."""
    return np.concatenate([strokes, np.full((len(strokes), 1, 2), np.nan)], axis=1).reshape(-1, 2)


def link_colours(plan: Plan, step: int) -> Floats:
    """Return one colour a chord (p, 3) by the clearance of its section at a step."""
    share = plan.clearance[step] / plan.horizon
    colours = clearance_colours()(np.where(plan.clearance[step] >= plan.horizon, 2.0, share))[:, :3]
    return colours[plan.robot.chord_sections]


def draw_marks(axes: Axes, stage: Stage, plan: Plan, *, labels: bool = True) -> None:
    """Draw the way-points and, with labels, their numbers and the scale."""
    pixels, _ = stage.camera.project(plan.way_points, stage.size)
    axes.plot(*pixels.T, "o", color=POINT, ms=_DOT, markeredgecolor="white", markeredgewidth=0.6, zorder=5)
    if not labels:
        return
    aside = _ASIDE * beside(pixels)
    for number in numbered(pixels * 72 / axes.figure.dpi):
        label = axes.annotate(
            str(number),
            pixels[number - 1],
            tuple(aside),
            textcoords="offset points",
            fontsize=SMALL,
            color=POINT,
            zorder=6,
        )
        label.set(ha="center", va="center", path_effects=HALO, fontweight="bold")
    _scale(axes, stage.camera, stage.size, float(np.median(stage.camera.project(plan.way_points, stage.size)[1])))


def numbered(places: Floats) -> list[int]:
    """Return the numbers, from 1, of places (k, 2), in points, that are written: of the ends, and what fits between."""
    chosen: list[int] = []
    for k in (len(places), 1, *range(2, len(places))):
        size = (_DIGIT[0] * len(str(k)), _DIGIT[1])
        if all((np.abs(places[k - 1] - places[other - 1]) >= size).any() for other in chosen):
            chosen.append(k)
    return sorted(chosen)


def beside(pixels: Floats) -> Floats:
    """Return which way (2,), right and up, leads aside from a way through pixels (k, 2), and rather up than down.

    A number that stands there seldom covers its neighbours, whichever way they lie.
    """
    right, down = pixels[-1] - pixels[0]
    aside = np.array([down, right]) * (-1.0 if right < 0 else 1.0)
    length = float(np.linalg.norm(aside))
    return aside / length if length > 0 else np.array([0.0, 1.0])


def _base(axes: Axes, stage: Stage, plan: Plan, step: int, picture: Picture) -> list[Artist]:
    """What the arm stands on, in thin lines; they show through obstacles, not through the arm."""
    pieces = np.concatenate([standing_lines(plan.task), workspace_lines(plan.task), mount_at(plan, step)])
    if not len(pieces):
        return []
    lines = sampled(stage.camera, stage.size, pieces)
    shown = np.where(in_sight(lines, picture.depth)[:, None], lines.pixels, np.nan)
    shown = np.insert(shown, np.flatnonzero(np.diff(lines.line)) + 1, np.nan, axis=0)
    return list(axes.plot(*shown.T, color=FAINT, linewidth=0.5, zorder=1))


def _path(axes: Axes, stage: Stage, plan: Plan, picture: Picture) -> list[Artist]:
    points = plan.path.point(np.linspace(0, plan.path.length, 600))
    pixels, depth = stage.camera.project(points, stage.size)
    ahead = depth > 0
    # A touch deeper than it is, so that it does not show through the face of the first link.
    lines = Lines(pixels[ahead], 0.99 / depth[ahead], np.zeros(int(ahead.sum()), dtype=np.int64))
    shown = np.where(in_sight(lines, picture.depth)[:, None], lines.pixels, np.nan)
    return list(axes.plot(*shown.T, color=PATH, linewidth=1.1, zorder=2, path_effects=HALO))


def _tip(axes: Axes, stage: Stage, plan: Plan, step: int) -> list[Artist]:
    pixels, _ = stage.camera.project(plan.joints[step, -1], stage.size)
    return list(
        axes.plot(*pixels, "o", color=TIP, ms=_DOT + 0.6, markeredgecolor="white", markeredgewidth=0.6, zorder=7)
    )


def _scale(axes: Axes, camera: Camera, size: tuple[int, int], depth: float) -> None:
    """Draw the world's axes into the lower right corner, as long as they would be in the picture's middle."""
    pixels_per_metre = size[1] / 2 / camera.half_height / depth
    length = nice_length(0.07 * size[0] / pixels_per_metre)
    arms = camera.axes[:2].T * (1, -1) * length * pixels_per_metre
    point = axes.figure.dpi / 72
    high = arms.clip(min=0).max(axis=0)
    origin = np.array([size[0] - 14 * point - high[0], size[1] - 20 * point - high[1]])
    for arm, name in zip(arms, "xyz", strict=True):
        if np.linalg.norm(arm) < 0.2 * length * pixels_per_metre:
            continue
        axes.plot(*np.stack([origin, origin + arm]).T, color=INK, linewidth=1.1, solid_capstyle="round", zorder=6)
        place = origin + arm * (1 + 7 * point / np.linalg.norm(arm))
        axes.text(
            place[0],
            place[1],
            name,
            fontsize=SMALL,
            color=INK,
            ha="center",
            va="center",
            style="italic",
            zorder=6,
        )
    corner = (size[0] - 8 * point, size[1] - 8 * point)
    axes.text(*corner, f"{length * 1e3:g} mm", fontsize=SMALL, color=FAINT, ha="right", zorder=6)


def nice_length(length: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is no longer than `length`, m."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(step for step in (1, 2, 5) if step * power <= length * (1 + 1e-9)))
