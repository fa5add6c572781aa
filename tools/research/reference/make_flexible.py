"""Make the reference files of the mechanisms with a flexible body, and state how good they are.

A file holds the solution in minimal coordinates, extrapolated in extended precision. Its stated error is the distance
to DOP853's solution of the same equations in double precision: another method, and rather the error of DOP853. Beside
it stands the distance to Exudyn, which shares nothing with either but the cloud: Euler parameters, index 2, Newmark's
method with steps 4h, 2h and h, Richardson's extrapolation, and what that knows of its own error.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import typer

from research.reference import (
    FLEXIBLE_SAMPLE_STEP,
    FLEXIBLE_STOP_TIME,
    GROUPS,
    History,
    differences,
    exudyn_flexible,
    flexible,
)
from research.reference.exudyn_models import Model, Run, Settings, simulate
from research.reference.make import richardson, tolerance_of, write

EXUDYN: dict[str, tuple[Callable[[Model], None], Settings]] = {
    name: (build, Settings(step_size=step, relative_tolerance=1e-13, absolute_tolerance=1e-15))
    for name, build, step in (
        ("FlexiblePendulum", exudyn_flexible.flexible_pendulum, 2.5e-5),
        ("FlexibleSliderCrank", exudyn_flexible.flexible_slider_crank, 2.5e-5),
        ("SpinUpBeam", exudyn_flexible.spin_up_beam, 1.25e-3),
    )
}
"""How Exudyn builds a mechanism, and its finest run."""


def shared(history: History, reference: History) -> tuple[History, History]:
    """The columns that both have, in the order of `reference`, at the rows of `history`; times of the latter."""
    columns = [column for column in reference if column in history]
    rows = len(history["time"])
    np.testing.assert_allclose(history["time"], reference["time"][:rows], atol=1e-12)
    theirs = {column: reference[column][:rows] for column in columns}
    return {**{column: history[column] for column in columns}, "time": theirs["time"]}, theirs


def sample_times(name: str, stop_time: float | None = None) -> np.ndarray:
    """The grid of a file, s, from 0 to stop_time (default: all of it)."""
    step = FLEXIBLE_SAMPLE_STEP[name]
    return np.arange(round((stop_time or FLEXIBLE_STOP_TIME[name]) / step) + 1) * step


def exudyn_runs(name: str, stop_time: float) -> list[Run]:
    """Exudyn with steps 4h, 2h and h."""
    build, settings = EXUDYN[name]
    runs = []
    for factor in (4, 2, 1):
        step = factor * settings.step_size
        typer.echo(f"{name}: Exudyn, h = {step:g} s … ", nl=False)
        runs.append(
            simulate(name, replace(settings, step_size=step), stop_time, FLEXIBLE_SAMPLE_STEP[name], build=build)
        )
        typer.echo(f"{runs[-1].steps} steps, {runs[-1].wall_time:.1f} s")
    return runs


def make_flexible(name: str, folder: Path) -> Path:
    """Solve the mechanism `name`, write its reference file into `folder` and return the path."""
    epsilon = np.finfo(np.longdouble).eps
    if epsilon > 2e-19:
        raise RuntimeError(f"longdouble has ε = {epsilon:.1e} here; the files need at most 2e-19 (x86 Linux)")
    times, clock = sample_times(name), time.perf_counter()
    typer.echo(f"{name}: minimal coordinates … ", nl=False)
    reference = flexible.precise(name, times)
    typer.echo(f"{time.perf_counter() - clock:.1f} s, in double precision … ", nl=False)
    error = differences(flexible.solve(name, times), reference)
    typer.echo(f"{time.perf_counter() - clock:.1f} s")
    header = {
        "model": name,
        "made by": f"python -m research references --only {name}",
        "solver": f"Gragg-Bulirsch-Stoer extrapolation to order 18, epsilon {epsilon:.1e}, {platform.machine()}",
        "formulation": "minimal coordinates, sums over all nodes",
        "stated error": "largest difference to DOP853 in double precision",
        **_figures("stated error", error),
    }
    runs = exudyn_runs(name, FLEXIBLE_STOP_TIME[name])
    coarse, fine = (richardson(a.history, b.history) for a, b in pairwise(runs))
    settings = EXUDYN[name][1]
    header |= {
        "deviation": f"largest difference to Exudyn {runs[-1].version}: ObjectFFRFreducedOrder, Euler parameters, "
        f"index 2, Newmark, extrapolated from {2 * settings.step_size:g} and {settings.step_size:g} s, Newton "
        f"tolerance {tolerance_of(settings)}",
        **_figures("deviation", differences(*shared(fine, reference))),
        "Exudyn's own error": "largest difference to its extrapolation from twice the steps",
        **_figures("Exudyn's own error", differences(fine, coarse)),
    }
    path = folder / f"{name}.csv"
    write(path, header, reference)
    for key, value in header.items():
        typer.echo(f"  {key}: {value}")
    typer.echo(f"  {path}: {path.stat().st_size / 1e3:.0f} kB")
    return path


def _figures(kind: str, values: dict[str, float]) -> dict[str, str]:
    return {f"{kind}, {group}": f"{value:.1e} {GROUPS[group]}" for group, value in values.items()}
