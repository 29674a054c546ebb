"""A move that is interrupted leaves nothing behind on which the arm may go without it having been proven."""

import numpy as np
import pytest
from section_makers import WIDE, thin_arm

from hognose.scene import Box, Scene
from hognose.steering import SteeredPath

MARGIN, STEP = 0.005, 0.004
WALL = Scene.from_obstacles([Box(name="wall", center=(0, 0, 0.1), size=(1, 1, 0.02))])


class Interrupted(BaseException):
    """As KeyboardInterrupt, which a test runner takes for its own."""


def interrupt(*_):
    raise Interrupted


def before_the_wall(kind):
    """An arm whose nose is as close to a wall as it may be."""
    steered = SteeredPath(thin_arm(kind, kind, kind), WALL, margin=MARGIN)
    while steered.advance(STEP, (0.0, 0.0)).held_by is None:
        pass
    return steered


@pytest.mark.parametrize("kind", ["link", "hinges", "joints", "arc"])
@pytest.mark.parametrize(
    "where", ["_way.reach", "_way.arm", "_surroundings.proven", "_surroundings.clearance", "_way.cut", "_curve.cut"]
)
def test_what_an_interrupted_move_left_is_not_taken_for_proven(kind, where, monkeypatch):
    steered = before_the_wall(kind)
    depth, joints = steered.depth, steered.joints
    owner, name = where.split(".")
    with monkeypatch.context() as patched:
        patched.setattr(getattr(steered, owner), name, interrupt)
        with pytest.raises(Interrupted):
            steered.advance(STEP, (1.0, 0.0))
    assert steered.depth == pytest.approx(depth, abs=STEP / 10)
    for _ in range(3):
        held = steered.advance(STEP).held_by
        assert held is not None
        assert held.reason == "clearance"
        assert steered.clearance.min() >= MARGIN
    steered.retreat(steered.depth - depth / 2)
    steered.advance(depth / 2)
    np.testing.assert_allclose(steered.joints, joints, rtol=0, atol=STEP / 10)
    assert steered.advance(STEP).held_by is not None
    assert steered.clearance.min() >= MARGIN


@pytest.mark.parametrize("kind", ["link", "arc"])
def test_an_interrupt_while_a_nose_gets_to_where_it_is_proven_to_go_leaves_its_clearance_true(kind, monkeypatch):
    steered = before_the_wall(kind)
    steered.retreat(0.02)
    with monkeypatch.context() as patched:
        patched.setattr(steered._surroundings, "clearance", interrupt)
        with pytest.raises(Interrupted):
            steered.advance(0.02)
    fresh = steered._surroundings.clearance(steered.vertices[None])[0]
    np.testing.assert_array_equal(steered.clearance, steered._surroundings.of_sections(fresh))


def test_the_reason_is_what_holds_first_where_the_end_of_a_move_breaks_another_limit():
    limits = {**WIDE["limits"], "cable_speed": 1e-4, "cable_travel": (-0.002, 0.002)}
    arm = thin_arm("arc", "arc", "arc", limits=limits)
    steered = SteeredPath(arm, Scene.from_obstacles([]), period_s=0.1)
    held = None
    for _ in range(2000):
        held = steered.advance(0.02, (8.0, 0.0)).held_by
        assert held is not None
        if held.reason != "cable speed":
            break
    assert held is not None
    assert held.reason == "cable travel"
    travel = arm.cable_lengths(steered.angles) - arm.straight_cable_lengths
    assert np.abs(travel).max() == pytest.approx(0.002, rel=0.02)
