"""Distances within one body: against sampled points, closed forms, and folds of all kinds."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hognose.robot.kinematics import positions_of
from hognose.robot.own_body import OwnBody, bends_of, separation
from tests.own_body_oracles import dense_clearance

seeds = st.integers(0, 2**32 - 1)
ROUNDING = 1e-9


def body_of(angles: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Joints (n+1, 3) of an arm at angles (n, 2)."""
    return positions_of(angles[None], np.zeros(1), lengths)[0][0]


def planar(bends: list[float] | np.ndarray) -> np.ndarray:
    """Angles (n, 2) of an arm that bends in a plane."""
    return np.column_stack([bends, np.zeros(len(bends))])


@given(seed=seeds, apart=st.floats(0.0, 1.0), shape=st.sampled_from(["any", "parallel", "folded", "straight"]))
def test_the_separation_is_that_of_the_closest_points_that_are_no_neighbours(seed, apart, shape):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(4, 3))
    if shape == "parallel":
        corners[3] = corners[2] + rng.uniform(0.3, 2.0) * (corners[1] - corners[0])
    elif shape != "any":  # one line, run through to and fro or onwards
        along, sign = rng.normal(size=3), -1.0 if shape == "folded" else 1.0
        corners[1:] = [corners[0] + along, corners[0] + along, corners[0] + (1.0 + sign * rng.uniform(0.3, 2)) * along]
    first, second = (float(np.linalg.norm(corners[k + 1] - corners[k])) for k in (0, 2))
    between = apart * (first + second)
    value, u, v = separation(corners[None], 0, 0, 2, first, second, between)
    assert 0.0 <= u <= first * (1 + 1e-12)
    assert 0.0 <= v <= second * (1 + 1e-12)
    assert u + v >= between * (1 - 1e-12)
    a, b = (corners[0] - corners[1]) / first, (corners[3] - corners[2]) / second
    off = corners[1] - corners[2]
    assert value == pytest.approx(np.linalg.norm(off + u * a - v * b), abs=ROUNDING)
    # For every u the best v there is has a closed form.
    us = np.linspace(0.0, first, 2001)
    us = us[us >= between - second - 1e-12 * first]
    vs = np.clip((off + us[:, None] * a) @ b, np.clip(between - us, 0.0, second), second)
    best = np.linalg.norm(off + us[:, None] * a - vs[:, None] * b, axis=1).min(initial=math.inf)
    assert value <= best + ROUNDING
    assert value >= best - first / 2000


@given(seed=seeds, sections=st.integers(1, 12), bend=st.floats(0.0, 1.2))
def test_the_closest_links_are_those_of_sampled_points(seed, sections, bend):
    rng = np.random.default_rng(seed)
    lengths, radii = rng.uniform(0.05, 0.15, sections), rng.uniform(0.01, 0.04, sections)
    joints = body_of(rng.normal(0.0, bend, (sections, 2)), lengths)
    value, pair = OwnBody.chain(lengths, radii).closest(joints[None])
    spacing = 0.004
    dense, _ = dense_clearance(joints, lengths, radii, spacing)
    if not math.isfinite(value[0]):
        assert dense == math.inf
        assert pair[0] == -1
        return
    # Points that just miss the neighbours' limit are left out by the samples, by a spacing at most.
    assert dense - 2 * spacing <= value[0] <= dense + ROUNDING


@given(seed=seeds, sections=st.integers(2, 30), size=st.floats(0.0, 1.5))
def test_points_are_as_far_apart_as_their_arc_and_bends_say(seed, sections, size):
    rng = np.random.default_rng(seed)
    lengths, angles = rng.uniform(0.01, 1.0, sections), rng.normal(0.0, size / sections, (sections, 2))
    joints, bends = body_of(angles, lengths), bends_of(angles)
    directions = np.diff(joints, axis=0) / lengths[:, None]
    turned = np.arccos(np.clip((directions[1:] * directions[:-1]).sum(axis=1), -1.0, 1.0))
    assert (turned <= bends[1:] + 1e-6).all()
    phi = bends[1:].sum()
    if phi < math.pi:
        distance = np.linalg.norm(joints[-1] - joints[0])
        assert distance >= lengths.sum() * math.cos(phi / 2) - ROUNDING


def test_the_bound_of_arc_and_bends_is_reached_by_one_bend_in_the_middle():
    for phi in np.linspace(0.1, 3.1, 31):
        joints = body_of(planar([0.0, phi]), np.ones(2))
        assert np.linalg.norm(joints[2] - joints[0]) == pytest.approx(2 * math.cos(phi / 2), abs=1e-12)


