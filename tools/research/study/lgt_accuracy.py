"""Chapter: how accurate every method is on every group, coordinate map and absolute coordinates of Table 1."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import MULTIPLIERS
from research.reference import Rotor
from research.study import lgt, runs, slopes
from research.study.chapter import Cell, Results
from research.study.lgt import ABSOLUTE, COMBINATIONS, METHODS, Combination, number
from research.study.output import figure, write_csv
from sigmafmu.markdown import markdown_table

TIGHT = {"relative_tolerance": 1e-11, "absolute_tolerance": 1e-12}
"""Of Newton's method: what is left is the method's error."""
QUANTITIES = ("position", "velocity", "rotation")
TURNING = ("HeavyTop", "HighSpeedRotor")
"""The followed body turns."""
RATIOS = {
    "*SE(3) over R³×SO(3), exp*": (Combination("SE3", "exp"), Combination("R3xSO3", "exp")),
    "*cayley over exp, R³×SO(3)*": (Combination("R3xSO3", "cayley"), Combination("R3xSO3", "exp")),
}
HEADER = ("method", "group", "map", "absolute", "table1", "h", *QUANTITIES, "failed")
CEILING = 0.1
"""Errors that tell an order are below this part of the motion, and above `Setup.floor`."""
SPIN_TIME, SPIN_STEPS = 2e-3, (2e-5, 1e-5, 5e-6)  # s
SPIN_METHODS = ("bliedf2", "generalizedAlpha")


@dataclass(frozen=True)
class Setup:
    """Of one mechanism; every step is half of the one before."""

    stop_time: float  # s
    quick_time: float  # s
    largest_step: float  # s
    halvings: int
    quick_halvings: range
    floor: tuple[float, float, float]
    """Of QUANTITIES: ten times what is left with the smallest steps, rounding of runs and of the reference."""

    def steps(self, quick: bool) -> list[float]:
        """Step sizes in s."""
        return [self.largest_step / 2**i for i in (self.quick_halvings if quick else range(self.halvings + 1))]


SETUPS = {
    "HeavyTop": Setup(1.0, 0.5, 4e-3, 7, range(2, 5), (5e-11, 5e-10, 5e-11)),
    "HighSpeedRotor": Setup(0.02, 0.01, 4e-5, 5, range(1, 4), (1e-13, 2e-9, 5e-12)),
    "SliderCrank": Setup(2.0, 1.0, 2e-2, 7, range(1, 4), (2e-12, 1e-10, 1e-12)),
}


def converge(
    mechanism: str, method: str, group: str, coordinate_map: str, steps: Sequence[float], stop_time: float
) -> dict[str, Any]:
    """Errors with all `steps`, for both kinds of absolute coordinates, and how far apart these are."""
    settings = {**METHODS[method], **(lgt.FIXED_STEPS if method == "rkmk54" else TIGHT)}
    chosen = {a: {**settings, **Combination(group, coordinate_map, a).settings} for a in ABSOLUTE}
    x, v = runs.point_motion(mechanism, runs.exact(mechanism, stop_time))
    return {
        "runs": {a: [runs.ours(mechanism, h, stop_time, **s) for h in steps] for a, s in chosen.items()},
        "difference": _difference(mechanism, steps[len(steps) // 2], stop_time, *chosen.values()),
        "motion": {"position": _extent(x), "velocity": _extent(v), "rotation": 1.0},
    }


def spin(method: str, coordinate_map: str) -> dict[str, Any]:
    """Error of the rotor's orientation [rad] after SPIN_TIME with each of SPIN_STEPS."""
    settings = {**METHODS[method], **TIGHT, **Combination("R3xSO3", coordinate_map).settings}
    found = [runs.ours("HighSpeedRotor", h, SPIN_TIME, **settings) for h in SPIN_STEPS]
    return {"measured": [run.get("rotation", np.nan) for run in found]}


def lag(coordinate_map: str, h: float) -> float:
    """Angle [rad] that the rotor's spin ω lacks after SPIN_TIME when the local coordinate of each step is h ω."""
    angle = Rotor().spin * h
    turned = {"exp": angle, "cayley": 2 * np.arctan(angle / 2), "cayley2": 4 * np.arctan(angle / 4)}[coordinate_map]
    return (angle - turned) * SPIN_TIME / h


def _difference(mechanism: str, h: float, stop_time: float, *settings: Mapping[str, float]) -> float:
    """Largest distance [m] of the followed point between two settings."""
    try:
        found = [runs.trajectory(mechanism, h, stop_time, **chosen)[0] for chosen in settings]
    except RuntimeError:
        return np.nan
    first, second = (runs.point_motion(mechanism, history)[0] for history in found)
    return float(np.abs(first - second).max())


