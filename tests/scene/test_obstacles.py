import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError
from scene_oracles import KINDS, contains, mesh_area, mesh_volume, random_obstacle, surface_points

from hognose.errors import InputError
from hognose.scene import Board, Box, Cylinder, FaceHole, Hole, Obstacle, Pipe, Scene, Sphere, Tank
from hognose.scene.part import Part

seeds = st.integers(0, 2**32 - 1)
ellipse = math.pi / 4


def volume(item):
    """The closed form; only for holes that do not overlap."""
    if isinstance(item, Sphere):
        return math.pi / 6 * item.diameter**3
    if isinstance(item, Cylinder):
        return ellipse * item.diameter**2 * math.dist(item.start, item.end)
    if isinstance(item, Pipe):
        bore = item.diameter - 2 * item.wall
        return ellipse * (item.diameter**2 - bore**2) * math.dist(item.start, item.end)
    if isinstance(item, Box):
        return math.prod(item.size)
    holes = sum(ellipse * math.prod(hole.diameters or (hole.diameter,) * 2) for hole in item.hole)
    if isinstance(item, Board):
        return (math.prod(item.size) - holes) * item.thickness
    return math.prod(item.size) - math.prod(edge - 2 * item.wall for edge in item.size) - holes * item.wall


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds)
@settings(max_examples=15, deadline=None)
def test_mesh_is_watertight_and_wound_outwards(kind, seed):
    triangles = random_obstacle(kind, np.random.default_rng(seed)).triangles()
    corners, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    # Corners are shared exactly, not nearly: no two distinct ones are closer than a hair.
    index = index.reshape(-1, 3)
    directed = Counter((int(a), int(b)) for t in index for a, b in zip(t, np.roll(t, -1), strict=True))
    assert all(times == 1 and directed[b, a] == 1 for (a, b), times in list(directed.items()))
    assert mesh_volume(triangles) > 0
    assert len(corners) >= 4


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds, tolerance=st.sampled_from([1e-3, 1e-4]))
@settings(max_examples=15, deadline=None)
def test_mesh_contains_the_solid_and_little_more(kind, seed, tolerance):
    rng = np.random.default_rng(seed)
    item = random_obstacle(kind, rng)
    scene = Scene.from_obstacles([item], tolerance)
    on_mesh, normal = surface_points(scene.triangles, rng, 300)
    offset = rng.choice([-1, 1], (300, 1)) * 10.0 ** rng.uniform(-9, -2, (300, 1))
    around = rng.uniform(scene.bounds[0, 0], scene.bounds[0, 1], (300, 3))
    corners = rng.choice(scene.triangles.reshape(-1, 3), 300)
    points = np.concatenate([on_mesh, on_mesh + offset * normal, around, corners])

    in_mesh = scene.inside(points) == 0
    on_mesh_too = scene.distance(points, points).value <= 1e-12
    assert np.all((in_mesh | on_mesh_too)[contains(item, points)])

    allowed = tolerance
    if isinstance(item, Sphere):
        allowed = max(tolerance, 0.0012 * item.diameter / 2)
    assert contains(item, points[in_mesh | on_mesh_too], allowed * (1 + 1e-9) + 1e-12).all()


@pytest.mark.parametrize(
    "item",
    [
        Sphere(center=(1, 2, 3), diameter=0.08),
        Cylinder(start=(0, 0, 0), end=(0.1, 0.2, 0.3), diameter=0.05),
        Pipe(start=(0, 0, 0), end=(0, 0, -0.5), diameter=0.05, wall=0.004),
        Box(center=(1, 0, 0), size=(0.1, 0.2, 0.3), rotation_deg=(10, 20, 30)),
        Board(
            center=(0, 1, 0),
            normal=(1, 1, 0),
            up=(0, 0, 1),
            size=(0.5, 0.4),
            thickness=0.01,
            hole=(
                Hole(center=(-0.1, 0), diameter=0.1),
                Hole(center=(0.1, 0.1), diameters=(0.1, 0.06), angle_deg=30),
            ),
        ),
        Tank(
            center=(0, 0, 1),
            size=(0.5, 0.6, 0.7),
            wall=0.02,
            hole=tuple(
                FaceHole(face=face, center=(0.05, -0.1), diameters=(0.08, 0.12), angle_deg=20)
                for face in ("-x", "+x", "-y", "+y", "-z", "+z")
            ),
        ),
    ],
    ids=KINDS,
)
def test_mesh_volume_tends_to_the_closed_form_from_above(item):
    for tolerance in (1e-3, 1e-4):
        triangles = item.triangles(tolerance)
        excess = mesh_volume(triangles) - volume(item)
        assert -1e-15 < excess <= tolerance * mesh_area(triangles) + 1e-15


