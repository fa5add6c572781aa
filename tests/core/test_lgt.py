"""Local-global transition maps: one suite of invariants for every group × coordinate map × absolute coordinates.

Expected values are those of `exact_groups`: 50 digits, from definitions.
"""

from dataclasses import dataclass

import mpmath as mp
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sigmafmu._core import lie

from . import exact_groups
from .exact_groups import CHARTS, Chart
from .helpers import EPS, exact, property_test, rounded, vectors

ANGLES = [1e-12, 1e-4, 0.5, 3.0, np.pi - 1e-6, np.pi, 4.0]  # rad; the Cayley map ends before pi
LENGTHS = [
    0.0,
    5e-324,
    1e-310,  # subnormal
    1e-160,  # the square underflows
    1e-12,
    1e-8,
    0.1,
    float(np.nextafter(1.0, 0.0)),  # the series ends at 1
    1.0,
    3.0,
    2 * np.pi - 1e-3,  # T of the exponential is nearly singular
    30.0,
]
DIRECTIONS = [np.array(d) for d in ([1 / 3, 2 / 3, -2 / 3], [0, -1.0, 0], [-0.48, 0.6, 0.64])]
TRANSLATIONS = [np.array(y) for y in ([0.3, -2.0, 1.1], [0.0, 0.0, 0.0], [1e3, -1e-3, 5e2])]
IDENTITY = np.array([0.0, 0, 0, 1, 0, 0, 0])


def length_of(angle: float, coordinates: str) -> float:
    """|x| of a rotation by an angle."""
    return {"exp": angle, "cayley": 2 * np.tan(angle / 2), "cayley2": 4 * np.tan(angle / 4)}[coordinates]


def lengths(coordinates: str) -> list[float]:
    largest = np.pi - 1e-7 if coordinates == "cayley" else np.inf
    return LENGTHS + [length_of(angle, coordinates) for angle in ANGLES if angle <= largest]


