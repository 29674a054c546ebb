"""The commands that draw; what the drawings show is tested with the view."""

from __future__ import annotations

import sys

import pytest

import hognose
from hognose.files import bundled_tasks


def test_report_writes_one_page(run, made, tmp_path):
    done = run("report", made / "good.parquet", "--no-animation")
    assert (done.code, done.err) == (0, "")
    assert [file.name for file in tmp_path.iterdir()] == ["good.html"]
    assert done.out == f"good.html: {(tmp_path / 'good.html').stat().st_size / 1e3:.0f} kB\n"
    page = (tmp_path / "good.html").read_text()
    assert page.lower().startswith("<!doctype html>")
    assert all(check.name in page for check in hognose.Plan.load(made / "good.parquet").checks)


def test_report_says_its_files_as_json(run, made, tmp_path):
    done = run("report", made / "good.parquet", "--no-animation", "-o", "page.html", "--json")
    assert (done.code, done.json) == (0, {"good": True, "files": ["page.html"]})
    assert [file.name for file in tmp_path.iterdir()] == ["page.html"]


@pytest.mark.parametrize("as_json", [False, True])
def test_report_of_an_infeasible_task_is_written_and_ends_with_1(run, made, tmp_path, as_json):
    done = run("report", made / "tight.toml", "--no-animation", *(["--json"] if as_json else []))
    assert (done.code, done.err) == (1, "")
    assert "certified clearance" in (tmp_path / "tight.html").read_text()
    assert not as_json or done.json["good"] is False


@pytest.mark.parametrize(("page", "as_json"), [("none/page.html", True), ("/dev/full/page.html", False)])
def test_report_that_cannot_be_written_leaves_nothing(run, made, tmp_path, page, as_json):
    done = run("report", made / "good.parquet", "--no-animation", "-o", page, *(["--json"] if as_json else []))
    assert done.code == 2
    assert "cannot write" in (done.json["error"] if as_json else done.err)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("as_json", [False, True])
def test_report_of_what_cannot_be_reached_ends_with_1_and_one_message(run, made, tmp_path, as_json):
    done = run("report", made / "far.toml", "--no-animation", *(["--json"] if as_json else []))
    assert done.code == 1
    assert "does not come clear of 'back board'" in (done.json["error"] if as_json else done.err)
    assert not list(tmp_path.iterdir())


def test_demo_plans_and_reports_its_tasks(run, tmp_path, monkeypatch):
    # Every fourth: tests of planning say that each of them plans well.
    tasks = dict(list(bundled_tasks().items())[::4])
    assert len(tasks) > 3
    monkeypatch.setattr("hognose.files.bundled_tasks", lambda: tasks)
    done = run("demo", "--no-animation", "-o", "out", "--json")
    assert (done.code, done.err) == (0, "")
    said = done.json
    assert (said["good"], said["left_out"]) == (True, {})
    assert [plan["good"] for plan in said["plans"]] == [True] * len(tasks)
    expected = {f"{name}{suffix}" for name in tasks for suffix in (".parquet", ".html")}
    assert {file.name for file in (tmp_path / "out").iterdir()} == expected
    assert {file for plan in said["plans"] for file in plan["files"]} == {f"out/{name}" for name in expected}
    assert all(hognose.Plan.load(file).good for file in (tmp_path / "out").glob("*.parquet"))


@pytest.mark.parametrize("as_json", [False, True])
def test_demo_into_a_file_ends_with_2(run, tmp_path, as_json):
    (tmp_path / "out").write_text("here first")
    done = run("demo", "-o", "out", *(["--json"] if as_json else []))
    assert done.code == 2
    assert "out: cannot make the folder" in (done.json["error"] if as_json else done.err)
    assert (tmp_path / "out").read_text() == "here first"


def test_demo_leaves_out_what_needs_an_extra_that_is_missing(run, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "cascadio", None)
    monkeypatch.setenv("HOGNOSE_CACHE", "off")
    only = {"step-tank": bundled_tasks()["step-tank"]}
    monkeypatch.setattr("hognose.files.bundled_tasks", lambda: only)
    done = run("demo", "-o", "out")
    assert done.code == 0
    assert "step-tank is left out: " in done.out
    assert "pip install 'hognose[step]'" in done.out
    assert not list((tmp_path / "out").iterdir())
    said = run("demo", "-o", "out", "--json").json
    assert list(said["left_out"]) == ["step-tank"]
    assert "pip install 'hognose[step]'" in said["left_out"]["step-tank"]
    done = run("plan", "step-tank")
    assert done.code == 2
    assert done.err.startswith("hognose: ")
    assert "pip install 'hognose[step]'" in done.err
