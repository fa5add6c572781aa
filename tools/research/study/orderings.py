"""What must hold on every machine: σ = 1 beats geom1, and the default runs wherever steps are not too large."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from research.measure import FORMULATION_NAMES
from research.study import cases, runs
from research.study.chapter import Cell, Results
from research.study.stability import (
    H_OMEGA,
    QUICK_H_OMEGA,
    QUICK_RHO_INF,
    RHO_INF,
    SAFE_H_OMEGA,
    SIGMA_TITLES,
    Panel,
    failures,
    run_panel,
)
from sigmafmu.markdown import markdown_table

RUNS = {"HeavyTop": (1e-3, 1.0, 2.0), "HighSpeedRotor": (1e-5, 0.1, 2.0), "SliderCrank": (2.5e-3, 2.0, 0.99)}
"""Step and end in s, and the smallest factor between the errors of geom1 and σ = 1.

On the slider-crank, whose bodies turn slowly, σ = 1 need only be no worse; a hundredth is left for Newton's tolerance.
"""


def gain(mechanism: str, h: float, stop_time: float, formulation: int) -> dict[str, Any]:
    """Largest position errors of geom1 and σ = 1 with the FMU's defaults."""
    geom1, one = (runs.ours(mechanism, h, stop_time, sigma=s, formulation=formulation) for s in (0.0, 1.0))
    failed = [run["failed"] for run in (geom1, one) if "failed" in run]
    if failed:
        return {"failed": failed[0]}
    return {"geom1": geom1["position"], "one": one["position"], "gain": geom1["position"] / one["position"]}


class Orderings:
    """Assertions on the results."""

    name = "orderings"
    title = "What must hold"
    mechanisms = tuple(RUNS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """Gains for each formulation, stability of the stabilized form for each σ."""
        h, stop_time, _ = RUNS[mechanism]
        result = [
            Cell(f"gain/{FORMULATION_NAMES[formulation]}", gain, (mechanism, h, stop_time, formulation))
            for formulation in cases.formulations(mechanism)
        ]
        rho_inf, h_omega = (QUICK_RHO_INF, QUICK_H_OMEGA) if quick else (RHO_INF, H_OMEGA)
        safe = tuple(product for product in h_omega if product <= SAFE_H_OMEGA)
        result += [
            Cell(
                f"stability/{sigma}",
                run_panel,
                (mechanism, Panel(sigma, "residual", "stabilizedIndex2"), rho_inf, safe),
            )
            for sigma in SIGMA_TITLES
        ]
        return result

    def report(self, results: Results, folder: Path) -> str:
        """Two tables and a verdict."""
        gains, maps = [], []
        for mechanism, found in results.items():
            for key, cell in found.items():
                kind, name = key.split("/")
                if kind == "gain":
                    figures = [f"{cell[x]:.2g}" for x in ("geom1", "one", "gain")] if "gain" in cell else ["fails"] * 3
                    gains.append([mechanism, name, *figures, f"≥ {RUNS[mechanism][2]:g}"])
                else:
                    failed = failures(cell["cells"], SAFE_H_OMEGA)
                    maps.append(
                        [mechanism, SIGMA_TITLES[name], f"{len(cell['cells']) - len(failed)} of {len(cell['cells'])}"]
                    )
        broken = violations(results)
        verdict = "Everything holds." if not broken else "These do not hold: " + "; ".join(broken) + "."
        return "\n".join(
            [
                f"{verdict} `make study` fails otherwise.\n",
                "Largest position error [m] with the defaults of the FMU (ρ∞ = 0.9, residual form):\n",
                markdown_table(["mechanism", "formulation", "geom1", "σ = 1", "gain", "asked for"], gains),
                f"Stabilized index 2, residual form, hω ≤ {SAFE_H_OMEGA}: cells of the stability map that run:\n",
                markdown_table(["mechanism", "scheme", "run"], maps),
            ]
        )


def violations(results: Mapping[str, Mapping[str, dict[str, Any]]]) -> list[str]:
    """What does not hold."""
    broken = []
    for mechanism, found in results.items():
        for key, cell in found.items():
            kind, name = key.split("/")
            if kind == "gain" and not cell.get("gain", 0.0) >= RUNS[mechanism][2]:
                broken.append(
                    f"{mechanism}, {name}: σ = 1 gains {cell.get('gain', 0.0):.2g}, not {RUNS[mechanism][2]:g}"
                )
            if kind == "stability":
                broken += [
                    f"{mechanism}, {SIGMA_TITLES[name]}, ρ∞ = {c['rho']:g}, hω = {c['hOmega']:g}: {c['outcome']}"
                    for c in failures(cell["cells"], SAFE_H_OMEGA)
                ]
    return broken


CHAPTER = Orderings()
