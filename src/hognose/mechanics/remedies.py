"""What would have to be different for an arm to be held, and not to buckle, in all poses of a motion.

Values are sought in the step that is worst as the arm is, tried in all steps, and sought again with those where they
are not enough. They are rounded to the safe side, and what is returned has been tried as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.mechanics import Mechanics
from hognose.robot.tension import LARGEST_STRAIN, STIFFEST
from hognose.ties import first_largest, first_smallest

Array = NDArray[np.float64]
#: An arm with a changed value, and by how much its weight is changed besides.
Varied = Callable[[float], tuple[Mechanics, float]]

#: Halvings of the interval in which a value is sought: to a millionth of it.
_HALVINGS = 20
#: How often a value is sought anew, with one more step.
_MOST_ROUNDS = 12
#: Least tensions (N) that are proposed.
_LEAST_TENSIONS = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1)

#: Modes whose eigenvalues differ by less than this share of the largest begin to buckle together.
_ALIKE = 1e-6

#: Steps that are not held are worse than any load factor.
_FAR = 1e9


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of a motion that does not stand.

    Attributes
    ----------
    angles : (T, n, 2) rad
    gravity : (T, 3) m/s²
        In the arm's own axes.
    worst
        The step that is worst.
    """

    angles: Array
    gravity: Array
    worst: int


def tension_needed(mechanics: Mechanics, poses: Poses) -> float:
    """The least `tension_max` (N) with which cables hold all poses; infinite if none does that they can bear."""
    most = LARGEST_STRAIN * float(mechanics.axial_stiffness.min())
    if most <= mechanics.tension_max:
        return math.inf
    found = _sought(
        lambda tension: (replace(mechanics, tension_max=tension), 1.0),
        (most, mechanics.tension_max),
        lambda tension: min(rounded_up(tension), most),
        poses,
    )
    return math.inf if found is None else found


def weight_borne(mechanics: Mechanics, poses: Poses, factor: float = 0.0) -> float:
    """The largest share of their masses with which the arm is held, and has a load factor; 0 if none is enough."""
    return _sought(lambda share: (mechanics, share), (0.0, 1.0), rounded_down, poses, factor) or 0.0


def bending_borne(mechanics: Mechanics, poses: Poses) -> float:
    """The largest share of their bending stiffnesses with which the arm is held; 0 if none is enough."""
    return (
        _sought(
            lambda share: (replace(mechanics, bending=share * mechanics.bending), 1.0), (0.0, 1.0), rounded_down, poses
        )
        or 0.0
    )


def stiffness_needed(mechanics: Mechanics, poses: Poses, factor: float) -> float:
    """The least multiple of EA with which the arm has a load factor in all poses; infinite if there are no such cables.

    To be asked only where sections bend back; elsewhere load factors are proportional to EA.
    """
    most = STIFFEST / float(mechanics.axial_stiffness.max())
    found = _sought(
        lambda times: (replace(mechanics, axial_stiffness=times * mechanics.axial_stiffness), 1.0),
        (most, 1.0),
        lambda times: min(rounded_up(times), most),
        poses,
        factor,
    )
    return math.inf if found is None else found


def pretension_allowed(mechanics: Mechanics, poses: Poses, factor: float) -> float | None:
    """The largest share of their pretensions with which cables give all poses a load factor.

    None is tensioned less than `tension_min`: see `with_pretension`. None if not even that is enough.
    """
    alike, least = float(mechanics.pretension.max()), mechanics.tension_min
    if np.ptp(mechanics.pretension) > 0 or alike == 0:
        return _sought(lambda share: (with_pretension(mechanics, share), 1.0), (0.0, 1.0), rounded_down, poses, factor)
    return _sought(
        lambda share: (with_pretension(mechanics, share), 1.0),
        (least / alike, 1.0),
        lambda share: max(rounded_down(share * alike), least) / alike,
        poses,
        factor,
    )


