"""Robots and tasks from files: values, units, and messages that name file, line and key."""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from file_texts import ALL_FILES, ROBOT_FILES, TASK_FILES, VARIED_FILES, places, scaled, toml, with_value

import hognose
from hognose.files import bundled_robots, bundled_tasks, load_task_or_plan, with_method

#: Metres in each unit that a file may declare.
LENGTH_UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}
ROBOT_LENGTHS = {
    "base_length", "tool_length", "min", "max", "speed", "cable_speed", "cable_travel", "pitch", "half_lengths",
    "axis_offset", "body_diameter", "body_width", "body_height", "cable_radius", "screw_lead", "drum_diameter",
    "centre_of_mass", "free_length", "passing_cable_radius", "length_range",
}  # fmt: skip
TASK_LENGTHS = {
    "margin", "way_points", "step", "spacing", "center", "size", "thickness", "diameter", "diameters", "wall",
    "start", "end", "entrance", "target", "via", "radius", "nozzle", "low", "high", "speed",
    "cad", "registration", "registration_at", "cable_zero", "sag", "motion_pivot", "position",
}  # fmt: skip


@pytest.fixture
def beside_its_files(tmp_path: Path) -> Path:
    """A folder with the STEP and STL files that bundled tasks name."""
    for name in ("step_tank.step", "slanted_vessel.stl"):
        shutil.copy(TASK_FILES["step-tank"].with_name(name), tmp_path)
    return tmp_path


def parsed(file: Path) -> dict[str, Any]:
    return tomllib.loads(file.read_text())


def load(name: str, file: Path) -> Any:
    return hognose.load_robot(file) if name in ROBOT_FILES else hognose.load_task(file)


def refusal(name: str, file: Path) -> str:
    with pytest.raises(hognose.InputError) as caught:
        load(name, file)
    return str(caught.value)


def test_the_bundled_names_are_the_files():
    others = "casia-coiled metabot-3arc on-wing-taper safire-18dof zju-24cable"
    assert bundled_robots() == ("sjtu-25dof", "sjtu-25dof-99", *others.split())
    tasks = "obstacle-array pipe-tank detour step-tank find-a-way slanted-vessel drum carrier tolerances"
    of_other_arms = "test-box pipe-jungle engine-stage feeder-slot baffled-tank"
    assert list(bundled_tasks()) == [*tasks.split(), "moving-obstacles", *of_other_arms.split()]
    assert all(file.is_file() for file in ALL_FILES.values())


@pytest.mark.parametrize("name", list(ALL_FILES))
def test_a_bundled_name_and_its_file_are_the_same(name, beside_its_files):
    by_name = hognose.load_robot(name) if name in ROBOT_FILES else hognose.load_task(name)
    copy = beside_its_files / "copy.toml"
    copy.write_text(ALL_FILES[name].read_text())
    for source in (copy, str(copy)):
        by_file = hognose.load_robot(source) if name in ROBOT_FILES else hognose.load_task(source)
        assert by_file.spec == by_name.spec


@pytest.mark.parametrize("name", list(ALL_FILES))
def test_the_writer_of_these_tests_writes_what_it_was_given(name):
    data = parsed(ALL_FILES[name])
    text, lines = toml(data)
    assert tomllib.loads(text) == data
    for keys, line in lines.items():
        assert re.search(rf"\b{re.escape([k for k in keys if isinstance(k, str)][-1])}\b", text.splitlines()[line - 1])


