"""Chapter: rkmk54 as a maker of reference solutions: its error against the independent ones over its tolerance."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from research.study import lgt, runs
from research.study.chapter import Cell, Results
from research.study.lgt import COMBINATIONS, METHODS, Combination, number
from research.study.output import figure, write_csv
from sigmafmu.markdown import markdown_table

STOP_TIMES = {"HeavyTop": 1.0, "HighSpeedRotor": 0.02, "SliderCrank": 2.0}  # s
QUICK_TIMES = {"HeavyTop": 0.5, "HighSpeedRotor": 0.005, "SliderCrank": 1.0}  # s
TOLERANCES = tuple(10.0**-i for i in range(4, 13))
QUICK_TOLERANCES = TOLERANCES[:7:3]
HALVINGS = 40  # of the longest step, which is the time between two samples
QUANTITIES = ("position", "velocity", "rotation", "multipliers")
HEADER = ("group", "map", "tolerance", "seconds", "steps", "retries", *QUANTITIES, "failed")


def adaptive(tolerance: float) -> dict[str, float]:
    """Settings of rkmk54 with one number for both tolerances."""
    tolerances = {"relative_tolerance": tolerance, "absolute_tolerance": tolerance}
    return {**METHODS["rkmk54"], **tolerances, "max_halvings": HALVINGS}


def tolerance_runs(
    mechanism: str, group: str, coordinate_map: str, tolerances: Sequence[float], stop_time: float, rounds: int
) -> dict[str, Any]:
    """Errors and CPU times [s] for each tolerance."""
    return {
        "runs": [
            _run(mechanism, {**adaptive(tolerance), **Combination(group, coordinate_map).settings}, stop_time, rounds)
            | {"tolerance": tolerance}
            for tolerance in tolerances
        ]
    }


def _run(mechanism: str, settings: Mapping[str, float], stop_time: float, rounds: int) -> dict[str, Any]:
    h = stop_time / runs.SAMPLES
    result = runs.ours(mechanism, h, stop_time, **settings)
    if "failed" in result:
        return result
    run = runs.simulation(mechanism, h, **settings)
    run.run(stop_time, runs.SAMPLES)
    result["retries"] = run.state.counters.retries
    result["seconds"] = runs.seconds(mechanism, h, stop_time, rounds, **settings)
    return result


class ReferenceMaker:
    """Error and time over the tolerance."""

    name = "lgt_rkmk54"
    title = "Local-global transition maps: rkmk54 as reference"
    mechanisms = tuple(STOP_TIMES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each group and map; they are timed, so they run alone."""
        times, tolerances = (QUICK_TIMES, QUICK_TOLERANCES) if quick else (STOP_TIMES, TOLERANCES)
        work = (tolerances, times[mechanism], 1 if quick else 5)
        return [
            Cell(f"{c.group}/{c.map}", tolerance_runs, (mechanism, c.group, c.map, *work), alone=True)
            for c in COMBINATIONS
        ]

    def report(self, results: Results, folder: Path) -> str:
        """A table for each mechanism and one figure."""
        write_csv(folder / "lgt_rkmk54.csv", _rows(results), ("mechanism", *HEADER))
        _draw(folder / "lgt_rkmk54.png", results)
        parts = [
            "Dormand and Prince's pair on Müller's (52)-(54), steps as long as its error control likes; one number for "
            "both tolerances, m/s and rad/s or relative. Errors against the independent solutions, largest over the "
            "run; multipliers where there are joints. Tables: R³×SO(3) and SE(3) with exp; the figure has all.\n\n"
            "![Error over tolerance and over CPU time](lgt_rkmk54.png)\n"
        ]
        for mechanism, found in results.items():
            parts.append(f"### {mechanism}\n\n{_table(found)}")
        return "\n".join(parts)


def errors(cell: Mapping[str, Any], quantity: str = "position") -> np.ndarray:
    """One for each tolerance; NaN where the run failed."""
    return np.array([run.get(quantity, np.nan) for run in cell["runs"]])


def _rows(results: Results) -> list[dict[str, Any]]:
    rows = []
    for mechanism, found in results.items():
        for key, cell in found.items():
            group, coordinate_map = key.split("/")
            rows += [{"mechanism": mechanism, "group": group, "map": coordinate_map, **run} for run in cell["runs"]]
    return rows


def _table(found: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for group in lgt.GROUPS:
        for run in found[f"{group}/exp"]["runs"]:
            figures = [number(run.get(quantity, np.nan)) if quantity in run else "–" for quantity in QUANTITIES]
            cost = (
                [f"{run['steps']}, {run['retries']}", f"{1e3 * run['seconds']:.3g}"] if "seconds" in run else ["–"] * 2
            )
            rows.append([Combination(group, "exp").name, f"{run['tolerance']:.0e}", *figures, *cost])
    units = [f"{quantity} [{runs.ERRORS[quantity]}]" for quantity in QUANTITIES]
    return markdown_table(["group, map", "tolerance", *units, "steps, rejected", "ms"], rows)


def _draw(path: Path, results: Results) -> None:
    """Mechanisms across; above position error over tolerance, below over CPU time."""
    with figure(path, (3.6 * len(results) + 0.4, 6.0)) as result:
        grid = result.subplots(2, len(results), squeeze=False, sharey="col")
        for (above, below), (mechanism, found) in zip(grid.T, results.items(), strict=True):
            for c in COMBINATIONS:
                cell = found[f"{c.group}/{c.map}"]
                seconds = errors(cell, "seconds")
                above.plot([run["tolerance"] for run in cell["runs"]], errors(cell), **c.style)
                below.plot(seconds, errors(cell), **c.style)
            above.set(title=mechanism, xscale="log", yscale="log", xlabel="tolerance")
            above.invert_xaxis()
            below.set(xscale="log", yscale="log", xlabel="CPU time in s")
        for axes in grid[:, 0]:
            axes.set_ylabel("position error in m")
        result.legend(handles=lgt.legend_handles(), loc="outside lower center", ncols=6, fontsize=8)


CHAPTER = ReferenceMaker()
