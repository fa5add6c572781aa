"""Inputs and tunable parameters: forces against mechanics, signals between communication points, jumps."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from .helpers import EPS, Instance, assert_same_bits, bodies, inputs, orders, parameters, rotation_matrix

FREE_ROTOR = {  # supports and load off: a free body
    **{f"{side}Support.{n}": (0.0,) * 3 for side in ("left", "right") for n in ("stiffness", "damping")},
    "load.torque": (0.0,) * 3,
}


# --- forces against mechanics ----------------------------------------------------------------------------------------


def test_constant_force_on_a_free_body(new):
    """x = ½ t² F/m exactly, v = t F/m: the method is exact for constant accelerations."""
    force, t = np.array([3.0, -4.0, 5.0]), 0.05
    instance = new("HighSpeedRotor").start(FREE_ROTOR | {"rotor.force": force.tolist(), "integrator.stepSize": 1e-4})
    instance.steps(1e-3, 50)
    acceleration = force / 1.223
    np.testing.assert_allclose(instance.get("rotor.acceleration"), acceleration, rtol=4 * EPS)
    np.testing.assert_allclose(instance.get("rotor.velocity"), t * acceleration, rtol=1e-13)  # 500 steps
    np.testing.assert_allclose(instance.get("rotor.position"), 0.5 * t**2 * acceleration, rtol=1e-13)


def test_constant_torque_about_the_spin_axis(new):
    """ω = ω₀ + t τ/J."""
    instance = new("HighSpeedRotor").start(FREE_ROTOR | {"rotor.torque": (2.0, 0, 0)})
    instance.steps(1e-3, 50)
    assert instance.get("rotor.angularVelocity[1]") == pytest.approx(20944 + 0.05 * 2.0 / 0.001541, rel=1e-13)
    np.testing.assert_allclose(instance.reals(["rotor.angularVelocity[2]", "rotor.angularVelocity[3]"]), 0.0, atol=1e-9)


def test_force_is_given_in_the_inertial_frame_and_torque_in_the_body_frame(new):
    """A rotor turned by a quarter about z: the same force pushes the same way, the same torque turns about its x."""
    quarter = {"rotor.initialQuaternion": (math.sqrt(0.5), 0, 0, math.sqrt(0.5))}
    instance = new("HighSpeedRotor").start(FREE_ROTOR | quarter | {"rotor.initialAngularVelocity": (0.0,) * 3})
    instance.set({"rotor.force": (1.0, 0, 0), "rotor.torque": (0.001, 0, 0)})
    np.testing.assert_allclose(instance.get("rotor.acceleration"), [1 / 1.223, 0, 0], atol=4 * EPS)
    np.testing.assert_allclose(instance.get("rotor.angularAcceleration"), [0.001 / 0.001541, 0, 0], atol=4 * EPS)


def test_load_torque_stays_fixed_in_the_inertial_frame(new):
    quarter = {"rotor.initialQuaternion": (math.sqrt(0.5), 0, 0, math.sqrt(0.5)), "rotor.initialAngularVelocity[1]": 0}
    load = {"load.torque": (0.001, 0, 0), "load.force": (0, 1.0, 0)}
    instance = new("HighSpeedRotor").start(FREE_ROTOR | quarter | load)
    np.testing.assert_allclose(instance.get("rotor.angularAcceleration"), [0, -0.001 / 0.000812, 0], atol=4 * EPS)
    np.testing.assert_allclose(instance.get("rotor.acceleration"), [0, 1 / 1.223, 0], atol=4 * EPS)


def test_actuators_of_the_supports_bend_them_as_their_stiffness_says(new):
    """At rest in the end: displacement = force / stiffness, and the supports carry the force."""
    slow = {"rotor.initialAngularVelocity[1]": 0.0, "load.torque": (0.0,) * 3, "integrator.stepSize": 1e-3}
    slow |= {f"{side}Support.damping": (100.0,) * 3 for side in ("left", "right")}
    instance = new("HighSpeedRotor").start(slow | {"rightSupport.stiffness[1]": 0.0, "rightSupport.damping[1]": 0.0})
    instance.set({"leftSupport.actuatorForce": (1.0, 2.0, 3.0), "rightSupport.actuatorForce": (0.0, -1.0, 0.5)})
    instance.steps(0.1, 40)
    left, right = (instance.get(f"{side}Support.position") for side in ("left", "right"))
    np.testing.assert_allclose(left - [-0.11, 0, 0], [1 / 4000, 2 / 4000, 3 / 4000], atol=1e-6)  # tilt² · length
    np.testing.assert_allclose((right - [0.09, 0, 0])[1:], [-1 / 4000, 0.5 / 4000], atol=1e-6)
    np.testing.assert_allclose(instance.get("leftSupport.force"), [-1.0, -2.0, -3.0], atol=1e-9)
    np.testing.assert_allclose(instance.get("rightSupport.force"), [0.0, 1.0, -0.5], atol=1e-9)


def power(instance: Instance) -> float:
    """What all inputs together do at the present point, from outputs alone."""
    total = 0.0
    for body in bodies(instance.fmu):
        total += instance.get(f"{body}.force") @ instance.get(f"{body}.velocity")
        total += instance.get(f"{body}.torque") @ instance.get(f"{body}.angularVelocity")
    for name in inputs(instance.fmu):
        if ".motorTorque" in name:
            total += instance.get(name) * instance.get(name.replace("motorTorque", "angularRate"))
        elif name.endswith(".actuatorForce"):
            total += instance.get(name) * instance.get(name.replace("actuatorForce", "rate"))
    for support, arm in (("leftSupport", (-0.11, 0, 0)), ("rightSupport", (0.09, 0, 0))):
        if f"{support}.actuatorForce[1]" in instance.fmu.variables:
            rotation = rotation_matrix(instance.get("rotor.quaternion"))
            arm_rate = rotation @ np.cross(instance.get("rotor.angularVelocity"), arm)
            total += instance.get(f"{support}.actuatorForce") @ (instance.get("rotor.velocity") + arm_rate)
    return total


@pytest.mark.parametrize("model", ["HeavyTop", "HighSpeedRotor", "SliderCrank"])
def test_inputs_do_as_much_work_as_the_energy_grows(new, model):
    """∫ power dt = change of the energy, by Simpson's rule on fine samples: frames, signs and points of all inputs."""
    span = {"HeavyTop": 0.05, "HighSpeedRotor": 2e-3, "SliderCrank": 0.1}[model]
    instance = new(model)
    undamped = {f"{side}Support.damping": (0.0,) * 3 for side in ("left", "right")} | {"load.torque": (0.0,) * 3}
    settings = undamped if model == "HighSpeedRotor" else {}
    samples = 400
    instance.start(settings | {"integrator.stepSize": span / samples / 4})
    rng = np.random.default_rng(2)
    size = {"HeavyTop": 20.0, "HighSpeedRotor": 20.0, "SliderCrank": 0.2}[model]
    instance.set({name: size * rng.uniform(0.5, 1.0) for name in inputs(instance.fmu)})
    first, powers = instance.get("energy.total"), [power(instance)]
    for _ in range(samples):
        instance.step(span / samples)
        powers.append(power(instance))
    weights = np.full(samples + 1, 2.0)
    weights[1::2], weights[[0, -1]] = 4.0, 1.0
    work = span / samples / 3 * weights @ powers
    gained = instance.get("energy.total") - first
    exchanged = span * np.abs(powers).max()
    assert abs(gained) > 1e-2 * exchanged
    assert gained == pytest.approx(work, abs=1e-4 * exchanged)


