"""Faults of type and length in files are told in plain words, not in those of Python or pydantic."""

from __future__ import annotations

import re
import tomllib

import pytest
from file_texts import ALL_FILES, VARIED_FILES, outcome, places, toml, value_at, with_value

import hognose
from hognose.files import load_robot, load_task
from hognose.files.toml_source import read_model
from hognose.planning import TaskSpec
from hognose.robot import RobotSpec

TASK = """\
schema = 1
units = "mm"
name = "a box"
robot = "sjtu-25dof"

[path]
way_points = [[0, 0, 0], [0, 0, 300]]

[[obstacle]]
kind = "box"
name = "box"
center = [0, 0, 700]
size = [10, 10, 10]
"""
#: By what is written instead of what: what is said of it, behind file and line.
TOLD = {
    ("size = [10, 10, 10]", 'size = "big"'): "obstacle[1].size: expected a list of three numbers, got 'big'",
    (
        "size = [10, 10, 10]",
        "size = [1, 2, 3, 4]",
    ): "obstacle[1].size: expected a list of three numbers, got [1, 2, 3, 4]",
    ("size = [10, 10, 10]", "size = [1, true, 3]"): "obstacle[1].size[2]: expected a number, got true",
    ("size = [10, 10, 10]", "size = {x = 1}"): "obstacle[1].size: expected a list of three numbers, got a table",
    ("[[0, 0, 0], [0, 0, 300]]", "3"): "path.way_points: expected a list of lists of three numbers, got 3",
    ("[[0, 0, 0], [0, 0, 300]]", "[3, 4]"): "path.way_points[1]: expected a list of three numbers, got 3",
    ('name = "a box"', "name = 2026-01-01"): "name: expected text in quotes, got 2026-01-01",
    ("schema = 1", "schema = 1.5"): "schema: expected a whole number, got 1.5",
    ("[path]", "path = 3\n[other]"): "path: expected a table, got 3",
    ("[path]", "obstacle = 3\n[path]"): "obstacle: expected a list of tables, got 3",
    ("[path]", "[path]\ndetour = 1"): "path.detour: expected true or false, got 1",
    (
        "[path]",
        "[tolerance]\ncalibration_deg = 7\n[path]",
    ): "tolerance.calibration_deg: input should be less than or equal",
    ("[path]", "[tolerance]\nsag = -1\n[path]"): "tolerance.sag: input should be greater than or equal to 0, got -1",
    ("[path]", "[tolerance]\nsag = 'x'\n[path]"): "tolerance.sag: expected a number or a list of numbers, got 'x'",
    ("[path]", "[tolerance]\nsag = [1, -1]\n[path]"): "tolerance.sag[2]: input should be greater than or equal to 0",
    ("[path]", "[tolerance]\nassumed = ['sagg']\n[path]"): "tolerance.assumed: unknown key 'sagg'; did you mean 'sag'? "
    "Known here: cad, registration, registration_deg, registration_at, timing_s, calibration_deg, cable_zero, sag",
    ("[path]", "[tolerance]\nassumed = ['cad']\n[path]"): "tolerance: `assumed`: 'cad' goes with a value of `cad`, and "
    "none is given; leave it out",
    ("[path]", "[tolerance]\nregistration_at = [0, 0, 0]\n[path]"): "tolerance: `registration_at` goes with "
    "`registration` or `registration_deg`, of which neither is given",
    ("[path]", "[motion]\nsmoothing_s = 0.5\n[path]"): 'motion: `smoothing_s` goes with `profile = "fastest"`',
    (
        "[path]",
        "[path]\nvia = [" + 21 * "[0, 0, 100]," + "]",
    ): "path.via: expected at most 20 entries, got [[0, 0, 100], [",
}


@pytest.mark.parametrize(("old", "new"), list(TOLD))
def test_what_was_expected_is_told_in_plain_words(old, new, tmp_path):
    text = TASK.replace(old, new, 1) if "obstacle = 3" not in new else TASK.split("[[obstacle]]")[0].replace(old, new)
    (tmp_path / "task.toml").write_text(text)
    with pytest.raises(hognose.InputError) as caught:
        load_task(tmp_path / "task.toml")
    assert re.sub(r"^.*?task\.toml(:\d+)?: ", "", str(caught.value), flags=re.MULTILINE).startswith(TOLD[old, new])


def test_either_of_two_types_is_told_once(tmp_path):
    text = ALL_FILES["sjtu-25dof"].read_text()
    (tmp_path / "arm.toml").write_text(re.sub(r"bend_limit_deg = .*", 'bend_limit_deg = "big"', text, count=1))
    with pytest.raises(hognose.InputError) as caught:
        load_robot(tmp_path / "arm.toml")
    (line,) = str(caught.value).splitlines()
    assert line.endswith("section[1].bend_limit_deg: expected a number or a list of two numbers, got 'big'")


@pytest.mark.parametrize("value", ["7", "-1", "[1, 7]", "'x'", "[1, 'x']", "nan"])
def test_a_number_out_of_range_is_not_told_to_be_a_list(value, tmp_path):
    (tmp_path / "task.toml").write_text(TASK.replace("[path]", f"[tolerance]\ncalibration_deg = {value}\n[path]"))
    with pytest.raises(hognose.InputError) as caught:
        load_task(tmp_path / "task.toml")
    assert str(caught.value).count("calibration_deg") == 1
    assert ("or a list" in str(caught.value)) == (value == "'x'")


def test_what_goes_together_is_no_fault(tmp_path):
    said = """[tolerance]
registration_deg = 0.0
registration_at = [0, 0, 0]
assumed = ["registration_deg", "sag"]
sag = 0
[motion]
smoothing_s = 0.5
retraction_profile = "fastest"
[path]"""
    (tmp_path / "task.toml").write_text(TASK.replace("[path]", said))
    assert load_task(tmp_path / "task.toml").budget is None
    (tmp_path / "task.toml").write_text(TASK.replace("[path]", "[tolerance]\nassumed = ['sag']\n[path]"))
    with pytest.raises(
        hognose.InputError, match="'sag' goes with a value of `sag`, and neither the task nor its robot"
    ):
        _ = load_task(tmp_path / "task.toml").budget


@pytest.mark.parametrize("name", list(VARIED_FILES))
@pytest.mark.parametrize("wrong", ["big", True, [], {"a": 1}, [[["x"]]]])
def test_no_message_has_words_of_python(name, wrong, tmp_path):
    data = tomllib.loads(ALL_FILES[name].read_text(encoding="utf-8"))
    model = RobotSpec if "section" in data else TaskSpec
    seen = set()
    for keys in places(data):
        kind = tuple(key for key in keys if isinstance(key, str)), type(value_at(data, keys))
        if kind in seen or keys == ("units",):
            continue
        seen.add(kind)
        (tmp_path / "wrong.toml").write_text(toml(with_value(data, keys, wrong))[0], encoding="utf-8")
        found = outcome(lambda: read_model(tmp_path / "wrong.toml", model))
        if isinstance(found, hognose.InputError):
            told = re.search(
                r"tuple|dictionary|a valid|instance|integer|datetime|constrained|True|None|items", str(found)
            )
            assert told is None, found
