"""COLLADA files made of pieces of XML."""

from pathlib import Path
from typing import Any

import numpy as np
from content_oracles import CORNERS, FACES

from hognose.scene.imports import dae
from hognose.scene.imports.content import Source

SPACE = "http://www.collada.org/2005/11/COLLADASchema"


def numbers(values: Any) -> str:
    return " ".join(map(repr, np.ravel(values).tolist()))


def positions(corners: Any = CORNERS, name="pos", count=None, accessor='stride="3"', params="XYZ", before="") -> str:
    """A source of positions."""
    values = np.ravel(np.asarray(corners, float))
    said = len(values) + len(before.split()) if count is None else count
    named = "".join(f'<param name="{each}" type="float"/>' if each != "-" else "<param/>" for each in params)
    return (
        f'<source id="{name}"><float_array id="{name}-a" count="{said}">{before} {numbers(values)}</float_array>'
        f'<technique_common><accessor source="#{name}-a" count="{len(corners)}" {accessor}>{named}</accessor>'
        "</technique_common></source>"
    )


VERTICES = '<vertices id="vert"><input semantic="POSITION" source="#pos"/></vertices>'
INPUT = '<input semantic="VERTEX" source="#vert" offset="0"/>'
NORMAL = '<input semantic="NORMAL" source="#none" offset="0"/><input semantic="TEXCOORD" source="#none" offset="2"/>'


def primitive(kind: str, rows: Any, inputs=INPUT, more="", count=None) -> str:
    """A primitive of one <p> a row."""
    said = len(rows) if count is None else count
    return f'<{kind} count="{said}">{inputs}{more}{"".join(f"<p>{numbers(row)}</p>" for row in rows)}</{kind}>'


def triangles(faces: Any = FACES) -> str:
    return primitive("triangles", [np.ravel(faces)], count=len(faces))


def mesh(*primitives: str, source: str | None = None) -> str:
    return f"<mesh>{positions() if source is None else source}{VERTICES}{''.join(primitives or [triangles()])}</mesh>"


def geometry(shape: str | None = None, name="shape", more="") -> str:
    return f'<geometry id="{name}" {more}>{mesh() if shape is None else shape}</geometry>'


def node(inside='<instance_geometry url="#shape"/>', name='id="n" name="box"', moves="") -> str:
    return f"<node {name}>{moves}{inside}</node>"


def collada(*nodes: str, geometries: str | None = None, asset='<unit meter="1"/><up_axis>Z_UP</up_axis>', more="",
            scene='<scene><instance_visual_scene url="#scene"/></scene>', space=SPACE) -> str:  # fmt: skip
    """A whole file."""
    placed = "".join(nodes or [node()])
    return (
        f'<?xml version="1.0" encoding="utf-8"?><COLLADA xmlns="{space}" version="1.4.1"><asset>{asset}</asset>'
        f"<library_geometries>{geometry() if geometries is None else geometries}</library_geometries>{more}"
        f'<library_visual_scenes><visual_scene id="scene">{placed}</visual_scene></library_visual_scenes>'
        f"{scene}</COLLADA>"
    )


def read(text: str | bytes):
    """The content of a file that need not exist."""
    return dae.read(Source(Path("file.dae"), text.encode() if isinstance(text, str) else text))
