"""The thin lines of a base are where the base is, and pictures hold the whole motion with them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import hognose
from hognose.planning import Plan
from hognose.report.base_lines import base_points, mount_at, mount_lines, standing_lines, workspace_lines
from hognose.report.render import set_stage
from hognose.robot.base import Mount

SIZE = (600, 300)


@pytest.fixture(scope="module")
def carried() -> Plan:
    return hognose.plan(hognose.load_task("carrier"))


@pytest.fixture(scope="module")
def coiled() -> Plan:
    return hognose.plan(hognose.load_task("drum"))


def test_the_coil_lies_on_the_circle_and_the_nozzle_ends_at_the_entrance(coiled):
    lines, drum = standing_lines(coiled.task), coiled.task.base
    assert all(np.allclose(one[1], other[0], atol=1e-15) for one, other in pairwise(lines[:-1]))
    ring = lines[:-1, 0]
    middle = ring.mean(axis=0)
    on_it = coiled.joints[0][(coiled.joints[0] - lines[-1, 0]) @ drum.direction < 0]
    assert len(on_it) > 5
    for places in (ring, on_it):
        np.testing.assert_allclose(np.linalg.norm(places - middle, axis=1), 0.28, rtol=0, atol=1e-9)
        np.testing.assert_allclose(places[:, 1], 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(lines[-1, 1], coiled.way_points[0], rtol=0, atol=1e-15)
    assert np.linalg.norm(lines[-1, 1] - lines[-1, 0]) == pytest.approx(0.2, abs=1e-15)


def test_the_workspace_is_a_box_between_its_corners(carried):
    lines, box = workspace_lines(carried.task), carried.task.spec.base.workspace
    sides = np.array(box.high) - np.array(box.low)
    assert sorted(np.linalg.norm(np.diff(lines, axis=1)[:, 0], axis=1)) == pytest.approx(sorted(np.repeat(sides, 4)))
    corners, each = np.unique(lines.reshape(-1, 3), axis=0, return_counts=True)
    assert (len(corners), set(each)) == (8, {3})
    assert np.isin(corners, [box.low, box.high]).all()


@given(st.integers(0, 2**32 - 1))
def test_the_mount_is_a_cylinder_behind_the_first_joint(seed):
    rng = np.random.default_rng(seed)
    axes, first = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    own = (mount_lines(Mount(0.3, 0.02, True), first, axes) - first) @ axes
    np.testing.assert_allclose(np.linalg.norm(own[..., :2], axis=2), 0.02, rtol=0, atol=1e-12)
    assert set(np.round(own[..., 2], 12).ravel() + 0.0) == {-0.3, 0.0}
    along = own[np.ptp(own[..., 2], axis=1) > 0.1]
    np.testing.assert_allclose(np.ptp(along, axis=1), [[0, 0, 0.3]] * len(along), rtol=0, atol=1e-12)
    assert len(along) == 4


def test_the_mount_goes_along(carried):
    """On a carrier it is in line with the first link."""
    base = carried.task.base
    for step in (0, 200, -1):
        link = carried.joints[step, 1] - carried.joints[step, 0]
        far = carried.joints[step, 0] - base.mount.length * link / np.linalg.norm(link)
        away = np.linalg.norm(mount_at(carried, step).reshape(-1, 3) - far, axis=1)
        assert away.min() == pytest.approx(base.mount.radius, abs=1e-9)


@pytest.mark.parametrize("name", ["carried", "coiled"])
def test_a_picture_holds_the_whole_motion_and_its_base(name, request):
    plan = request.getfixturevalue(name)
    camera = set_stage(plan, SIZE).camera
    pixels, depth = camera.project(np.concatenate([plan.joints.reshape(-1, 3), base_points(plan)]), SIZE)
    assert (depth > 0).all()
    assert (pixels >= 0).all()
    assert (pixels <= SIZE).all()


def test_a_slider_without_a_mount_has_no_lines(boards):
    assert not len(base_points(boards))
    assert not len(workspace_lines(boards.task))
