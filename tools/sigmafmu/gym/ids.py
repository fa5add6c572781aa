"""The environments with names: what each of them observes, sets and rewards."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

import gymnasium
import numpy as np

from sigmafmu.gym.channels import Outputs

LIBRARY = files("sigmafmu") / "library"

CLEARANCE = 5e-3
"""Of the rotor's disk in its housing [m]."""
SPEED = 8.0
"""That the slider-crank's crank is to keep [rad/s]."""


def centred(outputs: Outputs, action: np.ndarray) -> float:
    """1 in the middle, 0 at the housing, less for forces [N]."""
    return 1.0 - _eccentricity(outputs) ** 2 - 1e-5 * float(action @ action)


def touches(outputs: Outputs) -> bool:
    """Whether the disk is at the housing."""
    return _eccentricity(outputs) >= 1.0


def _eccentricity(outputs: Outputs) -> float:
    return float(np.hypot(outputs["plane.displacement1"], outputs["plane.displacement2"])) / CLEARANCE


def steady(outputs: Outputs, action: np.ndarray) -> float:
    """1 at the wanted speed, less for torque [N m]."""
    return 1.0 - (outputs["crankPivot.angularRate"] / SPEED - 1.0) ** 2 - 0.01 * float(action @ action)


def races(outputs: Outputs) -> bool:
    """Whether the crank is five times too fast, in any direction."""
    return abs(outputs["crankPivot.angularRate"]) >= 5.0 * SPEED


ENVIRONMENTS: dict[str, dict[str, Any]] = {
    # Damping in the shaft makes the disk whirl out to its housing, 6/s; two forces of a magnetic bearing hold it.
    "JeffcottRotor": {
        "model": LIBRARY / "JeffcottRotor.yaml",
        "observations": {
            "plane.displacement1": (-0.02, 0.02),
            "plane.displacement2": (-0.02, 0.02),
            "plane.rate1": (-5.0, 5.0),
            "plane.rate2": (-5.0, 5.0),
        },
        "actions": {"plane.actuatorForce1": (-20.0, 20.0), "plane.actuatorForce2": (-20.0, 20.0)},
        "parameters": {
            "shaftInside.damping": (80.0, 80.0, 0.0),
            "plane.initialDisplacement1": "U(-0.002,0.002)",
            "plane.initialDisplacement2": "U(-0.002,0.002)",
        },
        "reward": centred,
        "terminated": touches,
        "H": 2e-3,
    },
    # The crank's centre of mass tells its angle without a jump after each turn.
    "SliderCrank": {
        "model": "SliderCrank",
        "observations": {
            "crank.position[2]": (0.0, 0.2),
            "crank.position[3]": (0.0, 0.2),
            "crankPivot.angularRate": (-100.0, 100.0),
        },
        "actions": {"crankPivot.motorTorque": (-1.0, 1.0)},
        "parameters": {"integrator.stepSize": 1e-3, "crankPivot.initialAngularRate": "U(4,12)"},
        "reward": steady,
        "terminated": races,
        "H": 1e-2,
    },
}
"""Name → arguments of MechanismEnv. Episodes end after so many steps:"""
STEPS = {"JeffcottRotor": 250, "SliderCrank": 200}


def register() -> None:
    """Tell Gymnasium: `sigmafmu/<name>-v0`."""
    for name, arguments in ENVIRONMENTS.items():
        gymnasium.register(
            f"sigmafmu/{name}-v0",
            "sigmafmu.gym:MechanismEnv",
            max_episode_steps=STEPS[name],
            kwargs=arguments | {"stop_time": float("inf")},
        )
