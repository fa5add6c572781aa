"""Chapter: where in the plane of ρ∞ and hω each scheme runs, with what error, and how it fails where it does not.

ω is the largest angular velocity of the exact motion, so hω is the largest rotation in a step. Steps are never halved.
A run ends in one of three ways:

- it stops: the integrator says that a step failed (no convergence, singular, not finite, rotation above π);
- it diverges in silence: at a sample a value is not finite, the kinetic energy is over twice the largest of the exact
  motion, or the position is off by more than ten times the size of the motion;
- it runs. Its error is the largest one of the position over the samples, divided by the size of the motion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm

from research.measure import TRACKED, columns, exact
from research.reference import History
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from research.study.runs import simulation
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

STOP_TIMES = {"HeavyTop": 1.0, "HighSpeedRotor": 0.1, "SliderCrank": 5.0}  # s
SAMPLES = 10
"""Every number of steps is a multiple of it, so that samples fall on steps."""
H_OMEGA = (0.0375, 0.075, 0.15, 0.3, 0.6, 1.25, 2.5)
RHO_INF = (0.0, 0.2, 0.4, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0)
QUICK_H_OMEGA = (0.15, 0.3, 0.6)
QUICK_RHO_INF = (0.0, 0.5, 0.9, 1.0)
SAFE_H_OMEGA = 0.3
"""Up to here the default (stabilized index 2, residual, σ = 1) has to run at every ρ∞."""
ENERGY_LIMIT, ERROR_LIMIT = 2.0, 10.0
ERROR_RANGE = (1e-5, 1.0)  # of the colours

FORMULATIONS = {"index3": 1, "index2": 2, "stabilizedIndex2": 3}
FORMULATION_TITLES = {"index3": "index 3", "index2": "index 2", "stabilizedIndex2": "stabilized index 2"}
CORRECTORS = {"residual": 1, "incremental": 2}
SIGMA_TITLES = {"0": "σ = 0", "optimal": "σ = γ/(3β)", "1": "σ = 1"}
EXUDYN_TITLES = {"geom1": "Exudyn\ngeom1", "modified": "Exudyn\nσ-modified"}
OUTCOMES = ("runs", "stops", "diverges")
MARKS = {"stops": ("x", "#333333"), "diverges": ("^", "#c0392b")}

Maps = Mapping[str, dict[str, Any]]
"""Key of a panel → its result."""


@dataclass(frozen=True)
class Panel:
    """One scheme and formulation: one small map. `sigma` is a key of SIGMA_TITLES, or of EXUDYN_TITLES for Exudyn's."""

    sigma: str
    corrector: str  # of CORRECTORS, or "Exudyn"
    formulation: str

    @property
    def key(self) -> str:
        """Of the cell in the chapter."""
        return f"{self.corrector} {self.sigma} {self.formulation}"

    @property
    def title(self) -> str:
        """Of the scheme, on two lines."""
        if self.corrector == "Exudyn":
            return EXUDYN_TITLES[self.sigma]
        return f"{self.corrector}\n{SIGMA_TITLES[self.sigma]}"


def panels(mechanism: str) -> list[Panel]:
    """All schemes; without joints the formulations are one. Exudyn's index 2 knows the trapezoidal rule alone."""
    joints = _has_joints(mechanism)
    ours = [
        Panel(sigma, corrector, formulation)
        for formulation in (FORMULATIONS if joints else ("index3",))
        for corrector in CORRECTORS
        for sigma in SIGMA_TITLES
    ]
    peers = [Panel(sigma, "Exudyn", formulation) for formulation in ("index3", "index2") for sigma in EXUDYN_TITLES]
    return ours + [peer for peer in peers if joints or peer.formulation == "index3"]


