"""What the mechanics of a motion come to, for people: tensions, safety against buckling, sag, and sensitivity."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.mechanics import Held, Settled, why_unknown
from hognose.mechanics.pulls import pulls
from hognose.mechanics.sensitivity import ASSUMED_FRICTION, SHARE, ZERO, Sensitivity, sensitivity
from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.motion import Motion
from hognose.robot.tension import is_assumed
from hognose.ties import first_largest, first_smallest
from hognose.wording import span

Array = NDArray[np.float64]

#: Headings of `Loads.rows`.
HEADINGS = ("", "where the tip is on the target", "worst", "at step", "")
#: What stands for a value where no tensions hold the arm.
NOT_HELD = "not held"


@dataclass(frozen=True)
class Figure:
    """A figure that every step has.

    Attributes
    ----------
    key
        As JSON calls it; its end says the unit.
    name
        As people call it.
    values : (T,)
        NaN where there is none.
    scale, unit
        What people read: how many of which unit one is.
    lowest
        Whether the smallest is the worst.
    """

    key: str
    name: str
    values: Array
    scale: float
    unit: str
    lowest: bool = False

    @property
    def worst(self) -> int:
        """The step of the worst value; what is no number is the worst."""
        return (first_smallest if self.lowest else first_largest)(self.values)[0]

    def words(self, step: int, is_held: bool) -> str:
        """The value of a step as people read it."""
        value = self.values[step]
        return ("–" if is_held else NOT_HELD) if np.isnan(value) else f"{self.scale * value:.3g}"


@dataclass(frozen=True, eq=False)
class Loads:
    """The mechanics of a motion.

    Attributes
    ----------
    motion
    held
    uncompensated
        Where the arm comes to rest if its cables are commanded without regard to weight and bending, with pretension
        alone.
    sensitivity
    tension_by_zeros : (T,) N
        Largest standard deviation of a tension if the zeros of all cables are off, independently, by one of `ZERO`.
    """

    motion: Motion
    held: Held
    uncompensated: Settled
    sensitivity: Sensitivity
    tension_by_zeros: Array

    @property
    def sag(self) -> Array:
        """How far (T,) m the tip is off without compensation."""
        return np.linalg.norm(self.uncompensated.tip_shift, axis=1)

    def where_held(self, values: Array) -> Array:
        """Values (T,) or (T, k) with NaN where no tensions hold the arm: it is not there, and they are not its own."""
        rows = self.held.is_held.reshape(-1, *(1,) * (values.ndim - 1))
        return np.where(rows, values, np.nan)

    @property
    def figures(self) -> list[Figure]:
        """All figures, in the order in which they are shown; NaN where no tensions hold the arm."""
        held, tip = self.held, self.sensitivity
        mechanics = self.motion.task.mechanics
        given = 0.0 if mechanics is None else mechanics.friction
        mu = f"friction {given:g}" if given else f"friction {ASSUMED_FRICTION:g} (assumed)"
        off = f"{1e3 * ZERO:g} mm (1σ)"
        share = f"{100 * SHARE:g} %"
        what = "weight and bending" if mechanics is not None and mechanics.springs.any() else "the weight"
        figures = [
            Figure("largest_tension_N", "largest tension", held.tensions.max(axis=1), 1.0, "N"),
            Figure("least_tension_N", "least tension", held.tensions.min(axis=1), 1.0, "N", lowest=True),
            Figure("buckling_load_factor", "load factor of buckling", held.load_factor, 1.0, "", lowest=True),
            Figure("uncompensated_sag_m", f"tip without compensation of {what}", self.sag, 1e3, "mm"),
            Figure("tension_by_cable_zeros_N", f"a tension, cable zeros off by {off}", self.tension_by_zeros, 1.0, "N"),
            Figure("tip_by_cable_zeros_m", f"tip, cable zeros off by {off}", tip.zero, 1e3, "mm"),
            Figure("tip_by_share_m", f"tip, EA or all masses off by {share}", tip.share, 1e3, "mm"),
            Figure("tip_by_friction_m", f"tip, {mu}", tip.friction, 1e3, "mm"),
        ]
        return [dataclasses.replace(each, values=self.where_held(each.values)) for each in figures]

    @property
    def rows(self) -> list[list[str]]:
        """A table of them for people."""
        arrived, is_held = 0 if self.motion.retracts else -1, self.held.is_held
        return [
            [
                each.name,
                each.words(arrived, is_held[arrived]),
                each.words(each.worst, is_held[each.worst]),
                str(each.worst),
                each.unit,
            ]
            for each in self.figures
        ]

    @property
    def given(self) -> list[tuple[str, str, str]]:
        """What it all rests on: names, values with units, and a mark on what is assumed."""
        robot, arm = self.motion.robot, self.motion.task.mechanics
        assert arm is not None, "loads"
        cables = robot.spec.cables
        assert cables is not None, "loads"
        gravity = ", ".join(f"{x:g}" for x in self.motion.task.spec.gravity_m_s2)
        rows = [
            ("axial stiffness EA", f"{span(1e-3 * arm.axial_stiffness)} kN", "cables.axial_stiffness_N"),
            ("free length behind the base", f"{1e3 * arm.free_length:g} mm", "cables.free_length"),
            ("pretension", f"{span(arm.pretension)} N", "cables.pretension_N"),
            ("tension", f"{arm.tension_min:g} to {arm.tension_max:g} N", "cables.tension_min_N"),
            ("friction in the holes", f"{arm.friction:g}", "cables.friction"),
            ("least load factor", f"{arm.load_factor_min:g}", "cables.load_factor_min"),
            ("masses of links", f"{span(1e3 * arm.links[:, 1])} g", "section.link_mass"),
            ("mass at the tip", f"{1e3 * arm.tool_mass:g} g", "tool_mass"),
        ]
        if arm.bending.any():
            stiff = [group.bending_stiffness_N_m2 or 0.0 for group in robot.spec.section]
            rows.append(("bending stiffness EI", f"{span(stiff)} N m²", "section.bending_stiffness_N_m2"))
        said = [(name, value, "assumed" if is_assumed(key, robot.assumed) else "") for name, value, key in rows]
        return [*said, ("gravity", f"{gravity} m/s²", "")]

    @property
    def sentences(self) -> list[str]:
        """What the table does not say."""
        said = [f"{_not_held(self.held).capitalize()}."] if not self.held.is_held.all() else []
        moved = int(np.count_nonzero(~self.uncompensated.is_stable))
        if moved:
            said.append(
                f"Without compensation the arm would collapse at {moved} of {len(self.held.tensions)} steps, onto its "
                "joint limits; where it ends then depends on the way there."
            )
        assumed = [key for key in self.motion.robot.assumed if key == "cables" or key.startswith("cables.")]
        if assumed:
            said.append(f"Assumed, not known: {', '.join(assumed)}. Replace them with your machine's values.")
        return said

    def to_json(self) -> dict[str, Any]:
        """The figures in SI units: over all steps, the worst, and its step; without numbers where there are none."""
        return {
            each.key: {"worst": _number(each.values[each.worst]), "step": each.worst, "at_steps": _numbers(each.values)}
            for each in self.figures
        }


def loads(motion: Motion) -> Loads:
    """The mechanics of a motion.

    Raises
    ------
    InputError
        Those of the robot are not known; says why.
    """
    mechanics, held = motion.task.mechanics, motion.held
    if mechanics is None or held is None:
        raise InputError(f"mechanics of {motion.robot.name}: {why_unknown(motion.robot)}")
    gravity = motion.task.gravity(motion.at)
    sag = mechanics.uncompensated(motion.postures, gravity)
    lengths = motion.commanded_lengths
    ways = np.gradient(lengths, axis=0) if len(lengths) > 1 else np.zeros_like(lengths)
    arm = (mechanics, motion.postures, held, gravity)
    tensions = np.where(held.load_factor > 1.0, pulls(*arm, (ZERO, 0.0, 0.0), 0.0).zeros.max(axis=1), np.nan)
    return Loads(motion, held, sag, sensitivity(*arm, ways), tensions)


def in_a_line(motion: Motion) -> str:
    """Tensions and safety against buckling in a few words; empty if mechanics are not known."""
    held = motion.held
    if held is None:
        return ""
    if not held.is_held.all():
        return _not_held(held)
    factor = min(float(held.load_factor.min()), LARGEST_LOAD_FACTOR)
    return f"tensions {held.tensions.min():.3g} to {held.tensions.max():.3g} N, load factor of buckling {factor:.3g}"


def _not_held(held: Held) -> str:
    return f"no tensions hold the arm at {np.count_nonzero(~held.is_held)} of {len(held.is_held)} steps"


def _number(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def _numbers(values: Array) -> list[float | None]:
    return [_number(value) for value in values]
