"""Chapter: what stiff dampers do to the methods, on the rotor with its supports' damping raised."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import columns
from research.reference import Rotor
from research.reference.minimal_coordinates import high_speed_rotor
from research.study import lgt
from research.study.chapter import Cell, Results
from research.study.lgt import METHODS, number
from research.study.output import figure, write_csv
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

STEP, SAMPLES, STRIDE, QUICK_STRIDE = 1e-5, 50, 20, 4  # h in s; steps between two samples
DAMPING = (Rotor().damping, 1e3, 1e4, 3e4, 1e5, 3e5, 1e6)  # N s/m, of each support
QUICK_DAMPING = (1e4, 1e5)
AXES = {"leftSupport": (1, 2, 3), "rightSupport": (2, 3)}
HEADER = ("method", "damping", "h_over_tau", "error", "steps", "failed")


def stiff(damping: float, stride: int) -> dict[str, Any]:
    """By method: largest position error over the largest position, and steps taken for SAMPLES · stride · STEP."""
    rotor = replace(Rotor(), damping=damping)
    times = np.arange(SAMPLES + 1) * stride * STEP
    exact = columns(high_speed_rotor(times, rotor), "rotor.position")
    return {method: _run(method, damping, stride, exact) for method in lgt.methods(constrained=False)}


def ratio(damping: float) -> float:
    """h over τ = J_t / (d Σ a²), the time constant with which the dampers at distances a stop a tilting rotor."""
    rotor = Rotor()
    return STEP * damping * (rotor.left**2 + rotor.right**2) / rotor.inertia[1]


def _run(method: str, damping: float, stride: int, exact: np.ndarray) -> dict[str, Any]:
    definition = _core.mechanism("HighSpeedRotor")
    for support, axes in AXES.items():
        for axis in axes:
            definition.set(f"{support}.damping[{axis}]", damping)
    for name, value in {"step_size": STEP, **METHODS[method]}.items():
        setattr(definition.integrator, name, value)
    run = _core.Simulation(definition)
    largest = 0.0
    try:
        for i, position in enumerate(exact[1:], start=1):
            run.run(i * stride * STEP, stride)
            largest = max(largest, float(np.linalg.norm(run.state.q[:3] - position)))
    except RuntimeError as error:
        return {"failed": str(error)}
    return {"error": largest / np.linalg.norm(exact, axis=1).max(), "steps": run.state.counters.steps}


class Stiff:
    """Errors and steps over the damping."""

    name = "lgt_stiff"
    title = "Local-global transition maps: stiff forces"
    mechanisms = ("HighSpeedRotor",)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each damping."""
        chosen, stride = (QUICK_DAMPING, QUICK_STRIDE) if quick else (DAMPING, STRIDE)
        return [Cell(f"{damping:g}", stiff, (damping, stride)) for damping in chosen]

    def report(self, results: Results, folder: Path) -> str:
        """A table and a figure."""
        found = {float(key): cell for key, cell in results["HighSpeedRotor"].items()}
        write_csv(folder / "lgt_stiff.csv", _rows(found), HEADER)
        _draw(folder / "lgt_stiff.png", found)
        rows = []
        for damping, cell in found.items():
            entries = (
                f"{number(run.get('error', np.nan))} ({run['steps']})" if "steps" in run else "fails"
                for run in cell.values()
            )
            rows.append([f"{damping:g}", f"{ratio(damping):.2g}", *entries])
        return (
            f"The rotor with dampers d at its supports, h = {STEP:g} s. They stop its tilting within τ = J_t/(d Σa²). "
            "Implicit methods keep their steps, whatever d is. Explicit ones are stable up to h/τ of about 3: beyond, "
            "rkmk4 grows without bound until a step fails and is halved; rkmk54 stays right, and takes as many steps "
            "as that needs. Groups and maps change nothing of it (here R³×SO(3), exp). Largest position error over "
            "the largest position, in brackets the steps taken:\n\n"
            "![Error and steps over damping](lgt_stiff.png)\n\n"
            + markdown_table(["d [Ns/m]", "h/τ", *next(iter(found.values()))], rows)
        )


def _rows(found: Mapping[float, Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"method": method, "damping": damping, "h_over_tau": ratio(damping), **run}
        for damping, cell in found.items()
        for method, run in cell.items()
    ]


def _draw(path: Path, found: Mapping[float, Mapping[str, Any]]) -> None:
    with figure(path, (7.5, 3.4)) as result:
        for axes, name in zip(result.subplots(1, 2), ("error", "steps"), strict=True):
            for marker, method in zip("os^v", next(iter(found.values())), strict=True):
                values = [cell[method].get(name, np.nan) for cell in found.values()]
                axes.plot([ratio(d) for d in found], values, marker=marker, markersize=3, label=method)
            axes.set(xscale="log", yscale="log", xlabel="h / τ")
        result.axes[0].set_ylabel("position error over position")
        result.axes[1].set_ylabel("steps")
        result.axes[0].legend(fontsize=8)


CHAPTER = Stiff()
