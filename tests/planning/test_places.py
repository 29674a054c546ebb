"""The places that a path has to pass are called what the task file calls them, on every kind of base."""

from __future__ import annotations

import re

import numpy as np
import pytest

import hognose
from hognose.errors import HognoseError
from hognose.planning import Task, TaskSpec
from hognose.planning.places import places
from hognose.planning.planner import plan_along, refuse_buried_places
from hognose.route import Search
from hognose.route.search.bottleneck import crowded
from hognose.route.why import partial

ARM = hognose.load_robot("sjtu-25dof")
WAY = ((0, 0, 0), (0.02, 0.01, 0.2), (0.03, 0.03, 0.35), (0.03, 0.04, 0.5))
BASES = {
    "slider": {},
    "cart": {"kind": "cart", "position": (0, 0, -1.25)},
    "drum": {"kind": "drum", "radius": 0.28, "nozzle": 0.1},
    "carrier": {"kind": "arm"},
}
ALONG = {"way_points": WAY}
SEARCHED = {"entrance": WAY[0], "via": WAY[1:-1], "target": WAY[-1]}
NAMES = {
    "along": [
        ("path.way_points", "the entrance"),
        ("path.way_points", "way-point 2"),
        ("path.way_points", "way-point 3"),
        ("path.way_points", "the target"),
    ],
    "searched": [
        ("path.entrance", "the entrance"),
        ("path.via", "the place via 1"),
        ("path.via", "the place via 2"),
        ("path.target", "the target"),
    ],
}


def on(base: str, way: str | dict, *obstacles: dict, **more: object) -> Task:
    said = way if isinstance(way, dict) else ALONG if way == "along" else SEARCHED
    spec = {"name": "p", "robot": "sjtu-25dof", "base": BASES[base], "path": said, "obstacle": obstacles, **more}
    return Task(TaskSpec.model_validate(spec), ARM)


def ball(at, diameter: float, **more: object) -> dict:
    return {"kind": "sphere", "name": "ball", "center": tuple(at), "diameter": diameter, **more}


@pytest.mark.parametrize("path", NAMES)
@pytest.mark.parametrize("base", BASES)
def test_every_place_is_called_what_the_file_calls_it(base: str, path: str):
    task = on(base, path)
    expected = NAMES[path]
    if base == "cart":
        expected = [("base.position", "the nose of the straight arm"), *expected]
    found = places(task)
    assert [(place.key, place.words) for place in found] == expected
    np.testing.assert_array_equal([place.at for place in found], task.way_points)
    for place in found:
        buried = on(base, path, ball(place.at, 0.03))
        with pytest.raises(HognoseError, match=f"^{re.escape(place.key)}: {place.words} at .* lies inside .*'ball'"):
            refuse_buried_places(buried)
        beside = np.add(place.at, (0, 0.04, 0))  # nearer than half the body with its margin
        gap = crowded(on(base, path, ball(beside, 0.03)))
        assert gap is not None
        assert gap.sentences[0].startswith(f"{place.words} at ")


@pytest.mark.parametrize("base", ["slider", "cart", "drum", "carrier"])
def test_where_tolerances_leave_too_little_the_place_is_named(base: str):
    for place in places(on(base, "along")):
        radius = float(ARM.body_radii[-1])
        tight = on(
            base, "along", ball(np.add(place.at, (0, radius + 0.031, 0)), 0.05), tolerance={"registration": 0.01}
        )
        with pytest.raises(HognoseError, match=f"^tolerance: {place.words} at "):
            plan_along(tight)


@pytest.mark.parametrize("base", BASES)
def test_what_covers_the_nose_as_its_clock_begins_is_said_to(base: str):
    place = places(on(base, "along"))[0]
    gone = [{"time_s": 0.0}, {"time_s": 1.0, "position": (9.0, 0.0, 0.0)}]
    with pytest.raises(HognoseError, match=f"{place.words} at .* lies inside it"):
        refuse_buried_places(on(base, "along", ball(place.at, 0.03, motion=gone)))


@pytest.mark.slow
@pytest.mark.parametrize("base", ["slider", "cart"])
def test_how_far_the_arm_gets_is_tried_towards_the_target_not_the_entrance(base: str):
    wall = {"kind": "board", "name": "wall", "center": (0, 0, 0.4), "size": (3, 3), "thickness": 0.01}
    plan = partial.nearest(Search(on(base, {"target": (0, 0, 0.6)}, wall), None, 0))
    assert plan is not None
    assert plan.good
    assert 0.2 < plan.body[-1, -1, 2] < 0.4


@pytest.mark.parametrize(
    ("base", "run"),
    [
        ("slider", "the slider's run"),
        ("cart", "the slider's run"),
        ("drum", "the coil and the nozzle of the drum"),
        ("carrier", "the straight run before the entrance"),
    ],
)
def test_a_path_that_folds_back_is_said_to_be_beside_what_the_arm_lies_on(base: str, run: str):
    folded = {"way_points": ((0, 0, 0), (0.03, 0, 0.04), (0.01, 0, 0.01)), "detour": False}
    with pytest.raises(HognoseError, match=f"it lies too close beside {run}, or"):
        plan_along(on(base, folded))
