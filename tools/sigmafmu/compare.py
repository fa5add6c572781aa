"""Difference between a simulation and a reference solution, at the times that both have."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.reference import History, read_reference
from sigmafmu.result import Result
from sigmafmu.variables import split_element

REFERENCES = Path(__file__).parent / "references"
"""The reference files that the package was installed with."""


@dataclass(frozen=True)
class Reference:
    """A reference solution: what its header says, and its samples by column name."""

    header: dict[str, str]
    history: History

    @property
    def stated_position_error(self) -> str:
        """The error of its positions that the reference states itself, with unit."""
        return self.header["stated error, position"]


def find_reference(model: str) -> Reference | None:
    """The installed reference solution of `model` with its default parameters, if there is one."""
    path = REFERENCES / f"{model}.csv"
    return Reference(*read_reference(path)) if path.is_file() else None


def distance(result: Result, history: History, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Common times and, at each, the Euclidean distance of the vector (or scalar) `name` from `history`."""
    ours, theirs = _common_rows(result.time, history["time"])
    columns = [n for n in history if n == name or ((element := split_element(n)) and element[0] == name)]
    if not columns or not len(ours):
        raise SigmafmuError(f"the reference and the run of {result.model} have no sample of '{name}' in common")
    difference = np.column_stack([result[n][ours] - history[n][theirs] for n in columns])
    return result.time[ours], np.linalg.norm(difference, axis=1)


def _common_rows(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices into the sorted times `a` and `b` of the instants that both contain, up to rounding."""
    nearest = np.clip(np.searchsorted(a, b - 1e-9), 0, len(a) - 1)
    rows = np.flatnonzero(np.abs(a[nearest] - b) <= 1e-9 * np.maximum(1.0, np.abs(b)))
    return nearest[rows], rows
