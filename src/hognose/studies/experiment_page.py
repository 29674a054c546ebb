"""The whole experiment as one page: verdict, figures of both cases in and out, charts, and what the tip camera saw."""

from __future__ import annotations

from html import escape
from pathlib import Path

from hognose.report.figures import instants
from hognose.report.page import bullets, heading, page, picture, table
from hognose.report.style import png, svg
from hognose.studies.experiment import small_png
from hognose.studies.experiment_charts import along_the_path, reached, tensions, tip_camera
from hognose.studies.pictures import instants_of
from hognose.studies.way_figures import TIP_RMS, figures
from hognose.studies.whole_experiment import CALIBRATION, RESULTS, TABLE, Case, Experiment
from hognose.version import __version__
from hognose.write_whole import write_whole

#: Name of the page.
PAGE = "experiment.html"


def write_page(experiment: Experiment, drawn: dict[str, list[str]] | None = None) -> Path:
    """Write the page of what is done into the experiment's folder; the file.

    Parameters
    ----------
    experiment
    drawn
        The parts of cases, by name, that are drawn already; others are added.

    Raises
    ------
    InputError
        It cannot be written.
    """
    parts = [*_title(experiment), *_done(experiment), heading("What came of it"), *_figures(experiment)]
    drawn = {} if drawn is None else drawn
    for case in experiment.cases:
        if case.name not in drawn:
            drawn[case.name] = _case(case)
        parts += drawn[case.name]
    lead = "<p>Nobody gave or measured these values. Whatever depends on them is only as good as they are.</p>"
    parts += [heading("Assumed values"), lead, bullets(experiment.assumed)]
    parts.append(f"<footer>Made by Hognose {escape(__version__)} in {experiment.seconds:.0f} s.</footer>")
    file = experiment.folder / PAGE
    write_whole(file, page("The whole experiment", parts).encode())
    return file


def _title(experiment: Experiment) -> list[str]:
    _, why = experiment.verdict.split(": ", 1)
    mark, word = ("good", "Good") if experiment.good else ("bad", "Not good" if experiment.troubles else "Not complete")
    robot = experiment.cases[0].nominal.robot.name if experiment.cases else ""
    return [
        "<h1>The whole experiment</h1>",
        f'<p class="sub">Section 5 of the paper with the arm {escape(robot)}: emulated drives and slider move a twin '
        "whose zeros and stiffness are hidden</p>",
        f'<p class="verdict {mark}" role="status"><strong>{word}.</strong>{escape(why[:1].upper() + why[1:])}.</p>',
    ]


def _done(experiment: Experiment) -> list[str]:
    """What was done, step by step."""
    arm = experiment.arm
    if arm is None or not experiment.cases:
        return []
    told, first = arm.to_json(), experiment.cases[0].ran
    hidden, drives = arm.hidden, first.network
    steps = [
        f"Hidden: cable zeros of {1e3 * hidden.zeros.min():+.2f} to {1e3 * hidden.zeros.max():+.2f} mm, and EA of each "
        f"section {hidden.stiffness.min():.2f} to {hidden.stiffness.max():.2f} times what the robot file says "
        f"(seed {experiment.seed}).",
        f"Calibrated: the twin was clamped in a jig and read at {told['readings']} levels of tension. Zeros were found "
        f"within {1e3 * told['largest_zero_error_m']:.3f} mm and stiffness within "
        f"{100 * told['largest_stiffness_error']:.2f} %.",
        "Planned: with the stiffness that was found. The zeros that were found are added to the counts of the drives.",
        f"Run: {len(drives.nodes)} emulated drives, one for each cable and the slider's, on a bus of "
        f"{drives.spec.bus.bitrate / 1e6:g} Mbit/s; set-points every {1e3 * _cycle_of(experiment.cases[0]):g} ms. "
        "The motors moved the twin: cables that only pull, weight and contact.",
        "Recorded: every cycle, every event, and a picture of the tip camera every second.",
    ]
    return [heading("What was done"), bullets(steps)]


