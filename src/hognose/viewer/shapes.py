"""What the page draws, as arrays: where bodies stand, cables run, and how close is coloured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.robot.holes import holes_of
from hognose.rotations import quaternion_of_rotation

Array = NDArray[np.float64]
Colours = NDArray[np.uint8]

#: Colours from too close over the margin to far; beyond the horizon nothing is known but a bound, and needs to be.
TOO_CLOSE_COLOUR, NEAR_COLOUR, FAR_COLOUR, BEYOND_COLOUR = (150, 0, 24), (235, 120, 40), (246, 214, 120), (92, 168, 110)
#: Half lengths (m) of a link's disk, and how much thinner than the body joints are drawn.
DISK, NECK = 0.002, 0.86
#: Sides of a cylinder, and how thick balls are that show through none of them.
SIDES = 32
SKIN = float(np.cos(np.pi / SIDES))


def rgb(colour: str) -> tuple[int, int, int]:
    """The colour of a hexadecimal name, 0 to 255."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue


def turns_from_z(directions: Array) -> Array:
    """Quaternions (k, 4), w first, that turn +z to unit directions (k, 3) the shortest way."""
    out = np.concatenate(
        [1.0 + directions[:, 2:], -directions[:, 1:2], directions[:, :1], np.zeros((len(directions), 1))], axis=1
    )
    back = out[:, 0] < 1e-9
    out[back] = (0.0, 1.0, 0.0, 0.0)  # straight back: half a turn about x
    return out / np.linalg.norm(out, axis=1, keepdims=True)


def links(joints: Array, radii: Array) -> tuple[Array, Array, Array]:
    """Positions (n, 3), turns (n, 4) and scales (n, 3) that put a cylinder of radius and length 1 round each link."""
    along = np.diff(joints, axis=0)
    lengths = np.linalg.norm(along, axis=1)
    scales = np.stack([radii, radii, lengths], axis=1)
    return joints[:-1], turns_from_z(along / lengths[:, None]), scales


def bodies(robot: Robot, vertices: Array, outline: Array, radii: Array) -> tuple[Array, Array, Array]:
    """As `links`, for the chords of a body that end at vertices (p+1, 3) m; of flat ones the boxes.

    The outline (c+1, 3) m is that of the body; radii (p,) m smaller than the body's draw all of it so much thinner.
    """
    places, turns, scales = links(vertices, radii)
    if robot.outline.lines is not None:
        axes = robot.outline.lines.axes(outline)
        part = radii / robot.chord_radii
        for chord in np.flatnonzero(axes.any(axis=(1, 2))):
            x, y = axes[chord]
            turns[chord] = quaternion_of_rotation(np.stack([x, y, np.cross(x, y)], axis=1))
            scales[chord, :2] = 0.5 * part[chord] * robot.outline.sides[robot.chord_sections[chord]]
    return places, turns, scales


def arc(start: Array, frame: Array, turn: Array, length: float) -> Array:
    """Points (k, 3) m along the third column of a frame (3, 3), turning by (2,) rad/m towards the first and second."""
    rate = float(np.linalg.norm(turn))
    way = np.linspace(0.0, length, 25)[:, None]
    if rate * length < 1e-6:
        return start + way * frame[:, 2]
    side = frame[:, :2] @ turn / rate
    return start + (np.sin(rate * way) * frame[:, 2] + (1.0 - np.cos(rate * way)) * side) / rate


def unit_cylinder(sides: int = SIDES) -> tuple[Array, NDArray[np.int32]]:
    """Vertices (v, 3) and faces (f, 3) of a closed cylinder of radius 1 from z = 0 to 1."""
    turn = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(sides)], axis=1)
    low, high = ring, ring + np.array([0.0, 0.0, 1.0])
    # Caps have vertices of their own, so that their edges are drawn sharp.
    vertices = np.concatenate([low, high, low, high, [[0, 0, 0], [0, 0, 1.0]]])
    k = np.arange(sides)
    nxt, n = np.roll(k, -1), sides
    faces = np.concatenate(
        [
            np.stack([k, nxt, nxt + n], axis=1),
            np.stack([k, nxt + n, k + n], axis=1),
            np.stack([nxt + 2 * n, k + 2 * n, np.full(n, 4 * n)], axis=1),
            np.stack([k + 3 * n, nxt + 3 * n, np.full(n, 4 * n + 1)], axis=1),
        ]
    )
    return vertices, faces.astype(np.int32)


