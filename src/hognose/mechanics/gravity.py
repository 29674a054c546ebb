"""The weight of the arm: potential energy, its derivative by the angles, and its second derivative.

Pieces of sections (`hognose.mechanics.pieces`) hang one on the other. With S, the first moment of all that hangs on a
piece about its beginning, and W_a the turn of its end by an angle a of it, S has the derivative V_a by a, and the
energy U = -Σ m g·p of all masses

    ∂U/∂q_a = -g · V_a,      ∂²U/∂q_a∂q_b = -(g × W_a) · V_b   for a of a piece nearer the base than that of b.

A joint turns by W = a e_y of the piece before, and b e_x of its own; all behind it turns with it, V = W × S, so that
the second holds for the angles of one joint, too, a before b. An arc, besides, changes its own shape: see `_bent`. The
angles of a piece are shares of those of its section, and so are its derivatives.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.mechanics.bow import bow, turns_of_bow
from hognose.mechanics.postures import LONG, lay_pieces
from hognose.robot.kinematics import turned

Array = NDArray[np.float64]

#: Columns of the room that pieces need: turns by both angles; the axes x, y and z: where a joint ends, an arc begins.
_WA, _WB, _X, _Y, _Z, _ROOM = 0, 3, 6, 9, 12, 15


@kernel(inline="always")
def _across(a: NDArray, i: int, at: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The vector in row i of a, from a column on, across another."""
    return a[i, at + 1] * z - a[i, at + 2] * y, a[i, at + 2] * x - a[i, at] * z, a[i, at] * y - a[i, at + 1] * x


@kernel(inline="always")
def _of_axes(frames: NDArray, p: int, v: NDArray, i: int) -> tuple[float, float, float]:
    """Row i of v (m, 3), which is in the axes of a piece."""
    x, y, z = v[i, 0], v[i, 1], v[i, 2]
    return (
        x * frames[p, _X] + y * frames[p, _Y] + z * frames[p, _Z],
        x * frames[p, _X + 1] + y * frames[p, _Y + 1] + z * frames[p, _Z + 1],
        x * frames[p, _X + 2] + y * frames[p, _Y + 2] + z * frames[p, _Z + 2],
    )


@kernel(inline="always")
def _add(out: NDArray, i: int, at: int, share: float, x: float, y: float, z: float) -> None:
    out[i, at] += share * x
    out[i, at + 1] += share * y
    out[i, at + 2] += share * z


@kernel(fastmath={"contract"})
def _place(angles: NDArray, pieces: NDArray, axes: NDArray, frames: NDArray) -> None:
    """Fill the frames and turns of all pieces, and add the latter to those of their sections, `axes` (2n, 6)."""
    xx, xy, xz = 1.0, 0.0, 0.0
    yx, yy, yz = 0.0, 1.0, 0.0
    zx, zy, zz = 0.0, 0.0, 1.0
    own = np.empty((8, 3))
    axes[:] = 0.0
    for p in range(pieces.shape[0]):
        i, sa, sb = int(pieces[p, 0]), pieces[p, 1], pieces[p, 2]
        a, b = sa * angles[i, 0], sb * angles[i, 1]
        if pieces[p, 4] == 0.0:
            frames[p, _WA], frames[p, _WA + 1], frames[p, _WA + 2] = yx, yy, yz
            if sa != 0.0 or sb != 0.0:
                xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, a, b)
            frames[p, _WB], frames[p, _WB + 1], frames[p, _WB + 2] = xx, xy, xz
        frames[p, _X], frames[p, _X + 1], frames[p, _X + 2] = xx, xy, xz
        frames[p, _Y], frames[p, _Y + 1], frames[p, _Y + 2] = yx, yy, yz
        frames[p, _Z], frames[p, _Z + 1], frames[p, _Z + 2] = zx, zy, zz
        if pieces[p, 4] != 0.0:
            turns_of_bow(a, b, own)
            frames[p, _WA], frames[p, _WA + 1], frames[p, _WA + 2] = _of_axes(frames, p, own, 0)
            frames[p, _WB], frames[p, _WB + 1], frames[p, _WB + 2] = _of_axes(frames, p, own, 1)
            xx, xy, xz = _of_axes(frames, p, own, 5)
            yx, yy, yz = _of_axes(frames, p, own, 6)
            zx, zy, zz = _of_axes(frames, p, own, 7)
        _add(axes, 2 * i, 0, sa, frames[p, _WA], frames[p, _WA + 1], frames[p, _WA + 2])
        _add(axes, 2 * i + 1, 0, sb, frames[p, _WB], frames[p, _WB + 1], frames[p, _WB + 2])


