"""Figures build without a warning and say what the plan says."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from hognose.errors import InputError
from hognose.report.canvas import beside, numbered
from hognose.report.charts import cell_borders, least_clearance
from hognose.report.figures import (
    body_deviation,
    cable_lengths,
    clearance_map,
    instants,
    joint_angles,
    steps_at,
    tip_error,
)
from hognose.report.report import clearance_words
from hognose.report.style import png, svg

CHARTS = (clearance_map, joint_angles, cable_lengths, body_deviation, tip_error)


def lines(axes):
    return [np.asarray(line.get_ydata(), float) for line in axes.get_lines()]


@pytest.mark.parametrize("make", CHARTS)
def test_charts_become_png_and_svg(make, boards):
    figure = make(boards)
    assert png(figure).startswith(b"\x89PNG")
    assert b"<svg" in svg(figure)


@pytest.mark.parametrize("make", CHARTS)
def test_the_same_plan_gives_the_same_svg(make, tank):
    assert svg(make(tank)) == svg(make(tank))


@pytest.mark.parametrize("colour", ["links", "clearance"])
@pytest.mark.parametrize("case", ["boards", "tank"])
def test_instants_show_each_time_from_the_side_and_from_the_front(case, colour, request):
    plan = request.getfixturevalue(case)
    figure = instants(plan, [0, 1.5, 3.0, 4.5], colour=colour)
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert [text for text in texts if "t = " in text] == [
        f"({letter})  t = {time:.2f} s" for letter, time in zip("abcd", (0, 1.5, 3, 4.5), strict=True)
    ]
    assert texts.count("front") == 4
    assert any(text.endswith(" mm") for text in texts)
    assert {str(i + 1) for i in range(len(plan.way_points))} <= set(texts)
    assert png(figure, 60).startswith(b"\x89PNG")


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_any_number_of_instants_has_its_panels(count, tank):
    assert len(instants(tank, list(range(count))).axes) == 2 * count


def test_steps_are_the_nearest_to_the_times_and_evenly_spread_without_them(boards):
    assert steps_at(boards) == [0, 20, 40, 60]
    assert steps_at(boards, [0, 0.16, 8.99]) == [0, 1, 60]
    assert steps_at(replace(boards, time=boards.time[:1])) == [0]


@pytest.mark.parametrize("times", [[-1.0], [99.0], []])
def test_times_outside_the_plan_are_refused(times, boards):
    with pytest.raises(InputError, match="times"):
        instants(boards, times)


def test_an_unknown_colouring_is_refused(boards):
    with pytest.raises(InputError, match="'links' or 'clearance'"):
        instants(boards, colour="rainbow")


def test_the_clearance_map_names_the_smallest_value_and_its_place(boards):
    clearance = np.full_like(boards.clearance, boards.horizon)
    clearance[7, 4] = 0.0123
    axes = clearance_map(replace(boards, clearance=clearance)).axes[0]
    assert axes.get_title(loc="left") == f"Smallest clearance 12.30 mm, link 5, at {boards.time[7]:.2f} s"


def test_the_clearance_map_rings_nothing_where_nothing_is_measured(boards):
    far = replace(boards, clearance=np.full_like(boards.clearance, boards.horizon))
    near = replace(far, clearance=far.clearance - 1e-6)
    assert clearance_map(far).axes[0].get_title(loc="left") == "Smallest clearance ≥ 50 mm"
    rings = [len(clearance_map(plan).axes[0].lines) for plan in (near, far)]
    assert rings == [1, 0]
    assert "ring" not in clearance_words(far)
    assert "The ring marks" in clearance_words(near)


@pytest.mark.parametrize("fill", [-0.01, 0.0, 0.004, 0.05])
def test_the_clearance_map_draws_collisions_and_open_space(fill, boards):
    clearance = boards.clearance.copy()
    clearance[10:20, 3:5] = fill
    assert png(clearance_map(replace(boards, clearance=clearance)))
    assert png(clearance_map(replace(boards, clearance=np.full_like(clearance, fill))))


def test_clearance_at_the_horizon_is_a_lower_bound_in_words(boards):
    assert least_clearance(replace(boards, clearance=np.full_like(boards.clearance, 0.05))) == "≥ 50 mm"
    assert least_clearance(replace(boards, clearance=np.full_like(boards.clearance, 0.0125))) == "12.50 mm"


def test_cell_borders_lie_between_uneven_centres():
    np.testing.assert_allclose(cell_borders(np.array([0.0, 1.0, 3.0])), [-0.5, 0.5, 2.0, 4.0])
    np.testing.assert_allclose(cell_borders(np.array([2.0])), [1.5, 2.5])


def test_joint_angles_are_in_degrees_with_their_limits(boards):
    alpha, beta = joint_angles(boards).axes[:2]
    for axes, k in ((alpha, 0), (beta, 1)):
        drawn = lines(axes)
        np.testing.assert_allclose(drawn[:12], np.degrees(boards.angles[:, :, k]).T)
        assert sorted({float(line[0]) for line in drawn[12:]}) == pytest.approx([-28.6479, 28.6479], abs=1e-3)
        assert "(deg)" in axes.get_ylabel()


def test_cables_are_shown_as_change_in_millimetres_and_speed(boards):
    change, speed = cable_lengths(boards).axes[:2]
    expected = (boards.cable_lengths - boards.cable_lengths[0]).T * 1e3
    np.testing.assert_allclose(lines(change)[:36], expected, atol=1e-12)
    np.testing.assert_allclose(lines(speed)[:36], np.gradient(expected, 0.15, axis=1), atol=1e-9)


def test_the_bodys_deviation_is_shown_by_link_with_the_largest_of_all(boards):
    axes = body_deviation(boards).axes[0]
    drawn, expected = lines(axes), 1e3 * boards.body_deviation
    np.testing.assert_allclose(drawn[:-1], expected.T, atol=1e-12)
    np.testing.assert_allclose(drawn[-1], expected.max(axis=1), atol=1e-12)
    assert f"Largest {expected.max():.3g} mm" in axes.get_title(loc="left")


@pytest.mark.parametrize("error", [0.0, 1e-16, 1e-13, 2.4e-4, 1.0])
def test_the_tip_error_survives_zeros_and_rounding(error, boards):
    errors = np.where(np.arange(61) % 3 == 0, 0.0, error)
    axes = tip_error(replace(boards, tip_error=errors)).axes[0]
    low, high = axes.get_ylim()
    drawn = lines(axes)[0]
    assert (drawn > 0).all()
    assert low < drawn.min()
    assert drawn.max() < high
    if error >= 1e-13:
        np.testing.assert_allclose(drawn.max(), error * 1e3)


@pytest.mark.parametrize("make", [*CHARTS, instants])
def test_a_plan_of_a_single_step_is_drawn(make, boards):
    series = ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance", "tip_error")
    one = replace(boards, **{name: getattr(boards, name)[:1] for name in (*series, "body_deviation")})
    assert png(make(one), 40)


def test_a_picture_is_as_large_as_its_figure(boards):
    from io import BytesIO

    figure = tip_error(boards)
    assert Image.open(BytesIO(png(figure, 100))).size == (720, 250)


def test_importing_the_package_and_this_room_does_not_import_matplotlib():
    code = "import sys, hognose, hognose.report; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_drawing_does_not_import_pyplot():
    code = "import sys, hognose.report.report; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("way", "aside"),
    [((5.0, 0.0), (0, 1)), ((-5.0, 0.0), (0, 1)), ((0.0, 5.0), (1, 0)), ((3.0, 3.0), (0.5**0.5, 0.5**0.5))],
)
def test_numbers_stand_aside_from_the_way_and_rather_above_it(way, aside):
    pixels = np.array([[10.0, 20.0], [11.0, 19.0], np.add([10.0, 20.0], way)])
    np.testing.assert_allclose(beside(pixels), aside, atol=1e-12)
    np.testing.assert_allclose(beside(pixels[:1].repeat(2, axis=0)), (0, 1))


def test_numbers_that_would_lie_on_each_other_are_left_out():
    places = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 7.0], [40.0, 0.0], [44.0, 1.0], [48.0, 2.0]])
    assert numbered(places) == [1, 3, 4, 6]
    assert numbered(places[:1].repeat(2, axis=0)) == [2]
    apart = 10.0 * np.arange(12.0)[:, None] * [1, 0]
    assert numbered(apart) == list(range(1, 13))
    assert numbered(0.9 * apart) == [*range(1, 10), 12]  # numbers of two digits are wider
