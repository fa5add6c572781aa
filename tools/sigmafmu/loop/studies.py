"""Measures the masters of `gauss_seidel` on two systems that have a solution in one ODE: tables and figures."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.loop import sampling, tied_tops
from sigmafmu.loop.gauss_seidel import (
    EXTRAPOLATED,
    HOLD,
    ITERATED,
    LINEAR,
    SCHEMES,
    Aitken,
    CouplingError,
    FixedPoint,
    QuasiNewton,
    run,
)
from sigmafmu.plots import STYLE

STIFFNESSES = (1e4, 1e5, 1e6, 1e7)  # N/m
SPRING_STEPS = (4e-3, 2e-3, 1e-3, 5e-4)  # H, s
SPRING_STOP_TIME = 0.5  # s
SAMPLING_STEPS = (16e-3, 8e-3, 4e-3, 2e-3, 1e-3)  # H, s
SAMPLING_STOP_TIME = 1.0  # s
REFINEMENT = 16
"""H / h: the FMUs' own error falls with H as well, and stays below that of the coupling."""
SAMPLES = 8
"""Parts of a communication step between which the plant is watched; each has two internal steps."""
STEADY_ORDER = 0.3
"""Observed orders that differ by more do not belong to errors that fall with a power of H."""
MARKERS = dict(zip(SCHEMES, ("o", "s", "o", "x"), strict=True))
SOLVERS = {"fixed point": FixedPoint, "Aitken": Aitken, "quasi-Newton": QuasiNewton}

Advance = Callable[[], None]


@dataclass(frozen=True)
class Table:
    """A table for people."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass
class SpringRun:
    """One simulation of the tied tops."""

    stiffness: float  # N/m
    H: float  # s
    scheme: str
    time: np.ndarray = field(default_factory=lambda: np.zeros(0))
    error: np.ndarray = field(default_factory=lambda: np.full(1, np.nan))
    """Largest of the six coordinates' errors at each communication point, m; NaN if the run failed."""
    energy: np.ndarray = field(default_factory=lambda: np.full(1, np.nan))
    """Error of the total energy, J."""
    trials: float = np.nan
    """How many times a step was taken, on average."""


@dataclass
class SamplingRun:
    """One simulation of the speed loop."""

    H: float  # s
    scheme: str
    time: np.ndarray
    rate: np.ndarray  # rad/s
    error: float
    """Largest error of the rate, rad/s."""
    gain_error: float
    """Error of what the plant's energy grew by over the run, J."""
    trials: float
    """How many times a step was taken, on average."""
    balance: float
    """Largest difference, over the run, of the plant's gain of energy and the work of its torque so far, J."""
    residual: float
    """Residual energy, summed without sign, J."""
    mismatch: float
    """Power that torque and rate disagree about at the end of a step, on average without sign, W."""


def whole_steps(stop_time: float, H: float) -> int:
    """Communication steps of H up to `stop_time` [s]."""
    steps = int(stop_time / H * (1 + 1e-9)) if H > 0 else 0
    if steps < 2:
        raise SigmafmuError(f"the step size is {H:g} s, but must be positive and at most {stop_time / 2:g} s")
    return steps


def spring_runs(
    stiffnesses: Sequence[float] = STIFFNESSES,
    sizes: Iterable[float] = SPRING_STEPS,
    advance: Advance = lambda: None,
    *,
    schemes: Iterable[str] = SCHEMES,
) -> list[SpringRun]:
    """Every scheme with every stiffness and step size, without damping."""
    for stiffness in stiffnesses:
        if not (np.isfinite(stiffness) and stiffness > 0):
            raise SigmafmuError(f"the stiffness is {stiffness:g} N/m, but must be positive")
    steps = {H: whole_steps(SPRING_STOP_TIME, H) for H in sizes}
    fmu, runs = Fmu.of_model("HeavyTop"), []
    for stiffness in stiffnesses:
        spring = tied_tops.Spring(stiffness)
        exact = tied_tops.monolithic(spring, SPRING_STOP_TIME)
        for scheme in schemes:
            for H in steps:
                result = SpringRun(stiffness, H, scheme)
                with tied_tops.tied_tops(fmu, spring, H / REFINEMENT) as loop:
                    recorder = tied_tops.Recorder(loop)
                    recorder(0.0)
                    try:
                        result.trials = run(loop, H, steps[H], scheme, observe=recorder).mean()
                    except CouplingError:
                        pass
                    else:
                        result.time = np.array(recorder.time)
                        result.error = np.abs(np.array(recorder.position) - exact(result.time)).max(axis=1)
                        result.energy = np.array(recorder.energy) - recorder.energy[0]
                runs.append(result)
                advance()
    return runs


