"""Saving a task: only what changed is changed, and what is read back is what was meant."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hognose
from hognose.errors import InputError
from hognose.files import bundled_tasks
from hognose.files.task_toml import agrees, revised, written
from hognose.files.toml_arrays import array_of_rows
from hognose.planning import Task, TaskSpec
from hognose.planning.task import PathSpec
from hognose.viewer.model import edits
from hognose.viewer.model.saving import Original, save_task
from hognose.viewer.model.workbench import Workbench

TEXT = """\
# Head of the file
name = 'odd'   # single quotes
units = "{units}"
robot = "sjtu-25dof"
margin = 5 # margin's comment

[path] # table's comment
way_points = [ # all of them
  # the hole
  [0, 0, 0],     # entrance
  [1_0.0, 0.5e1, 20.0]  # middle
  , [ 2.0,   3.0, 41.0 ], [1,
     2, 60.0],
  [0.5, 1.5, 80] # target
]
order = 3

[[obstacle]]
kind = "sphere"    # far away
center = [100, 100, 100]
diameter = 1.0

# The end
"""
# Lengths in parts of a metre that are exact in no unit.
places = st.tuples(*[st.floats(-0.5, 0.5)] * 3)
changes = st.one_of(
    st.tuples(st.integers(0, 6), places).map(lambda a: edits.move_way_point(*a)),
    st.integers(0, 6).map(edits.add_way_point),
    st.tuples(st.integers(0, 6), places).map(lambda a: edits.add_way_point(*a)),
    st.integers(0, 6).map(edits.remove_way_point),
    st.integers(2, 9).map(edits.set_order),
    st.floats(1e-5, 0.1).map(edits.set_step),
    st.floats(0, 0.1).map(edits.set_margin),
    st.sampled_from(["exact", "prediction", "balanced"]).map(edits.set_method),
    st.sampled_from(["sjtu-25dof", "sjtu-25dof-99"]).map(edits.set_robot),
)


def read(text: str, folder: Path) -> TaskSpec:
    file = folder / "read.toml"
    file.write_bytes(text.encode())
    return hognose.load_task(file).spec


def edited(spec: TaskSpec, todo: list[edits.Change]) -> TaskSpec:
    """The spec after those of the edits that are possible."""
    for change in todo:
        try:
            spec = edits.validated(change(spec), "test")
        except InputError:
            continue
    return spec


def same(one: TaskSpec, other: TaskSpec) -> bool:
    return agrees(one.model_dump(), other.model_dump())


def comments(text: str) -> set[str]:
    return set(re.findall(r"#.*", text))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("saving")


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("file", bundled_tasks().values(), ids=lambda file: file.stem)
def test_a_file_that_says_it_already_stays_byte_for_byte(file, newline):
    text = file.read_text().replace("\n", newline)
    assert revised(text, hognose.load_task(file).spec) == text


@given(todo=st.lists(changes, max_size=6), units=st.sampled_from(["mm", "cm", "in"]), crlf=st.booleans())
@settings(max_examples=60, deadline=None)
def test_what_is_read_back_is_what_was_edited_and_comments_stay(folder, todo, units, crlf):
    text = TEXT.format(units=units).replace("\n", "\r\n" if crlf else "\n")
    before = read(text, folder)
    wanted = edited(before, todo)
    made = revised(text, wanted)
    assert same(read(made, folder), wanted)
    assert revised(made, wanted) == made
    kept = {tuple(p) for p in before.path.way_points} <= {tuple(p) for p in wanted.path.way_points}
    lost = {c.strip() for c in comments(text)} - {c.strip() for c in comments(made)}
    assert not lost or (not kept and lost <= {"# the hole", "# entrance", "# middle", "# target"})
    if crlf:
        assert not re.search(r"[^\r]\n", made)


@given(todo=st.lists(changes, max_size=6), name=st.sampled_from(sorted(bundled_tasks())))
@settings(max_examples=30, deadline=None)
def test_bundled_files_edited_and_read_back(folder, todo, name):
    file = bundled_tasks()[name]
    wanted = edited(hognose.load_task(file).spec, todo)
    made = revised(file.read_text(), wanted)
    for beside in ("step_tank.step", "slanted_vessel.stl"):
        (folder / beside).write_bytes((file.parent / beside).read_bytes())
    assert same(read(made, folder), wanted)
    assert same(read(written(wanted), folder), wanted)


ODD = [
    "path = {way_points = [[0, 0, 0], [0, 10, 50], [0, 0, 100]], order = 3}\n",
    "path.order = 3\npath.way_points = [[0, 0, 0], [0, 10, 50], [0, 0, 100]]\n",
    '"path"."way_points" = [[0, 0, 0],\n[0, 10, 50], # [1, 2, 3], no row\n[0, 0, 100],\n]\n[motion]',
    'obstacle = [{kind = "sphere", center = [1, 2, 3], diameter = 1}]\n[path]\nway_points=[[0,0,0],[0,9,50],[0,0,100]]',
    "[motion]\nstep = 4\n[path]\nway_points = [[0, 0, 0], [0, 10, 50], [0, 0, 100]]\n[report]\ntimes_s = [1]",
]


@pytest.mark.parametrize("layout", ODD)
@given(todo=st.lists(changes, max_size=4))
@settings(max_examples=20, deadline=None)
def test_odd_layouts(folder, layout, todo):
    text = f'units = "mm"\nname = "odd"\nrobot = "sjtu-25dof"\n{layout}'
    before = read(text, folder)
    assert revised(text, before) == text
    wanted = edited(before, todo)
    assert same(read(revised(text, wanted), folder), wanted)


def test_one_edit_changes_one_line(folder):
    text = bundled_tasks()["pipe-tank"].read_text()
    spec = hognose.load_task("pipe-tank").spec
    moved = edits.validated(edits.move_way_point(1, (0.03, 0.1001234567, 0.43))(spec), "")
    old, new = text.splitlines(), revised(text, moved).splitlines()
    assert [(a, b) for a, b in zip(old, new, strict=True) if a != b] == [
        ("  [30.0, 95.0, 430.0],    # between pipes 1 and 2", "  [30.0, 100.123, 430.0], # between pipes 1 and 2")
    ]
    wider = revised(text, edits.set_margin(0.0075)(spec))
    assert wider == text.replace("margin = 5.0 #", "margin = 7.5 #")


def test_a_row_that_is_added_or_removed_leaves_the_others(folder):
    text = bundled_tasks()["pipe-tank"].read_text()
    spec = hognose.load_task("pipe-tank").spec
    more = edits.validated(edits.add_way_point(1, (0.01, 0.02, 0.7))(spec), "")
    longer = revised(text, more)
    assert longer.replace("  [10.0, 20.0, 700.0],\n", "") == text
    assert revised(longer, spec) == text
    assert "# between pipes" not in revised(text, edits.remove_way_point(1)(spec))


def test_rows_keep_how_they_are_written():
    assert array_of_rows("[[0, 0], [1_0, 2]]", [["0", "0"], ["5", "2"]]) == "[[0, 0], [5, 2]]"
    assert array_of_rows("[\n [1_0, 2e0], # a\n]", [["10", "3"]]) == "[\n [1_0, 3],   # a\n]"
    assert array_of_rows("", [["1", "2"]]) == "[\n  [1, 2],\n]"


def test_a_search_becomes_way_points_and_all_that_was_asked_of_it_stays(folder):
    task = hognose.load_task("find-a-way")
    text = bundled_tasks()["find-a-way"].read_text()
    points = np.array([task.way_points[0], [0.0, 0.05, 0.5], task.way_points[-1]])
    spec = edits.validated(edits.take_route(points)(task.spec), "")
    found = read(revised(text, spec), folder)
    assert same(found, spec)
    assert found.path.target is None
    asked = {name: getattr(task.spec.path, name) for name in ("tip_direction", "tip_cone_deg", "keep_out")}
    assert asked["tip_direction"]
    assert asked["keep_out"]
    assert found.path == PathSpec(way_points=spec.path.way_points, **asked)
    assert Task(found, task.robot).scene.names == task.scene.names
    assert np.array_equal(Task(found, task.robot).scene.triangles, task.scene.triangles)


def test_a_bundled_example_is_not_written_over(tmp_path):
    file = bundled_tasks()["pipe-tank"]
    spec, original = hognose.load_task(file).spec, Original.of(file)
    for force in (False, True):
        with pytest.raises(InputError, match=r"bundled example .* current folder instead: 02_pipe_tank"):
            save_task(edits.set_margin(0.001)(spec), file, original, file.parent, force)
    assert Original.of(file) == original
    save_task(spec, tmp_path / "mine.toml", original, file.parent)
    assert (tmp_path / "mine.toml").read_bytes() == file.read_bytes()


def test_what_nobody_has_seen_is_not_written_over(tmp_path):
    file, other = tmp_path / "a.toml", tmp_path / "b.toml"
    file.write_text(TEXT.format(units="mm"))
    spec, original = hognose.load_task(file).spec, Original.of(file)
    file.write_text(TEXT.format(units="mm") + "# someone else\n")
    other.write_text("precious")
    for target, words in ((file, "has changed on disk"), (other, "exists already")):
        before = target.read_bytes()
        with pytest.raises(InputError, match=words):
            save_task(spec, target, original, tmp_path)
        assert target.read_bytes() == before
        save_task(spec, target, original, tmp_path, force=True)
        assert target.read_text() == TEXT.format(units="mm")
    with pytest.raises(InputError, match=r"must end in \.toml"):
        save_task(spec, tmp_path / "c.parquet", original, tmp_path)


def test_meshes_and_robots_are_found_from_another_folder(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    (here / "cube.off").write_text("OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    robot = Path(hognose.__file__).parent / "robot" / "bundled" / "sjtu-25dof-99.toml"
    (here / "my-arm.toml").write_bytes(robot.read_bytes())
    mesh = '[[obstacle]]\nkind = "mesh"\nfile = "cube.off"\nunits = "mm"\nposition = [500, 0, 0]\n'
    text = TEXT.format(units="mm").replace("sjtu-25dof", "my-arm.toml") + mesh
    (here / "a.toml").write_text(text)
    task = hognose.load_task(here / "a.toml")
    save_task(task.spec, there / "b.toml", Original.of(here / "a.toml"), here)
    found = hognose.load_task(there / "b.toml")
    assert found.spec.robot == "../here/my-arm.toml"
    assert found.robot.fingerprint == task.robot.fingerprint
    assert np.array_equal(found.scene.triangles, task.scene.triangles)
    (here / "cube.off").unlink()
    with pytest.raises(InputError, match=r"cube\.off.* is not there"):
        save_task(task.spec, there / "c.toml", Original.of(here / "a.toml"), here)
    assert not (there / "c.toml").exists()


def test_saving_from_the_workbench(tmp_path):
    task = hognose.load_task("detour")
    with Workbench(task, bundled_tasks()["detour"], folder=tmp_path) as bench:
        bench.edit(edits.set_margin(0.006))
        assert bench.dirty
        bench.save("mine.toml")
        assert not bench.dirty
        assert bench.source == tmp_path / "mine.toml"
        bench.edit(edits.set_margin(0.007))
        bench.save("mine.toml")
        bench.undo()
        bench.undo()
        assert bench.dirty
        bench.save_plan("plan.toml")
    assert hognose.load_task(tmp_path / "mine.toml").margin == 0.007
    assert hognose.Plan.load(tmp_path / "plan.parquet").task.spec == task.spec


def test_a_task_without_a_file_gets_a_complete_one(tmp_path):
    task = hognose.load_task("pipe-tank")
    with Workbench(task, folder=tmp_path) as bench:
        bench.save("new.toml")
    assert same(hognose.load_task(tmp_path / "new.toml").spec, task.spec)
