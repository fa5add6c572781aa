"""A small mechanism with each element that mechanism files know; what is new in their table is here by itself."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from research.elements.values import NUMBERS, value
from sigmafmu.mechanism_file.kinds import Reference
from sigmafmu.mechanism_file.load import MechanismFile, load_text
from sigmafmu.mechanism_file.structures import ByType, Key, List, Named, Struct
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
    typed: bool = False
    """Whether its section has others, which the key `type` tells apart."""

    @property
    def id(self) -> str:
        """Of all elements it alone has this one; for names of files."""
        return f"{self.section}-{self.name}".replace("_", "-")

    @property
    def on_two_bodies(self) -> bool:
        """Whether it acts between two, of which one may be the ground."""
        return any(key.name == "bodies" for key in self.keys)

    @property
    def on_plane(self) -> bool:
        """Whether its first body has a plane, in the forces that of the ground."""
        return self.section == "forces" and any(key.name == "normal" for key in self.keys)

    @property
    def on_coordinates(self) -> bool:
        """Whether it ties coordinates of joints."""
        kinds = (key.kind for key in self.keys)
        return any(isinstance(k, List) and k.of == Reference("coordinate") for k in kinds)


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
                yield Element(key.name, name, meaning, keys, typed=True)
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


# --- mechanisms ------------------------------------------------------------------------------------------------------

Point = tuple[float, float, float]
"""Or principal moments."""
BOX = (0.0208 / 12, 0.0464 / 12, 0.0544 / 12)
"""Moments of a box of 1 kg, 0.2 × 0.12 × 0.08 m."""
ROD = (0.02**2 / 6, 0.4**2 / 12, 0.4**2 / 12)
SHAFT = 0.27
"""Length of a wheel's shaft [m]."""
BESIDE, HERE = (-0.15, 0.0, 0.1), (0.3, 0.0, 0.1)
"""Where bodies are."""
DISK = (HERE[2] ** 2 / 4, HERE[2] ** 2 / 2, HERE[2] ** 2 / 4)
"""Of 1 kg about y, that stands on the plane z = 0."""


def mechanism(element: Element, present: bool = True, copies: int = 1, to_ground: bool = False) -> Json:
    """The content of a file with that many of the element, side by side, each with bodies of its own; or without it.

    Forces are between two bodies, or `to_ground`.
    """
    content: Json = {"sigmafmu": 1, "name": "Example", "gravity": [0, 0, -9.81], "expose": "all"}
    content |= {"bodies": {}, "joints": {}}
    for i in range(copies):
        _Copy(content, element, str(i + 1) if copies > 1 else "", 1.5 * i).add(present, to_ground)
    return content


def load(content: Json) -> MechanismFile:
    """Read such a content."""
    return load_text(json.dumps(content), Path("Example.json"))


