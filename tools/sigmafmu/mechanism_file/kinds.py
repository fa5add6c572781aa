"""What single values of a mechanism file may be.

Each kind reads a node, tells its JSON Schema and what it is called.
"""

import difflib
import math
import re
from collections.abc import Iterable, Mapping
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
class Flag:
    """True or false."""

    @property
    def text(self) -> str:
        """What it is."""
        return "`true` or `false`"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The truth value."""
        if isinstance(node.value, bool):
            return node.value
        return context.refuse(node.line, where, f"is {node.kind}; it must be true or false")

    def schema(self) -> dict[str, Any]:
        """A boolean."""
        return {"type": "boolean"}


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
class WordOr:
    """A word, or a value of a kind."""

    word: str
    kind: Kind

    @property
    def text(self) -> str:
        """What it is."""
        return f"{self.kind.text}, or `{self.word}`"

    def read(self, node: Node, where: str, context: Context) -> Any:
        """The word, or the value."""
        return self.word if node.value == self.word else self.kind.read(node, where, context)

    def schema(self) -> dict[str, Any]:
        """Either schema."""
        return {"anyOf": [{"const": self.word}, self.kind.schema()]}