def _cycle_of(case: Case) -> float:
    plan = case.ran.plan
    return float(plan.task.spec.motion.period_s) / case.ran.network.cycles_of(plan)


def figure_rows(experiment: Experiment) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The headings and the rows of a table of all figures: a column a way, and what they must be."""
    ways = [(case, way, figures(case.ran, way)) for case in experiment.cases for way in case.ran.ways]
    rows = []
    for each in zip(*(found for _, _, found in ways), strict=True):
        shown = (figure.shown + ("" if figure.is_met else " ✗") for figure in each)
        rows.append((each[0].words, *shown, each[0].bound))
    proven = [case.ran.plan.certified_clearance for case, _, _ in ways]
    before = [f"{1e3 * (case.before**2).mean() ** 0.5:.2f} mm" for case, _, _ in ways]
    rows += [
        ("clearance, certified for the plan", *("none" if x is None else f"{1e3 * x:.2f} mm" for x in proven), ""),
        ("load of the bus", *(f"{100 * case.ran.network.load:.0f} %" for case, _, _ in ways), ""),
        ("tip, RMS, had it not been calibrated", *before, ""),
    ]
    return ("", *(f"{case.nominal.name}, {way.name}" for case, way, _ in ways), "must be"), rows


def _figures(experiment: Experiment) -> list[str]:
    """The table of all figures, with what is to be known of it."""
    if not any(case.ran.ways for case in experiment.cases):
        return ["<p>Nothing was run.</p>"]
    head, rows = figure_rows(experiment)
    notes = (
        "<p>The tip is compared with the plan at the end of every cycle, while it moves. Time is simulated, so that no "
        "cycle is late. What the tip would be off without a calibration is computed by statics: such an arm is not "
        "moved, as its tensions are out of their band.</p>"
    )
    files = ", ".join(_link(name) for name in (RESULTS, TABLE, CALIBRATION))
    return [table(head, rows, numbers=range(1, len(head))), notes, f"<p>The same as files: {files}.</p>"]


def _case(case: Case) -> list[str]:
    """Pictures and charts of a case, and its files."""
    ran, parts = case.ran, [heading(case.nominal.name.capitalize())]
    files = [case.plan_file.name, ran.record.path.name, *(f"{case.name}-{way.name}.csv" for way in ran.ways)]
    words = ("plan", "record of both ways", *(f"cycles, {way.name}" for way in ran.ways))
    links = " · ".join(f"{text}: {_link(name)}" for text, name in zip(words, files, strict=True))
    parts.append(f"<p>{links}</p>")
    if not ran.ways:
        return [*parts, f"<p>{escape(ran.trouble)}</p>"]
    motion = reached(ran.plan, ran.ways[0])
    at = instants_of(motion)
    parts.append(
        picture("image/png", small_png(instants(motion, at)), "The arm on its way in",
                "As the twin reached it, from the side and, in the corner, from the front. The line is the path.")
    )  # fmt: skip
    if any(way.images for way in ran.ways):
        parts.append(
            picture("image/png", png(tip_camera(ran, at)), "What the tip camera saw",
                    "Pictures of the record. Below, on the way out, those closest to the same places. Where nothing "
                    "is in front of the arm, they are dark.")
        )  # fmt: skip
    text = (
        f"How far the tip was from where the plan has it, whose root mean square must be {1e3 * TIP_RMS:g} mm at most, "
        "and the clearance of the link that is closest to an obstacle."
    )
    parts.append(picture("image/svg+xml", svg(along_the_path(ran, TIP_RMS)), "Along the path", text))
    text = "As drives measured them, in and out again, coloured by the section at which the cable ends."
    parts.append(picture("image/png", small_png(tensions(ran)), "Tensions", text))
    return parts


def _link(name: str) -> str:
    return f'<a href="{escape(name, quote=True)}">{escape(name)}</a>'
