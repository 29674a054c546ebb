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
    assert "At the tip calibration 0.1° (assumed) is 8.1 of the 10.7 mm that tolerances take." in lines
    assert any(
        line.startswith("Of cable 3 at step 312, cable zeros 0.03 mm (assumed) take 9.2 N; 0.") for line in lines
    )
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
    assert tip["taken_m"] == pytest.approx(0.01066, abs=1e-5)
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


def test_timing_alone_is_a_budget_and_its_lines_are_printed(run):
    done = run("tolerance", "moving-obstacles")
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert lines[0] == "moving obstacles: what the timing of moving obstacles takes of the clearance to them"
    assert lines[2].startswith("hatch: timing 0.5 s takes ")
    assert lines[3].startswith("wheel: timing 0.02 s takes ")
    assert lines[4].startswith("GOOD")
    said = run("tolerance", "moving-obstacles", "--json").json
    assert (said["links"], said["draws"]) == ([], None)
    assert [each["obstacle"] for each in said["timing"]] == ["hatch", "wheel"]
    assert min(each["left_m"] for each in said["timing"]) >= said["certified_clearance_m"]


def test_timing_is_not_spoken_of_where_nothing_moves(run, tmp_path):
    assert "mov" not in run("tolerance", "pipe-tank").err.replace("remove", "")
    (tmp_path / "a.toml").write_text(FREE.replace("calibration_deg = 0.01", "timing_s = 0.1").replace("cad = 2", ""))
    done = run("tolerance", "a.toml")
    assert done.code == 2
    assert "timing_s is that of obstacles that move, and none does" in done.err


FREE = """
name = "free"
units = "mm"
robot = "sjtu-25dof"
[path]
way_points = [[0, 0, 0], [30, 95, 430], [-60, -50, 1000]]
[tolerance]
calibration_deg = 0.01
cad = 2
[[obstacle]]
kind = "sphere"
center = [300, 0, 0]
diameter = 40
"""


def test_what_is_farther_than_was_measured_is_a_lower_bound(run, tmp_path):
    """Nothing comes closer than the horizon of 50 mm; 2 mm of it are the drawing's."""
    (tmp_path / "a.toml").write_text(FREE)
    done = run("tolerance", "a.toml")
    rows = [line.split() for line in done.out.splitlines() if line.split()[:1] and line.split()[0].isdigit()]
    assert [row[-2] for row in rows] == ["≥"] * 12
    assert "≥: farther is not measured." in done.out
    assert "99% stay ≥ 48.00 mm away (farther is not measured)." in done.out
    assert "closer than 4" not in done.out
    said = run("tolerance", "a.toml", "--json").json
    assert all(link["left_is_lower_bound"] for link in said["links"])
    assert set(said["draws"]["quantiles_are_lower_bounds"].values()) == {True}
    (tmp_path / "b.toml").write_text(FREE.replace("[300, 0, 0]", "[100, 60, 300]"))
    done = run("tolerance", "b.toml", "--json").json
    assert not any(done["draws"]["quantiles_are_lower_bounds"].values())
    assert {link["left_is_lower_bound"] for link in done["links"]} == {True, False}


def test_what_no_tolerances_are_known_of_is_not_told_to_have_some(run):
    done = run("tolerance", "baffled-tank")
    assert done.code == 2
    assert "known for straight links; the sections of metabot-3arc" in done.err
    assert "calibration_deg" not in done.err