# --- signals between communication points ----------------------------------------------------------------------------

Signal = Callable[[float], tuple[float, float, float]]
"""Value, first and second derivative."""

DRIVEN = {
    "HeavyTop": "top.torque[1]",
    "HighSpeedRotor": "leftSupport.actuatorForce[2]",
    "SliderCrank": "crankPivot.motorTorque",
}
WATCHED = {
    "HeavyTop": ("top.velocity", "top.angularVelocity"),
    "HighSpeedRotor": ("rotor.position", "rotor.velocity"),
    "SliderCrank": ("rod.velocity", "rod.angularVelocity"),
}


def drive(instance: Instance, signal: Signal, span: float, count: int, derivatives: int) -> np.ndarray:
    """`count` communication steps, in each of which the master tells value and derivatives at its beginning."""
    model, H = instance.fmu.name, span / count
    for i in range(count):
        u = signal(i * H)
        instance.set({DRIVEN[model]: u[0]})
        for order in range(1, derivatives + 1):
            instance.set_input_derivatives(order, {DRIVEN[model]: u[order]})
        instance.slave.doStep(i * H, H)
    return np.concatenate([instance.get(name) for name in WATCHED[model]])


def oscillation(model: str) -> tuple[float, Signal]:
    """(span, signal): some periods in the span, strong enough to matter."""
    span, size = {"HeavyTop": (0.2, 300.0), "HighSpeedRotor": (0.02, 50.0), "SliderCrank": (0.5, 0.2)}[model]
    w = 3 * 2 * math.pi / span

    def signal(t: float) -> tuple[float, float, float]:
        return size * math.sin(w * t + 1), size * w * math.cos(w * t + 1), -size * w * w * math.sin(w * t + 1)

    return span, signal


