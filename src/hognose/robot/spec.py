"""What a robot file says: the arm section by section, its slider, its cables and its limits."""

from __future__ import annotations

import difflib
import math
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, Field, model_validator

from hognose.robot.body_shape import BodyShape
from hognose.robot.cable_circle import azimuths_of_all, fault_between_disks, fault_of_cables, fault_of_passing
from hognose.robot.extension import fault_of_extension
from hognose.robot.sections import KINDS, Geometry, Piece, SectionKind
from hognose.robot.tension import CablesSpec
from hognose.robot.tolerance import RobotTolerance
from hognose.robot.transmission import COUNT_LIMIT, PositiveNumber, Transmission
from hognose.units import Angle, FileModel, Length, NonNegativeLength, PositiveLength, names_a_field

#: Arms outside this range (m) are almost always a wrong unit.
PLAUSIBLE_ARM_LENGTH = (0.02, 30.0)

MOST_SECTIONS = 10_000

#: A section of more joints or disks is described as an arc without them.
MOST_JOINTS = 100

#: Smallest distance (m) of the hole planes before and after a joint: across none, a straight cable has no length.
SMALLEST_GAP = 1e-4

#: Keys of a section that only some kinds have.
_OF_SOME_KINDS = ("joints", "axis_offset", "disks", "bending_stiffness_N_m2", "length_range")

#: Tables and their keys that may hold one value for each section.
_FOR_EACH_SECTION = (
    ("tolerance", "calibration_deg"),
    ("tolerance", "sag"),
    ("cables", "axial_stiffness_N"),
    ("cables", "pretension_N"),
)

#: What a base is assumed to accelerate the first joint at (m/s²) where neither robot file nor task says it.
ASSUMED_ACCELERATION = 0.1

#: No link of a snake arm, and nothing that it carries, is heavier (kg).
HEAVIEST = 1000.0


def _is_bearable(mass: float) -> float:
    if mass > HEAVIEST:
        raise ValueError(f"{mass:g} kg is heavier than any part of a snake arm, {HEAVIEST:g} kg at most: is it in kg?")
    return mass


#: A mass (kg) of none or more.
Mass = Annotated[float, Field(ge=0, allow_inf_nan=False), AfterValidator(_is_bearable), Field(le=HEAVIEST)]
#: That of a link (kg), which has one.
LinkMass = Annotated[float, Field(ge=1e-9, allow_inf_nan=False), AfterValidator(_is_bearable), Field(le=HEAVIEST)]
Counts = Annotated[int, Field(ge=-COUNT_LIMIT, lt=COUNT_LIMIT)]
BendLimit = Annotated[float, Field(gt=0, le=180, allow_inf_nan=False)]
#: How far (deg) a bend may go to both sides of straight.
BendRange = tuple[
    Annotated[float, Field(le=0, ge=-180, allow_inf_nan=False)],
    Annotated[float, Field(ge=0, le=180, allow_inf_nan=False)],
]
#: A joint bends by less than this (deg); a section that bends at many places may bend by more in all.
SHARPEST_JOINT_DEG = 90.0


