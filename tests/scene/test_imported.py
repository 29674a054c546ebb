"""Obstacles from files: names of bodies, placement, points as balls, thickened surfaces."""

import logging
import sys
from typing import Any

import coal as coal_module
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from import_makers import EXAMPLES, MIDDLE, SIZE, STEP, box, content, exported, written
from scene_oracles import brute_distance
from scipy.spatial.transform import Rotation

from hognose.errors import InputError, MissingExtraError
from hognose.scene import Box, Mesh, Points, Scene
from hognose.scene.part import Part

coal: Any = coal_module  # it comes without types
seeds = st.integers(0, 2**32 - 1)


def names(file, **more):
    return Scene.from_obstacles([Mesh(file=str(file), **more)]).names


def two(names_of, **placed):
    """A scene of the box under some names, 1 m apart along x."""
    scene = trimesh.Scene()
    for number, name in enumerate(names_of):
        matrix = trimesh.transformations.translation_matrix([number, 0, 0])
        scene.add_geometry(box(SIZE / 1e3, MIDDLE / 1e3), node_name=name, geom_name="shape", transform=matrix)
    return scene


def test_nodes_of_a_glb_are_bodies_where_their_transforms_put_them(tmp_path):
    file = tmp_path / "tank.glb"
    scene = two(["lid", "wall"])
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])
    turn[:3, :3] *= 2.0
    turn[:3, 3] = 0, 5, 0
    scene.add_geometry(box(SIZE / 1e3, MIDDLE / 1e3), node_name="turned", geom_name="shape", transform=turn)
    mirror = np.diag([-1.0, 1, 1, 1])
    mirror[:3, 3] = 0, 0, 7
    scene.add_geometry(box(SIZE / 1e3, MIDDLE / 1e3), node_name="mirrored", geom_name="shape", transform=mirror)
    scene.export(file)
    read = Scene.from_obstacles([Mesh(file=str(file))])
    assert sorted(read.names) == ["tank: lid", "tank: mirrored", "tank: turned", "tank: wall"]
    middle, half = MIDDLE / 1e3, SIZE / 2e3
    expected = {
        "lid": (middle - half, middle + half),
        "wall": (middle - half + [1, 0, 0], middle + half + [1, 0, 0]),
        "turned": ([-2 * 0.17, 5 - 2 * 0.09, -0.34], [2 * 0.13, 5 + 2 * 0.11, 0.46]),
        "mirrored": ([-0.11, -0.13, 7 - 0.17], [0.09, 0.17, 7 + 0.23]),
    }
    for name, (low, high) in expected.items():
        np.testing.assert_allclose(read.bounds[read.names.index(f"tank: {name}")], [low, high], atol=1e-6)
    assert all("turned round" not in words for words in Mesh(file=str(file)).geometry.repairs)
    inside = read.inside([(np.add(low, high) / 2).tolist() for low, high in expected.values()])
    assert [read.names[k] for k in inside] == [f"tank: {name}" for name in expected]


def test_a_gltf_brings_its_other_file_and_compressed_ones_are_refused(tmp_path):
    files: Any = two(["lid", "wall"]).export(file_type="gltf")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    (gltf,) = tmp_path.glob("*.gltf")
    assert names(gltf) == (f"{gltf.stem}: lid", f"{gltf.stem}: wall")
    text = gltf.read_text()
    for buffer in tmp_path.glob("*.bin"):
        buffer.unlink()
    with pytest.raises(InputError, match=f"{gltf.name}: refers to the file '.*bin', which is not there; bring both"):
        names(gltf)
    gltf.write_text(text.replace("{", '{"extensionsRequired": ["KHR_draco_mesh_compression"],', 1))
    with pytest.raises(InputError, match=r"is compressed \(KHR_draco_mesh_compression\), which is not read"):
        names(gltf)


def test_curves_of_a_file_are_left_out_and_said_to_be(tmp_path):
    scene = two(["lid"])
    scene.add_geometry(trimesh.load_path([[0, 0, 0], [1, 1, 1]]))
    scene.export(tmp_path / "drawn.glb")
    item = Mesh(file=str(tmp_path / "drawn.glb"))
    assert Scene.from_obstacles([item]).names == ("drawn",)
    assert item.remarks() == ["drawn: 1 primitive of lines left out"]


