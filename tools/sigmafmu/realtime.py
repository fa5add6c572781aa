"""Paces an FMU with the wall clock, as a real-time master does, and looks at the latency of its steps."""

import ctypes
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave
from rich import box
from rich.table import Table

from sigmafmu import SigmafmuError, _core
from sigmafmu.model import Model
from sigmafmu.variables import SettingValue

FRAMES_PER_SECOND = 30.0
"""Of a run that is seen while it goes on."""


def native_steps(
    slave: FMU2Slave, H: float, n: int, period: float = 0.0, t0: float = 0.0, start: float = 0.0
) -> np.ndarray:
    """n communication steps of H from t0 [s] in C++: (n, 2), delay of the start and duration of each in s.

    With a `period` one starts every so many seconds, the first at the time `start` of time.monotonic() (0: at once).
    """
    address = ctypes.cast(slave.dll.fmi2DoStep, ctypes.c_void_p).value
    return _core.do_steps(address, slave.component, t0, H, n, period, start)


@dataclass(frozen=True)
class Latency:
    """Steps at a fixed rate; times in s."""

    model: str
    period: float
    delay: np.ndarray
    """How late each step started: the operating system's share."""
    duration: np.ndarray
    """How long each fmi2DoStep took."""

    @property
    def overruns(self) -> int:
        """Steps that were not finished within their period."""
        return int(np.sum(self.delay + self.duration > self.period))

    def table(self) -> Table:
        """Percentiles."""
        result = Table(
            title=f"{self.model} at {1 / self.period:g} Hz: {len(self.duration)} steps, {self.overruns} overruns",
            title_justify="left",
            box=box.SIMPLE_HEAD,
        )
        result.add_column("µs")
        for name in ("p50", "p99", "p99.9", "max"):
            result.add_column(name, justify="right")
        for label, values in (("fmi2DoStep", self.duration), ("start delay", self.delay)):
            quantiles = np.quantile(values, (0.5, 0.99, 0.999, 1.0)) * 1e6
            result.add_row(label, *(f"{x:.1f}" for x in quantiles))
        return result

    def plot(self, path: Path) -> None:
        """Histogram of both, on logarithmic axes."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8, 4.5), layout="constrained")
        axes = figure.subplots()
        shown = {"fmi2DoStep": self.duration * 1e6, "start delay (operating system)": self.delay * 1e6}
        smallest = max(min(values.min() for values in shown.values()), 1e-2)
        largest = max(values.max() for values in shown.values())
        bins = np.geomspace(smallest, 1.1 * max(largest, 1e6 * self.period), 80)
        for label, values in shown.items():
            axes.hist(np.maximum(values, smallest), bins=bins, histtype="step", linewidth=1.5, label=label)
        axes.axvline(self.period * 1e6, color="0.3", linestyle="--", label="period")
        axes.set(xscale="log", yscale="log", xlabel="µs", ylabel="steps")
        axes.set_title(f"{self.model} at {1 / self.period:g} Hz, {self.overruns} overruns", loc="left")
        figure.legend(loc="outside lower center", ncols=3, frameon=False)
        axes.grid(alpha=0.3)
        try:
            figure.savefig(path, dpi=130)
        except (OSError, ValueError) as error:
            raise SigmafmuError(f"cannot write {path}: {error}") from error


def run(
    model: Model,
    rate: float,
    duration: float,
    parameters: Mapping[str, SettingValue] | None = None,
    live: Callable[[Model, FMU2Slave, np.ndarray], AbstractContextManager[Callable[[], None]]] | None = None,
) -> Latency:
    """Run `model` for `duration` s of wall clock at `rate` Hz with H = 1 / rate.

    `live` shows it meanwhile: it gets the model, what runs and the times of frames, the first of them the start; within
    its context the run goes on, and what it gives is called at each of these times.
    """
    if not (rate > 0 and duration > 0 and np.isfinite(rate * duration)):
        raise SigmafmuError("rate and duration must be positive numbers")
    period, steps = 1 / rate, max(1, round(rate * duration))
    with model.instance(parameters) as instance:
        instance.start()
        try:
            if live is None:
                found = native_steps(instance.slave, period, steps, period)
            else:
                found = _seen(model, instance.slave, period, steps, live)
        except RuntimeError as error:
            raise SigmafmuError(f"{model.name}: {error}") from error
    return Latency(model.name, period, found[:, 0].copy(), found[:, 1].copy())


def _seen(model: Model, slave: FMU2Slave, period: float, steps: int, live: Callable[..., Any]) -> np.ndarray:
    """All steps, with a frame after some of them; what a frame takes is part of the next step's delay."""
    from sigmafmu.view.motion import MOST_FRAMES

    each = max(1, round(1 / (FRAMES_PER_SECOND * period)), -(-steps // MOST_FRAMES))
    ends = [*range(0, steps, each), steps]
    with live(model, slave, period * np.array(ends)) as show:
        show()
        parts, start = [], time.monotonic()
        for first, last in pairwise(ends):
            due = start + first * period
            parts.append(native_steps(slave, period, last - first, period, first * period, due))
            show()
    return np.concatenate(parts)
