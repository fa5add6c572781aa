"""Chapter: long runs. What energy and constraints do after many revolutions.

Energy error: the heavy top and the slider-crank keep their energy. The rotor does not, so what the dampers take and the
torque gives (trapezoidal rule over all steps) is taken off. Both are divided by the largest kinetic energy. Φ is the
largest constraint residual, in m or rad, dΦ/dt its rate. Steps that fail are halved, as in an FMU; a run *fails* when
that does not help, or when the energy error is as large as the largest kinetic energy or not finite.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from research.measure import FORMULATION_NAMES, INCREMENTAL, INDEX3, MULTIPLIERS, RESIDUAL
from research.reference import Rotor
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from research.study.runs import rotations, simulation
from research.study.stability import angular_velocity, largest_kinetic_energy
from sigmafmu import _core
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS


@dataclass(frozen=True)
class Length:
    """How far and how finely a mechanism runs."""

    step_size: float  # s
    stop_time: float  # s
    quick_time: float  # s


LENGTHS = {
    "HeavyTop": Length(1e-3, 100.0, 4.0),
    "HighSpeedRotor": Length(2e-5, 20.0, 0.2),
    "SliderCrank": Length(1e-3, 100.0, 4.0),
}
SAMPLES = 500
"""Stretches of a run; the histories have the largest value of each."""
DRAWN = 10  # of them make one point of a curve
STRIDE = 20  # steps between the states that are looked at
PART = 20_000  # steps whose states are in memory
RHO_INF = (1.0, 0.9, 0.5)
CORRECTORS = {RESIDUAL: "residual", INCREMENTAL: "incremental"}
HALVINGS = 10  # of a step that fails, the FMU's default
QUANTITIES = {"energy": "energy error", "phi": "Φ", "phidot": "dΦ/dt"}
FLOOR = 1e-17  # of the figures: exact zeros have no place on a logarithmic axis


def long_run(mechanism: str, formulation: int, corrector: int, rho_inf: float, stop_time: float) -> dict[str, Any]:
    """Histories of the largest errors in each stretch: time [s], energy, phi, phidot; "failed" says why it ended early.

    σ = 1. Retries are attempts at steps that were then halved.
    """
    h = LENGTHS[mechanism].step_size
    run = simulation(
        mechanism,
        h,
        formulation=formulation,
        corrector=corrector,
        spectral_radius=rho_inf,
        max_halvings=HALVINGS,
    )
    balance = _Balance(mechanism, run.state)
    steps = round(stop_time / h / SAMPLES)
    result: dict[str, Any] = {"time": [], **{name: [] for name in QUANTITIES}}
    for i in range(1, SAMPLES + 1):
        end = stop_time * i / SAMPLES
        try:
            found = _stretch(run, balance, end, steps)
        except RuntimeError as error:
            result["failed"] = str(error)
            break
        if not found[0] < 1.0:
            result["failed"] = f"energy has doubled at t = {end:g}"
            break
        for name, value in zip(result, (end, *found), strict=True):
            result[name].append(float(value))
    return {**result, "retries": run.state.counters.retries}


def _stretch(run: _core.Simulation, balance: "_Balance", end: float, steps: int) -> np.ndarray:
    """Largest energy error, Φ and dΦ/dt up to `end`, in parts."""
    begin, parts = run.state.time, -(-steps // PART)
    found = [
        balance.errors(*run.trajectory(begin + (end - begin) * k / parts, steps // parts)[:3])
        for k in range(1, parts + 1)
    ]
    return np.max(found, axis=0)  # a NaN stays


class _Balance:
    """Energy and constraints along a run that begins at `state`; takes its parts one after the other."""

    def __init__(self, mechanism: str, state: _core.State) -> None:
        self.system = _core.System(_core.mechanism(mechanism).multibody)
        self.power = _rotor_power if mechanism == "HighSpeedRotor" else None
        self.scale = largest_kinetic_energy(mechanism)
        self.expected = self.system.energy(state.q, state.v)

    def errors(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[float, float, float]:
        """Energy error over the largest kinetic energy, Φ, dΦ/dt: the largest at every STRIDE-th step of a part."""
        work = np.zeros(len(t))
        if self.power:
            power = self.power(q, v)
            work[1:] = np.cumsum(np.diff(t) * (power[1:] + power[:-1]) / 2)
        found = []
        for i in range(len(t) - 1, 0, -STRIDE):
            phi, phidot, _, _ = self.system.constraints(q[i], v[i])
            energy = self.system.energy(q[i], v[i]) - work[i]
            found.append((abs(energy - self.expected), np.abs(phi).max(initial=0), np.abs(phidot).max(initial=0)))
        self.expected += work[-1]
        energy, phi, phidot = np.max(found, axis=0)
        return energy / self.scale, phi, phidot


def _rotor_power(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """What the rotor's torque gives and its dampers take, W, for each row."""
    rotor = Rotor()
    turn = rotations(q[:, 3:7])
    taken = np.zeros(len(q))
    for x, axes in ((-rotor.left, slice(0, 3)), (rotor.right, slice(1, 3))):
        point = v[:, :3] + turn.apply(np.cross(v[:, 3:6], [x, 0.0, 0.0]))
        taken += rotor.damping * (point[:, axes] ** 2).sum(axis=1)
    return turn.apply(v[:, 3:6]) @ rotor.torque - taken


def _formulations(mechanism: str) -> tuple[int, ...]:
    return tuple(FORMULATION_NAMES) if MULTIPLIERS[mechanism] else (INDEX3,)


def _runs(mechanism: str) -> list[tuple[int, int, float]]:
    return [(f, corrector, rho) for f in _formulations(mechanism) for corrector in CORRECTORS for rho in RHO_INF]


