"""A space and the arm in it as a picture: see-through obstacles, shaded links, edges as drawn by hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.report.arm import joint_balls, link_bodies, link_edges
from hognose.report.base_lines import base_points
from hognose.report.camera import THREE_QUARTER, Camera, fitted_either_way, pixels_of
from hognose.report.edges import Edges, drawn, edges_of, normals_of, runs
from hognose.report.raster import keep_nearest, lay_over, shrunk
from hognose.report.solids import drawable
from hognose.report.style import JOINT, LINKS, OBSTACLES, rgb
from hognose.rotations import shortest_turn

if TYPE_CHECKING:
    from hognose.planning.plan import Plan

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Pixels are painted this many times finer each way, then averaged.
FINE = 2
#: Nothing nearer to the eye than this is drawn, m.
_NEAR = 0.01
#: Where the light comes from, along the camera's axes.
_LIGHT = np.array([-0.45, 0.62, -0.64])
#: Share of a depth by which a line may lie behind a surface and still count as on it.
_ON_SURFACE = 1e-4
#: The most that is added to it on surfaces seen at a grazing angle.
_STEEP = 6e-3
#: Opacity of an obstacle's faces: towards the eye, away from it, and walls that would hide the inside.
_FACING, _AWAY, _VEIL = 0.34, 0.12, 0.05
#: An obstacle whose box holds this share of the path is a room, not an obstacle in the way.
_ROOM = 0.2


class Layer(NamedTuple):
    """Triangles as a camera sees them: pixels (k, 3, 2), nearness (k, 3) 1/m, colours, opacity (k,)."""

    pixels: Floats
    nearness: Floats
    colours: Floats
    opacity: Floats


@dataclass(frozen=True)
class Lines:
    """Lines as sample points: pixels (p, 2), nearness (p,) 1/m, and the line each belongs to (p,)."""

    pixels: Floats
    nearness: Floats
    line: Ints


@dataclass(frozen=True)
class Stage:
    """All that stays as it is while the arm moves.

    Attributes
    ----------
    camera
    size
        Width and height of the picture, pixels.
    solids
        The obstacles' faces, the farthest first.
    backdrop : (FINE height, FINE width, 3) float
        The obstacles without the arm, on the finer grid of pixels.
    still : (height, width, 3) float
        The same on the picture's own pixels.
    outlines
        The obstacles' edges.
    plain : (p,) bool
        Which samples of them no obstacle hides.
    arm
        How the triangles of the links hang together.
    sections : (p,) int
        The section of each chord of the body.
    smooth : (p - 1,) bool
        At which inner ends of the chords the body goes on without a joint.
    density
        How opaque the obstacles are.
    """

    camera: Camera
    size: tuple[int, int]
    solids: Layer
    backdrop: NDArray[np.float32]
    still: NDArray[np.float32]
    outlines: Lines
    plain: NDArray[np.bool_]
    arm: Edges
    sections: Ints
    smooth: NDArray[np.bool_]
    density: float = 1.0


@dataclass(frozen=True)
class Picture:
    """One view of the arm in its space.

    Attributes
    ----------
    image : (height, width, 3) float, 0 to 1
    depth : (FINE height, FINE width) float, 1/m
        Nearness of the arm; zero where it is not.
    edges, edges_behind, arm_edges : (d, 2, 2) float, pixels
        Edges of obstacles that are in plain sight, those behind faces of obstacles, and those of the arm.
    """

    image: NDArray[np.float32]
    depth: NDArray[np.float32]
    edges: Floats
    edges_behind: Floats
    arm_edges: Floats


def relevant_points(plan: Plan, steps: ArrayLike) -> Floats:
    """Return what a picture should show (k, 3) m: the arm at steps, its base, the path, and obstacles nearby."""
    reach = float(plan.robot.body_radii.max())
    path = plan.path.point(np.linspace(0, plan.path.length, 50))
    body = np.concatenate([plan.joints[np.atleast_1d(steps)].reshape(-1, 3), path])
    body = np.concatenate([body - reach, body + reach])
    corners = plan.task.placed_scene.triangles.reshape(-1, 3)
    low, high = path.min(axis=0), path.max(axis=0)
    around = 0.35 * float(np.linalg.norm(high - low))
    return np.concatenate([body, base_points(plan), np.clip(corners, low - around, high + around)])


def with_the_arm(plan: Plan, towards_eye: ArrayLike) -> Floats:
    """Return a direction (3,) meant for an arm that enters along +z, turned the shortest way to where this one does."""
    return shortest_turn(plan.task.base.direction) @ np.asarray(towards_eye, dtype=float)


def set_stage(
    plan: Plan,
    size: tuple[int, int],
    *,
    camera: Camera | None = None,
    towards_eye: ArrayLike = THREE_QUARTER,
    steps: ArrayLike = (0, -1),
    density: float = 1.0,
    at: int = 0,
) -> Stage:
    """Prepare all that stays as it is while the arm moves.

    Parameters
    ----------
    plan
    size
        Width and height of the picture, pixels.
    camera
        Where to look from; without it the one that sees everything that matters at `steps`, with +y up, or with an
        arm that enters upright lying along the picture if that makes it much larger.
    towards_eye : (3,) float
        The direction of that camera, from the subject, if the arm enters along +z; it turns with the arm.
    steps
        Steps of the plan that must be in the picture.
    density
        How opaque the obstacles are: 1 as usual, less where many lie behind each other.
    at
        The step at which obstacles that move are drawn.
    """
    camera = camera or fitted_either_way(
        relevant_points(plan, steps),
        size,
        towards_eye=with_the_arm(plan, towards_eye),
        otherwise_up=with_the_arm(plan, (0.0, 1.0, 0.0)),
    )
    triangles, owner, edged = drawable(plan.scene_at(at))
    tones = rgb([OBSTACLES[i % len(OBSTACLES)] for i in range(max(len(plan.task.placed_scene.names), 1))])
    solids = _seen(camera, size, triangles, tones[owner], density * _opacities(plan, triangles, owner, camera))
    order = np.argsort(solids.nearness.mean(axis=1), kind="stable")
    solids = Layer(*(values[order] for values in solids))
    outlines = sampled(camera, size, drawn(edges_of(triangles[:edged], owner[:edged]), triangles, camera.eye))
    backdrop = np.ones((size[1] * FINE, size[0] * FINE, 3), np.float32)
    front = np.zeros(backdrop.shape[:2], np.float32)
    lay_over(*solids, backdrop, np.zeros_like(front), front, density * _VEIL * 1.01)
    plain, sections = in_sight(outlines, front), plan.robot.chord_sections
    smooth = plan.robot.model.smooth(plan.robot.link_lengths)
    arm = link_edges(len(sections), smooth & (np.diff(sections) == 0))
    still = shrunk(backdrop, FINE)
    return Stage(camera, size, solids, backdrop, still, outlines, plain, arm, sections, smooth, density)


def shoot(
    stage: Stage,
    vertices: ArrayLike,
    radii: ArrayLike,
    colours: Floats | None = None,
    across: ArrayLike | None = None,
) -> Picture:
    """Return the picture of the arm in a pose.

    Parameters
    ----------
    stage
    vertices : (p + 1, 3) float, m
        Ends of the chords of the body.
    radii : (p,) float, m
        Of the body round each chord.
    colours : (p, 3) float, 0 to 1
        Of the chords; without them, two tones of the sections in turn.
    across
        Of flat ones, as of `link_bodies`; balls in joints are as thick as these are.
    """
    bodies, thick = link_bodies(vertices, radii, across), np.asarray(radii, dtype=float)
    if across is not None:
        thin = np.linalg.norm(across, axis=2).min(axis=1)
        thick = np.where(thin > 0, thin, thick)
    balls = joint_balls(vertices, thick, stage.smooth)
    if colours is None:
        colours = rgb([LINKS[i % len(LINKS)] for i in stage.sections])
    of_balls = np.where(stage.smooth[:, None], colours[:-1], rgb([JOINT]))
    tones = np.concatenate([np.repeat(colours, bodies.shape[1], axis=0), np.repeat(of_balls, balls.shape[1], axis=0)])
    bodies = bodies.reshape(-1, 3, 3)
    closed = np.concatenate([bodies, balls.reshape(-1, 3, 3)])
    facing = np.einsum("ij,ij->i", normals_of(closed), stage.camera.eye - closed[:, 0]) > 0
    arm = _seen(stage.camera, stage.size, closed[facing], tones[facing])
    image, depth = _painted(stage, arm)
    lines = sampled(stage.camera, stage.size, drawn(stage.arm, bodies, stage.camera.eye))
    of_arm, of_solids = in_sight(lines, depth), in_sight(stage.outlines, depth)
    edges, behind = _strokes(stage.outlines, of_solids * (1 + stage.plain.astype(np.int64)))
    return Picture(image, depth, edges, behind, _strokes(lines, 2 * of_arm.astype(np.int64))[0])


def _painted(stage: Stage, arm: Layer) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the image and the arm's depth; only what the arm covers of the backdrop is painted anew."""
    image, depth = stage.still.copy(), np.zeros(stage.backdrop.shape[:2], np.float32)
    limit = np.array(stage.size)
    low = np.clip(np.floor(arm.pixels.min(axis=(0, 1)) / FINE), 0, limit).astype(np.int64)
    high = np.clip(np.ceil(arm.pixels.max(axis=(0, 1)) / FINE), low, limit).astype(np.int64)
    fine = np.s_[low[1] * FINE : high[1] * FINE, low[0] * FINE : high[0] * FINE]
    part, near = stage.backdrop[fine].copy(), depth[fine].copy()
    keep_nearest(arm.pixels - low * FINE, arm.nearness, arm.colours, part, near)
    solids = stage.solids._replace(pixels=stage.solids.pixels - low * FINE)
    lay_over(*solids, part, np.where(near > 0, near, np.float32(-1)), near.copy(), 1.0)
    depth[fine] = near
    image[low[1] : high[1], low[0] : high[0]] = shrunk(part, FINE)
    return image, depth


