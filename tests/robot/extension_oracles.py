"""Arms whose sections extend, and slow second opinions on them."""

import numpy as np
from robot_oracles import robot_of
from scipy.spatial.transform import Rotation
from section_makers import THIN, WIDE, of_kind


def extending(*counts_of_disks, pitch=0.09, length_range=(0.06, 0.13), **changes):
    """An arm of arcs that extend, each with so many disks or None, held by nothing but bends, unless changed."""
    own = {"pitch": pitch, "length_range": length_range, **THIN, **changes}
    return robot_of([of_kind("arc", disks=disks, **own) for disks in counts_of_disks], **WIDE)


def posture(robot, rng, bend=0.6):
    """Angles (n, 2) and lengths (n,) at random within the arm's."""
    low, high = robot.length_bounds.T
    return rng.uniform(-bend, bend, (robot.sections, 2)), rng.uniform(low, high)


def arcs_line(angles, lengths, parts):
    """Points (n * parts + 1, 3) of a chain of arcs at equal parts, and its last frame, by small turns and steps."""
    place, turn, points = np.zeros(3), Rotation.identity(), [np.zeros(3)]
    for (alpha, beta), length in zip(angles, lengths, strict=True):
        small = Rotation.from_rotvec(np.array([beta, alpha, 0.0]) / parts)
        half = Rotation.from_rotvec(np.array([beta, alpha, 0.0]) / (2 * parts))
        bend = np.hypot(alpha, beta) / parts
        chord = length / parts * (np.sin(bend / 2) / (bend / 2) if bend else 1.0)
        for _ in range(parts):
            place = place + chord * (turn * half).apply([0.0, 0.0, 1.0])
            turn = turn * small
            points.append(place)
    return np.array(points), turn.as_matrix()


def threaded(robot, angles, lengths):
    """Lengths (c,) of cables from hole to hole of all disks, of an arm of arcs that all have as many disks."""
    disks = robot.spec.section[0].disks
    points, frames = [np.zeros(3)], [Rotation.identity()]
    for (alpha, beta), length in zip(angles, lengths, strict=True):
        for _ in range(disks):
            small = np.array([beta, alpha, 0.0]) / disks
            line, _ = arcs_line([np.array([alpha, beta]) / disks], [length / disks], 1)
            points.append(points[-1] + frames[-1].apply(line[-1]))
            frames.append(frames[-1] * Rotation.from_rotvec(small))
    out = []
    for section, radius, azimuth in zip(robot.cable_sections, robot.cable_radii, robot.cable_azimuths, strict=True):
        hole = radius * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        count = disks * (int(section) + 1) + 1
        holes = np.array([p + f.apply(hole) for p, f in zip(points[:count], frames[:count], strict=True)])
        out.append(np.linalg.norm(np.diff(holes, axis=0), axis=1).sum())
    return np.array(out)