def test_lengths_arrive_in_metres_and_angles_in_degrees():
    robot = hognose.load_robot("sjtu-25dof")
    np.testing.assert_allclose(robot.link_lengths, 0.091, rtol=1e-15)
    np.testing.assert_allclose(robot.bend_limits, 0.5, rtol=1e-15)
    np.testing.assert_allclose(robot.body_radii, 0.0225, rtol=1e-15)
    assert robot.spec.feed.max == pytest.approx(1.1, rel=1e-15)
    assert robot.spec.feed.speed == pytest.approx(0.05, rel=1e-15)
    assert robot.spec.limits.cable_travel == pytest.approx((-0.09, 0.09), rel=1e-15)
    assert robot.spec.limits.joint_speed_deg_s == 7.0
    task = hognose.load_task("obstacle-array")
    np.testing.assert_allclose(task.way_points[1], [0.12, 0.04, 0.38], rtol=1e-15)
    assert (task.margin, task.spec.motion.step) == pytest.approx((0.005, 0.0035), rel=1e-15)
    assert task.spec.motion.period_s == 0.15


@pytest.mark.parametrize("unit", list(LENGTH_UNITS))
@pytest.mark.parametrize("name", list(ALL_FILES))
def test_every_length_scales_with_the_unit(name, unit, beside_its_files):
    data = parsed(ALL_FILES[name])
    factor = LENGTH_UNITS[data["units"]] / LENGTH_UNITS[unit]
    other = scaled(data, factor, ROBOT_LENGTHS if name in ROBOT_FILES else TASK_LENGTHS)
    (beside_its_files / "other.toml").write_text(toml({**other, "units": unit})[0])
    files = (ALL_FILES[name], beside_its_files / "other.toml")
    here, there = (load(name, file).spec.model_dump(mode="json") for file in files)
    flat_here, flat_there = ({keys: _leaf(dump, keys) for keys in places(dump)} for dump in (here, there))
    assert flat_here.keys() == flat_there.keys()
    for keys, value in flat_here.items():
        if isinstance(value, float):
            assert flat_there[keys] == pytest.approx(value, rel=1e-12, abs=1e-15)
        else:
            assert flat_there[keys] == value


def _leaf(data: Any, keys: tuple[str | int, ...]) -> Any:
    for key in keys:
        data = data[key]
    return None if isinstance(data, dict | list) else data


def test_a_wrong_unit_is_guessed_from_the_length_of_the_arm(tmp_path):
    data = with_value(parsed(ROBOT_FILES["sjtu-25dof"]), ("feed", "max"), 900.0)
    (tmp_path / "robot.toml").write_text(toml({**data, "units": "m"})[0])
    text = refusal("sjtu-25dof", tmp_path / "robot.toml")
    assert "the arm is 1,092 m long, expected 0.02 to 30 m" in text
    assert "is `units` right?" in text


@pytest.mark.parametrize("name", list(ROBOT_FILES))
def test_millimetres_taken_for_metres_are_noticed(name, tmp_path):
    (tmp_path / "file.toml").write_text(ROBOT_FILES[name].read_text().replace('units = "mm"', 'units = "m"'))
    assert "is `units` right?" in refusal(name, tmp_path / "file.toml")


@pytest.mark.parametrize("name", list(ALL_FILES))
def test_units_are_asked_for(name, tmp_path):
    file = tmp_path / "file.toml"
    data = parsed(ALL_FILES[name])
    for unit in (..., "ft", "MM", 3, ["mm"], {"a": 1}, ""):
        text, lines = toml(with_value(data, ("units",), unit))
        file.write_text(text)
        said = refusal(name, file)
        assert "expected one of 'mm', 'cm', 'm', 'in'" in said
        assert "is missing" in said if unit is ... else said.startswith(f"{file}:{lines['units',]}: units: is ")


@pytest.mark.parametrize("name", list(VARIED_FILES))
def test_a_wrong_value_is_told_with_the_line_and_name_of_its_key(name, tmp_path):
    """Every value in turn becomes an empty table, which none may be."""
    data, file = parsed(ALL_FILES[name]), tmp_path / "file.toml"
    for keys in places(data):
        if keys == ("units",):
            continue
        text, lines = toml(with_value(data, keys, {"nonsense": 1.0}))
        file.write_text(text)
        said = refusal(name, file)
        below = (*keys, "nonsense")
        line = next(lines[below[:end]] for end in range(len(below), 0, -1) if below[:end] in lines)
        table = next(lines[keys[:end]] for end in range(len(keys), 0, -1) if keys[:end] in lines)
        expected = (f"{file}:{line}: {_dotted(below)}", f"{file}:{table}: {_dotted(keys)}")
        assert any(fault.startswith(expected) for fault in said.splitlines()), (keys, said)


