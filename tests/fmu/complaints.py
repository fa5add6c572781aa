"""Complaints of an FMU about wrong calls: what they must be, and every call that can be wrong."""

import ctypes
from collections.abc import Callable

from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated

from .helpers import Instance, inputs

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
