"""The suite's paths, in families; of every one it is known that the arm can follow it.

Drawn paths, but for the wiggly ones, are as gentle as the joints need: joints one link L apart on a curve of curvature
κ bend by at most 2 asin(κL/2), and an angle of a universal joint is at most its bend. `confirm` proves it a second
time, on the joints.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.evaluation import section_families
from hognose.evaluation.case import LIMIT, LINKS, PITCH, SPACING, STEP, Case, feeds_to
from hognose.evaluation.curves import Profile, drawn, eased
from hognose.robot.kinematics import angles_of

Array = NDArray[np.float64]

#: Spacings sd (m) of the spacing family, and of the quick one. Links of 91 mm are whole numbers of some of them.
SPACINGS = (5e-5, 7e-5, 1e-4, 1.5e-4, 2e-4, 2.5e-4, 3e-4, 4e-4, 5e-4, 6e-4, 8e-4, 1e-3, 1.5e-3, 2e-3, 2.7e-3, 3.5e-3)
QUICK_SPACINGS = (5e-5, 5e-4, 3.5e-3)
#: Numbers of links of the links family, and of the quick one.
LINK_COUNTS = (3, 6, 12, 30, 100, 300, 1000)
QUICK_LINK_COUNTS = (3, 12, 100)


def sharpest_allowed(link: float, limit: float = LIMIT) -> float:
    """The curvature (1/m) on which joints `link` m apart bend by the limit (rad)."""
    return 2.0 * math.sin(limit / 2.0) / link


def suite_of_cases(seed: int = 1, quick: bool = False) -> list[Case]:
    """All cases, the same for the same seed; the quick suite has fewer of each family."""
    return [case for name, make in FAMILIES.items() for case in make(_generator(seed, name), quick)]


def statement(family: str) -> str:
    """How the cases of a family are known to be solvable: what its maker's docstring says first."""
    return (inspect.getdoc(FAMILIES[family]) or "").split("\n\n")[0].replace("\n", " ")


def confirm(case: Case, steps: int = 8, samples: int = 64) -> None:
    """Prove that a case has a solution, or raise InfeasibleError with what is missing.

    The joints of the reference are on the path and on the first crossings by the way they are found. Here they are
    looked at once more: at every feed they are a link apart and bend within the limits, and at some feeds no place that
    is passed on the path from a joint to the next is a link away already.
    """
    if case.model is not None:
        section_families.confirm(case)
        return
    where = f"{case.family}, {case.name}"
    joints, arcs = case.reference
    off = float(np.abs(np.linalg.norm(np.diff(joints, axis=1), axis=2) - case.link_lengths).max())
    if off > 1e-9:
        raise InfeasibleError(f"{where}: a link is off by {off:g} m")
    bend = float(np.abs(angles_of(joints)).max())
    if bend > case.bend_limit:
        raise InfeasibleError(f"{where}: a joint bends by {bend:.4f} rad, its limit is {case.bend_limit:g} rad")
    chosen = np.unique(np.linspace(0, len(case.feeds) - 1, steps).round().astype(int))
    some = np.minimum(arcs[chosen], case.path.length)
    passed = some[:, :-1, None] + np.linspace(0.0, 1.0, samples, endpoint=False) * np.diff(some, axis=1)[..., None]
    away = np.linalg.norm(case.path.point(passed) - joints[chosen][:, :-1, None, :], axis=-1)
    if not (away < case.link_lengths[:, None]).all():
        raise InfeasibleError(f"{where}: a joint is not on the first crossing")


