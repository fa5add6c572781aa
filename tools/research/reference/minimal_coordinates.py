"""Independent solutions of the benchmark mechanisms: minimal coordinates, no constraints, no multipliers.

- HeavyTop: rotation about the fixed point; Euler's equations about the pivot, quaternion kinematics; SciPy's DOP853.
- HighSpeedRotor: a free axisymmetric body; its axis and its angular momentum carry the motion, so that the spin of
  20944 rad/s does not have to be resolved; the spin angle is integrated beside them; SciPy's DOP853.
- SliderCrank: one degree of freedom, the crank angle θ; kinematics in closed form, θ(t) from the energy integral by
  quadrature; θ̈ by projecting Newton's and Euler's equations onto ∂q/∂θ, reactions from them body by body.

Each returns a history under the FMU's variable names. Frames and units as in `research.reference`.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from research.reference import (
    CRANK,
    CRANK_CENTRE,
    CRANK_LENGTH,
    GRAVITY,
    ROD,
    ROD_LENGTH,
    SLIDER,
    TOP,
    TOP_PIVOT,
    Body,
    History,
    Rotor,
    add_vector,
    continuous_sign,
    quaternions_from_matrices,
)

RELATIVE_TOLERANCE = 2.3e-14  # the smallest that SciPy accepts (100 ε)


def integrate(
    rhs: Callable, y0: np.ndarray, times: np.ndarray, atol: np.ndarray | float, first_step: float
) -> np.ndarray:
    """Solve y' = rhs(t, y) with DOP853; states at `times` (y0 at the first of them), samples × states.

    Every sample ends a step, because DOP853's interpolant is only of seventh order.
    """
    states, step = [y0], first_step
    for begin, end in pairwise(times):
        step = min(step, end - begin)
        solution = solve_ivp(
            rhs, (begin, end), states[-1], method="DOP853", rtol=RELATIVE_TOLERANCE, atol=atol, first_step=step
        )
        if not solution.success:
            raise RuntimeError(f"DOP853 stopped at t = {solution.t[-1]} s: {solution.message}")
        states.append(solution.y[:, -1])
        step = np.diff(solution.t).max()
    return np.array(states)


def rotation_matrices(quaternions: np.ndarray) -> np.ndarray:
    """R = I + 2 w ũ + 2 ũ² for unit quaternions (w, u), n × 4 → n × 3 × 3."""
    w, u = quaternions[:, 0], quaternions[:, 1:]
    tilde = np.zeros((len(u), 3, 3))
    tilde[:, 0, 1], tilde[:, 0, 2], tilde[:, 1, 2] = -u[:, 2], u[:, 1], -u[:, 0]
    tilde -= tilde.transpose(0, 2, 1)
    return np.eye(3) + 2.0 * w[:, None, None] * tilde + 2.0 * tilde @ tilde


def _quaternion_product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Hamilton product p ∘ q of quaternions (w, x, y, z), n × 4."""
    w = p[:, 0] * q[:, 0] - np.einsum("ij,ij->i", p[:, 1:], q[:, 1:])
    u = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.column_stack([w, u])


def _add_body(history: History, name: str, position: np.ndarray, quaternion: np.ndarray, velocity: np.ndarray) -> None:
    add_vector(history, f"{name}.position", position)
    add_vector(history, f"{name}.quaternion", quaternion)
    add_vector(history, f"{name}.velocity", velocity)


