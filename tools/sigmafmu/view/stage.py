"""The scene of a mechanism, taken apart into meshes that move: what the page and glTF are written from."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sigmafmu.contents.layout import Body, Frame
from sigmafmu.contents.parts import Place, Solid
from sigmafmu.contents.scene_of import Scene, color_of
from sigmafmu.contents.solids import frame_with_z
from sigmafmu.contents.symbols import GREY
from sigmafmu.view import rotations
from sigmafmu.view.meshes import Mesh, joined, mesh_of
from sigmafmu.view.motion import Motion, modes_of

FORCES = ("force", "reactionForce")
TORQUES = ("torque", "reactionTorque")


@dataclass(frozen=True)
class Point:
    """A point of a body, or of a moving frame of the ground: number `body` of a motion, −1 what is at rest.

    It is at `at` of its axes, moved by `modes` (f × 3) there.
    """

    body: int
    at: np.ndarray
    modes: np.ndarray

    def path(self, motion: Motion) -> np.ndarray:
        """Where it is in every frame, n × 3."""
        if self.body < 0:
            return np.broadcast_to(self.at, (len(motion.time), 3))
        track = list(motion.bodies.values())[self.body]
        local = self.at + (track.modal @ self.modes if len(self.modes) else 0.0)
        arms = np.broadcast_to(local, track.position.shape)
        return track.position + np.einsum("nij,nj->ni", rotations.matrix(track.quaternion), arms)


@dataclass(frozen=True)
class Carrier:
    """What moves a mesh: the point is its origin; it turns with the point's body, or reaches along z to another point.

    `length` is how long it is along z at the start.
    """

    point: Point
    turns: bool = True
    to: Point | None = None
    length: float = 0.0


@dataclass(frozen=True)
class Item:
    """A mesh in the axes of its carrier, with a colour; its layer can be hidden."""

    carrier: Carrier
    layer: str
    color: str
    mesh: Mesh


@dataclass(frozen=True)
class Tag:
    """A name at a point."""

    name: str
    detail: str
    layer: str
    color: str
    point: Point


@dataclass(frozen=True)
class Arrow:
    """A force or torque in W at a point; `variable` has three elements."""

    variable: str
    torque: bool
    point: Point


@dataclass(frozen=True)
class Stage:
    """All of it; `frames` are points whose body's axes can be shown."""

    scene: Scene
    items: list[Item]
    tags: list[Tag]
    arrows: list[Arrow]
    traces: list[tuple[str, Point]]


def stage_of(scene: Scene, recorded: Callable[[str], bool]) -> Stage:
    """Take a scene apart; `recorded` tells whether a variable is in the result."""
    bodies = [*scene.layout.bodies.values(), *scene.layout.moving]
    arrows = _arrows(scene, bodies, recorded)
    return Stage(scene, _items(scene, bodies), _tags(scene, bodies), arrows, _traces(scene, bodies))


def _point(place: Place, x: np.ndarray, bodies: list[Frame]) -> Point:
    """The point of `place` that is at x in W at the start."""
    names = [body.name for body in bodies]
    if place.body is None:
        return Point(-1, np.asarray(x, dtype=float), np.zeros((0, 3)))
    body = bodies[names.index(place.body)]
    return Point(names.index(place.body), body.rotation.T @ (x - body.position), _shift(place, body))


def _shift(place: Place, body: Frame) -> np.ndarray:
    """How a place moves with the modal coordinates of its body, f × 3 in its axes."""
    if not place.nodes or not isinstance(body, Body) or not modes_of(body):
        return np.zeros((0, 3))
    return body.modes[list(place.nodes)].mean(axis=0).T @ body.rotation


def _items(scene: Scene, bodies: list[Frame]) -> list[Item]:
    """Meshes; those that move alike and look alike are one."""
    found: dict[tuple, tuple[Carrier, list[Mesh]]] = {}
    for i, solid in enumerate(scene.solids):
        alone = i if solid.other else -1
        key = (solid.place, alone, solid.layer, solid.color, 0 if solid.modes is None else len(solid.modes))
        carrier, mesh = _carried(solid, bodies)
        found.setdefault(key, (carrier, []))[1].append(mesh)
    return [Item(carrier, key[2], key[3], joined(meshes)) for key, (carrier, meshes) in found.items()]


def _carried(solid: Solid, bodies: list[Frame]) -> tuple[Carrier, Mesh]:
    """What carries a solid, and its mesh in the axes of that."""
    modes = np.zeros((0, *solid.faces.shape)) if solid.modes is None else solid.modes
    if solid.other is not None:
        start, end = solid.between
        ends = [_point(place, x, bodies) for place, x in ((solid.place, start), (solid.other, end))]
        carrier = Carrier(ends[0], to=ends[1], length=float(np.linalg.norm(end - start)))
        return carrier, mesh_of((solid.faces - start) @ frame_with_z(end - start), modes)
    if solid.place.body is None:
        return Carrier(_point(solid.place, np.zeros(3), bodies)), mesh_of(solid.faces, modes)
    body = next(body for body in bodies if body.name == solid.place.body)
    if not solid.place.turns:
        return Carrier(_point(solid.place, body.centre, bodies), turns=False), mesh_of(solid.faces - body.centre, modes)
    R = body.rotation
    return Carrier(_point(solid.place, body.position, bodies)), mesh_of((solid.faces - body.position) @ R, modes @ R)


def _tags(scene: Scene, bodies: list[Frame]) -> list[Tag]:
    return [
        Tag(label.name, label.detail, label.layer, label.color, _point(label.place, label.point, bodies))
        for label in scene.labels
    ]


def _arrows(scene: Scene, bodies: list[Frame], recorded: Callable[[str], bool]) -> list[Arrow]:
    """Reactions and forces, which act on the second body (the first, if that is the ground)."""
    found = []
    for link in (*scene.layout.joints, *scene.layout.forces):
        place = link.places[1] if link.bodies[1] or not link.bodies[0] else link.places[0]
        x = link.points[1] if link.bodies[1] or not link.bodies[0] else link.points[0]
        for kinds, torque in ((FORCES, False), (TORQUES, True)):
            names = (f"{link.name}.{kind}" for kind in kinds)
            found += [Arrow(n, torque, _point(place, x, bodies)) for n in names if recorded(f"{n}[3]")]
    return found


def _traces(scene: Scene, bodies: list[Frame]) -> list[tuple[str, Point]]:
    """Points whose paths can be drawn: centres of bodies, and stations."""
    found = []
    for body in scene.layout.bodies.values():
        nodes = () if body.nodes is None else tuple(range(len(body.nodes)))
        found.append((body.name, _point(Place(body.name, nodes), body.centre, bodies)))
    return found + [(name, _point(place, x, bodies)) for name, x, place in scene.layout.stations]


def body_colors(scene: Scene) -> list[str]:
    """A colour for each body's name and path, and for each moving frame."""
    return [color_of(i) for i in range(len(scene.layout.bodies))] + [GREY] * len(scene.layout.moving)
