"""What one way of a run on emulated drives and a twin came to, and what it must come to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hognose.studies.there_and_back import ThereAndBack, Way, planned_at

#: How far (m) the tip may be off its plan in root mean square.
TIP_RMS = 1e-4


class Figure(NamedTuple):
    """A figure of one way of a case.

    Attributes
    ----------
    key
        With its unit.
    words
    value
    shown
        The value in words.
    bound
        What it must be, in words; empty if it may be anything.
    is_met
    """

    key: str
    words: str
    value: float
    shown: str
    bound: str = ""
    is_met: bool = True


def figures(ran: ThereAndBack, way: Way) -> list[Figure]:
    """What one way came to, and what it must come to."""
    plan, cycles, compared = ran.plan, way.cycles, way.compared
    arm, held, margin = plan.task.mechanics, plan.held, plan.task.margin
    assert arm is not None, "it moved a twin"
    assert held is not None, "it has mechanics"
    least, largest = float(cycles.tensions.min()), float(cycles.tensions.max())
    apart = float(np.abs(cycles.tensions - planned_at(held.tensions, way.place)).max())
    band, clear = ran.network.spec.watch.tension_band_N, float(way.clearance.min())
    behind = float(np.abs(cycles.following).max())
    window = ran.network.spec.drives.following_error_counts
    exact = f"{compared.exact} of {compared.reached}"
    return [
        Figure("tip_rms_m", "tip off its plan, RMS", way.tip_rms, f"{1e3 * way.tip_rms:.3f} mm",
               f"≤ {1e3 * TIP_RMS:g} mm", way.tip_rms <= TIP_RMS),
        Figure("tip_max_m", "tip off its plan, largest", float(way.tip_errors.max()),
               f"{1e3 * way.tip_errors.max():.3f} mm"),
        Figure("tip_end_m", "tip off its plan, last cycle", float(way.tip_errors[-1]),
               f"{1e3 * way.tip_errors[-1]:.3f} mm"),
        Figure("steps_exact", "steps commanded exactly as planned", compared.exact, exact, "all", compared.follows),
        Figure("following_counts", "following error, largest", behind, f"{behind:.0f} counts",
               f"≤ {window} counts", behind <= window),
        Figure("tension_least_N", "tension, least", least, f"{least:.1f} N", "> 0 N", least > 0.0),
        Figure("tension_largest_N", "tension, largest", largest, f"{largest:.1f} N", f"≤ {arm.tension_max:g} N",
               largest <= arm.tension_max),
        Figure("tension_off_N", "tension off its plan, largest", apart, f"{apart:.1f} N", f"≤ {band:g} N",
               apart <= band),
        Figure("clearance_m", "clearance of the twin, least", clear, f"{1e3 * clear:.2f} mm",
               f"≥ {1e3 * margin:g} mm", clear >= margin),
        Figure("contact_N", "contact", way.contact, f"{way.contact:.1f} N", "0 N", way.contact == 0.0),
        Figure("pictures", "pictures of the tip camera", len(way.images), str(len(way.images)), "≥ 1",
               len(way.images) > 0),
    ]  # fmt: skip
