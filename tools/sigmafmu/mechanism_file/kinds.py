"""What values of a mechanism file may be: each kind reads a node, tells its JSON Schema and what it is called."""

import difflib
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from sigmafmu.mechanism_file.problems import Problems, shown
from sigmafmu.mechanism_file.tree import Node
from sigmafmu.mechanism_file.units import UnitError, example, si_unit, to_si

INVALID: Any = None
"""In place of a value that was refused; None is no value of a file."""

LARGEST = 1e50
"""Size of a number in SI units: nothing that moves has larger ones, and products of these do not overflow."""


@dataclass
class Context:
    """What reading needs to know: where complaints go, and the names that the file gives to things of each sort."""

    problems: Problems
    names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def refuse(self, line: int, where: str, text: str) -> None:
        """Note a problem; the value is INVALID."""
        self.problems.add(line, where, text)


class Kind(Protocol):
    """A kind of value."""

    @property
    def text(self) -> str:
        """What it is, for tables."""

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The value, numbers in SI units; INVALID after a complaint."""

    def schema(self) -> dict[str, Any]:
        """Its JSON Schema."""


def nearest(word: str, known: Iterable[str]) -> str:
    """A hint at what was meant and what there is."""
    known = list(known)
    close = difflib.get_close_matches(word, known, 1, 0.6)
    hint = f"did you mean {close[0]}? " if close else ""
    return f"{hint}{_listed(known)}"


def _listed(words: list[str]) -> str:
    if not words:
        return "there is none"
    return f"allowed {'is' if len(words) == 1 else 'are'} {', '.join(words[:30])}{', ...' if len(words) > 30 else ''}"


@dataclass(frozen=True)
class Number:
    """A number of a dimension (units.DIMENSIONS), in SI units or as a text with its unit."""

    dimension: str = "number"
    least: float = -math.inf
    above: bool = False
    """Whether `least` itself is not allowed."""

    @property
    def text(self) -> str:
        """What it is."""
        return self.dimension if self.dimension == "number" else f"{self.dimension} [{si_unit(self.dimension)}]"

    @property
    def _expected(self) -> str:
        if self.dimension == "number":
            return "it must be a number"
        unit, text = si_unit(self.dimension), example(self.dimension)
        return f'it must be a number in {unit}, or a text with a unit such as "{text}"'

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The number in SI units."""
        value = node.value
        if isinstance(value, str) and self.dimension != "number":
            try:
                value = to_si(value, self.dimension)
            except UnitError as error:
                return context.refuse(node.line, where, f"{shown(value)} {error}; {self._expected}")
        if isinstance(value, bool) or not isinstance(value, int | float):
            what = shown(value) if isinstance(value, str) else node.kind
            return context.refuse(node.line, where, f"is {what}; {self._expected}")
        value = float(value)
        if not math.isfinite(value):
            return context.refuse(node.line, where, f"is {shown(value)}; it must be finite")
        if abs(value) > LARGEST:
            return context.refuse(node.line, where, f"is {value:g}; it must be at most {LARGEST:g} in size")
        if value < self.least or (self.above and value == self.least):
            allowed = f"{'above' if self.above else 'at least'} {self.least:g}"
            unit = si_unit(self.dimension)
            return context.refuse(node.line, where, f"is {value:g}{' ' + unit if unit else ''}; it must be {allowed}")
        return value

    def schema(self) -> dict[str, Any]:
        """That of its dimension (schema.py), with the limit, which applies to numbers and not to texts."""
        limit = {"exclusiveMinimum" if self.above else "minimum": self.least} if math.isfinite(self.least) else {}
        return {"$ref": f"#/$defs/{self.dimension.replace(' ', '_')}"} | limit


@dataclass(frozen=True)
class Whole:
    """A whole number of at least `least`."""

    least: int = 0

    @property
    def text(self) -> str:
        """What it is."""
        return "whole number"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The number."""
        value = node.value
        if isinstance(value, bool) or not isinstance(value, int) or value < self.least or value > 2**31 - 1:
            what = shown(value) if isinstance(value, int | float | str) else node.kind
            return context.refuse(node.line, where, f"is {what}; it must be a whole number of at least {self.least}")
        return value

    def schema(self) -> dict[str, Any]:
        """An integer."""
        return {"type": "integer", "minimum": self.least, "maximum": 2**31 - 1}


@dataclass(frozen=True)
class Text:
    """Any text, or one that matches a pattern which `allowed` tells in words."""

    pattern: str = ""
    allowed: str = ""

    @property
    def text(self) -> str:
        """What it is."""
        return "text"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The text; what YAML takes for a number or a truth value is refused, since its spelling is lost."""
        import re

        if not isinstance(node.value, str):
            return context.refuse(node.line, where, f"is {node.kind}; it must be a text, in quotes if need be")
        if self.pattern and not re.fullmatch(self.pattern, node.value):
            return context.refuse(node.line, where, f"is {shown(node.value)}; {self.allowed}")
        return node.value

    def schema(self) -> dict[str, Any]:
        """A string."""
        return {"type": "string"} | ({"pattern": f"^({self.pattern})$"} if self.pattern else {})


@dataclass(frozen=True)
class Version:
    """The number of this format."""

    number: int

    @property
    def text(self) -> str:
        """What it is."""
        return f"`{self.number}`"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The number."""
        if node.value == self.number and not isinstance(node.value, bool):
            return self.number
        what = shown(node.value) if isinstance(node.value, int | float | str) else node.kind
        return context.refuse(node.line, where, f"is {what}; this version reads {self.number}")

    def schema(self) -> dict[str, Any]:
        """A constant."""
        return {"const": self.number}


@dataclass(frozen=True)
class Word:
    """One of some words."""

    words: tuple[str, ...]

    @property
    def text(self) -> str:
        """What it is."""
        return " or ".join(f"`{word}`" for word in self.words)

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The word."""
        if node.value in self.words:
            return node.value
        what = shown(node.value) if isinstance(node.value, str) else node.kind
        return context.refuse(node.line, where, f"is {what}; {nearest(str(node.value), self.words)}")

    def schema(self) -> dict[str, Any]:
        """An enumeration."""
        return {"enum": list(self.words)}


@dataclass(frozen=True)
class Reference:
    """The name of something in the file: of a sort of names in the context."""

    sort: str

    @property
    def text(self) -> str:
        """What it is."""
        return f"name of a {self.sort}"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The name."""
        known = context.names.get(self.sort, ())
        if not isinstance(node.value, str):
            return context.refuse(node.line, where, f"is {node.kind}; it must be the {self.text}")
        if node.value not in known:
            return context.refuse(
                node.line, where, f"there is no {self.sort} {shown(node.value)}; {nearest(node.value, known)}"
            )
        return node.value

    def schema(self) -> dict[str, Any]:
        """A string; which names there are is beyond a schema."""
        return {"type": "string"}


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
