"""`hognose robot`."""

from __future__ import annotations

import shlex
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hognose.cli.completers import robots
from hognose.cli.options import Flag
from hognose.wording import span

if TYPE_CHECKING:
    from hognose.robot import Robot
    from hognose.robot.spec import SectionSpec


#: What keys that only some kinds of sections have are, behind their numbers.
_OWN = {"joints": "joints", "axis_offset": "mm apart", "disks": "disks", "bending_stiffness_N_m2": "N m²"}


def robot(
    name: Annotated[str | None, Parameter(completer=robots)] = None,
    /,
    *,
    write: Path | None = None,
    force: Flag = False,
    json: Flag = False,
) -> int:
    """Print a robot as tables, list the bundled robots, or copy the file of one to start another from.

    Parameters
    ----------
    name
        A bundled robot, or a robot file; without it, the bundled robots are listed.
    write
        Copy the file of this bundled robot, with its comments; the name of the copy ends in .toml.
    force
        Replace the copy if it is there.
    json
        Print the robot as JSON, in SI units.
    """
    from hognose.cli.console import say, say_json, table
    from hognose.files import bundled_robots, load_robot

    if write is not None:
        return _copy(name, write, force, json)
    if name is None:
        described = [[bundled, load_robot(bundled).spec.description] for bundled in bundled_robots()]
        if json:
            say_json({"robots": [bundled for bundled, _ in described]})
        else:
            table(("robot", "what it is"), described)
        return 0
    loaded = load_robot(name)
    if json:
        say_json({**loaded.spec.model_dump(by_alias=True), "units": "m", "fingerprint": loaded.fingerprint})
        return 0
    say(f"{loaded.name}: {loaded.spec.description}")
    say(f"source: {loaded.spec.source or 'not said'}; fingerprint {loaded.fingerprint}")
    say("* marks values that nobody published and that are assumed: replace them with your machine's.\n")
    table(("whole arm", "value", "unit"), _whole_arm(loaded))
    say("")
    kind = ("kind",) if _has_kinds(loaded) else ()
    if loaded.outline.flat:
        say(f"the body is flat: {loaded.outline.loss_words}\n")
    table(("section", "pitch mm", "h1, h2 mm", "body mm", "bend limit deg", "link mass kg", *kind), _joints(loaded))
    say("")
    table(("section", "circle mm", "azimuths deg", "um/count", "motor, gear, counts a turn"), _cables(loaded))
    return 0


def _copy(name: str | None, file: Path, force: bool, as_json: bool) -> int:
    from hognose.cli.console import new_file, say, say_json
    from hognose.errors import InputError
    from hognose.files import bundled_robots
    from hognose.files.loading import robot_text
    from hognose.write_whole import write_whole

    if name is None:
        raise InputError(f"--write: which robot? Name one: hognose robot {bundled_robots()[0]} --write {file}")
    if file.suffix != ".toml":
        raise InputError(f"{file}: the name of a robot file must end in .toml")
    write_whole(new_file(file, force), robot_text(name))
    if as_json:
        say_json({"good": True, "file": str(file)})
        return 0
    say(f"written to {file}: a copy of {name}. Change its `name` and values, and take out of `assumed` what you know")
    say(f"next:\n  hognose robot {shlex.quote(str(file))}   shows it")
    say(f"then name it in a task: robot = {dumps(file.name)}")
    return 0


def _whole_arm(robot: Robot) -> list[list[str]]:
    spec, pulled = robot.spec, robot.spec.limits.cable_acceleration
    rows = [
        ("sections", f"{robot.sections}", "", ""),
        ("cables", f"{robot.cables}", "", ""),
        ("length, first joint to tip", f"{1e3 * robot.length:g}", "mm", ""),
        ("base length", f"{1e3 * spec.base_length:g}", "mm", "base_length"),
        ("tool length", f"{1e3 * spec.tool_length:g}", "mm", "tool_length"),
        ("mass of the links", f"{robot.link_masses.sum():.4g}", "kg", "section.link_mass"),
        *([("tool mass", f"{robot.tool_mass:.4g}", "kg", "tool_mass")] if robot.tool_mass else []),
        ("slider travel", f"{1e3 * spec.feed.min:g} to {1e3 * spec.feed.max:g}", "mm", "feed.max"),
        ("feed speed", f"{1e3 * spec.feed.speed:g}", "mm/s", "feed.speed"),
        ("feed acceleration", f"{1e3 * spec.feed.acceleration_limit:g}", "mm/s²", "feed.acceleration"),
        ("joint speed", f"{spec.limits.joint_speed_deg_s:g}", "deg/s", "limits.joint_speed_deg_s"),
        (
            "joint acceleration",
            f"{spec.limits.joint_acceleration_deg_s2:g}",
            "deg/s²",
            "limits.joint_acceleration_deg_s2",
        ),
        ("cable speed", f"{1e3 * spec.limits.cable_speed:g}", "mm/s", "limits.cable_speed"),
        *(
            ()
            if pulled is None
            else [("cable acceleration", f"{1e3 * pulled:g}", "mm/s²", "limits.cable_acceleration")]
        ),
        (
            "cable travel",
            "{:g} to {:g}".format(*(1e3 * x for x in spec.limits.cable_travel)),
            "mm",
            "limits.cable_travel",
        ),
        ("motor counts", "{} to {}".format(*spec.limits.motor_counts), "counts", "limits.motor_counts"),
        *_springs(robot),
        *_tolerances(robot),
    ]
    return [[name, value + _mark(robot, key), unit] for name, value, unit, key in rows]