def least_tension_held(mechanics: Mechanics, poses: Poses, factor: float) -> float:
    """A `tension_min` (N) above 0 with which the arm is held and has a load factor in all poses; 0 if none was found.

    A pretension below it is raised with it, if there is none that is not above all pretensions.
    """
    for least in sorted(_LEAST_TENSIONS, key=lambda tension: tension > mechanics.pretension.min()):
        if least < mechanics.tension_max:
            changed = with_pretension(replace(mechanics, tension_min=least), 1.0)
            if (_room((changed, 1.0), poses, slice(None), factor) >= 0).all():
                return least
    return 0.0


def with_pretension(mechanics: Mechanics, share: float) -> Mechanics:
    """The same arm with a share of its pretensions, but none below `tension_min`."""
    return replace(mechanics, pretension=np.maximum(share * mechanics.pretension, mechanics.tension_min))


def where_it_buckles(mechanics: Mechanics, tensions: Array, poses: Poses) -> tuple[int, int]:
    """The section that turns the most where the arm begins to buckle, and the cable that pushes it most (0-based).

    A round arm begins to buckle in many directions at once, all of which count.

    Parameters
    ----------
    mechanics
    tensions : (T, c) N
    poses
        Where they are worst is looked at.
    """
    part = slice(poses.worst, poses.worst + 1)
    angles, pulls = poses.angles[part], tensions[part]
    elastic, geometric = mechanics.stiffness(angles, pulls, poses.gravity[part])
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(elastic[0]))
    except np.linalg.LinAlgError:  # nothing holds some joint
        values, modes = np.linalg.eigh(elastic[0])
    else:
        values, modes = np.linalg.eigh(inverse @ geometric[0] @ inverse.T)
        modes = inverse.T @ modes
    alike = values <= values[0] + _ALIKE * np.abs(values).max()
    ways = modes[:, alike].reshape(-1, 2, np.count_nonzero(alike))
    pushed = pulls[0] * np.einsum("jam,cjab,jbm->c", ways, mechanics.cable_hessian(angles)[0], ways)
    return first_largest((ways**2).sum(axis=(1, 2)))[0], first_smallest(pushed)[0]


def rounded_up(value: float) -> float:
    """A value above 0 rounded up to three digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(f"{math.ceil(value / digit * (1 - 1e-9)) * digit:.3g}")


def rounded_down(value: float) -> float:
    """A value rounded down to three digits; 0 if it is not above."""
    if value <= 0:
        return 0.0
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(f"{math.floor(value / digit * (1 + 1e-9)) * digit:.3g}")


def _sought(
    varied: Varied, ends: tuple[float, float], rounded: Callable[[float], float], poses: Poses, factor: float = 0.0
) -> float | None:
    """The value closest to the second end with which the arm stands in all poses, rounded towards the first.

    None if it does not stand at the first end either.
    """
    looked_at = [poses.worst]
    for _ in range(_MOST_ROUNDS):
        good, bad = ends
        if (_room(varied(good), poses, looked_at, factor) < 0).any():
            return None
        for _ in range(_HALVINGS):
            middle = 0.5 * (good + bad)
            if (_room(varied(middle), poses, looked_at, factor) >= 0).all():
                good = middle
            else:
                bad = middle
        value = rounded(good)
        room = _room(varied(value), poses, slice(None), factor)
        if (room >= 0).all():
            return value
        looked_at = sorted({*looked_at, int(np.argmin(room))})
    return ends[0] if (_room(varied(ends[0]), poses, slice(None), factor) >= 0).all() else None


def _room(varied: tuple[Mechanics, float], poses: Poses, steps: list[int] | slice, factor: float) -> Array:
    """By how much load factors are above the one that is needed; negative, too, at steps that are not held."""
    mechanics, weight = varied
    held = mechanics.hold(poses.angles[steps], weight * poses.gravity[steps])
    return np.where(held.is_held, held.load_factor - factor, -_FAR - np.abs(held.left).max(axis=1))
