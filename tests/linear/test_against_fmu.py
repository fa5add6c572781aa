"""Linear models against differences of the FMUs themselves."""

import numpy as np
import pytest

import sigmafmu
from research.linear import EXPERIMENTS, TIMES, check, points
from sigmafmu import _core
from sigmafmu.instance import Instance

LARGEST = {"point": 1e-8, "A": 1e-7, "B": 1e-8, "C": 5e-6, "D": 1e-9}
"""C includes reactions, whose differences lose digits to the FMU's own projection onto the constraints."""
JOINT_ACCELERATION = 5e-6
"""For A of SpinUpBeam: the FMU tells its joint's acceleration by a difference over 2 µs, known to 1e-9."""

NEW = 1e-4
"""For mechanisms whose FMU's rounding nobody has looked at."""


@pytest.mark.slow
@pytest.mark.parametrize("model", _core.mechanisms())
def test_matrices_are_differences_of_the_fmu(model):
    """At ten times of a motion with constant inputs."""
    found = [check(point) for point in points(model)]
    assert len(found) == TIMES == 10
    largest = LARGEST if model in EXPERIMENTS else dict.fromkeys(LARGEST, NEW)
    if model == "SpinUpBeam":
        largest = largest | {"A": JOINT_ACCELERATION}
    for name in largest:
        assert max(getattr(differences, name) for differences in found) < largest[name], name


@pytest.mark.parametrize("model", ["HeavyTop", "HighSpeedRotor", "FlexiblePendulum"])
def test_matrices_in_body_axes_are_differences_of_the_fmu(model):
    for point in list(points(model))[::4]:
        differences = check(point, "body")
        for name, largest in LARGEST.items():
            assert getattr(differences, name) < largest, name


def test_a_wrong_matrix_is_noticed(monkeypatch):
    """The comparison can fail: one entry of A off by a millionth."""
    from dataclasses import replace

    from research import linear as module

    def wrong(point, **options):
        model = sigmafmu.linearize(point, **options)
        A = model.A.copy()
        A[1, 0] *= 1 + 1e-6
        return replace(model, A=A)

    monkeypatch.setattr(module, "linearize", wrong)
    assert LARGEST["A"] < check(next(points("SliderCrank"))).A


@pytest.mark.parametrize(
    ("model", "free", "hold", "push", "outputs"),
    [
        ("SliderCrank", ["crankPivot.motorTorque"], {"crankPivot.angle": 0.5}, 1e-4, ["*.angle", "guide.*"]),
        ("FlexibleSliderCrank", ["crankPivot.motorTorque"], {"crankPivot.angle": 0.5}, 1e-4, ["*.angle", "rod.modal"]),
        ("FlexiblePendulum", ["beam.torque[2]"], {}, 1e-3, ["tip.position[1]", "beam.modal"]),
        ("SpinUpBeam", ["hubPivot.motorTorque"], {}, 1.0, ["*.angle", "beam.modal"]),
        ("HighSpeedRotor", ["rotor.force[2]"], {}, 1e-2, ["rotor.position", "leftSupport.force"]),
    ],
)
def test_response_to_a_step_is_that_of_the_fmu(fmu, model, free, hold, push, outputs):
    """The discrete model about an equilibrium and the FMU, after a small step of inputs."""
    rest = sigmafmu.trim(model, inputs=free if hold else (), hold=hold)
    H, steps = 2e-3, 200
    linear = sigmafmu.linearize(rest, inputs=free, outputs=outputs).to_discrete(H)
    u, x = np.full(len(linear.inputs), push), np.zeros(len(linear.x0))
    plant = fmu(model)
    accurate = {"integrator.method": "rkmk4", "integrator.stepSize": 1e-4}
    found, expected = [], []
    with Instance(plant, accurate | rest.start_values()) as instance:
        instance.start()
        slave = instance.slave
        references = plant.references(list(linear.outputs))
        start = np.array(slave.getReal(references))
        slave.setReal(plant.references(list(linear.inputs)), linear.u0 + u)
        for i in range(steps):
            slave.doStep(i * H, H)
            x = linear.A @ x + linear.B @ u
            found.append(np.array(slave.getReal(references)) - start)
            expected.append(linear.C @ x + linear.D @ u)
    scale = np.abs(expected).max(axis=0)
    moving = scale > 1e-6 * scale.max()
    error = np.abs(np.array(found) - expected).max(axis=0)[moving] / scale[moving]
    assert error.max() < 5e-3, error
