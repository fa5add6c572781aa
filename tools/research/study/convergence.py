"""Error over step size as in Figs. 3, 4, 7 and 10 of the paper: every σ, formulation and corrector, and Exudyn."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from scipy.optimize import minimize_scalar

from research.measure import FORMULATION_NAMES
from research.study import cases, runs, slopes
from research.study.cases import CASES, CORRECTORS, PEER_SCHEMES, PEERS, SIGMAS, Case
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from research.study.runs import ERRORS, RESIDUAL
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

HEADER = (
    *("code", "formulation", "scheme", "corrector", "sigma", "rho_inf", "h"),
    *ERRORS,
    *("steps", "iterations", "jacobians", "failed"),
)


def converge(
    mechanism: str, steps: Sequence[float], stop_time: float, sigma: float | None, settings: dict[str, float]
) -> dict[str, Any]:
    """Runs of ours with all `steps`; σ None: the best one, measured with the last step but two."""
    if sigma is None:
        sigma = best_sigma(mechanism, steps[-3], stop_time, settings)
    return {"sigma": sigma, "runs": [runs.ours(mechanism, h, stop_time, sigma=sigma, **settings) for h in steps]}


def best_sigma(mechanism: str, h: float, stop_time: float, settings: dict[str, float]) -> float:
    """The σ in [0, 3] with the smallest position error: a scan, refined between the neighbours of its minimum."""

    def error(sigma: float) -> float:
        return runs.ours(mechanism, h, stop_time, sigma=sigma, **settings).get("position", np.inf)

    scan = np.linspace(0.0, cases.LARGEST_SIGMA, 16)
    i = int(np.argmin([error(sigma) for sigma in scan]))
    bounds = scan[max(i - 1, 0)], scan[min(i + 1, len(scan) - 1)]
    return float(minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": 1e-2}).x)


class Convergence:
    """Figs. 3, 4, 7, 10."""

    name = "convergence"
    title = "Convergence"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One cell for each curve."""
        case = CASES[mechanism]
        common = (mechanism, case.steps(quick), case.time(quick))
        result = []
        for formulation, rho in cases.formulations(mechanism).items():
            for corrector, name in CORRECTORS.items():
                settings = cases.settings(mechanism, formulation, corrector=corrector)
                key = f"{FORMULATION_NAMES[formulation]}/{name}"
                for label in SIGMAS:
                    arguments = (*common, cases.sigma_of(label, rho), settings)
                    result.append(Cell(f"{key}/{label}", converge, arguments))
                if corrector == RESIDUAL:
                    result.append(Cell(f"{key}/best", converge, (*common, None, settings)))
        for formulation in PEER_SCHEMES:
            for label in PEERS:
                key = f"{FORMULATION_NAMES[formulation]}/Exudyn/{label}"
                settings = cases.peer_settings(mechanism, formulation, label)
                result.append(Cell(key, runs.exudyn_steps, (*common, settings)))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A figure and a table for each mechanism."""
        parts = [
            "Errors with the parameters of the paper: for the heavy top the largest over the run, for the others that "
            "at the end, as there. Solid: the residual form; dashed: the algorithms as printed (incremental); dotted: "
            "Exudyn; the tables have more of both. Triangles have the slope they name. A cross at the foot marks a "
            "step with which the run fails. *Best* is the σ of the smallest position error over the run, from a search "
            "with the third smallest step. Exudyn has no stabilized index 2, and index 2 only with Newmark's method, "
            "the trapezoidal rule whatever ρ∞ is. Without constraints, as in the rotor, all formulations are one. The "
            "paper's own curves are not drawn here: its text states few of their values.\n"
        ]
        for mechanism, found in results.items():
            curves = [Curve(mechanism, key, cell) for key, cell in found.items()]
            rows = [row for curve in curves for row in curve.rows()]
            write_csv(folder / f"convergence_{mechanism}.csv", rows, HEADER)
            image = f"convergence_{mechanism}.png"
            _draw(folder / image, CASES[mechanism], curves)
            picture = f"![{mechanism}: error over step size]({image})"
            parts.append(f"### {mechanism} ({CASES[mechanism].figures})\n\n{picture}\n")
            parts.append(_table(CASES[mechanism], curves))
        return "\n".join(parts)

    def redraw(self, folder: Path) -> list[Path]:
        """Draw the figures anew from the CSV files in `folder`; returns what was written."""
        written = []
        for mechanism in self.mechanisms:
            table = folder / f"convergence_{mechanism}.csv"
            if table.is_file():
                written.append(folder / f"convergence_{mechanism}.png")
                _draw(written[-1], CASES[mechanism], read_curves(table, mechanism))
        return written


def read_curves(table: Path, mechanism: str) -> list["Curve"]:
    """The curves of a CSV file that `Convergence.report` has written."""
    cells: dict[str, dict[str, Any]] = {}
    with table.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            key = f"{row['formulation']}/{row['corrector'] or row['code']}/{row['scheme']}"
            sigma = float(row["sigma"]) if row["sigma"] else None
            run = {"h": float(row["h"]), **{name: float(row[name]) for name in ERRORS if row[name]}}
            cells.setdefault(key, {"sigma": sigma, "runs": []})["runs"].append(run)
    return [Curve(mechanism, key, cell) for key, cell in cells.items()]


class Curve:
    """The runs of one method with all steps."""

    def __init__(self, mechanism: str, key: str, cell: dict[str, Any]) -> None:
        formulation, self.corrector, self.label = key.split("/", 2)
        self.formulation = next(f for f, name in FORMULATION_NAMES.items() if name == formulation)
        self.mechanism, self.runs, self.sigma = mechanism, cell["runs"], cell.get("sigma")
        self.steps = np.array([run["h"] for run in self.runs])
        self.peer = self.corrector == "Exudyn"

    def values(self, error: str) -> np.ndarray:
        """Error for every step, NaN where the run failed."""
        return np.array([run.get(error, np.nan) for run in self.runs])

    @property
    def name(self) -> str:
        """For tables."""
        if self.peer:
            return f"Exudyn, {self.label}"
        name = cases.sigma_name(self.label, self.sigma)
        return name if self.corrector == "residual" else f"{name}, incremental"

    def order(self, error: str) -> float:
        """Slope of log(error) over log(h) of the three smallest steps."""
        x, y = np.log(self.steps[-3:]), np.log(self.values(error)[-3:])
        return float(np.polyfit(x, y, 1)[0]) if np.isfinite(y).all() else np.nan

    def rows(self) -> list[dict[str, Any]]:
        """For the CSV file."""
        own = {
            "code": "Exudyn" if self.peer else "sigmafmu",
            "formulation": FORMULATION_NAMES[self.formulation],
            "scheme": self.label,
            "corrector": "" if self.peer else self.corrector,
            "sigma": self.sigma,
            "rho_inf": CASES[self.mechanism].rho_inf[self.formulation],
        }
        return [own | run for run in self.runs]


STYLES = {
    ("residual", "geom1"): (COLORS[5], "-", "o"),
    ("residual", "γ/(3β)"): (COLORS[2], "-", "o"),
    ("residual", "1"): (COLORS[0], "-", "o"),
    ("residual", "best"): (COLORS[1], "-", "o"),
    ("incremental", "1"): (COLORS[0], "--", "s"),
    ("Exudyn", "σ-modified"): (COLORS[3], ":", "^"),
}
"""Colour, line and marker of (corrector, label): what the figures show, since six curves can be told apart."""


def _draw(path: Path, case: Case, curves: list[Curve]) -> None:
    curves = [c for c in curves if (c.corrector, c.label) in STYLES]
    formulations = list(dict.fromkeys(c.formulation for c in curves if not c.peer))
    with figure(path, (3.6 * len(formulations) + 0.6, 2.6 * len(case.errors) + 1.0)) as result:
        grid = result.subplots(len(case.errors), len(formulations), squeeze=False, sharex=True, sharey="row")
        handles: dict[str, Any] = {}
        for row, error in zip(grid, case.errors, strict=True):
            for axes, formulation in zip(row, formulations, strict=True):
                shown = [c for c in curves if c.formulation == formulation]
                for curve in shown:
                    name = "best σ" if curve.label == "best" else curve.name
                    handles[name] = _draw_curve(axes, curve, error)
                axes.set(xscale="log", yscale="log")
                axes.label_outer()
                _draw_triangles(axes, shown, error)
            row[0].set_ylabel(f"{error} error in {ERRORS[error]}")
        for axes, formulation in zip(grid[0], formulations, strict=True):
            axes.set_title(cases.formulation_title(curves[0].mechanism, formulation))
        steps = curves[0].steps
        for axes in grid[-1]:
            axes.set_xlabel("h in s")
            axes.set_xticks(steps[::2], [f"{h:.2g}" for h in steps[::2]])
            axes.set_xticks(steps[1::2], [], minor=True)
        columns = 3 if len(formulations) > 1 else 2
        result.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns, fontsize=8)


def _draw_curve(axes: Axes, curve: Curve, error: str) -> Any:
    color, line, marker = STYLES[curve.corrector, curve.label]
    values = curve.values(error)
    (handle,) = axes.plot(curve.steps, values, color=color, linestyle=line, marker=marker, markersize=3)
    failed = curve.steps[np.isnan(values)]  # every method has its own height at the foot
    height = 0.02 + 0.03 * (len(STYLES) - 1 - list(STYLES).index((curve.corrector, curve.label)))
    axes.plot(failed, np.full(len(failed), height), "x", color=color, ms=4, transform=axes.get_xaxis_transform())
    return handle


def _draw_triangles(axes: Axes, curves: list[Curve], error: str) -> None:
    """Slope 2 above all curves; below the lowest one the order that it shows, if that is a whole number above 2."""
    steps = curves[0].steps
    slopes.above(axes, steps, [c.values(error) for c in curves], 2)
    best = min(curves, key=lambda c: np.nan_to_num(c.values(error)[-1], nan=np.inf))
    order = best.order(error)
    if np.isfinite(order) and round(order) > 2 and abs(order - round(order)) < 0.1:
        slopes.below(axes, steps, best.values(error), round(order))


def _table(case: Case, curves: list[Curve]) -> str:
    """Errors with one of the steps, and orders."""
    middle = len(curves[0].steps) // 2
    first = case.errors[0]
    header = ["formulation", "scheme"]
    for error in case.errors:
        header += [f"{error} [{ERRORS[error]}]", "order"]
    header += ["gain", "fails for h [s]"]
    geom1 = {
        (c.formulation, c.peer): c.values(first)[middle]
        for c in curves
        if c.label == "geom1" and c.corrector != "incremental"
    }
    rows = []
    for c in curves:
        row = [FORMULATION_NAMES[c.formulation], c.name]
        for error in case.errors:
            value, order = c.values(error)[middle], c.order(error)
            row += ["fails" if np.isnan(value) else f"{value:.1e}", "–" if np.isnan(order) else f"{order:.2f}"]
        gain = geom1[c.formulation, c.peer] / c.values(first)[middle]
        failed = c.steps[np.isnan(c.values(first))]
        rows.append([*row, "–" if np.isnan(gain) else f"{gain:.2g}", _range(failed)])
    return (
        f"Errors with h = {curves[0].steps[middle]:g} s, observed orders of the three smallest steps; *gain*: how many "
        f"times smaller the {first} error is than with geom1 of the same code.\n\n{markdown_table(header, rows)}"
    )


def _range(steps: np.ndarray) -> str:
    if len(steps) == 0:
        return ""
    return f"{steps[0]:.2g}" if len(steps) == 1 else f"{steps.min():.2g} … {steps.max():.2g}"


CHAPTER = Convergence()