def heavy_top(times: np.ndarray) -> History:
    """Heavy top about its pivot: J_P ω̇ + ω × J_P ω = m d × Rᵀg, ṗ = ½ p ∘ (0, ω), ω in B.

    d is the COM seen from the pivot and J_P = J + m (dᵀd I − d dᵀ), both in B. The pivot's force on the top follows
    from Newton's law, F = m (a − g) with a = R (ω̇ × d + ω × (ω × d)).
    """
    mass, d = TOP.mass, -TOP_PIVOT
    inertia = np.diag(TOP.inertia) + mass * (d @ d * np.eye(3) - np.outer(d, d))
    jx, jy, jz = np.diag(inertia)  # d lies on a principal axis, so J_P stays diagonal
    dx, dy, dz = mass * d
    gx, gy, gz = GRAVITY

    def rhs(_t: float, y: np.ndarray) -> list[float]:
        w, x, yy, z, ox, oy, oz = y.tolist()
        # Rᵀ g, divided by pᵀp: the norm may drift in the last digits
        n = w * w + x * x + yy * yy + z * z
        bx = ((w * w + x * x - yy * yy - z * z) * gx + 2 * (x * yy + w * z) * gy + 2 * (x * z - w * yy) * gz) / n
        by = (2 * (x * yy - w * z) * gx + (w * w - x * x + yy * yy - z * z) * gy + 2 * (yy * z + w * x) * gz) / n
        bz = (2 * (x * z + w * yy) * gx + 2 * (yy * z - w * x) * gy + (w * w - x * x - yy * yy + z * z) * gz) / n
        return [
            0.5 * (-x * ox - yy * oy - z * oz),
            0.5 * (w * ox + yy * oz - z * oy),
            0.5 * (w * oy + z * ox - x * oz),
            0.5 * (w * oz + x * oy - yy * ox),
            (dy * bz - dz * by - (jz - jy) * oy * oz) / jx,
            (dz * bx - dx * bz - (jx - jz) * oz * ox) / jy,
            (dx * by - dy * bx - (jy - jx) * ox * oy) / jz,
        ]

    y0 = np.array([1.0, 0.0, 0.0, 0.0, *TOP.angular_velocity])  # R = I: ω is the same in B and in W
    states = integrate(rhs, y0, times, np.array([1e-15] * 4 + [1e-13] * 3), first_step=1e-3)
    quaternions = states[:, :4] / np.linalg.norm(states[:, :4], axis=1, keepdims=True)
    omega = states[:, 4:]
    omega_dot = np.array([rhs(0.0, y)[4:] for y in states])
    rotations = rotation_matrices(quaternions)

    def in_world(vectors: np.ndarray) -> np.ndarray:
        return np.einsum("nij,nj->ni", rotations, vectors)

    velocity = np.cross(omega, d)
    acceleration = in_world(np.cross(omega_dot, d) + np.cross(omega, velocity))
    history: History = {"time": times}
    _add_body(
        history, "top", in_world(np.broadcast_to(d, omega.shape)), continuous_sign(quaternions), in_world(velocity)
    )
    add_vector(history, "top.angularVelocity", omega)
    add_vector(history, "pivot.reactionForce", mass * (acceleration - GRAVITY))
    return history


