"""The σ that suits a spinning body, in closed form; docs/sigma.md has the derivation."""

from collections.abc import Sequence

from sigmafmu import _core


def coefficients(rho_inf: float) -> tuple[float, float, float]:
    """γ/β, C_q of (41), and η of the velocity update."""
    p = _core.AlphaParameters(rho_inf)
    c_q = (1 - 6 * p.beta - 3 * (p.alpha_m - p.alpha_f)) / 6
    eta = 0.5 * (p.gamma * (1 - p.gamma) + p.alpha_f * (1 - p.alpha_f) - p.alpha_m * (1 - p.alpha_m)) - 1 / 24
    return p.gamma / p.beta, c_q, eta


def precession_sigma(rho_inf: float, ratio: float, kappa: float = 0.0) -> float:
    """σ* for p = J_polar/J_transverse and a moment that turns at κ Ω in W; κ = 0 is the slow precession."""
    gamma_beta, c_q, eta = coefficients(rho_inf)
    return gamma_beta * (1 / 3 - 4 * c_q * (1 - kappa) + 4 * eta * (1 - kappa) ** 2 / (ratio - kappa))


def nutation_sigma(rho_inf: float, ratio: float) -> float:
    """The σ that keeps the direction of the angular momentum in free nutation to third order."""
    gamma_beta, c_q, eta = coefficients(rho_inf)
    return gamma_beta * (1 / 3 + 4 * c_q * (ratio - 1) + 4 * eta * (ratio - 1) ** 2 / ratio)


def mean_ratio(moments: Sequence[float]) -> float:
    """1/q: what stands for p when a body spins about the first of three different principal moments of inertia."""
    j, j1, j2 = moments
    if j1 == j2:
        return j / j1  # what follows is 0/0 for a disc
    return (2 * j * (j1 + j2 - j)) / (4 * j1 * j2 - j * (j1 + j2))


def unsymmetric_sigma(rho_inf: float, moments: Sequence[float]) -> float:
    """σ* for spin about the first of three principal axes with these moments of inertia."""
    gamma_beta, c_q, eta = coefficients(rho_inf)
    return 4 * gamma_beta * (1 / 12 - c_q + eta / mean_ratio(moments))


def is_nearly_symmetric(moments: Sequence[float]) -> bool:
    """Whether σ* can be trusted: little wobble, and not near spin about the middle axis, which is unstable."""
    j, j1, j2 = moments
    return abs(j1 - j2) <= min(0.4 * (j1 + j2 - j), abs(j - 0.5 * (j1 + j2)))
