"""The whole experiment on a few steps: calibrated, commanded, reached, seen, recorded and judged."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import hognose
from hognose.cli import demo
from hognose.cli import experiment as command
from hognose.drive.network import emulated_network
from hognose.drive.record import read_record
from hognose.sim import Changes, Twin
from hognose.studies import whole_experiment as studied
from hognose.studies.experiment_charts import reached
from hognose.studies.experiment_page import PAGE, write_page
from hognose.studies.there_and_back import planned_at, there_and_back
from hognose.studies.way_figures import TIP_RMS, figures
from hognose.studies.whole_experiment import whole_experiment

#: Nothing here depends on how a processor rounds.
pytestmark = pytest.mark.slow
FAR = 6.0


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder, gone = tmp_path_factory.mktemp("experiment"), []
    found = whole_experiment(folder, ["obstacle-array"], 0, FAR, lambda *steps: gone.append(steps))
    return found, gone


@pytest.fixture(scope="module")
def files(made):
    found, _ = made
    return {file.name: file for file in (write_page(found), *found.save())}


def test_the_tip_is_where_it_must_be_in_and_out(made):
    found, gone = made
    [case] = found.cases
    assert [(way.name, way.place[0] < way.place[-1], way.trouble) for way in case.ran.ways] == [
        ("in", True, ""),
        ("out", False, ""),
    ]
    assert (found.good, found.left, case.ran.trouble) == (True, (), "")
    for way in case.ran.ways:
        assert 1e-6 < way.tip_rms <= TIP_RMS
        assert way.compared.exact == way.compared.reached == int(FAR) + 1
        # A second way to the same figure: at the end of every cycle, of the steps alone.
        whole = way.place == np.rint(way.place)
        planned = case.ran.plan.body[way.place[whole].astype(int), -1]
        np.testing.assert_allclose(np.linalg.norm(way.joints[whole, -1] - planned, axis=1), way.tip_errors[whole])
    assert gone[-1] == (2 * FAR, 2 * FAR)
    assert [steps for steps, _ in gone] == sorted(steps for steps, _ in gone)


def test_what_is_hidden_is_found_and_made_up_for(made):
    found, _ = made
    [case], arm = found.cases, found.arm
    fit = arm.calibration.fit
    assert np.abs(fit.zeros - arm.hidden.zeros).max() < 0.1 * np.abs(arm.hidden.zeros).max()
    assert case.before.max() > 20 * case.after.max()
    # The drives are told other counts than the plan's, the record has the plan's.
    assert np.any(case.ran.network.zeros != 0)
    assert (case.ran.ways[0].cycles.commanded[0] == case.ran.plan.motor_counts[0]).all()


def test_without_its_calibration_the_arm_is_not_even_moved(made, boards, tmp_path):
    bare = made[0].arm.uncalibrated
    plan = hognose.plan(bare.task(boards.task))
    ran = there_and_back(plan, bare.network(plan), bare.twin(boards.task), tmp_path / "a.mcap", FAR)
    assert ran.ways == ()
    assert " N, planned are " in ran.trouble
    assert ran.record.verdict == f"NOT GOOD: {ran.trouble}"
    [case] = made[0].cases
    assert replace(case, ran=ran).troubles == [f"obstacle array: {ran.trouble}"]


def test_pictures_of_the_tip_camera_are_in_the_record_and_decode(made):
    [case] = made[0].cases
    record = read_record(case.ran.record.path)
    shown = [image for way in case.ran.ways for image in way.images]
    assert 2 <= len(shown) <= len(record.images)
    for image in record.images:
        with Image.open(io.BytesIO(image.jpeg)) as picture:
            assert picture.size == (320, 240)
            assert np.asarray(picture).std() > 5.0  # boards in the light of the lamp, not darkness
    assert record.verdict == "GOOD: at step 0"


def test_the_page_has_its_figures_and_needs_nothing_else(made, files):
    [case] = made[0].cases
    text = files[PAGE].read_text()
    assert '<p class="verdict good" role="status"><strong>Good.</strong>The tip is off its plan by 0.0' in text
    for way in case.ran.ways:
        assert all(figure.shown.replace(">", "&gt;") in text for figure in figures(case.ran, way))
    assert "✗" not in text
    assert text.count("<img") == 4
    assert "http" not in text.replace("http://www.w3.org", "")
    assert "network: drives.newton_per_unit" in text
    assert all((made[0].folder / name).is_file() for name in _linked(text))


def _linked(text):
    return [part.split('"', 1)[0] for part in text.split('<a href="')[1:]]


def test_figures_are_in_files(made, files):
    [case] = made[0].cases
    told = json.loads(files["experiment.json"].read_text())
    assert told["good"]
    assert [way["way"] for way in told["cases"][0]["ways"]] == ["in", "out"]
    rows = list(csv.DictReader(io.StringIO(files["experiment.csv"].read_text())))
    cycles = list(csv.DictReader(io.StringIO(files["experiment-obstacle-array-in.csv"].read_text())))
    errors = np.array([float(cycle["tip_error_m"]) for cycle in cycles])
    for rms in (float(rows[0]["tip_rms_m"]), told["cases"][0]["ways"][0]["tip_rms_m"]):
        assert rms == pytest.approx(np.sqrt((errors**2).mean()))
    assert len(cycles) == len(case.ran.ways[0].cycles)


def test_a_missed_bound_is_said(made):
    found, _ = made
    [case] = found.cases
    way = case.ran.ways[0]
    off = replace(way, tip_errors=way.tip_errors + 2e-4, contact=3.0)
    worse = replace(case, ran=replace(case.ran, ways=(off, case.ran.ways[1])))
    first, second = worse.troubles
    assert first.startswith("obstacle array, in: tip off its plan, RMS: 0.2")
    assert first.endswith(" mm, must be ≤ 0.1 mm")
    assert second == "obstacle array, in: contact: 3.0 N, must be 0 N"
    bad = studied.Experiment(found.folder, 0, ("obstacle-array", "pipe-tank"), found.arm, [worse])
    assert bad.verdict == f"NOT GOOD: {first}; {second}; pipe-tank: not run"


def test_a_board_in_the_way_stops_the_way_in_along_its_path(boards, tmp_path):
    # Board 2 stands right behind board 1, where it has no hole.
    twin = Twin(boards.task, Changes(shifted={"board 2": (0.0, 0.0, -0.33)}))
    ran = there_and_back(boards, emulated_network(boards.robot), twin, tmp_path / "a.mcap", 30.0)
    [way] = ran.ways
    assert way.trouble.startswith("contact: link 12 is pressed by board 2 with ")
    assert 6.0 < way.place[-1] < 20.0
    assert way.contact > 1.0
    assert abs(np.diff(way.place)[-2]) < np.abs(np.diff(way.place)).max() / 3  # it slowed down
    assert ran.record.verdict == f"NOT GOOD: {way.trouble}"


def test_the_motion_that_was_reached_is_drawn_as_the_twin_was(made):
    [case] = made[0].cases
    motion = reached(case.ran.plan, case.ran.ways[0])
    assert len(motion.time) == int(FAR) + 1
    assert np.linalg.norm(motion.body[:, -1] - case.ran.plan.body[: int(FAR) + 1, -1], axis=1).max() < 5e-4
    np.testing.assert_allclose(motion.clearance.min(), case.ran.ways[0].clearance.min(), atol=2e-4)


def test_between_steps_values_are_linear():
    values = np.array([[0.0, 1.0], [2.0, 3.0], [6.0, 5.0]])
    np.testing.assert_allclose(planned_at(values, np.array([0.0, 0.5, 1.25, 2.0])), [[0, 1], [1, 2], [3, 3.5], [6, 5]])


@pytest.mark.parametrize("as_json", [False, True])
def test_the_command_says_what_came_of_it(made, tmp_path, monkeypatch, capsys, as_json):
    asked = []

    def done_before(folder, seed, progress, said, done):
        asked.append((folder, seed))
        said("calibrated")
        done(made[0])
        return made[0]

    monkeypatch.setattr(studied, "whole_experiment", done_before)
    assert demo.demo(output=tmp_path, experiment=True, seed=7, json=as_json) == 0
    assert asked == [(tmp_path, 7)]
    out = capsys.readouterr().out
    if as_json:
        told = json.loads(out)
        assert (told["good"], told["verdict"]) == (True, made[0].verdict)
        assert str(made[0].folder / PAGE) in told["files"]
    else:
        assert out.startswith("calibrated\n")
        assert out.endswith(f"{made[0].verdict}\n")


def test_an_interruption_leaves_the_cases_that_are_done(made, tmp_path, monkeypatch):
    def interrupted(folder, seed, progress, said, done):
        done(replace_folder(made[0], folder))
        raise KeyboardInterrupt

    monkeypatch.setattr(studied, "whole_experiment", interrupted)
    with pytest.raises(KeyboardInterrupt, match=r"interrupted; the cases that were done are in .*experiment\.html"):
        command.experiment(tmp_path, 0, True)
    assert "Not complete." in (tmp_path / PAGE).read_text()


def replace_folder(found, folder):
    return studied.Experiment(folder, found.seed, (*found.wanted, "pipe-tank"), found.arm, found.cases)
