"""Two heavy tops, each an FMU, whose centres of mass are tied by a spring-damper; and the same system in one ODE.

Top A precesses steadily; B starts with the same velocity but without spin, so it would fall. Their pivots stand apart
and the spring is relaxed when both tops point the same way; with positions from each pivot, in W,

    f = −k (x_A − x_B) − d (v_A − v_B) on A, −f on B,        V = k |x_A − x_B|² / 2.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp

from sigmafmu.fmu import Fmu
from sigmafmu.loop.gauss_seidel import Subsystem, subsystem
from sigmafmu.variables import vector_elements

OUTPUTS = ("top.position", "top.velocity", "energy.total")


@dataclass(frozen=True)
class Spring:
    """Spring-damper between two points: stiffness k [N/m], damping d [N s/m], the same in all directions."""

    stiffness: float
    damping: float = 0.0

    def force(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """N, for the deflection x [m] and its rate v [m/s]."""
        return -self.stiffness * x - self.damping * v

    def energy(self, x: np.ndarray) -> np.ndarray:
        """J, for deflections x (…, 3)."""
        return 0.5 * self.stiffness * np.sum(x**2, axis=-1)


@dataclass
class TiedTops:
    """The loop: f is the interface signal [N]."""

    tops: tuple[Subsystem, Subsystem]
    spring: Spring

    def deflection(self) -> tuple[np.ndarray, np.ndarray]:
        """Deflection of the spring [m] and its rate [m/s]."""
        difference = np.subtract(*(top.outputs() for top in self.tops))
        return difference[:3], difference[3:6]

    def signals(self) -> np.ndarray:
        """Force on A."""
        return self.spring.force(*self.deflection())

    def step(self, t: float, H: float, begin: np.ndarray, end: np.ndarray) -> None:
        """A and B, with opposite forces."""
        for top, sign in zip(self.tops, (1, -1), strict=True):
            top.step(t, H, sign * begin, sign * end)

    def save(self) -> None:
        """Keep both tops' states."""
        for top in self.tops:
            top.save()

    def restore(self) -> None:
        """Take both tops back."""
        for top in self.tops:
            top.restore()


@contextmanager
def tied_tops(fmu: Fmu, spring: Spring, h: float) -> Iterator[TiedTops]:
    """Both tops at t = 0, with internal steps of at most h [s]."""
    settings = {"integrator.stepSize": h, "integrator.relativeTolerance": 1e-12, "integrator.absoluteTolerance": 1e-12}

    def top(spin: np.ndarray) -> AbstractContextManager[Subsystem]:
        return subsystem(fmu, settings | {"top.initialAngularVelocity": spin.tolist()}, ["top.force"], OUTPUTS)

    spin_of_a, spin_of_b = _spins(fmu)
    with top(spin_of_a) as a, top(spin_of_b) as b:
        yield TiedTops((a, b), spring)


@dataclass
class Recorder:
    """What happens at the communication points; call it after each step."""

    loop: TiedTops
    time: list[float] = field(default_factory=list)
    position: list[np.ndarray] = field(default_factory=list)
    """Of A and B, (6,) m."""
    energy: list[float] = field(default_factory=list)
    """Of both tops and the spring, J."""

    def __call__(self, t: float) -> None:
        """Take the outputs at time t."""
        a, b = (top.outputs() for top in self.loop.tops)
        self.time.append(t)
        self.position.append(np.concatenate([a[:3], b[:3]]))
        self.energy.append(a[6] + b[6] + float(self.loop.spring.energy(a[:3] - b[:3])))


@lru_cache(maxsize=8)
def monolithic(spring: Spring, stop_time: float) -> Callable[[np.ndarray], np.ndarray]:
    """Positions of A and B, (times, 6) m, as a function of times up to `stop_time` [s].

    One ODE in minimal coordinates, Euler's equations about both pivots with the spring between them:
    J_P ω̇ + ω × J_P ω = d × Rᵀ (m g ± f), ṗ = ½ p ∘ (0, ω). The data are the FMU's, which starts with R = I.
    """
    fmu = Fmu.of_model("HeavyTop")
    mass, gravity, d = _number(fmu, "top.mass"), _vector(fmu, "gravity"), _vector(fmu, "top.initialPosition")
    inertia = np.diag([_number(fmu, f"top.inertia.{axis}") for axis in ("xx", "yy", "zz")])
    inertia += mass * (d @ d * np.eye(3) - np.outer(d, d))
    arm = _tilde(d)

    def kinematics(y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        p, omega = y[:4] / np.linalg.norm(y[:4]), y[4:]
        u = _tilde(p[1:])
        rotation = np.eye(3) + 2 * p[0] * u + 2 * u @ u
        return rotation, rotation @ d, rotation @ (_tilde(omega) @ d)

    def rates(y: np.ndarray, rotation: np.ndarray, force: np.ndarray) -> np.ndarray:
        p, omega = y[:4], y[4:]
        torque = arm @ (rotation.T @ (mass * gravity + force)) - _tilde(omega) @ (inertia @ omega)
        spin = p[0] * omega + _tilde(p[1:]) @ omega
        return np.concatenate([[-0.5 * p[1:] @ omega], 0.5 * spin, np.linalg.solve(inertia, torque)])

    def rhs(_t: float, y: np.ndarray) -> np.ndarray:
        (ra, xa, va), (rb, xb, vb) = kinematics(y[:7]), kinematics(y[7:])
        force = spring.force(xa - xb, va - vb)
        return np.concatenate([rates(y[:7], ra, force), rates(y[7:], rb, -force)])

    start = np.concatenate([(1.0, 0.0, 0.0, 0.0, *spin) for spin in _spins(fmu)])
    solution = solve_ivp(rhs, (0.0, stop_time), start, method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True)
    if not solution.success:
        raise RuntimeError(f"DOP853 stopped at t = {solution.t[-1]} s: {solution.message}")
    return lambda times: np.array(
        [np.concatenate([kinematics(y[:7])[1], kinematics(y[7:])[1]]) for y in solution.sol(times).T]
    )


def _number(fmu: Fmu, name: str) -> float:
    return float(fmu.variables[name].start)


def _vector(fmu: Fmu, name: str) -> np.ndarray:
    return np.array([_number(fmu, element) for element in vector_elements(fmu, name)])


def _spins(fmu: Fmu) -> tuple[np.ndarray, np.ndarray]:
    """Angular velocities [rad/s] of A and B at t = 0, in body axes; y is the top's own."""
    omega = _vector(fmu, "top.initialAngularVelocity")
    return omega, omega * [0.0, 0.0, 1.0]


def _tilde(v: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
