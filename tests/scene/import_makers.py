"""Files of meshes and point clouds, whole and damaged in every way, written with trimesh or by hand."""

import io
import json
import runpy
import struct
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

EXAMPLES = Path(__file__).parents[2] / "examples"
STEP = runpy.run_path(str(EXAMPLES / "make_step_tank.py"))
#: The box in every file: sides and middle, mm.
SIZE, MIDDLE = np.array([200.0, 300.0, 400.0]), np.array([10.0, 20.0, 30.0])
FORMATS = ["stl", "stl ascii", "obj", "ply", "ply ascii", "off", "glb", "3mf", "step"]


def box(size: Any = SIZE, middle: Any = MIDDLE) -> trimesh.Trimesh:
    made = trimesh.creation.box(size)
    made.apply_translation(middle)
    return made


def suffix_of(kind):
    return "." + kind.split()[0]


def units_of(kind):
    """What a task must say of a file in mm; GLB is always in metres, and the others tell."""
    return "mm" if suffix_of(kind) in (".stl", ".obj", ".ply", ".off") else None


@cache
def content(kind, mesh=None) -> bytes:
    """One mesh in mm (by default the box) as a file of a kind."""
    if kind == "step":
        assert mesh is None
        low = MIDDLE - SIZE / 2
        outline = ((0.0, 0.0), (200.0, 0.0), (200.0, 300.0), (0.0, 300.0))
        body = STEP["Body"]("box", tuple(low), (1, 0, 0), (0, 1, 0), 400.0, outline)
        return STEP["step_file"]([body]).encode()
    mesh = box() if mesh is None else mesh
    if kind == "glb":
        return exported(mesh.copy().apply_scale(1e-3), "glb")
    if kind == "3mf":
        scene = trimesh.Scene({"box": mesh})
        scene.units = "mm"
        return exported(scene, "3mf")
    more = {"encoding": "ascii"} if kind == "ply ascii" else {}
    return exported(mesh, {"stl ascii": "stl_ascii", "ply ascii": "ply"}.get(kind, kind), **more)


def exported(shape: Any, file_type: str, **more: Any) -> bytes:
    """What trimesh makes of something; text as bytes too."""
    made = shape.export(file_type=file_type, **more)
    return made if isinstance(made, bytes) else made.encode()


def written(folder, kind, data):
    file = folder / f"file{suffix_of(kind)}"
    file.write_bytes(data)
    return file


def with_vertex(kind, value):
    """The box with one coordinate that is no finite number; of STEP files, where there can be none, None."""
    mesh = box()
    vertices = np.array(mesh.vertices)
    vertices[3, 1] = value
    if kind == "stl":
        data = bytearray(content(kind))
        data[84 + 12 : 84 + 16] = struct.pack("<f", value)
        return bytes(data)
    if kind == "glb":
        return _glb(vertices * 1e-3, mesh.faces)
    if kind == "3mf":
        return _threemf(vertices, mesh.faces)
    if kind == "ply":
        head = _ply_head(len(vertices), len(mesh.faces), "binary_little_endian")
        rows = b"".join(struct.pack("<B3i", 3, *face) for face in mesh.faces)
        return head + vertices.astype("<f4").tobytes() + rows
    return text_of(kind, vertices, mesh.faces)


def text_of(kind, vertices, faces):
    """A text file of polygons; `faces` may have any number of corners."""
    points = [" ".join(f"{x:.9g}" for x in point) for point in vertices]
    if kind == "stl ascii":
        corners = ["\n".join(f"vertex {points[k]}" for k in face) for face in faces]
        facets = [f"facet normal 0 0 0\nouter loop\n{three}\nendloop\nendfacet" for three in corners]
        return ("solid a\n" + "\n".join(facets) + "\nendsolid a\n").encode()
    if kind == "obj":
        rows = [f"v {point}" for point in points] + ["f " + " ".join(str(k + 1) for k in face) for face in faces]
        return ("\n".join(rows) + "\n").encode()
    rows = [*points, *(f"{len(face)} " + " ".join(map(str, face)) for face in faces)]
    if kind == "off":
        return (f"OFF\n{len(points)} {len(faces)} 0\n" + "\n".join(rows) + "\n").encode()
    return _ply_head(len(points), len(faces), "ascii") + ("\n".join(rows) + "\n").encode()


def _ply_head(vertices, faces, form):
    return (
        f"ply\nformat {form} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()


def _threemf(vertices, faces):
    points = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in vertices)
    corners = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    model = (
        '<?xml version="1.0"?><model unit="millimeter" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">'
        f"<mesh><vertices>{points}</vertices><triangles>{corners}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>'
    )
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("3D/3dmodel.model", model)
        archive.writestr(
            "_rels/.rels",
            '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="a" '
            'Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
            "</Relationships>",
        )
    return buffer.getvalue()


def _glb(vertices, faces):
    points, index = np.asarray(vertices, "<f4").tobytes(), np.asarray(faces, "<u4").tobytes()
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "box"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(points) + len(index)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(index)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"},
        ],
    }  # fmt: skip
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(points + index), b"BIN\0") + points + index
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def empty_of(kind):
    """A file that is whole and has no triangle."""
    if kind == "stl":
        return bytes(80) + struct.pack("<I", 0)
    if kind == "step":
        return STEP["step_file"]([]).encode()
    if kind == "glb":
        return _glb(np.zeros((3, 3)), np.empty((0, 3)))
    if kind == "3mf":
        return _threemf([], [])
    return text_of("ply ascii" if kind == "ply" else kind, [], [])
