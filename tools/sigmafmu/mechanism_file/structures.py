"""What lists and mappings of a mechanism file may be."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sigmafmu.mechanism_file.csv_points import CsvError, read_points
from sigmafmu.mechanism_file.kinds import INVALID, Context, Kind, Number, Word, nearest
from sigmafmu.mechanism_file.problems import shown
from sigmafmu.mechanism_file.tree import Node


@dataclass(frozen=True)
class List:
    """A list of `count` values of a kind, or of any number of at least `least`."""

    of: Kind
    count: int | None = None
    least: int = 0

    @property
    def text(self) -> str:
        """What it is."""
        return f"list of {'' if self.count is None else f'{self.count} × '}{self.of.text}"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """A list of the values."""
        wanted = f"a list of {self.count}" if self.count is not None else f"a list of at least {self.least}"
        if not isinstance(node.value, list):
            return context.refuse(node.line, where, f"is {node.kind}; it must be {wanted}")
        size = len(node.value)
        if size < self.least or (self.count is not None and size != self.count):
            return context.refuse(node.line, where, f"has {size} entries; it must be {wanted}")
        values = [self.of.read(item, f"{where}[{i + 1}]", context) for i, item in enumerate(node.value)]
        return INVALID if any(value is INVALID for value in values) else values

    def schema(self) -> dict[str, Any]:
        """An array."""
        size = {"minItems": self.least if self.count is None else self.count}
        return {"type": "array", "items": self.of.schema(), **size, **({"maxItems": self.count} if self.count else {})}


@dataclass(frozen=True)
class Points:
    """At least two points [x, y] of a table, x ascending: in the file, or in a CSV file beside it, in SI units."""

    x: Kind
    y: Kind

    @property
    def text(self) -> str:
        """What it is."""
        return f"list of [{self.x.text}, {self.y.text}], or a CSV file"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The list of x and that of y."""
        if isinstance(node.value, str):
            return self._read_file(node, where, context)
        if not isinstance(node.value, list) or len(node.value) < 2:
            return context.refuse(node.line, where, f"must be a list of at least two points, each {self._point}")
        xs, ys = [], []
        for i, point in enumerate(node.value, 1):
            place = f"{where}[{i}]"
            if not isinstance(point.value, list) or len(point.value) != 2:
                context.refuse(point.line, place, f"is no point; it must be {self._point}")
                continue
            xs.append(self.x.read(point.value[0], f"{place}[1]", context))
            ys.append(self.y.read(point.value[1], f"{place}[2]", context))
            if len(xs) > 1 and INVALID not in xs[-2:] and not xs[-1] > xs[-2]:
                context.refuse(point.line, place, f"comes at {xs[-1]:g} after {xs[-2]:g}; points must ascend")
                xs[-1] = INVALID
        bad = len(xs) < len(node.value) or INVALID in xs or INVALID in ys
        return INVALID if bad else (xs, ys)

    def _read_file(self, node: Node, where: str, context: Context) -> Any:
        try:
            points = read_points(Path(context.problems.path).parent / node.value)
        except CsvError as error:
            return context.refuse(node.line, where, f"{shown(node.value)} {error}")
        if len(points) < 2:
            return context.refuse(node.line, where, f"{shown(node.value)} has {len(points)} points; it must have two")
        xs, ys = [], []
        for line, x, y in points:
            place = f"{where}, line {line} of {node.value}"
            xs.append(self.x.read(Node(x, node.line), f"{place}[1]", context))
            ys.append(self.y.read(Node(y, node.line), f"{place}[2]", context))
            if INVALID in (xs[-1], ys[-1]):
                return INVALID
            if len(xs) > 1 and not xs[-1] > xs[-2]:
                return context.refuse(node.line, place, f"comes at {x:g} after {xs[-2]:g}; points must ascend")
        return xs, ys

    @property
    def _point(self) -> str:
        return f"[{self.x.text}, {self.y.text}]"

    def schema(self) -> dict[str, Any]:
        """An array of pairs."""
        pair = {"type": "array", "prefixItems": [self.x.schema(), self.y.schema()], "minItems": 2, "maxItems": 2}
        return {"anyOf": [{"type": "string"}, {"type": "array", "minItems": 2, "items": pair}]}


def vector(dimension: str = "number") -> List:
    """Three numbers of a dimension."""
    return List(Number(dimension), 3)


