"""Cables that go linearly, of arms of any kinds of sections: how far angles leave linear ones, and what is proven."""

import numpy as np
import pytest

from benchmarks.cables_of_sections import dense, optimistic, random_arm, random_case
from hognose.planning.certificate.cable_motion import deviations
from hognose.robot import Robot
from hognose.robot.sections import MixedSections

#: Arms of the benchmark that are clear of what they pass, and close to it.
CLEAR = (0, 3, 5, 9)


def pulled(robot: Robot, rng: np.random.Generator, swing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles (2, n, 2) at both ends of a step, those of cables between (61, n, 2), and cable lengths (2, c)."""
    start = rng.uniform(-0.4, 0.4, (1, robot.sections, 2))
    planned = np.concatenate([start, start + rng.uniform(-swing, swing, start.shape)])
    lengths = robot.lengths_of_counts(robot.motor_counts(robot.cable_lengths(planned)))
    ends = robot.angles_from_cables(lengths, planned)
    return ends, robot.angles_from_cables(dense(lengths), dense(ends)), lengths


@pytest.mark.parametrize("swing", [0.004, 0.02])
def test_angles_leave_linear_ones_by_no_more_than_the_bound(swing):
    shares = []
    for seed in range(25):
        rng, robot = np.random.default_rng([seed, 7]), random_arm(np.random.default_rng(seed))
        ends, between, lengths = pulled(robot, rng, swing)
        found = deviations(robot, ends[:1], ends[1:], lengths[:1], lengths[1:])[0]
        off = np.linalg.norm(between - dense(ends), axis=2).max(axis=0)
        assert (off <= found + 1e-10).all()
        lines = [robot.model.vertices(robot.joint_positions(each)) for each in (between, dense(ends))]
        moved = np.linalg.norm(lines[0] - lines[1], axis=2).max(axis=0)
        if isinstance(robot.model, MixedSections):
            assert (moved <= robot.model.levers @ np.minimum(found, 1e6) + 1e-9).all()
        assert swing > 0.01 or np.isfinite(found).all()
        shares.append(float(found.max() / max(off.max(), 1e-9)))
    assert np.median(shares) < 2.0  # a bound, and not a far one


def test_certificates_of_mixed_sections_are_no_better_than_dense_simulations():
    cases = [random_case(seed) for seed in CLEAR]
    cables = [(each.cables, each.cables_seen) for each in cases if each.cables is not None]
    assert len(cables) == len(CLEAR)
    pairs = [*cables, *((each.joints, each.joints_seen) for each in cases)]
    assert optimistic(pairs) == 0
    assert all(0 < seen < 0.08 for _, seen in pairs)
    assert max(seen - proof for proof, seen in pairs) < 0.4e-3
