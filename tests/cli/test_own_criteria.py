"""A criterion of a script is shown wherever checks are, and so is what is not judged."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from own_criteria import FLOOR, HIGH_FLOOR, LOAD, appended

import hognose


@pytest.fixture(autouse=True)
def added() -> Iterator[None]:
    with appended(FLOOR, LOAD):
        yield


def test_check_shows_them(run, made):
    done = run("check", made / "good.parquet")
    assert (done.code, done.err) == (0, "")
    checks = hognose.Plan.load(made / "good.parquet").checks
    assert re.search(rf"^ok +height above the floor +{re.escape(checks[-2].comparison)} +step \d+", done.out, re.M)
    assert re.search(r"^not judged +payload +the robot names no payload *$", done.out, re.M)
    assert f"GOOD: all {len(checks) - 1} checks passed, 1 was not judged\n  payload: not judged (" in done.out


def test_check_says_them_as_json_in_si(run, made):
    done = run("check", made / "good.parquet", "--json")
    assert (done.code, done.json["good"]) == (0, True)
    floor, load = done.json["checks"][-2:]
    assert (floor["key"], floor["name"], floor["unit"]) == ("height_above_floor", "height above the floor", "m")
    assert 0.2 <= floor["value"] <= 0.5
    assert (floor["limit"], floor["section"], floor["ok"]) == (0.2, floor["link"], True)
    assert (load["key"], load["ok"], load["value"], load["limit"], load["unit"]) == ("payload", None, None, None, "N")
    assert load["detail"] == "the robot names no payload"
    named = done.json["checks"][0]
    assert (named["key"], named["unit"]) == ("bend_limits", "rad")
    assert named["limit"] == pytest.approx(0.5, rel=1e-9)


def test_what_a_script_does_not_let_pass_ends_with_1(run, made):
    with appended(HIGH_FLOOR):
        for command in (("check", made / "good.parquet"), ("plan", "pipe-tank"), ("check", "pipe-tank")):
            done = run(*command)
            assert done.code == 1
            assert re.search(r"height above a floor: [\d.]+ mm is below 600 mm at step \d+, section 6", done.out)
            assert "checks failed, 1 was not judged" in done.out


def test_the_report_shows_them(run, made, tmp_path):
    assert run("report", made / "good.parquet", "--no-animation").code == 0
    page = (tmp_path / "good.html").read_text()
    assert re.search(r"<th[^>]*>height above the floor</th>.*?>passed</td>", page)
    row = re.search(r"<th[^>]*>payload</th>(.*?)</tr>", page)
    assert row
    assert "the robot names no payload" in row[1]
    assert row[1].endswith("<td>not judged</td>")
    assert "checks passed. Not judged: payload." in page


def test_the_report_says_which_failed_apart_from_what_was_not_judged(run, made, tmp_path):
    with appended(HIGH_FLOOR):
        assert run("report", made / "good.parquet", "--no-animation").code == 1
        judged = [check for check in hognose.Plan.load(made / "good.parquet").checks if check.ok is not None]
    page = (tmp_path / "good.html").read_text()
    assert f"1 of {len(judged)} checks failed: height above a floor. Not judged: payload." in page
