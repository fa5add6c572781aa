"""SE(3): the motions it is made for, its bracket and its velocities; and the printed formulas of Müller 2022.

What SE(3) shares with R³×SO(3) is in test_lgt.py.
"""

import mpmath as mp
import numpy as np
import pytest

from sigmafmu._core import lie

from . import exact_groups
from .exact_groups import CHARTS, I3, Chart, cayley, exact_exponential, rotation_matrix
from .helpers import DIFFERENCES, EPS, derivative, exact, exact_exp, exact_hat, property_test, rounded, vectors

SE3 = [chart for chart in CHARTS if chart.se3]
every_map = pytest.mark.parametrize("chart", SE3, ids=str)
every_chart = pytest.mark.parametrize("chart", CHARTS, ids=str)
quaternions = vectors(3.0).map(lie.exp)
SCREWS = [
    np.array([1.0, -2.0, 0.5, *(t * np.array([1 / 3, 2 / 3, -2 / 3]))])
    for t in (0.0, 1e-300, 1e-12, 0.9, 1.1, 3.0, np.pi, 30.0)
]


# --- motions ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("X", SCREWS, ids=str)
def test_exponential_of_a_screw(X):
    """Eqs. (44), (45) against the power series of the 4×4 matrix: the closed form in 50 digits, and ours."""
    expected = exact_exponential(exact(X))
    assert mp.mnorm(exact_groups.psi(Chart("se3", "exp"), exact(X)) - expected) < mp.mpf(10) ** -45
    error = exact_groups.pose_of_quaternion(lie.se3_exp.psi(X)) - expected
    assert np.abs(rounded(error)).max() <= EPS * (8 + np.linalg.norm(X[3:])) * 3


@every_map
@property_test(50, x=vectors(1.5), point=vectors(2.0))
def test_a_turn_about_a_point_keeps_the_point(chart, x, point):
    """A body on a spherical joint: X = (-x × p, x) leaves p where it is, so SE(3) keeps lower pairs exactly.

    R³×SO(3) does not: its displacement is not the one that belongs to the rotation.
    """
    X = np.concatenate([-np.cross(x, point), x])
    where = np.concatenate([point, [1.0, 0, 0, 0]])
    np.testing.assert_allclose(chart.ours.product(chart.ours.psi(X), where)[:3], point, rtol=0, atol=64 * EPS)


def test_the_direct_product_leaves_the_point():
    x, point = np.array([0.0, 0.0, 0.5]), np.array([1.0, 0.0, 0.0])
    q = lie.r3xso3_exp.psi(np.concatenate([-np.cross(x, point), x]))
    assert np.linalg.norm(q[:3] + lie.rotation_matrix(q[3:]) @ point - point) > 0.1


@every_map
@pytest.mark.parametrize("axis", np.eye(3), ids=str)
def test_screws_about_one_axis_stay_on_it(chart, axis):
    """Cylindrical joint: rotation about and translation along an axis through a point, 1000 steps, no drift."""
    point = np.array([0.3, -0.2, 0.5])
    X = np.concatenate([0.02 * axis - np.cross(0.3 * axis, point), 0.3 * axis])
    q = np.array([0.0, 0, 0, 1, 0, 0, 0])
    for _ in range(1000):
        q = chart.ours.tau_quaternion(q, X)
    moved = q[:3] + lie.rotation_matrix(q[3:]) @ point - point
    np.testing.assert_allclose(np.cross(axis, moved), 0.0, rtol=0, atol=1000 * 4 * EPS)
    np.testing.assert_allclose(lie.rotation_matrix(q[3:]) @ axis, axis, rtol=0, atol=1000 * 4 * EPS)


@every_map
def test_only_the_exponential_keeps_the_pitch_of_a_screw(chart):
    """10 cm along z for each radian about z: coordinates of fixed ratio, a large step."""
    z = np.array([0.0, 0.0, 1.0])
    q = chart.ours.psi(np.concatenate([0.1 * z, z]))
    pitch = q[2] / chart.ours.angle(1.0)
    if chart.map == "exp":
        assert pitch == pytest.approx(0.1, rel=4 * EPS)
    else:
        assert abs(pitch - 0.1) > 1e-3


