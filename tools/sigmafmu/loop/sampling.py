"""The slider-crank's speed loop with a sampled PI law: what the step size and the hold of the torque do to it.

Plant: SliderCrank with the motor torque τ at the crank's pivot and the measured rate ω. Law: `SpeedPI` without a limit,
called at the communication points. As H goes to zero it becomes the continuous law

    τ = kp (r − ω) + I,   İ = ki (r − ω),                                                                   (1)

and `monolithic` solves plant and (1) as one ODE in the crank's angle.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp

from sigmafmu.fmu import Fmu
from sigmafmu.instance import Instance
from sigmafmu.loop.controllers.speed_pi import SpeedPI
from sigmafmu.loop.energy import Bond
from sigmafmu.loop.gauss_seidel import Subsystem, subsystem

GAINS = {"proportionalGain": 0.5, "integralGain": 5.0}  # N m s/rad, N m/rad
SET_POINT = 12.0  # rad/s, twice the speed at the start


def speed_law() -> SpeedPI:
    """The law in its linear range: set point from the start, no limit."""
    return SpeedPI(setPoint=SET_POINT, stepHeight=0.0, torqueLimit=np.inf, **GAINS)


class SpeedLoop:
    """The loop: the interface signal is the torque [N m] that the law gives at the communication points.

    With `samples` > 1 the plant takes each communication step in as many parts, with the same torque, so that its rate
    in between is seen.
    """

    def __init__(self, plant: Subsystem, H: float, samples: int = 1):
        self.plant, self.law = plant, speed_law()
        self.fraction = np.linspace(0.0, 1.0, samples + 1)
        self.rate = np.zeros(samples + 1)
        self.torque = np.zeros(samples + 1)
        self._sample(0.0, H)

    def _sample(self, t: float, H: float) -> None:
        self.demand = self.law.step(t, H, {"speed": self.plant.outputs()[0]})["torque"]

    def signals(self) -> np.ndarray:
        """Torque that the law asks for."""
        return np.array([self.demand])

    def step(self, t: float, H: float, begin: np.ndarray, end: np.ndarray) -> None:
        """The plant, then the law at the new time; `rate` and `torque` keep the plant's course over the step."""
        self.torque = begin + self.fraction * (end - begin)
        self.rate[0] = self.plant.outputs()[0]
        size = H / (len(self.fraction) - 1)
        for i, (u0, u1) in enumerate(zip(self.torque[:-1], self.torque[1:], strict=True)):
            self.plant.step(t + i * size, size, np.array([u0]), np.array([u1]))
            self.rate[i + 1] = self.plant.outputs()[0]
        self._sample(t + H, H)

    def save(self) -> None:
        """Keep the states of plant and law."""
        self.plant.save()
        self._saved = copy(self.law), self.demand

    def restore(self) -> None:
        """Take both back."""
        self.plant.restore()
        law, self.demand = self._saved
        self.law = copy(law)


@contextmanager
def speed_loop(fmu: Fmu, H: float, h: float, samples: int = 1) -> Iterator[SpeedLoop]:
    """The loop at t = 0 for communication steps of H and internal steps of at most h [s]."""
    settings = {"integrator.stepSize": h, "integrator.relativeTolerance": 1e-12, "integrator.absoluteTolerance": 1e-12}
    outputs = ["crankPivot.angularRate", "energy.total"]
    with subsystem(fmu, settings, ["crankPivot.motorTorque"], outputs) as plant:
        yield SpeedLoop(plant, H, samples)


