"""Gauss-Legendre quadrature against what it is made to do, and against numpy's."""

import numpy as np
import pytest

from hognose.path.quadrature import gauss_legendre


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 10, 17, 32])
def test_nodes_and_weights(count):
    nodes, weights = gauss_legendre(count)
    by_numpy = np.polynomial.legendre.leggauss(count)
    np.testing.assert_allclose(nodes, by_numpy[0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(weights, by_numpy[1], rtol=1e-13)
    np.testing.assert_array_equal(nodes, -nodes[::-1])
    # Exact for polynomials up to degree 2 n - 1: the integral of x^k over -1 … 1.
    for k in range(2 * count):
        assert weights @ nodes**k == pytest.approx(0.0 if k % 2 else 2 / (k + 1), abs=1e-14)
