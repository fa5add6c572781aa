"""Null pointers, what is logged when, and an instance that has been ill treated in every way."""

import ctypes
import math

import numpy as np
import pytest
from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated

from .complaints import bring_to, calls, complaint, doubles, integers, references
from .helpers import DISCARD, ERROR, OK, Instance, assert_same_bits, inputs, status_of

# --- null pointers ---------------------------------------------------------------------------------------------------


def test_null_instances_are_refused(new, model):
    instance = new(model)
    for function, arguments in calls(instance).items():
        assert status_of(getattr(instance.slave, function), None, *arguments) == ERROR, function
    instance.slave.fmi2FreeInstance(None)
    assert instance.messages == []


def test_null_pointers_are_refused(new, model):
    instance, undisturbed = bring_to(new(model), "step mode"), bring_to(new(model), "step mode")
    one, slave = references(*instance.fmu.references(["gravity[1]"])), instance.slave
    known = references(*instance.fmu.references(inputs(instance.fmu)[:1]))
    state = instance.save()
    for function, arguments in (
        ("fmi2GetReal", (None, 1, doubles(0))),
        ("fmi2GetReal", (one, 1, None)),
        ("fmi2SetReal", (None, 1, doubles(0))),
        ("fmi2SetReal", (one, 1, None)),
        ("fmi2GetInteger", (None, 1, integers(0))),
        ("fmi2GetInteger", (one, 1, None)),
        ("fmi2SetInteger", (None, 1, integers(0))),
        ("fmi2SetInteger", (one, 1, None)),
        ("fmi2SetDebugLogging", (1, 1, None)),
        ("fmi2GetFMUstate", (None,)),
        ("fmi2SetFMUstate", (None,)),
        ("fmi2SerializedFMUstateSize", (None, ctypes.byref(ctypes.c_size_t()))),
        ("fmi2SerializedFMUstateSize", (state, None)),
        ("fmi2SerializeFMUstate", (None, ctypes.create_string_buffer(8), 8)),
        ("fmi2SerializeFMUstate", (state, None, 8)),
        ("fmi2DeSerializeFMUstate", (None, 8, ctypes.byref(ctypes.c_void_p()))),
        ("fmi2DeSerializeFMUstate", (ctypes.create_string_buffer(8), 8, None)),
        ("fmi2GetDirectionalDerivative", (None, 1, known, 1, doubles(1), doubles(0))),
        ("fmi2GetDirectionalDerivative", (one, 1, None, 1, doubles(1), doubles(0))),
        ("fmi2GetDirectionalDerivative", (one, 1, known, 1, None, doubles(0))),
        ("fmi2GetDirectionalDerivative", (one, 1, known, 1, doubles(1), None)),
        ("fmi2SetRealInputDerivatives", (None, 1, integers(1), doubles(1))),
        ("fmi2SetRealInputDerivatives", (known, 1, None, doubles(1))),
        ("fmi2SetRealInputDerivatives", (known, 1, integers(1), None)),
        ("fmi2GetRealOutputDerivatives", (None, 1, integers(1), doubles(1))),
        ("fmi2GetRealOutputDerivatives", (one, 1, None, doubles(1))),
        ("fmi2GetRealOutputDerivatives", (one, 1, integers(1), None)),
        ("fmi2GetRealStatus", (fmi2LastSuccessfulTime, None)),
        ("fmi2GetBooleanStatus", (fmi2Terminated, None)),
    ):
        text = complaint(instance, getattr(slave, function), slave.component, *arguments)
        assert text == f"{function} got a null pointer for 1 values.", function
    # With no values there is nothing to point at.
    assert instance.status("fmi2GetReal", None, 0, None) == OK
    assert instance.status("fmi2SetReal", None, 0, None) == OK
    assert instance.status("fmi2FreeFMUstate", None) == OK
    slave.freeFMUstate(state)
    for each in (instance, undisturbed):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), undisturbed.outputs())


# --- what is logged when ---------------------------------------------------------------------------------------------


def hard_step(instance: Instance) -> None:
    """A step that needs halving, which is an event worth telling."""
    instance.set({"top.torque[2]": 1e6})
    instance.step(0.004)
    instance.set({"top.torque[2]": 0.0})
    assert instance.integer("integrator.retries") > 0


EVENT = "repeated internal steps with half the step size."


