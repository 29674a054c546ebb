"""`hognose bench` as a command: what it prints and writes, interrupts, and wrong use."""

from __future__ import annotations

import csv
import json

import pytest

from hognose.evaluation import suite
from hognose.evaluation.families import suite_of_cases
from hognose.evaluation.machine import measured_version

QUICK = [case for case in suite_of_cases(1, quick=True) if case.family in ("cases", "helix")]
TWO = ("--method", "exact", "--method", "prediction")


@pytest.fixture
def bench(run, monkeypatch):
    """The command on three cases, with hardly any time for each row."""
    monkeypatch.setattr(suite, "_BUDGETS", dict.fromkeys((True, False), (1e-4, 0.5)))
    monkeypatch.setattr(suite, "suite_of_cases", lambda seed, quick: QUICK)

    def command(*tokens):
        return run("bench", "--quick", *tokens)

    return command


def test_it_prints_tables_and_writes_its_files(bench, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    done = bench(*TWO, "-o", "out")
    assert (done.code, done.err) == (0, "")
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"results.json", "results.csv", "evaluation.html"}
    lines = done.out.splitlines()
    assert [line.split() for line in lines[1:4]] == [
        ["method", "cases", "helix"],
        ["exact", "2/2", "1/1"],
        ["prediction", "2/2", "1/1"],
    ]
    for case in ("obstacle-array", "pipe-tank"):
        at = next(number for number, line in enumerate(lines) if line.startswith(f"{case}: "))
        assert [lines[at + k].split()[0] for k in (1, 2, 3)] == ["method", "exact", "prediction"]
        assert len(lines[at + 2].split()) == 11
    verdicts = lines[lines.index("Targets") + 2 : -2]
    assert len(verdicts) == 14
    assert sum(line.rstrip().endswith("reached") for line in verdicts) == 2
    assert sum(line.rstrip().endswith("not measured") for line in verdicts) == 12
    assert lines[-1] == "written: out/results.json, out/results.csv, out/evaluation.html"
    assert max(map(len, lines)) <= 100


def test_as_json_it_prints_the_rows_that_it_wrote(bench, tmp_path):
    done = bench("--method", "exact", "--json")
    assert (done.code, done.err) == (0, "")
    said = done.json
    stored = json.loads((tmp_path / "hognose-bench" / "results.json").read_text())
    assert said["good"] is None  # most targets were not measured
    assert (said["seed"], said["quick"], said["version"]) == (1, True, measured_version())
    assert [row["method"] for row in said["rows"]] == ["exact"] * 3
    series = {"tip_series_mm", "body_series_mm", "time_series_us"}
    assert said["rows"] == [{name: row[name] for name in row if name not in series} for row in stored["rows"]]
    with (tmp_path / "hognose-bench" / "results.csv").open() as file:
        assert [line["why"] for line in csv.DictReader(file)] == [""] * 3
    assert {target["verdict"] for target in said["targets"]} == {"reached", "not measured"}
    assert said["files"] == [f"hognose-bench/{name}" for name in ("results.json", "results.csv", "evaluation.html")]


def test_docs_are_written_beside_their_pictures(bench, tmp_path):
    (tmp_path / "docs").mkdir()
    done = bench(*TWO, "--docs", "docs/evaluation.md")
    assert done.code == 0
    text = (tmp_path / "docs" / "evaluation.md").read_text()
    assert "hognose bench --quick --method exact --method prediction --docs docs/evaluation.md" in text
    pictures = {f"pictures/{file.name}" for file in (tmp_path / "docs" / "pictures").iterdir()}
    assert pictures
    assert all(f"]({name})" in text for name in pictures)
    assert str(tmp_path) not in text


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_says_how_to_go_on_and_the_same_command_does(bench, tmp_path, monkeypatch, as_json):
    real, calls = suite.measured, []

    def interrupted(label, case, *budgets):
        if len(calls) == 2:
            raise KeyboardInterrupt
        calls.append(label)
        return real(label, case, *budgets)

    flags = ["--json"] if as_json else []
    monkeypatch.setattr(suite, "measured", interrupted)
    done = bench(*TWO, *flags)
    message = "interrupted; finished rows are in hognose-bench, the same command goes on from them"
    assert done.code == 130
    assert (done.json["error"] if as_json else done.err) == (message if as_json else f"hognose: {message}\n")
    kept = json.loads((tmp_path / "hognose-bench" / "results.json").read_text())["rows"]
    assert len(kept) == 2
    monkeypatch.setattr(suite, "measured", real)
    assert bench(*TWO, *flags).code == 0
    rows = json.loads((tmp_path / "hognose-bench" / "results.json").read_text())["rows"]
    assert len(rows) == 6
    assert [row for row in rows if row in kept] == kept


WRONG: dict[str, tuple[list[str], str]] = {
    "an unknown method": (["--method", "exakt"], "method 'exakt' is unknown; did you mean 'exact'?"),
    "a negative seed": (["--seed=-1"], "--seed -1: expected a whole number, 0 or more"),
    "no seed": (["--seed", "one"], "--seed"),
    "an output that is a file": (["-o", "file"], "file: cannot make the folder: File exists"),
    "an output below a file": (["-o", "file/below"], "file/below: cannot make the folder: Not a directory"),
    "an output that cannot be": (["-o", "/proc/out"], "/proc/out: cannot make the folder"),
    "docs of another kind": (["--docs", "page.html"], "page.html: the name of this page must end in .md"),
    "docs in no folder": (["--docs", "none/page.md"], "none/page.md: cannot write: there is no folder none"),
    "damaged results": (["-o", "damaged"], "damaged/results.json: is not what an earlier run has written"),
    "an unknown option": (["--qick"], "--qick"),
}


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("use", list(WRONG))
def test_wrong_use_is_one_message_and_changes_nothing(bench, tmp_path, use, as_json):
    (tmp_path / "file").write_text("here first")
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "results.json").write_text('{"rows": [')
    tokens, reason = WRONG[use]
    done = bench(*tokens, *(["--json"] if as_json else []))
    assert done.code == 2
    if as_json:
        assert (done.err, done.json["good"], done.json["exit_code"]) == ("", False, 2)
        assert reason in done.json["error"]
    else:
        assert done.out == ""
        assert done.err.startswith("hognose: ")
        assert reason in done.err
    assert {file.name for file in tmp_path.iterdir()} == {"file", "damaged"}
    assert [file.name for file in (tmp_path / "damaged").iterdir()] == ["results.json"]
    assert (tmp_path / "file").read_text() == "here first"
    assert (tmp_path / "damaged" / "results.json").read_text() == '{"rows": ['
