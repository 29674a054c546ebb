"""Capsules that contain a body with flat sections: an outer bound of it, as one chain of chords.

A flat section is a box in the frame of each of its straight pieces. It is covered by lines parallel to the piece, each
the axis of a capsule: two along each edge, and between the edges so many as the flat sides need. Chords that lead from
one line to the next connect them to a chain; they lie within the box, have the radius 0, and are no body themselves.
How far the capsules stand out of the box is the loss. See docs/certificate.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.kernels import kernel
from hognose.robot.body_shape import BodyShape
from hognose.robot.sections import MixedSections, SectionModel
from hognose.robot.sections.chain import ROWS, X, Y, Z, arc_terms, bend_frame, turn_frame

Array = NDArray[np.float64]

#: The capsules stand out of a flat body by no more than this part of its shorter side.
MOST_LOST = 0.15
#: Widths of the lines along the edges that are tried.
_TRIED = 400


@dataclass(frozen=True)
class Cover:
    """Parallel lines that cover a rectangle about the origin.

    Attributes
    ----------
    offsets : (k, 2) m
        Where they are across the body, along x and y of the section; an odd number of them.
    radii : (k,) m
    loss : (2,) m
        How far they stand out of the sides that are across x, and across y.
    """

    offsets: Array
    radii: Array
    loss: Array

    @classmethod
    def of(cls, width: float, height: float) -> Cover:
        """The cover of a rectangle of a width along x and a height along y, m.

        Along each short side of it two circles are round rectangles of half its length each, so that little stands out
        there; what is left of the long sides has equal parts, each in one circle.
        """
        long, short = max(width, height), min(width, height)
        parts = 1
        edges = np.linspace(0.0, long / 2, _TRIED + 1)[1:]
        while True:
            edge = 0.5 * np.hypot(edges, short / 2)
            middle = 0.5 * np.hypot((long - 2 * edges) / parts, short)
            flat, narrow = np.maximum(edge - short / 4, middle - short / 2), edge - edges / 2
            best = int(np.argmin(np.maximum(flat, narrow)))
            if max(flat[best], narrow[best]) <= MOST_LOST * short:
                break
            parts += 2
        part = (long - 2 * edges[best]) / parts
        along = part * (np.arange(parts) - (parts - 1) / 2)
        beside = (long - edges[best]) / 2
        places = [(-beside, -short / 4), (-beside, short / 4), *((x, 0.0) for x in along), (beside, short / 4)]
        offsets = np.array([*places, (beside, -short / 4)])
        radii = np.array([edge[best]] * 2 + [middle[best]] * parts + [edge[best]] * 2)
        loss = np.array([narrow[best], flat[best]])
        return cls(offsets, radii, loss) if width >= height else cls(offsets[:, ::-1], radii, loss[::-1])


@kernel()
def _axes_along(angles: NDArray, table: NDArray, first: NDArray, out: NDArray) -> None:
    """X and y axes (T, q, 2, 3) of the frames behind the joints of all pieces, of angles (T, n, 2)."""
    frame = np.empty((ROWS, 3))
    for t in range(angles.shape[0]):
        frame[:] = 0.0
        frame[X, 0], frame[Y, 1], frame[Z, 2] = 1.0, 1.0, 1.0
        for i in range(angles.shape[1]):
            for p in range(first[i], first[i + 1]):
                a, b = table[p, 0] * angles[t, i, 0], table[p, 1] * angles[t, i, 1]
                if table[p, 3] == 0.0:
                    turn_frame(frame, a, b)
                else:
                    ca, cb, _, _, _ = arc_terms(a * a + b * b)
                    bend_frame(frame, a, b, ca, cb)
                for k in range(3):
                    out[t, p, 0, k], out[t, p, 1, k] = frame[X, k], frame[Y, k]


@dataclass(frozen=True, eq=False)
class Outline:
    """The chain of capsules that contains a body: of a round one that of its own chords, without any loss.

    Attributes
    ----------
    sections : (c,) int
        The section (0-based) of each chord.
    radii : (c,) m
        0 of chords that only connect others.
    inner_radii : (n,) m
        Of the largest round body within that of each section.
    sides : (n, 2) m
        Widths along x and heights along y of flat sections; 0 of round ones.
    loss : (n, 2) m
        How far the capsules stand out of flat sections, along x and along y of these.
    lines
        Where the chords are, if any section is flat.
    """

    sections: NDArray[np.int64]
    radii: Array
    inner_radii: Array
    sides: Array
    loss: Array
    lines: Lines | None = None

    @property
    def loss_words(self) -> str:
        """How far the capsules of flat sections stand out of them at most, in words; empty without any."""
        if self.lines is None:
            return ""
        x, y = 1e3 * self.loss.max(axis=0)
        end = 1e3 * self.radii[self.sides[self.sections, 0] > 0.0].max()
        return (
            f"clearances are those of capsules that contain it; they stand out of it by up to {x:.2f} mm along its "
            f"width and {y:.2f} mm along its height, and by up to {end:.2f} mm at its ends, the tip and the "
            "outer side of bends"
        )

    @property
    def flat(self) -> bool:
        """Whether any section is flat."""
        return self.lines is not None


@dataclass(frozen=True, eq=False)
class Lines:
    """The chain of an arm with flat sections, of V vertices and V - 1 chords.

    Attributes
    ----------
    vertices, pieces : (V,) int
        The end of a chord of the centre line that each vertex is beside, and the piece in whose frame.
    offsets : (V, 2) m
        How far beside it, along x and y of that frame.
    chords : (V-1,) int
        The chord of the centre line that each chord stands beside.
    table, first
        Pieces of the arm, as of `hognose.robot.sections.chain`.
    """

    vertices: NDArray[np.int64]
    pieces: NDArray[np.int64]
    offsets: Array
    chords: NDArray[np.int64]
    table: Array
    first: NDArray[np.int64]

    def place(self, line: Array, angles: Array) -> Array:
        """Vertices (T, V, 3) m in the arm's own axes, of its centre line (T, p+1, 3) m and angles (T, n, 2) rad."""
        axes = np.empty((len(angles), len(self.table), 2, 3))
        _axes_along(np.ascontiguousarray(angles), self.table, self.first, axes)
        return self.beside(line, axes)

    def beside(self, line: Array, axes: Array) -> Array:
        """Vertices (T, V, 3) m, of the centre line (T, p+1, 3) m and the x and y axes (T, q, 2, 3) of all pieces."""
        return line[:, self.vertices] + np.einsum("vk,tvkx->tvx", self.offsets, axes[:, self.pieces])

    def centre(self, body: Array) -> Array:
        """The centre line (T, p+1, 3) m within vertices (T, V, 3) m."""
        return body[:, self.on_line]

    @cached_property
    def on_line(self) -> NDArray[np.int64]:
        """Which of the vertices are those of the centre line."""
        return np.append(np.searchsorted(self.chords, np.arange(self.vertices[-1])), len(self.vertices) - 1)

    def axes(self, body: Array) -> Array:
        """X and y axes (p, 2, 3) of the body at each chord of the centre line, of vertices (V, 3) m; 0 where round."""
        first, (lines,) = self.on_line[:-1], np.nonzero(np.diff(self.on_line) > 1)
        out = np.zeros((len(first), 2, 3))
        for chord, at in zip(lines.tolist(), first[lines].tolist(), strict=True):
            beside = [at + 1, at + 4]  # where the first two lines begin
            out[chord] = np.linalg.solve(self.offsets[beside], body[beside] - body[at])
        return out

    @cached_property
    def levers(self) -> Array:
        """How far (V,) m the vertices are beside the centre line."""
        return np.linalg.norm(self.offsets, axis=1)

    def bulges(self, bulge: Array, arcs: Array) -> Array:
        """How far (m, V) m vertices leave their straight lines, where those of the centre line do by (m, p+1) m.

        Each bulge there is that before it and the chord's arc (p,) m times what bounds how fast a vector turns that
        is fixed to the chord; so a vertex beside it bulges by its lever times that more. (docs/certificate.md)
        """
        turning = np.maximum(np.diff(bulge, axis=1), 0.0) / arcs
        chord = np.append(self.chords, self.chords[-1])
        return bulge[:, self.vertices] + self.levers * turning[:, chord]


