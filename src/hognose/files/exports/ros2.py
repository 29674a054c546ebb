"""Plans as bags of ROS 2: a `JointTrajectory` of the motors, and one of the joints of the URDF."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import MissingExtraError
from hognose.files.exports.drive_axes import CARRIED, axes_of_plan, feed_joint
from hognose.files.exports.format import Content, Export
from hognose.files.exports.jointed_arm import JointedArm
from hognose.planning.plan import Plan

Array = NDArray[np.float64]

#: Topics of the bag.
MOTORS, ARM = "/plan/motors", "/plan/arm"
_KIND = "trajectory_msgs/msg/JointTrajectory"
_POSITIONS = (
    "points have positions only, so that ros2_control moves on straight lines between steps, for which clearances are "
    "certified; a controller that needs velocities gets them from the CSVs of --to axes"
)


def to_ros2(plan: Plan) -> Content:
    """The bag: one message a topic, in m and rad; its stamp is zero, which means now.

    Raises
    ------
    MissingExtraError
        rosbags is not installed.
    """
    axes = axes_of_plan(plan)
    motors = ([axis.name for axis in axes], np.column_stack([axis.values for axis in axes]))
    return Content(
        _bag({MOTORS: motors, ARM: _arm(plan)}, plan.time),
        remarks=(_POSITIONS, *([CARRIED] if plan.task.base.follows else []), *_coupled(plan)),
    )


def _coupled(plan: Plan) -> list[str]:
    arm = JointedArm.of(plan.robot)
    if not arm.following:
        return []
    told = [f"{ARM} has the first joint of each section about each axis, at its share of the angle; others follow it"]
    if plan.robot.extends:
        told.append(
            f"{ARM} has the first slide of each section that extends, at its share of what the section is longer than "
            f"at rest, and {MOTORS} has whole lengths: leave these out where the cables alone make them"
        )
    return told


def _arm(plan: Plan) -> tuple[list[str], Array]:
    """Joints of the URDF that follow no other one, and their positions (T, j)."""
    arm = JointedArm.of(plan.robot)
    leading = list(arm.leading.values())
    names, feed = [joint.name for joint in leading], feed_joint(plan)
    positions = arm.values(plan.angles, plan.section_lengths, leading)
    if feed is None:
        return names, positions
    return [feed[0].joint, *names], np.column_stack([feed[1], positions])


def _bag(trajectories: dict[str, tuple[Sequence[str], Array]], time: Array) -> bytes:
    """An MCAP file with a trajectory a topic: names of j joints, and their positions (T, j) at times (T,) s."""
    rosbag2, store = _rosbags()
    with tempfile.TemporaryDirectory() as folder:
        bag = rosbag2.Writer(Path(folder) / "bag", version=9, storage_plugin=rosbag2.StoragePlugin.MCAP)
        with bag:
            for topic, (names, positions) in trajectories.items():
                connection = bag.add_connection(topic, _KIND, typestore=store)
                message = _trajectory(store.types, names, positions, time)
                bag.write(connection, 0, store.serialize_cdr(message, _KIND))
        return next((Path(folder) / "bag").glob("*.mcap")).read_bytes()


def _trajectory(types: Any, names: Sequence[str], positions: Array, time: Array) -> Any:
    instant, none = types["builtin_interfaces/msg/Time"], np.zeros(0)
    point, duration = types["trajectory_msgs/msg/JointTrajectoryPoint"], types["builtin_interfaces/msg/Duration"]
    header = types["std_msgs/msg/Header"](stamp=instant(sec=0, nanosec=0), frame_id="")
    points = [
        point(
            positions=np.ascontiguousarray(row),
            velocities=none,
            accelerations=none,
            effort=none,
            time_from_start=duration(sec=at // 1_000_000_000, nanosec=at % 1_000_000_000),
        )
        for row, at in zip(positions, np.rint(1e9 * time).astype(np.int64).tolist(), strict=True)
    ]
    return types[_KIND](header=header, joint_names=list(names), points=points)


def _rosbags() -> tuple[Any, Any]:
    """What writes bags, and the messages of the oldest ROS 2 that is still cared for."""
    try:
        from rosbags import rosbag2
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        said = "" if (error.name or "").startswith("rosbags") else f", which cannot be imported: {error}"
        raise MissingExtraError(
            f"bags of ROS 2 need the package rosbags{said}; install it with: pip install 'hognose[ros]'"
        ) from None
    return rosbag2, get_typestore(Stores.ROS2_HUMBLE)


EXPORT = Export(".mcap", "motors and joints as JointTrajectory of ROS 2, in a bag", to_ros2)
