"""Which σ suits a model: the closed form for every body that spins, and a scan with short runs of its FMU."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from sigmafmu import SigmafmuError
from sigmafmu.model import Model
from sigmafmu.plots import COLORS, STYLE
from sigmafmu.spin_sigma import is_nearly_symmetric, mean_ratio, unsymmetric_sigma
from sigmafmu.variables import SettingValue, parse_settings

FORMULATIONS = ("index3", "index2", "stabilizedIndex2")
SIGMAS = np.linspace(0.0, 3.0, 13)
SAMPLES = 50
LONGEST = 8000
"""Internal steps of a run, unless a stop time is given."""
AT_REST = 1e-9
"""rad/s: rounding of the initial velocities."""
WORTH_IT = 1.5
"""A smaller gain is no reason to leave σ = 1."""
VARIED = ("integrator.sigma", "integrator.sigmaMode", "integrator.formulation", "integrator.method")
TOLERANCES = ("integrator.absoluteTolerance", "integrator.relativeTolerance")
REFERENCE = {"integrator.method": "rkmk54", **dict.fromkeys(TOLERANCES, 1e-12)}
"""A method of order five with error control, which knows no σ."""


@dataclass(frozen=True)
class Spin:
    """How a body turns at the start."""

    body: str
    rate: float  # rad/s
    """Angular velocity about the principal axis that is nearest to it."""
    ratio: float | None
    """p = J_polar/J_transverse about that axis; None if the body does not turn or its moments differ too much."""
    sigma: float | None
    """σ*, None with p."""


@dataclass(frozen=True)
class Scan:
    """Largest position error of any point over a run, in m, with one formulation."""

    formulation: str
    errors: np.ndarray
    """For every one of SIGMAS; NaN where the run fails."""
    at_one: float
    best: float
    at_best: float
    spin_optimal: float
    """With integrator.sigmaMode = spinOptimal."""

    @property
    def gain(self) -> float:
        """How many times smaller the best σ makes the error."""
        return self.at_one / self.at_best


@dataclass(frozen=True)
class Advice:
    """All about one model."""

    model: str
    step_size: float  # s
    stop_time: float  # s
    rho_inf: float
    spins: list[Spin]
    scans: list[Scan]


def advise(
    model: Model,
    parameters: Mapping[str, SettingValue],
    stop_time: float | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Advice:
    """Look at `model` with `parameters`, as `Model.run` takes them; `advance` is called `runs(model)` times."""
    chosen = {variable.name: value for variable, value in parse_settings(model.fmu, parameters)}
    for name in VARIED:
        if name in chosen:
            raise SigmafmuError(f"'{name}' cannot be set here: the scan varies it")
    values = {name: float(chosen.get(name, model.variables[name].start)) for name in _INTEGRATOR}
    h, rho_inf = values[_INTEGRATOR[0]], values[_INTEGRATOR[1]]
    default = model.stop_time
    stop_time = min(default, LONGEST * h) if stop_time is None else stop_time

    exact = _positions(model, {**parameters, **REFERENCE}, stop_time)
    advance()
    if np.ptp(exact, axis=0).max() == 0:
        raise SigmafmuError(f"{model.name} does not move in {stop_time:g} s; set an input or a start value")

    def error(**integrator: SettingValue) -> float:
        own = {f"integrator.{name}": value for name, value in integrator.items()}
        try:
            difference = _positions(model, {**parameters, **own}, stop_time) - exact
        except SigmafmuError:
            return np.nan
        finally:
            advance()
        return float(np.linalg.norm(difference, axis=2).max())

    scans = [_scan(formulation, error) for formulation in _formulations(model)]
    return Advice(model.name, h, stop_time, rho_inf, _spins(model, parameters, chosen, h, rho_inf), scans)


def runs(model: Model) -> int:
    """How often `advise` calls `advance`."""
    return 1 + (len(SIGMAS) + 2) * len(_formulations(model))


_INTEGRATOR = ("integrator.stepSize", "integrator.spectralRadius")


def _formulations(model: Model) -> tuple[str, ...]:
    """Without joints they are all the same."""
    return FORMULATIONS if any(name.endswith(".reactionForce[1]") for name in model.variables) else FORMULATIONS[:1]


def _positions(model: Model, parameters: Mapping[str, SettingValue], stop_time: float) -> np.ndarray:
    """Every point whose position is an output, (times, points, 3)."""
    result = model.run(stop_time, step_size=stop_time / SAMPLES, parameters=parameters, outputs=["*.position"])
    return result.values.reshape(len(result.time), -1, 3)


def _scan(formulation: str, error: Callable[..., float]) -> Scan:
    errors = np.array([error(formulation=formulation, sigma=float(s)) for s in SIGMAS])
    at_one = errors[np.searchsorted(SIGMAS, 1.0)]
    if not np.isfinite(at_one):
        raise SigmafmuError(f"the run with {formulation} and σ = 1 fails; try a smaller integrator.stepSize")
    best = round(_minimum(errors), 2)
    at_best = error(formulation=formulation, sigma=best)
    if not at_best < np.nanmin(errors):  # the parabola is an estimate
        best, at_best = float(SIGMAS[np.nanargmin(errors)]), float(np.nanmin(errors))
    mode = error(formulation=formulation, sigma=1.0, sigmaMode="spinOptimal")
    return Scan(formulation, errors, at_one, best, at_best, mode)


def _minimum(errors: np.ndarray) -> float:
    """Of the parabola through the squares around the smallest error: to leading order an error is affine in σ."""
    i = int(np.clip(np.nanargmin(errors), 1, len(SIGMAS) - 2))
    near = slice(i - 1, i + 2)
    if not np.isfinite(errors[near]).all():
        return float(SIGMAS[i])
    a, b, _ = np.polyfit(SIGMAS[near], errors[near] ** 2, 2)
    return float(np.clip(-b / (2 * a) if a > 0 else SIGMAS[i], SIGMAS[0], SIGMAS[-1]))


def _spins(
    model: Model, parameters: Mapping[str, SettingValue], chosen: Mapping[str, float], h: float, rho_inf: float
) -> list[Spin]:
    """Every rigid body at the start."""
    bodies = [name.removesuffix(".inertia.xx") for name in model.variables if name.endswith(".inertia.xx")]
    if not bodies:
        return []
    names = [f"{body}.angularVelocity" for body in bodies]
    start = model.run(h, step_size=h, parameters=parameters, outputs=names)
    result = []
    for body in bodies:

        def inertia(entry: str, body: str = body) -> float:
            name = f"{body}.inertia.{entry}"
            return float(chosen.get(name, model.variables[name].start))

        matrix = np.array([[inertia("".join(sorted(i + j))) for j in "xyz"] for i in "xyz"])
        result.append(_spin(body, matrix, start[f"{body}.angularVelocity"][0], rho_inf))
    return result


def _spin(body: str, inertia: np.ndarray, omega: np.ndarray, rho_inf: float) -> Spin:
    moments, axes = np.linalg.eigh(inertia)
    components = axes.T @ omega
    i = int(np.argmax(np.abs(components)))
    rate = abs(float(components[i]))
    order = np.array([moments[i], *np.delete(moments, i)])
    if rate < AT_REST:
        return Spin(body, 0.0, None, None)
    if not is_nearly_symmetric(order):
        return Spin(body, rate, None, None)
    return Spin(body, rate, mean_ratio(order), unsymmetric_sigma(rho_inf, order))


def sentences(advice: Advice) -> list[str]:
    """What to do with each formulation, and which of them is the best."""
    result = []
    for scan in advice.scans:
        name = scan.formulation if len(advice.scans) > 1 else "all formulations (there is no joint)"
        at_end = f"≥ {scan.best:g}" if scan.best == SIGMAS[-1] else f"= {scan.best:g}"
        if scan.gain < WORTH_IT:
            text = f"keep σ = 1; the best, σ {at_end}, gains a factor {scan.gain:.2f}"
        else:
            text = f"σ {at_end} makes the error {scan.gain:.2g} times smaller than σ = 1"
        if scan.at_one > WORTH_IT * scan.spin_optimal:
            text += f"; sigmaMode = spinOptimal {scan.at_one / scan.spin_optimal:.2g} times"
        result.append(f"{name}: {text}")
    if len(advice.scans) > 1:
        best = min(advice.scans, key=lambda s: s.at_best)
        if advice.scans[-1].at_best < WORTH_IT * best.at_best:
            best = advice.scans[-1]  # the one that keeps positions and velocities
        sigma = 1.0 if best.gain < WORTH_IT else best.best
        error = best.at_one if best.gain < WORTH_IT else best.at_best
        result.append(
            f"smallest error, {error:.1e} m: --set integrator.formulation={best.formulation} "
            f"--set integrator.sigma={sigma:g}"
        )
    return result


def figure(advice: Advice) -> Figure:
    """Error over σ for every formulation; a dot at the best, a dotted line for spinOptimal where it differs."""
    with mpl.rc_context(STYLE):
        result = Figure(figsize=(7.5, 4.5), layout="constrained")
        axes = result.subplots()
        for color, scan in zip(COLORS, advice.scans, strict=False):
            label = scan.formulation if len(advice.scans) > 1 else "every formulation"
            axes.semilogy(SIGMAS, scan.errors, "-o", markersize=3, color=color, label=label)
            axes.plot(scan.best, scan.at_best, "*", markersize=11, color=color)
            if scan.at_one > WORTH_IT * scan.spin_optimal:
                axes.axhline(scan.spin_optimal, color=color, linestyle=":", label="sigmaMode = spinOptimal")
        for spin in advice.spins:
            if spin.sigma and SIGMAS[0] <= spin.sigma <= SIGMAS[-1] and advice.step_size * spin.rate > FAST:
                axes.axvline(spin.sigma, color="0.4", linestyle="--", linewidth=1, label=f"σ* of {spin.body}")
        axes.axvline(1.0, color="0.8", linewidth=1)
        axes.set(xlabel="σ", ylabel="largest position error in m")
        axes.set_title(f"{advice.model}, h = {advice.step_size:g} s, {advice.stop_time:g} s, ρ∞ = {advice.rho_inf:g}")
        axes.legend()
    return result


FAST = 1e-3
"""h Ω in rad above which a body's spin is worth a line in the figure."""
