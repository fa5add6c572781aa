"""Every wrong call: its status, a message that tells what is wrong and what is allowed, and an instance unharmed."""

import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import (
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2DoStepStatus,
    fmi2LastSuccessfulTime,
    fmi2PendingStatus,
    fmi2Terminated,
)

from .helpers import (
    DISCARD,
    ERROR,
    OK,
    Instance,
    assert_same_bits,
    bodies,
    inputs,
    parameters,
    reads_resources,
    rigid_bodies,
    status_of,
)

COMPLAINTS = {"error": "logStatusError", "discard": "logStatusDiscard", "warning": "logStatusWarning"}


def references(*values: int) -> ctypes.Array:
    return (ctypes.c_uint * len(values))(*values)


def doubles(*values: float) -> ctypes.Array:
    return (ctypes.c_double * len(values))(*values)


def integers(*values: int) -> ctypes.Array:
    return (ctypes.c_int * len(values))(*values)


def shown(value: float) -> str:
    """A number as the messages have it."""
    return f"{value:.17g}"


def complaint(instance: Instance, call: Callable, *arguments, **keywords) -> str:
    """Text of the one message of a call that must fail; checks status and category."""
    message = instance.refusal(call, *arguments, **keywords)
    assert message.category == COMPLAINTS[message.status]
    return message.text


# --- values that no mechanism can have -------------------------------------------------------------------------------

BAD_VALUES = [
    # variable, value, unit, what is allowed
    ("{body}.mass", -1.0, " kg", "finite, above 0"),
    ("{body}.mass", 0.0, " kg", "finite, above 0"),
    ("{body}.inertia.xx", -0.5, " kg.m2", "finite, above 0"),
    ("{body}.inertia.zz", 0.0, " kg.m2", "finite, above 0"),
    ("integrator.stepSize", 0.0, " s", "finite, above 0"),
    ("integrator.stepSize", -1e-3, " s", "finite, above 0"),
    ("integrator.spectralRadius", -0.1, "", "finite, at least 0, at most 1"),
    ("integrator.spectralRadius", 1.0 + 2.3e-16, "", "finite, at least 0, at most 1"),
    ("integrator.absoluteTolerance", 0.0, "", "finite, above 0"),
    ("integrator.relativeTolerance", -1e-9, "", "finite, at least 0, at most 0.01"),
    ("integrator.sigma", math.inf, "", "finite"),
    ("gravity[2]", math.nan, " m/s2", "finite"),
    ("{body}.force[1]", -math.inf, " N", "finite"),
]


@pytest.mark.parametrize(("name", "value", "unit", "allowed"), BAD_VALUES)
def test_a_bad_value_is_refused_with_name_value_and_limits(new, model, name, value, unit, allowed):
    instance = new(model)
    of_rigid_bodies = name.startswith(("{body}.mass", "{body}.inertia"))
    if of_rigid_bodies and not rigid_bodies(instance.fmu):
        pytest.skip("no rigid body")
    name = name.format(body=(rigid_bodies if of_rigid_bodies else bodies)(instance.fmu)[0])
    before = new(model)
    before.slave.enterInitializationMode()
    text = complaint(instance, instance.set, {name: value})
    allowed = allowed.replace("0.01", shown(0.01))
    assert text.replace("-nan", "nan") == f"{name} is {shown(value)}{unit}; it must be {allowed}."
    instance.slave.enterInitializationMode()
    assert instance.get(name) == before.get(name)


def test_stiffness_and_damping_must_not_be_negative(new):
    instance = new("HighSpeedRotor")
    for name, unit in (("leftSupport.stiffness[2]", "N/m"), ("rightSupport.damping[3]", "N.s/m")):
        text = complaint(instance, instance.set, {name: -1.0})
        assert text == f"{name} is -1 {unit}; it must be finite, at least 0."


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_variable_takes_a_value_that_is_not_finite(new, model, value):
    """Every Real that can be set, in every phase in which it can."""
    instance = new(model)
    settable = [*(v.name for k in ("fixed", "tunable") for v in parameters(instance.fmu, k)), *inputs(instance.fmu)]
    for name in settable:
        variable = instance.fmu.variables[name]
        if variable.type == "Real":
            text = complaint(instance, instance.slave.setReal, [variable.valueReference], [value])
            assert text.startswith(f"{name} is ")
            assert "it must be finite" in text
    instance.start()
    for name in [*(v.name for v in parameters(instance.fmu, "tunable")), *inputs(instance.fmu)]:
        complaint(instance, instance.slave.setReal, instance.fmu.references([name]), [value])
    undisturbed = new(model).start()
    for each in (instance, undisturbed):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), undisturbed.outputs())