def _springs(robot: Robot) -> list[tuple[str, str, str, str]]:
    """The cables as springs, where the robot file has them."""
    given = robot.spec.cables
    if given is None:
        return []
    stiffness, pretension = (
        span(given.for_cables(key, robot.cable_sections)) for key in ("axial_stiffness_N", "pretension_N")
    )
    return [
        ("axial stiffness EA", stiffness, "N", "cables.axial_stiffness_N"),
        ("free length of cables", f"{1e3 * given.free_length:g}", "mm", "cables.free_length"),
        ("pretension", pretension, "N", "cables.pretension_N"),
        ("tension", f"{given.tension_min_N:g} to {given.tension_max_N:g}", "N", "cables.tension_min_N"),
        ("friction of cables", f"{given.friction:g}", "", "cables.friction"),
        ("least load factor of buckling", f"{given.load_factor_min:g}", "", "cables.load_factor_min"),
    ]


def _tolerances(robot: Robot) -> list[tuple[str, str, str, str]]:
    """Names, values, units and keys of the tolerances that the file gives; none where it gives none."""
    import numpy as np

    said, rows = robot.spec.tolerance, []
    given = (
        ("calibration of a joint, 1σ", said.calibration_deg, 1.0, "deg", "calibration_deg"),
        ("zero of a cable, 1σ", said.cable_zero, 1e3, "mm", "cable_zero"),
        ("sag left, at most", said.sag, 1e3, "mm", "sag"),
        ("axial stiffness EA, 1σ", said.axial_stiffness_percent, 1.0, "%", "axial_stiffness_percent"),
        ("masses, 1σ", said.mass_percent, 1.0, "%", "mass_percent"),
    )
    for name, value, factor, unit, key in given:
        values = factor * np.atleast_1d(value)
        if values.any():
            rows.append((name, span(values), unit, f"tolerance.{key}"))
    return rows


def _joints(robot: Robot) -> list[list[str]]:

    rows = []
    for number, group in enumerate(_groups(robot), 1):
        bend = dict.fromkeys(
            f"±{high:.2f}" if low == -high else f"{low:.2f} to {high:.2f}" for low, high in group.bend_ranges
        )
        cells = [
            (f"{1e3 * group.pitch:g}", "pitch"),
            ("{:g}, {:g}".format(*(1e3 * h for h in group.hole_planes)), "half_lengths"),
            _body(group),
            (", ".join(bend), "bend_limit_deg"),
            (f"{group.link_mass:g}", "link_mass"),
            *([(_kind(robot, group), "kind")] if _has_kinds(robot) else []),
        ]
        rows.append([str(number), *(text + _mark(robot, f"section.{key}") for text, key in cells)])
    return rows


def _cables(robot: Robot) -> list[list[str]]:
    import numpy as np

    rows = []
    azimuths = np.degrees(robot.cable_azimuths).round(9)
    for number, group in enumerate(_groups(robot), 1):
        gear = group.transmission
        screw = gear.screw_lead is not None
        motor = (
            f"screw {1e3 * (gear.screw_lead or 0):g} mm" if screw else f"drum {1e3 * (gear.drum_diameter or 0):g} mm"
        )
        lead = _mark(robot, f"section.transmission.{'screw_lead' if screw else 'drum_diameter'}")
        ratio = _mark(robot, "section.transmission.gear_ratio")
        counts = _mark(robot, "section.transmission.counts_per_turn")
        own = azimuths[robot.cable_sections == number - 1]
        rows.append(
            [
                str(number),
                _circles(robot, group),
                ", ".join(f"{x:g}" for x in own) + _mark(robot, "section.cable_azimuths_deg"),
                f"{1e6 * gear.travel_per_count:.4g}" + (lead or ratio or counts),
                f"{motor}{lead}, {gear.gear_ratio:g}{ratio}, {gear.counts_per_turn}{counts}",
            ]
        )
    return rows


def _has_kinds(robot: Robot) -> bool:
    """Whether its sections are more than links that turn freely."""
    return not robot.straight_links or any(group.bending_stiffness_N_m2 for group in robot.spec.section)


def _body(group: SectionSpec) -> tuple[str, str]:
    """The size of a section's body (mm), and the key that says it."""
    if group.shape.sides is None:
        return f"{2e3 * group.shape.radius:g}", "body_diameter"
    return "{:g} x {:g}".format(*(1e3 * side for side in group.shape.sides)), "body_width"


def _circles(robot: Robot, group: SectionSpec) -> str:
    """The circle of a section's cables, and that of those which pass it, if it is given: `16, passing 18`."""
    own = f"{1e3 * group.cable_radius:g}" + _mark(robot, "section.cable_radius")
    if group.passing_cable_radius is None:
        return own
    return f"{own}, passing {1e3 * group.passing_cable_radius:g}" + _mark(robot, "section.passing_cable_radius")


def _kind(robot: Robot, group: SectionSpec) -> str:
    """The kind of a section with what only this kind has: `joints, 6`."""
    given = {key: getattr(group, key) for key in _OWN} | {"axis_offset": group.axis_offset and 1e3 * group.axis_offset}
    said = [
        f"{value:g} {word}{_mark(robot, f'section.{key}')}"
        for key, word in _OWN.items()
        if (value := given[key]) is not None
    ]
    if group.length_range is not None:
        low, high = (1e3 * length for length in group.length_range)
        said.append(f"{low:g} to {high:g} long{_mark(robot, 'section.length_range')}")
    return ", ".join([group.kind, *said])


def _groups(robot: Robot) -> list[SectionSpec]:
    """The group of every section."""
    return [group for group in robot.spec.section for _ in range(group.count)]


def _mark(robot: Robot, key: str) -> str:
    """An asterisk where the key or a table that holds it is assumed, or a slider's acceleration is not given."""
    if key == "feed.acceleration" and robot.spec.feed.acceleration is None:
        return "*"
    return "*" if any(key == assumed or key.startswith(assumed + ".") for assumed in robot.assumed) else ""
