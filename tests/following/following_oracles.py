"""Paths to follow, and slow second opinions on where joints belong on them."""

import math
from functools import cache

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from hognose.following import METHODS
from hognose.path import Path
from hognose.robot.sections import KINDS, Geometry, MixedSections

SLIDER = (0.0, 0.0, 1.0)
#: Methods whose joints glide along a curve; of these, those whose curve is the path; and of these, those that promise
#: the first crossing even where a path turns by more than a right angle within a link.
GLIDING = [name for name, method in METHODS.items() if method.glides]
ON_PATH = [name for name in GLIDING if METHODS[name](Path.through([[0, 0, 0], [0, 0, 1]]), [0.1]).keeps_to_path]
FIRST_CROSSING = [name for name in ON_PATH if name != "optimization"]
MARCH = 1e-5


def random_path(seed, kind="gentle", order=3, run=1.1):
    """A slider's run, then way-points at random; `wild` ones turn by more than a link can take."""
    rng = np.random.default_rng(seed)
    bends, size = {"gentle": (0.25, 0.4), "wild": (1.2, 0.13)}[kind]
    steps = bends * rng.normal(size=(int(rng.integers(3, 7)), 3)) + np.array(SLIDER)
    steps *= rng.uniform(0.7, 1.3, (len(steps), 1)) * size / np.linalg.norm(steps, axis=1)[:, None]
    if order == 1:
        steps[0] = [0, 0, size]
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    # A straight tail, so that the whole arm has room beyond the base.
    points = np.append(points, points[-1:] + np.array([[0.0, 0.0, 0.6]]), axis=0)
    return Path.through(points, order, None if order == 1 else SLIDER).with_run(run)


def spline(points, order=3):
    return Path.through(np.array(points, dtype=float), order)


@cache
def knotted_paths():
    """Paths that come back near themselves, and bends tighter than a link: name -> path."""
    turn = np.linspace(0, 1.6 * np.pi, 15)[1:]
    hairpin = [[0, 0, 0], [0, 0, 0.5], [0.015, 0, 0.56], [0.03, 0, 0.5], [0.03, 0, 0.1], [0.03, 0, -0.6]]
    kinks = [[0, 0, 0], [0, 0, 0.4], [0.05, 0, 0.2], [0.1, 0, 0.5], [0.02, 0.02, 0.05], [0.7, 0, 0]]
    tight = [[0.01 * (-1) ** k, 0, 0.03 * k] for k in range(40)]
    ring = np.column_stack([0.045 * np.sin(turn), 0.004 * turn, 0.4 - 0.045 * np.cos(turn) + 0.045])
    ends = np.array([[0, 0, 0], [0, 0, 0.2], [0, 0, 0.35]])
    coil = [[0.03 * math.sin(a), 0.03 * math.cos(a), 0.05 * a / math.tau] for a in np.linspace(0, 16 * math.tau, 190)]
    eight = [[0.12 * math.sin(a), 0.002 * a, 0.12 * math.sin(2 * a)] for a in np.linspace(0, 2 * math.tau, 60)]
    return {
        "hairpin": spline(hairpin),
        "zigzag": spline(tight),
        "ring": spline(np.concatenate([ends, ring, [[-0.3, 0.05, 0.2], [-0.9, 0.05, 0.0]]])),
        "coil": spline(coil, 5),
        "figure of eight": spline(eight),
        "kinked line": spline(kinks, 1),
        "back and forth": spline([[0, 0, 0], [0, 0, 0.2], [0.003, 0, 0], [0.006, 0, 0.2], [0.009, 0, 0], [0.9, 0, 0]]),
    }


class Marcher:
    """Finds the first crossing by walking along the curve in steps of 0.01 mm."""

    def __init__(self, path):
        self.path = path
        self.arcs = np.union1d(np.arange(0, path.length, MARCH), path.break_arcs)
        self.points = path.point(self.arcs)

    def near(self, place, about, within):
        """Arc of the sample closest to a place, looked for around an arc."""
        low, high = np.searchsorted(self.arcs, [about - within, about + within])
        gaps = np.linalg.norm(self.points[low:high] - place, axis=1)
        return float(self.arcs[low + np.argmin(gaps)])

    def first_crossing(self, center, start, length, clear):
        """Arc of the first point beyond `start` this far from the centre, and how clear-cut that is.

        Returns (arc, cosine): the slope of the distance there; 0 if the distance all but reached the length
        before, or falls short of it again within `clear` m of arc. (None, largest distance) if the path ends.
        """
        begin = int(np.searchsorted(self.arcs, start + 2 * MARCH))
        farthest = float(np.linalg.norm(self.points[begin - 1] - center)) if begin else 0.0
        while begin < len(self.arcs):
            distance = np.linalg.norm(self.points[begin : begin + 4096] - center, axis=1)
            beyond = np.flatnonzero(distance >= length)
            rises = np.concatenate([[distance[0] - farthest], np.diff(distance)])
            turns = np.flatnonzero((rises[:-1] >= 0) & (rises[1:] < 0))
            if beyond.size:
                turns = turns[turns < beyond[0]]
            if turns.size and distance[turns].max() > length - clear:
                return float(self.arcs[begin + turns[0]]), 0.0
            if beyond.size:
                return self._refined(center, length, begin + int(beyond[0]), clear)
            farthest, begin = float(distance[-1]), begin + 4096
        return None, float(np.linalg.norm(self.points[-1] - center))

    def _refined(self, center, length, at, clear):
        def gap(s):
            return float(np.linalg.norm(self.path.point(s) - center)) - length

        low, high = self.arcs[at - 1], self.arcs[at]
        arc = brentq(gap, low, high, xtol=1e-15) if gap(low) < 0 < gap(high) else high
        after = self.points[at : at + int(clear / MARCH) + 2]
        if (np.linalg.norm(after - center, axis=1) < length).any():
            return arc, 0.0
        chord = (self.path.point(arc) - center) / length
        return arc, float(chord @ self.path.tangent(arc))