def outline_of(
    shapes: Sequence[BodyShape],
    model: SectionModel,
    lengths: Array,
    chord_sections: NDArray[np.int64],
    chord_radii: Array,
) -> Outline:
    """The outline of an arm with n shapes and lengths (n,) m of sections, and of its centre line's p chords."""
    inner = np.array([shape.inner_radius for shape in shapes])
    covers = {shape: Cover.of(*shape.sides) for shape in set(shapes) if shape.sides is not None}
    if not covers:
        none = np.zeros((len(shapes), 2))
        return Outline(chord_sections, chord_radii, inner, none, none)
    if isinstance(model, MixedSections):
        table, first, counts = model.table, model.first, model.counts
    else:
        ones = np.ones(len(lengths))
        table, counts = np.column_stack([ones, ones, lengths, 0 * ones]), ones.astype(np.int64)
        first = np.arange(len(lengths) + 1)
    pieces = np.repeat(np.arange(len(table)), counts)
    rows: list[tuple[int, int, float, float]] = []
    chords: list[tuple[int, float]] = []
    for chord, (section, piece) in enumerate(zip(chord_sections.tolist(), pieces.tolist(), strict=True)):
        rows.append((chord, piece, 0.0, 0.0))
        cover = covers.get(shapes[section])
        if cover is None:
            chords.append((chord, float(chord_radii[chord])))
            continue
        for line, ((x, y), radius) in enumerate(zip(cover.offsets.tolist(), cover.radii.tolist(), strict=True)):
            ends = (chord, chord + 1) if line % 2 == 0 else (chord + 1, chord)
            rows += [(end, piece, x, y) for end in ends]
            chords += [(chord, 0.0), (chord, radius)]
        chords.append((chord, 0.0))
    rows.append((len(pieces), int(pieces[-1]), 0.0, 0.0))
    vertices, of_piece = np.array([row[:2] for row in rows]).T
    of_chord = np.array([chord for chord, _ in chords])
    lines = Lines(vertices, of_piece, np.array([row[2:] for row in rows]), of_chord, table, first)
    loss = np.array([covers[shape].loss if shape in covers else (0.0, 0.0) for shape in shapes])
    sides = np.array([shape.sides or (0.0, 0.0) for shape in shapes])
    return Outline(chord_sections[of_chord], np.array([radius for _, radius in chords]), inner, sides, loss, lines)