def solver_trials(stiffness: float, H: float, scheme: str, solver: FixedPoint) -> float:
    """Trial steps per communication step, NaN if the iteration does not converge."""
    with tied_tops.tied_tops(Fmu.of_model("HeavyTop"), tied_tops.Spring(stiffness), H / REFINEMENT) as loop:
        try:
            return run(loop, H, whole_steps(SPRING_STOP_TIME, H), scheme, solver).mean()
        except CouplingError:
            return np.nan


def sampling_runs(
    sizes: Iterable[float] = SAMPLING_STEPS,
    advance: Advance = lambda: None,
    *,
    stop_time: float = SAMPLING_STOP_TIME,
    refinement: int = REFINEMENT,
    schemes: Iterable[str] = SCHEMES,
) -> list[SamplingRun]:
    """Every scheme with every step size; H / h is `refinement`, at least SAMPLES."""
    steps = {H: whole_steps(stop_time, H) for H in sizes}
    fmu, runs = Fmu.of_model("SliderCrank"), []
    exact = sampling.monolithic(stop_time)
    for scheme in schemes:
        for H in steps:
            with sampling.speed_loop(fmu, H, H / refinement, SAMPLES) as loop:
                recorder = sampling.Recorder(loop, H)
                trials = run(loop, H, steps[H], scheme, observe=recorder).mean()
            time, rate = np.array(recorder.time), np.array(recorder.rate)
            work = np.array([bond.work() for bond in recorder.bond])
            energy = exact(np.array([0.0, time[-1]]))["energy"]
            runs.append(
                SamplingRun(
                    H,
                    scheme,
                    time,
                    rate,
                    error=np.abs(rate - exact(time)["rate"]).max(),
                    gain_error=abs(np.sum(recorder.gained) - (energy[1] - energy[0])),
                    trials=trials,
                    balance=np.abs(np.cumsum(np.array(recorder.gained) - work)).max(),
                    residual=float(np.sum([abs(bond.residual()) for bond in recorder.bond])),
                    mismatch=float(np.mean([abs(bond.mismatch()) for bond in recorder.bond])),
                )
            )
            advance()
    return runs


def spring_tables(runs: Sequence[SpringRun]) -> list[Table]:
    """Errors and energy errors over stiffness and H, trial steps of the solvers."""
    sizes = sorted({r.H for r in runs}, reverse=True)
    stiffnesses = sorted({r.stiffness for r in runs})

    def table(caption: str, value: Callable[[SpringRun], float]) -> Table:
        rows = []
        for k in stiffnesses:
            for scheme in SCHEMES:
                values = [value(r) for H in sizes for r in runs if (r.stiffness, r.scheme, r.H) == (k, scheme, H)]
                rows.append([f"{k:.0e}", scheme, *map(_number, values), _order(sizes, values)])
        return Table(caption, ["k [N/m]", "scheme", *(f"H = {1e3 * H:g} ms" for H in sizes), "order"], rows)

    trials = [
        [f"{k:.0e}", scheme, *(_trials(solver_trials(k, sizes[0], scheme, solver())) for solver in SOLVERS.values())]
        for k in stiffnesses
        for scheme in ITERATED
    ]
    return [
        table("Largest position error over the run in m.", lambda r: r.error.max()),
        table("Largest error of the total energy over the run in J.", lambda r: np.abs(r.energy).max()),
        Table(
            f"Trial steps per communication step of {1e3 * sizes[0]:g} ms, until the forces agree to 1e-8.",
            ["k [N/m]", "scheme", *SOLVERS],
            trials,
        ),
    ]


def sampling_tables(runs: Sequence[SamplingRun]) -> list[Table]:
    """Errors and energies over H."""
    sizes = sorted({r.H for r in runs}, reverse=True)

    def table(
        caption: str, value: Callable[[SamplingRun], float], text: Callable[[float], str] = lambda x: f"{x:.1e}"
    ) -> Table:
        rows = []
        for scheme in SCHEMES:
            values = [value(r) for H in sizes for r in runs if (r.scheme, r.H) == (scheme, H)]
            rows.append([scheme, *map(text, values), _order(sizes, values)])
        return Table(caption, ["scheme", *(f"H = {1e3 * H:g} ms" for H in sizes), "order"], rows)

    return [
        table("Largest error of the rate in rad/s.", lambda r: r.error),
        table("Error of what the plant's energy grew by over the run in J.", lambda r: r.gain_error),
        table("Residual energy of all steps, without sign, in J.", lambda r: r.residual),
        table("Residual power at the end of a step, mean without sign, in W.", lambda r: r.mismatch),
        table("Largest difference of the plant's gain of energy and the work of its torque in J.", lambda r: r.balance),
        table("Trial steps per communication step.", lambda r: r.trials, _trials),
    ]


