"""Chapter: CPU time to an accuracy for every method, group and map, beside Exudyn's fastest ways."""

from pathlib import Path
from typing import Any

import numpy as np

from research.measure import FORMULATION_NAMES, MULTIPLIERS
from research.study import cases, lgt
from research.study.cases import CASES, PEER_SCHEMES
from research.study.chapter import Cell, Results
from research.study.iterations import PEER_VARIANTS
from research.study.lgt import COMBINATIONS, METHODS, Combination
from research.study.lgt_rkmk54 import TOLERANCES, tolerance_runs
from research.study.output import figure, write_csv
from research.study.work_precision import Curve, work, work_peer
from sigmafmu.markdown import markdown_table

PEER_WAYS = (
    "index 3/full/σ-modified",
    "index 2/full/σ-modified",
    "index 3/modified/σ-modified",
    "index 2/modified/σ-modified",
    "index 2/full/Euler parameters",
    "index 2/full/Tait-Bryan",
)
"""Of Exudyn: what is fastest on some mechanism in the chapter `work_precision`."""
ROUNDS = 3
FINE = 1e-4
"""The second accuracy, over the first."""
HEADER = ("code", "method", "group", "map", "h", "tolerance", "steps", "seconds", "position", "velocity", "failed")


class LgtWork:
    """Work-precision diagrams of the methods on all groups and maps."""

    name = "lgt_work"
    title = "Local-global transition maps: work and precision"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each curve; they are timed, so they run alone."""
        case = CASES[mechanism]
        stop_time, rounds = case.time(quick, short=True), 1 if quick else ROUNDS
        common = (mechanism, case.steps(quick), stop_time, rounds)
        result = []
        for method in lgt.methods(bool(MULTIPLIERS[mechanism])):
            for c in COMBINATIONS:
                key = f"{method}/sigmafmu/{c.group}/{c.map}"
                if method == "rkmk54":
                    tolerances = TOLERANCES[:5:2] if quick else TOLERANCES
                    arguments = (mechanism, c.group, c.map, tolerances, stop_time, rounds)
                    result.append(Cell(key, tolerance_runs, arguments, alone=True))
                else:
                    result.append(Cell(key, work, (*common, 1.0, {**METHODS[method], **c.settings}), alone=True))
        for way in PEER_WAYS[: 2 if quick else None]:
            name, variant, label = way.split("/")
            formulation = next(f for f in PEER_SCHEMES if FORMULATION_NAMES[f] == name)
            settings = cases.peer_settings(mechanism, formulation, label, **PEER_VARIANTS[variant])
            result.append(Cell(f"{name}/Exudyn/{variant}/{label}", work_peer, (*common, settings), alone=True))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A diagram and tables for each mechanism."""
        parts = [
            "CPU time of a whole run without output against the largest position error; default settings, every point "
            "one step size (rkmk54: one tolerance), nothing else of the study running. Grey: Exudyn, in the ways that "
            "are fastest in *Work and precision*, in the same run. Tables: time [ms] to one accuracy, interpolated; ≤: "
            "the largest step is good enough already; –: not reached.\n"
        ]
        for mechanism, found in results.items():
            curves = [Curve(key, cell) for key, cell in found.items()]  # of ours: method, code, group, map
            write_csv(folder / f"lgt_work_{mechanism}.csv", _rows(curves), HEADER)
            image = f"lgt_work_{mechanism}.png"
            _draw(folder / image, mechanism, curves)
            parts.append(f"### {mechanism}\n\n![{mechanism}: error over CPU time]({image})\n")
            parts.append(_tables(curves))
        return "\n".join(parts)


def _rows(curves: list[Curve]) -> list[dict[str, Any]]:
    return [
        {"code": c.code, "method": c.formulation, "group": c.variant, "map": c.label, **run}
        for c in curves
        for run in c.runs
    ]


def _peers(curves: list[Curve]) -> list[Curve]:
    return [c for c in curves if c.code == "Exudyn" and len(c.steps)]


def _draw(path: Path, mechanism: str, curves: list[Curve]) -> None:
    """Methods across."""
    names = lgt.methods(bool(MULTIPLIERS[mechanism]))
    ours = {(c.formulation, c.variant, c.label): c for c in curves if c.code != "Exudyn"}
    with figure(path, (2.5 * len(names) + 0.6, 4.0)) as result:
        row = result.subplots(1, len(names), squeeze=False, sharex=True, sharey=True)[0]
        for axes, method in zip(row, names, strict=True):
            for peer in _peers(curves):
                axes.plot(peer.seconds, peer.errors, color="0.7", linewidth=0.8, marker=".", markersize=3)
            for c in COMBINATIONS:
                curve = ours[method, c.group, c.map]
                axes.plot(curve.seconds, curve.errors, **c.style)
            axes.set(xscale="log", yscale="log", xlabel="CPU time in s", title=method.replace(", ", ",\n"))
        row[0].set_ylabel("position error in m")
        result.legend(handles=lgt.legend_handles(), loc="outside lower center", ncols=6, fontsize=8)


def _tables(curves: list[Curve]) -> str:
    ours = {(c.formulation, c.variant, c.label): c for c in curves if c.code != "Exudyn"}
    names = list(dict.fromkeys(method for method, *_ in ours))
    default = ours["generalizedAlpha", "R3xSO3", "exp"]
    coarse = float(default.errors[len(default.errors) // 2])
    parts = []
    for error in (coarse, FINE * coarse):
        rows = [
            [c.table1, c.name, *(ours[method, c.group, c.map].milliseconds(error) for method in names)]
            for c in COMBINATIONS
        ]
        reached = [c for c in _peers(curves) if not np.isnan(c.time_to(error))]
        peer = min(reached, key=lambda c: c.time_to(error), default=None)
        verdict = "Exudyn does not reach it with these steps."
        if peer:
            best = min((c for c in ours.values() if not np.isnan(c.time_to(error))), key=lambda c: c.time_to(error))
            fastest = f"{best.formulation} on {Combination(best.variant, best.label).name}"
            verdict = (
                f"Exudyn at its fastest: {peer.milliseconds(error)} ms ({peer.label}, {peer.formulation}, "
                f"{peer.variant} Newton), {peer.time_to(error) / default.time_to(error):.1f} times the default's "
                f"time, {peer.time_to(error) / best.time_to(error):.1f} times that of {fastest}."
            )
        table = markdown_table(["Table 1", "group, map", *names], rows)
        parts.append(f"Position error {error:.1e} m:\n\n{table}\n{verdict}\n")
    return "\n".join(parts)


CHAPTER = LgtWork()
