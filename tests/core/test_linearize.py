"""The linear model against closed forms and against the motion of the nonlinear mechanism."""

import numpy as np
import pytest

from sigmafmu import SigmafmuError, _core
from sigmafmu.linearize import linearize, linearize_at

MASS, LENGTH, GRAVITY, INERTIA = 15.0, 1.0, 9.81, 0.234375
HANGING = {  # HeavyTop without spin, its axis along -z
    "top.initialPosition[2]": 0.0,
    "top.initialPosition[3]": -1.0,
    "top.initialQuaternion[1]": np.sqrt(0.5),
    "top.initialQuaternion[2]": -np.sqrt(0.5),
    "top.initialVelocity[1]": 0.0,
    "top.initialAngularVelocity[2]": 0.0,
    "top.initialAngularVelocity[3]": 0.0,
}


def test_hanging_top_swings_with_the_pendulum_frequency():
    poles = np.linalg.eigvals(linearize("HeavyTop", settings=HANGING).A)
    omega = np.sqrt(MASS * GRAVITY * LENGTH / (INERTIA + MASS * LENGTH**2))
    # two pendulum modes and the free rotation about the vertical, a double zero, which rounding splits by its root
    np.testing.assert_allclose(sorted(poles.imag), [-omega, -omega, 0, 0, omega, omega], atol=1e-6)
    np.testing.assert_allclose(poles.real, 0, atol=1e-6)


def test_rotor_translation_has_the_modes_of_its_springs():
    # without spin and torque, along x one spring and one damper act on the mass
    settings = {"rotor.initialAngularVelocity[1]": 0.0, "load.torque[3]": 0.0}
    model = linearize("HighSpeedRotor", settings=settings)
    mass, stiffness, damping = 1.223, 4000.0, 5.165093
    expected = np.roots([mass, damping, stiffness])
    poles = np.linalg.eigvals(model.A)
    for pole in expected:
        assert np.abs(poles - pole).min() < 1e-6 * abs(pole)


@pytest.mark.parametrize(("model", "at"), [("HeavyTop", 0.3), ("SliderCrank", 0.3), ("SliderCrank", 0.25)])
def test_state_matrix_describes_neighbouring_motions(model, at):
    """(x(t + τ) − x(t)) / τ of neighbouring motions, extrapolated to τ = 0, is A x."""
    mechanism = _core.mechanism(model)
    start = _core.Simulation(mechanism)
    start.run(at, round(at / mechanism.integrator.step_size))
    q, v = start.state.q.copy(), start.state.v.copy()
    linear = linearize_at(mechanism, q, v, at)
    coarse, fine = _differences(mechanism, q, v, linear.basis, 2e-5), _differences(mechanism, q, v, linear.basis, 1e-5)
    scale = np.abs(linear.A).max()
    np.testing.assert_allclose(2 * fine - coarse, linear.A, atol=2e-5 * scale)


def _differences(mechanism, q, v, basis, tau):
    system = _core.System(mechanism.multibody)
    n = basis.shape[1]

    def particular(q, v, basis):
        _, _, constraint, rate = system.constraints(q, v)
        return -np.linalg.pinv(constraint) @ rate @ basis

    def advanced(q, v):
        simulation = _core.Simulation(mechanism)
        simulation.state.q, simulation.state.v = q, v
        simulation.start()
        simulation.run(simulation.state.time + tau, 4)
        return simulation.state.q.copy(), simulation.state.v.copy()

    q_end, v_end = advanced(q, v)
    constraint = system.constraints(q_end, v_end)[2]
    carried = basis - np.linalg.pinv(constraint) @ constraint @ basis
    drift, drift_end = particular(q, v, basis), particular(q_end, v_end, carried)
    result = np.zeros((2 * n, 2 * n))
    size = 1e-5
    for k in range(2 * n):
        x = np.eye(2 * n)[k]
        motion = velocity = 0
        for sign in (1, -1):
            near_q = system.project_positions(system.compose(q, sign * size * basis @ x[:n]))
            near_v = system.project_velocities(near_q, v + sign * size * (basis @ x[n:] + drift @ x[:n]))
            near_q, near_v = advanced(near_q, near_v)
            motion = motion + sign * _motion(q_end, near_q) / (2 * size)
            velocity = velocity + sign * near_v / (2 * size)
        xi = np.linalg.lstsq(carried, motion, rcond=None)[0]
        eta = np.linalg.lstsq(carried, velocity - drift_end @ xi, rcond=None)[0]
        result[:, k] = (np.concatenate([xi, eta]) - x) / tau
    return result


def _motion(q0, q1):
    """The motion from q0 to q1: per body translation in W and rotation vector in B."""
    parts = []
    for a, b in zip(q0.reshape(-1, 7), q1.reshape(-1, 7), strict=True):
        w0, r0 = a[3], -a[4:]
        w1, r1 = b[3], b[4:]
        quaternion = np.concatenate([[w0 * w1 - r0 @ r1], w0 * r1 + w1 * r0 + np.cross(r0, r1)])
        parts += [b[:3] - a[:3], _core.lie.log(quaternion)]
    return np.concatenate(parts)


@pytest.mark.parametrize("model", ["HeavyTop", "HighSpeedRotor", "SliderCrank"])
def test_output_matrices_are_derivatives_of_outputs(model):
    mechanism = _core.mechanism(model)
    simulation = _core.Simulation(mechanism)
    simulation.run(0.01, round(0.01 / mechanism.integrator.step_size))
    q, v = simulation.state.q.copy(), simulation.state.v.copy()
    linear = linearize_at(mechanism, q, v)
    output = _core.Outputs(mechanism)
    system = _core.System(mechanism.multibody)
    u = np.zeros(system.input_size)
    nominal = output.values(q, v, u)
    for j in range(system.input_size):  # outputs are affine in inputs
        difference = output.values(q, v, np.eye(system.input_size)[j]) - nominal
        np.testing.assert_allclose(linear.D[:, j], difference, atol=1e-9 * (1 + np.abs(nominal).max()))
    rates = [i for i, name in enumerate(linear.outputs) if ".velocity[" in name or ".angularVelocity[" in name]
    n = linear.basis.shape[1]
    # velocities depend on η through the basis itself
    np.testing.assert_allclose(linear.C[rates, n:], linear.basis[: len(rates)] @ np.eye(n), atol=1e-9)


def test_names_select_inputs_and_outputs():
    model = linearize("SliderCrank", 0.1, inputs=["crankPivot.motorTorque"], outputs=["crankPivot.angle"])
    assert model.inputs == ("crankPivot.motorTorque",)
    assert model.outputs == ("crankPivot.angle",)
    assert (model.B.shape, model.C.shape, model.D.shape) == ((2, 1), (1, 2), (1, 1))
    with pytest.raises(SigmafmuError, match=r"no input 'nothing'"):
        linearize("SliderCrank", inputs=["nothing"])
    with pytest.raises(SigmafmuError, match=r"SliderCrank has no variable crank\.masss"):
        linearize("SliderCrank", settings={"crank.masss": 1.0})
