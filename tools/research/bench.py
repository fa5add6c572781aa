"""What an internal step costs, in the core and through fmi2DoStep, beside Exudyn in the same run.

All candidates run in turn, several rounds; each keeps its fastest round, so that another load on the machine disturbs
least. Errors are those at the end of the run against the independent minimal-coordinate solution.
"""

import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from time import perf_counter

import numpy as np
from rich import box
from rich.table import Table

from sigmafmu import SigmafmuError, __version__, _core
from sigmafmu.fmu import Fmu
from sigmafmu.markdown import markdown_table
from sigmafmu.realtime import native_steps

FORMULATIONS = {"index3": 1, "index2": 2, "stabilizedIndex2": 3}
INTERNAL_STEPS_PER_CALL = 10
"""Internal steps in one fmi2DoStep."""


@dataclass(frozen=True)
class Case:
    """One mechanism at one step size; `point` is the position whose error counts."""

    model: str
    step_size: float  # s
    stop_time: float  # s
    rho_inf: float
    point: str
    variants: tuple[tuple[str, float], ...]  # (formulation, σ) to run


# Exudyn has its σ built in: the incremental form with half the printed line 6, which acts like σ ≈ 1.5. So each case
# has the default of the FMU, σ = 1, and a σ near the best for the mechanism.
CASES = (
    # ρ∞ = 0.65, since Exudyn's σ scheme fails here from 0.8 on
    Case("HeavyTop", 1e-4, 0.5, 0.65, "top.position", (("stabilizedIndex2", 1.0), ("index3", 1.0), ("index3", 1.8))),
    Case("HighSpeedRotor", 1e-5, 0.1, 0.9, "leftSupport.position", (("stabilizedIndex2", 1.0), ("index3", 1.7))),
    Case("SliderCrank", 1e-3, 1.0, 0.9, "slider.position", (("stabilizedIndex2", 1.0), ("index3", 1.0))),
)


@dataclass
class Candidate:
    """One way to simulate a case. `run` returns (seconds per internal step, iterations per step, final position)."""

    label: str
    run: Callable[[], tuple[float, float, np.ndarray]]
    peer: bool = False
    seconds: list[float] = field(default_factory=list)
    iterations: float = 0.0
    error: float = np.nan


def machine() -> str:
    """Processor and software that a result belongs to."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = names[0].split(":", 1)[1].strip() if names else cpu
    return f"{cpu}, {platform.system()}, sigmafmu {__version__}, Exudyn {version('exudyn')}"


def _core_run(case: Case, formulation: str, sigma: float) -> tuple[float, float, np.ndarray]:
    mechanism = _core.mechanism(case.model)
    mechanism.integrator.step_size = case.step_size
    mechanism.integrator.spectral_radius = case.rho_inf
    mechanism.integrator.formulation = FORMULATIONS[formulation]
    mechanism.integrator.sigma = sigma
    simulation = _core.Simulation(mechanism)
    steps = round(case.stop_time / case.step_size)
    start = perf_counter()
    simulation.run(case.stop_time, steps)
    seconds = perf_counter() - start
    state = simulation.state
    return seconds / steps, state.counters.newton_iterations / steps, _point_of_state(case, state.q)


def _point_of_state(case: Case, q: np.ndarray) -> np.ndarray:
    """Position of the case's point from the coordinates: 7 numbers for each body."""
    body = {"top": 0, "slider": 2, "leftSupport": 0}[case.point.split(".")[0]]
    position = q[7 * body : 7 * body + 3]
    if case.point.startswith("leftSupport"):
        position = position + _core.lie.rotation_matrix(q[3:7]) @ np.array([-0.11, 0.0, 0.0])
    return position


def _fmu_run(case: Case, fmu: Fmu, formulation: str, sigma: float) -> tuple[float, float, np.ndarray]:
    slave = fmu.instantiate()
    try:
        names = ["integrator.stepSize", "integrator.spectralRadius", "integrator.sigma"]
        slave.setReal(fmu.references(names), [case.step_size, case.rho_inf, sigma])
        slave.setInteger(fmu.references(["integrator.formulation"]), [FORMULATIONS[formulation]])
        slave.setupExperiment()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        steps = round(case.stop_time / case.step_size)
        calls = steps // INTERNAL_STEPS_PER_CALL
        began = perf_counter()
        native_steps(slave, INTERNAL_STEPS_PER_CALL * case.step_size, calls)
        seconds = (perf_counter() - began) / calls
        (iterations,) = slave.getInteger(fmu.references(["integrator.newtonIterations"]))
        position = np.array(slave.getReal(fmu.references([f"{case.point}[{i}]" for i in (1, 2, 3)])))
        return seconds / INTERNAL_STEPS_PER_CALL, iterations / steps, position
    finally:
        slave.freeInstance()


