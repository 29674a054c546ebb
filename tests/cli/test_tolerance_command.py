"""`hognose tolerance`: the budget of every link, in words and as JSON."""

import json

import pytest

import hognose


def test_it_prints_the_budget_of_every_link_and_what_dominates(run):
    done = run("tolerance", "tolerances")
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert lines[0] == "tolerances: what tolerances take of the clearance of each link, mm, where they take most"
    rows = [line.split() for line in lines if line.split()[:1] and line.split()[0].isdigit()]
    assert [row[0] for row in rows] == [str(link) for link in range(1, 13)]
    taken = [float(row[-3]) for row in rows]
    assert taken == sorted(taken)
    assert "At the tip calibration 0.1° (assumed) is 8.1 of the 11.1 mm that tolerances take." in lines
    assert lines[-1].startswith("GOOD")


def test_json_is_in_si_units_and_says_what_is_assumed(run):
    done = run("tolerance", "tolerances", "--json", "--draws", "500", "--seed", "7")
    said = json.loads(done.out)
    assert said["good"] is True
    assert said["assumed"] == ["cable_zero", "calibration_deg", "sag"]
    assert said["draws"]["count"] == 500
    plan = hognose.plan(hognose.load_task("tolerances"))
    assert said["certified_clearance_m"] == pytest.approx(plan.certified_clearance, abs=1e-12)
    tip = said["links"][-1]
    assert tip["taken_m"] == pytest.approx(0.01107, abs=1e-5)
    assert plan.task.budget is not None
    assert set(tip["parts_m"]) == set(plan.task.budget.given)
    assert min(link["left_m"] for link in said["links"]) == pytest.approx(plan.check("clearance_at_steps").value)


def test_a_task_without_tolerances_is_told_where_they_go(run):
    done = run("tolerance", "obstacle-array")
    assert done.code == 2
    assert "neither the task nor its robot has tolerances. Give them in a table [tolerance]" in done.err


@pytest.mark.parametrize("count", ["0", "2000000"])
def test_a_number_of_draws_that_makes_no_sense_is_refused(run, count):
    assert run("tolerance", "tolerances", "--draws", count).code == 2
