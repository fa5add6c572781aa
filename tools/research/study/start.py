"""Chapter: starting values. What the first steps cost when a_0 is not what the method's own a_n would be.

a_n approximates v̇(t_n + Δ_α h), Δ_α = α_m − α_f, so a_0 = v̇_0 is wrong by Δ_α h v̈_0. The shifted start
a_0 = v̇_0 + Δ_α h v̈_0 is what the integrator does. At ρ∞ = 1 both are the same, Δ_α = 0.

Index 3 has a transient of its own. Its steps fulfil Φ(q) = 0 with the velocities that this takes: v_n differs across
the constraints by δ = B⁺B l/h from the exact one, where l = h³ [C_q v̈ + ¼ (1/3 − σβ/γ) v̂ v̇] is the local error (40)
and B⁺ = M⁻¹Bᵀ(B M⁻¹Bᵀ)⁻¹. A start with the exact v_0 makes up for δ in its first step, by an acceleration wrong by
δ/(βh) = O(h), and λ with it. The start "a_0 and v_0" has v_0 + δ and shows that this is all there is.
"""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from research.measure import FORMULATION_NAMES, INDEX3, MULTIPLIERS, TRACKED, columns
from research.reference import History
from research.reference.minimal_coordinates import solve
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from research.study.runs import simulation
from sigmafmu import _core
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

LARGEST_STEPS = {"HeavyTop": 1e-3, "HighSpeedRotor": 1e-5, "SliderCrank": 4e-3}  # s
HALVINGS, QUICK_HALVINGS = 4, 2
STEPS = 40  # of a run: the transient, not the time
RHO_INF = (0.9, 0.5)
PLAIN, SHIFTED, VELOCITY = "a_0 = v̇_0", "a_0 shifted", "a_0 and v_0"
TIGHT = {"relative_tolerance": 1e-13, "absolute_tolerance": 1e-14}  # what is left is the start's doing


def transient(mechanism: str, formulation: int, rho_inf: float, start: str, steps: Sequence[float]) -> dict[str, Any]:
    """Errors after each of the first STEPS steps, a row for each step size: velocity [m/s] and multipliers [N]."""
    velocity, multipliers = [], []
    body, name = TRACKED[mechanism]
    for h in steps:
        run = simulation(mechanism, h, formulation=formulation, spectral_radius=rho_inf, **TIGHT)
        _set_start(run, mechanism, rho_inf, h, start)
        _, _, v, found = run.trajectory(STEPS * h, STEPS)
        reference = _reference(mechanism, h)
        velocity.append(_norms(v[:, 6 * body : 6 * body + 3] - columns(reference, f"{name}.velocity")))
        forces = [
            -found[:, first : first + 3] - columns(reference, f"{joint}.reactionForce")
            for joint, first in MULTIPLIERS[mechanism].items()
        ]
        multipliers.append(_norms(np.hstack(forces)) if forces else [])
    return {"h": list(steps), "velocity": velocity, "multipliers": multipliers}


def order(largest: Sequence[float]) -> float:
    """Observed in the last halving of h."""
    return float(np.log2(largest[-2] / largest[-1]))


def first_velocity(cell: dict[str, Any]) -> np.ndarray:
    """Velocity error after the first step, for each h."""
    return np.array(cell["velocity"])[:, 0]


def largest_multipliers(cell: dict[str, Any]) -> np.ndarray:
    """Largest error of the multipliers over all steps, for each h; empty without joints."""
    errors = np.array(cell["multipliers"])
    return errors.max(axis=1) if errors.size else np.array([])


def _set_start(run: _core.Simulation, mechanism: str, rho_inf: float, h: float, start: str) -> None:
    """Replace the start of the integrator, which is the shifted one; σ = 1."""
    alpha = _core.AlphaParameters(rho_inf)
    state, shift = run.state, alpha.alpha_m - alpha.alpha_f
    jerk = (state.a - state.vdot) / (shift * h)
    if start == PLAIN:
        state.a = state.vdot
    if start == VELOCITY:
        omega, omega_dot = (x.reshape(-1, 6)[:, 3:] for x in (state.v, state.vdot))
        lie = np.zeros((len(omega), 6))
        lie[:, 3:] = np.cross(omega, omega_dot)
        c_q = (1 - 6 * alpha.beta - 3 * shift) / 6
        local_error = h**3 * (c_q * jerk + (1 / 3 - alpha.beta / alpha.gamma) / 4 * lie.ravel())
        system = _core.System(_core.mechanism(mechanism).multibody)
        _, _, B, _ = system.constraints(state.q, state.v)
        M, _, _ = system.linearization(state.q, state.v, state.lambda_, np.zeros(system.input_size))
        across = np.linalg.solve(M, B.T)
        state.v = state.v + across @ np.linalg.solve(B @ across, B @ local_error) / h


@lru_cache(maxsize=16)
def _reference(mechanism: str, h: float) -> History:
    return solve(mechanism, np.arange(STEPS + 1) * h)


def _norms(difference: np.ndarray) -> np.ndarray:
    """Of each step but the start."""
    return np.linalg.norm(difference, axis=1)[1:]


def _formulations(mechanism: str) -> tuple[int, ...]:
    return tuple(FORMULATION_NAMES) if MULTIPLIERS[mechanism] else (INDEX3,)


def _starts(mechanism: str, formulation: int) -> tuple[str, ...]:
    own_transient = bool(MULTIPLIERS[mechanism]) and formulation == INDEX3
    return (PLAIN, SHIFTED, VELOCITY) if own_transient else (PLAIN, SHIFTED)


