"""What an evaluation says, block by block; `pages` renders it as HTML and as Markdown.

Every number in it comes from the results.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

from hognose.evaluation import figures
from hognose.evaluation.case import SPACING
from hognose.evaluation.differences import differences
from hognose.evaluation.families import statement
from hognose.evaluation.section_families import MAKERS
from hognose.evaluation.shapes import PUBLISHED_KINDS
from hognose.evaluation.subjects import PUBLISHED, method_of
from hognose.evaluation.suite import Results
from hognose.evaluation.summary import (
    Table,
    coverage,
    errors_beside_paper,
    failures,
    family_table,
    followed_in_part,
    origin,
    shapes_beside_published,
    targets_table,
    times_beside_paper,
    weakness,
)
from hognose.evaluation.targets import CASES, PUBLISHED_DEVIATION, targets_of


@dataclass(frozen=True)
class Heading:
    """A heading within the page."""

    text: str


@dataclass(frozen=True)
class Code:
    """A command."""

    text: str


@dataclass(frozen=True)
class Picture:
    """A figure, its file's name without suffix, and what it shows."""

    name: str
    title: str
    caption: str
    make: Callable[[Results], Figure | None]


Block = Heading | Code | Picture | Table | str | list[str]

PICTURES = {
    picture.name: picture
    for picture in (
        Picture(
            "time-steps",
            "Time of every step",
            "Pipe tank, logarithmic, as in figure 10(a) of the paper, but for all methods. A time is the best of "
            "several rounds, measured over blocks of at most 32 steps. It includes the call from Python, which is most "
            "of it for the fastest methods; the tables give the time without it. The first block includes the cold "
            "start.",
            figures.time_along,
        ),
        Picture(
            "tip-steps",
            "Tip error of every step",
            "Pipe tank, logarithmic, as in figure 10(b) of the paper: prediction lookup without and with "
            "interpolation.",
            figures.tip_along,
        ),
        Picture(
            "body-steps",
            "Body deviation of every step",
            "The largest distance of any point along the links from the path. With the joints on the path, all "
            "of the deviation is at the middle of the links; `balanced` shares it between joints and links.",
            figures.body_along,
        ),
        Picture(
            "time-links",
            "Time against the number of links",
            "One path and one length of the arm, divided into more and more links.",
            figures.time_by_links,
        ),
        Picture(
            "time-sd",
            "Time against the spacing of the points",
            "Stepping from point to point takes longer the closer the points are; jumps and predictions do not.",
            figures.time_by_spacing,
        ),
        Picture(
            "tip-sd",
            "Tip error against the spacing of the points",
            "The dashed lines are the two values in the paper, without and with interpolation. Iterative search takes "
            "the same points as prediction lookup, so their lines coincide. The lines are jagged because 91 mm "
            "is a whole multiple of some spacings, where straight links snap to points without error.",
            figures.tip_by_spacing,
        ),
        Picture(
            "valid",
            "Solved and valid",
            "Valid cases out of all cases of each family; in brackets the solved ones, if there are more.",
            figures.valid_map,
        ),
    )
}


def content(results: Results, command: str) -> list[Block]:
    """All blocks of the page; `command` makes it anew."""
    return [
        *_opening(results, command),
        *_paper(results),
        *_targets(results),
        *_families(results),
        *_cases(results),
        *_shapes(results),
        *_trends(),
        *_failures(results),
        *_all_figures(results),
    ]


def _opening(results: Results, command: str) -> list[Block]:
    machine = results.machine
    size = "the quick suite" if results.quick else "the full suite"
    return [
        f"All following methods of Hognose on the same paths, on the same machine, in one run: {size}, "
        f"{len(results.rows)} rows, seed {results.seed}, Hognose {results.version}. This page and its figures are "
        "written by the command below, never by hand. When it is run again, times vary, and with them the number of "
        "steps given to the slowest methods; everything else is the same.",
        Code(command),
        f"Machine: {machine['processor'] or 'processor unknown'} ({machine['architecture']}), one core; "
        f"Python {machine['python']}, numba {machine['numba']}.",
        Heading("The methods"),
        f"The methods {', '.join(PUBLISHED[:-1])} and {PUBLISHED[-1]} appear twice: as tuned here, and as described in "
        "their sources, marked “(published)”. All methods are compiled, and all are measured with the same code.",
        Table(("method", "what it is"), tuple((label, origin(label)) for label in results.methods)),
    ]


def _paper(results: Results) -> list[Block]:
    return [
        Heading("Comparison with the paper's tables"),
        f"Table 2 of the paper: time per step on the pipe tank, and the ratio to prediction lookup. Our methods are "
        f"timed in turn, best of several rounds, over whole motions, with points sd = {1e3 * SPACING:g} mm apart. The "
        "platforms differ, so only the ratios within the same columns can be compared.",
        times_beside_paper(results),
        f"Table 3 of the paper: the tip error on the pipe tank, prediction lookup without and with interpolation, "
        f"at sd = {1e3 * SPACING:g} mm. VVE is the variance of the error.",
        errors_beside_paper(results),
        PICTURES["time-steps"],
        PICTURES["tip-steps"],
        Heading("Differences from the paper, and consequences"),
        *differences(results),
        PICTURES["tip-sd"],
    ]