@pytest.mark.parametrize("model", DRIVEN)
@pytest.mark.parametrize(("derivatives", "order"), [(0, 1.0), (1, 2.0), (2, 3.0)], ids=["hold", "linear", "quadratic"])
def test_input_derivatives_raise_the_order_of_the_coupling(new, model, derivatives, order):
    """Error by the size of the communication step; the internal step is the same throughout and cancels out."""
    span, signal = oscillation(model)
    finest = 768
    settings = {"integrator.stepSize": span / finest}
    exact = drive(new(model).start(settings), signal, span, finest, 2)
    counts = (96, 192, 384) if derivatives < 2 else (48, 96, 192)
    errors = [np.abs(drive(new(model).start(settings), signal, span, n, derivatives) - exact).max() for n in counts]
    # The reference itself has the error of a quadratic signal at the finest step: (1/8)³ or less of the smallest.
    assert orders(errors) == pytest.approx([order] * 2, abs=0.15), errors


@pytest.mark.parametrize("model", DRIVEN)
@pytest.mark.parametrize("degree", [1, 2])
def test_polynomial_signals_are_taken_up_exactly(new, model, degree):
    """One long communication step or many short ones: the same internal steps see the same input."""
    span, _ = oscillation(model)
    size = {"HeavyTop": 300.0, "HighSpeedRotor": 50.0, "SliderCrank": 0.2}[model]
    c = (0.3 * size, 0.5 * size / span, 0.7 * size / span**2 if degree == 2 else 0.0)

    def signal(t: float) -> tuple[float, float, float]:
        return c[0] + c[1] * t + c[2] * t * t / 2, c[1] + c[2] * t, c[2]

    settings = {"integrator.stepSize": span / 64, "integrator.relativeTolerance": 1e-12}
    results = [drive(new(model).start(settings), signal, span, n, degree) for n in (64, 8, 1)]
    constant = drive(new(model).start(settings), signal, span, 1, 0)
    size = np.abs(results[0]).max()
    assert np.abs(constant - results[0]).max() > 1e-4 * size, "the signal matters"
    for result in results[1:]:
        np.testing.assert_allclose(result, results[0], rtol=0, atol=1e-11 * size)


