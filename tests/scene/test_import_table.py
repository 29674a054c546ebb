"""Every format of meshes with every defect: what is right, or a message that names the file and says what to do."""

import os
import struct

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from import_makers import (
    FORMATS,
    MIDDLE,
    SIZE,
    box,
    content,
    empty_of,
    suffix_of,
    text_of,
    units_of,
    with_vertex,
    written,
)

from hognose.errors import HognoseError, InputError
from hognose.scene import Mesh, Scene

TEXTS = ["obj", "ply ascii", "off"]


def read(file, kind, **more):
    """The obstacle of a file, with its content."""
    item = Mesh(file=str(file), units=units_of(kind), **more)
    assert item.geometry is not None
    return item


def outcome(action):
    """What an action returns, or the error of ours that it raises; any other escapes."""
    try:
        return action()
    except HognoseError as error:
        return error


def refusal(file, kind):
    with pytest.raises(InputError) as caught:
        read(file, kind)
    said = str(caught.value)
    assert said.startswith(str(file)), said
    assert "Traceback" not in said
    return said


@pytest.mark.parametrize("kind", FORMATS)
def test_a_whole_file_is_what_it_shows(kind, tmp_path):
    item = read(written(tmp_path, kind, content(kind)), kind)
    scene = Scene.from_obstacles([item])
    np.testing.assert_allclose(scene.triangles.min(axis=(0, 1)), 1e-3 * (MIDDLE - SIZE / 2), atol=1e-7)
    np.testing.assert_allclose(scene.triangles.max(axis=(0, 1)), 1e-3 * (MIDDLE + SIZE / 2), atol=1e-7)
    assert len(scene.triangles) == 12
    (body,) = item.geometry.bodies
    assert body.watertight
    volume = np.linalg.det(scene.triangles).sum() / 6
    assert volume == pytest.approx(SIZE.prod() * 1e-9, rel=1e-5)
    assert scene.names == ("file",)
    assert item.remarks() == []
    points = 1e-3 * (MIDDLE + SIZE * np.array([[0.49, 0, 0], [0.51, 0, 0], [0, -0.49, 0.49], [0, 0, -0.51]]))
    np.testing.assert_array_equal(scene.inside(points), [0, -1, 0, -1])


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("blank", [b"", b"\n \n", bytes(500)], ids=["nothing", "blanks", "zeros"])
def test_an_empty_file_is_refused(kind, blank, tmp_path):
    assert "the file is empty" in refusal(written(tmp_path, kind, blank), kind)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_file_without_triangles_is_refused(kind, tmp_path):
    said = refusal(written(tmp_path, kind, empty_of(kind)), kind)
    assert any(words in said for words in ("no triangles", "damaged", "the file is empty", "OpenCASCADE"))


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.9, 0.97])
def test_a_cut_file_is_refused(kind, share, tmp_path):
    data = content(kind, None if kind == "step" else trimesh.creation.icosphere(2, 100))
    cut = data[: int(share * len(data))]
    if kind == "obj":  # has neither a count nor an end: a cut within the faces shows only in the last of them
        cut = b"\n".join(cut.splitlines()[:-1]) + b"\nf 1 2"
    said = refusal(written(tmp_path, kind, cut), kind)
    assert any(words in said for words in ("cut", "not a", "no triangles", "damaged", "expected three"))


@pytest.mark.parametrize("kind", FORMATS)
@given(data=st.binary(min_size=1, max_size=400))
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_garbage_is_refused(kind, data, tmp_path):
    refusal(written(tmp_path, kind, data), kind)
    refusal(written(tmp_path, kind, content(kind)[:40] + data), kind)


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "step"])
@given(data=st.data())
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_flipped_bytes_give_a_scene_or_a_reason(kind, data, tmp_path):
    damaged = bytearray(content(kind))
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    file = written(tmp_path, kind, bytes(damaged))
    answer = outcome(lambda: Scene.from_obstacles([read(file, kind)]))
    if isinstance(answer, Scene):
        assert len(answer.triangles)
        assert np.isfinite(answer.triangles).all()
    else:
        assert str(file) in str(answer)


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "step"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_coordinate_that_is_no_number_is_refused(kind, value, tmp_path):
    assert "not finite" in refusal(written(tmp_path, kind, with_vertex(kind, value)), kind)


