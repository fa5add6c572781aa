"""The control laws alone, against what they promise in formulas."""

import ast
import importlib
import inspect
import math
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sigmafmu.loop.controllers.axis_attitude import AxisAttitude
from sigmafmu.loop.controllers.magnetic_bearings import MagneticBearings
from sigmafmu.loop.controllers.seal import Seal
from sigmafmu.loop.controllers.speed_pi import SpeedPI
from sigmafmu.loop.loops import LOOPS

EPS = float(np.finfo(float).eps)
H = 1e-3
LAWS = [part.law for loop in LOOPS.values() for part in loop.parts.values()]

small = st.floats(-1.0, 1.0, allow_subnormal=False)
vector = st.tuples(small, small, small).map(np.array)
rotation = (
    st.tuples(small, small, small, small)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


# --- every law ---


@pytest.mark.parametrize("law", LAWS)
def test_law_keeps_its_interface(law):
    """An answer for every output, the same after a reset; parameters by their start values unless given."""
    names = [*law.inputs, *law.outputs, *law.parameters]
    assert len(set(names)) == len(names)
    first, *_ = law.parameters
    assert law(**{first: 7.25}).values == {**law().values, first: 7.25}

    instance = law()
    measured = dict.fromkeys(law.inputs, 1e-3)

    def answers():
        return [instance.step(i * H, H, measured | {next(iter(measured)): 1e-3 * i}) for i in range(5)]

    before = answers()
    assert all(answer.keys() == law.outputs.keys() for answer in before)
    instance.reset()
    assert answers() == before


@pytest.mark.parametrize("law", LAWS)
def test_law_needs_the_standard_library_alone(law):
    tree = ast.parse(inspect.getsource(importlib.import_module(law.__module__)))
    imported = [n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
    imported += [alias.name for n in ast.walk(tree) if isinstance(n, ast.Import) for alias in n.names]
    assert {name.partition(".")[0] for name in imported} <= sys.stdlib_module_names


# --- speed ---


def test_pi_of_a_constant_error():
    """torque = kp e + ki e t, the trapezoidal rule being exact for a constant."""
    law = SpeedPI(proportionalGain=0.5, integralGain=3.0, setPoint=6.0, stepTime=100.0, torqueLimit=100.0)
    torques = [law.step(i * H, H, {"speed": 4.0})["torque"] for i in range(1001)]
    expected = 0.5 * 2.0 + 3.0 * 2.0 * H * np.arange(1001)
    np.testing.assert_allclose(torques, expected, rtol=1000 * EPS)  # a thousand additions


def test_integral_is_of_second_order():
    """∫ sin over one second: the error falls by 4 when H is halved."""
    errors = []
    for n in (50, 100, 200):
        law = SpeedPI(proportionalGain=0.0, integralGain=1.0, setPoint=0.0, stepTime=100.0, torqueLimit=100.0)
        for i in range(n + 1):
            torque = law.step(i / n, 1 / n, {"speed": -math.sin(i / n)})["torque"]
        errors.append(abs(torque - (1.0 - math.cos(1.0))))
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.01)


def test_integral_does_not_wind_up():
    """Seconds at the limit leave the integral empty: the torque is kp e as soon as the error is small."""
    law = SpeedPI(proportionalGain=1.0, integralGain=10.0, setPoint=0.0, stepTime=100.0, torqueLimit=2.0)
    for i in range(5000):
        assert law.step(i * H, H, {"speed": -50.0})["torque"] == 2.0
    torque = law.step(5.0, H, {"speed": 0.5})["torque"]
    # one trapezoid between e = 50 and e = -0.5 is all that may have been added
    assert torque == pytest.approx(-0.5 + 10.0 * H * 0.5 * (50.0 - 0.5), rel=10 * EPS)


def test_set_point_steps_at_its_time():
    law = SpeedPI(setPoint=6.0, stepTime=1.0, stepHeight=2.0)
    assert [law.set_point(t) for t in (0.0, np.nextafter(1.0, 0.0), 1.0, 9.0)] == [6.0, 6.0, 8.0, 8.0]


# --- bearings ---


def forces(law: MagneticBearings, left: complex, right: complex, time: float = 0.0) -> np.ndarray:
    """Forces (left, right) as y + i z."""
    measured = {"left.y": left.real, "left.z": left.imag, "right.y": right.real, "right.z": right.imag}
    f = law.step(time, H, measured)
    return np.array([f["leftForce.y"] + 1j * f["leftForce.z"], f["rightForce.y"] + 1j * f["rightForce.z"]])


def test_derivative_starts_without_a_kick_and_follows_a_ramp():
    """v = rate (1 − ((2τ − H) / (2τ + H))ⁿ), the trapezoidal rule for τ ḟ = q − f."""
    tau, rate, start = 2e-3, 0.3, 0.7
    law = MagneticBearings(stiffness=0.0, damping=1.0, filterTime=tau, crossStiffness=0.0)
    velocities = [-forces(law, start + rate * i * H, 0.0)[0].real for i in range(50)]
    pole = (2 * tau - H) / (2 * tau + H)
    # f and q are near 1 and their difference is divided by τ
    np.testing.assert_allclose(velocities, rate * (1 - pole ** np.arange(50)), atol=50 * EPS / tau)


@given(left=st.complex_numbers(max_magnitude=1), right=st.complex_numbers(max_magnitude=1), angle=st.floats(-7, 7))
def test_bearings_know_no_direction(left, right, angle):
    """Positions turned about the rotor's axis give forces turned by the same angle, over several samples."""
    turned_law, law, turn = (MagneticBearings(forceLimit=1e9), MagneticBearings(forceLimit=1e9), np.exp(1j * angle))
    for scale in (1.0, -0.5, 2.0):
        expected = turn * forces(law, scale * left, scale * right)
        got = forces(turned_law, complex(scale * turn * left), complex(scale * turn * right))
        # gains up to 1.3e5 = P + 2 D / (2 τ + H) + 2 C / distance on positions up to 2
        np.testing.assert_allclose(got, expected, atol=20 * EPS * 2 * 1.3e5)


def test_cross_feedback_is_a_couple_that_turns_the_axis_to_zero():
    """A gyroscope's axis follows the torque: ṡ ∝ torque, so the torque of the pair has to point against the slope."""
    law = MagneticBearings(stiffness=0.0, damping=0.0, crossStiffness=2500.0, distance=0.2)
    slope = 1e-3 + 2e-3j
    left, right = forces(law, -0.1 * slope, 0.1 * slope)
    assert left == -right
    # r × F of forces across x at x = ±0.1, as (y, z) → complex: i x F
    torque = 1j * (0.1 * right - 0.1 * left)
    assert torque == pytest.approx(-2500.0 * 0.2 * slope, rel=10 * EPS)


def test_forces_are_limited_and_wait_for_the_start_time():
    law = MagneticBearings(forceLimit=3.0, startTime=1.0, crossStiffness=0.0)
    assert np.all(forces(law, 1.0 + 1.0j, -1.0j, time=0.999) == 0)
    np.testing.assert_array_equal(forces(law, 1.0 + 1.0j, -1.0j, time=1.0)[0], -3.0 - 3.0j)


@given(y=small, z=small)
def test_seal_pushes_along_the_forward_whirl(y, z):
    """No power in radial motion, q Ω r² in a forward whirl at Ω."""
    force = Seal(crossCoupling=2000.0).step(0.0, H, {"y": y, "z": z})
    fy, fz = force["force.y"], force["force.z"]
    assert fy * y + fz * z == pytest.approx(0.0, abs=4 * EPS * 2000.0)
    velocity = (-80.0 * z, 80.0 * y)
    assert fy * velocity[0] + fz * velocity[1] == pytest.approx(2000.0 * 80.0 * (y * y + z * z), rel=10 * EPS)


# --- attitude ---


def matrix(q: np.ndarray) -> np.ndarray:
    """R of the unit quaternion (w, u): I + 2 w ũ + 2 ũ²."""
    tilde = np.cross(np.eye(3), q[1:])
    return np.eye(3) + 2 * q[0] * tilde + 2 * tilde @ tilde


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def torque(law: AxisAttitude, q: np.ndarray, omega: np.ndarray, hold: float = 0.0) -> np.ndarray:
    measured = {f"quaternion[{i + 1}]": q[i] for i in range(4)} | {
        f"angularVelocity[{i + 1}]": omega[i] for i in range(3)
    }
    answer = law.step(0.0, hold, measured)
    return np.array([answer[f"torque[{i}]"] for i in (1, 2, 3)])


def pointing_at(direction: np.ndarray, **values: float) -> AxisAttitude:
    return AxisAttitude(**{f"target[{i + 1}]": float(direction[i]) for i in range(3)}, **values)


Y = np.array([0.0, 1.0, 0.0])
WEIGHT = AxisAttitude().values["weightMoment"]
TORQUES = 500.0 + WEIGHT  # N m, the size of what is added up


@given(q=rotation, spin=st.floats(-200, 200))
def test_at_its_target_the_law_only_holds_the_weight(q, spin):
    """For every orientation that points at the target, whatever its spin: τ + e × Rᵀ (0, 0, −g) = 0 and τ_y = 0."""
    axis = matrix(q) @ Y
    tau = torque(pointing_at(axis), q, spin * Y)
    gravity = np.cross(Y, matrix(q).T @ [0.0, 0.0, -WEIGHT])
    np.testing.assert_allclose(tau + gravity, 0.0, atol=20 * EPS * TORQUES)
    assert tau[1] == 0.0


@given(q=rotation, omega=vector, target=vector.filter(lambda v: np.linalg.norm(v) > 0.1), length=st.floats(0.1, 10.0))
def test_torque_depends_on_directions_alone(q, omega, target, length):
    """Same for −q and for a target of another length."""
    tau = torque(pointing_at(target), q, omega)
    np.testing.assert_array_equal(torque(pointing_at(target), -q, omega), tau)
    np.testing.assert_allclose(torque(pointing_at(length * target), q, omega), tau, atol=20 * EPS * TORQUES)


@given(q=rotation, turn=rotation, omega=vector, target=vector.filter(lambda v: np.linalg.norm(v) > 0.1))
def test_without_weight_space_has_no_direction(q, turn, omega, target):
    """World turned: body and target alike. The torque, seen in the body, does not change."""
    tau = torque(pointing_at(target, weightMoment=0.0), q, omega)
    turned = torque(pointing_at(matrix(turn) @ target, weightMoment=0.0), product(turn, q), omega)
    np.testing.assert_allclose(turned, tau, atol=40 * EPS * TORQUES)


@given(q=rotation, omega=vector)
def test_power_is_minus_damping_minus_change_of_potential(q, omega):
    """τ·ω = −d |ω⊥|² − d/dt (k (1 − e·Γ) − g e·Rᵀ e_z), by central differences along exp(s ω̃)."""
    law = AxisAttitude()
    k, d = law.values["stiffness"], law.values["damping"]

    def potential(s: float) -> float:
        angle = s * np.linalg.norm(omega)
        half = np.array([np.cos(angle / 2), *(s / 2 * np.sinc(angle / 2 / np.pi) * omega)])
        height = (matrix(product(q, half)) @ Y)[2]  # the default target is upright
        return k * (1 - height) - WEIGHT * height

    step = EPS ** (1 / 3)
    change = (potential(step) - potential(-step)) / (2 * step)
    expected = -d * (omega[0] ** 2 + omega[2] ** 2) - change
    # differences: truncation step² and rounding ε / step, both ≈ ε^(2/3), of values of this size
    assert torque(law, q, omega) @ omega == pytest.approx(expected, abs=10 * EPS ** (2 / 3) * TORQUES)


def test_mean_of_a_held_torque_points_where_it_should():
    """The body turns by ω_y H; seen from W, the held torque's mean is the wanted one times sinc(ω_y H / 2)."""
    spin, hold = 150.0, 2e-3
    q, omega = product(np.array([0.8, 0.6, 0.0, 0.0]), np.array([0.96, 0.0, 0.28, 0.0])), spin * Y
    wanted = matrix(q) @ torque(AxisAttitude(), q, omega)
    held = torque(AxisAttitude(), q, omega, hold)
    # Gauss-Legendre with 8 nodes: exact to rounding for an arc of 0.3 rad
    nodes, weights = np.polynomial.legendre.leggauss(8)
    angles = spin * hold * (1 + nodes) / 2
    turned = [matrix(product(q, np.array([np.cos(a / 2), 0.0, np.sin(a / 2), 0.0]))) @ held for a in angles]
    mean = weights @ turned / 2
    np.testing.assert_allclose(mean, np.sinc(spin * hold / 2 / np.pi) * wanted, atol=20 * EPS * TORQUES)


def test_target_without_direction_is_refused():
    with pytest.raises(ValueError, match=r"target is \[0.0, 0.0, 0.0\]"):
        torque(pointing_at(np.zeros(3)), np.array([1.0, 0, 0, 0]), np.zeros(3))
