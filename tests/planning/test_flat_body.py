"""Arms whose body is flat: the box itself, densely sampled, is never closer than what is proven of it."""

from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
import trimesh
from planning_makers import between
from pydantic import ValidationError
from robot_oracles import robot_file, robot_of, section
from scipy.spatial.transform import Rotation

from hognose.files.exports.masses import link_inertia
from hognose.files.exports.mjcf import mjcf
from hognose.files.exports.subject import Subject
from hognose.path import Path
from hognose.planning.certificate import certify, gliding_motion, interpolated_motion, outlined
from hognose.planning.certificate.moving import Pieces
from hognose.planning.near_places import Near, gradients
from hognose.planning.penetration import section_clearance
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.report.arm import link_bodies
from hognose.robot import Drum, Robot, RobotSpec, Slider
from hognose.robot.base import centre_line, joints_on, outline
from hognose.robot.outline import Cover
from hognose.scene import Scene
from hognose.scene.part import Part
from hognose.viewer.shapes import bodies

mj: Any = mujoco  # its names are made at run time

FLAT = {"body": "flat", "body_diameter": None, "body_width": 0.04, "body_height": 0.05, "cable_radius": 0.012}
KINDS = {"link": {}, "joints": {"joints": 3, "pitch": 0.12}, "hinges": {"axis_offset": 0.03, "pitch": 0.12}}
#: Obstacles are specks of this size (m): their corners are all there is to them.
SPECK = 2e-5
TIGHTNESS = 2.5e-4


def arm(*kinds, width=0.03, height=0.06, **changes):
    sizes = {**FLAT, "body_width": width, "body_height": height, **changes}
    given = [section(kind=kind, **{**sizes, **KINDS[kind]}) for kind in kinds]
    return Robot.from_spec(RobotSpec.model_validate(robot_file(sections=tuple(given))))


def turn(axis, angle):
    """R_x or R_y (..., 3, 3) of angles (...)."""
    c, s, o = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    rows = {"x": [o + 1, o, o, o, c, -s, o, s, c], "y": [c, o, s, o, o + 1, o, -s, o, c]}[axis]
    return np.stack(rows, axis=-1).reshape(*np.shape(angle), 3, 3)


def boxes(robot, base, angles, at):
    """Section, origin (T, 3) m, axes (T, 3, 3) in columns and length (m) of every straight piece, by hand."""
    pieces = [
        (i, *piece)
        for i, group in enumerate(g for g in robot.spec.section for _ in range(g.count))
        for piece in group.pieces
    ]
    frame, place = np.repeat(np.eye(3)[None], len(angles), axis=0), np.zeros((len(angles), 3))
    place[:, 2] = base.along(at)
    for i, a, b, length, _ in pieces:
        frame = frame @ turn("y", a * angles[:, i, 0]) @ turn("x", b * angles[:, i, 1])
        axes = np.swapaxes(base.turned(np.swapaxes(frame, 1, 2), at), 1, 2)
        yield i, base.placed(place[:, None], at)[:, 0], axes, length
        place = place + length * frame[:, :, 2]


def to_boxes(robot, base, angles, at, points, longer=0.0):
    """Distances (T, k) m of points (k, 3) m to the boxes of a body, which may be longer at both ends."""
    half = np.array(robot.spec.section[0].shape.sides) / 2
    found = np.full((len(angles), len(points)), np.inf)
    for _, place, axes, length in boxes(robot, base, angles, at):
        local = np.einsum("tkx,txy->tky", points - place[:, None], axes)
        out = np.maximum(np.abs(local[..., :2]) - half, 0.0)
        along = np.maximum(np.maximum(-longer - local[..., 2], local[..., 2] - length - longer), 0.0)
        found = np.minimum(found, np.sqrt((out**2).sum(axis=-1) + along**2))
    return found


def specks(points):
    """A scene of tiny solids at points (k, 3) m."""
    parts = []
    for k, point in enumerate(points):
        mesh = trimesh.creation.box((SPECK,) * 3, transform=trimesh.transformations.translation_matrix(point))
        parts.append(Part(f"speck {k}", np.array(mesh.triangles)))
    return Scene.from_parts(parts)


def way(rng, robot, steps=3, swing=0.06):
    angles = np.cumsum(rng.normal(0, swing, (steps, robot.sections, 2)), axis=0)
    angles += rng.uniform(-0.3, 0.3, (robot.sections, 2))
    return np.clip(angles, -robot.bend_limits, robot.bend_limits), np.cumsum(rng.uniform(0, 0.02, steps))[:, None]


