"""Where values are equal but for rounding, the first is taken."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hognose.ties import first_largest, first_smallest

SIZES = st.floats(-1e3, 1e3, allow_nan=False)


@given(arrays(float, st.tuples(st.integers(1, 5), st.integers(1, 6)), elements=SIZES), st.integers(0, 2**32 - 1))
def test_rounding_does_not_change_which_one_is_taken(values, seed):
    values = np.round(values, 3)
    noise = np.random.default_rng(seed).uniform(-1, 1, values.shape) * 1e-13 * np.abs(values).max()
    for found, largest in ((first_largest, True), (first_smallest, False)):
        place = found(values)
        assert found(values + noise) == place
        assert values[place] == (values.max() if largest else values.min())
        before = values.reshape(-1)[: np.ravel_multi_index(place, values.shape)]
        assert not (before == values[place]).any()


@pytest.mark.parametrize("values", [[1.0, np.nan, 3.0], [1.0, np.inf, np.inf], [2.0, 3.0, -np.inf]])
def test_values_that_are_not_finite(values):
    array = np.array(values)
    assert first_largest(array) == (1,)
    assert first_smallest(np.full(3, np.inf)) == (0,)
