"""The start of a mechanism: coordinates and rates that the file gives hold, all else gives way to the joints."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sigmafmu import native
from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.definition import Json
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES

ROUNDING = 1e-9
"""Relative: less has not moved."""


@dataclass(frozen=True)
class Move:
    """What a body had to give way by: position [m], turn [rad], velocity [m/s] and angular velocity [rad/s]."""

    body: str
    position: float
    turn: float
    velocity: float
    angular_velocity: float

    @property
    def is_any(self) -> bool:
        """Whether it moved by more than rounding."""
        return max(self.position, self.turn, self.velocity, self.angular_velocity) > 0


@dataclass(frozen=True)
class Wanted:
    """A coordinate or rate that the file gives: the FMU's parameter for it, and its place in `System.coordinates`."""

    parameter: str
    index: int
    value: float
    is_rate: bool
    turns: bool

    def missed_by(self, x: float) -> bool:
        """Whether x is another value; whole turns do not count."""
        gap = x - self.value
        if self.turns and not self.is_rate:
            gap = np.remainder(gap + np.pi, 2 * np.pi) - np.pi
        return abs(gap) > ROUNDING * (1 + abs(self.value))


def assemble(content: Json, resources: Path, joints: Mapping[str, Record]) -> tuple[Json, tuple[Move, ...]]:
    """The definition at a start with the coordinates and rates of the file, and what had to move for it.

    The modal data are in the folder `resources`. Raises ValueError with the core's sentence for a definition that is
    wrong, or that names the joints that cannot close.
    """
    found = native.start(json.dumps(content), resources)
    wanted = list(_wanted(joints))
    before = content
    if any(w.missed_by((found["rates"] if w.is_rate else found["coordinates"])[w.index]) for w in wanted):
        found = native.start(json.dumps(content), resources, {w.parameter: w.value for w in wanted})
        content = _at(content, np.array(found["q"]), np.array(found["v"]))
    result = _with_turns(content, wanted, joints)
    if result is not before:
        native.start(json.dumps(result), resources)  # checks it
    return result, tuple(move for move in _moves(before, np.array(found["q"]), np.array(found["v"])) if move.is_any)


def _wanted(joints: Mapping[str, Record]) -> Iterator[Wanted]:
    index = 0
    for name, joint in joints.items():
        for c in JOINT_TYPES[joint["type"]].coordinates:
            for is_rate, word in enumerate(("coordinate", "rate")):
                if c.key(word) in joint:
                    parameter = f"{name}.{c.initial(word)}"
                    yield Wanted(parameter, index, joint[c.key(word)], bool(is_rate), c.turns)
            index += 1


def _with_turns(content: Json, wanted: Iterable[Wanted], joints: Mapping[str, Record]) -> Json:
    """Angles of more than half a turn are held: bodies do not tell how often they have turned."""
    far = {w.parameter for w in wanted if w.turns and not w.is_rate and abs(w.value) > np.pi}
    if not far:
        return content
    content = {**content, "held": dict.fromkeys(sorted(far))}
    content["joints"] = [dict(joint) for joint in content["joints"]]
    for entry in content["joints"]:
        for c in JOINT_TYPES[entry["type"]].coordinates:
            if f"{entry['name']}.{c.initial('coordinate')}" in far:
                entry[c.key("coordinate")] = joints[entry["name"]][c.key("coordinate")]
    return content


def _at(content: Json, q: np.ndarray, v: np.ndarray) -> Json:
    """The definition with its bodies at q, v."""
    bodies = []
    modal, modal_rate = 7 * len(content["bodies"]), 6 * len(content["bodies"])
    for i, body in enumerate(content["bodies"]):
        pose, twist = q[7 * i : 7 * i + 7].tolist(), v[6 * i : 6 * i + 6].tolist()
        body = body | {"position": pose[:3], "orientation": {"quaternion": pose[3:]}}
        body |= {"velocity": twist[:3], "angular_velocity": twist[3:]}
        if "flexible" in body:
            modes = body["flexible"]["modes"]
            moved = {
                "initial_coordinates": q[modal : modal + modes].tolist(),
                "initial_rates": v[modal_rate : modal_rate + modes].tolist(),
            }
            body["flexible"] = body["flexible"] | moved
            modal, modal_rate = modal + modes, modal_rate + modes
        bodies.append(body)
    return {**content, "bodies": bodies}


def _moves(content: Json, q: np.ndarray, v: np.ndarray) -> Iterator[Move]:
    """From the bodies of a definition to q, v; rounding is zero."""

    def distance(from_: list[float], to: np.ndarray) -> float:
        gap = float(np.linalg.norm(to - from_))
        return gap if gap > ROUNDING * (1 + float(np.linalg.norm(to))) else 0.0

    for i, body in enumerate(content["bodies"]):
        pose, twist = q[7 * i : 7 * i + 7], v[6 * i : 6 * i + 6]
        turned = rotations.product(np.array(body["orientation"]["quaternion"]) * [1, -1, -1, -1], pose[3:])
        turn = 2 * float(np.arctan2(np.linalg.norm(turned[1:]), abs(turned[0])))
        yield Move(
            body["name"],
            distance(body["position"], pose[:3]),
            turn if turn > ROUNDING else 0.0,
            distance(body["velocity"], twist[:3]),
            distance(body["angular_velocity"], twist[3:]),
        )
