"""Files are written whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hognose
from hognose.write_whole import write_together, write_whole

OLD, NEW = b"what stood there", b"what comes"
FAILURES = [errno.ENOSPC, errno.EIO, errno.EDQUOT]


@pytest.fixture
def target(tmp_path) -> Path:
    file = tmp_path / "plan.parquet"
    file.write_bytes(OLD)
    return file


def assert_untouched(target: Path) -> None:
    assert target.read_bytes() == OLD
    assert [file.name for file in target.parent.iterdir()] == [target.name]


@given(data=st.binary(max_size=10_000))
@settings(max_examples=20, deadline=None)
def test_what_is_written_is_read(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("whole")
    for content in (data, data[::-1]):
        write_whole(folder / "file", content)
        assert (folder / "file").read_bytes() == content
        assert len(list(folder.iterdir())) == 1


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("call", ["fsync", "replace", "chmod"])
def test_a_write_that_fails_leaves_the_old_file_and_no_other(target, monkeypatch, call, failure):
    def fails(*arguments: object) -> None:
        raise OSError(failure, os.strerror(failure))

    monkeypatch.setattr(os, call, fails)
    with pytest.raises(hognose.InputError) as caught:
        write_whole(target, NEW)
    assert str(caught.value) == f"{target}: cannot write: {os.strerror(failure)}. Nothing was written."
    assert_untouched(target)


def test_an_interrupted_write_leaves_the_old_file_and_no_other(target, monkeypatch):
    def interrupted(descriptor: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(target, NEW)
    assert_untouched(target)


def test_nothing_is_seen_before_it_is_on_the_disk(target, monkeypatch):
    seen: list[bytes] = []
    really = os.fsync

    def watched(descriptor: int) -> None:
        seen.append(target.read_bytes())
        assert os.fstat(descriptor).st_size == len(NEW)
        really(descriptor)

    monkeypatch.setattr(os, "fsync", watched)
    write_whole(target, NEW)
    assert seen == [OLD]
    assert target.read_bytes() == NEW


FULL_DISK = """
import os, resource, signal, sys
from hognose.write_whole import write_together, write_whole
from hognose import InputError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    write_whole(sys.argv[1], bytes(100_000))
except InputError as error:
    sys.exit(str(error))
