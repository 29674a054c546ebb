"""Criteria: the list of Hognose's own, those of scripts and packages, and what is not judged."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from own_criteria import FLOOR, HIGH_FLOOR, LOAD, appended
from plan_file_makers import rewritten
from planning_makers import CHECKS, failed

import hognose
from hognose.errors import InputError
from hognose.planning import Plan, run_checks
from hognose.planning.checks import ALL, Check, Criterion, criteria, least, most, not_judged
from hognose.planning.checks import shared as shared_figures
from hognose.planning.checks.check import faults, from_json, good, tally, to_json
from hognose.planning.checks.run import OWN

#: How messages begin that are about what `by_package` adds as `mine`.
OF_PACKAGE = r"^the entry 'mine' of hognose\.checks in the package mine-checks: "


def by_package(monkeypatch: pytest.MonkeyPatch, **entries: Any) -> None:
    """As if installed packages named these under `hognose.checks`."""
    monkeypatch.setattr("hognose.planning.checks.run.added", lambda group: {"checks": entries}[group])
    monkeypatch.setattr("hognose.planning.checks.run.package_of", lambda group, name: f"{name}-{group}")


def criterion(key: str, *found: Any, error: Exception | None = None) -> Criterion:
    def judge(motion, shared):
        yield from found
        if error is not None:
            raise error

    return Criterion(key, key.replace("_", " "), "m", judge)


def test_every_criterion_of_ours_has_a_key_a_name_and_a_sentence_of_its_own():
    assert tuple(ALL) == OWN
    for field in ("key", "name", "says"):
        assert len({getattr(each, field) for each in OWN}) == len(OWN)
    assert all(each.says.endswith(".") for each in OWN)
    keys = [each.key for each in OWN]
    assert [key for key in keys if key in CHECKS] == list(CHECKS)


def test_verdicts_bear_key_name_and_unit_of_their_criterion(boards):
    of = {each.key: each for each in OWN}
    for check in boards.checks:
        assert (check.name, check.unit) == (of[check.key].name, of[check.key].unit)
        assert check.unit in {"m", "m/s", "rad", "rad/s", "rad/s²", "s", "counts", "N", "1"}


@pytest.mark.parametrize("place", ["appended", "of a package", "of a package's list", "given"])
def test_a_criterion_of_twenty_lines_is_one_like_any(boards, monkeypatch, place):
    if place.startswith("of"):
        by_package(monkeypatch, floor=[FLOOR] if "list" in place else FLOOR)
    with appended(*([FLOOR] if place == "appended" else [])):
        judged = boards.verified(more=[FLOOR] if place == "given" else ())
    assert tuple(check.key for check in judged.checks) == (
        *(check.key for check in boards.checks),
        "height_above_floor",
    )
    found = judged.check("height_above_floor")
    lowest = boards.body[found.step, found.link - 1 : found.link + 1, 1].min() - boards.robot.body_radii[0]
    assert found.value == pytest.approx(0.5 + lowest, abs=1e-12)
    assert (found.limit, found.section, found.ok, found.at_least) == (0.2, found.link, True, True)
    assert judged.good
    assert f"all {len(boards.checks) + 1} checks passed" in judged.summary()


def test_an_appended_criterion_decides_what_a_good_plan_is(boards, tmp_path):
    with appended(HIGH_FLOOR):
        with pytest.raises(hognose.InfeasibleError, match=r"height above a floor: [\d.]+ mm is below 600 mm at step"):
            hognose.plan(boards.task)
        boards.save(tmp_path / "plan.parquet")
        read = Plan.load(tmp_path / "plan.parquet")
        assert not read.good
        assert failed(read.checks) == {"high_floor"}
        assert read.check("high_floor").sentence in read.summary()
    assert Plan.load(tmp_path / "plan.parquet").good


def test_what_is_not_judged_is_neither_passed_nor_failed(boards, tmp_path):
    with appended(LOAD):
        judged = boards.verified()
        found = judged.check("payload")
        assert (found.ok, found.judged, found.failed, found.verdict) == (None, False, False, "not judged")
        assert found.sentence == "payload: not judged (the robot names no payload)"
        assert (found.figures, found.comparison) == (("", ""), "")
        assert judged.good
        assert judged.summary().endswith(
            f"GOOD: all {len(boards.checks)} checks passed, 1 was not judged\n  {found.sentence}"
        )
        judged.save(tmp_path / "plan.parquet")
        assert Plan.load(tmp_path / "plan.parquet").check("payload") == found
    bad = run_checks(boards, more=[LOAD, HIGH_FLOOR])
    summary = dataclasses.replace(boards, checks=bad).summary()
    assert f"NOT GOOD: 1 of {len(boards.checks) + 1} checks failed, 1 was not judged\n  height above" in summary
    assert summary.endswith(found.sentence)


def test_a_plan_of_which_nothing_is_judged_is_not_good():
    found = Check("a", "a", None, math.nan, math.nan, "m")
    assert not good([found])
    assert not good([])
    assert tally([found, found]) == "none of 2 checks was judged"
    assert tally([found]) == "nothing was judged"
    assert faults([found, found]) == [found, found]
    bad = dataclasses.replace(found, ok=False)
    assert faults([found, bad, dataclasses.replace(found, ok=True)]) == [bad]
    assert good([found, dataclasses.replace(found, ok=True)])


WRONG = {
    "raises": ([], ZeroDivisionError("division by zero"), "ZeroDivisionError: division by zero"),
    "raises at last": ([most(0.0, 1.0)], RuntimeError("no\nmore"), "RuntimeError: no more"),
    "exits": ([], SystemExit(0), "SystemExit: 0"),
    "raises ours": ([], hognose.InfeasibleError("too far"), "InfeasibleError: too far"),
    "says yes": ([True], None, "gave a bool, expected verdicts"),
    "a step beyond": ([most(0.0, 1.0, step=10_000)], None, "names step 10000, expected a whole number from 0 to 312"),
    "a link beyond": ([least(1.0, 0.0, link=12)], None, "names link 13, expected a whole number from 1 to 12"),
    "half a cable": ([Check("", "", True, 0.0, 1.0, "", cable=1.5)], None, "names cable 1.5"),  # pyright: ignore[reportArgumentType]
    "a word for a figure": ([Check("", "", True, "x", 1.0, "")], None, "gave value = 'x', expected a number"),  # pyright: ignore[reportArgumentType]
}


@pytest.mark.parametrize("what", list(WRONG))
def test_a_foreign_criterion_that_goes_wrong_fails_and_says_how(boards, what):
    found, error, words = WRONG[what]
    checks = run_checks(boards, more=[criterion("goes_wrong", *found, error=error)])
    assert failed(checks) == {"goes_wrong"}
    assert words in checks[-1].sentence
    assert checks[-1].sentence.startswith("goes wrong: failed (it could not be judged: ")
    assert checks[-1].sentence.endswith("; the check goes_wrong comes from more)")
    json.dumps([to_json(check) for check in checks], allow_nan=False)


def test_the_package_of_a_criterion_that_goes_wrong_is_named(boards, monkeypatch):
    by_package(monkeypatch, mine=criterion("goes_wrong", error=ValueError("x")))
    expected = "comes from the entry 'mine' of hognose.checks in the package mine-checks)"
    assert run_checks(boards)[-1].sentence.endswith(expected)


def test_a_judge_that_returns_nothing_to_iterate_fails_too(boards):
    judge: Any = lambda motion, shared: None  # noqa: E731
    checks = run_checks(boards, more=[Criterion("none", "none", "m", judge)])
    assert failed(checks) == {"none"}


def test_no_verdict_is_one_for_a_motion_that_a_criterion_does_not_apply_to(boards):
    assert run_checks(boards, more=[criterion("not_here")]) == boards.checks


def test_truth_values_and_numbers_of_numpy_become_plain(boards):
    found = Check("", "", np.bool_(True), np.float64(1.0), np.float32(2.0), "", np.int64(3))  # pyright: ignore[reportArgumentType]
    (check,) = run_checks(boards, more=[criterion("plain", found)])[len(boards.checks) :]
    assert [type(value) for value in (check.ok, check.value, check.limit, check.step)] == [bool, float, float, int]


def test_equal_keys_are_refused_and_both_homes_named(boards, monkeypatch):
    with pytest.raises(InputError, match=r"more: the key 'bend_limits' .* from hognose\.planning\.checks\.ALL"):
        boards.verified(more=[criterion("bend_limits")])
    by_package(monkeypatch, mine=FLOOR)
    with pytest.raises(InputError, match=r"more: the key 'height_above_floor' .* from the entry 'mine'"):
        criteria([FLOOR])
    with (
        appended(FLOOR),
        pytest.raises(InputError, match=OF_PACKAGE + "the key"),
    ):
        criteria()


@pytest.mark.parametrize("wrong", [3, "text", print, {"a": FLOOR}, [FLOOR, None], SimpleNamespace(key="a")])
def test_what_is_no_criterion_is_refused(boards, monkeypatch, wrong):
    with pytest.raises(InputError, match=r"^more: .*hognose\.planning\.checks\.Criterion"):
        boards.verified(more=wrong)
    by_package(monkeypatch, mine=wrong)
    with pytest.raises(
        InputError,
        match=OF_PACKAGE + r".*planning\.checks\.Criterion",
    ):
        criteria()


def test_what_a_package_adds_must_be_there_more_than_once(monkeypatch):
    by_package(monkeypatch, mine=iter([FLOOR]))
    with pytest.raises(InputError, match=r"or a list of them, got list_iterator"):
        criteria()


NO_UNITS = ("furlong", "mm", "deg", "m/", "/s", "m²²", "ms", "m//s", " m", "M")


@pytest.mark.parametrize("unit", ["m", "rad/s²", "N", "N·m", "N m", "1/m", "kg", "counts", "1", "m²", "Pa", "rad/s"])
def test_units_of_si_are_taken(unit):
    assert dataclasses.replace(FLOOR, unit=unit).unit == unit


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"key": "Bend limits"}, "key: expected lower-case words"),
        ({"key": "bend__limits"}, "key: expected"),
        ({"key": 3}, "key: expected"),
        ({"name": ""}, "name of the criterion"),
        ({"name": "a\nb"}, "name of the criterion"),
        ({"unit": None}, "unit of the criterion"),
        *(({"unit": unit}, rf"unit of the criterion .*'{unit}' is no SI unit") for unit in NO_UNITS),
        ({"judge": 3}, "judge of the criterion"),
    ],
)
def test_a_criterion_that_is_none_is_refused_when_it_is_made(change, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(FLOOR, **change)


def test_a_check_is_found_by_its_key_and_not_by_its_name(boards):
    assert boards.check("bend_limits").name == "bend limits"
    with pytest.raises(InputError) as caught:
        boards.check("bend limits")
    assert all(key in str(caught.value) for key in CHECKS)


def test_what_criteria_share_is_worked_out_once(boards, monkeypatch):
    calls: list[str] = []

    def counted(name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *arguments: (calls.append(name), real(*arguments))[1]

    for name in ("followed", "section_clearance", "certify", "certify_cables", "gliding_motion", "interpolated_motion"):
        monkeypatch.setattr(shared_figures, name, counted(name, getattr(shared_figures, name)))

    def uses_all(motion, shared):
        yield most(shared.clearance.min() + shared.followed.min() + shared.along_path.clearance, 9.0)
        yield most(shared.interpolated.clearance + shared.cables_interpolated.clearance, 9.0)

    checks = run_checks(boards, more=[Criterion("uses_all", "uses all", "m", uses_all)])
    assert len(checks) == len(boards.checks) + 2
    assert sorted(calls) == [
        *(
            "certify",
            "certify",
            "certify_cables",
            "followed",
            "gliding_motion",
            "interpolated_motion",
            "section_clearance",
        )
    ]
    calls.clear()
    assert run_checks(boards, measured=boards.clearance) == boards.checks
    assert "section_clearance" not in calls


def test_progress_is_told_once_a_stage(boards):
    stages: list[str] = []
    boards.verified(stages.append, more=[FLOOR, LOAD])
    assert stages == ["checking kinematics", "certifying clearance", "making more checks"]


def test_where_joints_cannot_be_followed_nothing_else_is_judged(boards):
    lost = dataclasses.replace(boards, feed=boards.feed + 10.0)
    (check,) = run_checks(lost, more=[FLOOR])
    assert (check.key, check.ok, check.limit) == ("feed_on_path", False, boards.path.length)
    assert "nothing else can be checked" in check.sentence


def test_the_basis_of_a_package_that_is_not_judged_leaves_the_others_to_be(boards):
    """Else a plan would be good of which what comes behind was never judged."""
    unknown = dataclasses.replace(criterion("mine", not_judged("no masses")), basis=True)
    checks = run_checks(boards, more=[unknown, HIGH_FLOOR])
    assert failed(checks) == {"high_floor"}
    assert checks[-2].detail == "no masses"


def test_checks_go_to_json_and_back(boards):
    checks = run_checks(boards, more=[LOAD, criterion("goes_wrong", error=ValueError("x"))])
    said = json.loads(json.dumps([to_json(check) for check in checks], allow_nan=False))
    assert [set(entry) for entry in said] == [{field.name for field in dataclasses.fields(Check)}] * len(checks)
    again = from_json(said)
    assert [to_json(check) for check in again] == said
    assert again[: len(boards.checks)] == boards.checks
    assert good(again) == good(checks)


def test_files_whose_checks_had_no_keys_are_read(boards, tmp_path):
    boards.save(tmp_path / "new.parquet")

    def as_before(said: dict[str, Any]) -> dict[str, Any]:
        gone = {"key", "link", "cable", "obstacle"}
        said["checks"] = [{k: v for k, v in check.items() if k not in gone} for check in said["checks"]]
        return said

    (tmp_path / "old.parquet").write_bytes(rewritten(tmp_path / "new.parquet", change_meta=as_before))
    assert Plan.load(tmp_path / "old.parquet").checks == boards.checks


def test_not_judged_says_why():
    assert not_judged("no masses").detail == "no masses"