@pytest.mark.parametrize("kind", ["stl", "ply", "glb"])
def test_a_number_that_signals_is_refused_without_a_warning(kind, tmp_path):
    quiet, signalling = struct.pack("<f", np.nan), bytes.fromhex("0100807f")
    data = with_vertex(kind, np.nan)
    assert quiet in data
    assert "not finite" in refusal(written(tmp_path, kind, data.replace(quiet, signalling)), kind)


@pytest.mark.parametrize("kind", FORMATS)
def test_missing_folders_and_unreadable_files_are_named(kind, tmp_path, monkeypatch):
    file = tmp_path / f"file{suffix_of(kind)}"
    assert refusal(file, kind).endswith("no such file")
    file.mkdir()
    assert "is a folder, expected a file" in refusal(file, kind)
    file.rmdir()
    written(tmp_path, kind, content(kind))

    def locked(path, *more):  # the system is made to refuse: whoever runs the tests may be allowed everything
        raise PermissionError(13, os.strerror(13), str(path))

    monkeypatch.setattr("os.open", locked)
    assert refusal(file, kind).endswith(f"cannot read: {os.strerror(13)}")


@pytest.mark.parametrize("name", ["part.dwg", "part", "part.stl.zip", "part.iges", "a" * 300, "a" * 300 + ".stl"])
def test_other_names_are_refused(name):
    with pytest.raises(InputError, match=r"no such file|Expected|cannot read"):
        assert Mesh(file=name, units="mm").geometry
    with pytest.raises(ValueError, match="holds a control character"):
        Mesh(file=f"\0{name}", units="mm")


@pytest.mark.parametrize("kind", TEXTS)
def test_quads_and_polygons_become_triangles(kind, tmp_path):
    prism = trimesh.creation.cylinder(50, 100, sections=7)
    turns = np.arange(7) * 2 * np.pi / 7
    rim = 50 * np.column_stack([np.cos(turns), np.sin(turns)])
    vertices = np.concatenate([np.column_stack([rim, np.full(7, z)]) for z in (-50, 50)])
    around = [(k, (k + 1) % 7, (k + 1) % 7 + 7, k + 7) for k in range(7)]
    faces = [*around, tuple(range(6, -1, -1)), tuple(range(7, 14))]
    item = read(written(tmp_path, kind, text_of(kind, vertices, faces)), kind)
    (body,) = item.geometry.bodies
    assert body.watertight
    assert len(item.geometry.faces) == 7 * 2 + 5 * 2
    assert body.volume == pytest.approx(prism.volume, rel=1e-6)


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "step"])
def test_a_leaky_box_is_allowed_and_said_to_be_one(kind, tmp_path):
    ball = trimesh.creation.icosphere(2, 100)
    ball.update_faces(np.arange(len(ball.faces)) != 17)
    item = read(written(tmp_path, kind, content(kind, ball)), kind)
    (body,) = item.geometry.bodies
    assert (body.watertight, body.open_edges, body.twisted_edges) == (False, 3, 0)
    (remark,) = item.remarks()
    assert "file: not watertight: 3 open edges" in remark
    assert Scene.from_obstacles([item]).inside([[0, 0, 0], [0.2, 0, 0]]).tolist() == [0, -1]


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "step"])
def test_a_closed_box_inside_out_is_turned_round(kind, tmp_path):
    inside_out = box()
    inside_out.invert()
    item = read(written(tmp_path, kind, content(kind, inside_out)), kind)
    (body,) = item.geometry.bodies
    assert body.volume == pytest.approx(SIZE.prod() * (1 if units_of(kind) or kind == "3mf" else 1e-9), rel=1e-5)
    assert any("turned round" in words for words in body.repairs)
    assert Scene.from_obstacles([item]).inside([1e-3 * MIDDLE]).tolist() == [0]


@pytest.mark.parametrize("kind", [*TEXTS, "stl ascii"])
def test_collapsed_and_doubled_triangles_are_dropped(kind, tmp_path):
    mesh = box()
    faces = np.concatenate([mesh.faces, mesh.faces[2:4], [[0, 0, 1]], [[5, 5, 5]]])
    # 0 and 1 must be an edge of the box.
    assert any({0, 1} <= set(face) for face in mesh.faces.tolist())
    item = read(written(tmp_path, kind, text_of(kind, mesh.vertices, faces)), kind)
    assert len(item.geometry.faces) == 12
    assert item.geometry.watertight
    said = " ".join(item.geometry.repairs)
    assert "2 triangles dropped as collapsed to an edge or a point" in said
    assert "2 triangles dropped as doubles" in said


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "step"])
def test_what_is_far_away_or_absurdly_big_is_right_or_refused(kind, tmp_path):
    far = box(middle=(2e6, 0, 0))
    scene = Scene.from_obstacles([read(written(tmp_path, kind, content(kind, far)), kind)])
    assert scene.distance([[0, 0, 0]], [[0, 0, 0]]).value[0] == pytest.approx(2000 - 0.1, abs=1e-3)
    huge = written(tmp_path, kind, content(kind, box(size=SIZE * 1e6)))
    with pytest.raises(InputError, match="are `units`, `scale` and `position` right"):
        Scene.from_obstacles([read(huge, kind)])


