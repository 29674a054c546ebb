"""A suite that is interrupted, goes on, and does not mix what does not belong together."""

import csv
import dataclasses
import io
import json

import pytest
from evaluation_makers import small_case

from hognose.errors import InfeasibleError, InputError
from hognose.evaluation import suite
from hognose.evaluation.section_families import MAKERS
from hognose.evaluation.subjects import PUBLISHED, as_published, follower_for, method_of, subjects_of, takes_part
from hognose.evaluation.suite import SERIES, run_suite
from hognose.following import METHODS, OF_SECTIONS
from hognose.following.published import Tuned

LABELS = ["exact", "prediction", "interpolation"]
CASES = [small_case(), small_case("helix", "a"), small_case("spacing", "b")]


@pytest.fixture
def counted(monkeypatch):
    """The rows measured, in order, and hardly any time for each."""
    monkeypatch.setattr(suite, "_BUDGETS", dict.fromkeys((True, False), (1e-4, 1e-3)))
    real, done = suite.measured, []

    def measured(label, case, *budgets):
        done.append((label, case.family, case.name))
        return real(label, case, *budgets)

    monkeypatch.setattr(suite, "measured", measured)
    return done


def run(folder, labels=LABELS, **more):
    return run_suite(folder, labels, quick=True, cases=CASES, **more)


def stop_at(number):
    """A progress that is interrupted before row `number`."""

    def progress(done, total):
        assert total == 10  # 3 methods on 3 cases, and one race
        if done == number:
            raise KeyboardInterrupt

    return progress


def stored(folder):
    return json.loads((folder / "results.json").read_text())


def test_a_run_has_one_row_a_method_and_case_and_a_race(tmp_path, counted):
    seen = []
    found = run(tmp_path, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(done, 10) for done in range(11)]
    assert [(row.method, row.family) for row in found.rows] == [
        (label, case.family) for case in CASES for label in LABELS
    ]
    assert set(found.races) == {"pipe-tank"}
    assert set(found.races["pipe-tank"]) == set(LABELS)
    assert all(0.0 < value < 1e6 for value in found.races["pipe-tank"].values())
    assert all(row.valid for row in found.rows)


@pytest.mark.parametrize("at", [0, 4, 9])
def test_an_interrupted_run_keeps_its_rows_and_the_next_does_the_rest(tmp_path, counted, at):
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, progress=stop_at(at))
    kept = stored(tmp_path)["rows"]
    assert len(kept) == len(counted) == at
    first = list(counted)
    counted.clear()
    found = run(tmp_path)
    assert len(counted) == 9 - at
    assert not set(first) & set(counted)
    after = stored(tmp_path)
    assert after["rows"][:at] == kept
    assert len(after["rows"]) == len(found.rows) == 9
    assert set(after["races"]["pipe-tank"]) == set(LABELS)