def sampled(camera: Camera, size: tuple[int, int], lines: Floats) -> Lines:
    """Return points every few pixels along straight lines (d, 2, 3) m, as the camera sees them."""
    seen = (lines - camera.eye) @ camera.axes.T
    depth = seen[..., 2]
    seen, depth = seen[depth.max(axis=1) > _NEAR], depth[depth.max(axis=1) > _NEAR]
    rise = np.where(depth < _NEAR, depth[:, ::-1] - depth, np.inf)
    seen = seen + ((_NEAR - depth) / rise)[..., None] * (seen[:, ::-1] - seen)
    pixels = pixels_of(seen, camera.half_height, size)
    count = np.clip(np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1) / 3, 1, 2000).astype(np.int64) + 2
    line = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count)
    share = (place / (count[line] - 1))[:, None]
    nearness = 1 / seen[..., 2]
    return Lines(
        pixels[line, 0] * (1 - share) + pixels[line, 1] * share,
        nearness[line, 0] * (1 - share[:, 0]) + nearness[line, 1] * share[:, 0],
        line,
    )


def in_sight(lines: Lines, depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return which samples (p,) are not hidden by the surfaces of a depth image."""
    pixels = np.nan_to_num(np.clip(lines.pixels * FINE, -1e6, 1e6)).astype(np.int64)
    # A line on the rim of a body must not be hidden by the body's own pixels beside it, nor one in a corner
    # by the walls that come forward from it.
    beside = [
        depth[
            np.clip(pixels[:, 1] + dy, 0, depth.shape[0] - 1),
            np.clip(pixels[:, 0] + dx, 0, depth.shape[1] - 1),
        ]
        for dx, dy in ((0, 0), (-2, 0), (2, 0), (0, -2), (0, 2))
    ]
    low, high = np.min(beside, axis=0), np.max(beside, axis=0)
    slack = np.minimum(0.4 * (high - low), _STEEP * high) + _ON_SURFACE * high
    return lines.nearness >= low - slack


def _strokes(lines: Lines, state: Ints) -> tuple[Floats, Floats]:
    """Return the stretches in state 2 and those in state 1, each (d, 2, 2) pixels."""
    if not len(state):
        return np.empty((0, 2, 2)), np.empty((0, 2, 2))
    first, last = runs(state, lines.line)
    ends = np.stack([lines.pixels[first], lines.pixels[last]], axis=1)
    return ends[state[first] == 2], ends[state[first] == 1]


def _opacities(plan: Plan, triangles: Floats, owner: NDArray[np.integer], camera: Camera) -> Floats:
    """Return how opaque each triangle of the scene is drawn (k,); near walls of rooms are mere veils."""
    normals, middles = normals_of(triangles), triangles.mean(axis=1)
    facing = np.einsum("ij,ij->i", normals, camera.eye - middles) > 0
    opacity = np.where(facing, _FACING, _AWAY)
    path = plan.path.point(np.linspace(0, plan.path.length, 200))
    for i in range(len(plan.task.placed_scene.names)):
        mine = owner == i
        if not mine.any():
            continue
        corners = triangles[mine].reshape(-1, 3)
        inside = ((path > corners.min(axis=0)) & (path < corners.max(axis=0))).all(axis=1)
        if inside.mean() > _ROOM:
            inward = np.einsum("ij,ij->i", normals, path[inside].mean(axis=0) - middles) > 0
            opacity[mine] = np.where(facing & inward, _FACING, _VEIL)[mine]
    return opacity


def _seen(
    camera: Camera, size: tuple[int, int], triangles: Floats, colours: Floats, opacity: Floats | None = None
) -> Layer:
    """Return triangles (k, 3, 3) m as the camera sees them, lit, on the finer grid of pixels."""
    lit = np.abs(normals_of(triangles) @ camera.axes.T @ _LIGHT)[:, None]
    shaded = np.clip(colours * (0.62 + 0.46 * lit), 0, 1)
    opacity = np.ones(len(triangles)) if opacity is None else opacity
    seen, source = before_eye((triangles - camera.eye) @ camera.axes.T)
    fine = (size[0] * FINE, size[1] * FINE)
    return Layer(pixels_of(seen, camera.half_height, fine), 1 / seen[..., 2], shaded[source], opacity[source])


def before_eye(seen: Floats) -> tuple[Floats, Ints]:
    """Return the parts of triangles (k, 3, 3) that lie before the eye, and the triangle each comes from."""
    ahead = (seen[..., 2] > _NEAR).sum(axis=1)
    parts, sources = [seen[ahead == 3]], [np.flatnonzero(ahead == 3)]
    for i in np.flatnonzero((ahead > 0) & (ahead < 3)):
        corners = []
        for a, b in zip(seen[i], np.roll(seen[i], -1, axis=0), strict=True):
            if a[2] > _NEAR:
                corners.append(a)
            if (a[2] > _NEAR) != (b[2] > _NEAR):
                corners.append(a + (_NEAR - a[2]) / (b[2] - a[2]) * (b - a))
        fan = [np.stack([corners[0], *corners[j : j + 2]]) for j in range(1, len(corners) - 1)]
        parts.append(np.stack(fan))
        sources.append(np.full(len(fan), i))
    return np.concatenate(parts), np.concatenate(sources)
