"""A stand-in for a plan: three boards with staggered holes, or a tank with pipes, and an arm stepping in."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import manifold3d as m3
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from hognose.planning import Check
from hognose.planning.base_spec import BaseSpec
from hognose.planning.motion_spec import MotionSpec
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot import Outline
from hognose.robot.sections import RIGID_LINK

PITCH, LINKS, RADIUS, HORIZON = 0.091, 12, 0.0225, 0.05


@dataclass(frozen=True)
class Robot:
    name: str = "sjtu-25dof"
    link_lengths: Any = field(default_factory=lambda: np.full(LINKS, PITCH))
    body_radii: Any = field(default_factory=lambda: np.full(LINKS, RADIUS))
    bend_limits: Any = field(default_factory=lambda: np.full((LINKS, 2), 0.5))
    cable_sections: Any = field(default_factory=lambda: np.repeat(np.arange(LINKS), 3))
    chord_sections: Any = field(default_factory=lambda: np.arange(LINKS))
    assumed: tuple[str, ...] = ("tool_length = 100 mm", "gear ratio = 19 : 1")
    extends: bool = False

    @property
    def straight_cable_lengths(self) -> Any:
        return _cables(np.zeros((1, LINKS, 2)))[0]

    @property
    def bend_bounds(self) -> Any:
        return np.stack([-self.bend_limits, self.bend_limits], axis=-1)

    @property
    def chord_radii(self) -> Any:
        return self.body_radii

    @property
    def outline(self) -> Any:
        none = np.zeros((LINKS, 2))
        return Outline(self.chord_sections, self.body_radii, self.body_radii, none, none)

    @property
    def model(self) -> Any:
        return RIGID_LINK


@dataclass(frozen=True)
class Base:
    direction: Any = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    mount: None = None


@dataclass(frozen=True)
class Spec:
    base: BaseSpec = field(default_factory=BaseSpec)
    motion: MotionSpec = field(default_factory=MotionSpec)
    tolerance: ToleranceSpec = field(default_factory=ToleranceSpec)
    obstacle: tuple[object, ...] = ()


@dataclass(frozen=True)
class Task:
    name: str = "boards"
    margin: float = 0.005
    budget: None = None
    mechanics: None = None
    remarks: tuple[str, ...] = ()
    base: Base = Base()
    spec: Spec = Spec()
    moving: tuple[object, ...] = ()
    placed_scene: Any = None


@dataclass(frozen=True)
class Path:
    at: Any
    length: float

    def point(self, s):
        return self.at(np.asarray(s))


@dataclass(frozen=True)
class Scene:
    triangles: Any
    owner: Any
    names: tuple[str, ...]


@dataclass(frozen=True)
class StandIn:
    robot: Robot
    task: Task
    scene: Scene
    path: Path
    way_points: Any
    time: Any
    feed: Any
    joints: Any
    angles: Any
    cable_lengths: Any
    motor_counts: Any
    clearance: Any
    tip_error: Any
    body_deviation: Any
    checks: tuple[Check, ...]
    horizon: float = HORIZON
    certified_clearance: float | None = None
    retracts: bool = False

    @property
    def commanded_lengths(self) -> Any:
        return self.cable_lengths

    @property
    def centre_line(self) -> Any:
        return self.joints

    def scene_at(self, step: int) -> Scene:
        return self.scene

    @property
    def good(self) -> bool:
        return all(check.ok for check in self.checks)

    @property
    def remarks(self) -> list[str]:
        return list(self.task.remarks)

    def verified(self) -> StandIn:
        """What was checked once is not checked again: these are no plans."""
        return self

    def summary(self) -> str:
        return f"{self.task.name}: {'good' if self.good else 'not good'}"


def _arc_length_curve(way_points):
    """Return the straight run of the slider and a spline through the way-points, by arc length."""
    run = LINKS * PITCH
    knots = np.vstack([[0, 0, -run], [0, 0, -run / 2], [0, 0, -0.1], [0, 0, 0], way_points[1:]])
    chords = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    spline = CubicSpline(chords, knots, bc_type="natural")
    dense = spline(np.linspace(0, chords[-1], 8001))
    dense[dense[:, 2] < 0, :2] = 0
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    return Path(lambda s: np.stack([np.interp(s, lengths, dense[:, k]) for k in range(3)], -1), lengths[-1])


def _follow(path, feeds):
    s = np.linspace(0, path.length + 0.3, 12000)
    end, before = path.point(path.length), path.point(path.length - 1e-3)
    extension = np.maximum(s - path.length, 0)[:, None] * (end - before) / 1e-3
    points = path.point(np.minimum(s, path.length)) + extension
    joints = np.empty((len(feeds), LINKS + 1, 3))
    for t, feed in enumerate(feeds):
        joints[t, 0], start = path.point(feed), int(np.searchsorted(s, feed))
        for i in range(LINKS):
            away = np.linalg.norm(points[start:] - joints[t, i], axis=1)
            hit = start + int(np.argmax(away >= PITCH))
            direction = points[hit] - joints[t, i]
            joints[t, i + 1] = joints[t, i] + PITCH * direction / np.linalg.norm(direction)
            start = hit
    return joints


def _angles(joints):
    out = np.empty((len(joints), LINKS, 2))
    for t, chain in enumerate(joints):
        frame = np.eye(3)
        for i in range(LINKS):
            x, y, z = frame.T @ (chain[i + 1] - chain[i]) / PITCH
            alpha, beta = np.arctan2(x, z), np.arcsin(np.clip(-y, -1, 1))
            ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
            frame = frame @ np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]])
            frame = frame @ np.array([[1, 0, 0], [0, cb, -sb], [0, sb, cb]])
            out[t, i] = alpha, beta
    return out


def _deviation(path, joints):
    """Distance of each link's middle to the closest of dense points."""
    points = path.point(np.linspace(0, path.length, 6000))
    middles = (joints[:, 1:] + joints[:, :-1]) / 2
    return np.array([[np.linalg.norm(points - m, axis=1).min() for m in row] for row in middles])


