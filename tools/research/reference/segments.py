"""A flexible beam as a chain of rigid segments with rotational springs: the physics without modes.

The beam of a cloud is cut in the middle between its sections. Segment k, k = 0 … N, carries the mass and the rotary
inertia of section k; hinge j joins segments j − 1 and j, with the rotation vector φ_j and the spring of the cut length,
½ (EI/l) φ². A hinge bends but does not twist, a chain does not stretch: what the modes describe, but with geometrically
exact motion, and therefore with geometric stiffening. The error falls with 1/N².

Velocities v = (ω of segment 0 along its free axes, φ̇); with ω_k = Jω v and ṗ_k = Jv v, segment k's Newton and Euler
equations are projected onto v. State: quaternion of segment 0, φ, v.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from research.reference import GRAVITY
from research.reference.clouds import (
    PENDULUM_ANGULAR_VELOCITY,
    PENDULUM_BENDING,
    PENDULUM_LENGTH,
    PENDULUM_MASS,
    SpinUp,
)

# (1 − cos θ)/θ² and (θ − sin θ)/θ³ as polynomials in u = θ², highest power first, exact to rounding for θ < 2
_A = np.array([(-1.0) ** k / factorial(2 * k + 2) for k in range(12)][::-1])
_B = np.array([(-1.0) ** k / factorial(2 * k + 3) for k in range(12)][::-1])
_A1, _B1 = np.polyder(_A), np.polyder(_B)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a × b along the last axis; np.cross takes much longer for a few vectors."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        result[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return result


def _tangent(phi: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """T with Eᵀ Ė = (T φ̇)~ for E = exp(φ~), and Ṫ φ̇; T = I − a φ~ + b φ~² (n × 3 → n × 3 × 3, n × 3)."""
    u, change = (phi * phi).sum(1), 2.0 * (phi * rate).sum(1)
    tilde = _cross(phi[:, None], -np.eye(3)[None])  # rows −φ × e_i: the matrix φ~
    a, b = np.polyval(_A, u)[:, None], np.polyval(_B, u)[:, None]
    matrix = np.eye(3) - a[:, None] * tilde + b[:, None] * (tilde @ tilde)
    turn = _cross(phi, rate)
    a1, b1 = (np.polyval(c, u)[:, None] * change[:, None] for c in (_A1, _B1))
    return matrix, -a1 * turn + b1 * _cross(phi, turn) + b * _cross(rate, turn)


@dataclass(frozen=True)
class Chain:
    """Chain of segments + 1 segments; `bending` = EI in y and z, None: rigid in z. Its root turns about W's origin."""

    length: float  # m
    mass: float  # kg
    segments: int
    half_width: float  # m, of the sections' square of four nodes
    bending: tuple[float, float | None]  # N m2
    gravity: np.ndarray
    hub_inertia: float | None = None  # kg m2: the root turns about W z only, with this inertia; None: about all axes
    torque: Callable[[float], float] = lambda t: 0.0  # N m about W z, on the hub

    @property
    def _axes(self) -> np.ndarray:
        """Axes of a hinge, 3 × d: bending in y turns about z, bending in z about y."""
        return np.eye(3)[:, [2]] if self.bending[1] is None else np.eye(3)[:, [2, 1]]

    @property
    def _free(self) -> np.ndarray:
        """Axes about which segment 0 turns, 3 × 1 or 3 × 3."""
        return np.eye(3) if self.hub_inertia is None else np.eye(3)[:, [2]]

    def start(self, angular_velocity: np.ndarray) -> np.ndarray:
        """State with R = I, straight, turning as one rigid body."""
        still = np.zeros(self.segments * self._axes.shape[1])
        return np.concatenate([[1.0, 0.0, 0.0, 0.0], still, self._free.T @ angular_velocity, still])

    def _split(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        d, free = self.segments * self._axes.shape[1], self._free.shape[1]
        q, phi, base, rate = np.split(y, [4, 4 + d, 4 + d + free])
        return q, phi.reshape(self.segments, -1), base, rate.reshape(self.segments, -1)

    def _rotations(self, q: np.ndarray, phi: np.ndarray) -> np.ndarray:
        turns = Rotation.from_rotvec(phi @ self._axes.T).as_matrix()
        rotations = [Rotation.from_quat(q, scalar_first=True).as_matrix()]
        for turn in turns:
            rotations.append(rotations[-1] @ turn)
        return np.array(rotations)

    def points(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Centres of the segments in W, and in the frame of segment 0 (each segments + 1 × 3)."""
        q, phi, _, _ = self._split(y)
        rotations = self._rotations(q, phi)
        half = 0.5 * self.length / self.segments * rotations[:, :, 0]
        points = np.concatenate([np.zeros((1, 3)), np.cumsum(half[:-1] + half[1:], axis=0)])
        return points, points @ rotations[0]

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        """ẏ."""
        n, cut = self.segments, self.length / self.segments
        q, phi, base, rate = self._split(y)
        axes, free = self._axes, self._free
        d = axes.shape[1]
        masses = np.full(n + 1, self.mass / n)
        masses[[0, -1]] *= 0.5
        inertias = masses[:, None] * self.half_width**2 * np.array([2.0, 1.0, 1.0])
        if self.hub_inertia is not None:
            inertias[0, 2] += self.hub_inertia

        r = self._rotations(q, phi)
        tangent, drift = _tangent(phi @ axes.T, rate @ axes.T)
        columns = r[1:] @ tangent @ axes  # n × 3 × d: what φ̇_j adds to ω in W
        relative = (columns @ rate[:, :, None])[:, :, 0]
        omega = np.cumsum(np.concatenate([(r[0] @ free @ base)[None], relative]), axis=0)
        added = _cross(omega[1:], relative) + (r[1:] @ drift[:, :, None])[:, :, 0]
        alpha = np.cumsum(np.concatenate([np.zeros((1, 3)), added]), axis=0)  # at v̇ = 0
        half = 0.5 * cut * r[:, :, 0]
        swing = _cross(alpha, half) + _cross(omega, _cross(omega, half))
        zero = np.zeros((1, 3))
        points = np.concatenate([zero, np.cumsum(half[:-1] + half[1:], axis=0)])
        bias = np.concatenate([zero, np.cumsum(swing[:-1] + swing[1:], axis=0)])

        # Jω: segments × 3 × velocities; Jv: column × arm from its pivot, for the segments behind it
        every = np.concatenate([r[0] @ free, columns.transpose(1, 0, 2).reshape(3, -1)], axis=1)
        pivots = np.concatenate([np.zeros((free.shape[1], 3)), np.repeat(points[1:] - half[1:], d, axis=0)])
        first = np.concatenate([np.zeros(free.shape[1]), np.repeat(np.arange(1, n + 1), d)])
        behind = (np.arange(n + 1)[:, None] >= first)[:, :, None]
        turning = behind * every.T  # segments × velocities × 3
        moving = behind * _cross(every.T[None], points[:, None] - pivots)

        def in_axes(vectors: np.ndarray) -> np.ndarray:
            return vectors @ r  # from W into the segments' axes

        local = in_axes(turning)
        spin, spin_rate = (in_axes(v[:, None])[:, 0] for v in (omega, alpha))
        momentum = inertias * spin_rate + _cross(spin, inertias * spin)
        size = len(first)
        root = np.concatenate(
            [
                np.sqrt(masses)[:, None, None] * moving.transpose(0, 2, 1),
                np.sqrt(inertias)[:, :, None] * local.transpose(0, 2, 1),
            ]
        ).reshape(-1, size)
        load = masses[:, None] * (bias - self.gravity)
        force = -np.tensordot(load, moving, ([0, 1], [0, 2])) - np.tensordot(momentum, local, ([0, 1], [0, 2]))
        springs = np.array([b for b in self.bending if b is not None]) / cut
        force[free.shape[1] :] -= (springs * phi).ravel()
        if self.hub_inertia is not None:
            force[0] += self.torque(t)
        w, u, own = q[0], q[1:], free @ base
        turned = 0.5 * np.concatenate([[-u @ own], w * own + _cross(u, own)])
        return np.concatenate([turned, rate.ravel(), np.linalg.solve(root.T @ root, force)])

    def solve(self, y0: np.ndarray, times: np.ndarray, rtol: float, method: str = "DOP853") -> np.ndarray:
        """States at `times`, samples × states."""
        solution = solve_ivp(
            self.rhs, (times[0], times[-1]), y0, method=method, t_eval=times, rtol=rtol, atol=0.1 * rtol
        )
        if not solution.success:
            raise RuntimeError(f"{method} stopped at t = {solution.t[-1]} s: {solution.message}")
        return solution.y.T


def pendulum_chain(bending: tuple[float, float] = PENDULUM_BENDING, segments: int = 10) -> Chain:
    """FlexiblePendulum as a chain; with ten segments it has the sections of the pendulum's cloud."""
    return Chain(PENDULUM_LENGTH, PENDULUM_MASS, segments, 0.02, bending, GRAVITY)


def pendulum_motion(chain: Chain, times: np.ndarray, rtol: float = 1e-8) -> tuple[np.ndarray, np.ndarray]:
    """Tip of the pendulum in W and in the frame of its root, samples × 3, from the mechanism's initial state."""
    states = chain.solve(chain.start(PENDULUM_ANGULAR_VELOCITY), times, rtol)
    tips = [tuple(p[-1] for p in chain.points(y)) for y in states]
    return np.array([t[0] for t in tips]), np.array([t[1] for t in tips])


def spin_up_chain(spin_up: SpinUp, segments: int) -> Chain:
    """SpinUpBeam as a chain in the plane."""
    inertia = spin_up.inertia
    return Chain(
        spin_up.length,
        spin_up.mass,
        segments,
        spin_up.half_width,
        (spin_up.bending, None),
        np.zeros(3),
        spin_up.hub_inertia,
        lambda t: inertia * float(spin_up.acceleration(t)),
    )


def spin_up_deflection(spin_up: SpinUp, segments: int, times: np.ndarray, rtol: float = 1e-6) -> np.ndarray:
    """Tip deflection across the hub's x axis, m. Radau: the chain's high frequencies are at rest."""
    chain = spin_up_chain(spin_up, segments)
    states = chain.solve(chain.start(np.zeros(3)), times, rtol, "Radau")
    return np.array([chain.points(y)[1][-1, 1] for y in states])
