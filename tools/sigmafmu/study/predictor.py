"""Does the result depend on the predictor and on the iteration matrix?"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from sigmafmu.markdown import markdown_table
from sigmafmu.measure import FORMULATION_NAMES, INCREMENTAL, INDEX3, RESIDUAL
from sigmafmu.reference.exudyn_models import Settings, simulate
from sigmafmu.study import algorithm1, cases, runs
from sigmafmu.study.cases import CASES, CORRECTORS
from sigmafmu.study.chapter import Cell, Results
from sigmafmu.study.iterations import VARIANTS
from sigmafmu.study.output import write_csv

TOLERANCES = {"paper": {}, "tight": {"relative_tolerance": 1e-12, "absolute_tolerance": 1e-14}}
STEPS = {"HeavyTop": 1e-3, "HighSpeedRotor": 2e-5, "SliderCrank": 2.5e-3}  # s
TIMES = {"HeavyTop": 0.5, "HighSpeedRotor": 0.02, "SliderCrank": 1.0}  # s
QUICK_TIMES = {"HeavyTop": 0.1, "HighSpeedRotor": 0.005, "SliderCrank": 0.25}
HEADER = (
    *("corrector", "formulation", "tolerance", "variant", "h"),
    *("position", "iterations", "jacobians", "difference", "failed"),
)


def compare(mechanism: str, h: float, stop_time: float, settings: dict[str, float]) -> dict[str, Any]:
    """Runs with every variant of Newton's method and two tolerances.

    `difference`: the largest distance [m] of the followed point to the first run with the same tolerance.
    """
    found = []
    for tolerance, chosen in TOLERANCES.items():
        first = None
        for variant, newton in VARIANTS.items():
            everything = {**settings, **chosen, **newton}
            run = runs.ours(mechanism, h, stop_time, **everything)
            if "failed" not in run:
                history, _ = runs.trajectory(mechanism, h, stop_time, **everything)
                position, _ = runs.point_motion(mechanism, history)
                first = position if first is None else first
                run["difference"] = float(np.linalg.norm(position - first, axis=1).max())
            found.append({"tolerance": tolerance, "variant": variant, **run})
    return {"runs": found}


def by_hand(mechanism: str, h: float, stop_time: float, rho_inf: float, start: str, line6: str) -> dict[str, Any]:
    """Algorithm 1 in NumPy: its error, and its distance [m] to the core's incremental form."""
    position, _ = runs.point_motion(mechanism, runs.exact(mechanism, stop_time))
    settings = {"spectral_radius": rho_inf, "formulation": INDEX3, "corrector": INCREMENTAL, **TOLERANCES["tight"]}
    core, _ = runs.point_motion(mechanism, runs.trajectory(mechanism, h, stop_time, **settings)[0])
    try:
        history = algorithm1.trajectory(mechanism, h, stop_time, rho_inf, start, line6)
    except RuntimeError as error:
        return {"failed": str(error)}
    found, _ = runs.point_motion(mechanism, history)
    return {
        "position": float(np.linalg.norm(found - position, axis=1).max()),
        "difference": float(np.linalg.norm(found - core, axis=1).max()),
    }


def peer(mechanism: str, h: float, stop_time: float, settings: dict[str, Any]) -> dict[str, Any]:
    """Exudyn's run."""
    return runs.exudyn(mechanism, h, stop_time, **settings)


def equivalent(mechanism: str, h: float, stop_time: float, rho_inf: float, settings: dict[str, Any]) -> dict[str, Any]:
    """The σ of the residual form whose path is nearest to the core's incremental form and to Exudyn, and how near [m].

    Index 3, σ = 1 in both; `settings` are Exudyn's.
    """
    own = {"spectral_radius": rho_inf, "formulation": INDEX3, **TOLERANCES["tight"]}

    def path(**chosen: float) -> np.ndarray:
        return runs.point_motion(mechanism, runs.trajectory(mechanism, h, stop_time, **own, **chosen)[0])[0]

    peer = simulate(mechanism, Settings(h, **settings), stop_time, sample_step=stop_time / runs.SAMPLES).history
    found = {}
    for name, goal in {
        "incremental": path(corrector=INCREMENTAL),
        "Exudyn": runs.point_motion(mechanism, peer)[0],
    }.items():
        nearest = minimize_scalar(
            lambda sigma, goal=goal: float(np.linalg.norm(path(sigma=sigma) - goal, axis=1).max()),
            bounds=(0.0, cases.LARGEST_SIGMA),
            method="bounded",
            options={"xatol": 1e-2},
        )
        found[name] = {"sigma": float(nearest.x), "distance": float(nearest.fun)}
    return found