@given(seed=seeds, sections=st.integers(2, 20), size=st.floats(0.0, 4.0))
def test_what_bends_clear_is_clear(seed, sections, size):
    rng = np.random.default_rng(seed)
    lengths, radii = rng.uniform(0.03, 0.15, sections), rng.uniform(0.01, 0.04, sections)
    own, angles = OwnBody.chain(lengths, radii), rng.normal(0.0, size / sections, (sections, 2))
    if own.cleared_by_bends(bends_of(angles)[None]):
        assert own.closest(body_of(angles, lengths)[None])[0][0] >= own.horizon - ROUNDING


def test_a_straight_arm_is_cleared_by_its_bends_however_thick_it_is():
    for thick in (0.01, 0.1, 1.0):
        own = OwnBody.chain(np.full(30, 0.1), np.full(30, thick))
        assert own.cleared_by_bends(np.zeros((1, 30)))


def test_bends_up_to_the_limit_of_a_pair_are_cleared_and_none_beyond():
    """One joint between links long enough: with D the diameter, (π/2) D cos(φ/2) is D and the horizon at φ."""
    own = OwnBody.chain(np.full(2, 0.3), np.full(2, 0.05))
    phi = 2 * math.acos((0.1 + own.horizon) / (0.1 * math.pi / 2))
    assert own.cleared_by_bends(np.array([[9.0, phi * (1 - 1e-9)]]))
    assert not own.cleared_by_bends(np.array([[0.0, phi * (1 + 1e-9)]]))
    value, _ = own.closest(body_of(planar([0.0, phi]), own.lengths)[None])
    assert value[0] == pytest.approx(own.horizon, abs=1e-12)


@pytest.mark.parametrize(("pitch", "bend"), [(1.2, 94.78), (2.0, 104.47)])
def test_the_second_next_link_touches_from_the_bend_of_the_closed_form(pitch, bend):
    """The free ends of links 1 and 3 are pitch (1 + 2 cos bend) apart: as much as they are thick."""
    lengths, radii = np.full(3, pitch), np.full(3, 0.5)
    own = OwnBody.chain(lengths, radii)
    assert pitch * (1 + 2 * math.cos(math.radians(bend))) == pytest.approx(1.0, abs=1e-3)
    for beyond, touches in ((-0.1, False), (0.1, True)):
        joints = body_of(planar(np.radians([0.0, bend + beyond, bend + beyond])), lengths)
        away, _ = own.apart(joints, 0, 2)
        assert (away < 0) is touches


@given(pitch=st.floats(0.2, 3.0), joints=st.integers(1, 8), legs=st.floats(2.0, 5.0))
def test_a_hairpin_is_found_however_finely_the_body_is_divided(pitch, joints, legs):
    """Legs that lie beside each other, closer than the body is thick: in diameters, pitch and legs."""
    joints = min(joints, 1 + int(2.2 / pitch))
    straight = max(1, math.ceil(legs / pitch))
    bends = np.concatenate([np.zeros(straight), np.full(joints, math.pi / joints), np.zeros(straight - 1)])
    lengths, radii = np.full(len(bends), pitch), np.full(len(bends), 0.5)
    body = body_of(planar(bends), lengths)
    between = np.linalg.norm(np.cross(body[-1] - body[0], [0.0, 0.0, 1.0]))
    value, pair = OwnBody.chain(lengths, radii).closest(body[None])
    assert value[0] <= between - 1.0 + ROUNDING
    if between < 1.0 - 1e-6:
        assert value[0] < 0
        assert pair[0] >= 0


@given(radius=st.floats(1.0, 5.0), pitch=st.floats(0.1, 3.0), turn=st.floats(0.1, math.pi))
def test_a_bend_that_is_no_sharper_than_the_body_is_thick_never_touches_within_half_a_turn(radius, pitch, turn):
    """A polygon round a circle that the body's inner side does not reach; in radii of the body."""
    count = max(1, int(turn / (2 * math.atan(0.5 * pitch / radius))))
    bends = np.full(count, 2 * math.atan(0.5 * pitch / radius))
    lengths = np.full(count, pitch)
    value, _ = OwnBody.chain(lengths, np.ones(count)).closest(body_of(planar(bends), lengths)[None])
    assert value[0] >= -ROUNDING