@kernel(fastmath={"contract"})
def _bent(
    p: int,
    a: float,
    b: float,
    piece: NDArray,
    mass: float,
    moment: tuple,
    gravity: NDArray,
    frames: NDArray,
    found: NDArray,
) -> None:
    """Fill `found` (4, 3) of an arc, on whose end a mass hangs with a first moment about it.

    Its rows are the moment about its beginning, V by both angles, and -∂²U by a twice, by both, and by b twice. With c,
    the moment of the arc's own mass and of all others at its end, and R, the turn of the end, S = c + R S' and

        V_x = c_x + W_x × R S',    S_xy = c_xy + W_y,x × R S' + W_y × (W_x × R S') .
    """
    sx, sy, sz = moment
    own, turn = np.empty((6, 3)), np.empty((8, 3))
    bow(a, b, piece[3], mass, piece[5], piece[6], own)
    turns_of_bow(a, b, turn)
    x, y, z = _of_axes(frames, p, own, 0)
    found[0, 0], found[0, 1], found[0, 2] = sx + x, sy + y, sz + z
    ax, ay, az = _across(frames, p, _WA, sx, sy, sz)
    bx, by, bz = _across(frames, p, _WB, sx, sy, sz)
    x, y, z = _of_axes(frames, p, own, 1)
    found[1, 0], found[1, 1], found[1, 2] = x + ax, y + ay, z + az
    x, y, z = _of_axes(frames, p, own, 2)
    found[2, 0], found[2, 1], found[2, 2] = x + bx, y + by, z + bz
    for row in range(3):
        # Of the turns: W_a by a, W_b by a, W_b by b.
        tx, ty, tz = _of_axes(frames, p, turn, 2 + row)
        x, y, z = _of_axes(frames, p, own, 3 + row)
        x, y, z = x + ty * sz - tz * sy, y + tz * sx - tx * sz, z + tx * sy - ty * sx
        if row == 0:
            ux, uy, uz = _across(frames, p, _WA, ax, ay, az)
        elif row == 1:
            ux, uy, uz = _across(frames, p, _WB, ax, ay, az)
        else:
            ux, uy, uz = _across(frames, p, _WB, bx, by, bz)
        found[3, row] = gravity[0] * (x + ux) + gravity[1] * (y + uy) + gravity[2] * (z + uz)