"""


def test_a_disk_without_room_is_told_and_leaves_the_old_file(target):
    """The system itself refuses to write more than 1000 bytes."""
    done = subprocess.run([sys.executable, "-c", FULL_DISK, str(target)], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.strip() == f"{target}: cannot write: {os.strerror(errno.EFBIG)}. Nothing was written."
    assert_untouched(target)


@pytest.mark.parametrize("folder", ["missing", "/proc", "/dev/full", "/dev/null/below"])
def test_a_folder_that_cannot_be_written_says_so(tmp_path, folder):
    place = tmp_path / folder / "file"
    with pytest.raises(hognose.InputError, match=r"file: cannot write: .*Nothing was written"):
        write_whole(place, NEW)
    assert not list(tmp_path.iterdir())


def test_a_folder_in_the_way_says_so(tmp_path):
    (tmp_path / "file").mkdir()
    with pytest.raises(hognose.InputError, match="file: is not a regular file; nothing was written"):
        write_whole(tmp_path / "file", NEW)
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]
    assert not list((tmp_path / "file").iterdir())


@pytest.mark.parametrize("name", ["n" * 255, "ü" * 127, "é" * 60 + ".parquet", ".hidden", "a b\nc", "-o"])
def test_any_name_the_system_takes_will_do(tmp_path, name):
    write_whole(tmp_path / name, NEW)
    assert (tmp_path / name).read_bytes() == NEW
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("name", ["n" * 256, "a\0b", ""])
def test_a_name_the_system_does_not_take_is_told(tmp_path, name):
    with pytest.raises(hognose.InputError, match=r"cannot write|is not a regular file"):
        write_whole(f"{tmp_path}/{name}", NEW)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("mask", [0o000, 0o022, 0o027, 0o077])
def test_permissions_are_those_the_umask_leaves(tmp_path, mask):
    before = os.umask(mask)
    try:
        write_whole(tmp_path / "file", NEW)
        assert os.umask(mask) == mask
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o666 & ~mask


def test_a_link_stays_a_link(tmp_path, target):
    (tmp_path / "link").symlink_to(target)
    write_whole(tmp_path / "link", NEW)
    assert (tmp_path / "link").is_symlink()
    assert target.read_bytes() == NEW


@pytest.mark.parametrize("special", ["/dev/null", "/dev/full"])
def test_a_device_is_never_replaced(special):
    before = os.stat(special)
    with pytest.raises(hognose.InputError, match="is not a regular file"):
        write_whole(special, NEW)
    assert os.stat(special) == before


def test_a_bare_name_goes_into_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_whole("bare", NEW)
    assert (tmp_path / "bare").read_bytes() == NEW


def test_a_plan_that_cannot_be_saved_leaves_the_old_one(boards, target, monkeypatch):
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(hognose.InputError, match="No space left on device"):
        boards.save(target)
    assert_untouched(target)


def test_what_killed_runs_have_left_is_swept_and_nothing_else(target):
    folder = target.parent
    day = 24 * 3600.0
    stay = [".other.abcdefgh.hognose-part", f".{target.name}.abcdefgh", f"{target.name}.hognose-part", ".gitignore"]
    for name in (f".{target.name}.left0001.hognose-part", *stay):
        (folder / name).write_bytes(b"x")
        os.utime(folder / name, (0, time.time() - 1.1 * day))
    (folder / f".{target.name}.writing1.hognose-part").write_bytes(b"of a run that goes on")
    write_whole(target, NEW)
    assert {file.name for file in folder.iterdir()} == {target.name, f".{target.name}.writing1.hognose-part", *stay}


BESIDE = {"meshes/a.obj": b"a", "meshes/b.obj": b"b"}


def files_of(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_files_beside_another_come_before_it(tmp_path, monkeypatch):
    order = []
    replace = os.replace
    monkeypatch.setattr(os, "replace", lambda old, new: (order.append(Path(new).name), replace(old, new)))
    write_together(tmp_path / "model.urdf", NEW, BESIDE)
    assert order == ["a.obj", "b.obj", "model.urdf"]
    assert files_of(tmp_path) == {"model.urdf": NEW, **BESIDE}
    write_together(tmp_path / "model.urdf", OLD, BESIDE)
    assert order[3:] == ["model.urdf"]  # what is there already is not written again
    (tmp_path / "meshes" / "a.obj").write_bytes(b"cut")
    write_together(tmp_path / "other.urdf", NEW, BESIDE)
    assert files_of(tmp_path) == {"model.urdf": OLD, "other.urdf": NEW, **BESIDE}


@pytest.mark.parametrize("fails_at", ["b.obj", "model.urdf"])
def test_where_one_of_several_files_fails_nothing_new_is_left(tmp_path, monkeypatch, fails_at):
    replace = os.replace

    def fails(old, new):
        if Path(new).name == fails_at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(old, new)

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises(hognose.InputError, match="No space left on device"):
        write_together(tmp_path / "model.urdf", NEW, BESIDE)
    assert not list(tmp_path.iterdir())
    (tmp_path / "meshes").mkdir()
    (tmp_path / "model.urdf").write_bytes(OLD)
    (tmp_path / "meshes" / "a.obj").write_bytes(b"a")
    with pytest.raises(hognose.InputError, match="No space left on device"):
        write_together(tmp_path / "model.urdf", NEW, BESIDE)
    assert files_of(tmp_path) == {"model.urdf": OLD, "meshes/a.obj": b"a"}


def test_a_folder_beside_a_file_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "meshes").write_bytes(OLD)
    with pytest.raises(hognose.InputError, match=r"meshes: cannot write: File exists\. Nothing was written\."):
        write_together(tmp_path / "model.urdf", NEW, BESIDE)
    assert files_of(tmp_path) == {"meshes": OLD}
