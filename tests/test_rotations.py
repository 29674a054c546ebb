"""Rotations say the same in all ways of saying them, and as SciPy does."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hognose.rotations import (
    degrees_of_rotation,
    quaternion_of_rotation,
    rotation_of_degrees,
    rotations_of_vectors,
    shortest_turn,
    vector_of_rotation,
)

SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-720.0, 720.0)
#: The rotations that take a cube to itself: of many of them, parts of the quaternion are equally large, or 0.
OF_A_CUBE = Rotation.create_group("O").as_matrix().round()


@given(st.tuples(ANGLES, ANGLES, ANGLES))
def test_angles_are_about_fixed_axes_x_first(angles):
    expected = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    np.testing.assert_allclose(rotation_of_degrees(angles), expected, rtol=0, atol=1e-14)


@given(st.floats(-180.0, 180.0), st.sampled_from([None, 90.0, -90.0, 90.0 - 1e-7, -90.0 + 1e-12]), SEEDS)
def test_a_rotation_is_that_of_the_degrees_that_are_said_of_it(about_x, about_y, seed):
    random = np.random.default_rng(seed)
    about_y = random.uniform(-90.0, 90.0) if about_y is None else about_y
    R = Rotation.from_euler("xyz", [about_x, about_y, random.uniform(-180.0, 180.0)], degrees=True).as_matrix()
    said = degrees_of_rotation(R)
    np.testing.assert_allclose(rotation_of_degrees(said), R, rtol=0, atol=1e-13)
    assert abs(said[1]) <= 90.0


@given(SEEDS)
def test_vectors_are_the_axis_times_the_angle(seed):
    vectors = np.random.default_rng(seed).normal(size=(5, 3))
    vectors[0] = 0.0
    vectors *= np.minimum(1.0, 3.1 / np.maximum(np.linalg.norm(vectors, axis=1), 1e-9))[:, None]
    found = rotations_of_vectors(vectors)
    np.testing.assert_allclose(found, Rotation.from_rotvec(vectors).as_matrix(), rtol=0, atol=1e-14)
    np.testing.assert_allclose([vector_of_rotation(R) for R in found], vectors, rtol=0, atol=1e-13)


@given(SEEDS)
def test_a_quaternion_is_that_of_its_rotation_and_has_a_positive_largest_part(seed):
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    said = quaternion_of_rotation(R)
    np.testing.assert_allclose(Rotation.from_quat(np.roll(said, -1)).as_matrix(), R, rtol=0, atol=1e-14)
    assert said[np.argmax(np.abs(said))] == pytest.approx(np.abs(said).max())


@given(st.integers(0, len(OF_A_CUBE) - 1), SEEDS)
def test_rounding_does_not_turn_the_sign_of_a_quaternion(which, seed):
    R = OF_A_CUBE[which]
    noise = np.random.default_rng(seed).uniform(-1e-13, 1e-13, (3, 3))
    said = quaternion_of_rotation(R)
    np.testing.assert_allclose(quaternion_of_rotation(R + noise), said, rtol=0, atol=1e-12)
    np.testing.assert_allclose(Rotation.from_quat(np.roll(said, -1)).as_matrix(), R, rtol=0, atol=1e-14)


@given(SEEDS)
def test_a_direction_is_turned_to_the_shortest_way(seed):
    direction = np.random.default_rng(seed).normal(size=3)
    turned = shortest_turn(direction)
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(turned[:, 2], direction / np.linalg.norm(direction), atol=1e-14)
    assert abs(Rotation.from_matrix(turned).as_rotvec()[2]) < 1e-9  # no turn about +z


@pytest.mark.parametrize("direction", np.concatenate([np.eye(3), -np.eye(3)]).tolist())
def test_a_direction_along_an_axis_is_exact(direction):
    np.testing.assert_array_equal(shortest_turn(np.array(direction))[:, 2], direction)
