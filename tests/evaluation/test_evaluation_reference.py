"""The judge: joints by a search of its own, and how far others are from the first crossing."""

import math

import numpy as np
import pytest
from evaluation_makers import marched, ring_case, small_case

from hognose.errors import InfeasibleError
from hognose.evaluation.reference import first_crossings, off_first_crossing
from hognose.path import Path


def test_on_a_straight_line_joints_are_links_apart():
    path = Path.through([[0, 0, 0], [0, 0, 1]])
    joints, arcs = first_crossings(path, np.array([0.1, 0.2, 0.3]), np.array([0.0, 0.35]))
    assert np.allclose(arcs, [[0, 0.1, 0.3, 0.6], [0.35, 0.45, 0.65, 0.95]], atol=1e-13)
    assert np.allclose(joints[..., 2], arcs, atol=1e-13)
    assert not joints[..., :2].any()


def test_on_a_circle_equal_chords_take_equal_arcs():
    radius, link = 0.2, 0.091
    angle = np.linspace(0.0, 1.9 * math.pi, 400)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    path = Path.through(points, 5, (0.0, 1.0, 0.0))
    _, arcs = first_crossings(path, np.full(4, link), np.linspace(0.1, 0.5, 9))
    assert np.allclose(np.diff(arcs, axis=1), 2.0 * radius * math.asin(link / 2.0 / radius), atol=2e-7)


def test_the_first_of_several_crossings_is_found():
    """On a ring smaller than a link's reach most of it is a link away twice; a march says which comes first."""
    case = ring_case(0.06)
    joints, arcs = case.reference
    for step in range(len(case.feeds)):
        for link, length in enumerate(case.link_lengths):
            first = marched(case.path, arcs[step, link], joints[step, link], length - 1e-9, 1e-5)
            assert arcs[step, link + 1] == pytest.approx(first, abs=1.1e-5)


def test_an_arm_longer_than_its_path_is_infeasible():
    path = Path.through([[0, 0, 0], [0, 0, 1]])
    with pytest.raises(InfeasibleError, match="step 1: the arm ends 50 mm beyond the path"):
        first_crossings(path, np.array([0.5]), np.array([0.1, 0.55]))


def test_joints_where_they_belong_are_off_by_nothing():
    case = small_case()
    off = off_first_crossing(case.path, case.link_lengths, case.feeds, case.reference[0])
    assert off.shape == (5, 4)
    assert off.max() < 1e-12


def test_a_joint_on_another_crossing_is_off_by_much_of_a_link():
    case = ring_case(0.06)
    joints, arcs = case.reference
    length = case.link_lengths[0]
    # The second crossing: where the ring comes within a link of the joint again.
    later = np.arange(arcs[-1, 1] + 1e-3, case.path.length, 1e-5)
    second = later[np.linalg.norm(case.path.point(later) - joints[-1, 0], axis=1) <= length][0]
    wrong = joints[-1:].copy()
    wrong[0, 1] = case.path.point(second)
    assert abs(np.linalg.norm(wrong[0, 1] - wrong[0, 0]) - length) < 2e-5, "a link away all the same"
    off = off_first_crossing(case.path, case.link_lengths[:1], case.feeds[-1:], wrong[:, :2])
    assert off[0, 1] > length / 2


def test_being_off_does_not_add_up_along_the_arm():
    """Joints drifting by 0.1 mm more at every link are 0.1 mm off, not as much as the drift has become."""
    path = Path.through([[0, 0, 0], [0, 0, 2]])
    lengths, feeds = np.full(10, 0.1), np.array([0.2])
    drifted = path.point(0.2 + np.arange(11) * 0.1001)[None]
    off = off_first_crossing(path, lengths, feeds, drifted)
    assert off[0, 0] == 0.0
    assert np.allclose(off[0, 1:], 1e-4, atol=1e-12)


def test_a_joint_beside_the_path_is_off_by_that():
    case = small_case()
    moved = case.reference[0].copy()
    moved[:, 0, 1] += 0.003
    assert off_first_crossing(case.path, case.link_lengths, case.feeds, moved)[:, 0] == pytest.approx(0.003)
