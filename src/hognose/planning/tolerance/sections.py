"""What sections of other kinds than links mean for tolerances: how their joints count, and what is not known of them.

If the angles of a section are off by δα and δβ, each of its joints at c turns what is behind it by its shares of these,
about axes at right angles. With equal shares s, whose sum is 1, a place p moves by Σ s ψ × (p - c), which no error of
unit size makes more than Σ s |p - c|, and the square of that is at most Σ s |p - c|². Where one joint takes α and
another takes β, as hinges do, each counts in full.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.mechanics import why_unknown
from hognose.robot import Robot
from hognose.robot.backbone import bending_springs
from hognose.robot.sections import RIGID_LINK, MixedSections

Array = NDArray[np.float64]


def weights_of(robot: Robot, joints: Array) -> Array:
    """What the joint at the beginning of each chord (p,) rad² counts for, where sections are off by σ (n,) rad."""
    sections, model = robot.chord_sections, robot.model
    if not isinstance(model, MixedSections):
        begins = np.append(True, np.diff(sections) > 0)
        return np.where(begins, joints[sections] ** 2, 0.0)
    alpha, beta = model.table[:, :2].T  # each piece has one chord, as curved ones are refused
    alike = np.abs(alpha - beta) < 1e-12
    of_section = np.add.reduceat(np.stack([alpha, beta]), model.first[:-1], axis=1)[:, sections]
    either = np.where(alike, alpha * of_section[0], alpha * of_section[0] + beta * of_section[1])
    return joints[sections] ** 2 * either


def refuse_unknown_sections(robot: Robot, zeros: bool) -> None:
    """What is taken of what bends along its length is not known, nor what `zeros` of cables take of other sections."""
    pieces = isinstance(robot.model, MixedSections) and not robot.model.table[:, 3].any()
    if not (robot.straight_links or pieces):
        raise InputError(
            f"tolerance: what tolerances take is known for straight links; the sections of {robot.name} have "
            f"{int(np.max(robot.model.chords))} chords each at most. Leave the tolerances out of the task and "
            "the robot, and make the `margin` as large as what they take"
        )
    if zeros and robot.model is not RIGID_LINK:
        raise InputError(
            "tolerance.cable_zero: what lengths that are off do to angles is worked out for links of one "
            f"universal joint, not for the sections of {robot.name}; expected 0. `calibration_deg` bounds the angles"
        )


def refuse_flat(robot: Robot, zeros: bool, mechanics: bool) -> None:
    """How cables that are off roll links is not worked out, and on a flat body that counts."""
    if robot.outline.flat and (zeros or mechanics):
        key = "cable_zero" if zeros else "axial_stiffness_percent, mass_percent and friction of cables"
        raise InputError(
            f"tolerance: {key}: what errors of cables take of the flat body of {robot.name} is not known; leave them "
            "out, and give bounds of the angles instead, `calibration_deg`, or of the sag, `sag`"
        )


def refuse_unknown_mechanics(robot: Robot, key: str) -> None:
    """What errors of EA and masses do is not known of an arm without mechanics, or one that bends back by itself."""
    stiff = "it is not known of sections with `bending_stiffness_N_m2`" if bending_springs(robot).any() else ""
    if why := why_unknown(robot) or stiff:
        raise InputError(
            f"tolerance.{key}: what is left of the sag of {robot.name} cannot be worked out without its mechanics: "
            f"{why}. Or give a bound of it, `sag`"
        )
