"""glTF and GLB: one box in every way that the format can say it; all else is refused or noted in words."""

import io

import numpy as np
import pytest
import trimesh
from content_oracles import (
    CORNERS,
    FACES,
    QUADS,
    VOLUME,
    assert_is_the_box,
    of_body,
    of_content,
    volume,
)
from gltf_boxes import (
    MIDDLE,
    SAME,
    SIZE,
    UNIT,
    a_mesh_that_no_node_has,
    animations,
    another_scene,
    before,
    lines,
    matrix_of,
    moves,
    no_scene,
    nothing_to_place,
    plain,
    sparse_over_a_base,
    unknown_extensions,
)
from gltf_maker import Gltf, read, read_made
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hognose.errors import InputError
from hognose.scene import Mesh, Points, Scene
from hognose.scene.imports.content import Content, RawBody


@pytest.mark.parametrize("make", SAME, ids=lambda make: make.__name__)
def test_the_box_is_the_same_in_every_way_to_say_it(make):
    made = Gltf()
    make(made)
    content = read_made(made)
    assert_is_the_box(content)
    assert (content.metres, content.notes) == (1.0, ())
    text = read(made.text(), "file.gltf")
    np.testing.assert_array_equal(of_content(text), of_content(content))


@pytest.mark.parametrize("kind", ["u1", "u2", "u4"])
def test_indices_of_every_size(kind):
    made = Gltf()
    made.node(made.primitive(CORNERS, made.accessor(FACES.ravel(), kind)))
    assert_is_the_box(read_made(made))
    made = Gltf()
    sparse_over_a_base(made, kind)
    assert_is_the_box(read_made(made))


@pytest.mark.parametrize("normalized", [True, False])
@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u2"])
def test_quantised_positions(kind, normalized):
    most, signed = np.iinfo(kind).max, kind[0] == "i"
    stored = np.round(UNIT * 2 * most if signed else (UNIT + 0.5) * most)
    unit = (1 / (2 if signed else 1)) / (1 if normalized else most)
    made = Gltf()
    corners = made.accessor(stored, kind, gap=2, normalized=normalized)
    low = MIDDLE if signed else CORNERS.min(0)
    made.node(made.primitive(corners, FACES), scale=(SIZE * unit).tolist(), translation=low.tolist())
    made.tree["extensionsRequired"] = ["KHR_mesh_quantization"]
    assert_is_the_box(read_made(made))


def test_the_least_of_signed_integers_is_minus_one():
    made = Gltf()
    corners = made.accessor([[-128, -127, 0], [127, 0, 0], [0, 127, 64]], "i1", gap=1, normalized=True)
    made.node(made.primitive(corners))
    np.testing.assert_allclose(of_content(read_made(made))[0], [[-1, -1, 0], [1, 0, 0], [0, 1, 64 / 127]])


def test_instances_of_a_node_are_one_body_in_their_places():
    made, rng = Gltf(), np.random.default_rng(1)
    turns = Rotation.random(5, rng=rng)
    shifts, scales = rng.uniform(-3, 3, (5, 3)), rng.uniform(0.5, 2, (5, 3)) * [[1], [-1], [1], [-1], [1]]
    quats = np.round(turns.as_quat() * 32767)
    attributes = {
        "TRANSLATION": made.accessor(shifts, "f4"),
        "ROTATION": made.accessor(quats, "i2", normalized=True),
        "SCALE": made.accessor(scales, "f4"),
    }
    made.node(
        made.primitive(CORNERS, FACES),
        made.primitive([[0.0, 0, 0], [1, 2, 3]], mode=0),
        extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}},
        translation=[10, 0, 0],
    )
    content = read_made(made)
    (body,) = content.bodies
    assert body.name == "box"
    assert len(content.points) == 10
    placed = [
        turn.apply(CORNERS * scale) + shift + [10, 0, 0]
        for turn, scale, shift in zip(turns, scales, shifts, strict=True)
    ]
    expected = [
        corners[FACES if scale[0] > 0 else FACES[:, ::-1]] for corners, scale in zip(placed, scales, strict=True)
    ]
    np.testing.assert_allclose(of_body(body), np.concatenate(expected), atol=1e-3)
    assert volume(body) == pytest.approx(VOLUME * np.abs(scales.prod(axis=1)).sum(), rel=1e-3)


