"""Poles and matrices against closed forms."""

import numpy as np
import pytest

import sigmafmu
from sigmafmu import _core

MASS, LENGTH, GRAVITY = 15.0, 1.0, 9.81
AXIAL, TRANSVERSE = 0.46875, 0.234375 + MASS * LENGTH**2  # inertia of the heavy top about its pivot


def placed(quaternion, direction, spin):
    """Initial values of the heavy top with its centre of mass at `direction`, spinning about its axis."""
    return {
        "top.initialPosition": direction,
        "top.initialQuaternion": quaternion,
        "top.initialVelocity": [0, 0, 0],
        "top.initialAngularVelocity": [0, spin, 0],
    }


def upright(spin):
    return placed([np.sqrt(0.5), np.sqrt(0.5), 0, 0], [0, 0, 1], spin)


HANGING = placed([np.sqrt(0.5), -np.sqrt(0.5), 0, 0], [0, 0, -1], 0.0)


def test_hanging_top_swings_with_the_pendulum_frequency():
    model = sigmafmu.linearize("HeavyTop", parameters=HANGING)
    omega = np.sqrt(MASS * GRAVITY * LENGTH / TRANSVERSE)
    # two pendulum modes and the free rotation about the vertical, a double zero, which rounding splits by its root
    np.testing.assert_allclose(sorted(model.poles().imag), [-omega, -omega, 0, 0, omega, omega], atol=1e-6)
    np.testing.assert_allclose(model.poles().real, 0, atol=1e-6)
    assert model.is_equilibrium


@pytest.mark.parametrize("spin", [20.0, 300.0])  # below and above the spin that keeps the top upright, 202 rad/s
@pytest.mark.parametrize("frame", ["world", "body"])
def test_poles_of_an_upright_top_depend_on_the_frame(spin, frame):
    model = sigmafmu.linearize("HeavyTop", parameters=upright(spin), frame=frame)
    tilt = np.roots([TRANSVERSE, -1j * AXIAL * spin, -MASS * GRAVITY * LENGTH])  # of θx + i θy in W
    if frame == "body":
        tilt = tilt - 1j * spin
    expected = [*tilt, *tilt.conj(), 0, 0]
    found = list(model.poles())
    for pole in expected:
        nearest = min(found, key=lambda p: abs(p - pole))
        assert abs(nearest - pole) < 1e-5, (pole, model.poles())
        found.remove(nearest)
    assert model.is_steady
    assert not model.is_equilibrium


@pytest.mark.parametrize("frame", ["world", "body"])
def test_matrices_of_a_steady_spin_stay_the_same(frame):
    settings = upright(20.0) | {"integrator.stepSize": 1e-5}
    now, later = (
        sigmafmu.linearize("HeavyTop", at, parameters=settings, inputs=["top.torque"], frame=frame)
        for at in (0.0, 0.05)
    )
    np.testing.assert_allclose(later.A, now.A, atol=1e-8)
    # the torque's axes turn with the body, so only there is B constant
    assert np.allclose(later.B, now.B, atol=1e-8) == (frame == "body")


def test_rotor_translation_has_the_modes_of_its_springs():
    # without spin and torque, along x one spring and one damper act on the mass
    settings = {"rotor.initialAngularVelocity[1]": 0.0, "load.torque[3]": 0.0}
    model = sigmafmu.linearize("HighSpeedRotor", parameters=settings)
    mass, stiffness, damping = 1.223, 4000.0, 5.165093
    for pole in np.roots([mass, damping, stiffness]):
        assert np.abs(model.poles() - pole).min() < 1e-9 * abs(pole)
    i = model.states.index("rotor.velocity[1]")
    row = dict(zip(model.states, model.A[i], strict=True))
    assert row["rotor.position[1]"] == pytest.approx(-stiffness / mass, rel=1e-11)
    assert row["rotor.velocity[1]"] == pytest.approx(-damping / mass, rel=1e-11)


def test_beam_on_a_heavy_hub_has_the_modes_of_its_data():
    settings = {"gravity": [0, 0, 0], "hub.inertia.zz": 1e12, "hub.inertia.xx": 1e12, "hub.inertia.yy": 1e12}
    model = sigmafmu.linearize("SpinUpBeam", parameters=settings)
    modal = _core.mechanism("SpinUpBeam").multibody.bodies[1].modal
    stiffness = np.linalg.eigvals(np.linalg.solve(_modal_mass(modal), modal.stiffness))
    found = np.abs(model.poles()[np.abs(model.poles()) > 1e-3])
    np.testing.assert_allclose(sorted(found), np.repeat(np.sort(np.sqrt(stiffness.real)), 2), rtol=1e-6)


def _modal_mass(modal):
    shapes = np.asarray(modal.shapes).reshape(len(modal.nodes), 3, -1)
    masses = np.diag(modal.masses) if len(modal.masses) else np.asarray(modal.mass_matrix)
    return np.einsum("nci,nm,mcj->ij", shapes, masses, shapes)