@pytest.mark.parametrize(
    ("name", "items"),
    [
        ("formulation", "1 (index3), 2 (index2) or 3 (stabilizedIndex2)"),
        ("corrector", "1 (residual) or 2 (incremental)"),
        ("jacobian", "1 (full) or 2 (tangentFree)"),
        ("newton", "1 (full) or 2 (modified)"),
        ("method", "1 (generalizedAlpha), 2 (rkmk4), 3 (rkmk54) or 4 (bliedf2)"),
        ("group", "1 (R3xSO3) or 2 (SE3)"),
        ("localCoordinates", "1 (exp), 2 (cayley) or 3 (cayley2)"),
        ("absoluteCoordinates", "1 (quaternion) or 2 (rotationVector)"),
    ],
)
def test_an_enumeration_takes_its_items_only(new, model, name, items):
    instance = new(model)
    reference = instance.fmu.references([f"integrator.{name}"])
    for value in (0, -1, items.count("(") + 1, 2**31 - 1, -(2**31)):
        text = complaint(instance, instance.slave.setInteger, reference, [value])
        assert text == f"integrator.{name} is {shown(value)}; it must be {items}."


# --- values that do not fit together: refused when the mechanism is built --------------------------------------------


@dataclass(frozen=True)
class Misfit:
    model: str
    settings: dict
    parts: tuple[str, ...]  # of the message


MISFITS = {
    "triangle inequality": Misfit(
        "HeavyTop",
        {"top.inertia.yy": 1.0},
        ("top.inertia has the principal moments", "0.234375", ", 1 kg.m2", "none may exceed the sum of the other two"),
    ),
    "not positive definite": Misfit(
        "HeavyTop",
        {"top.inertia.xz": 0.5},
        ("top.inertia has the principal moments -0.26", "kg.m2; they must be positive, or one of them zero"),
    ),
    "quaternion without direction": Misfit(
        "SliderCrank",
        {"rod.initialQuaternion": (0.0, 0.0, 0.0, 0.0)},
        ("rod.initialQuaternion has the length 0", "at least 1e-6"),
    ),
    "far from any assembly": Misfit(  # 1 km off with the arm of 1 m
        "HeavyTop",
        {"top.initialPosition": (1000.0, 0.0, 0.0)},
        ("top.initialPosition[1] = 1000 m", "contradict joint pivot by 999 m."),
    ),
    # A quarter turn off its guide the slider's equations are dependent: no direction leads back.
    "singular on the way": Misfit(
        "SliderCrank",
        {"slider.initialQuaternion": (1.0, 0.0, 0.0, 1.0)},
        ("slider.initialQuaternion contradicts joint guide by 1.5708 rad.",),
    ),
    "joint torn apart": Misfit(
        "SliderCrank",
        {"rod.initialPosition": (1e9, 0.0, 0.0)},
        ("rod.initialPosition[1] = 1e+09 m", "crankPin", "by 1e+09 m."),
    ),
}


