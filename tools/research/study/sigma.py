"""Chapter: the error as a function of σ, and the spin-optimal σ (docs/sigma.md has the derivation).

Scans of the three mechanisms over σ; a gyroscope in slow precession, whose scans must have their minimum at σ*; the
same body in free nutation, which has an optimum of its own; the heavy top, where the formulation decides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from scipy.integrate import solve_ivp

from research.measure import FORMULATION_NAMES, INDEX3, STABILIZED
from research.reference import GRAVITY, TOP, Rotor
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from research.study.runs import ours
from sigmafmu import _core
from sigmafmu.markdown import markdown_table
from sigmafmu.spin_sigma import coefficients, nutation_sigma, precession_sigma

SPIN_OPTIMAL = 2  # integrator.sigmaMode
TIGHT = {"relative_tolerance": 1e-11}
"""Third order is soon below the default tolerance of Newton's method."""
SCANS = {"HeavyTop": (1.0, (1e-3, 5e-4)), "HighSpeedRotor": (0.2, (2e-5, 1e-5)), "SliderCrank": (1.0, (1e-3, 5e-4))}
"""Stop time and steps in s."""
SIGMAS = np.linspace(0.0, 3.0, 31)
QUICK_SIGMAS = np.linspace(0.0, 3.0, 7)
RHO_INF = (1.0, 0.9, 0.65)
RATIOS = (0.2, 0.4, 0.7, 1.0, 1.3, 1.6, 1.898, 1.99)
QUICK_RATIOS = (0.4, 1.898)


# --- a gyroscope: one body, a constant moment in W -------------------------------------------------------------------

SPIN = 100.0  # rad/s
PRECESSION = 0.01  # rad/s
NUTATION = 0.1  # rad/s, transverse angular velocity of the free body
GYRO_TIME = 2.0  # s


def gyroscope(moments: Sequence[float], moment: Sequence[float], transverse: Sequence[float]) -> _core.Mechanism:
    """A free body that spins about its x axis with a `moment` [N m] in W and a transverse angular velocity [rad/s]."""
    mechanism = _core.Mechanism()
    mechanism.multibody.gravity = np.zeros(3)
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = "gyroscope", 1.0, np.array(moments)
    body.initial_angular_velocity = np.array([SPIN, *transverse])
    mechanism.multibody.add(body)
    mechanism.multibody.add(_core.Load("moment", 0, np.zeros(3), np.array(moment)))
    return mechanism


def precessing(moments: Sequence[float]) -> _core.Mechanism:
    """A gyroscope in slow precession about y, without nutation (for equal transverse moments)."""
    return gyroscope(moments, (0.0, 0.0, -moments[0] * SPIN * PRECESSION), (PRECESSION, 0.0))


def nutating(ratio: float) -> _core.Mechanism:
    """A free symmetric body that nutates."""
    return gyroscope((ratio, 1.0, 1.0), (0.0, 0.0, 0.0), (NUTATION, 0.0))


def final_state(mechanism: _core.Mechanism, h: float, stop_time: float, **settings: float) -> _core.State:
    """The state at `stop_time` [s] after steps of h [s]; a step that fails is not halved."""
    for name, value in {"step_size": h, "max_halvings": 0, "relative_tolerance": 1e-13, **settings}.items():
        setattr(mechanism.integrator, name, value)
    run = _core.Simulation(mechanism)
    run.run(stop_time, round(stop_time / h))
    return run.state


