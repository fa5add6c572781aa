"""Independent solutions of the flexible mechanisms: minimal coordinates, all sums over the nodes of the cloud.

With velocities v (rates of the minimal coordinates), node velocities ṙ_i = J_i v and accelerations
J_i v̇ + b_i, d'Alembert's principle reads

    Σ m_i J_iᵀ (J_i v̇ + b_i − g) + (0, K ζ) = Q.

- `Pendulum`: v = (ω, ζ̇), in the axes of the frame: J_i = [−p̃_i, Φ_i], b_i = ω×(ω×p_i) + 2 ω×Φ_i ζ̇,
  p_i = X_i + Φ_i ζ; orientation as a quaternion, ṗ = ½ p ∘ (0, ω).
- `GuidedFrame`: the frame's motion is a function of one coordinate s, r_i = o(s) + R(s) p_i:
  J_i = [o′ + R′p_i, R Φ_i], b_i = ṡ² (o″ + R″p_i) + 2 ṡ R′Φ_i ζ̇. Slider-crank: s = θ; spin-up: s = hub angle.

No shape integrals, no constraints, no code shared with the FMUs. Solved by SciPy's DOP853 in double precision;
`precise` solves the same equations by extrapolation in extended precision, which tells the error of the former.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from research.reference import (
    CRANK,
    CRANK_CENTRE,
    CRANK_LENGTH,
    GRAVITY,
    ROD,
    ROD_LENGTH,
    SLIDER,
    History,
    add_vector,
    continuous_sign,
    quaternions_from_matrices,
)
from research.reference.clouds import PENDULUM_ANGULAR_VELOCITY, Cloud, SpinUp, conrod_cloud, pendulum_cloud
from research.reference.extrapolation import cholesky_solve, extrapolate
from research.reference.minimal_coordinates import integrate, rotation_matrices

Real = type[np.float64] | type[np.longdouble]


class _Nodes:
    """A cloud in the arithmetic of `real`, masses taken into square roots: Σ m_i J_iᵀ a_i = (√m J)ᵀ (√m a)."""

    def __init__(self, cloud: Cloud, real: Real) -> None:
        self.real = real
        self.x, self.phi = cloud.nodes.astype(real), cloud.modes.astype(real)
        self.root_mass = np.sqrt(cloud.masses.astype(real))[:, None]
        self.stiffness = cloud.stiffness.astype(real)
        self.modes = cloud.stiffness.shape[0]

    def moved(self, zeta: np.ndarray, zeta_rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """p_i = X_i + Φ_i ζ and Φ_i ζ̇, n × 3."""
        return self.x + self.phi @ zeta, self.phi @ zeta_rate

    def weighted(self, columns: list[np.ndarray], bias: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Σ m J_iᵀ J_i and Σ m J_iᵀ b_i, from the columns of J (each n × 3) and b (n × 3)."""
        jacobian = np.stack([(self.root_mass * c).ravel() for c in columns], axis=1)
        return jacobian.T @ jacobian, jacobian.T @ (self.root_mass * bias).ravel()

    def solve(self, mass: np.ndarray, force: np.ndarray) -> np.ndarray:
        """mass⁻¹ force."""
        return np.linalg.solve(mass, force) if self.real is np.float64 else cholesky_solve(mass, force)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a × b for a vector a and rows b."""
    return np.stack(
        [a[1] * b[:, 2] - a[2] * b[:, 1], a[2] * b[:, 0] - a[0] * b[:, 2], a[0] * b[:, 1] - a[1] * b[:, 0]], axis=1
    )


class Pendulum:
    """Flexible beam whose frame turns about the origin of W. State: quaternion, ζ, ω (in the frame), ζ̇."""

    def __init__(self, cloud: Cloud, gravity: np.ndarray = GRAVITY, real: Real = np.float64) -> None:
        self.nodes, self.gravity = _Nodes(cloud, real), gravity.astype(real)
        self.units = np.eye(3, dtype=real)

    def start(self, angular_velocity: np.ndarray) -> np.ndarray:
        """State with R = I, the beam straight and at rest in its frame."""
        still = np.zeros(self.nodes.modes)
        return np.concatenate([[1.0, 0.0, 0.0, 0.0], still, angular_velocity, still]).astype(self.nodes.real)

    def rhs(self, _t: float, y: np.ndarray) -> np.ndarray:
        """ẏ."""
        n = self.nodes.modes
        q, zeta, omega, zeta_rate = y[:4], y[4 : 4 + n], y[4 + n : 7 + n], y[7 + n :]
        nodes = self.nodes
        p, flow = nodes.moved(zeta, zeta_rate)
        w, u = q[0], q[1:]
        gravity = self.gravity
        # Rᵀ g, divided by qᵀq: the norm may drift in the last digits
        down = ((w * w - u @ u) * gravity + 2.0 * (u @ gravity) * u - 2.0 * w * _cross(u, gravity[None])[0]) / (q @ q)
        bias = _cross(omega, _cross(omega, p) + 2.0 * flow) - down
        columns = [_cross(axis, p) for axis in self.units] + [nodes.phi[:, :, f] for f in range(n)]
        mass, force = nodes.weighted(columns, bias)
        force[3:] += nodes.stiffness @ zeta
        turned = 0.5 * (w * omega + _cross(u, omega[None])[0])
        return np.concatenate([[-0.5 * (u @ omega)], turned, zeta_rate, nodes.solve(mass, -force)])


Jet = tuple[np.ndarray, np.ndarray, np.ndarray]
"""A function of s and its first two derivatives."""


Guide = Callable[[float, np.ndarray, np.ndarray], tuple[Jet, Jet, np.ndarray, np.ndarray]]
"""What one coordinate s moves: (t, s, ṡ) → jets of the frame's origin (3) and rotation matrix (3 × 3), the inertia of
the rigid bodies, and the generalized force on s that they leave at s̈ = 0 (gravity and drive minus inertia forces)."""


class GuidedFrame:
    """Flexible body on a frame that one coordinate s moves. State: s, ζ, ṡ, ζ̇."""

    def __init__(self, cloud: Cloud, guide: Guide, gravity: np.ndarray, real: Real = np.float64) -> None:
        self.nodes, self.guide, self.gravity = _Nodes(cloud, real), guide, gravity.astype(real)

    def start(self, rate: float) -> np.ndarray:
        """State with s = 0 at the given rate, the body undeformed and at rest in its frame."""
        still = np.zeros(self.nodes.modes)
        return np.concatenate([[0.0], still, [rate], still]).astype(self.nodes.real)

    def rhs(self, t: float, y: np.ndarray) -> np.ndarray:
        """ẏ."""
        nodes, half = self.nodes, len(y) // 2
        s, rate, zeta, zeta_rate = y[0], y[half], y[1:half], y[half + 1 :]
        (_, o1, o2), (r, r1, r2), inertia, drive = self.guide(t, s, rate)
        p, flow = nodes.moved(zeta, zeta_rate)
        bias = rate * rate * (o2 + p @ r2.T) + 2.0 * rate * (flow @ r1.T) - self.gravity
        columns = [o1 + p @ r1.T] + [nodes.phi[:, :, f] @ r.T for f in range(nodes.modes)]
        mass, force = nodes.weighted(columns, bias)
        mass[0, 0] += inertia
        force[0] -= drive
        force[1:] += nodes.stiffness @ zeta
        return np.concatenate([y[half:], nodes.solve(mass, -force)])


def slider_crank_frame(theta: np.ndarray) -> tuple[Jet, Jet, Jet]:
    """Jets in θ of the rod's origin B, its rotation matrix and the slider's position s = x_C (scalars).

    B = A + l (0, −sin θ, cos θ), C = (s, 0, 0), s² = L² − B·B (B_x = 0); e_x = (C − B)/L; e_y is perpendicular to W x
    (the slider's axis) and to e_x: e_y = n/|n|, n = W x × e_x; e_z = e_x × e_y.
    """
    sin, cos, zero = np.sin(theta), np.cos(theta), 0.0 * theta
    centre, crank, rod = (np.asarray(v, dtype=sin.dtype) for v in (CRANK_CENTRE, CRANK_LENGTH, ROD_LENGTH))
    along = [np.array(v) for v in ((zero, -sin, cos), (zero, -cos, -sin), (zero, sin, -cos))]
    b = [centre + crank * along[0], crank * along[1], crank * along[2]]
    s = np.sqrt(rod * rod - b[0] @ b[0])
    s1 = -(b[0] @ b[1]) / s
    s2 = -(b[0] @ b[2] + b[1] @ b[1] + s1 * s1) / s
    ex = [(np.array([value, zero, zero]) - point) / rod for value, point in zip((s, s1, s2), b, strict=True)]
    n = [np.array([zero, -x[2], x[1]]) for x in ex]
    # n = ρ e_y: the derivatives of the length ρ and of the unit vector
    rho = np.sqrt(n[0] @ n[0])
    rho1 = (n[0] @ n[1]) / rho
    rho2 = (n[1] @ n[1] + n[0] @ n[2] - rho1 * rho1) / rho
    ey = [n[0] / rho]
    ey.append((n[1] - rho1 * ey[0]) / rho)
    ey.append((n[2] - 2.0 * rho1 * ey[1] - rho2 * ey[0]) / rho)

    def cross(i: int, j: int) -> np.ndarray:
        (x, y, z), (u, v, w) = ex[i], ey[j]
        return np.array([y * w - z * v, z * u - x * w, x * v - y * u])

    ez = [cross(0, 0), cross(1, 0) + cross(0, 1), cross(2, 0) + 2.0 * cross(1, 1) + cross(0, 2)]
    rotation = tuple(np.array(axes).T for axes in zip(ex, ey, ez, strict=True))
    return tuple(b), rotation, (s, s1, s2)


def _slider_crank_guide(_t: float, theta: np.ndarray, rate: np.ndarray) -> tuple[Jet, Jet, np.ndarray, np.ndarray]:
    """Rod frame, crank about A (its COM at the middle of A and B) and slider, gravity on the crank."""
    origin, rotation, (_, s1, s2) = slider_crank_frame(theta)
    b1 = origin[1]
    inertia = CRANK.mass * (b1 @ b1) / 4.0 + CRANK.inertia[0] + SLIDER.mass * s1 * s1
    return origin, rotation, inertia, CRANK.mass * (b1 @ GRAVITY) / 2.0 - SLIDER.mass * s1 * s2 * rate * rate


def _spin_up_guide(spin_up: SpinUp, real: Real) -> Guide:
    """Hub about W z with its torque; the frame's origin is on the axis."""
    still, inertia = np.zeros(3, dtype=real), spin_up.inertia

    def guide(t: float, angle: np.ndarray, _rate: np.ndarray) -> tuple[Jet, Jet, np.ndarray, np.ndarray]:
        sin, cos = np.sin(angle), np.cos(angle)
        r, r1 = np.eye(3, dtype=real), np.zeros((3, 3), dtype=real)
        r[0, :2], r[1, :2] = (cos, -sin), (sin, cos)
        r1[0, :2], r1[1, :2] = (-sin, -cos), (cos, -sin)
        r2 = -r
        r2[2, 2] = 0.0
        return (still, still, still), (r, r1, r2), spin_up.hub_inertia, inertia * spin_up.acceleration(t)

    return guide


# --- time histories ---------------------------------------------------------------------------------------------------


def _solve(system: Pendulum | GuidedFrame, y0: np.ndarray, times: np.ndarray, step: float) -> np.ndarray:
    """States at `times`, samples × states: DOP853 in double precision, else extrapolation with steps up to `step`."""
    if system.nodes.real is np.float64:
        return integrate(system.rhs, y0, times, 1e-15, step / 4.0)
    return extrapolate(system.rhs, y0, times, step)


def _add_flexible(
    history: History,
    name: str,
    cloud: Cloud,
    position: np.ndarray,
    rotations: np.ndarray,
    velocity: np.ndarray,
    omega: np.ndarray,
    zeta: np.ndarray,
    zeta_rate: np.ndarray,
    stations: dict[str, int],
) -> tuple[np.ndarray, np.ndarray]:
    """Frame (position and velocity in W, ω in the frame), modal coordinates and stations; returns T and V (elastic)."""
    add_vector(history, f"{name}.position", position)
    add_vector(history, f"{name}.quaternion", quaternions_from_matrices(rotations))
    add_vector(history, f"{name}.velocity", velocity)
    add_vector(history, f"{name}.angularVelocity", omega)
    add_vector(history, f"{name}.modal", zeta)
    add_vector(history, f"{name}.modalRate", zeta_rate)
    p = cloud.nodes + np.einsum("iaf,nf->nia", cloud.modes, zeta)
    flow = np.einsum("iaf,nf->nia", cloud.modes, zeta_rate)
    for station, section in stations.items():
        middle = p[:, cloud.section(section)].mean(axis=1)
        add_vector(history, f"{station}.position", position + np.einsum("nab,nb->na", rotations, middle))
    # node velocities in the frame's axes
    speed = np.einsum("nba,nb->na", rotations, velocity)[:, None] + np.cross(omega[:, None], p) + flow
    kinetic = 0.5 * np.einsum("i,nia,nia->n", cloud.masses, speed, speed)
    return kinetic, 0.5 * np.einsum("nf,fg,ng->n", zeta, cloud.stiffness, zeta)


def _weight(cloud: Cloud, position: np.ndarray, rotations: np.ndarray, zeta: np.ndarray) -> np.ndarray:
    """Potential energy of the nodes in gravity, J, zero at the origin of W."""
    first = cloud.masses @ cloud.nodes + np.einsum("i,iaf,nf->na", cloud.masses, cloud.modes, zeta)
    return -(cloud.mass * position + np.einsum("nab,nb->na", rotations, first)) @ GRAVITY


def _add_energy(history: History, kinetic: np.ndarray, potential: np.ndarray) -> None:
    history["energy.kinetic"], history["energy.potential"] = kinetic, potential


def flexible_pendulum(times: np.ndarray, real: Real = np.float64, cloud: Cloud | None = None) -> History:
    """FlexiblePendulum: ω = (2, −3, 6) rad/s at R = I, gravity along −z. `tip`: the free end's centre."""
    cloud = cloud or pendulum_cloud()
    system = Pendulum(cloud, real=real)
    states = _solve(system, system.start(PENDULUM_ANGULAR_VELOCITY), times, 2.5e-3).astype(float)
    n = system.nodes.modes
    quaternions, zeta, omega, zeta_rate = np.split(states, [4, 4 + n, 7 + n], axis=1)
    quaternions = continuous_sign(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True))
    rotations, origin = rotation_matrices(quaternions), np.zeros_like(omega)
    history: History = {"time": times}
    kinetic, elastic = _add_flexible(
        history, "beam", cloud, origin, rotations, origin, omega, zeta, zeta_rate, {"tip": -1}
    )
    add_vector(history, "beam.quaternion", quaternions)
    _add_energy(history, kinetic, elastic + _weight(cloud, origin, rotations, zeta))
    return history


