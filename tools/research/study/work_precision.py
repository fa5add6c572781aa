"""CPU time against error: every scheme, formulation and Newton variant of ours, and Exudyn, one after the other."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import FORMULATION_NAMES, INDEX3
from research.study import cases, runs
from research.study.cases import CASES, PEER_SCHEMES, PEERS, SIGMAS
from research.study.chapter import Cell, Results
from research.study.convergence import best_sigma
from research.study.iterations import PEER_VARIANTS, VARIANTS
from research.study.output import figure, write_csv
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

HEADER = ("code", "formulation", "variant", "scheme", "sigma", "h", "steps", "seconds", *runs.ERRORS, "failed")
ROUNDS = 5
SCHEMES = {"full": (*SIGMAS, "best"), "simplified": ("geom1", "1"), "modified": ("geom1", "1")}
"""What is timed with each variant of Newton's method."""


def work(
    mechanism: str, steps: Sequence[float], stop_time: float, rounds: int, sigma: float | None, settings: dict[str, Any]
) -> dict[str, Any]:
    """Errors and times of ours with all `steps`; σ None: the best one."""
    if sigma is None:
        sigma = best_sigma(mechanism, steps[-3], stop_time, settings)
    chosen = {**settings, "sigma": sigma}
    found = [runs.ours(mechanism, h, stop_time, **chosen) for h in steps]
    for run in found:
        if "failed" not in run:
            run["seconds"] = runs.seconds(mechanism, run["h"], stop_time, rounds, **chosen)
    return {"sigma": sigma, "runs": found}


def work_peer(
    mechanism: str, steps: Sequence[float], stop_time: float, rounds: int, settings: dict[str, Any]
) -> dict[str, Any]:
    """Errors and times of Exudyn with all `steps`."""
    found = [runs.exudyn(mechanism, h, stop_time, **settings) for h in steps]
    for run in found:
        if "failed" not in run:
            run["seconds"] = runs.seconds_exudyn(mechanism, run["h"], stop_time, rounds, **settings)
    return {"runs": found}


class WorkPrecision:
    """Work-precision diagrams and the time to one accuracy."""

    name = "work_precision"
    title = "Work and precision"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each curve; they are timed, so they run alone."""
        case = CASES[mechanism]
        common = (mechanism, case.steps(quick), case.time(quick, short=True), 1 if quick else ROUNDS)
        result = []
        for formulation, rho in cases.formulations(mechanism).items():
            for variant, labels in SCHEMES.items():
                settings = cases.settings(mechanism, formulation, **VARIANTS[variant])
                for label in labels:
                    key = f"{FORMULATION_NAMES[formulation]}/sigmafmu/{variant}/{label}"
                    sigma = None if label == "best" else cases.sigma_of(label, rho)
                    result.append(Cell(key, work, (*common, sigma, settings), alone=True))
        for formulation in PEER_SCHEMES:
            for variant, chosen in PEER_VARIANTS.items():
                for label in PEERS if variant == "full" else ("geom1", "σ-modified"):
                    key = f"{FORMULATION_NAMES[formulation]}/Exudyn/{variant}/{label}"
                    settings = cases.peer_settings(mechanism, formulation, label, **chosen)
                    result.append(Cell(key, work_peer, (*common, settings), alone=True))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A diagram and two tables for each mechanism."""
        parts = [
            "CPU time of a whole run, without output, against the largest position error over it; every point is one "
            "step size, the fastest of some rounds, nothing else running. Grey: Exudyn, all its ways. The tables give "
            "the time to one accuracy, interpolated between the points; ≤: the largest step is good enough already.\n"
        ]
        for mechanism, found in results.items():
            curves = [Curve(key, cell) for key, cell in found.items()]
            rows = [row for curve in curves for row in curve.rows()]
            write_csv(folder / f"work_precision_{mechanism}.csv", rows, HEADER)
            image = f"work_precision_{mechanism}.png"
            _draw(folder / image, mechanism, curves)
            parts.append(f"### {mechanism}\n\n![{mechanism}: error over CPU time]({image})\n")
            parts.append(_tables(mechanism, curves))
        return "\n".join(parts)