@dataclass(frozen=True)
class _Copy:
    """An element and its bodies: what it adds to the content of a file, with a number behind all names, at y."""

    content: Json
    element: Element
    number: str
    y: float

    def add(self, present: bool, to_ground: bool) -> None:
        """All of it, or all but the element."""
        names = self._on(to_ground, present)
        if not present:
            return
        section, entries = self.element.section, self.content.setdefault(self.element.section, {})
        if section == ACTING:
            del self.content[ACTING]
            self.content["joints"][names[0]] |= self._entry(names)
        elif section == "drives":
            entries[names[0]] = {"motion": "rate", "value": "input"}
        elif section == "motions":
            entries[f"element{self.number}"] = {"input": True}
        else:
            kind = {"type": self.element.name} if self.element.typed else {}
            entries[f"element{self.number}"] = kind | self._entry(names)

    def _entry(self, names: tuple[str, ...]) -> Json:
        """Values of the element's keys."""
        values = {key.name: value(key, names) for key in self.element.keys}
        found = {key: x for key, x in values.items() if x is not None}
        if self.element.section == "sensors":
            found["point"] = [0.4, 0, 0.15]
        if {"normal", "axis"} <= found.keys():  # a disk that stands on its plane
            found |= {"axis": [0, 1, 0], "radius": HERE[2]}
        for name in ("point", "point1", "point2"):
            if name in found:
                found[name] = self._at(found[name])
        if "points2" in found:
            found["points2"] = [self._at(point) for point in found["points2"]]
        return found

    def _on(self, to_ground: bool, present: bool) -> tuple[str, ...]:
        """Names of the bodies or joints that the element acts on, which are added."""
        section, name = self.element.section, self.element.name
        if self.element.on_coordinates:
            return self._wheels()
        if section == "joints":  # what is fixed to the ground could not move
            moments = DISK if name == "rolling_disk" else BOX
            return (self._body("base", BESIDE) if name == "fixed" else "ground", self._body("part", HERE, moments))
        if section == "forces":
            return self._between(to_ground or self.element.on_plane)
        if section == "motions":  # a frame from which a body hangs
            self._joint("pivot", "spherical", self._body("part", HERE), BESIDE, present)
        elif name == "motor":
            return (self._joint("hinge", "spherical", self._body("part", HERE), (0, 0, 0.1)),)
        elif section in (ACTING, "drives"):
            return (self._joint("hinge", "revolute", self._body("part", HERE), (0, 0, 0.1), axis=[0, 1, 0]),)
        else:
            return (self._body("part", HERE),)
        return ()

    def _between(self, to_ground: bool) -> tuple[str, ...]:
        """Two bodies, or one; balls where balls touch."""
        balls = self.element.name in ("plane_contact", "sphere_contact")
        second = self._body("two", HERE, _ball(NUMBERS["radius2"]) if balls else BOX)
        if not self.element.on_two_bodies:
            return (second,)
        if to_ground:
            return ("ground", second)
        first = self._body("one", (0, 0, 0), _ball(NUMBERS["radius1"])) if balls else self._body("one", BESIDE)
        return (first, second)

    def _wheels(self) -> tuple[str, ...]:
        """Joints of wheels that touch; of a rack on a rail below its pinion."""
        roles = getattr(prescribed.COUPLING_TYPES.get(self.element.name), "joints", ()) or ("first", "second")
        radii = [NUMBERS["radius"], NUMBERS["radius"] / 2] if self.element.name in ("gear", "rack_and_pinion") else []
        names, x = [], 0.0
        for k, role in enumerate(roles):
            radius = radii[k] if radii else 0.1
            x += radius if k else 0.0
            if role == "rack":
                place = (0.0, 0.0, 0.1 - NUMBERS["radius"] - 0.03)
                names.append(self._joint("rail", "prismatic", self._body(role, place, ROD), place, axis=[1, 0, 0]))
            else:  # a little beside its centre of mass, so that it swings
                disk = (radius**2 / 4, radius**2 / 2, radius**2 / 4)
                wheel, end = self._body(role, (x + 0.01, 0.0, 0.1), disk), (x, SHAFT * (-1) ** k, 0.1)
                names.append(self._joint(f"{role}Shaft", "revolute", wheel, end, axis=[0, 1, 0]))
            x += radius
        return tuple(names)

    def _body(self, name: str, centre: Point, moments: Point = BOX) -> str:
        velocity = {"velocity": [0.1, -0.2, 0.3], "angular_velocity": [1.0, 0.5, -2.0]}
        body = {"center_of_mass": self._at(centre), "mass": 1.0, "inertia": list(moments)}
        moving = self.element.section in ("joints", "forces")
        self.content["bodies"][name + self.number] = body | (velocity if moving else {})
        return name + self.number

    def _joint(self, name: str, kind: str, body: str, point: Point, in_frame: bool = False, **more: Any) -> str:
        """To the ground, or to the moving frame of the ground that is the element."""
        ends: Json = {"point": self._at(point)}
        if in_frame:
            ends = {"frame1": {"motion": f"element{self.number}"}, "frame2": {"position": self._at((0, 0, 0))}}
        self.content["joints"][name + self.number] = {"type": kind, "bodies": ["ground", body]} | ends | more
        return name + self.number

    def _at(self, point: Any) -> list[float]:
        """A point that counts from this copy's place."""
        return [point[0], point[1] + self.y, point[2]]


def _ball(radius: float) -> Point:
    """Moments of a ball of 1 kg."""
    return (0.4 * radius**2,) * 3
