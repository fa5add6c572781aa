"""Runs a mechanism from a file in this process, without an FMU around it."""

import time
from collections.abc import Callable, Iterable, Mapping
from fnmatch import fnmatchcase

import numpy as np

from sigmafmu import SigmafmuError, _core
from sigmafmu.fmu import LogMessage, MessageHandler
from sigmafmu.mechanism_file.load import MechanismFile, mechanism_of
from sigmafmu.result import Result, Statistics
from sigmafmu.simulate import COUNTERS, CommunicationSteps, SimulationError, TakeRows, steps_of

INTEGRATOR = "integrator."


def steps_of_file(file: MechanismFile, stop_time: float | None, step_size: float | None) -> CommunicationSteps:
    """The communication steps of a run, by default those of the file's experiment."""
    mechanism = file.mechanism
    return steps_of(stop_time or mechanism.stop_time, step_size or mechanism.communication_step)


def simulate_file(
    file: MechanismFile,
    *,
    stop_time: float | None = None,
    step_size: float | None = None,
    settings: Mapping[str, str] | None = None,
    variables: Iterable[str] = (),
    keep_every: int = 1,
    on_rows: TakeRows | None = None,
    on_time: Callable[[float], None] | None = None,
    on_message: MessageHandler | None = None,
) -> Result:
    """As sigmafmu.simulate.simulate, for a mechanism file: real outputs, and settings by the names of the FMU."""
    steps = steps_of_file(file, stop_time, step_size)
    mechanism, inputs = _with_settings(file, settings or {})
    names = _chosen(_core.Outputs(mechanism).names, tuple(variables))
    slave = _core.Slave(mechanism)
    rows, wall_time, failure = [], 0.0, None
    try:
        for name, value in inputs.items():
            slave.set(name, value)
        slave.start()
        rows.append([0.0, *map(slave.get, names)])
        for start, size in steps:
            began = time.perf_counter()
            slave.do_step(start, size)
            wall_time += time.perf_counter() - began
            rows.append([start + size, *map(slave.get, names)])
            if on_time:
                on_time(start + size)
    except (RuntimeError, ValueError) as error:
        if not rows:
            raise SimulationError(f"{mechanism.name} cannot start: {error}") from error
        failure = f"{mechanism.name} stopped at t = {rows[-1][0]:.6g} s: {error}"
    for text in slave.messages:
        if on_message:
            on_message(LogMessage("info", "", text))
    values = np.array(rows)
    if on_rows:
        on_rows(("time", *names), values)
    kept = values[sorted({*range(0, len(values), keep_every), len(values) - 1})]
    counters = {} if failure else {field: int(slave.get(name)) for field, name in COUNTERS.items()}
    statistics = Statistics(float(values[-1, 0]), wall_time, len(values) - 1, **counters)
    result = Result(mechanism.name, kept[:, 0], tuple(names), kept[:, 1:], statistics, source=file)
    if failure:
        raise SimulationError(failure, result)
    return result


def _chosen(outputs: list[str], patterns: tuple[str, ...]) -> list[str]:
    if not patterns:
        return outputs
    found = [name for name in outputs if any(name == p or fnmatchcase(name, p) for p in patterns)]
    for pattern in patterns:
        if not any(name == pattern or fnmatchcase(name, pattern) for name in outputs):
            raise SigmafmuError(f"no output is called {pattern}")
    return found


def _with_settings(file: MechanismFile, settings: Mapping[str, str]) -> tuple[_core.Mechanism, dict[str, float]]:
    """The mechanism with parameters set, and the inputs among the settings."""
    words, numbers = {}, {}
    for name, text in settings.items():
        values = _numbers(text)
        if values is None and not name.startswith(INTEGRATOR):
            raise SigmafmuError(f"--set {name}={text}: it must be a number, or several with commas")
        if values is None:
            words[name.removeprefix(INTEGRATOR)] = text
        elif len(values) == 1:
            numbers[name] = values[0]
        else:
            numbers |= {f"{name}[{i}]": value for i, value in enumerate(values, 1)}
    content = file.definition | {"integrator": file.definition["integrator"] | words}
    try:
        mechanism = mechanism_of(content, file.resources)
        inputs = {name: numbers[name] for name in _core.Outputs(mechanism).inputs if name in numbers}
        for name in numbers.keys() - inputs.keys():
            mechanism.set(name, numbers[name])
    except (ValueError, RuntimeError) as error:
        raise SigmafmuError(str(error).rstrip(".")) from error
    return mechanism, inputs


def _numbers(text: str) -> list[float] | None:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        return None
