"""Measures what the documentation says about accuracy, and writes it as a Markdown page.

Every error is against the independent minimal-coordinate solutions of `research.reference.minimal_coordinates`.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache

import numpy as np

from research.reference.minimal_coordinates import solve
from sigmafmu import __version__, _core
from sigmafmu.markdown import markdown_table

INDEX3, INDEX2, STABILIZED = 1, 2, 3
RESIDUAL, INCREMENTAL = 1, 2
FORMULATION_NAMES = {INDEX3: "index 3", INDEX2: "index 2", STABILIZED: "stabilized index 2"}

# Body whose position is followed, joints whose first three multipliers are minus their force on the second body, and
# for the orders: end time and step sizes in the asymptotic range.
TRACKED = {"HeavyTop": (0, "top"), "HighSpeedRotor": (0, "rotor"), "SliderCrank": (2, "slider")}
MULTIPLIERS = {
    "HeavyTop": {"pivot": 0},
    "HighSpeedRotor": {},
    "SliderCrank": {"crankPivot": 0, "crankPin": 5, "wristPin": 8},
}
ORDER_RUNS = {
    "HeavyTop": (0.5, (2.5e-4, 1.25e-4, 6.25e-5)),
    "HighSpeedRotor": (0.02, (1e-5, 5e-6, 2.5e-6)),
    "SliderCrank": (1.0, (2.5e-4, 1.25e-4, 6.25e-5)),
}
SAMPLES = 50
Rows = list[Sequence[str]]
Advance = Callable[[], None]


def simulation(model: str, h: float, **settings: float) -> _core.Simulation:
    """A simulation of `model` with internal step `h` [s] and other integrator settings."""
    mechanism = _core.mechanism(model)
    mechanism.integrator.step_size = h
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    return _core.Simulation(mechanism)


@lru_cache(maxsize=8)
def exact(model: str, stop_time: float, samples: int) -> dict[str, np.ndarray]:
    """Independent solution at `samples` + 1 equidistant times."""
    return solve(model, np.linspace(0.0, stop_time, samples + 1))


def columns(history: dict[str, np.ndarray], name: str) -> np.ndarray:
    """The vector `name` of a history, (times, 3)."""
    return np.column_stack([history[f"{name}[{i}]"] for i in (1, 2, 3)])


def errors(model: str, stop_time: float, h: float, **settings: float) -> tuple[float, float, float]:
    """Largest errors over the run: position [m], velocity [m/s], multipliers [N] (NaN where there are none)."""
    steps = round(stop_time / h)
    stride = steps // SAMPLES
    _, q, v, multipliers = simulation(model, h, **settings).trajectory(stop_time, steps)
    reference = exact(model, stop_time, SAMPLES)
    body, name = TRACKED[model]

    def largest(values: np.ndarray, expected: np.ndarray) -> float:
        return float(np.linalg.norm(values[::stride] - expected, axis=1).max())

    forces = [
        largest(-multipliers[:, first : first + 3], columns(reference, f"{joint}.reactionForce"))
        for joint, first in MULTIPLIERS[model].items()
    ]
    return (
        largest(q[:, 7 * body : 7 * body + 3], columns(reference, f"{name}.position")),
        largest(v[:, 6 * body : 6 * body + 3], columns(reference, f"{name}.velocity")),
        max(forces, default=np.nan),
    )


def observed_orders(model: str, rho_inf: float) -> list[float]:
    """Least-squares slopes of log(error) over log(h), stabilized index 2: position, velocity, multipliers."""
    stop_time, steps = ORDER_RUNS[model]
    found = [
        errors(model, stop_time, h, spectral_radius=rho_inf, relative_tolerance=1e-12, absolute_tolerance=1e-14)
        for h in steps
    ]
    return [float(np.polyfit(np.log(steps), np.log(column), 1)[0]) for column in np.array(found).T]


def final_error(model: str, point: str, stop_time: float, h: float, **settings: float) -> float:
    """Error of a position at the end [m]; NaN when the run fails."""
    run = simulation(model, h, **settings)
    try:
        run.run(stop_time, round(stop_time / h))
    except RuntimeError:
        return np.nan
    body, _ = TRACKED[model]
    position = run.state.q[7 * body : 7 * body + 3]
    if point == "rightSupport.position":
        position = position + _core.lie.rotation_matrix(run.state.q[3:7]) @ np.array([0.09, 0.0, 0.0])
    return float(np.linalg.norm(position - columns(exact(model, stop_time, 1), point)[-1]))


def energy_error(model: str, rho_inf: float, formulation: int, stop_time: float = 20.0) -> tuple[float, float]:
    """Relative to the largest kinetic energy: largest energy error in the first and in the second half of the run."""
    h = 1e-3 if model == "HeavyTop" else 5e-4
    run = simulation(model, h, spectral_radius=rho_inf, formulation=formulation)
    multibody = _core.mechanism(model).multibody
    system = _core.System(multibody)
    samples = 2000
    energies, kinetic = [], []
    try:
        for i in range(samples + 1):
            run.run(stop_time * i / samples, round(stop_time / samples / h) if i > 0 else 0)
            energies.append(system.energy(run.state.q, run.state.v))
            kinetic.append(energies[-1] - system.energy(run.state.q, 0 * run.state.v))
    except RuntimeError:  # a failed step; what is missing counts as NaN
        energies += [np.nan] * (samples + 1 - len(energies))
    deviation = np.abs(np.array(energies) - energies[0]) / max(kinetic)
    half = samples // 2
    return float(deviation[:half].max()), float(deviation[half:].max())


def _number(x: float) -> str:
    return "fails" if np.isnan(x) else f"{x:.1e}"


def orders_section(advance: Advance) -> str:
    """Observed orders of all mechanisms."""
    rows: Rows = []
    for model in TRACKED:
        for rho in (1.0, 0.9, 0.65, 0.5):
            found = observed_orders(model, rho)
            rows.append([model, f"{rho:g}", *("–" if np.isnan(x) else f"{x:.2f}" for x in found)])
            advance()
    text = "Stabilized index 2, σ = 1, residual corrector; largest error over the run, three halvings of h.\n\n"
    return text + markdown_table(["mechanism", "ρ∞", "position", "velocity", "multipliers"], rows)


def heavy_top_section(advance: Advance) -> str:
    """Position error of the heavy top at 1 s for every scheme."""
    alpha = _core.AlphaParameters(0.9)
    optimal = alpha.gamma / (3 * alpha.beta)
    schemes = [
        ("geom1 (σ = 0)", 0.0, RESIDUAL),
        ("σ = γ/(3β)", optimal, RESIDUAL),
        ("σ = 1", 1.0, RESIDUAL),
        ("σ = 1.6", 1.6, RESIDUAL),
        ("σ = 1, incremental (Alg. 1, 3 as printed)", 1.0, INCREMENTAL),
    ]
    rows: Rows = []
    for label, sigma, corrector in schemes:
        values = [
            final_error(
                "HeavyTop", "top.position", 1.0, 2.5e-4, sigma=sigma, corrector=corrector, formulation=formulation
            )
            for formulation in FORMULATION_NAMES
        ]
        rows.append([label, *map(_number, values)])
        advance()
    text = "HeavyTop, ρ∞ = 0.9, h = 2.5e-4 s: error of the position at 1 s in m.\n\n"
    return text + markdown_table(["scheme", *FORMULATION_NAMES.values()], rows)


def robustness_section(advance: Advance) -> str:
    """Heavy top over ρ∞ and h."""
    steps = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
    rows: Rows = []
    for rho in (0.0, 0.3, 0.5, 0.65, 0.8, 0.9, 1.0):
        values = [final_error("HeavyTop", "top.position", 1.0, h, spectral_radius=rho) for h in steps]
        rows.append([f"{rho:g}", *map(_number, values)])
        advance()
    text = "HeavyTop, stabilized index 2, σ = 1: error of the position at 1 s in m.\n\n"
    return text + markdown_table(["ρ∞", *(f"h = {h:g} s" for h in steps)], rows)


def rotor_section(advance: Advance) -> str:
    """Bearing position of the rotor."""
    steps = (2e-5, 1e-5, 5e-6)
    rows: Rows = []
    for sigma in (0.0, 1.0, 1.7):
        values = [final_error("HighSpeedRotor", "rightSupport.position", 0.2, h, sigma=sigma) for h in steps]
        rows.append([f"{sigma:g}", *map(_number, values)])
        advance()
    text = "HighSpeedRotor, ρ∞ = 0.9: error of the right bearing's position at 0.2 s in m.\n\n"
    return text + markdown_table(["σ", *(f"h = {h:g} s" for h in steps)], rows)


def slider_crank_section(advance: Advance) -> str:
    """Slider position, constraint residuals and joint forces of the slider-crank."""
    rows: Rows = []
    for stop_time in (2.0, 5.0):
        position, velocity, multipliers = errors("SliderCrank", stop_time, 1e-4)
        reference = exact("SliderCrank", stop_time, SAMPLES)
        largest = max(np.abs(columns(reference, f"{j}.reactionForce")).max() for j in MULTIPLIERS["SliderCrank"])
        run = simulation("SliderCrank", 1e-4)
        system = _core.System(_core.mechanism("SliderCrank").multibody)
        phi = phidot = 0.0
        for i in range(1, 1001):
            run.run(stop_time * i / 1000, round(stop_time * 10))
            residuals = system.constraints(run.state.q, run.state.v)
            phi = max(phi, np.abs(residuals[0]).max())
            phidot = max(phidot, np.abs(residuals[1]).max())
        rows.append(
            [
                f"0 … {stop_time:g} s",
                *map(_number, (position, velocity, multipliers / largest, float(phi), float(phidot))),
            ]
        )
        advance()
    text = "SliderCrank, stabilized index 2, σ = 1, ρ∞ = 0.9, h = 1e-4 s: largest values over the run.\n\n"
    header = ["run", "position [m]", "velocity [m/s]", "joint forces, relative", "Φ", "dΦ/dt"]
    return text + markdown_table(header, rows)


def energy_section(advance: Advance) -> str:
    """Energy errors over 20 s."""
    rows: Rows = []
    for model in ("HeavyTop", "SliderCrank"):
        for formulation, name in FORMULATION_NAMES.items():
            for rho in (1.0, 0.9, 0.5):
                rows.append([model, name, f"{rho:g}", *map(_number, energy_error(model, rho, formulation))])
                advance()
    text = (
        "Largest energy error over the largest kinetic energy in the first and the second 10 s of a 20 s run "
        "(h = 1e-3 s for HeavyTop, 5e-4 s for SliderCrank). At ρ∞ = 1 nothing damps the multipliers of index 3: they\n"
        "grow until a step fails, which is why the FMU warns of that combination.\n\n"
    )
    return text + markdown_table(["mechanism", "formulation", "ρ∞", "0 … 10 s", "10 … 20 s"], rows)


SECTIONS: dict[str, tuple[Callable[[Advance], str], int]] = {
    "Order": (orders_section, 12),
    "Heavy top: schemes": (heavy_top_section, 5),
    "Heavy top: robustness": (robustness_section, 7),
    "High-speed rotor: σ": (rotor_section, 3),
    "Slider-crank": (slider_crank_section, 2),
    "Energy": (energy_section, 18),
}


def runs() -> int:
    """How often `page` calls `advance`."""
    return sum(count for _, count in SECTIONS.values())


def page(advance: Advance) -> Iterator[str]:
    """The parts of the Markdown page."""
    yield f"# Measured accuracy\n\nWritten by `make measure`, sigmafmu {__version__}.\n"
    yield "Errors are against independent solutions in minimal coordinates\n"
    yield "(`tools/research/reference/minimal_coordinates.py`), whose own error is below 1e-9 of the values.\n"
    for title, (section, _) in SECTIONS.items():
        yield f"\n## {title}\n\n{section(advance)}"