def _exudyn_run(case: Case, modified: bool) -> tuple[float, float, np.ndarray]:
    from research.reference.exudyn_models import Settings, simulate

    settings = Settings(
        case.step_size, rotation="lieGroup", scheme="index3", rho_inf=case.rho_inf, modified_newton=modified
    )
    run = simulate(case.model, settings, stop_time=case.stop_time)
    return run.cpu_time / run.steps, run.newton_iterations / run.steps, np.full(3, np.nan)


def _exudyn_error(case: Case, modified: bool, exact: np.ndarray) -> float:
    """Error of the run that `_exudyn_run` times, which stores nothing."""
    from research.reference.exudyn_models import Settings, simulate

    settings = Settings(
        case.step_size, rotation="lieGroup", scheme="index3", rho_inf=case.rho_inf, modified_newton=modified
    )
    history = simulate(case.model, settings, stop_time=case.stop_time, sample_step=case.stop_time).history
    return float(np.linalg.norm(_last(history, case.point) - exact))


def _last(history: dict[str, np.ndarray], point: str) -> np.ndarray:
    return np.array([history[f"{point}[{i}]"][-1] for i in (1, 2, 3)])


def measure(case: Case, rounds: int, advance: Callable[[], None]) -> list[Candidate]:
    """All candidates of a case, the peers first; `advance` is called after each run."""
    from research.reference.minimal_coordinates import solve

    fmu = Fmu.of_model(case.model)
    candidates = [
        Candidate("Exudyn, σ-modified, index 3, full Newton", lambda: _exudyn_run(case, False), peer=True),
        Candidate("Exudyn, σ-modified, index 3, modified Newton", lambda: _exudyn_run(case, True), peer=True),
    ]
    for formulation, sigma in case.variants:
        name = f"{formulation}, σ = {sigma:g}"
        candidates += [
            Candidate(f"core, {name}", lambda f=formulation, s=sigma: _core_run(case, f, s)),
            Candidate(f"FMU, {name}", lambda f=formulation, s=sigma: _fmu_run(case, fmu, f, s)),
        ]
    exact = _last(solve(case.model, np.array([0.0, case.stop_time])), case.point)
    for _ in range(rounds):
        for candidate in candidates:
            seconds, candidate.iterations, position = candidate.run()
            candidate.seconds.append(seconds)
            candidate.error = float(np.linalg.norm(position - exact))
            advance()
    for candidate, modified in zip(candidates[:2], (False, True), strict=True):
        candidate.error = _exudyn_error(case, modified, exact)
    return candidates


def rows(candidates: list[Candidate]) -> list[list[str]]:
    """Label, µs per step, times faster than the faster Exudyn run, iterations per step, position error in m."""
    best_peer = min(min(c.seconds) for c in candidates if c.peer)
    return [
        [
            c.label,
            f"{min(c.seconds) * 1e6:.2f}",
            "" if c.peer else f"{best_peer / min(c.seconds):.1f}",
            f"{c.iterations:.2f}",
            f"{c.error:.1e}",
        ]
        for c in candidates
    ]


HEADER = ("", "µs per step", "times faster", "iterations", "position error [m]")


def title(case: Case) -> str:
    """What was run."""
    return f"{case.model}: h = {case.step_size:g} s, ρ∞ = {case.rho_inf:g}, t = {case.stop_time:g} s"


def table(case: Case, candidates: list[Candidate]) -> Table:
    """The result of one case for the terminal."""
    result = Table(title=title(case), box=box.SIMPLE_HEAD, title_justify="left")
    for i, name in enumerate(HEADER):
        result.add_column(name, justify="right" if i else "left")
    for row in rows(candidates):
        result.add_row(*row)
    return result


def page(results: list[tuple[Case, list[Candidate]]]) -> str:
    """The result of all cases as a Markdown page."""
    parts = [f"# Cost of an internal step\n\n{__doc__.split(chr(10), 2)[2].strip()}\n\n{machine()}.\n"]
    for case, candidates in results:
        parts.append(f"\n## {title(case)}\n\n{markdown_table(HEADER, rows(candidates))}")
    return "".join(parts)


def run(rounds: int, advance: Callable[[], None]) -> list[tuple[Case, list[Candidate]]]:
    """Measure all cases."""
    from research.reference.exudyn_models import load_exudyn

    try:
        load_exudyn(fast=True)
    except RuntimeError as error:
        raise SigmafmuError(f"the benchmark cannot run: {error}") from error
    return [(case, measure(case, rounds, advance)) for case in CASES]


def runs(rounds: int) -> int:
    """How often `run` calls `advance`."""
    return rounds * sum(2 + 2 * len(case.variants) for case in CASES)
