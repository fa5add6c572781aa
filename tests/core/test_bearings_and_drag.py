"""Bearings with cross-coupling and with axes that turn, quadratic drag: against closed forms."""

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import GROUND

FRAME = _core.Frame(np.zeros(3), np.eye(3))
ZERO = np.zeros(3)


def rotor(bearing, spin=0.0, start=1e-3, mass=2.0):
    """A shaft that spins about z, so heavy about it that nothing slows it down, displaced along x."""
    mechanism = _core.Mechanism("Rotor")
    shaft = _core.RigidBody()
    shaft.name, shaft.mass, shaft.inertia = "shaft", mass, np.array([6e5, 6e5, 1e6])
    shaft.initial_position = np.array([start, 0.0, 0.0])
    shaft.initial_angular_velocity = np.array([0.0, 0.0, spin])
    mechanism.multibody.add(shaft)
    mechanism.multibody.gravity = ZERO
    mechanism.multibody.add(bearing)
    return mechanism


def orbit(mechanism, stop, h):
    """x + i y at the end."""
    run = _core.Simulation(mechanism)
    run.advance(h, round(stop / h))
    return run.state.q[0] + 1j * run.state.q[1]


def exact(t, start, mass, rate, stiffness):
    """z(t) of m z'' + rate z' + stiffness z = 0 with complex constants, from rest."""
    roots = np.roots([mass, rate, stiffness])
    weights = np.linalg.solve([[1, 1], roots], [start, 0])
    return weights @ np.exp(roots * t)


def near(expected):
    """Up to (ω h)²/12 ω t, the error of the phase."""
    return pytest.approx(expected, abs=1e-5 * max(abs(expected), 1e-3))


@pytest.mark.parametrize("cross", [20.0, 80.0], ids=["damped", "oil whip"])
def test_cross_coupling_drives_an_orbit(cross):
    """k_xy = -k_yx = k_c: unstable where k_c > c ω, ω = √(k/m)."""
    stiffness, damping, mass = 200.0, 4.0, 2.0
    seal = _core.Bearing(
        "seal", GROUND, FRAME, 0, FRAME, stiffness * np.ones(3), damping * np.ones(3), np.array([cross, -cross])
    )
    expected = exact(2.0, 1e-3, mass, damping, stiffness - 1j * cross)
    assert (abs(expected) > 1e-3) == (cross > damping * np.sqrt(stiffness / mass))
    assert orbit(rotor(seal), 2.0, 1e-4) == near(expected)


@pytest.mark.parametrize("spin", [5.0, 15.0], ids=["below", "above the critical speed"])
def test_damping_that_turns_with_the_shaft(spin):
    """m z'' + c (z' - iΩ z) + k z = 0: unstable above Ω = √(k/m); with the axes of the housing it never is."""
    stiffness, damping, mass = 200.0, 2.0, 2.0
    constants = (stiffness * np.ones(3), damping * np.ones(3))
    turning = _core.Bearing("bearing", 0, FRAME, GROUND, FRAME, *constants)
    expected = exact(3.0, 1e-3, mass, damping, stiffness - 1j * damping * spin)
    assert (abs(expected) > 1e-3) == (spin > np.sqrt(stiffness / mass))
    assert orbit(rotor(turning, spin), 3.0, 1e-4) == near(expected)
    fixed = _core.Bearing("bearing", GROUND, FRAME, 0, FRAME, *constants)
    assert orbit(rotor(fixed, spin), 3.0, 1e-4) == near(exact(3.0, 1e-3, mass, damping, stiffness))


def falling(drag, spin=0.0):
    mechanism = _core.Mechanism("Fall")
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = "ball", 2.0, np.array([0.3, 0.3, 0.3])
    body.initial_angular_velocity = np.array([0.0, 0.0, spin])
    mechanism.multibody.add(body)
    mechanism.multibody.gravity = np.array([0.0, 0.0, -9.81])
    mechanism.multibody.add(drag)
    return mechanism


def test_a_fall_through_air():
    """v = v_∞ tanh(g t / v_∞), v_∞ = √(m g / c), against a wind that blows upwards."""
    coefficient, wind = 0.4, 3.0
    drag = _core.Drag("air", 0, ZERO, coefficient * np.ones(3), flow=np.array([0.0, 0.0, -wind]))
    mechanism = falling(drag)
    mechanism.multibody.body(0).initial_velocity = np.array([0.0, 0.0, -wind])
    slave = _core.Slave(mechanism)
    slave.start()
    for i in range(1000):
        slave.do_step(i * 1e-3, 1e-3)
    terminal = np.sqrt(2.0 * 9.81 / coefficient)
    assert slave.get("ball.velocity[3]") == pytest.approx(-wind - terminal * np.tanh(9.81 / terminal), rel=1e-6)
    fallen = wind + terminal**2 / 9.81 * np.log(np.cosh(9.81 / terminal))
    assert slave.get("ball.position[3]") == pytest.approx(-fallen, rel=1e-6)
    against = slave.get("ball.velocity[3]") + wind
    assert slave.get("air.force[3]") == pytest.approx(coefficient * against**2, rel=1e-12)


def test_a_spin_dies_away():
    """J w' = -c w²: w = w_0 / (1 + c w_0 t / J)."""
    drag = _core.Drag("air", 0, ZERO, ZERO, rotational=np.array([0.0, 0.0, 0.02]))
    run = _core.Simulation(falling(drag, 40.0))
    run.advance(1e-3, 1000)
    assert run.state.v[5] == pytest.approx(40.0 / (1 + 0.02 * 40.0 / 0.3), rel=1e-5)
