"""What a description of a robot says, whatever its format: a tree of bodies with joints, and what closes its loops."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from sigmafmu.importers.inertia import Inertia, Pose
from sigmafmu.mechanism_file.problems import FileError

GROUND = "ground"


class DescriptionError(FileError):
    """A description that cannot be read: `FILE:LINE: what is wrong; what is allowed`."""


@dataclass
class Shape:
    """What is drawn: the keys of a shape in a mechanism file, and where it is in the body's frame."""

    keys: dict[str, Any]
    pose: Pose = field(default_factory=Pose)


@dataclass
class Body:
    """A rigid body in its own frame."""

    name: str
    inertia: Inertia = field(default_factory=Inertia)
    shapes: list[Shape] = field(default_factory=list)
    inertia_axes: Pose | None = None
    """Axes in which the description gives the inertia, if these are others."""
    start: Pose | None = None
    """Where it is in W, if no joint says so."""
    merged: list[str] = field(default_factory=list)
    """Names of bodies that are part of it."""
    comment: str = ""


@dataclass
class Joint:
    """A joint of the mechanism file, by frames of both bodies; z is the axis."""

    name: str
    type: str
    bodies: tuple[str, str]
    """First, second; in the tree parent and child."""
    frames: tuple[Pose, Pose]
    keys: dict[str, Any] = field(default_factory=dict)
    """Damping, limits and so on."""
    comment: str = ""
    closes: bool = False
    """Whether it closes a loop; else it carries its second body."""


@dataclass
class Force:
    """A force of the mechanism file between frames of two bodies."""

    name: str
    type: str
    bodies: tuple[str, str]
    frames: tuple[Pose, Pose]
    keys: dict[str, Any] = field(default_factory=dict)
    comment: str = ""


@dataclass
class Coupling:
    """A coupling of coordinates."""

    name: str
    type: str
    joints: list[str]
    keys: dict[str, Any] = field(default_factory=dict)


@dataclass
class Tendon:
    """A spring on a sum of coordinates."""

    name: str
    joints: list[str]
    keys: dict[str, Any] = field(default_factory=dict)


@dataclass
class Robot:
    """All of it. The names are those of the description until `rename` has made them names of a mechanism file."""

    name: str
    source: str
    """What it was made of, for the first line."""
    bodies: dict[str, Body] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    forces: list[Force] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    tendons: list[Tendon] = field(default_factory=list)
    gravity: list[float] = field(default_factory=lambda: [0.0, 0.0, -9.81])
    step_size: float = 1e-3
    in_ground: list[str] = field(default_factory=list)
    """Bodies that are part of it."""
    coordinates: dict[str, str] = field(default_factory=dict)
    """Names of coordinates in the mechanism file, by the description's names of their joints."""
    changed: list[str] = field(default_factory=list)
    """Bodies whose mass or inertia is not that of the description."""
    told: list[str] = field(default_factory=list)
    """What was dropped or changed, a sentence each."""

    def tell(self, text: str) -> None:
        """Note what was dropped or changed, once."""
        if text not in self.told:
            self.told.append(text)

    def tree(self) -> Iterator[Joint]:
        """Joints that carry bodies."""
        return (joint for joint in self.joints.values() if not joint.closes)

    def attached(self) -> Iterator[Joint | Force]:
        """All that has frames in bodies."""
        yield from self.joints.values()
        yield from self.forces

    def on_coordinates(self) -> Iterator[Coupling | Tendon]:
        """All that names coordinates."""
        yield from self.couplings
        yield from self.tendons


def start_within_limits(robot: Robot, name: str, keys: dict[str, Any]) -> None:
    """A coordinate that would start beyond its limits starts at the nearest."""
    x = keys.get("coordinate", 0.0)
    low, high = keys.get("limits", (x, x))
    if not low <= x <= high:
        keys["coordinate"] = low if x < low else high
        robot.tell(f"{name}: starts at {keys['coordinate']:.6g}, since {x:g} is beyond its limits")


def valid_name(text: str) -> str:
    """The name of a mechanism file that is nearest to a text."""
    words = [re.sub(r"[^A-Za-z0-9_]", "_", word) for word in text.split(".") if word] or ["_"]
    return ".".join(f"_{word}" if word[0].isdigit() else word for word in words)


def rename(robot: Robot) -> None:
    """Give all elements names of a mechanism file that differ; those of bodies and joints stay where they can."""
    taken = {GROUND}

    def unique(name: str, ending: str) -> str:
        base = valid_name(name)
        candidates = [base, f"{base}_{ending}", *(f"{base}_{ending}{i}" for i in range(2, len(taken) + 3))]
        new = next(candidate for candidate in candidates if candidate not in taken)
        taken.add(new)
        if new != name:
            changed.append(f"{name} is {new}")
        return new

    changed: list[str] = []
    bodies = {GROUND: GROUND} | {name: unique(name, "body") for name in robot.bodies}
    joints = {name: unique(name, "joint") for name in robot.joints}
    robot.bodies = {bodies[name]: body for name, body in robot.bodies.items()}
    robot.joints = {joints[name]: joint for name, joint in robot.joints.items()}
    for name, body in robot.bodies.items():
        body.name = name
    for name, joint in robot.joints.items():
        joint.name = name
    for element in robot.attached():
        element.bodies = bodies[element.bodies[0]], bodies[element.bodies[1]]
    robot.coordinates = {old: _coordinate(name, joints) for old, name in robot.coordinates.items()} | joints
    robot.changed = [bodies[name] for name in robot.changed]
    for element in robot.on_coordinates():
        element.joints = [_coordinate(name, joints) for name in element.joints]
        element.name = unique(element.name, "coupling" if isinstance(element, Coupling) else "tendon")
    for force in robot.forces:
        force.name = unique(force.name, "force")
    robot.name = valid_name(robot.name).replace(".", "_")
    if changed:
        robot.tell(f"other names: {', '.join(changed)}")


def _coordinate(name: str, joints: dict[str, str]) -> str:
    """A coordinate with its joint's new name; until then a joint and the coordinate's word have a zero between."""
    joint, _, word = name.partition("\0")
    return f"{joints[joint]}.{word}" if word else joints[joint]
