"""Cables of arms whose sections are of any kinds: lengths of angles, and angles of lengths.

What `hognose.robot.cables` and `hognose.robot.cable_angles` are for links, section by section as the kinds say it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: Newton's method ends where it moves no angle by more (rad), and gives up after so many steps, or where one is as far
#: as this (rad); its derivatives are differences so far to both sides (rad).
_STILL, _MOST_STEPS, _FARTHEST, _ASIDE = 1e-10, 50, 10.0, 1e-6


def lengths_of(
    angles: Array, model: MixedSections, first_cable: NDArray[np.int64], holes: Array, straight: Array
) -> Array:
    """Cable lengths (T, c) m of angles (T, n, 2) rad.

    Parameters
    ----------
    angles
    model
    first_cable : (n + 1,)
        The own cables of section i are first_cable[i] to first_cable[i + 1] - 1; the later ones pass it.
    holes : (c, 3)
        Radius (m), cosine and sine of the azimuth of every cable.
    straight : (c,) m
        What is straight however the arm bends.
    """
    out = np.repeat(straight[None], len(angles), axis=0)
    for i, (kind, section) in enumerate(zip(model.kinds, model.sections, strict=True)):
        passing = slice(int(first_cable[i]), None)
        out[:, passing] += kind.cables(section, angles[:, i], *holes[passing].T)
    return out


def angles_of(
    lengths: Array,
    near: Array,
    model: MixedSections,
    first_cable: NDArray[np.int64],
    holes: Array,
    straight: Array,
) -> Array:
    """Angles (T, n, 2) rad of cable lengths (T, c) m, found from angles nearby; the others as of `lengths_of`.

    Those of a section make the sum of squares of what its own cables differ by smallest, with the sections before it
    where they are; where cables are linear in them, they are solved for at once. NaN from the first section for which
    none are found.
    """
    out, left = np.array(near, dtype=np.float64), lengths - straight
    for i, (kind, section) in enumerate(zip(model.kinds, model.sections, strict=True)):
        own = slice(int(first_cable[i]), int(first_cable[i + 1]))

        def through(angles: Array, kind=kind, section=section, own=own) -> Array:
            return kind.cables(section, angles, *holes[own].T)

        solved = _solved_at_once if kind.linear(section) else _by_newton
        angles = solved(left[:, own], out[:, i], through)
        out[:, i] = angles
        passing = slice(int(first_cable[i + 1]), None)
        left[:, passing] -= kind.cables(section, angles, *holes[passing].T)
        out[np.isnan(angles[:, 0] + angles[:, 1]), i:] = np.nan
    return out


def _solved_at_once(left: Array, near: Array, through: Callable[[Array], Array]) -> Array:
    """Angles (T, 2) rad of what is left (T, k) m for the own cables of a section that are linear in them."""
    straight, *bent = through(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    slopes = np.stack(bent, axis=1) - straight[:, None]
    (aa, ab), (_, bb) = slopes.T @ slopes
    determinant = aa * bb - ab * ab
    if not determinant > 1e-9 * (aa + bb) ** 2:
        return np.full(near.shape, np.nan)
    angles = (left - straight) @ slopes @ np.array([[bb, -ab], [-ab, aa]]) / determinant
    angles[np.abs(angles - near).max(axis=1) > _FARTHEST] = np.nan
    return angles


def _by_newton(left: Array, near: Array, through: Callable[[Array], Array]) -> Array:
    """As `_solved_at_once`, for cables of any kind, from angles nearby."""
    angles, open_rows = near.copy(), np.arange(len(near))
    for _ in range(_MOST_STEPS):
        at = angles[open_rows]
        off = left[open_rows] - through(at)
        slopes = np.stack(
            [(through(at + aside) - through(at - aside)) / (2 * _ASIDE) for aside in _ASIDE * np.eye(2)], axis=2
        )
        (aa, ab), (_, bb) = np.einsum("tka,tkb->abt", slopes, slopes)
        a, b = np.einsum("tka,tk->at", slopes, off)
        determinant = aa * bb - ab * ab
        determined = determinant > 1e-9 * (aa + bb) ** 2
        step = np.full((len(at), 2), np.nan)
        turns = np.stack([bb * a - ab * b, aa * b - ab * a], axis=1)
        np.divide(turns, determinant[:, None], out=step, where=determined[:, None])
        step[np.abs(step).max(axis=1) > _FARTHEST] = np.nan
        angles[open_rows] += step
        open_rows = open_rows[np.hypot(step[:, 0], step[:, 1]) >= _STILL]
        if not open_rows.size:
            break
    angles[open_rows] = np.nan
    return angles
