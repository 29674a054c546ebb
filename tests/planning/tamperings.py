"""Kinds of tampering with a plan file of eight rows, and what a message must say of each."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
import trimesh
from plan_file_makers import at, replaced

from hognose.planning.embedded import PREFIX, packed
from hognose.robot import Robot, RobotSpec
from hognose.scene import Mesh

#: One column of each kind, and a change of one of its cells that is larger than what is allowed.
CELLS = {
    "time_s": 1e-6,
    "feed_m": 1e-5,
    "joint_00_z_m": 1e-7,
    "joint_07_y_m": 1e-7,
    "alpha_03_rad": 1e-4,
    "beta_12_rad": 1e-4,
    "cable_07_m": 1e-7,
    "motor_36_counts": 1,
    "clearance_12_m": 1e-7,
    "deviation_12_m": 1e-7,
}


@dataclass(frozen=True)
class Tampering:
    """What is changed, and what a message must say of it when the digests are new."""

    named: str
    table: Callable[[Any], Any] | None = None
    meta: Callable[[Any], Any] | None = None
    entries: Callable[[dict[bytes, bytes]], object] | None = None


def rows(table: Any, order: Any) -> Any:
    return table.take(pa.array(np.arange(table.num_rows)[order]))


def cell(change: Callable[[Any], Any]) -> Callable[[np.ndarray], np.ndarray]:
    """One cell in the middle of a column changed."""

    def changed(values: np.ndarray) -> np.ndarray:
        values[len(values) // 2] = change(values[len(values) // 2])
        return values

    return changed


def swapped(one: str, other: str) -> Callable[[Any], Any]:
    def change(table: Any) -> Any:
        names = [{one: other, other: one}.get(name, name) for name in table.column_names]
        return table.rename_columns(names)

    return change


def reordered(order: Any, count: int = 0) -> Tampering:
    """Rows in another order; the metadata says as many rows as there are."""
    return Tampering(
        "'time_s' does not rise|set-points a", lambda table: rows(table, order), at("rows", lambda n: n + count)
    )


def retimed(order: Any, count: int = 0) -> Tampering:
    """The same with times that are as they should be, so that nothing but the motion gives it away."""

    def change(table: Any) -> Any:
        taken = rows(table, order)
        return replaced("time_s", lambda times: 15.0 * np.arange(len(times)))(taken)

    named = "set-points a step apart|tip on target|starts as it lies on its base|is that of an? "
    return Tampering(named, change, at("rows", lambda n: n + count))


def robot_said(change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A change of the robot, with the fingerprint that the changed robot has."""

    def made(said: Any) -> Any:
        change(said["robot"])
        said["robot_fingerprint"] = Robot.from_spec(RobotSpec.model_validate(said["robot"])).fingerprint
        return said

    return made


def of_all_sections(key: str, factor: float) -> Callable[[Any], Any]:
    def change(robot: Any) -> None:
        for section in robot["section"]:
            *way, last = key.split(".")
            place = section
            for name in way:
                place = place[name]
            place[last] *= factor

    return robot_said(change)


#: What is said of a changed cell.
SAID_OF = {
    "time": "set-points a period|'time_s' does not rise",
    "feed": "feed|a step apart|tip error",
    "joint": "joints agree|link lengths|none beyond",
    "alpha": "cables agree|tip error",
    "beta": "cables agree|tip error",
    "cable": "cables agree",
    "motor": "motor counts agree",
    "clearance": "clearance agrees",
    "deviation": "deviation_12_m",
}


