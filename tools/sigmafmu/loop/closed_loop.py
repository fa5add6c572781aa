"""Run a closed loop: the plant's FMU through FMPy, the laws as Python or as FMUs, sampled with a period H.

At each sample t_n, in this order:

1. the plant's outputs y_n at t_n are read (they belong to the interval that ends at t_n) and recorded;
2. every law gets y_n and answers with u_n;
3. the plant's inputs become u_{n−d}, d the delay in samples (0 unless asked for), zero before the first answer arrives;
4. the plant steps from t_n to t_n + H. With `hold="zero"` its inputs stay as they are; with `hold="linear"` they go on
   with the slope (u_{n−d} − u_{n−d−1}) / H of the last two (a first-order hold; slope zero at first), which the FMU
   integrates as a ramp.

Masters that step all FMUs at once and exchange values afterwards have d = 1; see `sigmafmu.loop.ssp_masters`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager

import numpy as np
from fmpy.fmi1 import FMICallException

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu, LogMessage
from sigmafmu.instance import COUNTERS, Instance, SimulationError, reason
from sigmafmu.loop.controllers import Law
from sigmafmu.loop.loops import CONTROLLER, Loop, Part
from sigmafmu.result import Result, Statistics
from sigmafmu.steps import communication_steps
from sigmafmu.variables import SettingValue

Values = Mapping[str, float]
Step = Callable[[float, float, Values], Values]
"""(t_n, H, values of the law's inputs) → values of its outputs; an output that is left out is zero."""

HOLDS = ("zero", "linear")


def off(time: float, H: float, measured: Values) -> Values:
    """The controller that does nothing."""
    return {}


def run_closed_loop(
    loop: Loop,
    H: float | None = None,
    stop_time: float | None = None,
    controller: Law | Step | Fmu | None = None,
    hold: str = "zero",
    start_values: Mapping[str, SettingValue] | None = None,
    *,
    delay: int = 0,
) -> Result:
    """Run `loop` from 0 to `stop_time` with the sampling period `H`, both in s and by default those of the loop.

    `controller` replaces the law of the part "controller": another law, a function `(t, H, measured) -> actuation`, or
    a controller as an FMU; `off` does nothing. `start_values` are parameters of the plant, or of a part if they begin
    with its name ("controller.setPoint"). The result has a row for each sample: what the laws measured at t_n and
    `loop.shown`, then the plant's inputs as they are from t_n on (in the last row: up to there).
    """
    if hold not in HOLDS:
        raise SigmafmuError(f"hold is '{hold}', but must be one of {', '.join(HOLDS)}")
    if delay < 0:
        raise SigmafmuError(f"delay is {delay}, but must be 0 samples or more")
    fmu = Fmu.of_model(loop.plant)
    samples = communication_steps(fmu, loop.stop_time if stop_time is None else stop_time, loop.H if H is None else H)
    plant_values, part_values = split_start_values(loop, start_values or {})

    outputs, inputs = loop.outputs, loop.inputs
    references, input_references = fmu.references(outputs), fmu.references(inputs)
    rows, wall_time = [], 0.0
    zeros = [0.0] * len(inputs)
    answers = [zeros] * (delay + 1)  # the oldest first
    messages: list[LogMessage] = []
    with ExitStack() as stack:
        plant = stack.enter_context(Instance(fmu, plant_values, messages.append))
        plant.start()
        slave = plant.slave
        laws = {
            name: stack.enter_context(
                _law(part, controller if name == CONTROLLER else None, part_values[name], messages)
            )
            for name, part in loop.parts.items()
        }
        try:
            for start, size in samples:
                values = slave.getReal(references)
                known = dict(zip(outputs, values, strict=True))
                actuation = dict.fromkeys(inputs, 0.0)
                for name, part in loop.parts.items():
                    measured = {ours: known[theirs] for ours, theirs in part.measured.items()}
                    answer = laws[name](start, size, measured)
                    _check(name, part, answer, start)
                    actuation |= {part.actuated[ours]: value for ours, value in answer.items()}
                before, answers = answers[0], [*answers[1:], list(actuation.values())]
                applied = answers[0]
                rows.append([*values, *applied])
                slave.setReal(input_references, applied)
                if hold == "linear" and len(rows) > delay + 1:
                    slopes = [(now - then) / samples[0][1] for now, then in zip(applied, before, strict=True)]
                    slave.setRealInputDerivatives(input_references, [1] * len(inputs), slopes)
                began = time.perf_counter()
                slave.doStep(start, size)
                wall_time += time.perf_counter() - began
            rows.append([*slave.getReal(references), *applied])
            counters = slave.getInteger(fmu.references(list(COUNTERS.values())))
        except FMICallException as error:
            why = reason(messages, error)
            raise SimulationError(f"{loop.plant} in its loop stopped at t = {start:.6g} s: {why}") from error
    end = samples.end
    return Result(
        model=loop.plant,
        time=np.array([*(start for start, _ in samples), end]),
        names=(*outputs, *inputs),
        values=np.array(rows),
        units={name: fmu.variables[name].unit or "" for name in (*outputs, *inputs)},
        statistics=Statistics(end, wall_time, len(samples), **dict(zip(COUNTERS, counters, strict=True))),
    )


def _check(name: str, part: Part, answer: Values, now: float) -> None:
    for output, value in answer.items():
        if output not in part.actuated:
            raise SigmafmuError(f"the {name} answers with '{output}', but has the outputs {', '.join(part.actuated)}")
        if not math.isfinite(value):
            raise SigmafmuError(f"the {name} wants {output} = {value} at t = {now:.6g} s, which is not finite")


def split_start_values(
    loop: Loop, start_values: Mapping[str, SettingValue]
) -> tuple[dict[str, SettingValue], dict[str, dict[str, float]]]:
    """Start values of the plant, and those of each part by its name."""
    plant, parts = {}, {name: {} for name in loop.parts}
    for name, value in start_values.items():
        part, _, variable = name.partition(".")
        if part not in parts:
            plant[name] = value
            continue
        law = loop.parts[part].law
        if variable not in law.parameters:
            raise SigmafmuError(f"{law.__name__} has no parameter '{variable}'; it has {', '.join(law.parameters)}")
        try:
            parts[part][variable] = float(value)
        except (TypeError, ValueError):
            raise SigmafmuError(f"'{name}' needs a number, not '{value}'") from None
    return plant, parts


@contextmanager
def _law(
    part: Part, replacement: Law | Step | Fmu | None, values: dict[str, float], messages: list[LogMessage]
) -> Iterator[Step]:
    """The law of `part`, or `replacement`, as a function; `values` are parameters of either."""
    if isinstance(replacement, Fmu):
        with Instance(replacement, values, messages.append) as instance:
            instance.start()
            yield _step_of_fmu(replacement, instance.slave, part)
        return
    if replacement is None:
        yield part.law(**values).step
        return
    if values:
        raise SigmafmuError(f"start values for the controller ({', '.join(values)}), but it was given ready made")
    if callable(replacement):
        yield replacement
        return
    replacement.reset()
    yield replacement.step


def _step_of_fmu(fmu: Fmu, slave, part: Part) -> Step:
    """A controller FMU as a function: its outputs after fmi2DoStep(t_n, H) answer what was measured at t_n."""
    inputs, outputs = fmu.references(list(part.measured)), fmu.references(list(part.actuated))

    def step(time: float, H: float, measured: Values) -> Values:
        slave.setReal(inputs, [measured[name] for name in part.measured])
        slave.doStep(time, H)
        return dict(zip(part.actuated, slave.getReal(outputs), strict=True))

    return step