def test_input_follows_its_derivatives_to_the_end_of_the_step(new):
    """Outputs after a step belong to the input at its end; there it stays, and the derivatives are used up."""
    instance = new("HighSpeedRotor").start(FREE_ROTOR)
    instance.set({"rotor.force[2]": 1.0})
    instance.set_input_derivatives(1, {"rotor.force[2]": 100.0})
    instance.set_input_derivatives(2, {"rotor.force[2]": 3000.0})
    instance.step(0.02)
    expected = 1.0 + 100 * 0.02 + 0.5 * 3000 * 0.02**2
    assert instance.get("rotor.force[2]") == pytest.approx(expected, rel=4 * EPS)
    assert instance.get("rotor.acceleration[2]") == pytest.approx(expected / 1.223, rel=4 * EPS)
    instance.step(0.01)
    assert instance.get("rotor.force[2]") == pytest.approx(expected, rel=4 * EPS)
    assert instance.get("rotor.acceleration[2]") == pytest.approx(expected / 1.223, rel=4 * EPS)


def test_derivatives_given_before_the_start_count(new):
    """In initialization mode and before: the same as at the first communication point."""
    settings = FREE_ROTOR | {"rotor.force[2]": 1.0}
    late = new("HighSpeedRotor").start(settings)
    late.set_input_derivatives(1, {"rotor.force[2]": 100.0})
    early = new("HighSpeedRotor")
    early.set_input_derivatives(1, {"rotor.force[2]": 100.0})
    early.start(settings)
    for instance in (early, late):
        instance.steps(1e-3, 5)
    names = ["rotor.position[2]", "rotor.velocity[2]", "rotor.acceleration[2]"]
    np.testing.assert_allclose(early.reals(names), late.reals(names), rtol=1e-6)  # the start knows the rate
    # 1 ms of a ramp, then constant: v = (1 t₁ + ½ 100 t₁² + 1.1 (t − t₁)) / m
    expected = (1e-3 + 0.5 * 100 * 1e-6 + 1.1 * 4e-3) / 1.223
    assert early.get("rotor.velocity[2]") == pytest.approx(expected, rel=1e-9)


# --- jumps -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", DRIVEN)
@pytest.mark.parametrize("formulation", ["index3", "index2", "stabilizedIndex2"])
def test_second_order_with_an_input_that_jumps(new, model, formulation):
    """Switched on at a communication point in the midst, off at another: piecewise constant."""
    span, _ = oscillation(model)
    size = {"HeavyTop": 300.0, "HighSpeedRotor": 50.0, "SliderCrank": 0.2}[model]

    def run(n: int, formulation: str = formulation) -> np.ndarray:
        settings = {"integrator.stepSize": span / (12 * n), "integrator.formulation": formulation}
        settings |= {"integrator.relativeTolerance": 1e-12, "integrator.absoluteTolerance": 1e-12}
        instance = new(model).start(settings)
        for i in range(12):
            instance.set({DRIVEN[model]: size if 3 <= i < 9 else 0.0})
            instance.slave.doStep(i * span / 12, span / 12)
        return np.concatenate([instance.get(name) for name in WATCHED[model]])

    coarse = {"HeavyTop": 32, "HighSpeedRotor": 64, "SliderCrank": 32}[model]
    exact = run(32 * coarse, "stabilizedIndex2")
    errors = [np.abs(run(n) - exact).max() for n in (coarse, 2 * coarse, 4 * coarse)]
    assert orders(errors) == pytest.approx([2.0, 2.0], abs=0.1), errors


TUNABLE_JUMPS = {
    "HeavyTop": {"gravity": (3.0, 0.0, -20.0)},
    "HighSpeedRotor": {
        "leftSupport.stiffness": (1000.0, 9000.0, 2000.0),
        "rightSupport.damping": (0.0, 50.0, 20.0),
        "load.torque": (0.0, 1.0, 0.0),
        "load.force": (0.0, 3.0, 5.0),
    },
    "SliderCrank": {"gravity": (0.0, 0.0, 9.81)},
}


