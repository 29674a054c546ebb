"""Small cases, hand-made rows, and slow second opinions on what is measured."""

import math

import numpy as np

from hognose.evaluation.case import Case
from hognose.evaluation.machine import machine, measured_version
from hognose.evaluation.measure import Row
from hognose.evaluation.suite import Results
from hognose.path import Path


def small_case(family="cases", name="pipe-tank", links=3, steps=5, spacing=0.002, limit=0.5):
    """Three links of 91 mm on a path that bends gently to one side; all of it takes milliseconds."""
    points = np.array([[0, 0, 0], [0.01, 0.0, 0.1], [0.04, 0.01, 0.2], [0.08, 0.02, 0.3], [0.1, 0.03, 0.45]])
    length = 0.091 * links
    path = Path.through(points, 3, (0.0, 0.0, 1.0)).with_run(length)
    return Case(family, name, path, np.full(links, 0.091), np.linspace(0.0, length, steps), limit, spacing)


def ring_case(radius, links=3, turns=1.2):
    """Links of 91 mm on a ring that closes on itself, 2 mm beside its start."""
    angle = np.linspace(0.0, 2.0 * math.pi * turns, 120)
    ring = np.stack([radius * (1.0 - np.cos(angle)), 0.002 * angle / math.tau, radius * np.sin(angle)], axis=1)
    path = Path.through(ring, 3, (0.0, 0.0, 1.0)).with_run(0.1)
    return Case("ring", "ring", path, np.full(links, 0.091), np.linspace(0.0, 0.1, 6), 0.5, 0.0005)


def row(method, family="cases", case="pipe-tank", **figures):
    """A valid row of a method, with the figures given."""
    given = {"solved": True, "valid": True, "why": "", "steps": 304, "all_steps": 304, "links": 12, "spacing_mm": 0.5}
    given["arm_m"] = 1.092
    return Row(method=method, family=family, case=case, path_m=2.0, **{**given, **figures})


def results(rows, races=None, **more):
    """Results of rows made by hand."""
    given = {"version": measured_version(), "seed": 1, "quick": True, "machine": machine(), **more}
    return Results(rows=tuple(rows), races=races or {}, **given)


def marched(path, start, center, length, stride=2e-5):
    """The arc of the first point beyond `start` this far from the centre, by walking, at most five lengths far."""
    end = min(path.length, start + 5.0 * length)
    arcs = np.append(np.arange(start + stride, end, stride), end)
    beyond = np.flatnonzero(np.linalg.norm(path.point(arcs) - center, axis=1) >= length)
    assert beyond.size, "the walk found nothing"
    return float(arcs[beyond[0]])


def bends(joints, base=(0.0, 0.0, 1.0)):
    """The angle (T, n) rad between every link and the one before it, the first with the slider."""
    links = np.diff(joints, axis=1)
    links = links / np.linalg.norm(links, axis=2, keepdims=True)
    before = np.concatenate([np.broadcast_to(base, links[:, :1].shape), links[:, :-1]], axis=1)
    return np.arccos(np.clip((links * before).sum(axis=2), -1.0, 1.0))
