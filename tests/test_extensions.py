"""Entry points of other packages: what they add is there beside ours, and what cannot be used names its package."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from extension_makers import Silent, described
from hypothesis import given
from hypothesis import strategies as st

import hognose
from hognose.errors import InputError
from hognose.extensions import Table, added, home
from hognose.files import bundled_robots, load_robot
from hognose.files.loading import _ROBOTS
from hognose.following import METHODS, Follower
from hognose.following.exact import Exact

Install = Callable[..., None]
names = st.text("abcdefghijklmnopqrstuvwxyz-", min_size=1, max_size=8)


class Nearly(Exact):
    """As exact, under another name."""

    name = "nearly"


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Add a package whose entry points are values of this process, as if it was there when the process began."""
    module = ModuleType("added_here")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.syspath_prepend(tmp_path)
    for table in (METHODS, _ROBOTS):
        monkeypatch.setattr(table, "_entries", dict(table._entries))
        monkeypatch.setattr(table, "_whole", False)
    added.cache_clear()

    def installed(package: str, group: str, **entries: Any) -> None:
        for name, value in entries.items():
            setattr(module, f"{package}_{name}", value)
        values = {name.replace("_", "-"): f"{module.__name__}:{package}_{name}" for name in entries}
        described(tmp_path, package, "1.0", {f"hognose.{group}": values})

    yield installed
    added.cache_clear()


def test_a_package_adds_its_entries_behind_ours_in_every_group(install):
    before, robots = list(METHODS._entries), list(_ROBOTS._entries)
    install("one", "methods", nearly=Nearly)
    install("two", "robots", other=str(_ROBOTS._entries["sjtu-25dof"]))
    assert list(METHODS) == [*before, "nearly"]
    assert bundled_robots() == (*robots, "other")
    assert added("methods") == {"nearly": Nearly}
    assert added("nothing") == {}
    assert (home("methods", "nearly"), home("methods", "exact"), home("robots", "other")) == ("one", "hognose", "two")


def test_an_added_method_follows(install):
    install("one", "methods", nearly=Nearly)
    path = hognose.Path.through([[0, 0, 0], [0, 0, 0.3], [0, 0.1, 0.6]])
    for feeds in ([0.0, 0.1], [0.2]):
        joints = hognose.follow(path, [0.1, 0.1], feeds, "nearly")
        assert (joints == hognose.follow(path, [0.1, 0.1], feeds)).all()
    assert isinstance(hognose.follower(path, [0.1], "nearly"), Nearly)
    with pytest.raises(InputError, match=r"did you mean 'nearly'\? Methods: exact, .*, nearly, aim, fitted$"):
        hognose.follow(path, [0.1], [0.0], "nerly")


@pytest.mark.parametrize("kind", ["text", "path", "function"])
def test_an_added_robot_is_a_path_or_a_function_that_returns_one(install, kind):
    file = Path(_ROBOTS._entries["sjtu-25dof"])
    install("one", "robots", other={"text": str(file), "path": file, "function": lambda: file}[kind])
    assert load_robot("other").fingerprint == load_robot("sjtu-25dof").fingerprint
    with pytest.raises(InputError, match=r"Did you mean 'other'\? Bundled: sjtu-25dof, .*, other$"):
        load_robot("othr")


def test_a_robot_may_be_in_an_archive(install, tmp_path):
    import zipfile

    with zipfile.ZipFile(tmp_path / "pack.zip", "w") as archive:
        archive.write(_ROBOTS._entries["sjtu-25dof"], "robots/arm.toml")
    install("one", "robots", other=zipfile.Path(tmp_path / "pack.zip", "robots/arm.toml"))
    assert load_robot("other").fingerprint == load_robot("sjtu-25dof").fingerprint


def _raises() -> Path:
    raise RuntimeError("no arm today")


def _raises_silently() -> Path:
    raise Silent


