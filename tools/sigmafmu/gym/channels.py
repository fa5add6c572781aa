"""What an environment reads and sets: variables of a model, as rows of numbers and by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from fmpy.model_description import ModelVariable

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.variables import Variable, choose_one, select, vectors

Bound = float | Sequence[float]
Bounds = tuple[Bound, Bound] | None
"""Lowest and highest value, of a vector for all elements or for each; None: those that the model tells."""
Names = Iterable[str] | Mapping[str, Bounds]


class Outputs(dict[str, Any]):
    """Values by name: floats, arrays of vectors, and `time` [s]. SigmafmuError tells what to do about others."""

    def __missing__(self, name: str) -> Any:
        elements: list[float] = []
        while (element := f"{name}[{len(elements) + 1}]") in self:
            elements.append(self[element])
        if not elements:
            known = ", ".join(vectors(self))
            raise SigmafmuError(f"the environment does not read '{name}'; name it in `outputs` (it reads {known})")
        return np.array(elements)


@dataclass(frozen=True)
class Channels:
    """Scalars in the order in which their numbers stand, with their bounds."""

    names: tuple[str, ...]
    references: tuple[int, ...]
    low: np.ndarray  # (n,)
    high: np.ndarray  # (n,)


def observed(fmu: Fmu, wanted: Names) -> Channels:
    """Scalars, vectors and patterns; without bounds and where the model tells none, they are infinite."""
    found = _channels(wanted, lambda name: select(fmu, [name]))
    if not found.names:
        raise SigmafmuError("an environment needs one observation or more")
    return found


def acted(fmu: Fmu, wanted: Names) -> Channels:
    """Inputs, which need finite bounds."""

    def inputs(name: str) -> list[ModelVariable]:
        variables = choose_one(fmu, name)
        if variables[0].causality != "input":
            raise SigmafmuError(f"'{name}' is no input of {fmu.name}; it is of causality {variables[0].causality}")
        return variables

    found = _channels(wanted, inputs)
    if not found.names:
        raise SigmafmuError("an environment needs one action or more")
    for name, low, high in zip(found.names, found.low, found.high, strict=True):
        if not np.isfinite([low, high]).all():
            raise SigmafmuError(f"'{name}' needs finite bounds: actions={{'{name}': (low, high)}}")
    return found


def read_also(fmu: Fmu, names: Iterable[str]) -> tuple[str, ...]:
    """Scalars that only reward and end of an episode see."""
    return tuple(v.name for v in select(fmu, (names,) if isinstance(names, str) else names))


def _channels(wanted: Names, variables_of: Any) -> Channels:
    if isinstance(wanted, str):
        wanted = [wanted]
    pairs = wanted.items() if isinstance(wanted, Mapping) else ((name, None) for name in wanted)
    rows: dict[str, tuple[int, float, float]] = {}
    for name, bounds in pairs:
        variables = variables_of(name)
        for variable, low, high in zip(variables, *_bounds(name, variables, bounds), strict=True):
            if variable.name in rows:
                raise SigmafmuError(f"'{variable.name}' is named twice")
            rows[variable.name] = (variable.valueReference, low, high)
    references, low, high = zip(*rows.values(), strict=True) if rows else ((), (), ())
    return Channels(tuple(rows), references, np.array(low, dtype=float), np.array(high, dtype=float))


def _bounds(name: str, variables: Sequence[ModelVariable], bounds: Bounds) -> tuple[np.ndarray, np.ndarray]:
    if bounds is None:
        told = [Variable.of(v) for v in variables]
        low = np.array([-np.inf if v.minimum is None else v.minimum for v in told])
        high = np.array([np.inf if v.maximum is None else v.maximum for v in told])
        return low, high
    try:
        low, high = (np.broadcast_to(np.asarray(bound, dtype=float), len(variables)) for bound in bounds)
    except (TypeError, ValueError):
        raise SigmafmuError(
            f"the bounds of '{name}' must be a pair (low, high) of numbers, or of {len(variables)} numbers each, "
            f"not {bounds!r}"
        ) from None
    if not (low < high).all():
        raise SigmafmuError(f"the lower bound of '{name}' must be below the upper one, not {bounds!r}")
    return low, high
