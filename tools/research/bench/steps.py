"""A step of every mechanism in every formulation, beside Exudyn and the limit kernels."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from research.bench import Effort, limits, runs
from research.mechanisms import linkages, named
from research.reference import chain
from research.reference.minimal_coordinates import solve
from sigmafmu import _core
from sigmafmu.fmu import Fmu
from sigmafmu.markdown import markdown_table

TITLE = "Every mechanism and formulation"
FILE = "steps.csv"


@dataclass(frozen=True)
class Case:
    """A mechanism at a step size, from its start to stop_time."""

    name: str
    step_size: float  # s
    stop_time: float  # s
    rho_inf: float = 0.9
    sigma: float = 1.0  # besides 1, tried with index 3
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the last body, m
    output: str = ""  # of the FMU, at that point
    alone: bool = False  # not in Exudyn here
    regular: Callable[[], _core.Mechanism] | None = None  # what Exudyn gets: its fast solvers take no redundant joints

    @property
    def steps(self) -> int:
        """Internal steps of a run."""
        return round(self.stop_time / self.step_size)

    def mechanism(self) -> _core.Mechanism:
        """A fresh one."""
        return _core.mechanism(self.name) if self.name in _core.mechanisms() else named(self.name)


def _regular(build: Callable[..., _core.Mechanism], *size: int) -> Callable[[], _core.Mechanism]:
    return partial(build, *size, linkages.REGULAR[build])


# Exudyn has its σ built in: the incremental form with half the printed line 6, which acts like σ ≈ 1.5. So three
# mechanisms have a σ near their best as well. ρ∞ = 0.65 for the top, since Exudyn's σ scheme fails there from 0.8 on.
CASES = (
    Case("HeavyTop", 1e-4, 0.5, rho_inf=0.65, sigma=1.8, output="top.position"),
    Case("HighSpeedRotor", 1e-5, 0.1, sigma=1.7, point=(-0.11, 0.0, 0.0), output="leftSupport.position"),
    Case("SliderCrank", 1e-3, 1.0, output="slider.position"),
    Case("FreeBody", 1e-3, 5.0),
    Case("PlanarFourBar", 1e-3, 1.0, regular=_regular(linkages.planar_four_bar)),
    Case("DoubleFourBar", 1e-3, 0.6, regular=_regular(linkages.four_bar_row, 2)),
    Case("FourBarRow10", 1e-3, 0.3, regular=_regular(linkages.four_bar_row, 10)),
    Case("Bricard", 1e-3, 1.0, regular=_regular(linkages.bricard)),
    Case("RevoluteArm7", 1e-3, 0.5),
    Case("Humanoid", 1e-3, 0.2),
    Case("Chain10", 1e-3, 0.5, point=(0.5, 0.0, 0.0)),
    Case("RevoluteChain10", 1e-3, 0.5),
    Case("RandomTree30", 1e-3, 0.2),
    Case("FlexiblePendulum", 1e-4, 0.1, alone=True),
    Case("FlexibleSliderCrank", 1e-4, 0.1, alone=True),
    Case("SpinUpBeam", 5e-3, 5.0, alone=True),
)
QUICK = ("HeavyTop", "SliderCrank", "PlanarFourBar", "RevoluteArm7", "Chain10")
EXUDYN_MODELS = ("HeavyTop", "HighSpeedRotor", "SliderCrank")
"""Built by research.reference.exudyn_models; Exudyn gets the others from our definition."""
SPARSE_FROM = 5
"""Bodies from which on Exudyn's sparse solver is tried as well."""

Candidates = dict[tuple[str, str, float], Callable[[], runs.Run]]
"""By code, formulation or kind of Newton's method, and σ."""


def measure(effort: Effort) -> list[dict[str, Any]]:
    """A row for each way to run each case."""
    return [row for case in CASES if not effort.quick or case.name in QUICK for row in _measure(case, effort)]


def _exudyn(case: Case) -> Candidates:
    own = case.name in EXUDYN_MODELS
    model = case.name if own else (case.regular or case.mechanism)().multibody
    bodies = len(case.mechanism().multibody.bodies)
    result: Candidates = {}
    for modified in (False, True):
        for sparse in (False, True) if bodies >= SPARSE_FROM else (False,):
            what = f"{'modified' if modified else 'full'} Newton{', sparse' if sparse else ''}"
            settings = {"rho_inf": case.rho_inf, "modified": modified, "sparse": sparse}
            result["Exudyn", what, np.nan] = partial(
                runs.exudyn, model, case.step_size, case.steps, np.array(case.point), **settings
            )
    return result


