"""An arc of constant curvature, in the axes of its beginning: its first moment and its turn, with their derivatives.

Bent by a and b it ends at L (a c₂, -b c₂, c₁), turned by exp(a e_y + b e_x), with c_k of t = a² + b² from
`hognose.robot.stumpff`. A mass spread evenly along it has its centre at L (a c₃, -b c₃, c₂), the integral of that over
the arc. Whatever hangs on it, its moment is a vector (a F, -b F, G) with functions F and G of t.
"""

from __future__ import annotations

from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.stumpff import of_bend


@kernel()
def bow(a: float, b: float, length: float, behind: float, mass: float, centre: float, out: NDArray) -> None:
    """Fill `out` (6, 3): the first moment of an arc about its beginning, by a, by b, by a twice, by both, by b twice.

    A mass `behind` is at its end, its own is `centre` along it, or spread evenly if that is below 0.
    """
    c1, d1, dd1, c2, d2, dd2, c3, d3, dd3 = of_bend(a * a + b * b)
    m = length * behind
    F, dF, ddF, G, dG, ddG = m * c2, m * d2, m * dd2, m * c1, m * d1, m * dd1
    m = length * mass
    if centre < 0.0:
        F, dF, ddF, G, dG, ddG = F + m * c3, dF + m * d3, ddF + m * dd3, G + m * c2, dG + m * d2, ddG + m * dd2
    else:
        part = centre / length
        square = part * part
        c1, d1, dd1, c2, d2, dd2, _, _, _ = of_bend(square * (a * a + b * b))
        F, dF, ddF = F + m * square * c2, dF + m * square**2 * d2, ddF + m * square**3 * dd2
        m *= part
        G, dG, ddG = G + m * c1, dG + m * square * d1, ddG + m * square**2 * dd1
    aa, ab, bb = a * a, a * b, b * b
    out[0, 0], out[0, 1], out[0, 2] = a * F, -b * F, G
    out[1, 0], out[1, 1], out[1, 2] = F + 2.0 * aa * dF, -2.0 * ab * dF, 2.0 * a * dG
    out[2, 0], out[2, 1], out[2, 2] = 2.0 * ab * dF, -F - 2.0 * bb * dF, 2.0 * b * dG
    out[3, 0] = a * (6.0 * dF + 4.0 * aa * ddF)
    out[3, 1] = -b * (2.0 * dF + 4.0 * aa * ddF)
    out[3, 2] = 2.0 * dG + 4.0 * aa * ddG
    out[4, 0] = b * (2.0 * dF + 4.0 * aa * ddF)
    out[4, 1] = -a * (2.0 * dF + 4.0 * bb * ddF)
    out[4, 2] = 4.0 * ab * ddG
    out[5, 0] = a * (2.0 * dF + 4.0 * bb * ddF)
    out[5, 1] = -b * (6.0 * dF + 4.0 * bb * ddF)
    out[5, 2] = 2.0 * dG + 4.0 * bb * ddG


@kernel()
def turns_of_bow(a: float, b: float, out: NDArray) -> None:
    """Fill `out` (8, 3): the turns W_a and W_b of its end, W_a by a, W_b by a, W_b by b, and the end's three axes.

    W_x = e_x + c₂ w × e_x + c₃ w × (w × e_x) with w = (b, a, 0), the left Jacobian of rotations.
    """
    c1, _, _, c2, d2, _, c3, d3, _ = of_bend(a * a + b * b)
    aa, ab, bb = a * a, a * b, b * b
    out[0, 0], out[0, 1], out[0, 2] = c3 * ab, 1.0 - c3 * bb, c2 * b
    out[1, 0], out[1, 1], out[1, 2] = 1.0 - c3 * aa, c3 * ab, -c2 * a
    out[2, 0], out[2, 1], out[2, 2] = b * (c3 + 2.0 * aa * d3), -2.0 * ab * b * d3, 2.0 * ab * d2
    out[3, 0], out[3, 1], out[3, 2] = -2.0 * a * (c3 + aa * d3), b * (c3 + 2.0 * aa * d3), -c2 - 2.0 * aa * d2
    out[4, 0], out[4, 1], out[4, 2] = -2.0 * ab * a * d3, a * (c3 + 2.0 * bb * d3), -2.0 * ab * d2
    out[5, 0], out[5, 1], out[5, 2] = 1.0 - c2 * aa, c2 * ab, -c1 * a
    out[6, 0], out[6, 1], out[6, 2] = c2 * ab, 1.0 - c2 * bb, c1 * b
    out[7, 0], out[7, 1], out[7, 2] = c1 * a, -c1 * b, 1.0 - c2 * (aa + bb)