def predicted(path, lengths, feeds, spacing):
    """Prediction lookup as the paper writes it (eqs. 4-10, figure 4): all three candidates, one step at a time."""
    points = path.equal_distance_points(spacing)
    increments = [round(length / spacing) for length in lengths]  # eq. 6
    joints = []
    for feed in feeds:
        index = math.floor(feed / spacing + 0.5)  # eq. 7
        row = [points[index]]
        for i, length in enumerate(lengths):
            found = walked(points, index, index + increments[i], row[-1], length)  # eq. 8
            increments[i], index = found - index, found
            row.append(points[found])
        joints.append(row)
    return np.array(joints)


def walked(points, base, found, center, length):
    """Eqs. 9 and 10, repeated until the middle candidate is the best."""
    while True:
        candidates = [found, found - 1, found + 1]
        errors = [abs(np.linalg.norm(points[c] - center) - length) for c in candidates]
        best = int(np.argmin(errors))
        if best == 0:
            return found
        found = candidates[best]
        assert found > base


def interpolated(path, lengths, feeds, spacing):
    """Eqs. 11-12 on the pair of neighbours that brackets the length, beside the point the lookup finds."""
    points = path.equal_distance_points(spacing)
    joints = []
    for feed in feeds:
        index = int(feed / spacing)
        row = [points[index] + (feed / spacing - index) * (points[index + 1] - points[index])]
        for length in lengths:
            found = walked(points, index, index + round(length / spacing), row[-1], length)
            if np.linalg.norm(points[found] - row[-1]) > length:
                found -= 1
            here, there = (float(np.linalg.norm(points[found + k] - row[-1])) for k in (0, 1))
            assert here <= length <= there
            row.append(points[found] + (length - here) / (there - here) * (points[found + 1] - points[found]))
            index = found
        joints.append(row)
    return np.array(joints)


def arm(kinds, pitches, joints=4, limit=1.5, tool=0.0):
    """The model and the lengths of an arm of sections of kinds, its joints bent by `limit` (rad) at most."""
    keys = {"joints": {"joints": joints}, "hinges": {"axis_offset": 0.02}, "link": {}, "arc": {}}
    blank = {"joints": None, "axis_offset": None, "disks": None}
    sections = [
        Geometry(float(pitch), 0.0, 0.0, 0.02, (limit, limit), **{**blank, **keys[kind]})
        for kind, pitch in zip(kinds, pitches, strict=True)
    ]
    lengths = np.array(pitches, dtype=float)
    lengths[-1] += tool
    return MixedSections([KINDS[kind] for kind in kinds], sections, tool), lengths


def places(model, body, angles, base=None):
    """Samples of the body and its tip (q+1, 3), from a base at a place (3,) with a turn, by rotations of scipy's."""
    (place, turn), found = base or (np.zeros(3), Rotation.identity()), []
    for i, (alpha, beta) in enumerate(angles):
        for p in range(model.first[i], model.first[i + 1]):
            share_a, share_b, length, curved = model.table[p]
            a, b = share_a * alpha, share_b * beta
            parts = [*body[4][body[3] == p], 1.0]
            if not curved:
                turn = turn * Rotation.from_euler("YX", [a, b])
                ways = [place + part * length * turn.apply([0, 0, 1.0]) for part in parts]
            else:
                bend = math.hypot(a, b)
                chords = [part * length * np.sinc(part * bend / 2 / math.pi) for part in parts]
                ways = [
                    place + chord * (turn * Rotation.from_rotvec(np.array([b, a, 0]) * part / 2)).apply([0, 0, 1.0])
                    for part, chord in zip(parts, chords, strict=True)
                ]
                turn = turn * Rotation.from_rotvec([b, a, 0])
            found += ways[:-1]
            place = ways[-1]
    return np.array([*found, place])