class Curve:
    """Time and error of one method with all steps; what failed is left out."""

    def __init__(self, key: str, cell: Mapping[str, Any]) -> None:
        self.formulation, self.code, self.variant, self.label = key.split("/", 3)
        self.sigma, self.runs = cell.get("sigma"), cell["runs"]
        ran = [run for run in self.runs if "failed" not in run]
        self.seconds = np.array([run["seconds"] for run in ran])
        self.errors = np.array([run["position"] for run in ran])
        self.steps = np.array([run["h"] for run in ran])

    @property
    def name(self) -> str:
        """For tables."""
        if self.code == "Exudyn":
            return f"Exudyn, {self.label}"
        return cases.sigma_name(self.label, self.sigma)

    def time_to(self, error: float) -> float:
        """CPU time [s] to this error, interpolated in logarithms; NaN where no run reaches it.

        Where already the largest step does, its time: an upper bound.
        """
        x, y = np.log(self.seconds), np.log(self.errors) - np.log(error)
        if len(y) and y[0] <= 0:
            return float(self.seconds[0])
        for i in range(len(y) - 1):  # from large steps to small ones
            if y[i] >= 0 >= y[i + 1]:
                return float(np.exp(np.interp(0.0, [y[i + 1], y[i]], [x[i + 1], x[i]])))
        return np.nan

    def milliseconds(self, error: float) -> str:
        """`time_to` for tables."""
        time = self.time_to(error)
        return "–" if np.isnan(time) else ("≤ " if self.errors[0] <= error else "") + f"{1e3 * time:.3g}"

    def rows(self) -> list[dict[str, Any]]:
        """For the CSV file."""
        own = {"code": self.code, "formulation": self.formulation, "variant": self.variant, "scheme": self.label}
        return [{**own, "sigma": self.sigma, **run} for run in self.runs]


STYLES = {
    ("full", "geom1"): (COLORS[5], "-"),
    ("full", "γ/(3β)"): (COLORS[2], "-"),
    ("full", "1"): (COLORS[0], "-"),
    ("full", "best"): (COLORS[1], "-"),
    ("simplified", "1"): (COLORS[0], ":"),
    ("modified", "1"): (COLORS[0], "--"),
}
"""Colour and line of what is drawn of ours; the rest is in the CSV file."""
PEER_MARKERS = {"geom1": "^", "σ-modified": "s", "Euler parameters": "v", "Tait-Bryan": "D"}


def _draw(path: Path, mechanism: str, curves: list[Curve]) -> None:
    formulations = cases.formulations(mechanism)
    with figure(path, (max(3.6 * len(formulations), 6.0), 4.6)) as result:
        handles: dict[str, Any] = {}
        row = result.subplots(1, len(formulations), squeeze=False, sharex=True, sharey=True)[0]
        for axes, formulation in zip(row, formulations, strict=True):
            for c in (c for c in curves if c.code == "Exudyn" and c.variant == "full" and len(c.steps)):
                marker = PEER_MARKERS[c.label]
                (line,) = axes.plot(c.seconds, c.errors, color="0.6", marker=marker, markersize=3, linewidth=0.8)
                handles[c.name] = line
            for c in curves:
                style = STYLES.get((c.variant, c.label))
                if c.code == "Exudyn" or c.formulation != FORMULATION_NAMES[formulation] or not style:
                    continue
                name = "best σ" if c.label == "best" else c.name
                name += "" if c.variant == "full" else f", {c.variant} Newton"
                color, line = style
                (handles[name],) = axes.plot(c.seconds, c.errors, line, color=color, marker="o", markersize=3)
            axes.set(xscale="log", yscale="log", xlabel="CPU time in s")
            axes.set_title(cases.formulation_title(mechanism, formulation))
        row[0].set_ylabel("position error in m")
        result.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)


def _tables(mechanism: str, curves: list[Curve]) -> str:
    ours = {(c.formulation, c.variant, c.label): c for c in curves if c.code != "Exudyn"}
    geom1 = ours[FORMULATION_NAMES[INDEX3], "full", "geom1"]
    middle = len(geom1.errors) // 2
    error = float(geom1.errors[middle])
    variants = [
        [name, cases.sigma_name(label), *(ours[name, v, label].milliseconds(error) for v in VARIANTS)]
        for name in dict.fromkeys(name for name, _, _ in ours)
        for label in SCHEMES["modified"]
    ]
    times = sorted((c for c in curves if not np.isnan(c.time_to(error))), key=lambda c: c.time_to(error))
    peer = min((c.time_to(error) for c in times if c.code == "Exudyn"), default=np.nan)
    ranking = [
        [c.name, c.formulation, c.variant, c.milliseconds(error), f"{peer / c.time_to(error):.1f}"]
        for c in times
        if c.code == "Exudyn" or c.variant == "full"
    ]
    return (
        f"CPU time [ms] to a position error of {error:.1e} m, which geom1 reaches in index 3 with "
        f"h = {geom1.steps[middle]:g} s. Newton's variants of ours:\n\n"
        + markdown_table(["formulation", "scheme", *VARIANTS], variants)
        + "\nEverything (ours with full Newton), the fastest first; *factor*: how many times faster than Exudyn at its "
        + "fastest.\n\n"
        + markdown_table(["scheme", "formulation", "Newton", "ms", "factor"], ranking)
    )


CHAPTER = WorkPrecision()