# --- the bracket and velocities --------------------------------------------------------------------------------------


@every_chart
@property_test(50, U=vectors(2.0, 6), V=vectors(2.0, 6), W=vectors(2.0, 6))
def test_commutator(chart, U, V, W):
    """Of 4×4 matrices on SE(3); the rotational one alone on R³×SO(3). Antisymmetric, Jacobi's identity."""
    bracket = chart.ours.commutator
    A, B = (exact_groups.twist_matrix(exact(X)) for X in (V, W))
    expected = rounded(exact_groups.vee(A * B - B * A))
    np.testing.assert_allclose(bracket(V, W)[3:], expected[3:], rtol=0, atol=8 * EPS * 8)
    np.testing.assert_allclose(bracket(V, W)[:3], expected[:3] * chart.se3, rtol=0, atol=8 * EPS * 16)
    np.testing.assert_array_equal(bracket(V, W), -bracket(W, V))
    jacobi = bracket(U, bracket(V, W)) + bracket(V, bracket(W, U)) + bracket(W, bracket(U, V))
    np.testing.assert_allclose(jacobi, 0.0, rtol=0, atol=16 * EPS * 100)


@every_chart
def test_commutator_is_what_two_motions_differ_by(chart):
    """psi(sV) psi(sW) psi(-sV) psi(-sW) = psi(s² [V, W]) + O(s³), for every map."""
    V, W = np.array([1.0, -0.5, 0.3, 0.2, 0.9, -0.6]), np.array([-0.4, 0.8, 1.1, 0.7, -0.1, 0.5])
    ours = chart.ours

    def error(s):
        X = np.array([0.0, 0, 0, 1, 0, 0, 0])
        for Y in (V, W, -V, -W):
            X = ours.product(X, ours.psi(s * Y))
        return np.linalg.norm(ours.psi_inverse(X) / s**2 - ours.commutator(V, W))

    assert error(1e-3) < 1e-2
    assert error(1e-2) / error(5e-3) == pytest.approx(2.0, abs=0.1)


@every_chart
@property_test(50, quaternion=quaternions, v=vectors(10.0, 6), vdot=vectors(10.0, 6))
def test_velocities_and_accelerations_there_and_back(chart, quaternion, v, vdot):
    ours = chart.ours
    V = ours.velocity(quaternion, v)
    Vdot = ours.acceleration(quaternion, v, vdot)
    np.testing.assert_array_equal(V[3:], v[3:])
    np.testing.assert_array_equal(Vdot[3:], vdot[3:])
    np.testing.assert_allclose(ours.mixed_velocity(quaternion, V), v, rtol=0, atol=32 * EPS * 10)
    np.testing.assert_allclose(ours.mixed_acceleration(quaternion, V, Vdot), vdot, rtol=0, atol=32 * EPS * 300)
    expected = lie.rotation_matrix(quaternion).T @ v[:3] if chart.se3 else v[:3]
    np.testing.assert_allclose(V[:3], expected, rtol=0, atol=16 * EPS * 10)


@every_chart
@property_test(25, quaternion=quaternions, v=vectors(3.0, 6), vdot=vectors(3.0, 6))
def test_acceleration_is_the_derivative_of_the_velocity(chart, quaternion, v, vdot):
    """Along a motion with v(t) = v + t v̇ and dR/dt = R hat(w): at t = 0 the second-order part of R does not matter."""
    ours = chart.ours

    def velocity(t):
        turned = lie.compose(np.array([0.0, 0, 0, *quaternion]), np.concatenate([np.zeros(3), t * v[3:]]))
        return ours.velocity(turned[3:], v + t * vdot)

    expected = derivative(velocity)
    np.testing.assert_allclose(ours.acceleration(quaternion, v, vdot), expected, rtol=0, atol=DIFFERENCES * 30)


