"""Make the reference files tests/references/<Model>.csv with Exudyn, and state how good they are.

    python -m research references [--only HeavyTop] [--output tests/references]

Every mechanism is solved with three steps 4h, 2h and h. Mechanisms with constraints use Euler parameters, index 2 and
Newmark's method, of second order: the file holds Richardson's extrapolation of the two finer runs, and its stated
error is the distance to the extrapolation of the two coarser ones. The rotor is solved explicitly (RK67, sixth order,
exact to rounding already): the file holds the finest run, its stated error is the distance to the next one. Beside it
stands the distance to the independent solution in minimal coordinates. The mechanisms with a flexible body are made by
`make_flexible`.
"""

from __future__ import annotations

import platform
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import typer

from research.reference import (
    GROUPS,
    SAMPLE_STEP,
    STOP_TIME,
    History,
    differences,
    group_of,
    vector_columns,
)
from research.reference.exudyn_models import Run, Settings, simulate
from research.reference.minimal_coordinates import solve


@dataclass(frozen=True)
class Recipe:
    """How a reference is made: settings of the finest run, which follows runs with 4 and 2 times its step."""

    settings: Settings
    description: str
    extrapolate: bool  # Richardson, for a method of second order


# The Newton tolerance is near rounding: Newmark's accelerations, and with them the multipliers, carry an error of the
# velocities divided by the step.
_INDEX_2 = "Euler parameters, index 2 (constraints on velocity level), Newmark (trapezoidal rule), full Newton"
_IMPLICIT = Settings(step_size=2.5e-5, relative_tolerance=1e-13, absolute_tolerance=1e-15)
RECIPES = {
    "HeavyTop": Recipe(_IMPLICIT, _INDEX_2, extrapolate=True),
    "HighSpeedRotor": Recipe(
        Settings(step_size=1e-5, rotation="lieGroup", scheme="RK67"),
        "rotation vector increments, explicit Runge-Kutta method of order 6 (RK67)",
        extrapolate=False,
    ),
    "SliderCrank": Recipe(replace(_IMPLICIT, step_size=5e-5), _INDEX_2, extrapolate=True),
}


def richardson(coarse: History, fine: History) -> History:
    """(4 x(h/2) − x(h)) / 3: removes the h² term of the error. Quaternions are normalised afterwards."""
    result = {name: (4.0 * fine[name] - _nearer(name, coarse, fine)) / 3.0 for name in fine}
    result["time"] = fine["time"]
    for first in [name for name in fine if name.endswith(".quaternion[1]")]:
        columns = vector_columns(first.removesuffix("[1]"), 4)
        norm = np.sqrt(sum(result[column] ** 2 for column in columns))
        for column in columns:
            result[column] = result[column] / norm
    return result


def _nearer(name: str, coarse: History, fine: History) -> np.ndarray:
    """The coarse samples; those of a quaternion with the sign that is nearer to the fine ones."""
    if group_of(name) != "quaternion":
        return coarse[name]
    columns = vector_columns(name.partition("[")[0], 4)
    return coarse[name] * np.where(sum(coarse[column] * fine[column] for column in columns) < 0.0, -1.0, 1.0)


def make(name: str, folder: Path) -> Path:
    """Solve the mechanism `name`, write its reference file into `folder` and return the path."""
    recipe = RECIPES[name]
    steps = [factor * recipe.settings.step_size for factor in (4, 2, 1)]
    runs: list[Run] = []
    for step in steps:
        typer.echo(f"{name}: Exudyn, h = {step:g} s … ", nl=False)
        runs.append(simulate(name, replace(recipe.settings, step_size=step), STOP_TIME[name], SAMPLE_STEP[name]))
        typer.echo(f"{runs[-1].steps} steps, {runs[-1].wall_time:.1f} s")
    histories = [run.history for run in runs]
    if recipe.extrapolate:
        reference = richardson(histories[1], histories[2])
        error = differences(reference, richardson(histories[0], histories[1]))
        how = (
            f"Richardson's extrapolation (4 x({steps[2]:g}) - x({steps[1]:g})) / 3",
            f"largest difference to the extrapolation from {steps[0]:g} and {steps[1]:g} s",
        )
    else:
        reference = histories[2]
        error = differences(reference, histories[1])
        how = (f"the run with {steps[2]:g} s", f"largest difference to the run with {steps[1]:g} s")

    typer.echo(f"{name}: minimal coordinates … ", nl=False)
    start = time.perf_counter()
    independent = solve(name, reference["time"])
    deviation = differences(reference, {column: independent[column] for column in reference})
    typer.echo(f"{time.perf_counter() - start:.1f} s")

    header = {
        "model": name,
        "made by": f"python -m research references --only {name}",
        "solver": f"Exudyn {runs[-1].version} on {platform.system()} {platform.machine()}",
        "formulation": recipe.description,
        "steps": ", ".join(f"{step:g}" for step in steps) + " s",
        "Newton tolerance": tolerance_of(recipe.settings),
        "values": how[0],
        "stated error": how[1],
        **{f"stated error, {group}": f"{value:.1e} {GROUPS[group]}" for group, value in error.items()},
        "deviation": "largest difference to the independent solution in minimal coordinates",
        **{f"deviation, {group}": f"{value:.1e} {GROUPS[group]}" for group, value in deviation.items()},
    }
    path = folder / f"{name}.csv"
    write(path, header, reference)
    for group, value in deviation.items():
        typer.echo(f"  {group:<16} stated error {error[group]:.1e}, deviation {value:.1e} {GROUPS[group]}")
    typer.echo(f"  {path}: {path.stat().st_size / 1e3:.0f} kB")
    return path


def tolerance_of(settings: Settings) -> str:
    """Of Newton's method, in words."""
    if settings.scheme == "RK67":
        return "none (explicit)"
    return f"{settings.relative_tolerance:g} relative, {settings.absolute_tolerance:g} absolute"


def write(path: Path, header: dict[str, str], history: History) -> None:
    """Header lines, column names, table; 17 digits for positions and angles, 13 for the rest, 12 for time."""
    digits = {"position": 17, "angle": 17, "time": 12}
    columns = [
        # Exudyn leaves noise like 1e-30 in components that are zero
        [f"{x:.{digits.get(group_of(name), 13)}g}" for x in np.where(np.abs(samples) < 1e-18, 0.0, samples)]
        for name, samples in history.items()
    ]
    lines = [f"# {key}: {value}" for key, value in header.items()]
    lines += [",".join(history), *(",".join(row) for row in zip(*columns, strict=True))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