@pytest.mark.parametrize("misfit", MISFITS.values(), ids=MISFITS)
def test_what_does_not_fit_together_is_refused_at_initialization(new, misfit):
    instance, undisturbed = new(misfit.model), new(misfit.model).start()
    instance.set(misfit.settings)
    instance.slave.setupExperiment()
    instance.slave.enterInitializationMode()
    # Reading needs the initial state, which cannot be computed: a failed computation. Leaving the mode is an error.
    message = instance.refusal(instance.outputs)
    assert message.status == "discard"
    assert all(part in message.text for part in misfit.parts), message.text
    leaving = instance.refusal(instance.slave.exitInitializationMode)
    assert (leaving.status, leaving.text) == ("error", message.text)
    # Other values, and it goes on from where it is ...
    instance.set({name: undisturbed.get(name) for name in misfit.settings if name in instance.fmu.variables})
    vectors = [name for name in misfit.settings if name not in instance.fmu.variables]
    instance.set({name: undisturbed.get(name).tolist() for name in vectors})
    instance.slave.exitInitializationMode()
    expected = undisturbed.trajectory(1e-3, 10)
    assert_same_bits(instance.trajectory(1e-3, 10), expected)
    # ... and another try ends in a reset.
    instance.reset().set(misfit.settings)
    instance.slave.enterInitializationMode()
    assert instance.status("fmi2ExitInitializationMode") == ERROR
    instance.reset().start()
    assert_same_bits(instance.trajectory(1e-3, 10), expected)


def test_a_thin_rod_is_on_the_boundary_of_the_triangle_inequality_and_allowed(new):
    new("HeavyTop").start({"top.inertia.xx": 0.3, "top.inertia.yy": 0.6, "top.inertia.zz": 0.3})
    text = complaint(
        instance := new("HeavyTop"),
        instance.start,
        {"top.inertia.xx": 0.3, "top.inertia.yy": 0.6001, "top.inertia.zz": 0.3},
    )
    assert "triangle inequality" in text


# --- variables that are not there, or not what they are taken for ----------------------------------------------------


def test_unknown_value_references_are_refused(new, model):
    instance = new(model).start()
    count = len(instance.fmu.variables)
    slave = instance.slave
    for reference in (count, 123456, 2**32 - 1):
        expected = f"Value reference {reference} is unknown; this FMU has 0 to {count - 1}."
        for call, arguments in (
            (slave.getReal, ([reference],)),
            (slave.getInteger, ([reference],)),
            (slave.setReal, ([reference], [0.0])),
            (slave.setInteger, ([reference], [1])),
            (slave.setRealInputDerivatives, ([reference], [1], [0.0])),
            (slave.getRealOutputDerivatives, ([reference], [1])),
            (slave.getDirectionalDerivative, ([reference], [], [])),
            (slave.getDirectionalDerivative, ([], [reference], [1.0])),
        ):
            assert complaint(instance, call, *arguments) == expected


def test_types_are_not_mixed(new, model):
    instance = new(model).start()
    slave = instance.slave
    real = instance.fmu.references(["energy.total"])
    parameter = instance.fmu.references(["gravity[1]"])
    integer = instance.fmu.references(["integrator.steps"])
    option = instance.fmu.references(["integrator.formulation"])
    assert complaint(instance, slave.getInteger, real) == "energy.total is a Real; it was read as an Integer."
    assert complaint(instance, slave.getReal, integer) == "integrator.steps is an Integer; it was read as a Real."
    assert complaint(instance, slave.getReal, option) == "integrator.formulation is an Integer; it was read as a Real."
    assert complaint(instance, slave.setInteger, parameter, [1]) == "gravity[1] is a Real; it was set as an Integer."
    assert "was set as a Real" in complaint(instance, slave.setReal, option, [1.0])
    for call, arguments in (
        (slave.getBoolean, (real,)),
        (slave.getString, (real,)),
        (slave.setBoolean, (parameter, [1])),
        (slave.setString, (parameter, ["1"])),
    ):
        assert "this FMU has no variables of that type" in complaint(instance, call, *arguments)
    # No variable at all is nothing wrong.
    assert (slave.getBoolean([]), slave.getString([]), slave.getReal([]), slave.getInteger([])) == ([], [], [], [])


def test_outputs_cannot_be_set(new, model):
    instance = new(model)
    for phase in ("before", "after"):
        for variable in instance.fmu.description.modelVariables:
            if variable.causality == "output":
                setter = instance.slave.setReal if variable.type == "Real" else instance.slave.setInteger
                text = complaint(instance, setter, [variable.valueReference], [1])
                assert text == f"{variable.name} is an output; it cannot be set."
            elif variable.causality == "local":
                text = complaint(instance, instance.slave.setInteger, [variable.valueReference], [1])
                assert text == f"{variable.name} is computed; it cannot be set."
        if phase == "before":
            instance.start()


