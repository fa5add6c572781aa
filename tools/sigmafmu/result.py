"""What a simulation gives back: recorded variables over time and the cost of getting them."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import numpy as np

from sigmafmu import SigmafmuError, extras
from sigmafmu.variables import pattern, split_element, vectors

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from sigmafmu.fmu import Fmu
    from sigmafmu.view.notebook import Shown


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


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Values of the recorded variables at the communication points.

    `result["guide.displacement"]` is the column of a scalar, an array (n,); `result["slider.position"]` that of a
    vector, (n, 3). Both are in SI units, and NotRecordedError, a KeyError, says that a run has not recorded them.
    """

    model: str
    time: np.ndarray
    """(n,) in s."""
    names: tuple[str, ...]
    """Of the scalars."""
    values: np.ndarray
    """One row per communication point, one column per name."""
    statistics: Statistics
    units: dict[str, str] = field(default_factory=dict)
    """By the name of the scalar, as FMI writes them, such as `rad/s`; `1` or empty if there is none."""
    fmu: Fmu | None = field(default=None, repr=False, compare=False)
    """What was run, for `show`."""

    def __getstate__(self) -> dict[str, object]:
        return self.__dict__ | {"fmu": None}  # an open FMU stays in its process

    def __repr__(self) -> str:
        span = f"{self.time[0]:g} … {self.time[-1]:g} s" if len(self.time) else "empty"
        return f"<Result of {self.model}: {len(self.time)} rows of {len(self.names)} variables, {span}>"

    def __contains__(self, name: str) -> bool:
        return name in self.names or name in vectors(self.names)

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

    def show(self, height: int = 600) -> Shown:
        """The mechanism in motion, for a notebook to display; `height` in pixels.

        Raises SigmafmuError if `position` and `quaternion` of a body were not recorded, or if nothing tells what the
        mechanism looks like.
        """
        from sigmafmu.view.notebook import Shown
        from sigmafmu.view.page import page
        from sigmafmu.view.subject import scene_of_fmu

        if self.fmu is None:
            raise SigmafmuError(f"the result of {self.model} does not tell what the mechanism looks like")
        return Shown(page(scene_of_fmu(self.fmu), self), height)

    def plot(self, path: Path | str | None = None, names: Iterable[str] = (), *, phase: bool = False) -> Figure:
        """A matplotlib figure: what matters of the model, or the named scalars, vectors or patterns; saved at `path`.

        With `phase` rates are drawn over their coordinates: those of joints, or of positions if there are none.
        Raises NotRecordedError for a name that is not there, SigmafmuError if the file cannot be written.
        """
        from sigmafmu import plots

        names = (names,) if isinstance(names, str) else tuple(names)
        chosen = self.only(names) if names else self
        figure = plots.phase_portraits(chosen) if phase else plots.figure(chosen, named=bool(names))
        if path is not None:
            plots.save(figure, path)
        return figure

    def only(self, names: Iterable[str]) -> Result:
        """The same with fewer variables: scalars, vectors, or patterns with `*` and `?`."""
        columns: dict[int, None] = {}  # an ordered set
        for name in (names,) if isinstance(names, str) else names:
            found = [i for i, n in enumerate(self.names) if pattern(name).fullmatch(n)]
            if not found:
                raise NotRecordedError(name)
            columns |= dict.fromkeys(found)
        kept = tuple(self.names[i] for i in columns)
        units = {name: self.units[name] for name in kept if name in self.units}
        return replace(self, names=kept, values=self.values[:, list(columns)], units=units)

    def to_csv(self, path: Path | str) -> None:
        """Write time and all values with 17 digits, which is exact; SigmafmuError if that fails."""
        with CsvWriter(path) as writer:
            writer.write(("time", *self.names), np.column_stack((self.time, self.values)))

    def to_pandas(self) -> pandas.DataFrame:
        """A DataFrame with a column for each scalar and the index `time`; `attrs["units"]` are the units."""
        frame = extras.need("pandas").DataFrame(self.values, columns=list(self.names))
        frame.index = extras.need("pandas").Index(self.time, name="time")
        frame.attrs = {"model": self.model, "units": dict(self.units)}
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """A Dataset over `time` with a variable for each scalar and vector, which has a dimension `<name>_`.

        Elements are counted from 1 as in the model. The attribute `units` is that of the climate conventions, which
        plots of xarray show.
        """
        xr = extras.need("xarray")
        variables = {}
        for base, elements in vectors(self.names).items():
            attributes = {"units": self.units.get(elements[0], "")}
            if elements == [base]:
                variables[base] = ("time", self[base], attributes)
            else:
                numbers = [split[1] for name in elements if (split := split_element(name))]
                variables[base] = xr.DataArray(
                    self[base], dims=("time", f"{base}_"), coords={f"{base}_": numbers}, attrs=attributes
                )
        time = ("time", self.time, {"units": "s"})
        return xr.Dataset(variables, coords={"time": time}, attrs={"model": self.model})

    def to_parquet(self, path: Path | str) -> None:
        """Write a Parquet file with a column for `time` and each scalar; SigmafmuError if that fails.

        Its metadata have the `model` and the `units` as a JSON object.
        """
        told = {"model": self.model, "units": json.dumps({"time": "s", **self.units})}
        try:
            extras.need("fastparquet").write(str(path), self.to_pandas().reset_index(), custom_metadata=told)
        except OSError as error:
            raise SigmafmuError(f"cannot write {path}: {error.strerror or error}") from error


class CsvWriter:
    """A CSV file that grows piece by piece; it is made with the first of them."""

    def __init__(self, path: Path | str):
        self.path, self.rows = Path(path), 0
        self._file: TextIO | None = None

    def __enter__(self) -> CsvWriter:
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
