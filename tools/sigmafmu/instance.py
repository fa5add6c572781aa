"""A live instance of a model: set, step, get, save and restore, and runs that record."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, overload

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2LastSuccessfulTime

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu, LogMessage, MessageHandler
from sigmafmu.recorder import Reader, Recorder, TakeRows, check_memory
from sigmafmu.result import Result, Statistics
from sigmafmu.signals import Signal, Signals
from sigmafmu.steps import communication_steps
from sigmafmu.variables import SettingValue, choose_one, parse_settings, recorded_variables

COUNTERS = {
    "steps": "integrator.steps",
    "newton_iterations": "integrator.newtonIterations",
    "jacobian_evaluations": "integrator.jacobianEvaluations",
    "retries": "integrator.retries",
}


class SimulationError(SigmafmuError):
    """The model refused a call, with its own reason; `result` holds what a run recorded before that, if anything."""

    def __init__(self, message: str, result: Result | None = None):
        super().__init__(message)
        self.result = result


def reason(messages: Iterable[LogMessage], error: FMICallException) -> str:
    """The FMU's own complaints, which say more than the status of the call."""
    return "; ".join(dict.fromkeys(m.text for m in messages if m.is_complaint)) or str(error)


@dataclass(frozen=True)
class State:
    """All that an instance remembers, as bytes: it can be pickled, and restored in another process."""

    guid: str
    """Of the FMU that it belongs to."""
    time: float  # s
    data: bytes