def of_column(name: str, least: float) -> dict[str, Tampering]:
    """Everything that is done to one column."""
    words = SAID_OF[name.split("_")[0]]
    whole = name.startswith("motor")

    def kind(change: Callable[[np.ndarray], Any], named: str = name, called: str | None = None) -> Tampering:
        return Tampering(named, replaced(name, change, called))

    kinds = {
        "a little more": kind(cell(lambda x: x + least), words),
        "a little less": kind(cell(lambda x: x - least), words),
        "far more": kind(cell(lambda x: x + 10**6), f"{words}|more than any plan can"),
        "turned round": kind(cell(lambda x: -x - 2 * least), words),
        "shifted by a row": kind(lambda values: np.roll(values, 1), words),
        "doubled": kind(lambda values: 2 * values + whole, f"{words}|bend limits"),
        "single precision": kind(lambda values: values.astype(np.float32)),
        "32 bits": kind(lambda values: values.astype(np.int32)),
        "the other kind": kind(lambda values: values.astype(float if whole else int)),
        "text": kind(lambda values: pa.array([repr(float(x)) for x in values])),
        "a dictionary": kind(lambda values: pa.array([repr(float(x)) for x in values]).dictionary_encode()),
        "an empty cell": kind(lambda values: pa.array([None, *values[1:].tolist()])),
        "renamed": kind(lambda values: values, called=f"{name}_"),
        "dropped": Tampering(name, lambda table: table.drop_columns([name])),
        "twice": Tampering(name, lambda table: table.append_column(name, table.column(name))),
    }
    for word, value in {} if whole else {"NaN": np.nan, "infinite": np.inf, "minus infinite": -np.inf}.items():
        kinds[word] = kind(cell(lambda x, v=value: v))
    return {f"{name}: {word}": tampering for word, tampering in kinds.items()}


#: Columns are refused by what they hold in one place for all, so two of them stand for the others. What the numbers of
#: these say is compared with other numbers, whether one or all are changed, up or down.
ALL_KINDS, SOME = ("alpha_03_rad", "motor_36_counts"), ("a little more", "far more", "shifted by a row")
COLUMNS = {
    key: kind
    for name, least in CELLS.items()
    for key, kind in of_column(name, least).items()
    if name in ALL_KINDS or key.endswith(SOME)
}

COUNTS = "motor counts agree"
OTHERS: dict[str, Tampering] = {
    "counts: the smallest there is": Tampering(COUNTS, replaced("motor_01_counts", cell(lambda x: -(2**63)))),
    "counts: the largest there is": Tampering(COUNTS, replaced("motor_01_counts", cell(lambda x: 2**63 - 1))),
    "counts: all turned round": Tampering(COUNTS, replaced("motor_01_counts", lambda v: -v - 1)),
    "two angles swapped": Tampering("cables|tip", swapped("alpha_05_rad", "beta_05_rad")),
    "two cables swapped": Tampering("cables agree", swapped("cable_01_m", "cable_02_m")),
    "two motors swapped": Tampering(COUNTS, swapped("motor_34_counts", "motor_36_counts")),
    "two clearances swapped": Tampering("clearance agrees", swapped("clearance_11_m", "clearance_12_m")),
    "time and feed swapped": Tampering("time_s|feed|set-points", swapped("time_s", "feed_m")),
    "a motor more": Tampering("motor_37_counts", lambda t: t.append_column("motor_37_counts", t["motor_01_counts"])),
    "a joint more": Tampering("joint_13_x_m", lambda t: t.append_column("joint_13_x_m", t["joint_12_x_m"])),
    "a feed in other letters": Tampering("FEED_M", lambda t: t.append_column("FEED_M", t["feed_m"])),
    "first row dropped": reordered(slice(1, None), -1),
    "middle row dropped": reordered(np.r_[0:3, 4:8], -1),
    "last row dropped": retimed(slice(0, -1), -1),
    "first row dropped, retimed": retimed(slice(1, None), -1),
    "middle row dropped, retimed": retimed(np.r_[0:3, 4:8], -1),
    "a row twice": reordered(np.r_[0:4, 3:8], 1),
    "a row twice, retimed": retimed(np.r_[0:4, 3:8], 1),
    "last row twice, retimed": retimed(np.r_[0:8, 7], 1),
    "two rows swapped": reordered(np.r_[0:3, 4, 3, 5:8]),
    "two rows swapped, retimed": retimed(np.r_[0:3, 4, 3, 5:8]),
    "all rows backwards": reordered(slice(None, None, -1)),
    "all rows backwards, retimed": retimed(slice(None, None, -1)),
    "cut to half, retimed": retimed(slice(0, 4), -4),
    "rows cut, metadata as before": Tampering("says 8 rows, but there are 7", lambda t: rows(t, slice(0, -1))),
    "time twice as fast": Tampering("set-points a period apart", replaced("time_s", lambda v: v / 2)),
    "time half as fast": Tampering("set-points a period apart", replaced("time_s", lambda v: v * 2)),
    "time later": Tampering("set-points a period apart", replaced("time_s", lambda v: v + 0.1)),
    "time in fits": Tampering("set-points a period", replaced("time_s", lambda v: v + 0.01 * (np.arange(len(v)) % 2))),
    "feed stretched": Tampering("set-points a step apart|feed", replaced("feed_m", lambda v: v * 1.001)),
    "feed moved": Tampering("starts as it lies on its base|feed", replaced("feed_m", lambda v: v + 1e-4)),
}  # fmt: skip

