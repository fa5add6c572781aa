"""Time that codes need to reach an error, against converged solutions that share nothing with ours."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from research.bench import Effort, runs
from research.bench.trees import pinocchio_model
from research.mechanisms import named
from research.reference import chain
from research.reference.minimal_coordinates import solve
from research.study.output import figure
from sigmafmu import SigmafmuError, _core
from sigmafmu.markdown import markdown_table

TITLE = "Time to an error"
FILE = "work.csv"
FIGURE = "work.png"
TARGETS = (1e-4, 1e-6, 1e-8)  # m
FINEST = 3e-9
"""No finer steps after an error below this one, m."""


@dataclass(frozen=True)
class Case:
    """A mechanism and the largest step of all methods."""

    name: str
    stop_time: float  # s
    largest: float  # s
    rho_inf: float
    sigma: float  # near the best of index 3
    point: tuple[float, float, float]
    exact: Callable[[float], np.ndarray]  # of the point at a time

    def mechanism(self) -> _core.Mechanism:
        """A fresh one."""
        return _core.mechanism(self.name) if self.name in _core.mechanisms() else named(self.name)


def _top(time: float) -> np.ndarray:
    history = solve("HeavyTop", np.array([0.0, time]))
    return np.array([history[f"top.position[{i}]"][-1] for i in (1, 2, 3)])


def _arm(time: float) -> np.ndarray:
    """DOP853 on the accelerations of Pinocchio's articulated-body algorithm."""
    import pinocchio as pin

    model, v = pinocchio_model(named("RevoluteArm7").multibody)
    data, n = model.createData(), model.nv

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[n:], pin.aba(model, data, y[:n], y[n:], np.zeros(n))])

    start = np.concatenate([np.zeros(n), v])
    end = solve_ivp(rates, (0.0, time), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    pin.forwardKinematics(model, data, end[:n])
    return data.oMi[n].act(model.inertias[n].lever)


CASES = (
    Case("HeavyTop", 1.0, 1e-3, 0.65, 1.6, (0.0, 0.0, 0.0), _top),
    Case("Chain10", 0.5, 1e-2, 0.9, 1.0, (0.5, 0.0, 0.0), partial(chain.tip, 10)),
    Case("RevoluteArm7", 0.5, 1e-2, 0.9, 1.0, (0.0, 0.0, 0.0), _arm),
)


@dataclass(frozen=True)
class Method:
    """A code with its settings, and the order of its errors."""

    label: str
    order: int
    run: Callable[[float, int], runs.Run]  # of a step size and a number of steps
    most_steps: int = 10**7


def _methods(case: Case) -> list[Method]:
    definition, point = case.mechanism().multibody, np.array(case.point)

    def ours(label: str, order: int = 2, **settings: Any) -> Method:
        settings = {"spectral_radius": case.rho_inf, **settings}
        return Method(label, order, lambda h, n: runs.core(case.mechanism(), h, n, point, **settings))

    methods = [ours("ours, default"), ours("ours, index 3", formulation=1)]
    if case.sigma != 1.0:
        methods.append(ours(f"ours, index 3, σ = {case.sigma:g}", formulation=1, sigma=case.sigma))
    aba = runs.pinocchio_aba(definition)
    return [
        *methods,
        ours("ours, rkmk4", 4, method=2),
        ours("ours, rkmk54", 5, method=3),
        Method(
            "Exudyn, σ-modified",
            2,
            lambda h, n: runs.exudyn(
                case.name if case.name in _core.mechanisms() else definition,
                h,
                n,
                point,
                rho_inf=case.rho_inf,
                modified=len(definition.bodies) > 1,
                sparse=len(definition.bodies) > 1,
            ),
        ),
        Method("MuJoCo, RK4", 4, lambda h, n: runs.mujoco(definition, h, n, point, "RK4")),
        Method("Pinocchio, RK4", 4, lambda h, n: runs.pinocchio_rk4(definition, h, n, point, aba), most_steps=10**4),
    ]


def measure(effort: Effort) -> list[dict[str, Any]]:
    """A row for each step size of each method."""
    budget = 0.1 if effort.quick else 3.0  # s of a run
    rows = []
    for case in CASES[:1] if effort.quick else CASES:
        effort.tell(f"{case.name}: time to an error")
        exact = case.exact(case.stop_time)
        for method in _methods(case):
            rows += [{"mechanism": case.name, **row} for row in _series(case, method, exact, budget)]
    return rows


def _series(case: Case, method: Method, exact: np.ndarray, budget: float) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    steps = round(case.stop_time / case.largest)
    while steps <= method.most_steps:
        h = case.stop_time / steps
        try:
            tries = [method.run(h, steps)]
        except Exception as error:  # steps that are too long: each code has errors of its own for them
            if rows:
                raise SigmafmuError(f"{method.label} fails on {case.name} at h = {h:g} s: {error}") from error
            steps *= 2
            continue
        if tries[0].seconds * steps < 0.1 * budget:
            tries += [method.run(h, steps) for _ in range(2)]
        seconds = steps * min(run.seconds for run in tries)
        error = float(np.linalg.norm(tries[0].position - exact))
        rows.append({"method": method.label, "order": method.order, "h": h, "ms": 1e3 * seconds, "error": error})
        if error < FINEST or 2 * seconds > budget:
            break
        steps *= 2
    return rows


def milliseconds_to(series: list[dict[str, Any]], target: float) -> tuple[str, float]:
    """Time to an error, and how it was found.

    "": between two runs; "≈": from the last one on by the order of the method, if its error still falls like that; "<":
    the first run is better; NaN where errors do not fall.
    """
    if not series:
        return "", np.nan
    if series[0]["error"] <= target:
        return "< ", series[0]["ms"]
    for coarse, fine in pairwise(series):
        if fine["error"] <= target:
            part = np.log(coarse["error"] / target) / np.log(coarse["error"] / fine["error"])
            return "", coarse["ms"] * (fine["ms"] / coarse["ms"]) ** part
    if len(series) < 2:
        return "", np.nan
    before, last = series[-2:]
    order = last["order"]
    if before["error"] / last["error"] < 2 ** (order - 0.5):
        return "", np.nan
    return "≈ ", last["ms"] * (last["error"] / target) ** (1 / order)


def time_to(series: list[dict[str, Any]], target: float) -> str:
    """Milliseconds to an error; a dash where errors do not fall."""
    how, ms = milliseconds_to(series, target)
    return "–" if np.isnan(ms) else f"{how}{ms:.2g}"


def report(rows: list[dict[str, Any]], folder: Path) -> str:
    """Figure and table."""
    names = list(dict.fromkeys(row["mechanism"] for row in rows))
    _draw(rows, names, folder / FIGURE)
    parts = [
        "Position of the top, of the chain's tip and of the arm's last link at the end, with constant steps that are "
        "halved again and again. The references are DOP853 in minimal coordinates, at 1e-12. ≈ goes on from the "
        "smallest error that was reached by the method's order; a dash is where errors stop to fall. rkmk54 takes the "
        "steps that its tolerances ask for, at most these.\n\n"
        f"![Error over time]({folder.name}/{FIGURE})\n"
    ]
    for case in CASES:
        mine = [row for row in rows if row["mechanism"] == case.name]
        if not mine:
            continue
        lines = []
        for method in dict.fromkeys(row["method"] for row in mine):
            series = [row for row in mine if row["method"] == method]
            lines.append([method, *(time_to(series, target) for target in TARGETS)])
        header = (f"{case.name}, {case.stop_time:g} s: ms to", *(f"{target:.0e} m" for target in TARGETS))
        parts.append("\n" + markdown_table(header, lines))
    return "".join(parts)


def _draw(rows: list[dict[str, Any]], names: list[str], path: Path) -> None:
    colors = list(dict.fromkeys(row["method"] for row in rows))
    with figure(path, (4.0 * len(names), 4.2)) as drawing:
        every = drawing.subplots(1, len(names), squeeze=False)[0]
        for axes, name in zip(every, names, strict=True):
            mine = [row for row in rows if row["mechanism"] == name]
            for method in dict.fromkeys(row["method"] for row in mine):
                series = [row for row in mine if row["method"] == method]
                color = f"C{colors.index(method)}"
                style = "o-" if method.startswith("ours") else "s--"
                times, errors = ([row[key] for row in series] for key in ("ms", "error"))
                axes.loglog(times, errors, style, color=color, markersize=3, label=method)
            axes.set(xlabel="ms", title=name)
        every[0].set_ylabel("position error [m]")
        every[0].legend(fontsize=7)
