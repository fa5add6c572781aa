"""Algorithm 1 of the paper (index 3, σ = 1) line by line in NumPy: what is it that it solves, and what does Exudyn?

The core's incremental form is the printed one; this is independent of its code, and can take another factor in line 6.
"""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from research.measure import INCREMENTAL, INDEX3
from research.reference import History
from research.reference.exudyn_models import Settings, simulate
from research.study import cases, runs
from research.study.cases import CASES
from research.study.chapter import Cell, Results
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

LINE_6 = {"hβ/γ": 1.0, "hβ/(2γ)": 0.5}
"""Factor of line 6 over hβ/γ, which is printed; (82) with (29) gives half of it, and so does Exudyn."""
MAX_ITERATIONS = 50
TIGHT = {"relative_tolerance": 1e-12, "absolute_tolerance": 1e-14}
STEPS = {"HeavyTop": 1e-3, "HighSpeedRotor": 2e-5, "SliderCrank": 2.5e-3}  # s
TIMES = {"HeavyTop": 0.5, "HighSpeedRotor": 0.02, "SliderCrank": 1.0}  # s
QUICK_TIMES = {"HeavyTop": 0.1, "HighSpeedRotor": 0.005, "SliderCrank": 0.25}


def trajectory(mechanism: str, h: float, stop_time: float, rho_inf: float, line6: str) -> History:
    """The body in `TRACKED` at SAMPLES + 1 times, as `runs.trajectory` has it.

    Newton's method goes on until increments of the motion (m, rad) are below 1e-13; RuntimeError where they are not.
    """
    definition = _core.mechanism(mechanism)
    system = _core.System(definition.multibody)
    alpha = _core.AlphaParameters(rho_inf)
    alpha_m, alpha_f, beta, gamma = alpha.alpha_m, alpha.alpha_f, alpha.beta, alpha.gamma
    gamma_prime, beta_prime = gamma / (h * beta), (1 - alpha_m) / (h**2 * beta * (1 - alpha_f))
    state = runs.simulation(mechanism, h, spectral_radius=rho_inf).state  # consistent q, v, v̇, a
    q, v, vdot, a = (np.array(x) for x in (state.q, state.v, state.vdot, state.a))
    u = np.zeros(system.input_size)
    size, constraints = system.velocity_size, system.constraint_size
    steps = round(stop_time / h)
    found = [(q, v)]
    for step in range(1, steps + 1):
        new = np.zeros_like(vdot)
        multipliers = np.zeros(constraints)
        a_new = ((1 - alpha_f) * new + alpha_f * vdot - alpha_m * a) / (1 - alpha_m)
        v_new = v + h * (1 - gamma) * a + h * gamma * a_new
        theta = h * v + h**2 * (0.5 - beta) * a + h**2 * beta * a_new
        omega, turn = (x.reshape(-1, 6)[:, 3:] for x in (v_new, theta))
        turn -= LINE_6[line6] / gamma_prime * np.cross(omega, turn)
        q_new = system.compose(q, theta)
        for _ in range(MAX_ITERATIONS):
            phi, _, B, _ = system.constraints(q_new, v_new)
            M, C, K = system.linearization(q_new, v_new, multipliers, u)
            matrix = np.zeros((size + constraints, size + constraints))
            matrix[:size, :size] = beta_prime * M + gamma_prime * C + K
            matrix[:size, size:], matrix[size:, :size] = B.T, B
            scale = np.concatenate([np.ones(size), np.full(constraints, beta_prime)])  # λ beside the motion
            right = -np.concatenate([system.residual(q_new, v_new, new, multipliers, u), phi])
            change = scale * np.linalg.solve(matrix * scale, right)
            q_new = system.compose(q_new, change[:size])
            v_new = v_new + gamma_prime * change[:size]
            new = new + beta_prime * change[:size]
            multipliers = multipliers + change[size:]
            if not np.abs(change[:size]).max() < np.pi:
                raise RuntimeError(f"Algorithm 1 diverges at t = {step * h} s")
            if np.abs(change[:size]).max() < 1e-13:
                break
        else:
            raise RuntimeError(f"Algorithm 1 does not converge at t = {step * h} s")
        a = ((1 - alpha_f) * new + alpha_f * vdot - alpha_m * a) / (1 - alpha_m)
        q, v, vdot = q_new, v_new, new
        if step % (steps // runs.SAMPLES) == 0:
            found.append((q, v))
    return runs.body_history(mechanism, *(np.array(x) for x in zip(*found, strict=True)))


def by_hand(mechanism: str, h: float, stop_time: float, rho_inf: float, line6: str) -> dict[str, Any]:
    """Its error, and its distance [m] to the core's incremental form."""
    position, _ = runs.point_motion(mechanism, runs.exact(mechanism, stop_time))
    settings = {"spectral_radius": rho_inf, "formulation": INDEX3, "corrector": INCREMENTAL, **TIGHT}
    core, _ = runs.point_motion(mechanism, runs.trajectory(mechanism, h, stop_time, **settings)[0])
    try:
        history = trajectory(mechanism, h, stop_time, rho_inf, line6)
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
    own = {"spectral_radius": rho_inf, "formulation": INDEX3, **TIGHT}

    def path(**chosen: float) -> np.ndarray:
        return runs.point_motion(mechanism, runs.trajectory(mechanism, h, stop_time, **own, **chosen)[0])[0]

    theirs = simulate(mechanism, Settings(h, **settings), stop_time, sample_step=stop_time / runs.SAMPLES).history
    found = {}
    for name, goal in {
        "incremental": path(corrector=INCREMENTAL),
        "Exudyn": runs.point_motion(mechanism, theirs)[0],
    }.items():
        nearest = minimize_scalar(
            lambda sigma, goal=goal: float(np.linalg.norm(path(sigma=sigma) - goal, axis=1).max()),
            bounds=(0.0, cases.LARGEST_SIGMA),
            method="bounded",
            options={"xatol": 1e-2},
        )
        found[name] = {"sigma": float(nearest.x), "distance": float(nearest.fun)}
    return found


class Algorithm1:
    """The printed algorithm beside the core, Exudyn and the equations."""

    name = "algorithm1"
    title = "Algorithm 1 by hand"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each factor of line 6, Exudyn, and the search for the nearest σ."""
        steps = (STEPS[mechanism], (QUICK_TIMES if quick else TIMES)[mechanism])
        rho = CASES[mechanism].rho_inf[INDEX3]
        settings = cases.peer_settings(mechanism, INDEX3, "σ-modified")
        return [
            *(Cell(line6, by_hand, (mechanism, *steps, rho, line6)) for line6 in LINE_6),
            Cell("Exudyn", peer, (mechanism, *steps, settings)),
            Cell("equivalent", equivalent, (mechanism, *steps, rho, settings)),
        ]

    def report(self, results: Results, folder: Path) -> str:
        """Two tables."""
        choices, nearest = [], []
        for mechanism, found in results.items():
            for line6 in LINE_6:
                cell = found[line6]
                choices.append([mechanism, line6, _number(cell, "position"), _number(cell, "difference")])
            choices.append([mechanism, "Exudyn, σ-modified", _number(found["Exudyn"], "position"), ""])
            for name, near in found["equivalent"].items():
                nearest.append([mechanism, name, f"{near['sigma']:.2f}", f"{near['distance']:.1e}"])
        return "\n".join(
            [
                "Algorithm 1 (index 3) written down a second time, in NumPy, with the factor of line 6 left open. As "
                "printed it is the core's incremental form; with half the factor it is Exudyn's.\n",
                markdown_table(["mechanism", "line 6", "error [m]", "distance to the core [m]"], choices),
                "σ = 1 means another σ there: the residual form whose path is nearest to that of the printed algorithm "
                "and to Exudyn's (index 3), and how near it comes:\n",
                markdown_table(["mechanism", "path of", "σ of the residual form", "distance [m]"], nearest),
            ]
        )


def _number(cell: dict[str, Any], name: str) -> str:
    return f"{cell[name]:.2e}" if name in cell else "fails"


CHAPTER = Algorithm1()