def test_a_refused_call_sets_none_of_its_values(new, model):
    """The bad one last: those before it must not stay."""
    instance, undisturbed = new(model), new(model).start()
    body = bodies(instance.fmu)[0]
    good = ["gravity[1]", "integrator.sigma", f"{body}.initialPosition[1]", f"{body}.force[2]"]
    values = [7.0, 0.3, 1.7, 11.0]
    for bad, value in (("integrator.stepSize", -1.0), ("energy.total", 0.0), ("integrator.steps", 1.0)):
        complaint(instance, instance.slave.setReal, instance.fmu.references([*good, bad]), [*values, value])
    complaint(instance, instance.slave.setReal, [*instance.fmu.references(good), 99999], [*values, 0.0])
    instance.start()
    assert_same_bits(instance.reals(good), undisturbed.reals(good))
    assert_same_bits(instance.trajectory(1e-3, 5), undisturbed.trajectory(1e-3, 5))


def test_derivatives_of_other_things_are_refused(new, model):
    instance, undisturbed = new(model).start(), new(model).start()
    slave, body = instance.slave, bodies(instance.fmu)[0]
    force = instance.fmu.references([f"{body}.force[1]", f"{body}.force[2]"])
    output = instance.fmu.references(["energy.total", f"{body}.velocity[1]"])
    parameter, counter = instance.fmu.references(["gravity[1]"]), instance.fmu.references(["integrator.steps"])
    for order in (0, 3, -1):
        text = complaint(instance, slave.setRealInputDerivatives, force, [1, order], [5.0, 1.0])
        assert text == f"The derivative order of {body}.force[2] is {order}; it must be 1 to 2."
    for order in (0, 2):
        text = complaint(instance, slave.getRealOutputDerivatives, output, [1, order])
        assert text == f"The derivative order of {body}.velocity[1] is {order}; it must be 1."
    for value in (math.nan, math.inf):
        text = complaint(instance, slave.setRealInputDerivatives, force, [1, 1], [5.0, value])
        assert text.startswith(f"Derivative 1 of {body}.force[2] is {value}; it must be finite")
        text = complaint(instance, slave.getDirectionalDerivative, output, force, [1.0, value])
        assert text == f"The direction of {body}.force[2] must be finite."
    text = complaint(instance, slave.setRealInputDerivatives, parameter, [1], [1.0])
    assert text == "gravity[1] is no input; derivatives can be set for inputs alone."
    text = complaint(instance, slave.getRealOutputDerivatives, counter, [1])
    assert text == "integrator.steps is no Real output; derivatives can be had of Real outputs alone."
    text = complaint(instance, slave.getDirectionalDerivative, output, parameter, [1.0])
    assert text == "gravity[1] is no input; directional derivatives exist with respect to inputs alone."
    text = complaint(instance, slave.getDirectionalDerivative, parameter, force, [1.0, 1.0])
    assert text == "gravity[1] is no Real output; directional derivatives exist of Real outputs alone."
    for each in (instance, undisturbed):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), undisturbed.outputs())


# --- calls in the wrong order ----------------------------------------------------------------------------------------

STATES = ("instantiated", "initialization mode", "step mode", "terminated")


def bring_to(instance: Instance, state: str) -> Instance:
    if state != "instantiated":
        instance.slave.enterInitializationMode()
    if state in {"step mode", "terminated"}:
        instance.slave.exitInitializationMode()
        instance.step(1e-3)
    if state == "terminated":
        instance.slave.terminate()
    return instance


