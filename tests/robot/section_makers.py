"""Arms whose sections are of all kinds, and slow second opinions on them."""

import numpy as np
from robot_oracles import robot_of, section
from scipy.spatial.transform import Rotation

from hognose.robot.sections import MixedSections

ARC = {"kind": "arc", "half_lengths": None}
KINDS = ("link", "hinges", "joints", "arc")
#: Of an arm that is held by nothing but bends, and of its sections.
WIDE = {
    "feed": {"min": 0.0, "max": 5.0, "speed": 1.0},
    "limits": {
        "joint_speed_deg_s": 60.0,
        "joint_acceleration_deg_s2": 2000.0,
        "cable_speed": 1.0,
        "cable_travel": (-1.0, 1.0),
    },
}
THIN = {"body_diameter": 0.03, "cable_radius": 0.012}


def of_kind(kind, rng=None, **changes):
    """A section of a kind in metres; at random if there are random numbers."""
    pitch = 0.091 if rng is None else float(rng.uniform(0.06, 0.14))
    joints = 4 if rng is None else int(rng.integers(2, 8))
    half = pitch / 12 if kind != "joints" else pitch / joints / 4
    own = {
        "link": {},
        "hinges": {"axis_offset": 0.3 * pitch},
        "joints": {"joints": joints},
        "arc": {"disks": None if rng is None or rng.random() < 0.5 else int(rng.integers(3, 9))},
    }[kind]
    # Behind an arc there is no straight body for a hole plane before the next joint.
    spec = {
        "kind": kind,
        "pitch": pitch,
        "half_lengths": None if kind == "arc" else (0.0, half),
        "bend_limit_deg": 40.0,
    }
    return section(**{**spec, **own, **changes})


def thin_arm(*kinds, **changes):
    """An arm of sections of these kinds that is held by nothing but bends, unless changed; some values of sections."""
    of_arm = {name: changes.pop(name) for name in ("feed", "limits", "base_length") if name in changes}
    return robot_of([of_kind(kind, **THIN, **changes) for kind in kinds], **{**WIDE, **of_arm})


def mixed_robot(seed, sections=6, kinds=KINDS, passing=False, **changes):
    """An arm of sections of random kinds; the first is an arc, so that it is never one of links alone.

    Cables run on other circles in most of the sections that they pass, if `passing`.
    """
    rng = np.random.default_rng(seed)
    parts = [of_kind(kind, rng) for kind in ["arc", *rng.choice(kinds, sections - 1)]]
    tool = float(rng.choice([0.0, 0.03]))
    if passing:
        parts = [each | {"passing_cable_radius": float(rng.uniform(0.005, 0.020))} for each in parts]
        parts = [each if rng.random() < 0.8 else each | {"passing_cable_radius": None} for each in parts]
    return robot_of(parts, **{"tool_length": tool, **changes})


def mixed(robot):
    """The model of an arm that is not one of links alone."""
    assert isinstance(robot.model, MixedSections)
    return robot.model


def stretched(robot, i):
    """The pieces (m, 4) of section i."""
    model = mixed(robot)
    return model.table[model.first[i] : model.first[i + 1]]


def dense_line(robot, angles, parts=400):
    """Points of the centre line (q, 3), and where each section ends among them, by many small turns and steps."""
    place, turn, points, ends = np.zeros(3), Rotation.identity(), [np.zeros(3)], [0]
    for i, (alpha, beta) in enumerate(angles):
        for share_a, share_b, length, curved in stretched(robot, i):
            a, b = share_a * alpha, share_b * beta
            if curved:
                small = Rotation.from_rotvec(np.array([b, a, 0.0]) / parts)
                half = Rotation.from_rotvec(np.array([b, a, 0.0]) / (2 * parts))
                bend = np.hypot(a, b)
                chord = 2 * length / bend * np.sin(bend / (2 * parts)) if bend else length / parts
                for _ in range(parts):
                    place = place + chord * (turn * half).apply([0.0, 0.0, 1.0])
                    turn = turn * small
                    points.append(place)
            else:
                turn = turn * Rotation.from_euler("YX", [a, b])
                for k in range(1, parts + 1):
                    points.append(place + length * k / parts * turn.apply([0.0, 0.0, 1.0]))
                place = points[-1]
        ends.append(len(points) - 1)
    return np.array(points), np.array(ends), turn.as_matrix()
