"""Chapter: flexible bodies, how the errors fall with the step size for every σ, formulation and method."""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from research.measure import FORMULATION_NAMES
from research.study import cases, slopes
from research.study.cases import SIGMAS
from research.study.chapter import Cell, Results
from research.study.flexible_runs import (
    CASES,
    ERRORS,
    FIXED_STEPS,
    OTHERS,
    PEERS,
    RHO_INF,
    explicit,
    generalized_alpha,
    our_steps,
    peer_steps,
    rigid_steps,
)
from research.study.lgt import ORDERS, number, order, step_axis
from research.study.output import figure, write_csv
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

RIGID = "rigid"
"""Cell of FlexiblePendulum with a rigid beam."""
HEADER = ("code", "method", "h", *ERRORS, "steps", "iterations", "jacobians", "failed")
LABELS = {
    "position": "point of the centre line, m",
    "modal": "modal coordinates, m",
    "angularVelocity": "angular velocity, rad/s",
}
FLOOR, CEILING = {"position": 1e-13, "modal": 1e-13, "angularVelocity": 1e-10}, 0.1
"""Errors between which the order is read: the solution's own error, and a share of the largest error drawn."""
PEER_NEWTON = {"relative_tolerance": 1e-10}
"""With its default, 1e-8, angular velocities in index 3 have no order: one iteration is enough for the residual."""
SHOWN = (
    ("geom1", "index 3"),
    ("geom1", "stabilized index 2"),
    ("γ/(3β)", "index 3"),
    ("1", "index 3"),
    ("1", "stabilized index 2"),
)
"""σ and formulation of the curves in the upper figures; the others lie on them."""
PEER = "Exudyn/index 3, σ-modified"
FORMULATION_LINES = dict(zip(FORMULATION_NAMES.values(), ("-", "--", ":"), strict=True))
METHOD_COLORS = dict(zip(("generalizedAlpha", "bliedf2", "rkmk4", "rkmk54"), COLORS, strict=False))


class FlexibleAccuracy:
    """Convergence with the step size."""

    name = "flexible_accuracy"
    title = "Flexible bodies: convergence"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each method; one for the rigid beam."""
        case = CASES[mechanism]
        common = (mechanism, case.steps(quick), case.time(quick))
        result = [Cell(f"sigmafmu/{name}", our_steps, (*common, s)) for name, s in ways(mechanism).items()]
        peers = list(PEERS.items())[:: 2 if quick else 1]
        result += [Cell(f"Exudyn/{name}", peer_steps, (*common, {**s, **PEER_NEWTON})) for name, s in peers]
        if mechanism == "FlexiblePendulum":
            result.append(Cell(RIGID, rigid_steps, common[1:]))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A figure and two tables for each mechanism."""
        parts = [
            f"Largest error over the run against minimal coordinates with sums over all nodes; ρ∞ = {RHO_INF:g}. "
            "`position` is the tip of the beam or the middle of the rod, `modal` the vector of modal coordinates, "
            "`angularVelocity` that of the floating frame. Exudyn: ObjectFFRFreducedOrder with the same masses, "
            "stiffness and modes. rkmk54 with fixed steps. SpinUpBeam's torque is a chord over each step, so that "
            "explicit methods have no more than order two there; they are left out.\n"
        ]
        for mechanism, found in results.items():
            curves = {key: Curve(cell["runs"]) for key, cell in found.items() if key != RIGID}
            write_csv(folder / f"{self.name}_{mechanism}.csv", _rows(curves), HEADER)
            image = f"{self.name}_{mechanism}.png"
            _draw(folder / image, mechanism, curves)
            parts.append(f"### {mechanism}\n\n![{mechanism}: error over step size]({image})\n\n{_table(curves)}")
            parts.append(f"\nThe share that σ has in the errors:\n\n{_sigma_table(curves, found.get(RIGID))}")
        return "\n".join(parts)

    def redraw(self, folder: Path) -> list[Path]:
        """Draw the figures anew from the CSV files in `folder`; returns what was written."""
        written = []
        for mechanism in self.mechanisms:
            table = folder / f"{self.name}_{mechanism}.csv"
            if table.is_file():
                written.append(table.with_suffix(".png"))
                _draw(written[-1], mechanism, read_curves(table))
        return written


def read_curves(table: Path) -> dict[str, "Curve"]:
    """The curves of a CSV file that `FlexibleAccuracy.report` has written."""
    runs: dict[str, list[dict[str, float]]] = {}
    with table.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            run = {"h": float(row["h"]), **{name: float(row[name]) for name in ERRORS if row[name]}}
            runs.setdefault(f"{row['code']}/{row['method']}", []).append(run)
    return {key: Curve(found) for key, found in runs.items()}


def ways(mechanism: str) -> dict[str, dict[str, float]]:
    """Methods of ours and their settings."""
    others = {
        name: {**settings, **FIXED_STEPS} if settings.get("method") == 3 else settings
        for name, settings in OTHERS.items()
        if not (CASES[mechanism].driven and explicit(settings))
    }
    return {**generalized_alpha(), **others}