def nasty(coordinates: str) -> list[np.ndarray]:
    """Every length with some direction and some translation."""
    return [
        np.concatenate([TRANSLATIONS[i % 3], length * DIRECTIONS[(i // 3) % 3]])
        for i, length in enumerate(lengths(coordinates))
    ]


def unit(vector):
    length = np.linalg.norm(vector)
    return vector / length if length > 0.1 else DIRECTIONS[0]


LARGEST = {"exp": 6.2, "cayley": 3.1, "cayley2": 6.2}
"""Rotation angles [rad] of drawn coordinates: past π where the map goes that far, short of where T is singular."""


def local_coordinates(coordinates, angle=None):
    """X with rotations up to an angle and translations up to 10 m."""
    longest = length_of(angle or LARGEST[coordinates], coordinates)
    known = st.sampled_from([t for t in lengths(coordinates) if t <= longest])
    x = st.builds(lambda t, n: t * unit(n), st.one_of(known, st.floats(0.0, longest)), vectors(1.0))
    return st.builds(lambda y, x: np.concatenate([y, x]), vectors(10.0), x)


every_chart = pytest.mark.parametrize("chart", CHARTS, ids=str)
every_nasty_point = pytest.mark.parametrize(
    ("chart", "X"), [pytest.param(c, X, id=f"{c}-{X}") for c in CHARTS for X in nasty(c.map)]
)
w0 = np.array([0.7, -0.2, 1.3, 0.9, -0.4, 2.2])


def over_charts(examples, *kinds, **strategies):
    """A property for every chart; `kinds` name arguments that are local coordinates of it."""

    def decorate(check):
        @every_chart
        def test(chart):
            drawn = strategies | {kind: local_coordinates(chart.map) for kind in kinds}

            def run(**arguments):
                check(chart, **arguments)

            property_test(examples, **drawn)(run)()

        test.__doc__ = check.__doc__
        return test

    return decorate


def sine_error(chart, X, terms=12):
    """A few roundings of size ε; in the exponential that of t = |x|, t ε/2, goes into sin t and cos t in full."""
    return EPS * (terms + (np.linalg.norm(X[3:]) if chart.map == "exp" else 0.0))


def size(x):
    return 1.0 + np.abs(x).max()


def assert_near(actual, expected, tolerance):
    assert np.isfinite(actual).all()
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance)


# --- the motion of local coordinates ---------------------------------------------------------------------------------


def check_psi(chart, X):
    """Rotation and translation; the translation is linear in y."""
    ours = chart.ours.psi(X)
    expected = exact_groups.psi(chart, exact(X))
    error = rounded(exact_groups.pose_of_quaternion(ours) - expected)
    atol = sine_error(chart, X)
    assert np.abs(error[:3, :3]).max() <= atol
    assert np.abs(error[:3, 3]).max() <= atol * size(X[:3])
    assert abs(np.linalg.norm(ours[3:]) - 1.0) <= 3 * EPS


@every_nasty_point
def test_psi_at_nasty_points(chart, X):
    check_psi(chart, X)


@over_charts(40, "X")
def test_psi(chart, X):
    check_psi(chart, X)


@every_nasty_point
def test_angle(chart, X):
    """The rotation angle of |x| is that of the quaternion, (cos φ/2, sin φ/2 n)."""
    angle = chart.ours.angle(np.linalg.norm(X[3:]))
    quaternion = chart.ours.psi(X)[3:]
    expected = [np.cos(angle / 2), abs(np.sin(angle / 2))]
    assert_near([quaternion[0], np.linalg.norm(quaternion[1:])], expected, sine_error(chart, X))


@every_chart
@pytest.mark.parametrize("x", [t * d for t in (0.0, 5e-324, 1e-310, 1e-160, 1e-12) for d in DIRECTIONS], ids=str)
def test_tiny_rotations_keep_their_digits(chart, x):
    """Every map is x to first order, relative to x itself; halving the smallest numbers loses their last bit."""
    X = np.concatenate([np.zeros(3), x])
    motion = chart.ours.psi(X)
    np.testing.assert_allclose(motion[4:], x / 2, rtol=4 * EPS, atol=1e-323)
    np.testing.assert_allclose(chart.ours.psi_inverse(motion), X, rtol=4 * EPS, atol=1e-323)


def check_inverse(chart, X):
    """psi⁻¹(psi(X)): X itself below π, in every case the same motion.

    Near π Rodrigues parameters grow like 1/cos(φ/2), and rounding of the quaternion goes into them with their square.
    """
    ours = chart.ours
    motion = ours.psi(X)
    again = ours.psi_inverse(motion)
    t = np.linalg.norm(X[3:])
    growth = (1 + t**2) if chart.map == "cayley" else 1.0
    if ours.angle(t) < np.pi - 1e-9:
        atol = 16 * EPS * growth * size(t)
        assert_near(again[3:], X[3:], atol)
        assert_near(again[:3], X[:3], atol * size(X[:3]))
    if chart.map != "cayley":
        assert ours.angle(np.linalg.norm(again[3:])) <= np.pi * (1 + 4 * EPS)
    difference = exact_groups.pose_of_quaternion(motion) - exact_groups.psi(chart, exact(again))
    assert np.abs(rounded(difference)).max() <= 16 * EPS * growth * size(X[:3])


@pytest.mark.parametrize(
    ("chart", "X"),
    [pytest.param(c, X, id=f"{c}-{X}") for c in CHARTS for X in nasty(c.map) if np.linalg.norm(X[3:]) < 1e6],
)
def test_psi_inverse_at_nasty_points(chart, X):
    check_inverse(chart, X)


@over_charts(40, "X")
def test_psi_inverse(chart, X):
    check_inverse(chart, X)


# --- the tangent operator --------------------------------------------------------------------------------------------


def inverse_error(chart, T, inverse):
    """Entrywise bound of T⁻¹ per ε: its blocks are S⁻¹, T⁻¹ and -S⁻¹ L T⁻¹.

    The coefficients of the algebraic maps are exact to a few ε. Those of the exponential divide by what vanishes at 2π,
    so an error of T grows by |T⁻¹|.
    """
    inner, outer, mixed = (np.linalg.norm(m) for m in (inverse[3:, 3:], inverse[:3, :3], T[:3, 3:]))
    return (inner + outer + inner * outer * mixed) * (max(1.0, inner) if chart.map == "exp" else 1.0)


def check_tangent(chart, X, w):
    """T, T w, T⁻¹, T⁻¹ w against differences of the motion in 50 digits."""
    ours = chart.ours
    expected = exact_groups.tangent(chart, exact(X))
    T = rounded(expected)
    atol = sine_error(chart, X) * size(X[:3])
    assert_near(ours.tangent(X), T, atol)
    assert_near(ours.tangent_times(X, w), rounded(expected * exact(w)), atol * size(w))
    inverse = expected**-1
    rounded_inverse = rounded(inverse)
    atol = sine_error(chart, X, 16) * inverse_error(chart, T, rounded_inverse) * size(X[:3])
    assert_near(ours.tangent_inverse(X), rounded_inverse, atol)
    assert_near(ours.tangent_inverse_times(X, w), rounded(inverse * exact(w)), atol * size(w))
    assert_near(ours.tangent(X) @ ours.tangent_inverse(X), np.eye(6), atol * size(T) * 6)


@every_nasty_point
def test_tangent_at_nasty_points(chart, X):
    check_tangent(chart, X, w0)


@over_charts(25, "X", w=vectors(10.0, 6))
def test_tangent(chart, X, w):
    check_tangent(chart, X, w)


def check_tangent_derivative(chart, X, w):
    """d(T(X) w)/dX against differences in 80 digits."""
    expected = rounded(exact_groups.tangent_derivative(chart, exact(X), exact(w)))
    atol = sine_error(chart, X, 24) * size(X[:3]) * size(w)
    assert_near(chart.ours.tangent_derivative(X, w), expected, atol)


@every_nasty_point
def test_tangent_derivative_at_nasty_points(chart, X):
    check_tangent_derivative(chart, X, w0)


@over_charts(12, "X", w=vectors(10.0, 6))
def test_tangent_derivative(chart, X, w):
    check_tangent_derivative(chart, X, w)


@every_chart
def test_coordinates_are_scaled_like_the_rotation_vector(chart):
    np.testing.assert_array_equal(chart.ours.tangent(np.zeros(6)), np.eye(6))
    np.testing.assert_array_equal(chart.ours.tangent_inverse(np.zeros(6)), np.eye(6))


# --- the maps tau ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Absolute:
    """A pair of absolute coordinates: a row of Table 1."""

    name: str

    def __str__(self) -> str:
        return self.name

    def tau(self, chart: Chart):
        return getattr(chart.ours, f"tau_{self.name}")

    def of(self, pose: np.ndarray) -> np.ndarray:
        """Coordinates of (position, quaternion)."""
        return pose if self.name == "quaternion" else np.concatenate([pose[:3], lie.log(pose[3:])])

    def exact(self, q: np.ndarray) -> mp.matrix:
        """Pose in 50 digits."""
        return getattr(exact_groups, f"pose_of_{self.name}")(q)

    def error(self, q: np.ndarray, pose: mp.matrix) -> tuple[float, float]:
        """Largest difference of rotation matrices and of positions."""
        difference = np.abs(rounded(self.exact(q) - pose))
        return difference[:3, :3].max(), difference[:3, 3].max()

    def check(self, q: np.ndarray) -> None:
        """Quaternions are unit, rotation vectors at most π long, up to rounding."""
        assert np.isfinite(q).all()
        if self.name == "quaternion":
            assert abs(np.linalg.norm(q[3:]) - 1.0) <= 2 * EPS
        else:
            assert np.linalg.norm(q[3:]) <= np.pi * (1 + 2 * EPS)


ABSOLUTES = [Absolute("quaternion"), Absolute("rotation_vector")]
every_absolute = pytest.mark.parametrize("absolute", ABSOLUTES, ids=str)

STARTS = [  # m, quaternion: identity, generic, half a turn, hardly more
    IDENTITY,
    np.array([1.0, -20.0, 3.0, 0.5, -0.5, 0.7, 0.1]),
    np.array([0.0, 0.5, 0.0, 0.0, 0.6, 0.0, -0.8]),
    np.array([0.0, 0.0, 0.0, -1e-9, 0.0, 1.0, 0.0]),
]


def check_tau(chart, absolute, q, X):
    """The product on the group; positions err by the size of what is added and, on SE(3), of what is turned."""
    result = absolute.tau(chart)(q, X)
    absolute.check(result)
    expected = exact_groups.product(chart, absolute.exact(q), exact_groups.psi(chart, exact(X)))
    rotation, position = absolute.error(result, expected)
    atol = sine_error(chart, X, 24)
    assert rotation <= atol
    assert position <= atol * (size(q[:3]) + size(X[:3]))


@every_absolute
@every_nasty_point
def test_tau_at_nasty_points(chart, X, absolute):
    for start in STARTS:
        unit_start = np.concatenate([start[:3], start[3:] / np.linalg.norm(start[3:])])
        check_tau(chart, absolute, absolute.of(unit_start), X)


poses = st.builds(
    lambda p, x: np.concatenate([p, lie.exp(x)]), vectors(10.0), local_coordinates("exp", 30.0).map(lambda X: X[3:])
)


@every_chart
@pytest.mark.parametrize("angle", [0.1, np.pi - 3.0 - 1e-12, np.pi - 3.0 + 1e-12, 0.2, 3.0])
def test_tau_takes_the_complementary_rotation_vector_past_a_half_turn(chart, angle):
    axis = DIRECTIONS[2]
    q = np.concatenate([np.zeros(3), 3.0 * axis])
    X = np.concatenate([np.ones(3), length_of(angle, chart.map) * axis])
    total = 3.0 + angle
    expected = total if total <= np.pi else total - 2 * np.pi
    assert_near(chart.ours.tau_rotation_vector(q, X)[3:], expected * axis, 16 * EPS)


@over_charts(40, "X", pose=poses)
def test_tau(chart, X, pose):
    for absolute in ABSOLUTES:
        check_tau(chart, absolute, absolute.of(pose), X)


def assert_same_pose(absolute, one, other, tolerance):
    error = np.abs(rounded(absolute.exact(one) - absolute.exact(other))).max()
    assert error <= tolerance


@over_charts(25, "X", "Y", pose=poses)
def test_group_axioms(chart, X, Y, pose):
    """Neutral element, inverse and associativity, each a few products of poses with positions up to 30 m."""
    for absolute in ABSOLUTES:
        tau, q = absolute.tau(chart), absolute.of(pose)
        assert_same_pose(absolute, tau(q, np.zeros(6)), q, 32 * EPS)
        there = tau(q, X)
        assert_same_pose(absolute, tau(there, -X), q, 40 * EPS * 40)
        product = chart.ours.product
        both = product(pose, product(chart.ours.psi(X), chart.ours.psi(Y)))
        assert_same_pose(absolute, tau(there, Y), absolute.of(both), 64 * EPS * 40)
        back = product(pose, chart.ours.inverse(pose))
        assert_same_pose(ABSOLUTES[0], back, IDENTITY, 16 * EPS * 20)


# --- many turns ------------------------------------------------------------------------------------------------------

STEP_ANGLE = 0.37  # rad


@every_absolute
@every_chart
def test_many_turns(chart, absolute):
    """400 equal steps, 23 turns about an oblique axis: coordinates in bounds, outputs continuous, the end exact.

    The rotation vector jumps once in a turn, and nothing else does: rotation, position and the nearest quaternion
    change by as much in every step.
    """
    tau, steps = absolute.tau(chart), 400
    X = np.concatenate([[0.01, -0.02, 0.03], length_of(STEP_ANGLE, chart.map) * DIRECTIONS[2]])
    q = absolute.of(np.array([0.1, 0.2, 0.3, 0.5, -0.5, 0.5, 0.5]))
    quaternion = q[3:] if absolute.name == "quaternion" else lie.exp(q[3:])
    start, jumps = absolute.exact(q), 0
    for _ in range(steps):
        before, previous, q = q, quaternion, tau(q, X)
        absolute.check(q)
        jumps += np.linalg.norm(q[3:] - before[3:]) > 1.0
        quaternion = q[3:] if absolute.name == "quaternion" else lie.nearest(lie.exp(q[3:]), previous)
        change = np.linalg.norm(quaternion - previous)
        assert change == pytest.approx(2 * np.sin(STEP_ANGLE / 4), abs=32 * EPS)
        turn = Rotation.from_quat(previous, scalar_first=True).inv() * Rotation.from_quat(quaternion, scalar_first=True)
        assert_near(turn.as_rotvec(), STEP_ANGLE * DIRECTIONS[2], 64 * EPS)
        assert np.linalg.norm(q[:3] - before[:3]) <= np.linalg.norm(X[:3]) * (1 + 64 * EPS)
    turns = steps * STEP_ANGLE / (2 * np.pi)
    assert jumps == 0 if absolute.name == "quaternion" else abs(jumps - turns) <= 1
    expected = exact_groups.psi(chart, exact(X))
    power = exact_groups.block(expected[:3, :3] ** steps, steps * expected[:3, 3])
    end = exact_groups.product(chart, start, expected**steps if chart.se3 else power)
    rotation, position = absolute.error(q, end)
    assert rotation <= 8 * EPS * steps
    assert position <= 8 * EPS * steps


# --- what the groups share with the rest of the product --------------------------------------------------------------


@property_test(100, X=local_coordinates("exp", 30.0), w=vectors(10.0, 6))
def test_rotation_vectors_on_the_direct_product_are_the_functions_of_so3(X, w):
    """Bit for bit: the same formulas."""
    ours, x, wr = CHARTS[0].ours, X[3:], w[3:]
    np.testing.assert_array_equal(ours.tangent(X)[3:, 3:], lie.tangent(x))
    np.testing.assert_array_equal(ours.tangent_times(X, w)[3:], lie.tangent_times(x, wr))
    np.testing.assert_array_equal(ours.tangent_inverse(X)[3:, 3:], lie.tangent_inverse(x))
    np.testing.assert_array_equal(ours.tangent_inverse_times(X, w)[3:], lie.tangent_inverse_times(x, wr))
    np.testing.assert_array_equal(ours.tangent_derivative(X, w)[3:, 3:], lie.tangent_derivative(x, wr))
    q = np.concatenate([w[:3], lie.exp(wr)])
    np.testing.assert_array_equal(ours.tau_quaternion(q, X), lie.compose(q, X))
