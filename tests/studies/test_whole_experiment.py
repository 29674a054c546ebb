"""The whole experiment on a few steps: calibrated, commanded, reached, seen and recorded."""

import io

import numpy as np
import pytest
from PIL import Image

import hognose
from hognose.drive.senses import Contact, Picture, Sensed, Sensing
from hognose.studies.experiment_page import experiment_page
from hognose.studies.whole_experiment import experiment, verdict

#: Nothing here depends on how a processor rounds.
pytestmark = pytest.mark.slow
FAR = 6.0


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("experiment")
    seen = []
    made = experiment(
        "boards", hognose.load_task("obstacle-array"), folder, until=FAR, progress=lambda *said: seen.append(said)
    )
    return made, folder, seen


def test_the_tip_is_where_it_must_be_in_and_back(case):
    made, _, _ = case
    assert [(leg.name, leg.start, leg.end, leg.trouble) for leg in made.legs] == [
        ("in", 0, FAR, ""),
        ("back", FAR, 0, ""),
    ]
    assert made.good
    assert all(leg.rms <= 1e-4 for leg in made.legs)
    assert verdict([made]).startswith("GOOD: the tip is 0.0")
    assert made.zero_error < 0.1 * np.abs(made.hidden.zeros).max()


def test_all_of_it_is_recorded(case):
    made, folder, seen = case
    record = made.record
    assert record.verdict == "GOOD: at step 0"
    assert made.summary.compared.exact == made.summary.compared.reached == int(FAR) + 1
    assert len(record.images) >= 2
    for image in record.images:
        with Image.open(io.BytesIO(image.jpeg)) as picture:
            assert picture.size == (320, 240)
            assert np.asarray(picture).std() > 5.0  # boards in the light of the lamp, not darkness
    assert {file.name for file in folder.iterdir()} == {"boards.parquet", "boards.mcap", "boards-calibration.json"}
    shares = [share for share, _ in seen]
    assert shares == sorted(shares)
    assert "back, step 0" in {words for _, words in seen}


def test_the_page_has_its_figures(case):
    made, _, _ = case
    page = experiment_page([made])
    for leg in made.legs:
        assert f"{1e3 * leg.rms:.4f}" in page
    assert page.count("<img") == 2
    assert "http" not in page.replace("http://www.w3.org", "")
    assert "drives.newton_per_unit" in page


def test_without_its_calibration_the_arm_is_elsewhere(tmp_path):
    with pytest.raises(hognose.InfeasibleError, match=r"at step 0 of the plan: cable \d+ \(node \d+\): pulls"):
        experiment("boards", hognose.load_task("obstacle-array"), tmp_path, until=FAR, calibrates=False)


class Scripted:
    """Senses that feel what a test says, and an executor that is told to come to rest."""

    refuses, goes_back = False, False

    def __init__(self):
        self.force, self.refused, self.pictures = 0.0, [], []
        self.axes = self.clock = self

    def now(self):
        return 7.0

    def look(self, now):
        return Sensed((Picture(now, b"jpeg"),), Contact("link 3 is pressed by board 2", self.force))

    def image(self, time, jpeg):
        self.pictures.append((time, jpeg))

    def refuse_to_go_on(self, why):
        self.refused.append(why)
        self.refuses = True


def test_a_contact_stops_it_and_the_way_out_is_open():
    scripted = Scripted()
    sensing = Sensing(scripted, scripted, scripted)  # type: ignore[arg-type]

    def feel(*forces):
        for scripted.force in forces:
            sensing.cycle(None)  # type: ignore[arg-type]
        return len(scripted.refused)

    assert feel(0.2, 0.9) == 0
    assert feel(3.0) == 1
    assert scripted.refused == ["contact: link 3 is pressed by board 2 with 3.0 N"]
    assert feel(9.0, 8.0) == 1  # while it comes to rest
    scripted.refuses, scripted.goes_back = False, True  # the next motion
    assert feel(8.0, 9.0, 5.0, 2.0, 0.5) == 1
    assert feel(4.0) == 2  # it was free meanwhile
    scripted.refuses, scripted.goes_back = False, False
    assert feel(4.0) == 3  # deeper into it is no way
    assert scripted.pictures[0] == (7.0, b"jpeg")
