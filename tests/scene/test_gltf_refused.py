"""glTF and GLB that cannot be taken as they are meant: refused in words, whatever is wrong with them."""

import struct

import numpy as np
import pytest
from content_oracles import CORNERS, FACES, assert_is_the_box
from gltf_boxes import (
    SHIFT,
    matrix_of,
    plain,
)
from gltf_maker import Gltf, glb_of, read, read_made

from hognose.errors import InputError
from hognose.scene import Mesh
from hognose.scene.imports import gltf


def primitive(g):
    return g.tree["meshes"][0]["primitives"][0]


def accessor(g, number=0):
    return g.tree["accessors"][number]


def instanced(g, attributes):
    g.tree["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}


DRACO = "KHR_draco_mesh_compression"
REFUSED = {
    "version 1": (lambda g: g.tree["asset"].update(version="1.0"), r"is glTF 1\.0, expected 2\.0"),
    "version 3 at least": (lambda g: g.tree["asset"].update(minVersion="3.0"), r"is glTF 3\.0, expected 2\.0"),
    "no version": (lambda g: g.tree.pop("asset"), r'no "asset" with a "version" \(glTF 1\.0 is not read\)'),
    "draco required": (
        lambda g: g.tree.update(extensionsRequired=[DRACO]),
        f"is compressed .{DRACO}.",
    ),
    "draco late in the header": (
        lambda g: (g.tree.update(extras="x" * 300_000), primitive(g).update(extensions={DRACO: {}})),
        f"is compressed .{DRACO}.",
    ),
    "meshopt used": (
        lambda g: g.tree["bufferViews"][0].update(extensions={"EXT_meshopt_compression": {}}),
        "is compressed .EXT_meshopt_compression.",
    ),
    "an unknown extension required": (
        lambda g: g.tree.update(extensionsRequired=["KHR_mesh_quantization", "ZZ_holes", "CESIUM_RTC"]),
        "needs extensions that Hognose does not know: CESIUM_RTC, ZZ_holes;",
    ),
    "a skin": (lambda g: g.tree["nodes"][0].update(skin=0), r"node 0 \('box'\) is bent by a skeleton"),
    "its own child": (lambda g: g.tree["nodes"][0].update(children=[0]), r"node 0 \('box'\) is a child of itself"),
    "a circle of nodes": (
        lambda g: g.tree["nodes"].extend([{"children": [2]}, {"children": [1]}]),
        "node 1 is a child of itself, directly or through others",
    ),
    "two parents": (
        lambda g: g.tree["nodes"].extend([{"children": [0]}, {"children": [0]}]),
        r"node 0 \('box'\) is a child of node 1 and again of node 2",
    ),
    "a child twice": (lambda g: g.tree["nodes"].append({"children": [0, 0]}), "is a child of node 1 and again"),
    "a child that is not there": (lambda g: g.tree["nodes"][0].update(children=[7]), "has the child 7, which is not"),
    "a scene that is not there": (lambda g: g.tree.update(scene=1), "its scene is 1, but it has 1"),
    "a scene of no node": (lambda g: g.tree.update(scenes=[{"nodes": [3]}]), "a scene places node 3, but it has 1"),
    "a scene of a child": (
        lambda g: g.tree["nodes"].append({"children": [0]}),
        r"a scene places node 0 \('box'\), which is the child of another",
    ),
    "a mesh that is not there": (lambda g: g.tree["nodes"][0].update(mesh=4), "places mesh 4, but it has 1"),
    "a matrix and a scale": (
        lambda g: g.tree["nodes"][0].update(matrix=matrix_of(np.eye(3), SHIFT), scale=[1, 1, 1]),
        "has a matrix, and a translation",
    ),
    "a matrix of perspective": (
        lambda g: g.tree["nodes"][0].update(matrix=[1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
        "does not end in 0, 0, 0, 1",
    ),
    "a short matrix": (lambda g: g.tree["nodes"][0].update(matrix=[1, 2]), r"nodes\[0\]\.matrix: list should have"),
    "no rotation": (lambda g: g.tree["nodes"][0].update(rotation=[0, 0, 0, 0]), "no unit quaternion"),
    "a place that is no number": (lambda g: g.tree["nodes"][0].update(translation=[float("nan"), 0, 0]), "holds NaN"),
    "an infinite place": (lambda g: g.tree["nodes"][0].update(translation=[1e999, 0, 0]), "holds Infinity"),
    "a number of 400 digits": (lambda g: g.tree["nodes"][0].update(translation=[10**400, 0, 0]), "damaged"),
    "a mode that is not there": (lambda g: primitive(g).update(mode=7), "primitive 0 of mesh 0 has the mode 7"),
    "a corner too many": (lambda g: accessor(g, 1).update(count=35), "has 35 corners, no whole number of triangles"),
    "too few for a strip": (
        lambda g: (accessor(g, 1).update(count=2), primitive(g).update(mode=5)),
        "has 2 corners, too few for a triangle",
    ),
    "a vertex that is not there": (lambda g: accessor(g).update(count=7), "names the vertex 7, but there are 7"),
    "rows beyond the view": (lambda g: accessor(g).update(count=9), "accessor 0 has 9 rows, more than the 96 bytes"),
    "a view beyond the buffer": (
        lambda g: g.tree["bufferViews"][1].update(byteLength=99_999),
        "buffer view 1 goes beyond the end of buffer 0",
    ),
    "rows closer than their length": (
        lambda g: g.tree["bufferViews"][0].update(byteStride=8),
        "rows of accessor 0 are 12 bytes long, but 8 bytes apart",
    ),
    "an accessor of nothing": (lambda g: accessor(g).pop("bufferView"), "accessor 0 says nothing of where"),
    "a component type of its own": (lambda g: accessor(g).update(componentType=5130), "has the component type 5130"),
    "positions in a plane": (lambda g: accessor(g).update(type="VEC2"), "is of 'VEC2', but positions need VEC3"),
    "indices of fractions": (lambda g: accessor(g, 1).update(componentType=5126, count=18), "no whole numbers from 0"),
    "signed indices": (lambda g: accessor(g, 1).update(componentType=5122), "no whole numbers from 0 on"),
    "an accessor that is not there": (lambda g: primitive(g).update(indices=5), "in accessor 5, but it has 2"),
    "a view that is not there": (lambda g: accessor(g).update(bufferView=9), "in buffer view 9, but there are 2"),
    "a buffer that is not there": (lambda g: g.tree["bufferViews"][0].update(buffer=1), "buffer 1, but has 1"),
    "instances of no place": (
        lambda g: instanced(g, {}),
        r"EXT_mesh_gpu_instancing of node 0 \('box'\) does not say where",
    ),
    "instances of different lengths": (
        lambda g: instanced(g, {"SCALE": g.accessor(CORNERS[:2], "f4"), "TRANSLATION": g.accessor(CORNERS, "f4")}),
        "has attributes of different lengths",
    ),
    "instances of nothing": (
        lambda g: g.tree["nodes"][0].update(extensions={"EXT_mesh_gpu_instancing": []}),
        "EXT_mesh_gpu_instancing of node 0 .* has no attributes",
    ),
    "weights without targets": (lambda g: g.tree["nodes"][0].update(weights=[1.0]), "has 0 morph targets, but 1 weigh"),
    "targets of another length": (
        lambda g: (
            primitive(g).update(targets=[{"POSITION": g.accessor([[0, 0, 1]], "f4")}]),
            g.tree["nodes"][0].update(weights=[1.0]),
        ),
        "has 1 rows, expected 8",
    ),
    "too much": (
        lambda g: instanced(g, {"SCALE": g.sparse(2_000_000, [0], [[1, 1, 1]], "f4")}),
        "holds more than 20,000,000 triangles or points",
    ),
    "sparse indices out of order": (
        lambda g: primitive(g).update(attributes={"POSITION": g.sparse(8, [3, 3], CORNERS[:2], "f4")}),
        "sparse indices of accessor 2 are not in increasing order",
    ),
    "a sparse index beyond": (
        lambda g: primitive(g).update(attributes={"POSITION": g.sparse(8, [3, 8], CORNERS[:2], "f4")}),
        "a sparse index of accessor 2 is 8, but it has 8 rows",
    ),
    "a sparse bomb": (
        lambda g: primitive(g).update(attributes={"POSITION": g.sparse(10**12, [3], CORNERS[:1], "f4")}),
        "accessor 2 has more than 20,000,000 rows",
    ),
    "text for a number": (lambda g: primitive(g).update(mode="lines"), r"meshes\[0\]\.primitives\[0\]\.mode: input"),
    "a negative number": (lambda g: primitive(g).update(indices=-1), r"primitives\[0\]\.indices: input should be"),
    "nodes that are no list": (lambda g: g.tree.update(nodes={"a": 1}), "nodes: input should be a valid list"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_taken_is_refused_in_words(name):
    made = Gltf()
    plain(made)
    spoil, complaint = REFUSED[name]
    spoil(made)
    with pytest.raises(InputError, match=complaint):
        read_made(made)


def test_positions_that_are_no_numbers_are_refused_with_the_body(tmp_path):
    made = Gltf()
    wrong = CORNERS.copy()
    wrong[2, 1] = np.nan
    made.node(made.primitive(wrong, FACES))
    (tmp_path / "file.glb").write_bytes(made.glb())
    with pytest.raises(InputError, match=r"'box': \d of 36 corners or points have coordinates that are not finite"):
        assert Mesh(file=str(tmp_path / "file.glb")).geometry


def test_what_is_placed_too_often_is_refused_before_it_is_made(monkeypatch):
    monkeypatch.setattr(gltf, "MOST_ELEMENTS", 36)
    made = Gltf()
    plain(made)
    made.tree["nodes"] += [{"mesh": 0}] * 2
    made.tree["scenes"] = [{"nodes": [0, 1, 2]}]
    assert len(read_made(made).bodies) == 3
    made.tree["nodes"].append({"mesh": 0})
    made.tree["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    with pytest.raises(InputError, match="holds more than"):
        read_made(made)


def test_the_container_is_held_to_what_it_says():
    made = Gltf()
    plain(made)
    whole = made.glb()
    for length in range(len(whole)):
        with pytest.raises(InputError, match=r"cut|not a GLB file"):
            read(whole[:length])
    with pytest.raises(InputError, match=rf"ends after {len(whole):,} bytes, but goes on to {len(whole) + 1:,}"):
        read(whole + b"\0")
    with pytest.raises(InputError, match="version 1, expected 2"):
        read(b"glTF" + struct.pack("<I", 1) + whole[8:])
    tail = len(whole) - len(made.blob) - 8
    with pytest.raises(InputError, match="chunk 2 says it is"):
        read(whole[:tail] + struct.pack("<I", len(made.blob) + 1) + whole[tail + 4 :])
    with pytest.raises(InputError, match="more than one chunk of JSON or of numbers"):
        read(made.glb((b"BIN\0", b"1234")))
    with pytest.raises(InputError, match="first chunk is not JSON"):
        read(whole.replace(b"JSON", b"json"))
    with pytest.raises(InputError, match=r"buffer 0 should have .* bytes, but has"):
        read(glb_of(made.glb()[20:tail], made.blob[:-1]))
    with pytest.raises(InputError, match="does not begin with `glTF`"):
        read(made.text(), "file.glb")
    with pytest.raises(InputError, match=r"refers to the file 'a.bin', which is read of .gltf files only"):
        read(glb_of(made.text("a.bin"), b""))


def test_json_is_held_to_its_rules():
    made = Gltf()
    plain(made)
    text = made.text()
    assert_is_the_box(read(b"\xef\xbb\xbf" + text, "file.gltf"))
    for spoiled, complaint in (
        (text.replace(b'"nodes"', b'"nodes": [], "nodes"', 1), "has 'nodes' twice"),
        (text[:-5], "its JSON cannot be read"),
        (b"[" * 100_000, "its JSON cannot be read: it is nested too deep"),
        (b"\xff\xfe" + text, "its JSON cannot be read"),
        (b"[]", "not a glTF 2.0 file"),
        (b'{"asset": {"version": 2}}', "not a glTF 2.0 file"),
        (text.replace(b";base64,", b","), "not as base64"),
        (text.replace(b";base64,", b";base64,!"), "is not base64"),
        (text.replace(b";base64,", b";base64,AAAA"), None),
    ):
        if complaint:
            with pytest.raises(InputError, match=complaint):
                read(spoiled, "file.gltf")


def test_files_beside_it(tmp_path):
    made = Gltf()
    plain(made)
    folder = tmp_path / "a folder"
    (folder / "sub").mkdir(parents=True)
    file = folder / "file.gltf"

    def said(uri):
        with pytest.raises(InputError) as caught:
            read(made.text(uri), file)
        return str(caught.value)

    for name, uri in (("plain.bin", "plain.bin"), ("with blank.bin", "with%20blank.bin"), ("sub/ä.bin", "sub/ä.bin")):
        assert said(uri) == f"refers to the file {name!r}, which is not there; bring both, or export it as GLB"
        (folder / name).write_bytes(made.blob)
        assert_is_the_box(read(made.text(uri), file))
        (folder / name).write_bytes(made.blob[:-1])
        assert f"buffer 0 should have {len(made.blob)} bytes, but has {len(made.blob) - 1}" in said(uri)
    (tmp_path / "out.bin").write_bytes(made.blob)
    (folder / "link.bin").symlink_to(tmp_path / "out.bin")
    for uri in (
        "../out.bin",
        "%2e%2e/out.bin",
        str(tmp_path / "out.bin"),
        "sub/../../out.bin",
        "link.bin",
        "..\\out.bin",
    ):
        assert "which is outside its folder" in said(uri)
    assert "which is not a file beside it" in said("https://example.org/a.bin")
    assert "which is not a file beside it" in said("file:///etc/hosts")
    assert "which is not there" in said("sub")
    assert "cannot be read" in said("a%00b.bin")
    assert "cannot be read" in said("a" * 5000) or "which is not there" in said("a" * 5000)