def test_objects_and_groups_of_an_obj_are_bodies_without_its_materials(tmp_path):
    one = content("obj").decode().splitlines()
    points, faces = ([line for line in one if line.startswith(kind)] for kind in ("v ", "f "))
    faces = [line.split("#")[0] for line in faces]
    text = ["mtllib missing.mtl", "o lid", *points, "usemtl red", *faces[:6], "g sub", *faces[6:], "o wall"]
    text += [" ".join(["v", *(str(float(x) + 1000) for x in line.split()[1:4])]) for line in points]
    text += ["f " + " ".join(f"{int(part.split('/')[0]) - 9}" for part in line.split()[1:]) for line in faces]
    text += ["g sub", "f 1/1/1 2//2 3/3"]
    file = tmp_path / "tank.obj"
    file.write_text("\r\n".join(text))
    item = Mesh(file=str(file), units="mm", name="vessel")
    scene = Scene.from_obstacles([item])
    # The lid and the group are halves of one box, and enclose nothing each by itself.
    assert scene.names == ("vessel: lid + sub", "vessel: wall")
    assert np.bincount(scene.owner).tolist() == [13, 12]
    np.testing.assert_allclose(scene.bounds[1], 1e-3 * (np.array([MIDDLE - SIZE / 2, MIDDLE + SIZE / 2]) + 1000))


def test_solids_of_one_stl_and_doubled_names_are_told_apart(tmp_path):
    one = content("stl ascii").decode().split("\n", 1)[1].rsplit("endsolid", 1)[0]
    file = tmp_path / "parts.stl"
    file.write_text(f"solid lid\n{one}endsolid lid\nsolid wall\n{one}endsolid wall\n")
    assert names(file, units="mm") == ("parts: lid", "parts: wall")
    glb = tmp_path / "twins.glb"
    two(["a", "b"]).export(glb)
    glb.write_bytes(glb.read_bytes().replace(b'"name":"b"', b'"name":"a"'))
    assert len(set(names(glb))) == 2
    obstacles = [Mesh(file=str(glb)), Mesh(file=str(glb), position=(0, 1, 0)), Box(center=(0, 0, 0), size=(1, 1, 1))]
    called = Scene.from_obstacles(obstacles).names
    assert called[:2] == names(glb)
    assert all(name.startswith("twins 2: ") for name in called[2:4])
    assert called[4] == "box 1"
    with pytest.raises(InputError, match='2 obstacles are called "t: '):
        Scene.from_obstacles([Mesh(file=str(glb), name="t"), Mesh(file=str(glb), name="t")])


@given(seed=seeds)
@settings(max_examples=20, deadline=None)
def test_a_mesh_is_scaled_then_turned_then_moved(seed, tmp_path_factory):
    rng = np.random.default_rng(seed)
    file = written(tmp_path_factory.mktemp("placed"), "stl", content("stl"))
    turn, move, scale = rng.uniform(-180, 180, 3), rng.uniform(-2, 2, 3), rng.uniform(0.1, 3)
    item = Mesh(file=str(file), units="cm", position=tuple(move), rotation_deg=tuple(turn), scale=scale)
    local = Mesh(file=str(file), units="cm").triangles()
    matrix = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
    np.testing.assert_allclose(item.triangles(), scale * local @ matrix.T + move, atol=1e-12)


@given(seed=seeds, count=st.integers(1, 300))
@settings(max_examples=30, deadline=None)
def test_points_are_balls(seed, count, tmp_path_factory):
    rng = np.random.default_rng(seed)
    file = tmp_path_factory.mktemp("cloud") / "scan.xyz"
    points, diameter = rng.uniform(-1, 1, (count, 3)), rng.uniform(0.001, 0.3)
    np.savetxt(file, points, fmt="%.17g")
    cube = Box(center=(2, 0, 0), size=(1, 1, 1))
    scene = Scene.from_obstacles([Points(file=str(file), units="m", diameter=diameter), cube])
    starts = rng.uniform(-2, 2, (40, 3))
    ends = np.where(rng.uniform(size=(40, 1)) < 0.3, starts, starts + rng.normal(size=(40, 3)) * 0.3)
    to_points = brute_distance(starts, ends, np.repeat(points[:, None], 3, axis=1)).min(axis=1)
    to_cube = brute_distance(starts, ends, cube.triangles()).min(axis=1)
    expected = np.minimum(np.maximum(to_points - diameter / 2, 0), to_cube)
    found = scene.distance(starts, ends)
    np.testing.assert_allclose(found.value, expected, atol=1e-12)
    apart = np.linalg.norm(found.on_segment - found.on_mesh, axis=1)
    np.testing.assert_allclose(apart, expected, atol=1e-9)
    moving = scene.clearance(starts[:, None], ends[:, None], [0.02], horizon=0.5).value[:, 0]
    np.testing.assert_allclose(moving, np.minimum(expected - 0.02, 0.5), atol=1e-12)

    tested = np.concatenate([starts, points + 0.4 * diameter * np.array([0, 0, 1]), points])
    nearest = np.linalg.norm(tested[:, None] - points, axis=2).min(axis=1)
    clear_cut = np.abs(nearest - diameter / 2) > 1e-9
    in_ball = (nearest < diameter / 2)[clear_cut]
    answer = scene.inside(tested)[clear_cut]
    assert (answer[in_ball] >= 0).all()
    assert (answer[~in_ball] != 0).all()


