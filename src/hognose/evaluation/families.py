"""The suite's paths, in families; of every one it is known that the arm can follow it.

Drawn paths are as gentle as the joints need: joints one link L apart on a curve of curvature κ bend by at most
2 asin(κL/2), and an angle of a universal joint is at most its bend. `confirm` proves it a second time on the joints.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.evaluation.curves import Profile, drawn, eased
from hognose.following.exact import Exact
from hognose.path import Path
from hognose.robot.kinematics import angles_of

Array = NDArray[np.float64]

#: The paper's arm: 12 links of 91 mm, joints to 0.5 rad, 3.5 mm a step.
LINKS, PITCH, LIMIT, STEP = 12, 0.091, 0.5, 0.0035
SPACING = 0.0005
#: Spacings sd (m) of the spacing family; the quick suite takes every third.
SPACINGS = (0.00005, 0.0001, 0.00025, 0.0005, 0.001, 0.002, 0.0035)


@dataclass(frozen=True, eq=False)
class Case:
    """An arm, a path and the feeds to follow it with.

    Attributes
    ----------
    family, name : str
    path : Path
        Starts with a straight run along z, as long as the arm.
    link_lengths : (n,) m
    feeds : (T,) m
    bend_limit : float, rad
        Of each of the two angles of every joint.
    spacing : float, m
        Distance sd of the points, for the methods that use them.
    """

    family: str
    name: str
    path: Path
    link_lengths: Array
    feeds: Array
    bend_limit: float = LIMIT
    spacing: float = SPACING


def sharpest_allowed(link: float, limit: float = LIMIT) -> float:
    """The curvature (1/m) on which joints `link` m apart bend by the limit (rad)."""
    return 2.0 * math.sin(limit / 2.0) / link


def suite_of_cases(seed: int = 1, quick: bool = False) -> list[Case]:
    """All cases, the same for the same seed; the quick suite has fewer of each family."""
    return [case for name, make in FAMILIES.items() for case in make(_generator(seed, name), quick)]


def confirm(case: Case, steps: int = 8, samples: int = 64) -> None:
    """Prove that a case has a solution, or raise InfeasibleError with what is missing.

    The joints come from exact following. Independently of it: they are a link apart, the distance from every joint
    along the path stays below a link's length up to the next joint (a dense march, so it is the first crossing),
    and the angles at all steps are within the limit.
    """
    where = f"{case.family}, {case.name}"
    joints, arcs = Exact(case.path, case.link_lengths, case.spacing).run_with_arcs(case.feeds)
    worst = float(np.abs(angles_of(joints)).max())
    if worst > case.bend_limit:
        raise InfeasibleError(f"{where}: a joint bends by {worst:.4f} rad, its limit is {case.bend_limit:g} rad")
    off = float(np.abs(np.linalg.norm(np.diff(joints, axis=1), axis=2) - case.link_lengths).max())
    if off > 1e-10:
        raise InfeasibleError(f"{where}: a link is off by {off:g} m")
    chosen = np.unique(np.linspace(0, len(case.feeds) - 1, steps).round().astype(int))
    parts = np.linspace(0.0, 1.0, samples, endpoint=False)
    some = arcs[chosen]
    between = some[:, :-1, None] + parts * np.diff(some, axis=1)[..., None]
    places = case.path.point(np.minimum(between, case.path.length))
    away = np.linalg.norm(places - joints[chosen][:, :-1, None, :], axis=-1)
    if not (away < case.link_lengths[:, None]).all():
        raise InfeasibleError(f"{where}: a joint is not on the first crossing")
    on_path = float(np.linalg.norm(case.path.point(np.minimum(some, case.path.length)) - joints[chosen], axis=-1).max())
    if on_path > 1e-9:
        raise InfeasibleError(f"{where}: a joint is {on_path:g} m off the path")


def _cases(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """The two inspections of the paper; solvable as `hognose plan` checks them, and `confirm` does."""
    return [_bundled(name, "cases", name) for name in ("obstacle-array", "pipe-tank")]


def _s_curves(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Waves of random height and length in a plane; at most 0.9 of the joints' sharpest curvature."""
    made = []
    for number in range(1 if quick else 4):
        top = sharpest_allowed(PITCH) * rng.uniform(0.4, 0.9)
        wave, azimuth = rng.uniform(0.5, 1.1), rng.uniform(0.0, 2.0 * math.pi)

        def bend(s: Array, top: float = top, wave: float = wave, azimuth: float = azimuth) -> Array:
            return _along(top * np.sin(2.0 * math.pi * s / wave), azimuth)

        made.append(_case("s-curve", f"wave {number + 1}", bend))
    return made


