"""Derivatives of cable lengths through sections of all kinds, and the bound of the third one."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_oracles import tapered_robot
from section_makers import mixed, mixed_robot

from hognose.robot.cable_gains import angles_per_length
from hognose.robot.cable_terms import ENTRIES, THIRD, terms
from hognose.robot.section_cable import CableLaw
from hognose.robot.sections import KINDS, Geometry

seeds = st.integers(0, 2**32 - 1)
FOUND = {"link": {}, "hinges": {"axis_offset": 0.02}, "joints": {"joints": 5}, "arc": {"disks": 6}, "led": {}}


def course_of(kind, entering, radius, azimuth):
    """What `terms` finds at angles within a reach, and the lengths of the same cable at angles (T, 2)."""
    name = "arc" if kind == "led" else kind
    planes = (0.0, 0.0) if name == "arc" else (0.004, 0.006)
    shape = Geometry(
        0.1, *planes, 0.02, (0.7, 0.7), **{"joints": None, "axis_offset": None, "disks": None, **FOUND[kind]}
    )
    row = np.array([*KINDS[name].cable_law(shape)], dtype=float)
    c, s = math.cos(azimuth), math.sin(azimuth)

    def found(at, reach=0.0):
        out = np.empty(ENTRIES)
        terms(False, np.empty(4), np.asarray(at), np.array(planes), np.array([radius, c, s]), row, entering, radius,
              reach, out)  # fmt: skip
        return out

    def lengths(at):
        one = (np.array([each]) for each in (radius, c, s, entering))
        return KINDS[name].cables(shape, np.atleast_2d(at), *one)[:, 0]

    return found, lengths


@pytest.mark.parametrize("kind", list(FOUND))
@pytest.mark.parametrize("entering", [0.019, 0.012, 0.026])
def test_derivatives_are_differences_and_the_third_is_below_its_bound(kind, entering):
    rng = np.random.default_rng(5)
    for _ in range(6):
        at, azimuth = rng.uniform(-0.8, 0.8, 2), rng.uniform(0, 2 * math.pi)
        found, lengths = course_of(kind, entering, 0.019, azimuth)
        steps, h = np.arange(-2, 3), 2e-3
        grid = at + h * np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
        values = lengths(grid).reshape(5, 5)
        first, second = np.array([1, -8, 0, 8, -1]) / (12 * h), np.array([-1, 16, -30, 16, -1]) / (12 * h * h)
        expected = [first @ values[:, 2], first @ values[2], second @ values[:, 2], second @ values[2],
                    first @ values @ first]  # fmt: skip
        np.testing.assert_allclose(found(at)[:THIRD], expected, rtol=0, atol=1e-7)
        # Along lines through the place, in all directions and as far as the reach.
        reach = 0.15
        bound, largest = found(at, reach)[THIRD], 0.0
        for way in rng.normal(size=(8, 2)):
            line = at + np.linspace(-reach, reach, 61)[:, None] * way / np.linalg.norm(way)
            largest = max(largest, np.abs(np.diff(lengths(line), 3)).max() / (reach / 30) ** 3)
        assert largest <= bound + 1e-7
        assert kind in ("link", "hinges") or bound < 0.1  # those may be bent so far that a cable has no length


def test_a_link_that_keeps_its_circle_is_the_same_by_both_formulas():
    rng = np.random.default_rng(1)
    for _ in range(20):
        angles, reach, around = rng.uniform(-0.6, 0.6, 2), rng.uniform(0, 0.2), rng.uniform(0, 6)
        trig = np.array([np.cos(angles[0]), np.sin(angles[0]), np.cos(angles[1]), np.sin(angles[1])])
        hole, law = np.array([0.019, np.cos(around), np.sin(around)]), np.array(CableLaw(0.01, 0.02))
        both = np.empty((2, ENTRIES))
        for plain, out in zip((True, False), both, strict=True):
            terms(plain, trig, angles, law[:2], hole, law, 0.019, 0.019, reach, out)
        np.testing.assert_allclose(both[0], both[1], rtol=1e-12, atol=1e-16)


def test_a_cable_that_may_have_no_length_has_no_bound():
    found, _ = course_of("link", 0.019, 0.019, 0.0)
    assert math.isfinite(found((0.0, 0.0), 0.3)[THIRD])
    assert found((0.0, 0.0), 0.6)[THIRD] == math.inf  # planes 10 mm apart on a circle of 19 mm


@settings(deadline=None, max_examples=6)
@given(seeds, st.booleans())
def test_angles_change_with_cables_as_their_inverse_does(seed, rigid):
    robot = tapered_robot(seed, 4, passing=True) if rigid else mixed_robot(seed, 4, passing=True)
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-0.3, 0.3, (1, robot.sections, 2))
    lengths, gains = robot.cable_lengths(angles), angles_per_length(robot, angles)[0]
    for cable in rng.integers(robot.cables, size=3):
        off = 1e-6 * np.eye(robot.cables)[cable]
        more, less = (robot.angles_from_cables(lengths + sign * off, angles)[0] for sign in (1, -1))
        np.testing.assert_allclose(gains[..., cable], (more - less) / 2e-6, rtol=1e-5, atol=1e-4)


def test_ends_of_chords_move_by_no_more_than_their_levers():
    for seed in range(8):
        rng, robot = np.random.default_rng(seed), mixed_robot(seed, 5)
        angles = rng.uniform(-0.6, 0.6, (robot.sections, 2))
        where = robot.model.vertices(robot.joint_positions(angles))
        for _ in range(8):
            off = rng.normal(size=angles.shape) * rng.uniform(0, 0.2)
            moved = np.linalg.norm(robot.model.vertices(robot.joint_positions(angles + off)) - where, axis=1)
            assert (moved <= mixed(robot).levers @ np.linalg.norm(off, axis=1) + 1e-12).all()
        # A straight arm that bends at its first section alone moves by almost as much.
        small = np.zeros_like(angles)
        small[0, 0] = 1e-4
        straight = robot.model.vertices(robot.joint_positions(np.zeros_like(angles)))
        tip = np.linalg.norm(robot.model.vertices(robot.joint_positions(small)) - straight, axis=1)[-1]
        assert tip >= 0.9e-4 * mixed(robot).levers[-1, 0]