def _targets(results: Results) -> list[Block]:
    found = targets_of(results)
    missed = sum(target.verdict == "MISSED" for target in found)
    unknown = sum(target.verdict == "not measured" for target in found)
    words = f"{len(found) - missed - unknown} of {len(found)} targets are reached, {missed} missed"
    return [
        Heading("Targets"),
        words + (f", {unknown} not measured." if unknown else "."),
        targets_table(found),
    ]


def _families(results: Results) -> list[Block]:
    off_path = [
        label
        for label in results.methods
        if any(row.method == label and not row.on_path and row.family not in MAKERS for row in results.rows)
    ]
    known = tuple((family, statement(family)) for family in results.families)
    return [
        Heading("The families, and why they are solvable"),
        "A verdict on a method requires cases that have a solution. The table states why each family has one. In "
        "addition, every case is proven to be solvable before it is used. Its joints are found by a search that shares "
        "no code with the methods: from a joint it advances along the path by the missing distance, repeatedly. A "
        "chord is no longer than its arc, so this cannot pass the first point at a distance of one link. Then all "
        "bends must be within the limits at every feed.",
        Table(("family", "what it is, and why it is solvable"), known),
        "*Solved*: the method returned finite positions for every feed it was given. *Valid* is a verdict that does "
        "not come from the method, although it uses the tolerance that the method states:",
        [
            "every bend angle is within the limit of the joints, and every link has its length, to the tolerance that "
            "the method states (rounding for all but the methods that snap to points);",
            "for methods that keep to the path: every joint is on the first crossing, seen from the previous joint, to "
            "three times the tolerance;",
            f"for methods that do not ({', '.join(off_path)}): every joint is within half a link of where it belongs. "
            "On another crossing it would be farther away. The distance of the body from the path is the body "
            "deviation, which is not part of the verdict;",
            "for sections that are no rigid links: every end is where plain rotations put it for its angles, which are "
            "within the limits, and the tip is on the path; other ends are, too, or within half a section of it, as "
            "the method promises.",
        ],
        PICTURES["valid"],
        coverage(results),
    ]


def _cases(results: Results) -> list[Block]:
    blocks: list[Block] = [
        Heading("The two cases of the paper"),
        "Times are in µs per step: the mean over the whole motion in one call, and the median, 95th percentile and "
        "maximum over blocks of at most 32 steps, each including its call from Python. Distances are the number of "
        "distance evaluations per step, which does not depend on the machine. The tip error is computed by forward "
        "kinematics, the body deviation at points along the links; link is the largest error of a link length. "
        "Lengths are in mm.",
    ]
    for case in CASES:
        table = family_table(results, "cases", case)
        if table.rows:
            blocks += [f"**{case}**", table]
    return [*blocks, PICTURES["body-steps"]]


def _shapes(results: Results) -> list[Block]:
    table = shapes_beside_published(results)
    if not table.rows:
        return []
    drawn = len(results.of("shapes", table.rows[0][0])) // len(PUBLISHED_KINDS)
    return [
        Heading("Arms of few arcs beside published figures"),
        f"Published of following with a continuum arm, whose base moves in six degrees of freedom, is an average "
        f"deviation of the shape of {PUBLISHED_DEVIATION:g} % of the length and no tip error, over S, C and robot "
        f"shapes (sb-ftl 2026, abstract). Those shapes are not published: the {drawn} of each kind here are drawn from "
        "the words, so the sets differ, and the figures stand beside each other and no more. Here three arcs come from "
        "a slider, which can only push. Deviations are means along the body, wholly in and over all poses of the way "
        "in, of which the first are nearly straight.",
        table,
    ]


def _trends() -> list[Block]:
    return [Heading("What determines the time"), PICTURES["time-links"], PICTURES["time-sd"]]


def _failures(results: Results) -> list[Block]:
    found = failures(results)
    blocks: list[Block] = [Heading("Where methods fail")]
    if found.rows:
        weak = {method_of(row[0]): weakness(row[0]) for row in found.rows}
        blocks += ["The rows that are not valid, one line per method and reason, with the largest value.", found]
        blocks += [
            "Known weaknesses of these methods:",
            [f"{method}: {words}" for method, words in weak.items() if words],
        ]
    else:
        blocks += ["No method failed on any case of this suite."]
    partly = followed_in_part(results)
    if partly:
        blocks += [
            "Slow methods were run over the last steps of a motion only. Methods that continue from the previous "
            "posture start there with the arm laid along the path, and drift less than over a whole motion, so their "
            "verdict is more favourable.",
            partly,
        ]
    return blocks


def _all_figures(results: Results) -> list[Block]:
    blocks: list[Block] = [
        Heading("All values of all families"),
        "The largest value over the cases of each family. `results.csv` has one line per method and case.",
    ]
    for family in results.families:
        blocks += [f"**{family}**", family_table(results, family)]
    return blocks
