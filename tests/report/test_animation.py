"""Moving pictures: as many frames, as large and as long as asked for, and whole or not at all."""

from __future__ import annotations

import sys
from io import BytesIO
from types import SimpleNamespace

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image, ImageSequence

from hognose.errors import InputError, MissingExtraError
from hognose.report import animation
from hognose.report.animation import Film, animate, caption, gif
from hognose.wording import at_least_mm

SMALL = (160, 96)


def read(data):
    with Image.open(BytesIO(data)) as image:
        frames = []
        for frame in ImageSequence.Iterator(image):
            frames.append((np.asarray(frame.convert("RGB")).astype(int), frame.info["duration"]))
        return image.size, image.info.get("loop"), frames


def test_a_gif_has_the_frames_the_size_and_the_duration_asked_for(boards, tmp_path):
    path = animate(boards, tmp_path / "motion.gif", frames=7, fps=10, size=SMALL)
    size, loop, frames = read(path.read_bytes())
    assert size == SMALL
    assert loop == 0
    assert len(frames) == 7
    assert [pause for _, pause in frames[:-1]] == [100] * 6
    assert frames[-1][1] > 100
    assert list(tmp_path.iterdir()) == [path]


def test_frames_of_a_gif_are_the_drawn_ones(boards):
    _, _, frames = read(gif(boards, Film(frames=3, size=SMALL)))
    drawn = list(animation.drawn_frames(boards, [0, 30, 60], SMALL))
    for (shown, _), pixels in zip(frames, drawn, strict=True):
        off = np.abs(shown - pixels)
        assert off.mean() < 3
        # The background is white to the bit, not nearly so.
        white = (pixels == 255).all(axis=2)
        assert (shown[white] == 255).all()
    assert np.abs(frames[0][0] - frames[2][0]).max() > 100


def test_no_more_frames_than_steps(tank):
    assert len(read(gif(tank, Film(frames=500, size=(80, 64))))[2]) == len(tank.time)


def test_progress_counts_every_frame(tank, tmp_path):
    calls = []
    animate(
        tank,
        tmp_path / "a.gif",
        frames=4,
        size=SMALL,
        progress=lambda done, total: calls.append((done, total)),
    )
    assert calls == [(1, 4), (2, 4), (3, 4), (4, 4)]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, RuntimeError])
def test_being_stopped_leaves_the_old_file_and_nothing_else(stop, tank, tmp_path):
    path = tmp_path / "motion.gif"
    path.write_bytes(b"old")

    def stopping(done, total):
        if done == 2:
            raise stop

    with pytest.raises(stop):
        animate(tank, path, frames=4, size=SMALL, progress=stopping)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "wish", "complaint"),
    [
        ("a.avi", {}, r"\.gif or \.mp4"),
        ("a", {}, r"\.gif or \.mp4"),
        ("a.gif", {"frames": 0}, "frames = 0"),
        ("a.gif", {"fps": 0}, "fps = 0"),
        ("a.gif", {"size": (10, 500)}, "10 × 500"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_drawn(name, wish, complaint, tank, tmp_path):
    with pytest.raises(InputError, match=complaint):
        animate(tank, tmp_path / name, **wish)
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_named(tank, tmp_path):
    with pytest.raises(InputError, match="nowhere"):
        animate(tank, tmp_path / "nowhere" / "a.gif", frames=2, size=SMALL)


def test_without_its_package_an_mp4_names_the_extra(tank, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtraError, match=r"hognose\[sim\]"):
        animate(tank, tmp_path / "a.mp4", frames=2, size=SMALL)
    assert not list(tmp_path.iterdir())


def test_an_mp4_is_given_every_frame_at_an_even_size(tank, tmp_path, monkeypatch):
    sent = []

    def write_frames(path, size, *, fps, **_):
        assert (size, fps) == ((160, 94), 12)
        try:
            while True:
                sent.append((yield))
        finally:
            with open(path, "wb") as file:
                file.write(b"film")

    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", SimpleNamespace(write_frames=write_frames))
    path = animate(tank, tmp_path / "a.mp4", frames=3, fps=12, size=(161, 95))
    assert path.read_bytes() == b"film"
    assert [frame.shape for frame in sent] == [(94, 160, 3)] * 3


# The reader of the test leaves pipes of its ffmpeg to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_real_mp4_reads_back_with_its_frames_and_size(tank, tmp_path):
    path = animate(tank, tmp_path / "a.mp4", frames=4, fps=12, size=(160, 96))
    frames = imageio_ffmpeg.read_frames(str(path))
    about = next(frames)
    assert about["size"] == (160, 96)
    assert about["fps"] == 12
    assert sum(1 for _ in frames) >= 4


def test_the_caption_tells_a_value_from_a_lower_bound(tank):
    step = int(np.argmin(tank.clearance.min(axis=1)))
    assert caption(tank, 0) == "t = 0.0 s    feed 0 mm    clearance ≥ 50 mm"
    assert f"clearance {at_least_mm(tank.clearance[step].min(), 1)} mm" in caption(tank, step)
