"""Where our figures differ from the paper's, in words whose numbers come from the results."""

from __future__ import annotations

from hognose.evaluation.families import SPACING
from hognose.evaluation.subjects import as_published
from hognose.evaluation.suite import Results
from hognose.evaluation.summary import number, spacings_like
from hognose.evaluation.targets import PAPER_LESS, PAPER_RMSE, row_of


def differences(results: Results) -> list[str]:
    """Paragraphs: what is not known of the paper's run, its error with interpolation, its platform."""
    return [*_spacing(results), *_interpolation(results), *_ratios(results), _platform()]


def _spacing(results: Results) -> list[str]:
    plain = row_of(results, "pipe-tank", "prediction")
    if plain is None or plain.tip_rmse_mm is None:
        return []
    text = (
        f"The paper gives neither sd, the distance of the points, nor where its way-points are. At sd = "
        f"{1e3 * SPACING:g} mm our tip RMSE without interpolation is {number(plain.tip_rmse_mm)} mm, the paper's is "
        f"{PAPER_RMSE[0]} mm."
    )
    near = spacings_like(results, PAPER_RMSE[0])
    if near:
        text += (
            f" Ours first passes the paper's between sd = {near[0].spacing_mm:g} and {near[1].spacing_mm:g} mm "
            f"({number(near[0].tip_rmse_mm)} and {number(near[1].tip_rmse_mm)} mm), so its points may have been about "
            "that far apart; the error is no smooth function of sd, so this is no more than a hint."
        )
    return [text]


def _interpolation(results: Results) -> list[str]:
    rows = [row for row in results.of("spacing", "interpolation") if row.tip_rmse_mm is not None]
    if not rows:
        return []
    worst = max(rows, key=lambda row: row.tip_rmse_mm or 0.0)
    times = PAPER_RMSE[1] / (worst.tip_rmse_mm or 1.0)
    text = (
        f"The paper's error with interpolation, {PAPER_RMSE[1]} mm, is larger than interpolation explains. Between "
        "points the path leaves the straight line by κ sd²/8 at most, and the sum of that over the links is all that "
        f"should be left. Of all sd from {min(row.spacing_mm for row in rows):g} to "
        f"{max(row.spacing_mm for row in rows):g} mm ours is largest at {worst.spacing_mm:g} mm, with "
        f"{number(worst.tip_rmse_mm)} mm: the paper's is {number(times)} times that."
    )
    if times > 1.0:
        text += (
            " So no sd in this range turns the paper's first figure into its second by this interpolation, and "
            "something else must be left in its error. It may be a base that stays on a point; or taking always the "
            "next point as neighbour, as the paper draws it, although the length often lies between the point found "
            "and the one before. "
            f"We do not know. Its {PAPER_LESS[0]:g} and {PAPER_LESS[1]:g} % are therefore figures to beat, not to hit."
        )
    return [text]


def _ratios(results: Results) -> list[str]:
    ours, slow = row_of(results, "pipe-tank", "prediction"), row_of(results, "pipe-tank", as_published("iterative"))
    if ours is None or slow is None:
        return []
    return [
        f"Our prediction lookup measures {number(ours.evaluations)} distances a step for {ours.links} links, because "
        "it looks at a neighbour only where that can be closer; the paper's looks at three places each time. Iterative "
        f"search as published measures {number(slow.evaluations)}. So our ratios to prediction lookup say as much "
        "about our prediction lookup as about the other method."
    ]


def _platform() -> str:
    return (
        "The paper measured on an i7-4790 and does not name its language; its times suggest code that is not compiled. "
        "Our times include no inverse resolution and no cable lengths, and whether the paper's do is not said. Hence "
        "ratios within each column, and nothing else, are compared. The published optimization had to be written from "
        "descriptions of it, because the text of reference 29 was not at hand."
    )