@dataclass(frozen=True)
class Direction:
    """Three numbers that are not all zero; their length does not matter."""

    @property
    def text(self) -> str:
        """What it is."""
        return "direction: list of 3 × number"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The three numbers, of length 1."""
        values = vector().read(node, where, context)
        if values is INVALID:
            return INVALID
        largest = max(map(abs, values))
        if largest == 0:
            return context.refuse(node.line, where, "is (0, 0, 0); an axis must have a length above 0")
        scaled = [value / largest for value in values]
        length = math.hypot(*scaled)
        return [value / length for value in scaled]

    def schema(self) -> dict[str, Any]:
        """As a vector, not of zeros."""
        return {**vector().schema(), "contains": {"not": {"const": 0}}}


@dataclass(frozen=True)
class Key:
    """A key of a mapping: its name, what its value may be, what it means, and what holds without it."""

    name: str
    kind: Kind
    meaning: str
    required: bool = False
    default: str = ""


class Record(dict):
    """The values of a mapping by their keys, and the lines they are in."""

    def __init__(self, node: Node, where: str):
        super().__init__()
        self.where, self.line = where, node.line
        self.lines: dict[str, int] = {key: child.line for key, child in node.value.items()}

    def line_of(self, key: str) -> int:
        """The line of a value, or that of the mapping without it."""
        return self.lines.get(key, self.line)


Check = Callable[[Record, Context], None]


@dataclass(frozen=True)
class Struct:
    """A mapping with these keys; `check` complains of what they do not allow together."""

    keys: tuple[Key, ...]
    check: Check | None = None
    name: str = "mapping"
    """What it is, for tables."""
    one_of: tuple[str, ...] = ()
    """Exactly one of these keys must be there."""
    shared: bool = False
    """Whether the schema has it once and refers to it."""

    @property
    def text(self) -> str:
        """What it is."""
        return self.name

    def read(self, node: Node, where: str, context: Context) -> Any:
        """A Record of the keys that are there."""
        if not isinstance(node.value, dict):
            keys = ", ".join(key.name for key in self.keys)
            return context.refuse(node.line, where, f"is {node.kind}; it must be a mapping with the keys {keys}")
        before, record = len(context.problems.found), Record(node, where)
        known = {key.name: key for key in self.keys}
        for name, child in node.value.items():
            if name not in known:
                line = node.key_lines[name]
                context.refuse(line, _joined(where, name), f"this key is unknown; {nearest(name, known)}")
                continue
            value = known[name].kind.read(child, _joined(where, name), context)
            if value is not INVALID:
                record[name] = value
        for key in self.keys:
            if key.required and key.name not in node.value:
                context.refuse(node.line, where, f"{key.name} is missing; it must be there: {key.meaning}")
        present = [name for name in self.one_of if name in node.value]
        if self.one_of and len(present) != 1:
            has = " and ".join(present) if present else "none of them"
            context.refuse(node.line, where, f"has {has}; it must have one of {', '.join(self.one_of)}")
        if len(context.problems.found) == before and self.check:
            self.check(record, context)
        return record if len(context.problems.found) == before else INVALID

    def schema(self) -> dict[str, Any]:
        """An object, or where it is."""
        return {"$ref": f"#/$defs/{self.name}"} if self.shared else self.object_schema()

    def object_schema(self) -> dict[str, Any]:
        """An object."""
        required = [key.name for key in self.keys if key.required]
        properties = {key.name: {"description": key.meaning, **key.kind.schema()} for key in self.keys}
        result: dict[str, Any] = {"type": "object", "properties": properties, "additionalProperties": False}
        if required:
            result["required"] = required
        if self.one_of:
            result["oneOf"] = [{"required": [name]} for name in self.one_of]
        return result


def _joined(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key


@dataclass(frozen=True)
class ByType:
    """A mapping whose key `type` says which other keys it has."""

    types: Mapping[str, Struct]

    @property
    def text(self) -> str:
        """What it is."""
        return "mapping by its `type`"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The Record, which has `type`."""
        if not isinstance(node.value, dict):
            return context.refuse(node.line, where, f"is {node.kind}; it must be a mapping with a type")
        if "type" not in node.value:
            return context.refuse(node.line, where, f"type is missing; {nearest('', self.types)}")
        kind = Word(tuple(self.types)).read(node.value["type"], _joined(where, "type"), context)
        return INVALID if kind is INVALID else self.types[kind].read(node, where, context)

    def schema(self) -> dict[str, Any]:
        """One of the objects, chosen by `type`."""
        branches = [
            {"if": {"properties": {"type": {"const": name}}}, "then": struct.schema()}
            for name, struct in self.types.items()
        ]
        chosen = {"type": {"enum": list(self.types)}}
        return {"type": "object", "properties": chosen, "required": ["type"], "allOf": branches}


@dataclass(frozen=True)
class Named:
    """A mapping of names to values of a kind."""

    of: Kind
    name_kind: Kind

    @property
    def text(self) -> str:
        """What it is."""
        return f"name: {self.of.text}"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The values by their names, in the file's order."""
        if node.value is None:  # `joints:` with nothing below
            return {}
        if not isinstance(node.value, dict):
            return context.refuse(node.line, where, f"is {node.kind}; it must be a mapping of names")
        result = {}
        for name, child in node.value.items():
            valid = self.name_kind.read(Node(name, node.key_lines[name]), f"{where}.{name}"[:80], context)
            value = self.of.read(child, f"{where}.{name}"[:80], context)
            if valid is not INVALID and value is not INVALID:
                result[name] = value
        return result

    def schema(self) -> dict[str, Any]:
        """An object of any names."""
        return {
            "type": ["object", "null"],
            "propertyNames": self.name_kind.schema(),
            "additionalProperties": self.of.schema(),
        }


@dataclass(frozen=True)
class Either:
    """One kind for a mapping, another for all else."""

    plain: Kind
    mapping: Kind

    @property
    def text(self) -> str:
        """What it is."""
        return f"{self.plain.text}, or {self.mapping.text}"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The value of the one or the other."""
        return (self.mapping if isinstance(node.value, dict) else self.plain).read(node, where, context)

    def schema(self) -> dict[str, Any]:
        """Either schema."""
        return {"anyOf": [self.plain.schema(), self.mapping.schema()]}


@dataclass(frozen=True)
class Later:
    """A value whose dimension other parts of the file tell: it stays Pending until these are known."""

    what: str
    one_of: tuple[Kind, ...]

    @property
    def text(self) -> str:
        """What it is."""
        return self.what

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The node itself, with its place."""
        return Pending(node, where)

    def schema(self) -> dict[str, Any]:
        """Any of them."""
        return {"anyOf": [kind.schema() for kind in self.one_of]}


@dataclass(frozen=True)
class Pending:
    """A node that awaits its kind."""

    node: Node
    where: str

    def read(self, kind: Kind, context: Context) -> Any:
        """Its value."""
        return kind.read(self.node, self.where, context)