def _ours(case: Case) -> Candidates:
    h, steps, point = case.step_size, case.steps, np.array(case.point)
    variants = [(formulation, 1.0) for formulation in reversed(runs.FORMULATIONS)]
    if case.sigma != 1.0:
        variants.append(("index3", case.sigma))
    fmu = Fmu.of_model(case.name) if case.output else None
    result: Candidates = {}
    for formulation, sigma in variants:
        settings = {"spectral_radius": case.rho_inf, "formulation": runs.FORMULATIONS[formulation], "sigma": sigma}
        result["core", formulation, sigma] = lambda settings=settings: runs.core(
            case.mechanism(), h, steps, point, **settings
        )
        if fmu:
            parameters = {"integrator.spectralRadius": case.rho_inf, "integrator.sigma": sigma}
            result["FMU", formulation, sigma] = partial(runs.fmu, fmu, case.output, h, steps, parameters, formulation)
    return result


def _measure(case: Case, effort: Effort) -> Iterator[dict[str, Any]]:
    effort.tell(case.name)
    found = runs.fastest({**({} if case.alone else _exudyn(case)), **_ours(case)}, effort.rounds)
    exact = _exact(case)
    peer = min((run.seconds for (code, _, _), run in found.items() if code == "Exudyn"), default=np.nan)
    limit = limits.chains().get(10, (None,))[0] if case.name == "Chain10" else limits.seconds_per_step(case.name)
    for (code, what, sigma), run in found.items():
        yield {
            "mechanism": case.name,
            "code": code,
            "what": what,
            "sigma": sigma,
            "step_size": case.step_size,
            "stop_time": case.stop_time,
            "rho_inf": case.rho_inf,
            "ns_per_step": 1e9 * run.seconds,
            "iterations": run.iterations,
            "ns_per_iteration": 1e9 * run.seconds / run.iterations,
            "times_faster": np.nan if code == "Exudyn" else peer / run.seconds,
            "times_limit": np.nan if code == "Exudyn" or limit is None else run.seconds / limit,
            "error": np.nan if exact is None else float(np.linalg.norm(run.position - exact)),
        }


def _exact(case: Case) -> np.ndarray | None:
    """Where the point is at the end, from an independent solution; None: there is none here."""
    if case.output:
        history = solve(case.name, np.array([0.0, case.stop_time]))
        return np.array([history[f"{case.output}[{i}]"][-1] for i in (1, 2, 3)])
    return chain.tip(10, case.stop_time) if case.name == "Chain10" else None


HEADER = ("", "ns per step", "iterations", "ns per iteration", "times faster", "/ limit", "error [m]")


def report(rows: list[dict[str, Any]], _: Path) -> str:
    """A table for each mechanism."""
    parts = [
        "Exudyn runs its σ-modified index-3 scheme with Lie group nodes, full and modified Newton, dense and sparse; "
        "*times faster* is beside the fastest of these. *Core* is the integrator called from C++, *FMU* the same "
        f"through `fmi2DoStep` with {runs.INTERNAL_STEPS_PER_CALL} internal steps in a call. Where all joints of a "
        "linkage are hinges, Exudyn gets a ball and a sleeve in place of the redundant ones. Errors are those of a "
        "point of the last body at the end, where an independent solution in minimal coordinates is at hand. "
        "*/ limit* is beside a program written for this mechanism alone, index 3 with general blocks"
        f"{_limits_told(rows)}.\n"
    ]
    for name in dict.fromkeys(row["mechanism"] for row in rows):
        mine = [row for row in rows if row["mechanism"] == name]
        first = mine[0]
        parts.append(
            f"\n### {name}: h = {first['step_size']:g} s, ρ∞ = {first['rho_inf']:g}, t = {first['stop_time']:g} s\n\n"
            + markdown_table(HEADER, [_cells(row) for row in mine])
        )
    return "".join(parts)


def _limits_told(rows: list[dict[str, Any]]) -> str:
    return "" if any(row["times_limit"] > 0 for row in rows) else "; these were not at hand"


def _cells(row: dict[str, Any]) -> list[str]:
    sigma = "" if np.isnan(row["sigma"]) else f", σ = {row['sigma']:g}"
    formats = {
        "ns_per_step": ".0f",
        "iterations": ".2f",
        "ns_per_iteration": ".0f",
        "times_faster": ".1f",
        "times_limit": ".2f",
        "error": ".1e",
    }
    values = ["" if np.isnan(row[key]) else f"{row[key]:{form}}" for key, form in formats.items()]
    return [f"{row['code']}, {row['what']}{sigma}", *values]
