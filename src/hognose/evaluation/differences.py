"""Differences between our figures and the paper's, as paragraphs whose numbers come from the results."""

from __future__ import annotations

from hognose.evaluation.case import SPACING
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
        f"The paper states neither sd, the spacing of the points, nor the positions of its way-points. At sd = "
        f"{1e3 * SPACING:g} mm our tip RMSE without interpolation is {number(plain.tip_rmse_mm)} mm; the paper's is "
        f"{PAPER_RMSE[0]} mm."
    )
    near = spacings_like(results, PAPER_RMSE[0])
    if near:
        text += (
            f" Ours first exceeds the paper's between sd = {near[0].spacing_mm:g} and {near[1].spacing_mm:g} mm "
            f"({number(near[0].tip_rmse_mm)} and {number(near[1].tip_rmse_mm)} mm), so its points may have been about "
            "that far apart. The error is not a smooth function of sd, so this is only an indication."
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
        "points the path leaves the straight line by at most κ sd²/8, and only the sum of this over the links should "
        f"remain. Of all sd from {min(row.spacing_mm for row in rows):g} to "
        f"{max(row.spacing_mm for row in rows):g} mm, ours is largest at {worst.spacing_mm:g} mm, with "
        f"{number(worst.tip_rmse_mm)} mm; the paper's is {number(times)} times as large."
    )
    if times > 1.0:
        text += (
            " So for no sd in this range does this interpolation give both figures of the paper, and its error must "
            "have another source. The base may have stayed on a point, or the next point may always have been taken "
            "as the neighbour, as in the paper's figure, although the length often lies between the point found and "
            "the previous one. "
            f"We do not know. The reductions by {PAPER_LESS[0]:g} and {PAPER_LESS[1]:g} % are therefore lower limits "
            "for ours, not values to reproduce."
        )
    return [text]


def _ratios(results: Results) -> list[str]:
    ours, slow = row_of(results, "pipe-tank", "prediction"), row_of(results, "pipe-tank", as_published("iterative"))
    if ours is None or slow is None:
        return []
    return [
        f"Our prediction lookup measures {number(ours.evaluations)} distances per step for {ours.links} links, because "
        "it tests a neighbour only where that can be closer; the paper's tests three points each time. Iterative "
        f"search as published measures {number(slow.evaluations)}. So our ratios to prediction lookup depend as much "
        "on our prediction lookup as on the other method."
    ]


def _platform() -> str:
    return (
        "The times of the paper were measured on an i7-4790. The programming language is not stated; the times suggest "
        "code that is not compiled. Our times include neither inverse resolution nor cable lengths; whether the "
        "paper's do is not stated. Therefore only ratios within a column are compared. The published optimization had "
        "to be reconstructed from descriptions, because the text of reference 29 was not available."
    )
