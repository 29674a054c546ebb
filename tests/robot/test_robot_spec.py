import copy
import json
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import Field, ValidationError
from robot_oracles import BUNDLED, DRUM, SCREW, robot_file, robot_of, section, tapered_robot

import hognose
from hognose.errors import InputError
from hognose.robot import Robot, RobotSpec
from hognose.robot.spec import SectionSpec

BUNDLED_FOLDER = Path(hognose.__file__).parent / "robot" / "bundled"
ARRAYS = [
    "link_lengths",
    "joint_before",
    "joint_after",
    "body_radii",
    "bend_limits",
    "link_masses",
    "centres_of_mass",
    "cable_sections",
    "cable_radii",
    "cable_azimuths",
    "travel_per_count",
]


def changed(place, value):
    """The plain robot file with one value changed, put in, or (for ...) taken out."""
    data = copy.deepcopy(robot_file([section(count=3)]))
    *parents, last = place
    target = data
    for key in parents:
        target = target[key]
    if value is ...:
        del target[last]
    else:
        target[last] = value
    return data


def test_the_plain_file_is_sound():
    assert RobotSpec.model_validate(robot_file()).arm_length == pytest.approx(0.273)


NUMBERS = [
    (*place, key)
    for place, keys in [
        ((), ["base_length", "tool_length"]),
        (("feed",), ["min", "max", "speed"]),
        (("limits",), ["joint_speed_deg_s", "joint_acceleration_deg_s2", "cable_speed"]),
        (("section", 0), ["pitch", "body_diameter", "bend_limit_deg", "link_mass", "cable_radius"]),
        (("section", 0), ["cable_azimuth_step_deg"]),
        (("section", 0, "transmission"), ["screw_lead", "gear_ratio"]),
    ]
    for key in keys
]


#: Numbers that may be left out if others are given instead, and what is said if they are not.
ONE_OF = {"screw_lead": "screw_lead or drum_diameter", "body_diameter": "body_diameter is missing"}


@pytest.mark.parametrize("value", ["0.5", True, float("nan"), float("inf"), -float("inf"), None, [0.5]])
@pytest.mark.parametrize("place", NUMBERS, ids=lambda place: ".".join(map(str, place)))
def test_every_number_must_be_a_finite_number(place, value):
    with pytest.raises(ValidationError) as caught:
        RobotSpec.model_validate(changed(place, value))
    assert any(error["loc"][: len(place)] == place for error in caught.value.errors()) or (
        value is None and ONE_OF.get(place[-1], "not said") in str(caught.value)
    )


POSITIVE = [
    place for place in NUMBERS if place[-1] not in ("base_length", "tool_length", "min", "cable_azimuth_step_deg")
]


