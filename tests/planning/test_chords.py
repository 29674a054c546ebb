"""Sections of several chords: a model that cuts every link in two says the same of the arm as the whole links."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planning_makers import between, clearances, random_robot, random_scene

from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.path import Path
from hognose.planning import Task, run_checks
from hognose.planning.certificate import certify, gliding_motion, interpolated_motion
from hognose.planning.penetration import section_clearance
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot import Robot
from hognose.robot.base import Slider, centre_line, joints_on
from hognose.robot.sections.link import RigidLink
from hognose.robot.sections.model import SectionModel
from hognose.scene import Scene
from hognose.steering import SteeredPath

START = np.array([0.1, -0.2, 0.3])
#: How close the certificate comes to what was seen, m: docs/certificate.md.
TIGHTNESS = 2.5e-4


class HalvedLink(RigidLink):
    """A link whose two halves are chords of their own."""

    chords = 2

    def vertices(self, joints, angles=None):
        middles = 0.5 * (joints[..., :-1, :] + joints[..., 1:, :])
        return np.insert(joints, np.arange(1, joints.shape[-2]), middles, axis=-2)

    def bulges(self, low, high, lengths, spin, swing):
        ends = super().bulges(low, high, lengths, spin, swing)
        return np.insert(ends, np.arange(1, ends.shape[1]), np.maximum(ends[:, :-1], ends[:, 1:]), axis=1)

    def sagitta(self, lengths, limits):
        return np.zeros(2 * lengths.size)


def halved(robot, left_out=0.0):
    """The same arm, its links cut in two; `left_out` (m) pretends that the body is so much off the chords."""

    class Halves(HalvedLink):
        def sagitta(self, lengths, limits):
            return super().sagitta(lengths, limits) + left_out

    class Halved(Robot):
        @cached_property
        def model(self) -> SectionModel:
            return Halves()

    return Halved(**{name: getattr(robot, name) for name in Robot.__dataclass_fields__})


@given(seed=st.integers(0, 2**32 - 1), sections=st.integers(1, 5), left_out=st.sampled_from([0.0, 0.002]))
def test_what_is_certified_of_halves_holds_for_the_whole_links(seed, sections, left_out):
    rng = np.random.default_rng(seed)
    robot, base = random_robot(rng, sections), Slider(START, 1.0, 0.0, 0.0)
    halves = halved(robot, left_out)
    angles, feeds = np.cumsum(rng.normal(0, 0.1, (4, sections, 2)), axis=0), np.cumsum(rng.uniform(0, 0.05, 4))
    at = feeds[:, None]
    joints = joints_on(base, robot, angles, at)
    scene = random_scene(rng, joints.min(axis=(0, 1)), joints.max(axis=(0, 1)))
    whole = section_clearance(scene, robot, centre_line(base, robot, joints, at), 1.0)
    found = section_clearance(scene, halves, centre_line(base, halves, joints, at), 1.0)
    outside = whole > 0
    np.testing.assert_allclose(found[outside], whole[outside] - left_out, rtol=0, atol=1e-12)
    vertices = centre_line(base, halves, joints, at)
    proof = certify(interpolated_motion(halves, base, at, angles), halves, scene, vertices, found, 1.0)
    dense = joints_on(base, robot, between(angles, 50), between(at, 50))
    sampled = clearances(scene, robot, dense, 1.0).min() - left_out
    moved = np.linalg.norm(np.diff(dense, axis=0), axis=2).max()
    assert proof.clearance <= max(sampled, 0.0) + 1e-12
    assert proof.clearance <= 0 or proof.clearance >= sampled - TIGHTNESS - moved / 2
    assert 0 <= proof.link < sections


def test_gliding_is_not_proven_of_chords_between_the_joints():
    robot = halved(random_robot(np.random.default_rng(5), 3))
    path = Path.through([[0, 0, 0], [0, 0, 3]], 1)
    with pytest.raises(InputError, match="proven for straight links only"):
        gliding_motion(path, robot, np.linspace(0.0, 0.2, 3))


def test_sections_of_several_chords_are_not_steered():
    robot = halved(random_robot(np.random.default_rng(5), 3))
    with pytest.raises(InputError, match="several chords cannot be steered"):
        SteeredPath(robot, Scene.from_obstacles([]))


def test_gliding_is_not_judged_of_chords_between_the_joints(boards):
    robot = halved(boards.robot)
    plan = dataclasses.replace(boards, task=Task(boards.task.spec, robot), checks=())
    checks = {check.key: check for check in run_checks(plan)}
    assert (checks["certified_along_path"].ok, checks["certified_along_path"].failed) == (None, False)
    assert "straight links only" in checks["certified_along_path"].detail
    assert checks["certified_interpolated"].ok
    assert checks["certified_interpolated"].value <= boards.clearance.min()


def test_tolerances_of_sections_that_bend_along_their_length_are_refused():
    robot = halved(random_robot(np.random.default_rng(5), 3))
    assert Budget.of(ToleranceSpec(), robot, START) is None
    with pytest.raises(InputError, match="known for straight links; the sections of random have 2 chords"):
        Budget.of(ToleranceSpec(cad=0.001), robot, START)


def test_zeros_of_cables_that_bend_sections_in_another_way_are_refused():
    robot = random_robot(np.random.default_rng(5), 3)

    class Other(Robot):
        @cached_property
        def model(self) -> SectionModel:
            return RigidLink()

    other = Other(**{name: getattr(robot, name) for name in Robot.__dataclass_fields__})
    assert Budget.of(ToleranceSpec(cad=0.001, calibration_deg=0.1), other, START) is not None
    with pytest.raises(InputError, match=r"cable_zero: .* for links of one universal joint, not for .* of random;"):
        Budget.of(ToleranceSpec(cable_zero=0.0001), other, START)
