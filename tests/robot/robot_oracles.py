"""Random robots, and slow second opinions on what a robot says about its joints and cables."""

import numpy as np
from scipy.linalg import expm

from hognose.robot import Robot, RobotSpec

BUNDLED = ["sjtu-25dof", "sjtu-25dof-99"]
SCREW = {"screw_lead": 0.004, "gear_ratio": 4.8, "counts_per_turn": 2000}
DRUM = {"drum_diameter": 0.027, "gear_ratio": 25.0, "counts_per_turn": 65536}


def section(**changes):
    """One section of a robot file, in metres."""
    return {
        "pitch": 0.091,
        "half_lengths": (0.0105, 0.0105),
        "body_diameter": 0.045,
        "bend_limit_deg": 28.0,
        "link_mass": 0.062,
        "cable_radius": 0.019,
        "cable_azimuths_deg": (50.0, -70.0, -190.0),
        "transmission": SCREW,
        **changes,
    }


def robot_file(sections=None, **changes):
    """A whole robot file as it is read, in metres."""
    return {
        "schema": 1,
        "name": "test arm",
        "feed": {"min": 0.0, "max": 1.1, "speed": 0.05},
        "limits": {
            "joint_speed_deg_s": 7.0,
            "joint_acceleration_deg_s2": 60.0,
            "cable_speed": 0.04,
            "cable_travel": (-0.09, 0.09),
        },
        "section": sections or (section(count=3),),
        **changes,
    }


def robot_of(sections=None, **changes):
    return Robot.from_spec(RobotSpec.model_validate(robot_file(sections, **changes)))


def tapered_robot(seed, sections=7, passing=False):
    """An arm whose sections differ in pitch, h1, h2, cable circle, azimuths, number of cables, transmission.

    Cables run on the circles of most sections that they pass, if `passing`, and else keep their own; and joints bend
    farther to one side than to the other.
    """
    rng = np.random.default_rng(seed)
    parts = []
    for width in np.linspace(0.06, 0.03, sections):
        pitch = rng.uniform(0.06, 0.14)
        cables = int(rng.integers(3, 6))
        parts.append(
            section(
                pitch=pitch,
                half_lengths=tuple(pitch * rng.uniform(0.02, 0.3, 2)),
                body_diameter=width,
                bend_limit_deg=tuple(rng.uniform(15, 50, 2)),
                cable_radius=width * rng.uniform(0.3, 0.45),
                cable_azimuths_deg=tuple(np.arange(cables) * 360 / cables - rng.uniform(0, 60, cables)),
                transmission=SCREW if rng.random() < 0.5 else DRUM,
            )
        )
    tool_length = rng.uniform(0, 0.05)
    if passing:
        chosen = [each | {"passing_cable_radius": each["body_diameter"] * rng.uniform(0.2, 0.48)} for each in parts]
        parts = [here if rng.random() < 0.8 else each for here, each in zip(chosen, parts, strict=True)]
        parts = [each | {"alpha_range_deg": (-each["bend_limit_deg"][0], 14.0)} for each in parts]
    return robot_of(parts, tool_length=tool_length)


def circle(robot, cable, link):
    """Radius (m) of the circle of a cable's holes in the disks of a link (0-based), or of the mount (-1)."""
    groups = [group for group in robot.spec.section for _ in range(group.count)]
    owner, here = robot.cable_sections[cable], groups[max(link, 0)]
    own = groups[owner].cable_radius
    return own if max(link, 0) == owner or here.passing_cable_radius is None else here.passing_cable_radius


def random_angles(robot, rng, leading=(), share=1.0):
    return rng.uniform(-share, share, (*leading, robot.sections, 2)) * robot.bend_limits


def rotation(alpha, beta):
    """R_y(alpha) R_x(beta), written out (paper eq. 15)."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    return np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]]) @ np.array([[1, 0, 0], [0, cb, -sb], [0, sb, cb]])


def frames(robot, angles, feed=0.0):
    """Joints and tip (n+1, 3), and the orientation (n, 3, 3) of every link's frame, which stands at its joint."""
    place, turn = np.array([0.0, 0.0, feed]), np.eye(3)
    places, turns = [place], []
    for (alpha, beta), length in zip(angles, robot.link_lengths, strict=True):
        turn = turn @ rotation(alpha, beta)
        turns.append(turn)
        place = place + length * turn[:, 2]
        places.append(place)
    return np.array(places), np.array(turns)


