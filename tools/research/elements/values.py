"""A value for every key of mechanism files, by its name or by what it may be."""

from __future__ import annotations

from typing import Any

from sigmafmu.mechanism_file.kinds import Flag, Kind, Number, Reference, Whole, Word, WordOr
from sigmafmu.mechanism_file.structures import Direction, Key, List, Points

Json = dict[str, Any]
GEOMETRY: Json = {
    "point": [0, 0, 0],
    "point1": [0, 0, 0],
    "point2": [0.3, 0, 0.1],
    "points2": [[0.2, -0.1, 0.1], [0.2, 0.1, 0.1], [0.4, -0.1, 0.1], [0.4, 0.1, 0.1]],
    "axis": [0, 0, 1],
    "normal": [0, 0, 1],
    "axis1": [0, 1, 0],
    "axis2": [1, 0, 0],
}
NUMBERS: Json = {
    "radius": 0.15,
    "radius1": 0.15,
    "radius2": 0.2,
    "stiffness": 100.0,
    "free_length": 0.2,
    "modulus": 1e4,
    "pitch": 0.05,
    "ratio": -2.0,
    "limits": [-0.5, 0.5],
    "length": 0.3,
    "friction": 1.0,
    "stribeck_friction": 0.5,
    "stribeck_rate": 0.4,
    "viscous_friction": 0.1,
    "creep_rate": 0.05,
    "stop_stiffness": 1e4,
    "stop_damping": 0.5,
    "stop_depth": 0.01,
}
TABLES: Json = {"length": [0.1, 0.3, 0.6], "force": [-5.0, 0.0, 20.0], "rate": [-1.0, 1.0], "rate_force": [-2.0, 2.0]}
LEFT_OUT = ("description", "stiffness_coupling", "damping_coupling", "node", "offset", "input", "coordinate")
"""Keys that examples do not have, where they may be left out."""


def value(key: Key, names: tuple[str, ...]) -> Any:
    """Something that a key may have; None: it is left out. References are to these names."""
    if key.name in GEOMETRY:
        return GEOMETRY[key.name]
    if key.name in LEFT_OUT and not key.required:
        return None
    if isinstance(key.kind, List) and isinstance(key.kind.of, Number) and key.kind.count is None and key.name in TABLES:
        return TABLES[key.name]
    if key.name in NUMBERS and isinstance(NUMBERS[key.name], list) == (isinstance(key.kind, List)):
        return NUMBERS[key.name]
    if not key.required and not _is_numeric(key.kind):
        return None
    return _value(key.kind, names, NUMBERS.get(key.name, 1.0))


def _is_numeric(kind: Kind) -> bool:
    if isinstance(kind, List | Points):
        return _is_numeric(kind.of if isinstance(kind, List) else kind.y)
    return isinstance(kind, Number | Flag)


def _value(kind: Kind, names: tuple[str, ...], number: Any) -> Any:
    if isinstance(kind, List):
        count = kind.count or (len(names) if isinstance(kind.of, Reference) else max(kind.least, 2))
        if isinstance(kind.of, Reference):
            return list(names[:count])
        return [_value(kind.of, names, number) for _ in range(count)]
    if isinstance(kind, Points):
        return [[0, 0], [1, 0.1]]
    if isinstance(kind, Reference):
        return names[-1]
    if isinstance(kind, Word):
        return kind.words[0]
    if isinstance(kind, WordOr):
        return kind.word
    if isinstance(kind, Flag):
        return True
    if isinstance(kind, Whole):
        return kind.least
    if isinstance(kind, Direction):
        return [0, 0, 1]
    return number
