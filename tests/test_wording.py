"""Rounding as people read it: what is proven is never shown as better than it is."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hognose.planning import Check
from hognose.wording import at_least, at_least_mm, at_most, beside_limit

numbers = st.floats(-1e12, 1e12)
anything = st.floats(allow_nan=False, allow_infinity=False)


@given(value=numbers, places=st.integers(0, 6))
def test_a_lower_bound_is_rounded_down_and_an_upper_one_up_by_less_than_a_place(value, places):
    below, above = Fraction(at_least(value, places)), Fraction(at_most(value, places))
    exact, place = Fraction(repr(value)), Fraction(1, 10**places)
    assert exact - place < below <= exact <= above < exact + place


@given(value=numbers)
def test_lengths_are_said_in_mm(value):
    assert at_least_mm(value) == at_least(1e3 * value, 2)


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
    ("check", "words"),
    [
        (Check("c", True, 24.149999, 5.0, "mm", at_least=True), "c: 24.149 mm is at least 5 mm"),
        (Check("c", False, 4.9999999, 5.0, "mm", at_least=True), "c: 4.9999 mm is below 5 mm"),
        (Check("c", False, 0.0, 0.0, "mm", at_least=True), "c: 0 mm is not above 0 mm"),
        (Check("c", False, -1e-12, 0.0, "mm", at_least=True), "c: -1e-12 mm is below 0 mm"),
        (Check("c", False, 5.0000001, 5.0, "mm"), "c: 5.0001 mm exceeds 5 mm"),
        (Check("c", True, 5.0, 5.0, "mm"), "c: 5 mm is within 5 mm"),
        (Check("c", False, 1.0, 5.0, "s", 3, 4), "c: 1 s fails, though within 5 s at step 3, section 4"),
        (Check("c", False, 6.0, 5.0, "s", detail="so"), "c: 6 s exceeds 5 s (so)"),
        (Check("c", False, 4.00001, 4.00002, "mm", at_least=True), "c: 4.00001 mm is below 4.00002 mm"),
        (Check("c", False, 2.0**63, 0.0, "counts"), "c: 9.2234e+18 counts exceeds 0 counts"),
        (Check("c", False, 123456789, 100000, "counts"), "c: 123456789 counts exceeds 100000 counts"),
    ],
)  # fmt: skip
def test_sentences(check, words):
    assert check.sentence == words
