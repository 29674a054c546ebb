"""What is seen of the twin behind emulated drives: pictures and contacts, in this program or in processes of their own."""

import io
import time

import numpy as np
import pytest
from PIL import Image

import hognose
from hognose.cli.operate import Asked, operate
from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.network import emulated_network
from hognose.drive.record import read_record
from hognose.sim import Changes, Twin
from hognose.studies.rehearsal import Rehearsal, TwinPlant
from hognose.studies.senses import DistantSenses, TipCamera, TwinSenses, contact_of

#: Nothing here depends on how a processor rounds.
pytestmark = pytest.mark.slow
#: So long (s) a process may take to start on any machine.
LONG = 120.0


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


def test_a_picture_is_taken_every_so_often(plan):
    senses = TwinSenses(TwinPlant(plan, emulated_network(plan.robot)).twin, TipCamera(plan), every=0.5)
    taken = [picture.time for now in np.arange(0.0, 2.0, 0.1) for picture in senses.look(float(now)).pictures]
    np.testing.assert_allclose(taken, [0.0, 0.5, 1.0, 1.5])


def test_what_stands_in_the_way_is_felt_and_named(plan):
    board = plan.task.scene.names[0]
    twin = Twin(plan.task, Changes(shifted={board: (0.0, 0.02, 0.0)}))
    plant = TwinPlant(plan, emulated_network(plan.robot), twin)
    counts, feed = plan.motor_counts.astype(float), plan.feed * 1e6
    felt = None
    for step in range(1, 60):
        plant.move(counts[step], float(feed[step]), 0.15)
        felt = felt or contact_of(twin)
    assert felt is not None
    assert felt.words.endswith(f"is pressed by {board}")
    assert felt.force > 0.0


def test_pictures_of_the_twin_in_another_process_come_back(plan, tmp_path):
    file = tmp_path / "plan.parquet"
    plan.save(file)
    process = EmulatorProcess(Rehearsal(file))
    senses = DistantSenses(process, file, every=0.0)
    try:
        pictures, end = [], time.monotonic() + LONG
        while len(pictures) < 2:
            assert time.monotonic() < end, "no picture came"
            pictures += senses.look(time.monotonic()).pictures
            time.sleep(0.01)
    finally:
        senses.close()
        process.close()
    with Image.open(io.BytesIO(pictures[0].jpeg)) as picture:
        assert picture.size == (320, 240)
    assert not senses._process.is_alive()
    expected = TwinSenses(TwinPlant(plan, emulated_network(plan.robot)).twin, TipCamera(plan)).look(0.0).pictures[0]
    with Image.open(io.BytesIO(expected.jpeg)) as one, Image.open(io.BytesIO(pictures[0].jpeg)) as other:
        assert np.abs(np.asarray(one).astype(int) - np.asarray(other)).mean() < 2.0


def test_a_contact_brings_a_run_to_rest_along_its_path(plan, tmp_path, monkeypatch, capsys):
    file, record, board = tmp_path / "plan.parquet", tmp_path / "run.mcap", plan.task.scene.names[0]
    plan.save(file)
    whole = TwinPlant.__init__

    def among_others(self, plan, network, twin=None):
        whole(self, plan, network, Twin(plan.task, Changes(shifted={board: (0.0, 0.02, 0.0)})))

    monkeypatch.setattr(TwinPlant, "__init__", among_others)
    asked = Asked(str(file), (None, True, True, True), (80.0, False, False, False), 100.0, record, None, True, False)
    assert operate(asked) == 1
    said = capsys.readouterr().out
    assert f"is pressed by {board} with " in said
    assert "HELD  at step " in said
    ended = read_record(record)
    assert ended.verdict is not None
    assert "contact: link " in ended.verdict
    assert len(ended.images) > 1