@pytest.mark.parametrize(("width", "height"), [(0.025, 0.05), (0.05, 0.025), (0.02, 0.02), (0.01, 0.15)])
def test_the_lines_cover_the_rectangle_and_stand_out_by_what_is_said(width, height):
    cover = Cover.of(width, height)
    across = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 161) * width, np.linspace(-0.5, 0.5, 161) * height), -1)
    away = np.linalg.norm(across.reshape(-1, 1, 2) - cover.offsets, axis=2)
    assert (away <= cover.radii + 1e-12).any(axis=1).all()
    reach = (np.abs(cover.offsets) + cover.radii[:, None]).max(axis=0)
    np.testing.assert_allclose(reach - np.array([width, height]) / 2, cover.loss, rtol=0, atol=1e-12)
    assert (cover.loss > 0).all()
    assert cover.loss.max() <= 0.15 * min(width, height)
    assert len(cover.radii) % 2 == 1


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("kinds", [("link",) * 4, ("joints", "link", "hinges")])
def test_the_box_is_never_closer_than_certified_and_not_much_farther(seed, kinds):
    """Against the distance of boxes to points, in closed form, at 40 places of every step."""
    rng = np.random.default_rng(seed)
    robot = arm(*kinds, width=rng.uniform(0.026, 0.08), height=rng.uniform(0.026, 0.08))
    base = Slider(np.array([0.1, -0.2, 0.3]), 1.0, 0.0, 0.0)
    if seed % 2 and len(set(kinds)) == 1:
        base = Drum.before(np.zeros(3), robot, 0.3, 0.05, np.eye(3))
    angles, at = way(rng, robot)
    joints = joints_on(base, robot, angles, at)
    places = joints[rng.integers(0, 3, 60), rng.integers(0, robot.sections + 1, 60)] + rng.normal(0, 0.06, (60, 3))
    dense_angles, dense_at = between(angles, 40), between(at, 40)
    away = to_boxes(robot, base, dense_angles, dense_at, places)
    points = places[away.min(axis=0) > 0.008][:8]
    assert len(points) > 3
    scene, line = specks(points), outline(base, robot, joints, at)
    found = section_clearance(scene, robot, line, 1.0)
    exact = to_boxes(robot, base, angles, at, points).min(axis=1)
    assert (found.min(axis=1) <= exact + SPECK).all()
    # Capsules are round at their ends; but for that, they stand out by the loss.
    longer = to_boxes(robot, base, angles, at, points, robot.outline.radii.max()).min(axis=1)
    assert (found.min(axis=1) >= longer - np.hypot(*robot.outline.loss[0]) - SPECK).all()
    seen = to_boxes(robot, base, dense_angles, dense_at, points).min()
    moving = outlined(interpolated_motion(robot, base, at, angles), robot, base)
    proof = certify(moving, robot, scene, line, found, 1.0)
    assert proof.clearance <= seen + SPECK
    lines = outline(base, robot, joints_on(base, robot, dense_angles, dense_at), dense_at)
    dense = section_clearance(scene, robot, lines, 1.0).min()
    assert dense - TIGHTNESS - 1e-4 <= proof.clearance <= dense + 1e-9
    assert proof.clearance > 0


