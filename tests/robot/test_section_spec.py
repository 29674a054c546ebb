"""What robot files say of sections of other kinds than links, and what is said of mistakes in them."""

import numpy as np
import pytest
from pydantic import ValidationError
from robot_oracles import robot_of, section
from section_makers import mixed, of_kind

from hognose.robot.sections.joints import told_apart


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ([section(kind="arcs")], "kind 'arcs' is unknown; did you mean 'arc'?"),
        ([section(kind="tentacle")], "kind 'tentacle' is unknown; there are link, hinges, joints, arc"),
        ([section(joints=3)], "joints is for sections of kind 'joints', and this one is of kind 'link'"),
        ([of_kind("arc", axis_offset=0.02)], "axis_offset is for sections of kind 'hinges'"),
        ([of_kind("joints", disks=3)], "disks is for sections of kind 'arc', and this one is of kind 'joints'"),
        ([section(half_lengths=None)], "half_lengths is missing"),
        ([of_kind("joints", joints=None)], "needs `joints`, their number"),
        (
            [of_kind("joints", joints=6, pitch=0.091, half_lengths=(0.008, 0.008))],
            "too short for its 6 joints: each has 15.1667 mm of the pitch of 91 mm, and half_lengths add up to 16 mm",
        ),
        (
            [of_kind("joints", joints=2, bend_limit_deg=95.0)],
            "bends by 134° in all; beyond 130° the places of its ends leave its angles open",
        ),
        ([of_kind("hinges", axis_offset=None)], "two hinges need axis_offset"),
        (
            [of_kind("hinges", axis_offset=0.085, half_lengths=(0.002, 0.005))],
            "too short for its hinges: axis_offset and half_lengths add up to 92 mm",
        ),
        ([of_kind("arc", half_lengths=(0.0, 0.01))], "has no joint: leave out its half_lengths"),
        (
            [of_kind("arc", pitch=0.03, bend_limit_deg=80.0)],
            "bends by 113° in all, to a radius of 15.2 mm, tighter than the body's own 22.5 mm",
        ),
        (
            [of_kind("arc"), section()],
            "the joint of group 2 stands at the end of a section that bends along its length",
        ),
        (
            [of_kind("joints", joints=4, pitch=0.06, half_lengths=(0.0, 0.01)), section(half_lengths=(0.006, 0.006))],
            "joint parts of groups 1 and 2 leave nothing of the pitch of 15 mm",
        ),
    ],
)
def test_what_does_not_fit_is_said_in_a_sentence(sections, said):
    with pytest.raises(ValidationError) as caught:
        robot_of(sections)
    assert said in str(caught.value)


@pytest.mark.parametrize("joints", [2, 3, 4, 5, 6, 9])
def test_within_the_limits_where_a_stack_ends_says_its_angles(joints):
    rng, most = np.random.default_rng(joints), told_apart(joints)
    around, bend = rng.uniform(0, 2 * np.pi, 4_000), most * (1 - 0.2 * rng.random(4_000) ** 2)
    angles = np.stack([bend * np.cos(around), bend * np.sin(around)], axis=1)[:, None]
    angles = angles[(np.abs(angles) < np.pi).all(axis=(1, 2))]
    stack = robot_of([of_kind("joints", joints=joints, half_lengths=(0.0, 0.002), bend_limit_deg=60.0)])
    np.testing.assert_allclose(stack.angles(stack.joint_positions(angles)), angles, atol=1e-6)


def test_a_section_may_bend_by_more_than_a_joint():
    for kind, limit in (("arc", 100.0), ("joints", 134.0), ("hinges", 89.9), ("link", 89.9)):
        assert np.degrees(robot_of([of_kind(kind, bend_limit_deg=limit)]).bend_limits).max() == pytest.approx(limit)
    assert robot_of([of_kind("joints", bend_limit_deg=(10.0, 180.0))]).bend_limits.max() == pytest.approx(np.pi)
    for kind, limit, each in (("hinges", 90.0, 90), ("link", 120.0, 120)):
        with pytest.raises(ValidationError, match=f"bends a joint by {each} deg, which must be less than 90"):
            robot_of([of_kind(kind, bend_limit_deg=(10.0, limit))])
    with pytest.raises(ValidationError, match="bend_limit_deg"):
        robot_of([of_kind("joints", bend_limit_deg=180.1)])


def test_the_holes_of_two_hinges_may_lie_at_the_hinges():
    arm = robot_of([of_kind("hinges", half_lengths=(0.0, 0.0), cable_azimuths_deg=(0.0, 120.0, 240.0))])
    angle = 0.5  # about the first hinge alone: the far end of cable 1, at (r, 0, offset), is turned about y
    change = arm.cable_lengths(np.array([[angle, 0.0]])) - arm.cable_lengths(np.zeros((1, 2)))
    offset, radius = 0.3 * 0.091, 0.019
    turned = np.array(
        [radius * np.cos(angle) + offset * np.sin(angle), offset * np.cos(angle) - radius * np.sin(angle)]
    )
    assert change[0] == pytest.approx(np.linalg.norm(turned - [radius, 0.0]) - offset, abs=1e-15)
    with pytest.raises(ValidationError, match=r"hole planes before and after a joint must be 0\.1 mm apart"):
        robot_of([section(half_lengths=(0.0, 0.0))])


def test_an_arc_of_which_the_inner_side_just_does_not_fold_is_taken():
    bend = 0.9 * 0.091 / 0.0225  # of both axes together
    assert robot_of([of_kind("arc", bend_limit_deg=(1.0, min(89.0, bend * 57.2))), of_kind("arc")]).sections == 2


def test_kinds_are_mixed_freely_and_have_one_digest_each():
    arms = [
        robot_of([of_kind("arc"), of_kind("joints"), of_kind("hinges"), of_kind("link")]),
        robot_of([of_kind("arc"), of_kind("joints", joints=3), of_kind("hinges"), of_kind("link")]),
        robot_of([of_kind("arc", disks=4), of_kind("joints"), of_kind("hinges"), of_kind("link")]),
        robot_of([of_kind("arc"), of_kind("joints"), of_kind("hinges", axis_offset=0.02), of_kind("link")]),
    ]
    assert len({arm.fingerprint for arm in arms}) == len(arms)
    assert [mixed(arm).chords.tolist()[1:] for arm in arms] == [[4, 2, 1], [3, 2, 1], [4, 2, 1], [4, 2, 1]]