@given(seed=seeds)
@settings(max_examples=15, deadline=None)
def test_a_thickened_mesh_is_that_much_closer(seed, tmp_path_factory):
    rng = np.random.default_rng(seed)
    file = written(tmp_path_factory.mktemp("thick"), "stl", content("stl"))
    thin, thick = (Scene.from_obstacles([Mesh(file=str(file), units="mm", tolerance=t)]) for t in (0.0, 0.004))
    starts = rng.uniform(-0.4, 0.4, (60, 3))
    ends = starts + 0.1 * rng.normal(size=(60, 3))
    expected = np.maximum(thin.distance(starts, ends).value - 0.004, 0)
    np.testing.assert_allclose(thick.distance(starts, ends).value, expected, atol=1e-12)
    np.testing.assert_allclose(thick.bounds[0], thin.bounds[0] + np.array([[-0.004], [0.004]]))


def test_coal_agrees_on_a_scan_of_spheres():
    rng = np.random.default_rng(11)
    points = rng.uniform(-0.2, 0.2, (60, 3))
    parts = [coal.Sphere(0.01)] * 60
    scene = Scene.from_parts([Part("scan", np.repeat(points[:, None], 3, axis=1), 0.01)])
    for start in rng.uniform(-0.5, 0.5, (30, 3)):
        end = start + np.array([0, 0, 0.09])
        pose = coal.Transform3s(np.eye(3), (start + end) / 2)
        theirs = min(
            coal.distance(
                coal.Capsule(0.01, 0.09), pose, ball, coal.Transform3s(np.eye(3), point),
                coal.DistanceRequest(), coal.DistanceResult(),
            )
            for ball, point in zip(parts, points, strict=True)
        )  # fmt: skip
        ours = scene.distance([start], [end]).value[0] - 0.01
        if ours > 1e-4:
            assert theirs == pytest.approx(ours, abs=2e-6)


@pytest.mark.parametrize(
    "text",
    ["0 0 0\n10 0 0\n0 10 5\n", "x,y,z\n0,0,0\n10,0,0\n0,10,5", "# a scan\n0;0;0;255\n\n10;0;0;1\n// end\n0;10;5;3\n"],
    ids=["xyz", "csv", "with more"],
)
def test_texts_of_points(text, tmp_path):
    (tmp_path / "scan.csv").write_text(text)
    item = Points(file=str(tmp_path / "scan.csv"), units="mm", diameter=0.002, position=(1, 0, 0))
    np.testing.assert_allclose(item.triangles()[:, 1], [[1, 0, 0], [1.01, 0, 0], [1, 0.01, 0.005]])
    assert item.geometry.is_cloud


@pytest.mark.parametrize(
    ("name", "data", "complaint"),
    [
        ("a.xyz", b"1 2 3\n4 5\n", "line 2 is '4 5'; expected x y z"),
        ("a.xyz", b"1 2 3\n4 five 6\n7 8 9", "line 2: 'five' is not a number"),
        ("a.xyz", b"1 2 3\n4 nan 6\n", "1 of 2 corners or points have coordinates that are not finite"),
        ("a.xyz", b"x y z\n", "holds no points"),
        ("a.xyz", b"PK\0\0\0\0", "not a text file"),
        ("a.xyz", b"", "the file is empty"),
        ("a.ply", content("ply"), 'is an obstacle of kind = "mesh"'),
        ("a.rcp", b"1 2 3", "A scan in another format (.rcp) is not read: open it in CloudCompare"),
    ],
)
def test_wrong_clouds_are_refused(name, data, complaint, tmp_path):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError) as caught:
        assert Points(file=str(tmp_path / name), units="mm", diameter=0.001).geometry
    assert complaint in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / name))


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_points_of_a_ply_and_doubles_among_them(encoding, tmp_path):
    points = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)
    data = exported(trimesh.PointCloud(np.concatenate([points, points[:7]])), "ply", encoding=encoding)
    (tmp_path / "scan.ply").write_bytes(data)
    item = Points(file=str(tmp_path / "scan.ply"), units="m", diameter=0.01)
    read = item.triangles()[:, 0]
    tolerance = 1e-6 if encoding == "ascii" else 0
    assert len(read) == 50
    np.testing.assert_allclose(read[np.lexsort(read.T)], points[np.lexsort(points.T)], atol=tolerance)
    assert item.geometry.notes == ("7 points that were there twice dropped",)
    with pytest.raises(InputError, match=r'holds 57 points but no triangles: .* kind = "points"'):
        assert Mesh(file=str(tmp_path / "scan.ply"), units="m").geometry