@kernel(fastmath={"contract"})
def gravity_at(
    angles: NDArray, pieces: NDArray, tool: float, gravity: NDArray, room: tuple, torque: NDArray, hessian: NDArray
) -> float:
    """Add dU/dq (2n,) and d²U/dq² (2n, 2n) of one pose; returns U (J), with the beginning of the arm at height 0.

    Pieces are (p, 7), the tool load is at the end of the last one; `room_for` makes room to work in.
    """
    axes, frames, found = room
    gx, gy, gz = gravity[0], gravity[1], gravity[2]
    _place(angles, pieces, axes, frames)
    mass, sx, sy, sz = tool, 0.0, 0.0, 0.0
    for p in range(pieces.shape[0] - 1, -1, -1):
        i, sa, sb = int(pieces[p, 0]), pieces[p, 1], pieces[p, 2]
        j, k = 2 * i, 2 * i + 1
        # With what comes behind in the same section, whose V are summed up so far.
        aa, ab, bb = 0.0, 0.0, 0.0
        gax, gay, gaz = _pulled(gx, gy, gz, frames, p, _WA)
        gbx, gby, gbz = _pulled(gx, gy, gz, frames, p, _WB)
        if p + 1 < pieces.shape[0] and pieces[p + 1, 0] == pieces[p, 0]:
            aa = 2.0 * sa * (gax * axes[j, 3] + gay * axes[j, 4] + gaz * axes[j, 5])
            bb = 2.0 * sb * (gbx * axes[k, 3] + gby * axes[k, 4] + gbz * axes[k, 5])
            ab = sa * (gax * axes[k, 3] + gay * axes[k, 4] + gaz * axes[k, 5])
            ab += sb * (gbx * axes[j, 3] + gby * axes[j, 4] + gbz * axes[j, 5])
        if pieces[p, 4] == 0.0:
            zx, zy, zz = frames[p, _Z], frames[p, _Z + 1], frames[p, _Z + 2]
            along = mass * pieces[p, 3] + pieces[p, 5] * pieces[p, 6]
            sx, sy, sz = sx + along * zx, sy + along * zy, sz + along * zz
            ax, ay, az = _across(frames, p, _WA, sx, sy, sz)
            bx, by, bz = _across(frames, p, _WB, sx, sy, sz)
            aa += sa * sa * (gax * ax + gay * ay + gaz * az)
            ab += sa * sb * (gax * bx + gay * by + gaz * bz)
            bb += sb * sb * (gbx * bx + gby * by + gbz * bz)
        else:
            _bent(p, sa * angles[i, 0], sb * angles[i, 1], pieces[p], mass, (sx, sy, sz), gravity, frames, found)
            sx, sy, sz = found[0, 0], found[0, 1], found[0, 2]
            ax, ay, az = found[1, 0], found[1, 1], found[1, 2]
            bx, by, bz = found[2, 0], found[2, 1], found[2, 2]
            aa += sa * sa * found[3, 0]
            ab += sa * sb * found[3, 1]
            bb += sb * sb * found[3, 2]
        mass += pieces[p, 5]
        _add(axes, j, 3, sa, ax, ay, az)
        _add(axes, k, 3, sb, bx, by, bz)
        hessian[j, j] -= aa
        hessian[j, k] -= ab
        hessian[k, j] -= ab
        hessian[k, k] -= bb
    for i in range(axes.shape[0]):
        torque[i] -= gx * axes[i, 3] + gy * axes[i, 4] + gz * axes[i, 5]
        ax, ay, az = _pulled(gx, gy, gz, axes, i, 0)
        for k in range(i + 2 - i % 2, axes.shape[0]):
            value = ax * axes[k, 3] + ay * axes[k, 4] + az * axes[k, 5]
            hessian[i, k] -= value
            hessian[k, i] -= value
    return -(gx * sx + gy * sy + gz * sz)


@kernel(inline="always")
def _pulled(gx: float, gy: float, gz: float, a: NDArray, i: int, at: int) -> tuple[float, float, float]:
    """Gravity across the vector in row i of a, from a column on."""
    return gy * a[i, at + 2] - gz * a[i, at + 1], gz * a[i, at] - gx * a[i, at + 2], gx * a[i, at + 1] - gy * a[i, at]


@kernel()
def room_for(pieces: NDArray, sections: int) -> tuple[NDArray, NDArray, NDArray]:
    """Room for `gravity_at` to work in."""
    return np.empty((2 * sections, 6)), np.empty((pieces.shape[0], _ROOM)), np.empty((4, 3))


@kernel()
def _gravity(
    angles: NDArray, pieces: NDArray, tool: float, gravity: NDArray, torques: NDArray, hessians: NDArray
) -> None:
    room, laid = room_for(pieces, angles.shape[1]), pieces.copy()
    for t in range(angles.shape[0]):
        if angles.shape[2] > LONG:
            lay_pieces(angles[t], pieces, laid)
        gravity_at(angles[t], laid, tool, gravity[t], room, torques[t], hessians[t])


def gravity_of(angles: Array, pieces: Array, tool: float, gravity: Array) -> tuple[Array, Array]:
    """Torques dU/dq (T, 2n) N m with which the joints hold the weight, and their derivatives (T, 2n, 2n) N m/rad.

    Parameters
    ----------
    angles : (T, n, 2) rad
        Or (T, n, 3) postures, see `hognose.mechanics.postures`.
    pieces : (p, 7)
        Each a `hognose.mechanics.pieces.Weight`.
    tool : kg
        Load at the end of the last piece.
    gravity : (T, 3) m/s²
        In the arm's own axes.
    """
    size = 2 * angles.shape[1]
    torques, hessians = np.zeros((len(angles), size)), np.zeros((len(angles), size, size))
    _gravity(angles, pieces, tool, gravity, torques, hessians)
    return torques, hessians