@pytest.mark.parametrize(
    ("units", "scale", "said"),
    [
        ("m", 1, "400 m long: is that so? Its numbers are read as m; it would be 0.4 m in mm, 4 m in cm, 10.2 m in in"),
        ("mm", 0.01, "4 mm long: is that so? Its numbers are read as mm; it would be 4 m in m, 0.102 m in in"),
        ("mm", 0.015, None),
        ("m", 0.12, None),
    ],
)
def test_a_doubtful_size_is_said(units, scale, said, tmp_path):
    file = written(tmp_path, "stl", content("stl", box(SIZE * scale, MIDDLE)))
    assert Mesh(file=str(file), units=units).remarks() == ([f"file: {said}"] if said else [])


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if units_of(kind)])
def test_formats_that_do_not_say_their_unit_must_be_told(kind):
    with pytest.raises(ValueError, match="do not say their unit; give `units`, one of 'mm', 'cm', 'm', 'in'"):
        Mesh(file=f"file{suffix_of(kind)}")


@pytest.mark.parametrize(("kind", "length"), [("stl", 1), ("obj", 1), ("3mf", 1), ("glb", 1e-3)])
@pytest.mark.parametrize(("units", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254)])
def test_units_that_are_given_hold(kind, length, units, metres, tmp_path):
    item = Mesh(file=str(written(tmp_path, kind, content(kind))), units=units, scale=0.5)
    corners = item.triangles()
    np.testing.assert_allclose(np.ptp(corners, axis=(0, 1)), 0.5 * SIZE * length * metres, rtol=1e-6)


@pytest.mark.parametrize(("unit", "metres"), [("$", 1.0), (".CENTI.", 1e-2), (".MILLI.", 1e-3)])
def test_the_unit_of_a_step_file_holds(unit, metres, tmp_path):
    data = content("step").replace(b"SI_UNIT(.MILLI.,.METRE.)", f"SI_UNIT({unit},.METRE.)".encode())
    item = read(written(tmp_path, "step", data), "step")
    np.testing.assert_allclose(np.ptp(item.triangles(), axis=(0, 1)), SIZE * metres, rtol=1e-6)


def test_step_files_say_their_unit_themselves():
    with pytest.raises(ValueError, match="STEP files say their unit"):
        Mesh(file="a.step", units="mm")
    with pytest.raises(ValueError, match="needs a tolerance above 0"):
        Mesh(file="a.STEP", tolerance=0)


@pytest.mark.slow
def test_a_million_triangles_are_read_and_searched(tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", "off")
    across, along = 1000, 501
    turn, rise = np.meshgrid(np.arange(across) * 2 * np.pi / across, np.arange(1, along) * np.pi / along)
    rings = np.stack([np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)], axis=-1) * 150
    rings = np.concatenate([np.tile([0.0, 0, 150], (1, across, 1)), rings, np.tile([0.0, 0, -150], (1, across, 1))])
    right = np.roll(rings, -1, axis=1)
    quads = np.stack([rings[:-1], rings[1:], right[1:], right[:-1]], axis=2).reshape(-1, 4, 3)
    corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    row = np.zeros(len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    row["corners"] = corners
    data = bytes(80) + len(row).to_bytes(4, "little") + row.tobytes()
    item = read(written(tmp_path, "stl", data), "stl")
    scene = Scene.from_obstacles([item])
    assert len(scene.triangles) == 2 * across * (along - 1)  # less those collapsed at the poles
    assert item.geometry.watertight
    rng = np.random.default_rng(0)
    points = rng.normal(size=(300, 3))
    points *= (rng.uniform(0.12, 0.18, 300) / np.linalg.norm(points, axis=1))[:, None]
    radius = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(scene.distance(points, points).value, np.abs(radius - 0.15), atol=2e-6)
    np.testing.assert_array_equal(scene.inside(points) == 0, radius < 0.15)
