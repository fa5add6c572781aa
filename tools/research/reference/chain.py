"""A chain of links on spherical joints in minimal velocities, the angular velocities of all links: no multiplier.

SI units; W is the inertial frame. `research.mechanisms.chains` says what the chain is.
"""

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from research.mechanisms.chains import GRAVITY, LINK_INERTIA, LINK_MASS, X, link_spins


def accelerations(turns: Rotation, w: np.ndarray) -> np.ndarray:
    """ω' in W by Jourdain's principle, of links that are turned like this and have these angular velocities in W.

    The center of link k moves with Σ_j ω_j × r_kj, r_kj being the whole of link j before it and half of its own.
    """
    links = len(w)
    along = turns.apply(X)
    J = np.zeros((3 * links, 3 * links))  # of the centers
    bias = np.zeros((links, 3))  # their accelerations at ω' = 0
    for k in range(links):
        for j in range(k + 1):
            r = along[j] * (0.5 if j == k else 1.0)
            J[3 * k : 3 * k + 3, 3 * j : 3 * j + 3] = np.cross(r, -np.eye(3)).T
            bias[k] += np.cross(w[j], np.cross(w[j], r))
    mass = LINK_MASS * J.T @ J
    force = LINK_MASS * J.T @ (GRAVITY - bias).ravel()
    R = turns.as_matrix()
    for k in range(links):
        inertia = R[k] @ np.diag(LINK_INERTIA) @ R[k].T
        mass[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += inertia
        force[3 * k : 3 * k + 3] -= np.cross(w[k], inertia @ w[k])
    return np.linalg.solve(mass, force).reshape(-1, 3)


@cache
def tip(links: int, time: float) -> np.ndarray:
    """Free end of the last link, in W; DOP853 on quaternions, whose length is that of rounding."""

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        q, w = y[: 4 * links].reshape(-1, 4), y[4 * links :].reshape(-1, 3)
        spin = np.column_stack([np.zeros(links), w])
        turn = np.array([_product(s, p) for s, p in zip(spin, q, strict=True)])
        wdot = accelerations(Rotation.from_quat(q, scalar_first=True), w)
        return np.concatenate([0.5 * turn.ravel(), wdot.ravel()])

    y0 = np.concatenate([np.tile([1.0, 0, 0, 0], links), link_spins(links).ravel()])
    solution = solve_ivp(rates, (0.0, time), y0, method="DOP853", rtol=1e-12, atol=1e-12)
    turns = Rotation.from_quat(solution.y[: 4 * links, -1].reshape(-1, 4), scalar_first=True)
    return turns.apply(X).sum(axis=0)


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Of quaternions (w, x, y, z)."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])
