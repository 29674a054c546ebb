"""Parts of a URDF: joints, inertias, round bodies and boxes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.files.exports.xml import Element, element
from hognose.rotations import degrees_of_rotation

Array = NDArray[np.float64]

#: A joint must have an effort, which nobody knows; this (N m, N) stands for it.
EFFORT = 1000.0
#: No shift, or no turn.
NONE = (0.0, 0.0, 0.0)
X, Y, Z = np.eye(3)
#: Lowest, highest, and fastest: m or rad, m/s or rad/s.
Limit = tuple[float, float, float]


def link(root: Element, name: str, mass: float, moments: ArrayLike, height: float = 0.0) -> Element:
    """A link with a mass (kg) at a height (m) along z, and moments (3,) kg m² about it."""
    made = element(root, "link", name=name)
    inertial = element(made, "inertial")
    element(inertial, "origin", xyz=(0.0, 0.0, height), rpy=NONE)
    element(inertial, "mass", value=mass)
    xx, yy, zz = np.asarray(moments, np.float64)
    element(inertial, "inertia", ixx=xx, ixy="0", ixz="0", iyy=yy, iyz="0", izz=zz)
    return made


def joint(
    root: Element,
    name: str,
    parent: str,
    child: str,
    shift: ArrayLike = NONE,
    R_parent_joint: Array | None = None,
    *,
    turns: ArrayLike | None = None,
    slides: ArrayLike | None = None,
    limit: Limit | None = None,
    leader: tuple[str, float] | None = None,
) -> None:
    """A joint that turns about an axis or slides along one, within limits; a fixed one without an axis.

    It may follow a leader, by a factor.
    """
    axis = turns if slides is None else slides
    kind = "fixed" if axis is None else "revolute" if slides is None else "prismatic"
    made = element(root, "joint", name=name, type=kind)
    element(made, "parent", link=parent)
    element(made, "child", link=child)
    turned = NONE if R_parent_joint is None else np.radians(degrees_of_rotation(R_parent_joint))
    element(made, "origin", xyz=shift, rpy=turned)
    if axis is None or limit is None:
        return
    element(made, "axis", xyz=axis)
    low, high, speed = limit
    element(made, "limit", lower=low, upper=high, velocity=speed, effort=EFFORT)
    if leader is not None:
        element(made, "mimic", joint=leader[0], multiplier=leader[1], offset="0")


def cylinder(inside: Element, radius: float, length: float, middle: ArrayLike, material: str, along_y: bool = False):
    """A cylinder along z, or along y, to look at and to run into."""
    for tag in ("visual", "collision"):
        part = element(inside, tag)
        element(part, "origin", xyz=middle, rpy=(0.5 * np.pi if along_y else 0.0, 0.0, 0.0))
        element(element(part, "geometry"), "cylinder", radius=radius, length=length)
        if tag == "visual":
            element(part, "material", name=material)


def box(inside: Element, size: ArrayLike, middle: ArrayLike, material: str) -> None:
    """A box of sizes (3,) m along the axes, to look at and to run into."""
    for tag in ("visual", "collision"):
        part = element(inside, tag)
        element(part, "origin", xyz=middle, rpy=NONE)
        element(element(part, "geometry"), "box", size=size)
        if tag == "visual":
            element(part, "material", name=material)


def ball(inside: Element, radius: float, height: float, material: str) -> None:
    """A ball at a height (m) along z, to look at and to run into."""
    for tag in ("visual", "collision"):
        part = element(inside, tag)
        element(part, "origin", xyz=(0.0, 0.0, height), rpy=NONE)
        element(element(part, "geometry"), "sphere", radius=radius)
        if tag == "visual":
            element(part, "material", name=material)
