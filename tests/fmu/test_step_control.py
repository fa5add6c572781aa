"""The error estimate of internal steps, the warnings that follow from it, and steps chosen by it."""

import math

import numpy as np
import pytest

from .helpers import ERROR, METHODS, Instance, assert_same_bits, orders

H = {
    "HeavyTop": 1e-3,
    "HighSpeedRotor": 1e-5,
    "SliderCrank": 2e-3,
    "FlexiblePendulum": 1e-3,
    "FlexibleSliderCrank": 1e-3,
}
moving = pytest.mark.parametrize("model", H)
ESTIMATE, LARGEST = "integrator.errorEstimate", "integrator.largestErrorEstimate"


def warnings(instance: Instance) -> list[str]:
    return [m.text for m in instance.messages if m.category == "logStatusWarning"]


# --- the estimate ----------------------------------------------------------------------------------------------------


@moving
@pytest.mark.parametrize(("method", "order"), [("generalizedAlpha", 3), ("bliedf2", 3), ("rkmk4", 4)])
def test_the_estimate_has_the_order_of_the_error_of_a_step(new, model, method, order):
    found = []
    for k in range(3):
        h = H[model] / 4 / 2**k
        instance = new(model).start({"integrator.stepSize": h, "integrator.method": method})
        instance.steps(h, 10 * 2**k)
        found.append(instance.get(ESTIMATE))
        assert instance.get(LARGEST) >= found[-1] > 0
    assert orders(found)[-1] == pytest.approx(order, abs=0.35)


def test_the_estimate_is_that_of_a_position_over_the_size(new):
    """One step of the slider-crank against 100: its size is half the length of the rod."""
    for h in (4e-3, 2e-3):
        settings = {"integrator.formulation": "index2", "integrator.spectralRadius": 1.0}
        one = new("SliderCrank").start({"integrator.stepSize": h, **settings})
        many = new("SliderCrank").start({"integrator.stepSize": h / 100, **settings})
        one.step(h)
        many.step(h)
        difference = max(
            np.linalg.norm(one.get(f"{body}.position") - many.get(f"{body}.position"))
            for body in ("crank", "rod", "slider")
        )
        turn = max(
            np.linalg.norm(one.get(f"{body}.rotationVector") - many.get(f"{body}.rotationVector"))
            for body in ("crank", "rod", "slider")
        )
        error = max(difference / 0.15, turn)
        assert error / 4 < one.get(ESTIMATE) < 4 * error


# --- warnings --------------------------------------------------------------------------------------------------------


def test_the_six_mechanisms_run_without_a_warning(new, model):
    instance = new(model).start()
    instance.steps(float(instance.fmu.description.defaultExperiment.stepSize), 30)
    assert warnings(instance) == []
    assert instance.get(LARGEST) < 1e-5


def test_a_large_error_is_told_once(new):
    instance = new("HeavyTop").start({"integrator.stepSize": 5e-3})
    instance.steps(5e-3, 40)
    (text,) = warnings(instance)
    assert "the position error of an internal step of 0.005 s is estimated as 0.00" in text
    assert text.endswith("choose a smaller integrator.stepSize, or integrator.stepControl error.")
    instance.messages.clear()
    instance.reset().start({"integrator.stepSize": 5e-3})
    instance.steps(5e-3, 40)
    assert len(warnings(instance)) == 1


def test_a_spin_that_grows_is_told_once(new):
    """J w' = 5e4 N m: w h passes 1 rad at 4000 rad/s."""
    instance = new("HeavyTop").start()
    instance.set({"top.torque[2]": 5e4})
    instance.steps(1e-3, 60)
    (text,) = [t for t in warnings(instance) if "spins" in t]
    assert text.startswith("top spins at 4")
    assert "more than 1: choose an integrator.stepSize of at most 0.00012" in text


def test_a_stiff_spring_that_is_not_resolved_is_told(new):
    """A support of 1e12 N/m: half a period of its vibration in a tenth of a step."""
    stiff = {f"{support}.stiffness": (1e12,) * 3 for support in ("leftSupport", "rightSupport")}
    settings = {"integrator.spectralRadius": 1.0, "rotor.initialPosition[2]": 1e-3, **stiff}
    instance = new("HighSpeedRotor").start(settings)
    instance.steps(1e-4, 10)
    assert any("the position error of an internal step" in text for text in warnings(instance))


