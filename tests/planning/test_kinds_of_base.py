"""Every kind of base with tolerances, with obstacles that move, and with both, by an oracle of dense poses."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from planning_makers import variant
from scipy.spatial.transform import Rotation, Slerp

import hognose
from hognose.errors import InfeasibleError
from hognose.planning import Plan, Task
from hognose.planning.certificate.bound import TIGHTNESS
from hognose.robot.base import joints_on
from hognose.scene import Sphere
from hognose.steering import SteeredPath

pytestmark = pytest.mark.slow

SHORT = [[0, 0, 0], [0.02, 0.04, 0.25], [-0.03, 0.05, 0.55]]
#: A way that is longer than the arm, so that a carrier follows into its bends.
LONG = [[0, 0, 0], [0.03, 0.06, 0.3], [-0.03, 0.05, 0.7], [0.0, -0.1, 1.1], [0.1, -0.2, 1.5]]
KINDS = {
    "slider": ({"kind": "slider"}, SHORT),
    "cart": ({"kind": "cart", "position": [0.01, 0.0, -1.25]}, SHORT),
    "drum": ({"kind": "drum", "radius": 0.24, "nozzle": 0.1}, SHORT),
    "carrier": ({"kind": "arm"}, LONG),
}
SIGMA = {"cad": 0.001, "registration": 0.0005}
TOLERANCES = {"none": {}, "placed": SIGMA, "turned": {**SIGMA, "registration_deg": 0.05}}
RADIUS, SPEED, APART, PIECES = 0.03, 0.1, 0.02, 10
#: By so much (m) meshes of balls stick out at most.
STICKS_OUT = 1e-4


def task_of(kind: str, tolerance: str, obstacles: list[dict[str, Any]]) -> Task:
    """A small task on a base, slow enough for all limits."""
    base, way = KINDS[kind]
    changes = {"base": base, "path.way_points": way, "obstacle": obstacles, "tolerance": TOLERANCES[tolerance]}
    changes |= {"motion.step": 0.014, "motion.period_s": 1.0, "path.detour": False}
    return variant(hognose.load_task("pipe-tank"), changes)


def posed(plan: Plan, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bodies (m, n+2, 3), the far end of the mount in front, and times (m,), at shares (m,) of the rows."""
    rows = np.arange(len(plan.time))
    times = np.interp(shares, rows, plan.time)
    flat = plan.angles.reshape(len(rows), -1)
    angles = np.stack([np.interp(shares, rows, each) for each in flat.T], axis=1).reshape(len(shares), -1, 2)
    if plan.base_pose is None:
        feeds = np.interp(shares, rows, plan.feed)
        joints = joints_on(plan.task.base, plan.robot, angles, feeds[:, None])
        along = np.broadcast_to([0.0, 0.0, 1.0], joints[:, 0].shape)
    else:
        turned = Slerp(rows, Rotation.from_quat(plan.base_pose[:, 3:], scalar_first=True))(shares)
        places = np.stack([np.interp(shares, rows, each) for each in plan.base_pose[:, :3].T], axis=1)
        own = plan.robot.joint_positions(angles, np.zeros(len(shares)))
        joints = np.stack([turned.apply(own[:, k]) for k in range(own.shape[1])], axis=1) + places[:, None]
        along = turned.apply([0.0, 0.0, 1.0])
    far = joints[:, :1] - plan.robot.spec.base_length * along[:, None]
    return np.concatenate([far, joints], axis=1), times


