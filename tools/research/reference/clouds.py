"""Flexible beams as nodal clouds with mode shapes, by formula, and the flexible benchmark mechanisms made of them.

A cloud has n nodes X_i with masses m_i, and n_f mode shapes Φ_i (3 × n_f) with modal coordinates ζ (m):

    r_i = x + R (X_i + Φ_i ζ),   T = ½ Σ m_i ṙ_i·ṙ_i,   V = ½ ζᵀ K ζ

without geometric stiffening. A beam lies along x from 0 to L in equal sections of four nodes (x, ±c, ±c); the mass of a
section is that of the length it stands for (half at the ends). A deflection w(ξ), ξ = x/L, turns the sections with it:

    bending in y: u = (−y w′, w, 0),   bending in z: u = (−z w′, 0, w),   w′ = dw/dx.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

Shape = tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray], np.ndarray]]
"""A deflection shape w(ξ) and its derivative dw/dξ; w = 1 stands for one metre per unit of its coordinate."""


@dataclass(frozen=True)
class Cloud:
    """Nodes, masses, modes and stiffness of a flexible body, in its frame."""

    nodes: np.ndarray  # n × 3, m
    masses: np.ndarray  # n, kg
    modes: np.ndarray  # n × 3 × n_f, 1
    stiffness: np.ndarray  # n_f × n_f, N/m

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(self.masses.sum())

    @property
    def modal_mass(self) -> np.ndarray:
        """Mass matrix of ζ with the frame held, n_f × n_f, kg."""
        return np.einsum("i,iaf,iag->fg", self.masses, self.modes, self.modes)

    def section(self, k: int) -> slice:
        """The four nodes of section k (−1: the last); their mean is a point of the centre line."""
        k = k % (len(self.nodes) // 4)
        return slice(4 * k, 4 * k + 4)


def beam_cloud(
    length: float,
    mass: float,
    intervals: int,
    half_width: float,
    y_shapes: Sequence[Shape],
    z_shapes: Sequence[Shape],
    stiffness: np.ndarray,
) -> Cloud:
    """Cloud of a beam with intervals + 1 sections; its modes are the y shapes, then the z shapes."""
    station = np.arange(intervals + 1) / intervals
    corner = half_width * np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
    xi, corners = np.repeat(station, 4), np.tile(corner, (intervals + 1, 1))
    section_mass = np.full(intervals + 1, mass / intervals)
    section_mass[[0, -1]] *= 0.5
    modes = np.zeros((len(xi), 3, len(y_shapes) + len(z_shapes)))
    directions = [1] * len(y_shapes) + [2] * len(z_shapes)
    for f, (axis, (w, slope)) in enumerate(zip(directions, (*y_shapes, *z_shapes), strict=True)):
        modes[:, 0, f] = -corners[:, axis - 1] * slope(xi) / length
        modes[:, axis, f] = w(xi)
    return Cloud(np.column_stack([length * xi, corners]), np.repeat(section_mass / 4.0, 4), modes, stiffness)


def power(n: int) -> Shape:
    """w = ξⁿ."""
    return lambda xi: xi**n, lambda xi: n * xi ** (n - 1)


def power_stiffness(powers: Sequence[int], bending: float, length: float) -> np.ndarray:
    """EI ∫ w_i″ w_j″ dx of w = ξⁿ (n ≥ 2): EI/L³ · i (i−1) j (j−1) / (i + j − 3); bending = EI in N m2."""
    i, j = np.meshgrid(powers, powers, indexing="ij")
    return bending / length**3 * (i * (i - 1) * j * (j - 1) / (i + j - 3))


def sine(n: int) -> Shape:
    """w = sin nπξ, mode n of a beam pinned at both ends."""
    return lambda xi: np.sin(n * np.pi * xi), lambda xi: n * np.pi * np.cos(n * np.pi * xi)


def cantilever_root(n: int) -> float:
    """β_n of the clamped-free beam, cos β cosh β = −1, n = 1, 2, …; its eigenfrequency is β² sqrt(EI / (ρA L⁴))."""
    # cos β + 1/cosh β has one root within ±1 of (n − ½) π and no overflow
    middle = (n - 0.5) * np.pi
    return brentq(lambda beta: np.cos(beta) + 1.0 / np.cosh(beta), middle - 1.0, middle + 1.0, xtol=1e-15, rtol=1e-15)


def free_root(n: int) -> float:
    """β_n of the free-free (or clamped-clamped) beam, cos β cosh β = 1, n = 1, 2, …, without the rigid modes."""
    middle = (n + 0.5) * np.pi
    return brentq(lambda beta: np.cos(beta) - 1.0 / np.cosh(beta), middle - 1.0, middle + 1.0, xtol=1e-15, rtol=1e-15)


def cantilever(n: int) -> Shape:
    """Mode n of the clamped-free beam, one at the tip: w ∝ cosh βξ − cos βξ − s (sinh βξ − sin βξ)."""
    beta = cantilever_root(n)
    s = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
    scale = 0.5 * (-1.0) ** (n + 1)  # the bracket is ±2 at ξ = 1

    def w(xi: np.ndarray) -> np.ndarray:
        return scale * (np.cosh(beta * xi) - np.cos(beta * xi) - s * (np.sinh(beta * xi) - np.sin(beta * xi)))

    def slope(xi: np.ndarray) -> np.ndarray:
        return scale * beta * (np.sinh(beta * xi) + np.sin(beta * xi) - s * (np.cosh(beta * xi) - np.cos(beta * xi)))

    return w, slope


def _two_planes(y_stiffness: np.ndarray, z_stiffness: np.ndarray) -> np.ndarray:
    zero = np.zeros((len(y_stiffness), len(z_stiffness)))
    return np.block([[y_stiffness, zero], [zero.T, z_stiffness]])


# FlexiblePendulum: a beam whose frame turns about its root at the origin of W.
PENDULUM_LENGTH = 1.0  # m
PENDULUM_MASS = 1.0  # kg
PENDULUM_BENDING = (8.0, 12.0)  # N m2, EI in y and in z
PENDULUM_ANGULAR_VELOCITY = np.array([2.0, -3.0, 6.0])  # rad/s at t = 0, R = I


def pendulum_cloud(bending: tuple[float, float] = PENDULUM_BENDING, intervals: int = 10) -> Cloud:
    """The pendulum's beam: shapes ξ², ξ³ in y and in z, tangent to the frame at the root."""
    shapes = [power(2), power(3)]
    stiffness = _two_planes(*(power_stiffness([2, 3], b, PENDULUM_LENGTH) for b in bending))
    return beam_cloud(PENDULUM_LENGTH, PENDULUM_MASS, intervals, 0.02, shapes, shapes, stiffness)