@pytest.mark.parametrize("value", [0, -0.001])
@pytest.mark.parametrize("place", POSITIVE, ids=lambda place: ".".join(map(str, place)))
def test_what_must_be_above_zero_is_refused_at_zero_and_below(place, value):
    with pytest.raises(ValidationError):
        RobotSpec.model_validate(changed(place, value))


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("schema",), 2, "schema"),
        (("schema",), 0, "schema"),
        (("name",), "", "name"),
        (("name",), "x" * 81, "name"),
        (("name",), ..., "name"),
        (("nmae",), "x", "nmae"),
        (("base_length",), -0.001, "base_length"),
        (("tool_length",), -0.001, "tool_length"),
        (("section",), (), "section"),
        (("section",), ..., "section"),
        (("feed",), ..., "feed"),
        (("feed", "min"), 0.1, "must start at or below 0 and reach beyond it"),
        (("feed", "max"), -0.1, "must start at or below 0 and reach beyond it"),
        (("feed", "stroke"), 1.0, "stroke"),
        (("limits", "cable_travel"), (0.0, 0.1), "cable_travel must be [below 0, above 0]"),
        (("limits", "cable_travel"), (-0.1, 0.0), "cable_travel must be [below 0, above 0]"),
        (("limits", "cable_travel"), (0.1, -0.1), "cable_travel must be [below 0, above 0]"),
        (("limits", "cable_travel"), (-0.1, 0.1, 0.2), "cable_travel"),
        (("limits", "motor_counts"), (0, 1000), "motor_counts must be [below 0, above 0]"),
        (("limits", "motor_counts"), (-1000, 0), "motor_counts must be [below 0, above 0]"),
        (("limits", "motor_counts"), (-1000.5, 1000), "motor_counts"),
        (("section", 0, "count"), 0, "count"),
        (("section", 0, "count"), 10_001, "count"),
        (("section", 0, "count"), 1.0, "count"),
        (("section", 0, "half_lengths"), (-0.001, 0.01), "half_lengths"),
        (("section", 0, "half_lengths"), (0.01,), "half_lengths"),
        (("section", 0, "half_lengths"), (0.0455, 0.0455), "half_lengths add up to 91 mm"),
        (("section", 0, "half_lengths"), (0.0, 0.0), "half_lengths add up to 0 mm"),
        (("section", 0, "half_lengths"), (5e-5, 4e-5), "must be 0.1 mm apart at least"),
        (("section", 0, "pitch"), 1e-10, "too small"),
        (("section", 0, "pitch"), 10**400, "pitch"),
        (("section", 0, "link_mass"), 1e300, "link_mass"),
        (("section", 0, "link_mass"), 1001.0, "1001 kg is heavier than any part of a snake arm, 1000 kg at most"),
        (("section", 0, "link_mass"), 0.0, "link_mass"),
        (("tool_mass",), 1e9, "1e+09 kg is heavier than any part of a snake arm, 1000 kg at most"),
        (("limits", "joint_speed_deg_s"), 5e-324, "joint_speed_deg_s"),
        (("limits", "joint_acceleration_deg_s2"), 1.7e308, "joint_acceleration_deg_s2"),
        (("limits", "motor_counts"), (-(2**63) - 1, 5), "motor_counts"),
        (("limits", "motor_counts"), (-5, 2**63), "motor_counts"),
        (("limits", "motor_counts"), (-(10**400), 10**400), "motor_counts"),
        (("section", 0, "transmission", "counts_per_turn"), 2**63, "counts_per_turn"),
        (("section", 0, "transmission", "counts_per_turn"), 10**400, "counts_per_turn"),
        (("section", 0, "transmission", "gear_ratio"), 10**400, "gear_ratio"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 10.0, 20.0), "leaves 340° without a cable, from 20° to 0°"),
        (("section", 0, "cable_azimuths_deg"), (-90.0, 0.0, 90.0), "leaves 180° without a cable, from 90° to 270°"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 60.0, 120.0, 180.0), "leaves 180°"),
        (("section", 0, "bend_limit_deg"), 90.0, "bend_limit_deg"),
        (("section", 0, "bend_limit_deg"), (20.0, 90.0), "bend_limit_deg"),
        (("section", 0, "bend_limit_deg"), (20.0, 0.0), "bend_limit_deg"),
        (("section", 0, "bend_limit_deg"), (20.0, 20.0, 20.0), "bend_limit_deg"),
        (
            ("section", 0, "cable_radius"),
            0.0225,
            "cable_radius 22.5 mm lies outside the body of 45 mm diameter",
        ),
        (("section", 0, "cable_azimuths_deg"), (0.0, 120.0), "cable_azimuths_deg"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 120.0, 361.0), "cable_azimuths_deg"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 120.0, -361.0), "cable_azimuths_deg"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 120.0, 120.0), "the same azimuth twice"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 120.0, -240.0), "the same azimuth twice"),
        (("section", 0, "cable_azimuths_deg"), (0.0, 120.0, 360.0), "the same azimuth twice"),
        (("section", 0, "cable_azimuth_step_deg"), 361.0, "cable_azimuth_step_deg"),
        (("section", 0, "transmission"), {**SCREW, **DRUM}, "exactly one of them"),
        (("section", 0, "transmission", "screw_lead"), ..., "exactly one of them"),
        (("section", 0, "transmission", "counts_per_turn"), 0, "counts_per_turn"),
        (("section", 0, "transmission", "counts_per_turn"), 2000.5, "counts_per_turn"),
        (("section", 0, "transmission", "gear_ratio"), ..., "gear_ratio"),
        (("section", 0, "colour"), "red", "colour"),
        (("assumed",), ("section.pich",), "'section.pich' is not a key of a robot file"),
        (("assumed",), ("section.pitch.mm",), "'section.pitch.mm' is not a key of a robot file"),
        (("assumed",), ("",), "'' is not a key of a robot file"),
    ],
)
def test_every_stated_constraint_is_held_and_named(place, value, words):
    with pytest.raises(ValidationError) as caught:
        RobotSpec.model_validate(changed(place, value))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("name",), "x" * 80),
        (("feed", "min"), -0.2),
        (("section", 0, "count"), 300),
        (("section", 0, "half_lengths"), (0.0, 0.0001)),
        (("section", 0, "cable_azimuths_deg"), (0.0, 1.0, 180.9)),
        (("limits", "motor_counts"), (-(2**63), 2**63 - 1)),
        (("limits", "joint_speed_deg_s"), 1e9),
        (("section", 0, "half_lengths"), (0.0454, 0.0455)),
        (("section", 0, "bend_limit_deg"), 89.9),
        (("section", 0, "cable_radius"), 0.0224),
        (("section", 0, "cable_azimuths_deg"), (-360.0, 120.0, 240.0)),
        (("section", 0, "link_mass"), 1),
        (("assumed",), ("feed.max", "section", "section.transmission.drum_diameter", "limits.cable_travel")),
    ],
)
def test_values_just_inside_the_constraints_are_taken(place, value):
    RobotSpec.model_validate(changed(place, value))


