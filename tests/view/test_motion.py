"""Frames of an animation: dense enough, true to the result, and small."""

import base64
import zlib

import numpy as np
import pytest

from sigmafmu import SigmafmuError
from sigmafmu.contents.layout import Layout
from sigmafmu.result import Result, Statistics
from sigmafmu.view import rotations
from sigmafmu.view.motion import FRAMES, MOST_TURN, motion_of
from sigmafmu.view.packed import Packed

BODY = {"name": "top", "mass": 1.0, "inertia": {"xx": 1.0, "yy": 1.0, "zz": 1.0}}


@pytest.fixture
def layout(tmp_path):
    return Layout({"bodies": [BODY]}, tmp_path)


def spinning(time, w, *, with_rate=True):
    """A body on a circle that spins with the constant angular velocity w, as a result."""
    q = rotations.exponential(np.outer(time, w))
    position = np.column_stack([np.cos(time), np.sin(time), 0 * time])
    values, names = [position, q], [f"top.position[{i}]" for i in (1, 2, 3)]
    names += [f"top.quaternion[{i}]" for i in (1, 2, 3, 4)]
    if with_rate:
        values.append(np.tile(w, (len(time), 1)))
        names += [f"top.angularVelocity[{i}]" for i in (1, 2, 3)]
    return Result("Top", time, tuple(names), np.column_stack(values), Statistics(1.0, 1.0, len(time) - 1))


def angles(p, q):
    return np.linalg.norm(rotations.logarithm(rotations.product(rotations.conjugate(p), q)), axis=1)


def test_rotations_agree_with_rodrigues():
    rng = np.random.default_rng(1)
    psi = rng.normal(size=(20, 3))
    for x, q in zip(psi, rotations.exponential(psi), strict=True):
        angle, hat = np.linalg.norm(x), -np.cross(np.eye(3), x).T
        R = np.eye(3) + np.sin(angle) / angle * hat + (1 - np.cos(angle)) / angle**2 * hat @ hat
        np.testing.assert_allclose(rotations.matrix(q), R, atol=1e-14)
        np.testing.assert_allclose(np.abs(q @ rotations.of_matrix(R)), 1, atol=1e-14)
    small = psi / np.linalg.norm(psi, axis=1, keepdims=True) * rng.uniform(0, 3.1, (20, 1))
    np.testing.assert_allclose(rotations.logarithm(rotations.exponential(small)), small, atol=1e-13)


def test_a_slow_motion_keeps_rows_of_the_result(layout):
    time = np.linspace(0, 2, 4001)
    result = spinning(time, np.array([0.0, 0.3, 1.0]))
    motion = motion_of(result, layout, ["top.position[1]"])
    assert FRAMES <= len(motion.time) < 2 * FRAMES
    rows = np.searchsorted(time, motion.time - 1e-12)
    assert (time[rows] == motion.time).all()
    assert motion.time[-1] == 2
    assert (motion.bodies["top"].position == result["top.position"][rows]).all()
    assert (motion.columns["top.position[1]"] == result["top.position[1]"][rows]).all()


@pytest.mark.parametrize("turn", [0.7, 3.0, 6.0, 20.0, 200.0])
def test_a_fast_spin_is_resolved(layout, turn):
    """Frames between rows are those of the true motion, even if a body turns many times from row to row."""
    time = np.linspace(0, 1, 41)
    w = turn / time[1] * np.array([0.6, 0.0, 0.8])
    motion = motion_of(spinning(time, w), layout, ())
    q = motion.bodies["top"].quaternion
    assert angles(q[:-1], q[1:]).max() < 1.001 * MOST_TURN
    assert ((q[1:] * q[:-1]).sum(axis=1) > 0).all()
    assert angles(q, rotations.exponential(np.outer(motion.time, w))).max() < 1e-9
    circle = np.column_stack([np.cos(motion.time), np.sin(motion.time), 0 * motion.time])
    assert np.abs(motion.bodies["top"].position - circle)[len(q) // 40 : -len(q) // 40].max() < 1e-6


def test_without_rates_the_shortest_arc_is_taken(layout):
    time = np.linspace(0, 1, 41)
    w = 3.0 / time[1] * np.array([0.0, 0.0, 1.0])
    q = motion_of(spinning(time, w, with_rate=False), layout, ()).bodies["top"].quaternion
    assert angles(q[:-1], q[1:]).max() < 1.001 * MOST_TURN


def test_a_result_without_poses_is_refused(layout):
    result = Result("Top", np.zeros(2), ("energy.total",), np.zeros((2, 1)), Statistics(1.0, 1.0, 1))
    with pytest.raises(SigmafmuError, match=r"no top\.position\[1\]: to see a mechanism, record `position`"):
        motion_of(result, layout, ())


def test_packed_numbers_come_back():
    rng = np.random.default_rng(2)
    arrays = [np.cumsum(rng.normal(size=(500, 3)), axis=0), rng.normal(size=40), np.full((7, 2), 3.5), np.arange(9.0)]
    steps = [1e-6, None, None, 1.0]
    packed = Packed()
    tickets = [packed.add(array, step) for array, step in zip(arrays, steps, strict=True)]
    data = zlib.decompress(base64.b64decode(packed.text()))
    for array, step, ticket in zip(arrays, steps, tickets, strict=True):
        columns = array.reshape(len(array), -1).T
        count = columns.size
        planes = np.frombuffer(data, np.uint8, 4 * count, ticket["at"]).reshape(4, count).astype(np.int64)
        zigzag = (planes * 256 ** np.arange(4)[:, None]).sum(axis=0)
        whole = np.where(zigzag % 2, -(zigzag + 1) // 2, zigzag // 2).reshape(columns.shape).cumsum(axis=1)
        back = np.array(ticket["bias"])[:, None] + np.array(ticket["step"])[:, None] * whole
        tolerance = 0.51 * step if step else 0.51 * np.ptp(columns, axis=1).max() / 65535
        assert np.abs(back - columns).max() <= tolerance


def test_ten_seconds_of_thirty_bodies_are_small():
    """Their poses and 100 curves: less than 1 MB, of the 3 MB that a page with its viewer may have."""
    time = np.linspace(0, 10, 601)
    rng = np.random.default_rng(3)
    packed = Packed()
    for _ in range(30):
        phase = np.outer(time, rng.uniform(1, 6, 3)) + rng.uniform(0, 6, 3)
        packed.add(np.sin(phase), 1e-6)
        packed.add(rotations.exponential(2 * np.cos(phase)), 1 / 32767)
    for _ in range(100):
        packed.add(np.sin(rng.uniform(1, 20) * time))
    assert len(packed.text()) < 1e6
