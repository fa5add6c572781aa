"""Which runs a study has: parameters that are crossed, zipped or sampled, as one column for each scalar."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.sweeps.sampling import Distribution, sample
from sigmafmu.variables import SettingValue, choose_one, parse_settings

Varied = SettingValue | Iterable[Any] | Distribution
"""A constant, a sequence of values (for a vector: of vectors), or a distribution of SciPy."""

_Block = dict[str, np.ndarray]
"""Columns of parameters that change together, by the names of scalars."""


@dataclass(frozen=True)
class Plan:
    """The parameters of all runs, checked against the model's names and types."""

    runs: int
    columns: dict[str, np.ndarray]
    """By the name of a varied scalar: (runs,) of numbers, or of names of an enumeration's items."""
    constants: dict[str, Any]
    """By the name of a scalar: what all runs share."""

    def settings(self, run: int) -> dict[str, Any]:
        """What a run sets."""
        return self.constants | {name: column[run].item() for name, column in self.columns.items()}


def plan(
    fmu: Fmu,
    parameters: Mapping[str | tuple[str, ...], Varied],
    runs: int | None = None,
    sampling: str = "random",
    seed: int = 0,
) -> Plan:
    """The runs of `parameters`: every combination of those that vary, the first of them slowest, samples fastest.

    A tuple of names varies its parameters together; its value has a row (tuple) for each run. `runs` samples are drawn
    of the distributions, by `sampling` (`random`, `latin` or `sobol`) from `seed`. Raises SigmafmuError.
    """
    constants: dict[str, Any] = {}
    blocks: list[_Block] = []
    drawn: dict[str, Distribution] = {}
    for key, value in parameters.items():
        if isinstance(key, tuple):
            blocks.append(_zipped(fmu, key, value))
        elif hasattr(value, "ppf"):
            drawn |= {one_real(fmu, key): value}  # type: ignore[dict-item]
        elif _varies(fmu, key, value):
            blocks.append(_column(fmu, key, list(value)))  # type: ignore[arg-type]
        else:
            constants |= _scalars(fmu, key, value)
    if drawn:
        if runs is None:
            raise SigmafmuError(
                f"{', '.join(drawn)} {'is' if len(drawn) == 1 else 'are'} sampled: give the number of runs"
            )
        blocks.append(sample(drawn, runs, sampling, seed))
    elif runs is not None:
        raise SigmafmuError(f"{runs} runs are wanted, but no parameter has a distribution to draw from")
    return _crossed(blocks, constants)


def _crossed(blocks: Sequence[_Block], constants: dict[str, Any]) -> Plan:
    names = [*constants, *(name for block in blocks for name in block)]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise SigmafmuError(f"'{twice[0]}' is set twice")
    sizes = [len(next(iter(block.values()))) for block in blocks]
    total = int(np.prod(sizes, dtype=np.int64)) if sizes else 1
    columns: dict[str, np.ndarray] = {}
    repeats = total
    for block, size in zip(blocks, sizes, strict=True):
        repeats //= size
        rows = np.arange(total) // repeats % size
        columns |= {name: values[rows] for name, values in block.items()}
    return Plan(total, columns, constants)


def _varies(fmu: Fmu, name: str, value: object) -> bool:
    """Whether it is a sequence of values; one sequence of numbers is a value of a vector."""
    if isinstance(value, str | int | float | np.number) or np.ndim(value) == 0:  # type: ignore[arg-type]
        return False
    if name in fmu.variables:
        return True
    return not all(isinstance(element, int | float | np.number) for element in value)  # type: ignore[attr-defined]


def _column(fmu: Fmu, name: str, values: list[Any]) -> _Block:
    if not values:
        raise SigmafmuError(f"'{name}' has no values")
    rows = [_scalars(fmu, name, value) for value in values]
    return {scalar: np.array([row[scalar] for row in rows]) for scalar in rows[0]}


def _zipped(fmu: Fmu, names: tuple[str, ...], rows: Any) -> _Block:
    rows = list(rows)
    if wrong := next((row for row in rows if np.ndim(row) == 0 or len(row) != len(names)), None):
        raise SigmafmuError(f"{', '.join(names)} vary together: each run needs {len(names)} values, not {wrong}")
    block: _Block = {}
    for i, name in enumerate(names):
        block |= _column(fmu, name, [row[i] for row in rows])
    return block


def _scalars(fmu: Fmu, name: str, value: Any) -> dict[str, Any]:
    """Scalars and their values; items of enumerations by name."""
    found: dict[str, Any] = {}
    for variable, number in parse_settings(fmu, {name: value}):
        if variable.type == "Enumeration":
            found[variable.name] = next(i.name for i in variable.declaredType.items if int(i.value) == number)
        else:
            found[variable.name] = number
    return found


def one_real(fmu: Fmu, name: str) -> str:
    """The name of a real scalar that can be set, of which samples can be drawn; SigmafmuError for others."""
    variables = choose_one(fmu, name)
    if len(variables) > 1 or variables[0].type != "Real":
        raise SigmafmuError(
            f"only real scalars are sampled; '{name}' is of type {variables[0].type}, size {len(variables)}"
        )
    parse_settings(fmu, {name: 0.0})  # it can be set
    return name