@given(st.lists(st.integers(-359, 360), min_size=3, max_size=8, unique_by=lambda azimuth: azimuth % 360))
@settings(deadline=None, max_examples=200)
def test_cables_are_taken_if_and_only_if_they_can_pull_every_way(azimuths):
    """Positive tensions can pull any way if no direction has all of the cables on one side of it, or across it."""
    ways = np.radians(np.arange(0, 360, 0.5))[:, None] - np.radians(azimuths)
    pull = np.cos(ways).max(axis=1)  # of the cable that helps the most; whole degrees make right angles exact
    possible = bool((pull > 1e-9).all())
    data = changed(("section", 0, "cable_azimuths_deg"), tuple(map(float, azimuths)))
    if possible:
        RobotSpec.model_validate(data)
        return
    with pytest.raises(ValidationError, match="without a cable"):
        RobotSpec.model_validate(data)


def test_cables_run_within_the_body_of_every_section_they_pass():
    wide, narrow = section(body_diameter=0.06, cable_radius=0.025), section(body_diameter=0.04, cable_radius=0.015)
    RobotSpec.model_validate(robot_file([wide, narrow]))
    RobotSpec.model_validate(robot_file([section(body_diameter=0.06, cable_radius=0.015), narrow, narrow]))
    words = (
        "the cables of group 3 run through group 2, too, but their cable_radius of 25 mm lies outside its body of 40 mm"
    )
    with pytest.raises(ValidationError, match=words):
        RobotSpec.model_validate(robot_file([wide, narrow, wide]))
    with pytest.raises(ValidationError, match="the cables of group 2 run through group 1"):
        RobotSpec.model_validate(robot_file([narrow, section(body_diameter=0.06, cable_radius=0.02)]))
    # Where they run on a circle of the narrow section, they may come from a wider one.
    waist = narrow | {"passing_cable_radius": 0.018}
    RobotSpec.model_validate(robot_file([wide, waist, wide]))
    with pytest.raises(ValidationError, match="passing_cable_radius 20 mm lies outside the body of 40 mm diameter"):
        RobotSpec.model_validate(robot_file([narrow | {"passing_cable_radius": 0.02}]))


