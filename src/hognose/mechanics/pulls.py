"""What errors of cables and of masses do to tensions, and how much of the load factor they take, to first order.

With the motors held, a change dr of the joint torques moves the angles by dq = -K⁻¹ dr, and with them the tensions:

    zeros of cables off by δ        dT = diag(k) (J K⁻¹ Jᵀ diag(k) - 1) δ
    all masses larger by a share s  dT = -s diag(k) J K⁻¹ dU/dq
    EA larger by a share s          dT = s (T + diag(k) J K⁻¹ dU/dq)

where U is the energy of the weight, and for EA that of bending, too.

The load factor is 1/μ, with μ the largest eigenvalue of M = -L⁻¹ K_geometric L⁻ᵀ, L Lᵀ = K_elastic. Tensions that are
off change M by -L⁻¹ (Σ dT_k H_k) L⁻ᵀ, and μ by no more than the Frobenius norm of that (Weyl), however many modes are
alike. With independent zeros the mean of its square is Σ_d tr(G_d P G_d P), where P = K_elastic⁻¹ and G_d is what the
zero of cable d makes of Σ dT_k H_k. Masses and EA are all alike: load factors are worked out with them off.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.mechanics import Mechanics
from hognose.mechanics.states import Held
from hognose.mechanics.stiffness import load_factors

Array = NDArray[np.float64]

#: Entries of the largest matrices that are made at a time.
_LARGEST_PART = 4_000_000


@dataclass(frozen=True, eq=False)
class Pulls:
    """What errors do to T steps; zero where the arm buckles anyway, or is not held.

    Attributes
    ----------
    zeros, masses, stiffness : (T, c) N
        Standard deviations of tensions by the zeros of all cables, and by masses and EA of all of them alike.
    buckling_zeros, buckling_masses, buckling_stiffness : (T,)
        By how much 1 / load factor grows for each, at as many standard deviations as were asked for.
    """

    zeros: Array
    masses: Array
    stiffness: Array
    buckling_zeros: Array
    buckling_masses: Array
    buckling_stiffness: Array


def pulls(
    mechanics: Mechanics,
    angles: Array,
    held: Held,
    gravity: Array,
    deviations: tuple[float, float, float],
    coverage: float,
) -> Pulls:
    """What errors do to tensions and load factors.

    Parameters
    ----------
    mechanics
    angles : (T, n, 2) rad
    held
        Of these angles.
    gravity : (T, 3) m/s²
        In the arm's own axes.
    deviations
        Standard deviations of the zero of each cable (m), and of all masses and EA, as shares of them.
    coverage
        How many of them load factors are to bear.
    """
    count, cables = len(angles), mechanics.robot.cables
    tensions, factors = np.zeros((3, count, cables)), np.zeros((3, count))
    sound = np.flatnonzero(held.is_held & (held.load_factor > 1.0))
    part = max(1, _LARGEST_PART // max(cables, 4 * mechanics.robot.sections) ** 2)
    for start in range(0, len(sound), part):
        rows = sound[start : start + part]
        poses = angles[rows], held.tensions[rows], gravity[rows], held.load_factor[rows]
        tensions[:, rows], factors[:, rows] = _of_part(mechanics, *poses, deviations, coverage)
    return Pulls(*tensions, *factors)


def _of_part(
    mechanics: Mechanics,
    angles: Array,
    tensions: Array,
    gravity: Array,
    load_factor: Array,
    deviations: tuple[float, float, float],
    coverage: float,
) -> tuple[Array, Array]:
    """The tensions (3, T, c) and load factors (3, T) of `Pulls`."""
    zero, mass, stiff = deviations
    J, k = mechanics.cable_jacobian(angles), mechanics.spring_constants(mechanics.cable_lengths(angles))
    elastic, geometric = mechanics.stiffness(angles, tensions, gravity)
    pulled = J * k[..., None]  # (T, c, 2n)
    turning = pulled @ np.linalg.inv(elastic + geometric)
    by_mass = -(turning @ mechanics.gravity_torque(angles, gravity)[..., None])[..., 0]
    by_stiffness = tensions + (turning @ mechanics.torque(angles, gravity)[..., None])[..., 0]
    spreads = np.zeros((3, *tensions.shape))
    spreads[1:] = mass * np.abs(by_mass), stiff * np.abs(by_stiffness)
    taken = np.zeros((3, len(angles)))
    if zero:
        by_zero = turning @ np.swapaxes(pulled, 1, 2)
        own = np.arange(k.shape[1])
        by_zero[:, own, own] -= k
        spreads[0] = zero * np.linalg.norm(by_zero, axis=2)
        if coverage:
            taken[0] = coverage * zero * _shaken(mechanics.cable_hessian(angles), by_zero, elastic)
    for row, share, changed in ((1, mass, by_mass), (2, stiff, by_stiffness)):
        for off in (coverage * share, -coverage * share) if share else ():
            arm, weight = (mechanics, (1.0 + off) * gravity) if row == 1 else (_stiffer(mechanics, off), gravity)
            there = load_factors(*arm.stiffness(angles, np.maximum(tensions + off * changed, 0.0), weight))
            taken[row] = np.maximum(taken[row], _inverse(there) - _inverse(load_factor))
    return spreads, taken


def _shaken(hessians: Array, by_zero: Array, elastic: Array) -> Array:
    """Root mean square (T,) 1/m of the Frobenius norm of L⁻¹ (Σ dT_k H_k) L⁻ᵀ, for zeros with a deviation of 1.

    Parameters
    ----------
    hessians : (T, c, n, 2, 2) m/rad²
    by_zero : (T, c, c) N/m
        What the zero of the cable in the last axis does to the tension of that in the one before.
    elastic : (T, 2n, 2n) N m/rad
    """
    steps, cables, joints = hessians.shape[:3]
    bends = np.swapaxes(by_zero, 1, 2) @ hessians.reshape(steps, cables, -1)  # G_d, its blocks in rows (T, c, 4n)
    P = np.linalg.inv(elastic).reshape(steps, joints, 2, joints, 2)
    # tr(G P G' Pᵀ) of two blocks is Σ G_ab P_bc G'_cd P_ad
    pairs = np.einsum("tjbkc,tjakd->tjabkcd", P, P).reshape(steps, 4 * joints, 4 * joints)
    return np.sqrt(np.einsum("tdi,tdi->t", bends @ pairs, bends))


def _stiffer(mechanics: Mechanics, share: float) -> Mechanics:
    return dataclasses.replace(mechanics, axial_stiffness=(1.0 + share) * mechanics.axial_stiffness)


def _inverse(factors: Array) -> Array:
    """1 / load factor; infinite where nothing holds the arm."""
    with np.errstate(divide="ignore"):
        return 1.0 / factors
