"""What the tests of the FMUs share: an instance that knows its variables by name, and small numerical tools."""

import ctypes
import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2LastSuccessfulTime
from fmpy.model_description import ModelVariable

from sigmafmu.fmu import Fmu, LogMessage
from sigmafmu.variables import SettingValue, parse_settings, select

OK, WARNING, DISCARD, ERROR, FATAL = range(5)

EPS = float(np.finfo(float).eps)

FORMULATIONS = ("index3", "index2", "stabilizedIndex2")
CORRECTORS = ("residual", "incremental")
JACOBIANS = ("full", "tangentFree")
NEWTONS = ("full", "modified")
METHODS = ("generalizedAlpha", "rkmk4", "rkmk54", "bliedf2")
GROUPS = ("R3xSO3", "SE3")
LOCAL_COORDINATES = ("exp", "cayley", "cayley2")
ABSOLUTE_COORDINATES = ("quaternion", "rotationVector")

Settings = Mapping[str, SettingValue]


def integrator_combinations() -> list[Settings]:
    """Every choice of formulation, corrector, jacobian and newton; a sigma of its own for each body; controlled steps;
    every method on every group, with all coordinates taking turns."""
    names = ("formulation", "corrector", "jacobian", "newton")
    return [
        {"integrator.sigmaMode": "spinOptimal"},
        *({"integrator.stepControl": "error", "integrator.method": method} for method in METHODS),
        *(
            {f"integrator.{name}": value for name, value in zip(names, values, strict=True)}
            for values in itertools.product(FORMULATIONS, CORRECTORS, JACOBIANS, NEWTONS)
        ),
        *method_combinations(),
    ]


def method_combinations() -> list[Settings]:
    """Every method on every group. Each kind of coordinates occurs with each method."""
    names = ("method", "group", "localCoordinates", "absoluteCoordinates")
    coordinates = {
        "R3xSO3": (("exp", "rotationVector"), ("cayley2", "quaternion")),
        "SE3": (("exp", "quaternion"), ("cayley", "rotationVector")),
    }
    return [
        {f"integrator.{name}": value for name, value in zip(names, (method, group, *chosen), strict=True)}
        for method in METHODS
        for group in GROUPS
        for chosen in coordinates[group]
    ]


def real_outputs(fmu: Fmu) -> list[str]:
    return [v.name for v in fmu.description.modelVariables if v.causality == "output" and v.type == "Real"]


def counters(fmu: Fmu) -> list[str]:
    return [v.name for v in fmu.description.modelVariables if v.causality == "local" and v.type == "Integer"]


def inputs(fmu: Fmu) -> list[str]:
    return [v.name for v in fmu.description.modelVariables if v.causality == "input"]


def parameters(fmu: Fmu, variability: str) -> list[ModelVariable]:
    return [v for v in fmu.description.modelVariables if v.causality == "parameter" and v.variability == variability]


def bodies(fmu: Fmu) -> list[str]:
    return owners(fmu, ".initialQuaternion[1]")


def rigid_bodies(fmu: Fmu) -> list[str]:
    return owners(fmu, ".mass")


def flexible_bodies(fmu: Fmu) -> list[str]:
    return owners(fmu, ".modal[1]")


def owners(fmu: Fmu, variable: str) -> list[str]:
    return [name.removesuffix(variable) for name in fmu.variables if name.endswith(variable)]


def is_made_of_a_file(fmu: Fmu) -> bool:
    """Whether it reads its mechanism from the resources."""
    return (fmu.directory / "resources" / "identity.json").exists()


def modal_files(fmu: Fmu) -> list[Path]:
    """The modal data of its flexible bodies."""
    own = {"mechanism.json", "identity.json", "shapes.json"}
    return sorted(path for path in (fmu.directory / "resources").glob("*.json") if path.name not in own)


def reads_resources(fmu: Fmu) -> bool:
    """Whether its binary reads anything there; a rigid FMU that has been compiled has only a file for drawings."""
    return is_made_of_a_file(fmu) or bool(modal_files(fmu))


