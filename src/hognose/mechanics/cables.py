"""How cable lengths change with joint angles: their first and second derivatives, written out.

A length is a sum over the sections that the cable passes, so its Hessian has a 2 × 2 block for each section and nothing
else. Angles are numbered q = (α₁, β₁, α₂, …). The formulas of one joint are in `hognose.robot.joint_cable`, those of
sections of other kinds in `hognose.robot.section_cable`.

What is called `joints` has two columns, h₁ and h₂, of an arm of links alone whose cables keep their circles; otherwise
it is the `CableLaw` of every section. Then `holes` has the circles (m) of each cable on the mount and in every section
behind its own radius, cosine and sine.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.mechanics.postures import LONG, lay_joints, lay_runs
from hognose.robot.joint_cable import curvature, through_joint
from hognose.robot.section_cable import through_section

Array = NDArray[np.float64]


@kernel(fastmath={"contract"})
def jacobian_at(
    angles: NDArray, joints: NDArray, sections: NDArray, holes: NDArray, lengths: NDArray, jacobian: NDArray
) -> None:
    """Add lengths (c,) through the joints to `lengths`, and write their derivatives (c, 2n) for one pose.

    Angles are (n, 2), joints and holes as of `jacobians_of`. What a cable does not reach is left as it is.
    """
    if joints.shape[1] > 2:
        for j in range(joints.shape[0]):
            for k in range(sections.size - 1, -1, -1):
                if sections[k] < j:
                    break
                length, ga, gb, _, _, _ = through_section(
                    joints[j], angles[j, 0], angles[j, 1], holes[k, 3 + j], holes[k, 4 + j], holes[k, 1], holes[k, 2]
                )
                lengths[k] += length
                jacobian[k, 2 * j], jacobian[k, 2 * j + 1] = ga, gb
        return
    for j in range(joints.shape[0]):
        ca, sa = math.cos(angles[j, 0]), math.sin(angles[j, 0])
        cb, sb = math.cos(angles[j, 1]), math.sin(angles[j, 1])
        h1, h2 = joints[j, 0], joints[j, 1]
        for k in range(sections.size - 1, -1, -1):
            if sections[k] < j:
                break
            length, ga, gb = through_joint(ca, sa, cb, sb, h1, h2, holes[k, 0], holes[k, 1], holes[k, 2])
            lengths[k] += length
            jacobian[k, 2 * j], jacobian[k, 2 * j + 1] = ga, gb


@kernel(fastmath={"contract"})
def geometric_at(
    angles: NDArray, joints: NDArray, sections: NDArray, holes: NDArray, tensions: NDArray, out: NDArray
) -> None:
    """Add the sum of tensions (c,) times the Hessians of the lengths to `out` (2n, 2n), for one pose."""
    others = joints.shape[1] > 2
    for j in range(joints.shape[0]):
        ca, sa = math.cos(angles[j, 0]), math.sin(angles[j, 0])
        cb, sb = math.cos(angles[j, 1]), math.sin(angles[j, 1])
        h1, h2 = joints[j, 0], joints[j, 1]
        taa, tbb, tab = 0.0, 0.0, 0.0
        for k in range(sections.size - 1, -1, -1):
            if sections[k] < j:
                break
            r, c, s = holes[k, 0], holes[k, 1], holes[k, 2]
            if others:
                circles = holes[k, 3 + j], holes[k, 4 + j]
                _, _, _, aa, bb, ab = through_section(joints[j], angles[j, 0], angles[j, 1], *circles, c, s)
            else:
                length, ga, gb = through_joint(ca, sa, cb, sb, h1, h2, r, c, s)
                aa, bb, ab = curvature(ca, sa, cb, sb, h1, h2, r, c, s, length, ga, gb)
            taa, tbb, tab = taa + tensions[k] * aa, tbb + tensions[k] * bb, tab + tensions[k] * ab
        a = 2 * j
        out[a, a] += taa
        out[a, a + 1] += tab
        out[a + 1, a] += tab
        out[a + 1, a + 1] += tbb


@kernel()
def _jacobians(
    angles: NDArray,
    joints: NDArray,
    sections: NDArray,
    holes: NDArray,
    straight: NDArray,
    lengths: NDArray,
    jacobians: NDArray,
) -> None:
    laws, runs = joints.copy(), straight.copy()
    for t in range(angles.shape[0]):
        if angles.shape[2] > LONG:
            lay_joints(angles[t], joints, laws)
            lay_runs(angles[t], joints, sections, straight, runs)
        lengths[t] = runs
        jacobian_at(angles[t], laws, sections, holes, lengths[t], jacobians[t])


@kernel()
def _geometric(
    angles: NDArray, joints: NDArray, sections: NDArray, holes: NDArray, tensions: NDArray, out: NDArray
) -> None:
    laws = joints.copy()
    for t in range(angles.shape[0]):
        if angles.shape[2] > LONG:
            lay_joints(angles[t], joints, laws)
        geometric_at(angles[t], laws, sections, holes, tensions[t], out[t])


@kernel(fastmath={"contract"})
def _hessians(angles: NDArray, joints: NDArray, sections: NDArray, holes: NDArray, out: NDArray) -> None:
    others, laws = joints.shape[1] > 2, joints.copy()
    for t in range(angles.shape[0]):
        if angles.shape[2] > LONG:
            lay_joints(angles[t], joints, laws)
        for j in range(joints.shape[0]):
            ca, sa = math.cos(angles[t, j, 0]), math.sin(angles[t, j, 0])
            cb, sb = math.cos(angles[t, j, 1]), math.sin(angles[t, j, 1])
            h1, h2 = joints[j, 0], joints[j, 1]
            for k in range(sections.size - 1, -1, -1):
                if sections[k] < j:
                    break
                r, c, s = holes[k, 0], holes[k, 1], holes[k, 2]
                if others:
                    circles = holes[k, 3 + j], holes[k, 4 + j]
                    _, _, _, aa, bb, ab = through_section(laws[j], angles[t, j, 0], angles[t, j, 1], *circles, c, s)
                else:
                    length, ga, gb = through_joint(ca, sa, cb, sb, h1, h2, r, c, s)
                    aa, bb, ab = curvature(ca, sa, cb, sb, h1, h2, r, c, s, length, ga, gb)
                out[t, k, j, 0, 0], out[t, k, j, 0, 1], out[t, k, j, 1, 0], out[t, k, j, 1, 1] = aa, ab, ab, bb


def jacobians_of(
    angles: Array, joints: Array, sections: NDArray[np.int64], holes: Array, straight: Array
) -> tuple[Array, Array]:
    """Cable lengths (T, c) m and their derivatives (T, c, 2n) m/rad at angles or postures.

    Parameters
    ----------
    angles : (T, n, 2) rad
        Or (T, n, 3) postures, see `hognose.mechanics.postures`; so have the other functions here.
    joints : (n, 2) or (n, 6) m
        h₁ and h₂, or a `CableLaw` each.
    sections : (c,)
        At the end of which section each cable is fixed, ascending.
    holes : (c, 3) or (c, 3 + n + 1)
        Radius (m), cosine and sine of the azimuth; with laws also the circles (m) on the mount and in every section.
    straight : (c,) m
        What of the lengths is between joints.
    """
    lengths = np.empty((len(angles), sections.size))
    jacobians = np.zeros((len(angles), sections.size, 2 * len(joints)))
    _jacobians(angles, joints, sections, holes, straight, lengths, jacobians)
    return lengths, jacobians


def hessians_of(angles: Array, joints: Array, sections: NDArray[np.int64], holes: Array) -> Array:
    """Second derivatives (T, c, n, 2, 2) m of cable lengths by the two angles of each joint; the others are zero."""
    out = np.zeros((len(angles), sections.size, len(joints), 2, 2))
    _hessians(angles, joints, sections, holes, out)
    return out


def geometric_stiffness(
    angles: Array, joints: Array, sections: NDArray[np.int64], holes: Array, tensions: Array
) -> Array:
    """Stiffness (T, 2n, 2n) N m/rad that tensions (T, c) N give the joints as the Jacobian of the lengths changes."""
    out = np.zeros((len(angles), 2 * len(joints), 2 * len(joints)))
    _geometric(angles, joints, sections, holes, tensions, out)
    return out
