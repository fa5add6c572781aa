"""Linear-quadratic regulators designed from linear models hold the FMUs themselves."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

import sigmafmu
from sigmafmu import _core
from sigmafmu.instance import Instance

H = 1e-3


def regulator(model, Q, R):
    """K of u = −K x with the least ∫ xᵀQx + uᵀRu."""
    return np.linalg.solve(R, model.B.T @ solve_continuous_are(model.A, model.B, Q, R))


@pytest.mark.parametrize("gain", [0.0, 1.0])
def test_slider_crank_is_held_where_it_would_fall(fmu, gain):
    motor = ["crankPivot.motorTorque"]
    rest = sigmafmu.trim("SliderCrank", inputs=motor, hold={"crankPivot.angle": 0.5})
    model = sigmafmu.linearize(rest, inputs=motor, outputs=["crankPivot.angle"])
    assert model.poles().real.max() > 5
    K = gain * regulator(model, np.diag([100.0, 1.0]), np.eye(1))
    start = sigmafmu.trim("SliderCrank", inputs=motor, hold={"crankPivot.angle": 0.9})
    plant = fmu("SliderCrank")
    with Instance(plant, start.start_values()) as instance:
        instance.start()
        slave = instance.slave
        measured, driven = plant.references(list(model.states)), plant.references(motor)
        for i in range(3000):
            x = np.array(slave.getReal(measured)) - model.x0
            slave.setReal(driven, model.u0 - K @ x)
            slave.doStep(i * H, H)
        x = np.array(slave.getReal(measured)) - model.x0
    if gain:
        np.testing.assert_allclose(x, 0, atol=1e-6)
    else:
        assert abs(x[0]) > 1  # it has left: the comparison means something


@pytest.mark.parametrize("spin", [0.0, 20.0])  # 202 rad/s would keep it upright
@pytest.mark.parametrize("gain", [0.0, 1.0])
def test_heavy_top_is_held_upright(fmu, spin, gain):
    """Torques in body axes; the reference spins with the top."""

    def tilted(angle):
        half = np.pi / 4 + angle / 2
        return {
            "top.initialPosition": [0, -np.sin(angle), np.cos(angle)],
            "top.initialQuaternion": [np.cos(half), np.sin(half), 0, 0],
            "top.initialVelocity": [0, 0, 0],
            "top.initialAngularVelocity": [0, spin, 0],
        }

    model = sigmafmu.linearize("HeavyTop", parameters=tilted(0.0), inputs=["top.torque"], frame="body")
    assert model.is_steady
    assert model.poles().real.max() > 3
    K = gain * regulator(model, np.diag([1e4] * 3 + [1e2] * 3), np.eye(3))
    plant = fmu("HeavyTop")
    upright = _core.lie.rotation_matrix(np.array(tilted(0.0)["top.initialQuaternion"]))
    with Instance(plant, tilted(0.3)) as instance:
        instance.start()
        slave = instance.slave
        references = {
            name: plant.references([f"top.{name}[{i + 1}]" for i in range(n)])
            for name, n in (("quaternion", 4), ("angularVelocity", 3), ("torque", 3), ("position", 3))
        }

        def state(time):
            turned = _core.lie.rotation_matrix(_core.lie.exp(np.array([0.0, 0.0, spin * time])))
            here = _core.lie.rotation_matrix(np.array(slave.getReal(references["quaternion"])))
            small = (turned @ upright).T @ here
            rotation = np.array([small[2, 1] - small[1, 2], small[0, 2] - small[2, 0], small[1, 0] - small[0, 1]]) / 2
            velocity = np.array(slave.getReal(references["angularVelocity"])) - [0, spin, 0]
            return np.concatenate([rotation, velocity])

        for i in range(6000):
            slave.setReal(references["torque"], -K @ state(i * H))
            slave.doStep(i * H, H)
        height = slave.getReal(references["position"])[2]
        end = state(6000 * H)
    if gain:
        np.testing.assert_allclose(end, 0, atol=1e-4)
        assert height == pytest.approx(1.0, abs=1e-8)
    else:
        assert height < 0.9
