"""The whole experiment as a page: what was reached, in and back, and what was seen on the way."""

from __future__ import annotations

import io
from collections.abc import Sequence
from html import escape

import numpy as np
from matplotlib.figure import Figure

from hognose.planning.assumed import assumed_values
from hognose.report.page import bullets, heading, page, picture, table
from hognose.report.style import BAD, INK, LINKS, PATH, SMALL, dress, new_figure, png, section_colours
from hognose.studies.whole_experiment import TIP_RMS, Experiment, Leg, verdict
from hognose.version import __version__

_COLUMNS = ("way", "steps", "tip off its plan, RMS (mm)", "largest (mm)", "must be (mm)", "verdict")
#: So many pictures of the tip camera are shown of each case, in so many columns.
_SHOWN, _ACROSS = 8, 4


def experiment_page(cases: Sequence[Experiment]) -> str:
    """The page, which needs nothing but itself."""
    said = verdict(cases)
    kind = "good" if said.startswith("GOOD") else "bad"
    parts = [
        "<h1>The experiment, without its hardware</h1>",
        f'<p class="sub">{escape(" and ".join(case.plan.task.name for case in cases))}: in and back, on emulated '
        "drives that move a twin</p>",
        f'<p class="verdict {kind}">{escape(said)}</p>',
        bullets(_steps(cases)),
    ]
    for case in cases:
        parts += _case(case)
    parts += [heading("Assumed"), bullets(_assumed(cases[0])), f"<footer>Hognose {__version__}</footer>"]
    return page("The experiment", parts)


def _steps(cases: Sequence[Experiment]) -> list[str]:
    one = cases[0]
    return [
        "Each arm has zeros and stiffness of its cables that nobody knows; it is calibrated in its jig.",
        "It is planned with the stiffness that was found, and its drives are commanded with the zeros that were found.",
        f"{len(one.network.nodes)} emulated drives get the set-points over CANopen, {100 * one.network.load:.0f} % of "
        "the bus, and move the twin. What they say, what it touches and what its camera sees comes back.",
        "All of it is in the record, from which the figures below are read again.",
    ]


def _case(case: Experiment) -> list[str]:
    name, found = case.plan.task.name, case.summary
    return [
        heading(name),
        table(_COLUMNS, [_row(leg) for leg in case.legs], numbers=(2, 3, 4)),
        "<p>From the record, and what it cannot know:</p>",
        table(("figure", "value", "where"), [*_figures(case), *found.rows]),
        f"<p>{escape(found.compared.words)}</p>",
        picture("image/png", png(_chart(case)), f"{name}: tip and tensions",
                "Above: how far the tip of the twin was off its plan, in and back. Below: what every cable pulled, by "
                "its drive, from the base (dark) to the tip."),
        picture("image/jpeg", _contact_sheet(case), f"{name}: what the tip camera saw",
                f"{_SHOWN} of the {len(case.record.images)} pictures in the record, in their order, in and back."),
        "<p>" + ", ".join(
            f'<a href="{escape(file)}">{escape(file)}</a>'
            for file in (f"{case.name}.parquet", f"{case.name}.mcap", f"{case.name}-calibration.json")
        ) + "</p>",
    ]  # fmt: skip


def _row(leg: Leg) -> tuple[str, ...]:
    return (
        leg.name,
        f"{leg.start:g} to {leg.end:g}",
        f"{1e3 * leg.rms:.4f}",
        f"{1e3 * leg.off.max():.3f}",
        f"{1e3 * TIP_RMS:g}",
        "passed" if leg.good else "failed",
    )


def _figures(case: Experiment) -> list[tuple[str, str, str]]:
    """What the record does not know."""
    hidden, left = np.abs(case.hidden.zeros).max(), case.zero_error
    return [
        ("smallest clearance as planned", f"{1e3 * case.plan.clearance.min():.2f} mm", ""),
        ("largest hidden zero of a cable", f"{1e3 * hidden:.2f} mm", f"{1e3 * left:.3f} mm left when calibrated"),
        ("hidden stiffness of sections", f"{case.hidden.stiffness.min():.2f} to {case.hidden.stiffness.max():.2f}",
         "times what the robot file says"),
    ]  # fmt: skip


def _chart(case: Experiment) -> Figure:
    figure, period = new_figure(7.2, 5.2), case.network.cycles_of(case.plan)
    top = dress(figure.add_axes((0.09, 0.57, 0.88, 0.35)), "Step", "Tip off (mm)")
    low = dress(figure.add_axes((0.09, 0.09, 0.88, 0.35)), "Time (s)", "Tension (N)")
    for leg, colour in zip(case.legs, (PATH, LINKS[0]), strict=False):
        top.plot(leg.places, 1e3 * leg.off, color=colour, linewidth=1.0, label=leg.name)
    top.axhline(1e3 * TIP_RMS, color=BAD, linewidth=0.8, linestyle=":", label="root mean square must be below")
    top.set_ylim(bottom=0.0)
    top.set_title(f"Tip of the twin, {period} set-points a step", fontsize=9, color=INK, loc="left")
    top.legend(fontsize=SMALL, frameon=False, ncols=3)
    cycles = case.record.cycles
    for cable, colour in enumerate(section_colours(cycles.tensions.shape[1])):
        low.plot(cycles.time, cycles.tensions[:, cable], color=colour, linewidth=0.6)
    low.set_title("Tension of every cable, as its drive says", fontsize=9, color=INK, loc="left")
    return figure


def _contact_sheet(case: Experiment) -> bytes:
    """Some pictures of the tip camera, side by side, as one JPEG."""
    from PIL import Image

    images = case.record.images
    chosen = [images[k] for k in np.linspace(0, len(images) - 1, min(_SHOWN, len(images))).round().astype(int)]
    opened = [Image.open(io.BytesIO(each.jpeg)) for each in chosen]
    width, height = opened[0].size
    gap, rows = 4, -(-len(opened) // _ACROSS)
    sheet = Image.new("RGB", (_ACROSS * (width + gap) - gap, rows * (height + gap) - gap), "white")
    for k, each in enumerate(opened):
        sheet.paste(each, (k % _ACROSS * (width + gap), k // _ACROSS * (height + gap)))
    out = io.BytesIO()
    sheet.save(out, "JPEG", quality=85)
    return out.getvalue()


def _assumed(case: Experiment) -> list[str]:
    return [
        *assumed_values(case.plan),
        *case.network.spec.assumed,
        "time constant of emulated motors, 2 ms",
        "contact and damping of the twin",
    ]
