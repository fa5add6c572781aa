"""Chapter: the condition of Newton's matrix as h → 0, and what rounding leaves of the multipliers.

With γ' = γ/(hβ) and β' = (1 − α_m)/(h²β(1 − α_f)) the matrix of (67), and of (D.2) with η for ση, mixes powers of h:
M* = β'M + γ'C grows like h⁻², the rows of dΦ/dt like h⁻¹, B stays. Rows of the dynamics times βh², rows of dΦ/dt
over γ', and the unknowns βh² λ and μ = η/γ' in place of λ and η leave

    [ κM U + γhC U + βh²K   Bᵀ   D Bᵀ ]
    [ B                     0    0    ]      κ = βh²β',   D = κM + γhC,   γ'U = ∂v/∂(motion),
    [ hβ/γ Z + B (U − I)    0    B Bᵀ ]

with the second row taken from the third. Nothing in it grows as h → 0. Undone, the scaling costs the product of the
largest entries of the matrix, M* ~ h⁻², and of its inverse: in index 3 a violated Φ moves λ by Φ/h², in the other two
dΦ/dt alone moves it, by (dΦ/dt)/h. So the condition grows like h⁻⁴, h⁻³ and h⁻³. Without joints the scaling is one
common factor, and changes nothing.

Scaling cannot change what rounding does to the problem itself: positions are known to ε|q|, and in index 3 that moves λ
by ε|q|M/(βh²). In the other two the velocities settle λ, and are known to ε|v|: ε|v|M/h. Runs of a few steps show it.
"""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from research.measure import FORMULATION_NAMES, INDEX3, MULTIPLIERS, STABILIZED, columns
from research.reference import History
from research.reference.minimal_coordinates import solve
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from research.study.runs import simulation
from sigmafmu import _core
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

RHO_INF = 0.9
LARGEST_STEPS = {"HeavyTop": 1e-3, "HighSpeedRotor": 1e-5, "SliderCrank": 1e-3}  # s, hω < 0.3
SMALLEST_STEP = 1e-8  # s
QUICK_STRIDE = 3
STEPS = 10
"""Steps of a run, the first half of which is left to the transient."""


def conditions(mechanism: str, formulation: int, step_sizes: Sequence[float]) -> dict[str, Any]:
    """2-norm condition numbers at the end of the first step, as printed and scaled."""
    printed, scaled = [], []
    for h in step_sizes:
        left, matrix, right = newton_matrix(mechanism, formulation, h)
        inverse = np.linalg.inv(matrix)
        scaled.append(_norm(matrix) * _norm(inverse))
        # L and R are inverted exactly, and the scaled matrix is well conditioned: no digits are lost on the way
        printed.append(_norm(left @ matrix @ right) * _norm(_inverse(right) @ inverse @ _inverse(left)))
    return {"h": list(step_sizes), "printed": printed, "scaled": scaled}


