"""`hognose scene`: what a person sees of a file before planning with it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from hognose.files import bundled_tasks

STEP_TANK = bundled_tasks()["step-tank"].with_name("step_tank.step")


def box() -> Any:
    made = trimesh.creation.box((200, 300, 400))
    made.apply_translation([10, 20, 30])
    return made


def stl(folder: Path, mesh: Any) -> Path:
    mesh.export(folder / "file.stl")
    return folder / "file.stl"


def test_it_shows_the_bodies_of_a_step_file(run):
    done = run("scene", STEP_TANK)
    assert (done.code, done.err) == (0, "")
    first, second, *rest = done.out.splitlines()
    assert first.startswith(f"{STEP_TANK}: ")
    assert "triangles; numbers in m, as the file says" in first
    assert second.startswith("size 660 × 6")
    assert sum("yes" in line.split() for line in rest) == 8
    assert any("step_tank: baffle" in line for line in rest)
    assert "note:" not in done.out


def test_it_says_all_as_json(run, tmp_path):
    done = run("scene", stl(tmp_path, box()), "--units", "mm", "--json")
    (item,) = done.json["items"]
    assert (done.code, done.err) == (0, "")
    assert done.json["units"] == "mm"
    assert done.json["units_from"] == "asked"
    assert done.json["remarks"] == []
    np.testing.assert_allclose(item["size_m"], [0.2, 0.3, 0.4], atol=1e-8)
    np.testing.assert_allclose(done.json["low_m"], [-0.09, -0.13, -0.17], atol=1e-8)
    assert item["volume_m3"] == pytest.approx(0.024, rel=1e-6)
    assert (item["triangles"], item["points"], item["watertight"]) == (12, 0, True)
    assert item["repairs"] == ["28 vertices merged"]


def test_a_file_that_does_not_say_its_unit_is_shown_in_all(run, tmp_path):
    done = run("scene", stl(tmp_path, box()))
    assert "numbers in mm, assumed: the file does not say" in done.out
    assert "longest side is 0.4 m in mm, 4 m in cm, 400 m in m, 10.16 m in in" in done.out


def test_what_is_wrong_is_noted(run, tmp_path):
    inside_out = box()
    inside_out.invert()
    inside_out.update_faces(np.arange(12) != 3)
    done = run("scene", stl(tmp_path, inside_out), "--units", "m")
    assert done.code == 0
    assert "NO" in done.out
    notes = [line for line in done.out.splitlines() if line.startswith("note: ")]
    assert len(notes) == 3
    assert "not watertight: 3 open edges" in notes[0]
    assert "normals seem to point inwards" in notes[1]
    assert "400 m long: is that so? Its numbers are read as m; it would be 0.4 m in mm" in notes[2]


def test_point_clouds_and_tasks_are_shown_too(run, tmp_path):
    (tmp_path / "scan.xyz").write_text("0 0 0\n100 0 0\n0 100 50\n")
    done = run("scene", tmp_path / "scan.xyz", "--units", "mm")
    assert "3 points" in done.out
    assert "size 100 × 100 × 50 mm" in done.out
    trimesh.PointCloud(np.eye(3)).export(str(tmp_path / "scan.ply"))
    assert run("scene", tmp_path / "scan.ply", "--units", "m", "--json").json["items"][0]["points"] == 3
    done = run("scene", "pipe-tank")
    assert [line.split("  ")[0] for line in done.out.splitlines()[4:]] == [
        "tank", "pipe 1", "pipe 2", "pipe 3", "back board",
    ]  # fmt: skip
    assert run("scene", "step-tank", "--json").json["items"][0]["name"] == "tank: shell"


@pytest.mark.parametrize(
    ("name", "more", "complaint"),
    [
        ("none.stl", (), "none.stl: no such file"),
        ("cut.stl", (), "it says it has 12 triangles, and ends after 5"),
        ("whole.stl", ("--units", "furlong"), "--units: 'furlong' is unknown; expected one of mm, cm, m, in"),
        ("what.dwg", (), "An AutoCAD drawing (.dwg) is not read: export its solids there as STEP"),
        ("tank.step", ("--units", "mm"), "STEP files say their unit"),
        ("no-such-task", (), "no such file, and no bundled task of that name"),
        ("pipe-tank", ("--units", "mm"), "a task file says its own"),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_wrong_input_is_one_message(name, more, complaint, as_json, run, tmp_path):
    whole = stl(tmp_path, box()).read_bytes()
    (tmp_path / "whole.stl").write_bytes(whole)
    (tmp_path / "cut.stl").write_bytes(whole[:350])
    (tmp_path / "what.dwg").write_bytes(b"AC1027")
    (tmp_path / "tank.step").write_bytes(STEP_TANK.read_bytes())
    done = run("scene", name, *more, *(["--json"] if as_json else []))
    assert done.code == 2
    assert complaint in (json.loads(done.out)["error"] if as_json else done.err)
    assert (done.err == "") == as_json


def test_check_names_the_part_that_is_close(run):
    assert run("plan", "step-tank").code == 0
    done = run("check", "step-tank.parquet")
    assert done.code == 0
    assert "closest to tank: " in done.out