def to_segments(starts: np.ndarray, ends: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distances (m, p) of segments (m, p, 3) from a point each (m, 3)."""
    ways, seen = ends - starts, points[:, None] - starts
    share = np.clip((seen * ways).sum(axis=2) / (ways**2).sum(axis=2), 0.0, 1.0)
    return np.linalg.norm(seen - share[..., None] * ways, axis=2)


def left(plan: Plan, shares: np.ndarray) -> tuple[float, float]:
    """What tolerances leave of the clearances of the mount and of the links, in closed form: the smallest of each."""
    bodies, times = posed(plan, shares)
    found = np.full((len(shares), bodies.shape[1] - 1), np.inf)
    for item in plan.task.spec.obstacle:
        assert isinstance(item, Sphere)
        centres = np.tile(np.array(item.center, dtype=float), (len(times), 1))
        if item.motion:
            knots = [each.time_s for each in item.motion]
            places = np.array([each.position for each in item.motion])
            centres = centres + np.stack([np.interp(times, knots, each) for each in places.T], axis=1)
        found = np.minimum(found, to_segments(bodies[:, :-1], bodies[:, 1:], centres) - RADIUS)
    found -= np.append(plan.robot.body_radii[0], plan.robot.body_radii)
    said = plan.task.spec.tolerance
    if said.cad:
        levers = np.linalg.norm(bodies - plan.task.base.start, axis=2)
        spread = np.hypot(said.registration, np.radians(said.registration_deg) * levers)
        found -= said.cad + 2.0 * np.maximum(spread[:, :-1], spread[:, 1:])
    return float(found[:, 0].min()), float(found[:, 1:].min())


def ball(place: np.ndarray, moves: bool, when: float, aside: np.ndarray, last: float) -> dict[str, Any]:
    """A ball at a place, always or only then: it comes along `aside` and goes on."""
    made: dict[str, Any] = {"kind": "sphere", "center": place.tolist(), "diameter": 2 * RADIUS}
    if moves:
        times = (-1.0, last + 1.0)
        made["motion"] = [{"time_s": t, "position": (SPEED * (t - when) * aside).tolist()} for t in times]
    return made


def beside(plan: Plan, moves: bool) -> list[dict[str, Any]]:
    """Balls beside a link and beside the mount; and one that comes through where the mount was at the beginning."""
    bodies, times = posed(plan, np.arange(len(plan.time), dtype=float))
    middle, last, found = len(times) // 2, float(times[-1]), []
    for segment in (0, 8) if plan.task.base.mount else (8,):
        start, end = bodies[middle, segment : segment + 2]
        axis = (end - start) / np.linalg.norm(end - start)
        aside = np.cross(axis, [1.0, 0.0, 0.0])
        aside /= np.linalg.norm(aside)
        away = RADIUS + plan.robot.body_radii[0] + APART
        place = 0.5 * (start + end) + away * np.cross(axis, aside)
        found.append({"name": f"ball {segment}", **ball(place, moves, float(times[middle]), aside, last)})
    if moves and plan.task.base.mount:
        place = bodies[0, :2].mean(axis=0)
        found.append({"name": "late", **ball(place, True, last, np.array([0.0, 1.0, 0.0]), last)})
    return found


@pytest.fixture(scope="module")
def bare() -> dict[str, Plan]:
    """Plans in empty space, by the kind of base."""
    return {kind: hognose.plan(task_of(kind, "none", [])) for kind in KINDS}


CELLS = [cell for cell in itertools.product(KINDS, TOLERANCES, (False, True)) if cell[1:] != ("none", False)]


@pytest.mark.parametrize(("kind", "tolerance", "moves"), CELLS)
def test_what_is_certified_is_kept_by_dense_poses(bare, kind, tolerance, moves):
    plan = hognose.plan(task_of(kind, tolerance, beside(bare[kind], moves)))
    assert plan.good
    rows = np.arange(len(plan.time) - 1.0 + 1e-9, step=1.0 / PIECES)
    mount, links = left(plan, rows)
    proven = plan.check("certified_interpolated").value
    assert proven <= links + 1e-9
    assert proven >= min(links, plan.horizon) - TIGHTNESS - STICKS_OUT
    at_steps = left(plan, np.arange(len(plan.time), dtype=float))[1]
    for key in ("certified_along_path", "certified_cables"):
        assert plan.check(key).value <= at_steps + 1e-5  # counts of motors are rounded
    if plan.task.base.mount is not None:
        proven = plan.check("clearance_of_mount").value
        assert proven <= mount + 1e-9
        # What stands is tested against all that the mount sweeps, by half of a step more.
        loose = TIGHTNESS if moves else plan.task.spec.motion.step / 2 + 0.0005
        assert proven >= min(mount, plan.horizon) - loose - STICKS_OUT
        assert mount < plan.horizon


@pytest.mark.parametrize("kind", ["slider", "cart", "carrier"])
def test_a_ball_that_meets_the_mount_at_a_time_is_named(bare, kind):
    plan = bare[kind]
    bodies, times = posed(plan, np.arange(len(plan.time), dtype=float))
    middle, side = len(times) // 2, np.array([0.0, 1.0, 0.0])
    met = {"name": "met", **ball(bodies[middle, :2].mean(axis=0), True, times[middle], side, times[-1])}
    with pytest.raises(InfeasibleError, match="'met' moves into the way of the mount") as caught:
        hognose.plan(task_of(kind, "none", [met]))
    assert caught.value.plan is not None
    check = caught.value.plan.check("clearance_of_mount")
    assert check.obstacle == "met"
    # A bound that holds, of a motion that touches: no more than was seen.
    assert check.value <= left(caught.value.plan, np.arange(len(times), dtype=float))[0] + 1e-9 <= 0.0


@pytest.mark.parametrize("tolerance", ["placed", "turned"])
def test_a_carrier_with_tolerances_is_steered(tolerance):
    assert SteeredPath.of(task_of("carrier", tolerance, [])).margin == 0.005