def test_cables_that_pass_a_flat_group_are_within_its_sides_at_all_their_azimuths():
    flat = {"body": "flat", "body_width": 0.025, "body_height": 0.05, "body_diameter": None, "cable_radius": 0.012}
    flat |= {"cable_azimuths_deg": (40.0, 160.0, 280.0), "passing_cable_radius": 0.02}
    RobotSpec.model_validate(robot_file([section(count=1, **flat)]))  # none passes it
    with pytest.raises(ValidationError, match=r"passing_cable_radius 20 mm .* at the azimuth 40"):
        RobotSpec.model_validate(robot_file([section(count=2, **flat)]))


@pytest.mark.parametrize("behind", [False, True])
def test_cables_stay_within_the_body_of_an_arc_between_its_disks(behind):
    """By points of the straight cable on the inner side, for the fewest disks that are let through and one less."""
    arc = section(kind="arc", half_lengths=None, pitch=0.2, body_diameter=0.04, bend_limit_deg=75.0, cable_radius=0.012)
    outer = arc | {"cable_radius": 0.019}
    parts = [arc, outer] if behind else [outer]
    enough = disks = 0
    for disks in range(1, 20):
        parts[0] = parts[0] | {"disks": disks}
        bend = np.hypot(*[np.radians(75.0)] * 2)
        curved = 0.2 / bend
        ends = [(curved - 0.019) * np.array([np.cos(a), np.sin(a)]) for a in (0.0, bend / disks)]
        along = np.linspace(0.0, 1.0, 101)[:, None]
        farthest = (curved - np.linalg.norm(ends[0] + along * (ends[1] - ends[0]), axis=1)).max()
        if farthest <= 0.02:
            RobotSpec.model_validate(robot_file(parts))
            break
        with pytest.raises(ValidationError, match=f"between disks = {disks} of an arc, cables at 19 mm") as caught:
            RobotSpec.model_validate(robot_file(parts))
        enough = int(str(caught.value).split("take disks = ")[1].split()[0])
    assert 2 < disks == enough


def test_sections_are_counted_over_all_groups():
    with pytest.raises(ValidationError, match="10,001 sections are too many; at most 10,000"):
        RobotSpec.model_validate(robot_file([section(count=10_000, pitch=0.0211), section(pitch=0.0211)]))


def test_the_joint_parts_of_two_sections_must_fit_on_the_link_between_them():
    """The link of section i holds h2 of its own joint and h1 of the next one."""
    parts = [section(pitch=0.02, half_lengths=(0.002, 0.01)), section(half_lengths=(0.015, 0.01))]
    with pytest.raises(ValidationError):
        RobotSpec.model_validate(robot_file(parts))


@pytest.mark.parametrize(("count", "pitch"), [(12, 91.0), (1, 0.019), (10_000, 0.0031)])
def test_an_arm_of_an_implausible_length_is_asked_for_its_units(count, pitch):
    with pytest.raises(ValidationError, match="is `units` right") as caught:
        RobotSpec.model_validate(robot_file([section(count=count, pitch=pitch, half_lengths=(pitch / 10, pitch / 10))]))
    assert "0.02 to 30 m" in str(caught.value)


def test_a_robot_file_in_the_wrong_unit_is_an_input_error_that_says_so(tmp_path):
    text = (BUNDLED_FOLDER / "sjtu-25dof.toml").read_text().replace('units = "mm"', 'units = "m"')
    file = tmp_path / "arm.toml"
    file.write_text(text)
    with pytest.raises(InputError, match="is `units` right") as caught:
        hognose.load_robot(file)
    assert "arm.toml" in str(caught.value)
    assert "1,092 m" in str(caught.value)


def test_an_unknown_robot_is_an_input_error_that_lists_the_known_ones():
    with pytest.raises(InputError, match="Did you mean 'sjtu-25dof'") as caught:
        hognose.load_robot("sjtu-25dog")
    for name in BUNDLED:
        assert name in str(caught.value)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=25)
def test_a_dumped_robot_validates_to_the_identical_robot(seed):
    robot = tapered_robot(seed)
    dumped = robot.spec.model_dump(by_alias=True)
    again = Robot.from_spec(RobotSpec.model_validate(dumped))
    assert again.spec == robot.spec
    assert again.fingerprint == robot.fingerprint
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(again, name), getattr(robot, name))
    # Through JSON text, as plan files keep it, arrays come back as lists and every float to the bit.
    assert RobotSpec.model_validate(json.loads(json.dumps(dumped))) == robot.spec
    assert RobotSpec.model_validate_json(robot.spec.model_dump_json(by_alias=True)) == robot.spec


