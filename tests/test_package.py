"""The package as a whole: light to import, whole in its names, documented."""

from __future__ import annotations

import functools
import importlib
import importlib.metadata
import inspect
import json
import pkgutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import hognose

pytestmark = pytest.mark.slow  # starts Python for each of many imports

ROOT = Path(__file__).parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
#: What takes time to import, and what is not there in an installation without extras.
HEAVY = {"numpy", "numba", "pyarrow", "matplotlib", "pydantic", "manifold3d", "rich", "scipy", "pandas"}
OPTIONAL = {"scipy", "coal", "mujoco", "pandas", "hypothesis", "pytest", "viser", "imageio", "imageio_ffmpeg", "can",
            "canopen", "cascadio", "dask", "mcap", "trimesh"}  # fmt: skip
#: What python-can loads as its plug-in, and needs it.
OF_OTHERS = {"hognose.drive.tcp_bus"}
MODULES = [
    module.name
    for module in pkgutil.walk_packages(hognose.__path__, "hognose.", onerror=lambda name: None)
    if "__main__" not in module.name and not module.name.startswith("hognose.view.") and module.name != "hognose.view"
    if module.name not in OF_OTHERS
]


@functools.cache
def imported(code: str) -> set[str]:
    """The top-level modules that are loaded after running some code in a new process."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", f"{code}\nimport sys, json; print(json.dumps(sorted(sys.modules)))"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return {name.split(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


def test_importing_the_package_costs_next_to_nothing():
    loaded = imported("import hognose; dir(hognose); hognose.__version__")
    assert "hognose" in loaded
    assert not loaded & (HEAVY | OPTIONAL)


def test_importing_the_commands_needs_nothing_heavy_and_nothing_optional():
    loaded = imported("import hognose.cli")
    assert not loaded & (OPTIONAL | {"numba", "pyarrow", "matplotlib", "manifold3d", "numpy"})


@pytest.mark.parametrize(
    "code",
    [
        "import hognose, tempfile, pathlib; folder = tempfile.TemporaryDirectory()\n"
        "file = pathlib.Path(folder.name) / 'a.parquet'; hognose.plan(hognose.load_task('pipe-tank')).save(file)\n"
        "hognose.Plan.load(file); folder.cleanup()",
        f"import importlib\nfor name in {MODULES!r}: importlib.import_module(name)",
    ],
    ids=["planning", "every module"],
)
def test_nothing_optional_is_imported(code):
    # numba takes scipy if it is there.
    assert not imported(code) & OPTIONAL - imported("import numba")


def test_every_public_name_is_there():
    assert len(set(hognose.__all__)) == len(hognose.__all__)
    assert sorted(hognose.__all__) == dir(hognose)
    for name in hognose.__all__:
        assert getattr(hognose, name) is not None
    names: dict[str, Any] = {}
    exec("from hognose import *", names)
    assert set(hognose.__all__) <= set(names)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'hognose' has no attribute 'plam'"):
        getattr(hognose, "plam")  # noqa: B009
    assert not hasattr(hognose, "__wrapped__")


def test_public_names_are_those_of_their_rooms():
    for name in set(hognose.__all__) - {"__version__", "METHODS"}:
        found = getattr(hognose, name)
        assert found.__name__ == name
        assert found.__module__.startswith("hognose.")


def test_the_version_is_one():
    assert PROJECT["version"] == hognose.__version__ == importlib.metadata.version("hognose")


def test_errors_have_one_root():
    for name in ("InputError", "InfeasibleError", "MissingExtraError"):
        assert issubclass(getattr(hognose, name), hognose.HognoseError)
    assert issubclass(hognose.InputError, ValueError)
    assert not issubclass(hognose.InfeasibleError, ValueError)


def test_the_package_is_typed():
    assert (Path(hognose.__path__[0]) / "py.typed").is_file()


def public(module: Any) -> Iterator[tuple[str, Any]]:
    """Functions, classes and their members that a module defines and does not hide."""
    for name, found in vars(module).items():
        if name.startswith("_") or getattr(found, "__module__", None) != module.__name__:
            continue
        if inspect.isclass(found):
            yield name, found
            for member, value in vars(found).items():
                value = getattr(value, "__func__", getattr(value, "fget", getattr(value, "func", value)))
                if not member.startswith("_") and inspect.isfunction(value) and value.__module__ == module.__name__:
                    yield f"{name}.{member}", value
        elif inspect.isroutine(found) or hasattr(found, "py_func"):
            yield name, found


@pytest.mark.parametrize("name", MODULES)
def test_every_module_and_everything_public_in_it_is_documented(name):
    module = importlib.import_module(name)
    assert (module.__doc__ or "").strip(), name
    undocumented = [found for found, thing in public(module) if not (getattr(thing, "__doc__", None) or "").strip()]
    assert not undocumented


def test_the_search_for_undocumented_things_finds_things():
    modules = ("plan", "motion", "checks.check")
    found = [name for each in modules for name, _ in public(importlib.import_module(f"hognose.planning.{each}"))]
    assert {"Plan", "Plan.save", "Plan.load", "Plan.good", "Motion.path", "Check", "Check.sentence"} <= set(found)


def test_the_command_is_declared():
    (command,) = importlib.metadata.entry_points(group="console_scripts", name="hognose")
    assert command.value == PROJECT["scripts"]["hognose"]
    assert callable(command.load())


def test_the_old_name_of_the_planner_still_works_and_says_what_it_is_called_now():
    task = hognose.load_task("pipe-tank")
    with pytest.warns(DeprecationWarning, match="is called plan_along now"):
        plan = importlib.import_module("hognose.planning").plan(task)
    assert plan.good


def test_the_old_name_of_the_report_still_works_and_says_what_it_is_called_now():
    with pytest.warns(DeprecationWarning, match=r"hognose\.view is called hognose\.report now"):
        camera = importlib.import_module("hognose.view.camera")
    assert camera is importlib.import_module("hognose.report.camera")
    assert camera.__spec__ is not None
    assert camera.__name__ == camera.__spec__.name == "hognose.report.camera"
    for module in pkgutil.iter_modules(importlib.import_module("hognose.report").__path__):  # and warns no more
        here, there = (importlib.import_module(f"hognose.{room}.{module.name}") for room in ("view", "report"))
        assert here is there
    with pytest.raises(ModuleNotFoundError, match=r"hognose\.view\.nothing"):
        importlib.import_module("hognose.view.nothing")
