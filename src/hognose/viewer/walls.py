"""The obstacles in the page's space: solid, but for those that stand round the way, which are seen through."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hognose.report.solids import drawable
from hognose.report.style import OBSTACLES
from hognose.rotations import quaternion_of_rotation
from hognose.scene import MovingObstacle, Scene
from hognose.viewer.shapes import rgb

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

#: How much of obstacles that stand round the way is seen.
OPACITY = 0.2


class Walls:
    """Obstacles that are drawn. Only one thread may change them.

    Attributes
    ----------
    shown
        The scene that is drawn; None before the first.
    parts
        Its obstacles, by name.
    shells
        The triangles (m, 3, 3) m of those that stand round the way, by name.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.shown: Scene | None = None
        self.parts: dict[str, Any] = {}
        self.shells: dict[str, Array] = {}
        self._places: dict[str, int] = {}
        self._poses: dict[str, tuple[Array, Array]] = {}
        self._opacity, self._hidden = OPACITY, ()

    def show(self, scene: Scene, way: Array) -> None:
        """Draw a scene in place of the one before; what stands round a way (k, 3) m so that the way can be seen."""
        for handle in self.parts.values():
            handle.remove()
        self.shown, self.parts, self.shells, self._poses = scene, {}, {}, {}
        self._places = {name: index for index, name in enumerate(scene.names)}
        triangles, owner, _ = drawable(scene)
        onwards = np.append(way[1:], way[-1:], axis=0)
        first, last = np.minimum(way, onwards), np.maximum(way, onwards)  # of each piece: thin walls lie between places
        for name, index in self._places.items():
            own = triangles[owner == index]
            if not len(own):
                continue
            low, high = scene.bounds[index]
            if ((last > low) & (first < high)).all(axis=1).any():
                self.shells[name] = own
                self._draw_shell(name)
            else:
                self._draw_solid(name, own)
        self.hide(self._hidden)

    def move(self, moving: Iterable[MovingObstacle], time: float) -> None:
        """Put obstacles that move, drawn as placed, where they are at a time (s)."""
        for each in moving:
            turned, places = each.motion.poses([time])
            offset = places[0] - turned[0] @ each.motion.pivot
            for name in each.scene.names:
                self._poses[name] = (quaternion_of_rotation(turned[0]), offset)
                self._put(name)

    def _put(self, name: str) -> None:
        if name in self._poses and name in self.parts:
            self.parts[name].wxyz, self.parts[name].position = self._poses[name]

    def see_through(self, opacity: float) -> None:
        """Draw what stands round the way with an opacity from 0 to 1."""
        if opacity == self._opacity:
            return
        self._opacity = opacity
        for name in self.shells:
            self.parts[name].remove()
            self._draw_shell(name)
            self._put(name)
        self.hide(self._hidden)

    def hide(self, beginnings: tuple[str, ...]) -> None:
        """Show the obstacles whose names do not begin with one of these."""
        self._hidden = beginnings
        for name, part in self.parts.items():
            part.visible = not name.startswith(beginnings)

    def _draw_solid(self, name: str, triangles: Array) -> None:
        self.parts[name] = self._scene.add_mesh_simple(
            self._node(name),
            triangles.reshape(-1, 3).astype(np.float32),
            np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3),
            color=self._colour(name),
            flat_shading=True,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _draw_shell(self, name: str) -> None:
        """As glTF: there, what is blended does not hide what is drawn behind it afterwards, as other walls in it."""
        shell = blended(self.shells[name], self._colour(name), self._opacity)
        self.parts[name] = self._scene.add_glb(self._node(name), shell, cast_shadow=False, receive_shadow=False)

    def _node(self, name: str) -> str:
        return f"/space/{self._places[name]}"

    def _colour(self, name: str) -> tuple[int, int, int]:
        return rgb(OBSTACLES[self._places[name] % len(OBSTACLES)])


def blended(triangles: Array, colour: tuple[int, int, int], opacity: float) -> bytes:
    """A GLB file (glTF 2.0) of triangles (m, 3, 3) m with flat faces, of a colour that can be seen through."""
    corners = triangles.reshape(-1, 3).astype("<f4")
    linear = (np.array(colour) / 255) ** 2.2  # glTF's colours are not in the screen's scale
    material = {
        "pbrMetallicRoughness": {"baseColorFactor": [*linear.tolist(), opacity], "metallicFactor": 0.0},
        "alphaMode": "BLEND" if opacity < 1 else "OPAQUE",
        "doubleSided": True,
    }
    accessor = {
        "bufferView": 0,
        "componentType": 5126,
        "type": "VEC3",
        "count": len(corners),
        "min": corners.min(axis=0).tolist(),
        "max": corners.max(axis=0).tolist(),
    }
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [material],
        "accessors": [accessor],
        "bufferViews": [{"buffer": 0, "byteLength": corners.nbytes}],
        "buffers": [{"byteLength": corners.nbytes}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", corners.nbytes, b"BIN\0") + corners.tobytes()
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