class SectionSpec(FileModel):
    """One section, or `count` equal ones in a row: a universal joint and the link behind it, or another `kind`.

    `half_lengths` are h₁ (hole plane to joint centre, before the joint) and h₂ (joint centre to hole plane,
    after it); `pitch` is the distance to the next joint centre, 2h + L in the paper. The azimuths of the
    cables of each further section of a group are shifted by `cable_azimuth_step_deg`.

    `kind` is `link`, `hinges` (two of them, `axis_offset` apart), `joints` (a stack of so many equal ones, all of it
    one pitch long) or `arc` (bends along its whole length, its cables straight between `disks` if they are given). Of
    all kinds `bend_limit_deg` is that of the whole section, and `half_lengths` those of each joint.

    `bending_stiffness_N_m2` is EI of what bends back by itself, a backbone or flexures: of all kinds that have it, a
    section bent by α and β holds the energy EI (α² + β²) / (2 pitch), whether it bends at joints or along its length.
    `length_range` is [shortest, longest] of an arc that can change its length, which is the pitch at rest.

    `body` is `round`, of `body_diameter`, or `flat`: `body_width` along x and `body_height` along y of the section.

    Cables that end in the section run in it on the circle of `cable_radius`; those of later sections, which pass it, on
    that of `passing_cable_radius`, or else on the circle of their own section.

    `alpha_range_deg` and `beta_range_deg` are [low, high] where an axis bends less far to one side than to the other.
    """

    kind: str = "link"
    joints: Annotated[int, Field(ge=1, le=MOST_JOINTS)] | None = None
    axis_offset: PositiveLength | None = None
    disks: Annotated[int, Field(ge=1, le=MOST_JOINTS)] | None = None
    bending_stiffness_N_m2: PositiveNumber | None = None
    length_range: tuple[PositiveLength, PositiveLength] | None = None
    count: Annotated[int, Field(ge=1, le=MOST_SECTIONS)] = 1
    pitch: PositiveLength
    half_lengths: tuple[NonNegativeLength, NonNegativeLength] | None = None
    body_diameter: PositiveLength | None = None
    bend_limit_deg: BendLimit | tuple[BendLimit, BendLimit]
    alpha_range_deg: BendRange | None = None
    beta_range_deg: BendRange | None = None
    link_mass: LinkMass
    centre_of_mass: NonNegativeLength | None = None
    cable_radius: PositiveLength
    passing_cable_radius: PositiveLength | None = None
    cable_azimuths_deg: Annotated[tuple[Angle, ...], Field(min_length=3)]
    cable_azimuth_step_deg: Angle = 0.0
    transmission: Transmission
    body: str = "round"
    body_width: PositiveLength | None = None
    body_height: PositiveLength | None = None

    @model_validator(mode="after")
    def _ranges_fit(self) -> SectionSpec:
        for key, limit in zip(("alpha_range_deg", "beta_range_deg"), self._given_limits, strict=True):
            given = getattr(self, key)
            if given is not None and given[0] == given[1]:
                raise ValueError(f"{key} [0, 0] does not let the section bend; one of both sides must be open")
            if given is not None and max(-given[0], given[1]) > limit:
                raise ValueError(
                    f"{key} [{given[0]:g}, {given[1]:g}] goes beyond bend_limit_deg {limit:g}; it says what of that is "
                    "left on each side"
                )
        return self

    @model_validator(mode="after")
    def _kind_fits(self) -> SectionSpec:
        if self.kind not in KINDS:
            near = difflib.get_close_matches(self.kind, KINDS, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ";"
            raise ValueError(f"kind {self.kind!r} is unknown{hint} there are {', '.join(KINDS)}")
        for key in _OF_SOME_KINDS:
            if getattr(self, key) is not None and key not in self.model.takes:
                takers = " or ".join(repr(name) for name, kind in KINDS.items() if key in kind.takes)
                raise ValueError(f"{key} is for sections of kind {takers}, and this one is of kind {self.kind!r}")
        return self

    @model_validator(mode="after")
    def _parts_fit(self) -> SectionSpec:
        fault = self.model.fault(self.geometry) or self._fault_of_flat_arc
        if fault:
            raise ValueError(fault)
        if not self.pieces[0].curved:
            if self.half_lengths is None:
                raise ValueError(
                    "half_lengths is missing: [h1, h2], how far the hole planes before and after a joint are from it"
                )
            if sum(self.half_lengths) + (self.axis_offset or 0.0) < SMALLEST_GAP:
                raise ValueError(
                    f"half_lengths add up to {1e3 * sum(self.half_lengths):g} mm; the hole planes before and after a "
                    f"joint must be {1e3 * SMALLEST_GAP:g} mm apart at least"
                )
            if max(self.limits) * (share := max(self.pieces[0][:2])) >= SHARPEST_JOINT_DEG:
                raise ValueError(
                    f"bend_limit_deg {max(self.limits):g} deg bends a joint by {max(self.limits) * share:g} deg, which "
                    f"must be less than {SHARPEST_JOINT_DEG:g}"
                )
        if self.centre_of_mass is not None and self.centre_of_mass > self.pitch:
            raise ValueError(
                f"centre_of_mass {1e3 * self.centre_of_mass:g} mm lies beyond the link, whose pitch is "
                f"{1e3 * self.pitch:g} mm; it is measured from the link's joint"
            )
        fault = fault_of_cables(self.shape, self.cable_radius, self.passing_cable_radius, *self.cables)
        if fault:
            raise ValueError(fault)
        return self

    @property
    def model(self) -> SectionKind:
        """The model of its kind."""
        return KINDS[self.kind]

    @property
    def cables(self) -> tuple[tuple[float, ...], float, int]:
        """Azimuths (deg) of the cables of its first section, their change from section to section, and sections."""
        return self.cable_azimuths_deg, self.cable_azimuth_step_deg, self.count

    @property
    def shape(self) -> BodyShape:
        """The shape of its body."""
        return BodyShape.of(self.body, self.body_diameter, self.body_width, self.body_height)

    @property
    def _fault_of_flat_arc(self) -> str:
        if self.shape.sides is None or not any(piece.curved for piece in self.pieces):
            return ""
        return (
            f"a flat body is known of straight pieces, and a section of kind {self.kind!r} bends and turns its sides "
            'along its length: describe it as kind "joints", a stack of so many straight ones, or make the body round'
        )

    @property
    def centre(self) -> float:
        """How far (m) its centre of mass is from its joint; in the middle unless given."""
        return self.pitch / 2 if self.centre_of_mass is None else self.centre_of_mass

    @property
    def hole_planes(self) -> tuple[float, float]:
        """h₁ and h₂ (m); both 0 of sections without joints."""
        return self.half_lengths or (0.0, 0.0)

    @property
    def _given_limits(self) -> tuple[float, float]:
        given = self.bend_limit_deg
        return given if isinstance(given, tuple) else (given, given)

    @property
    def bend_ranges(self) -> tuple[BendRange, BendRange]:
        """Lowest and highest α, and β (deg)."""
        alpha, beta = self._given_limits
        return self.alpha_range_deg or (-alpha, alpha), self.beta_range_deg or (-beta, beta)

    @property
    def limits(self) -> tuple[float, float]:
        """Largest |α| and |β| (deg)."""
        (low_alpha, high_alpha), (low_beta, high_beta) = self.bend_ranges
        return max(-low_alpha, high_alpha), max(-low_beta, high_beta)

    @property
    def geometry(self) -> Geometry:
        """What its model is told of each of its sections."""
        alpha, beta = self.limits
        return Geometry(
            self.pitch,
            *self.hole_planes,
            *(self.shape.radius, (math.radians(alpha), math.radians(beta))),
            *(self.joints, self.axis_offset, self.disks, self.length_range),
        )

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The pieces of each of its sections."""
        return self.model.pieces(self.geometry)


class FeedAxis(FileModel):
    """The slider: how far the base joint travels along +z, and how fast."""

    min: Length
    max: Length
    speed: PositiveLength
    acceleration: PositiveLength | None = None

    @property
    def acceleration_limit(self) -> float:
        """Largest acceleration, m/s²; an assumed one unless it is given."""
        return ASSUMED_ACCELERATION if self.acceleration is None else self.acceleration

    @model_validator(mode="after")
    def _has_travel(self) -> FeedAxis:
        if self.min > 0 or self.max <= 0:
            raise ValueError("the travel from min to max must start at or below 0 and reach beyond it")
        return self


class Limits(FileModel):
    """What joints and cables may do in motion."""

    joint_speed_deg_s: PositiveNumber
    joint_acceleration_deg_s2: PositiveNumber
    cable_speed: PositiveLength
    cable_acceleration: PositiveLength | None = None
    cable_travel: tuple[Length, Length]
    motor_counts: tuple[Counts, Counts] = (-(2**31), 2**31 - 1)

    @model_validator(mode="after")
    def _ranges_hold_zero(self) -> Limits:
        for name in ("cable_travel", "motor_counts"):
            low, high = getattr(self, name)
            if not low < 0 < high:
                raise ValueError(f"{name} must be [below 0, above 0]: the straight arm is at 0")
        return self


class RobotSpec(FileModel):
    """A whole robot file."""

    schema_version: Annotated[int, Field(alias="schema", ge=1, le=1)] = 1
    name: Annotated[str, Field(min_length=1, max_length=80)]
    description: str = ""
    source: str = ""
    assumed: tuple[str, ...] = ()
    base_length: NonNegativeLength = 0.0
    tool_length: NonNegativeLength = 0.0
    tool_mass: Mass = 0.0
    feed: FeedAxis
    limits: Limits
    cables: CablesSpec | None = None
    tolerance: RobotTolerance = RobotTolerance()
    section: Annotated[tuple[SectionSpec, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _cables_stay_within(self) -> RobotSpec:
        circles = [(group.passing_cable_radius, group.cable_radius) for group in self.section]
        shapes, azimuths = [group.shape for group in self.section], [azimuths_of_all(*g.cables) for g in self.section]
        geometries = [group.geometry for group in self.section]
        fault = fault_of_passing(shapes, circles, azimuths) or fault_between_disks(geometries, circles)
        counts = [group.count for group in self.section]
        if fault := fault or fault_of_extension(geometries, counts, circles, self.tool_length):
            raise ValueError(fault)
        return self

    @model_validator(mode="after")
    def _is_plausible(self) -> RobotSpec:
        count = sum(group.count for group in self.section)
        if count > MOST_SECTIONS:
            raise ValueError(f"section: {count:,} sections are too many; at most {MOST_SECTIONS:,}")
        low, high = PLAUSIBLE_ARM_LENGTH
        if not low <= self.arm_length <= high:
            raise ValueError(
                f"the arm is {self.arm_length:,.4g} m long, expected {low:g} to {high:g} m: "
                'is `units` right? (units = "mm" for lengths in millimetres)'
            )
        for number, (group, following) in enumerate(pairwise(self.section), 1):
            end, before = group.pieces[-1], following.hole_planes[0]
            if end.curved and before > 0:
                raise ValueError(
                    f"section: the joint of group {number + 1} stands at the end of a section that bends along its "
                    f"length, so there is no straight body for a hole plane {1e3 * before:g} mm before it: make its "
                    "half_lengths [0, h2]"
                )
            if not end.curved and group.hole_planes[1] + before >= end.length:
                raise ValueError(
                    f"section: the joint parts of groups {number} and {number + 1} leave nothing of the pitch of "
                    f"{1e3 * end.length:g} mm for the link between them"
                )
        for table, key in _FOR_EACH_SECTION:
            given = getattr(getattr(self, table), key, None)
            if isinstance(given, tuple) and len(given) != count:
                raise ValueError(f"{table}.{key}: {len(given)} values, but the arm has {count} sections")
        for key in self.assumed:
            if not names_a_field(RobotSpec, key.split(".")):
                raise ValueError(f"assumed: {key!r} is not a key of a robot file")
        return self

    @property
    def arm_length(self) -> float:
        """Length (m) from the first joint to the tip, the tool included."""
        return sum(group.count * group.pitch for group in self.section) + self.tool_length
