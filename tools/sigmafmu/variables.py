"""Choosing variables of a model by name and turning a user's text into their values."""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence

from fmpy.model_description import ModelVariable

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu

Value = float | int
SettingValue = str | Value | Sequence[Value]

_ELEMENT = re.compile(r"^(?P<base>.+)\[(?P<index>\d+)\]$")
_SETTABLE = {"parameter", "input"}


def split_element(name: str) -> tuple[str, int] | None:
    """`top.position[2]` → (`top.position`, 2); None for a scalar."""
    match = _ELEMENT.match(name)
    return (match["base"], int(match["index"])) if match else None


def vector_elements(fmu: Fmu, base: str) -> list[str]:
    """Names of the elements `base[1]`, `base[2]`, … that the model has, in order."""
    elements = [name for name in fmu.variables if (element := split_element(name)) and element[0] == base]
    return sorted(elements, key=lambda name: split_element(name)[1])


def outputs(fmu: Fmu) -> list[ModelVariable]:
    """All that a run computes, in the order of the model description: outputs, and the counters, which are local."""
    return [v for v in fmu.description.modelVariables if v.causality in {"output", "local"}]


def select(fmu: Fmu, patterns: Iterable[str]) -> list[ModelVariable]:
    """Variables named by `patterns`: a scalar, a whole vector, or outputs that match a pattern with `*` and `?`.

    Each pattern must name at least one.
    """
    chosen: dict[str, ModelVariable] = {}
    for pattern in patterns:
        candidates = outputs(fmu) if re.search(r"[*?]", pattern) else fmu.description.modelVariables
        # not fnmatch: there, the [1] of an element would be a set of characters
        regex = re.compile(re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".") + r"(\[\d+\])?")
        matches = {v.name: v for v in candidates if regex.fullmatch(v.name)}
        if not matches:
            raise _unknown(fmu, pattern)
        chosen |= matches
    return list(chosen.values())


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
    values = value.split(",") if isinstance(value, str) else list(value) if isinstance(value, Sequence) else [value]
    if len(values) != len(elements):
        raise SigmafmuError(f"'{name}' has {len(elements)} elements, but {len(values)} given; example: {name}=0,0,0")
    return [pair for element, v in zip(elements, values, strict=True) for pair in _parse_setting(fmu, element, v)]


def _parse_value(variable: ModelVariable, value: SettingValue) -> Value:
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
    names = {element[0] if (element := split_element(n)) else n for n in fmu.variables}
    close = difflib.get_close_matches(name, sorted(names), n=3)
    hint = f"did you mean {' or '.join(close)}?" if close else f"`sigmafmu info {fmu.name}` lists its variables"
    return SigmafmuError(f"{fmu.name} has no variable '{name}'; {hint}")