def _runs(mechanism: str) -> list[tuple[int, float, str]]:
    return [(f, rho, s) for f in _formulations(mechanism) for rho in RHO_INF for s in _starts(mechanism, f)]


def _key(formulation: int, rho_inf: float, start: str) -> str:
    return f"{FORMULATION_NAMES[formulation]}/{rho_inf:g}/{start}"


class Start:
    """Transients of the two starts, and of a third one in index 3."""

    name = "start"
    title = "Starting values"
    mechanisms = tuple(LARGEST_STEPS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each formulation, ρ∞ and start."""
        halvings = QUICK_HALVINGS if quick else HALVINGS
        steps = tuple(LARGEST_STEPS[mechanism] / 2**i for i in range(halvings + 1))
        return [Cell(_key(*run), transient, (mechanism, *run, steps)) for run in _runs(mechanism)]

    def report(self, results: Results, folder: Path) -> str:
        """The explanation, then a table and a figure for each mechanism."""
        parts = [
            __doc__.split("\n\n", 1)[1].strip() + "\n",
            f"Tables: residual form, σ = 1; error of the velocity after the first step, largest error of the "
            f"multipliers within {STEPS} steps, with the smallest h; orders of the last halving.\n",
        ]
        for mechanism, found in results.items():
            stem = f"{self.name}-{mechanism}"
            _write_csv(folder / f"{stem}.csv", mechanism, found)
            _draw(folder / f"{stem}.png", mechanism, found)
            parts.append(f"### {mechanism}\n\n{_table(mechanism, found)}\n![Start of {mechanism}]({stem}.png)\n")
        return "\n".join(parts)


def _write_csv(path: Path, mechanism: str, found: dict[str, Any]) -> None:
    rows = []
    for formulation, rho, start in _runs(mechanism):
        cell = found[_key(formulation, rho, start)]
        for i, h in enumerate(cell["h"]):
            for n in range(STEPS):
                row = {"formulation": FORMULATION_NAMES[formulation], "rho": rho, "start": start, "h": h, "step": n + 1}
                row["velocity"] = cell["velocity"][i][n]
                if cell["multipliers"][i]:
                    row["multipliers"] = cell["multipliers"][i][n]
                rows.append(row)
    write_csv(path, rows, ("formulation", "rho", "start", "h", "step", "velocity", "multipliers"))


def _table(mechanism: str, found: dict[str, Any]) -> str:
    rows = []
    for formulation, rho, start in _runs(mechanism):
        cell = found[_key(formulation, rho, start)]
        row = [FORMULATION_NAMES[formulation] if MULTIPLIERS[mechanism] else "–", f"{rho:g}", start]
        for errors in (first_velocity(cell), largest_multipliers(cell)):
            row += [f"{errors[-1]:.1e}", f"{order(errors):.2f}"] if len(errors) else ["–", "–"]
        rows.append(row)
    header = ["formulation", "ρ∞", "start", "velocity [m/s]", "order", "multipliers [N]", "order"]
    return markdown_table(header, rows)


def _draw(path: Path, mechanism: str, found: dict[str, Any]) -> None:
    """Formulations across; above the error from step to step, below its largest value over h."""
    formulations = _formulations(mechanism)
    quantity, unit = ("multipliers", "N") if MULTIPLIERS[mechanism] else ("velocity", "m/s")
    with figure(path, (max(6.4, 3.8 * len(formulations)), 6.2)) as result:
        grid = result.subplots(2, len(formulations), squeeze=False, sharex="row", sharey="row")
        for column, formulation in zip(grid.T, formulations, strict=True):
            for rho in RHO_INF:
                for start in _starts(mechanism, formulation):
                    cell = found[_key(formulation, rho, start)]
                    _draw_curves(*column, cell, quantity, rho, start)
            if MULTIPLIERS[mechanism]:
                column[0].set_title(FORMULATION_NAMES[formulation])
            column[0].set(yscale="log", xlabel=f"step of h = {cell['h'][-1]:.3g} s")
            column[1].set(xscale="log", yscale="log", xlabel="h in s")
            for axes in column:
                axes.tick_params(labelbottom=True)
                axes.minorticks_off()
            column[1].set_xticks(cell["h"], [f"{h:.2g}" for h in cell["h"]])
        grid[0, 0].set_ylabel(f"error in {unit}")
        grid[1, 0].set_ylabel(f"{'first' if quantity == 'velocity' else 'largest'} error in {unit}")
        handles = dict(zip(*reversed(grid[0, 0].get_legend_handles_labels()), strict=True))
        result.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)
        result.suptitle(f"{mechanism}: {quantity} in the first {STEPS} steps", x=0.01, ha="left", fontsize=11)


def _draw_curves(by_step: Axes, by_h: Axes, cell: dict[str, Any], quantity: str, rho: float, start: str) -> None:
    color = {PLAIN: COLORS[1], SHIFTED: COLORS[0], VELOCITY: COLORS[2]}[start]
    line, marker = ("-", "o") if rho == RHO_INF[0] else ("--", "s")
    style = {"color": color, "linestyle": line, "label": f"{start}, ρ∞ = {rho:g}"}
    by_step.plot(np.arange(1, STEPS + 1), cell[quantity][-1], **style)
    by_h.plot(
        cell["h"],
        largest_multipliers(cell) if quantity == "multipliers" else first_velocity(cell),
        marker=marker,
        markersize=3,
        **style,
    )


CHAPTER = Start()