def _cases(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """The two inspections of the paper; solvable, because `hognose plan` makes good plans of both."""
    return [_bundled(name, "cases", name) for name in ("obstacle-array", "pipe-tank")]


def _s_curves(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Plane waves of random height and length; solvable, as their curvature is at most 0.9 of the limit."""
    made = []
    for number in range(1 if quick else 4):
        top = sharpest_allowed(PITCH) * rng.uniform(0.4, 0.9)
        wave, azimuth = rng.uniform(0.5, 1.1), rng.uniform(0.0, 2.0 * math.pi)

        def bend(s: Array, top: float = top, wave: float = wave, azimuth: float = azimuth) -> Array:
            return _along(top * np.sin(2.0 * math.pi * s / wave), azimuth)

        made.append(_case("s-curve", f"wave {number + 1}", bend))
    return made


def _helices(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Screws of random curvature and torsion; solvable, as their curvature is at most 0.85 of the limit."""
    made = []
    for number in range(1 if quick else 3):
        top, torsion = sharpest_allowed(PITCH) * rng.uniform(0.4, 0.85), rng.uniform(1.0, 5.0)
        made.append(_case("helix", f"helix {number + 1}", _screw(top, torsion)))
    return made


def _tight(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """An arc, a wave and a screw 1, 2 and 3 % above the smallest radius that the joints allow; just solvable."""
    top = sharpest_allowed(PITCH)

    def arc(s: Array) -> Array:
        return _along(np.full_like(s, top / 1.01), 0.6)

    def wave(s: Array) -> Array:
        return _along(top / 1.02 * np.tanh(8.0 * np.sin(2.0 * math.pi * s / 1.2)), 2.1)

    cases = [_case("tight", "arc", arc), _case("tight", "wave", wave), _case("tight", "screw", _screw(top / 1.03, 2.5))]
    return cases[:1] if quick else cases


def _near_itself(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """A loop and a coil that come back to within 60 mm of themselves; solvable, as their radius is 230 mm.

    Links are 91 mm, so a later turn is nearer to a joint than the point that is a link away; 28 links for two turns.
    """
    radius, rise = 0.23, 0.06 / (2.0 * math.pi)
    square = radius**2 + rise**2
    coil = _screw(radius / square, rise / square)
    turn = 2.0 * math.pi * math.sqrt(square)

    def loop(s: Array) -> Array:
        return coil(s) * eased(s, turn + 0.15, 0.15)[:, None] * (s < turn + 0.15)[:, None]

    cases = [_case("near-itself", "loop", loop, links=28), _case("near-itself", "coil", coil, links=28)]
    return cases if not quick else cases[1:]


def _wiggly(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """Waves about as long as a link, which the links cut short; solvable, as the joints found keep their limits.

    The path turns by more than a right angle within a link, so a joint moves unsteadily as the arm goes in, and more
    than one point of the path may be a link away. Drawn far sharper than what joints could follow around.
    """
    length, made = 1.6 * LINKS * PITCH, []
    for wave, heading in ((0.12, 1.2), (0.06, 1.2), (0.06, 0.8))[: 1 if quick else 3]:

        def bend(s: Array, wave: float = wave, heading: float = heading) -> Array:
            turning = heading * 2.0 * math.pi / wave * np.cos(2.0 * math.pi * s / wave)
            return _along(turning * eased(s, length, 0.15), 0.7)

        path = drawn(bend, length, LINKS * PITCH, every=0.004)
        name = f"{1e3 * wave:g} mm at {math.degrees(heading):.0f} deg"
        made.append(Case("wiggly", name, path, np.full(LINKS, PITCH), feeds_to(LINKS * PITCH, STEP)))
    return made


def _long(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Arms of 5 and 10 m on paths twice as long; solvable, as their curvature is at most 0.8 of the limit."""
    made = []
    for metres in (10, 20)[: 1 if quick else 2]:
        waves, shifts = rng.uniform(0.9, 3.0, (2, 3)), rng.uniform(0.0, 2.0 * math.pi, (2, 3))
        top = 0.8 * sharpest_allowed(0.15) / math.sqrt(2.0) / 3.0

        def bend(s: Array, waves: Array = waves, shifts: Array = shifts, top: float = top) -> Array:
            phases = 2.0 * math.pi * s[:, None, None] / waves + shifts
            return top * np.sin(phases).sum(axis=2)

        links = round(metres / 2 / 0.15)
        made.append(_case("long", f"{metres} m", bend, links=links, link=0.15, step=0.02, every=0.03))
    return made


def _links(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """One path, and an arm of 1092 mm divided into 3 to 1,000 links; solvable, as the longest can follow it."""
    length = LINKS * PITCH
    top = 0.9 * sharpest_allowed(length / 3)
    made = []
    for links in QUICK_LINK_COUNTS if quick else LINK_COUNTS:
        link = length / links

        def bend(s: Array) -> Array:
            return np.stack([top * np.sin(7.0 * s), 0.4 * top * np.sin(4.0 * s)], axis=1) / 1.08

        # Short links get short steps, or nothing would be left of the last step to start from; the last 313 of them.
        step, spacing = min(STEP, 0.4 * link), min(SPACING, link / 20)
        case = _case("links", f"{links:,} links", bend, links=links, link=link, step=step, spacing=spacing)
        made.append(replace(case, feeds=case.feeds[-313:]))
    return made


def _spacings(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """The pipe tank with point spacings sd from 0.05 to 3.5 mm; solvable, as the pipe tank is."""
    chosen = QUICK_SPACINGS if quick else SPACINGS
    return [_bundled("pipe-tank", "spacing", f"sd = {1e3 * sd:g} mm", sd) for sd in chosen]


#: What makes the cases of each family: (random numbers, quick) to cases.
FAMILIES: dict[str, Callable[[np.random.Generator, bool], list[Case]]] = {
    "cases": _cases,
    "s-curve": _s_curves,
    "helix": _helices,
    "tight": _tight,
    "near-itself": _near_itself,
    "wiggly": _wiggly,
    "long": _long,
    "links": _links,
    "spacing": _spacings,
    **section_families.MAKERS,
}


def _generator(seed: int, family: str) -> np.random.Generator:
    return np.random.default_rng([seed, list(FAMILIES).index(family)])


def _along(curvature: Array, azimuth: float) -> Array:
    return curvature[:, None] * np.array([math.cos(azimuth), math.sin(azimuth)])


def _screw(curvature: float, torsion: float) -> Profile:
    def bend(s: Array) -> Array:
        return curvature * np.stack([np.cos(torsion * s), np.sin(torsion * s)], axis=1)

    return bend


def _case(
    family: str,
    name: str,
    profile: Profile,
    links: int = LINKS,
    link: float = PITCH,
    step: float = STEP,
    spacing: float = SPACING,
    every: float = 0.015,
) -> Case:
    """A drawn case; the arm starts on its straight run and ends with its base at the run's end."""
    arm = links * link
    length = 1.06 * arm + 0.05

    def gentle(s: Array) -> Array:
        return profile(s) * eased(s, length, min(0.15, 0.2 * length))[:, None]

    path = drawn(gentle, length, arm, every)
    sharpest, allowed = path.sharpest[0], sharpest_allowed(link)
    if sharpest > allowed:
        raise InfeasibleError(f"{family}, {name}: curvature {sharpest:.4f} is above {allowed:.4f} 1/m")
    return Case(family, name, path, np.full(links, link), feeds_to(arm, step), LIMIT, spacing)


def _bundled(task_name: str, family: str, name: str, spacing: float = SPACING) -> Case:
    from hognose.files import load_task
    from hognose.planning.planner import insertion

    task = load_task(task_name)
    path = task.path_through(task.way_points)
    return Case(family, name, path, task.robot.link_lengths, insertion(task, path).feed, LIMIT, spacing)
