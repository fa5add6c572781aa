"""A small mechanism with each element that mechanism files know; what is new in their table is here by itself."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from sigmafmu.mechanism_file.kinds import Flag, Kind, Number, Reference, Whole, Word, WordOr
from sigmafmu.mechanism_file.load import MechanismFile, load_text
from sigmafmu.mechanism_file.structures import ByType, Direction, Key, List, Named, Points, Struct
from sigmafmu.mechanism_file.table import coordinates, forces, joints, outputs, prescribed
from sigmafmu.mechanism_file.table.mechanism import MECHANISM

Json = dict[str, Any]
NO_ELEMENTS = ("bodies", "stations")
"""Lists of a file whose entries are none."""
ACTING = "acting"
"""Section of what acts on coordinates, whose keys are a joint's."""
MEANINGS: dict[str, dict[str, Any]] = {
    "joints": joints.JOINT_TYPES,
    "forces": forces.FORCE_TYPES,
    "couplings": prescribed.COUPLING_TYPES,
    "sensors": outputs.SENSOR_TYPES,
}
ACTING_MEANINGS = {
    "joint_springs": "spring and damper on a coordinate",
    "joint_frictions": "friction on a coordinate",
    "joint_stops": "stops at both ends of a coordinate's range",
    "joint_armatures": "inertia that moves with a coordinate",
    "motor": "torque in a joint that lets its bodies turn any way",
}


@dataclass(frozen=True)
class Element:
    """A type of a section of mechanism files, or a section that has one type."""

    section: str
    name: str
    meaning: str
    keys: tuple[Key, ...]

    @property
    def id(self) -> str:
        """Of all elements it alone has this one; for names of files."""
        return f"{self.section}-{self.name}".replace("_", "-")


@cache
def elements() -> tuple[Element, ...]:
    """All, in the order of the loader's table."""
    return tuple(_elements())


def _elements() -> Iterator[Element]:
    for key in MECHANISM.keys:
        if not isinstance(key.kind, Named) or key.name in NO_ELEMENTS:
            continue
        if isinstance(key.kind.of, ByType):
            for name, struct in key.kind.of.types.items():
                known = MEANINGS.get(key.name, {}).get(name)
                meaning = known.meaning if known else struct.keys[0].meaning
                acting = _on_coordinates(name) if key.name == "joints" else set()
                keys = tuple(k for k in struct.keys[1:] if k.name not in acting)
                yield Element(key.name, name, meaning, keys)
        elif isinstance(key.kind.of, Struct):
            yield Element(key.name, key.name.removesuffix("s"), key.meaning, key.kind.of.keys)
        if key.name == "joints":
            yield from _acting()


def _on_coordinates(joint: str) -> set[str]:
    """Keys of a type of joint for its coordinates, and its motor."""
    free = joints.JOINT_TYPES[joint].coordinates
    return {key.name for key in (*(key for c in free for key in coordinates.keys_of(c)), *joints.MOTOR)}


def _acting() -> Iterator[Element]:
    hinge = {key.name: key for key in joints.JOINTS.types["revolute"].keys}
    for name, keys in coordinates.ACTING.items():
        meaning = ACTING_MEANINGS.get(name, keys[0].meaning)
        yield Element(ACTING, name, meaning, tuple(hinge[key.word] for key in keys))
    yield Element(ACTING, "motor", ACTING_MEANINGS["motor"], joints.MOTOR)


# --- values ----------------------------------------------------------------------------------------------------------

GEOMETRY: Json = {
    "point": [0, 0, 0],
    "point1": [0, 0, 0],
    "point2": [0.3, 0, 0.1],
    "points2": [[0.2, -0.1, 0.1], [0.2, 0.1, 0.1], [0.4, -0.1, 0.1], [0.4, 0.1, 0.1]],
    "axis": [0, 0, 1],
    "normal": [0, 0, 1],
    "axis1": [0, 1, 0],
    "axis2": [1, 0, 0],
}
NUMBERS: Json = {
    "radius": 0.15,
    "radius1": 0.15,
    "radius2": 0.2,
    "stiffness": 100.0,
    "free_length": 0.2,
    "modulus": 1e4,
    "pitch": 0.05,
    "ratio": -2.0,
    "limits": [-0.5, 0.5],
    "length": 0.3,
    "friction": 1.0,
    "stribeck_friction": 0.5,
    "stribeck_rate": 0.4,
    "viscous_friction": 0.1,
    "creep_rate": 0.05,
    "stop_stiffness": 1e4,
    "stop_damping": 0.5,
    "stop_depth": 0.01,
}
TABLES: Json = {"length": [0.1, 0.3, 0.6], "force": [-5.0, 0.0, 20.0], "rate": [-1.0, 1.0], "rate_force": [-2.0, 2.0]}
LEFT_OUT = ("description", "stiffness_coupling", "damping_coupling", "node", "offset", "input", "coordinate")
"""Keys that examples do not have, where they may be left out."""


def value(key: Key, names: tuple[str, ...]) -> Any:
    """Something that a key may have; None: it is left out. References are to these names."""
    if key.name in GEOMETRY:
        return GEOMETRY[key.name]
    if key.name in LEFT_OUT and not key.required:
        return None
    if isinstance(key.kind, List) and isinstance(key.kind.of, Number) and key.kind.count is None and key.name in TABLES:
        return TABLES[key.name]
    if key.name in NUMBERS and isinstance(NUMBERS[key.name], list) == (isinstance(key.kind, List)):
        return NUMBERS[key.name]
    if not key.required and not _is_numeric(key.kind):
        return None
    return _value(key.kind, names, NUMBERS.get(key.name, 1.0))


def _is_numeric(kind: Kind) -> bool:
    if isinstance(kind, List | Points):
        return _is_numeric(kind.of if isinstance(kind, List) else kind.y)
    return isinstance(kind, Number | Flag)


def _value(kind: Kind, names: tuple[str, ...], number: Any) -> Any:
    if isinstance(kind, List):
        count = kind.count or (len(names) if isinstance(kind.of, Reference) else max(kind.least, 2))
        if isinstance(kind.of, Reference):
            return list(names[:count])
        return [_value(kind.of, names, number) for _ in range(count)]
    if isinstance(kind, Points):
        return [[0, 0], [1, 0.1]]
    if isinstance(kind, Reference):
        return names[-1]
    if isinstance(kind, Word):
        return kind.words[0]
    if isinstance(kind, WordOr):
        return kind.word
    if isinstance(kind, Flag):
        return True
    if isinstance(kind, Whole):
        return kind.least
    if isinstance(kind, Direction):
        return [0, 0, 1]
    return number


Point = tuple[float, float, float]
"""Or principal moments."""
BOX = (0.0208 / 12, 0.0464 / 12, 0.0544 / 12)
"""Moments of a box of 1 kg, 0.2 × 0.12 × 0.08."""
ROD = (0.02**2 / 6, 0.4**2 / 12, 0.4**2 / 12)


SHAFT = 0.27
"""Length of a wheel's shaft [m]."""


def ball(radius: float) -> Point:
    """Moments of a ball of 1 kg."""
    return (0.4 * radius**2,) * 3


# --- mechanisms ------------------------------------------------------------------------------------------------------


def mechanism(element: Element, present: bool = True, copies: int = 1, to_ground: bool = False) -> Json:
    """The content of a file with that many of the element, side by side, each with bodies of its own; or without it.

    Forces are between two bodies, or `to_ground`.
    """
    content: Json = {
        "sigmafmu": 1,
        "name": "Example",
        "gravity": [0, 0, -9.81],
        "expose": "all",
        "bodies": {},
        "joints": {},
        element.section if element.section != ACTING else "forces": {},
    }
    for i in range(copies):
        _add(content, element, str(i + 1) if copies > 1 else "", 1.5 * i, present, to_ground)
    return content


def on_two_bodies(element: Element) -> bool:
    """Whether it acts between two, of which one may be the ground."""
    return any(key.name == "bodies" for key in element.keys)


def _add(content: Json, element: Element, n: str, y: float, present: bool, to_ground: bool) -> None:
    """A copy, at y."""

    def body(name: str, centre: Point, moments: Point = BOX) -> str:
        """At a place that counts from this copy's."""
        velocity = {"velocity": [0.1, -0.2, 0.3], "angular_velocity": [1.0, 0.5, -2.0]}
        place = [centre[0], centre[1] + y, centre[2]]
        content["bodies"][name + n] = {"center_of_mass": place, "mass": 1.0, "inertia": list(moments)}
        content["bodies"][name + n] |= velocity if element.section in ("joints", "forces") else {}
        return name + n

    def hinge(name: str, turned: str, x: float, beside: float = 0.0) -> str:
        """Horizontal, so that it swings."""
        ends = {"bodies": ["ground", turned], "point": [x, y + beside, 0.1], "axis": [0, 1, 0]}
        content["joints"][name + n] = {"type": "revolute", **ends}
        return name + n

    def wheel(role: str, x: float, radius: float, shaft: float) -> str:
        """On a hinge at the end of its shaft, a little beside its centre of mass."""
        disk = (radius**2 / 4, radius**2 / 2, radius**2 / 4)
        return hinge(f"{role}Shaft", body(role, (x + 0.01, 0, 0.1), disk), x, shaft)

    def rack(role: str, x: float, radius: float) -> str:
        """On a rail below a pinion."""
        place = (x, 0.0, 0.1 - radius - 0.03)
        rail = {
            "bodies": ["ground", body(role, place, ROD)],
            "point": at({"point": [*place]})["point"],
            "axis": [1, 0, 0],
        }
        content["joints"]["rail" + n] = {"type": "prismatic", **rail}
        return "rail" + n

    def coupled() -> tuple[str, ...]:
        """What a coupling or a tendon ties: wheels that touch."""
        roles = getattr(prescribed.COUPLING_TYPES.get(element.name), "joints", ()) or ("first", "second")
        radii = [0.15, 0.075, 0.075] if element.name in ("gear", "rack_and_pinion") else [0.1] * len(roles)
        places = [sum(radii[:k]) + sum(radii[1 : k + 1]) for k in range(len(roles))]
        shafts = [SHAFT * (-1) ** k for k in range(len(roles))]
        return tuple(
            rack(role, 0.0, NUMBERS["radius"]) if role == "rack" else wheel(role, x, radius, shaft)
            for role, x, radius, shaft in zip(roles, places, radii, shafts, strict=False)
        )

    def at(keys: Json) -> Json:
        """Points moved to this copy."""
        moved = dict(keys)
        for name in ("point", "point1", "point2"):
            if name in moved:
                moved[name] = [moved[name][0], moved[name][1] + y, moved[name][2]]
        if "points2" in moved:
            moved["points2"] = [[x, py + y, z] for x, py, z in moved["points2"]]
        return moved

    def entry(*names: str) -> Json:
        values = {key.name: value(key, names) for key in element.keys}
        found = {key: x for key, x in values.items() if x is not None}
        if element.section not in (ACTING, "loads", "motions", "drives", "tendons"):
            found["type"] = element.name
        if element.section == "sensors":
            found["point"] = [0.4, 0, 0.15]
        return at(found)

    beside, here = (-0.15, 0.0, 0.1), (0.3, 0.0, 0.1)
    names: tuple[str, ...]
    if element.section == "joints":  # what is fixed to the ground could not move
        names = (body("base", beside) if element.name == "fixed" else "ground", body("part", here))
    elif element.section == "forces":
        round_ones = element.name in ("plane_contact", "sphere_contact")
        names = (body("two", here, ball(NUMBERS["radius2"])) if round_ones else body("two", here),)
        if on_two_bodies(element):
            on_ground = to_ground or any(key.name == "normal" for key in element.keys)
            one = (
                (body("one", (0, 0, 0), ball(NUMBERS["radius1"])) if round_ones else body("one", beside))
                if not on_ground
                else "ground"
            )
            names = (one, *names)
    elif element.section in ("couplings", "tendons"):
        names = coupled()
    elif element.section == "motions":  # a frame from which a body hangs
        names = (body("part", here),)
        frame = {"motion": "element" + n} if present else {}
        pivot = {"type": "spherical", "bodies": ["ground", *names], "frame1": frame}
        content["joints"]["pivot" + n] = pivot | {"frame2": {"position": [0, y, 0]}}
    elif element.section in (ACTING, "drives"):
        names = (hinge("hinge", body("part", here), 0.0),)
    else:
        names = (body("part", here),)
    if element.name == "motor":
        content["joints"][names[0]] = at({"type": "spherical", "bodies": ["ground", "part" + n], "point": [0, 0, 0.1]})
    if not present:
        return
    if element.section == ACTING:
        content["joints"][names[0]] |= entry()
    elif element.section == "drives":
        content["drives"][names[0]] = {"motion": "rate", "value": "input"}
    elif element.section == "motions":
        content["motions"]["element" + n] = {"input": True}
    else:
        content[element.section]["element" + n] = entry(*names)


def load(content: Json) -> MechanismFile:
    """Read such a content."""
    return load_text(json.dumps(content), Path("Example.json"))