def events(instance: Instance) -> list:
    """Messages but for the warnings that such steps deserve, which are no matter of debug logging."""
    return [m for m in instance.messages if m.category != "logStatusWarning"]


def test_events_are_logged_on_demand_only(new):
    for debug in (False, True):
        instance = new("HeavyTop", debug=debug).start({"integrator.stepSize": 2e-3})
        hard_step(instance)
        assert [(m.status, m.category) for m in events(instance)] == [("info", "logEvents")] * debug
        assert all(m.text.endswith(EVENT) for m in events(instance))


@pytest.mark.parametrize(
    ("first", "on", "categories", "expected"),
    [
        (False, True, [], True),
        (False, True, ["logEvents"], True),
        (False, True, ["logAll"], True),
        (False, True, ["logStatusError", "logEvents"], True),
        (False, True, ["logStatusError"], False),
        (True, True, ["logStatusWarning"], False),  # the named categories only
        (True, False, [], False),
        (True, False, ["logEvents"], False),
        (True, False, ["logStatusError"], False),  # off is off
    ],
)
def test_debug_logging_is_switched(new, first, on, categories, expected):
    instance = new("HeavyTop", debug=first).start({"integrator.stepSize": 2e-3})
    instance.slave.setDebugLogging(on, categories)
    hard_step(instance)
    assert [m.category for m in events(instance)] == ["logEvents"] * expected
    # Complaints come in any case.
    assert instance.status("fmi2EnterInitializationMode") == ERROR
    assert instance.messages[-1].category == "logStatusError"


def test_unknown_log_categories_are_refused(new):
    instance = new("HeavyTop", debug=True).start({"integrator.stepSize": 2e-3})
    text = complaint(instance, instance.slave.setDebugLogging, False, ["logEvents", "logNonsense"])
    assert text == 'The log category "logNonsense" is unknown.'
    instance.messages.clear()
    hard_step(instance)
    assert [m.category for m in events(instance)] == ["logEvents"], "the refused call has changed nothing"


@pytest.mark.parametrize(
    ("model", "settings", "parts"),
    [
        (
            "HighSpeedRotor",
            {"integrator.stepSize": 2e-4},
            ("integrator.stepSize is 0.0002 s", "rotor spins at 20944 rad/s", "choose at most 3.7"),
        ),
        (
            "SliderCrank",
            {"integrator.formulation": "index3", "integrator.spectralRadius": 1.0},
            ("index3 with integrator.spectralRadius 1 lets the multipliers oscillate",),
        ),
        ("HighSpeedRotor", {"integrator.formulation": "index3", "integrator.spectralRadius": 1.0}, None),
        ("HeavyTop", {"integrator.formulation": "index3", "integrator.spectralRadius": 0.99}, None),
        ("HeavyTop", {"integrator.spectralRadius": 1.0}, None),
    ],
)
def test_settings_that_deserve_a_second_thought(new, model, settings, parts):
    instance = new(model).start(settings)
    if parts is None:
        assert instance.messages == []
        return
    (message,) = instance.messages
    assert (message.status, message.category) == ("warning", "logStatusWarning")
    assert all(part in message.text for part in parts), message.text


# --- all at once -----------------------------------------------------------------------------------------------------


def test_an_instance_that_has_been_ill_treated_in_every_way_still_runs(new, model):
    """Refused calls between all steps, then a reset: both runs are bit by bit the undisturbed one."""
    instance, undisturbed = new(model).start(), new(model).start()
    H, reference = 1e-3, instance.fmu.references(["gravity[1]"])[0]
    expected = undisturbed.trajectory(H, 20)

    def ill_treat(i: int) -> None:
        slave = instance.slave
        for call in (
            lambda: slave.setReal([reference], [math.nan]),
            lambda: slave.getReal([10**6]),
            lambda: slave.doStep(i * H + 1.0, H),
            lambda: slave.doStep(i * H, -H),
            lambda: slave.enterInitializationMode(),
            lambda: slave.setupExperiment(),
            lambda: slave.deSerializeFMUstate(b"nonsense" * 20),
            lambda: slave.cancelStep(),
        ):
            assert status_of(call) in {ERROR, DISCARD}

    for _ in range(2):
        rows = [instance.outputs()]
        for i in range(20):
            ill_treat(i)
            instance.slave.doStep(i * H, H)
            rows.append(instance.outputs())
        assert_same_bits(np.array(rows), expected)
        instance.reset().start()
