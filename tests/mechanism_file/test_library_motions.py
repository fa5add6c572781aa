"""Mechanisms of the library against motions in few coordinates and closed forms: errors, and the order of them."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from sigmafmu import _core
from sigmafmu.linear.linearization import linearize
from sigmafmu.linear.point import OperatingPoint
from sigmafmu.mechanism_file.load import load

from . import library_motions as motions
from .helpers import LIBRARY, read


def run(name, names, times, h, **values):
    """Values of variables at equal times, with internal steps of h."""
    mechanism = load(LIBRARY / f"{name}.yaml").mechanism
    mechanism.integrator.step_size = h
    slave = _core.Slave(mechanism)
    for variable, value in values.items():
        slave.set(variable.replace("__", "."), value)
    slave.start()
    rows = [[slave.get(n) for n in names]]
    for t, after in pairwise(times):
        slave.do_step(t, after - t)
        rows.append([slave.get(n) for n in names])
    return np.array(rows)


def assert_second_order(name, names, times, h, expected, error, **values):
    """With h the error is below `error`, with half of it a quarter; without that term next to nothing is left."""
    coarse, fine = (run(name, names, times, step, **values) for step in (h, h / 2))
    errors = [np.abs(found - expected).max() for found in (coarse, fine)]
    assert errors[0] < error, errors
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1), errors
    assert np.abs((4 * fine - coarse) / 3 - expected).max() < 0.02 * errors[0]


def vectors(*names):
    return [f"{name}[{i}]" for name in names for i in (1, 2, 3)]


def test_a_stewart_platform_on_six_springs_with_actuators():
    forces = np.array([300.0, -100.0, 50.0, 200.0, 0.0, -150.0])
    minimal = motions.stewart_platform(forces)
    times = np.linspace(0, 0.2, 11)
    q, _ = minimal.motion(np.zeros(6), np.zeros(6), times)
    x, R = minimal.places(q)
    expected = np.column_stack([x[:, 0], motions.rotation_vectors(R[:, 0]), minimal.springs(q)])
    assert np.ptp(expected, axis=0).min() > 1e-3  # all of it moves
    names = [*vectors("platform.position", "platform.rotationVector"), *(f"leg{i}.displacement" for i in range(1, 7))]
    inputs = {f"leg{i}__actuatorForce": force for i, force in enumerate(forces, 1)}
    assert_second_order("StewartPlatform", names, times, 2e-3, expected, 2e-5, **inputs)


def test_a_double_wishbone_in_bushings():
    minimal = motions.double_wishbone()
    times = np.linspace(0, 0.1, 11)
    q, _ = minimal.motion(np.zeros(7), np.array([0, 0, 0, 0, 0, 0, 60.0]), times)
    x, R = minimal.places(q)
    expected = np.column_stack([x[:, [0, 1, 2, 4]].reshape(-1, 12), motions.rotation_vectors(R[:, 2]), q[:, 6]])
    names = vectors(*(f"{body}.position" for body in ("lowerArm", "upperArm", "knuckle", "wheel")))
    names += [*vectors("knuckle.rotationVector"), "hub.angle"]
    assert np.ptp(x[:, 4], axis=0).max() > 4e-3
    assert_second_order("DoubleWishbone", names, times, 2e-4, expected, 1e-6)


def test_an_arm_of_seven_joints():
    minimal = motions.robot_arm()
    times = np.linspace(0, 0.3, 7)
    start = np.radians([[20, -35, 10, 70, 0, 45, 0], [0, 10, 0, -20, 0, 0, 60]])
    q, v = minimal.motion(*start, times)
    names = [f"joint{i}.angle" for i in range(1, 8)] + [f"joint{i}.angularRate" for i in range(1, 8)]
    assert_second_order("RobotArm", names, times, 2e-3, np.column_stack([q, v]), 1e-4)


def test_a_crank_rocker_at_a_prescribed_speed():
    """Angles of the rocker are geometry; the drive's torque is that of the motion."""
    times = np.linspace(0, 0.5, 51)
    speed = 4 * np.pi
    crank = np.pi / 3 + speed * times
    names = ["rockerShaft.angle", "rockerShaft.angularRate", "crankShaft.driveTorque"]
    found = run("CrankRocker", names, times, 5e-4)
    _, psi = motions.crank_rocker_angles(crank)
    assert np.ptp(psi) > 0.5
    assert np.abs(-np.diff(psi) - np.diff(found[:, 0])).max() < 1e-11  # that of the ground in the rocker
    minimal = motions.crank_rocker()
    torque = [minimal.drive(np.array([angle]), np.array([speed]), np.zeros(1))[0] for angle in crank]
    assert np.ptp(torque) > 1
    assert np.abs(found[:, 2] - torque).max() < 1e-9  # no freedom is left, and nothing to integrate


def test_a_cardan_shaft():
    """The first joint makes the shaft run unevenly by cos β / (1 - sin² β sin² φ), the second one makes it good."""
    speed, times = 30.0, np.linspace(0, 0.3, 61)
    phi = speed * times
    names = ["outputShaft.angle", "outputShaft.angularRate", "tube.angularVelocity[1]", "inputShaft.driveTorque"]
    found = run("CardanShaft", names, times, 2.5e-4)
    assert np.abs(found[:, 0] - phi).max() < 1e-11
    assert np.abs(found[:, 1] - speed).max() < 1e-9
    beta = motions.BEND
    ratio = np.cos(beta) / (1 - np.sin(beta) ** 2 * np.sin(phi) ** 2)
    assert np.ptp(ratio) > 0.2
    assert np.abs(found[:, 2] / speed - ratio).max() < 1e-9
    minimal = motions.cardan_shaft()
    torque = np.array([minimal.drive(np.array([angle]), np.array([speed]), np.zeros(1)) for angle in phi])
    assert np.abs(torque).max() > 0.1
    assert np.abs(found[:, 3:] - torque).max() < 1e-9


def linear_motion(M, damping, load, times):
    """Rates of M w' + D w = load from rest."""
    A, b = -np.linalg.solve(M, damping), np.linalg.solve(M, load)
    n = len(b)
    return np.array([expm(np.block([[A, b[:, None]], [np.zeros((1, n + 1))]]) * t)[:n, n] for t in times])


def test_a_planetary_gear():
    """Willis: 30 sun + 70 ring = 100 carrier, by the rates of sun and carrier; planets turn with 30 (c - s) / 20."""
    sun, carrier = np.eye(2)
    ring = (100 * carrier - 30 * sun) / 70
    planet = carrier + 1.5 * (carrier - sun)
    wheels = ((3e-4, sun), (1.5e-3 + 3 * 0.2 * 0.05**2, carrier), (6e-3, ring), (3 * 5e-5, planet))
    M = sum(J * np.outer(rate, rate) for J, rate in wheels)
    damping = 0.2 * np.outer(carrier, carrier) + 0.5 * np.outer(ring, ring)
    times = np.linspace(0, 0.5, 26)
    rates = linear_motion(M, damping, 0.3 * sun, times)
    expected = rates @ np.column_stack([sun, carrier, ring, planet - carrier])
    names = ["sunShaft.angularRate", "carrierShaft.angularRate", "ringShaft.angularRate", "pin2.angularRate"]
    assert np.abs(expected[-1]).min() > 0.1
    assert_second_order("PlanetaryGear", names, times, 2e-3, expected, 2e-3)


def test_a_bevel_differential():
    """The carrier has the mean rate of both sides, the planet on it their difference."""
    left, right = np.eye(2)
    carrier, planet = (left + right) / 2, left - right
    carried = 0.012 + 2 * (2e-4 + 0.4 * 0.05**2)  # about x, with both planets
    M = 0.15 * np.eye(2) + carried * np.outer(carrier, carrier) + 2 * 3.5e-4 * np.outer(planet, planet)
    times = np.linspace(0, 1, 26)
    rates = linear_motion(M, np.diag([0.1, 0.6]), 2 * carrier, times)
    expected = rates @ np.column_stack([left, right, carrier, planet])
    names = ["leftShaft.angularRate", "rightShaft.angularRate", "carrierShaft.angularRate", "pin1.angularRate"]
    assert np.abs(expected[-1]).min() > 1
    assert_second_order("BevelDifferential", names, times, 2e-2, expected, 4e-4)


