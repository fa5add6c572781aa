"""Choosing variables of a model by name and turning a user's text into their values."""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, takewhile

import numpy as np
from fmpy.model_description import ModelVariable

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu

Value = float | int
SettingValue = str | Value | Sequence[Value] | np.ndarray
"""A number, the name of an item of an enumeration, or a vector: a sequence, or text with commas."""

_ELEMENT = re.compile(r"^(?P<base>.+)\[(?P<index>\d+)\]$")
_SETTABLE = {"parameter", "input"}


@dataclass(frozen=True)
class Variable:
    """A scalar variable of a model, as its modelDescription.xml tells."""

    name: str
    type: str
    """`Real`, `Integer`, `Boolean` or `Enumeration`."""
    causality: str
    """`parameter`, `input`, `output` or `local`."""
    variability: str
    """`fixed` parameters can be set before the start only, `tunable` ones at any time."""
    unit: str
    """SI unit as FMI writes it, such as `N.m`; `1` or empty if there is none."""
    description: str
    start: float | None
    """Start value in its unit, the item's number for an enumeration; None if the model computes it."""
    minimum: float | None
    maximum: float | None
    items: tuple[str, ...] = ()
    """Names of an enumeration's items; their numbers are 1, 2, …"""

    @classmethod
    def of(cls, variable: ModelVariable) -> "Variable":
        """What FMPy has read."""
        items = variable.declaredType.items if variable.type == "Enumeration" else ()
        start, low, high = (
            None if text is None else float({"true": 1, "false": 0}.get(text, text))
            for text in (variable.start, variable.min, variable.max)
        )
        return cls(
            variable.name,
            variable.type,
            variable.causality,
            variable.variability or "",
            variable.unit or "",
            variable.description or "",
            start,
            low,
            high,
            tuple(item.name for item in items),
        )


def split_element(name: str) -> tuple[str, int] | None:
    """`top.position[2]` → (`top.position`, 2); None for a scalar."""
    match = _ELEMENT.match(name)
    return (match["base"], int(match["index"])) if match else None


def vectors(names: Iterable[str]) -> dict[str, list[str]]:
    """Names of scalars under the names of their vectors; a scalar that is no element is under its own."""
    found: dict[str, list[str]] = {}
    for name in names:
        element = split_element(name)
        found.setdefault(element[0] if element else name, []).append(name)
    return found


def pattern(text: str) -> re.Pattern[str]:
    """Matches a scalar, the elements of a vector, or what a pattern with `*` and `?` means."""
    # not fnmatch: there, the [1] of an element would be a set of characters
    return re.compile(re.escape(text).replace(r"\*", ".*").replace(r"\?", ".") + r"(\[\d+\])?")


def vector_elements(fmu: Fmu, base: str) -> list[str]:
    """Names of the elements `base[1]`, `base[2]`, … that the model has, in order."""
    numbered = (f"{base}[{i}]" for i in count(1))
    return list(takewhile(fmu.variables.__contains__, numbered))


def choose_one(fmu: Fmu, name: str) -> list[ModelVariable]:
    """The scalar `name`, or the elements of the vector `name`; raises SigmafmuError if there is neither."""
    names = [name] if name in fmu.variables else vector_elements(fmu, name)
    if not names:
        raise _unknown(fmu, name)
    return [fmu.variables[n] for n in names]


def outputs(fmu: Fmu) -> list[ModelVariable]:
    """All that a run computes, in the order of the model description: outputs, and the counters, which are local."""
    return [v for v in fmu.description.modelVariables if v.causality in {"output", "local"}]


def select(fmu: Fmu, patterns: Iterable[str]) -> list[ModelVariable]:
    """Variables named by `patterns`: a scalar, a whole vector, or outputs that match a pattern with `*` and `?`.

    Each pattern must name at least one.
    """
    chosen: dict[str, ModelVariable] = {}
    for text in patterns:
        if text in fmu.variables:  # a scalar: nothing to search for
            chosen[text] = fmu.variables[text]
            continue
        candidates = outputs(fmu) if re.search(r"[*?]", text) else fmu.description.modelVariables
        matches = {v.name: v for v in candidates if pattern(text).fullmatch(v.name)}
        if not matches:
            raise _unknown(fmu, text)
        chosen |= matches
    return list(chosen.values())


def recorded_variables(fmu: Fmu, variables: Iterable[str]) -> list[ModelVariable]:
    """What a run records: `variables` (names or patterns), or all outputs if there are none."""
    variables = (variables,) if isinstance(variables, str) else tuple(variables)
    return select(fmu, variables) if variables else outputs(fmu)


def parse_settings(fmu: Fmu, settings: Mapping[str, SettingValue]) -> list[tuple[ModelVariable, Value]]:
    """Variables and their values for `settings`; a vector may be set as a whole, `{"gravity": "0,0,-1.62"}`."""
    return [pair for name, value in settings.items() for pair in _parse_setting(fmu, name, value)]


def _parse_setting(fmu: Fmu, name: str, value: SettingValue) -> list[tuple[ModelVariable, Value]]:
    if name in fmu.variables:
        variable = fmu.variables[name]
        if variable.causality not in _SETTABLE:
            raise SigmafmuError(f"'{name}' is of causality {variable.causality}; only parameters and inputs can be set")
        return [(variable, _parse_value(variable, value))]

    elements = vector_elements(fmu, name)
    if not elements:
        raise _unknown(fmu, name)
    if isinstance(value, str):
        values: list[SettingValue] = list(value.split(","))
    else:
        values = list(np.atleast_1d(value))
    if len(values) != len(elements):
        raise SigmafmuError(f"'{name}' has {len(elements)} elements, but {len(values)} given; example: {name}=0,0,0")
    return [pair for element, v in zip(elements, values, strict=True) for pair in _parse_setting(fmu, element, v)]


def _parse_value(variable: ModelVariable, value: SettingValue) -> Value:
    if variable.type == "Real" and isinstance(value, float):
        return float(value)
    text = str(value).strip()
    if variable.type == "Enumeration":
        items = variable.declaredType.items
        for item in items:
            if text in (item.name, item.value):
                return int(item.value)
        raise SigmafmuError(f"'{variable.name}' cannot be '{text}'; choose one of {', '.join(i.name for i in items)}")
    if variable.type == "Boolean" and text.lower() in {"true", "false"}:
        return int(text.lower() == "true")
    number, kind = (float, "a number") if variable.type == "Real" else (int, "an integer")
    try:
        return number(text)
    except ValueError:
        raise SigmafmuError(f"'{variable.name}' needs {kind}, not '{text}'") from None


def _unknown(fmu: Fmu, name: str) -> SigmafmuError:
    close = difflib.get_close_matches(name, sorted(vectors(fmu.variables)), n=3)
    hint = f"did you mean {' or '.join(close)}?" if close else f"`sigmafmu info {fmu.name}` lists its variables"
    return SigmafmuError(f"{fmu.name} has no variable '{name}'; {hint}")