def flexible_slider_crank(times: np.ndarray, real: Real = np.float64, cloud: Cloud | None = None) -> History:
    """FlexibleSliderCrank from θ = 0, θ̇ = 6 rad/s. `middle`: the centre of the rod's middle section."""
    cloud = cloud or conrod_cloud(ROD_LENGTH, ROD.mass)
    system = GuidedFrame(cloud, _slider_crank_guide, GRAVITY, real)
    states = _solve(system, system.start(CRANK.angular_velocity[0]), times, 1.25e-3).astype(float)
    n = system.nodes.modes
    theta, zeta, rate, zeta_rate = states[:, 0], states[:, 1 : 1 + n], states[:, 1 + n], states[:, 2 + n :]
    jets = [slider_crank_frame(angle) for angle in theta]
    b, b1 = (np.array([jet[0][k] for jet in jets]) for k in (0, 1))
    rotations, derivatives = (np.array([jet[1][k] for jet in jets]) for k in (0, 1))
    slider, slider1 = (np.array([jet[2][k] for jet in jets]) for k in (0, 1))
    spin = np.einsum("nba,nbc->nac", rotations, derivatives)  # Rᵀ R′, skew
    omega = np.column_stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]]) * rate[:, None]
    history: History = {"time": times}
    kinetic, elastic = _add_flexible(
        history, "rod", cloud, b, rotations, b1 * rate[:, None], omega, zeta, zeta_rate, {"middle": 5}
    )
    history["crankPivot.angle"], history["crankPivot.angularRate"] = theta, rate
    history["guide.displacement"], history["guide.rate"] = slider, slider1 * rate
    crank = CRANK.mass * np.einsum("na,na->n", b1, b1) / 4.0 + CRANK.inertia[0]
    kinetic = kinetic + 0.5 * rate**2 * (crank + SLIDER.mass * slider1**2)
    height = _weight(cloud, b, rotations, zeta) - CRANK.mass * (0.5 * (CRANK_CENTRE + b)) @ GRAVITY
    _add_energy(history, kinetic, elastic + height)
    return history


