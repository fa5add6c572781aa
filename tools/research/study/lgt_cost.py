"""Chapter: what an internal step costs with every method, group, map and absolute coordinates."""

from collections.abc import Mapping
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from research.measure import MULTIPLIERS
from research.study import lgt, runs
from research.study.chapter import Cell, Results
from research.study.lgt import ABSOLUTE, COMBINATIONS, DEFAULT, METHODS, Combination
from research.study.output import figure, write_csv
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

STEPS = {"HeavyTop": 1e-3, "HighSpeedRotor": 1e-5, "SliderCrank": 1e-3}  # s
COUNT, QUICK_COUNT = 1000, 200  # steps of a run
ROUNDS, QUICK_ROUNDS = 9, 2
EVERY = [Combination(c.group, c.map, a) for a in ABSOLUTE for c in COMBINATIONS]
MEASURED = ("microseconds", "iterations", "jacobians")
HEADER = ("mechanism", "method", "group", "map", "absolute", "table1", "ratio", *MEASURED)


def step_costs(mechanism: str, count: int, rounds: int) -> dict[str, Any]:
    """By method, in the order of EVERY: median CPU time [µs], iterations and matrices of a step.

    All methods and combinations take turns, so that what else the machine does meets them alike; the first round only
    warms up.
    """
    h = STEPS[mechanism]
    jobs = [(method, c) for method in lgt.methods(bool(MULTIPLIERS[mechanism])) for c in EVERY]
    times: dict[tuple[str, Combination], list[float]] = {job: [] for job in jobs}
    result: dict[str, Any] = {method: {name: [] for name in MEASURED} for method, _ in jobs}
    for _ in range(rounds + 1):
        for method, c in jobs:
            run = _simulation(mechanism, h, method, c)
            start = process_time()
            run.run(count * h, count)
            times[method, c].append(process_time() - start)
    for method, c in jobs:
        run = _simulation(mechanism, h, method, c)
        run.run(count * h, count)
        counters = run.state.counters
        found = (
            1e6 * median(times[method, c][1:]) / count,
            counters.newton_iterations / counters.steps,
            counters.jacobian_evaluations / counters.steps,
        )
        for name, value in zip(MEASURED, found, strict=True):
            result[method][name].append(value)
    return result


def _simulation(mechanism: str, h: float, method: str, combination: Combination) -> _core.Simulation:
    settings = {**METHODS[method], **(lgt.FIXED_STEPS if method == "rkmk54" else {})}
    return runs.simulation(mechanism, h, **settings, **combination.settings)


class Cost:
    """CPU time of a step."""

    name = "lgt_cost"
    title = "Local-global transition maps: cost of a step"
    mechanisms = tuple(STEPS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each mechanism: what is compared is measured together, and alone."""
        work = (QUICK_COUNT, QUICK_ROUNDS) if quick else (COUNT, ROUNDS)
        return [Cell("steps", step_costs, (mechanism, *work), alone=True)]

    def report(self, results: Results, folder: Path) -> str:
        """A table for each mechanism and one figure."""
        found = {mechanism: cells["steps"] for mechanism, cells in results.items()}
        write_csv(folder / "lgt_cost.csv", _rows(found), HEADER)
        _draw(folder / "lgt_cost.png", found)
        parts = [
            "Median CPU time of an internal step with the default settings, in units of the default combination "
            "(generalizedAlpha, R³×SO(3), exp, quaternion); everything takes turns in one process. rkmk54 with fixed "
            "steps. Second table, with quaternions: Newton iterations and matrices factorized per step; for the "
            "explicit methods iterations of the projection, and accelerations evaluated (a small linear system each) "
            "with those of the projection.\n\n![CPU time of a step](lgt_cost.png)\n"
        ]
        for mechanism, cell in found.items():
            parts.append(f"### {mechanism}\n\n{_tables(mechanism, cell)}")
        return "\n".join(parts)


def _rows(found: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    rows = []
    for mechanism, by_method in found.items():
        for method, measured in by_method.items():
            for i, c in enumerate(EVERY):
                own = {"mechanism": mechanism, "method": method, "group": c.group, "map": c.map, "absolute": c.absolute}
                row = {name: measured[name][i] for name in MEASURED}
                rows.append({**own, "table1": c.table1, "ratio": ratio(by_method, method, i), **row})
    return rows


def ratio(by_method: Mapping[str, Any], method: str, i: int) -> float:
    """Time of a step over that of the default combination."""
    return by_method[method]["microseconds"][i] / default(by_method)


def default(by_method: Mapping[str, Any]) -> float:
    """Time [µs] of a step of the default combination."""
    return by_method["generalizedAlpha"]["microseconds"][EVERY.index(DEFAULT)]


def _tables(mechanism: str, by_method: Mapping[str, Any]) -> str:
    times, counts = [], []
    for i, c in enumerate(EVERY):
        times.append([c.table1, c.name, c.absolute, *(f"{ratio(by_method, method, i):.2f}" for method in by_method)])
        if c in COMBINATIONS:
            entries = (f"{m['iterations'][i]:.2f}, {m['jacobians'][i]:.2f}" for m in by_method.values())
            counts.append([c.table1, c.name, *entries])
    return (
        f"1 is {default(by_method):.2f} µs, h = {STEPS[mechanism]:g} s.\n\n"
        + markdown_table(["Table 1", "group, map", "absolute", *by_method], times)
        + "\nIterations, matrices per step:\n\n"
        + markdown_table(["Table 1", "group, map", *by_method], counts)
    )


def _draw(path: Path, found: Mapping[str, Mapping[str, Any]]) -> None:
    """Mechanisms across; a dot for each combination, hollow with rotation vectors."""
    with figure(path, (3.4 * len(found) + 1.0, 4.2)) as result:
        row = result.subplots(1, len(found), squeeze=False)[0]
        for axes, (mechanism, by_method) in zip(row, found.items(), strict=True):
            for line, method in enumerate(by_method):
                for i, c in enumerate(EVERY):
                    offset = 0.1 * (i % len(COMBINATIONS) - 2.5)
                    style = {**c.style, "linestyle": "none", "markersize": 5}
                    if c.absolute == "rotationVector":
                        style["fillstyle"] = "none"
                    axes.plot(ratio(by_method, method, i), line + offset, **style)
            axes.axvline(1.0, color="0.6", linewidth=0.8)
            axes.set_yticks(range(len(by_method)), [method.replace(", ", ",\n") for method in by_method])
            title = f"{mechanism}, 1 = {default(by_method):.1f} µs"
            axes.set(title=title, xlabel="CPU time of a step / default", xlim=(0, None))
            axes.invert_yaxis()
        handles = lgt.legend_handles()
        for handle in handles:
            handle.set_linestyle("none")
        result.legend(handles=handles, loc="outside lower center", ncols=6, fontsize=8, title="hollow: rotationVector")


CHAPTER = Cost()