def _cables(angles):
    section = np.repeat(np.arange(LINKS), 3)
    azimuth = np.radians(50 - 10 * section - 120 * np.tile([0, 1, 2], LINKS))
    bend = np.cumsum(angles, axis=1)[:, section]
    change = -0.019 * (bend[..., 0] * np.cos(azimuth) - bend[..., 1] * np.sin(azimuth))
    return PITCH * (section + 1) + change


def _triangles(solid):
    mesh = solid.to_mesh()
    return np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts)].astype(float)


def _scene(solids):
    parts = [_triangles(solid) for solid in solids.values()]
    owner = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    return Scene(np.concatenate(parts), owner, tuple(solids))


def _boards(holes):
    solids, distances = {}, []
    for i, (x, y, z) in enumerate(holes):
        plate = m3.Manifold.cube((0.6, 0.6, 0.01), True).translate((0, 0, z))
        hole = m3.Manifold.cylinder(0.1, 0.05, circular_segments=64, center=True).translate((x, y, z))
        solids[f"board-{i + 1}"] = plate - hole
        distances.append(
            lambda p, x=x, y=y, z=z: np.maximum(
                np.abs(p[..., 2] - z) - 0.005, 0.05 - np.hypot(p[..., 0] - x, p[..., 1] - y)
            )
        )
    return solids, distances


def _tank():
    box = m3.Manifold.cube((0.8, 0.8, 1.0), True).translate((0, 0, 0.52))
    inside = m3.Manifold.cube((0.77, 0.77, 0.97), True).translate((0, 0, 0.52))
    hole = m3.Manifold.cylinder(0.2, 0.06, circular_segments=64, center=True).scale((1, 1.5, 1))
    solids, distances = {"tank": box - inside - hole}, []
    for i, (y, z) in enumerate([(-0.13, 0.42), (0.13, 0.5), (0.06, 0.86)]):
        pipe = m3.Manifold.cylinder(0.77, 0.05, circular_segments=48, center=True)
        solids[f"pipe-{i + 1}"] = pipe.rotate((0, 90, 0)).translate((0, y, z))
        distances.append(lambda p, y=y, z=z: np.hypot(p[..., 1] - y, p[..., 2] - z) - 0.05)
    return solids, distances


def make_plan(case: str = "boards", steps: int = 313, names: tuple[str, ...] | None = None) -> Any:
    """Return a stand-in plan of `steps` steps through the boards or into the tank."""
    if case == "boards":
        way_points = np.array([[0, 0, 0], [0.0, 0.0, 0.06], [0.09, 0.05, 0.5], [-0.02, -0.06, 0.94], [0, 0.02, 1.07]])
        solids, distances = _boards(way_points[1:4])
    else:
        way_points = np.array([[0, 0, 0], [0.05, 0.0, 0.45], [0.1, 0.14, 0.76], [0.12, 0.22, 0.9]])
        solids, distances = _tank()
    scene = _scene(solids if names is None else dict(zip(names, solids.values(), strict=False)))
    path = _arc_length_curve(way_points)
    time = 0.15 * np.arange(steps)
    feed = np.linspace(0, path.length - LINKS * PITCH - 1e-3, steps)
    joints = _follow(path, feed)
    angles = _angles(joints)
    cables = _cables(angles)
    along = np.linspace(0, 1, 9)[:, None]
    bodies = joints[:, :-1, None] * (1 - along) + joints[:, 1:, None] * along
    clearance = np.min([distance(bodies).min(-1) for distance in distances], axis=0) - RADIUS
    clearance = np.minimum(clearance, HORIZON)
    step, section = np.unravel_index(np.argmin(clearance), clearance.shape)
    checks = (
        Check("clearance", "clearance", bool(clearance.min() >= 0.005), float(clearance.min()), 0.005, "m", int(step),
              int(section) + 1, at_least=True, detail="to board-2"),
        Check("bend_angle", "bend angle", True, float(np.abs(angles).max()), 0.5, "rad", 3, 12),
        Check("joint_speed", "joint speed", True, 0.054, 0.35, "rad/s", 2, 3),
        Check("tip_error", "tip error", True, 2e-13, 0.0005, "m"),
    )  # fmt: skip
    error = np.where(np.arange(steps) % 7 == 0, 0.0, 1e-13 * (1 + np.arange(steps) % 5))
    return StandIn(
        Robot(), Task(case, placed_scene=scene), scene, path, way_points, time, feed, joints, angles, cables,
        np.round((cables - cables[0]) * 2e6).astype(int), clearance, error, _deviation(path, joints), checks,
    )  # fmt: skip


@pytest.fixture(scope="session")
def boards() -> Any:
    return make_plan("boards", 61)


@pytest.fixture(scope="session")
def tank() -> Any:
    return make_plan("tank", 31)


@pytest.fixture(scope="session")
def stand_in() -> Any:
    return make_plan
