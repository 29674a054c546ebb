"""What a camera on the tip sees: the space lit by a lamp beside the lens, as the pictures of a real one show it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hognose.report.camera import Camera, pixels_of
from hognose.report.figures import steps_at
from hognose.report.raster import keep_nearest, shrunk
from hognose.report.render import FINE, before_eye
from hognose.report.solids import drawable
from hognose.report.style import HEAD, INK, OBSTACLES, new_figure, rgb
from hognose.robot.tip_camera import ANGLE_OF_VIEW_DEG

if TYPE_CHECKING:
    from hognose.planning import Task
    from hognose.planning.plan import Plan
    from hognose.scene import Scene

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

#: Where no light comes back from, 0 to 1.
DARK = (0.05, 0.06, 0.08)
#: The distance (m) at which the lamp gives half of what it gives close by.
_REACH = 0.45
#: How bright a surface across the sight is close by, and what it has without the lamp.
_LAMP, _AMBIENT = 1.18, 0.10
#: Faces that differ more than this in direction, or in distance (share of it), have a line between them.
_FOLD, _GAP = np.cos(np.radians(25.0)), 0.04
#: How much of its light is left on such a line.
_LINE = 0.55


def tip_camera(plan: Plan, step: int) -> Camera:
    """Return a camera in the middle of the tip, which looks along the last link and turns with it; its y is up."""
    return camera_at(plan.task, plan.at[step], plan.angles[step], plan.body[step, -1])


def camera_at(task: Task, at: Floats, angles: Floats, tip: Floats) -> Camera:
    """Return the camera of an arm with its base at (k,), at angles (n, 2) rad, with its tip at (3,) m; see above."""
    frame = task.robot.tip_pose(angles)[:3, :3]
    right, up, sight = task.base.turned((frame * (-1.0, 1.0, 1.0)).T[None], at[None])[0]
    return Camera(tip, np.stack([right, up, sight]), float(np.tan(np.radians(0.5 * ANGLE_OF_VIEW_DEG))))


def tip_picture(plan: Plan, step: int, size: tuple[int, int] = (640, 480)) -> Pixels:
    """Return the picture (height, width, 3) of the camera on the tip at a step; size is width and height in pixels."""
    return photograph(plan.scene_at(step), tip_camera(plan, step), size)


def photograph(scene: Scene, camera: Camera, size: tuple[int, int]) -> Pixels:
    """Return the picture (height, width, 3) of a scene, lit from where the camera stands.

    A surface is the darker, the farther it is and the more it is turned away; what is open is `DARK`.
    """
    triangles, owner, _ = drawable(scene)
    image = np.full((size[1] * FINE, size[0] * FINE, 3), DARK)
    if not len(triangles):
        return _bytes(image)
    fine = (image.shape[1], image.shape[0])
    seen, source = before_eye((triangles - camera.eye) @ camera.axes.T)
    number, depth = np.full(image.shape, -1.0), np.zeros(image.shape[:2])
    names = np.repeat(source[:, None].astype(float), 3, axis=1)
    keep_nearest(pixels_of(seen, camera.half_height, fine), 1 / seen[..., 2], names, number, depth)
    hit = depth > 0
    face = number[..., 0].astype(np.int64)
    tones = rgb([OBSTACLES[i % len(OBSTACLES)] for i in range(int(owner.max()) + 1)])
    normals = _normals((triangles[:, 1:] - triangles[:, :1]) @ camera.axes.T)
    light = _light(normals[face], depth, camera.half_height)
    image[hit] = (tones[owner[face]] * light[..., None])[hit]
    return _bytes(image * np.where(_lines(normals[face], depth), _LINE, 1.0)[..., None])


def tip_pictures(plan: Plan, times: Sequence[float] | None = None) -> Figure:
    """Return what the camera on the tip sees at instants (s), side by side; errors as of `instants`."""
    steps = steps_at(plan, times)
    each, foot, title = 2.35, 0.04, 0.24
    height, width = 0.75 * each, foot + (each + foot) * len(steps)
    tall = height + title + foot
    figure = new_figure(width, tall, 160.0)
    pixels = (round(each * 160), round(height * 160))
    for k, step in enumerate(steps):
        left = foot + k * (each + foot)
        axes = figure.add_axes((left / width, foot / tall, each / width, height / tall))
        axes.imshow(tip_picture(plan, step, pixels), aspect="auto")
        axes.set_axis_off()
        figure.text(left / width, 1 - 0.05 / tall, f"({chr(97 + k)})  t = {plan.time[step]:.2f} s", fontsize=HEAD,
                    color=INK, va="top")  # fmt: skip
    return figure


def _normals(edges: Floats) -> Floats:
    """Return the unit normals (k, 3) of triangles with two edges (k, 2, 3) each, towards either side."""
    normals = np.cross(edges[:, 0], edges[:, 1])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)


def _light(normals: Floats, depth: Floats, half_height: float) -> Floats:
    """Return how bright every pixel (h, w) is, of the normals (h, w, 3) and the nearness (h, w) 1/m seen there."""
    height, width = depth.shape
    focal = height / 2 / half_height
    across = (np.arange(width) + 0.5 - width / 2) / focal
    up = (height / 2 - np.arange(height) - 0.5) / focal
    ray = np.stack([*np.meshgrid(across, up), np.ones(depth.shape)], axis=-1)
    length = np.linalg.norm(ray, axis=-1)
    facing = np.abs(np.einsum("hwc,hwc->hw", normals, ray)) / length
    away = length / np.maximum(depth, 1e-9)
    return _AMBIENT / (1 + away / _REACH) + _LAMP * (0.25 + 0.75 * facing) / (1 + (away / _REACH) ** 2)


def _lines(normals: Floats, depth: Floats) -> NDArray[np.bool_]:
    """Return the pixels (h, w) at which surfaces fold or end."""
    found = np.zeros(depth.shape, bool)
    for here, there in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        one, other = depth[here], depth[there]
        fold = np.abs(np.einsum("hwc,hwc->hw", normals[here], normals[there])) < _FOLD
        found[here] |= (one > 0) & (fold | (np.abs(one - other) > _GAP * np.maximum(one, other)))
    return found


def _bytes(image: Floats) -> Pixels:
    return np.round(255 * np.clip(shrunk(image, FINE), 0, 1)).astype(np.uint8)