def newton_matrix(
    mechanism: str, formulation: int, h: float, rho_inf: float = RHO_INF, sigma: float = 1.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """L, S, R after one step from the start: S is scaled, L S R is (67), for index 2 its variant, or (D.2).

    Unknowns are the motion increments of the bodies, λ and, in the stabilized form, η = γ'μ.
    """
    run = simulation(mechanism, h, formulation=formulation, spectral_radius=rho_inf, sigma=sigma)
    start = (run.state.q.copy(), run.state.v.copy(), run.state.a.copy())
    run.run(h, 1)
    alpha = _core.AlphaParameters(rho_inf)
    system = _core.System(_core.mechanism(mechanism).multibody)
    q, v, multipliers = run.state.q, run.state.v, run.state.lambda_
    M, C, K = system.linearization(q, v, multipliers, np.zeros(system.input_size))
    _, _, B, Z = system.constraints(q, v)
    _, _, B_start, _ = system.constraints(*start[:2])
    U, P_inverse = _velocity_derivatives(alpha, sigma, h, start, q, v)

    beta_h2 = alpha.beta * h * h
    gamma_prime = alpha.gamma / (alpha.beta * h)
    D = (1 - alpha.alpha_m) / (1 - alpha.alpha_f) * M + alpha.gamma * h * C
    dynamics = D @ U + beta_h2 * K
    rates = Z / gamma_prime + B @ U
    n, m = M.shape[0], B.shape[0]
    none = np.zeros((m, m))
    if formulation == STABILIZED:
        matrix = np.block(
            [
                [dynamics, B.T, D @ P_inverse @ B_start.T],
                [B, none, none],
                [rates - B, none, B @ P_inverse @ B_start.T],
            ]
        )
        left = np.diag(np.r_[np.full(n, 1 / beta_h2), np.ones(m), np.full(m, gamma_prime)])
        left[n + m :, n : n + m] = gamma_prime * np.eye(m)
        right = np.diag(np.r_[np.ones(n), np.full(m, beta_h2), np.full(m, 1 / gamma_prime)])
        return left, matrix, right
    matrix = np.block([[dynamics, B.T], [B if formulation == INDEX3 else rates, none]])
    left = np.diag(np.r_[np.full(n, 1 / beta_h2), np.full(m, 1.0 if formulation == INDEX3 else gamma_prime)])
    right = np.diag(np.r_[np.ones(n), np.full(m, beta_h2)])
    return left, matrix, right


def _velocity_derivatives(
    alpha: _core.AlphaParameters,
    sigma: float,
    h: float,
    start: tuple[np.ndarray, np.ndarray, np.ndarray],
    q: np.ndarray,
    v: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """U = ∂v/∂(motion) / γ' and P⁻¹, block-diagonal, for the motion from the start (q, v, a) to q."""
    U, P_inverse = np.eye(len(v)), np.eye(len(v))
    c = h * (1 - alpha.beta / alpha.gamma) * start[1] + h * h * (0.5 - alpha.beta / alpha.gamma) * start[2]
    for body in range(len(v) // 6):
        turn = slice(6 * body + 3, 6 * body + 6)
        quaternion = slice(7 * body + 3, 7 * body + 7)
        theta = _core.lie.log(_relative(start[0][quaternion], q[quaternion]))
        w = c[turn] + (1 - sigma) * h * alpha.beta / alpha.gamma * v[turn]
        P = sigma * np.eye(3) + (1 - sigma) * _core.lie.tangent(theta)
        dtheta = np.eye(3) - _core.lie.tangent_derivative(theta, w)
        P_inverse[turn, turn] = np.linalg.inv(P)
        U[turn, turn] = P_inverse[turn, turn] @ dtheta @ _core.lie.tangent_inverse(theta)
    return U, P_inverse


def _relative(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """first⁻¹ second, unit quaternions (w, x, y, z)."""
    w, u = first[0], -first[1:]
    return np.r_[w * second[0] - u @ second[1:], w * second[1:] + second[0] * u + np.cross(u, second[1:])]


def _norm(matrix: np.ndarray) -> float:
    return float(np.linalg.norm(matrix, 2))


def _inverse(triangular: np.ndarray) -> np.ndarray:
    """Of L or R: [[D, 0], [E, F]] with diagonal blocks."""
    diagonal = np.diag(triangular)
    off = triangular - np.diag(diagonal)
    return np.diag(1 / diagonal) - off / diagonal[:, None] / diagonal[None, :]


def noise(mechanism: str, formulation: int, step_sizes: Sequence[float]) -> dict[str, Any]:
    """Runs of a few steps: largest error of the multipliers over their size, iterations per step; NaN if they fail."""
    error, iterations = [], []
    for h in step_sizes:
        run = simulation(mechanism, h, formulation=formulation, spectral_radius=RHO_INF)
        try:
            _, _, _, found = run.trajectory(STEPS * h, STEPS)
        except RuntimeError:
            error.append(np.nan)
            iterations.append(np.nan)
            continue
        reference = _reference(mechanism, h)
        late = slice(STEPS // 2, None)
        largest = size = 0.0
        for joint, first in MULTIPLIERS[mechanism].items():
            force = columns(reference, f"{joint}.reactionForce")
            largest = max(largest, np.abs(-found[late, first : first + 3] - force[late]).max())
            size = max(size, np.abs(force).max())
        error.append(float(largest / size))
        iterations.append(run.state.counters.newton_iterations / STEPS)
    return {"h": list(step_sizes), "error": error, "iterations": iterations}


@lru_cache(maxsize=16)
def _reference(mechanism: str, h: float) -> History:
    return solve(mechanism, np.arange(STEPS + 1) * h)


def exponent(h: Sequence[float], values: Sequence[float]) -> float:
    """Slope of log(values) over log(h), least squares."""
    return float(np.polyfit(np.log(h), np.log(values), 1)[0])


def _step_sizes(mechanism: str, quick: bool) -> tuple[float, ...]:
    """Two for each decade, in s."""
    largest = LARGEST_STEPS[mechanism]
    count = 2 * round(np.log10(largest / SMALLEST_STEP)) + 1
    every = tuple(float(h) for h in np.geomspace(largest, SMALLEST_STEP, count))
    return every[::-QUICK_STRIDE][::-1] if quick else every


def _formulations(mechanism: str) -> tuple[int, ...]:
    return tuple(FORMULATION_NAMES) if MULTIPLIERS[mechanism] else (INDEX3,)


class Conditioning:
    """Condition numbers and rounding as h → 0."""

    name = "conditioning"
    title = "Conditioning as h → 0"
    mechanisms = tuple(LARGEST_STEPS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """Condition and, with joints, rounding for each formulation."""
        steps = _step_sizes(mechanism, quick)
        kinds = {"condition": conditions, **({"noise": noise} if MULTIPLIERS[mechanism] else {})}
        return [
            Cell(f"{kind}/{FORMULATION_NAMES[formulation]}", function, (mechanism, formulation, steps))
            for formulation in _formulations(mechanism)
            for kind, function in kinds.items()
        ]

    def report(self, results: Results, folder: Path) -> str:
        """The explanation, then a table and a figure for all mechanisms."""
        rows = [row for mechanism, found in results.items() for row in _rows(mechanism, found)]
        write_csv(folder / f"{self.name}.csv", rows, tuple(rows[0]))
        _draw(folder / f"{self.name}.png", results)
        text = (
            f"σ = 1, ρ∞ = {RHO_INF:g}. Condition numbers in the 2-norm; *growth* is the exponent of h, fitted up to "
            f"h = 1e-5 s. Multipliers: largest error in the second half of {STEPS} steps over their size.\n"
        )
        parts = [__doc__.split("\n\n", 1)[1].strip() + "\n", text, _table(results)]
        return "\n".join([*parts, f"![Condition and rounding as h → 0]({self.name}.png)\n"])


def _rows(mechanism: str, found: dict[str, Any]) -> list[dict[str, Any]]:
    rows = []
    for formulation in _formulations(mechanism):
        name = FORMULATION_NAMES[formulation]
        condition, rounding = found[f"condition/{name}"], found.get(f"noise/{name}", {})
        for i, h in enumerate(condition["h"]):
            row = {"mechanism": mechanism, "formulation": name, "h": h}
            row |= {kind: condition[kind][i] for kind in ("printed", "scaled")}
            rows.append(row | {kind: rounding[kind][i] if rounding else "" for kind in ("error", "iterations")})
    return rows


def _table(results: Results) -> str:
    rows = []
    for mechanism, found in results.items():
        for formulation in _formulations(mechanism):
            name = FORMULATION_NAMES[formulation]
            row = [mechanism, name if MULTIPLIERS[mechanism] else "–"]
            condition = found[f"condition/{name}"]
            h = np.array(condition["h"])
            small = h <= 1.1e-5
            for kind in ("printed", "scaled"):
                values = np.array(condition[kind])
                row += [f"{values[-1]:.1e}", f"{round(exponent(h[small], values[small]), 1) + 0.0:.1f}"]
            errors = found.get(f"noise/{name}", {}).get("error", [])
            rows.append([*row, f"{min(errors):.0e}" if errors else "–", f"{errors[-1]:.0e}" if errors else "–"])
    header = ["mechanism", "formulation", "as printed, h = 1e-8 s", "growth", "scaled, h = 1e-8 s", "growth"]
    return markdown_table([*header, "multipliers, best h", "multipliers, h = 1e-8 s"], rows)


def _draw(path: Path, results: Results) -> None:
    """Mechanisms across; above the condition, below the error of the multipliers."""
    with figure(path, (max(6.4, 3.9 * len(results)), 6.2)) as result:
        grid = result.subplots(2, len(results), squeeze=False, sharey="row")
        handles: dict[str, Line2D] = {}
        for (condition, rounding), (mechanism, found) in zip(grid.T, results.items(), strict=True):
            condition.set_title(mechanism if MULTIPLIERS[mechanism] else f"{mechanism}, no joints")
            for formulation in _formulations(mechanism):
                name = FORMULATION_NAMES[formulation]
                style = {"color": COLORS[formulation - 1], "marker": "o", "markersize": 3}
                cell = found[f"condition/{name}"]
                for kind, label, line in (("printed", "as printed", "--"), ("scaled", "scaled", "-")):
                    (curve,) = condition.plot(cell["h"], cell[kind], line, **style)
                    handles[f"{name}, {label}"] = curve
                if f"noise/{name}" in found:
                    cell = found[f"noise/{name}"]
                    rounding.plot(cell["h"], cell["error"], **style)
            for axes in (condition, rounding):
                axes.set(xscale="log", yscale="log", xlabel="h in s")
                axes.tick_params(labelleft=True)
                axes.minorticks_off()
            if not MULTIPLIERS[mechanism]:
                rounding.set_axis_off()
        grid[0, 0].set_ylabel("condition number")
        grid[1, 0].set_ylabel("error of the multipliers over their size")
        result.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)


CHAPTER = Conditioning()
