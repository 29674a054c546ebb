"""What a MuJoCo model looks like: lights, cameras and colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.colours import COLOURS
from hognose.files.exports.obstacle_meshes import ObstacleMesh
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import Element, element
from hognose.robot.base import axes_of
from hognose.robot.tip_camera import ANGLE_OF_VIEW_DEG

Array = NDArray[np.float64]

#: Of the camera that looks at all, deg, from top to bottom.
_OVERVIEW = 45.0
#: From where all is looked at: so much along the feed, up, and to the side.
_FROM = (-0.55, 0.5, 0.75)
#: How close: at 1 the whole ball round everything is seen, whose corners are empty.
_CLOSE = 0.72


def views(root: Element, subject: Subject, meshes: list[ObstacleMesh]) -> None:
    """How large the model is, and what the viewer needs to show it."""
    centre, extent = _middle(subject, meshes)
    element(root, "statistic", center=centre, extent=extent, meansize=0.02)
    visual = element(root, "visual")
    element(visual, "global", offwidth="1920", offheight="1080", azimuth="140", elevation="-20")
    element(visual, "headlight", ambient="0.3 0.3 0.3", diffuse="0.5 0.5 0.5", specular="0.1 0.1 0.1")
    element(visual, "map", znear=0.002, zfar=20.0, shadowclip=1.0)
    element(visual, "quality", shadowsize="4096")


def materials(asset: Element) -> None:
    """Colours of what there is, and of the sky."""
    element(asset, "texture", type="skybox", builtin="gradient", rgb1="0.93 0.95 0.97", rgb2="0.72 0.77 0.82",
            width="256", height="256")  # fmt: skip
    for name, colour in COLOURS.items():
        element(asset, "material", name=name, rgba=colour, specular=0.2, shininess=0.3)


def lights_and_camera(world: Element, subject: Subject, meshes: list[ObstacleMesh]) -> None:
    """A light from above, and a camera that sees everything."""
    (centre, extent), up = _middle(subject, meshes), _up(subject)
    element(world, "light", name="sun", type="directional", pos=centre + 2.0 * extent * up, dir=-up,
            diffuse="0.5 0.5 0.5", specular="0.1 0.1 0.1")  # fmt: skip
    along = axes_of(subject.base, subject.base.coordinates(np.zeros(1), _straight(subject)))[0][:, 2]
    across = np.cross(along, up)
    if np.linalg.norm(across) < 0.1:  # it goes up or down
        across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across /= np.linalg.norm(across)
    level = np.cross(up, across)
    level = along if np.linalg.norm(level) < 0.1 else level / np.linalg.norm(level)
    back = _unit(_FROM[0] * level + _FROM[1] * up + _FROM[2] * across)
    eye = centre + back * (_CLOSE * extent / np.sin(np.radians(_OVERVIEW / 2)))
    right = _unit(np.cross(up, back))
    element(world, "camera", name="overview", pos=eye, xyaxes=np.concatenate([right, np.cross(back, right)]),
            fovy=_OVERVIEW)  # fmt: skip


def tip(body: Element) -> None:
    """A camera in the tip, which looks ahead; the headlight goes with it."""
    element(body, "camera", name="tip_camera", xyaxes="-1 0 0 0 1 0", fovy=ANGLE_OF_VIEW_DEG)


def _straight(subject: Subject) -> Array:
    """Joints and tip (1, n+1, 3) m of the straight arm at feed 0, in front of a drum, too."""
    along = np.append(0.0, np.cumsum(subject.robot.link_lengths))
    return (subject.base.start + along[:, None] * subject.base.direction)[None]


def _middle(subject: Subject, meshes: list[ObstacleMesh]) -> tuple[Array, float]:
    """The middle (3,) m of all there is, the straight arm in it, and how far (m) the farthest of it is from there."""
    corners = np.concatenate([_straight(subject)[0], *(mesh.centre + mesh.vertices for mesh in meshes)])
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return middle, float(np.linalg.norm(corners - middle, axis=1).max())


def _up(subject: Subject) -> Array:
    """Unit vector (3,) against gravity; y without any."""
    size = float(np.linalg.norm(subject.gravity))
    return -subject.gravity / size if size > 0 else np.array([0.0, 1.0, 0.0])


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