class Curve:
    """Errors of one method with all steps; NaN where a run fails."""

    def __init__(self, runs: list[Mapping[str, Any]]) -> None:
        self.runs = runs
        self.steps = np.array([run["h"] for run in runs])

    def errors(self, quantity: str) -> np.ndarray:
        """From the largest step to the smallest."""
        return np.array([run.get(quantity, np.nan) for run in self.runs])

    def order(self, quantity: str) -> float:
        """Observed."""
        errors = self.errors(quantity)
        return order(self.steps, errors, FLOOR[quantity], CEILING)


def _rows(curves: Mapping[str, Curve]) -> list[dict[str, Any]]:
    return [
        {"code": key.split("/", 1)[0], "method": key.split("/", 1)[1], **run}
        for key, curve in curves.items()
        for run in curve.runs
    ]


def _table(curves: Mapping[str, Curve]) -> str:
    """Errors with the middle step and orders; σ = 1 of generalizedAlpha."""
    chosen = {key: c for key, c in curves.items() if "σ = " not in key or key.endswith("σ = 1")}
    middle = len(next(iter(chosen.values())).steps) // 2
    rows = []
    for key, curve in chosen.items():
        code, method = key.split("/", 1)
        row = [code, method]
        for quantity in ERRORS:
            row += [number(curve.errors(quantity)[middle]), number(curve.order(quantity), ".2f").replace("fails", "–")]
        rows.append(row)
    h = next(iter(chosen.values())).steps[middle]
    header = ["code", "method"]
    for quantity, unit in ERRORS.items():
        header += [f"{quantity}, {unit}", "order"]
    return f"h = {h:g} s:\n\n{markdown_table(header, rows)}"


def _sigma_table(curves: Mapping[str, Curve], rigid: Mapping[str, list[float]] | None) -> str:
    """Errors over those of geom1, with the smallest step that all have."""
    rows = []
    for name in FORMULATION_NAMES.values():
        ours = {label: curves[f"sigmafmu/{name}, {cases.sigma_name(label)}"] for label in SIGMAS}
        base = ours[SIGMAS[0]]
        for quantity in ERRORS:
            ratios = [ours[label].errors(quantity)[-1] / base.errors(quantity)[-1] for label in SIGMAS[1:]]
            rows.append([name, quantity, number(base.errors(quantity)[-1]), *(f"{r:.4f}" for r in ratios)])
        if rigid:
            errors = {label: rigid[f"{name}, {cases.sigma_name(label)}"][-1] for label in SIGMAS}
            base_error = errors[SIGMAS[0]]
            ratios = [errors[label] / base_error for label in SIGMAS[1:]]
            rows.append([name, "position, rigid beam", number(base_error), *(f"{r:.4f}" for r in ratios)])
    return markdown_table(["formulation", "error", "geom1", *(f"σ = {s}: times" for s in SIGMAS[1:])], rows)


def _draw(path: Path, mechanism: str, curves: Mapping[str, Curve]) -> None:
    """Quantities across; generalizedAlpha with Exudyn above, other methods below."""
    others = [name for name in OTHERS if f"sigmafmu/{name}" in curves and name != "bliedf2, SE(3)"]
    steps = next(iter(curves.values())).steps
    shown = {(label, name): f"sigmafmu/{name}, {cases.sigma_name(label)}" for label, name in SHOWN}
    with figure(path, (10.5, 6.6)) as result:
        above, below = result.subfigures(2, 1)
        top, bottom = above.subplots(1, len(ERRORS)), below.subplots(1, len(ERRORS))
        for i, quantity in enumerate(ERRORS):
            for key, curve in curves.items():
                if key == PEER:
                    _line(top[i], curve, quantity, "Exudyn", color="0.8", linewidth=4)
            for color, label in zip(COLORS, SIGMAS, strict=False):
                for name, line in FORMULATION_LINES.items():
                    sigma = cases.sigma_name(label)
                    if key := shown.get((label, name)):
                        style = {"color": color, "linestyle": line, "marker": "o"}
                        _line(top[i], curves[key], quantity, f"{sigma}, {name}", **style)
            for name in others:
                line = ("--", "x") if "SE(3)" in name else ("-", "o")
                style = {"color": METHOD_COLORS[name.split(",")[0]], "linestyle": line[0], "marker": line[1]}
                _line(bottom[i], curves[f"sigmafmu/{name}"], quantity, name, **style)
            top[i].set_title(LABELS[quantity])
            slopes.above(top[i], steps, [curves[key].errors(quantity) for key in shown.values()], 2)
            for name in others:
                if ORDERS.get(name, 2) > 2:
                    errors = curves[f"sigmafmu/{name}"].errors(quantity)
                    slopes.below(bottom[i], steps, errors, ORDERS[name], at=1)
        for axes in (*top, *bottom):
            step_axis(axes, next(iter(curves.values())).steps.tolist())
            axes.set(yscale="log", xlabel="step size h in s")
        for part, axes, columns in ((above, top[0], 5), (below, bottom[0], 4)):
            handles = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))  # one of each label
            part.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns, fontsize=7.5)
        above.suptitle(f"{mechanism}: largest errors, generalizedAlpha above, other methods below", x=0.01, ha="left")


def _line(axes: Axes, curve: Curve, quantity: str, label: str, **style: Any) -> None:
    axes.plot(curve.steps, curve.errors(quantity), label=label, markersize=3, **style)


CHAPTER = FlexibleAccuracy()
