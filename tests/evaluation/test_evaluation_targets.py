"""Verdicts from rows made by hand: reached, MISSED, and not measured; and the tables beside the paper's."""

import pytest
from evaluation_makers import results, row

from hognose.evaluation.subjects import subjects_of
from hognose.evaluation.summary import (
    coverage,
    errors_beside_paper,
    failures,
    number,
    origin,
    percent,
    shapes_beside_published,
    spacings_like,
    targets_table,
    times_beside_paper,
    weakness,
)
from hognose.evaluation.targets import Target, targets_of


def everything(**changes):
    """Rows and races that reach all targets, and those changed."""
    given = {
        "prediction_rmse": 0.2,
        "interpolation_rmse": 0.01,
        "tip": 1e-10,
        "sound": True,
        "body": 1.2,
        "optimization": 500.0,
        "bisection": 3.0,
        "iterative": 2.0,
        "balanced": 1.5,
        "deviation": 5.0,
        "section_tip": 1e-9,
        "fitted": True,
        **changes,
    }
    rows = [
        row("prediction", tip_rmse_mm=given["prediction_rmse"], tip_variance_mm2=0.02),
        row("interpolation", tip_rmse_mm=given["interpolation_rmse"], tip_variance_mm2=0.002),
        row("exact", tip_max_mm=given["tip"], body_max_mm=2.4),
        row("exact", case="obstacle-array", tip_max_mm=1e-12, body_max_mm=4.0),
        row("exact", family="tight", case="arc", tip_max_mm=1e-12, valid=given["sound"]),
        row("balanced", body_max_mm=given["body"]),
        row("balanced", case="obstacle-array", body_max_mm=2.0),
        row("fitted", "shapes", "S 1", body_in_mm=given["deviation"], tip_max_mm=given["section_tip"], arm_m=1.0),
        row("fitted", "shapes", "C 1", body_in_mm=3.0, tip_max_mm=1e-9, arm_m=1.0, valid=given["fitted"]),
        row("exact", "arcs", "a", tip_max_mm=1e-9, valid=False),
    ]
    race = {"prediction": 0.4, "exact": 1.0, "balanced": given["balanced"]}
    race |= {f"{name} (published)": given[name] for name in ("optimization", "bisection", "iterative")}
    return results(rows, {"pipe-tank": race, "obstacle-array": {"exact": 1.0, "balanced": 2.0}})


def verdicts(found):
    return {target.name: target.verdict for target in targets_of(found)}


def test_all_targets_can_be_reached():
    found = targets_of(everything())
    assert [target.verdict for target in found] == ["reached"] * 14
    values = {target.name: target.value for target in found}
    assert values["optimization as published / prediction, time"] == pytest.approx(1250)
    assert values["bisection as published / prediction, time"] == pytest.approx(7.5)
    assert values["interpolation lowers the tip's RMSE by"] == pytest.approx(95)
    assert values["interpolation lowers the tip's variance by"] == pytest.approx(90)
    assert values["exact: largest tip error, all families"] == pytest.approx(1e-13)
    assert values["balanced / exact: largest body deviation, pipe-tank"] == pytest.approx(0.5)
    assert values["balanced / exact: time, obstacle-array"] == pytest.approx(2.0)
    assert values["fitted, wholly in: mean deviation, S, C and robot shapes"] == pytest.approx(0.4)
    assert values["other sections: largest tip error, all families"] == pytest.approx(1e-12)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"optimization": 399.0}, "optimization as published / prediction, time"),
        ({"bisection": 1.9}, "bisection as published / prediction, time"),
        ({"iterative": 1.5}, "iterative as published / prediction, time"),
        ({"interpolation_rmse": 0.105}, "interpolation lowers the tip's RMSE by"),
        ({"tip": 2e-6}, "exact: largest tip error, all families"),
        ({"sound": False}, "exact: solved and valid, all families"),
        ({"body": 1.5}, "balanced / exact: largest body deviation, pipe-tank"),
        ({"balanced": 20.5}, "balanced / exact: time, pipe-tank"),
        ({"deviation": 36.0}, "fitted, wholly in: mean deviation, S, C and robot shapes"),
        ({"section_tip": 2e-6}, "other sections: largest tip error, all families"),
        ({"fitted": False}, "fitted: solved and valid, other sections"),
    ],
)
def test_a_target_that_is_missed_says_so_and_no_other(change, name):
    found = verdicts(everything(**change))
    assert {target for target, verdict in found.items() if verdict == "MISSED"} == {name}


def test_what_was_not_measured_is_neither_reached_nor_missed():
    assert set(verdicts(results([])).values()) == {"not measured"}
    found = verdicts(results([row("exact", tip_max_mm=1e-12, body_max_mm=2.0)]))
    assert found.pop("exact: largest tip error, all families") == "reached"
    assert found.pop("exact: solved and valid, all families") == "reached"
    assert set(found.values()) == {"not measured"}


def test_a_method_that_never_came_to_an_answer_does_not_count_as_exact():
    found = verdicts(results([row("exact", solved=False, valid=False)]))
    assert found["exact: solved and valid, all families"] == "MISSED"
    assert found["exact: largest tip error, all families"] == "not measured"


