"""However a file is damaged: a value or an InputError that names the file; what loads is planned or refused."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from file_texts import ALL_FILES, ROBOT_FILES, TASK_FILES, VARIED_FILES, outcome, places, toml, value_at, with_value
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import hognose
from hognose.planning import Task, TaskSpec
from hognose.planning.planner import plan_along
from hognose.robot import Robot

DATA: dict[str, dict[str, Any]] = {name: tomllib.loads(file.read_text()) for name, file in ALL_FILES.items()}
DEEP: Any = {"a": {"b": [[1.0], {"c": "d"}]}}
#: What may stand where something else should.
ODD: list[Any] = [
    True, False, 0, 0.0, -0.0, -1, -1.0, 1, 1e-300, -1e-300, 1e-9, 1e9, 1e18, 1e160, 1e300, -1e300, 2**31, 2**63 - 1,
    -(2**63), float("nan"), float("inf"), float("-inf"), "", " ", "abc", "1.0", "sjtu-25dof", "exact", "board",
    "a" * 300, [], [[]], [{}], {}, DEEP, [1.0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0], [float("nan")] * 3, [1e300] * 3,
    [1.0] * 1000, ["a", "b", "c"], [[0.0, 0.0, 0.0]] * 3, [[0.0, 0.0, 0.0], [0.0, 0.0, 1e9]], "\u0000\u202e",
    "../../etc/passwd", 10**400, -(10**400), 1.7e308, 5e-324, [0.0, 0.0], [5e-324] * 3, [-(2**70), 2**70],
    [-(10**400), 10**400], [1.7e308] * 2, "\u001b[31mred",
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    made = tmp_path_factory.mktemp("files")
    for beside in ("step_tank.step", "slanted_vessel.stl"):
        shutil.copy(TASK_FILES["step-tank"].with_name(beside), made)
    return made


def load(name: str, file: Path) -> Robot | Task | hognose.HognoseError:
    return outcome(lambda: hognose.load_robot(file) if name in ROBOT_FILES else hognose.load_task(file))


def judged(name: str, folder: Path, content: str | bytes) -> Robot | Task | str:
    """What a file holds, or why it was refused."""
    file = folder / "damaged.toml"
    file.write_bytes(content.encode("utf-8", "surrogatepass") if isinstance(content, str) else content)
    loaded = load(name, file)
    if isinstance(loaded, Robot | Task):
        return loaded
    assert isinstance(loaded, hognose.InputError)
    assert all(fault.startswith(str(file)) for fault in str(loaded).splitlines()), str(loaded)
    return str(loaded)


@st.composite
def mutations(draw: st.DrawFn, name: str) -> dict[str, Any]:
    """The file's content with one to three values replaced, deleted, added or doubled."""
    data = DATA[name]
    for _ in range(draw(st.sampled_from([1, 1, 2, 3]))):
        keys = draw(st.sampled_from(list(places(data))))
        value = value_at(data, keys)
        kind = draw(st.sampled_from(["replace", "replace", "replace", "delete", "add", "double", "scale"]))
        if kind == "replace":
            data = with_value(data, keys, draw(st.sampled_from(ODD)))
        elif kind == "delete":
            data = with_value(data, keys, ...)
        elif kind == "add" and isinstance(value, dict):
            data = with_value(data, (*keys, draw(st.sampled_from(["colour", "name", "", "a b", "ü", "kind"]))), 1.0)
        elif kind == "double" and isinstance(value, list):
            data = with_value(data, keys, value * 2)
        elif kind == "scale" and isinstance(value, float):
            data = with_value(data, keys, value * draw(st.sampled_from([-1.0, 1e-3, 0.1, 0.9, 1.1, 10.0, 1e3])))
        assume(data)
    return data


#: Numbers beyond this, in mm or degrees, are planned apart, in a process of limited memory.
FAR = 1e7


def is_far(data: Any) -> bool:
    if isinstance(data, dict):
        return any(map(is_far, data.values()))
    if isinstance(data, list):
        return any(map(is_far, data))
    return isinstance(data, float | int) and abs(data) > FAR


