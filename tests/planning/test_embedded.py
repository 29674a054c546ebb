"""A plan carries the content of mesh and point files: it needs them no more, and notices when it was changed."""

import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import trimesh
from plan_file_makers import rewritten

import hognose
from hognose.files import bundled_tasks
from hognose.files.exports import export
from hognose.planning import run_checks
from hognose.planning.embedded import PREFIX

TASK = """
name = "files"
units = "mm"
robot = "sjtu-25dof"
[path]
way_points = [[0, 0, 0], [0, 0, 150]]
[[obstacle]]
kind = "mesh"
file = "parts/ball.stl"
units = "m"
position = [200, 0, 100]
[[obstacle]]
kind = "mesh"
name = "other ball"
file = "parts/ball.stl"
units = "cm"
scale = 100
position = [-200, 0, 100]
[[obstacle]]
kind = "points"
file = "scan.xyz"
units = "mm"
diameter = 3
[[obstacle]]
kind = "sphere"
center = [0, 300, 0]
diameter = 10
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "parts").mkdir()
    ball = trimesh.creation.icosphere(3, 0.1)
    ball.update_faces(np.arange(len(ball.faces)) != 5)
    ball.export(tmp_path / "parts" / "ball.stl")
    np.savetxt(tmp_path / "scan.xyz", np.random.default_rng(0).normal(size=(500, 3)) * 10 + [0, 150, 60])
    (tmp_path / "task.toml").write_text(TASK)
    return tmp_path


@pytest.fixture
def plan(folder):
    return hognose.plan(hognose.load_task(folder / "task.toml"))


def entries(file: Path) -> dict[bytes, bytes]:
    return dict(pq.ParquetFile(file).metadata.metadata)


def test_a_plan_is_checked_and_shown_without_the_files(plan, folder, tmp_path):
    plan.save(folder / "plan.parquet")
    shutil.rmtree(folder / "parts")
    (folder / "scan.xyz").unlink()
    (folder / "task.toml").unlink()
    read = hognose.Plan.load(folder / "plan.parquet")
    assert read.task.spec == plan.task.spec
    assert read.scene.names == ("ball", "other ball", "scan", "sphere 1") == plan.scene.names
    assert read.scene.triangles.tobytes() == plan.scene.triangles.tobytes()
    assert run_checks(read) == plan.checks
    assert read.summary() == plan.summary()
    assert "note: other ball: not watertight: 3 open edges" in read.summary()
    read.save(folder / "again.parquet")
    assert (folder / "again.parquet").read_bytes() == (folder / "plan.parquet").read_bytes()
    (folder / "task.toml").write_text(TASK)
    with pytest.raises(hognose.InputError, match=r"obstacle\[1\]"):
        hognose.load_task(folder / "task.toml")


def test_a_geometry_is_kept_once_and_other_readers_see_plain_columns(plan, folder):
    plan.save(folder / "plan.parquet")
    held = entries(folder / "plan.parquet")
    assert sum(key.startswith(PREFIX.encode()) for key in held) == 2
    assert all(value.isascii() for value in held.values())
    said = json.loads(held[b"hognose"])
    assert [digest is None for digest in said["geometry"]] == [False, False, False, True]
    assert pq.read_table(folder / "plan.parquet").num_columns > 100
    export(plan, folder / "plan.json")
    assert json.loads((folder / "plan.json").read_text())["hognose"]["geometry"] == said["geometry"]


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda key, value: None, "the plan file does not hold the geometry of 'parts/ball.stl'"),
        (lambda key, value: value[:-40], "is damaged"),
        (lambda key, value: value[: len(value) // 2] + b"!!" + value[len(value) // 2 :], "is damaged"),
        (lambda key, value: b"{}", "is damaged"),
        (lambda key, value: value.replace(b'"first": 0, "last": 1279', b'"first": 0, "last": 1278'), "is damaged"),
        (lambda key, value: value.replace(b'"open_edges": 3', b'"open_edges": 0'), "is not the one"),
    ],
)
def test_a_changed_geometry_is_noticed(change, complaint, plan, folder):
    plan.save(folder / "plan.parquet")
    key = f"{PREFIX}{plan.task.spec.obstacle[0].geometry.digest}".encode()

    def alter(held):
        value = change(key, held.pop(key))
        if value is not None:
            held[key] = value

    file = folder / "plan.parquet"
    file.write_bytes(rewritten(file, change_entries=alter))
    with pytest.raises(hognose.InputError) as caught:
        hognose.Plan.load(file)
    assert complaint in str(caught.value)
    assert str(caught.value).startswith(str(file))


def test_the_step_tank_is_planned_and_its_parts_are_named(tmp_path):
    made = hognose.plan(hognose.load_task("step-tank"))
    assert made.good
    assert bundled_tasks()["step-tank"].with_name("step_tank.step").stat().st_size < 300_000
    closest = made.check("clearance_at_steps").detail
    assert "closest to tank: " in closest
    made.save(tmp_path / "plan.parquet")
    assert run_checks(hognose.Plan.load(tmp_path / "plan.parquet")) == made.checks
