"""The suite's paths for arms whose sections bend along their length or at several joints.

A section's end is found on the path in closed form: of k equal joints, from a start along T, an end at the angle θ to T
is d = L sin(kθ/(k+1)) / (k sin(θ/(k+1))) away, and the section turns by 2kθ/(k+1) in that plane; of an arc, L sin θ/θ
and 2θ (docs/following.md). Where α and β are both bent a stack of joints leaves that plane a little.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.evaluation.case import LIMIT, LINKS, PITCH, STEP, Case, feeds_to
from hognose.evaluation.curves import Profile, drawn, eased
from hognose.evaluation.shapes import PUBLISHED_KINDS, shape
from hognose.path import Path
from hognose.robot.sections import KINDS, Geometry, MixedSections

Array = NDArray[np.float64]

#: Shapes of each kind, how many of them are drawn, and for a quick run; sections of their arm, of 1 m; the largest |α|
#: and |β| (rad) of each; and feeds, of the last of which the arm is wholly in.
EACH, SHOWN, QUICK_SHOWN, SECTIONS, SUPPLE, POSES = 40, 40, 2, 3, 1.5, 30
#: Paths bend by this part of what sections can: those with their ends on the path bend up to a third more than it.
_PART = 0.7
#: Radius (m) of the bodies, which nothing is measured of.
_RADIUS = 0.01
#: What is left (m) of an inspection's path in front of the tip: bodies of arcs end a little beyond their own length.
_LEFT = 0.002
#: The march to a section's end ends when it lacks so little (m), or has failed after so many passes.
_CLOSE, _MOST_PASSES = 1e-12, 500
#: Samples of a section's length at which the turn of the shapes is looked at.
_SAMPLES = 200


def equal_sections(count: int, pitch: float, limit: float, joints: int | None = None) -> MixedSections:
    """The model of an arm of equal arcs, or of equal stacks of joints."""
    section = Geometry(pitch, 0.0, 0.0, _RADIUS, (limit, limit), joints)
    return MixedSections([KINDS["joints" if joints else "arc"]] * count, [section] * count, 0.0)


def confirm(case: Case) -> None:
    """Prove that sections of a case can follow its path, or raise InfeasibleError with what is missing.

    Of the drawn shapes: that no part of the path as long as a section turns by more than a section can. Of all others
    the ends of the sections are found on the path, by a march that shares no code with the methods, and the sections
    between them bend within the limits.
    """
    where = f"{case.family}, {case.name}"
    worst = float((_turns(case) if case.family == "shapes" else bends(case)).max())
    if worst > case.bend_limit:
        raise InfeasibleError(f"{where}: a section bends by {worst:.4f} rad, its limit is {case.bend_limit:g} rad")


def _turns(case: Case) -> Array:
    """By how much (m,) rad the path turns along parts as long as a section."""
    pitch = float(case.link_lengths.max())
    begins = np.linspace(0.0, case.path.length - pitch, _SAMPLES)
    inside = begins[:, None] + np.linspace(0.0, pitch, _SAMPLES // 10)
    tangents = case.path.tangent(inside)
    along = np.einsum("ijk,ik->ij", tangents, tangents[:, 0])
    return np.arccos(np.clip(along, -1.0, 1.0)).max(axis=1)


def bends(case: Case) -> Array:
    """How much (T, n) rad every section bends whose ends are on the path; InfeasibleError if no end is found."""
    assert case.model is not None
    where = f"{case.family}, {case.name}"
    arcs, tangent = np.array(case.feeds), case.path.tangent(case.feeds)
    ends, found = case.path.point(arcs), np.empty((len(arcs), len(case.link_lengths)))
    for i, length in enumerate(case.link_lengths):
        joints = case.model.sections[i].joints
        arcs, away, angle = _marched(case.path, ends, tangent, arcs, float(length), joints, where)
        share = 1.0 if joints is None else joints / (joints + 1)
        found[:, i] = 2.0 * share * angle
        chord = away / np.linalg.norm(away, axis=1)[:, None]
        across = chord - np.einsum("ij,ij->i", chord, tangent)[:, None] * tangent
        across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
        tangent = np.cos(found[:, i])[:, None] * tangent + np.sin(found[:, i])[:, None] * across
        ends = ends + away
    return found


def _marched(
    path: Path, ends: Array, tangent: Array, arcs: Array, length: float, joints: int | None, where: str
) -> tuple[Array, Array, Array]:
    """Arc lengths (T,), ways (T, 3) and their angles (T,) to the tangents, of sections from the ends on."""
    arc = arcs + length
    for _ in range(_MOST_PASSES):
        away = path.point(np.minimum(arc, path.length)) - ends
        angle = np.arctan2(np.linalg.norm(np.cross(tangent, away), axis=1), np.einsum("ij,ij->i", tangent, away))
        lacking = _reach(length, angle, joints) - np.linalg.norm(away, axis=1)
        if np.abs(lacking).max() <= _CLOSE:
            return arc, away, angle
        arc = arc + lacking
    raise InfeasibleError(f"{where}: no end of a section was found on the path in {_MOST_PASSES} passes")


def _reach(length: float, angle: Array, joints: int | None) -> Array:
    """How far (T,) m a section reaches at an angle (T,) rad to its beginning."""
    if joints is None:
        return length * np.sinc(angle / math.pi)
    share = np.where(angle > 1e-9, angle, 1e-9) / (joints + 1)
    return length * np.sin(joints * share) / (joints * np.sin(share))


def _arcs(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Waves and screws for arms of 12 and 6 arcs; solvable, as ends of sections are found on the paths, in limits.

    And the two inspections of the paper, for the paper's arm with arcs in place of its links.
    """
    made = [_bundled(name) for name in ("obstacle-array", "pipe-tank")]
    return made + _drawn("arcs", rng, ((12, None),) if quick else ((12, None), (6, None)), 1 if quick else 2)