def plan_of(loaded: Robot | Task) -> Any:
    """A plan with a coarse step of what was loaded: made, or refused by an error of ours. Straight to a target."""
    if isinstance(loaded, Robot):
        task = Task(hognose.load_task("pipe-tank").spec, loaded)
    else:
        task = loaded
    given = task.spec.motion
    method = "exact" if given.method == "fitted" else given.method  # whose keyframes take seconds, each time
    coarse_ones = {"step": max(given.step, 0.05), "spacing": 0.01, "method": method}
    motion = given.model_copy(update=coarse_ones)
    spec: TaskSpec = task.spec.model_copy(update={"motion": motion})
    coarse = Task(spec, task.robot)
    searched = spec.path.target is not None  # which takes seconds, each time
    return outcome(lambda: plan_along(coarse, way_points=coarse.way_points) if searched else hognose.plan(coarse))


@pytest.mark.parametrize("name", list(VARIED_FILES))
@given(data=st.data())
@settings(max_examples=15, deadline=None)
def test_a_mutated_file_gives_a_value_or_says_why_not(folder, name, data):
    content = data.draw(mutations(name))
    loaded = judged(name, folder, toml(content)[0])
    many = isinstance(loaded, Robot) and loaded.sections > 50
    if isinstance(loaded, str) or many or is_far({**content, "limits": None}):  # counts are large by nature
        return
    made = plan_of(loaded)
    assert made.good if isinstance(made, hognose.Plan) else len(str(made)) > 20


#: Key and value, in mm, of what nobody builds, but somebody may write.
EXTREME: dict[str, tuple[str, str]] = {
    "a target a thousand kilometres away": ("[40.0, 20.0, 1040.0]", "[40.0, 20.0, 1e9]"),
    "a target beyond the sun": ("[40.0, 20.0, 1040.0]", "[40.0, 20.0, 1e18]"),
    "a target beyond all numbers": ("[40.0, 20.0, 1040.0]", "[40.0, 20.0, 1e300]"),
    "an entrance far away": ("[0.0, 0.0, 0.0],\n  [40", "[1e10, 0.0, 0.0],\n  [40"),
    "a step of a thousand kilometres": ("step = 3.5", "step = 1e9"),
    "a margin of a thousand kilometres": ("margin = 5.0", "margin = 1e9"),
    "a pillar beyond all numbers": ("diameter = 70.0", "diameter = 1e300"),
    "a pillar that ends beyond all numbers": ("end = [10.0, 250.0", "end = [10.0, 1e300"),
    "a ball beyond all numbers": ("diameter = 100.0", "diameter = 1e300"),
}
PLAN_EACH = """
import os, resource, sys, warnings
import hognose.cli, hognose.files, hognose.planning
warnings.simplefilter("error")
for file in sys.argv[1:]:
    if child := os.fork():
        print(file, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    else:
        resource.setrlimit(resource.RLIMIT_AS, (4_000_000_000, 4_000_000_000))
        resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
        sys.stdout = open(file + ".said", "w")
        sys.stderr = sys.stdout
        hognose.cli.main(["plan", file, "-o", file + ".parquet"])
"""


@pytest.fixture(scope="module")
def extreme(tmp_path_factory) -> dict[str, tuple[int, str]]:
    """Exit code and message of planning each of the extreme tasks."""
    folder = tmp_path_factory.mktemp("extreme")
    text, files = TASK_FILES["detour"].read_text(), {}
    for number, (what, (old, new)) in enumerate(EXTREME.items()):
        assert text.count(old) == 1
        files[what] = folder / f"{number}.toml"
        files[what].write_text(text.replace(old, new))
    done = subprocess.run(
        [sys.executable, "-c", PLAN_EACH, *map(str, files.values())], capture_output=True, text=True, check=False
    )
    codes = dict(line.split() for line in done.stdout.splitlines())
    return {what: (int(codes[str(file)]), Path(f"{file}.said").read_text()) for what, file in files.items()}


@pytest.mark.parametrize("what", list(EXTREME))
def test_the_extreme_is_refused_before_it_costs_memory_or_time(extreme, what):
    code, said = extreme[what]
    assert code in (1, 2), said
    assert "Traceback" not in said
    assert len(said) > 20


@pytest.mark.parametrize("odd", range(len(ODD)))
@pytest.mark.parametrize("name", ["sjtu-25dof", "pipe-tank"])
def test_an_odd_value_anywhere_gives_a_value_or_says_why_not(folder, name, odd):
    for keys in list(places(DATA[name]))[odd % 4 :: 4]:  # each place meets every fourth of them, to save time
        judged(name, folder, toml(with_value(DATA[name], keys, ODD[odd]))[0])


