"""A file that a person names is a file: devices, pipes and sockets, which may never end, are not opened."""

import os
import socket
from pathlib import Path

import pytest

import hognose
from hognose.errors import InputError
from hognose.files.inspection import inspect
from hognose.read_whole import read_whole
from hognose.scene import Mesh, Points


@pytest.fixture
def others(tmp_path, monkeypatch):
    """What is no file, by what it is said to be."""
    monkeypatch.chdir(tmp_path)  # a socket's name must be short
    os.mkfifo("pipe")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        os.symlink("pipe", "link")
        (tmp_path / "folder").mkdir()
        yield {
            "pipe": "a named pipe", "link": "a named pipe", "socket": "a socket", "/dev/zero": "a device",
            "/dev/null": "a device", "folder": "a folder",
        }  # fmt: skip


def test_what_is_no_file_is_refused_unopened(others, monkeypatch):
    def opened(*given):
        raise AssertionError(given)

    monkeypatch.setattr(os, "open", opened)
    for name, kind in others.items():
        with pytest.raises(InputError) as caught:
            read_whole(name, 1000, "a plan file")
        assert str(caught.value) == f"{name}: is {kind}, expected a plan file"


READERS = {
    "task": (hognose.load_task, ".toml"),
    "robot": (hognose.load_robot, ".toml"),
    "plan": (hognose.Plan.load, ".parquet"),
    "mesh": (lambda name: Mesh(file=name, units="mm").geometry, ".stl"),
    "scan": (lambda name: Points(file=name, units="mm", diameter=0.01).geometry, ".xyz"),
    "step": (lambda name: Mesh(file=name).geometry, ".step"),
    "inspected": (inspect, ".ply"),
    "inspected task": (inspect, ".toml"),
}


@pytest.mark.parametrize("what", list(READERS))
def test_every_reader_refuses_a_pipe_and_a_device(what, tmp_path):
    """Opening the pipe would wait for ever, reading the device would not end."""
    reader, suffix = READERS[what]
    pipe, device = tmp_path / f"pipe{suffix}", tmp_path / f"device{suffix}"
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    for name, kind in ((pipe, "a named pipe"), (device, "a device")):
        with pytest.raises(InputError, match=f"{name}: is {kind}, expected"):
            reader(str(name))


def test_a_file_comes_back_whole(tmp_path):
    data = os.urandom(200_000)
    (tmp_path / "file").write_bytes(data)
    assert read_whole(tmp_path / "file", len(data)) == data
    (tmp_path / "link").symlink_to("file")
    assert read_whole(str(tmp_path / "link"), len(data)) == data
    (tmp_path / "empty").touch()
    assert read_whole(tmp_path / "empty", 0) == b""


def test_a_larger_file_is_refused_unread(tmp_path):
    with (tmp_path / "file").open("wb") as file:
        file.truncate(3_000_000)
    with pytest.raises(InputError, match=r"file: 3 MB is too large \(at most 2 MB\); make it coarser"):
        read_whole(tmp_path / "file", 2_000_000, too_large="make it coarser")


@pytest.mark.parametrize("name", ["/proc/self/environ", "/proc/kmsg", "/proc/self/pagemap"])
def test_files_without_a_size_are_not_read(name):
    """They say that they are regular files of no bytes."""
    assert not Path(name).exists() or read_whole(name, 1000) == b""


def test_a_circle_of_links_and_missing_files_are_said(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(InputError, match="a: cannot read: Too many levels"):
        read_whole(tmp_path / "a", 1000)
    for name in ("none", "none/file"):
        with pytest.raises(InputError, match=f"{name}: no such file"):
            read_whole(tmp_path / name, 1000)
    with pytest.raises(InputError, match=r"cannot read: .*embedded null"):
        read_whole("a\0b", 1000)


@pytest.mark.parametrize("change", ["grown", "rewritten"])
def test_a_file_that_is_written_to_meanwhile_is_not_half_one_half_the_other(change, tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.write_bytes(b"a" * 1000)
    really = os.fstat

    def changing(descriptor):
        found = really(descriptor)
        data = b"b" * (1000 if change == "rewritten" else 2000)
        file.write_bytes(data)
        os.utime(file, ns=(0, 0))
        return found

    monkeypatch.setattr(os, "fstat", changing)
    with pytest.raises(InputError, match="file: was written to while it was read; try again"):
        read_whole(file, 5000)


def test_a_pipe_that_takes_the_place_of_a_file_is_not_waited_for(tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.write_bytes(b"a")
    really = os.open

    def late(path, flags):
        file.unlink()
        os.mkfifo(file)
        return really(path, flags)

    monkeypatch.setattr(os, "open", late)
    with pytest.raises(InputError, match="file: is a named pipe, expected a file"):
        read_whole(file, 1000)