def calls(instance: Instance) -> dict[str, tuple]:
    """Arguments after the instance for a call of each function that is right but for the state."""
    output = references(*instance.fmu.references(["energy.total"]))
    tunable = references(*instance.fmu.references(["gravity[1]"]))
    counter = references(*instance.fmu.references(["integrator.steps"]))
    known = references(*instance.fmu.references(inputs(instance.fmu)[:1]))
    one, state = doubles(0.0), instance.save()
    size, data = ctypes.c_size_t(), instance.slave.serializeFMUstate(state)
    return {
        "fmi2SetDebugLogging": (0, 0, None),
        "fmi2SetupExperiment": (0, 0.0, 0.0, 0, 0.0),
        "fmi2EnterInitializationMode": (),
        "fmi2ExitInitializationMode": (),
        "fmi2Terminate": (),
        "fmi2Reset": (),
        "fmi2GetReal": (output, 1, one),
        "fmi2SetReal": (tunable, 1, one),
        "fmi2GetInteger": (counter, 1, integers(0)),
        "fmi2SetInteger": (counter, 0, integers(0)),
        "fmi2GetBoolean": (counter, 0, None),
        "fmi2SetBoolean": (counter, 0, None),
        "fmi2GetString": (counter, 0, None),
        "fmi2SetString": (counter, 0, None),
        "fmi2GetFMUstate": (ctypes.byref(ctypes.c_void_p()),),
        "fmi2SetFMUstate": (state,),
        "fmi2SerializedFMUstateSize": (state, ctypes.byref(size)),
        "fmi2SerializeFMUstate": (state, ctypes.create_string_buffer(len(data)), len(data)),
        "fmi2DeSerializeFMUstate": (data, len(data), ctypes.byref(ctypes.c_void_p())),
        "fmi2FreeFMUstate": (ctypes.byref(state),),
        "fmi2GetDirectionalDerivative": (output, 1, known, 1, doubles(1.0), one),
        "fmi2SetRealInputDerivatives": (known, 1, integers(1), one),
        "fmi2GetRealOutputDerivatives": (output, 1, integers(1), one),
        "fmi2DoStep": (instance.time, 1e-3, 1),
        "fmi2GetRealStatus": (fmi2LastSuccessfulTime, ctypes.byref(ctypes.c_double())),
        "fmi2GetBooleanStatus": (fmi2Terminated, ctypes.byref(ctypes.c_int())),
    }


ALWAYS = STATES
READABLE, WRITABLE, DONE = STATES[1:], STATES[:3], STATES[2:]
ALLOWED = {  # FMI 2.0.4, section 4.2.4
    "fmi2SetDebugLogging": ALWAYS,
    "fmi2SetupExperiment": STATES[:1],
    "fmi2EnterInitializationMode": STATES[:1],
    "fmi2ExitInitializationMode": STATES[1:2],
    "fmi2Terminate": STATES[2:3],
    "fmi2Reset": ALWAYS,
    "fmi2GetReal": READABLE,
    "fmi2SetReal": WRITABLE,
    "fmi2GetInteger": READABLE,
    "fmi2SetInteger": WRITABLE,
    "fmi2GetBoolean": READABLE,
    "fmi2SetBoolean": WRITABLE,
    "fmi2GetString": READABLE,
    "fmi2SetString": WRITABLE,
    "fmi2GetFMUstate": ALWAYS,
    "fmi2SetFMUstate": ALWAYS,
    "fmi2SerializedFMUstateSize": ALWAYS,
    "fmi2SerializeFMUstate": ALWAYS,
    "fmi2DeSerializeFMUstate": ALWAYS,
    "fmi2FreeFMUstate": ALWAYS,
    "fmi2GetDirectionalDerivative": READABLE,
    "fmi2SetRealInputDerivatives": WRITABLE,
    "fmi2GetRealOutputDerivatives": DONE,
    "fmi2DoStep": STATES[2:3],
    "fmi2GetRealStatus": DONE,
    "fmi2GetBooleanStatus": DONE,
}


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("function", ALLOWED)
@pytest.mark.parametrize("model", ["SliderCrank"])
def test_each_function_is_allowed_in_the_states_of_the_standard(new, model, function, state):
    instance, undisturbed = bring_to(new(model), state), bring_to(new(model), state)
    arguments = calls(instance)[function]
    if state in ALLOWED[function]:
        assert instance.status(function, *arguments) == OK
        assert instance.messages == []
        return
    text = complaint(instance, getattr(instance.slave, function), instance.slave.component, *arguments)
    assert text == f'{function} is not allowed in the state "{state}".'
    # The call has left no trace.
    assert instance.serialized() == undisturbed.serialized()