def run_panel(
    mechanism: str, panel: Panel, rho_inf: Sequence[float], h_omega: Sequence[float]
) -> dict[str, list[dict[str, Any]]]:
    """The cells of a map: ρ∞, the hω asked for, h in s, outcome, relative error (NaN unless it runs) and reason."""
    if (panel.corrector, panel.formulation) == ("Exudyn", "index2"):
        rho_inf = (1.0,)
    cells = []
    for rho in rho_inf:
        for product in h_omega:
            steps = number_of_steps(mechanism, product)
            end = dict(zip(("outcome", "error", "reason"), run(mechanism, panel, rho, steps), strict=True))
            cells.append({"rho": rho, "hOmega": product, "h": STOP_TIMES[mechanism] / steps, **end})
    return {"cells": cells}


def failures(cells: Sequence[dict[str, Any]], largest_h_omega: float) -> list[dict[str, Any]]:
    """Those cells up to an hω that do not run."""
    return [cell for cell in cells if cell["hOmega"] <= largest_h_omega and cell["outcome"] != "runs"]


def number_of_steps(mechanism: str, h_omega: float) -> int:
    """Steps of the run at hω, a multiple of SAMPLES."""
    return SAMPLES * max(1, round(STOP_TIMES[mechanism] * angular_velocity(mechanism) / (SAMPLES * h_omega)))


def angular_velocity(mechanism: str) -> float:
    """The largest of the exact motion over the run, rad/s."""
    history = exact(mechanism, STOP_TIMES[mechanism], 500)
    bodies = _core.mechanism(mechanism).multibody.bodies
    return max(float(np.linalg.norm(columns(history, f"{b.name}.angularVelocity"), axis=1).max()) for b in bodies)


@lru_cache
def largest_kinetic_energy(mechanism: str) -> float:
    """Of the exact motion over the run, J."""
    _, velocity = _of_history(mechanism, exact(mechanism, STOP_TIMES[mechanism], 500))
    return float(_kinetic_energy(mechanism, velocity).max())


def run(mechanism: str, panel: Panel, rho: float, steps: int) -> tuple[str, float, str]:
    """How one run ended: "runs", "diverges" or "stops", its relative error, and why it failed."""
    try:
        if panel.corrector == "Exudyn":
            position, velocity = _run_exudyn(mechanism, panel, rho, steps)
        else:
            position, velocity = _run_core(mechanism, panel, rho, steps)
    except RuntimeError as error:  # Exudyn's SolverError is one too
        return "stops", np.nan, (str(error).strip().splitlines() or ["no message"])[0]
    return assess(mechanism, position, velocity)


def assess(mechanism: str, position: np.ndarray, velocity: np.ndarray) -> tuple[str, float, str]:
    """What `run` returns, of a run that reached the end: (samples, 3) in m and (samples, 6 bodies)."""
    reference = exact(mechanism, STOP_TIMES[mechanism], SAMPLES)
    expected, _ = _of_history(mechanism, reference)
    if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
        return "diverges", np.nan, "not finite"
    size = np.linalg.norm(expected - expected[0], axis=1).max()
    error = float(np.linalg.norm(position - expected, axis=1).max() / size)
    energy = _kinetic_energy(mechanism, velocity).max() / largest_kinetic_energy(mechanism)
    if energy > ENERGY_LIMIT:
        return "diverges", np.nan, f"{energy:.1e} times the kinetic energy"
    if error > ERROR_LIMIT:
        return "diverges", np.nan, f"an error of {error:.1e} times the motion"
    return "runs", error, ""


