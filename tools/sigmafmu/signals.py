"""Inputs of a run over time: straight lines between the communication points."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import ArrayLike

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.variables import SettingValue, choose_one, parse_settings

Signal = SettingValue | tuple[ArrayLike, ArrayLike] | Callable[[float], ArrayLike]
"""A constant, a table (times [s], values) or a function of time [s]; a vector's table has a column for each element."""

ROUNDING = 1e-12
"""Relative, of communication points."""

_AtTime = Callable[[float], ArrayLike]


class Signals:
    """The inputs of one run."""

    def __init__(self, fmu: Fmu, inputs: Mapping[str, Signal]):
        constants: dict[str, Any] = {}
        self._references: list[int] = []
        self._begins: list[tuple[str, int, _AtTime]] = []
        self._ends: list[tuple[str, int, _AtTime]] = []
        for name, value in inputs.items():
            elements = choose_one(fmu, name)
            if elements[0].causality != "input":
                raise SigmafmuError(f"'{name}' is no input of {fmu.name}; it is of causality {elements[0].causality}")
            if callable(value):
                begin = end = value
            elif _is_table(value):
                begin, end = _table(name, *value)  # type: ignore[misc]
            else:
                constants[name] = value
                continue
            self._references += [v.valueReference for v in elements]
            self._begins.append((name, len(elements), begin))
            self._ends.append((name, len(elements), end))
        self.constants = parse_settings(fmu, constants)
        self._interpolates = bool(fmu.description.coSimulation.canInterpolateInputs)

    def set(self, slave: FMU2Slave, now: float) -> None:
        """Values at a time [s]."""
        if self._references:
            slave.setReal(self._references, _values(self._begins, now))

    def set_step(self, slave: FMU2Slave, now: float, size: float) -> None:
        """Values at the begin of a step, and the slope to those at its end."""
        if not self._references:
            return
        begin = _values(self._begins, now)
        slave.setReal(self._references, begin)
        if self._interpolates:
            slopes = (_values(self._ends, now + size) - begin) / size
            slave.setRealInputDerivatives(self._references, [1] * len(slopes), slopes)

    def finish(self, slave: FMU2Slave, now: float) -> None:
        """Leave the inputs where they are at the end of the last step."""
        if self._references:
            slave.setReal(self._references, _values(self._ends, now))


def _is_table(value: object) -> bool:
    return isinstance(value, tuple) and len(value) == 2 and all(np.ndim(part) > 0 for part in value)


def _table(name: str, times: ArrayLike, values: ArrayLike) -> tuple[_AtTime, _AtTime]:
    """Interpolation with what holds from a time on, and up to it: a time that comes twice is a jump."""
    t, u = np.asarray(times, dtype=float), np.asarray(values, dtype=float)
    if t.ndim != 1 or len(u) != len(t) or u.ndim > 2:
        raise SigmafmuError(f"the table of '{name}' has times of shape {t.shape} and values of shape {u.shape}")
    if not (np.isfinite(t).all() and np.isfinite(u).all() and (np.diff(t) >= 0).all()):
        raise SigmafmuError(f"the table of '{name}' must be finite, and its times must not decrease")
    columns = u.reshape(len(t), -1).T

    def snapped(now: float) -> float:
        """The time of the table that rounding has moved communication points away from, so that jumps are at these."""
        i = int(np.searchsorted(t, now))
        return next((float(x) for x in t[max(i - 1, 0) : i + 1] if math.isclose(x, now, rel_tol=ROUNDING)), now)

    def from_here(now: float) -> np.ndarray:
        return np.array([np.interp(snapped(now), t, column) for column in columns])

    def up_to_here(now: float) -> np.ndarray:
        return np.array([np.interp(-snapped(now), -t[::-1], column[::-1]) for column in columns])

    return from_here, up_to_here


def _values(signals: Sequence[tuple[str, int, _AtTime]], now: float) -> np.ndarray:
    parts = []
    for name, size, at in signals:
        part = np.atleast_1d(np.asarray(at(now), dtype=float))
        if part.shape != (size,):
            raise SigmafmuError(f"'{name}' has {size} elements, but its signal has shape {part.shape} at t = {now:g} s")
        parts.append(part)
    return np.concatenate(parts)