class Predictor:
    """Path independence of the residual form."""

    name = "predictor"
    title = "Predictor and path independence"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each corrector and formulation, and Algorithm 1 in NumPy. The incremental form starts as printed."""
        steps = (STEPS[mechanism], (QUICK_TIMES if quick else TIMES)[mechanism])
        result = []
        for formulation in cases.formulations(mechanism):
            for corrector, name in CORRECTORS.items():
                settings = cases.settings(mechanism, formulation, corrector=corrector)
                key = f"{FORMULATION_NAMES[formulation]}/{name}"
                result.append(Cell(key, compare, (mechanism, *steps, settings)))
        rho = CASES[mechanism].rho_inf[INDEX3]
        for start in algorithm1.STARTS:
            for line6 in algorithm1.LINE_6:
                key = f"Algorithm 1|{start}|{line6}"
                result.append(Cell(key, by_hand, (mechanism, *steps, rho, start, line6)))
        settings = cases.peer_settings(mechanism, INDEX3, "σ-modified")
        result.append(Cell("Exudyn", peer, (mechanism, *steps, settings)))
        result.append(Cell("equivalent", equivalent, (mechanism, *steps, rho, settings)))
        return result

    def report(self, results: Results, folder: Path) -> str:
        """Tables: how far the results spread, iterations, and Algorithm 1 with its choices."""
        spreads, iterations, choices, nearest = [], [], [], []
        for mechanism, found in results.items():
            rows = []
            for key, cell in found.items():
                if "/" not in key or "|" in key:
                    continue
                formulation, corrector = key.split("/")
                rows += [{"corrector": corrector, "formulation": formulation, **run} for run in cell["runs"]]
                spreads.append([mechanism, formulation, corrector, *_spreads(cell["runs"])])
                if corrector == CORRECTORS[RESIDUAL]:
                    iterations.append([mechanism, formulation, *_iterations(cell["runs"])])
            write_csv(folder / f"predictor_{mechanism}.csv", rows, HEADER)
            for key, cell in found.items():
                if "|" in key:
                    _, start, line6 = key.split("|")
                    choices.append([mechanism, start, line6, _error(cell, "position"), _error(cell, "difference")])
            choices.append([mechanism, "Exudyn, σ-modified", "", _error(found["Exudyn"], "position"), ""])
            for name, near in found["equivalent"].items():
                nearest.append([mechanism, name, f"{near['sigma']:.2f}", f"{near['distance']:.1e}"])
        parts = [
            "σ = 1. Each line has the runs with full, simplified and modified Newton. *Spread* is the largest distance "
            "between their positions; with *tight* tolerances (1e-12 relative, 1e-14 absolute) it must vanish if the "
            "result belongs to the equations alone, and stays if it belongs to the path.\n",
            markdown_table(
                ["mechanism", "formulation", "corrector", "discretization error [m]", "spread [m]", "tight [m]"],
                spreads,
            ),
            "Mean iterations per step of the residual form, tolerances of the paper:\n",
            markdown_table(["mechanism", "formulation", *VARIANTS], iterations),
            "Algorithm 1 (index 3) written down a second time, in NumPy, with the predictor of v̇ (line 1) and the "
            "factor of line 6 left open. As printed it is the core's incremental form; with half the factor it is "
            "Exudyn's. The result moves with the predictor, in one case to divergence: the printed scheme is defined "
            "by its predictor as much as by its equations.\n",
            markdown_table(["mechanism", "line 1", "line 6", "error [m]", "distance to the core [m]"], choices),
            "So σ = 1 means another σ there: the residual form whose path is nearest to that of the printed algorithm "
            "and to Exudyn's (index 3), and how near it comes:\n",
            markdown_table(["mechanism", "path of", "σ of the residual form", "distance [m]"], nearest),
        ]
        return "\n".join(parts)


def _error(cell: dict[str, Any], name: str) -> str:
    return f"{cell[name]:.2e}" if name in cell else "fails"


def _spreads(found: list[dict[str, Any]]) -> list[str]:
    """Discretization error of the first run that went through, and the spread for each tolerance."""
    result = [next((f"{run['position']:.1e}" for run in found if "failed" not in run), "fails")]
    for tolerance in TOLERANCES:
        of_tolerance = [run for run in found if run["tolerance"] == tolerance]
        failed = sum("failed" in run for run in of_tolerance)
        largest = max((run["difference"] for run in of_tolerance if "failed" not in run), default=np.nan)
        result.append(f"{largest:.1e}" + (f" ({failed} fail)" if failed else ""))
    return result


def _iterations(found: list[dict[str, Any]]) -> list[str]:
    """One figure for each variant."""
    chosen = [run for run in found if run["tolerance"] == "paper"]
    return ["fails" if "failed" in run else f"{run['iterations']:.2f}" for run in chosen]


CHAPTER = Predictor()