def test_limits_themselves_reach():
    assert Target("a", 5.0, 5.0, "×", at_least=True).verdict == "reached"
    assert Target("a", 5.0, 5.0, "×").verdict == "reached"
    assert Target("a", 4.999, 5.0, "×", at_least=True).verdict == "MISSED"
    assert Target("a", 5.001, 5.0, "×").verdict == "MISSED"


def test_the_table_of_targets_shows_each_verdict():
    table = targets_table(
        [Target("a", 4.0, 5.0, "×", True), Target("b", None, 1.0, "mm"), Target("c", 99.99995, 72, "%")]
    )
    assert table.rows == (
        ("a", "4 ×", "≥ 5 ×", "MISSED"),
        ("b", "– mm", "≤ 1 mm", "not measured"),
        ("c", "99.9999 %", "≤ 72 %", "MISSED"),
    )


def test_tables_beside_the_papers_hold_both_and_their_ratios():
    times = {line[0]: line[1:] for line in times_beside_paper(everything()).rows}
    assert times["optimization"] == ("390", "1,219", "500", "1,250", "–", "–")
    assert times["iterative"] == ("1.29", "4.03", "2", "5", "–", "–")
    assert times["prediction"] == ("0.32", "1", "0.4", "1", "0.4", "1")
    errors = errors_beside_paper(everything()).rows
    assert errors[0] == ("RMSE (mm)", "0.4674", "0.2429", "48 %", "0.2", "0.01", "95 %")
    assert errors[1][-3:] == ("0.02", "0.002", "90 %")


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0"), (0.12345, "0.123"), (123.4, "123"), (1234.5, "1,234"), (3e-9, "3e-09"), (999.9, "1,000")],
)
def test_numbers_are_short(value, text):
    assert number(value) == text


def test_deviations_of_shapes_stand_beside_the_published_ones():
    rows = [
        row("aim", "shapes", "S 1", body_in_mm=4.0, body_mean_mm=2.0, tip_max_mm=1e-9, arm_m=1.0),
        row("aim", "shapes", "S 2", body_in_mm=6.0, body_mean_mm=3.0, tip_max_mm=2e-9, arm_m=1.0, valid=False),
        row("aim", "shapes", "C 1", solved=False, valid=False),
    ]
    assert shapes_beside_published(results(rows)).rows == (
        ("aim", "S", "1/2", "0.5", "0.25", "2e-09"),
        ("aim", "C", "0/1", "–", "–", "–"),
        ("aim", "robot", "0/0", "–", "–", "–"),
        ("published", "S, C, robot", "–", "1.9", "–", "0"),
    )
    assert shapes_beside_published(results([row("exact")])).rows == ()


def test_only_all_of_it_is_100_per_cent():
    assert percent(100.0) == "100"
    assert percent(99.99999) == "99.9999"
    assert percent(None) == "–"


def test_failures_are_grouped_by_method_and_reason_with_the_largest_figure():
    away = "a joint is {} mm from where it belongs, more than 45.5 mm"
    rows = [
        row("exact"),
        row("fabrik", "tight", "arc", valid=False, why=away.format(120)),
        row("fabrik", "tight", "wave", valid=False, why=away.format("1.2e+03")),
        row("fabrik", "helix", "a", valid=False, why="a link is off by 3 mm, more than 1 mm; " + away.format(60)),
        row("fabrik", "helix", "b"),
        row(
            "ccd", "helix", "a", solved=False, valid=False, why="step 3: ccd left the tip 5.1 mm from its goal {on it}"
        ),
        row("ccd", "helix", "b", solved=False, valid=False, why="something {else}"),
    ]
    assert failures(results(rows)).rows == (
        ("fabrik", "a joint is up to 1,200 mm from where it belongs", "tight; helix (a)"),
        ("fabrik", "a link is off by up to 3 mm", "helix (a)"),
        ("ccd", "the tip stays up to 5.1 mm from its goal", "helix (a)"),
        ("ccd", "something (else)", "helix (b)"),
    )
    table = coverage(results(rows))
    assert table.head == ("method", "cases", "tight", "helix")
    assert table.rows == (("exact", "1/1", "", ""), ("fabrik", "", "0/2 (2)", "1/2 (2)"), ("ccd", "", "", "0/2"))


def test_methods_say_what_they_are_and_where_they_are_weak():
    assert origin("iterative").startswith("Iterative search: ")
    assert origin("iterative (published)").startswith("Go point by point")
    for label in subjects_of():
        assert origin(label).endswith(".")
        assert label in ("exact",) or len(weakness(label)) > 20
    assert weakness("fabrik").startswith("only the tip is on the path")


def test_the_spacing_at_which_our_error_is_the_papers_is_bracketed():
    errors = {0.1: 0.03, 0.5: 0.2, 0.6: 0.6, 1.0: 0.1}
    rows = [row("prediction", "spacing", f"{sd}", spacing_mm=sd, tip_rmse_mm=error) for sd, error in errors.items()]
    assert [found.spacing_mm for found in spacings_like(results(rows), 0.4674)] == [0.5, 0.6]
    assert spacings_like(results(rows), 3.0) == []
    assert spacings_like(results(rows), 0.01) == []