@every_chart
@property_test(25, pose=vectors(3.0, 6), X=vectors(0.8, 6), rate=vectors(2.0, 6))
def test_velocity_of_coordinates_is_the_velocity_of_the_pose(chart, pose, X, rate):
    """Mixed velocities of q = tau(q0, X(t)): position by differences, angular velocity as on SO(3)."""
    ours = chart.ours
    q0 = np.concatenate([pose[:3], lie.exp(pose[3:])])
    q = ours.tau_quaternion(q0, X)
    mixed = ours.mixed_velocity(q[3:], ours.tangent_times(X, rate))
    qdot = derivative(lambda s: ours.tau_quaternion(q0, X + s * rate))
    np.testing.assert_allclose(mixed[:3], qdot[:3], rtol=0, atol=DIFFERENCES * 20)
    w = 2 * (q[3] * qdot[4:] - qdot[3] * q[4:] - np.cross(q[4:], qdot[4:]))
    np.testing.assert_allclose(mixed[3:], w, rtol=0, atol=DIFFERENCES * 20)


# --- the printed formulas --------------------------------------------------------------------------------------------
# docs/lie.md lists the misprints. Each test evaluates, in 50 digits at a generic point, the formula as corrected, which
# must agree with a definition, and where one line differs the printed line, which must not.

x, y, x1 = (exact(v) for v in ([0.7, -1.1, 0.4], [1.3, 0.2, -0.8], [-0.3, 0.9, 1.2]))
c, d = x / 2, y / 2  # the paper's (extended) Rodrigues parameters
phi, phi1 = mp.norm(x), mp.norm(x1)
sigma = 2 / (1 + mp.norm(c) ** 2)
alpha, beta = mp.sinc(phi), mp.sinc(phi / 2) ** 2
gamma = alpha / beta
R = rotation_matrix(exact_exp(x))
H, Y, C, D = (exact_hat(v) for v in (x, y, c, d))
half = mp.mpf(1) / 2


def same(one, other):
    return mp.mnorm(one - other, "f") < mp.mpf(10) ** -40


def right(chart):
    """Inverse of the right-trivialised differential of the paper's psi, rotation first: T⁻¹ at -X, reordered."""
    scale = 1 if chart.map == "exp" else 2  # X = 2 (d, c)
    T = exact_groups.tangent(chart, -mp.matrix([*y, *x]))
    m = mp.zeros(6)
    for i in range(6):
        for j in range(6):
            m[i, j] = scale * T[(i + 3) % 6, (j + 3) % 6]
    return m**-1


def close(one, other):
    """To the error of the differences in `exact_groups`."""
    return mp.mnorm(one - other, "f") < mp.mpf(10) ** -25


def blocks(upper, lower, mixed):
    m = mp.zeros(6)
    m[:3, :3], m[3:, 3:], m[3:, :3] = upper, lower, mixed
    return m


def test_rotation_matrices():
    n = H / phi
    assert same(R, I3 + alpha * H + half * beta * H**2)  # (30)
    assert same(R, I3 + mp.sin(phi) * n + 2 * mp.sin(phi / 2) ** 2 * n**2)  # (31)
    assert not same(R, I3 + mp.sin(phi) * n + half * mp.sin(phi / 2) ** 2 * n**2)
    assert same(cayley(C), I3 + sigma * (C + C**2))  # (35)


def test_differentials_on_the_rotation_group():
    exp, cay = Chart("r3xso3", "exp"), Chart("r3xso3", "cayley")
    n = H / phi
    assert close(right(exp)[:3, :3] ** -1, I3 + beta / 2 * H + (1 - alpha) * n**2)  # (32)
    assert close(right(exp)[:3, :3], I3 - half * H + (1 - gamma) / phi**2 * H**2)  # (33)
    assert close(right(cay)[:3, :3] ** -1, sigma * (I3 + C))  # (36)
    assert close(right(cay)[:3, :3], I3 / sigma + half * (C**2 - C))  # (37)


def test_quaternion_of_rodrigues_parameters():
    root = mp.sqrt(sigma / 2)
    assert same(cayley(C), rotation_matrix(mp.matrix([root, *(root * c)])))  # (41)
    assert not same(cayley(C), rotation_matrix(mp.matrix([root, *(mp.sqrt(1 - sigma / 2) * c)])))


