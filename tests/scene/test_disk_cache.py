"""What is kept on disk comes back bit for bit, and nothing that happens to it there is ever noticed."""

import os
import sys

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from import_makers import exported, written

from hognose.cache_folder import cache_folder, state_folder
from hognose.scene import Mesh, Scene, disk_cache, tree_cache
from hognose.scene.imports import reading

ARRAYS = {"a": np.arange(12.0).reshape(3, 4), "b": np.array([[1, -2]], np.int32), "none": np.empty((0, 3))}


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.fixture
def small_is_kept(monkeypatch):
    monkeypatch.setattr(tree_cache, "WORTH_KEEPING", 10)
    monkeypatch.setattr(reading, "_WORTH_KEEPING", 10)


def same(arrays, others):
    assert arrays.keys() == others.keys()
    for name, array in arrays.items():
        assert array.dtype == others[name].dtype
        np.testing.assert_array_equal(array, others[name])


def test_arrays_come_back_and_may_be_written(place):
    assert disk_cache.recall("k1") is None
    disk_cache.remember("k1", ARRAYS)
    back = disk_cache.recall("k1")
    assert back is not None
    same(back, ARRAYS)
    assert all(array.flags.writeable for array in back.values())
    assert [file.name for file in place.iterdir()] == ["k1.hognose"]


@given(data=st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_files_are_not_believed(data, place):
    disk_cache.remember("k2", ARRAYS)
    file = place / "k2.hognose"
    content = bytearray(file.read_bytes())
    way = data.draw(st.sampled_from(["cut", "flip", "more", "garbage"]))
    if way == "cut":
        content = content[: data.draw(st.integers(0, len(content) - 1))]
    elif way == "flip":
        content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    elif way == "more":
        content += b"x"
    else:
        content = bytearray(data.draw(st.binary(max_size=300)))
    file.write_bytes(content)
    back = disk_cache.recall("k2")
    if back is not None:  # blanks between the entries of the head mean nothing
        assert way in ("flip", "cut")
        same(back, ARRAYS)


def test_a_place_that_cannot_be_written_is_done_without(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "file" / "below"))
    disk_cache.remember("k3", ARRAYS)
    assert disk_cache.recall("k3") is None


def test_the_longest_unused_are_thrown_away(place, monkeypatch):
    big = {"a": np.zeros(10_000)}
    monkeypatch.setattr(disk_cache, "LARGEST_CACHE", 250_000)
    for number, key in enumerate(["old", "used", "new"]):
        disk_cache.remember(key, big)
        os.utime(place / f"{key}.hognose", (1000 + number, 1000 + number))
    assert disk_cache.recall("old") is not None
    disk_cache.remember("newest", big)
    assert {file.stem for file in place.iterdir()} == {"old", "new", "newest"}


def test_drafts_are_kept_where_the_platform_keeps_what_must_not_be_lost(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "both"))
    assert state_folder() == cache_folder() == tmp_path / "both"
    monkeypatch.delenv("HOGNOSE_CACHE")
    folders = {}
    for platform in ("linux", "darwin", "win32"):
        monkeypatch.setattr(sys, "platform", platform)
        folders[platform] = state_folder()
    assert folders["linux"] == tmp_path / "xdg" / "hognose"
    assert folders["darwin"] == tmp_path / "Library" / "Application Support" / "hognose"
    assert folders["win32"] == tmp_path / "AppData" / "Local" / "hognose"
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("XDG_STATE_HOME")
    assert state_folder() == tmp_path / ".local" / "state" / "hognose"
    monkeypatch.setenv("HOGNOSE_CACHE", "off")
    assert state_folder() is None


def test_the_folder_is_the_platforms_and_can_be_moved_or_switched_off(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.delenv("HOGNOSE_CACHE")
    folders = {}
    for platform in ("linux", "darwin", "win32"):
        monkeypatch.setattr(sys, "platform", platform)
        folders[platform] = cache_folder()
    assert folders["linux"] == tmp_path / "xdg" / "hognose"
    assert folders["darwin"] == tmp_path / "Library" / "Caches" / "hognose"
    assert folders["win32"] == tmp_path / "AppData" / "Local" / "hognose" / "cache"
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder() == tmp_path / ".cache" / "hognose"
    monkeypatch.setenv("HOGNOSE_CACHE", "OFF")
    assert cache_folder() is None
    disk_cache.remember("k4", ARRAYS)
    assert disk_cache.recall("k4") is None


@pytest.mark.usefixtures("small_is_kept")
def test_a_scene_from_the_cache_is_the_same_and_is_not_built(place, tmp_path, monkeypatch):
    ball = trimesh.creation.icosphere(3, 100)
    file = written(tmp_path, "stl", exported(ball, "stl"))
    item = Mesh(file=str(file), units="mm", position=(0.1, 0.2, 0.3), rotation_deg=(1, 2, 3))
    first = Scene.from_obstacles([item])
    assert first.tree is not None
    assert len(list(place.iterdir())) == 2
    with monkeypatch.context() as patch:
        patch.setattr(tree_cache, "build_tree", None)
        patch.setattr(reading, "repaired", None)
        again = Scene.from_obstacles([Mesh(**item.model_dump())])
    assert first.tree is not None
    assert again.tree is not None
    same(vars(first.tree), vars(again.tree))
    rng = np.random.default_rng(0)
    starts, ends = rng.uniform(-0.5, 0.5, (2, 50, 3))
    np.testing.assert_array_equal(first.distance(starts, ends).value, again.distance(starts, ends).value)
    for kept in place.iterdir():
        kept.write_bytes(b"damaged")
    same(vars(first.tree), vars(Scene.from_obstacles([Mesh(**item.model_dump())]).tree))

    moved = Scene.from_obstacles([Mesh(**{**item.model_dump(), "position": (0, 0, 0)})])
    assert not np.array_equal(moved.triangles, first.triangles)
    file.write_bytes(exported(trimesh.creation.icosphere(3, 50), "stl"))
    smaller = Mesh(**item.model_dump())
    assert np.ptp(smaller.triangles()[..., 0]) == pytest.approx(0.1, rel=0.02)


def test_what_killed_runs_have_left_is_swept_and_nothing_else(place):
    place.mkdir()
    names = [".0123456789abcdef.ab_1x9zq", ".0123456789abcdef.newonexx", "notes.txt", ".gitignore", ".k.a.b"]
    for name in names:
        (place / name).write_bytes(b"x")
        os.utime(place / name, (0, 0))
    os.utime(place / names[1])
    disk_cache.remember("k3", ARRAYS)
    assert {file.name for file in place.iterdir()} == {"k3.hognose", *names[1:]}
