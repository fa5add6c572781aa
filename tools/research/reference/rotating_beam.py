"""Eigenfrequencies of a uniform beam clamped to a turning hub of no radius, by Ritz's method, to many digits.

Units: length L, mass ρA L, time sqrt(ρA L⁴ / EI). The centrifugal force stretches the beam, N(ξ) = ½ Ω² (1 − ξ²), so

    in the plane of rotation:   K + Ω² (G − M),      across it:   K + Ω² G,

with K = ∫ w_i″w_j″, G = ∫ ½ (1 − ξ²) w_i′w_j′ and M = ∫ w_i w_j. Without G (linear modes) the stiffness in the plane is
K − Ω² M, which is negative as soon as Ω exceeds the first eigenfrequency at rest. Southwell's formula
ω² = ω_0² + c Ω² takes c = wᵀ G w / wᵀ M w (1.193 for the first mode) minus one in the plane.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss
from scipy.linalg import eigh


def _matrices(terms: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K, G and M for w_k = ξ² P_k(2ξ − 1), by Gauss quadrature that is exact for them."""
    points, weights = leggauss(terms + 4)
    xi, weights = 0.5 * (points + 1.0), 0.5 * weights
    shapes = [Polynomial([0, 0, 1]) * Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial) for k in range(terms)]
    w, slope, curvature = (np.array([s.deriv(n)(xi) for s in shapes]) for n in (0, 1, 2))
    return (curvature * weights) @ curvature.T, (slope * weights * 0.5 * (1.0 - xi**2)) @ slope.T, (w * weights) @ w.T


def frequencies(speed: float, in_plane: bool, stiffening: bool = True, terms: int = 10) -> np.ndarray:
    """Squares of the eigenfrequencies, ascending (negative: diverges); the first few of `terms` are exact to ~1e-8."""
    k, g, m = _matrices(terms)
    return eigh(k + speed**2 * (stiffening * g - in_plane * m), m, eigvals_only=True)


def southwell(mode: int, terms: int = 10) -> float:
    """c = wᵀ G w / wᵀ M w of a mode at rest (0: the first), out of plane."""
    k, g, m = _matrices(terms)
    vector = eigh(k, m)[1][:, mode]
    return float(vector @ g @ vector)