def test_table_of_calls_is_complete(new):
    assert set(calls(bring_to(new("HeavyTop"), "step mode"))) == set(ALLOWED)


def test_a_second_life_after_the_end(new, model):
    instance, fresh = bring_to(new(model), "terminated"), new(model).start()
    assert instance.status("fmi2DoStep", 1e-3, 1e-3, 1) == ERROR
    instance.reset().start()
    assert_same_bits(instance.trajectory(1e-3, 5), fresh.trajectory(1e-3, 5))


def test_nothing_is_pending(new, model):
    """Steps end before fmi2DoStep returns: there is nothing to cancel and nothing to wait for."""
    instance = new(model).start()
    slave = instance.slave
    assert "no step is pending" in complaint(instance, slave.cancelStep)
    for call, kind in (
        (slave.getStatus, fmi2DoStepStatus),
        (slave.getStringStatus, fmi2PendingStatus),
        (slave.getIntegerStatus, fmi2LastSuccessfulTime),
        (slave.getBooleanStatus, fmi2DoStepStatus),
        (slave.getRealStatus, fmi2DoStepStatus),
    ):
        message = instance.refusal(call, kind)
        assert (message.status, message.category) == ("discard", "logStatusDiscard")
        assert "asynchronous" in message.text
    assert slave.getBooleanStatus(fmi2Terminated) is False
    assert slave.getRealStatus(fmi2LastSuccessfulTime) == 0.0


# --- instantiation ---------------------------------------------------------------------------------------------------


class Recorder:
    """A logger in C's eyes, which records all it is told."""

    def __init__(self, environment: int = 0x5EED):
        self.calls: list[tuple] = []
        self.functions = fmi2CallbackFunctions()
        self.functions.logger = fmi2CallbackLoggerTYPE(lambda *arguments: self.calls.append(arguments))
        self.functions.componentEnvironment = environment

    @property
    def text(self) -> str:
        return self.calls[-1][4].decode()


@pytest.fixture
def instantiate(new, model):
    """fmi2Instantiate with chosen arguments; what it returns is freed."""
    instance = new(model)
    components = []

    def call(recorder: Recorder | None, **arguments):
        chosen = {
            "name": b"it",
            "kind": 1,
            "guid": instance.fmu.description.guid.encode(),
            "resources": (instance.fmu.directory / "resources").as_uri().encode(),
        } | arguments
        functions = None if recorder is None else ctypes.byref(recorder.functions)
        names = ("name", "kind", "guid", "resources")
        component = instance.slave.fmi2Instantiate(*(chosen[n] for n in names), functions, 0, 0)
        components.append(component)
        return component

    yield call
    for component in components:
        if component:
            instance.slave.fmi2FreeInstance(component)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"name": b""}, "The instance name is missing; it must not be empty."),
        ({"name": None}, "The instance name is missing; it must not be empty."),
        ({"kind": 0}, "This FMU is for co-simulation alone."),
        ({"guid": b"{00000000-0000-0000-0000-000000000000}"}, "The GUID does not fit; it must be {guid}."),
        ({"guid": b""}, "The GUID does not fit; it must be {guid}."),
        ({"guid": None}, "The GUID does not fit; it must be {guid}."),
    ],
)
def test_instantiation_is_refused(fmu, model, instantiate, arguments, text):
    recorder = Recorder()
    assert instantiate(recorder, **arguments) is None
    (call,) = recorder.calls
    expected_name = arguments.get("name", b"it") or b""
    assert call[:4] == (0x5EED, expected_name, ERROR, b"logStatusError")
    assert recorder.text == text.replace("{guid}", fmu(model).description.guid)
    assert instantiate(recorder)


def test_instantiation_without_callbacks_or_logger(instantiate):
    assert instantiate(None) is None
    silent = Recorder()
    silent.functions.logger = fmi2CallbackLoggerTYPE()
    assert instantiate(silent, name=b"") is None
    assert instantiate(silent)


