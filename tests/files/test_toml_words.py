"""Faults of type and length in files are told in plain words, not in those of Python or pydantic."""

from __future__ import annotations

import re
import tomllib

import pytest
from file_texts import ALL_FILES, outcome, places, toml, value_at, with_value

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


@pytest.mark.parametrize("name", list(ALL_FILES))
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
