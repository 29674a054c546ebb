"""Cables of arms whose sections are of any kinds: lengths of angles, and angles of lengths.

What `hognose.robot.cables` and `hognose.robot.cable_angles` are for links whose cables keep one circle, section by
section as the kinds say it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hognose.robot.sections import ARC, Geometry, SectionKind

Array = NDArray[np.float64]

#: How cables run: each section's kind and geometry; where its own cables begin (n + 1,), which the later ones pass;
#: radius (m), cosine and sine of the azimuth (c, 3) of every cable; its circles (c, n + 1) m on the mount and in each
#: section; and what of it is straight (c,) m however the arm bends.
Courses = tuple[Sequence[tuple[SectionKind, Geometry]], NDArray[np.int64], Array, Array, Array]

#: Newton's method ends where it moves no angle by more (rad), and gives up after so many steps, or where one is as far
#: as this (rad); its derivatives are differences so far to both sides (rad).
_STILL, _MOST_STEPS, _FARTHEST, _ASIDE = 1e-10, 50, 10.0, 1e-6


def lengths_of(
    angles: Array,
    sections: Sequence[tuple[SectionKind, Geometry]],
    first_cable: NDArray[np.int64],
    holes: Array,
    circles: Array,
    straight: Array,
    extended: Array | None = None,
) -> Array:
    """Cable lengths (T, c) m of angles (T, n, 2) rad; the others are `Courses`.

    Sections that extend are as long as `extended` (T, n) m says, or else at rest.
    """
    out = np.repeat(straight[None], len(angles), axis=0)
    for i, (kind, section) in enumerate(sections):
        passing = slice(int(first_cable[i]), None)
        around = _round(holes, circles, i, passing)
        if extended is None or section.length_range is None:
            out[:, passing] += kind.cables(section, angles[:, i], *around)
        else:
            out[:, passing] += _through_extended(section, extended[:, i], angles[:, i], around)
    return out


def angles_of(
    lengths: Array,
    near: Array,
    sections: Sequence[tuple[SectionKind, Geometry]],
    first_cable: NDArray[np.int64],
    holes: Array,
    circles: Array,
    straight: Array,
) -> tuple[Array, Array]:
    """Angles (T, n, 2) rad of cable lengths (T, c) m, found from angles nearby; the others are `Courses`.

    Also the lengths (T, n) m of the sections, which are the pitches of those that do not extend.

    Those of a section make the sum of squares of what its own cables differ by smallest, with the sections before it
    where they are; where cables are linear in them, they are solved for at once. NaN from the first section for which
    none are found.
    """
    out, left = np.array(near, dtype=np.float64), lengths - straight
    extended = np.tile([section.pitch for _, section in sections], (len(lengths), 1))
    for i, (kind, section) in enumerate(sections):
        own = slice(int(first_cable[i]), int(first_cable[i + 1]))
        around = _round(holes, circles, i, own)
        passing = slice(int(first_cable[i + 1]), None)
        if section.length_range is not None:
            out[:, i], extended[:, i] = _extended(left[:, own], section, around)
            farther = _round(holes, circles, i, passing)
            left[:, passing] -= _through_extended(section, extended[:, i], out[:, i], farther)
            out[np.isnan(extended[:, i]), i:] = extended[np.isnan(extended[:, i]), i:] = np.nan
            continue

        def through(angles: Array, kind=kind, section=section, around=around) -> Array:
            return kind.cables(section, angles, *around)

        solved = _solved_at_once if kind.cable_law(section).linear else _by_newton
        angles = solved(left[:, own], out[:, i], through)
        out[:, i] = angles
        left[:, passing] -= kind.cables(section, angles, *_round(holes, circles, i, passing))
        out[np.isnan(angles[:, 0] + angles[:, 1]), i:] = np.nan
    return out, extended


def _through_extended(section: Geometry, length: Array, angles: Array, around: tuple[Array, ...]) -> Array:
    """As `SectionKind.cables`, of a section that has lengths (T,) m: less what is straight at rest."""
    radius, cosine, sine, entering = around
    return ARC.cables_at(section, length[:, None], angles, radius, cosine, sine, entering) + (
        length[:, None] - section.pitch
    )


def _extended(left: Array, section: Geometry, around: tuple[Array, ...]) -> tuple[Array, Array]:
    """Angles (T, 2) rad and lengths (T,) m of what is left (T, k) m for the own cables of a section that extends.

    S L - r (S α cos φ - S β sin φ), with S = sin(θ/2D)/(θ/2D), is linear in S α, S β and S L; and from those θ
    follows, as S θ is 2 D sin(θ/2D). NaN where there is none, or where the cables do not determine all three.
    """
    radius, cosine, sine, _ = around
    slopes = np.stack([-radius * cosine, radius * sine, np.ones_like(radius)], axis=1)
    square = slopes.T @ slopes
    if not np.linalg.det(square / np.sqrt(np.outer(np.diag(square), np.diag(square)))) > 1e-9:
        return np.full((len(left), 2), np.nan), np.full(len(left), np.nan)
    shrunk = np.linalg.solve(square, slopes.T @ (left + section.pitch).T).T.astype(np.float64)
    return unshrunk(shrunk[:, :2], shrunk[:, 2], section.disks)


def unshrunk(turns: Array, length: Array, disks: int | None) -> tuple[Array, Array]:
    """Angles (..., 2) rad and lengths (...) m of S times them, S = sin(θ/2D)/(θ/2D), which are linear in the cables.

    NaN where no bend has them.
    """
    if disks is None:
        return turns, length
    part = np.hypot(turns[..., 0], turns[..., 1]) / (2 * disks)
    with np.errstate(invalid="ignore"):
        half = np.arcsin(part)
    grown = 1.0 / np.sinc(half / np.pi)
    return turns * grown[..., None], length * grown


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


def _round(holes: Array, circles: Array, i: int, cables: slice) -> tuple[Array, Array, Array, Array]:
    """Of some cables in section i: circle (m), cosine and sine of the azimuth, and the circle (m) they come from."""
    return circles[cables, i + 1], holes[cables, 1], holes[cables, 2], circles[cables, i]