def test_differential_of_the_exponential():
    B = (  # (47)
        -half * Y + (1 - gamma) / phi**2 * (H * Y + Y * H) + (x.T * y)[0] / phi**4 * (1 / beta + gamma - 2) * H**2
    )
    inner = I3 - half * H + (1 - gamma) / phi**2 * H**2
    assert close(right(Chart("se3", "exp")), blocks(inner, inner, B))  # (46)


def test_differential_of_the_cayley_map():
    inner = I3 / sigma + half * (C**2 - C)
    assert close(right(Chart("se3", "cayley")), blocks(inner, half * (I3 - C), half * (C - I3) * D))  # (49)
    motion = exact_groups.psi(Chart("se3", "cayley"), mp.matrix([*y, *x]))
    assert same(motion[:3, 3], (I3 + cayley(C)) * d)  # (48)


def rotation_of_vector(v):
    return rotation_matrix(exact_exp(v))


def composed(x1, other, a, b, g):
    """Eqs. (74), (77)."""
    return a * x1 + b * other + g * exact_hat(x1) * other


def test_composition_of_rotation_vectors():
    expected = rotation_of_vector(x1) * R
    s, k, s1, k1 = (f(angle / 2) for angle in (phi, phi1) for f in (mp.sinc, mp.cos))

    def vector(product):
        q = mp.sinc(mp.acos(k1 * k - product * (x1.T * x)[0] / 4))  # (76)
        return composed(x1, x, s1 * k / q, k1 * s / q, s1 * s / (2 * q))  # (75)

    assert same(rotation_of_vector(vector(s1 * s)), expected)
    assert not same(rotation_of_vector(vector(mp.sinc(phi1) * mp.sinc(phi))), expected)  # before (74)
    ours = lie.r3xso3_exp.tau_rotation_vector(*(np.array([0.0, 0, 0, *rounded(v)]) for v in (x1, x)))
    np.testing.assert_allclose(ours[3:], rounded(vector(s1 * s)), rtol=0, atol=8 * EPS)


def test_composition_of_a_rotation_vector_and_rodrigues_parameters():
    expected = rotation_of_vector(x1) * cayley(C)
    root, s1, k1, dot = mp.sqrt(sigma / 2), mp.sinc(phi1 / 2), mp.cos(phi1 / 2), (x1.T * c)[0]

    def vector(factor):
        q = mp.sinc(mp.acos(root * k1 - half * factor * s1 * dot))  # (79)
        return composed(x1, c, root * s1 / q, 2 * factor * k1 / q, factor * s1 / q)  # (78)

    assert same(rotation_of_vector(vector(root)), expected)
    assert not same(rotation_of_vector(vector(mp.sqrt(1 - sigma / 2))), expected)
    ours = lie.r3xso3_cayley.tau_rotation_vector(*(np.array([0.0, 0, 0, *rounded(v)]) for v in (x1, x)))
    np.testing.assert_allclose(ours[3:], rounded(vector(root)), rtol=0, atol=8 * EPS)


def test_update_of_a_quaternion():
    p0, p = exact_exp(x1)[0], exact_exp(x1)[1:4]
    k, s = mp.cos(phi / 2), mp.sinc(phi / 2) / 2
    P = exact_hat(p)

    def update(last):
        return mp.matrix([p0 * k - s * (p.T * x)[0], *(k * p + s * (p0 * x + last))])  # (62)

    expected = rotation_of_vector(x1) * R
    assert same(rotation_matrix(update(P * x)), expected)
    assert not same(rotation_matrix(update(P**2 * x)), expected)


@pytest.mark.parametrize(
    ("tau", "rotation"),
    [("tau_quaternion", [0.0, 0.6, 0.0, 0.8]), ("tau_rotation_vector", [1.0, -2.0, 0.5])],
)
@property_test(10, start=vectors(3.0), shift=vectors(3.0), turn=vectors(1.0))
def test_displacements_on_the_direct_product_are_added_in_w(tau, rotation, start, shift, turn):
    """(66), (70) as printed turn Δr with the body; with v = dr/dt in W, as the group has it, Δr is simply added."""
    moved = getattr(lie.r3xso3_exp, tau)(np.array([*start, *rotation]), np.concatenate([shift, turn]))
    np.testing.assert_array_equal(moved[:3], start + shift)
