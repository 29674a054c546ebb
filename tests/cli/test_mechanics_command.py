"""`hognose mechanics`: what the cables must pull, in words, as JSON and as a figure."""

import json

import numpy as np
import pytest

import hognose
from hognose.planning.loads import loads


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


def test_it_prints_a_table_and_the_verdict(run):
    done = run("mechanics", "obstacle-array")
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert lines[0] == "obstacle array: will the arm hold it?"
    rows = {line.split("  ")[0]: line.split() for line in lines if "  " in line}
    assert rows["largest tension"][-4:] == ["91.2", "91.2", "312", "N"]
    assert rows["load factor of buckling"][-3:-1] == ["4.56", "4.04"]
    assert any(line.startswith("Assumed, not known: cables.") for line in lines)
    assert lines[-1].startswith("GOOD")


def test_json_has_every_step_in_si_units(run, plan):
    done = run("mechanics", "obstacle-array", "--json")
    said = json.loads(done.out)
    assert said["good"] is True
    found = loads(plan)
    np.testing.assert_allclose(said["largest_tension_N"]["at_steps"], plan.held.tensions.max(axis=1), rtol=1e-12)
    np.testing.assert_allclose(said["uncompensated_sag_m"]["at_steps"], found.sag, rtol=0, atol=1e-9)
    assert said["buckling_load_factor"]["worst"] == pytest.approx(plan.held.load_factor.min(), rel=1e-8)
    assert 0.0045 < said["uncompensated_sag_m"]["worst"] < 0.006
    assert 0.0018 < said["tip_by_cable_zeros_m"]["worst"] < 0.0025


def test_it_draws_a_figure(run, tmp_path):
    for suffix, begin in ((".png", b"\x89PNG"), (".svg", b"<?xml")):
        done = run("mechanics", "obstacle-array", "--figure", f"forces{suffix}", "--json")
        assert json.loads(done.out)["file"] == f"forces{suffix}"
        assert (tmp_path / f"forces{suffix}").read_bytes().startswith(begin)
    assert run("mechanics", "obstacle-array", "--figure", "forces.pdf").code == 2


def test_a_robot_without_cables_is_told_what_to_give(run, tmp_path):
    text = hognose.files.loading.robot_text("sjtu-25dof").decode()
    start, end = text.index("[cables]"), text.index("[[section]]")
    (tmp_path / "bare.toml").write_text(text[:start].replace('"cables", ', "") + text[end:])
    task = hognose.files.bundled_tasks()["obstacle-array"].read_text()
    (tmp_path / "task.toml").write_text(task.replace('"sjtu-25dof"', '"bare.toml"'))
    done = run("mechanics", "task.toml")
    assert done.code == 2
    assert "the robot file has no table [cables]; give axial_stiffness_N" in done.err


def test_steps_at_which_the_arm_would_collapse_are_counted(plan):
    from dataclasses import replace

    soft = {"axial_stiffness_N": 25e3, "load_factor_min": 1.0}
    cables = plan.robot.spec.cables.model_copy(update=soft)
    robot = hognose.Robot.from_spec(plan.robot.spec.model_copy(update={"cables": cables}))
    found = loads(replace(plan, task=hognose.Task(plan.task.spec, robot)))
    assert "Without compensation the arm would collapse at" in found.sentences[0]


def test_where_no_tensions_hold_the_arm_no_figures_are_shown(plan):
    from dataclasses import replace

    from hognose.planning.loads import in_a_line
    from hognose.report import mechanics as chart

    cables = plan.robot.spec.cables.model_copy(update={"tension_max_N": 60.0})
    other = replace(
        plan,
        task=hognose.Task(
            plan.task.spec, hognose.Robot.from_spec(plan.robot.spec.model_copy(update={"cables": cables}))
        ),
    )
    held = other.held.is_held
    assert held.any()
    assert not held.all()
    found = loads(other)
    first, lost = str(int(np.argmin(held))), np.count_nonzero(~held)
    for _, arrived, worst, step, _ in found.rows:
        assert (arrived, worst, step) == ("not held", "not held", first)
    assert found.sentences[0] == f"No tensions hold the arm at {lost} of {len(held)} steps."
    assert in_a_line(other) == f"no tensions hold the arm at {lost} of {len(held)} steps"
    for figure in found.to_json().values():
        assert (figure["worst"], figure["step"]) == (None, int(first))
        assert [value is None for value in figure["at_steps"]] == (~held).tolist()
    for axes in chart.mechanics(found).axes:
        for line in axes.lines:
            drawn = np.asarray(line.get_ydata(), np.float64)
            if len(drawn) == len(held):
                np.testing.assert_array_equal(np.isnan(drawn), ~held)
    nowhere = replace(found, held=replace(found.held, status=np.ones_like(found.held.status)))
    assert all(row[1] == "not held" for row in nowhere.rows)
    chart.mechanics(nowhere)
    unstable = found.sensitivity.zero.copy()
    unstable[held] = np.nan
    shown = replace(found, sensitivity=replace(found.sensitivity, zero=unstable)).figures[5]
    assert shown.words(int(np.argmax(held)), True) == "–"
