"""How far links are from obstacles, and which way leads away from them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.route.fit.motion import Motion, looked_at
from hognose.scene import Scene

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def room_of(
    motion: Motion, robot: Robot, scene: Scene, upper: float, guide: Array, deepest: float, tight: float
) -> tuple[Array, Array, Index, Index, Array]:
    """Clearances (q,) m of an insertion and the directions (q, 3) in which they grow; chords, steps, places (q,) there.

    Parameters
    ----------
    motion, robot, scene
    upper, guide, deepest
        As of `apart`.
    tight : m
        Where not all steps are looked at at first, those beside places with so little more than the smallest are, too.
    """
    chord, step, every = looked_at(robot, len(motion.feeds))

    def found(chord: Index, step: Index) -> tuple[Array, Array, Index, Index, Array]:
        starts, ends = motion.line[step, chord], motion.line[step, chord + 1]
        value, normals, fraction = apart(scene, starts, ends, upper, guide, deepest)
        return value - robot.chord_radii[chord], normals, chord, step, fraction

    first = found(chord, step)
    if every == 1:
        return first
    near = np.flatnonzero(first[0] < first[0].min() + tight)
    # Each of these stands for the tightest step around it, so that there are always as many.
    around = np.clip(step[near] + np.arange(1 - every, every)[:, None], 0, len(motion.feeds) - 1)
    others = found(np.tile(chord[near], len(around)), around.ravel())
    tightest = np.argmin(others[0].reshape(around.shape), axis=0) * len(near) + np.arange(len(near))
    for all_of_them, few in zip(first, others, strict=True):
        all_of_them[near] = few[tightest]
    return first


def apart(
    scene: Scene, starts: Array, ends: Array, upper: float, guide: Array, deepest: float
) -> tuple[Array, Array, Array]:
    """Distance (q,) m of links, the direction (q, 3) in which it grows, and where (q,) along the link it is.

    Parameters
    ----------
    scene
    starts, ends : (q, 3) m
    upper
        Distances (m) beyond this are not looked for.
    guide : (g, 3) m
        Where a link cuts a surface, the way to this curve is the one that leads out.
    deepest
        How deep (m) such a link seems to be at most.
    """
    found = scene.distance(starts, ends, upper=upper, threads=1)
    along = ends - starts
    seen = found.triangle >= 0
    on_link = np.where(seen[:, None], found.on_segment, starts)
    away = np.where(seen[:, None], on_link - found.on_mesh, 0.0)
    value = found.value.copy()
    cut = seen & (value < 1e-6)
    if cut.any():
        gap = guide[None] - on_link[cut][:, None]
        nearest = np.argmin((gap**2).sum(axis=2), axis=1)
        away[cut] = gap[np.arange(len(nearest)), nearest]
        value[cut] = -np.minimum(np.linalg.norm(away[cut], axis=1), deepest)
    size = np.linalg.norm(away, axis=1)
    fraction = ((on_link - starts) * along).sum(axis=1) / (along**2).sum(axis=1)
    return value, away / np.maximum(size, 1e-12)[:, None], np.clip(fraction, 0.0, 1.0)
