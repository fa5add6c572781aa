"""The start of a mechanism: coordinates and rates that the file gives hold, all else gives way to the joints."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sigmafmu import native
from sigmafmu.mechanism_file import least_change, rotations
from sigmafmu.mechanism_file.definition import Json
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES
from sigmafmu.mechanism_file.tree_starts import change, tree_starts

State = tuple[np.ndarray, np.ndarray]
"""q and v."""

MOST_BODIES = 100
"""Of mechanisms for which other starts are tried: what does not close costs the cube of their number."""
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

    def gap(self, x: float) -> float:
        """From the value to x; whole turns do not count."""
        gap = x - self.value
        return gap if self.is_rate or not self.turns else float(np.remainder(gap + np.pi, 2 * np.pi) - np.pi)

    def missed_by(self, x: float) -> bool:
        """Whether x is another value."""
        return abs(self.gap(x)) > ROUNDING * (1 + abs(self.value))


def assemble(content: Json, resources: Path, joints: Mapping[str, Record]) -> tuple[Json, tuple[Move, ...]]:
    """The definition at a start with the coordinates and rates of the file, and what had to move for it.

    The modal data are in the folder `resources`. Where joints do not close from the bodies' places, other starts along
    the tree are tried, and that which moves least is taken; from there the change is made least. Raises ValueError for
    a definition that is wrong, RuntimeError with the joints that cannot close and by how much.
    """
    try:
        start, moved = _assembled(content, resources, joints)
    except RuntimeError as error:
        start, moved = _from_other_starts(content, resources, joints, error)
    if any(move.position or move.turn for move in _moves(content, *moved)) and least_change.applies(content):
        start, moved = _from_the_nearest(content, resources, joints, (start, moved))
    return start, tuple(move for move in _moves(content, *moved) if move.is_any)


def _from_other_starts(
    content: Json, resources: Path, joints: Mapping[str, Record], error: RuntimeError
) -> tuple[Json, State]:
    """As assemble(), from where bodies hang along trees; without success the error with the least gap."""
    found = []
    for begin in tree_starts(content, joints) if len(content["bodies"]) <= MOST_BODIES else ():
        try:
            found.append(_assembled(begin, resources, joints))
        except (ValueError, RuntimeError) as other:
            if _missing(other) < _missing(error):
                error = RuntimeError(str(other))
    if not found:
        raise error
    return min(found, key=lambda result: change(content, _at(content, *result[1])))


def _from_the_nearest(
    content: Json, resources: Path, joints: Mapping[str, Record], found: tuple[Json, State]
) -> tuple[Json, State]:
    """As assemble(), from the positions nearby that are the nearest to where the file has the bodies."""
    start, (q, v) = found
    text, held = json.dumps(start), [w for w in _wanted(joints) if not w.is_rate]

    def closure(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        told = native.closure(text, resources, q, [w.index for w in held])
        missed = [w.gap(value) for w, value in zip(held, told["values"], strict=True)]
        size = 6 * len(content["bodies"])
        rows = np.vstack([told["rows"].reshape(-1, size), told["value_rows"].reshape(-1, size)])
        return np.concatenate([told["gaps"], missed]), rows

    nearest = least_change.nearest(content, q, closure)
    if nearest is None or not change(content, _at(content, nearest, v)) < change(content, _at(content, q, v)):
        return found
    bodies = zip(content["bodies"], _at(content, nearest, v)["bodies"], strict=True)
    places = ("position", "orientation")
    begin = {**content, "bodies": [old | {key: new[key] for key in places} for old, new in bodies]}
    try:
        return _assembled(begin, resources, joints)
    except (ValueError, RuntimeError):  # the least change has an axis the wrong way round
        return found


def _missing(error: Exception) -> float:
    """What joints miss by, where a message of the core tells it."""
    match = re.search(r"cannot be closed.* by (\S+) \w+\.$", str(error))
    return float(match[1]) if match else np.inf


def _assembled(content: Json, resources: Path, joints: Mapping[str, Record]) -> tuple[Json, State]:
    """From one start: the definition there, and its state."""
    text, wanted = json.dumps(content), list(_wanted(joints))
    told = native.start(text, resources)
    if any(w.missed_by(told["rates" if w.is_rate else "coordinates"][w.index]) for w in wanted):
        told = native.start(text, resources, {w.parameter: w.value for w in wanted})
        content = _at(content, told["q"], told["v"])
    return _with_turns(content, wanted, joints), (told["q"], told["v"])


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