@pytest.mark.parametrize("seed", range(6))
def test_no_vertex_beside_the_centre_line_leaves_its_way_by_more_than_the_bulge(seed):
    rng = np.random.default_rng(seed)
    robot = arm("joints", "link", "hinges", "link", width=0.03, height=0.09)
    base = Slider(np.zeros(3), 1.0, 0.0, 0.0)
    low = rng.uniform(-0.6, 0.6, (1, robot.sections, 2))
    angles = np.concatenate([low, low + rng.uniform(-1, 1, low.shape) * 10 ** rng.uniform(-3, 0)])
    motion = outlined(interpolated_motion(robot, base, np.zeros((2, 1)), angles), robot, base)
    dense = motion.place(between(motion.parameters, 200))[1]
    gone, bulge = motion.travel(Pieces.between(motion.parameters, dense[[0, -1]], np.zeros((2, 0))))
    part = np.linspace(0, 1, len(dense))[:, None, None]
    off = np.linalg.norm(dense - (1 - part) * dense[0] - part * dense[-1], axis=2).max(axis=0)
    assert (off <= bulge[0] + 1e-12).all()
    np.testing.assert_allclose(gone[0], np.linalg.norm(dense[-1] - dense[0], axis=1), rtol=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_gliding_no_vertex_goes_farther_than_is_taken_for_its_way(seed):
    """The length of the way of each vertex, how the links roll included, on paths that leave the plane."""
    rng = np.random.default_rng(seed)
    robot = arm(*("link",) * 5, width=0.03, height=0.08)
    base = Slider(np.array([0.0, 0.0, -robot.length]), robot.length, 0.0, 0.0)
    points = np.cumsum(rng.uniform((-0.03, -0.03, 0.1), (0.03, 0.03, 0.16), (5, 3)), axis=0)
    path = Path.through(np.concatenate([np.zeros((1, 3)), points]), 3, (0.0, 0.0, 1.0)).with_run(robot.length)
    feeds = np.linspace(0.3, 0.312, 4)
    glides = gliding_motion(path, robot, feeds)
    assert glides is not None
    motion = outlined(glides, robot, base)
    parameters, body = motion.place(motion.parameters)
    pieces = Pieces.between(parameters, body, np.zeros((4, 0)))
    taken, bulge = motion.travel(pieces)
    assert (bulge == 0).all()
    fine = np.zeros((181, parameters.shape[1]))
    fine[:, 0] = np.linspace(feeds[0], feeds[-1], 181)
    ways = np.linalg.norm(np.diff(motion.place(fine)[1], axis=0), axis=2).reshape(3, 60, -1).sum(axis=1)
    assert (ways <= taken + 1e-9).all()
    assert robot.outline.lines is not None
    beside = robot.outline.lines.levers > 0
    assert (taken[:, beside] > ways[:, beside]).all()
    assert (taken[:, beside] <= ways[:, beside] + 0.02).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"body_width": None}, "body_width is missing: a flat body has body_width along x and body_height along y"),
        ({"body_height": None}, "body_height is missing"),
        ({"body_width": -0.03}, "body_width"),
        ({"body_width": 0.0}, "body_width"),
        ({"body_diameter": 0.05}, "body_diameter is for a round body; a flat one has body_width and body_height"),
        ({"body": "oval"}, "body 'oval' is unknown; there are round, flat"),
        ({"body": "round"}, "body_diameter is missing, as the body is round"),
        ({"body": "round", "body_diameter": 0.05}, 'body_width is for a body that is flat: give body = "flat", too'),
        ({"body_width": 1.5}, "is 30 times as wide as it is high, expected less than 20"),
        ({"cable_radius": 0.018, "body_width": 0.03}, "cable_radius 18 mm lies outside the body of 30 by 50 mm at the"),
        ({"kind": "arc", "half_lengths": None}, "a flat body is known of straight pieces, and a section of kind 'arc'"),
    ],
)
def test_what_contradicts_a_flat_body_is_said(changes, words):
    with pytest.raises(ValidationError) as error:
        RobotSpec.model_validate(robot_file(sections=(section(**{**FLAT, **changes}),)))
    assert words in str(error.value)


def test_cables_of_later_sections_stay_within_a_flat_one_before_them():
    flat, round_ = section(**FLAT), section(cable_radius=0.021)
    with pytest.raises(ValidationError, match="the cables of group 2 run through group 1, too, but their cable_radius"):
        RobotSpec.model_validate(robot_file(sections=(flat, round_)))
    assert RobotSpec.model_validate(robot_file(sections=(round_, flat)))


def test_a_round_body_is_its_own_outline():
    robot = Robot.from_spec(RobotSpec.model_validate(robot_file()))
    assert not robot.outline.flat
    assert robot.outline.radii is robot.chord_radii
    np.testing.assert_array_equal(robot.outline.inner_radii, robot.body_radii)


