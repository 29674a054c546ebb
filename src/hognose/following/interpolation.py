"""Prediction lookup with interpolation (paper section 3.3, eqs. 11–12, figure 5).

After the lookup, the joint is put on the segment between the two points whose distances bracket the link
length: G = M_In + (L - L_In) / (L_In+1 - L_In) · (M_In+1 - M_In). The paper draws the pair In, In+1 only; the right
one is the pair that brackets L, on either side of the closest point.

Cost a step: that of prediction lookup and one division a link. Known weakness: the joint lies on the chord of
two points, off the curve by up to κ sd²/8.
"""

from __future__ import annotations

from hognose.following.prediction import Prediction


class Interpolation(Prediction):
    """Prediction lookup, then eq. (12) on the bracketing pair."""

    name = "interpolation"
    _interpolates = True

    @property
    def tolerance(self) -> float:
        """Second order in the spacing: the sagitta of two neighbours, and eq. (12)'s linear distance."""
        sharpest = min(self.path.sharpest[0], 1.0 / self.spacing)
        return self.spacing**2 * (sharpest / 8 + 1 / (8 * float(self.link_lengths.min()))) + 1e-12
