"""Robots from packages, converted to mechanism files: their accelerations beside those of Pinocchio and MuJoCo.

A state is written into the mechanism file as coordinates and rates, and what is compared are outputs of the slave: all
that a user's file goes through is in between. Friction and limits, which act on one side, are left out on both sides.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import yaml

from sigmafmu import _core
from sigmafmu.importers.robot import Robot
from sigmafmu.mechanism_file.load import load_text
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES

STATES = 20
SEED = 1
ONE_SIDED = ("friction", "limits")

Json = dict[str, Any]


@dataclass
class State:
    """Of a robot: coordinates and rates by their names, and bodies that are placed, with keys of the file.

    Accelerations of `bodies`, which move freely, are compared, those of bodies `on_balls` are not.
    """

    coordinates: dict[str, tuple[float, float]] = field(default_factory=dict)
    bodies: dict[str, Json] = field(default_factory=dict)
    on_balls: dict[str, Json] = field(default_factory=dict)


class Reference(Protocol):
    """A robot in another program."""

    def at_random(self, rng: np.random.Generator) -> tuple[State, np.ndarray]:
        """A state and its accelerations: of coordinates, then of bodies."""


@dataclass(frozen=True)
class Compared:
    """A robot that was converted and compared."""

    name: str
    package: str
    bodies: int
    degrees: int
    error: float
    """Largest difference of accelerations over all states, of the largest acceleration in the state."""
    told: list[str]


def without_one_sided(text: str) -> Json:
    """The content of a mechanism file without friction and limits, with all variables."""
    content = yaml.safe_load(text)
    for joint in content.get("joints", {}).values():
        for c in JOINT_TYPES[joint["type"]].coordinates:
            for key in ONE_SIDED:
                joint.pop(c.key(key), None)
    return content | {"expose": "all"}


def split(name: str, joints: Json) -> tuple[str, str]:
    """The joint of a coordinate, and its word."""
    if name in joints:
        words = [c.word for c in JOINT_TYPES[joints[name]["type"]].coordinates]
        return name, words[0]
    joint, _, word = name.rpartition(".")
    return joint, word


def damping(content: Json, name: str) -> float:
    """Of a coordinate."""
    joint, word = split(name, content["joints"])
    return float(content["joints"][joint].get(_coordinate(content, joint, word).key("damping"), 0.0))


def _coordinate(content: Json, joint: str, word: str) -> Any:
    return next(c for c in JOINT_TYPES[content["joints"][joint]["type"]].coordinates if c.word == word)


def slave_at(content: Json, state: State) -> _core.Slave:
    """The mechanism, started at a state."""
    content = json.loads(json.dumps(content))
    for name, (x, rate) in state.coordinates.items():
        joint, word = split(name, content["joints"])
        c = _coordinate(content, joint, word)
        content["joints"][joint] |= {c.key("coordinate"): x, c.key("rate"): rate}
    for name, keys in (state.bodies | state.on_balls).items():
        content["bodies"][name] |= keys
    slave = _core.Slave(load_text(json.dumps(content), Path("robot.yaml")).mechanism)
    slave.start()
    return slave


def accelerations(slave: _core.Slave, content: Json, coordinates: Iterable[str], bodies: Iterable[str]) -> np.ndarray:
    """Of coordinates [rad/s², m/s²], then of bodies: of the centre of mass in W, angular in the body's axes."""
    values = []
    for name in coordinates:
        joint, word = split(name, content["joints"])
        variable = "angularAcceleration" if word.startswith("angle") else "acceleration"
        values.append(slave.get(f"{joint}.{variable}{word.removeprefix('angle').removeprefix('displacement')}"))
    for name in bodies:
        for variable in ("acceleration", "angularAcceleration"):
            values += [slave.get(f"{name}.{variable}[{i}]") for i in (1, 2, 3)]
    return np.array(values)


def center_of_mass(content: Json, body: str) -> np.ndarray:
    """In the body's frame [m]."""
    return np.array(content["bodies"][body].get("center_of_mass", [0, 0, 0]), dtype=float)


def degrees(content: Json) -> int:
    """Of freedom."""
    return _core.freedom(load_text(json.dumps(content), Path("robot.yaml")).mechanism.multibody).degrees


def compared(path: Path, package: str, robot: Robot, content: Json, reference: Reference, states: int) -> Compared:
    """A robot at random states."""
    rng = np.random.default_rng(SEED)
    worst = 0.0
    for _ in range(states):
        state, expected = reference.at_random(rng)
        found = accelerations(slave_at(content, state), content, state.coordinates, state.bodies)
        worst = max(worst, float(np.abs(found - expected).max() / np.abs(expected).max()))
    return Compared(path.stem, package, len(robot.bodies), degrees(content), worst, robot.told)
