"""Control laws as plain Python classes: one file each, the standard library only, so that it can travel inside an FMU.

`SpeedPI`, `MagneticBearings` and `AxisAttitude` control; `Seal` is a disturbance with the same interface.
"""

from collections.abc import Mapping
from typing import Protocol

Variable = tuple[float, str, str]
"""Start value, unit, description."""


class Law(Protocol):
    """What a law has. It is sampled: `step` is called once at each sample, in the order of time.

    The names are those of the variables of the FMU that `sigmafmu.loop.controller_fmu` makes of it.
    """

    inputs: Mapping[str, Variable]
    outputs: Mapping[str, Variable]
    parameters: Mapping[str, Variable]
    values: dict[str, float]
    """The parameters of this instance; may be changed between samples."""

    def __init__(self, **values: float) -> None:
        """Parameters that are not given have their start values."""

    def reset(self) -> None:
        """Forget everything but the parameters."""

    def step(self, time: float, H: float, measured: Mapping[str, float]) -> dict[str, float]:
        """Outputs for [time, time + H] from the inputs measured at `time`; both in s."""
