"""Exports: the plan's columns, bit for bit."""

from __future__ import annotations

import csv
import dataclasses
import json
import re

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from extension_makers import Silent

import hognose
from hognose import extensions
from hognose.files import exports
from hognose.files.exports import Content, Export, export, formats


@pytest.fixture(scope="module")
def plan() -> hognose.Plan:
    """A bundled plan with numbers in it that are hard to write down."""
    made = hognose.plan(hognose.load_task("pipe-tank"))
    clearance = made.clearance.copy()
    clearance[3, :6] = [5e-324, -0.0, 1 / 3, 999999.9999999999, 2.2250738585072014e-308, 0.1 + 0.2]
    return dataclasses.replace(made, clearance=clearance)


@pytest.fixture(scope="module")
def columns(plan, tmp_path_factory) -> dict[str, np.ndarray]:
    """The columns as the plan file has them; that they are the plan's is tested with the plan file."""
    file = tmp_path_factory.mktemp("export") / "plan.parquet"
    export(plan, file)
    table = pq.read_table(file)
    return {name: table.column(name).to_numpy() for name in table.column_names}


def assert_same_bits(values: list[str] | list[float], expected: np.ndarray) -> None:
    kind = int if expected.dtype == np.int64 else float
    assert np.array([kind(value) for value in values], dtype=expected.dtype).tobytes() == expected.tobytes()