def unit_box() -> tuple[Array, NDArray[np.int32]]:
    """Vertices (v, 3) and faces (f, 3) of a box from -1 to 1 along x and y and 0 to 1 along z, with sharp edges."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float64)
    sides = []
    for axis, flip in ((0, False), (0, True), (1, False), (1, True), (2, False), (2, True)):
        side = np.insert(square[::-1] if flip == (axis != 1) else square, axis, 1.0 if not flip else -1.0, axis=1)
        sides.append(side)
    vertices = np.concatenate(sides)
    vertices[:, 2] = 0.5 * (vertices[:, 2] + 1.0)
    faces = 4 * np.arange(6)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return vertices, faces.reshape(-1, 3).astype(np.int32)


def unit_ball(rings: int = 12, sides: int = 20) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and faces of a ball of radius 1."""
    v, u = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, rings + 1), 2 * np.pi * np.arange(sides) / sides, indexing="ij"
    )
    vertices = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1).reshape(-1, 3)
    k = np.arange(rings * sides).reshape(rings, sides)
    right = np.roll(k, -1, axis=1)
    faces = np.concatenate(
        [np.stack([k, right, right + sides], axis=-1), np.stack([k, right + sides, k + sides], axis=-1)]
    )
    return vertices, faces.reshape(-1, 3).astype(np.int32)


def rings(joints: Array, radii: Array, sides: int = 20) -> Array:
    """Pieces (k, 2, 3) m of rings round the middles of links with joints (T, n+1, 3) m and radii (n,) m."""
    middles = 0.5 * (joints[:, :-1] + joints[:, 1:])
    along = np.diff(joints, axis=1)
    along = along / np.linalg.norm(along, axis=2, keepdims=True)
    aside = np.cross(along, np.eye(3)[np.argmin(np.abs(along), axis=2)])
    aside = aside / np.linalg.norm(aside, axis=2, keepdims=True)
    turn = 2 * np.pi * np.arange(sides + 1)[:, None, None, None] / sides
    circle = middles + radii[:, None] * (np.cos(turn) * aside + np.sin(turn) * np.cross(along, aside))
    return np.stack([circle[:-1], circle[1:]], axis=-2).reshape(-1, 2, 3)


def clearance_colours(clearance: Array, margin: float, horizon: float) -> Colours:
    """Colours (n, 3) of links with clearances (n,) m: dark red below the margin, green from the horizon on."""
    part = np.clip((clearance - margin) / max(horizon - margin, 1e-9), 0.0, 1.0)[:, None]
    out = np.array(NEAR_COLOUR) + part * (np.array(FAR_COLOUR, dtype=np.float64) - np.array(NEAR_COLOUR))
    out[clearance < margin] = TOO_CLOSE_COLOUR
    out[clearance >= horizon] = BEYOND_COLOUR
    return out.astype(np.uint8)


def cables(robot: Robot, joints: Array, frames: Array) -> tuple[Array, NDArray[np.int64]]:
    """Pieces (k, 2, 3) m of all cables between the disks they pass, and the section (k,) each cable belongs to.

    Frames (n+1, 3, 3) are those of the base and the links.
    """
    pieces, owner = [], []
    for cable, section in enumerate(robot.cable_sections):
        holes = holes_of(robot, joints, frames, cable)
        pieces.append(np.stack([holes[:-1], holes[1:]], axis=1))
        owner.append(np.full(len(holes) - 1, section))
    return np.concatenate(pieces), np.concatenate(owner)


def disks(robot: Robot, joints: Array, frames: Array) -> tuple[Array, Array, Array]:
    """Positions, turns and scales, as `links` has them, of the disk before and after every joint."""
    places, along, radii = [], [], []
    for i in range(robot.sections):
        before, after = robot.joint_before[i], robot.joint_after[i]
        for frame, offset in ((frames[i], -before - DISK), (frames[i + 1], after - DISK)):
            places.append(joints[i] + offset * frame[:, 2])
            along.append(frame[:, 2])
            radii.append(1.02 * robot.body_radii[i])
    scales = np.stack([radii, radii, np.full(len(radii), 2 * DISK)], axis=1)
    return np.array(places), turns_from_z(np.array(along)), scales
