"""What judges of scripts and other packages return: whatever it is, a verdict in plain types or a failure in words."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from typing import Any

import numpy as np
import pytest
from extension_makers import Silent
from hypothesis import given
from hypothesis import strategies as st
from own_criteria import appended
from planning_makers import failed

from hognose.errors import InputError
from hognose.planning import Plan, run_checks
from hognose.planning.checks import Check, Criterion, Shared, least, most
from hognose.planning.checks.check import from_json, to_json
from hognose.planning.columns import Quantity
from hognose.planning.motion import Motion

numbers = st.floats() | st.integers(-3, 400) | st.sampled_from([0.1, 0.1 * (1 + 1e-12), 5.0, -5.0, 0.0, math.nan])
texts = st.text(st.characters(exclude_categories=()), max_size=8)
junk = st.one_of(
    st.none(),
    st.booleans(),
    st.booleans().map(np.bool_),
    numbers,
    numbers.map(np.float64),
    st.floats(width=32).map(np.float32),
    st.integers(-3, 400).map(np.int64),
    st.just(10**400),
    numbers.map(np.asarray),
    texts,
    texts.map(np.str_),
    st.complex_numbers(),
    st.just([1, 2]),
    st.just(b"raw"),
)
likely: dict[str, st.SearchStrategy[Any]] = {
    "ok": st.sampled_from([True, False, None, np.bool_(True), np.bool_(False)]),
    "value": numbers,
    "limit": numbers | numbers.map(np.float64),
    "at_least": st.booleans() | st.booleans().map(np.bool_),
    "is_bound": st.booleans() | st.booleans().map(np.bool_),
    "obstacle": st.none() | texts | texts.map(np.str_),
    "detail": texts | texts.map(np.str_),
    **{name: st.none() | st.integers(0, 14) | st.integers(0, 14).map(np.int32) for name in ("step", "section", "link")},
    "cable": st.none() | st.integers(1, 24),
}
verdicts = st.builds(
    lambda said, wrong: Check(**{"key": "", "name": "", "unit": "", **said, **wrong}),
    st.fixed_dictionaries(likely),
    st.dictionaries(st.sampled_from(list(likely)), junk, max_size=2),
)
TYPES: dict[str, tuple[type, ...]] = {
    **dict.fromkeys(("key", "name", "unit", "detail"), (str,)),
    **dict.fromkeys(("step", "section", "link", "cable"), (int, type(None))),
    **dict.fromkeys(("value", "limit"), (float,)),
    "ok": (bool, type(None)),
    "at_least": (bool,),
    "is_bound": (bool,),
    "obstacle": (str, type(None)),
}


@given(found=verdicts)
def test_whatever_a_judge_returns_becomes_a_verdict_that_a_file_can_hold(boards, found):
    criterion = Criterion("foreign", "foreign check", "m", lambda motion, shared: [found])
    (check,) = criterion.guarded(boards, Shared(boards), "the package cell")
    assert {each.name for each in dataclasses.fields(Check)} == set(TYPES)
    assert all(type(getattr(check, name)) in kinds for name, kinds in TYPES.items())
    said = json.loads(json.dumps([to_json(check)], allow_nan=False).encode())
    assert [to_json(again) for again in from_json(said)] == said
    if check.detail.startswith("it could not be judged"):
        assert check.failed
        assert check.sentence.startswith("foreign check: failed (it could not be judged: it")
        assert check.detail.endswith("; the check foreign comes from the package cell")
    else:
        assert check.ok == found.ok
        assert not check.ok or check.figures_agree


@given(found=verdicts)
def test_what_is_said_of_a_verdict_is_true_of_the_numbers_that_are_shown(boards, found):
    (check,) = Criterion("foreign", "f", "m", lambda motion, shared: [found]).guarded(boards, Shared(boards), "a")
    if not (math.isfinite(1e3 * check.value) and math.isfinite(1e3 * check.limit)) or not check.judged:
        return
    relation = re.fullmatch(r"(?:≥ )?(\S+) (!?)([≤≥>]) (\S+) mm(, but failed)?", check.comparison)
    assert relation
    assert check.comparison.startswith("≥ ") == (check.is_bound and check.at_least)
    value, unlike, sign, limit = float(relation[1]), bool(relation[2]), relation[3], float(relation[4])
    holds = {"≤": value <= limit, "≥": value >= limit, ">": value > limit}[sign]
    assert holds != unlike
    assert check.failed == (unlike or bool(relation[5]))
    words = {
        "is within": value <= limit,
        "is at least": value >= limit,
        "exceeds": value > limit,
        "is below": value < limit,
        "is not above": value <= limit,
        "and thus at least": value >= limit,
        "not proven to be at least": value < limit,
        "not proven to be above": value <= limit,
        "fails, though within": value <= limit,
        "fails, though at least": value >= limit,
    }
    said = re.match(r"f: (?:≥ )?\S+ mm ([a-z, ]+) \S+ mm", check.sentence)
    assert said
    assert words[said[1]]


CONTRADICTIONS = {
    "above": Check("", "", True, 5.0, 4.0, ""),
    "below": Check("", "", True, 3.0, 4.0, "", at_least=True),
    "none": Check("", "", True, 0.0, 0.0, "", at_least=True),
    "no number": Check("", "", True, math.nan, 4.0, ""),
    "no limit": Check("", "", True, 4.0, math.nan, ""),
}


@pytest.mark.parametrize("what", list(CONTRADICTIONS))
def test_a_verdict_that_contradicts_its_figures_fails_and_says_so(boards, what):
    found = CONTRADICTIONS[what]
    checks = run_checks(boards, more=[Criterion("odd", "odd", "m", lambda motion, shared: [found])])
    assert failed(checks) == {"odd"}
    expected = f"its judge says that it passed, but its value is {found.value:.12g} and its limit {found.limit:.12g}"
    assert expected in checks[-1].sentence


@pytest.mark.parametrize(
    "found",
    [
        most(5.0, 4.0 * 1.25 * (1 - 1e-12), ok=True),  # an allowance for rounding
        most(3.0, 4.0, ok=False),  # something else than the figure decided
        least(5.0, 4.0),
        Check("", "", True, -5.0, -5.0, "", at_least=True),
        Check("", "", True, math.nan, math.nan, ""),
    ],
)
def test_a_verdict_that_does_not_is_taken_as_it_is(boards, found):
    (check,) = run_checks(boards, more=[Criterion("even", "even", "m", lambda motion, shared: [found])])[-1:]
    assert (check.ok, check.detail) == (found.ok, "")
    assert repr((check.value, check.limit)) == repr((found.value, found.limit))


def test_a_plan_is_saved_with_the_verdict_of_a_judge_that_counts_in_numpy(boards, tmp_path):
    least_of = Check("", "", np.True_, np.float64(2), np.float64(1), "", obstacle=np.str_("lid"), at_least=np.True_)  # pyright: ignore[reportArgumentType]
    with appended(Criterion("numpy", "numpy", "m", lambda motion, shared: [least_of])):
        boards.save(tmp_path / "plan.parquet")
        found = Plan.load(tmp_path / "plan.parquet").check("numpy")
    assert (found.ok, found.at_least, found.obstacle, found.value) == (True, True, "lid", 2.0)


def test_an_error_whose_words_cannot_be_made_is_a_failure_too(boards):
    def judge(motion, shared):
        raise Silent

    checks = run_checks(boards, more=[Criterion("silent", "silent", "m", judge)])
    assert "it could not be judged: Silent; the check silent" in checks[-1].sentence


OF_MOTION = [
    *(each.name for each in dataclasses.fields(Motion) if each.type == "Array" or each.type.startswith("NDArray")),
    *("body", "exact_joints", "tip_error", "body_deviation"),
]
OF_SHARED = ["followed", "intervals", "joint_speed", "cable_lengths", "clearance"]


@pytest.mark.parametrize("name", [*OF_MOTION, *(f"shared.{name}" for name in OF_SHARED)])
def test_a_judge_cannot_alter_the_plan_that_it_judges(boards, name):
    def judge(motion, shared):
        array = getattr(shared, name.partition(".")[2]) if "." in name else getattr(motion, name)
        array[...] = 0
        yield most(0, 0)

    before = {each: getattr(boards, each).tobytes() for each in OF_MOTION}
    checks = run_checks(boards, more=[Criterion("alters", "alters", "m", judge)])
    assert failed(checks) == {"alters"}
    assert "read-only" in checks[-1].sentence
    assert {each: getattr(boards, each).tobytes() for each in OF_MOTION} == before


def test_no_array_that_a_judge_is_given_can_be_written_to(boards):
    arrays = {
        f"{type(owner).__name__}.{name}": value
        for owner in (boards, Shared(boards))
        for name in dir(owner)
        if isinstance(value := getattr(owner, name), np.ndarray)
    }
    assert {f"Plan.{name}" for name in OF_MOTION} | {f"Shared.{name}" for name in OF_SHARED} <= set(arrays)
    assert [name for name, array in arrays.items() if array.flags.writeable] == []


def test_the_arrays_of_who_makes_a_plan_stay_as_they_are(boards):
    angles, extra = np.array(boards.angles), {"note": np.arange(float(len(boards.time)))}
    made = dataclasses.replace(boards, angles=angles, extra=extra)
    assert angles.flags.writeable
    assert extra["note"].flags.writeable
    angles[:], extra["note"][:] = 9.0, -1.0  # and the plan's as they are
    assert np.array_equal(made.angles, boards.angles)
    assert np.array_equal(made.extra["note"], np.arange(float(len(boards.time))))
    assert not made.angles.flags.writeable
    assert not made.extra["note"].flags.writeable


def broken(motion: Motion) -> Any:
    raise KeyError("mass")


@pytest.mark.parametrize(("of", "words"), [(broken, "broken failed with KeyError: 'mass'"), ("nothing", "nothing'")])
def test_a_quantity_whose_figures_cannot_be_made_is_named(boards, of, words):
    with pytest.raises(InputError, match="quantity 'load_N': ") as caught:
        Quantity("load_N", "N", "load", of).values(boards)
    assert words in str(caught.value)