def _dotted(keys: tuple[str | int, ...]) -> str:
    text = "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in keys)
    return text.removeprefix(".")


@pytest.mark.parametrize("name", list(VARIED_FILES))
def test_an_unknown_key_is_told_with_its_line_and_the_nearest_known(name, tmp_path):
    data, file = parsed(ALL_FILES[name]), tmp_path / "file.toml"
    for keys in places(data):
        key = keys[-1]
        if isinstance(key, int) or len(key) < 4:
            continue
        text, lines = toml(with_value(data, (*keys[:-1], f"{key}x"), 1.0))
        file.write_text(text)
        said = next(fault for fault in refusal(name, file).splitlines() if "unknown key" in fault)
        spelt = (*keys[:-1], f"{key}x")
        if key == "units":
            assert "'units'" in said
            continue
        assert said.startswith(f"{file}:{lines[spelt]}: {_dotted(spelt)}: unknown key; did you mean {key!r}?"), said
        assert key in said.split("Known here: ")[1].split(", ")


REQUIRED = {
    "sjtu-25dof": "name feed feed.max limits limits.cable_speed section section.0.pitch section.0.transmission",
    "pipe-tank": "name robot path obstacle.0.wall obstacle.1.diameter obstacle.0.hole.0.face",
}


def test_an_unknown_key_like_no_other_says_what_is_known_there(tmp_path):
    text, lines = toml(with_value(parsed(TASK_FILES["detour"]), ("motion", "qqqq"), 1))
    (tmp_path / "task.toml").write_text(text)
    place = f"{tmp_path / 'task.toml'}:{lines['motion', 'qqqq']}: motion.qqqq"
    expected = f"{place}: unknown key. Known here: method, period_s, profile, retraction_profile, "
    expected += "retraction_start_s, smoothing_s, spacing, step, tip_tolerance"
    assert refusal("detour", tmp_path / "task.toml") == expected


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("jerk_time_s", "smoothing_s"),
        ("jerk_s", "smoothing_s"),
        ("jerk_time", "smoothing_s"),
        ("dt", "period_s"),
        ("period", "period_s"),
        ("smoothing", "smoothing_s"),
        ("retraction_start", "retraction_start_s"),
        ("smoothing_ms", "smoothing_s"),
        ("velocity_s", None),  # nothing but the unit is that of another key
    ],
)
def test_a_suggested_key_is_what_was_meant_and_not_one_of_the_same_unit(key, meant, tmp_path):
    text, _ = toml(with_value(parsed(TASK_FILES["detour"]), ("motion", key), 1))
    (tmp_path / "task.toml").write_text(text)
    hint = f"; did you mean {meant!r}?" if meant else "."
    assert f"motion.{key}: unknown key{hint} Known here: method" in refusal("detour", tmp_path / "task.toml")


def test_a_path_without_way_points_and_without_target_leads_nowhere(tmp_path):
    text, lines = toml(with_value(parsed(TASK_FILES["pipe-tank"]), ("path", "way_points"), ...))
    (tmp_path / "task.toml").write_text(text)
    place = f"{tmp_path / 'task.toml'}:{lines[('path',)]}: path"
    expected = f"{place}: `way_points` are missing; or give a `target`, and a way to it is searched"
    assert refusal("pipe-tank", tmp_path / "task.toml") == expected