def test_a_board_is_where_its_frame_says():
    board = Board(center=(1, 2, 3), normal=(0, 0, -2), up=(0, 3, 1), size=(0.4, 0.2), thickness=0.02)
    np.testing.assert_allclose(board.frame, [[-1, 0, 0], [0, 1, 0], [0, 0, -1]], atol=1e-15)
    corners = board.triangles().reshape(-1, 3)
    np.testing.assert_allclose(corners.min(axis=0), [0.8, 1.9, 2.99], atol=1e-15)
    np.testing.assert_allclose(corners.max(axis=0), [1.2, 2.1, 3.01], atol=1e-15)


def test_a_file_gives_lengths_in_its_unit_and_holes_as_tables():
    item = TypeAdapter(Obstacle).validate_python(
        {
            "kind": "board",
            "center": [0, 0, 300],
            "size": [600, 600],
            "thickness": 10,
            "hole": [{"center": [10, 0], "diameter": 100}],
        },
        context={"metres_per_unit": 1e-3},
    )
    assert item == Board(
        center=(0, 0, 0.3), size=(0.6, 0.6), thickness=0.01, hole=(Hole(center=(0.01, 0), diameter=0.1),)
    )


board = {"kind": "board", "center": (0, 0, 0), "size": (0.2, 0.1), "thickness": 0.01}
tank = {"kind": "tank", "center": (0, 0, 0), "size": (0.2, 0.3, 0.4), "wall": 0.01}
straight = {"start": (0, 0, 0), "end": (0, 0, 1), "diameter": 0.1}


@pytest.mark.parametrize(
    ("given_as", "complaint"),
    [
        ({"kind": "cone"}, "does not match any of the expected tags"),
        ({"kind": "sphere", "center": (0, 0, 0), "diameter": 0}, "greater than 0"),
        ({"kind": "sphere", "center": (0, 0, math.nan), "diameter": 1}, "finite"),
        ({"kind": "sphere", "center": (0, 0), "diameter": 1}, "Field required"),
        ({"kind": "sphere", "center": (0, 0, 0), "radius": 1}, "Extra inputs are not permitted"),
        ({"kind": "sphere", "center": (0, 0, 0), "diameter": 1, "name": ""}, "at least 1 character"),
        ({"kind": "cylinder", **straight, "end": (0, 0, 0)}, "start and end of the cylinder are the same"),
        ({"kind": "pipe", **straight, "wall": 0.01, "end": (0, 0, 0)}, "start and end of the pipe"),
        (
            {"kind": "pipe", **straight, "wall": 0.05},
            "wall of 50 mm must be less than half its outer diameter",
        ),
        ({**board, "normal": (0, 0, 0)}, "is zero; it must be a direction"),
        ({**board, "up": (0, 0, 0)}, "is zero; it must be a direction"),
        ({**board, "normal": (0, -2, 0)}, "parallel to its normal"),
        ({**board, "hole": [{"center": (0, 0)}]}, "here it has neither"),
        ({**board, "hole": [{"center": (0, 0), "diameter": 0.01, "diameters": (0.1, 0.1)}]}, "it has both"),
        (
            {**board, "hole": [{"center": (0.06, 0), "diameter": 0.08}]},
            "hole 1 of the board does not lie inside",
        ),
        (
            {**board, "hole": [{"center": (0, 0), "diameters": (0.15, 0.01), "angle_deg": 90}]},
            "hole 1 of the board does not lie inside 200 mm × 100 mm",
        ),
        ({**tank, "wall": 0.1}, "wall of 100 mm must be less than half its smallest size"),
        ({**tank, "hole": [{"face": "up", "center": (0, 0), "diameter": 0.1}]}, "'-x', '\\+x'"),
        (
            {**tank, "hole": [{"face": "-y", "center": (0.08, 0), "diameter": 0.03}]},
            "seen from within face -y, does not lie inside 180 mm × 380 mm",
        ),
    ],
)
def test_what_cannot_be_is_refused(given_as, complaint):
    with pytest.raises(ValidationError, match=complaint):
        TypeAdapter(Obstacle).validate_python(given_as)


magnitudes = st.integers(-320, 300).map(lambda power: float(f"1e{power}")) | st.floats(5e-324, 1e300)
parts = st.tuples(*[st.floats(-1, 1)] * 3)


@given(size=magnitudes, along=parts, key=st.sampled_from(["normal", "up"]))
def test_a_direction_of_any_length_is_right_or_refused(size, along, key):
    plain = {"center": (0, 0, 0), "size": (0.2, 0.1), "thickness": 0.01}
    direction = tuple(size * part for part in along)
    try:
        made = Board.model_validate({**plain, key: direction})
    except ValidationError as error:
        said = str(error)
        if not any(words in said for words in ("is zero", "has a length of", "parallel to its normal")):
            raise
        return
    np.testing.assert_allclose(made.frame @ made.frame.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(made.triangles()).sum() / 6 == pytest.approx(0.2 * 0.1 * 0.01)
    assert np.dot(made.frame[:, 2], made.normal) == pytest.approx(np.linalg.norm(made.normal))


SIZES = {
    "sphere": {"kind": "sphere", "center": (0, 0, 0.3), "diameter": "?"},
    "cylinder": {"kind": "cylinder", "start": (0, 0, 0), "end": (0, 0, 0.1), "diameter": "?"},
    "short cylinder": {"kind": "cylinder", "start": (0, 0, 0), "end": (0, 0, "?"), "diameter": 0.1},
    "slanted pipe": {"kind": "pipe", "start": (0, 0, 0), "end": ("?", "?", 0), "diameter": 0.1, "wall": 0.01},
    "thin pipe": {"kind": "pipe", "start": (0, 0, 0), "end": (0, 0.1, 0.1), "diameter": 0.1, "wall": "?"},
    "box": {"kind": "box", "center": (0, 0, 0.3), "size": ("?", 0.1, "?")},
    "thin board": {"kind": "board", "center": (0, 0, 0.3), "size": (0.1, 0.1), "thickness": "?"},
    "narrow board": {"kind": "board", "center": (0, 0, 0.3), "size": ("?", 0.1), "thickness": 0.01},
    "tank": {"kind": "tank", "center": (0, 0, 0.3), "size": (0.1, 0.1, 0.1), "wall": "?"},
    "wide tank": {"kind": "tank", "center": (0, 0, 0.3), "size": ("?", "?", "?"), "wall": 1e-9},
}


def filled(value, size):
    if isinstance(value, dict):
        return {key: filled(item, size) for key, item in value.items()}
    if isinstance(value, tuple):
        return tuple(filled(item, size) for item in value)
    return size if value == "?" else value


@pytest.mark.parametrize("kind", list(SIZES))
@given(size=magnitudes)
@settings(max_examples=60, deadline=None)
def test_a_size_of_any_magnitude_is_there_or_refused(kind, size):
    """Nothing vanishes: what is taken is met by who comes from far away."""
    try:
        made = TypeAdapter(Obstacle).validate_python(filled(SIZES[kind], size))
        scene = Scene.from_obstacles([made])
    except (ValidationError, InputError):
        return
    assert np.isfinite(scene.triangles).all()
    assert len(scene.triangles) >= 12
    far = min(3.0 * scene.bounds[:, 1].max() + 1.0, 9_999.0)  # no farther than lengths may be
    start = np.array([[far, 0.9 * far, 0.8 * far]])
    corners = np.linalg.norm(scene.triangles.reshape(-1, 3) - start, axis=1)
    found = scene.distance(start, start).value[0]
    assert found <= corners.min() * (1 + 1e-9)
    assert found >= corners.min() - np.linalg.norm(scene.bounds[0, 1] - scene.bounds[0, 0])


def test_a_scene_has_no_triangle_that_is_not_finite():
    triangles = np.zeros((2, 3, 3))
    triangles[1, 2, 0] = np.nan
    with pytest.raises(InputError, match=r'1 of the 2 triangles of "ghost" have corners that are not finite'):
        Scene.from_parts([Part("ghost", triangles)])
    with pytest.raises(InputError, match='nothing is left of "ghost" in rounding'):
        Scene.from_parts([Part("ghost", np.empty((0, 3, 3)))])