def high_speed_rotor(times: np.ndarray, rotor: Rotor | None = None) -> History:
    """Axisymmetric rotor on two supports, without resolving its spin.

    With the axis e = R e_x (in W) and Ω = ω · e the angular momentum is L = J_x Ω e + J_t e × ė, hence

        ẋ = v,   m v̇ = Σ F_i,   ė = L × e / J_t,   L̇ = t + Σ r_i × F_i,   Ω = L · e / J_x,

    with support points p_i = x + r_i, r_i = a_i e, and forces F_i = −k (p_i − g_i) − d ṗ_i. What is left to resolve is
    nutation (J_x Ω / J_t ≈ 4e4 rad/s, tiny) and slower motion. The orientation is R = N(e) exp(φ ẽ_x) with N the
    shortest rotation from e_x to e. With tilt ϑ, its azimuth α and A, B rotations about e_x and about the axis of the
    tilt, N = A(α) B(ϑ) A(−α); its angular velocity is α̇ e_x + ϑ̇ n − α̇ e, the part along e is −α̇ (1 − cos ϑ), and
    α̇ sin²ϑ = (e × ė)_x. So the spin angle obeys

        φ̇ = Ω + (e × ė)_x / (1 + e_x);   integrated is δ = φ − Ω(0) t, which stays small.
    """
    rotor = rotor or Rotor()
    mass, (jx, jt, _) = rotor.mass, rotor.inertia
    k, c, left, right = rotor.stiffness, rotor.damping, -rotor.left, rotor.right
    tx, ty, tz = rotor.torque.tolist()

    def rhs(_t: float, y: np.ndarray) -> list[float]:
        px, py, pz, vx, vy, vz, ex, ey, ez, lx, ly, lz, _ = y.tolist()
        dx, dy, dz = (ly * ez - lz * ey) / jt, (lz * ex - lx * ez) / jt, (lx * ey - ly * ex) / jt  # ė
        # left support holds x, y, z; right support y, z; ground points lie at a_i e_x
        f1x = -k * (px + left * (ex - 1.0)) - c * (vx + left * dx)
        f1y = -k * (py + left * ey) - c * (vy + left * dy)
        f1z = -k * (pz + left * ez) - c * (vz + left * dz)
        f2y = -k * (py + right * ey) - c * (vy + right * dy)
        f2z = -k * (pz + right * ez) - c * (vz + right * dz)
        mx, my, mz = left * f1x, left * f1y + right * f2y, left * f1z + right * f2z  # Σ a_i F_i
        spin = (lx * ex + ly * ey + lz * ez) / jx
        return [
            vx,
            vy,
            vz,
            f1x / mass,
            (f1y + f2y) / mass,
            (f1z + f2z) / mass,
            dx,
            dy,
            dz,
            tx + ey * mz - ez * my,
            ty + ez * mx - ex * mz,
            tz + ex * my - ey * mx,
            spin - rotor.spin + (ey * dz - ez * dy) / (1.0 + ex),
        ]

    y0 = np.zeros(13)
    y0[6], y0[9] = 1.0, jx * rotor.spin
    atol = np.array([1e-15] * 3 + [1e-12] * 3 + [1e-15] * 3 + [1e-14] * 3 + [1e-12])
    states = integrate(rhs, y0, times, atol, first_step=1e-6)
    position, velocity, axis, momentum, delta = np.split(states, [3, 6, 9, 12], axis=1)
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    spin = np.einsum("ni,ni->n", momentum, axis) / jx
    across = momentum / jt - (jx / jt * spin)[:, None] * axis  # e × ė

    # shortest rotation e_x → e as unit quaternion: (1 + e_x, e_x × e) / sqrt(2 (1 + e_x))
    shortest = np.column_stack([1.0 + axis[:, 0], np.zeros(len(axis)), -axis[:, 2], axis[:, 1]])
    shortest /= np.linalg.norm(shortest, axis=1, keepdims=True)
    half = 0.5 * (rotor.spin * times + delta[:, 0])
    turn = np.column_stack([np.cos(half), np.sin(half), np.zeros((len(half), 2))])
    quaternion = continuous_sign(_quaternion_product(shortest, turn))
    rotations = rotation_matrices(quaternion)
    history: History = {"time": times}
    _add_body(history, "rotor", position, quaternion, velocity)
    add_vector(history, "rotor.angularVelocity", np.einsum("nji,nj->ni", rotations, spin[:, None] * axis + across))
    add_vector(history, "leftSupport.position", position + left * axis)
    add_vector(history, "rightSupport.position", position + right * axis)
    return history