def _key(formulation: int, corrector: int, rho_inf: float) -> str:
    return f"{FORMULATION_NAMES[formulation]}/{CORRECTORS[corrector]}/{rho_inf:g}"


class LongRuns:
    """Energy and drift over long times."""

    name = "long_runs"
    title = "Long runs"
    mechanisms = tuple(LENGTHS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each formulation, corrector and ρ∞."""
        length = LENGTHS[mechanism]
        stop_time = length.quick_time if quick else length.stop_time
        return [Cell(_key(*run), long_run, (mechanism, *run, stop_time)) for run in _runs(mechanism)]

    def report(self, results: Results, folder: Path) -> str:
        """What is shown, then a table and a figure for each mechanism."""
        parts = [__doc__.split("\n\n", 1)[1].strip() + "\n"]
        for mechanism, found in results.items():
            stem = f"{self.name}-{mechanism}"
            _write_csv(folder / f"{stem}.csv", mechanism, found)
            _draw(folder / f"{stem}.png", mechanism, found)
            stop_time = max(cell["time"][-1] for cell in found.values() if cell["time"])
            turns = stop_time * angular_velocity(mechanism) / (2 * np.pi)
            parts.append(
                f"### {mechanism}\n\nσ = 1, h = {LENGTHS[mechanism].step_size:g} s, {stop_time:g} s: "
                f"up to {turns:.2g} turns of a body.\n\n"
                f"{_table(mechanism, found)}\n![Long runs of {mechanism}]({stem}.png)\n"
            )
        return "\n".join(parts)


def _points(cell: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Time and the largest errors of DRAWN stretches together."""
    if not cell["time"]:
        return {name: np.array([]) for name in ("time", *QUANTITIES)}
    begins = np.arange(0, len(cell["time"]), DRAWN)
    return {name: np.maximum.reduceat(np.array(cell[name]), begins) for name in ("time", *QUANTITIES)}


def _write_csv(path: Path, mechanism: str, found: Mapping[str, Any]) -> None:
    header = ("formulation", "corrector", "rho", "time", *QUANTITIES)
    rows = []
    for formulation, corrector, rho in _runs(mechanism):
        points = _points(found[_key(formulation, corrector, rho)])
        method = (FORMULATION_NAMES[formulation], CORRECTORS[corrector], rho)
        rows += [dict(zip(header, (*method, *values), strict=True)) for values in zip(*points.values(), strict=True)]
    write_csv(path, rows, header)


def _table(mechanism: str, found: Mapping[str, Any]) -> str:
    """Largest errors in the first and the last fifth."""
    rows = []
    for formulation, corrector, rho in _runs(mechanism):
        cell = found[_key(formulation, corrector, rho)]
        name = FORMULATION_NAMES[formulation] if MULTIPLIERS[mechanism] else "–"
        row = [name, CORRECTORS[corrector], f"{rho:g}"]
        if "failed" in cell:
            rows.append([*row, cell["failed"], *["–"] * 3, str(cell["retries"])])
            continue
        fifth = SAMPLES // 5
        energy = np.array(cell["energy"])
        row += [f"{energy[:fifth].max():.1e}", f"{energy[-fifth:].max():.1e}"]
        row += [f"{max(cell[name]):.1e}" if MULTIPLIERS[mechanism] else "–" for name in ("phi", "phidot")]
        rows.append([*row, str(cell["retries"])])
    header = ["formulation", "corrector", "ρ∞", "energy, first fifth", "energy, last fifth", "Φ", "dΦ/dt", "retries"]
    return markdown_table(header, rows)


def _draw(path: Path, mechanism: str, found: Mapping[str, Any]) -> None:
    """Formulations across, quantities down."""
    formulations = _formulations(mechanism)
    quantities = dict(QUANTITIES) if MULTIPLIERS[mechanism] else {"energy": QUANTITIES["energy"]}
    with figure(path, (max(6.4, 3.9 * len(formulations)), 1.2 + 2.2 * len(quantities))) as result:
        grid = result.subplots(len(quantities), len(formulations), squeeze=False, sharex=True, sharey="row")
        handles: dict[str, Line2D] = {}
        for row, (quantity, label) in zip(grid, quantities.items(), strict=True):
            row[0].set_ylabel(label)
            for axes, formulation in zip(row, formulations, strict=True):
                for corrector in CORRECTORS:
                    for rho in RHO_INF:
                        cell = found[_key(formulation, corrector, rho)]
                        name = f"{CORRECTORS[corrector]}, ρ∞ = {rho:g}"
                        handles[name] = _draw_curve(axes, cell, quantity, corrector, rho)
                axes.set_yscale("log")
                axes.minorticks_off()
        for axes, formulation in zip(grid[0], formulations, strict=True):
            if MULTIPLIERS[mechanism]:
                axes.set_title(FORMULATION_NAMES[formulation])
        for axes in grid[-1]:
            axes.set_xlabel("time in s")
        result.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)
        result.suptitle(
            f"{mechanism}: h = {LENGTHS[mechanism].step_size:g} s    ✕ fails", x=0.01, ha="left", fontsize=11
        )


def _draw_curve(axes: Axes, cell: Mapping[str, Any], quantity: str, corrector: int, rho: float) -> Line2D:
    color = COLORS[RHO_INF.index(rho)]
    points = _points(cell)
    values = np.maximum(points[quantity], FLOOR)
    (curve,) = axes.plot(points["time"], values, "-" if corrector == RESIDUAL else "--", color=color, linewidth=1)
    if "failed" in cell:
        at = (points["time"][-1], values[-1]) if len(values) else (0.0, 1.0)
        axes.plot(*at, "x", color=color, markersize=7, markeredgewidth=2)
    return curve


CHAPTER = LongRuns()
