"""glTF files made piece by piece: the JSON as a dictionary and one buffer of bytes."""

import base64
import json
import struct
from pathlib import Path

import numpy as np

from hognose.scene.imports import gltf
from hognose.scene.imports.content import Source

COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
WIDTHS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


class Gltf:
    """A file being made: `tree` may be changed at will before it is written."""

    def __init__(self):
        self.tree = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
        }  # fmt: skip
        self.blob = b""

    def view(self, data, **more):
        """A buffer view of some bytes, which begin at no even address."""
        self.blob += b"\xff" * 3
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), **more})
        self.blob += data
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, values, kind, *, gap=0, shift=0, **more):
        """An accessor of rows, with a gap after each and a shift before the first (bytes)."""
        rows = np.asarray(values).astype(f"<{kind}")
        rows = rows.reshape(len(rows), -1)
        data = bytes(shift) + b"".join(row.tobytes() + b"\xaa" * gap for row in rows)
        size = rows.shape[1] * rows.itemsize
        view = self.view(data, **({"byteStride": size + gap} if gap else {}))
        said = {"bufferView": view, "byteOffset": shift, "componentType": COMPONENTS[kind], "count": len(rows)}
        self.tree["accessors"].append({**said, "type": WIDTHS[rows.shape[1]], **more})
        return len(self.tree["accessors"]) - 1

    def sparse(self, count, places, values, kind, *, index="u2", base=None):
        """An accessor of which some rows are given, over zeros or over the rows of a base."""
        values = np.asarray(values).astype(f"<{kind}").reshape(len(places), -1)
        made = {"componentType": COMPONENTS[kind], "count": count, "type": WIDTHS[values.shape[1]]}
        if base is not None:
            made["bufferView"] = self.view(np.asarray(base).astype(f"<{kind}").tobytes())
        made["sparse"] = {
            "count": len(places),
            "indices": {
                "bufferView": self.view(np.asarray(places).astype(f"<{index}").tobytes()),
                "componentType": COMPONENTS[index],
            },
            "values": {"bufferView": self.view(values.tobytes())},
        }
        self.tree["accessors"].append(made)
        return len(self.tree["accessors"]) - 1

    def primitive(self, positions, indices=None, **more):
        """A primitive of accessors, or of rows that become some."""
        if not isinstance(positions, int):
            positions = self.accessor(positions, "f4")
        if indices is not None and not isinstance(indices, int):
            indices = self.accessor(np.ravel(indices), "u2")
        return {"attributes": {"POSITION": positions}, **({} if indices is None else {"indices": indices}), **more}

    def node(self, *primitives, name="box", mesh=None, **more):
        """A node with a mesh of its own."""
        self.tree["meshes"].append({"primitives": list(primitives), **(mesh or {})})
        self.tree["nodes"].append({"mesh": len(self.tree["meshes"]) - 1, "name": name, **more})
        return len(self.tree["nodes"]) - 1

    def text(self, uri=None):
        """The JSON; without a name of a file, the buffer is in it."""
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        return json.dumps({**self.tree, "buffers": [{"byteLength": len(self.blob), "uri": uri}]}).encode()

    def glb(self, *more):
        """All as one GLB file, with more chunks (kind, bytes) behind."""
        tree = {**self.tree, "buffers": [{"byteLength": len(self.blob)}]}
        return glb_of(json.dumps(tree).encode(), self.blob, *more)


def glb_of(text, blob, *more):
    """A GLB file of any text and bytes."""
    text += b" " * (-len(text) % 4)
    chunks = b"".join(struct.pack("<I4s", len(d), k) + d for k, d in ((b"JSON", text), (b"BIN\0", blob), *more))
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def read(data, path="file.glb"):
    """The content of a file that need not exist."""
    return gltf.read(Source(Path(path), data))


def read_made(made):
    """The content of what was made, as GLB."""
    return read(made.glb())
