"""YAML text as a tree of nodes that know their lines.

It is built from the parser's events: what a file refers to twice stays one node, nothing is constructed but texts,
numbers, lists and mappings, and limits hold before anything large exists. Plain scalars mean what the core schema of
YAML 1.2 says, of which JSON is a part: `1e-3` is a number, `no` and `on` are texts.
"""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from sigmafmu.mechanism_file.problems import MechanismFileError, Problem, shown

LARGEST_FILE = 10_000_000
"""Bytes; a thousand bodies with their joints take less than half a million."""
MOST_NODES = 500_000
"""With every alias counted as what it stands for."""
DEEPEST = 24

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # 25 times as fast, where PyYAML has it
_NUMBER = re.compile(r"[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?")
_PAIR = re.compile(r"(?<!\\)((?:\\\\)*)(\\u[dD][89abAB]\w\w\\u[dD][c-fC-F]\w\w)", re.ASCII)
"""How JSON escapes characters beyond 16 bits, which YAML does not know."""
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}
_WORDS |= {".nan": float("nan"), ".inf": float("inf"), "+.inf": float("inf"), "-.inf": float("-inf")}


@dataclass(slots=True)
class Node:
    """A value of the file: text, number, truth value, None, a list of nodes or a mapping of texts to nodes."""

    value: Any
    line: int
    key_lines: dict[str, int] = field(default_factory=dict)
    """Of a mapping."""
    size: int = 1
    """How many nodes it stands for."""

    @property
    def kind(self) -> str:
        """What it is, in messages."""
        kinds = {dict: "a mapping", list: "a list", str: "a text", bool: "a truth value", type(None): "nothing"}
        return kinds.get(type(self.value), "a number")


def read_text(path: Path) -> str:
    """The text of a file of acceptable size; raises MechanismFileError."""
    try:
        if path.exists() and not path.is_file():
            raise _error(path, 1, "is no file; give the path of a mechanism file")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise _error(path, 1, f"cannot be read: {error.strerror}") from error
    if len(content) > LARGEST_FILE:
        raise _error(path, 1, f"is larger than {LARGEST_FILE // 1_000_000} MB; a mechanism file must not be")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise _error(path, line, f"byte 0x{content[error.start]:02x} is no UTF-8; save the file as UTF-8") from error


def parse(text: str, path: Path | str) -> Node:
    """The tree of a text; raises MechanismFileError for the first thing that is no YAML or beyond the limits."""
    builder = _Builder(path)
    text = _PAIR.sub(lambda found: found[1] + json.loads(f'"{found[2]}"'), text)
    try:
        for event in yaml.parse(text, Loader=_LOADER):
            builder.take(event)
    except yaml.YAMLError as error:
        raise _of_yaml(path, text, error) from error
    except RecursionError as error:  # of PyYAML without its C library
        raise _too_deep(path, 1) from error
    return builder.root or Node({}, 1)


def _error(path: Path | str, line: int, text: str) -> MechanismFileError:
    return MechanismFileError(path, [Problem(line, "", text)])


def _too_deep(path: Path | str, line: int) -> MechanismFileError:
    return _error(path, line, f"lists and mappings are nested deeper than {DEEPEST}; that is the most")


def _of_yaml(path: Path | str, text: str, error: yaml.YAMLError) -> MechanismFileError:
    mark = getattr(error, "problem_mark", None)
    position = getattr(error, "position", None)
    line = mark.line + 1 if mark else text[: position or 0].count("\n") + 1
    problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "it cannot be parsed"
    if "nesting depth" in str(problem):
        return _too_deep(path, line)
    return _error(path, line, f"is no YAML: {problem}")


def _scalar(event: yaml.ScalarEvent) -> Any:
    text = event.value
    if event.style:  # quoted
        return text
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    if not _NUMBER.fullmatch(text):
        return text
    return int(text) if text.lstrip("+-").isdigit() and len(text) < 16 else float(text)


@dataclass(slots=True)
class _Open:
    """A list or mapping whose end has not come."""

    node: Node
    anchor: str | None
    key: str | None = None
    """That awaits its value."""

    @property
    def awaits_key(self) -> bool:
        return isinstance(self.node.value, dict) and self.key is None


class _Builder:
    """Takes events one by one; what is open is on a stack, so that nesting is no recursion."""

    def __init__(self, path: Path | str):
        self.path = path
        self.root: Node | None = None
        self._stack: list[_Open] = []
        self._anchors: dict[str, Node | None] = {}  # None: still open

    def take(self, event: yaml.Event) -> None:
        line = event.start_mark.line + 1
        if isinstance(event, yaml.DocumentStartEvent) and self.root is not None:
            raise _error(self.path, line, "a second document begins; a file has one")
        if isinstance(event, yaml.AliasEvent):
            self._put(self._named(event.anchor, line), line)
        elif isinstance(event, yaml.NodeEvent):
            self._begin(event, line)
        elif isinstance(event, yaml.CollectionEndEvent):
            ended = self._stack.pop()
            self._complete(ended.node, ended.anchor, ended.node.line)

    def _named(self, anchor: str, line: int) -> Node:
        node = self._anchors.get(anchor)
        if node is None:
            reason = "refers to itself" if anchor in self._anchors else "has no anchor before it"
            raise _error(self.path, line, f"*{anchor} {reason}; an alias must come after its anchor's value")
        return node

    def _begin(self, event: yaml.NodeEvent, line: int) -> None:
        if event.tag not in (None, "!"):
            raise _error(self.path, line, f"the tag {shown(event.tag)} is not allowed; mechanism files have no tags")
        if event.anchor is not None:
            self._anchors[event.anchor] = None
        if isinstance(event, yaml.ScalarEvent):
            is_key = bool(self._stack) and self._stack[-1].awaits_key
            self._complete(Node(event.value if is_key else _scalar(event), line), event.anchor, line)
            return
        if len(self._stack) >= DEEPEST:
            raise _too_deep(self.path, line)
        empty: dict | list = {} if isinstance(event, yaml.MappingStartEvent) else []
        self._stack.append(_Open(Node(empty, line), event.anchor))

    def _complete(self, node: Node, anchor: str | None, line: int) -> None:
        if anchor is not None:
            self._anchors[anchor] = node
        self._put(node, line)

    def _put(self, node: Node, line: int) -> None:
        """A complete node into the one around it, where it is a key or a value."""
        if not self._stack:
            self.root = node
            return
        around = self._stack[-1]
        parent = around.node
        if around.awaits_key:
            key = node.value
            if not isinstance(key, str):
                raise _error(self.path, line, f"{node.kind} is a key; keys must be texts")
            if key in parent.value:
                first = parent.key_lines[key]
                raise _error(
                    self.path, line, f"the key {shown(key)} is there twice, first in line {first}; one is allowed"
                )
            around.key = key
            parent.key_lines[key] = line
            return
        if isinstance(parent.value, list):
            parent.value.append(node)
        else:
            parent.value[around.key] = node
            around.key = None
        parent.size += node.size
        if parent.size > MOST_NODES:
            raise _error(
                self.path, line, f"aliases stand for more than {MOST_NODES} values in all; that is the most of a file"
            )
