"""Cables in plain NumPy: lengths through holes in space, the angles of lengths, and the certificate's bound."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from hognose.robot import Robot


def turning(alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """R_y(α) R_x(β), (..., 3, 3)."""
    ca, sa, cb, sb, zero = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta), 0 * alpha
    rows = ((ca, sa * sb, sa * cb), (zero, cb, -sb), (-sa, ca * sb, ca * cb))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def through(robot: Robot, i: int, j: int, angles: np.ndarray) -> np.ndarray:
    """Lengths (..., m) m of section i's own cables in joint j, from the holes, at angles (..., 2)."""
    own = robot.cable_sections == i
    around = robot.cable_azimuths[own]
    off = robot.cable_radii[own] * np.array([np.cos(around), np.sin(around), 0 * around])
    before, after = off.copy(), off.copy()
    before[2] -= robot.joint_before[j]
    after[2] += robot.joint_after[j]
    return np.linalg.norm(turning(angles[..., 0], angles[..., 1]) @ after - before, axis=-2)


def slopes(robot: Robot, i: int, j: int, at: np.ndarray) -> np.ndarray:
    """Derivatives (m, 2) of these by central differences of high order."""
    columns = []
    for axis in np.eye(2):
        steps = [through(robot, i, j, at + k * 1e-3 * axis) for k in (-2, -1, 1, 2)]
        columns.append((steps[0] - 8 * steps[1] + 8 * steps[2] - steps[3]) / 12e-3)
    return np.stack(columns, axis=1)


def bends(robot: Robot, i: int, j: int, at: np.ndarray) -> np.ndarray:
    """Second derivatives (m, 2, 2) of these."""
    columns = []
    for axis in np.eye(2):
        steps = [slopes(robot, i, j, at + k * 1e-3 * axis) for k in (-2, -1, 1, 2)]
        columns.append((steps[0] - 8 * steps[1] + 8 * steps[2] - steps[3]) / 12e-3)
    return np.stack(columns, axis=2)


def fitted(robot: Robot, lengths: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Angles (n, 2) of lengths (c,): section by section, least squares over its own cables."""
    straight = robot.straight_cable_lengths
    found = np.empty_like(near)
    for i in range(robot.sections):
        own = robot.cable_sections == i
        rest = sum(through(robot, i, j, np.zeros(2)) for j in range(i + 1))
        target = lengths[own] - (straight[own] - rest) - sum(through(robot, i, j, found[j]) for j in range(i))
        found[i] = least_squares(
            lambda x, i=i, target=target: 1e3 * (through(robot, i, i, x) - target),
            near[i],
            method="lm",
            xtol=1e-14,
            ftol=1e-14,
            gtol=1e-14,
        ).x
    return found


def bound(
    robot: Robot, low: np.ndarray, high: np.ndarray, low_lengths: np.ndarray, high_lengths: np.ndarray
) -> np.ndarray:
    """How far (n,) rad angles leave linear ones on one piece, by docs/certificate.md."""
    n, middle = robot.sections, (low + high) / 2
    swing = np.linalg.norm(high - low, axis=1)
    reach = swing / 2 + swing.max() / 2 + 1e-6
    own = [robot.cable_sections == i for i in range(n)]
    lengths = (low_lengths, (low_lengths + high_lengths) / 2, high_lengths)
    off = [robot.cable_lengths(a) - b for a, b in zip((low, middle, high), lengths, strict=True)]
    p = [np.linalg.pinv(slopes(robot, i, i, middle[i])) for i in range(n)]
    gain = np.array([np.linalg.norm(each, 2) for each in p])
    a, h, steep, third = np.zeros((2 * n, 2 * n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    for i in range(n):
        for j in range(i + 1):
            slope, bend = slopes(robot, i, j, middle[j]), bends(robot, i, j, middle[j])
            arm = np.hypot(robot.cable_radii[own[i]], robot.joint_after[j])
            shortest = through(robot, i, j, middle[j]) - arm * reach[j]
            if shortest.min() <= 0:
                return np.full(n, np.inf)
            changes = 2.885 * arm + 4.5 * arm**2 / shortest + 2 / np.sqrt(3) * arm**3 / shortest**2
            a[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = p[i] @ slope
            h[i, j] = np.linalg.norm(bend) + np.linalg.norm(changes) * reach[j]
            steep[i, j] = np.linalg.norm(slope) + h[i, j] * reach[j]
            third[i] += np.linalg.norm(changes) * swing[j] ** 3
    back = np.linalg.inv(a).reshape(n, 2, n, 2).swapaxes(1, 2)
    size = np.linalg.norm(back, 2, axis=(2, 3))
    known = np.zeros(n)
    for each in off:
        solved = np.linalg.solve(a, np.concatenate([p[i] @ each[own[i]] for i in range(n)]))
        known += np.linalg.norm(solved.reshape(n, 2), axis=1)
    far = np.array([1.25 * max(np.linalg.norm(each[own[i]]) for each in off) for i in range(n)])
    return _closed(swing, reach, gain, h, steep, third / (72 * np.sqrt(3)), size, known, far)


def _closed(swing, reach, gain, h, steep, cubic, size, known, far) -> np.ndarray:
    """The first bound that follows from a larger one."""
    found = known
    for _ in range(30):
        x = 1.1 * found + 1e-15
        tilted = gain * np.diag(h) * (swing / 2 + x)
        found = known + size @ (gain * (cubic + h @ ((swing / 2 + x) * x) + tilted * (far + cubic + steep @ x)))
        if (swing / 2 + x > reach).any():
            break
        if (found < x).all():
            return found
    return np.full(len(swing), np.inf)
