"""A plan as one page that can be read, printed and handed on without anything beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hognose.planning.assumed import assumed_values
from hognose.planning.base_words import base_words, profile_words
from hognose.planning.checks.check import Check, tally
from hognose.planning.link_budgets import clearance_left
from hognose.planning.loads import HEADINGS, loads
from hognose.report.animation import Film, gif
from hognose.report.charts import has_closest, least_clearance
from hognose.report.figures import (
    body_deviation,
    cable_lengths,
    clearance_map,
    instants,
    joint_angles,
    steps_at,
    tip_error,
)
from hognose.report.mechanics import mechanics
from hognose.report.page import bullets, heading, page, picture, table
from hognose.report.style import png, svg
from hognose.report.tolerance_section import tolerance_section
from hognose.wording import at_least_mm, at_most, span
from hognose.write_whole import write_whole

if TYPE_CHECKING:
    from hognose.planning.plan import Plan

Progress = Callable[[int, int], None]

#: A moving picture larger than this is laid beside the page instead of into it, bytes.
EMBED_LIMIT = 6_000_000
_FRAMES = 90
_CHARTS = 6


def write_report(
    plan: Plan,
    path: Path | str,
    *,
    times: Sequence[float] | None = None,
    animation: bool = True,
    progress: Progress | None = None,
) -> list[Path]:
    """Verify a plan and write a page about it: verdict, key figures, checks, assumptions, figures.

    Parameters
    ----------
    plan
    path
        Of the page (HTML); the folder must be there.
    times
        Instants to show the arm at, s; by default four, spread evenly.
    animation
        Whether to show the motion as well.
    progress
        Called with the number of figures and frames done and the number of all.

    Returns
    -------
    written
        The page; and the moving picture where it is too large to lie inside the page.

    Raises
    ------
    InputError
        If a time lies outside the plan, or the file cannot be written.
    """
    path, plan = Path(path), plan.verified()
    frames = min(_FRAMES, len(plan.time)) if animation else 0
    total, written = _CHARTS + frames, [path]

    def charted(done: int) -> None:
        if progress is not None:
            progress(done, total)

    parts = [_title(plan), heading("Key figures"), table((), key_figures(plan))]
    parts += [*tolerance_section(plan), *_mechanics(plan), heading("Checks"), checks_table(plan), *_assumptions(plan)]
    parts.append(heading("Figures"))
    parts += _figures(plan, times, charted)
    if animation:
        moving = gif(plan, Film(frames), progress=lambda done, _: charted(_CHARTS + done))
        beside = path.with_suffix(".gif")
        if len(moving) < EMBED_LIMIT:
            title, text = "The motion", "The whole motion, repeated."
            parts.append(picture("image/gif", moving, title, text, moving=True))
        else:
            write_whole(beside, moving)
            written.append(beside)
            parts.append(f"<p>The animation is in the file {escape(beside.name)}, beside this page.</p>")
    parts.append(f"<footer>Made by Hognose. Robot {escape(plan.robot.name)}, task {escape(plan.task.name)}.</footer>")
    write_whole(path, page(f"{plan.task.name}: {plan.robot.name}", parts).encode("utf-8"))
    return written


def key_figures(plan: Plan) -> list[tuple[str, str]]:
    """Return the key figures as names and values with units."""
    robot = plan.robot
    length, bend = float(np.sum(robot.link_lengths)) * 1e3, np.degrees(np.abs(plan.angles))
    round_, sides = robot.outline.sides[:, 0] == 0.0, np.unique(np.round(1e3 * robot.outline.sides, 3), axis=0)
    thick = [f"{span(2e3 * np.unique(np.round(robot.body_radii[round_], 6)))} mm"] if round_.any() else []
    thick += [f"flat {width:g} × {height:g} mm" for width, height in sides if width > 0]
    change = (plan.commanded_lengths - robot.straight_cable_lengths) * 1e3
    constant = plan.task.spec.motion.profile_of(plan.retracts) == "constant"
    speed = np.gradient(change, plan.time, axis=0) if len(plan.time) > 1 else np.zeros_like(change)
    return [
        ("Robot", f"{robot.name}: {len(robot.link_lengths)} sections, {change.shape[1]} cables"),
        ("Arm, length and diameter", f"{length:.0f} mm, {', '.join(thick)}"),
        *([("Flat body", robot.outline.loss_words)] if robot.outline.flat else []),
        ("Base", base_words(plan.task)),
        *([] if constant else [("Profile", profile_words(plan))]),
        ("Obstacles", ", ".join(plan.task.placed_scene.names) or "none"),
        *([("Obstacles that move", ", ".join(each.name for each in plan.task.moving))] if plan.task.moving else []),
        *([("Notes on files", "; ".join(plan.remarks))] if plan.remarks else []),
        ("Way-points", str(len(plan.way_points))),
        ("Duration", f"{plan.time[-1] - plan.time[0]:.1f} s in {len(plan.time) - 1} steps"),
        ("Feed", f"{(plan.feed[-1] - plan.feed[0]) * 1e3:.1f} mm"),
        ("Smallest clearance at the steps", least_clearance(plan)),
        ("Certified clearance of the whole motion", _certified(plan)),
        ("Required clearance", f"{plan.task.margin * 1e3:g} mm"),
        ("Largest bend angle", f"{at_most(bend.max(), 1)} deg"),
        ("Body deviation from the path, largest and root mean square", _deviation(plan)),
        ("Largest tip error", f"{float(np.max(plan.tip_error)) * 1e3:.3g} mm"),
        *([("Sections, their lengths", _section_lengths(plan))] if robot.extends else []),
        ("Cables, largest change of what motors command", f"{at_most(np.abs(change).max(), 1)} mm"),
        ("Cables, largest speed", f"{at_most(np.abs(speed).max())} mm/s"),
        ("Motors, range of positions", f"{plan.motor_counts.min()} to {plan.motor_counts.max()} counts"),
    ]


def _section_lengths(plan: Plan) -> str:
    """How short and how long sections that extend are on the way, and how much they can be."""
    extending = plan.robot.extending
    lengths, (low, high) = 1e3 * plan.section_lengths[:, extending], 1e3 * plan.robot.length_bounds[extending].T
    return f"{lengths.min():.1f} to {lengths.max():.1f} mm, of {low.min():g} to {high.max():g} mm"


def _mechanics(plan: Plan) -> list[str]:
    """Whether the arm holds it: a table, on what it rests, and a figure; nothing where mechanics are not known."""
    if plan.task.mechanics is None:  # the checks say so
        return []
    found = loads(plan)
    words = [f"<p>{escape(text)}</p>" for text in found.sentences]
    body = table(HEADINGS, found.rows, numbers=(1, 2, 3))
    given = table(("Taken for it", "", ""), found.given)
    drawn = picture("image/svg+xml", svg(mechanics(found)), "Tensions, load factor and sag", _MECHANICS)
    return [heading("Will the arm hold it?"), *words, body, given, drawn]


def _certified(plan: Plan) -> str:
    proven = plan.certified_clearance
    beside = "" if plan.task.budget is None else ", tolerances taken off"
    return "none" if proven is None else f"≥ {at_least_mm(proven)} mm{beside}"


def _deviation(plan: Plan) -> str:
    away = plan.body_deviation * 1e3
    return f"{at_most(away.max())} mm, {np.sqrt(np.mean(away**2)):.2f} mm"


def checks_table(plan: Plan) -> str:
    """Return the checks of a plan as a table of HTML."""
    rows = [
        (
            check.name,
            check.figures[0],
            f"{check.relation} {check.figures[1]}" if check.has_figures else "",
            _where(plan, check),
            check.verdict,
        )
        for check in plan.checks
    ]
    return table(("Check", "Value", "Limit", "Where", "Verdict"), rows, numbers=(1, 2))


def _where(plan: Plan, check: Check) -> str:
    places = list(check.place)
    if check.step is not None:
        places[0] += f" ({plan.time[check.step]:.2f} s)"
    return ", ".join([*places, check.detail] if check.detail else places)


def _title(plan: Plan) -> str:
    said = tally(check for check in plan.checks if check.judged)
    if not plan.checks:
        mark, word, why = "bad", "Not checked", "No check was made."
    elif plan.good:
        mark, word, why = "good", "Good", f"{said[0].upper()}{said[1:]}."
    else:
        mark, word = "bad", "Not good"
        failed = ", ".join(check.name for check in plan.checks if check.failed)
        why = f"{said}: {failed}." if failed else "Nothing was judged."
    unjudged = [check.name for check in plan.checks if not check.judged]
    why += f" Not judged: {', '.join(unjudged)}." if unjudged else ""
    return (
        f"<h1>{escape(plan.task.name)}</h1>\n"
        f'<p class="sub">Motion plan for the arm {escape(plan.robot.name)}</p>\n'
        f'<p class="verdict {mark}" role="status"><strong>{word}.</strong>{escape(why)}</p>'
    )


def _assumptions(plan: Plan) -> list[str]:
    assumed = assumed_values(plan)
    if not assumed:
        return []
    lead = "<p>Nobody gave or measured these values. Whatever depends on them is only as good as they are.</p>"
    return [heading("Assumed values"), lead, bullets(assumed)]


def _figures(plan: Plan, times: Sequence[float] | None, done: Callable[[int], None]) -> list[str]:
    shown = ", ".join(f"{plan.time[step]:.2f}" for step in steps_at(plan, times))
    made = [
        picture(
            "image/png",
            png(instants(plan, times)),
            "The arm on its way in",
            f"At {shown} s, from the side and, in the corner, from the front. The line is the path, the "
            "numbered dots are the way-points, and the red dot is the tip. Links alternate in tone; obstacles "
            "are transparent.",
        )
    ]
    done(1)
    for make, title, text in _CAPTIONS:
        if make is clearance_map:
            made.append(picture("image/png", png(clearance_map(plan), 200), title, clearance_words(plan)))
        else:
            made.append(picture("image/svg+xml", svg(make(plan)), title, text))
        done(len(made))
    return made


def clearance_words(plan: Plan) -> str:
    """Return what is to be known of the map of clearances."""
    below = int(np.sum((clearance_left(plan) < plan.task.margin).any(axis=1)))
    margin = f"{plan.task.margin * 1e3:g} mm"
    tolerant = "" if plan.task.budget is None else ", tolerances taken off"
    verdict = f"No link comes closer than the margin of {margin}{tolerant}."
    if below:
        verdict = (
            f"At {below} of {len(plan.time)} steps a link is closer than the margin of {margin}{tolerant} (outlined)."
        )
    ringed = has_closest(plan)
    if tolerant:
        verdict += f" Colours {'and the ring ' if ringed else ''}are of distances as planned."
    ring = " The ring marks the smallest value." if ringed else ""
    return (
        f"Distance from the surface of each link to the nearest obstacle. {verdict}{ring} "
        f"Grey is {plan.horizon * 1e3:g} mm or more; larger distances are not measured."
    )


_MECHANICS = (
    "Tension of every cable, coloured by the section at which it ends; the load factor, by which tensions and weight "
    "could grow until the arm buckles; and how far the tip would be off. Dashed lines are limits."
)

_CAPTIONS = (
    (clearance_map, "Clearance of every link over time", ""),
    (
        joint_angles,
        "Joint angles",
        "The two bend angles of each section; dashed lines are the bend limits. Each bend of the path passes through "
        "the sections in turn, from the tip to the base.",
    ),
    (
        cable_lengths,
        "Cables",
        "Change of length of each cable from the straight pose, and its speed, coloured by the section at which the "
        "cable ends. Negative values are pulled in, positive ones are paid out.",
    ),
    (
        body_deviation,
        "Body and path",
        "The largest distance from the path of points along each link; dashed, the largest of all links. A "
        "rigid link is a chord, so in bends its middle is off the path even if both its joints are on it.",
    ),
    (
        tip_error,
        "Tip error",
        "Distance of the tip, by forward kinematics from the joint angles, from where it should be. The "
        "scale is logarithmic; values at the lower edge are rounding errors.",
    ),
)
