"""Mechanisms at the edge of double precision, against independent solutions. `python -m research.robustness`.

Two links in a plane, with masses, lengths, thicknesses and places of any order of magnitude, against their two angles
by SciPy's DOP853; and a top in steady precession, in closed form.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from sigmafmu import _core
from sigmafmu.markdown import markdown_table

G = 9.81  # m/s2
ANGLES, RATES = np.array([0.3, -0.5]), np.array([1.0, -2.0])  # of links of 1 m against the horizontal [rad], [rad/s]
Y, Z = np.eye(3)[1], np.eye(3)[2]


# --- two links -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TwoLinks:
    """Rods in the plane of x and y, the first hinged to the ground; masses in kg, lengths in m."""

    masses: tuple[float, float] = (1.0, 1.0)
    length: float = 1.0
    thickness: float = 1e-2  # over the length
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pivot_stiffness: float = 0.0  # a spring in all directions in place of the hinge to the ground, if any [N/m]

    @property
    def time(self) -> float:
        """1 s for 1 m, and as long for the motion of other lengths."""
        return float(np.sqrt(self.length))

    def mechanism(self) -> _core.Mechanism:
        """Its start has velocities that the hinges allow."""
        m = _core.Mechanism()
        m.name = "TwoLinks"
        m.multibody.gravity = -G * Y
        rates = RATES / self.time
        end, speed = np.array(self.origin), np.zeros(3)
        for i, mass in enumerate(self.masses):
            along = self.length * np.array([np.cos(ANGLES[i]), np.sin(ANGLES[i]), 0.0])
            body = _core.RigidBody()
            body.name, body.mass = f"link{i + 1}", mass
            across = mass * self.length**2 * (1 / 12 + self.thickness**2 / 16)
            body.inertia = np.array([mass * self.length**2 * self.thickness**2 / 8, across, across])
            body.initial_position = end + along / 2
            body.initial_quaternion = Rotation.from_rotvec(ANGLES[i] * Z).as_quat(scalar_first=True)
            body.initial_angular_velocity = rates[i] * Z
            body.initial_velocity = speed + np.cross(rates[i] * Z, along / 2)
            end, speed = end + along, speed + np.cross(rates[i] * Z, along)
            m.multibody.add(body)
        half = self.length / 2 * np.eye(3)[0]
        ground, before, after = (_core.Frame(x, np.eye(3)) for x in (np.array(self.origin), half, -half))
        if self.pivot_stiffness > 0:
            stiffness = np.full(3, self.pivot_stiffness)
            sides = (_core.GROUND, ground.origin, 0, after.origin)
            m.multibody.add(_core.SpringDamper("pivot", *sides, stiffness, np.zeros(3)))
        else:
            m.multibody.add(_core.Joint("pivot", _core.JointType.revolute, _core.GROUND, ground, 0, after))
        m.multibody.add(_core.Joint("elbow", _core.JointType.revolute, 0, before, 1, after))
        return m

    def tip(self, q: np.ndarray) -> np.ndarray:
        """Of the second link, from the origin, over the length."""
        turn = Rotation.from_quat(q[10:14], scalar_first=True)
        return (q[7:10] + turn.apply([self.length / 2, 0, 0]) - self.origin) / self.length

    def exact_tip(self, stop: float) -> np.ndarray:
        """M(θ) θ'' + h(θ, θ') = 0 for links of length 1 and times in units of `time`; gravity stays."""
        m1, m2 = np.array(self.masses) / sum(self.masses)
        j = 1 / 12 + self.thickness**2 / 16
        coupling = m2 / 2

        def rhs(_: float, y: np.ndarray) -> np.ndarray:
            (a, b), rates = y[:2], y[2:]
            c, s = np.cos(a - b), np.sin(a - b)
            mass = np.array([[m1 * (j + 0.25) + m2, coupling * c], [coupling * c, m2 * (j + 0.25)]])
            force = np.array([(m1 / 2 + m2) * G * np.cos(a), coupling * G * np.cos(b)])
            force += coupling * s * np.array([rates[1] ** 2, -(rates[0] ** 2)])
            return np.concatenate([rates, np.linalg.solve(mass, -force)])

        y0 = np.concatenate([ANGLES, RATES])
        angles = solve_ivp(rhs, (0, stop / self.time), y0, "DOP853", rtol=1e-13, atol=1e-13).y[:2, -1]
        return np.array([np.cos(angles).sum(), np.sin(angles).sum(), 0.0])

    def error(self, fineness: int = 1, **settings: float) -> float:
        """Of the tip after `time`, in 1000 steps, over the length."""
        steps = 1000 * fineness
        simulation = run(self.mechanism(), self.time / steps, steps, settings)
        return float(np.linalg.norm(self.tip(simulation.state.q) - self.exact_tip(self.time)))


# --- a top -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SteadyTop:
    """On a spherical joint, 0.1 kg at 0.05 m, tilted by 1 rad, with the gravity that makes it precess at 10 rad/s."""

    spin: float  # about its own axis [rad/s]
    mass: float = 0.1
    arm: float = 0.05
    tilt: float = 1.0
    precession: float = 10.0
    inertia: tuple[float, float] = (6e-5, 1e-4)  # across and along its axis, which is z [kg.m2]

    def mechanism(self) -> _core.Mechanism:
        """(C w - A p cos(tilt)) p = m g l, A about the pivot (Goldstein, Classical Mechanics, section 5.7)."""
        across, along = self.inertia
        about_pivot = across + self.mass * self.arm**2
        torque = (along * self.spin - about_pivot * self.precession * np.cos(self.tilt)) * self.precession
        m = _core.Mechanism()
        m.name = "SteadyTop"
        m.multibody.gravity = -torque / (self.mass * self.arm) * Z
        turn = Rotation.from_rotvec(self.tilt * Y)
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = "top", self.mass, np.array([across, across, along])
        body.initial_position = turn.apply(self.arm * Z)
        body.initial_quaternion = turn.as_quat(scalar_first=True)
        w = turn.inv().apply(self.precession * Z)
        body.initial_angular_velocity = np.array([w[0], w[1], self.spin])
        body.initial_velocity = np.cross(self.precession * Z, body.initial_position)
        m.multibody.add(body)
        tip = _core.Frame(-self.arm * Z, np.eye(3))
        ground = _core.Frame(np.zeros(3), np.eye(3))
        m.multibody.add(_core.Joint("pivot", _core.JointType.spherical, _core.GROUND, ground, 0, tip))
        return m

    def error(self, fineness: int = 1, **settings: float) -> float:
        """Of the axis after 0.1 s, 1 rad of precession; steps of 0.1 rad of spin."""
        steps = round(self.spin) * fineness
        simulation = run(self.mechanism(), 0.1 / steps, steps, settings)
        expected = Rotation.from_rotvec(0.1 * self.precession * Z) * Rotation.from_rotvec(self.tilt * Y)
        axis = Rotation.from_quat(simulation.state.q[3:7], scalar_first=True).apply(Z)
        return float(np.linalg.norm(axis - expected.apply(Z)))


def run(mechanism: _core.Mechanism, h: float, steps: int, settings: dict[str, float]) -> _core.Simulation:
    """Steps of h [s] from the start, none of which may be repeated."""
    mechanism.integrator.step_size = h
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    simulation = _core.Simulation(mechanism)
    simulation.advance(h, steps)
    if simulation.state.counters.retries > 0:
        raise RuntimeError("steps were repeated")
    return simulation


CASES: dict[str, TwoLinks | SteadyTop] = {
    "two links of 1 m and 1 kg": TwoLinks(),
    "masses 1e6 : 1": TwoLinks(masses=(1e6, 1.0)),
    "masses 1 : 1e6": TwoLinks(masses=(1.0, 1e6)),
    "first link 1e-9 kg": TwoLinks(masses=(1e-9, 1.0)),
    "second link 1e-9 kg": TwoLinks(masses=(1.0, 1e-9)),
    "first link 1e-12 kg": TwoLinks(masses=(1e-12, 1.0)),
    "second link 1e-12 kg": TwoLinks(masses=(1.0, 1e-12)),
    "rods 1 µm thick": TwoLinks(thickness=1e-6),
    "pivot 1 km from the origin": TwoLinks(origin=(600.0, 0.0, 800.0)),
    "links of 1 mm": TwoLinks(length=1e-3),
    "links of 1 km": TwoLinks(length=1e3),
    "spring of 1e9 N/m as pivot": TwoLinks(pivot_stiffness=1e9),
    "top at 1e3 rad/s": SteadyTop(spin=1e3),
    "top at 1e5 rad/s": SteadyTop(spin=1e5),
}
FORMULATIONS: dict[str, dict[str, float]] = {
    "stabilizedIndex2": {"formulation": 3},
    "index3": {"formulation": 1},
    "index2": {"formulation": 2},
}


def table() -> str:
    """Errors of all cases in all formulations, in Markdown."""
    rows = [(name, *(f"{case.error(**s):.1e}" for s in FORMULATIONS.values())) for name, case in CASES.items()]
    return markdown_table(("case", *FORMULATIONS), rows)


def main() -> None:
    """Print the table of docs/method.md."""
    print(table(), end="")


if __name__ == "__main__":
    main()