def _stacks(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Waves and screws for arms of 12 stacks of 3 joints and 6 of 6; solvable, as such ends are found here, too."""
    return _drawn("stacks", rng, ((12, 3),) if quick else ((12, 3), (6, 6)), 1 if quick else 2)


def _shapes(rng: np.random.Generator, quick: bool) -> list[Case]:
    """S, C and robot shapes for three arcs on a slider; solvable near the path: it turns no more than sections can."""
    made, model = [], equal_sections(SECTIONS, 1.0 / SECTIONS, SUPPLE)
    lengths, feeds = np.full(SECTIONS, 1.0 / SECTIONS), np.linspace(0.0, 1.0, POSES)
    for kind in PUBLISHED_KINDS:
        seeds = rng.integers(2**32, size=EACH)  # so that a quick run draws some of the same shapes
        for number, seed in enumerate(seeds[: QUICK_SHOWN if quick else SHOWN], 1):
            path = shape(kind, 1.0, np.random.default_rng(seed))
            made.append(Case("shapes", f"{kind} {number}", path, lengths, feeds, SUPPLE, model=model))
    return made


#: What makes the cases of each family, as in `hognose.evaluation.families`.
MAKERS: dict[str, Callable[[np.random.Generator, bool], list[Case]]] = {
    "arcs": _arcs,
    "stacks": _stacks,
    "shapes": _shapes,
}


def _drawn(family: str, rng: np.random.Generator, arms: tuple[tuple[int, int | None], ...], each: int) -> list[Case]:
    """Waves and screws, as many of each for every arm: numbers of sections, and of their joints."""
    made = []
    for sections, joints in arms:
        pitch = LINKS * PITCH / sections
        limit = LIMIT * LINKS / sections
        for number in range(each):
            top, side = _PART * limit / pitch * rng.uniform(0.6, 1.0, 2), rng.uniform(0.0, 2.0 * math.pi)
            wave, torsion = rng.uniform(0.7, 1.1), rng.uniform(1.0, 4.0)

            def waves(s: Array, top: float = top[0], wave: float = wave, side: float = side) -> Array:
                return top * np.sin(2.0 * math.pi * s / wave)[:, None] * [math.cos(side), math.sin(side)]

            def screw(s: Array, top: float = top[1], torsion: float = torsion) -> Array:
                return top * np.stack([np.cos(torsion * s), np.sin(torsion * s)], axis=1)

            words = f"{sections} arcs" if joints is None else f"{sections} x {joints} joints"
            model = equal_sections(sections, pitch, limit, joints)
            for name, profile in (("wave", waves), ("screw", screw)):
                made.append(_case(family, f"{name} {number + 1}, {words}", profile, model, limit))
    return made


def _case(family: str, name: str, profile: Profile, model: MixedSections, limit: float) -> Case:
    arm = LINKS * PITCH
    length = 1.06 * arm + 0.05

    def gentle(s: Array) -> Array:
        return profile(s) * eased(s, length, 0.25 * arm)[:, None]

    lengths = np.array([section.pitch for section in model.sections])
    path = drawn(gentle, length, arm)
    return Case(family, name, path, lengths, feeds_to(arm, STEP), limit, model=model)


def _bundled(name: str) -> Case:
    """A bundled inspection by 12 arcs."""
    from hognose.files import load_task

    task = load_task(name)
    path, arm = task.path_through(task.way_points), LINKS * PITCH
    model = equal_sections(LINKS, PITCH, LIMIT)
    feeds = feeds_to(path.length - arm - _LEFT, STEP)
    return Case("arcs", name, path, np.full(LINKS, PITCH), feeds, LIMIT, model=model)