def test_groups_are_expanded_section_by_section():
    first = section(
        count=3,
        pitch=0.1,
        half_lengths=(0.01, 0.02),
        bend_limit_deg=(10.0, 20.0),
        cable_azimuths_deg=(0.0, 120.0, 240.0),
        cable_azimuth_step_deg=-10.0,
    )
    second = section(
        count=2,
        pitch=0.05,
        body_diameter=0.03,
        bend_limit_deg=30.0,
        link_mass=0.02,
        cable_radius=0.012,
        cable_azimuths_deg=(5.0, 95.0, 185.0, 275.0),
        cable_azimuth_step_deg=7.0,
        transmission=DRUM,
    )
    robot = robot_of([first, second], tool_length=0.03, base_length=0.2)
    np.testing.assert_allclose(robot.link_lengths, [0.1, 0.1, 0.1, 0.05, 0.08], rtol=1e-15)
    assert robot.length == pytest.approx(0.43, rel=1e-15)
    assert robot.length == pytest.approx(robot.spec.arm_length, rel=1e-15)
    np.testing.assert_array_equal(robot.joint_before, [0.01] * 3 + [0.0105] * 2)
    np.testing.assert_array_equal(robot.joint_after, [0.02] * 3 + [0.0105] * 2)
    np.testing.assert_array_equal(robot.body_radii, [0.0225] * 3 + [0.015] * 2)
    np.testing.assert_array_equal(np.degrees(robot.bend_limits).round(12), [[10, 20]] * 3 + [[30, 30]] * 2)
    np.testing.assert_array_equal(robot.link_masses, [0.062] * 3 + [0.02] * 2)
    np.testing.assert_array_equal(robot.cable_sections, [0] * 3 + [1] * 3 + [2] * 3 + [3] * 4 + [4] * 4)
    np.testing.assert_array_equal(robot.cable_radii, [0.019] * 9 + [0.012] * 8)
    azimuths = [0, 120, 240, -10, 110, 230, -20, 100, 220, 5, 95, 185, 275, 12, 102, 192, 282]
    np.testing.assert_allclose(np.degrees(robot.cable_azimuths), azimuths, rtol=0, atol=1e-12)
    assert (robot.sections, robot.cables) == (5, 17)


def test_equal_sections_in_a_row_are_a_group_written_out():
    whole = robot_of([section(count=4, cable_azimuth_step_deg=-10.0)])
    azimuths = [tuple(a - 10.0 * i for a in (50.0, -70.0, -190.0)) for i in range(4)]
    parts = robot_of([section(cable_azimuths_deg=a) for a in azimuths])
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(whole, name), getattr(parts, name))


def test_the_tool_lengthens_the_nose_and_no_cable():
    bare, tooled = robot_of(), robot_of(tool_length=0.04)
    bent = np.full((3, 2), 0.2)
    np.testing.assert_allclose(tooled.cable_lengths(bent), bare.cable_lengths(bent), rtol=0, atol=1e-16)
    np.testing.assert_array_equal(tooled.joint_positions(bent)[:-1], bare.joint_positions(bent)[:-1])
    pose = bare.tip_pose(bent)
    np.testing.assert_allclose(tooled.joint_positions(bent)[-1], pose[:3, 3] + 0.04 * pose[:3, 2], rtol=0, atol=1e-15)


