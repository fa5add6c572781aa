"""What a simulation gives back: recorded variables over time and the cost of getting them."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.variables import split_element


class NotRecordedError(KeyError):
    """A result was asked for a variable that the run did not record."""


@dataclass(frozen=True)
class Statistics:
    """Totals of a run. Counters are None for a model that does not have them."""

    simulated_time: float
    wall_time: float
    """Seconds spent in fmi2DoStep alone."""
    communication_steps: int
    steps: int | None = None
    newton_iterations: int | None = None
    jacobian_evaluations: int | None = None
    retries: int | None = None

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second of computing."""
        return self.simulated_time / self.wall_time if self.wall_time > 0 else float("nan")

    @property
    def newton_per_step(self) -> float:
        """Mean number of Newton iterations of an internal step."""
        return (
            self.newton_iterations / self.steps if self.steps and self.newton_iterations is not None else float("nan")
        )


@dataclass(frozen=True)
class Result:
    """Values of the recorded variables at the communication points."""

    model: str
    time: np.ndarray
    names: tuple[str, ...]
    values: np.ndarray
    """One row per communication point, one column per name."""
    statistics: Statistics
    units: dict[str, str] = field(default_factory=dict)
    source: Any = field(default=None, repr=False, compare=False)
    """The open FMU or loaded mechanism file that was run, for `show`."""

    def __contains__(self, name: str) -> bool:
        return name in self.names

    def __getitem__(self, name: str) -> np.ndarray:
        """Column of the scalar `name`, or (n, k) array of the vector `name[1..k]`."""
        if name in self.names:
            return self.values[:, self.names.index(name)]
        columns = [i for i, n in enumerate(self.names) if (element := split_element(n)) and element[0] == name]
        if not columns:
            raise NotRecordedError(name)
        return self.values[:, columns]

    def summary(self) -> str:
        """One line about what was simulated and what it cost."""
        s = self.statistics
        text = f"{self.model}: {s.simulated_time:.6g} s simulated in {s.wall_time:.3g} s"
        text += f" ({s.real_time_factor:.3g} times real time)"
        if s.steps is not None:
            text += f"; {s.steps} internal steps, {s.newton_per_step:.2f} Newton iterations each, {s.retries} retries"
        return text

    def show(self, height: int = 600) -> Any:
        """The mechanism in motion, for a notebook to display; `height` in pixels.

        Raises SigmafmuError if `position` and `quaternion` of a body were not recorded, or if nothing tells what the
        mechanism looks like.
        """
        from sigmafmu.view.notebook import Shown
        from sigmafmu.view.page import page
        from sigmafmu.view.subject import drawn

        if self.source is None:
            raise SigmafmuError(f"the result of {self.model} does not tell what the mechanism looks like")
        return Shown(page(drawn(self.source).scene, self), height)

    def write_csv(self, path: Path | str) -> None:
        """Write time and all values with 17 digits, which is exact."""
        with CsvWriter(path) as writer:
            writer.write(("time", *self.names), np.column_stack((self.time, self.values)))


class CsvWriter:
    """A CSV file that grows piece by piece; it is made with the first of them."""

    def __init__(self, path: Path | str):
        self.path, self.rows = Path(path), 0
        self._file: TextIO | None = None

    def __enter__(self) -> "CsvWriter":
        return self

    def __exit__(self, *_: object) -> None:
        if self._file:
            self._file.close()

    def write(self, names: Sequence[str], rows: np.ndarray) -> None:
        """Add rows, with 17 digits, which is exact; the first call writes the header."""
        try:
            if not self._file:
                self._file = self.path.open("w", encoding="utf-8", newline="")
                csv.writer(self._file, lineterminator="\n").writerow(names)
            np.savetxt(self._file, rows, fmt="%.17g", delimiter=",")
        except OSError as error:
            raise SigmafmuError(f"cannot write {self.path}: {error.strerror}") from error
        self.rows += len(rows)
