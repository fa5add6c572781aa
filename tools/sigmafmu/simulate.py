"""Run an FMU as a co-simulation master would: fixed communication steps through FMPy's FMU2Slave."""

import ctypes
import math
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2LastSuccessfulTime, fmi2ValueReference
from fmpy.model_description import ModelVariable

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu, LogMessage, MessageHandler
from sigmafmu.result import Result, Statistics
from sigmafmu.variables import SettingValue, Value, outputs, parse_settings, select

DEFAULT_COMMUNICATION_STEPS = 1000
ROUNDING = 1e-9
"""Of a communication step: a shorter rest is none."""
CHUNK_ROWS = 1024
"""Rows that are recorded before they go on to whoever takes them."""
MEMORY_SHARE = 0.5
"""The part of the machine's memory that the rows of a run may take."""
COUNTERS = {
    "steps": "integrator.steps",
    "newton_iterations": "integrator.newtonIterations",
    "jacobian_evaluations": "integrator.jacobianEvaluations",
    "retries": "integrator.retries",
}


TakeRows = Callable[[Sequence[str], np.ndarray], None]
"""Gets the names of the columns (the first is time) and some rows, which are reused afterwards."""


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
    keep_every: int = 1,
    on_rows: TakeRows | None = None,
    on_time: Callable[[float], None] | None = None,
    on_message: MessageHandler | None = None,
) -> Result:
    """Run `fmu` from 0 to `stop_time` in communication steps of `step_size`, recording `variables` at each of them.

    Both times default to the model's default experiment, `variables` (names or patterns) to all outputs. The result
    holds every `keep_every`-th row and the last one; `on_rows` gets all of them, in pieces. Raises SimulationError with
    the FMU's own message if the FMU refuses a call.
    """
    steps = communication_steps(fmu, stop_time, step_size)
    assignments = parse_settings(fmu, settings or {})
    recorded = recorded_variables(fmu, variables)
    _check_memory(len(steps) // keep_every, len(recorded) + 1)

    messages: list[LogMessage] = []

    def receive(message: LogMessage) -> None:
        messages.append(message)
        if on_message:
            on_message(message)

    slave = fmu.instantiate(receive)
    try:
        try:
            _initialize(slave, assignments, stop_time=sum(steps[-1]))
            recorder = _Recorder(slave, recorded, keep_every, on_rows)
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
            reached = _last_successful_time(slave, default=recorder.last_time)
            failure = f"{fmu.name} stopped at t = {reached:.6g} s: {reason(messages, error)}"

        counters = _counters(slave, fmu)
        result = recorder.result(fmu, wall_time, counters)
        if failure:
            raise SimulationError(failure, result)
        slave.terminate()
        return result
    finally:
        slave.freeInstance()


def recorded_variables(fmu: Fmu, variables: Iterable[str]) -> list[ModelVariable]:
    """What a run records: `variables` (names or patterns), or all outputs if there are none."""
    variables = tuple(variables)
    return select(fmu, variables) if variables else outputs(fmu)


@dataclass(frozen=True)
class CommunicationSteps(Sequence[tuple[float, float]]):
    """Start and size of each communication step, computed when asked for: a long run has more than fit in memory."""

    step_size: float  # s
    whole: int
    rest: float  # s
    """The last, shorter step; 0 if there is none."""

    def __len__(self) -> int:
        return self.whole + (self.rest > 0)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        i = index + len(self) if index < 0 else index
        if not 0 <= i < len(self):
            raise IndexError(index)
        return i * self.step_size, self.step_size if i < self.whole else self.rest


def communication_steps(fmu: Fmu, stop_time: float | None = None, step_size: float | None = None) -> CommunicationSteps:
    """The communication steps of a run; the last is shorter if the step size does not divide the stop time."""
    experiment = fmu.description.defaultExperiment
    if stop_time is None:
        stop_time = float(experiment.stopTime) if experiment and experiment.stopTime else 1.0
    if step_size is None:
        declared = float(experiment.stepSize) if experiment and experiment.stepSize else None
        step_size = declared or stop_time / DEFAULT_COMMUNICATION_STEPS
    return steps_of(stop_time, step_size)


def steps_of(stop_time: float, step_size: float) -> CommunicationSteps:
    """Communication steps from 0 to `stop_time`."""
    for name, value in (("stop time", stop_time), ("step size", step_size)):
        if not (math.isfinite(value) and value > 0):
            raise SigmafmuError(f"the {name} must be a positive number of seconds, not {value:g}")
    if stop_time / step_size > 2**53:
        raise SigmafmuError(f"the step size {step_size:g} s is too small to count {stop_time:g} s in such steps")
    whole = math.floor(stop_time / step_size + ROUNDING)
    rest = stop_time - whole * step_size
    return CommunicationSteps(step_size, whole, rest if rest > ROUNDING * step_size else 0.0)


def _check_memory(rows: int, columns: int) -> None:
    needed = rows * columns * np.dtype(float).itemsize
    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > MEMORY_SHARE * installed:
        raise SigmafmuError(
            f"{rows} rows of {columns} columns take {needed / 1e9:.3g} GB, and this machine has {installed / 1e9:.3g} "
            "GB of memory; record fewer variables, take longer communication steps, or keep every n-th row"
        )


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
    """Values of chosen variables at the communication points, in chunks; keeps every `keep_every`-th row and the last.

    A chunk that is full goes to `on_rows`, so that a run of any length takes no more memory than what is kept of it.
    """

    def __init__(
        self, slave: FMU2Slave, variables: list[ModelVariable], keep_every: int = 1, on_rows: TakeRows | None = None
    ):
        self.last_time = 0.0
        self._variables, self._keep_every, self._on_rows = variables, keep_every, on_rows
        self._chunk = np.zeros((CHUNK_ROWS, len(variables) + 1))
        self._filled, self._flushed = 0, 0  # rows of the chunk, and before it
        self._kept: list[np.ndarray] = []
        self._blocks: list[tuple[list[int], _Block]] = []
        for types, getter, c_type in (
            ({"Real"}, slave.fmi2GetReal, ctypes.c_double),
            ({"Integer", "Enumeration"}, slave.fmi2GetInteger, ctypes.c_int),
            ({"Boolean"}, slave.fmi2GetBoolean, ctypes.c_int),
        ):
            columns = [i for i, v in enumerate(variables) if v.type in types]
            if columns:
                references = [variables[i].valueReference for i in columns]
                block = _Block(slave, getter, c_type, references, CHUNK_ROWS)
                self._blocks.append(([i + 1 for i in columns], block))

    def record(self, now: float) -> None:
        if self._filled == CHUNK_ROWS:
            self._flush()
        for _, block in self._blocks:
            block.record(self._filled)
        self._chunk[self._filled, 0] = self.last_time = now
        self._filled += 1

    def _flush(self) -> None:
        rows = self._chunk[: self._filled]
        for columns, block in self._blocks:
            rows[:, columns] = block.values[: self._filled]
        self._kept.append(rows[-self._flushed % self._keep_every :: self._keep_every].copy())
        if self._on_rows:
            self._on_rows(("time", *(v.name for v in self._variables)), rows)
        self._flushed += self._filled
        self._filled = 0

    def result(self, fmu: Fmu, wall_time: float, counters: dict[str, int]) -> Result:
        last = self._filled - 1  # never -1: a chunk is emptied only to record another row
        self._flush()
        if (self._flushed - 1) % self._keep_every:
            self._kept.append(self._chunk[[last]])
        rows = np.concatenate(self._kept)
        return Result(
            model=fmu.name,
            time=rows[:, 0],
            names=tuple(v.name for v in self._variables),
            values=rows[:, 1:],
            units={v.name: v.unit or "" for v in self._variables},
            statistics=Statistics(self.last_time, wall_time, self._flushed - 1, **counters),
            source=fmu,
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
