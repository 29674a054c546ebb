"""Rounding as people read it: what is proven is never shown as better than it is."""

from __future__ import annotations

import ast
import math
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import hognose
from hognose.planning import Check
from hognose.wording import at_least, at_least_mm, at_most, beside_limit, mm, point

numbers = st.floats(-1e12, 1e12)
anything = st.floats(allow_nan=False, allow_infinity=False)


def check(ok, value, limit, unit, **more):
    return Check("c", "c", ok, value, limit, unit, **more)


@given(value=numbers, places=st.integers(0, 6))
def test_a_lower_bound_is_rounded_down_and_an_upper_one_up_by_less_than_a_place(value, places):
    below, above = Fraction(at_least(value, places)), Fraction(at_most(value, places))
    exact, place = Fraction(repr(value)), Fraction(1, 10**places)
    assert exact - place < below <= exact <= above < exact + place


@given(value=numbers)
def test_lengths_are_said_in_mm(value):
    assert at_least_mm(value) == at_least(1e3 * value, 2)


@given(place=st.tuples(numbers, numbers, numbers), form=st.sampled_from([".1f", "g", ".0f"]))
def test_a_point_reads_as_its_coordinates_in_mm_and_never_as_minus_zero(place, form):
    inside, unit = point(place, form).removeprefix("(").split(") ")
    shown = inside.split(", ")
    assert unit == "mm"
    assert [float(text) for text in shown] == [float(format(1e3 * c, form)) for c in place]
    assert mm(place[0], form) == f"{shown[0]} mm"
    assert not any(float(text) == 0 and text.startswith("-") for text in shown)


def test_some_points():
    assert point((0.0, -0.0025, -1e-9)) == "(0.0, -2.5, 0.0) mm"
    assert point((1.0, 0.12345, -0.0), "g") == "(1000, 123.45, 0) mm"
    assert point((0.0105, 0.0115, 0.1), ".0f") == "(10, 12, 100) mm"
    assert (mm(0.00125), mm(-1e-9), mm(0.02, "g")) == ("1.25 mm", "0.00 mm", "20 mm")


def thousands(node):
    """Whether something is multiplied by 1000 in an expression, as lengths are to be shown in mm."""
    factors = (side for n in ast.walk(node) if isinstance(n, ast.BinOp) for side in (n.left, n.right))
    return any(isinstance(side, ast.Constant) and side.value == 1000 for side in factors)


def shows_a_point(node):
    """`", ".join(… 1e3 * c …)` or `x, y, z = (f"{1e3 * c:.1f}" …)`."""
    if isinstance(node, ast.Call):
        by = node.func.value if isinstance(node.func, ast.Attribute) and node.func.attr == "join" else None
        return isinstance(by, ast.Constant) and by.value == ", " and thousands(node)
    texts = any(isinstance(n, ast.JoinedStr) for n in ast.walk(node))
    return isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple) and texts and thousands(node.value)


def test_points_are_shown_by_one_function():
    root = Path(hognose.__file__).parent
    trees = [(file.relative_to(root), ast.parse(file.read_text())) for file in sorted(root.rglob("*.py"))]
    found = [f"{file}:{ast.unparse(node)}" for file, tree in trees for node in ast.walk(tree) if shows_a_point(node)]
    assert [place.split(":")[0] for place in found] == ["wording.py"], found


@pytest.mark.parametrize(
    ("value", "shown"),
    [(24.149999, "24.14"), (5.0, "5.00"), (4.999999, "4.99"), (0.0, "0.00"), (-0.0, "0.00"), (-1e-9, "-0.01")],
)
def test_some_lower_bounds(value, shown):
    assert at_least(value) == shown


@given(value=anything, limit=anything, lower_bound=st.booleans())
def test_a_figure_lies_on_the_same_side_of_its_limit_as_it_is_shown(value, limit, lower_bound):
    """Never "0 is below 0", nor "5 exceeds 5"."""
    shown, limited = (float(text) for text in beside_limit(value, limit, lower_bound))
    assert (shown < limited, shown == limited) == (value < limit, value == limit)


@given(value=anything, lower_bound=st.booleans())
def test_a_figure_is_rounded_to_the_worse_side(value, lower_bound):
    shown = float(beside_limit(value, 0.5 * value, lower_bound)[0])
    assert shown <= value if lower_bound else shown >= value


