"""The communication steps of a run."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu

DEFAULT_COMMUNICATION_STEPS = 1000
ROUNDING = 1e-9
"""Of a communication step: a shorter rest is none."""


@dataclass(frozen=True)
class CommunicationSteps(Sequence[tuple[float, float]]):
    """Start and size of each communication step, computed when asked for: a long run has more than fit in memory."""

    step_size: float  # s
    whole: int
    rest: float  # s
    """The last, shorter step; 0 if there is none."""
    begin: float = 0.0  # s

    def __len__(self) -> int:
        return self.whole + (self.rest > 0)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        i = index + len(self) if index < 0 else index
        if not 0 <= i < len(self):
            raise IndexError(index)
        return self.begin + i * self.step_size, self.step_size if i < self.whole else self.rest

    @property
    def end(self) -> float:
        """Where the last step ends [s]."""
        return sum(self[-1])


def communication_steps(
    fmu: Fmu, stop_time: float | None = None, step_size: float | None = None, begin: float = 0.0
) -> CommunicationSteps:
    """The communication steps of a run; the last is shorter if the step size does not divide the time."""
    experiment = fmu.description.defaultExperiment
    if stop_time is None:
        stop_time = float(experiment.stopTime) if experiment and experiment.stopTime else 1.0
    if step_size is None:
        declared = float(experiment.stepSize) if experiment and experiment.stepSize else None
        step_size = declared or stop_time / DEFAULT_COMMUNICATION_STEPS
    for name, value in (("stop time", stop_time), ("step size", step_size)):
        if not (math.isfinite(value) and value > 0):
            raise SigmafmuError(f"the {name} must be a positive number of seconds, not {value:g}")
    length = stop_time - begin
    if length < ROUNDING * step_size:
        raise SigmafmuError(f"the stop time must be above the present time {begin:g} s, not {stop_time:g} s")
    if stop_time / step_size > 2**53:
        raise SigmafmuError(f"the step size {step_size:g} s is too small to count {stop_time:g} s in such steps")
    whole = math.floor(length / step_size + ROUNDING)
    rest = length - whole * step_size
    return CommunicationSteps(step_size, whole, rest if rest > ROUNDING * step_size else 0.0, begin)
