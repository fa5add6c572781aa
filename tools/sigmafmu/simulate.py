"""Run an FMU as a co-simulation master would: fixed communication steps through FMPy's FMU2Slave."""

import ctypes
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2LastSuccessfulTime, fmi2ValueReference
from fmpy.model_description import ModelVariable

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu, LogMessage, MessageHandler
from sigmafmu.result import Result, Statistics
from sigmafmu.variables import SettingValue, Value, outputs, parse_settings, select

DEFAULT_COMMUNICATION_STEPS = 1000
COUNTERS = {
    "steps": "integrator.steps",
    "newton_iterations": "integrator.newtonIterations",
    "jacobian_evaluations": "integrator.jacobianEvaluations",
    "retries": "integrator.retries",
}


class SimulationError(SigmafmuError):
    """The FMU refused a call; `result` holds what was recorded before that, if anything."""

    def __init__(self, message: str, result: Result | None = None):
        super().__init__(message)
        self.result = result


def simulate(
    fmu: Fmu,
    *,
    stop_time: float | None = None,
    step_size: float | None = None,
    settings: Mapping[str, SettingValue] | None = None,
    variables: Iterable[str] = (),
    on_time: Callable[[float], None] | None = None,
    on_message: MessageHandler | None = None,
) -> Result:
    """Run `fmu` from 0 to `stop_time` in communication steps of `step_size`, recording `variables` at each of them.

    Both times default to the model's default experiment, `variables` (names or patterns) to all outputs. Raises
    SimulationError with the FMU's own message if the FMU refuses a call.
    """
    steps = communication_steps(fmu, stop_time, step_size)
    assignments = parse_settings(fmu, settings or {})
    variables = tuple(variables)
    recorded = select(fmu, variables) if variables else outputs(fmu)

    messages: list[LogMessage] = []

    def receive(message: LogMessage) -> None:
        messages.append(message)
        if on_message:
            on_message(message)

    slave = fmu.instantiate(receive)
    try:
        try:
            _initialize(slave, assignments, stop_time=sum(steps[-1]))
            recorder = _Recorder(slave, recorded, rows=len(steps) + 1)
            recorder.record(0.0)
        except FMICallException as error:
            raise SimulationError(f"{fmu.name} cannot start: {reason(messages, error)}") from error

        wall_time, failure = 0.0, None
        try:
            for start, size in steps:
                began = time.perf_counter()
                slave.doStep(start, size)
                wall_time += time.perf_counter() - began
                recorder.record(start + size)
                if on_time:
                    on_time(start + size)
        except FMICallException as error:
            reached = _last_successful_time(slave, default=recorder.time[recorder.rows - 1])
            failure = f"{fmu.name} stopped at t = {reached:.6g} s: {reason(messages, error)}"

        counters = _counters(slave, fmu)
        result = recorder.result(fmu.name, wall_time, counters)
        if failure:
            raise SimulationError(failure, result)
        slave.terminate()
        return result
    finally:
        slave.freeInstance()


def communication_steps(
    fmu: Fmu, stop_time: float | None = None, step_size: float | None = None
) -> list[tuple[float, float]]:
    """Start and size of each communication step; the last is shorter if the step size does not divide the stop time."""
    experiment = fmu.description.defaultExperiment
    if stop_time is None:
        stop_time = float(experiment.stopTime) if experiment and experiment.stopTime else 1.0
    if step_size is None:
        declared = float(experiment.stepSize) if experiment and experiment.stepSize else None
        step_size = declared or stop_time / DEFAULT_COMMUNICATION_STEPS
    for name, value in (("stop time", stop_time), ("step size", step_size)):
        if not (math.isfinite(value) and value > 0):
            raise SigmafmuError(f"the {name} must be a positive number of seconds, not {value:g}")
    rounding = 1e-9
    whole = math.floor(stop_time / step_size + rounding)
    steps = [(i * step_size, step_size) for i in range(whole)]
    rest = stop_time - whole * step_size
    return [*steps, (whole * step_size, rest)] if rest > rounding * step_size else steps


