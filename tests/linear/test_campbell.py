"""Campbell diagrams against closed forms of rigid rotors."""

import numpy as np
import pytest
from typer.testing import CliRunner

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.cli import app

MASS, POLAR, TRANSVERSE = 1.223, 0.001541, 0.000812
PLACES, STIFFNESS, DAMPING = np.array([-0.11, 0.09]), 4000.0, 5.165093
AXIS = "rotor.angularVelocityW[1]"
UPRIGHT = {"load.torque[3]": 0.0}
SHAFT = """
sigmafmu: 1
name: Shaft
gravity: [0, 0, 0]
bodies:
  housing: {mass: 4, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0]}
  rotor: {mass: 1, inertia: [0.002, %s, 0.001], position: [0, 0, 0]}
joints:
  shaft: {type: revolute, bodies: [housing, rotor], point: [0, 0, 0], axis: [1, 0, 0]}
forces:
  mount:
    type: bushing
    bodies: [ground, housing]
    point: [0, 0, 0]
    stiffness: [9e4, 4e4, 4e4]
    torsional_stiffness: [900, 200, 200]
"""


def closed_form(speed):
    """Poles of q = (y + i z, φ): M q̈ + (D − i Ω G) q̇ + K q = 0."""
    moments = np.array([[2, PLACES.sum()], [PLACES.sum(), (PLACES**2).sum()]])
    inverse = np.diag([1 / MASS, 1 / TRANSVERSE])
    rates = DAMPING * moments - 1j * speed * np.diag([0, POLAR])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ (STIFFNESS * moments), -inverse @ rates]])
    return np.linalg.eigvals(system)


@pytest.fixture(scope="module")
def rotor():
    return sigmafmu.load("HighSpeedRotor").campbell(AXIS, np.linspace(0, 600, 25), parameters=UPRIGHT)


def test_poles_are_those_of_the_rigid_rotor(rotor):
    for speed, poles in zip(rotor.speeds, rotor.poles, strict=True):
        for pole in closed_form(speed):
            assert np.abs(poles - pole).min() < 1e-7 * abs(pole), (speed, pole)


def test_critical_speeds_are_those_of_the_rigid_rotor(rotor):
    """Where a pole of the closed form has |Im λ| = Ω; positive Im λ is forward whirl."""

    def excess(speed, sign):
        return sign * closed_form(speed).imag - speed

    whirling = [c for c in rotor.critical if c.whirl != "plane"]
    assert [c.whirl for c in whirling] == ["backward", "forward", "backward"]
    for critical in whirling:
        sign = 1 if critical.whirl == "forward" else -1
        assert np.abs(excess(critical.speed, sign)).min() < 1e-6 * critical.speed
    (axial,) = (c for c in rotor.critical if c.whirl == "plane")  # of one spring and one damper along the axis
    assert axial.speed == pytest.approx(np.roots([MASS, DAMPING, STIFFNESS])[0].imag, rel=1e-8)


def test_columns_are_continuous(rotor):
    """No mode changes its place: each step is small against the distance of the frequencies."""
    steps = np.abs(np.diff(rotor.poles, axis=0)).max(axis=0)
    assert (steps < 80).all()  # rad/s; nutation moves by 2 Ω per speed


def test_a_rotor_in_a_joint(tmp_path):
    """A gyroscope in a housing on springs: Jt θ̈ − i Ω Jp θ̇ + k θ = 0, with Jt that of both bodies."""
    file = tmp_path / "Shaft.yaml"
    file.write_text(SHAFT % "0.001", encoding="utf-8")
    found = sigmafmu.load(file).campbell("shaft.angularRate", np.linspace(0, 500, 11))
    for speed, poles in zip(found.speeds, found.poles, strict=True):
        for pole in np.roots([0.021, -1j * speed * 0.002, 200.0]):
            assert np.abs(poles - pole).min() < 1e-6 * abs(pole)
    (speed,) = (c.speed for c in found.critical if c.whirl == "forward" and c.speed < 110)
    assert speed == pytest.approx(np.sqrt(200.0 / (0.021 - 0.002)), rel=1e-8)


def test_a_rotor_that_is_not_symmetric_is_refused(tmp_path):
    file = tmp_path / "Shaft.yaml"
    file.write_text(SHAFT % "0.0015", encoding="utf-8")
    with pytest.raises(SigmafmuError, match=r"Shaft is not symmetric about the axis of shaft\.angularRate"):
        sigmafmu.load(file).campbell("shaft.angularRate", [100.0, 200.0])


@pytest.mark.parametrize("speeds", [[1.0], [2.0, 1.0], [0.0, np.inf], [-1.0, 1.0]])
def test_speeds_increase(speeds):
    with pytest.raises(SigmafmuError, match="two or more speeds that increase"):
        sigmafmu.load("HighSpeedRotor").campbell(AXIS, speeds)


def test_the_command_tells_critical_speeds_and_draws(tmp_path):
    png, table = tmp_path / "campbell.png", tmp_path / "campbell.csv"
    options = ["--rate", AXIS, "--from", "60", "--to", "120", "--points", "7", "--set", "load.torque[3]=0"]
    command = ["campbell", "HighSpeedRotor", *options, "--plot", str(png), "--output", str(table)]
    result = CliRunner().invoke(app, command, catch_exceptions=False)
    assert result.exit_code == 0
    assert "critical: 80.3904 rad/s (767.672 rpm), forward" in result.stdout
    assert png.read_bytes().startswith(b"\x89PNG")
    assert np.loadtxt(table, delimiter=",", skiprows=1).shape == (7, 37)