def test_the_bundled_arms_are_those_of_the_sources():
    paper, later = (hognose.load_robot(name) for name in BUNDLED)
    assert (paper.sections, paper.cables, later.sections, later.cables) == (12, 36, 12, 36)
    np.testing.assert_allclose(paper.link_lengths, np.full(12, 0.091), rtol=1e-15)
    np.testing.assert_allclose(paper.bend_limits, np.full((12, 2), 0.5), rtol=1e-15)
    np.testing.assert_allclose(later.link_lengths, np.full(12, 0.09921), rtol=1e-15)
    np.testing.assert_allclose(later.bend_limits, np.full((12, 2), 0.35), rtol=1e-15)
    assert paper.spec.base_length + paper.length == pytest.approx(1.235, rel=1e-12)
    holes = np.sort(np.degrees(paper.cable_azimuths) % 360)
    np.testing.assert_allclose(np.diff(holes), np.full(35, 10.0), atol=1e-9)
    np.testing.assert_allclose(np.degrees(paper.cable_azimuths[::3]), 50 - 10.0 * np.arange(12), rtol=0, atol=1e-12)
    for arm in (paper, later):
        np.testing.assert_allclose(arm.cable_radii, np.full(36, 0.019), rtol=1e-15)
    assert {"feed", "limits", "base_length"} <= set(paper.assumed)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("name",), "another arm"),
        (("tool_length",), 0.001),
        (("base_length",), 0.001),
        (("feed", "max"), 1.2),
        (("limits", "cable_speed"), 0.041),
        (("limits", "motor_counts"), (-5, 5)),
        (("section", 0, "count"), 4),
        (("section", 0, "pitch"), np.nextafter(0.091, 1)),
        (("section", 0, "half_lengths"), (0.0105, 0.0106)),
        (("section", 0, "cable_azimuth_step_deg"), 1.0),
        (("section", 0, "transmission", "counts_per_turn"), 2001),
    ],
)
def test_the_fingerprint_changes_with_every_value(place, value):
    assert Robot.from_spec(RobotSpec.model_validate(changed(place, value))).fingerprint != robot_of().fingerprint


@pytest.mark.parametrize(("key", "value"), [("description", "d"), ("source", "s"), ("assumed", ("feed",))])
def test_the_fingerprint_does_not_change_with_the_words(key, value):
    assert robot_of(**{key: value}).fingerprint == robot_of().fingerprint


class LaterSection(SectionSpec):
    """A section with a key that a later version brings."""

    friction: float = 0.1


class LaterSpec(RobotSpec):
    """A robot file with keys that a later version brings, before and behind those of today."""

    section: Annotated[tuple[LaterSection, ...], Field(min_length=1)]  # pyright: ignore[reportIncompatibleVariableOverride]
    weight_compensation: bool = False
    drum_stops: tuple[float, ...] = ()


def test_keys_of_later_versions_leave_the_fingerprint_alone_at_their_defaults():
    data = robot_of().spec.model_dump(by_alias=True)
    given = Robot.from_spec(LaterSpec.model_validate(data))
    assert "friction" in given.spec.model_dump_json()
    assert given.fingerprint == robot_of().fingerprint
    others = [
        data | {"weight_compensation": True},
        data | {"drum_stops": (1.0,)},
        data | {"section": [{**data["section"][0], "friction": 0.2}, *data["section"][1:]]},
    ]
    found = {Robot.from_spec(LaterSpec.model_validate(other)).fingerprint for other in others}
    assert len(found | {given.fingerprint}) == 1 + len(others)


@pytest.mark.parametrize(
    ("name", "fingerprint"), [("sjtu-25dof", "112e50cd61367560"), ("sjtu-25dof-99", "ebfd266e10f78c4f")]
)
def test_fingerprints_are_those_in_plan_files(name, fingerprint):
    """The digests of files that were written with schema 2; whatever robot files get, these stay.

    The bundled arms had no cables that are springs then.
    """
    spec = hognose.load_robot(name).spec
    assert Robot.from_spec(spec.model_copy(update={"cables": None})).fingerprint == fingerprint


def test_a_robot_cannot_be_changed_by_accident():
    robot = robot_of()
    for name in [*ARRAYS, "straight_cable_lengths"]:
        with pytest.raises(ValueError, match="read-only"):
            getattr(robot, name)[0] = 1
    with pytest.raises(AttributeError):
        robot.link_lengths = np.ones(3)  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(ValidationError):
        robot.spec.name = "other"  # pyright: ignore[reportAttributeAccessIssue]
