"""What `hognose log` says is what happened."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from record_makers import NETWORK, START, row_at, write

from hognose.drive.record import RecordWriter, read_record
from hognose.drive.record.chart import chart
from hognose.drive.record.planned import Planned, compare
from hognose.drive.record.summary import summary
from hognose.errors import InputError


def recorded(plan, file, rows):
    with RecordWriter(file, plan, NETWORK, START) as writer:
        for row in rows:
            writer.cycle(row)
    return read_record(file)


def run(plan, places):
    return [row_at(plan, 0.05 * k, "RUN", place, k) for k, place in enumerate(places)]


def test_the_whole_plan_is_followed_exactly(plan, tmp_path):
    last = len(plan.time) - 1
    places = [step + share / 4 for step in range(last) for share in range(4)] + [float(last)]
    found = summary(recorded(plan, tmp_path / "run.mcap", run(plan, places)))
    compared = found.compared
    assert (compared.first, compared.last, compared.reached, compared.exact) == (0, last, last + 1, last + 1)
    assert compared.missing == ()
    assert 0.3 < compared.off <= 0.5
    assert compared.slider_off is not None
    assert compared.slider_off < 1e-15
    assert compared.follows
    assert f"commands at {last + 1} of {last + 1} steps, 0 to {last}, are exactly the plan's" in compared.words
    assert found.same_plan
    other = summary(found.record, replace(plan, motor_counts=plan.motor_counts + 1))
    assert not other.same_plan
    assert (other.compared.exact, other.compared.off) == (0, pytest.approx(1.5))
    assert "not the one that was run" in other.remarks[-1]


@pytest.mark.parametrize("way", [1, -1])
def test_one_count_off_at_one_step_is_found(plan, tmp_path, way):
    rows = run(plan, [k / 2 for k in range(21)])
    counts = rows[8].commanded.copy()
    counts[17] += way
    rows[8] = rows[8]._replace(commanded=counts)
    compared = compare(recorded(plan, tmp_path / "run.mcap", rows).cycles, Planned.of(plan))
    assert (compared.reached, compared.exact) == (11, 10)
    assert (compared.off, compared.off_cable, compared.off_time) == (1.0, 17, pytest.approx(0.4))
    assert not compared.follows
    assert "cable 18 at 0.40 s" in compared.words


def test_a_step_that_was_left_out_is_found(plan, tmp_path):
    places = [k / 2 for k in range(21) if k not in (8, 12)]
    compared = compare(recorded(plan, tmp_path / "run.mcap", run(plan, places)).cycles, Planned.of(plan))
    assert (compared.reached, compared.exact, compared.missing) == (9, 9, (4, 6))
    assert not compared.follows
    assert "2 steps were left out, the first is 4" in compared.words


def test_commands_before_and_after_the_run_are_not_the_plans(plan, tmp_path):
    rows = [row._replace(state="TENSION", commanded=row.commanded + 999) for row in run(plan, [0.0] * 5)]
    record = recorded(plan, tmp_path / "run.mcap", rows)
    assert compare(record.cycles, Planned.of(plan)).words == "no command of the plan was sent"
    assert not compare(record.cycles, Planned.of(plan)).follows
    with pytest.raises(InputError, match="the plan has 35 cables, but the record 36"):
        compare(record.cycles, Planned(plan.time, plan.feed, plan.motor_counts[:, 1:]))


def test_figures_are_the_worst_of_all_cycles_and_cables(made):
    found = summary(read_record(made.file))
    rows = made.rows
    assert found.duration == rows[-1].time
    assert found.states == (("HOLD", pytest.approx(0.5)), ("RUN", pytest.approx(1.45)))
    late = [row.lateness for row in rows]
    assert found.lateness == (np.median(late), np.quantile(late, 0.999), max(late))
    for worst, name, pick in (
        (found.following, "following", lambda values: np.abs(values).max()),
        (found.largest_current, "currents", lambda values: np.abs(values).max()),
        (found.least_tension, "tensions", np.min),
        (found.largest_tension, "tensions", np.max),
    ):
        assert worst is not None
        values = np.array([getattr(row, name) for row in rows])
        assert abs(worst.value) == pick(values)
        row = next(row for row in rows if row.time == worst.time)
        assert abs(getattr(row, name)[worst.cable]) == abs(worst.value)
        assert worst.step == row.progress


def test_what_was_not_measured_has_no_figure(plan, tmp_path):
    rows = [
        row._replace(
            state="HOLD",
            tensions=row.tensions * np.nan,
            slider_commanded=np.nan,
            slider_measured=np.nan,
            progress=np.nan,
            lateness=np.nan,
        )
        for row in run(plan, [0.0, 0.5, 1.0])
    ]
    found = summary(recorded(plan, tmp_path / "run.mcap", rows))
    assert (found.least_tension, found.largest_tension, found.compared.slider_off) == (None, None, None)
    assert found.lateness is None
    assert found.following is not None
    assert found.following.step is None
    assert "step" not in found.following.where
    assert "tension" not in " ".join(name for name, *_ in found.rows)
    assert json.loads(json.dumps(found.to_json(), allow_nan=False))["least_tension_N"] is None


def test_a_record_without_a_cycle_has_a_summary(plan, tmp_path):
    record = read_record(write(plan, tmp_path / "run.mcap", 0, None).file)
    found = summary(record)
    assert (found.lateness, found.following, found.states, found.duration) == (None, None, (), 1.8)
    assert found.verdict == "none, as the program that ran the plan did not end it"
    said = json.loads(json.dumps(found.to_json(), allow_nan=False))
    assert (said["cycles"], said["verdict"], said["finished"]) == (0, None, True)
    chart(record)


def test_the_chart_shows_all_cables_and_events(made):
    figure = chart(read_record(made.file))
    top, middle, low = figure.axes
    assert len(middle.lines) == len(low.lines) == 36 + 2  # an event is a line across
    np.testing.assert_array_equal(top.lines[0].get_ydata(), [row.progress for row in made.rows])
    np.testing.assert_array_equal(middle.lines[5].get_ydata(), [row.tensions[5] for row in made.rows])
    np.testing.assert_array_equal(low.lines[5].get_ydata(), [row.following[5] for row in made.rows])
    assert [text.get_text() for text in top.texts] == ["HOLD", "RUN"]


def test_a_damaged_plan_in_the_record_is_said(made):
    record = read_record(made.file)
    with pytest.raises(InputError, match=r"the plan in the record is damaged.*--plan"):
        summary(replace(record, plan_file=record.plan_file[:5000]))