class SliderCrank:
    """Kinematics and dynamics of the slider-crank as functions of θ (arrays allowed), rotation about W x.

    B = A + l (0, −sin θ, cos θ),   C = (s, 0, 0),   s = sqrt(L² − B_y² − B_z²)   (B_x = 0),

    rod e_x = (C − B) / L. The universal joint asks for slider e_x ⟂ rod e_y; the slider does not turn, so e_y is
    perpendicular to W x and to e_x: e_y = (W x × e_x) / |W x × e_x|, with the sign of the initial configuration, and
    e_z = e_x × e_y. B never reaches the W x axis (|A| = 0.156 > l = 0.08), so e_y is unique all along.

    A prime is d/dθ. For a frame, ω = w θ̇ with w = ½ Σ e_i × e_i′ and w′ = ½ Σ e_i × e_i″.
    """

    def __init__(self, theta: np.ndarray) -> None:
        theta = np.atleast_1d(np.asarray(theta, dtype=float))
        sin, cos, zero = np.sin(theta), np.cos(theta), np.zeros_like(theta)
        crank_y = [np.stack(v, axis=1) for v in ((zero, cos, sin), (zero, -sin, cos), (zero, -cos, -sin))]
        crank_z = [np.stack(v, axis=1) for v in ((zero, -sin, cos), (zero, -cos, -sin), (zero, sin, -cos))]
        crank_x = [np.stack([zero + one, zero, zero], axis=1) for one in (1.0, 0.0, 0.0)]
        b = [CRANK_CENTRE * one + CRANK_LENGTH * z for one, z in zip((1.0, 0.0, 0.0), crank_z, strict=True)]

        # s² = L² − B·B, s s′ = −B·B′, s s″ = −B·B″ − B′·B′ − s′²
        s = np.sqrt(ROD_LENGTH**2 - _dot(b[0], b[0]))
        s1 = -_dot(b[0], b[1]) / s
        s2 = -(_dot(b[0], b[2]) + _dot(b[1], b[1]) + s1 * s1) / s
        c = [np.stack([value, zero, zero], axis=1) for value in (s, s1, s2)]
        rod_x = [(end - begin) / ROD_LENGTH for begin, end in zip(b, c, strict=True)]
        across = [np.stack([zero, -x[:, 2], x[:, 1]], axis=1) for x in rod_x]  # W x × e_x and its derivatives
        rod_y = _unit(across)
        rod_z = [
            np.cross(rod_x[0], rod_y[0]),
            np.cross(rod_x[1], rod_y[0]) + np.cross(rod_x[0], rod_y[1]),
            np.cross(rod_x[2], rod_y[0]) + 2.0 * np.cross(rod_x[1], rod_y[1]) + np.cross(rod_x[0], rod_y[2]),
        ]
        half = 0.5 * CRANK_LENGTH
        self.bodies = {
            "crank": _BodyMotion(
                CRANK, [p - half * z for p, z in zip(b, crank_z, strict=True)], crank_x, crank_y, crank_z
            ),
            "rod": _BodyMotion(ROD, [0.5 * (p + q) for p, q in zip(b, c, strict=True)], rod_x, rod_y, rod_z),
            "slider": _BodyMotion(
                SLIDER, c, *([np.eye(3)[i] * one + 0 * b[0] for one in (1.0, 0.0, 0.0)] for i in range(3))
            ),
        }
        self.b, self.c, self.theta = b[0], c[0], theta

    def acceleration(self, rate: np.ndarray) -> np.ndarray:
        """θ̈ from Σ x′·(m ẍ − m g) + w·(J ω̇ + ω × J ω) = 0, a linear equation in θ̈."""
        mass = force = 0.0
        for body in self.bodies.values():
            mass = mass + body.body.mass * _dot(body.x[1], body.x[1]) + _dot(body.w, body.turned(body.w))
            force = force - _dot(body.x[1], body.inertial_force(rate, 0.0 * rate))
            force = force - _dot(body.w, body.inertial_torque(rate, 0.0 * rate))
        return force / mass

    def energy(self, rate: np.ndarray) -> np.ndarray:
        """Kinetic plus potential energy, J (potential zero at z = 0)."""
        total = 0.0
        for body in self.bodies.values():
            m, x, w = body.body.mass, body.x, body.w
            total = total + 0.5 * rate**2 * (m * _dot(x[1], x[1]) + _dot(w, body.turned(w))) - m * x[0] @ GRAVITY
        return total

    def reactions(self, rate: np.ndarray) -> dict[str, np.ndarray]:
        """Joint forces on the second body, N, in W: ground → crank → rod → slider, and ground → slider for the guide.

        Unknown are the forces P at B on the rod and W at C on the slider, and the torque τ u on the rod that keeps the
        universal joint's axes perpendicular, u = slider e_x × rod e_y:

            rod:     P − W = f,   (B − x) × P − (C − x) × W + τ u = n,      slider:  W_x = f_x

        with f = m (ẍ − g), n = J ω̇ + ω × J ω. The guide then takes f − W of the slider (no force along W x), the
        crank's pivot f + P of the crank.
        """
        second = self.acceleration(rate)
        crank, rod, slider = self.bodies.values()
        n = len(self.theta)
        matrix, right = np.zeros((n, 7, 7)), np.zeros((n, 7))
        matrix[:, 0:3, 0:3], matrix[:, 0:3, 3:6] = np.eye(3), -np.eye(3)
        matrix[:, 3:6, 0:3] = _tilde(self.b - rod.x[0])
        matrix[:, 3:6, 3:6] = -_tilde(self.c - rod.x[0])
        matrix[:, 3:6, 6] = np.cross([1.0, 0.0, 0.0], rod.axes[1][0])
        matrix[:, 6, 3] = 1.0
        right[:, 0:3] = rod.inertial_force(rate, second)
        right[:, 3:6] = rod.inertial_torque(rate, second)
        right[:, 6] = slider.inertial_force(rate, second)[:, 0]
        solution = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        pin, wrist = solution[:, 0:3], solution[:, 3:6]
        guide = slider.inertial_force(rate, second) - wrist
        guide[:, 0] = 0.0
        return {
            "crankPivot": crank.inertial_force(rate, second) + pin,
            "crankPin": pin,
            "wristPin": wrist,
            "guide": guide,
        }