def test_a_mesh_that_is_placed_twice_is_two_bodies_with_names_that_stay():
    made = Gltf()
    made.node(made.primitive(CORNERS, FACES), name="left", mesh={"name": "part"})
    made.tree["nodes"] += [{"mesh": 0, "translation": [1, 0, 0]}, {"mesh": 0, "translation": [2, 0, 0]}]
    made.tree["scenes"] = [{"nodes": [2, 0, 1]}]
    first, second = read_made(made), read_made(made)
    assert [body.name for body in first.bodies] == [body.name for body in second.bodies] == ["part", "left", "part"]
    np.testing.assert_allclose([body.vertices[:, 0].min() for body in first.bodies], [1.9, -0.1, 0.9], atol=1e-6)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_trimesh_agrees_on_trees_of_nodes(seed):
    rng, made = np.random.default_rng(seed), Gltf()
    count = int(rng.integers(1, 9))
    for number in range(count):
        more = {"translation": rng.uniform(-2, 2, 3).tolist(), "rotation": Rotation.random(rng=rng).as_quat().tolist()}
        if rng.random() < 0.5:
            more = {"matrix": matrix_of(rng.uniform(-1, 1, (3, 3)), rng.uniform(-2, 2, 3))}
        made.node(made.primitive(rng.uniform(-1, 1, (5, 3)), rng.integers(0, 5, (4, 3))), name=f"n{number}", **more)
    for number in range(1, count):
        if rng.random() < 0.7:
            made.tree["nodes"][int(rng.integers(number))].setdefault("children", []).append(number)
    children = {child for node in made.tree["nodes"] for child in node.get("children", [])}
    made.tree["scenes"] = [{"nodes": [number for number in range(count) if number not in children]}]
    content = read_made(made)
    theirs = trimesh.load_scene(io.BytesIO(made.glb()), file_type="glb", process=False, skip_materials=True)
    assert len(content.bodies) == count
    for body in content.bodies:
        turn, shape = theirs.graph[body.name]
        corners = theirs.geometry[shape].vertices @ turn[:3, :3].T + turn[:3, 3]
        faces = theirs.geometry[shape].faces
        faces = faces[:, ::-1] if np.linalg.det(turn[:3, :3]) < 0 else faces
        np.testing.assert_allclose(of_body(body), corners[faces][: len(body.faces)], atol=1e-4)


def test_points_belong_to_no_body(tmp_path):
    made = Gltf()
    made.node(made.primitive(CORNERS, mode=0), translation=[1, 0, 0])
    content = read_made(made)
    assert content.bodies == ()
    np.testing.assert_allclose(content.points, CORNERS + np.array([1, 0, 0]), atol=1e-6)
    file = tmp_path / "scan.glb"
    file.write_bytes(made.glb())
    scene = Scene.from_obstacles([Points(file=str(file), diameter=0.2)])
    assert scene.distance([[0, 0.1, 0.2]], [[0, 0.1, 0.2]]).value[0] == pytest.approx(0.9 - 0.1, abs=1e-6)
    with pytest.raises(InputError, match=r'holds 8 points but no triangles.*kind = "points"'):
        assert Mesh(file=str(file)).geometry


NOTED = {
    lines: "3 primitives of lines left out",
    nothing_to_place: "1 primitive without positions left out",
    another_scene: "2 nodes with a mesh, not in its scene, left out ('hidden', …)",
    a_mesh_that_no_node_has: "1 mesh that no node places left out",
    animations: "2 animations left out: everything is where it is at rest",
    unknown_extensions: "holds data of extensions that are not read: AA_values, XX_more",
    no_scene: "has no scene: all nodes are taken",
}


@pytest.mark.parametrize("make", NOTED, ids=lambda make: make.__name__)
def test_what_is_left_out_is_noted(make):
    made = Gltf()
    make(made)
    content = read_made(made)
    assert_is_the_box(content)
    assert content.notes == (NOTED[make],)


def test_all_scenes_are_taken_if_none_is_said_to_be_shown():
    made = Gltf()
    another_scene(made)
    del made.tree["scene"]
    content = read_made(made)
    assert [body.name for body in content.bodies] == ["box", "hidden"]  # each once, though in two scenes
    assert content.notes[0] == "does not say which of its 2 scenes is meant: all are taken"
    assert content.notes[1] == "1 node with a mesh, not in its scene, left out"


def test_chunks_of_other_kinds_are_noted():
    made = Gltf()
    plain(made)
    content = read(made.glb((b"XTRA", b"1234"), (b"MORE", b"")))
    assert_is_the_box(content)
    assert content.notes == ("2 chunks of an unknown kind left out",)


@pytest.mark.parametrize(
    ("faces", "same"),
    [
        (np.roll(FACES[::-1], 1, axis=1), True),
        (FACES[:, ::-1], False),
        (np.concatenate([FACES[1:], FACES[:1, ::-1]]), False),
        (np.concatenate([QUADS[:, [0, 1, 3]], QUADS[:, [1, 2, 3]]]), False),
        (FACES[1:], False),
    ],
)
def test_the_oracle_notices_another_way_round_or_another_diagonal(faces, same):
    content = Content((RawBody("box", CORNERS, faces),))
    if same:
        assert_is_the_box(content)
    else:
        with pytest.raises(AssertionError):
            assert_is_the_box(content)


def test_sides_of_a_box_in_nodes_of_their_own_are_one_body(tmp_path):
    made = Gltf()
    for number, quad in enumerate(QUADS):
        made.node(made.primitive(before(CORNERS[quad]), [0, 1, 2, 0, 2, 3]), name=f"s{number}", **moves())
    made.node(made.primitive(CORNERS, FACES), name="whole", translation=[1, 0, 0])
    made.tree["scenes"] = [{"nodes": list(range(7))}]
    file = tmp_path / "file.glb"
    file.write_bytes(made.glb())
    scene = Scene.from_obstacles([Mesh(file=str(file))])
    assert scene.names == ("file: s0 + 5 more", "file: whole")
    points = MIDDLE + np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]])
    assert scene.inside(points).tolist() == [0, 1, -1]
    assert read_made(made).notes == ("6 nodes that are parts of one surface put together: one body",)