def _extent(x: np.ndarray) -> float:
    return float(np.linalg.norm(x - x[0], axis=1).max())


class Accuracy:
    """Convergence of all combinations."""

    name = "lgt_accuracy"
    title = "Local-global transition maps: accuracy"
    mechanisms = tuple(SETUPS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each method, group and map; on the rotor also the lag of its spin."""
        setup = SETUPS[mechanism]
        work = (tuple(setup.steps(quick)), setup.quick_time if quick else setup.stop_time)
        result = [
            Cell(f"{method}/{c.group}/{c.map}", converge, (mechanism, method, c.group, c.map, *work))
            for method in lgt.methods(bool(MULTIPLIERS[mechanism]))
            for c in COMBINATIONS
        ]
        if mechanism == "HighSpeedRotor":
            result += [
                Cell(f"spin/{method}/{name}", spin, (method, name)) for method in SPIN_METHODS for name in lgt.MAPS
            ]
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A figure and a table for each mechanism, with the explanation of what they show."""
        parts = [
            "Largest error over the run, of the followed point's position and velocity and of the body's orientation. "
            "The defaults of the FMU (ρ∞ = 0.9, σ = 1), Newton's tolerances tight; rkmk54 with fixed steps, its error "
            "control off. Colour: the group; line: the coordinate map. Table 1: the combination's place in the paper, "
            "with quaternions; rotation vectors (rows 2) give the same lines.\n"
        ]
        for mechanism, found in results.items():
            curves = {tuple(key.split("/")): cell for key, cell in found.items() if not key.startswith("spin/")}
            write_csv(folder / f"lgt_accuracy_{mechanism}.csv", _rows(curves), HEADER)
            image = f"lgt_accuracy_{mechanism}.png"
            _draw(folder / image, mechanism, curves)
            parts.append(f"### {mechanism}\n\n![{mechanism}: error over step size]({image})\n")
            parts.append(_tables(mechanism, curves))
            parts.append(_absolute(curves))
            if mechanism == "HighSpeedRotor":
                parts.append(_spin({key: cell for key, cell in found.items() if key.startswith("spin/")}))
        return "\n".join(parts)

    def redraw(self, folder: Path) -> list[Path]:
        """Draw the figures anew from the CSV files in `folder`; returns what was written."""
        written = []
        for mechanism in self.mechanisms:
            table = folder / f"lgt_accuracy_{mechanism}.csv"
            if table.is_file():
                written.append(table.with_suffix(".png"))
                _draw(written[-1], mechanism, read_curves(table))
        return written


Curves = Mapping[tuple[str, ...], Mapping[str, Any]]
"""(method, group, map) → what `converge` returned."""


def read_curves(table: Path) -> Curves:
    """The curves of a CSV file that `Accuracy.report` has written."""
    cells: dict[tuple[str, str, str], dict[str, Any]] = {}
    with table.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            cell = cells.setdefault((row["method"], row["group"], row["map"]), {"runs": {}})
            run = {"h": float(row["h"]), **{name: float(row[name]) for name in QUANTITIES if row[name]}}
            cell["runs"].setdefault(row["absolute"], []).append(run)
    return cells


def values(cell: Mapping[str, Any], quantity: str, absolute: str = "quaternion") -> np.ndarray:
    """Errors for each step; NaN where the run failed."""
    return np.array([run.get(quantity, np.nan) for run in cell["runs"][absolute]])


def observed(mechanism: str, cell: Mapping[str, Any], quantity: str) -> float:
    """Order of a curve."""
    floor = SETUPS[mechanism].floor[QUANTITIES.index(quantity)]
    steps = [run["h"] for run in cell["runs"]["quaternion"]]
    return lgt.order(steps, values(cell, quantity), floor, CEILING * cell["motion"][quantity])


def _rows(curves: Curves) -> list[dict[str, Any]]:
    rows = []
    for (method, *names), cell in curves.items():
        for absolute in ABSOLUTE:
            c = replace(Combination(*names), absolute=absolute)
            own = {"method": method, "group": c.group, "map": c.map, "absolute": absolute, "table1": c.table1}
            rows += [{**own, **run} for run in cell["runs"][absolute]]
    return rows


def _draw(path: Path, mechanism: str, curves: Curves) -> None:
    """Methods across; position, velocity or, where bodies spin fast, orientation down."""
    names = list(dict.fromkeys(method for method, *_ in curves))
    quantities = ("position", "rotation") if mechanism == "HighSpeedRotor" else ("position", "velocity")
    steps = [run["h"] for run in next(iter(curves.values()))["runs"]["quaternion"]]
    with figure(path, (2.5 * len(names) + 0.6, 6.0)) as result:
        grid = result.subplots(2, len(names), squeeze=False, sharex=True, sharey="row")
        for row, quantity in zip(grid, quantities, strict=True):
            for axes, method in zip(row, names, strict=True):
                for c in COMBINATIONS:
                    axes.plot(steps, values(curves[method, c.group, c.map], quantity), **c.style)
                axes.set_yscale("log")
                lgt.step_axis(axes, steps)
                shown = [values(curves[method, c.group, c.map], quantity) for c in COMBINATIONS]
                slopes.above(axes, steps, shown, lgt.ORDERS[method.partition(",")[0]], at=len(steps) // 2 - 2)
            row[0].set_ylabel(f"{quantity} error in {runs.ERRORS[quantity]}")
        for axes, method in zip(grid[0], names, strict=True):
            axes.set_title(method.replace(", ", ",\n"))
        for axes in grid[-1]:
            axes.set_xlabel("h in s")
        result.legend(handles=lgt.legend_handles(), loc="outside lower center", ncols=6, fontsize=8)


def _tables(mechanism: str, curves: Curves) -> str:
    """Errors with the middle step and orders."""
    names = list(dict.fromkeys(method for method, *_ in curves))
    steps = [run["h"] for run in next(iter(curves.values()))["runs"]["quaternion"]]
    middle = len(steps) // 2
    parts = []
    for quantity in QUANTITIES if mechanism in TURNING else QUANTITIES[:2]:
        found = {
            (method, c): values(curves[method, c.group, c.map], quantity)[middle]
            for method in names
            for c in COMBINATIONS
        }
        rows = []
        for c in COMBINATIONS:
            orders = {method: observed(mechanism, curves[method, c.group, c.map], quantity) for method in names}
            entries = (f"{number(found[m, c])} ({'–' if np.isnan(p) else f'{p:.2f}'})" for m, p in orders.items())
            rows.append([c.table1, c.name, *entries])
        for label, (above, below) in RATIOS.items():
            rows.append(["", label, *(f"{found[method, above] / found[method, below]:.2g} ×" for method in names)])
        parts.append(
            f"{quantity.capitalize()} error [{runs.ERRORS[quantity]}] with h = {steps[middle]:g} s, in brackets the "
            f"observed order:\n\n{markdown_table(['Table 1', 'group, map', *names], rows)}"
        )
    return "\n".join(parts)


def _absolute(curves: Curves) -> str:
    worst = max((cell["difference"], key) for key, cell in curves.items())
    motion = next(iter(curves.values()))["motion"]["position"]
    return (
        f"Rotation vectors instead of quaternions move the point by {worst[0]:.1e} m at most ({', '.join(worst[1])}), "
        f"{worst[0] / motion:.0e} of its motion: absolute coordinates only store what the group has computed.\n"
    )


def _spin(found: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for coordinate_map in lgt.MAPS:
        row = [coordinate_map]
        for i, h in enumerate(SPIN_STEPS):
            row += [f"{lag(coordinate_map, h):.1e}"]
            row += [number(found[f"spin/{method}/{coordinate_map}"]["measured"][i]) for method in SPIN_METHODS]
        rows.append(row)
    header = ["map"]
    for h in SPIN_STEPS:
        header += [f"h = {h:g} s: (*)", *SPIN_METHODS]
    return (
        "**Why Cayley loses the angle of a spin.** A body that spins with constant ω turns by hω in a step. The local "
        "coordinate of that motion is x = hω for exp, where it grows linearly, 2 tan(hω/2) for Cayley and 4 tan(hω/4) "
        "for Cayley2, whose rates ẋ = ω (1 + x²/4) and ω (1 + x²/16) change within the step. Where a method makes "
        "x = hω of constant velocities, as BLieDF does, it lags behind by (*) hω − 2 atan(hω/2) ≈ (hω)³/12 and "
        "hω − 4 atan(hω/4) ≈ (hω)³/48 in every step, a quarter; generalized-α by another multiple, which σ changes. "
        "That is second order, but in the angle of the spin, where the exponential has no error at all. The bearings "
        "of a rotor with an axis of symmetry do not feel it; an unbalance or an angle sensor would. Error of the "
        f"orientation [rad] on R³×SO(3) after {SPIN_TIME:g} s, {SPIN_TIME * Rotor().spin / (2 * np.pi):.1f} turns:\n\n"
        + markdown_table(header, rows)
    )


CHAPTER = Accuracy()