@given(value=st.floats(1e-3, 1e3), limit=st.floats(1e-3, 1e3))
def test_figures_far_apart_have_five_digits(value, limit):
    if abs(value - limit) > 1e-3 * max(value, limit):
        for text in beside_limit(value, limit, True):
            assert len(text.replace(".", "").lstrip("0")) <= 5


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_shown_as_that(value):
    assert beside_limit(value, 1.0, True) == (str(value), "1")
    assert beside_limit(1.0, value, False) == ("1", str(value))
    assert at_least(value) == at_most(value) == str(value)


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        (check(True, 0.024149999, 0.005, "m", at_least=True), "c: 24.149 mm is at least 5 mm"),
        (check(False, 0.0049999999, 0.005, "m", at_least=True), "c: 4.9999 mm is below 5 mm"),
        (check(False, 0.0, 0.0, "m", at_least=True), "c: 0 mm is not above 0 mm"),
        (check(False, -1e-15, 0.0, "m", at_least=True), "c: -1e-12 mm is below 0 mm"),
        (check(False, 0.0050000001, 0.005, "m"), "c: 5.0001 mm exceeds 5 mm"),
        (check(True, 0.005, 0.005, "m"), "c: 5 mm is within 5 mm"),
        (check(True, math.radians(3.1), math.radians(20), "rad/s"), "c: 3.1 deg/s is within 20 deg/s"),
        (check(False, 0.25, 0.2, "m/s"), "c: 250 mm/s exceeds 200 mm/s"),
        (check(False, 1.0, 5.0, "s", step=3, section=4), "c: 1 s fails, though within 5 s at step 3, section 4"),
        (check(False, 6.0, 5.0, "s", detail="so"), "c: 6 s exceeds 5 s (so)"),
        (check(False, 4.00001e-3, 4.00002e-3, "m", at_least=True), "c: 4.00001 mm is below 4.00002 mm"),
        (check(False, 2.0**63, 0.0, "counts"), "c: 9.2234e+18 counts exceeds 0 counts"),
        (check(False, 123456789, 100000, "counts"), "c: 123456789 counts exceeds 100000 counts"),
        (check(False, 2, 0, "1", cable=7, detail="missing"), "c: 2 exceeds 0 at cable 7 (missing)"),
        (check(True, math.radians(40), math.radians(40) * (1 + 1e-12), "rad"), "c: 40 deg is within 40 deg"),
        (check(False, math.radians(40) * (1 + 1e-12), math.radians(40), "rad"), "c: 40.001 deg exceeds 40 deg"),
        (check(False, 7.0, 5.0, "s", at_least=True), "c: 7 s fails, though at least 5 s"),
        (check(True, 0.05, 0.005, "m", at_least=True, is_bound=True), "c: ≥ 50 mm and thus at least 5 mm"),
        (check(False, 0.004, 0.005, "m", at_least=True, is_bound=True), "c: ≥ 4 mm not proven to be at least 5 mm"),
        (check(False, 0.0, 0.0, "m", at_least=True, is_bound=True), "c: ≥ 0 mm not proven to be above 0 mm"),
        (check(None, math.nan, math.nan, "m", detail="no masses"), "c: not judged (no masses)"),
        (check(False, math.nan, math.nan, "m", detail="it broke"), "c: failed (it broke)"),
        (check(False, math.nan, 5.0, "s"), "c: nan s exceeds 5 s"),
    ],
)  # fmt: skip
def test_sentences(verdict, words):
    assert verdict.sentence == words


@given(value=anything, limit=anything, unit=st.sampled_from(["m", "rad", "rad/s²", "s", "1", "counts"]))
def test_the_figures_of_a_check_are_apart_where_its_values_are(value, limit, unit):
    verdict = check(value <= limit, value, limit, unit)
    shown, limited = (float(text.split()[0]) for text in verdict.figures)
    assume(all(math.isfinite(1e3 * number) for number in (value, limit)))  # in mm it has to be a number, too
    assume(all(number == 0 or abs(number) > 1e-290 for number in (value, limit)))
    if verdict.ok and limit - value <= 1e-9 * abs(limit):
        assert shown <= limited
    else:
        assert (shown < limited, shown == limited) == (value < limit, value == limit)
