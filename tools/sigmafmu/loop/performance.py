"""What a closed loop achieves, in a few numbers."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sigmafmu.loop.controllers.axis_attitude import AxisAttitude
from sigmafmu.loop.controllers.magnetic_bearings import MagneticBearings
from sigmafmu.loop.controllers.speed_pi import SpeedPI
from sigmafmu.result import Result

BAND = 0.1
"""A speed has settled within this share of the set point; the crank's ripple stays below it."""
TAIL = 0.2
"""Last share of a run, taken as its end."""


@dataclass(frozen=True)
class Figure:
    """A number with its unit; NaN if it does not exist, such as the rise time of a loop that does not rise."""

    label: str
    value: float
    unit: str

    def __str__(self) -> str:
        return "–" if np.isnan(self.value) else f"{self.value:.3g} {self.unit}"


def speed(result: Result, law: SpeedPI) -> list[Figure]:
    """Answer of the crank to the step of the set point."""
    t, rate, angle = result.time, result["crankPivot.angularRate"], result["crankPivot.angle"]
    begin, height = law.values["stepTime"], law.values["stepHeight"]
    start, final = law.values["setPoint"], law.values["setPoint"] + height
    share = (rate - start) / height
    after = t >= begin
    last_turn = angle >= angle[-1] - 2.0 * np.pi
    mean = np.trapezoid(rate[last_turn], t[last_turn]) / np.ptp(t[last_turn])
    return [
        Figure("rise time, 10 to 90 %", _first(t, after & (share >= 0.9)) - _first(t, after & (share >= 0.1)), "s"),
        Figure(
            f"settling time, to ±{BAND:.0%}",
            _settled(t[after], np.abs(rate - final)[after], BAND * abs(final)) - begin,
            "s",
        ),
        Figure("largest speed over the set point", (rate[after].max() - final) if after.any() else np.nan, "rad/s"),
        Figure("mean error of the last turn", mean - law.set_point(t[-1]), "rad/s"),
        Figure("ripple of the last turn", np.ptp(rate[last_turn]), "rad/s"),
        Figure("largest torque", np.abs(result["crankPivot.motorTorque"]).max(), "N m"),
    ]


def bearings(result: Result, law: MagneticBearings) -> list[Figure]:
    """Orbits of the rotor at the end of the run, and what the bearings do against it."""
    end = result.time >= (1.0 - TAIL) * result.time[-1]
    radii = {name: whirl(result, name) for name in ("rotor", "leftSupport", "rightSupport")}
    forces = [whirl(result, f"{side}Support", "actuatorForce") for side in ("left", "right")]
    return [
        *(Figure(f"rms orbit radius at the end, {name}", 1e6 * _rms(r[end]), "µm") for name, r in radii.items()),
        Figure("largest orbit radius, leftSupport", 1e6 * radii["leftSupport"].max(), "µm"),
        Figure("largest bearing force", np.max(forces), "N"),
    ]


def attitude(result: Result, law: AxisAttitude) -> list[Figure]:
    """How the top's axis comes to its target."""
    t, angle = result.time, axis_error(result, law)
    return [
        Figure("angle from the target at the start", angle[0], "°"),
        Figure("time until it stays below 5°", _settled(t, angle, 5.0), "s"),
        Figure("angle at the end", angle[-1], "°"),
        Figure("largest torque", np.abs(result["top.torque"]).max(), "N m"),
    ]


PERFORMANCE: dict[str, Callable[..., list[Figure]]] = {
    "SliderCrank": speed,
    "HighSpeedRotor": bearings,
    "HeavyTop": attitude,
}


def whirl(result: Result, name: str, quantity: str = "position") -> np.ndarray:
    """Length of the part across the axis x of the vector `name.quantity`, in its unit."""
    return np.hypot(result[f"{name}.{quantity}[2]"], result[f"{name}.{quantity}[3]"])


def axis_error(result: Result, law: AxisAttitude) -> np.ndarray:
    """Angle between the top's axis (its centre of mass seen from the pivot) and the target, degrees."""
    target = np.array([law.values[f"target[{i}]"] for i in (1, 2, 3)])
    axis = result["top.position"]
    across = np.linalg.norm(np.cross(axis, target), axis=1)
    return np.degrees(np.arctan2(across, axis @ target))


def _settled(t: np.ndarray, error: np.ndarray, bound: float) -> float:
    """The time after which `error` stays within `bound`."""
    outside = np.flatnonzero(error > bound)
    first = outside[-1] + 1 if len(outside) else 0
    return t[first] if first < len(t) else np.nan


def _first(t: np.ndarray, condition: np.ndarray) -> float:
    return t[condition][0] if condition.any() else np.nan


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