def spin_up_beam(times: np.ndarray, real: Real = np.float64, spin_up: SpinUp | None = None) -> History:
    """SpinUpBeam from rest. `tip.deflection`: displacement of the free end's centre across the frame's x axis."""
    spin_up = spin_up or SpinUp()
    cloud = spin_up.cloud
    system = GuidedFrame(cloud, _spin_up_guide(spin_up, real), np.zeros(3), real)
    states = _solve(system, system.start(0.0), times, 0.02).astype(float)
    n = system.nodes.modes
    angle, zeta, rate, zeta_rate = states[:, 0], states[:, 1 : 1 + n], states[:, 1 + n], states[:, 2 + n :]
    zero = np.zeros_like(angle)
    half = 0.5 * angle
    quaternions = np.column_stack([np.cos(half), zero, zero, np.sin(half)])
    origin, omega = np.zeros((len(times), 3)), np.column_stack([zero, zero, rate])
    history: History = {"time": times}
    kinetic, elastic = _add_flexible(
        history, "beam", cloud, origin, rotation_matrices(quaternions), origin, omega, zeta, zeta_rate, {"tip": -1}
    )
    add_vector(history, "beam.quaternion", continuous_sign(quaternions))
    history["hubPivot.angle"], history["hubPivot.angularRate"] = angle, rate
    history["tip.deflection"] = zeta @ cloud.modes[cloud.section(-1), 1].mean(axis=0)
    _add_energy(history, kinetic + 0.5 * spin_up.hub_inertia * rate**2, elastic)
    return history


SOLUTIONS: dict[str, Callable[..., History]] = {
    "FlexiblePendulum": flexible_pendulum,
    "FlexibleSliderCrank": flexible_slider_crank,
    "SpinUpBeam": spin_up_beam,
}


def solve(name: str, times: np.ndarray) -> History:
    """History of the mechanism `name` at `times` (s, increasing, the first is 0)."""
    return SOLUTIONS[name](np.asarray(times, dtype=float))


def precise(name: str, times: np.ndarray) -> History:
    """The same, solved by extrapolation in extended precision (where NumPy's longdouble is more than double)."""
    return SOLUTIONS[name](np.asarray(times, dtype=float), np.longdouble)