#: One of every kind of obstacle, far from the arm, and of all else that a task may say.
EVERYTHING = """
margin = 5.0
[path]
target = [40.0, 20.0, 1040.0]
via = [[0.0, 0.0, 100.0]]
tip_direction = [0.0, 0.0, 1.0]
tip_cone_deg = 20.0
[[path.keep_out]]
center = [9000.0, 0.0, 0.0]
size = [1.0, 1.0, 1.0]
[motion]
step = 3.5
period_s = 0.15
spacing = 0.5
tip_tolerance = 0.5
[report]
times_s = [1.0, 2.0]
[[obstacle]]
kind = "sphere"
center = [9000.0, 0.0, 0.0]
diameter = 3.0
[[obstacle]]
kind = "cylinder"
start = [9000.0, 0.0, 0.0]
end = [9000.0, 0.0, 10.0]
diameter = 3.0
[[obstacle]]
kind = "pipe"
start = [9000.0, 0.0, 0.0]
end = [9000.0, 0.0, 10.0]
diameter = 3.0
wall = 1.0
[[obstacle]]
kind = "box"
center = [9000.0, 0.0, 0.0]
size = [1.0, 1.0, 1.0]
rotation_deg = [1.0, 2.0, 3.0]
[[obstacle]]
kind = "board"
center = [9000.0, 0.0, 0.0]
size = [100.0, 100.0]
thickness = 1.0
[[obstacle.hole]]
center = [0.0, 0.0]
diameters = [3.0, 4.0]
angle_deg = 30.0
[[obstacle]]
kind = "tank"
center = [9000.0, 0.0, 0.0]
size = [100.0, 100.0, 100.0]
wall = 3.0
[[obstacle.hole]]
face = "-x"
center = [0.0, 0.0]
diameter = 3.0
"""


