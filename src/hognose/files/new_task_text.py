"""The text of a new task file, with a comment on each of its keys."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterable, Sequence

from hognose.robot.base import FORWARD
from hognose.units import LENGTH_UNITS

Place = tuple[float, float, float]

#: So many names of bodies are listed; `hognose scene` lists all.
_LISTED = 12


def task_text(
    *,
    name: str,
    file: str,
    units: str,
    robot: str,
    margin: float,
    entrance: Place,
    direction: Place,
    target: Place,
    step: float,
    space: str,
    kind: str,
    space_units: str | None,
    diameter: float | None,
    solid: bool,
    bodies: Sequence[str],
) -> str:
    """A task whose route is searched; every line that is commented out is valid as well.

    Lengths are in `units`. `file` is its own name, `space` and `robot` are named as seen from there; for the rest see
    `hognose.files.new_task.Wanted`.
    """
    head = [
        f"# Written by `hognose new`. Plan it:  hognose plan {shlex.quote(file)}",
        '# Lines that begin with "# " and a key show what else can be said: remove the "# ". All keys: docs/files.md.',
        "schema = 1",
        f"name = {_text(name)}",
        *_beside(
            (f"units = {_text(units)}", "of every length in this file"),
            (f"robot = {_text(robot)}", "a bundled arm (`hognose robot` lists them), or a robot file beside this one"),
            (f"margin = {_number(margin)}", "clearance that the whole motion must keep, also between the steps"),
        ),
    ]
    tables = (
        head,
        base_table(direction),
        _path(entrance, direction, target),
        _motion(step),
        _tolerance(units),
        _obstacle(space, kind, units, space_units, diameter, solid, bodies),
    )
    return "\n\n".join("\n".join(lines) for lines in tables if lines) + "\n"


def base_table(direction: Place) -> list[str]:
    """The table `[base]`, which says where the arm points at the start, line by line; that only if it is not +z."""
    x, y, z = direction
    ahead = (x, y) == FORWARD[:2] and z > 0
    given = [] if ahead else [(f"direction = {_place(direction)}", "along which the arm enters")]
    kind = ('# kind = "arm"', 'a carrier takes the first joint along, no slider; or "drum", "cart": docs/base.md')
    return ["[base]", *_beside(*given, kind)]


def _path(entrance: Place, direction: Place, target: Place) -> list[str]:
    return [
        "[path] # places are in the frame of the file below",
        *_beside(
            (f"entrance = {_place(entrance)}", "where the tip is at the start; the arm lies straight behind it"),
            (f"target = {_place(target)}", "where the tip goes; the route there is searched"),
            (f"# via = [{_place(_between(entrance, target))}]", "places to pass on the way, in this order"),
            (f"# tip_direction = {_place(direction)}", "where the tip is to point at the target …"),
            ("# tip_cone_deg = 10.0", "… and how far it may point elsewhere"),
        ),
        "# With way-points nothing is searched. They replace entrance and target, which are the first and the last:",
        f"# way_points = [{_place(entrance)}, {_place(target)}]",
    ]


def _motion(step: float) -> list[str]:
    return [
        "[motion]",
        *_beside(
            (f"step = {_number(step)}", "feed per step"),
            ("period_s = 0.15", "time per step"),
            ('# profile = "fastest"', "as fast as the robot's limits allow, from rest to rest: docs/profile.md"),
            ('method = "exact"', "how the body follows the nose; `hognose methods` lists others"),
        ),
    ]


def _tolerance(units: str) -> list[str]:
    millimetre = _number(0.001 / LENGTH_UNITS[units])
    return [
        "[tolerance] # what is not known exactly is taken off every clearance: docs/tolerances.md",
        *_beside(
            (f"# cad = {millimetre}", "bound: how far surfaces are from the drawing"),
            (f"# registration = {millimetre}", "1 sigma: the place of the base, along each axis"),
            ("# registration_deg = 0.02", "1 sigma: its turn, about each axis"),
            ("# calibration_deg = 0.1", "1 sigma: the zero of each joint angle"),
            ("# timing_s = 0.1", "bound: how early or late obstacles that move may be"),
        ),
    ]


def _obstacle(
    space: str, kind: str, own: str, units: str | None, diameter: float | None, solid: bool, bodies: Sequence[str]
) -> list[str]:
    far = _number(0.1 / LENGTH_UNITS[own])
    keys = [(f'kind = "{kind}"', ""), (f"file = {_text(space)}", "named as seen from this file")]
    if units is not None:
        keys.append((f"units = {_text(units)}", "of the numbers in that file"))
    if diameter is not None:
        keys.append((f"diameter = {_number(diameter)}", "of the ball around each point: more than their distance"))
    keys += [
        ("# position = [0.0, 0.0, 0.0]", "moves the file; in its own frame nothing needs to be moved"),
        ("# rotation_deg = [0.0, 0.0, 0.0]", "turns it before that: R = R_z R_y R_x"),
    ]
    if kind == "mesh":
        keys.append((f"{'# ' if solid else ''}solid = false", "surfaces without an inside, such as a duct"))
    if len(bodies) > 1:
        keys.append((f"# without = [{_text(_literally(bodies[-1]))}]", "bodies to leave out, or `bodies`, to keep"))
    lines = [
        "[[obstacle]] # add as many as there are: files, boxes, pipes, boards with holes …",
        *_beside(*keys),
    ]
    if len(bodies) > 1:
        more = f" and {len(bodies) - _LISTED} more" if len(bodies) > _LISTED else ""
        lines.append(f"# Its bodies: {', '.join(map(_text, bodies[:_LISTED]))}{more}.")
    return [
        *lines,
        "# It may move; more of that in docs/moving-obstacles.md:",
        f"# motion = [{{time_s = 0.0}}, {{time_s = 10.0, position = [0.0, 0.0, {far}]}}]",
    ]


def _beside(*keys: tuple[str, str]) -> list[str]:
    """Lines with comments, which begin in one column."""
    widest = max(len(key) for key, _ in keys)
    return [f"{key:<{widest}} # {comment}" if comment else key for key, comment in keys]


def _between(one: Place, other: Place) -> Place:
    x, y, z = (0.5 * (a + b) for a, b in zip(one, other, strict=True))
    return x, y, z


def _literally(name: str) -> str:
    """A name as a pattern that means nothing else."""
    return "".join(f"[{sign}]" if sign in "*?[" else sign for sign in name)


def _place(coordinates: Iterable[float]) -> str:
    return f"[{', '.join(map(_number, coordinates))}]"


def _number(value: float) -> str:
    return repr(float(f"{value:.15g}") + 0.0)  # no minus zero


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", r"\u007f")