@pytest.mark.parametrize("seed", range(6))
def test_what_calibration_takes_of_hinges_and_stacks_bounds_what_finite_differences_say(seed):
    """Angles off by their standard deviations spread each vertex by no more than is taken, flat or round."""
    rng = np.random.default_rng(seed)
    robot = arm("joints", "hinges", "link", "joints", width=0.03, height=0.09)
    if seed % 2:
        round_ = section(kind="hinges", **KINDS["hinges"])
        stack = section(kind="joints", half_lengths=(0.006, 0.006), **KINDS["joints"])
        robot = Robot.from_spec(RobotSpec.model_validate(robot_file(sections=(round_, stack))))
    base, at = Slider(np.array([0.1, 0.0, -0.2]), 1.0, 0.0, 0.0), np.zeros((1, 1))
    angles, sigma = rng.uniform(-0.6, 0.6, (robot.sections, 2)), rng.uniform(0.001, 0.003, robot.sections)
    spec = ToleranceSpec.model_validate({"calibration_deg": tuple(np.degrees(sigma))})
    budget = Budget.of(spec, robot, base.start)
    assert budget is not None

    def body(angles):
        return outline(base, robot, joints_on(base, robot, angles[None], at), at)[0]

    step, columns = 1e-6, []
    for i, k in np.ndindex(robot.sections, 2):
        off = np.zeros_like(angles)
        off[i, k] = step
        columns.append(sigma[i] * (body(angles + off) - body(angles - off)) / (2 * step))
    columns = np.array(columns).transpose(1, 2, 0)
    spread = np.linalg.svd(columns, compute_uv=False)[:, 0]
    taken = budget.spread(body(angles)[None])[0]
    assert (spread <= taken + 1e-9).all()
    assert (taken <= 2.0 * spread + 1e-3).all()

    line, chords = body(angles), np.flatnonzero(robot.outline.radii)
    away = rng.normal(size=(len(chords), 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    zero = np.zeros(len(chords), np.int64)
    near = Near(zero, robot.outline.sections[chords], chords, line[chords + 1], away, np.zeros(len(chords)))
    joints = joints_on(base, robot, angles[None], at)
    motion: Any = SimpleNamespace(
        robot=robot, task=SimpleNamespace(base=base), angles=angles[None], at=at, body=joints,
        centre_line=centre_line(base, robot, joints, at),
    )  # fmt: skip
    found = gradients(motion, budget, near)[:, 6:]
    np.testing.assert_allclose(found, np.einsum("qxe,qx->qe", columns[chords + 1], away), rtol=0, atol=1e-9)


def test_a_flat_body_is_drawn_as_its_box():
    robot = arm("link", "link", width=0.03, height=0.06)
    base, at, angles = Slider(np.zeros(3), 1.0, 0.0, 0.0), np.zeros((1, 1)), np.array([[[0.2, -0.1], [0.3, 0.4]]])
    joints = joints_on(base, robot, angles, at)
    body = outline(base, robot, joints, at)[0]
    assert robot.outline.lines is not None
    axes = robot.outline.lines.axes(body)
    drawn = link_bodies(joints[0], robot.body_radii, 0.5 * robot.outline.sides[:, :, None] * axes)
    places, turns, scales = bodies(robot, joints[0], body, robot.body_radii)
    for (i, place, frame, length), quaternion in zip(boxes(robot, base, angles, at), turns, strict=True):
        local = (drawn[i].reshape(-1, 3) - place[0]) @ frame[0]
        np.testing.assert_allclose(local.min(axis=0), [-0.015, -0.03, 0.0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(local.max(axis=0), [0.015, 0.03, length], rtol=0, atol=1e-12)
        np.testing.assert_allclose(Rotation.from_quat(quaternion, scalar_first=True).as_matrix(), frame[0], atol=1e-12)
        np.testing.assert_allclose(scales[i], [0.015, 0.03, length], rtol=0, atol=1e-12)
        np.testing.assert_allclose(places[i], place[0], rtol=0, atol=1e-12)


def test_models_for_other_programs_have_the_box_and_its_inertia():
    robot = arm("link", "link", width=0.03, height=0.06)
    spec = mjcf(Subject(robot))[0]
    model = mj.MjModel.from_xml_string(ElementTree.tostring(spec, encoding="unicode"))
    found = [model.geom_size[k] for k in range(model.ngeom) if model.geom_type[k] == mj.mjtGeom.mjGEOM_BOX]
    np.testing.assert_allclose(found, [[0.015, 0.03, length / 2] for length in robot.link_lengths], rtol=1e-9)
    mesh = trimesh.creation.box((0.03, 0.06, robot.pitches[0]))
    mesh.density = robot.link_masses[0] / mesh.volume
    found = link_inertia(robot, 0, float(robot.link_masses[0]), float(robot.pitches[0]))
    np.testing.assert_allclose(found, np.diag(mesh.moment_inertia), rtol=1e-9)


def test_what_is_lost_at_the_ends_is_said_beside_the_sides():
    # A round group of 60 mm beside the flat one loses nothing, whatever its radius.
    flat = section(body="flat", body_width=0.025, body_height=0.05, body_diameter=None, cable_radius=0.01)
    words = robot_of([section(body_diameter=0.06), flat]).outline.loss_words
    assert f"by up to {1e3 * Cover.of(0.025, 0.05).radii.max():.2f} mm at its ends" in words
    assert robot_of([section(body_diameter=0.06)]).outline.loss_words == ""