FINGERPRINT = "fingerprint"
METADATA: dict[str, Tampering] = {
    "bend limits loosened": Tampering(FINGERPRINT, meta=at("robot.section.0.bend_limit_deg", 80.0)),
    "joint speed loosened": Tampering(FINGERPRINT, meta=at("robot.limits.joint_speed_deg_s", 700.0)),
    "robot's name": Tampering(FINGERPRINT, meta=at("robot.name", "another")),
    "fingerprint": Tampering(FINGERPRINT, meta=at("robot_fingerprint", "0123456789abcdef")),
    "cable circle": Tampering("cables agree", meta=of_all_sections("cable_radius", 1.01)),
    "pitch": Tampering("link lengths|feed|joints", meta=of_all_sections("pitch", 1.001)),
    "body thinner": Tampering("clearance agrees", meta=of_all_sections("body_diameter", 0.99)),
    "gear": Tampering(COUNTS, meta=of_all_sections("transmission.gear_ratio", 1.01)),
    "half lengths": Tampering("cables agree", meta=robot_said(
        lambda robot: robot["section"][0].update(half_lengths=[x * 1.1 for x in robot["section"][0]["half_lengths"]]))),
    "azimuths": Tampering("cables agree", meta=robot_said(
        lambda robot: robot["section"][0].update(cable_azimuth_step_deg=7.0))),
    "tool longer": Tampering("link|joint", meta=robot_said(lambda robot: robot.update(tool_length=0.05))),
    "one section less": Tampering("unknown", meta=robot_said(lambda r: r["section"][0].update(count=11))),
    "one section more": Tampering("missing", meta=robot_said(lambda r: r["section"][0].update(count=13))),
    "bend limits tightened": Tampering("bend limits", meta=robot_said(
        lambda robot: robot["section"][0].update(bend_limit_deg=2.0))),
    "an obstacle removed": Tampering("clearance agrees", meta=lambda said: _without_obstacle(said, 2)),
    "all obstacles removed": Tampering(
        "clearance agrees", meta=lambda s: {**s, "geometry": [], "task": {**s["task"], "obstacle": []}},
        entries=lambda held: [held.pop(key) for key in list(held) if key.startswith(PREFIX.encode())]),
    "an obstacle moved": Tampering("clearance agrees", meta=at("task.obstacle.1.center.2", 1.071)),
    "margin raised": Tampering("clearance at steps", meta=at("task.margin", 0.1)),
    "another target": Tampering("path through|tip on", meta=at("task.path.way_points.1.0", lambda x: x + 0.001)),
    "another way": Tampering("joint|path|tip", meta=at("way_points_m.1.0", lambda x: x + 0.001)),
    "a way-point less": Tampering("joint|path|tip", meta=at("way_points_m", lambda points: [points[0], points[-1]])),
    "another kind of path": Tampering("joint|path|tip|feed", meta=at("task.path.kind", "bspline")),
    "another order": Tampering("joint|path|tip|feed", meta=at("task.path.order", 4)),
    "another method": Tampering("joint|tip", meta=at("task.motion.method", "prediction")),
    "another step": Tampering("set-points a step apart", meta=at("task.motion.step", 0.159)),
    "another period": Tampering("set-points a period apart", meta=at("task.motion.period_s", 7.5)),
    "another horizon": Tampering("clearance agrees", meta=at("clearance_horizon_m", 0.03)),
    "rows": Tampering("says 9 rows, but there are 8", meta=at("rows", 9)),
    "the way": Tampering("says a retraction", meta=at("retracts", True)),
    "schema older": Tampering("plan schema 1 has no key .*altered", meta=at("schema", 1)),
    "schema oldest": Tampering("Plan the task anew", meta=at("schema", 0)),
    "schema newer": Tampering("Update Hognose", meta=at("schema", 3)),
    "schema true": Tampering("schema", meta=at("schema", True)),
    "version gone": Tampering("version", meta=at("version", ...)),
    "a key more": Tampering("units", meta=at("units", "mm")),
    "a key of the task more": Tampering("speedup", meta=at("task.motion.speedup", 2)),
    "verdict without its checks": Tampering("`good`", meta=at("good", False)),
    "no checks": Tampering("`good`", meta=at("checks", [])),
    "a check that failed": Tampering("`good`", meta=at("checks.0.ok", False)),
    "geometry exchanged": Tampering(
        "does not hold the geometry of|unknown", meta=at("geometry.0", "0" * 64)),
    "geometry of what has none": Tampering("comes from no file", meta=at("geometry.1", lambda _: "0" * 64)),
    "geometry forgotten": Tampering("geometry|unknown", meta=at("geometry", [])),
    "mesh exchanged": Tampering("is not the one", entries=lambda held: _other_mesh(held)),
    "mesh gone": Tampering("does not hold the geometry of", entries=lambda held: held.pop(_mesh_key(held))),
    "mesh that nothing needs": Tampering("unknown", entries=lambda held: held.update({b"hognose.geometry.00": b"x"})),
    "an entry more": Tampering("hognose.offsets", entries=lambda held: held.update({b"hognose.offsets": b"{}"})),
    "digests gone": Tampering("digests", entries=lambda held: held.pop(b"hognose.sha256")),
    "a digest gone": Tampering("has no digest", entries=lambda held: held.update(
        {b"hognose.sha256": held[b"hognose.sha256"].replace(b'"cable_07_m"', b'"cable_99_m"')})),
    "digests no JSON": Tampering("damaged", entries=lambda held: held.update({b"hognose.sha256": b"{"})),
    "digests a list": Tampering("damaged|digests", entries=lambda held: held.update({b"hognose.sha256": b"[]"})),
    "metadata gone": Tampering("not a plan", entries=lambda held: held.pop(b"hognose")),
}  # fmt: skip
ALL = COLUMNS | OTHERS | METADATA


def _without_obstacle(said: Any, which: int) -> Any:
    del said["task"]["obstacle"][which]
    del said["geometry"][which]
    return said


def _mesh_key(held: dict[bytes, bytes]) -> bytes:
    return next(key for key in held if key.startswith(PREFIX.encode()))


def _other_mesh(held: dict[bytes, bytes]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        trimesh.creation.box((0.01, 0.01, 0.01)).export(f"{folder}/small.stl")
        mesh = Mesh.model_validate({"file": f"{folder}/small.stl", "units": "m"})
        held[_mesh_key(held)] = packed(mesh.geometry).encode()
