"""What surrounds the arm: all obstacles as one triangle mesh, and the distances to it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, limit, pair, positive, several, whole
from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.scene import distance as kernels
from hognose.scene.answers import Clearance, Distances, Witness
from hognose.scene.obstacle import TOLERANCE, ObstacleModel, named_parts
from hognose.scene.part import Part
from hognose.scene.tree import Tree
from hognose.scene.tree_cache import cached_tree
from hognose.scene.winding import Groups, enclosing, grouped
from hognose.threads import Block, share_out

FloatArray = NDArray[np.float64]

# Links beyond the horizon are searched this much farther, m, and so can be left alone for some steps.
_SLACK = 0.01
# Points this close to a surface, m, are looked at again when something in the scene is thickened.
_TOUCHING = 1e-9


@dataclass(frozen=True, eq=False)
class Scene:
    """All obstacles as one mesh, with the tree that finds the closest triangle.

    A mesh is a shell: a link wholly inside a solid looks clear. `inside` tells. A point of a point cloud is a triangle
    whose corners are one, thickened to a ball.

    Attributes
    ----------
    names : tuple of str
        The obstacles' names; those of the bodies for a file of several.
    triangles : (m, 3, 3)
        Corners, m; obstacle after obstacle.
    owner : (m,) int32
        The obstacle each triangle belongs to, never decreasing.
    bounds : (obstacles, 2, 3)
        Lowest and highest coordinates of each obstacle, m.
    growth : (obstacles,)
        How far each obstacle's triangles are thickened on all sides, m.
    solid : (obstacles,) bool
        Whether each obstacle has an inside; a surface has none.
    shell : (obstacles,) int
        Open obstacles with the same number may enclose together what none of them does; -1 for all others.
    tree : Tree or None
        None if the scene is empty.
    """

    names: tuple[str, ...]
    triangles: FloatArray
    owner: NDArray[np.int32]
    bounds: FloatArray
    growth: FloatArray = field(default_factory=lambda: np.empty(0))
    solid: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, np.bool_))
    shell: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))

    @classmethod
    def from_obstacles(cls, obstacles: Iterable[ObstacleModel], tolerance: float = TOLERANCE) -> Scene:
        """Return the scene of some obstacles; there may be none.

        Parameters
        ----------
        obstacles
            Unnamed ones are called by their kind and a running number, "pipe 2" for the second pipe.
        tolerance
            Largest distance, m, by which round parts of a mesh may stick out of the solid.

        Raises
        ------
        InputError
            If two obstacles have the same name, or the tolerance is not positive.
        """
        items = several("obstacles", obstacles, ObstacleModel, "an obstacle")
        return cls.from_parts(named_parts(items, positive("tolerance", tolerance)))

    @classmethod
    def from_meshes(cls, names: Sequence[str], meshes: Sequence[ArrayLike]) -> Scene:
        """Return the scene of closed meshes, each (m, 3, 3) in metres and wound outwards.

        Raises
        ------
        InputError
            If names and meshes do not match, or a mesh is empty, misshapen or not finite.
        """
        titles, arrays = several("names", names, str, "text"), several("meshes", meshes, object, "an array")
        if len(titles) != len(arrays):
            raise InputError(f"{len(titles)} names for {len(arrays)} meshes; expected one name a mesh")
        return cls.from_parts([Part(name, _mesh(name, mesh)) for name, mesh in zip(titles, arrays, strict=True)])

    @classmethod
    def from_parts(cls, parts: Sequence[Part]) -> Scene:
        """Return the scene of parts; there may be none.

        Raises
        ------
        InputError
            A part has no triangle, or a corner that is not finite.
        """
        if not parts:
            return cls((), np.empty((0, 3, 3)), np.empty(0, np.int32), np.empty((0, 2, 3)))
        for part in parts:
            _refuse_unusable(part)
        triangles = np.concatenate([part.triangles for part in parts])
        owner = np.repeat(np.arange(len(parts), dtype=np.int32), [len(part.triangles) for part in parts])
        growth = np.array([part.growth for part in parts], dtype=np.float64)
        bounds = np.stack([[part.triangles.min(axis=(0, 1)), part.triangles.max(axis=(0, 1))] for part in parts])
        bounds += growth[:, None, None] * np.array([[[-1.0], [1.0]]])
        solid, shell = np.array([part.solid for part in parts]), np.array([part.shell for part in parts])
        return cls(tuple(part.name for part in parts), triangles, owner, bounds, growth, solid, shell)

    @cached_property
    def tree(self) -> Tree | None:
        """What finds the closest triangle; None if the scene is empty.

        It is made when it is first asked for: what is only drawn needs none.
        """
        return cached_tree(self.triangles, self.growth[self.owner]) if len(self.triangles) else None

    def clearance(
        self,
        starts: ArrayLike,
        ends: ArrayLike,
        radii: ArrayLike,
        horizon: float = 0.05,
        threads: int | None = None,
        first: ArrayLike | None = None,
    ) -> Clearance:
        """Return the clearances of n links over T steps, fast if successive steps are close to each other.

        Parameters
        ----------
        starts, ends
            Ends of the links' axes, (T, n, 3), m.
        radii
            Radii of the links, (n,), m.
        horizon
            Clearances of this much, m, or more are returned as exactly this much. Infinite finds them all.
        threads
            Number of threads, or None for one a core.
        first : (g,)
            Where each of g parts begins, if links are parts of something of which only the smallest clearance counts.

        Returns
        -------
        Clearance
            Of links, or of parts. Exact to rounding below the horizon.

        Raises
        ------
        InputError
            If shapes do not match, or a number is not finite or is negative where it must not be.
        """
        starts, ends = pair("starts", starts, "ends", ends, "(T, n, 3)")
        steps, links = starts.shape[:2]
        radii = floats("radii", radii, "(n,)")
        if len(radii) != links:
            raise InputError(f"{len(radii)} radii for {links} links; expected one a link")
        if np.any(radii < 0):
            raise InputError(f"the smallest of the radii is {radii.min():g} m; expected none below zero")
        horizon = limit("horizon", horizon)
        bounds = None if first is None else _bounds(first, links)
        columns = links if bounds is None else len(bounds) - 1
        value, triangle = np.full((steps, columns), horizon), np.full((steps, columns), -1, np.int32)
        tree = self.tree
        if tree is not None and value.size:
            shared = (*tree.arrays, starts, ends, radii)

            def fill(block: Block) -> None:
                link, past_link, step, past_step = block
                rest = (horizon, _SLACK, (link, past_link), (step, past_step), value, triangle)
                if bounds is None:
                    kernels.clearances(*shared, *rest)
                else:
                    kernels.clearances_of_parts(*shared, bounds, *rest)

            share_out(fill, steps, columns, threads)
        return Clearance(value, triangle, horizon)

    def distance(
        self, starts: ArrayLike, ends: ArrayLike, upper: float = np.inf, threads: int | None = None
    ) -> Distances:
        """Return the distances of independent segments to the scene; with equal ends, of points.

        Parameters
        ----------
        starts, ends
            Ends of the segments, (q, 3), m.
        upper
            Distances of this much, m, or more are returned as exactly this much.
        threads
            Number of threads, or None for one a core.

        Raises
        ------
        InputError
            If shapes do not match or a number is not finite.
        """
        starts, ends = pair("starts", starts, "ends", ends, "(q, 3)")
        upper = limit("upper", upper)
        q = len(starts)
        found = Distances(np.full(q, upper), np.full((q, 3), np.nan), np.full((q, 3), np.nan), np.full(q, -1, np.int32))
        tree = self.tree
        if tree is not None and q:
            shared = (*tree.arrays, starts, ends, upper)
            answers = (found.value, found.on_segment, found.on_mesh, found.triangle)

            def fill(block: Block) -> None:
                kernels.nearest(*shared, block[:2], *answers)

            share_out(fill, 1, q, threads)
        return found

    def witness(self, start: ArrayLike, end: ArrayLike) -> Witness:
        """Return where one segment, start (3,) to end (3,) in m, and the scene come closest."""
        starts, ends = pair("start", start, "end", end, "(3,)")
        found = self.distance(starts[None], ends[None])
        return Witness(
            obstacle=self.obstacle_of(int(found.triangle[0])),
            distance=float(found.value[0]),
            on_segment=tuple(found.on_segment[0].tolist()),
            on_mesh=tuple(found.on_mesh[0].tolist()),
        )

    def obstacle_of(self, triangle: int) -> str | None:
        """Return the name of the obstacle a triangle belongs to, or None for -1."""
        number = whole("triangle", triangle, -1, len(self.owner) - 1)
        return None if number < 0 else self.names[self.owner[number]]

    def inside(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return, for points (p, 3) in m, the index of the first obstacle that contains each, or -1.

        Decided by the generalised winding number, which a few missing triangles do not upset. Surfaces contain nothing
        but what their thickness covers.

        Raises
        ------
        InputError
            If the shape is wrong or a number is not finite.
        """
        points = coordinates("points", points, "(p, 3)")
        answer = np.full(len(points), -1, np.int64)
        if self.tree is not None and len(points):
            groups = self._groups
            shared = (groups.order, groups.start, groups.obstacle, groups.plates)
            # Nothing lies within bounds that are the wrong way round.
            bounds = np.where(self.solid[:, None, None], self.bounds, self.bounds[:, ::-1])
            enclosing(self.triangles, *shared, bounds, points, answer)
            shells, first = self._shells
            if shells is not None and (answer < 0).any():
                together = shells.inside(points[answer < 0])
                answer[answer < 0] = np.where(together >= 0, first[together], -1)
            if self.growth.any():
                found = self.distance(points, points, upper=_TOUCHING)
                within = (answer < 0) & (found.value == 0) & (found.triangle >= 0)
                within &= self.growth[self.owner[found.triangle]] > 0
                answer[within] = self.owner[found.triangle[within]]
        return answer

    def alone(self, obstacle: int) -> Scene:
        """Return the scene of one obstacle, given its index, without the others; it is made once."""
        obstacle = whole("obstacle", obstacle, 0, len(self.names) - 1)
        if len(self.names) == 1:
            return self
        if obstacle not in self._alone:
            part = Part(
                self.names[obstacle],
                self.triangles[self.owner == obstacle],
                float(self.growth[obstacle]),
                self.solid[obstacle],
            )
            self._alone[obstacle] = Scene.from_parts([part])
        return self._alone[obstacle]

    @cached_property
    def _shells(self) -> tuple[Scene | None, NDArray[np.int64]]:
        """A scene of each shell as one obstacle, if there is any, and the first obstacle of each."""
        numbers, first, counts = np.unique(self.shell, return_index=True, return_counts=True)
        chosen = (numbers >= 0) & (counts > 1)
        parts = [
            Part(self.names[index], self.triangles[(self.shell == number)[self.owner]])
            for number, index in zip(numbers[chosen], first[chosen], strict=True)
        ]
        return (Scene.from_parts(parts) if parts else None), first[chosen]

    @cached_property
    def _alone(self) -> dict[int, Scene]:
        return {}

    @cached_property
    def _groups(self) -> Groups:
        assert self.tree is not None
        return grouped(self.triangles, self.owner, self.tree.triangle, len(self.names))


def _bounds(first: ArrayLike, links: int) -> NDArray[np.int64]:
    """Where each of g parts of links begins, and the last one ends (g + 1,)."""
    given = floats("first", first, "(g,)", "")
    bounds = np.append(given, links)
    if not len(given) or given[0] != 0 or (np.diff(bounds) <= 0).any() or (given != np.floor(given)).any():
        raise InputError(f"first: expected 0 and then ascending whole numbers below {links}, the number of links")
    return bounds.astype(np.int64)


def _mesh(name: str, mesh: Any) -> FloatArray:
    part = coordinates(f'meshes: the mesh of "{name}"', mesh, "(m, 3, 3)")
    if not len(part):
        raise InputError(f'the mesh of "{name}" has no triangles')
    return part


def _refuse_unusable(part: Part) -> None:
    if not len(part.triangles):
        raise InputError(f'nothing is left of "{part.name}" in rounding: something of it is too thin for its size')
    wrong = int((~np.isfinite(part.triangles)).any(axis=(1, 2)).sum())
    if wrong:
        raise InputError(
            f'{wrong:,} of the {len(part.triangles):,} triangles of "{part.name}" have corners that are not finite '
            "numbers; are its sizes and directions right?"
        )
