"""What errors of cables and masses do to tensions and load factors: against arms that have them, brought to rest."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_makers import DOWN, paper_arm, poses, random_arm

from hognose.mechanics.pulls import pulls
from hognose.mechanics.stiffness import load_factors

#: An arm that is not far from buckling, and one whose sections and cables are all different.
ARMS = (lambda: paper_arm(8, axial_stiffness_N=50e3, pretension_N=60.0), lambda: random_arm(4, 4))


@pytest.fixture(params=ARMS, ids=["alike", "different"])
def arm(request):
    return request.param()


def of(arm, deviations, count=3, seed=2, coverage=2.0):
    angles = poses(arm, np.random.default_rng(seed), count, 0.3)
    held, gravity = arm.hold(angles, DOWN), np.broadcast_to(DOWN, (count, 3))
    assert held.is_held.all()
    assert (held.load_factor > 1).all()
    return angles, held, gravity, pulls(arm, angles, held, gravity, deviations, coverage)


def test_zeros_change_tensions_by_what_is_said(arm):
    """The mean square over independent errors is the sum over the cables one by one."""
    error = 1e-7
    angles, held, _, found = of(arm, (error, 0.0, 0.0))
    squares = np.zeros_like(held.tensions)
    for k in range(arm.robot.cables):
        commanded = held.commanded_lengths.copy()
        commanded[:, k] += error
        squares += (arm.settle(angles, commanded, DOWN).tensions - held.tensions) ** 2
    np.testing.assert_allclose(found.zeros, np.sqrt(squares), rtol=1e-3)
    assert not found.masses.any()
    assert not found.stiffness.any()


def test_masses_and_stiffness_change_tensions_by_what_is_said(arm):
    share = 1e-4
    angles, held, _, found = of(arm, (0.0, share, share))
    heavier = replace(arm, links=arm.links * [1.0, 1.0 + share, 1.0], tool_mass=arm.tool_mass * (1 + share))
    stiffer = replace(arm, axial_stiffness=arm.axial_stiffness * (1 + share))
    for other, said in ((heavier, found.masses), (stiffer, found.stiffness)):
        changed = other.settle(angles, held.commanded_lengths, DOWN).tensions - held.tensions
        np.testing.assert_allclose(np.abs(changed), said, rtol=0.01, atol=1e-3 * said.max())


def test_zeros_shake_the_stiffness_as_much_as_is_said(arm):
    """The Frobenius norm, cable by cable, with the matrices written out."""
    error = 1e-6
    angles, held, gravity, found = of(arm, (error, 0.0, 0.0), 1)
    elastic, geometric = arm.stiffness(angles, held.tensions, gravity)
    inverse, squares = np.linalg.inv(np.linalg.cholesky(elastic[0])), 0.0
    for k in range(arm.robot.cables):
        commanded = held.commanded_lengths.copy()
        commanded[:, k] += error
        tensions = arm.settle(angles, commanded, DOWN).tensions
        changed = arm.stiffness(angles, tensions, gravity)[1][0] - geometric[0]
        squares += np.linalg.norm(inverse @ changed @ inverse.T) ** 2
    assert found.buckling_zeros[0] == pytest.approx(2.0 * np.sqrt(squares), rel=1e-3)


def test_drawn_arms_are_seldom_closer_to_buckling(arm):
    error, share, count = 2e-5, 0.02, 300
    angles, held, gravity, found = of(arm, (error, share, share), 1)
    rng = np.random.default_rng(5)
    many = np.repeat(angles, count, axis=0)
    said = {"zeros": found.buckling_zeros, "masses": found.buckling_masses, "stiffness": found.buckling_stiffness}
    for which, bound in said.items():
        commanded, weight, other = (
            np.repeat(held.commanded_lengths, count, axis=0),
            np.repeat(gravity, count, axis=0),
            arm,
        )
        if which == "zeros":
            commanded = commanded + error * rng.standard_normal(commanded.shape)
        elif which == "masses":
            weight = (1.0 + share * rng.standard_normal((count, 1))) * weight
        else:
            other = replace(arm, axial_stiffness=(1.0 - 2.0 * share) * arm.axial_stiffness)
            commanded, weight, many = commanded[:1], weight[:1], angles
        rest = other.settle(many, commanded, weight)
        factors = load_factors(*other.stiffness(rest.angles, rest.tensions, weight))
        grown = 1.0 / factors - 1.0 / held.load_factor
        assert np.mean(grown > bound + 2e-4) <= 0.03, which  # the pose changes, too, by a little


def test_where_it_buckles_nothing_is_said():
    arm = paper_arm(8, axial_stiffness_N=20e3, pretension_N=120.0)
    angles, gravity = np.zeros((1, 8, 2)), DOWN[None]
    held = arm.hold(angles, gravity)
    assert held.load_factor[0] < 1
    found = pulls(arm, angles, held, gravity, (1e-4, 0.1, 0.1), 2.0)
    assert not found.zeros.any()
    assert not found.buckling_zeros.any()


def test_a_long_motion_is_judged_in_parts(monkeypatch):
    arm = ARMS[1]()
    *_, whole = of(arm, (1e-4, 0.05, 0.1), 7)
    monkeypatch.setattr("hognose.mechanics.pulls._LARGEST_PART", 3 * 16**2)
    *_, parts = of(arm, (1e-4, 0.05, 0.1), 7)
    for name in ("zeros", "masses", "stiffness", "buckling_zeros", "buckling_masses", "buckling_stiffness"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-9, atol=1e-12)
