"""What the twin reached as a motion, its pictures, and the rows of the experiment's page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image, ImageSequence

from hognose.errors import InputError, MissingExtraError
from hognose.report import animation
from hognose.report.animation import Film, gif
from hognose.report.tip_camera import tip_picture
from hognose.sim import Changes, simulate
from hognose.studies import experiment, pictures, reached
from hognose.studies.charts import body_errors, run_over_time, tip_off_path
from hognose.studies.shifts import Shifted

pytestmark = pytest.mark.slow
UP = Changes(shifted={"board 2": (0.0, 0.045, 0.0)})


@pytest.fixture(scope="module")
def good(boards):
    done = simulate(boards)
    return experiment.Run("obstacle-array", done, reached(done))


@pytest.fixture(scope="module")
def caught(boards):
    done = simulate(boards, UP)
    return done, reached(done)


def test_the_motion_is_where_the_twin_was(good, caught):
    for done, motion in ((good.done, good.motion), caught):
        assert len(motion.time) == len(done.angles)
        np.testing.assert_array_equal(motion.joints, done.joints)
        np.testing.assert_allclose(motion.body, done.joints, atol=1e-9)
        np.testing.assert_array_equal(motion.cable_lengths, motion.robot.cable_lengths(motion.angles))
        assert motion.checks == ()
    # Angles of the log are one integration step of 2 ms ahead of its joints.
    np.testing.assert_allclose(good.motion.angles, good.done.angles, atol=1e-3)
    np.testing.assert_allclose(good.motion.feed, good.done.plan.feed, atol=1e-6)
    np.testing.assert_allclose(good.motion.clearance, good.done.plan.clearance, atol=0.3e-3)


def test_the_board_stands_where_it_was_shifted_to(boards, caught):
    done, motion = caught
    moved = motion.scene.triangles - boards.scene.triangles
    number = boards.scene.names.index("board 2")
    np.testing.assert_allclose(moved[boards.scene.owner == number] - [0, 0.045, 0], 0, atol=1e-12)
    assert not moved[boards.scene.owner != number].any()
    touched = done.contact.max(axis=1) > 0
    assert motion.clearance[touched].min() < 0 < motion.clearance[: np.flatnonzero(touched)[0]].min()


def test_errors_agree_with_each_other(good, caught):
    for done, motion in ((good.done, good.motion), caught):
        assert (body_errors(done) >= done.tip_errors).all()
        # The plan's tip is on the path.
        assert (tip_off_path(motion) <= done.tip_errors + 1e-6).all()
        assert len(run_over_time(done, motion).axes) == 2


def test_instants_end_where_the_motion_ends(good):
    assert pictures.instants_of(good.motion) == [0, 22, 34, 46]
    columns = ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")
    short = replace(good.motion, **{name: getattr(good.motion, name)[:200] for name in columns})
    assert pictures.instants_of(short) == [0, 22, short.time[-1]]


def test_a_shift_tells_when_how_hard_and_how_it_ended(good, caught):
    rows = experiment.shift_rows([Shifted(0.0, good.done), Shifted(0.045, caught[0])])
    assert rows[0][:3] == ("0", "none", "")
    assert rows[0][-1] == "at the target"
    assert rows[1][0] == "45"
    assert 15.0 < float(rows[1][1]) < 18.0
    assert float(rows[1][2]) > 5.0
    assert float(rows[1][3]) < float(rows[1][4])
    tables = experiment.error_rows([good]), experiment.paper_rows([good, good])
    assert all(all(row) for table in tables for row in table)


def test_the_camera_is_laid_into_a_corner_and_nothing_else_changes(good):
    size = (320, 180)
    alone, both = (next(Film(1, size=size, shows=shows).drawn(good.motion, None)) for shows in ("arm", "both"))
    rows, columns = np.nonzero((alone != both).any(axis=2))
    assert columns.max() < size[0] / 3
    inset = tip_picture(good.motion, 0, animation._corner_size(size))
    top, left = rows.min() + 1, columns.min() + 1
    np.testing.assert_array_equal(both[top : top + inset.shape[0], left : left + inset.shape[1]], inset)
    [picture] = Film(1, size=(80, 64), shows="camera").drawn(good.motion, None)
    np.testing.assert_array_equal(picture, tip_picture(good.motion, 0, (80, 64)))


@pytest.mark.parametrize("shows", ["camera", "both"])
def test_few_colours_show_what_the_camera_sees(good, shows, tmp_path):
    (tmp_path / "film.gif").write_bytes(gif(good.motion, Film(3, size=(160, 96), shows=shows)))
    with Image.open(tmp_path / "film.gif") as image:
        assert len([*ImageSequence.Iterator(image)]) == 3
        image.seek(0)
        shown = np.asarray(image.convert("RGB")).astype(int)
    [drawn] = Film(1, size=(160, 96), shows=shows).drawn(good.motion, None)
    assert np.abs(shown - drawn).mean() < 3


def test_files_are_written_by_their_endings(good, tmp_path, monkeypatch):
    calls = []

    def animate(motion, file, *, shows, **more):
        calls.append((file.name, shows))
        return file

    monkeypatch.setattr(pictures, "animate", animate)
    names = [(tmp_path / video, tmp_path / camera) for video, camera in (("a.gif", "b.png"), ("c.mp4", "d.gif"))]
    for video, camera in names:
        assert pictures.write_pictures(good.done, video, camera) == [video, camera]
    assert calls == [("a.gif", "both"), ("c.mp4", "both"), ("d.gif", "camera")]
    with Image.open(tmp_path / "b.png") as image:
        assert image.size[0] > 3 * image.size[1]


@pytest.mark.parametrize(
    ("video", "camera", "words"),
    [
        ("a.avi", None, r"a\.avi: a moving picture ends in \.gif or \.mp4"),
        (None, "b.jpg", r"b\.jpg: the camera's picture"),
    ],
)
def test_other_endings_are_refused(tmp_path, video, camera, words):
    with pytest.raises(InputError, match=words):
        pictures.refuse_names(*(None if name is None else tmp_path / name for name in (video, camera)))


def test_an_mp4_needs_its_package(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    pictures.refuse_names(tmp_path / "a.gif", tmp_path / "b.png")
    for names in ((tmp_path / "a.mp4", None), (None, tmp_path / "b.mp4")):
        with pytest.raises(MissingExtraError, match=r"pip install 'hognose\[sim\]'"):
            pictures.refuse_names(*names)
