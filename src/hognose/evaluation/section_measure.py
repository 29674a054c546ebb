"""The verdict on a method that places arms whose sections bend along their length or at several joints."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.evaluation.case import Case
from hognose.following import Follower
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: How far (m) an end may be from where the angles put it, or from the path if it shall be on it; slack of angles, rad.
SLACK, BEND_SLACK = 1e-9, 1e-9


def placed(model: MixedSections, angles: Array, bases: Array) -> Array:
    """Ends (T, n+1, 3) m of sections at angles (T, n, 2) rad from bases (T, 3) m along z, by plain rotations.

    It shares nothing with the model but what the sections are: arcs, or equal joints.
    """
    frame, ends = np.broadcast_to(np.eye(3), (len(angles), 3, 3)), [bases]
    for i, section in enumerate(model.sections):
        if section.joints is None:
            turn, end = _arc(angles[:, i], section.pitch)
            ends.append(ends[-1] + np.einsum("tij,tj->ti", frame, end))
            frame = frame @ turn
            continue
        end = ends[-1]
        for _ in range(section.joints):
            frame = frame @ _joint(angles[:, i] / section.joints)
            end = end + section.pitch / section.joints * frame[:, :, 2]
        ends.append(end)
    return np.stack(ends, axis=1)


def _joint(angles: Array) -> Array:
    """R_y(α) R_x(β), (T, 3, 3)."""
    (ca, cb), (sa, sb) = np.cos(angles).T, np.sin(angles).T
    zero = np.zeros_like(ca)
    return np.stack([ca, sa * sb, sa * cb, zero, cb, -sb, -sa, ca * sb, ca * cb], axis=1).reshape(-1, 3, 3)


def _arc(angles: Array, length: float) -> tuple[Array, Array]:
    """exp(α e_y + β e_x), (T, 3, 3), and the end (T, 3) m of an arc that turns so."""
    bend = np.hypot(angles[:, 0], angles[:, 1])
    safe = np.where(bend > 0.0, bend, 1.0)
    towards = angles * [1.0, -1.0] / safe[:, None]  # x and y of where it bends to
    sine, left = np.sin(bend), 2.0 * np.sin(0.5 * bend) ** 2
    x, y = towards.T
    rows = (1 - left * x * x, -left * x * y, sine * x)
    rows += (-left * x * y, 1 - left * y * y, sine * y)
    rows += (-sine * x, -sine * y, np.cos(bend))
    turn = np.stack(rows, axis=1).reshape(-1, 3, 3)
    across = left / safe
    end = length * np.stack([across * x, across * y, np.sinc(bend / math.pi)], axis=1)
    return turn, end


def objections(case: Case, follower: Follower, joints: Array, feeds: Array) -> tuple[str, float]:
    """What makes ends of sections not valid, empty if nothing does, and how far (m) they may be off the path.

    The ends are where plain kinematics put them for their angles, which are within the limits; the tip is on the path,
    and so are all ends of a method that keeps to it; else they are within half a section of it.
    """
    assert case.model is not None
    found, angles = [], case.model.angles(joints)
    off = float(np.abs(placed(case.model, angles, case.path.point(feeds)) - joints).max())
    if off > SLACK:
        found.append(f"a link is off by {1e3 * off:.3g} mm, more than {1e3 * SLACK:.3g} mm")
    bend = float(np.abs(angles).max())
    if bend > case.bend_limit + BEND_SLACK:
        found.append(f"a joint bends by {bend:.4f} rad, its limit is {case.bend_limit:g} rad")
    allowance = SLACK if follower.keeps_to_path else 0.5 * float(case.link_lengths.min())
    away = case.path.distance_to(joints)
    if away[:, :-1].max() > allowance:
        found.append(f"an end is {1e3 * away[:, :-1].max():.3g} mm off the path, more than {1e3 * allowance:.3g} mm")
    if away[:, -1].max() > SLACK:
        found.append(f"the tip is {1e3 * away[:, -1].max():.3g} mm off the path")
    return "; ".join(found), allowance


def errors(case: Case, joints: Array, feeds: Array) -> tuple[Array, Array, float, float]:
    """Of joints (T, n+1, 3) m: distances (T,) m of the tip, by plain kinematics, and (T, m) m of the body to the path.

    Also by how much (m) an end is off where the angles put it, and the largest angle (rad).
    """
    assert case.model is not None
    angles = case.model.angles(joints)
    plain = placed(case.model, angles, case.path.point(feeds))
    body = case.path.distance_to(case.model.vertices(joints))
    return case.path.distance_to(plain[:, -1]), body, float(np.abs(plain - joints).max()), float(np.abs(angles).max())