def test_links_that_are_neighbours_all_over_make_no_pair():
    own = OwnBody.chain(np.full(4, 0.1), np.full(4, 0.07))
    assert (0, 1) not in [tuple(pair) for pair in own.pairs.tolist()]
    assert [own.names(k) for k in range(len(own.pairs))] == [(0, 2), (0, 3), (1, 3)]
    value, pair = OwnBody.chain(np.full(1, 0.1), np.full(1, 0.1)).closest(np.zeros((2, 2, 3)))
    assert np.isinf(value).all()
    assert (pair == -1).all()


@given(seed=seeds, sections=st.integers(2, 8))
def test_the_place_is_half_way_between_the_closest_points(seed, sections):
    rng = np.random.default_rng(seed)
    lengths, radii = rng.uniform(0.05, 0.15, sections), rng.uniform(0.005, 0.02, sections)
    joints = body_of(rng.normal(0.0, 1.0, (sections, 2)), lengths)
    own = OwnBody.chain(lengths, radii)
    value, pair = own.closest(joints[None])
    away, place = own.apart(joints, *own.names(int(pair[0])))
    assert away == value[0]
    for link in own.names(int(pair[0])):
        share = np.linspace(0.0, 1.0, 4001)[:, None]
        points = joints[link] + share * (joints[link + 1] - joints[link])
        half = 0.5 * (value[0] + own.thick[pair[0]])
        assert np.linalg.norm(points - place, axis=1).min() <= half + 1e-4


@given(seed=seeds)
def test_the_shortest_arc_of_a_pair_is_that_of_points_that_are_just_no_neighbours(seed):
    rng = np.random.default_rng(seed)
    lengths, radii = rng.uniform(0.02, 0.15, 5), rng.uniform(0.01, 0.04, 5)
    own, ends = OwnBody.chain(lengths, radii), np.append(0.0, np.cumsum(lengths))
    for k in range(len(own.pairs)):
        i, j = own.names(k)
        share = np.linspace(0.0, 1.0, 301)
        arcs = (ends[j] + share * lengths[j])[:, None] - (ends[i] + share * lengths[i])
        permitted = arcs[arcs >= 0.5 * math.pi * (radii[i] + radii[j])]
        assert own.arcs[k] == pytest.approx(permitted.min(initial=own.arcs[k] + 1e-3), abs=1.001e-3)
        assert own.arcs[k] <= permitted.min(initial=math.inf) + ROUNDING


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_what_both_links_go_is_taken_off_between_configurations(share):
    """The last of three links, 20 mm thick, goes down through the first one, or the first one up, or both."""
    own = OwnBody.chain(np.full(3, 0.1), np.full(3, 0.01))
    (k,) = np.flatnonzero((own.pairs == (0, 2)).all(axis=1))
    alone = {name: getattr(own, name)[k : k + 1] for name in ("pairs", "aparts", "arcs", "thick")}
    up, crossed = np.array([0.0, 0.0, 0.3]), np.array([[-0.05, 0, 0], [0.05, 0, 0], [0, -0.05, 0], [0, 0.05, 0]])
    low, high = (
        crossed + sign * np.array([-share * up, -share * up, (1 - share) * up, (1 - share) * up]) for sign in (1, -1)
    )
    travel = np.linalg.norm(high - low, axis=1)[None]
    bound, pair = dataclasses.replace(own, **alone).between(np.array([low, high]), travel)
    assert bound[0] == pytest.approx(-0.02, abs=1e-12)
    assert pair[0] == 0


@given(seed=seeds, sections=st.integers(2, 6), size=st.floats(0.0, 0.2))
def test_between_configurations_at_least_so_much_is_left(seed, sections, size):
    """Vertices that go on straight lines: as far as each goes is taken off."""
    rng = np.random.default_rng(seed)
    lengths, radii = rng.uniform(0.05, 0.15, sections), rng.uniform(0.005, 0.02, sections)
    low = rng.normal(0.0, 1.0, (sections, 2))
    ends = [body_of(low + rng.normal(0.0, size, low.shape) * k, lengths) for k in (0, 1)]
    own = OwnBody.chain(lengths, radii)
    bound, pair = own.between(np.array(ends), np.linalg.norm(ends[1] - ends[0], axis=1)[None])
    motion = np.array([ends[0] + t * (ends[1] - ends[0]) for t in np.linspace(0.0, 1.0, 33)])
    assert bound[0] <= own.closest(motion)[0].min() + ROUNDING
    assert (pair[0] == -1) == (len(own.pairs) == 0)
