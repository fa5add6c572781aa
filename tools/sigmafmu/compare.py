"""Difference between a simulation and a reference solution, at the times that both have."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.result import Result
from sigmafmu.variables import split_element

REFERENCES = Path(__file__).parent / "references"
"""The reference files that the package was installed with."""

History = dict[str, np.ndarray]
"""Column name → samples; `history["time"]` holds the sample times in s."""


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


def read_reference(path: str | Path) -> tuple[dict[str, str], History]:
    """Read a reference file: (header, history).

    The header holds the `# key: value` lines at the top of the file, the history one array per column.
    """
    header: dict[str, str] = {}
    with Path(path).open(encoding="utf-8") as lines:
        for line in lines:
            if not line.startswith("#"):
                names = line.strip().split(",")
                break
            key, _, value = line[1:].partition(":")
            header[key.strip()] = value.strip()
        else:
            raise ValueError(f"{path}: no table after the header")
        table = np.loadtxt(lines, delimiter=",", ndmin=2)
    if table.shape[1] != len(names):
        raise ValueError(f"{path}: {len(names)} column names for {table.shape[1]} columns")
    return header, dict(zip(names, table.T, strict=True))


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
