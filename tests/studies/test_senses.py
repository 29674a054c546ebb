"""What is seen of the twin behind emulated drives: pictures and contacts, in this program or in other processes."""

import io
import time

import numpy as np
import pytest
from PIL import Image

import hognose
from hognose.cli.operate import Asked, operate
from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.emulator import Emulator
from hognose.drive.emulator.process import EmulatorProcess
from hognose.drive.local_bus import local_bus
from hognose.drive.motions import counts_of
from hognose.drive.network import emulated_network
from hognose.drive.record import read_record
from hognose.drive.recorded_run import RecordedRun
from hognose.drive.settings import Settings
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


def in_the_way(plan):
    """A twin whose first board stands 35 mm higher than planned: its hole leaves 27 mm to the arm."""
    return Twin(plan.task, Changes(shifted={"board 1": (0.0, 0.035, 0.0)}))


def test_what_stands_in_the_way_is_felt_and_named(plan):
    twin = in_the_way(plan)
    plant = TwinPlant(plan, emulated_network(plan.robot), twin)
    assert contact_of(twin) is None  # nothing was integrated yet
    found = []
    for _ in range(20):
        plant.move(plan.motor_counts[0].astype(float), float(plan.feed[0]) * 1e6, 0.05)
        found.append(contact_of(twin))
    felt = [each for each in found if each is not None]
    assert {each.words for each in felt} <= {f"link {k} is pressed by board 1" for k in range(1, 13)}
    assert 1.0 < max(each.force for each in felt) < 50.0


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
        while (tip := senses.tip()) is None:
            assert time.monotonic() < end, "nobody says where the tip is"
        process._process.kill()  # its drives are silent then, which is told: senses have nothing to say
        process._process.join(LONG)
        for now in (end, end + 1.0):
            assert senses.look(now).contact is None
        assert senses.tip() is None
        senses._pipe.close()  # as if the program that runs the plan were killed
        senses._process.join(LONG)
        assert not senses._process.is_alive()
    finally:
        senses.close()
        process.close()
    with Image.open(io.BytesIO(pictures[0].jpeg)) as picture:
        assert picture.size == (320, 240)
    np.testing.assert_allclose(tip, plan.body[0, -1], atol=1e-4)
    expected = TwinSenses(TwinPlant(plan, emulated_network(plan.robot)).twin, TipCamera(plan)).look(0.0).pictures[0]
    with Image.open(io.BytesIO(expected.jpeg)) as one, Image.open(io.BytesIO(pictures[0].jpeg)) as other:
        assert np.abs(np.asarray(one).astype(int) - np.asarray(other)).mean() < 2.0


def test_after_a_contact_the_way_back_is_open_and_the_way_in_is_not(plan, tmp_path):
    # Board 2 stands right behind board 1, where it has no hole.
    network = emulated_network(plan.robot)
    twin = Twin(plan.task, Changes(shifted={"board 2": (0.0, 0.0, -0.33)}))
    clock, plant = SimulatedClock(), TwinPlant(plan, network, twin)
    bus = local_bus(Emulator(network, plant, counts_of(plan, network)[0].tolist()), clock)
    file, senses = tmp_path / "run.mcap", TwinSenses(twin, TipCamera(plan))
    run, places = RecordedRun(plan, network, bus, clock, file, Settings(), senses=senses), []
    executor = run.executor
    run.at_cycle.append(lambda cycle: places.append(cycle.set_point.place))
    with run.writer:
        executor.arm()
        executor.hold()
        executor.tension()
        first = executor.run(30.0)
        again = executor.run(30.0)
        pressed, back = contact_of(twin), executor.run(0.0)
        in_again = executor.run(1.0)
    for outcome in (first, again):
        assert outcome.trouble is not None
        assert outcome.trouble.words.startswith("contact: link 12 is pressed by board 2 with ")
    assert again.place == first.place  # nothing was sent: drives would go through what they have got
    assert pressed is not None
    assert pressed.force > 5.0
    assert (back.trouble, back.place) == (None, 0.0)
    assert (in_again.trouble, in_again.place, contact_of(twin)) == (None, 1.0, None)
    assert max(places) == first.place


def test_a_contact_ends_a_run_before_it_goes_along_the_plan(plan, tmp_path, monkeypatch, capsys):
    file, record = tmp_path / "plan.parquet", tmp_path / "run.mcap"
    plan.save(file)
    whole = TwinPlant.__init__
    monkeypatch.setattr(
        TwinPlant, "__init__", lambda self, plan, network, twin=None: whole(self, plan, network, in_the_way(plan))
    )
    asked = Asked(
        str(file), (None, True, True, True), (80.0, False, False, False, False), 100.0, record, (), None, True, False
    )
    with pytest.raises(hognose.InfeasibleError, match=r"contact: link \d+ is pressed by board 1 with [\d.]+ N"):
        operate(asked)
    assert "RUN" not in capsys.readouterr().out
    assert read_record(record).images