@dataclass
class Recorder:
    """Rate, torque and energies at the communication points; call it after each step."""

    loop: SpeedLoop
    H: float
    time: list[float] = field(default_factory=list)
    rate: list[float] = field(default_factory=list)
    torque: list[float] = field(default_factory=list)
    """What the plant got at the end of each step."""
    gained: list[float] = field(default_factory=list)
    """What the plant's energy grew by in each step, J."""
    bond: list[Bond] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._energy, self._demand = self.loop.plant.outputs()[1], self.loop.demand

    def __call__(self, t: float) -> None:
        """Take the outputs at time t, and what happened in the step to it."""
        loop = self.loop
        rate, energy = loop.plant.outputs()
        self.time.append(t)
        self.rate.append(rate)
        self.torque.append(loop.torque[-1])
        self.gained.append(energy - self._energy)
        # The law between samples: (1) with the rate that it sees, linear between its two samples.
        seen = loop.rate[0] + loop.fraction * (loop.rate[-1] - loop.rate[0])
        error = SET_POINT - seen
        integral = np.cumsum(np.concatenate([[0.0], (error[:-1] + error[1:]) / 2])) * self.H / (len(seen) - 1)
        asked = self._demand + GAINS["proportionalGain"] * (error - error[0]) + GAINS["integralGain"] * integral
        self.bond.append(Bond(self.H, effort=(loop.torque, asked), flow=(loop.rate.copy(), seen)))
        self._energy, self._demand = energy, loop.demand


def energies(fmu: Fmu, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The plant's M [kg m2] in its kinetic energy M ω²/2 and its potential V [J] at these angles of the crank [rad]."""
    found = []
    with Instance(fmu) as instance:
        for angle in angles:
            instance.reset({"crankPivot.initialAngle": angle, "crankPivot.initialAngularRate": 1.0})
            found.append(instance.get(["energy.kinetic", "energy.potential"]))
    kinetic, potential = np.array(found).T
    return 2 * kinetic, potential


@lru_cache(maxsize=8)
def monolithic(stop_time: float, nodes: int = 256) -> Callable[[np.ndarray], dict[str, np.ndarray]]:
    """Rate [rad/s], torque [N m] and energy [J] of plant and (1) as one ODE, for times up to `stop_time` [s].

    With the kinetic energy M(θ) θ̇²/2 and the potential V(θ), Lagrange's equation is M θ̈ + M′ θ̇²/2 + V′ = τ. M and V
    come from the FMU, started in as many positions as there are nodes. They are smooth and 2π-periodic; their Fourier
    series have converged to rounding with a few hundred nodes.
    """
    fmu = Fmu.of_model("SliderCrank")
    mass, potential = energies(fmu, 2 * np.pi * np.arange(nodes) / nodes)
    n = np.arange(nodes // 2 + 1)
    m, v = (np.fft.rfft(f) / nodes * np.where(n == 0, 1, 2) for f in (mass, potential))
    if max(np.abs(m[-4:]).max() / mass.max(), np.abs(v[-4:]).max() / np.ptp(potential)) > 1e-14:
        raise RuntimeError("the Fourier series of mass and potential have not converged: take more nodes")
    series = np.array([m, 1j * n * m, 1j * n * v])

    def law(rate: np.ndarray, integral: np.ndarray) -> np.ndarray:
        return GAINS["proportionalGain"] * (SET_POINT - rate) + integral

    def rhs(_t: float, y: np.ndarray) -> list[float]:
        theta, rate, integral = y
        mass, mass_slope, potential_slope = (series @ np.exp(1j * n * theta)).real
        torque = law(rate, integral) - mass_slope * rate**2 / 2 - potential_slope
        return [rate, torque / mass, GAINS["integralGain"] * (SET_POINT - rate)]

    start = [0.0, float(fmu.variables["crank.initialAngularVelocity[1]"].start), 0.0]
    solution = solve_ivp(rhs, (0.0, stop_time), start, method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True)
    if not solution.success:
        raise RuntimeError(f"DOP853 stopped at t = {solution.t[-1]} s: {solution.message}")

    def at(times: np.ndarray) -> dict[str, np.ndarray]:
        theta, rate, integral = solution.sol(times)
        mass, potential = (np.array([m, v]) @ np.exp(1j * np.outer(n, theta))).real
        return {"rate": rate, "torque": law(rate, integral), "energy": mass * rate**2 / 2 + potential}

    return at