RESOURCES = {
    "null": None,
    "empty": b"",
    "three slashes": b"file:///no/such/folder%20here/resources",
    "one slash": b"file:/no/such/resources",
    "two slashes": b"file://host/share/resources",
    "umlauts, escaped": b"file:///tmp/M%C3%BCnchen/resources",
    "umlauts in UTF-8": "file:///tmp/München/resources".encode(),
    "umlauts in Latin-1": "file:///tmp/München/resources".encode("latin-1"),
    "a path of Windows": b"C:\\FMU\\resources",
    "half an escape": b"file:///tmp/%2",
    "capitals": b"FILE://LOCALHOST/tmp/resources",
    "this machine by its number": b"file://127.0.0.1/tmp/resources",
    "formats": b"%s%n",
    "long": b"file:///" + 100_000 * b"x",
}


@pytest.mark.parametrize("resources", RESOURCES.values(), ids=RESOURCES)
def test_resource_location_matters_only_where_there_are_resources(fmu, model, instantiate, resources):
    recorder = Recorder()
    component = instantiate(recorder, resources=resources)
    if not reads_resources(fmu(model)):
        assert component
        return
    assert component is None
    assert [call[2:4] for call in recorder.calls] == [(ERROR, b"logStatusError")]
    assert ".json" in recorder.text


@pytest.mark.parametrize("model", ["FlexiblePendulum"])
@pytest.mark.parametrize(
    "uri",
    [
        "file://{}",
        "FILE://{}",
        "File:{}",
        "file://localhost{}",
        "FILE://LocalHost{}",
        "file://127.0.0.1{}",
        "file://[::1]{}",
        "{}",
    ],
)
def test_scheme_and_host_of_the_resources_are_read_as_the_standard_says(fmu, model, uri, instantiate):
    """Both in any case (RFC 3986), and names of this machine are none of another."""
    resources = uri.format(fmu(model).directory / "resources")
    recorder = Recorder()
    assert instantiate(recorder, resources=resources.encode()), recorder.calls


@pytest.mark.parametrize("model", ["FlexiblePendulum"])
@pytest.mark.parametrize(
    ("uri", "text"),
    [
        ("HTTP://localhost/x", "; it must be a file URI, as file:///folder."),
        ("file:///x%00/resources", "; %%00 is not possible in a path."),
        ("%00", "%%00/beam.json: it cannot be opened"),
    ],
)
def test_other_locations_of_the_resources_are_refused(uri, text, instantiate):
    recorder = Recorder()
    assert instantiate(recorder, resources=uri.encode()) is None
    assert len(recorder.calls) == 1
    assert text in recorder.text


def test_folder_with_spaces_and_umlauts(fmu, model, tmp_path):
    folder = tmp_path / "Müller & Söhne 100%20"
    fmpy.extract(fmu(model).path, folder)
    H = float(fmu(model).description.defaultExperiment.stepSize)
    here, there = (fmpy.simulate_fmu(f, stop_time=H, output_interval=H) for f in (fmu(model).path, folder))
    assert here.tobytes() == there.tobytes()


def test_logger_gets_its_environment_and_the_name_of_the_instance(new, model, instantiate):
    slave = new(model).slave
    recorders = [Recorder(0x1111), Recorder(0x2222)]
    components = [instantiate(r, name=name) for r, name in zip(recorders, (b"first", b"second"), strict=True)]
    for component in components:
        assert status_of(slave.fmi2DoStep, component, 0.0, 1.0, 1) == ERROR
    assert [r.calls[0][:4] for r in recorders] == [
        (0x1111, b"first", ERROR, b"logStatusError"),
        (0x2222, b"second", ERROR, b"logStatusError"),
    ]
    assert [len(r.calls) for r in recorders] == [1, 1]


def test_messages_are_safe_for_a_logger_that_formats_them(new, model):
    """The logger is variadic like printf: a percent sign must come doubled, and nothing else may need arguments."""
    instance = new(model)
    categories = (ctypes.c_char_p * 1)(b"100%s of %n")
    call = (instance.slave.fmi2SetDebugLogging, instance.slave.component, 1, 1, categories)
    assert complaint(instance, *call) == 'The log category "100%%s of %%n" is unknown.'


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
