"""Obstacles in models for other programs: the same bounds and volumes, and everything that differs is said."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from model_makers import Mujoco, mj, task_on, volume
from robot_oracles import robot_of

from hognose.files import load_task
from hognose.files.exports import export
from hognose.files.exports.xml import distinct
from hognose.scene import Scene
from hognose.scene.moving import parts_of

ROBOT = robot_of()
#: Every kind of obstacle, and one far away, where short numbers would be coarse.
OBSTACLES = [
    {"kind": "sphere", "center": (0.3, 0.1, 0.2), "diameter": 0.1},
    {"kind": "cylinder", "start": (0, 0, 0.1), "end": (0.2, 0.3, 0.4), "diameter": 0.05},
    {"kind": "pipe", "start": (0, 1, 0.1), "end": (0.2, 1.3, 0.4), "diameter": 0.08, "wall": 0.01},
    {"kind": "box", "center": (1, 0, 0), "size": (0.1, 0.2, 0.3), "rotation_deg": (10, 20, 30)},
    {"kind": "box", "name": "far away", "center": (3000.0, 0, 0), "size": (0.1, 0.2, 0.3)},
    {"kind": "board", "center": (0, 0, 1), "normal": (0, 1, 1), "size": (0.6, 0.4), "thickness": 0.01,
     "hole": [{"center": (0.1, 0), "diameter": 0.1}, {"center": (-0.15, 0), "diameters": (0.1, 0.2), "angle_deg": 30}]},
    {"kind": "tank", "center": (0, -1, 0), "size": (0.5, 0.4, 0.6), "wall": 0.01, "rotation_deg": (0, 40, 0),
     "hole": [{"face": "-z", "center": (0, 0), "diameter": 0.1}]},
]  # fmt: skip


def a_task(*obstacles, **more):
    return task_on("slider", ROBOT, 0, obstacle=list(obstacles), **more)


def in_urdf(file: Path) -> dict[str, np.ndarray]:
    """The triangles (m, 3, 3) m of every visual of the root link, which are those to run into as well."""
    link = ElementTree.parse(file).getroot().find("link[@name='task']")
    assert link is not None
    found = {}
    for tag in ("visual", "collision"):
        for part in link.findall(tag):
            mesh, origin = part.find("geometry/mesh"), part.find("origin")
            assert mesh is not None
            assert origin is not None
            assert origin.get("rpy") == "0.0 0.0 0.0"
            loaded = trimesh.load_mesh(file.parent / mesh.get("filename", ""), process=False)
            shift = np.array(origin.get("xyz", "").split(), float)
            triangles = loaded.vertices[loaded.faces] + shift
            if tag == "visual":
                found[part.get("name", "")] = triangles
            else:
                np.testing.assert_array_equal(found[part.get("name", "")], triangles)
    return found


def solids(task) -> dict[str, np.ndarray]:
    return {part.name: part.triangles for part in parts_of(task.scene_at(0.0))}


def bounds(triangles):
    return np.array([triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))])


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The task of all obstacles, and the folder of its models."""
    folder, task = tmp_path_factory.mktemp("models"), a_task(*OBSTACLES)
    export(task, folder / "model.xml")
    export(task, folder / "model.urdf")
    return task, folder


def test_a_urdf_has_the_same_triangles(written):
    task, folder = written
    wanted, found = solids(task), in_urdf(folder / "model.urdf")
    assert list(found) == list(wanted)
    for name, triangles in wanted.items():
        assert len(found[name]) == len(triangles)
        tolerance = 1e-15 + np.spacing(np.abs(triangles).max())
        np.testing.assert_allclose(found[name], triangles, rtol=0, atol=tolerance)


def test_mujoco_has_the_same_bounds_and_volumes(written):
    task, folder = written
    model = Mujoco((folder / "model.xml").read_bytes())
    for name, triangles in solids(task).items():
        vertices, faces = model.mesh(name)
        size = np.ptp(bounds(triangles), axis=0).max()
        assert len(faces) == len(triangles)
        np.testing.assert_allclose(bounds(vertices[faces]), bounds(triangles), rtol=0, atol=1e-6 * size)
        middle = bounds(triangles).mean(axis=0)  # volumes of what is far from the origin lose digits
        np.testing.assert_allclose(volume(vertices[faces] - middle), volume(triangles - middle), rtol=1e-5)


def test_bundled_spaces_keep_their_bounds_and_volumes(tmp_path):
    for name in ("pipe-tank", "step-tank", "slanted-vessel"):
        task = load_task(name)
        export(task, tmp_path / "model.xml")
        export(task, tmp_path / "model.urdf")
        model, other = Mujoco((tmp_path / "model.xml").read_bytes()), in_urdf(tmp_path / "model.urdf")
        for part, triangles in solids(task).items():
            vertices, faces = model.mesh(part)
            np.testing.assert_allclose(bounds(other[part]), bounds(triangles), rtol=0, atol=1e-15)
            np.testing.assert_allclose(volume(other[part]), volume(triangles), rtol=1e-12)
            np.testing.assert_allclose(bounds(vertices[faces]), bounds(triangles), rtol=0, atol=1e-6)
            np.testing.assert_allclose(volume(vertices[faces]), volume(triangles), rtol=1e-4)


def test_a_ray_through_a_hole_meets_nothing(written):
    task, folder = written
    model = Mujoco((folder / "model.xml").read_bytes())
    board = task.spec.obstacle[5]
    mj.mj_forward(model.model, model.data)
    for (x, y), hits in (((0.1, 0.0), False), ((-0.15, 0.0), False), ((0.0, 0.15), True)):
        place = np.array(board.center) + board.frame @ [x, y, 0.1]
        geom = np.zeros(1, np.int32)
        distance = mj.mj_ray(model.model, model.data, place, -board.frame[:, 2], None, 1, -1, geom)
        met = 0 <= distance < 0.2 and model.model.geom(int(geom[0])).name == "board 1"
        assert met == hits


