"""Columns that Hognose does not know are kept, or refused with a reason."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plan_file_makers import rewritten
from planning_makers import assert_same_cells, outcome, variant

import hognose
from hognose.files import export
from hognose.plain_text import is_plain
from hognose.planning import Plan, retraction
from hognose.planning.columns import columns_of
from hognose.planning.extra_columns import LONGEST_NAME, LONGEST_TEXT, MOST_EXTRA


@pytest.fixture(scope="module")
def small(tasks) -> Plan:
    """A plan of five rows."""
    made = hognose.plan(variant(tasks["pipe-tank"], {"motion.step": 0.3, "motion.period_s": 30.0}))
    assert len(made.time) == 5
    return made


def with_extra(plan: Plan, **extra: object) -> Plan:
    return dataclasses.replace(plan, extra=extra)


THREE = {
    "operator_note": np.array(["", "a,b", 'said "go"', "two\nlines", "Ä 🐍"], dtype=object),
    "temperature_degC": np.array([-0.0, 5e-324, 1 / 3, 1e300, 21.5]),
    "encoder, raw": np.array([-(2**63), 2**63 - 1, 0, 1, -1]),
}


@pytest.fixture(scope="module")
def noted(small) -> Plan:
    return dataclasses.replace(small, extra=THREE)


def test_they_come_back_bit_for_bit_and_are_named(noted, tmp_path):
    noted.save(tmp_path / "plan.parquet")
    read = Plan.load(tmp_path / "plan.parquet")
    assert_same_cells(read, noted)
    assert list(read.extra) == list(THREE)
    assert read.good
    assert read.checks == noted.checks
    told = "3 columns that Hognose does not know are kept: operator_note, temperature_degC, encoder, raw"
    assert told in read.remarks
    assert f"note: {told}" in read.summary()
    read.save(tmp_path / "again.parquet")
    assert (tmp_path / "again.parquet").read_bytes() == (tmp_path / "plan.parquet").read_bytes()


def test_csv_has_them(noted, tmp_path):
    export(noted, tmp_path / "plan.csv")
    with (tmp_path / "plan.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header[-3:] == list(THREE)
    assert [row[-3] for row in rows] == THREE["operator_note"].tolist()
    assert np.array([float(row[-2]) for row in rows]).tobytes() == THREE["temperature_degC"].tobytes()
    assert [int(row[-1]) for row in rows] == THREE["encoder, raw"].tolist()


def test_json_has_them(noted, tmp_path):
    export(noted, tmp_path / "plan.json")
    columns = json.loads((tmp_path / "plan.json").read_text())["columns"]
    assert list(columns)[-3:] == list(THREE)
    for name, values in THREE.items():
        assert columns[name] == values.tolist()


@given(data=st.data())
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_is_written_comes_back(small, tmp_path, data):
    name = data.draw(st.text(max_size=90))
    kind = st.one_of(st.just(st.integers(-(2**63), 2**63 - 1)), st.just(st.floats()), st.just(st.text(max_size=20)))
    cells = data.draw(st.lists(data.draw(kind), min_size=5, max_size=5))
    dtype = object if isinstance(cells[0], str) else np.int64 if isinstance(cells[0], int) else np.float64
    plan = dataclasses.replace(small, extra={name: np.array(cells, dtype=dtype)})
    made = outcome(lambda: plan.save(tmp_path / "plan.parquet"))
    if made is None:
        assert_same_cells(Plan.load(tmp_path / "plan.parquet"), plan)
    else:
        assert isinstance(made, hognose.InputError)
        bad_name = not name.strip() or len(name) > 80 or not is_plain(name)
        bad_text = not all(is_plain(cell, lines=True) for cell in cells if isinstance(cell, str))
        assert bad_name or bad_text or not all(np.isfinite(cell) for cell in cells if isinstance(cell, float))


def test_texts_of_numpy_and_lists_are_texts(small, tmp_path):
    with_extra(small, note=["a", "b", "", "d", "e"]).save(tmp_path / "plan.parquet")
    assert Plan.load(tmp_path / "plan.parquet").extra["note"].tolist() == ["a", "b", "", "d", "e"]


def test_texts_of_other_programs_are_texts(small, tmp_path):
    small.save(tmp_path / "plan.parquet")
    cells = pa.array(["a"] * 5, pa.large_string())
    (tmp_path / "large.parquet").write_bytes(
        rewritten(tmp_path / "plan.parquet", lambda table: table.append_column("note", cells))
    )
    assert Plan.load(tmp_path / "large.parquet").extra["note"].tolist() == ["a"] * 5


CELLS = {"text": pa.array(["a"] * 5), "numbers": pa.array([1.5] * 5), "whole numbers": pa.array([1] * 5)}


@pytest.mark.parametrize("kind", list(CELLS))
def test_one_without_its_digest_is_an_alteration(small, tmp_path, kind):
    small.save(tmp_path / "plan.parquet")
    altered = rewritten(tmp_path / "plan.parquet", lambda t: t.append_column("note", CELLS[kind]), sealed=False)
    (tmp_path / "altered.parquet").write_bytes(altered)
    with pytest.raises(
        hognose.InputError, match=r"column 'note' has no digest\. .*docs/plan-file\.md.*the file was altered"
    ):
        Plan.load(tmp_path / "altered.parquet")


@pytest.mark.parametrize("digests", [[], {}, {"columns": []}, {"hognose": "", "columns": []}, {"columns": {}}])
def test_digests_of_another_form_are_an_alteration(small, tmp_path, digests):
    small.save(tmp_path / "plan.parquet")
    entry = {b"hognose.sha256": json.dumps(digests).encode()}
    altered = rewritten(tmp_path / "plan.parquet", change_entries=lambda held: held.update(entry))
    (tmp_path / "altered.parquet").write_bytes(altered)
    with pytest.raises(hognose.InputError, match="does not hold the digests: the file was altered"):
        Plan.load(tmp_path / "altered.parquet")


@pytest.mark.parametrize("name", list(THREE))
def test_a_changed_or_lost_cell_is_an_alteration(noted, tmp_path, name):
    noted.save(tmp_path / "plan.parquet")
    index = pq.read_schema(tmp_path / "plan.parquet").names.index(name)

    def shuffled(table):
        return table.set_column(index, name, pa.chunked_array([table[name].take([1, 0, 2, 3, 4]).combine_chunks()]))

    for change in (shuffled, lambda table: table.drop_columns([name])):
        (tmp_path / "altered.parquet").write_bytes(rewritten(tmp_path / "plan.parquet", change, sealed=False))
        with pytest.raises(hognose.InputError, match="the file was altered"):
            Plan.load(tmp_path / "altered.parquet")


def test_digests_of_texts_tell_where_one_ends(small, tmp_path):
    with_extra(small, note=["ab", "c", "", "", ""]).save(tmp_path / "plan.parquet")
    index = pq.read_schema(tmp_path / "plan.parquet").names.index("note")
    moved = pa.array(["a", "bc", "", "", ""])
    (tmp_path / "moved.parquet").write_bytes(
        rewritten(tmp_path / "plan.parquet", lambda t: t.set_column(index, "note", moved), sealed=False)
    )
    with pytest.raises(hognose.InputError, match="column 'note'"):
        Plan.load(tmp_path / "moved.parquet")


ALIKE = [
    "joint_13_x_m", "joint_1_x_m", "JOINT_00_X_M", "motor_37_counts", "Feed_m", "FEED M", "feed-m", " time_s",
    "time_s_", "alpha_3_rad", "\uff46eed_m", "cable_037_m", "clearance_00_m", "deviation_13_m",
]  # fmt: skip
NOT_ALIKE = ["times", "feed_mm", "my_feed_m", "joint_speed", "stress_01_N", "gamma_01_rad", "alpha"]


@pytest.mark.parametrize("name", ALIKE)
def test_a_name_that_looks_like_one_of_ours_is_refused_in_files_and_in_python(small, tmp_path, name):
    assert name not in {column.name for column in columns_of(small.robot)}
    with pytest.raises(hognose.InputError, match=r"column '.*' is unknown: .* looks like '"):
        with_extra(small, **{name: [1.0] * 5}).save(tmp_path / "plan.parquet")
    small.save(tmp_path / "plan.parquet")
    altered = rewritten(tmp_path / "plan.parquet", lambda table: table.append_column(name, pa.array([1.0] * 5)))
    (tmp_path / "altered.parquet").write_bytes(altered)
    with pytest.raises(hognose.InputError, match=r"column '.*' is unknown: .* looks like '"):
        Plan.load(tmp_path / "altered.parquet")


@pytest.mark.parametrize("name", NOT_ALIKE)
def test_another_name_is_kept(small, tmp_path, name):
    with_extra(small, **{name: [1.0] * 5}).save(tmp_path / "plan.parquet")
    assert list(Plan.load(tmp_path / "plan.parquet").extra) == [name]


def test_a_column_of_ours_is_no_further_one(small, tmp_path):
    with pytest.raises(hognose.InputError, match="column 'feed_m' of `extra` is known as one of 'feed_m', but is"):
        with_extra(small, feed_m=[1.0] * 5).save(tmp_path / "plan.parquet")


BAD_NAMES = ["", " ", "x" * (LONGEST_NAME + 1), "a\nb", "a\tb", "a\x00b", "\u202eabc", "\ud800"]


@pytest.mark.parametrize("name", BAD_NAMES)
def test_a_name_that_cannot_be_kept_is_refused(small, tmp_path, name):
    with pytest.raises(hognose.InputError, match="its name cannot be kept: expected 1 to 80 letters"):
        with_extra(small, **{name: [1.0] * 5}).save(tmp_path / "plan.parquet")
    assert not list(tmp_path.iterdir())


#: Cells as another program may write them, or a script; None where Parquet or NumPy has none such.
BAD_CELLS = {
    "not finite": (pa.array([1.0, np.nan, 3, 4, 5]), np.array([1.0, np.nan, 3, 4, 5]), "not finite"),
    "single precision": (pa.array([1.0] * 5, pa.float32()), np.ones(5, np.float32), "holds float"),
    "32 bits": (pa.array([1] * 5, pa.int32()), np.ones(5, np.int32), "holds int32"),
    "truth values": (pa.array([True] * 5), np.ones(5, bool), "holds bool"),
    "lists": (pa.array([[1.0]] * 5), np.ones((5, 1)), "holds list|shape"),
    "several types": (None, np.array([1, "a", 2.0, "b", "c"], dtype=object), "several types"),
    "empty cells": (pa.array(["a", None, "b", "c", "d"]), np.array(["a", None, "b", "c", "d"]), "empty|several"),
    "long texts": (pa.array(["x" * (LONGEST_TEXT + 1)] * 5), np.array(["x" * (LONGEST_TEXT + 1)] * 5), "too long"),
    "control characters": (pa.array(["\x1b[2J"] * 5), np.array(["\x1b[2J"] * 5), "control characters"),
    "bytes": (pa.array([b"a"] * 5), np.array([b"a"] * 5), "holds (binary|.S1)"),
    "dates": (pa.array(np.arange(5).astype("M8[s]")), np.arange(5).astype("M8[s]"), "holds (timestamp|datetime)"),
    "fewer": (None, np.ones(4), "one for each step"),
}


@pytest.mark.parametrize("kind", list(BAD_CELLS))
def test_cells_that_cannot_be_kept_are_refused_with_the_reason(small, tmp_path, kind):
    arrow, numpy, reason = BAD_CELLS[kind]
    with pytest.raises(hognose.InputError, match=f"column 'mine' .*({reason})"):
        with_extra(small, mine=numpy).save(tmp_path / "plan.parquet")
    if arrow is not None:
        small.save(tmp_path / "plan.parquet")
        changed = rewritten(tmp_path / "plan.parquet", lambda table: table.append_column("mine", arrow))
        (tmp_path / "changed.parquet").write_bytes(changed)
        with pytest.raises(hognose.InputError, match=f"column 'mine' .*({reason})"):
            Plan.load(tmp_path / "changed.parquet")


def test_text_that_is_not_utf_8_is_refused(small, tmp_path):
    small.save(tmp_path / "plan.parquet")
    raw = pa.array([b"\xff"] * 5).view(pa.string())
    (tmp_path / "raw.parquet").write_bytes(
        rewritten(tmp_path / "plan.parquet", lambda table: table.append_column("mine", raw), sealed=False)
    )
    with pytest.raises(hognose.InputError, match="not UTF-8"):
        Plan.load(tmp_path / "raw.parquet")


def test_there_may_be_so_many_and_no_more(small, tmp_path):
    extra = {f"mine {k}": np.arange(5) for k in range(MOST_EXTRA)}
    dataclasses.replace(small, extra=extra).save(tmp_path / "plan.parquet")
    assert "mine 0, mine 1, mine 2, mine 3, mine 4 and 251 more" in Plan.load(tmp_path / "plan.parquet").summary()
    with pytest.raises(hognose.InputError, match="257 columns that Hognose does not know; it keeps 256 at most"):
        dataclasses.replace(small, extra=extra | {"more": np.arange(5)}).save(tmp_path / "more.parquet")


def test_a_column_twice_is_refused(noted, tmp_path):
    noted.save(tmp_path / "plan.parquet")
    twice = rewritten(
        tmp_path / "plan.parquet", lambda table: table.append_column("temperature_degC", table["temperature_degC"])
    )
    (tmp_path / "twice.parquet").write_bytes(twice)
    with pytest.raises(hognose.InputError, match="column 'temperature_degC' appears 2 times"):
        Plan.load(tmp_path / "twice.parquet")


def test_the_way_out_has_none_of_the_insertion(noted):
    assert not retraction(noted).extra


def test_check_notes_them(noted, tmp_path: Path, monkeypatch, capfd):
    from hognose.cli import main

    monkeypatch.chdir(tmp_path)
    noted.save("plan.parquet")
    with pytest.raises(SystemExit) as ended:
        main(["check", "plan.parquet"])
    assert ended.value.code == 0
    assert "3 columns that Hognose does not know are kept: operator_note" in capfd.readouterr().out
    with pytest.raises(SystemExit):
        main(["check", "plan.parquet", "--json"])
    assert any("does not know" in remark for remark in json.loads(capfd.readouterr().out)["remarks"])