def test_an_interruption_within_a_row_loses_that_row_only(tmp_path, counted, monkeypatch):
    working = suite.measured

    def interrupted(label, case, *budgets):
        if (label, case.family) == ("prediction", "helix"):
            raise KeyboardInterrupt
        return working(label, case, *budgets)

    monkeypatch.setattr(suite, "measured", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    assert [(row["method"], row["family"]) for row in stored(tmp_path)["rows"]] == [
        ("exact", "cases"),
        ("prediction", "cases"),
        ("interpolation", "cases"),
        ("exact", "helix"),
    ]


def test_a_finished_run_measures_nothing_again_and_fresh_does(tmp_path, counted):
    before = run(tmp_path)
    written = (tmp_path / "results.json").read_bytes()
    counted.clear()
    assert run(tmp_path) == before
    assert (tmp_path / "results.json").read_bytes() == written
    assert counted == []
    run(tmp_path, fresh=True)
    assert len(counted) == 9


def test_another_method_is_added_to_what_is_there(tmp_path, counted):
    run(tmp_path, ["prediction"])
    counted.clear()
    found = run(tmp_path, ["exact"])
    assert {label for label, _, _ in counted} == {"exact"}
    assert found.methods == ["exact", "prediction"]
    assert [row.method for row in found.rows] == ["exact", "prediction"] * 3
    assert set(found.races["pipe-tank"]) == {"exact", "prediction"}


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda text: text[: len(text) // 2], "EOF while parsing"),
        (lambda text: "", "EOF while parsing"),
        (lambda text: "[]", "Input should be an object"),
        (
            lambda text: text.replace('"rows": [{', '"rows": [{"extra": 1, ', 1).replace('"family"', '"fam"', 1),
            "family",
        ),
        (lambda text: text.replace('"solved": true', '"solved": "perhaps"', 1), "rows.0.solved"),
        (lambda text: text.replace('"quick": true', '"quick": false'), "quick was False, now True"),
        (lambda text: text.replace('"seed": 1', '"seed": 7'), "seed was 7, now 1"),
        (lambda text: text.replace('"version": "', '"version": "9'), "version was 9"),
        (lambda text: text.replace('"numba": "', '"numba": "9'), "machine was"),
    ],
)
def test_results_that_cannot_be_resumed_are_an_error_and_stay(tmp_path, counted, damage, reason):
    run(tmp_path, ["exact"])
    file = tmp_path / "results.json"
    damaged = damage(file.read_text())
    assert damaged != file.read_text()
    file.write_text(damaged)
    with pytest.raises(InputError) as raised:
        run(tmp_path, ["exact"])
    assert str(raised.value).startswith(f"{file}: ")
    assert reason in str(raised.value)
    assert str(raised.value).endswith("--fresh replaces it, --output names another folder")
    assert file.read_text() == damaged
    assert len(run(tmp_path, ["exact"], fresh=True).rows) == 3


def test_results_that_are_a_folder_are_an_error(tmp_path, counted):
    (tmp_path / "results.json").mkdir()
    with pytest.raises(InputError, match=r"results.json: is a folder, expected a file"):
        run(tmp_path)


def test_csv_and_json_agree(tmp_path, counted):
    found = run(tmp_path)
    lines = list(csv.DictReader(io.StringIO((tmp_path / "results.csv").read_text())))
    rows = stored(tmp_path)["rows"]
    assert len(lines) == len(rows) == len(found.rows) == 9
    for line, row in zip(lines, rows, strict=True):
        assert set(line) == set(row) - set(SERIES)
        assert line == {name: "" if row[name] is None else str(row[name]) for name in line}


def test_a_case_without_a_solution_ends_the_suite(tmp_path, counted):
    wrong = dataclasses.replace(small_case(), bend_limit=0.05)
    with pytest.raises(InfeasibleError, match="cases, pipe-tank: a joint bends by"):
        run_suite(tmp_path, LABELS, quick=True, cases=[wrong])
    assert counted == []


def test_subjects_are_all_methods_and_the_published_ones_beside_them():
    labels = subjects_of()
    assert list(dict.fromkeys(map(method_of, labels))) == list({**METHODS, **OF_SECTIONS})
    assert [label for label in labels if label != method_of(label)] == [
        as_published(name) for name in METHODS if name in ("iterative", "bisection", "optimization")
    ]
    assert subjects_of(["iterative", "exact", "exact"]) == ["iterative", "iterative (published)", "exact"]
    with pytest.raises(InputError, match="did you mean 'exact'"):
        subjects_of(["exakt"])


def test_published_variants_are_what_they_say():
    case = small_case()
    for label in subjects_of():
        if not takes_part(label, "cases"):
            assert label in OF_SECTIONS
            continue
        follower = follower_for(label, case)
        assert follower.name == method_of(label)
        assert isinstance(follower, Tuned) == (method_of(label) in PUBLISHED)
        if isinstance(follower, Tuned):
            assert follower.as_published is (label != method_of(label))


def test_the_spacing_family_is_for_methods_that_use_points():
    assert [label for label in subjects_of() if takes_part(label, "spacing")] == [
        "exact",
        "prediction",
        "interpolation",
        "iterative",
        "iterative (published)",
    ]
    links = [label for label in subjects_of() if takes_part(label, "helix")]
    assert list(dict.fromkeys(map(method_of, links))) == list(METHODS)


def test_families_of_other_sections_are_for_the_methods_that_take_them():
    for family in MAKERS:
        assert sorted(label for label in subjects_of() if takes_part(label, family)) == sorted(OF_SECTIONS)
