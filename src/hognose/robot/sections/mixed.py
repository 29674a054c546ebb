"""An arm whose sections are of any kinds, mixed: all that robots, clearances and certificates ask of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.kernels import kernel
from hognose.robot.sections.chain import (
    ROWS,
    X,
    Y,
    Z,
    angles_along,
    arc_terms,
    bend_frame,
    moved,
    placed_along,
    turn_frame,
    vertices_along,
)
from hognose.robot.sections.kind import Array, Geometry, Piece, SectionKind
from hognose.robot.sections.link import RIGID_LINK
from hognose.robot.sections.model import SectionModel

#: A curved piece has so many chords that they leave it, at the bend limits, by this part of the body's radius at most.
_LEFT_OUT = 0.01
#: No section needs more chords than this.
_MOST_CHORDS = 64


@kernel()
def _bulges(
    low: NDArray,
    high: NDArray,
    table: NDArray,
    counts: NDArray,
    first: NDArray,
    spins: NDArray,
    swings: NDArray,
    out: NDArray,
    scales: NDArray | None = None,
) -> None:
    """How far (m, p+1) vertices can leave their straight lines while angles (m, n, 2) go linearly from low to high.

    Sections may go linearly from `scales[0]` to `scales[1]` (m, n) times their lengths, too.

    As for rigid links, an eighth of a bound of the acceleration. Along a curved piece, at the part σ of it, the frame
    turns against the piece's beginning at a rate of at most σ w, and that rate changes by at most
    min(1/2, σ θ/6) (σ w)², where w is how far the piece's turn goes in all and θ its largest (docs/certificate.md).
    """
    frame = np.empty((ROWS, 3))
    for m in range(low.shape[0]):
        frame[:] = 0.0
        frame[X, 0], frame[Y, 1], frame[Z, 2] = 1.0, 1.0, 1.0
        spin = frame[0]
        spin[0], spin[1], spin[2] = spins[m, 0], spins[m, 1], spins[m, 2]
        # A bound of what the angular velocity changes by; of the angular speed; of the acceleration.
        change, speed, acceleration = 0.0, math.sqrt(spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2), swings[m]
        out[m, 0] = acceleration / 8.0
        at = 0
        for i in range(low.shape[1]):
            for p in range(first[i], first[i + 1]):
                alpha, beta = table[p, 0] * low[m, i, 0], table[p, 1] * low[m, i, 1]
                alpha_end, beta_end = table[p, 0] * high[m, i, 0], table[p, 1] * high[m, i, 1]
                a, b, length = alpha_end - alpha, beta_end - beta, table[p, 2]
                if table[p, 3] == 0.0:
                    moved(frame, 0, 0.0, a, 0.0)
                    turn_frame(frame, alpha, beta)
                    moved(frame, 0, b, 0.0, 0.0)
                    change += speed * math.sqrt(a * a + b * b) + abs(a * b)
                    speed = math.sqrt(spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2) + change
                    acceleration += length * (change + speed * speed)
                    at += 1
                    out[m, at] = acceleration / 8.0
                    continue
                went = math.sqrt(a * a + b * b)
                bent = math.sqrt(max(alpha * alpha + beta * beta, alpha_end * alpha_end + beta_end * beta_end))
                before = math.sqrt(spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2)
                ca, cb, cc, _, _ = arc_terms(alpha * alpha + beta * beta)
                # The turn's rate at the end, ẇ + A w × ẇ + C w × (w × ẇ) with w = (β, α, 0).
                across = beta * a - alpha * b
                moved(frame, 0, b + cc * alpha * across, a - cc * beta * across, ca * across)
                bend_frame(frame, alpha, beta, ca, cb)
                after = math.sqrt(spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2)
                count, entered, until, longer = counts[p], change, speed, 0.0
                if scales is not None:
                    longer = length * abs(scales[1, m, i] - scales[0, m, i])
                    length *= max(scales[0, m, i], scales[1, m, i])
                for j in range(1, count + 1):
                    part = j / count
                    rate = part * went
                    change = entered + until * rate + min(0.5, part * bent / 6.0) * rate * rate
                    speed = min(before + rate, after + (1.0 - (j - 1) / count) * went) + change
                    acceleration += length / count * (change + speed * speed)
                    if scales is not None:
                        acceleration += 2.0 * longer / count * speed
                    at += 1
                    out[m, at] = acceleration / 8.0
                speed = after + change


def model_of(sections: Sequence[tuple[SectionKind, Geometry]], tool_length: float) -> SectionModel:
    """The model of an arm, of its sections and a tool (m): that of rigid links where all of them are."""
    kinds, geometries = zip(*sections, strict=True)
    if all(kind.pieces(each) == (Piece(1.0, 1.0, each.pitch),) for kind, each in sections):
        return RIGID_LINK
    return MixedSections(kinds, geometries, tool_length)


class MixedSections:
    """Sections of any kinds as rows of pieces, which the kinds say: see `hognose.robot.sections.kind`.

    It is a `SectionModel`. The lengths and limits that its methods are given are those of its own sections; lengths say
    something new only of sections that extend. Their chords are enough where they are longest.

    Parameters
    ----------
    kinds, sections
        One for each section.
    tool_length : m
        Of the tool, which is rigid with the end of the last section.
    """

    def __init__(self, kinds: Sequence[SectionKind], sections: Sequence[Geometry], tool_length: float) -> None:
        self.kinds, self.sections = tuple(kinds), tuple(sections)
        pieces = [list(kind.pieces(section)) for kind, section in zip(kinds, sections, strict=True)]
        if tool_length > 0.0:
            last = pieces[-1][-1]
            if last.curved:
                pieces[-1].append(Piece(0.0, 0.0, tool_length))
            else:
                pieces[-1][-1] = last._replace(length=last.length + tool_length)
        self._pieces = pieces
        flat = [piece for row in pieces for piece in row]
        owners = np.repeat(np.arange(len(pieces)), [len(row) for row in pieces])
        self.first = np.cumsum([0, *(len(row) for row in pieces)])
        self.table = np.array(flat, dtype=np.float64)
        self._of_pieces = list(zip(flat, (self.sections[i] for i in owners), strict=True))
        self.counts = np.array([_chords(*each) for each in self._of_pieces])
        self.chords = np.add.reduceat(self.counts, self.first[:-1])
        left = [_sagitta(*each, count) for each, count in zip(self._of_pieces, self.counts.tolist(), strict=True)]
        self._sagitta = np.repeat(left, self.counts)
        self._arcs = np.repeat(self.table[:, 2] / self.counts, self.counts)
        self.extends = np.array([section.length_range is not None for section in self.sections])
        self.gains = np.array([_gains(row) for row in pieces])

    @cached_property
    def curvature_shares(self) -> Array:
        """1/k (n,) of each section as a stack of k equal joints: 1 for a link, 0 for an arc.

        Sections whose two axes differ, which are no such stack, count as links.
        """
        alike = np.abs(self.gains[:, 0] - self.gains[:, 1]) < 1e-12
        return np.where(alike, np.clip(2.0 * self.gains[:, 0] - 1.0, 0.0, 1.0), 1.0)

    @cached_property
    def linear_cables(self) -> bool:
        """Whether angles go linearly where cable lengths do: all cables are linear in the angles."""
        return all(kind.cable_law(each).linear for kind, each in zip(self.kinds, self.sections, strict=True))

    @cached_property
    def levers(self) -> Array:
        """How far (p+1, n) m/rad vertices move at most with an error of each section's pair of angles.

        Derived in docs/certificate.md. An error δ turns the frame behind a piece by no more than |δ| times the sum of
        the larger shares up to there, and no more than |δ| √(A² + B²) with the sums A and B of both shares.
        """
        sections = np.repeat(np.arange(len(self.sections)), np.diff(self.first))
        turns, reached = [], np.zeros(3)
        for p, (alpha, beta, _, curved) in enumerate(self.table):
            if p in self.first:
                reached = np.zeros(3)
            share, count = np.array([alpha, beta, max(alpha, beta)]), int(self.counts[p])
            for part in np.arange(1, count + 1) / count if curved else (1.0,):
                a, b, larger = reached + part * share
                turn = np.where(np.arange(len(self.sections)) < sections[p], 1.0, 0.0)
                turn[sections[p]] = min(larger, math.hypot(a, b))
                turns.append(turn)
            reached = reached + share
        arcs = self.arcs(np.array([section.lengths[1] for section in self.sections]))[:, None]
        return np.concatenate([np.zeros((1, len(self.sections))), np.cumsum(arcs * turns, axis=0)])

    @cached_property
    def chord_bends(self) -> Array:
        """The largest bend (p,) rad of what each chord stands for within the limits, or of the joint before it."""
        bends = [_bend(*each) for each in self._of_pieces]
        return np.repeat(np.where(self.table[:, 3] != 0.0, bends / self.counts, bends), self.counts)

    @cached_property
    def passed(self) -> Array:
        """Which part (p+1, n) of every section lies before each end of a chord."""
        owners, whole = np.repeat(np.arange(len(self.sections)), self.chords), np.arange(len(self.sections))
        shares = self._arcs / np.bincount(owners, self._arcs)[owners]
        before = np.cumsum(shares[:, None] * (owners[:, None] == whole), axis=0)
        return np.concatenate([np.zeros((1, len(self.sections))), before])

    @cached_property
    def lone_arcs(self) -> NDArray[np.bool_]:
        """Which sections (n,) are nothing but one arc."""
        single = np.diff(self.first) == 1
        return single & (self.table[self.first[:-1]][:, [0, 1, 3]] == 1.0).all(axis=1)

    def smooth(self, lengths: Array) -> NDArray[np.bool_]:
        """See `SectionModel.smooth`."""
        pieces = np.repeat(np.arange(len(self.table)), self.counts)
        jointless = (self.table[:, 3] == 1.0) | ~self.table[:, :2].any(axis=1)
        return jointless[pieces[1:]]

    def angles(self, joints: Array) -> Array:
        """See `SectionModel.angles`."""
        out = np.empty((len(joints), len(self.sections), 2))
        step, section = angles_along(joints, self.table, self.first, self.gains, out, np.empty((ROWS + 3, 3)))
        if step >= 0:
            raise InputError(
                f"joints: section {section + 1} has no angles at step {step}: its ends are the same point, or the "
                "second lies behind the first, where no bend of the section leads"
            )
        return out

    def positions(self, angles: Array, feeds: Array, lengths: Array) -> tuple[Array, Array]:
        """See `SectionModel.positions`."""
        joints, frames = np.empty((len(angles), len(self.sections) + 1, 3)), np.empty((len(angles), 3, 3))
        arm = (self.table, self.first, np.empty((ROWS + 3, 3)))
        if self.extends.any():
            placed_along(angles, feeds, *arm, joints, frames, self.scales(np.broadcast_to(lengths, angles.shape[:2])))
        else:
            placed_along(angles, feeds, *arm, joints, frames)
        return joints, frames

    def lengths(self, joints: Array, angles: Array) -> Array:
        """Lengths (T, n) m of sections that are a single arc with joints (T, n+1, 3) m and angles (T, n, 2) rad.

        Of a chord d and a bend θ that is d (θ/2)/sin(θ/2).
        """
        chords = np.linalg.norm(np.diff(joints, axis=1), axis=2)
        return chords / np.sinc(np.hypot(angles[..., 0], angles[..., 1]) / (2.0 * math.pi))

    def scales(self, lengths: Array) -> Array:
        """How many times as long as at rest sections of lengths (..., n) m are; 1 if they do not extend."""
        rest = np.array([each.pitch for each in self.sections])
        return np.ascontiguousarray(np.where(self.extends, lengths / rest, 1.0))

    def vertices(self, joints: Array, angles: Array | None = None) -> Array:
        """See `SectionModel.vertices`."""
        flat = np.ascontiguousarray(joints).reshape(-1, *joints.shape[-2:])
        bent = self.angles(flat) if angles is None else np.ascontiguousarray(angles).reshape(len(flat), -1, 2)
        arm = (self.table, self.counts, self.first)
        out = np.empty((len(flat), int(self.counts.sum()) + 1, 3))
        if self.extends.any():
            vertices_along(bent, flat, *arm, out, self.scales(self.lengths(flat, bent)))
        else:
            vertices_along(bent, flat, *arm, out)
        return out.reshape(*joints.shape[:-2], *out.shape[1:])

    def arcs(self, lengths: Array) -> Array:
        """See `SectionModel.arcs`."""
        return self._arcs * np.repeat(self.scales(lengths), self.chords) if self.extends.any() else self._arcs

    def sagitta(self, lengths: Array, limits: Array) -> Array:
        """See `SectionModel.sagitta`: what the largest bends within the limits leave out."""
        return self._sagitta

    def sharpest(self, lengths: Array, limits: Array) -> Array:
        """See `SectionModel.sharpest`: up to which each section follows a circle, with others like it before it.

        With angles (α, β) of at most the bend b about any axis, and directions that are behind the tangent by half of
        what a last straight piece ℓ goes round, b ≈ κ (L - ℓ/2 + ℓ'/2) with ℓ' of the section before. Of k joints that
        bend alike, chords of a circle, 2 k sin(b/2k) takes the place of b. Where curvature changes sections bend more.
        """
        last = [piece.length if not piece.curved else 0.0 for piece in (row[-1] for row in self._pieces)]
        reach = lengths - 0.5 * np.array(last) + 0.5 * np.append(0.0, last[:-1])
        bends = [_sharpest_bend(row, limit) for row, limit in zip(self._pieces, limits, strict=True)]
        return np.minimum(np.array(bends) / reach, math.sqrt(2.0) / lengths)

    def bulges(self, low: Array, high: Array, lengths: Array, spin: Array, swing: Array) -> Array:
        """See `SectionModel.bulges`."""
        out, arm = np.empty((len(low), int(self.counts.sum()) + 1)), (self.table, self.counts, self.first)
        if self.extends.any() and lengths.ndim == 3:
            _bulges(low, high, *arm, spin, swing, out, self.scales(lengths))
        else:
            _bulges(low, high, *arm, spin, swing, out)
        return out


def _bend(piece: Piece, section: Geometry) -> float:
    """The largest bend (rad) of a piece within the limits of its section."""
    return math.hypot(piece.alpha * section.bend_limits[0], piece.beta * section.bend_limits[1])


def _longest(piece: Piece, section: Geometry) -> float:
    """How long (m) a piece gets: sections that extend have a single one."""
    return piece.length if section.length_range is None else section.length_range[1]


def _sharpest_bend(pieces: Sequence[Piece], limits: Array) -> float:
    """2 k sin(b/2k) rad of k joints that make the smaller bend b of both limits (2,) rad; b where a piece is curved."""
    found = []
    for axis, limit in enumerate(limits.tolist()):
        shares = [piece[axis] for piece in pieces if piece[axis] > 0.0]
        bend, curved = limit * sum(shares), any(piece.curved and piece[axis] > 0.0 for piece in pieces)
        found.append(bend if curved else 2 * len(shares) * math.sin(bend / (2 * len(shares))))
    return min(found)


def _chords(piece: Piece, section: Geometry) -> int:
    if not piece.curved:
        return 1
    wanted = _longest(piece, section) * _bend(piece, section) / (8.0 * _LEFT_OUT * section.body_radius)
    return min(max(math.ceil(math.sqrt(wanted)), 2), _MOST_CHORDS)


def _sagitta(piece: Piece, section: Geometry, count: int) -> float:
    """How far (m) a piece leaves each of its chords at most: ρ (1 - cos ψ/2) on a circle."""
    if not piece.curved:
        return 0.0
    bend = max(_bend(piece, section), 1e-9)
    return 2.0 * _longest(piece, section) / bend * math.sin(bend / (4 * count)) ** 2


def _gains(pieces: Sequence[Piece]) -> tuple[float, float]:
    """How far the direction of a section's end turns with each angle near zero."""
    whole = sum(piece.length for piece in pieces)
    alpha, beta, behind = 0.0, 0.0, whole
    for piece in pieces:
        lever = behind - (0.5 * piece.length if piece.curved else 0.0)
        alpha, beta = alpha + piece.alpha * lever / whole, beta + piece.beta * lever / whole
        behind -= piece.length
    return alpha, beta