# FlexibleSliderCrank: the slider-crank with this rod; its frame has the origin in B and e_x towards C.
CONROD_BENDING = (4.0, 6.0)  # N m2, EI in y and in z


def conrod_cloud(length: float, mass: float) -> Cloud:
    """The connecting rod: shapes sin πξ, sin 2πξ in y and in z, both ends on the frame's axis."""
    shapes = [sine(1), sine(2)]
    wave = np.array([1, 2]) * np.pi / length
    stiffness = _two_planes(*(np.diag(b * wave**4 * length / 2.0) for b in CONROD_BENDING))
    return beam_cloud(length, mass, 10, 0.02, shapes, shapes, stiffness)


@dataclass(frozen=True)
class SpinUp:
    """Spin-up of a cantilever on a hub that turns about W z, in the plane, without gravity.

    The beam is that of Wu and Haug (Int. J. Numer. Methods Eng. 26 (1988) 2211), the law of the speed that of Kane,
    Ryan and Banerjee (J. Guidance 10 (1987) 139): Ω(t) = Ω_s (t/T_s − sin(2πt/T_s) / 2π) up to T_s, then Ω_s. Here a
    torque drives the hub, T = J Ω̇ with J the inertia of hub and straight beam about W z. With a hub this heavy its
    speed follows the law although the beam bends. The hub's axis is the root of the beam.

    Linear modes have no geometric stiffening: in the turning frame the beam's stiffness is K − Ω² M instead of growing
    with Ω². Half way of the rise it bends too far by about (c Ω²/ω_1²), c = 1.193, Ω = Ω_s/2, ω_1 = 2.91 rad/s: 1 % at
    Ω_s = 0.5, 4 % at 1, 17 % at 2 rad/s; above ω_1 it diverges. The published manoeuvre, 6 rad/s, is out of its reach.
    """

    length: float = 8.0  # m
    area: float = 7.3e-5  # m2
    second_moment: float = 8.218e-9  # m4
    density: float = 2766.0  # kg/m3
    modulus: float = 6.895e10  # N/m2
    hub_inertia: float = 1000.0  # kg m2 about W z
    final_speed: float = 0.5  # rad/s, Ω_s
    rise_time: float = 15.0  # s, T_s
    intervals: int = 40
    modes: int = 3

    @property
    def mass(self) -> float:
        """Mass of the beam, kg."""
        return self.density * self.area * self.length

    @property
    def bending(self) -> float:
        """EI, N m2."""
        return self.modulus * self.second_moment

    @property
    def half_width(self) -> float:
        """Distance c of the nodes from the centre line that gives the rotary inertia ρI: c² = I/A."""
        return float(np.sqrt(self.second_moment / self.area))

    @property
    def cloud(self) -> Cloud:
        """The beam: cantilever modes in y; K_jj = EI β_j⁴ / (4 L³), from ∫ w² dξ = ¼ of modes that are 1 at the tip."""
        shapes = [cantilever(n) for n in range(1, self.modes + 1)]
        roots = np.array([cantilever_root(n) for n in range(1, self.modes + 1)])
        stiffness = np.diag(self.bending * roots**4 / (4.0 * self.length**3))
        return beam_cloud(self.length, self.mass, self.intervals, self.half_width, shapes, [], stiffness)

    @property
    def inertia(self) -> float:
        """J of hub and straight beam about W z, kg m2."""
        cloud = self.cloud
        return self.hub_inertia + float(cloud.masses @ (cloud.nodes[:, 0] ** 2 + cloud.nodes[:, 1] ** 2))

    def speed(self, t: np.ndarray) -> np.ndarray:
        """The law Ω(t), rad/s."""
        x = np.minimum(t / self.rise_time, 1.0)
        return self.final_speed * (x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi))

    def acceleration(self, t: np.ndarray) -> np.ndarray:
        """Its derivative (Ω_s/T_s)(1 − cos(2πt/T_s)), zero after T_s; rad/s2."""
        x = np.minimum(t / self.rise_time, 1.0)
        return self.final_speed / self.rise_time * (1.0 - np.cos(2.0 * np.pi * x))

    def angle(self, t: np.ndarray) -> np.ndarray:
        """Its integral, rad: Ω_s T_s (x²/2 + (cos 2πx − 1) / 4π²), x = t/T_s ≤ 1, then at constant speed."""
        x = np.minimum(t / self.rise_time, 1.0)
        rising = 0.5 * x * x + (np.cos(2.0 * np.pi * x) - 1.0) / (4.0 * np.pi**2)
        return self.final_speed * (self.rise_time * rising + np.maximum(t - self.rise_time, 0.0))