def test_what_moves_stands_where_it_is_at_time_0_and_that_is_said(tmp_path):
    motion = [{"time_s": -1.0, "position": (0, 0, 0)}, {"time_s": 3.0, "position": (0.4, 0, 0)}]
    task = a_task({**OBSTACLES[3], "name": "door", "motion": motion}, OBSTACLES[0])
    there = bounds(Scene.from_obstacles([task.spec.obstacle[0]]).triangles) + np.array([0.1, 0.0, 0.0])
    for suffix in (".xml", ".urdf"):
        done = export(task, tmp_path / f"model{suffix}")
        said = "obstacles that move in the task (door) stand here where they are at time 0"
        assert said in done.remarks
        assert said in re.sub(r"\s+", " ", (tmp_path / f"model{suffix}").read_text())
    np.testing.assert_allclose(bounds(in_urdf(tmp_path / "model.urdf")["door"]), there, atol=1e-15)
    vertices, faces = Mujoco((tmp_path / "model.xml").read_bytes()).mesh("door")
    np.testing.assert_allclose(bounds(vertices[faces]), there, atol=1e-7)


def test_points_and_thickness_keep_their_bounds_or_are_named(tmp_path):
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.1, 0.1, (50, 3))
    (tmp_path / "scan.xyz").write_text("\n".join(" ".join(map(repr, row)) for row in points.tolist()))
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "block.stl")
    task = a_task(
        {"kind": "points", "name": "scan", "file": str(tmp_path / "scan.xyz"), "units": "m", "diameter": 0.004},
        {"kind": "mesh", "name": "block", "file": str(tmp_path / "block.stl"), "units": "m", "tolerance": 0.0012},
    )
    done = export(task, tmp_path / "model.urdf")
    assert (
        done.remarks[0] == "points (scan) are octahedra here, with their corners on the balls that they are in the task"
    )
    assert done.remarks[1] == "meshes (block) are thickened on all sides in the task, by up to 1.2 mm, but not here"
    found = in_urdf(tmp_path / "model.urdf")
    np.testing.assert_allclose(bounds(found["scan"]), task.scene.bounds[0], rtol=0, atol=1e-15)
    assert volume(found["scan"]) == pytest.approx(50 * 4 / 3 * 0.002**3)
    np.testing.assert_allclose(bounds(found["block"]), task.scene.bounds[1] + [[0.0012], [-0.0012]], atol=1e-15)
    export(task, tmp_path / "model.xml")
    vertices, faces = Mujoco((tmp_path / "model.xml").read_bytes()).mesh("scan")
    np.testing.assert_allclose(bounds(vertices[faces]), task.scene.bounds[0], rtol=0, atol=1e-7)


@pytest.mark.parametrize("corners", [3, 4])
def test_an_open_surface_of_a_few_triangles_is_taken(corners, tmp_path):
    vertices = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0.0]])[:corners]
    trimesh.Trimesh(vertices, [[0, 1, 2], [2, 1, 3]][: corners - 2], process=False).export(tmp_path / "sheet.ply")
    sheet = {"kind": "mesh", "name": "sheet", "file": str(tmp_path / "sheet.ply"), "units": "m", "solid": False}
    export(a_task(sheet), tmp_path / "model.xml")
    placed, faces = Mujoco((tmp_path / "model.xml").read_bytes()).mesh("sheet")
    assert len(faces) == corners - 2
    np.testing.assert_allclose(bounds(placed[faces]), [vertices.min(axis=0), vertices.max(axis=0)], atol=1e-8)


NAMES = ["link_01", "tip", "a \"b\" <c> & 'd'", "x -- y ---", "-->", "größe 1", "/../..", "\ufffe", "\uffff", "task"]


def test_any_name_is_taken(tmp_path):
    boxes = [{**OBSTACLES[3], "name": name, "center": (k, 0, 0)} for k, name in enumerate(NAMES)]
    motion = [{"time_s": 0.0}, {"time_s": 3.0, "position": (0.4, 0, 0)}]
    task = a_task(*boxes[1:], {**boxes[0], "motion": motion}, {**boxes[4], "name": "-- moves --", "motion": motion},
                  name='a "task" -- <&>')  # fmt: skip
    export(task, tmp_path / "model.xml")
    export(task, tmp_path / "model.urdf")
    model, wanted = Mujoco((tmp_path / "model.xml").read_bytes()), distinct(task.scene_at(0.0).names)
    assert len(wanted) == len(NAMES) + 1
    found = in_urdf(tmp_path / "model.urdf")
    assert list(found) == wanted
    for name, triangles in zip(wanted, solids(task).values(), strict=True):
        vertices, faces = model.mesh(name)
        np.testing.assert_allclose(bounds(vertices[faces]), bounds(triangles), atol=1e-6)
        np.testing.assert_allclose(bounds(found[name]), bounds(triangles), atol=1e-14)
    assert sorted(p.parent.name for p in tmp_path.rglob("*.obj")) == ["meshes"] * len(list(tmp_path.rglob("*.obj")))


def test_names_that_are_alike_get_numbers():
    assert distinct(["a", "a", "a (2)", "b", "\x00", "\ud800"]) == [
        "a",
        "a (2)",
        "a (2) (2)",
        "b",
        "\ufffd",
        "\ufffd (2)",
    ]