def _run_core(mechanism: str, panel: Panel, rho: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    alpha = _core.AlphaParameters(rho)
    stop_time = STOP_TIMES[mechanism]
    simulated = simulation(
        mechanism,
        stop_time / steps,
        spectral_radius=rho,
        sigma={"0": 0.0, "1": 1.0, "optimal": alpha.gamma / (3 * alpha.beta)}[panel.sigma],
        formulation=FORMULATIONS[panel.formulation],
        corrector=CORRECTORS[panel.corrector],
    )
    body, _ = TRACKED[mechanism]
    rows = []
    for i in range(SAMPLES + 1):
        simulated.run(stop_time * i / SAMPLES, steps // SAMPLES if i else 0)
        rows.append((simulated.state.q[7 * body : 7 * body + 3].copy(), simulated.state.v.copy()))
    return np.array([q for q, _ in rows]), np.array([v for _, v in rows])


def _run_exudyn(mechanism: str, panel: Panel, rho: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    from research.reference.exudyn_models import Settings, simulate

    stop_time = STOP_TIMES[mechanism]
    settings = Settings(
        stop_time / steps,
        rotation="lieGroup",
        scheme=panel.formulation,
        rho_inf=rho,
        simplified_kinematics=panel.sigma == "geom1",
    )
    history = simulate(mechanism, settings, stop_time, sample_step=stop_time / SAMPLES).history
    return _of_history(mechanism, history)


def _of_history(mechanism: str, history: History) -> tuple[np.ndarray, np.ndarray]:
    """Position of the tracked body, and velocities of all bodies in the core's order."""
    names = [body.name for body in _core.mechanism(mechanism).multibody.bodies]
    velocity = [columns(history, f"{name}.{part}") for name in names for part in ("velocity", "angularVelocity")]
    return columns(history, f"{TRACKED[mechanism][1]}.position"), np.hstack(velocity)


def _kinetic_energy(mechanism: str, velocity: np.ndarray) -> np.ndarray:
    """In J, for each row of velocities; the mechanisms have principal axes."""
    bodies = _core.mechanism(mechanism).multibody.bodies
    diagonal = np.concatenate([np.r_[np.full(3, body.mass), body.inertia] for body in bodies])
    return 0.5 * velocity**2 @ diagonal


class Stability:
    """The stability maps, one figure for each mechanism."""

    name = "stability"
    title = "Stability: ρ∞ and hω"
    mechanisms = tuple(STOP_TIMES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each panel."""
        rho_inf, h_omega = (QUICK_RHO_INF, QUICK_H_OMEGA) if quick else (RHO_INF, H_OMEGA)
        return [Cell(p.key, run_panel, (mechanism, p, rho_inf, h_omega)) for p in panels(mechanism)]

    def report(self, results: Results, folder: Path) -> str:
        """What the outcomes mean, then a table and a figure for each mechanism."""
        parts = [__doc__.split("\n\n", 1)[1].strip() + "\n"]
        for mechanism, maps in results.items():
            stem = f"{self.name}-{mechanism}"
            _write_csv(folder / f"{stem}.csv", mechanism, maps)
            _draw(folder / f"{stem}.png", mechanism, maps)
            parts.append(f"### {mechanism}\n\n{_table(mechanism, maps)}\n![Stability of {mechanism}]({stem}.png)\n")
        return "\n".join(parts)


def _write_csv(path: Path, mechanism: str, maps: Maps) -> None:
    header = ("corrector", "sigma", "formulation", "rho", "hOmega", "h", "outcome", "error", "reason")
    write_csv(path, [{**vars(p), **cell} for p in panels(mechanism) for cell in maps[p.key]["cells"]], header)


def _table(mechanism: str, maps: Maps) -> str:
    """How many cells of each panel run, stop and diverge; those that run also up to SAFE_H_OMEGA."""
    rows = []
    for panel in panels(mechanism):
        cells = maps[panel.key]["cells"]
        safe = [cell for cell in cells if cell["hOmega"] <= SAFE_H_OMEGA]
        count = {o: sum(cell["outcome"] == o for cell in cells) for o in OUTCOMES}
        rows.append(
            [
                panel.title.replace("\n", ", "),
                FORMULATION_TITLES[panel.formulation] if _has_joints(mechanism) else "–",
                f"{len(safe) - len(failures(safe, SAFE_H_OMEGA))} of {len(safe)}",
                f"{count['runs']} of {len(cells)}",
                str(count["stops"]),
                str(count["diverges"]),
            ]
        )
    header = ["scheme", "formulation", f"runs, hω ≤ {SAFE_H_OMEGA:g}", "runs", "stops", "diverges in silence"]
    return markdown_table(header, rows)


def _draw(path: Path, mechanism: str, maps: Maps) -> None:
    """Formulations down, schemes across."""
    every = panels(mechanism)
    formulations = list(dict.fromkeys(panel.formulation for panel in every))
    titles = list(dict.fromkeys(panel.title for panel in every))
    rho_inf, h_omega = (sorted({c[k] for m in maps.values() for c in m["cells"]}) for k in ("rho", "hOmega"))
    colors = ScalarMappable(LogNorm(*ERROR_RANGE), mpl.colormaps["viridis"].with_extremes(bad="#eeeeee"))
    with figure(path, (12.5, 1.6 + 2.0 * len(formulations))) as result:
        grid = result.subplots(len(formulations), len(titles), sharex=True, sharey=True, squeeze=False)
        grid[0, 0].set_xticks(range(len(h_omega)), [f"{x:g}" for x in h_omega])
        grid[0, 0].set_yticks(range(len(rho_inf)), [f"{y:g}" for y in rho_inf])
        for axes in grid.ravel():
            axes.tick_params(length=0, labelsize=7)
            axes.tick_params(axis="x", rotation=90)
            axes.grid(False)
            axes.set_visible(False)
        for panel in every:
            axes = grid[formulations.index(panel.formulation), titles.index(panel.title)]
            axes.set_visible(True)
            _draw_map(axes, maps[panel.key]["cells"], rho_inf, h_omega, colors)
        for axes, title in zip(grid[0], titles, strict=True):
            axes.set_title(title, fontsize=9, loc="center", fontweight="normal")
        for axes, formulation in zip(grid[:, 0], formulations, strict=True):
            axes.set_ylabel(f"{FORMULATION_TITLES[formulation]}\nρ∞" if _has_joints(mechanism) else "ρ∞")
        result.supxlabel("hω in rad", fontsize=9)
        result.suptitle(
            f"{mechanism}: error of the position over the size of the motion, {STOP_TIMES[mechanism]:g} s    "
            "✕ a step fails    ▲ diverges in silence",
            x=0.01,
            ha="left",
            fontsize=11,
        )
        result.colorbar(colors, ax=grid, extend="both", pad=0.01, aspect=12 * len(formulations))


def _draw_map(
    axes: Axes,
    cells: Sequence[dict[str, Any]],
    rho_inf: Sequence[float],
    h_omega: Sequence[float],
    colors: ScalarMappable,
) -> None:
    rows = sorted({rho_inf.index(cell["rho"]) for cell in cells})  # all, or ρ∞ = 1 alone
    errors = np.full((len(rows), len(h_omega)), np.nan)
    for cell in cells:
        x, y = h_omega.index(cell["hOmega"]), rho_inf.index(cell["rho"])
        if cell["outcome"] == "runs":
            errors[y - rows[0], x] = np.clip(cell["error"], *ERROR_RANGE)
        else:
            marker, color = MARKS[cell["outcome"]]
            axes.plot(x, y, marker, color=color, markersize=4)
    edges = (np.arange(len(h_omega) + 1) - 0.5, np.arange(len(rows) + 1) + rows[0] - 0.5)
    axes.pcolormesh(*edges, errors, cmap=colors.cmap, norm=colors.norm, edgecolors="white", linewidth=0.5)
    if len(rows) < len(rho_inf):
        axes.text(0.5 * (len(h_omega) - 1), rows[0] - 1.2, "trapezoidal rule", ha="center", fontsize=8)


def _has_joints(mechanism: str) -> bool:
    return bool(_core.mechanism(mechanism).multibody.joints)


CHAPTER = Stability()
