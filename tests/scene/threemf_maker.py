"""3MF archives made of pieces of XML."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from content_oracles import CORNERS, FACES

from hognose.scene.imports import threemf
from hognose.scene.imports.content import Source

_MS = "http://schemas.microsoft.com/3dmanufacturing"
#: The namespaces of extensions, by the prefix that files give them.
SPACES = {
    "p": f"{_MS}/production/2015/06", "m": f"{_MS}/material/2015/02", "s": f"{_MS}/slice/2015/07",
    "b": f"{_MS}/beamlattice/2017/02", "t": f"{_MS}/trianglesets/2021/07", "sc": f"{_MS}/securecontent/2019/04",
    "pa": f"{_MS}/production/alternatives/2021/04", "v": "http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01",
    "d": "http://schemas.3mf.io/3dmanufacturing/displacement/2023/10", "x": "urn:vendor:more",
    "bo": "http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07",
}  # fmt: skip
START = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def mesh(corners=CORNERS, faces=FACES, more="", inside=""):
    """A mesh."""
    vertices = "".join(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in np.asarray(corners, float).tolist())
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" {more}/>' for a, b, c in np.asarray(faces).tolist())
    return f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles>{inside}</mesh>"


def solid(number: Any = 1, shape: str | None = None, name: str | None = "box", more="") -> str:
    """An object; a name of None leaves it without."""
    named = "" if name is None else f'name="{name}"'
    return f'<object id="{number}" {named} {more}>{mesh() if shape is None else shape}</object>'


def group(number: int, *components: str, name: str | None = None) -> str:
    """An object of components, each the attributes of one."""
    parts = "".join(f"<component {attributes}/>" for attributes in components)
    return solid(number, f"<components>{parts}</components>", name)


def model(*objects, items=('objectid="1"',), unit='unit="meter"', head="", resources=""):
    """The XML of a model part; `items` are the attributes of each."""
    spaces = " ".join(f'xmlns:{prefix}="{uri}"' for prefix, uri in SPACES.items())
    build = "".join(f"<item {attributes}/>" for attributes in items)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><model {unit} {head} xmlns="{_MS}/core/2015/02" {spaces}>'
        f'<metadata name="Title">box</metadata><resources>{resources}{"".join(objects)}</resources>'
        f"<build>{build}</build></model>"
    )


def relations(*targets):
    """The part that says where to begin."""
    each = "".join(f'<Relationship Id="r{k}" Type="{START}" Target="{name}"/>' for k, name in enumerate(targets))
    other = '<Relationship Id="t" Type="http://example.org/thumbnail" Target="/Metadata/thumbnail.png"/>'
    return f'<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">{other}{each}</Relationships>'


def archive(parts, method=zipfile.ZIP_DEFLATED):
    """A ZIP archive of parts by name."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as file:
        for name, content in parts.items():
            file.writestr(name, content)
    return buffer.getvalue()


def package(root, more=None, name="3D/3dmodel.model"):
    """A 3MF file of a root part and others by name."""
    return archive({"_rels/.rels": relations("/" + name), name: root, **(more or {})})


def read(data):
    """The content of a file that need not exist."""
    return threemf.read(Source(Path("file.3mf"), data))
