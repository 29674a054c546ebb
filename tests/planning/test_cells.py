"""Numbers of columns, however they are divided into chunks, are those that pyarrow itself gives."""

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hognose.planning.cells import numbers

KINDS = {pa.float64(): st.floats(), pa.int64(): st.integers(-(2**63), 2**63 - 1)}


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_they_are_the_same_to_the_last_bit(kind, data):
    chunks = data.draw(st.lists(st.lists(KINDS[kind], max_size=5), max_size=4))
    arrays = [pa.array([*each, 7], kind)[: len(each)] for each in chunks]
    cells = pa.chunked_array(arrays, kind).slice(data.draw(st.integers(0, 3)))
    found = numbers(cells)
    assert found.dtype == kind.to_pandas_dtype()
    assert found.flags.writeable
    assert found.tobytes() == cells.to_numpy().tobytes()
    assert np.array_equal(found, np.array(cells.to_pylist(), found.dtype), equal_nan=kind == pa.float64())