def exact_axis(mechanism: _core.Mechanism, stop_time: float) -> np.ndarray:
    """Spin axis e of a body in W: L = L₀ + τ t exactly, R' = R ω̃ with ω = J⁻¹ Rᵀ L by DOP853."""
    body = mechanism.multibody.bodies[0]
    inertia = np.array(body.inertia)
    start = _core.Simulation(mechanism).state
    omega = np.array(start.v[3:])
    moment = inertia * start.vdot[3:] + np.cross(omega, inertia * omega)  # R = I at the start

    def rhs(t: float, columns: np.ndarray) -> np.ndarray:
        rotation = columns.reshape(3, 3)
        w = (rotation.T @ (inertia * omega + moment * t)) / inertia
        return (rotation @ _core.lie.hat(w)).ravel()

    end = solve_ivp(rhs, (0.0, stop_time), np.eye(3).ravel(), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return end.reshape(3, 3)[:, 0]


def gyro_time(moments: Sequence[float]) -> float:
    """About GYRO_TIME, whole turns of the nutation in W.

    The scheme's steady velocity differs from the exact one at the start, by a relative O(h²). The nutation that this
    excites has a bounded effect on the axis, which vanishes there.
    """
    turn = 2 * np.pi * moments[1] / (moments[0] * SPIN)
    return turn * round(GYRO_TIME / turn)


def axis_error(mechanism: _core.Mechanism, exact: np.ndarray, stop_time: float, h: float, **settings: float) -> float:
    """Error of the direction of the x axis at the end [rad], with about the step h [s]."""
    end = final_state(mechanism, stop_time / round(stop_time / h), stop_time, **settings)
    return float(np.linalg.norm(_core.lie.rotation_matrix(end.q[3:7])[:, 0] - exact))


def momentum_error(mechanism: _core.Mechanism, h: float, **settings: float) -> float:
    """Change of the angular momentum in W, relative to its part across the axis at the start, half a nutation later."""
    inertia = np.array(mechanism.multibody.bodies[0].inertia)
    stop_time = gyro_time(inertia) + np.pi * inertia[1] / (inertia[0] * SPIN)
    end = final_state(mechanism, stop_time / round(stop_time / h), stop_time, **settings)
    start = inertia * np.array([SPIN, NUTATION, 0.0])
    change = _core.lie.rotation_matrix(end.q[3:7]) @ (inertia * end.v[3:]) - start
    return float(np.linalg.norm(change[1:]) / start[1])


# --- the heavy top as a gyroscope ------------------------------------------------------------------------------------


def top_path(times: np.ndarray, gyroscopic: float, kinematic: float) -> np.ndarray:
    """Centre of mass of the heavy top whose angular momentum and kinematics are off by relative errors, (times, 3).

    With the axis d and y, the rate of the axis by the velocities: I d × ẏ + G (1 + e₁) y = l d × m g, ḋ = (1 + e₂) y.
    """
    length = abs(TOP.position[1])
    inertia = TOP.inertia[0] + TOP.mass * length**2
    momentum = TOP.inertia[1] * TOP.angular_velocity[1]
    weight = TOP.mass * length * GRAVITY

    def rhs(_t: float, state: np.ndarray) -> np.ndarray:
        d, y = state[:3], state[3:]
        rate = (1 + kinematic) * y
        moment = np.cross(d, weight) - momentum * (1 + gyroscopic) * y
        return np.concatenate([rate, -np.cross(d, moment) / inertia - d * (y @ rate)])

    d0 = np.array(TOP.position) / length
    start = np.concatenate([d0, np.cross(TOP.angular_velocity, d0)])
    solution = solve_ivp(rhs, (0.0, times[-1]), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times)
    return length * solution.y[:3].T


def top_sigma(rho_inf: float, formulation: int, stop_time: float) -> float:
    """The optimum predicted for the heavy top's position at `stop_time` [s]."""
    ratio = TOP.inertia[1] / TOP.inertia[0]
    if formulation == INDEX3:
        return precession_sigma(rho_inf, ratio)
    times, e = np.array([0.0, stop_time]), 1e-4
    by_momentum, by_kinematics = (
        (top_path(times, *(e * x))[-1] - top_path(times, *(-e * x))[-1]) / (2 * e) for x in np.eye(2)
    )
    gain = -(by_momentum @ by_kinematics) / (by_kinematics @ by_kinematics)
    gamma_beta, c_q, eta = coefficients(rho_inf)
    length = abs(TOP.position[1])
    return 4 * gamma_beta * (1 / 12 - c_q + (1 + length**2) * gain * eta / ratio)


# --- cells -----------------------------------------------------------------------------------------------------------


def scan(mechanism: str, formulation: int, h: float, stop_time: float, sigmas: Sequence[float]) -> dict[str, Any]:
    """Largest position error of a mechanism for every σ, ρ∞ = 0.9; NaN where the run fails."""
    runs = [ours(mechanism, h, stop_time, formulation=formulation, sigma=sigma, **TIGHT) for sigma in sigmas]
    mode = ours(mechanism, h, stop_time, formulation=formulation, sigma_mode=SPIN_OPTIMAL, **TIGHT)
    return {
        "sigmas": list(sigmas),
        "errors": [run.get("position", np.nan) for run in runs],
        "spinOptimal": mode.get("position", np.nan),
    }


def rotor_orders(rho_inf: float, steps: Sequence[float], stop_time: float) -> dict[str, Any]:
    """Error of the bearing at the end for some σ and every step."""
    inertia = Rotor().inertia
    best = precession_sigma(rho_inf, inertia[0] / inertia[1])
    schemes = {
        "σ = 0 (geom1)": {"sigma": 0.0},
        "σ = γ/(3β)": {"sigma": coefficients(rho_inf)[0] / 3},
        "σ = 1": {"sigma": 1.0},
        f"σ* = {best:.3f}": {"sigma": best},
        "spinOptimal": {"sigma_mode": SPIN_OPTIMAL},
    }
    errors = {
        name: [
            ours("HighSpeedRotor", h, stop_time, spectral_radius=rho_inf, **TIGHT, **chosen).get(
                "final position", np.nan
            )
            for h in steps
        ]
        for name, chosen in schemes.items()
    }
    return {"steps": list(steps), "errors": errors}


def minimum(error: Callable[[float], float], around: float, width: float = 0.6, samples: int = 7) -> float:
    """Where an error that is linear in σ − σ_min, up to its sign, has its minimum: a parabola through error²."""
    sigmas = np.linspace(around - width, around + width, samples)
    a, b, _ = np.polyfit(sigmas - around, [error(s) ** 2 for s in sigmas], 2)
    return float(around - b / (2 * a))


def gyroscope_cell(ratio: float, rho_inf: float) -> dict[str, Any]:
    """Minima of the scans and orders there, of slow precession and of free nutation."""
    steps = [0.04 / SPIN, 0.02 / SPIN, 0.01 / SPIN]
    slow, free = precessing((ratio, 1.0, 1.0)), nutating(ratio)
    stop_time = gyro_time((ratio, 1.0, 1.0))
    exact = exact_axis(slow, stop_time)

    def precession(h: float, sigma: float) -> float:
        return axis_error(slow, exact, stop_time, h, sigma=sigma, spectral_radius=rho_inf)

    def nutation(h: float, sigma: float) -> float:
        return momentum_error(free, h, sigma=sigma, spectral_radius=rho_inf)

    result: dict[str, Any] = {}
    for name, error, sigma in (
        ("precession", precession, precession_sigma(rho_inf, ratio)),
        ("nutation", nutation, nutation_sigma(rho_inf, ratio)),
    ):
        if name == "nutation" and ratio == 1.0:
            continue  # the angular velocity of a sphere is constant: every σ is exact
        errors = [error(h, sigma) for h in steps]
        result[name] = {
            "sigma": sigma,
            "minimum": minimum(lambda s, error=error: error(steps[-1], s), sigma),
            "order": float(np.polyfit(np.log(steps), np.log(errors), 1)[0]),
            "gain": error(steps[-1], 1.0) / errors[-1],
        }
    return result


def top_cell(formulation: int, stop_time: float, rho_inf: float) -> dict[str, Any]:
    """Predicted and measured optimum of the heavy top's position at the end, and the gain over σ = 1 there."""
    h = 2.5e-4

    def error(sigma: float) -> float:
        run = ours("HeavyTop", h, stop_time, formulation=formulation, sigma=sigma, spectral_radius=rho_inf, **TIGHT)
        return run.get("final position", np.nan)

    found = minimum(error, minimum(error, top_sigma(rho_inf, formulation, stop_time)), width=0.2)
    return {
        "formula": top_sigma(rho_inf, formulation, stop_time),
        "measured": found,
        "gain": error(1.0) / error(found),
    }


# --- the chapter -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SigmaChapter:
    """See the head of this module."""

    name: str = "sigma"
    title: str = "σ scans and the spin-optimal σ"
    mechanisms: tuple[str, ...] = tuple(SCANS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """Scans for all; orders with the rotor, the gyroscope with it, optima by formulation with the top."""
        stop_time, steps = SCANS[mechanism]
        formulations = FORMULATION_NAMES if _core.mechanism(mechanism).multibody.joints else (INDEX3,)
        sigmas = [float(s) for s in (QUICK_SIGMAS if quick else SIGMAS)]
        cells = [
            Cell(f"scan {f} {h:g}", scan, (mechanism, f, h, stop_time, sigmas))
            for f in formulations
            for h in (steps[:1] if quick else steps)
        ]
        radii = (0.9,) if quick else RHO_INF
        if mechanism == "HighSpeedRotor":
            orders = (2e-5, 1e-5) if quick else (2e-5, 1e-5, 5e-6)
            cells += [Cell(f"orders {rho:g}", rotor_orders, (rho, orders, stop_time)) for rho in radii]
            cells += [
                Cell(f"gyroscope {p:g} {rho:g}", gyroscope_cell, (p, rho))
                for p in (QUICK_RATIOS if quick else RATIOS)
                for rho in radii
            ]
        if mechanism == "HeavyTop":
            cells += [
                Cell(f"top {f} {end:g} {rho:g}", top_cell, (f, end, rho))
                for f in (INDEX3, STABILIZED)
                for end in ((1.0,) if quick else (0.5, 1.0))
                for rho in radii
            ]
        return cells

    def report(self, results: Results, folder: Path) -> str:
        """Figures of the scans, tables of optima and orders."""
        parts = [self._scans(results, folder)]
        if "HighSpeedRotor" in results:
            parts += [
                self._orders(results["HighSpeedRotor"], folder),
                self._gyroscope(results["HighSpeedRotor"], folder),
            ]
        if "HeavyTop" in results:
            parts.append(self._top(results["HeavyTop"], folder))
        return "\n\n".join(part for part in parts if part)

    def _scans(self, results: Results, folder: Path) -> str:
        rows = []
        with figure(folder / "sigma_scan.png", (4.0 * len(results), 3.4)) as canvas:
            all_axes = canvas.subplots(1, len(results), squeeze=False)[0]
            for axes, (mechanism, cells) in zip(all_axes, results.items(), strict=True):
                rows += _draw_scan(axes, mechanism, cells)
        write_csv(folder / "sigma_scan.csv", rows, ("mechanism", "formulation", "h", "sigma", "position"))
        return (
            "Largest position error over the run against σ, residual form, ρ∞ = 0.9; thin lines have half the step, "
            "dotted is what `integrator.sigmaMode = spinOptimal` reaches with σ = 1 given.\n\n![](sigma_scan.png)"
        )

    def _orders(self, cells: dict[str, dict[str, Any]], folder: Path) -> str:
        rows, table = [], []
        steps: list[float] = []
        for key, cell in _of(cells, "orders"):
            if "failed" in cell:
                table.append([key, "fails"])
                continue
            steps = cell["steps"]
            for scheme, errors in cell["errors"].items():
                order = float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
                table.append([key, scheme, *(f"{e:.1e}" for e in errors), f"{order:.2f}"])
                rows += [
                    {"rho": key, "scheme": scheme, "h": h, "position": e} for h, e in zip(steps, errors, strict=True)
                ]
        write_csv(folder / "sigma_orders.csv", rows, ("rho", "scheme", "h", "position"))
        header = ["ρ∞", "scheme", *(f"h = {h:g} s" for h in steps), "order"]
        return f"Rotor, error of the right bearing at {SCANS['HighSpeedRotor'][0]:g} s in m:\n\n" + markdown_table(
            header, table
        )

    def _gyroscope(self, cells: dict[str, dict[str, Any]], folder: Path) -> str:
        rows, table = [], []
        for key, cell in _of(cells, "gyroscope"):
            ratio, rho = key.split()
            row = [ratio, rho]
            for motion in ("precession", "nutation"):
                if motion not in cell:
                    row += ["fails" if "failed" in cell else "–"] * 4
                    continue
                values = cell[motion]
                rows.append({"ratio": ratio, "rho": rho, "motion": motion, **values})
                row += [
                    f"{values['sigma']:.3f}",
                    f"{values['minimum']:.3f}",
                    f"{values['order']:.2f}",
                    f"{values['gain']:.0f}",
                ]
            table.append(row)
        write_csv(folder / "sigma_gyroscope.csv", rows, ("ratio", "rho", "motion", "sigma", "minimum", "order", "gain"))
        with figure(folder / "sigma_gyroscope.png", (8.0, 3.4)) as canvas:
            for axes, motion in zip(canvas.subplots(1, 2), ("precession", "nutation"), strict=True):
                _draw_optima(axes, motion, [row for row in rows if row["motion"] == motion])
        header = ["p", "ρ∞", "σ*", "minimum", "order", "gain", "σ nutation", "minimum", "order", "gain"]
        return (
            "A free symmetric body, p = J_polar/J_transverse. Left: slow precession under a constant moment, error of "
            "the axis. Right: free nutation, change of the angular momentum. The minimum of a scan beside the formula, "
            "the order at the formula's σ, and how much larger the error is with σ = 1 (hΩ = 0.01):\n\n"
            f"{markdown_table(header, table)}\n\n![](sigma_gyroscope.png)"
        )

    def _top(self, cells: dict[str, dict[str, Any]], folder: Path) -> str:
        rows, table = [], []
        for key, cell in _of(cells, "top"):
            formulation, end, rho = key.split()
            name = FORMULATION_NAMES[int(formulation)]
            if "failed" in cell:
                table.append([name, end, rho, "fails"])
                continue
            rows.append({"formulation": name, "end": end, "rho": rho, **cell})
            table.append([name, end, rho, f"{cell['formula']:.2f}", f"{cell['measured']:.2f}", f"{cell['gain']:.1f}"])
        write_csv(folder / "sigma_top.csv", rows, ("formulation", "end", "rho", "formula", "measured", "gain"))
        header = ["formulation", "end [s]", "ρ∞", "predicted σ", "measured σ", "gain over σ = 1"]
        return "Heavy top, best σ for the position at the end, h = 2.5e-4 s:\n\n" + markdown_table(header, table)


def _of(cells: dict[str, dict[str, Any]], kind: str) -> list[tuple[str, dict[str, Any]]]:
    """The rest of the key and the result of all cells of one kind."""
    return [(key.removeprefix(f"{kind} "), cell) for key, cell in cells.items() if key.startswith(f"{kind} ")]


def _draw_scan(axes: Axes, mechanism: str, cells: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    rows = []
    drawn: dict[str, str] = {}
    for key, cell in _of(cells, "scan"):
        if "failed" in cell:
            continue
        formulation, h = key.split()
        label = FORMULATION_NAMES[int(formulation)]
        first = label not in drawn
        color = drawn.setdefault(label, f"C{len(drawn)}")
        axes.semilogy(
            cell["sigmas"], cell["errors"], color=color, lw=1.6 if first else 0.8, label=label if first else None
        )
        axes.axhline(cell["spinOptimal"], color=color, ls=":", lw=1.6 if first else 0.8)
        rows += [
            {"mechanism": mechanism, "formulation": label, "h": h, "sigma": s, "position": e}
            for s, e in zip(cell["sigmas"], cell["errors"], strict=True)
        ]
    axes.set_title(mechanism)
    axes.set_xlabel("σ")
    axes.set_ylabel("position error [m]")
    if len(drawn) > 1:
        axes.legend(fontsize=7)
    return rows


def _draw_optima(axes: Axes, motion: str, rows: Sequence[dict[str, Any]]) -> None:
    """Closed forms as lines over p, minima of the scans as marks."""
    formula = {"precession": precession_sigma, "nutation": nutation_sigma}[motion]
    ratios = np.linspace(0.2, 2.0, 100)
    for i, rho in enumerate(sorted({row["rho"] for row in rows}, key=float, reverse=True)):
        axes.plot(ratios, [formula(float(rho), p) for p in ratios], color=f"C{i}", label=f"ρ∞ = {rho}")
        found = [(float(row["ratio"]), row["minimum"]) for row in rows if row["rho"] == rho]
        axes.plot(*zip(*found, strict=True), color=f"C{i}", ls="", marker="o", ms=4)
    axes.set_title({"precession": "Slow precession", "nutation": "Free nutation"}[motion])
    axes.set_xlabel("J_polar / J_transverse")
    axes.set_ylabel("best σ")
    axes.set_ylim(0.0, 6.0)
    if rows:
        axes.legend(title="line: formula, mark: scan", fontsize=7, title_fontsize=7)


CHAPTER = SigmaChapter()