def spring_figure(runs: Sequence[SpringRun]) -> Figure:
    """Energy error over time for the stiffness where the masters differ most clearly, and position errors over H.

    With a single H these are over time, too.
    """
    sizes = sorted({r.H for r in runs})
    stiffnesses = sorted({r.stiffness for r in runs})
    shown_stiffness, shown_H = stiffnesses[len(stiffnesses) // 2], sizes[len(sizes) // 2]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12, 4.2), layout="constrained")
        energy, position = figure.subplots(1, 2)
        shown = [r for r in runs if (r.stiffness, r.H) == (shown_stiffness, shown_H) and len(r.time)]
        what = f"k = {_power(shown_stiffness)} N/m, H = {1e3 * shown_H:g} ms"
        _over_time(energy, shown, lambda r: np.abs(r.energy), "J")
        energy.set_title(f"Energy error, {what}")
        if len(sizes) > 1:
            _over_size(position, runs, lambda r: r.error.max() if r.stiffness == stiffnesses[0] else None, "m")
            position.set_title(f"Largest position error, k = {_power(stiffnesses[0])} N/m")
        else:
            _over_time(position, shown, lambda r: r.error, "m")
            position.set_title(f"Position error, {what}")
        figure.legend(*position.get_legend_handles_labels(), loc="outside lower center", ncols=6)
    return figure


def sampling_figure(runs: Sequence[SamplingRun]) -> Figure:
    """Response at a large step size, error and residual energy over H."""
    exact = sampling.monolithic(SAMPLING_STOP_TIME)
    sizes = sorted({r.H for r in runs})
    shown_H = sizes[-2] if len(sizes) > 1 else sizes[0]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12, 3.8), layout="constrained")
        over_time, error, residual = figure.subplots(1, 3)
        shown_time = 0.25 * SAMPLING_STOP_TIME
        fine = np.linspace(0.0, shown_time, 500)
        over_time.plot(fine, exact(fine)["rate"], color="0.2", linewidth=2.5, alpha=0.5, label="one ODE")
        for scheme in (HOLD, EXTRAPOLATED, LINEAR):
            for r in runs:
                if (r.scheme, r.H) == (scheme, shown_H):
                    over_time.plot(r.time, r.rate, MARKERS[scheme] + "-", label=scheme, linewidth=1, markersize=3)
        over_time.set(xlabel="time in s", ylabel="rad/s", xlim=(0, shown_time), ylim=(5, 20))
        over_time.set_title(f"Rate of the crank, H = {1e3 * shown_H:g} ms")
        over_time.legend(handles=over_time.lines[:1], loc="upper left")
        _over_size(error, runs, lambda r: r.error, "rad/s")
        error.set_title("Largest error of the rate")
        _over_size(residual, runs, lambda r: r.residual, "J")
        residual.set_title("Residual energy")
        figure.legend(*residual.get_legend_handles_labels(), loc="outside lower center", ncols=6)
    return figure


def _over_time(axes: Axes, runs: Sequence[SpringRun], value: Callable, unit: str) -> None:
    for r in runs:
        axes.semilogy(r.time[1:], value(r)[1:], label=r.scheme, linewidth=1)
    axes.set(xlabel="time in s", ylabel=unit, xlim=(0, SPRING_STOP_TIME))


def _over_size(axes: Axes, runs: Sequence, value: Callable, unit: str) -> None:
    """Log-log over H, with lines of first and second order."""
    sizes = np.array(sorted({r.H for r in runs}))
    for scheme in SCHEMES:
        points = [(1e3 * r.H, v) for r in runs if r.scheme == scheme and (v := value(r)) is not None]
        axes.loglog(*np.transpose(points), MARKERS[scheme] + "-", label=scheme, markersize=5, fillstyle="none")
    start = max(v for r in runs if sizes[0] == r.H and (v := value(r)) is not None)
    for order, style in ((1, ":"), (2, "--")):
        line = start * 0.5 ** (2 * order - 1) * (sizes / sizes[0]) ** order
        axes.loglog(1e3 * sizes, line, style, color="0.5", label=f"order {order}")
    axes.set(xlabel="H in ms", ylabel=unit)
    axes.set_xticks(1e3 * sizes, labels=[f"{1e3 * H:g}" for H in sizes], minor=False)
    axes.set_xticks([], minor=True)


def _power(x: float) -> str:
    """1e6 as 10⁶ for matplotlib, other numbers as they are."""
    exponent = round(np.log10(x))
    return f"$10^{{{exponent}}}$" if np.isclose(x, 10.0**exponent) else f"{x:g}"


def _number(x: float) -> str:
    return "fails" if np.isnan(x) else f"{x:.1e}"


def _trials(x: float) -> str:
    return "does not converge" if np.isnan(x) else f"{x:.1f}"


def _order(sizes: Sequence[float], values: Sequence[float]) -> str:
    """Observed with the two smallest sizes, if the error falls as it did from the size before them."""
    if len(sizes) < 3 or not np.all(np.array(values[-3:]) > 0):
        return "–"
    before, last = np.diff(np.log(values[-3:])) / np.diff(np.log(sizes[-3:]))
    return f"{last:.2f}" if last > 0.5 and abs(last - before) < STEADY_ORDER else "–"
