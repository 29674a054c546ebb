"""An arm buckles on the twin where its tangent stiffness says so, and nowhere else."""

import itertools

import numpy as np

from benchmarks.mechanics_on_mujoco import buckles


def test_the_sign_of_the_smallest_eigenvalue_says_whether_an_arm_buckles():
    found = np.array(list(itertools.islice(filter(None, map(buckles, itertools.count())), 60)))
    said, does = found.T
    np.testing.assert_array_equal(said, does)
    assert 15 < does.sum() < 45