def twist(axis, point):
    """exp's argument for a turn about an axis through a point: (omega; v = -omega x q), as in table 1."""
    x, y, z = axis
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    matrix[:3, 3] = -np.cross(axis, point)
    return matrix


def product_of_exponentials(angles, joint_heights, tip_height):
    """Eq. 13 read literally: both twists of section i cross the z axis at the height of joint i."""
    pose = np.eye(4)
    for (alpha, beta), height in zip(angles, joint_heights, strict=True):
        at = [0.0, 0.0, height]
        pose = pose @ expm(twist([0, 1, 0], at) * alpha) @ expm(twist([1, 0, 0], at) * beta)
    rest = np.eye(4)
    rest[2, 3] = tip_height
    return pose @ rest


def cable_heights(robot):
    """Height of the holes on the base, before joint 1, and of the two (n, 2) on each link in its frame."""
    pitches = robot.link_lengths.copy()
    pitches[-1] -= robot.spec.tool_length
    next_before = np.append(robot.joint_before[1:], robot.joint_before[-1])
    return -robot.joint_before[0], np.column_stack([robot.joint_after, pitches - next_before])


def cable_lengths(robot, angles):
    """Cable lengths (c,) as the distances between holes placed in space."""
    places, turns = frames(robot, angles)
    base, heights = cable_heights(robot)
    lengths = []
    for cable, (owner, azimuth) in enumerate(zip(robot.cable_sections, robot.cable_azimuths, strict=True)):
        around = np.array([np.cos(azimuth), np.sin(azimuth)])
        holes = [np.array([*circle(robot, cable, -1) * around, base])]
        for link in range(owner + 1):
            x, y = circle(robot, cable, link) * around
            holes += [places[link] + turns[link] @ [x, y, height] for height in heights[link]]
        lengths.append(np.linalg.norm(np.diff(holes, axis=0), axis=1).sum())
    return np.array(lengths)


def mjcf(robot):
    """The arm in MuJoCo: a body a link (y hinge, then x hinge), a site a hole, a spatial tendon a cable."""
    cables = list(zip(robot.cable_sections, robot.cable_azimuths, strict=True))
    base, heights = cable_heights(robot)

    def sites(body, levels, first_owner):
        return "".join(
            f'<site name="c{k}_{body}_{place}" pos="{r * np.cos(a):.17g} {r * np.sin(a):.17g} {z:.17g}"/>'
            for k, (owner, a) in enumerate(cables)
            for r in [circle(robot, k, -1 if body == "base" else body)]
            if owner >= first_owner
            for place, z in enumerate(levels)
        )

    bodies = sites("base", [base], 0)
    for i, shift in enumerate(np.append(0.0, robot.link_lengths[:-1])):
        bodies += (
            f'<body pos="0 0 {shift:.17g}">'
            '<joint type="hinge" axis="0 1 0"/><joint type="hinge" axis="1 0 0"/>'
            f'<inertial pos="0 0 {robot.centres_of_mass[i]:.17g}" mass="{robot.link_masses[i]:.17g}" '
            f'diaginertia="1e-4 1e-4 1e-4"/>{sites(i, heights[i], i)}'
        )
    if robot.tool_mass:
        load = f'<inertial pos="0 0 0" mass="{robot.tool_mass:.17g}" diaginertia="1e-6 1e-6 1e-6"/>'
        bodies += f'<body pos="0 0 {robot.link_lengths[-1]:.17g}">{load}</body>'
    bodies += f'<site name="tip" pos="0 0 {robot.link_lengths[-1]:.17g}"/>' + "</body>" * robot.sections
    tendons = "".join(
        f'<spatial name="c{k}"><site site="c{k}_base_0"/>'
        + "".join(f'<site site="c{k}_{i}_{place}"/>' for i in range(owner + 1) for place in (0, 1))
        + "</spatial>"
        for k, (owner, _) in enumerate(cables)
    )
    return (
        '<mujoco><compiler angle="radian"/><option><flag contact="disable"/></option>'
        f"<worldbody>{bodies}</worldbody><tendon>{tendons}</tendon></mujoco>"
    )