class Instance:
    """One instance of an FMU, with names instead of value references; it remembers every log message."""

    def __init__(self, fmu: Fmu, *, debug: bool = False):
        self.fmu = fmu
        self.messages: list[LogMessage] = []
        self.slave = fmu.instantiate(self.messages.append, debug=debug)
        self.time = 0.0
        self.all_outputs = (real_outputs(fmu), counters(fmu))

    def free(self) -> None:
        if self.slave.component:
            self.slave.freeInstance()
            self.slave.component = None

    # --- values -----------------------------------------------------------------------------------------------------

    def names(self, name: str) -> list[str]:
        """The elements of the vector `name`, or the scalar itself."""
        return [v.name for v in select(self.fmu, [name])]

    def get(self, name: str) -> np.ndarray | float:
        """A Real variable or a whole vector."""
        values = self.reals(self.names(name))
        return float(values[0]) if name in self.fmu.variables else values

    def reals(self, names: Sequence[str]) -> np.ndarray:
        return np.array(self.slave.getReal(self.fmu.references(list(names))))

    def integer(self, name: str) -> int:
        return self.slave.getInteger(self.fmu.references([name]))[0]

    def outputs(self) -> np.ndarray:
        """Every output, integers too; for comparing bit by bit."""
        reals, integers = (self.fmu.references(names) for names in self.all_outputs)
        return np.concatenate([self.slave.getReal(reals), self.slave.getInteger(integers)])

    def set(self, settings: Settings) -> None:
        """Set parameters and inputs, Reals in one call."""
        pairs = parse_settings(self.fmu, settings)
        for setter, types in ((self.slave.setReal, {"Real"}), (self.slave.setInteger, {"Integer", "Enumeration"})):
            chosen = [(v.valueReference, value) for v, value in pairs if v.type in types]
            if chosen:
                setter(*zip(*chosen, strict=True))

    def set_input_derivatives(self, order: int, rates: Mapping[str, float]) -> None:
        self.slave.setRealInputDerivatives(self.fmu.references(list(rates)), [order] * len(rates), list(rates.values()))

    def output_derivatives(self, names: Sequence[str]) -> np.ndarray:
        return np.array(self.slave.getRealOutputDerivatives(self.fmu.references(list(names)), [1] * len(names)))

    def directional_derivatives(self, unknowns: Sequence[str], direction: Mapping[str, float]) -> np.ndarray:
        references = self.fmu.references
        return np.array(
            self.slave.getDirectionalDerivative(
                references(list(unknowns)), references(list(direction)), list(direction.values())
            )
        )

    # --- life ---------------------------------------------------------------------------------------------------------

    def start(
        self, settings: Settings | None = None, *, start_time: float = 0.0, stop_time: float | None = None
    ) -> "Instance":
        """From instantiated to step mode."""
        self.set(settings or {})
        self.slave.setupExperiment(startTime=start_time, stopTime=stop_time)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = start_time
        return self

    def reset(self) -> "Instance":
        self.slave.reset()
        return self

    def step(self, H: float) -> None:
        self.slave.doStep(self.time, H)
        self.time += H

    def steps(self, H: float, count: int) -> None:
        """Communication points start + i H, not accumulated."""
        start = self.time
        for i in range(count):
            self.slave.doStep(start + i * H, H)
        self.time = start + count * H

    def trajectory(self, H: float, count: int) -> np.ndarray:
        """All outputs now and after each of `count` steps."""
        rows, start = [self.outputs()], self.time
        for i in range(count):
            self.slave.doStep(start + i * H, H)
            rows.append(self.outputs())
        self.time = start + count * H
        return np.array(rows)

    def last_successful_time(self) -> float:
        return self.slave.getRealStatus(fmi2LastSuccessfulTime)

    def save(self) -> ctypes.c_void_p:
        return self.slave.getFMUstate()

    def restore(self, state: ctypes.c_void_p) -> None:
        self.slave.setFMUstate(state)

    def serialized(self) -> bytes:
        state = self.save()
        data = self.slave.serializeFMUstate(state)
        self.slave.freeFMUstate(state)
        return data

    def deserialize(self, data: bytes) -> None:
        state = self.slave.deSerializeFMUstate(data)
        self.restore(state)
        self.slave.freeFMUstate(state)

    # --- refusals -----------------------------------------------------------------------------------------------------

    def status(self, function: str, *arguments) -> int:
        """Status of the C function `function` called with this instance and `arguments`."""
        return status_of(getattr(self.slave, function), self.slave.component, *arguments)

    def refusal(self, call: Callable, *arguments, **keywords) -> LogMessage:
        """The one message of a call that must fail, and whose status the message must carry."""
        self.messages.clear()
        status = status_of(call, *arguments, **keywords)
        assert len(self.messages) == 1, f"expected one message, got {[str(m) for m in self.messages]}"
        message = self.messages[0]
        assert (status, message.status) in {(DISCARD, "discard"), (ERROR, "error")}
        return message


def status_of(call: Callable, *arguments, **keywords) -> int:
    try:
        result = call(*arguments, **keywords)
    except FMICallException as error:
        return error.status
    return result if isinstance(result, int) else OK


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def assert_same_bits(a: np.ndarray, b: np.ndarray, names: Sequence[str] = ()) -> None:
    """Equal to the last bit; says which columns differ if not."""
    if same_bits(a, b):
        return
    assert a.shape == b.shape
    columns = np.flatnonzero((np.atleast_2d(a) != np.atleast_2d(b)).any(axis=0))
    raise AssertionError(f"different bits in {[names[i] for i in columns] if len(names) else columns.tolist()}")


def orders(errors: Iterable[float]) -> np.ndarray:
    """Observed orders of errors at halved step sizes."""
    errors = np.asarray(list(errors))
    return np.log2(errors[:-1] / errors[1:])


def fastest_rotation(instance: Instance) -> float:
    """Largest angular velocity, rad/s, at least 1: the time scale of the motion, vibrations included."""
    rates = [np.linalg.norm(instance.get(f"{body}.angularVelocity")) for body in bodies(instance.fmu)]
    rates += [2 * np.linalg.norm(instance.get(f"{b}.angularAcceleration")) ** 0.5 for b in bodies(instance.fmu)]
    masses = [instance.get(f"{body}.mass") for body in rigid_bodies(instance.fmu)]
    stiffness = sum(float(instance.get(f"{s}.stiffness").max()) for s in owners(instance.fmu, ".stiffness[1]"))
    if masses:  # a bar rocks faster than it bounces, and its energy goes up and down twice as fast
        rates.append(4 * np.sqrt(stiffness / min(masses)))
    for path in modal_files(instance.fmu):
        held = max(json.loads(path.read_text())["frequencies"])  # Hz, with the frame held: less than those of the body
        rates.append(1.5 * 2 * np.pi * held)
    return max(1.0, *rates)


def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """R_WB of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )
