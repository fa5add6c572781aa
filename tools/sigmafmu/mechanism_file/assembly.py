"""The start of a mechanism: coordinates and rates that the file gives hold, all else gives way to the joints."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sigmafmu import _core
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


def assemble(
    content: Json, make: Callable[[Json], Any], joints: Mapping[str, Record]
) -> tuple[Json, Any, tuple[Move, ...]]:
    """The definition at a start with the coordinates and rates of the file, its mechanism, and what had to move for it.

    `make` is the mechanism of a definition. Where joints do not close from the bodies' places, other starts along the
    tree are tried, and that which moves least is taken; from there the change is made least. Raises ValueError or
    RuntimeError with the core's sentence, which names the joints that cannot close and by how much.
    """
    mechanism = make(content)
    try:
        start, moved = _assembled(content, mechanism, joints)
    except RuntimeError as error:
        start, moved = _from_other_starts(content, make, joints, error)
    if any(move.position or move.turn for move in _moves(content, *moved)) and least_change.applies(content):
        start, moved = _from_the_nearest(content, make, joints, (start, moved))
    return start, make(start), tuple(move for move in _moves(content, *moved) if move.is_any)


def _from_other_starts(
    content: Json, make: Callable[[Json], Any], joints: Mapping[str, Record], error: RuntimeError
) -> tuple[Json, State]:
    """As assemble(), from where bodies hang along trees; without success the error with the least gap."""
    found = []
    for begin in tree_starts(content, joints) if len(content["bodies"]) <= MOST_BODIES else ():
        try:
            found.append(_assembled(begin, make(begin), joints))
        except (ValueError, RuntimeError) as other:
            if _missing(other) < _missing(error):
                error = RuntimeError(str(other))
    if not found:
        raise error
    return min(found, key=lambda result: change(content, _at(content, *result[1])))


def _from_the_nearest(
    content: Json, make: Callable[[Json], Any], joints: Mapping[str, Record], found: tuple[Json, State]
) -> tuple[Json, State]:
    """As assemble(), from the positions nearby that are the nearest to where the file has the bodies."""
    start, (q, v) = found
    system = _core.System(make(start).multibody)
    held = [w for w in _wanted(joints) if not w.is_rate]
    nearest = least_change.nearest(content, system, q, lambda q: _held_rows(system, held, q))
    if nearest is None or not change(content, _at(content, nearest, v)) < change(content, _at(content, q, v)):
        return found
    bodies = zip(content["bodies"], _at(content, nearest, v)["bodies"], strict=True)
    places = ("position", "orientation")
    begin = {**content, "bodies": [old | {key: new[key] for key in places} for old, new in bodies]}
    try:
        return _assembled(begin, make(begin), joints)
    except (ValueError, RuntimeError):  # the least change has an axis the wrong way round
        return found


def _held_rows(system: Any, held: Sequence[Wanted], q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What coordinates of the file miss at q, and their gradients, by rates of unit velocities."""
    rest = np.zeros(system.velocity_size)
    if not held:
        return np.zeros(0), np.zeros((0, len(rest)))
    values = system.coordinates(q, rest)[0]
    rates = np.array([system.coordinates(q, unit)[1] for unit in np.eye(len(rest))])
    return np.array([w.gap(values[w.index]) for w in held]), rates.T[[w.index for w in held]]


def _missing(error: Exception) -> float:
    """What joints miss by, where a message of the core tells it."""
    match = re.search(r"cannot be closed.* by (\S+) \w+\.$", str(error))
    return float(match[1]) if match else np.inf


def _assembled(content: Json, mechanism: Any, joints: Mapping[str, Record]) -> tuple[Json, State]:
    """From one start: the definition there, and its state."""
    q, v = _core.assemble(mechanism.multibody)
    wanted = list(_wanted(joints))
    reached = _core.System(mechanism.multibody).coordinates(q, v) if wanted else ()
    if any(w.missed_by(reached[w.is_rate][w.index]) for w in wanted):
        for w in wanted:
            mechanism.set(w.parameter, w.value)
        q, v = _core.assemble(mechanism.multibody)
        content = _at(content, q, v)
    return _with_turns(content, wanted, joints), (q, v)


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
