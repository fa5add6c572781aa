"""Numbers that a worker makes of a run, so that its curves need not travel: maximum, RMS, or a function of yours."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.result import Result
from sigmafmu.variables import choose_one


def _mean(t: np.ndarray, y: np.ndarray) -> float:
    """Over time, by the trapezoidal rule."""
    return float(np.trapezoid(y, t) / (t[-1] - t[0]))


REDUCTIONS: dict[str, Callable[[np.ndarray, np.ndarray], float]] = {
    "max": lambda t, y: float(y.max()),
    "min": lambda t, y: float(y.min()),
    "maxabs": lambda t, y: float(np.abs(y).max()),
    "final": lambda t, y: float(y[-1]),
    "mean": _mean,
    "rms": lambda t, y: float(np.sqrt(_mean(t, y**2))),
    "argmax": lambda t, y: float(t[y.argmax()]),
}
"""Name → a number of times (n,) [s] and values (n,); `argmax` is the time of the maximum."""

Function = Callable[[Result], float]


@dataclass(frozen=True)
class Scalar:
    """One of them."""

    name: str
    units: str
    kind: str
    """A key of REDUCTIONS; empty for a function."""
    variable: str
    function: Function | None = None

    def of(self, result: Result) -> float:
        """Its value for a run; of a vector the length counts."""
        if self.function:
            return float(self.function(result))
        values = result[self.variable]
        return REDUCTIONS[self.kind](result.time, np.linalg.norm(values, axis=1) if values.ndim > 1 else values)


def read_scalars(fmu: Fmu, wanted: Iterable[str] | Mapping[str, str | Function]) -> list[Scalar]:
    """Texts such as `max(guide.reactionForce)`, or names with such texts or with functions; raises SigmafmuError."""
    if isinstance(wanted, str):
        wanted = [wanted]
    named = wanted if isinstance(wanted, Mapping) else {text: text for text in wanted}
    return [_scalar(fmu, name, what) for name, what in named.items()]


def _scalar(fmu: Fmu, name: str, what: str | Function) -> Scalar:
    if not isinstance(what, str):
        return Scalar(name, "", "", "", what)
    match = re.fullmatch(r"\s*(\w+)\(([^()]+)\)\s*", what)
    if not match or match[1] not in REDUCTIONS:
        raise SigmafmuError(f"'{what}' is no scalar; write max(VARIABLE), or one of {', '.join(REDUCTIONS)}")
    kind, variable = match[1], match[2].strip()
    units = choose_one(fmu, variable)[0].unit or ""
    return Scalar(name, "s" if kind == "argmax" else units, kind, variable)