def whirl(speed=120.0, inner=8.0, cross=0.0):
    """Poles of the JeffcottRotor at a speed, in the middle of its bearing."""
    text = (LIBRARY / "JeffcottRotor.yaml").read_text(encoding="utf-8")
    for old, new in {
        "120 rad/s": f"{speed!r} rad/s",
        "1 mm": "0",
        "[8, 8, 0]": f"[{inner!r}, {inner!r}, 0]",
        "[4, 4, 0]": f"[4, 4, 0], cross_stiffness: [{cross!r}, {-cross!r}]",
    }.items():
        assert old in text
        text = text.replace(old, new)
    mechanism = read(text).mechanism
    state = _core.Simulation(mechanism).state
    u = np.zeros(_core.System(mechanism.multibody).input_size)
    return linearize(OperatingPoint(mechanism, state.q, state.v, u, state.turned)).poles()


def exact_whirl(speed, inner, cross=0.0):
    """Of m z'' + (outer + inner) z' + (k - i (speed inner + cross)) z = 0, z = x + i y."""
    roots = np.roots([1.0, 4.0 + inner, 1e4 - 1j * (speed * inner + cross)])
    return np.concatenate([roots, roots.conj()])


def sorted_poles(poles):
    return np.array(sorted(poles, key=lambda p: (round(p.imag, 6), p.real)))


@pytest.mark.parametrize("speed", [0.0, 60.0, 149.0, 151.0, 400.0])
def test_whirl_of_a_jeffcott_rotor(speed):
    found = sorted_poles(whirl(speed))
    assert np.abs(found - sorted_poles(exact_whirl(speed, 8.0))).max() < 1e-9


def threshold(growth, low, high):
    """Where the largest real part is zero."""
    return brentq(growth, low, high, xtol=1e-10)


def test_a_jeffcott_rotor_becomes_unstable_where_it_should():
    """Inner damping: above the critical speed (1 + outer/inner); cross-coupling: above the damping times that speed."""
    assert threshold(lambda speed: whirl(speed).real.max(), 100, 200) == pytest.approx(100 * (1 + 4 / 8), rel=1e-8)
    assert threshold(lambda k: whirl(0.0, 0.0, k).real.max(), 100, 900) == pytest.approx(4 * 100, rel=1e-8)


def test_a_jeffcott_rotor_grows_as_its_pole_says():
    """The orbit after 0.3 s, for a start that has all of both whirls."""
    times = np.linspace(0, 0.3, 31)
    forward, backward = np.roots([1.0, 12.0, 1e4 - 1j * 120 * 8.0])
    start = 1e-3
    a = (0 - backward * start) / (forward - backward)
    z = a * np.exp(forward * times) + (start - a) * np.exp(backward * times)
    expected = np.column_stack([z.real, z.imag])
    names = ["disk.position[1]", "disk.position[2]"]
    assert_second_order("JeffcottRotor", names, times, 1e-3, expected, 1e-5)


def test_a_coin_that_rolls():
    minimal, allowed = motions.rolling_coin()
    times = np.linspace(0, 0.4, 11)
    lean, heading = np.pi / 6, 3 / np.cos(np.pi / 6)
    u = np.array([heading, 1.0, 15 - heading * np.sin(lean)])
    q, v = minimal.rolling(np.array([0, 0, 0, lean, 0]), u, times, allowed)
    x, R = minimal.places(q)
    assert np.ptp(q, axis=0).min() > 0.05  # all of it moves
    names = vectors("coin.position", "coin.velocity", "coin.angularVelocity", "table.contactPoint")
    R, (heading, lean, turn) = R[:, 0], v[:, 2:].T
    ahead = motions.turned(q[:, 2, None] * motions.Z)[:, :, 0]
    spin = heading[:, None] * motions.Z + lean[:, None] * ahead + turn[:, None] * R[:, :, 1]
    velocity = np.column_stack([v[:, :2], -0.1 * np.sin(q[:, 3]) * v[:, 3]])
    touching = x[:, 0] - 0.1 * np.cross(ahead, R[:, :, 1])
    expected = np.column_stack([x[:, 0], velocity, np.einsum("tij,ti->tj", R, spin), touching])
    assert np.abs(touching[:, 2]).max() < 1e-12
    assert_second_order("RollingCoin", names, times, 1e-3, expected, 2e-3)