class _BodyMotion:
    """A body's COM x(θ) and axes e_i(θ) in W, with first and second derivatives; w and w′ of its rotation."""

    def __init__(self, body: Body, x: list[np.ndarray], *axes: list[np.ndarray]) -> None:
        self.body, self.x, self.axes = body, x, axes
        self.w = 0.5 * sum(np.cross(e[0], e[1]) for e in axes)
        self.w1 = 0.5 * sum(np.cross(e[0], e[2]) for e in axes)

    def turned(self, vector: np.ndarray) -> np.ndarray:
        """J u in W, for u in W."""
        moments = self.body.inertia
        return sum(j * _dot(e[0], vector)[:, None] * e[0] for j, e in zip(moments, self.axes, strict=True))

    def inertial_force(self, rate: np.ndarray, second: np.ndarray) -> np.ndarray:
        """m (ẍ − g), N, in W."""
        rate, second = np.atleast_1d(rate)[:, None], np.atleast_1d(second)[:, None]
        return self.body.mass * (self.x[2] * rate**2 + self.x[1] * second - GRAVITY)

    def inertial_torque(self, rate: np.ndarray, second: np.ndarray) -> np.ndarray:
        """J ω̇ + ω × J ω, N m, in W."""
        rate, second = np.atleast_1d(rate)[:, None], np.atleast_1d(second)[:, None]
        omega = self.w * rate
        return self.turned(self.w1 * rate**2 + self.w * second) + np.cross(omega, self.turned(omega))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", a, b)


