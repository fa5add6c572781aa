"""SO(3) and R³×SO(3) against 50-digit arithmetic and SciPy, at random and at nasty points."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sigmafmu._core import lie

from .helpers import (
    EPS,
    exact,
    exact_coefficients,
    exact_exp,
    exact_hat,
    exact_product,
    exact_square,
    exact_tangent,
    property_test,
    rounded,
    vectors,
)

NASTY_ANGLES = [  # rad
    0.0,
    5e-324,
    1e-300,
    1e-160,  # their squares underflow
    1.6e-154,
    1e-150,
    1e-12,
    1e-8,
    1e-4,
    0.1,
    float(np.nextafter(1.0, 0.0)),  # the series ends at 1
    1.0,
    float(np.nextafter(1.0, 2.0)),
    1.0 + 1e-8,
    3.0,
    np.pi - 1e-12,
    np.pi,
    np.pi + 1e-12,
    2 * np.pi - 1e-3,  # T is nearly singular
    30.0,
]
DIRECTIONS = [np.array(d) for d in ([1.0, 0, 0], [0, -1.0, 0], [1 / 3, 2 / 3, -2 / 3], [-0.48, 0.6, 0.64])]
SUBNORMAL = 1e-323  # halving the smallest numbers loses their last bit
NASTY = [angle * direction for angle in NASTY_ANGLES for direction in DIRECTIONS]
AXES = np.eye(3)


def angles(largest):
    return st.one_of(st.sampled_from([t for t in NASTY_ANGLES if t <= largest]), st.floats(0.0, largest))


def unit(vector):
    length = np.linalg.norm(vector)
    return vector / length if length > 0.1 else DIRECTIONS[2]


directions = vectors(1.0).map(unit)


def rotation_vectors(largest=30.0):
    return st.builds(lambda angle, direction: angle * direction, angles(largest), directions)


def size(x):
    """Length to a factor √3; unlike the length it does not underflow."""
    return 2 * np.abs(x).max() + SUBNORMAL / EPS


def sine_error(theta, terms=8):
    """Rounding of t = |θ| by t ε/2 goes into sin t and cos t in full, beside a few roundings of size ε."""
    return EPS * (terms + np.linalg.norm(theta))


# --- coefficients ----------------------------------------------------------------------------------------------------


def check_coefficients(x):
    """Below x = 1 every coefficient is correct to one unit in the last place.

    Above it a and b are correct to 4 ε beyond what the rounding of t = √x makes of them (x a'(x) ε, which matters at
    the zeros of a); a'/t and b'/t are differences of terms of size a/x, b/x and correct to 4 ε of those.
    """
    ours = lie.coefficients(x)
    theirs = exact_coefficients(x)
    error = np.array([abs(float(mp.mpf(float(o)) - t)) for o, t in zip(ours, theirs, strict=True)])
    a, b, da, db = (abs(float(t)) for t in theirs)
    if x < 1.0:
        assert (error <= EPS * np.array([a, b, da, db])).all()
        return
    sinc = 2.0 / x  # at most: cos, sin and their products with t ≤ 30, over x
    assert (error[:2] <= EPS * (4 * np.array([a, b]) + x * np.array([da, db]))).all()
    assert (error[2:] <= EPS * (4 * np.array([a + sinc, a + 3 * b]) / x + sinc)).all()


@pytest.mark.parametrize("t", NASTY_ANGLES)
def test_coefficients_at_nasty_points(t):
    check_coefficients(t * t)


@pytest.mark.parametrize("x", [float(np.nextafter(1.0, 0.0)), 1.0, float(np.nextafter(1.0, 2.0))])
def test_coefficients_at_the_end_of_the_series(x):
    check_coefficients(x)


@property_test(300, t=st.floats(0.0, 30.0))
def test_coefficients(t):
    check_coefficients(t * t)


def test_coefficients_at_zero():
    np.testing.assert_array_equal(lie.coefficients(0.0), [1 / 2, 1 / 6, -1 / 12, -1 / 60])


# --- hat, exp, log ---------------------------------------------------------------------------------------------------


@property_test(50, w=vectors(1e3), x=vectors(1e3))
def test_hat_is_the_cross_product(w, x):
    np.testing.assert_array_equal(lie.hat(w), -lie.hat(w).T)
    np.testing.assert_allclose(lie.hat(w) @ x, np.cross(w, x), rtol=0, atol=4 * EPS * 1e6)


def check_exp(theta):
    quaternion = lie.exp(theta)
    np.testing.assert_allclose(quaternion, rounded(exact_exp(exact(theta))), rtol=0, atol=sine_error(theta, 2))
    assert abs(np.linalg.norm(quaternion) - 1.0) <= 2 * EPS
    scipy = Rotation.from_rotvec(theta).as_matrix()
    np.testing.assert_allclose(lie.rotation_matrix(quaternion), scipy, rtol=0, atol=sine_error(theta))


@pytest.mark.parametrize("theta", NASTY, ids=str)
def test_exp_at_nasty_points(theta):
    check_exp(theta)


@property_test(200, theta=rotation_vectors())
def test_exp(theta):
    check_exp(theta)


@pytest.mark.parametrize("theta", [t for t in NASTY if np.linalg.norm(t) < 1e-7], ids=str)
def test_exp_keeps_tiny_rotations(theta):
    """To first order, relative to the rotation itself: half of it, and 1."""
    np.testing.assert_allclose(lie.exp(theta)[1:], theta / 2, rtol=4 * EPS, atol=SUBNORMAL)
    np.testing.assert_allclose(lie.log(lie.exp(theta)), theta, rtol=4 * EPS, atol=SUBNORMAL)


def check_log(theta):
    """Against the logarithm of the same quaternion in 50 digits; |log| ≤ π; the same rotation."""
    quaternion = lie.exp(theta)
    rotation = lie.log(quaternion)
    q = exact(quaternion)
    sine = mp.sqrt(q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    sign = -1 if q[0] < 0 else 1
    scale = 2 * sign * mp.atan2(sine, sign * q[0]) / sine if sine else mp.mpf(2)
    expected = rounded(scale * q[1:4])
    np.testing.assert_allclose(rotation, expected, rtol=4 * EPS, atol=4 * EPS * np.linalg.norm(expected))
    assert np.linalg.norm(rotation) <= np.pi * (1 + 2 * EPS)
    if np.linalg.norm(theta) < np.pi - 1e-9:
        np.testing.assert_allclose(rotation, theta, rtol=0, atol=8 * EPS * np.linalg.norm(theta) + SUBNORMAL)
    scipy = Rotation.from_quat(quaternion, scalar_first=True)
    np.testing.assert_allclose(Rotation.from_rotvec(rotation).as_matrix(), scipy.as_matrix(), rtol=0, atol=16 * EPS)


@pytest.mark.parametrize("theta", NASTY, ids=str)
def test_log_at_nasty_points(theta):
    check_log(theta)


@property_test(200, theta=rotation_vectors())
def test_log(theta):
    check_log(theta)


def test_log_takes_the_short_way_round():
    """q and -q are the same rotation; beyond π the axis turns over."""
    for theta in NASTY:
        quaternion = lie.exp(theta)
        if abs(quaternion[0]) > 1e-9:
            np.testing.assert_array_equal(lie.log(-quaternion), lie.log(quaternion))
    np.testing.assert_allclose(
        lie.log(lie.exp((np.pi + 1e-3) * AXES[2])), -(np.pi - 1e-3) * AXES[2], atol=4 * EPS * np.pi
    )
    np.testing.assert_array_equal(lie.log(np.array([1.0, 0, 0, 0])), np.zeros(3))
    np.testing.assert_array_equal(np.abs(lie.log(np.array([-1.0, 0, 0, 0]))), np.zeros(3))


# --- the tangent operator --------------------------------------------------------------------------------------------


def check_tangent(theta, c):
    """T, T c, T⁻¹, T⁻¹ c against 50 digits. T⁻¹ amplifies errors of T by |T⁻¹|²."""
    expected = exact_tangent(exact(theta))
    inverse = expected**-1
    atol = sine_error(theta)
    growth = max(1.0, float(mp.mnorm(inverse, "f"))) ** 2
    np.testing.assert_allclose(lie.tangent(theta), rounded(expected), rtol=0, atol=atol)
    np.testing.assert_allclose(lie.tangent_times(theta, c), rounded(expected * exact(c)), rtol=0, atol=atol * size(c))
    np.testing.assert_allclose(lie.tangent_inverse(theta), rounded(inverse), rtol=0, atol=atol * growth)
    np.testing.assert_allclose(
        lie.tangent_inverse_times(theta, c), rounded(inverse * exact(c)), rtol=0, atol=atol * growth * size(c)
    )
    np.testing.assert_allclose(
        lie.tangent(theta) @ lie.tangent_inverse(theta), np.eye(3), rtol=0, atol=4 * atol * growth
    )
    np.testing.assert_allclose(lie.tangent_times(theta, theta), theta, rtol=0, atol=4 * EPS * size(theta))
    np.testing.assert_allclose(
        lie.tangent_inverse_times(theta, theta), theta, rtol=0, atol=4 * EPS * growth * size(theta)
    )


@pytest.mark.parametrize("theta", NASTY, ids=str)
def test_tangent_at_nasty_points(theta):
    check_tangent(theta, np.array([0.3, -2.0, 1.1]))


@property_test(200, theta=rotation_vectors(2 * np.pi - 1e-3), c=vectors(100.0))
def test_tangent(theta, c):
    check_tangent(theta, c)


def check_differential(theta, direction):
    """T(θ) θ' is the body-fixed angular velocity: exp(-θ) exp(θ + s θ') = exp(s T(θ) θ' + O(s²)), s = 1e-20."""
    s = mp.mpf(10) ** -20
    start = exact_exp(exact(theta))
    conjugate = mp.matrix([start[0], -start[1], -start[2], -start[3]])

    def turned(step):
        return exact_product(conjugate, exact_exp(exact(theta) + step * exact(direction)))[1:4]

    velocity = rounded((turned(s) - turned(-s)) / s)
    np.testing.assert_allclose(
        lie.tangent_times(theta, direction), velocity, rtol=0, atol=sine_error(theta) * size(direction)
    )


@pytest.mark.parametrize("theta", NASTY, ids=str)
def test_tangent_is_the_differential_of_exp_at_nasty_points(theta):
    check_differential(theta, np.array([-0.7, 0.2, 1.3]))


@property_test(100, theta=rotation_vectors(), direction=directions)
def test_tangent_is_the_differential_of_exp(theta, direction):
    check_differential(theta, direction)


def check_tangent_derivative(theta, c):
    """d(T(θ) c)/dθ by central differences of width 1e-15 in 50 digits; they are exact to 1e-29."""
    s = mp.mpf(10) ** -15
    expected = np.empty((3, 3))
    for i in range(3):
        e = exact(AXES[i])
        change = exact_tangent(exact(theta) + s * e) * exact(c) - exact_tangent(exact(theta) - s * e) * exact(c)
        expected[:, i] = rounded(change / (2 * s))
    atol = sine_error(theta) * size(c)
    np.testing.assert_allclose(lie.tangent_derivative(theta, c), expected, rtol=0, atol=atol)


@pytest.mark.parametrize("theta", NASTY, ids=str)
def test_tangent_derivative_at_nasty_points(theta):
    check_tangent_derivative(theta, np.array([0.9, -0.4, 2.2]))


@property_test(100, theta=rotation_vectors(), c=vectors(10.0))
def test_tangent_derivative(theta, c):
    check_tangent_derivative(theta, c)


@pytest.mark.parametrize("theta", [1e-3 * DIRECTIONS[2], 0.8 * DIRECTIONS[3], 2.5 * DIRECTIONS[2]], ids=str)
def test_increments_of_coordinates_and_of_the_group_agree_to_second_order(theta):
    """Eqs. (69), (77): exp(θ) exp(Δ) = exp(θ + T⁻¹(θ) Δ) + O(Δ²)."""
    direction = np.array([0.5, -1.0, 0.7])

    def distance(size):
        group = Rotation.from_rotvec(theta) * Rotation.from_rotvec(size * direction)
        local = theta + lie.tangent_inverse_times(theta, size * direction)
        return np.linalg.norm((group.inv() * Rotation.from_rotvec(local)).as_rotvec())

    assert distance(1e-2) < 1e-4
    assert np.log2(distance(1e-2) / distance(5e-3)) == pytest.approx(2.0, abs=0.1)


# --- the group R³×SO(3) ----------------------------------------------------------------------------------------------

IDENTITY = np.array([0.0, 0, 0, 1, 0, 0, 0])


@st.composite
def elements(draw):
    return np.concatenate([draw(vectors(10.0)), lie.exp(draw(rotation_vectors()))])


def local(q):
    """θ with exp(θ) = q."""
    return np.concatenate([q[:3], lie.log(q[3:])])


def assert_same_element(p, q, tolerance):
    np.testing.assert_allclose(p[:3], q[:3], rtol=0, atol=tolerance * 20)
    assert min(np.abs(p[3:] - q[3:]).max(), np.abs(p[3:] + q[3:]).max()) <= tolerance


@property_test(100, p=elements(), q=elements(), r=elements())
def test_group_axioms(p, q, r):
    """p ∘ q by compose(p, log q): the quaternion of q may change its sign on the way."""
    assert_same_element(lie.compose(IDENTITY, local(p)), p, 8 * EPS)
    assert_same_element(lie.compose(p, np.zeros(6)), p, 2 * EPS)
    assert_same_element(lie.compose(p, -local(p)), IDENTITY, 8 * EPS)
    once = lie.compose(lie.compose(p, local(q)), local(r))
    other = lie.compose(p, local(lie.compose(q, local(r))))
    assert_same_element(once, other, 32 * EPS)


@property_test(100, q=elements(), shift=vectors(10.0), theta=rotation_vectors())
def test_compose_adds_translations_and_multiplies_rotations(q, shift, theta):
    result = lie.compose(q, np.concatenate([shift, theta]))
    np.testing.assert_array_equal(result[:3], q[:3] + shift)
    product = rounded(exact_product(exact(q[3:]), exact_exp(exact(theta))))
    np.testing.assert_allclose(result[3:], product, rtol=0, atol=sine_error(theta))
    scipy = Rotation.from_quat(q[3:], scalar_first=True) * Rotation.from_rotvec(theta)
    np.testing.assert_allclose(lie.rotation_matrix(result[3:]), scipy.as_matrix(), rtol=0, atol=sine_error(theta, 16))


@property_test(50, q=elements(), theta=rotation_vectors(), excess=st.floats(-1e-9, 1e-9))
def test_compose_brings_a_quaternion_back_to_unit_length(q, theta, excess):
    """The Newton step leaves 3/8 (|q|² - 1)², below ε here."""
    q[3:] *= 1.0 + excess
    result = lie.compose(q, np.concatenate([np.zeros(3), theta]))
    assert abs(np.linalg.norm(result[3:]) - 1.0) <= 2 * EPS


def test_quaternion_stays_unit_and_accurate_over_a_million_compositions():
    """About one axis the product is known: its angle is the sum; each step may round by 2 ε, as a random walk."""
    steps, theta = 1_000_000, np.array([0.0, 0.0, 0.0, 0.1, 0.2, -0.3])
    q = IDENTITY
    worst = 0.0
    for i in range(steps):
        q = lie.compose(q, theta)
        if i % 1000 == 0:
            worst = max(worst, abs(np.linalg.norm(q[3:]) - 1.0))
    assert max(worst, abs(np.linalg.norm(q[3:]) - 1.0)) <= 2 * EPS
    expected = rounded(exact_exp(steps * exact(theta[3:])))
    assert_same_element(q, np.concatenate([np.zeros(3), expected]), 2 * EPS * steps)


def test_square_of_the_smallest_angles_may_underflow():
    assert exact_square(exact([1e-300, 0, 0])) > 0
    np.testing.assert_array_equal(
        lie.tangent(np.array([1e-300, 0, 0])), np.eye(3) - 0.5 * lie.hat(np.array([1e-300, 0, 0]))
    )
    assert (rounded(exact_hat(exact(AXES[0]))) == lie.hat(AXES[0])).all()
