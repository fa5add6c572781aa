"""What a chapter of the study is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

Results = Mapping[str, Mapping[str, dict[str, Any]]]
"""mechanism → key of the cell → what the cell's function returned."""


@dataclass(frozen=True)
class Cell:
    """One unit of work, done in a process of a pool; its result is kept on disk, so that a study can be resumed."""

    key: str
    """Unique within the chapter and mechanism, the same from run to run."""
    function: Callable[..., dict[str, Any]]
    """At module level; returns what JSON can hold: numbers (also NumPy's), lists, arrays, strings."""
    arguments: tuple
    alone: bool = False
    """Its result is a time: nothing else may run beside it."""


class Chapter(Protocol):
    """One question, its cells and the answer as text, tables and figures."""

    name: str
    """Stem of its files."""
    title: str
    mechanisms: tuple[str, ...]
    """Which of HeavyTop, HighSpeedRotor, SliderCrank it looks at."""

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """The work for one mechanism; `quick` asks for a small version of it."""

    def report(self, results: Results, folder: Path) -> str:
        """Write CSV and PNG into `folder`; returns the section in Markdown, its heading not included.

        `results` holds the mechanisms that were asked for. A run that fails is a result too, {"failed": "why"}.
        """