def _helices(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Screws of constant curvature and torsion; at most 0.85 of the joints' sharpest curvature."""
    made = []
    for number in range(1 if quick else 3):
        top, torsion = sharpest_allowed(PITCH) * rng.uniform(0.4, 0.85), rng.uniform(1.0, 5.0)
        made.append(_case("helix", f"helix {number + 1}", _screw(top, torsion)))
    return made


def _tight(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """Bends a hair above the smallest radius, 183.9 mm for 91 mm links and 0.5 rad: 1, 2 and 3 % above it."""
    top = sharpest_allowed(PITCH)

    def arc(s: Array) -> Array:
        return _along(np.full_like(s, top / 1.01), 0.6)

    def wave(s: Array) -> Array:
        return _along(top / 1.02 * np.tanh(8.0 * np.sin(2.0 * math.pi * s / 1.2)), 2.1)

    cases = [_case("tight", "arc", arc), _case("tight", "wave", wave), _case("tight", "screw", _screw(top / 1.03, 2.5))]
    return cases[:1] if quick else cases


def _near_itself(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """Paths that come back within a link of themselves, radius 230 mm and 60 mm of rise a turn, 28 links.

    The first point at a link's length is still unique, but a later turn is nearer to many joints than it.
    """
    radius, rise = 0.23, 0.06 / (2.0 * math.pi)
    square = radius**2 + rise**2
    coil = _screw(radius / square, rise / square)
    turn = 2.0 * math.pi * math.sqrt(square)

    def loop(s: Array) -> Array:
        return coil(s) * eased(s, turn + 0.15, 0.15)[:, None] * (s < turn + 0.15)[:, None]

    cases = [_case("near-itself", "loop", loop, links=28), _case("near-itself", "coil", coil, links=28)]
    return cases if not quick else cases[1:]


def _long(rng: np.random.Generator, quick: bool) -> list[Case]:
    """Paths of 10 and 20 m for arms half as long, of 150 mm links; at most 0.8 of the joints' sharpest curvature."""
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
    """One path for an arm of 1092 mm in 3 to 1,000 links; gentle enough for the longest link."""
    length = LINKS * PITCH
    top = 0.9 * sharpest_allowed(length / 3)
    made = []
    for links in (3, 12, 100, 1000):
        link = length / links

        def bend(s: Array) -> Array:
            return np.stack([top * np.sin(7.0 * s), 0.4 * top * np.sin(4.0 * s)], axis=1) / 1.08

        made.append(_case("links", f"{links:,} links", bend, links=links, link=link, spacing=min(SPACING, link / 20)))
    return made


def _spacings(_rng: np.random.Generator, quick: bool) -> list[Case]:
    """The pipe tank at seven distances sd of the points; solvable as the pipe tank is."""
    chosen = SPACINGS[::3] if quick else SPACINGS
    return [_bundled("pipe-tank", "spacing", f"sd = {1e3 * sd:g} mm", sd) for sd in chosen]


#: What makes the cases of each family: (random numbers, quick) to cases.
FAMILIES: dict[str, Callable[[np.random.Generator, bool], list[Case]]] = {
    "cases": _cases,
    "s-curve": _s_curves,
    "helix": _helices,
    "tight": _tight,
    "near-itself": _near_itself,
    "long": _long,
    "links": _links,
    "spacing": _spacings,
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
    feeds = np.append(np.arange(0.0, arm - 0.5 * step, step), arm)
    return Case(family, name, path, np.full(links, link), feeds, LIMIT, spacing)


def _bundled(task_name: str, family: str, name: str, spacing: float = SPACING) -> Case:
    from hognose.files import load_task
    from hognose.planning.planner import insertion_feeds

    task = load_task(task_name)
    path = task.path_through(task.way_points)
    return Case(family, name, path, task.robot.link_lengths, insertion_feeds(task, path), LIMIT, spacing)
