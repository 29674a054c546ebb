"""The figures hold what the rows say."""

import numpy as np
import pytest
from evaluation_makers import results, row
from matplotlib.axes import Axes

from hognose.evaluation import figures
from hognose.evaluation.content import PICTURES

UP = tuple(float(value) for value in np.linspace(1.0, 2.0, 30))
DOWN = tuple(float(value) for value in np.linspace(0.9, 0.3, 20))


def lines(axes: Axes):
    """What is drawn, by its name."""
    return {
        str(line.get_label()): (np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist())
        for line in axes.get_lines()
    }


@pytest.mark.parametrize("name", list(PICTURES))
def test_without_rows_there_is_no_figure(name):
    assert PICTURES[name].make(results([])) is None


def test_times_along_a_motion_begin_at_the_step_that_was_followed_first():
    rows = [
        row("exact", time_series_us=UP, steps=30, all_steps=30),
        row("ccd", time_series_us=DOWN, steps=20, all_steps=30),
        row("ccd", case="obstacle-array", time_series_us=UP, steps=30, all_steps=30),
    ]
    figure = figures.time_along(results(rows))
    assert figure is not None
    assert lines(figure.axes[0]) == {
        "exact": (list(range(30)), list(UP)),
        "ccd": (list(range(10, 30)), list(DOWN)),
    }
    assert figure.axes[0].get_yscale() == "log"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["exact", "ccd"]


def test_tip_errors_along_a_motion_are_those_of_the_two_methods():
    rows = [
        row(method, tip_series_mm=UP, steps=30, all_steps=30) for method in ("exact", "prediction", "interpolation")
    ]
    figure = figures.tip_along(results(rows))
    assert figure is not None
    assert set(lines(figure.axes[0])) == {"prediction", "interpolation"}
    assert lines(figure.axes[0])["prediction"] == (list(range(30)), list(UP))


def test_body_deviations_stand_side_by_side_for_both_cases():
    rows = [
        row(method, case=case, body_series_mm=UP if method == "exact" else DOWN[:20] + UP[:10], steps=30, all_steps=30)
        for case in ("obstacle-array", "pipe-tank")
        for method in ("exact", "balanced")
    ]
    figure = figures.body_along(results(rows))
    assert figure is not None
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["obstacle-array", "pipe-tank"]
    for axes in figure.axes:
        assert lines(axes)["exact"][1] == list(UP)
        assert lines(axes)["balanced"][1] == list(DOWN[:20] + UP[:10])
        assert axes.get_ylim()[0] == 0.0


def test_time_against_links_is_sorted_and_leaves_out_what_failed():
    rows = [
        row("exact", "links", "b", links=100, time_us=3.0),
        row("exact", "links", "a", links=3, time_us=0.1),
        row("fabrik", "links", "a", links=3, time_us=5.0),
        row("fabrik", "links", "b", links=100, solved=False, valid=False),
    ]
    figure = figures.time_by_links(results(rows))
    assert figure is not None
    assert lines(figure.axes[0]) == {"exact": ([3, 100], [0.1, 3.0]), "fabrik": ([3], [5.0])}
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == ["3", "100"]


def test_tip_error_against_sd_shows_the_papers_two_figures():
    rows = [
        row(method, "spacing", f"{sd}", spacing_mm=sd, tip_rmse_mm=sd / 2)
        for method in ("exact", "prediction", "interpolation", "iterative", "iterative (published)")
        for sd in (0.05, 0.5, 3.5)
    ]
    figure = figures.tip_by_spacing(results(rows))
    assert figure is not None
    drawn = lines(figure.axes[0])
    assert drawn.pop("paper, without: 0.4674 mm")[1] == [0.4674, 0.4674]
    assert drawn.pop("paper, with: 0.2429 mm")[1] == [0.2429, 0.2429]
    assert drawn == dict.fromkeys(("prediction", "interpolation", "iterative"), ([0.05, 0.5, 3.5], [0.025, 0.25, 1.75]))


def test_the_map_counts_valid_and_solved():
    rows = [
        row("exact", "helix", "a"),
        row("exact", "helix", "b"),
        row("ccd", "helix", "a", valid=False),
        row("ccd", "helix", "b", valid=False, solved=False),
        row("ccd", "tight", "a"),
    ]
    figure = figures.valid_map(results(rows))
    assert figure is not None
    axes = figure.axes[0]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["helix", "tight"]
    assert [text.get_text() for text in axes.get_yticklabels()] == ["exact", "ccd"]
    assert {text.get_position(): text.get_text() for text in axes.texts} == {
        (0, 0): "2/2",
        (0, 1): "0/2 (1)",
        (1, 1): "1/1",
    }
    shades = np.ma.filled(np.ma.asarray(axes.get_images()[0].get_array(), dtype=float), np.nan)
    assert np.array_equal(shades, [[1.0, np.nan], [0.0, 1.0]], equal_nan=True)


def test_published_variants_keep_the_colour_and_differ_in_dashes():
    rows = [
        row("iterative", time_series_us=UP, steps=30, all_steps=30),
        row("iterative (published)", time_series_us=UP, steps=30, all_steps=30),
    ]
    figure = figures.time_along(results(rows))
    assert figure is not None
    tuned, published = figure.axes[0].get_lines()
    assert tuned.get_color() == published.get_color()
    assert tuned.get_linestyle() == "-"
    assert published.get_linestyle() == "--"


def test_methods_of_others_get_a_colour_of_their_own(monkeypatch):
    monkeypatch.setattr("hognose.evaluation.suite.subjects_of", lambda: ["exact", "mine", "yours"])
    rows = [row(label, time_series_us=UP, steps=30, all_steps=30) for label in ("exact", "mine", "yours")]
    figure = figures.time_along(results(rows))
    assert figure is not None
    assert len({line.get_color() for line in figure.axes[0].get_lines()}) == 3
