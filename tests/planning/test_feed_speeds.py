"""The speeds at which a task feeds, and those that its base is judged by."""

from __future__ import annotations

import math

import pytest

import hognose
from hognose.planning import Task, TaskSpec
from hognose.planning.base_limits import BaseLimits
from hognose.planning.motion_spec import MotionSpec

ARM = hognose.load_robot("sjtu-25dof")


@pytest.mark.parametrize("way_in", ["constant", "fastest"])
@pytest.mark.parametrize("way_out", ["constant", "fastest", None])
def test_joints_must_be_able_to_turn_at_constant_feed_if_either_way_has_it(way_in, way_out):
    motion = MotionSpec(step=0.002, period_s=0.1, profile=way_in, retraction_profile=way_out)
    assert motion.feed_speed == (0.02 if "constant" in (way_in, way_out) else 0.0)


@pytest.mark.parametrize(
    ("base", "speed", "judged"),
    [
        ({}, 0.05, 0.05),
        ({"kind": "drum", "radius": 0.3}, 0.05, 0.05),
        ({"kind": "arm"}, 0.05, math.inf),
        ({"kind": "arm", "speed": 0.2}, 0.2, 0.2),
    ],
)
def test_only_a_carrier_whose_speed_is_not_said_is_not_judged_by_it(base, speed, judged):
    path = {"way_points": [(0, 0, 0), (0, 0, 0.5)]}
    spec = TaskSpec.model_validate({"name": "t", "robot": "sjtu-25dof", "base": base, "path": path})
    limits = BaseLimits.of(Task(spec, ARM))
    assert (limits.speed, limits.judged_speed) == (speed, judged)