def test_the_step_tank_is_what_its_maker_says():
    item = Mesh(file=str(EXAMPLES / "step_tank.step"), name="tank")
    assert (EXAMPLES / "step_tank.step").read_text() == STEP["step_file"](STEP["tank"]())
    assert item.geometry.watertight
    scene = Scene.from_obstacles([item])
    bodies = {f"tank: {body.name}": body for body in STEP["tank"]()}
    assert set(scene.names) == set(bodies)
    for k, name in enumerate(scene.names):
        body = bodies[name]
        normal = np.cross(body.x, body.y)
        area = _area(body.outline) - sum(_area(hole) for hole in body.holes)
        volume = np.linalg.det(scene.triangles[scene.owner == k]).sum() / 6
        assert volume == pytest.approx(area * body.height * 1e-9, rel=5e-3), name
        along = (scene.triangles[scene.owner == k] @ normal).ravel()
        assert [along.min(), along.max()] == pytest.approx(
            [1e-3 * np.dot(body.origin, normal), 1e-3 * (np.dot(body.origin, normal) + body.height)], abs=1e-6
        )


def _area(loop):
    if hasattr(loop, "radius"):
        return np.pi * loop.radius**2
    x, y = np.transpose(loop)
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


@pytest.mark.parametrize("tolerance", [2e-5, 5e-4, 5e-3])
def test_thickened_triangles_of_a_step_file_contain_its_round_solids(tolerance):
    item = Mesh(file=str(EXAMPLES / "step_tank.step"), tolerance=tolerance)
    scene = Scene.from_obstacles([item])
    turns = np.linspace(0, 2 * np.pi, 999)
    circle = np.column_stack([np.cos(turns), np.sin(turns), np.full_like(turns, 0.2)])
    for radius in (0.292, 0.3):  # of the shell, inside and outside
        points = circle * [radius, radius, 1]
        assert scene.distance(points, points).value.max() <= 0, tolerance
    off = circle * [0.3 + 3 * tolerance, 0.3 + 3 * tolerance, 1]
    assert scene.distance(off, off).value.min() > 0


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cascadio", None)
    with pytest.raises(MissingExtraError, match=r"step_tank\.step: .*pip install 'hognose\[step\]'"):
        assert Mesh(file=str(EXAMPLES / "step_tank.step"), tolerance=1.23e-4).geometry


def test_a_damaged_step_file_prints_nothing_of_its_own(tmp_path, capfd):
    data = (EXAMPLES / "step_tank.step").read_text().replace("ADVANCED_FACE", "ADVANCED_FARCE")
    (tmp_path / "bad.step").write_text(data)
    with pytest.raises(InputError, match=r"bad\.step: "):
        assert Mesh(file=str(tmp_path / "bad.step")).geometry
    assert capfd.readouterr() == ("", "")
    assert not logging.getLogger("trimesh").disabled


def test_an_assembly_of_another_cad_kernel_in_inches_is_where_it_should_be():
    """Written with OpenCASCADE: a plate with three bolts, twice, once turned about x; a ball; a ring."""
    item = Mesh(file=str(EXAMPLES.parent / "tests" / "data" / "assembly_inch.step"), name="machine")
    scene = Scene.from_obstacles([item])
    assert item.geometry.watertight
    found = {name: scene.bounds[k] for k, name in enumerate(scene.names)}
    assert len(found) == 10
    grown = np.array([[-5e-5], [5e-5]])
    for name, low, high, round_by in (
        ("plate", (1.0, -0.01, 0), (1.2, 0, 0.1), 0), ("plate 2", (0, 0, 0.5), (0.2, 0.1, 0.51), 0),
        ("ball", (-0.05, -0.05, -0.05), (0.05, 0.05, 0.05), 6e-5),
        ("ring", (-0.09, 0.21, -0.01), (0.09, 0.39, 0.01), 6e-5),
        ("bolt 5", (0.085, 0.045, 0.51), (0.095, 0.055, 0.55), 6e-5),
        ("bolt 3", (1.135, -0.05, 0.045), (1.145, -0.01, 0.055), 6e-5),
    ):  # fmt: skip
        np.testing.assert_allclose(found[f"machine: {name}"] - grown, [low, high], atol=round_by + 1e-7)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(5000, 3))
    surface = 0.05 * directions / np.linalg.norm(directions, axis=1)[:, None]
    assert scene.distance(surface, surface).value.max() == 0
    outside = surface * 1.003
    assert scene.distance(outside, outside).value.min() > 0
