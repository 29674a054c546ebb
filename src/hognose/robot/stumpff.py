"""Stumpff's functions, of which place and turn of an arc of constant curvature are made, without a division by zero.

c_k(t) = Σ (-t)^j / (2j + k)!, so that with t = θ² c₁ = sin θ / θ, c₂ = (1 - cos θ)/θ², c₃ = (θ - sin θ)/θ³, and so on.
From the series follows c_k = 1/k! - t c_{k+2}, and for the derivative by t c_k' = (k c_{k+2} - c_{k+1}) / 2.
"""

from __future__ import annotations

from typing import Any

from hognose.kernels import kernel

#: Terms of the series: exact to rounding up to θ = 10.
_TERMS = 24


@kernel()
def stumpff(t: float) -> Any:
    """c₁ to c₇ of t = θ²."""
    c6, c7 = 1.0, 1.0
    for j in range(_TERMS, 0, -1):
        c6 = 1.0 - t * c6 / ((2 * j + 5) * (2 * j + 6))
        c7 = 1.0 - t * c7 / ((2 * j + 6) * (2 * j + 7))
    c6, c7 = c6 / 720.0, c7 / 5040.0
    c5, c4 = 1.0 / 120.0 - t * c7, 1.0 / 24.0 - t * c6
    c3, c2 = 1.0 / 6.0 - t * c5, 0.5 - t * c4
    return 1.0 - t * c3, c2, c3, c4, c5, c6, c7


@kernel()
def of_sine(t: float) -> Any:
    """c₁ and its first two derivatives by t."""
    c1, c2, c3, c4, c5, _, _ = stumpff(t)
    return c1, 0.5 * (c3 - c2), 0.25 * (3.0 * c5 - 3.0 * c4 + c3)


@kernel()
def of_bend(t: float) -> Any:
    """c₁, c₂ and c₃, each with its first two derivatives by t."""
    c1, c2, c3, c4, c5, c6, c7 = stumpff(t)
    d1, d2, d3 = 0.5 * (c3 - c2), c4 - 0.5 * c3, 0.5 * (3.0 * c5 - c4)
    dd1 = 0.25 * (3.0 * c5 - 3.0 * c4 + c3)
    dd2 = 0.25 * (8.0 * c6 - 5.0 * c5 + c4)
    dd3 = 0.25 * (15.0 * c7 - 7.0 * c6 + c5)
    return c1, d1, dd1, c2, d2, dd2, c3, d3, dd3