@pytest.mark.parametrize("odd", [0, 5e-324, 1.7e308, -(10**400), 2**63, True, "\u001b[31m", []])
def test_whatever_stands_for_a_value_all_that_is_loaded_is_finite(folder, odd):
    data = tomllib.loads('name = "all"\nunits = "mm"\nrobot = "sjtu-25dof"\n' + EVERYTHING)
    assert isinstance(judged("detour", folder, toml(data)[0]), Task)
    robot = DATA["sjtu-25dof"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name, content in (("detour", data), ("sjtu-25dof", robot)):
            for keys in places(content):
                value = [odd] * len(value_at(content, keys)) if isinstance(value_at(content, keys), list) else odd
                loaded = judged(name, folder, toml(with_value(content, keys, value))[0])
                if isinstance(loaded, str):
                    assert all(letter.isprintable() for letter in loaded.replace("\n", ""))
                elif isinstance(loaded, Task):
                    assert np.isfinite(loaded.scene.triangles).all()
                    assert np.isfinite(loaded.way_points).all()
                else:
                    bent = np.full((loaded.sections, 2), 0.1)
                    assert np.isfinite(loaded.motor_counts(loaded.cable_lengths(bent))).all()


@pytest.mark.parametrize("key", ["name", "robot", "obstacle.0.name", "description"])
def test_control_characters_are_refused_with_their_key_and_line(folder, key):
    keys = tuple(int(part) if part.isdigit() else part for part in key.split("."))
    data = with_value(DATA["pipe-tank"], ("obstacle", 0, "name"), "tank")
    for text in ("\u001b]0;x\u0007", "a\u009bb", "\u007f", "a\rb", "\u202etxt.exe", "a\u2028b"):
        content, lines = toml(with_value(data, keys, text))
        said = judged("pipe-tank", folder, content)
        assert isinstance(said, str)
        assert f":{lines[keys]}: " in said
        assert "holds a control character" in said
        assert said.isprintable()
    several = judged("pipe-tank", folder, toml(with_value(data, keys, "two\nlines\tof text"))[0])
    assert isinstance(several, Task) == (key == "description")


@pytest.mark.parametrize("name", list(VARIED_FILES))
def test_the_fault_of_one_key_is_told_with_that_key(folder, name):
    for keys in places(DATA[name]):
        said = judged(name, folder, toml(with_value(DATA[name], keys, [[["no"]]]))[0])
        assert isinstance(said, str)
        assert str([key for key in keys if isinstance(key, str)][-1]) in said


@pytest.mark.parametrize("name", list(VARIED_FILES))
@given(data=st.data())
@settings(max_examples=20, deadline=None)
def test_a_text_cut_anywhere_gives_a_value_or_says_why_not(folder, name, data):
    text = ALL_FILES[name].read_bytes()
    judged(name, folder, text[: data.draw(st.integers(0, len(text)))])


@pytest.mark.parametrize("name", list(VARIED_FILES))
@given(data=st.data())
@settings(max_examples=20, deadline=None)
def test_any_changed_bytes_give_a_value_or_say_why_not(folder, name, data):
    content = bytearray(ALL_FILES[name].read_bytes())
    for _ in range(data.draw(st.integers(1, 5))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    judged(name, folder, bytes(content))


@given(content=st.binary(max_size=500) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace")))
@settings(max_examples=60, deadline=None)
def test_garbage_is_refused(folder, content):
    for name in ("sjtu-25dof", "pipe-tank"):
        assert isinstance(judged(name, folder, content), str)


NONSENSE: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "the file is empty"),
    "a comment": (b"# nothing\n", "the file is empty"),
    "binary": (bytes(range(256)), "not a text file"),
    "another encoding": ('name = "Zürich"'.encode("utf-16"), "not a text file"),
    "a null byte": (b'units = "mm"\0', "not valid TOML"),
    "half a table": (b"[path", "not valid TOML"),
    "a key twice": (b'units = "mm"\nunits = "mm"', "not valid TOML"),
    "deep arrays": (b"a = " + b"[" * 100_000, "not valid TOML"),
    "deep tables": (b"a = " + b"{b = " * 5_000, "not valid TOML"),
    "a deep header": (b'units = "mm"\n[' + b".".join([b"a"] * 5_000) + b"]", "unknown key"),
    "a deep but whole array": (b'units = "mm"\nname = ' + b"[" * 300 + b"]" * 300, "name"),
    "a long number": (b'units = "mm"\nname = ' + b"9" * 5_000, "not valid TOML"),
}


@pytest.mark.parametrize("kind", list(NONSENSE))
@pytest.mark.parametrize("name", ["sjtu-25dof", "pipe-tank"])
def test_nonsense_is_told_for_what_it_is(folder, name, kind):
    content, reason = NONSENSE[kind]
    said = judged(name, folder, content)
    assert isinstance(said, str)
    assert reason in said


def test_invalid_toml_is_told_with_its_line(folder):
    said = judged("pipe-tank", folder, 'schema = 1\nunits = "mm"\nmargin = 5,0\n')
    assert isinstance(said, str)
    assert "line 3" in said


@pytest.mark.parametrize("name", ["sjtu-25dof", "pipe-tank"])
def test_a_huge_file_is_refused_unread(tmp_path, name):
    huge = tmp_path / "huge.toml"
    with huge.open("wb") as file:
        file.truncate(100_000_000_000)
    assert "100,000 MB is too large" in str(load(name, huge))


@pytest.mark.parametrize("name", ["sjtu-25dof", "pipe-tank"])
def test_what_is_no_file_is_told_for_what_it_is(tmp_path, name):
    (tmp_path / "folder.toml").mkdir()
    os.symlink(tmp_path / "loop.toml", tmp_path / "loop.toml")
    os.symlink(tmp_path / "nowhere.toml", tmp_path / "dangling.toml")
    long = "n" * 300 + ".toml"
    reasons = {
        "folder.toml": "is a folder", "loop.toml": "cannot read: Too many levels", "dangling.toml": "no such file",
        "none.toml": "no such file", long: "cannot read: File name too long", "a\0b.toml": "cannot read",
    }  # fmt: skip
    for file, reason in reasons.items():
        said = load(name, tmp_path / file)
        assert isinstance(said, hognose.InputError)
        assert str(said).startswith(f"{tmp_path / file}: {reason}")


@pytest.mark.parametrize("name", ["sjtu-25dof", "pipe-tank"])
def test_a_file_that_may_not_be_read_says_so(tmp_path, name, monkeypatch):
    """The system is made to refuse: whoever runs the tests may be allowed everything."""
    (tmp_path / "secret.toml").write_bytes(ALL_FILES[name].read_bytes())

    really = os.open

    def refuse(path: Path, *more: int) -> int:
        if Path(path).name == "secret.toml":
            raise PermissionError(13, "Permission denied", str(path))
        return really(path, *more)

    monkeypatch.setattr(os, "open", refuse)
    said = load(name, tmp_path / "secret.toml")
    assert isinstance(said, hognose.InputError)
    assert str(said) == f"{tmp_path / 'secret.toml'}: cannot read: Permission denied"


def test_a_task_whose_robot_is_its_own_file_is_refused(folder):
    text = TASK_FILES["pipe-tank"].read_text().replace('"sjtu-25dof"', '"damaged.toml"')
    said = judged("pipe-tank", folder, text)
    assert isinstance(said, str)
    assert "robot: " in said