@pytest.mark.parametrize(
    ("group", "entry", "value", "said"),
    [
        ("methods", "exact", Nearly, r"'exact' is there already: hognose has one, and one adds another"),
        ("methods", "other", Nearly, r"'other', which one adds, calls itself 'nearly'; .* must have one name"),
        ("methods", "none", "nearly", r"'none', which one adds, is not a subclass of hognose\.following\.Follower"),
        ("methods", "none", dict, r"is not a subclass of hognose\.following\.Follower"),
        ("methods", "bare", Follower, r"'bare', which one adds, calls itself None"),
        ("robots", "sjtu-25dof", "arm.toml", r"'sjtu-25dof' is there already: hognose has one, and one adds another"),
        ("robots", "arm", 7, r"'arm', which one adds, is not the path of a robot file"),
    ],
)
def test_what_is_none_of_a_table_names_package_group_and_entry(install, group, entry, value, said):
    install("one", group, **{entry.replace("-", "_"): value})
    table: Table[Any] = {"methods": METHODS, "robots": _ROBOTS}[group]
    for _ in range(2):  # it is no better the second time
        with pytest.raises(InputError, match=rf"^hognose\.{group}: .*{said}"):
            list(table)


@pytest.mark.parametrize(
    ("group", "value", "said"),
    [
        ("methods", 3, r"is not a subclass of hognose\.following\.Follower"),
        ("methods", Exact, r"calls itself 'exact'; the class and its entry point must have one name"),
        ("robots", 3, "is not the path of a robot file, a traversable, or a function that returns one"),
    ],
)
def test_what_is_none_of_a_table_cannot_be_put_into_it(install, group, value, said):
    table: Table[Any] = {"methods": METHODS, "robots": _ROBOTS}[group]
    before = dict(table)
    with pytest.raises(InputError, match=rf"^hognose\.{group}: 'foo' {said}"):
        table["foo"] = value
    assert dict(table) == before


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("missing.toml", r"missing\.toml: "),
        (_raises, "RuntimeError: no arm today"),
        (_raises_silently, "its function failed: Silent$"),
        (lambda: None, "its function returns no path of a robot file, but None"),
    ],
)
def test_a_robot_that_cannot_be_read_names_its_package(install, value, said):
    install("one", "robots", arm=value)
    with pytest.raises(InputError, match=rf"^robot 'arm' of one: .*{said}"):
        load_robot("arm")
    assert load_robot("sjtu-25dof").name == "sjtu-25dof"


def test_two_packages_that_add_the_same_name_are_both_named(install):
    install("one", "methods", nearly=Nearly)
    install("two", "methods", nearly=Nearly)
    with pytest.raises(InputError, match=r"two packages add 'nearly' to hognose\.methods: (one and two|two and one)"):
        hognose.follow(hognose.Path.through([[0, 0, 0], [0, 0, 1]]), [0.1], [0.0])


def test_an_entry_that_cannot_be_loaded_names_its_package(install, tmp_path):
    described(tmp_path, "broken", "1.0", {"hognose.methods": {"gone": "no_such_module:Gone"}})
    with pytest.raises(InputError, match=r"^broken adds 'gone' to hognose\.methods, but no_such_module:Gone cannot be"):
        list(METHODS)


@given(st.dictionaries(names, st.integers()), st.dictionaries(names, st.integers()), names)
def test_a_table_is_a_dictionary_of_ours(own, changes, name):
    table: Table[int] = Table("nothing", own, lambda name, value: None)
    expected, given_items = dict(own), list(own.items())
    assert table == expected
    for key, value in changes.items():
        table[key] = expected[key] = value
    assert (dict(table), list(table), len(table), repr(table)) == (
        expected,
        list(expected),
        len(expected),
        repr(expected),
    )
    assert (name in table) == (name in expected)
    assert table.pop(name, None) == expected.pop(name, None)
    assert table == expected
    assert list(own.items()) == given_items
