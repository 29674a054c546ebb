"""Arms on every kind of base, in random frames and spaces, and their models in other programs."""

from typing import Any

import mujoco
import numpy as np
import yourdfpy
from numpy.typing import NDArray
from robot_oracles import random_angles, robot_file, section
from scipy.spatial.transform import Rotation

from hognose.files import bundled_robots, load_robot
from hognose.planning import Task, TaskSpec
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import axes_of, joints_on
from hognose.robot.carrier import Carrier
from hognose.robot.drum import Drum
from hognose.robot.holes import link_frames

mj: Any = mujoco  # its names are made at run time
Array = NDArray[np.float64]
KINDS = ("slider", "cart", "drum", "arm")
SPRINGS = {
    "axial_stiffness_N": 100e3,
    "free_length": 0.3,
    "pretension_N": 40.0,
    "tension_min_N": 10.0,
    "tension_max_N": 195.0,
}


def sprung_robot(**changes) -> Robot:
    """An arm whose cables are springs, with a tool, and links that weigh more at one end."""
    parts = [section(count=2), section(pitch=0.07, body_diameter=0.042, centre_of_mass=0.02, link_mass=0.04)]
    given = {"cables": SPRINGS, "tool_length": 0.03, "tool_mass": 0.02, **changes}
    return Robot.from_spec(RobotSpec.model_validate(robot_file(parts, **given)))


def all_robots() -> dict[str, Robot]:
    """The arms of the paper, which stand for all of links alone, and one with springs."""
    names = [name for name in bundled_robots() if name.startswith("sjtu")]
    return {**{name: load_robot(name) for name in names}, "sprung": sprung_robot()}


def task_on(kind: str, robot: Robot, seed: int, **more: Any) -> Task:
    """A task of an arm on a kind of base, anywhere and turned any way."""
    rng = np.random.default_rng(seed)
    angles = Rotation.random(rng=rng).as_euler("xyz", degrees=True)
    place = rng.uniform(-1.0, 1.0, 3)
    ahead = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()[:, 2]
    own = {"cart": {"position": place}, "drum": {"radius": 0.6, "nozzle": 0.05}}.get(kind, {})
    start = place + robot.length * ahead
    spec = {
        "name": "test",
        "robot": robot.name,
        "base": {"kind": kind, "rotation_deg": angles, **own},
        "path": {"way_points": np.array([start + 0.001 * ahead, start + 0.2 * ahead])},
        **more,
    }
    return Task(TaskSpec.model_validate(spec), robot)


def random_coordinates(task: Task, rng: np.random.Generator, count: int) -> Array:
    """Coordinates (count, k) of a task's base."""
    if isinstance(task.base, Carrier):
        poses = [rng.uniform(-1, 1, (count, 3)), Rotation.random(count, rng=rng).as_quat(scalar_first=True)]
        return np.concatenate(poses, axis=1)
    return rng.uniform(0.0, 0.3, (count, 1))


def random_poses(task: Task, seed: int, count: int = 6) -> tuple[Array, Array]:
    """Coordinates (count, k) of the base, and angles (count, n, 2) rad; the arm is straight in the first."""
    rng = np.random.default_rng(seed)
    angles = random_angles(task.robot, rng, (count,))
    angles[0] = 0.0
    return random_coordinates(task, rng, count), angles


def expected(task: Task, at: Array, angles: Array) -> tuple[Array, Array]:
    """Joints and tip (n+1, 3) m, and frames (n, 3, 3) of the links, in the frame of the task, of one pose."""
    joints = joints_on(task.base, task.robot, angles[None], at[None])[0]
    return joints, link_frames(angles, axes_of(task.base, at[None])[0])[1:]


class Mujoco:
    """A model in MuJoCo."""

    def __init__(self, content: bytes):
        self.model = mj.MjModel.from_xml_string(content.decode())
        self.data = mj.MjData(self.model)

    def set(self, task: Task, at: Array, angles: Array) -> None:
        data, base = self.data, task.base
        if isinstance(base, Carrier):
            data.mocap_pos[0], data.mocap_quat[0] = at[:3], at[3:]
            data.qpos[:] = angles.ravel()
        else:
            data.qpos[:] = [at[0] / base.radius if isinstance(base, Drum) else at[0], *angles.ravel()]
        mj.mj_forward(self.model, data)

    def joints(self, sections: int) -> tuple[Array, Array]:
        bodies = [self.data.body(f"link_{i:02d}") for i in range(1, sections + 1)]
        places = [body.xpos for body in bodies] + [self.data.body("tip").xpos]
        return np.array(places), np.array([body.xmat.reshape(3, 3) for body in bodies])

    def mesh(self, name: str) -> tuple[Array, NDArray[np.int32]]:
        """Vertices (v, 3) m of an obstacle, where they are, and its faces (m, 3)."""
        model, geom, mesh = self.model, self.model.geom(name).id, self.model.mesh(name).id
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        local = model.mesh_vert[first : first + count].astype(float)
        mj.mj_kinematics(model, self.data)
        placed = local @ self.data.geom_xmat[geom].reshape(3, 3).T + self.data.geom_xpos[geom]
        begin = model.mesh_faceadr[mesh]
        return placed, model.mesh_face[begin : begin + model.mesh_facenum[mesh]]


class Urdf:
    """A model that yourdfpy has read."""

    def __init__(self, file):
        options = {"build_collision_scene_graph": True, "load_collision_meshes": True, "force_collision_mesh": False}
        self.model = yourdfpy.URDF.load(str(file), **options)
        assert self.model.validate()

    def set(self, task: Task, at: Array, angles: Array) -> None:
        base = task.base
        if isinstance(base, Carrier):
            turn = base.R_task_start.T @ Rotation.from_quat(at[3:], scalar_first=True).as_matrix()
            named = dict(zip("xyz", at[:3] - base.start, strict=True))
            named |= dict(zip(("alpha", "beta", "roll"), Rotation.from_matrix(turn).as_euler("YXZ"), strict=True))
            values = {f"base_{name}": value for name, value in named.items()}
        else:
            values = {"drum": at[0] / base.radius} if isinstance(base, Drum) else {"feed": at[0]}
        for i, (alpha, beta) in enumerate(angles, 1):
            values |= {f"alpha_{i:02d}": alpha, f"beta_{i:02d}": beta}
        assert sorted(values) == sorted(self.model.actuated_joint_names)
        self.model.update_cfg(values)

    def joints(self, sections: int) -> tuple[Array, Array]:
        frames = [self.model.get_transform(f"link_{i:02d}", "task") for i in range(1, sections + 1)]
        tip = self.model.get_transform("tip", "task")
        return np.array([frame[:3, 3] for frame in [*frames, tip]]), np.array([frame[:3, :3] for frame in frames])


def volume(triangles: Array) -> float:
    """What closed triangles (m, 3, 3) m enclose, m³."""
    return float(np.einsum("mi,mi->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6.0)
