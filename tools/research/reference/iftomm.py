"""Problems of the IFToMM library of benchmarks that are not in `linkage_motions`: independent solutions and values."""

import numpy as np
from scipy.integrate import solve_ivp

ANDREWS = {
    "drive.angle": 15.81077119629904,
    "pivotB.angle": 0.04082224013073101,
    "pivotA5.angle": 0.5244099658805304,
    "pivotA7.angle": 1.048080741042263,
}
"""Angles at 0.03 s of the test set for IVP solvers (problem "Andrews' squeezing mechanism", to 15 digits there)."""


def flyball_motion(times: np.ndarray) -> np.ndarray:
    """Slider and angle below horizontal of the Flyball with their rates, (4, times).

    Its arms move alike, and H about z is kept.
    """
    m, L, r0, Jx, Jt = 5.3, 0.971698113207547, 0.05, 5e-6, 0.0957572169811321  # of an arm
    K, C, free, g, ms = 8e5, 4e4, 0.5, 9.81, 3.0
    alone = 5e-6 + 5e-3  # shaft and slider about z

    def spin_inertia(a: float) -> float:
        return alone + 2 * (m * (r0 + L * np.cos(a)) ** 2 + Jx * np.sin(a) ** 2 + Jt * np.cos(a) ** 2)

    def slope(a: float) -> float:
        return 2 * (-2 * m * (r0 + L * np.cos(a)) * L * np.sin(a) + (Jx - Jt) * np.sin(2 * a))

    H = spin_inertia(np.pi / 6) * 2 * np.pi

    def rhs(_: float, y: np.ndarray) -> list[float]:
        s, a, s_rate, a_rate = y
        across, along = 0.5 * np.cos(a), 1 - 0.5 * np.sin(a) - s
        length = np.hypot(across, along)
        by_s, by_a = -along / length, (-across * 0.5 * np.sin(a) - along * 0.5 * np.cos(a)) / length
        tension = 2 * (K * (length - free) + C * (by_s * s_rate + by_a * a_rate))
        w = H / spin_inertia(a)
        s_force = -ms * g - tension * by_s
        a_force = 0.5 * w**2 * slope(a) + 2 * m * g * L * np.cos(a) - tension * by_a
        return [s_rate, a_rate, s_force / ms, a_force / (2 * (m * L**2 + Jt))]

    start = [0.5, np.pi / 6, 0.0, 0.0]
    return solve_ivp(rhs, (0, times[-1]), start, "Radau", times, rtol=1e-10, atol=1e-12).y