@pytest.mark.parametrize("model", TUNABLE_JUMPS)
def test_second_order_when_tunable_parameters_jump(new, model):
    span, _ = oscillation(model)

    def run(n: int) -> np.ndarray:
        settings = {"integrator.stepSize": span / (4 * n)}
        settings |= {"integrator.relativeTolerance": 1e-12, "integrator.absoluteTolerance": 1e-12}
        instance = new(model).start(settings)
        instance.slave.doStep(0.0, span / 4)
        instance.set(TUNABLE_JUMPS[model])
        for i in (1, 2, 3):
            instance.slave.doStep(i * span / 4, span / 4)
        return np.concatenate([instance.get(name) for name in WATCHED[model]])

    coarse = {"HeavyTop": 64, "HighSpeedRotor": 128, "SliderCrank": 64}[model]
    exact = run(32 * coarse)
    errors = [np.abs(run(n) - exact).max() for n in (coarse, 2 * coarse, 4 * coarse)]
    assert orders(errors) == pytest.approx([2.0, 2.0], abs=0.1), errors


def test_tunable_parameters_act_at_once(new):
    """On all that follows from them, without a step in between."""
    instance = new("HighSpeedRotor").start()
    instance.steps(1e-3, 10)
    x, k = instance.get("leftSupport.position") - [-0.11, 0, 0], instance.get("leftSupport.stiffness")
    force, acceleration = instance.get("leftSupport.force"), instance.get("rotor.acceleration")
    energy = instance.get("energy.potential")
    instance.set({"leftSupport.stiffness": (2 * k).tolist()})
    np.testing.assert_allclose(instance.get("leftSupport.force") - force, -k * x, rtol=0, atol=1e-15)
    np.testing.assert_allclose(instance.get("rotor.acceleration") - acceleration, -k * x / 1.223, rtol=0, atol=1e-15)
    assert instance.get("energy.potential") - energy == pytest.approx(0.5 * k @ x**2, rel=1e-9)
    instance.set({"gravity": (0.0, 0.0, -9.81)})
    expected = acceleration - k * x / 1.223 + [0, 0, -9.81]
    np.testing.assert_allclose(instance.get("rotor.acceleration"), expected, rtol=0, atol=1e-14)


def test_gravity_switched_off_leaves_the_kinetic_energy_alone(new):
    instance = new("SliderCrank").start({"integrator.stepSize": 2e-5})
    instance.step(0.1)
    instance.set({"gravity": (0.0, 0.0, 0.0)})
    kinetic = instance.get("energy.kinetic")
    for _ in range(10):
        instance.step(0.01)
        assert instance.get("energy.kinetic") == pytest.approx(kinetic, rel=1e-6)


def test_every_tunable_parameter_can_be_changed_in_step_mode(new, model):
    instance = new(model).start()
    instance.step(1e-3)
    for variable in parameters(instance.fmu, "tunable"):
        value = instance.get(variable.name)
        instance.set({variable.name: 0.5 * value + 0.25})
        assert instance.get(variable.name) == 0.5 * value + 0.25
        instance.step(1e-4)


def test_every_fixed_parameter_is_refused_in_step_mode(new, model):
    """With its name, and nothing changes, not even other values of the same call."""
    instance, other = new(model).start(), new(model).start()
    for variable in parameters(instance.fmu, "fixed"):
        real = variable.type == "Real"
        setter, getter = (
            (instance.slave.setReal, instance.slave.getReal)
            if real
            else (instance.slave.setInteger, instance.slave.getInteger)
        )
        before = getter([variable.valueReference])
        message = instance.refusal(setter, [variable.valueReference], before)
        assert message.text == (
            f"{variable.name} is a fixed parameter; it can be set only before the simulation starts, or after a reset."
        )
        if real:
            gravity = instance.fmu.references(["gravity[3]"])
            instance.refusal(instance.slave.setReal, [*gravity, variable.valueReference], [-5.0, *before])
    for each in (instance, other):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), other.outputs())


def test_setting_the_same_value_again_changes_nothing(new, model):
    """A master may write all inputs and tunable parameters at every communication point."""
    quiet, busy = new(model).start(), new(model).start()
    names = [v.name for v in parameters(busy.fmu, "tunable")] + inputs(busy.fmu)
    for _ in range(20):
        busy.set(dict(zip(names, busy.reals(names), strict=True)))
        for instance in (quiet, busy):
            instance.step(1e-3)
    assert_same_bits(quiet.outputs(), busy.outputs())