@contextmanager
def started(
    fmu: Fmu, settings: Mapping[str, SettingValue], messages: list[LogMessage] | None = None
) -> Iterator[FMU2Slave]:
    """A slave in step mode at t = 0, for masters of their own; what it reports goes to `messages`."""
    messages = [] if messages is None else messages
    slave = fmu.instantiate(messages.append)
    try:
        try:
            _initialize(slave, parse_settings(fmu, settings), stop_time=None)
        except FMICallException as error:
            raise SimulationError(f"{fmu.name} cannot start: {reason(messages, error)}") from error
        yield slave
    finally:
        slave.freeInstance()


def _initialize(slave: FMU2Slave, assignments: list[tuple[ModelVariable, Value]], stop_time: float | None) -> None:
    setters = {
        "Real": slave.setReal,
        "Integer": slave.setInteger,
        "Enumeration": slave.setInteger,
        "Boolean": slave.setBoolean,
    }
    for variable, value in assignments:
        setters[variable.type]([variable.valueReference], [value])
    slave.setupExperiment(startTime=0.0, stopTime=stop_time)
    slave.enterInitializationMode()
    slave.exitInitializationMode()


class _Block:
    """Variables of one FMI type; the FMU writes their values straight into the rows of an array."""

    def __init__(self, slave: FMU2Slave, getter: Callable, c_type: type, references: list[int], rows: int):
        self.values = np.zeros((rows, len(references)), dtype=c_type)
        self._slave, self._getter = slave, getter
        self._references = (fmi2ValueReference * len(references))(*references)
        self._row_type = c_type * len(references)

    def record(self, row: int) -> None:
        target = self._row_type.from_buffer(self.values, row * self.values.strides[0])
        self._getter(self._slave.component, self._references, len(self._references), target)


class _Recorder:
    """Values of chosen variables at the communication points."""

    def __init__(self, slave: FMU2Slave, variables: list[ModelVariable], rows: int):
        self.time = np.zeros(rows)
        self.rows = 0
        self._variables = variables
        self._blocks: list[tuple[list[int], _Block]] = []
        for types, getter, c_type in (
            ({"Real"}, slave.fmi2GetReal, ctypes.c_double),
            ({"Integer", "Enumeration"}, slave.fmi2GetInteger, ctypes.c_int),
            ({"Boolean"}, slave.fmi2GetBoolean, ctypes.c_int),
        ):
            columns = [i for i, v in enumerate(variables) if v.type in types]
            if columns:
                references = [variables[i].valueReference for i in columns]
                self._blocks.append((columns, _Block(slave, getter, c_type, references, rows)))

    def record(self, now: float) -> None:
        for _, block in self._blocks:
            block.record(self.rows)
        self.time[self.rows] = now
        self.rows += 1

    def result(self, model: str, wall_time: float, counters: dict[str, int]) -> Result:
        values = np.zeros((self.rows, len(self._variables)))
        for columns, block in self._blocks:
            values[:, columns] = block.values[: self.rows]
        return Result(
            model=model,
            time=self.time[: self.rows],
            names=tuple(v.name for v in self._variables),
            values=values,
            units={v.name: v.unit or "" for v in self._variables},
            statistics=Statistics(float(self.time[self.rows - 1]), wall_time, self.rows - 1, **counters),
        )


def reason(messages: list[LogMessage], error: FMICallException) -> str:
    """The FMU's own complaints, which say more than the status of the call."""
    complaints = dict.fromkeys(m.text for m in messages if m.is_complaint)
    return "; ".join(complaints) or str(error)


def _counters(slave: FMU2Slave, fmu: Fmu) -> dict[str, int]:
    present = {field: name for field, name in COUNTERS.items() if name in fmu.variables}
    try:
        values = slave.getInteger(fmu.references(list(present.values())))
    except FMICallException:  # not readable after an error
        return {}
    return dict(zip(present, values, strict=True))


def _last_successful_time(slave: FMU2Slave, default: float) -> float:
    try:
        return slave.getRealStatus(fmi2LastSuccessfulTime)
    except FMICallException:  # only a discarded step has one
        return default
