"""Whatever a public function is given: an answer, or an error of ours that names the argument; never a traceback."""

from __future__ import annotations

import datetime
import functools
import inspect
import warnings
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

import hognose
from hognose.scene import Box
from hognose.steering import Move, SteeredTask

ROBOT = hognose.load_robot("sjtu-25dof")
TASK = hognose.load_task("pipe-tank")
PATH = hognose.Path.through([[0, 0, 0], [0.1, 0.05, 0.5], [0, 0, 1.2]], start_direction=[0, 0, 1]).with_run(1.1)
ARCS = hognose.load_robot("metabot-3arc")
SCENE = hognose.Scene.from_obstacles([Box(center=(0.5, 0, 0.5), size=(0.1, 0.1, 0.1))])
STRAIGHT = np.zeros((ROBOT.sections, 2))
JOINTS = ROBOT.joint_positions(STRAIGHT)
POINTS = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.5], [0.0, 0.0, 1.0]]


class Silent:
    """An object that is nothing in particular."""

    def __init__(self, *ignored: object) -> None:
        del ignored


#: What nobody should give, but somebody does.
ODD: dict[str, Any] = {
    "none": None, "text": "x", "no text": "", "bytes": b"x", "number": 3, "fraction": 0.5, "zero": 0, "negative": -1,
    "true": True, "nan": float("nan"), "inf": float("inf"), "huge": 1.7e308, "tiny": 5e-324, "big": 10**400,
    "complex": 1j, "object": Silent(), "class": Silent, "function": len, "empty": [], "dict": {}, "set": {1},
    "texts": ["a", "b"], "numbers as text": ["0", "0", "1"], "ragged": [[1.0], [1.0, 2.0]], "nested": [[[1.0]]],
    "no numbers": [None, None, None], "bools": [True, False, True], "nans": [float("nan")] * 3,
    "huge ones": [1.7e308] * 3, "huge pairs": [[1.7e308] * 3, [-1.7e308] * 3], "tiny ones": [5e-324] * 3,
    "big ones": [10**400] * 3, "bool array": np.ones((3, 3), bool), "complex array": np.ones((3, 3), complex),
    "object array": np.array([Silent()] * 3), "text array": np.array(["1.0"] * 3), "scalar array": np.array(0.5),
    "empty array": np.empty((0, 3)), "deep array": np.zeros((2, 2, 2, 2)), "dates": np.array(["2020-01-01"], "M8[D]"),
    "date": datetime.date(2020, 1, 1), "path": FilePath("x"), "generator": (x for x in range(3)), "robot": ROBOT,
    "task": TASK, "curve": PATH, "scene": SCENE, "nul": "a\0b", "long": "n" * 5000,
}  # fmt: skip


@functools.cache
def made() -> hognose.Plan:
    return hognose.plan(TASK)


def steered() -> hognose.SteeredPath:
    return hognose.SteeredPath(ROBOT, SCENE)


def follower() -> Any:
    return hognose.follower(PATH, ROBOT.link_lengths)


#: Every public function and method: how it is reached, and arguments that suit.
CALLS: dict[str, tuple[Callable[[], Callable[..., Any]], dict[str, Any]]] = {
    "load_robot": (lambda: hognose.load_robot, {"source": "sjtu-25dof", "relative_to": None}),
    "load_task": (lambda: hognose.load_task, {"source": "pipe-tank"}),
    "plan": (lambda: hognose.plan, {"task": TASK, "progress": print, "seconds": 1.0, "seed": 0}),
    "follow": (
        lambda: hognose.follow,
        {
            "path": PATH, "link_lengths": [0.1, 0.1], "feeds": [0.0, 0.1], "method": "exact", "spacing": 0.0005,
            "bend_limits": 0.5, "model": ROBOT.model, "axes": None, "carried": False,
        },
    ),
    "follower": (
        lambda: hognose.follower,
        {
            "path": PATH, "link_lengths": [0.1, 0.1], "method": "prediction", "spacing": 0.0005, "bend_limits": 0.5,
            "model": ROBOT.model, "axes": None, "carried": False,
        },
    ),
    "follower, of arcs": (
        lambda: hognose.follower,
        {
            "path": PATH, "link_lengths": ARCS.link_lengths, "method": "aim", "spacing": 0.0005, "bend_limits": 0.5,
            "model": ARCS.model, "axes": np.eye(3), "carried": True,
        },
    ),
    "Follower.step": (lambda: follower().step, {"feed": 0.1}),
    "Follower.run": (lambda: follower().run, {"feeds": [0.1, 0.2]}),
    "Path": (lambda: hognose.Path, {"breaks": PATH.breaks, "coefficients": PATH.coefficients}),
    "Path.through": (lambda: hognose.Path.through, {"points": POINTS, "order": 3, "start_direction": None}),
    "Path.bezier": (lambda: hognose.Path.bezier, {"points": POINTS, "start_direction": [0, 0, 1]}),
    "Path.bspline": (lambda: hognose.Path.bspline, {"points": POINTS, "order": 3, "start_direction": [0, 0, 1]}),
    "Path.with_run": (lambda: PATH.with_run, {"length": 1.0}),
    "Path.with_end": (lambda: PATH.with_end, {"length": 1.0}),
    "Path.with_lead": (lambda: PATH.with_lead, {"lead": PATH}),
    "Path.reversed": (lambda: PATH.reversed, {}),
    "Path.distance_to": (lambda: PATH.distance_to, {"points": POINTS}),
    "Path.parameter": (lambda: PATH.parameter, {"s": 0.1}),
    "Path.arc_length": (lambda: PATH.arc_length, {"u": 0.1}),
    "Path.point": (lambda: PATH.point, {"s": [0.1, 0.2]}),
    "Path.tangent": (lambda: PATH.tangent, {"s": 0.1}),
    "Path.frame": (lambda: PATH.frame, {"s": 0.1}),
    "Path.curvature": (lambda: PATH.curvature, {"s": 0.1}),
    "Path.equal_distance_points": (lambda: PATH.equal_distance_points, {"spacing": 0.01}),
    "Robot.from_spec": (lambda: hognose.Robot.from_spec, {"spec": ROBOT.spec}),
    "Robot.angles": (lambda: ROBOT.angles, {"joints": JOINTS}),
    "Robot.joint_positions": (
        lambda: ROBOT.joint_positions,
        {"angles": STRAIGHT, "feed": 0.1, "lengths": ROBOT.link_lengths},
    ),
    "Robot.tip_pose": (lambda: ROBOT.tip_pose, {"angles": STRAIGHT, "feed": 0.1, "lengths": ROBOT.link_lengths}),
    "Robot.cable_lengths": (lambda: ROBOT.cable_lengths, {"angles": STRAIGHT, "lengths": ROBOT.link_lengths}),
    "Robot.section_lengths": (lambda: ROBOT.section_lengths, {"joints": JOINTS}),
    "Robot.lengths_from_cables": (
        lambda: ROBOT.lengths_from_cables,
        {"cable_lengths": [ROBOT.straight_cable_lengths], "near": [STRAIGHT]},
    ),
    "Robot.angles_from_cables": (
        lambda: ROBOT.angles_from_cables,
        {"cable_lengths": [ROBOT.straight_cable_lengths], "near": [STRAIGHT]},
    ),
    "Robot.lengths_of_counts": (lambda: ROBOT.lengths_of_counts, {"counts": [0] * ROBOT.cables}),
    "Robot.motor_counts": (lambda: ROBOT.motor_counts, {"cable_lengths": ROBOT.straight_cable_lengths}),
    "Scene.from_obstacles": (
        lambda: hognose.Scene.from_obstacles,
        {"obstacles": [Box(center=(0, 0, 0), size=(1, 1, 1))], "tolerance": 1e-4},
    ),
    "Scene.from_meshes": (lambda: hognose.Scene.from_meshes, {"names": ["a"], "meshes": [SCENE.triangles]}),
    "Scene.clearance": (
        lambda: SCENE.clearance,
        {"starts": JOINTS[None, :-1], "ends": JOINTS[None, 1:], "radii": ROBOT.body_radii, "horizon": 0.05,
         "threads": None, "first": [0, 5]},
    ),
    "Scene.alone": (lambda: SCENE.alone, {"obstacle": 0}),
    "Scene.distance": (lambda: SCENE.distance, {"starts": POINTS, "ends": POINTS, "upper": 1.0, "threads": 1}),
    "Scene.witness": (lambda: SCENE.witness, {"start": POINTS[0], "end": POINTS[1]}),
    "Scene.obstacle_of": (lambda: SCENE.obstacle_of, {"triangle": 0}),
    "Scene.inside": (lambda: SCENE.inside, {"points": POINTS}),
    "Task": (lambda: hognose.Task, {"spec": TASK.spec, "robot": ROBOT}),
    "Task.with_obstacles": (lambda: TASK.with_obstacles, {"scene": SCENE, "moving": ()}),
    "Task.share_obstacles": (lambda: TASK.share_obstacles, {"other": TASK}),
    "Task.scene_at": (lambda: TASK.scene_at, {"time": 1.0}),
    "Task.gravity": (lambda: TASK.gravity, {"at": np.zeros((1, 1))}),
    "Task.held": (
        lambda: TASK.held,
        {"angles": STRAIGHT[None], "at": np.zeros((1, 1)), "lengths": ROBOT.link_lengths[None]},
    ),
    "Task.commanded_lengths": (
        lambda: TASK.commanded_lengths,
        {"angles": STRAIGHT[None], "at": np.zeros((1, 1)), "lengths": ROBOT.link_lengths[None]},
    ),
    "Task.path_through": (lambda: TASK.path_through, {"way_points": TASK.way_points}),
    "Plan.check": (lambda: made().check, {"key": "bend_limits"}),
    "Plan.summary": (lambda: made().summary, {}),
    "Plan.verified": (lambda: made().verified, {"progress": print, "more": ()}),
    "Plan.save": (lambda: made().save, {"path": "made.parquet"}),
    "Plan.load": (lambda: hognose.Plan.load, {"path": "made.parquet", "progress": print}),
    "SteeredPath": (
        lambda: hognose.SteeredPath,
        {"robot": ROBOT, "scene": SCENE, "entrance": [0, 0, 0], "margin": 0.005, "period_s": 0.1, "base": TASK.base,
         "tolerances": np.zeros(ROBOT.sections), "budget": None, "method": "exact"},
    ),
    "SteeredPath.of": (lambda: hognose.SteeredPath.of, {"task": TASK, "period_s": None, "method": None}),
    "SteeredPath.advance": (lambda: steered().advance, {"distance": 0.01, "turn": [0.1, 0.1]}),
    "SteeredPath.retreat": (lambda: steered().retreat, {"distance": 0.01}),
    "SteeredPath.task": (lambda: advanced().task, {"name": "mine", "obstacles": [], "tolerance": 0.001}),
}  # fmt: skip


@functools.cache
def advanced() -> hognose.SteeredPath:
    path = steered()
    path.advance(0.05)
    return path


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> None:
    """Nothing is written elsewhere."""
    monkeypatch.chdir(tmp_path)


def sound(value: Any) -> bool:
    """Whether no number in an answer is NaN."""
    if isinstance(value, float | np.ndarray | np.generic):
        return not np.isnan(value).any()
    if isinstance(value, tuple | list):
        return all(map(sound, value))
    if is_dataclass(value) and isinstance(value, hognose.Path | hognose.Plan | hognose.Robot | Move | SteeredTask):
        return all(sound(getattr(value, field.name)) for field in fields(value))
    return True


@pytest.mark.parametrize("name", list(CALLS))
def test_what_suits_is_taken(name):
    made().save("made.parquet")
    reach, good = CALLS[name]
    assert sound(reach()(**good))


@pytest.mark.parametrize(
    ("name", "argument"), [(name, argument) for name, (_, good) in CALLS.items() for argument in good]
)
def test_an_odd_argument_gives_an_answer_or_an_error_that_names_what_is_wrong(name, argument):
    reach, good = CALLS[name]
    call = reach()
    for what, odd in ODD.items():
        answer = outcome(call, {**good, argument: odd})
        if isinstance(answer, hognose.HognoseError):
            assert len(str(answer)) > 14
            assert "Error" not in str(answer)
            assert isinstance(answer, hognose.InputError) or what in ("number", "fraction", "zero", "tiny", "true")
        else:
            assert sound(answer), (name, argument, what)


def outcome(call: Callable[..., Any], arguments: dict[str, Any]) -> Any:
    """What a call returns, or the error of ours that it raises; any other escapes, and so does every warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return call(**arguments)
        except hognose.HognoseError as error:
            return error


SURELY_WRONG = ["text", "bytes", "object", "complex", "nan", "dict", "big", "complex array", "text array", "ragged"]


@pytest.mark.parametrize(
    ("name", "argument"),
    [
        (name, argument)
        for name, (_, good) in CALLS.items()
        for argument, value in good.items()
        if isinstance(
            value, float | int | list | np.ndarray | hognose.Path | hognose.Robot | hognose.Task | hognose.Scene
        )
    ],
)
def test_what_is_surely_wrong_is_an_input_error_that_names_the_argument(name, argument):
    reach, good = CALLS[name]
    for what in SURELY_WRONG:
        with pytest.raises(hognose.InputError) as caught:
            reach()(**{**good, argument: ODD[what]})
        said = str(caught.value)
        words = {"points": "way-point", "seconds": "time", "obstacles": "obstacle", "names": "names"}
        assert argument in said or words.get(argument, "?") in said or name == "Path", (what, said)


#: Values that are made by ours, whose constructors nobody calls.
MADE_BY_OURS = {"Robot", "Scene", "Plan", "Check"}


def test_no_public_function_is_left_out():
    names = set()
    for name in hognose.__all__:
        thing = getattr(hognose, name)
        if inspect.isfunction(thing):
            names.add(name)
        elif inspect.isclass(thing) and not issubclass(thing, Exception):
            names |= {name} - MADE_BY_OURS
            for member, value in vars(thing).items():
                plain = getattr(value, "__func__", value)
                if not member.startswith("_") and inspect.isfunction(plain):
                    names.add(f"{name}.{member}")
    assert names - {"Scene.from_parts", "Plan.of"} <= set(CALLS)
    for name, (reach, good) in CALLS.items():
        assert set(good) == set(inspect.signature(reach()).parameters), name
