"""Chapter: flexible bodies, CPU time to an accuracy and cost of a step, beside Exudyn in the same run."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import INDEX2, INDEX3, STABILIZED
from research.reference.exudyn_models import Settings, simulate
from research.study import runs
from research.study.chapter import Cell, Results
from research.study.flexible_runs import CASES, PEERS, RHO_INF, SAMPLES, ours, peer
from research.study.lgt import number
from research.study.lgt_rkmk54 import adaptive
from research.study.output import figure, write_csv
from research.study.work_precision import Curve as Times
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

ROUNDS = 5
WAYS: dict[str, dict[str, float]] = {
    "stabilized index 2": {"formulation": STABILIZED},
    "index 2": {"formulation": INDEX2},
    "index 3": {"formulation": INDEX3},
    "stabilized, simplified Newton": {"formulation": STABILIZED, "jacobian": 2},
    "stabilized, modified Newton": {"formulation": STABILIZED, "newton": 2},
    "bliedf2": {"method": 4},
    "rkmk4": {"method": 2},
    "rkmk54": {"method": 3},
}
"""Methods of ours; generalizedAlpha with σ = 1 unless named otherwise."""
TOLERANCES = tuple(10.0**-i for i in range(3, 13))
"""Of rkmk54, relative and absolute; its steps go up to the distance of samples."""
PEER_WAYS = {
    **PEERS,
    "index 2, Euler parameters, modified Newton": {**PEERS["index 2, Euler parameters"], "modified_newton": True},
    "index 3, σ-modified, modified Newton": {**PEERS["index 3, σ-modified"], "modified_newton": True},
}
MECHANISMS = ("FlexiblePendulum", "FlexibleSliderCrank")
"""SpinUpBeam has its torque from Python in both codes, which costs more than the step."""
FINE = 1 / 50
"""The second accuracy, over the first."""
HEADER = (
    "code",
    "method",
    "h",
    "tolerance",
    "steps",
    "seconds",
    "position",
    "modal",
    "iterations",
    "jacobians",
    "failed",
)


def work(mechanism: str, steps: Sequence[float], stop_time: float, rounds: int, settings: dict[str, float]) -> Any:
    """A cell: errors and times of ours with all `steps`."""
    found = [ours(mechanism, h, stop_time, **settings) for h in steps]
    for run in found:
        if "failed" not in run:
            run["seconds"] = _seconds(mechanism, run["h"], stop_time, rounds, settings)
    return {"runs": found}


def work_tolerances(mechanism: str, h: float, stop_time: float, rounds: int, tolerances: Sequence[float]) -> Any:
    """A cell: errors and times of rkmk54 with steps up to h."""
    found = []
    for tolerance in tolerances:
        settings = adaptive(tolerance)
        run = {**ours(mechanism, h, stop_time, **settings), "tolerance": tolerance}
        if "failed" not in run:
            run["seconds"] = _seconds(mechanism, h, stop_time, rounds, settings)
        found.append(run)
    return {"runs": found}


def _seconds(mechanism: str, h: float, stop_time: float, rounds: int, settings: dict[str, float]) -> float:
    return runs.seconds(mechanism, h, stop_time, rounds, spectral_radius=RHO_INF, **settings)


def work_peer(mechanism: str, steps: Sequence[float], stop_time: float, rounds: int, settings: dict[str, Any]) -> Any:
    """A cell: errors and times of Exudyn with all `steps`."""
    found = [peer(mechanism, h, stop_time, **settings) for h in steps]
    for run in found:
        if "failed" not in run:
            chosen, build = Settings(run["h"], rho_inf=RHO_INF, **settings), CASES[mechanism].build
            taken: list[float] = []
            while len(taken) < rounds and sum(taken) < runs.ENOUGH:
                taken.append(simulate(mechanism, chosen, stop_time, build=build).cpu_time)
            run["seconds"] = min(taken)
    return {"runs": found}


class FlexibleWork:
    """Work-precision diagrams, cost of a step, Newton iterations."""

    name = "flexible_work"
    title = "Flexible bodies: work and precision"
    mechanisms = MECHANISMS

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each curve; they are timed, so they run alone."""
        case = CASES[mechanism]
        stop_time, rounds = case.time(quick), 1 if quick else ROUNDS
        common = (mechanism, case.steps(quick), stop_time, rounds)
        result = []
        for name, settings in WAYS.items():
            if name == "rkmk54":
                arguments = (mechanism, stop_time / SAMPLES, stop_time, rounds, TOLERANCES[:: 3 if quick else 1])
                result.append(Cell(f"{name}/sigmafmu//", work_tolerances, arguments, alone=True))
            else:
                result.append(Cell(f"{name}/sigmafmu//", work, (*common, settings), alone=True))
        for name, settings in list(PEER_WAYS.items())[:: 3 if quick else 1]:
            result.append(Cell(f"{name}/Exudyn//", work_peer, (*common, settings), alone=True))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A figure, then tables for each mechanism."""
        parts = [
            "CPU time of a whole run without output against the largest error of the followed point; every point one "
            "step size (rkmk54: one tolerance), the fastest of some rounds, nothing else running. Exudyn's weight is "
            "a force on the mean of all nodes, its own way to gravity being incomplete for flexible bodies; that makes "
            "less than a tenth of its steps' cost.\n\n![Error over CPU time](flexible_work.png)\n"
        ]
        write_csv(folder / "flexible_work.csv", _rows(results), ("mechanism", *HEADER))
        curves = {mechanism: _curves(cells) for mechanism, cells in results.items()}
        _draw(folder / "flexible_work.png", curves)
        parts += [f"### {mechanism}\n\n{_tables(found)}" for mechanism, found in curves.items()]
        return "\n".join(parts)


def _curves(cells: Mapping[str, Any]) -> dict[str, Times]:
    return {key: Times(key, cell) for key, cell in cells.items()}


def _rows(results: Results) -> list[dict[str, Any]]:
    rows = []
    for mechanism, cells in results.items():
        for curve in _curves(cells).values():
            rows += [{"mechanism": mechanism, "code": curve.code, "method": curve.formulation, **r} for r in curve.runs]
    return rows


def _tables(curves: Mapping[str, Times]) -> str:
    default = next(iter(curves.values()))
    middle = len(default.errors) // 2
    errors = [float(default.errors[middle]), FINE * float(default.errors[middle])]
    peers = [c for c in curves.values() if c.code == "Exudyn"]
    best = min((c.time_to(errors[0]) for c in peers if not np.isnan(c.time_to(errors[0]))), default=np.nan)
    rows = []
    for c in curves.values():
        ran = [run for run in c.runs if "seconds" in run]
        if not ran:
            rows.append([c.code, c.formulation, "fails", *["–"] * 6])
            continue
        run = ran[len(ran) // 2]
        cost = 1e6 * run["seconds"] / run["steps"]
        cells = [f"{cost:.3g}", f"{run['iterations']:.2f}", f"{run['jacobians']:.2f}", number(run["position"])]
        step = f"{run['tolerance']:.0e} (tolerance)" if "tolerance" in run else f"{run['h']:g}"
        rows.append([c.code, c.formulation, step, *cells, *(c.milliseconds(e) for e in errors)])
    ratio = best / default.time_to(errors[0])
    header = ["code", "method", "h, s", "µs per step", "iterations", "matrices", "error, m"]
    return (
        "Cost of a step, and CPU time [ms] to two errors (–: not reached with these steps, ≤: the largest step is good "
        "enough). Iterations and matrices are per step; the explicit methods count iterations of the projection and "
        "evaluated accelerations.\n\n"
        + markdown_table([*header, *(f"ms to {e:.1e} m" for e in errors)], rows)
        + f"\nTo {errors[0]:.1e} m the fastest of Exudyn's ways takes {ratio:.1f} times the time of the default.\n"
    )


def _draw(path: Path, curves: Mapping[str, Mapping[str, Times]]) -> None:
    with figure(path, (4.4 * max(len(curves), 2), 4.6)) as result:
        row = result.subplots(1, len(curves), squeeze=False)[0]
        handles: dict[str, Any] = {}
        for axes, (mechanism, found) in zip(row, curves.items(), strict=True):
            for c in (c for c in found.values() if c.code == "Exudyn" and len(c.steps)):
                style = {"color": "0.6", "linewidth": 0.8, "marker": "s", "markersize": 3}
                (handles["Exudyn"],) = axes.plot(c.seconds, c.errors, **style)
            for color, name in zip(COLORS, WAYS, strict=True):
                c = found[f"{name}/sigmafmu//"]
                style = {"color": color, "marker": "o", "markersize": 3}
                (handles[name],) = axes.plot(c.seconds, c.errors, **style)
            axes.set(xscale="log", yscale="log", xlabel="CPU time in s", title=mechanism)
        row[0].set_ylabel("error of the followed point in m")
        result.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)


CHAPTER = FlexibleWork()