class Instance:
    """One instance of a model, between its start values and wherever it was stepped to.

    It begins before its initialization: parameters can be set. What needs a running model (step, get, save, run) starts
    it; from then on inputs and tunable parameters can be set. Use it in a `with` statement, or call `close()`. All
    methods raise SimulationError with the model's own sentence if it refuses, and SigmafmuError for names that it does
    not have. After an error, `reset()` or `restore(state)` go on.
    """

    def __init__(
        self, fmu: Fmu, parameters: Mapping[str, SettingValue] | None = None, on_message: MessageHandler | None = None
    ):
        self.time = 0.0
        """Present time [s]."""
        self._fmu, self._on_message = fmu, on_message
        self._complaints: list[LogMessage] = []
        self._readers: dict[tuple[str, ...], Reader] = {}
        self._started = False
        self.slave: FMU2Slave = fmu.instantiate(self._receive)
        """FMPy's object, for calls that this class does not have."""
        try:
            self.set(parameters or {})
        except SigmafmuError:
            self.close()
            raise

    def __enter__(self) -> "Instance":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Instance of {self._fmu.name} at t = {self.time:g} s>"

    def close(self) -> None:
        """Free the instance."""
        if self.slave.component is not None:
            self.slave.freeInstance()
            self.slave.component = None

    @contextmanager
    def calls(self, what: str = "refuses") -> Iterator[None]:
        """Around calls of `slave`: if one fails, SimulationError tells why, as “<model> <what>: <reason>”."""
        self._begin()
        try:
            yield
        except FMICallException as error:
            raise SimulationError(f"{self._fmu.name} {what}: {reason(self._complaints, error)}") from error

    @overload
    def set(self, name: str, value: SettingValue, /) -> None: ...
    @overload
    def set(self, values: Mapping[str, SettingValue], /) -> None: ...
    def set(self, name: str | Mapping[str, SettingValue], value: SettingValue | None = None, /) -> None:
        """Set a parameter or an input, or all of a mapping.

        A value is a number in the variable's SI unit, a sequence for a vector, or the name of an enumeration's item.
        Inputs keep their values until they are set again.
        """
        if isinstance(name, str):
            if value is None:
                raise SigmafmuError(f"'{name}' needs a value")
            name = {name: value}
        setters = {
            "Real": self.slave.setReal,
            "Integer": self.slave.setInteger,
            "Enumeration": self.slave.setInteger,
            "Boolean": self.slave.setBoolean,
        }
        assignments = parse_settings(self._fmu, name)
        with self.calls():
            for variable, number in assignments:
                setters[variable.type]([variable.valueReference], [number])

    @overload
    def get(self, name: str, /) -> Any: ...
    @overload
    def get(self, names: list[str] | tuple[str, ...], /) -> np.ndarray: ...
    def get(self, name: str | list[str] | tuple[str, ...], /) -> Any:
        """Present value of the scalar `name` in its SI unit, or (k,) array of the vector `name[1..k]`.

        Of several names: an array of all their scalars, one after the other. An enumeration is the number of its item.
        """
        self.start()
        names = (name,) if isinstance(name, str) else tuple(name)
        if names not in self._readers:
            self._readers[names] = Reader(self.slave, [v for n in names for v in choose_one(self._fmu, n)])
        reader = self._readers[names]
        with self.calls():
            reader.read()
        values = reader.rows()[0]
        return float(values[0]) if isinstance(name, str) and name in self._fmu.variables else values

    def start(self) -> None:
        """Initialize with the parameters that were set; does nothing if the instance has been started."""
        if self._started:
            return
        with self.calls("cannot start"):
            self.slave.setupExperiment(startTime=0.0)
            self.slave.enterInitializationMode()
            self.slave.exitInitializationMode()
        self._started = True

    def step(self, H: float, /) -> None:
        """Step by `H` seconds; the integrator takes its own steps within.

        If that fails, `time` is what the model has reached.
        """
        self.start()
        self._begin()
        try:
            self.slave.doStep(self.time, H)
        except FMICallException as error:
            raise SimulationError(self._stopped(error)) from error
        self.time += H

    def save(self) -> State:
        """The present state, to the last bit: motion, inputs, parameters, what the integrator remembers."""
        self.start()
        with self.calls():
            state = self.slave.getFMUstate()
            try:
                data = self.slave.serializeFMUstate(state)
            finally:
                self.slave.freeFMUstate(state)
        return State(self._fmu.description.guid, self.time, data)

    def restore(self, state: State, /) -> None:
        """Go on from a state that this or another instance of the same FMU has saved."""
        if state.guid != self._fmu.description.guid:
            raise SigmafmuError(f"the state belongs to the FMU {state.guid}, not to {self._fmu.name}")
        self.start()
        with self.calls():
            restored = self.slave.deSerializeFMUstate(state.data)
            try:
                self.slave.setFMUstate(restored)
            finally:
                self.slave.freeFMUstate(restored)
        self.time = state.time

    def reset(self, parameters: Mapping[str, SettingValue] | None = None) -> None:
        """Back to before the initialization, with start values but for `parameters`: what was set is forgotten."""
        with self.calls():
            self.slave.reset()
        self.time, self._started = 0.0, False
        self.set(parameters or {})

    def run(
        self,
        stop_time: float | None = None,
        *,
        step_size: float | None = None,
        inputs: Mapping[str, Signal] | None = None,
        outputs: Iterable[str] = (),
        keep_every: int = 1,
        on_rows: TakeRows | None = None,
        on_time: Callable[[float], None] | None = None,
    ) -> Result:
        """Go on to `stop_time`, which counts from the instance's start; otherwise as `Model.run`."""
        steps = communication_steps(self._fmu, stop_time, step_size, self.time)
        signals = Signals(self._fmu, inputs or {})
        recorded = recorded_variables(self._fmu, outputs)
        check_memory(len(steps) // keep_every, len(recorded) + 1)
        before = self._counters() if self._started else {}
        for variable, value in signals.constants:
            self.set(variable.name, value)
        with self.calls("cannot start"):
            signals.set(self.slave, self.time)
            self.start()
            recorder = Recorder(self.slave, recorded, keep_every, on_rows)
            recorder.record(self.time)

        begin, wall_time, failure = self.time, 0.0, None
        self._begin()
        try:
            for start, size in steps:
                signals.set_step(self.slave, start, size)
                began = time.perf_counter()
                self.slave.doStep(start, size)
                wall_time += time.perf_counter() - began
                self.time = start + size
                recorder.record(self.time)
                if on_time:
                    on_time(self.time)
            signals.finish(self.slave, self.time)
        except FMICallException as error:
            failure = self._stopped(error)

        counters = {name: total - before.get(name, 0) for name, total in self._counters().items()}
        rows, count = recorder.finish()
        result = Result(
            model=self._fmu.name,
            time=rows[:, 0],
            names=recorder.names,
            values=rows[:, 1:],
            units={v.name: v.unit or "" for v in recorded},
            statistics=Statistics(float(rows[-1, 0]) - begin, wall_time, count - 1, **counters),
            fmu=self._fmu,
        )
        if failure:
            raise SimulationError(failure, result)
        return result

    def _receive(self, message: LogMessage) -> None:
        if message.is_complaint:
            self._complaints.append(message)
        if self._on_message:
            self._on_message(message)

    def _begin(self) -> None:
        """Before calls whose complaints belong together."""
        if self.slave.component is None:
            raise SigmafmuError(f"this instance of {self._fmu.name} is closed; make another")
        self._complaints.clear()

    def _stopped(self, error: FMICallException) -> str:
        """What to say of a step that failed; the time becomes what was reached."""
        with suppress(FMICallException):  # only a discarded step tells it
            self.time = float(self.slave.getRealStatus(fmi2LastSuccessfulTime))
        return f"{self._fmu.name} stopped at t = {self.time:.6g} s: {reason(self._complaints, error)}"

    def _counters(self) -> dict[str, int]:
        present = {field: name for field, name in COUNTERS.items() if name in self._fmu.variables}
        try:
            values = self.slave.getInteger(self._fmu.references(list(present.values())))
        except FMICallException:  # not readable after an error
            return {}
        return dict(zip(present, values, strict=True))
