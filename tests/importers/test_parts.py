"""Inertias that are put together and taken apart, and numbers and rotations as they are written."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sigmafmu.importers.inertia import Inertia, Pose, nearest_possible, rod
from sigmafmu.importers.write import number, orientation
from sigmafmu.importers.xml import axes_with_z
from sigmafmu.mechanism_file import tree
from sigmafmu.mechanism_file.kinds import Context
from sigmafmu.mechanism_file.problems import Problems
from sigmafmu.mechanism_file.rotations import matrix, of_orientation
from sigmafmu.mechanism_file.table.ends import ORIENTATION

RNG = np.random.default_rng(1)
SAME = settings(max_examples=200, derandomize=True, deadline=None, database=None)
angles = st.sampled_from([0, np.pi / 2, -np.pi / 2, np.pi, np.pi / 6, 1.5708, 3.14159, -0.785398]) | st.floats(-4, 4)


def points(count=30):
    """Masses and places of a cloud."""
    return RNG.uniform(0.1, 2, count), RNG.normal(size=(count, 3))


def inertia_of(masses, places):
    center = masses @ places / masses.sum()
    d = places - center
    return Inertia(
        masses.sum(),
        center,
        np.einsum("i,ijk", masses, (d**2).sum(1)[:, None, None] * np.eye(3) - d[:, :, None] * d[:, None, :]),
    )


def assert_same(a, b):
    assert a.mass == pytest.approx(b.mass, rel=1e-13)
    np.testing.assert_allclose(a.center, b.center, rtol=0, atol=1e-13)
    np.testing.assert_allclose(a.J, b.J, rtol=0, atol=1e-12 * np.abs(b.J).max())


def test_inertias_of_clouds_of_points():
    masses, places = points()
    whole, part = inertia_of(masses, places), inertia_of(masses[:9], places[:9])
    assert_same(part + inertia_of(masses[9:], places[9:]), whole)
    assert_same(whole - part, inertia_of(masses[9:], places[9:]))
    pose = Pose(np.array([1.0, 2, 3]), Rotation.random(random_state=1).as_matrix())
    assert_same(whole.seen_from(pose), inertia_of(masses, pose.p + places @ pose.R.T))
    assert_same(whole.seen_from(pose).seen_from(pose.inverse()), whole)


def test_a_rod_is_many_points_on_a_line():
    axis, middle = np.array([2.0, -1, 2]) / 3, np.array([0.3, 0.2, 0.1])
    s = (np.arange(2000) + 0.5) / 2000 - 0.5
    cloud = inertia_of(np.full(2000, 3 / 2000), middle + 0.7 * s[:, None] * axis)
    np.testing.assert_allclose(rod(3, 0.7, middle, axis).J, cloud.J, atol=1e-6 * 3 * 0.7**2)


@pytest.mark.parametrize("moments", [(0.1, 0.1, 0.5), (-0.1, 0.2, 0.3), (0, 0, 1), (1, 1, 1), (0, 1, 1)])
def test_the_nearest_inertia_that_a_body_can_have(moments):
    R = Rotation.random(random_state=2).as_matrix()
    J = R @ np.diag(moments) @ R.T
    found = nearest_possible(J)
    assert Inertia(1, np.zeros(3), found).is_possible()
    if Inertia(1, np.zeros(3), J).is_possible() and min(moments) > 0:
        np.testing.assert_allclose(found, J, atol=1e-5)
    assert np.linalg.eigvalsh(found)[2] == pytest.approx(max(moments))


def read_orientation(text: str) -> np.ndarray:
    if not text:
        return np.eye(3)
    problems = Problems("some.yaml")
    record = ORIENTATION.read(tree.parse(text, "some.yaml"), "", Context(problems))
    problems.stop()
    return matrix(of_orientation(record))


@SAME
@given(roll=angles, pitch=angles, yaw=angles)
def test_rotations_are_read_back(roll, pitch, yaw):
    R = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    np.testing.assert_allclose(read_orientation(orientation(R)), R, rtol=0, atol=1e-14)


@SAME
@given(axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 1e-3))
def test_axes_have_the_direction_as_z(axis):
    R = axes_with_z(np.array(axis))
    np.testing.assert_allclose(R[:, 2], np.array(axis) / np.linalg.norm(axis), rtol=0, atol=1e-15)
    np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-15)
    assert np.linalg.det(R) > 0


def test_rotations_are_written_as_short_as_they_can():
    def written(*rpy):
        return orientation(Rotation.from_euler("xyz", rpy).as_matrix())

    assert written(0, 0, 0) == ""
    assert written(0, np.pi / 2, 0) == '{ rotation_vector: [0, "90 deg", 0] }'
    assert written(np.pi / 2, 0, np.pi / 2) == '{ rpy: ["90 deg", 0, "90 deg"] }'
    assert written(0.1, 0.2, 0.3) == "{ rpy: [0.1, 0.2, 0.3] }"
    assert written(0, 1.5708, 0).startswith("{ r")


@SAME
@given(x=st.floats(-1e30, 1e30))
def test_numbers_are_numbers_in_yaml(x):
    import yaml

    found = yaml.safe_load(number(x))
    assert isinstance(found, int | float)
    assert found == pytest.approx(x, rel=1e-14, abs=0)
    assert json.loads(number(x)) == found


@pytest.mark.parametrize(
    ("x", "text"), [(0.1 + 0.2, "0.3"), (-0.0, "0"), (5e-5, "5.0e-05"), (2.0, "2"), (1e9, "1000000000.0")]
)
def test_numbers_are_short(x, text):
    assert number(x) == text