# --- steps chosen by the error ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank", "FlexiblePendulum"])
@pytest.mark.parametrize("method", ["generalizedAlpha", "bliedf2", "rkmk4"])
def test_steps_keep_the_tolerance(new, model, method):
    """Errors at the end go with the tolerance; steps are divided, never longer than stepSize."""
    step, count = H[model], 50
    exact = new(model).start({"integrator.method": "rkmk54", "integrator.stepSize": step})
    exact.steps(step, count)
    found = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        settings = {"integrator.method": method, "integrator.stepSize": step, "integrator.stepControl": "error"}
        instance = new(model).start({**settings, "integrator.errorTolerance": tolerance})
        instance.steps(step, count)
        assert instance.get(LARGEST) <= tolerance
        assert instance.integer("integrator.steps") >= count
        body = {"HeavyTop": "top", "SliderCrank": "crank", "FlexiblePendulum": "beam"}[model]
        found.append(np.linalg.norm(instance.get(f"{body}.quaternion") - exact.get(f"{body}.quaternion")))
        assert found[-1] <= 1e3 * tolerance
    assert found[0] >= found[1] >= found[2] or max(found[1:]) < 1e-8


def test_a_tolerance_that_cannot_be_kept_is_the_reason(new):
    settings = {"integrator.stepControl": "error", "integrator.errorTolerance": 1e-17, "integrator.maxHalvings": 3}
    instance = new("HeavyTop").start(settings)
    message = instance.refusal(instance.slave.doStep, 0.0, 1e-3)
    assert message.status == "discard"
    assert "its error is estimated as" in message.text
    assert "largest in body top" in message.text


def test_hard_motion_takes_shorter_steps(new):
    """A torque for one communication step; afterwards they grow again."""
    instance = new("SliderCrank").start({"integrator.stepControl": "error", "integrator.stepSize": 5e-3})
    steps = []
    for torque in (0.0, 5.0, 0.0):
        before = instance.integer("integrator.steps")
        instance.set({"crankPivot.motorTorque": torque})
        instance.steps(5e-3, 4)
        steps.append(instance.integer("integrator.steps") - before)
    assert steps[1] > 1.2 * steps[0]


# --- the experiment's tolerance --------------------------------------------------------------------------------------


def started(instance: Instance, settings: dict, tolerance: float | None) -> Instance:
    instance.set(settings)
    instance.slave.setupExperiment(tolerance=tolerance, startTime=0.0)
    instance.slave.enterInitializationMode()
    instance.slave.exitInitializationMode()
    instance.time = 0.0
    return instance


@pytest.mark.parametrize("method", METHODS)
def test_the_tolerance_of_the_experiment_is_the_error_tolerance(new, method):
    settings = {"integrator.method": method, "integrator.stepControl": "error", "integrator.stepSize": 2e-3}
    if method == "rkmk54":
        same = {"integrator.relativeTolerance": 1e-5, "integrator.absoluteTolerance": 1e-7}
        other = {"integrator.relativeTolerance": 1e-9, "integrator.absoluteTolerance": 1e-11}
    else:
        same, other = {"integrator.errorTolerance": 1e-5}, {"integrator.errorTolerance": 1e-6}
    runs = [
        started(new("HeavyTop"), settings, 1e-5),
        started(new("HeavyTop"), settings | same, None),
        started(new("HeavyTop"), settings | other, 1e-5),  # what was set stays
        started(new("HeavyTop"), settings | other, None),
    ]
    given, chosen, overridden, set_alone = (run.trajectory(1e-2, 5) for run in runs)
    assert_same_bits(given, chosen)
    assert_same_bits(overridden, set_alone)
    assert not np.array_equal(given, overridden)


def test_the_tolerance_does_not_concern_fixed_steps(new, model):
    one, other = started(new(model), {}, 1e-2), started(new(model), {}, None)
    assert_same_bits(one.trajectory(1e-3, 5), other.trajectory(1e-3, 5))


def test_the_tolerance_is_part_of_the_state_and_ends_with_a_reset(new):
    settings = {"integrator.stepControl": "error", "integrator.stepSize": 2e-3}
    coarse, fine = started(new("HeavyTop"), settings, 1e-4), started(new("HeavyTop"), settings, None)
    expected = coarse.trajectory(1e-2, 3)
    coarse.reset()
    assert_same_bits(started(coarse, settings, None).trajectory(1e-2, 3), fine.trajectory(1e-2, 3))
    first, second = started(new("HeavyTop"), settings, 1e-4), new("HeavyTop")
    second.deserialize(first.serialized())
    assert_same_bits(second.trajectory(1e-2, 3), expected)


@pytest.mark.parametrize("tolerance", [-1e-6, math.nan, math.inf])
def test_impossible_tolerances_are_refused(new, tolerance):
    instance = new("HeavyTop")
    assert instance.status("fmi2SetupExperiment", 1, tolerance, 0.0, 0, 0.0) == ERROR
    assert "tolerance is" in instance.messages[-1].text
    instance.start()