def test_csv_has_the_columns_bit_for_bit(plan, columns, tmp_path):
    export(plan, tmp_path / "plan.csv")
    with (tmp_path / "plan.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == list(columns)
    assert len(rows) == len(plan.time)
    for index, name in enumerate(header):
        assert_same_bits([row[index] for row in rows], columns[name])


def test_pandas_reads_the_csv(plan, columns, tmp_path):
    export(plan, tmp_path / "plan.csv")
    frame = pd.read_csv(tmp_path / "plan.csv")
    assert list(frame.columns) == list(columns)
    for name, values in columns.items():
        np.testing.assert_allclose(frame[name].to_numpy(), values, rtol=1e-15, atol=0)


def test_json_has_the_columns_bit_for_bit_and_the_metadata(plan, columns, tmp_path):
    export(plan, tmp_path / "plan.json")
    content = json.loads((tmp_path / "plan.json").read_text())
    assert set(content) == {"hognose", "columns"}
    assert list(content["columns"]) == list(columns)
    for name, values in columns.items():
        assert_same_bits(content["columns"][name], values)
    plan.save(tmp_path / "plan.parquet")
    assert content["hognose"]["good"] is False  # whatever the plan in hand says of itself
    assert plan.good
    base, profile = content["hognose"].pop("base"), content["hognose"].pop("profile")
    assert base == {"kind": "slider", "direction": [0.0, 0.0, 1.0], "words": "slider along +z"}
    said = plan.task.spec.motion
    assert (profile["kind"], profile["period_s"], profile["step"]) == ("constant", said.period_s, said.step)
    assert content["hognose"] == json.loads(pq.read_schema(tmp_path / "plan.parquet").metadata[b"hognose"])


@pytest.mark.parametrize("name", ["plan.xls", "plan", "plan.", "plan.csv.gz", ".csv", "plan.none"])
def test_an_unknown_suffix_says_which_there_are(plan, tmp_path, name):
    with pytest.raises(hognose.InputError, match=rf"unknown format .*; expected {re.escape(', '.join(formats()))}$"):
        export(plan, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_ours_are_first():
    assert list(formats())[:3] == [".csv", ".json", ".parquet"]


@pytest.mark.parametrize("suffix", list(formats()))
def test_nothing_is_written_where_it_cannot_be(plan, tmp_path, suffix):
    with pytest.raises(hognose.InputError, match=r"cannot write: No such file or directory\. Nothing was written"):
        export(plan, tmp_path / "none" / f"plan{suffix}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".CSV", ".Parquet"])
def test_the_case_of_a_suffix_does_not_matter_or_is_refused(plan, tmp_path, suffix):
    try:
        export(plan, tmp_path / f"plan{suffix}")
    except hognose.InputError:
        assert not list(tmp_path.iterdir())
    else:
        assert (tmp_path / f"plan{suffix}").stat().st_size > 10_000


@pytest.fixture
def adds(monkeypatch):
    """Have other packages add formats, by the names of their entry points."""

    def add(**given):
        monkeypatch.setattr(exports, "added", lambda group: given if group == "exports" else {})

    return add


def test_other_packages_add_formats(plan, adds, tmp_path):
    before = formats()
    adds(steps=Export(".steps", "the number of steps", lambda plan: str(len(plan.time)).encode()))
    assert list(formats()) == [*before, ".steps"]
    written = export(plan, tmp_path / "plan.steps")
    assert (tmp_path / "plan.steps").read_text() == str(len(plan.time))
    assert written.plan is not None
    assert not written.plan.good  # verified, whatever the plan in hand says of itself
    with pytest.raises(hognose.InputError, match=r"expected \.csv, \.json, \.parquet, (.*, )?\.steps$"):
        export(plan, tmp_path / "plan.xls")


def test_an_entry_point_adds_a_format(monkeypatch):
    class Entry:
        name, value, dist = "mine", "mine:EXPORT", None

        def load(self):
            return Export(".mine", "mine", lambda plan: b"")

    before = formats()
    monkeypatch.setattr(extensions, "entry_points", lambda group: [Entry()] if group == "hognose.exports" else [])
    extensions.added.cache_clear()
    try:
        assert list(formats()) == [*before, ".mine"]
    finally:
        extensions.added.cache_clear()


def test_two_formats_of_one_suffix_are_refused(plan, adds, tmp_path):
    adds(mine=Export(".csv", "mine", lambda plan: b""))
    with pytest.raises(hognose.InputError, match=r"'csv' and 'mine' both write \.csv; uninstall"):
        export(plan, tmp_path / "plan.json")
    adds(one=Export(".x", "mine", lambda plan: b""), other=Export(".x", "mine", lambda plan: b""))
    with pytest.raises(hognose.InputError, match=r"'one' and 'other' both write \.x"):
        formats()


def test_what_is_no_format_is_refused(adds):
    adds(mine=lambda plan: b"")
    with pytest.raises(hognose.InputError, match=r"'mine' is function, expected a hognose\.files\.exports\.Export"):
        formats()


@pytest.mark.parametrize("suffix", ["csv", ".", "", ".CSV", ".tar.gz", ".a b", 7])
def test_a_suffix_is_a_dot_and_small_letters(suffix):
    with pytest.raises(hognose.InputError, match="suffix: expected a dot and small letters"):
        Export(suffix, "mine", lambda plan: b"")


def test_what_makes_models_of_tasks_or_robots_is_a_function():
    for name in ("of_task", "of_robot"):
        with pytest.raises(hognose.InputError, match=f"{name}: expected a function or None, got str"):
            Export(".mine", "mine", lambda plan: b"", **{name: "text"})  # pyright: ignore[reportArgumentType]


def test_a_format_may_write_files_beside_its_own_and_say_more(plan, adds, tmp_path):
    content = Content(b"main", {"parts/one.bin": b"one"}, ("nothing is missing",))
    adds(mine=Export(".mine", "mine", lambda plan: content, of_robot=lambda robot: Content(robot.name.encode())))
    done = export(plan, tmp_path / "plan.mine")
    assert (done.beside, done.remarks) == ((tmp_path / "parts" / "one.bin",), ("nothing is missing",))
    assert ((tmp_path / "plan.mine").read_bytes(), done.beside[0].read_bytes()) == (b"main", b"one")
    assert export(plan.robot, tmp_path / "arm.mine").plan is None
    assert (tmp_path / "arm.mine").read_bytes() == b"sjtu-25dof"


def test_two_formats_of_one_name_are_refused(adds):
    adds(mjcf=Export(".mine", "mine", lambda plan: b""))
    with pytest.raises(hognose.InputError, match="'mjcf' is there twice"):
        formats()


def _silent(plan):
    raise Silent


@pytest.mark.parametrize(
    ("write", "reason"),
    [
        (lambda plan: "text", "made str, expected bytes"),
        (lambda plan: plan.nothing, "fails: AttributeError: "),
        (_silent, "fails: Silent$"),
    ],
)
def test_a_format_that_fails_writes_nothing_and_is_named(plan, adds, tmp_path, write, reason):
    adds(mine=Export(".mine", "mine", write))
    with pytest.raises(hognose.InputError, match=rf"the format \.mine, which another package adds, {reason}"):
        export(plan, tmp_path / "plan.mine")
    assert not list(tmp_path.iterdir())
