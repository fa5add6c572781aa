"""The benchmark bicycle: poles of `linearize` against the published matrices and numbers.

J. P. Meijaard, J. M. Papadopoulos, A. Ruina, A. L. Schwab, Proc. R. Soc. A 463 (2007) 1955: M φ'' + v C1 φ' +
(g K0 + v² K2) φ = 0 for lean and steer.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.optimize import brentq

from sigmafmu import _core
from sigmafmu.linear.linearization import linearize
from sigmafmu.linear.point import OperatingPoint
from sigmafmu.mechanism_file.load import load_text

FILE = Path(__file__).parents[2] / "models" / "library" / "Bicycle.yaml"
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])
C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
GRAVITY = 9.81
RADII = {"rearWheel": 0.3, "frontWheel": 0.35}


def published(speed):
    """Poles of the published matrices."""
    A = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(M, GRAVITY * K0 + speed**2 * K2), -np.linalg.solve(M, speed * C1)],
        ]
    )
    return np.linalg.eigvals(A)


def upright(speed):
    """The linear model of the bicycle that rides straight ahead."""
    content = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    for name, body in content["bodies"].items():
        body["velocity"] = [speed, 0, 0]
        body["angular_velocity"] = [0, speed / RADII[name] if name in RADII else 0, 0]
    mechanism = load_text(json.dumps(content), FILE).mechanism
    q, v = _core.assemble(mechanism.multibody)
    inputs = _core.Outputs(mechanism).inputs
    turned = _core.System(mechanism.multibody).coordinates(q, v)[0]
    return linearize(OperatingPoint(mechanism, q, v, np.zeros(len(inputs)), turned))


def nearest(poles, pole):
    return poles[np.abs(poles - pole).argmin()]


@pytest.mark.parametrize("speed", [0.0, 1.0, 3.0, 5.0, 8.0])
def test_poles_are_those_of_the_published_matrices(speed):
    model = upright(speed)
    assert len(model.states) == 10
    poles = model.poles()
    for pole in published(speed):
        assert abs(nearest(poles, pole) - pole) < 1e-10 * (1 + abs(pole))
    assert np.sum(np.abs(poles) < 1e-4) == 6  # path, heading, both wheels and the speed


def test_poles_at_5_m_per_s_are_the_published_ones():
    poles = upright(5.0).poles()
    for pole in (-0.775341882195845 + 4.464867713788229j, -0.322866429004087, -14.07838969279822):
        assert abs(nearest(poles, pole) - pole) < 1e-11


def test_states_are_seven_coordinates_and_three_rates():
    model = upright(5.0)
    coordinates = [
        "rearHub.angle",
        "steering.angle",
        "frontHub.angle",
        "frame.position[1]",
        "frame.position[2]",
        "frame.rotationW[1]",
        "frame.rotationW[3]",
    ]
    rates = ["rearHub.angularRate", "steering.angularRate", "frame.angularVelocityW[1]"]
    assert list(model.states) == [*coordinates, *rates]
    A = dict(zip(model.states, np.array(model.A).T, strict=True))
    row = model.states.index("frame.position[2]")
    assert A["frame.rotationW[3]"][row] == pytest.approx(5.0, abs=1e-9)  # y' = v heading + ...
    row = model.states.index("frontHub.angle")
    assert A["rearHub.angularRate"][row] == pytest.approx(0.3 / 0.35, abs=1e-9)


def lean_and_steer(speed):
    """The part of A of these and their rates, which nothing else acts on."""
    model = upright(speed)
    names = ("frame.rotationW[1]", "steering.angle", "frame.angularVelocityW[1]", "steering.angularRate")
    chosen = [model.states.index(name) for name in names]
    A = np.array(model.A)[chosen]
    assert np.abs(np.delete(A, chosen, axis=1)).max() < 1e-8
    return A[:, chosen]


def test_weave_and_capsize_become_stable_and_unstable_where_published():
    weave = brentq(lambda v: max(p.real for p in np.linalg.eigvals(lean_and_steer(v)) if p.imag > 1), 4.0, 4.6)
    capsize = brentq(lambda v: np.linalg.det(lean_and_steer(v)), 5.5, 6.5)
    assert weave == pytest.approx(4.29238253634111, abs=1e-9)
    assert capsize == pytest.approx(6.02426201538837, abs=1e-9)


def test_it_stays_upright_by_itself():
    """The push of the file dies away as the slowest poles say."""
    from sigmafmu.mechanism_file.load import load

    slave = _core.Slave(load(FILE).mechanism)
    slave.start()
    energy = slave.get("energy.total")
    slave.do_step(0, 5.0)
    assert abs(slave.get("steering.angle")) < 0.05
    assert slave.get("energy.total") == pytest.approx(energy, rel=1e-5)
    assert slave.get("constraint.positionResidual") < 1e-9
    assert slave.get("constraint.velocityResidual") < 1e-6
