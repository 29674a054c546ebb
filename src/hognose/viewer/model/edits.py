"""Edits of a task: functions from what a task says to what it says then."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from hognose.errors import InputError
from hognose.files.toml_source import validate
from hognose.path import Path
from hognose.planning import Plan, TaskSpec
from hognose.planning.task import PathSpec
from hognose.scene import ObstacleModel
from hognose.units import FileModel

#: An edit.
Change = Callable[[TaskSpec], TaskSpec]


def validated(spec: TaskSpec, source: str) -> TaskSpec:
    """The same spec, checked like a file's.

    Parameters
    ----------
    spec
        Perhaps made by `model_copy`, which checks nothing. Obstacles are taken as they are.
    source
        What the messages call it.

    Raises
    ------
    InputError
        All of its faults, each with its key.
    """
    data = {field.alias or name: getattr(spec, name) for name, field in TaskSpec.model_fields.items()}
    parts = {name: dict(value) for name, value in data.items() if isinstance(value, FileModel)}
    made = validate(data | parts | {"units": "m"}, TaskSpec, source)
    return made.model_copy(update={"obstacle": spec.obstacle})  # the very same tuple


def move_way_point(index: int, place: ArrayLike) -> Change:
    """Put a way-point at another place (3,) m; of a search, entrance, target or what is via; `index` counts from 0."""
    moved = _point(place)

    def change(spec: TaskSpec) -> TaskSpec:
        stops = list(spec.path.stops)
        stops[_known(index, stops)] = moved
        return _through(spec, stops)

    return change


def add_way_point(index: int, place: ArrayLike | None = None) -> Change:
    """Put a way-point behind another one; behind the last, before it.

    Parameters
    ----------
    index
        Of the one it comes behind, from 0.
    place : (3,) m, optional
        Unless given, in the middle of the curve to the next one, so that the path hardly changes.
    """
    given = None if place is None else _point(place)

    def change(spec: TaskSpec) -> TaskSpec:
        stops = list(spec.path.stops)
        before = min(_known(index, stops), len(stops) - 2)
        if before < 0:
            raise InputError("path.way_points: there is only one; no way-point can be added after it")
        stops.insert(before + 1, given or _middle(spec, before))
        return _through(spec, stops)

    return change


def remove_way_point(index: int) -> Change:
    """Take a way-point out; entrance and target stay, they can be moved."""

    def change(spec: TaskSpec) -> TaskSpec:
        stops = list(spec.path.stops)
        if _known(index, stops) in (0, len(stops) - 1):
            which = "entrance" if index == 0 else "target"
            raise InputError(f"the {which} cannot be removed, only moved; remove a way-point between the ends")
        del stops[index]
        return _through(spec, stops)

    return change


def set_order(order: int) -> Change:
    """Draw the path with pieces of another degree."""
    return lambda spec: _with_path(spec, order=order)


def set_step(step: float) -> Change:
    """Make the motion of other feed steps (m)."""
    return lambda spec: _with_motion(spec, step=step)


def set_margin(margin: float) -> Change:
    """Ask for another clearance (m)."""
    return lambda spec: spec.model_copy(update={"margin": margin})


def set_method(method: str) -> Change:
    """Follow the path with another method."""
    return lambda spec: _with_motion(spec, method=method)


def set_robot(robot: str) -> Change:
    """Take another robot: a bundled one, or a file beside the task's."""
    return lambda spec: spec.model_copy(update={"robot": robot})


def solids(spec: TaskSpec) -> tuple[ObstacleModel, ...]:
    """All that the arm must keep away from, boxes to be kept out of included and named, as `Task.scene` has them."""
    boxes = enumerate(spec.path.keep_out, 1)
    return (*spec.obstacle, *(box.model_copy(update={"name": box.name or f"keep-out {k}"}) for k, box in boxes))


def take_route_of(plan: Plan) -> Change:
    """As `take_route`, along the way of a plan; where its path begins at a cart's nose, that is left to the base."""
    return take_route(plan.way_points if plan.task.nose is None else plan.way_points[1:])


def take_route(way_points: ArrayLike) -> Change:
    """Make a search's task one along the route it found, from the entrance to the target, (m, 3) m.

    What was asked of the way stays and is checked.
    """
    points = tuple(_point(point) for point in np.asarray(way_points))
    start = PathSpec.model_fields["entrance"].default
    return lambda spec: _with_path(spec, way_points=points, target=None, entrance=start)


def ask_for_route(spec: TaskSpec) -> TaskSpec:
    """Make a task along way-points one that searches from the first to the last, with all that is asked of the way."""
    if spec.path.target is not None:
        return spec
    first, *_, last = spec.path.way_points
    order = max(spec.path.order, 2)
    return _with_path(spec, way_points=(), kind="spline", entrance=first, target=last, order=order)


def take_steered(steered: TaskSpec) -> Change:
    """Take over what was steered; what is asked of the way stays and is checked."""
    way = {name: getattr(steered.path, name) for name in ("way_points", "kind", "order", "detour")}

    def change(spec: TaskSpec) -> TaskSpec:
        start = PathSpec.model_fields["entrance"].default
        return _with_path(spec.model_copy(update={"motion": steered.motion}), target=None, entrance=start, **way)

    return change


def _with_path(spec: TaskSpec, **update: object) -> TaskSpec:
    return spec.model_copy(update={"path": spec.path.model_copy(update=update)})


def _with_motion(spec: TaskSpec, **update: object) -> TaskSpec:
    return spec.model_copy(update={"motion": spec.motion.model_copy(update=update)})


def _through(spec: TaskSpec, stops: Sequence[tuple[float, ...]]) -> TaskSpec:
    if spec.path.target is None:
        return _with_path(spec, way_points=tuple(stops))
    return _with_path(spec, entrance=stops[0], via=tuple(stops[1:-1]), target=stops[-1])


def _known(index: int, stops: Sequence[object]) -> int:
    if not 0 <= index < len(stops):
        raise InputError(f"there is no way-point {index + 1}; there are {len(stops)}")
    return index


def _point(place: ArrayLike) -> tuple[float, float, float]:
    try:
        x, y, z = (float(c) for c in np.asarray(place, dtype=np.float64))
    except (TypeError, ValueError):
        raise InputError(f"a position is three numbers in m, got {place!r}") from None
    return x, y, z


def _middle(spec: TaskSpec, before: int) -> tuple[float, float, float]:
    """Half way along a spline's piece; of anything else in the middle of the straight line."""
    path, stops = spec.path, np.array(spec.path.stops)
    if path.target is not None or path.kind != "spline" or path.order == 1:
        return _point(stops[before : before + 2].mean(axis=0))
    curve = Path.through(stops, path.order, spec.direction)
    chords = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(stops, axis=0), axis=1))])
    ends = curve.arc_length(curve.breaks[0] + chords[before : before + 2])
    return _point(curve.point(ends.mean()))