@pytest.mark.parametrize(("name", "dotted"), [(name, key) for name, keys in REQUIRED.items() for key in keys.split()])
def test_a_missing_key_is_told(name, dotted, tmp_path):
    keys = tuple(int(key) if key.isdigit() else key for key in dotted.split("."))
    text, lines = toml(with_value(parsed(ALL_FILES[name]), keys, ...))
    (tmp_path / "file.toml").write_text(text)
    line = next((f":{lines[keys[:end]]}" for end in range(len(keys) - 1, 0, -1) if keys[:end] in lines), "")
    assert refusal(name, tmp_path / "file.toml") == f"{tmp_path / 'file.toml'}{line}: {_dotted(keys)}: is missing"


def test_every_fault_is_told_at_once(tmp_path):
    data = with_value(parsed(TASK_FILES["pipe-tank"]), ("margin",), -1.0)
    data = with_value(data, ("motion", "period_s"), 0.0)
    data = with_value(data, ("obstacle", 3, "wall"), "thick")
    text, lines = toml(data)
    (tmp_path / "task.toml").write_text(text)
    said = refusal("pipe-tank", tmp_path / "task.toml").splitlines()
    assert len(said) == 3
    for keys in [("margin",), ("motion", "period_s"), ("obstacle", 3, "wall")]:
        assert any(f":{lines[keys]}: {_dotted(keys)}: " in fault for fault in said)


def test_unknown_names_say_what_there_is_and_what_was_meant():
    with pytest.raises(
        hognose.InputError, match=r"Did you mean 'sjtu-25dof'\? Bundled: sjtu-25dof, sjtu-25dof-99, casia-"
    ):
        hognose.load_robot("sjtu-25dov")
    with pytest.raises(
        hognose.InputError, match=r"Did you mean 'pipe-tank'\? Bundled: obstacle-array, pipe-tank, detour"
    ):
        hognose.load_task("pipetank")


def test_an_unknown_method_says_the_nearest(tmp_path):
    (tmp_path / "task.toml").write_text(TASK_FILES["pipe-tank"].read_text().replace('"exact"', '"predicton"'))
    match = r"task\.toml:\d+: motion\.method: .*'predicton' is unknown; did you mean 'prediction'\? Methods: exact, "
    with pytest.raises(hognose.InputError, match=match):
        hognose.load_task(tmp_path / "task.toml")
    with pytest.raises(hognose.InputError, match="did you mean 'exact'"):
        with_method(hognose.load_task("pipe-tank"), "exakt")


def test_with_method_changes_the_method_only():
    task = hognose.load_task("pipe-tank")
    other = with_method(task, "interpolation")
    assert other.spec.motion.method == "interpolation"
    assert with_method(other, "exact").spec == task.spec
    assert task.spec.motion.method == "exact"


def test_a_robot_file_is_looked_for_beside_the_task(tmp_path, monkeypatch):
    (tmp_path / "arms").mkdir()
    text = ROBOT_FILES["sjtu-25dof"].read_text().replace('name = "sjtu-25dof"', 'name = "mine"')
    (tmp_path / "arms" / "mine.toml").write_text(text)
    (tmp_path / "task.toml").write_text(TASK_FILES["detour"].read_text().replace('"sjtu-25dof"', '"arms/mine.toml"'))
    monkeypatch.chdir("/")
    assert hognose.load_task(tmp_path / "task.toml").robot.name == "mine"
    (tmp_path / "arms" / "mine.toml").write_text(text.replace("pitch = 91.0", "pitch = -91.0"))
    with pytest.raises(hognose.InputError) as caught:
        hognose.load_task(tmp_path / "task.toml")
    said = str(caught.value)
    assert said.startswith(f"{tmp_path / 'task.toml'}: robot: {tmp_path / 'arms' / 'mine.toml'}:")
    assert "section[1].pitch: input should be greater than 0, got -91.0" in said


def test_a_suffix_tells_plans_from_tasks(tmp_path):
    assert isinstance(load_task_or_plan("detour"), hognose.Task)
    with pytest.raises(hognose.InputError, match=r"none\.parquet: no such file"):
        load_task_or_plan(str(tmp_path / "none.parquet"))
