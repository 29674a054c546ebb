"""What must be reached, and whether it was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hognose.evaluation.measure import Row
from hognose.evaluation.section_families import MAKERS
from hognose.evaluation.subjects import as_published
from hognose.evaluation.suite import Results

#: The paper's table 2, ms a step, and table 3, mm and mm², without and with interpolation.
PAPER_MS = {"optimization": 390.0, "bisection": 6.0, "iterative": 1.29, "prediction": 0.32}
#: And by how many per cent the paper says that interpolation lowers them.
PAPER_LESS = (48.0, 72.0)
PAPER_RMSE, PAPER_VARIANCE = (0.4674, 0.2429), (0.0394, 0.0107)
CASES = ("obstacle-array", "pipe-tank")
#: What is published of following S, C and robot shapes with a continuum arm whose base moves freely, in six degrees of
#: freedom [sb-ftl 2026, abstract]: the average deviation of the shape in % of length, and the tip's error in m. The
#: shapes are not published.
PUBLISHED_DEVIATION, PUBLISHED_TIP = 1.9, 0.0
#: What counts as no tip error, m: rounding.
NO_ERROR = 1e-9


@dataclass(frozen=True)
class Target:
    """A figure beside what it must reach; `value` is None where it was not measured."""

    name: str
    value: float | None
    limit: float
    unit: str
    at_least: bool = False

    @property
    def verdict(self) -> str:
        """Reached, MISSED or not measured."""
        if self.value is None:
            return "not measured"
        return "reached" if (self.value >= self.limit if self.at_least else self.value <= self.limit) else "MISSED"


def targets_of(results: Results) -> list[Target]:
    """All targets; times are ratios taken in one race, errors at sd = 0.5 mm on the pipe tank."""
    found = [
        Target(
            f"{name} as published / prediction, time",
            ratio(results, as_published(name), "prediction"),
            limit,
            "×",
            True,
        )
        for name, limit in (("optimization", 1000.0), ("bisection", 5.0), ("iterative", 4.0))
    ]
    found += [
        Target("interpolation lowers the tip's RMSE by", lowered(results, "tip_rmse_mm"), PAPER_LESS[0], "%", True),
        Target(
            "interpolation lowers the tip's variance by", lowered(results, "tip_variance_mm2"), PAPER_LESS[1], "%", True
        ),
    ]
    exact = [row for row in results.rows if row.method == "exact" and row.family not in MAKERS]
    tips = [row.tip_max_mm for row in exact if row.tip_max_mm is not None]
    sound = 100.0 * sum(row.solved and row.valid for row in exact) / len(exact) if exact else None
    found += [
        Target("exact: largest tip error, all families", 1e-3 * max(tips) if tips else None, 1e-9, "m"),
        Target("exact: solved and valid, all families", sound, 100.0, "%", True),
    ]
    for case in CASES:
        balanced, plain = row_of(results, case, "balanced"), row_of(results, case, "exact")
        body = None
        if balanced and plain and balanced.body_max_mm is not None and plain.body_max_mm:
            body = balanced.body_max_mm / plain.body_max_mm
        found += [
            Target(f"balanced / exact: largest body deviation, {case}", body, 0.6, "×"),
            Target(f"balanced / exact: time, {case}", ratio(results, "balanced", "exact", case), 20.0, "×"),
        ]
    return found + _of_sections(results)


def _of_sections(results: Results) -> list[Target]:
    """Targets of arms with sections of other kinds than links; the published figures are of other shapes."""
    fitted = [row for family in MAKERS for row in results.of(family, "fitted")]
    tips = [row.tip_max_mm for family in MAKERS for row in results.of(family) if row.tip_max_mm is not None]
    sound = 100.0 * sum(row.solved and row.valid for row in fitted) / len(fitted) if fitted else None
    deviation = mean_deviation(results.of("shapes", "fitted"))
    return [
        Target("fitted, wholly in: mean deviation, S, C and robot shapes", deviation, PUBLISHED_DEVIATION, "%"),
        Target("other sections: largest tip error, all families", 1e-3 * max(tips) if tips else None, NO_ERROR, "m"),
        Target("fitted: solved and valid, other sections", sound, 100.0, "%", True),
    ]


def mean_deviation(rows: Sequence[Row], wholly_in: bool = True) -> float | None:
    """Mean over rows of the body's mean deviation, in % of the arm's length, at the last step or of all; or None."""
    means = [(row.body_in_mm if wholly_in else row.body_mean_mm, row.arm_m) for row in rows]
    parts = [0.1 * mean / arm for mean, arm in means if mean is not None]
    return sum(parts) / len(parts) if parts else None


def row_of(results: Results, case: str, method: str) -> Row | None:
    """The row of a method on a bundled case."""
    return next(iter(results.of("cases", method, case)), None)


def ratio(results: Results, slow: str, fast: str, case: str = "pipe-tank") -> float | None:
    """Time of one method over that of another in the race on a case."""
    above, below = results.raced(case, slow), results.raced(case, fast)
    return above / below if above is not None and below else None


def lowered(results: Results, figure: str) -> float | None:
    """By how many per cent interpolation lowers a figure of prediction on the pipe tank."""
    plain, better = row_of(results, "pipe-tank", "prediction"), row_of(results, "pipe-tank", "interpolation")
    if plain is None or better is None:
        return None
    before, after = getattr(plain, figure), getattr(better, figure)
    return 100.0 * (1.0 - after / before) if before and after is not None else None
