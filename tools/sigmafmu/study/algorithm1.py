"""Algorithm 1 of the paper (index 3, σ = 1) line by line in NumPy, with the choices that it fixes left open.

The core's incremental form is the printed one; this is independent of its code, and can start from another v̇ or take
another factor in line 6.
"""

from collections.abc import Callable

import numpy as np

from sigmafmu import _core
from sigmafmu.reference import History
from sigmafmu.study import runs

STARTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {"v̇ := 0": np.zeros_like, "v̇ := v̇ₙ": np.copy}
"""Line 1: printed is zero."""
LINE_6 = {"hβ/γ": 1.0, "hβ/(2γ)": 0.5}
"""Factor of line 6 over hβ/γ, which is printed; (82) with (29) gives half of it, and so does Exudyn."""
MAX_ITERATIONS = 50


def trajectory(mechanism: str, h: float, stop_time: float, rho_inf: float, start: str, line6: str) -> History:
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
        new = STARTS[start](vdot)
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