def _tilde(v: np.ndarray) -> np.ndarray:
    matrix = np.zeros((len(v), 3, 3))
    matrix[:, 0, 1], matrix[:, 0, 2], matrix[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return matrix - matrix.transpose(0, 2, 1)


def _unit(n: list[np.ndarray]) -> list[np.ndarray]:
    """u = n / |n| and its first two derivatives: u′ = (n′ − u r′) / r, u″ = (n″ − 2 u′ r′ − u r″) / r with r = |n|."""
    r = np.sqrt(_dot(n[0], n[0]))
    r1 = _dot(n[0], n[1]) / r
    r2 = (_dot(n[1], n[1]) + _dot(n[0], n[2]) - r1 * r1) / r
    u = n[0] / r[:, None]
    u1 = (n[1] - u * r1[:, None]) / r[:, None]
    u2 = (n[2] - 2.0 * u1 * r1[:, None] - u * r2[:, None]) / r[:, None]
    return [u, u1, u2]


def slider_crank(times: np.ndarray, nodes: int = 512) -> History:
    """Slider-crank from θ = 0, θ̇ = 6 rad/s, by quadrature: no time integration at all.

    One degree of freedom without dissipation has the energy integral ½ M(θ) θ̇² + V(θ) = E. The crank never turns back,
    so t(θ) = ∫ dθ / θ̇ with 1/θ̇ = sqrt(M / (2 (E − V))) =: g(θ), smooth and 2π-periodic: its Fourier series

        g = Σ c_n exp(i n θ)   gives   t(θ) = c_0 θ + Σ_{n≠0} c_n (exp(i n θ) − 1) / (i n)

    to the last digits with a few hundred nodes. θ(t) by Newton's method.
    """

    def kinetic_and_potential(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        mechanism = SliderCrank(theta)
        potential = mechanism.energy(np.zeros_like(theta))
        return mechanism.energy(np.ones_like(theta)) - potential, potential  # ½ M, V

    half_mass, potential = kinetic_and_potential(np.zeros(1))
    energy = half_mass * CRANK.angular_velocity[0] ** 2 + potential

    def rate_of(theta: np.ndarray) -> np.ndarray:
        half_mass, potential = kinetic_and_potential(theta)
        return np.sqrt((energy - potential) / half_mass)

    c = np.fft.rfft(1.0 / rate_of(2.0 * np.pi * np.arange(nodes) / nodes)) / nodes
    if np.abs(c[-4:]).max() > 1e-15:
        raise RuntimeError("the Fourier series of dt/dθ has not converged: take more nodes")
    n = np.arange(1, len(c))
    theta = times / c[0].real
    for _ in range(50):
        series = 2.0 * ((np.exp(1j * np.outer(theta, n)) - 1.0) @ (c[1:] / (1j * n))).real
        change = (c[0].real * theta + series - times) * rate_of(theta)
        theta = theta - change
        if np.abs(change).max() < 1e-14 * max(1.0, np.abs(theta).max()):
            break
    else:
        raise RuntimeError("Newton's method for θ(t) did not converge")

    rate = rate_of(theta)
    mechanism = SliderCrank(theta)
    history: History = {"time": times}
    for name, body in mechanism.bodies.items():
        rotations = np.stack([e[0] for e in body.axes], axis=2)
        _add_body(history, name, body.x[0], quaternions_from_matrices(rotations), body.x[1] * rate[:, None])
        omega = body.w * rate[:, None]
        add_vector(history, f"{name}.angularVelocity", np.einsum("nji,nj->ni", rotations, omega))
    for name, force in mechanism.reactions(rate).items():
        add_vector(history, f"{name}.reactionForce", force)
    history["crankPivot.angle"] = theta
    history["guide.displacement"] = mechanism.c[:, 0]
    return history


SOLUTIONS: dict[str, Callable[[np.ndarray], History]] = {
    "HeavyTop": heavy_top,
    "HighSpeedRotor": high_speed_rotor,
    "SliderCrank": slider_crank,
}


def solve(name: str, times: np.ndarray) -> History:
    """History of the mechanism `name` at `times` (s, increasing, the first is 0)."""
    return SOLUTIONS[name](np.asarray(times, dtype=float))
