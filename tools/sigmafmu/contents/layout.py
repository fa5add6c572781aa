"""Where the parts of a mechanism are at the start, read from its file `mechanism.json`; lengths in m, vectors in W."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .parts import Place


@dataclass
class Frame:
    """What moves as a whole, with its pose at the start: a body, or a frame of the ground."""

    name: str
    position: np.ndarray
    rotation: np.ndarray


@dataclass
class MovingFrame(Frame):
    """A frame of the ground that moves as prescribed: by tables, or by inputs if it is `driven`."""

    mechanism: str
    """In JSON, and its number there:"""
    index: int
    driven: bool
    """Whether its displacement and its rotation vector are inputs of the FMU."""

    def poses(self, times: np.ndarray, added: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 3) and quaternions (n, 4) at n times [s]; `added` (n, 6) are those inputs."""
        from sigmafmu import native  # not there when the FMUs are built, which have no such frame

        return native.poses(self.mechanism, self.index, times, added)


@dataclass
class Body(Frame):
    """A body; `nodes` (n × 3) are those of a flexible one, `ends` where joints and forces attach to it.

    `modes` (n × 3 × f, in W) are displacements of its nodes, `shapes` what its file says to draw.
    """

    centre: np.ndarray
    mass: float
    inertia: np.ndarray
    spin: np.ndarray
    nodes: np.ndarray | None = None
    modes: np.ndarray | None = None
    shapes: Sequence[Mapping[str, Any]] = ()
    ends: list[np.ndarray] = field(default_factory=list)
    guided: bool = False

    @property
    def reach(self) -> float:
        """How far its ends are from its centre."""
        return max((float(np.linalg.norm(end - self.centre)) for end in self.ends), default=0.0)

    @property
    def gyration(self) -> float:
        """Its largest radius of gyration."""
        return float(np.sqrt(max(np.linalg.eigvalsh(self.inertia)[-1], 0) / self.mass)) if self.mass > 0 else 0.0


@dataclass
class Link:
    """A joint or a force between two bodies (None: the ground): a point and axes (columns) on each."""

    name: str
    type: str
    bodies: list[Body | None]
    points: list[np.ndarray]
    axes: list[np.ndarray]
    places: list[Place]
    stiff: np.ndarray
    """Directions, axes of W, in which a spring or damper acts."""
    radius: float = 0.0
    """Of a disk that rolls."""


@dataclass
class Follower:
    """A force and a torque on a body at a point, as they are at the start."""

    name: str
    place: Place
    point: np.ndarray
    force: np.ndarray
    torque: np.ndarray


Shapes = Mapping[str, Sequence[Mapping[str, Any]]]
"""What files say to draw, by body: places from the origin of the body's frame (a rigid one's centre of mass)."""
NO_SHAPES: Shapes = {}


class Layout:
    """Bodies, joints and forces of a mechanism in its initial configuration."""

    def __init__(self, mechanism: dict[str, Any], resources: Path, bold: float = 1.0, shapes: Shapes = NO_SHAPES):
        bodies = [_body(entry, resources) for entry in mechanism.get("bodies", [])]
        for body in bodies:
            body.shapes = shapes.get(body.name, ())
        self.bodies = {body.name: body for body in bodies}
        self.moving = list(_moving_frames(mechanism))
        """Frames of the ground by their numbers, which are nodes of the ground."""
        self.joints = [self._joint(entry) for entry in mechanism.get("joints", [])]
        self.forces, self.on_joints, self.followers = [], [], []
        for entry in mechanism.get("forces", []):
            if "bodies" in entry:
                self.forces.append(self._force(entry))
            elif "body" in entry:
                self.followers.append(self._follower(entry))
            else:
                self.on_joints.append((entry["name"], entry.get("joint")))
        self.loads = [load for load in mechanism.get("loads", []) if load["body"] in self.bodies]
        self.stations = [
            (
                entry["name"],
                self.bodies[entry["body"]].nodes[entry["nodes"]].mean(axis=0),
                Place(entry["body"], tuple(entry["nodes"])),
            )
            for entry in mechanism.get("stations", [])
        ]
        self.sensors = [self._sensor(entry) for entry in mechanism.get("sensors", [])]
        self.stop_time = float(mechanism.get("experiment", {}).get("stop_time", 1.0))
        self.gravity = np.array(mechanism.get("gravity", (0, 0, 0)), dtype=float)

        span = float(np.linalg.norm(np.ptp(self.points, axis=0)))
        gyration = float(np.median([body.gyration for body in bodies]))
        self.size = (span if span > 2 * gyration else 5 * gyration) or 1.0
        """How large the mechanism is."""
        reaches = [body.reach for body in bodies if body.reach > 1e-6 * self.size]
        usual = float(np.median(reaches)) if reaches else self.size
        most = 0.014 * min(1.0, (3 / len(bodies)) ** 0.4)
        self.thickness = bold * float(np.clip(0.1 * usual, 0.003 * self.size, most * self.size))
        """Radius of bars, `bold` times the usual one."""

    @property
    def points(self) -> np.ndarray:
        """Centres, nodes, and both points of joints and forces, n × 3."""
        links = [point for link in (*self.joints, *self.forces) for point in link.points]
        links += [follower.point for follower in self.followers] + [point for _, _, point, _, _ in self.sensors]
        nodes = [node for body in self.bodies.values() if body.nodes is not None for node in body.nodes]
        return np.array([body.centre for body in self.bodies.values()] + links + nodes)

    def _joint(self, entry: dict[str, Any]) -> Link:
        frames = [entry.get(key, {}) for key in ("frame1", "frame2")]
        places = [(frame.get("position", (0, 0, 0)), frame.get("node", -1)) for frame in frames]
        if entry["type"] in ("prismatic", "cylindrical", "planar", "screw") and entry["bodies"][1] in self.bodies:
            self.bodies[entry["bodies"][1]].guided = True
        return self._link(entry, places, [_rotation(frame.get("orientation", {})) for frame in frames])

    def _force(self, entry: dict[str, Any]) -> Link:
        places, turns = [], []
        for i in (1, 2):
            frame = entry.get(f"frame{i}", {"position": entry.get(f"point{i}"), "node": entry.get(f"node{i}", -1)})
            places.append((frame.get("position") or (0, 0, 0), frame.get("node", -1)))
            turns.append(_rotation(frame.get("orientation", {})))
        return self._link(entry, places, turns)

    def _sensor(self, entry: dict[str, Any]) -> tuple[str, str, np.ndarray, np.ndarray, Place]:
        """Name, type, point, axes, and what carries it."""
        frame = entry.get("frame", {})
        place, turn = np.array(frame.get("position", (0, 0, 0)), dtype=float), _rotation(frame.get("orientation", {}))
        return entry["name"], entry["type"], *self._attached(entry["body"], frame.get("node", -1), place, turn)

    def _attached(self, body: str, node: int, at: np.ndarray, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray, Place]:
        """A point and axes on a body, one of its nodes or the ground: in W at the start, and what carries them."""
        if found := self.bodies.get(body):
            origin = found.position if node < 0 else found.nodes[node]
            return found.rotation @ at + origin, found.rotation @ axes, _place(found, node)
        if node < 0:
            return at, axes, Place()
        frame = self.moving[node]
        return frame.rotation @ at + frame.position, frame.rotation @ axes, Place(frame.name)

    def _follower(self, entry: dict[str, Any]) -> Follower:
        """What acts on a single body: a force that turns with it, or drag."""
        body = self.bodies[entry["body"]]
        node = entry.get("node", -1)
        place = body.position if node < 0 else body.nodes[node]
        point = place + body.rotation @ np.array(entry.get("point", (0, 0, 0)), dtype=float)
        body.ends.append(point)
        force, torque = (
            body.rotation @ np.array(entry.get(key, (0, 0, 0)), dtype=float) for key in ("force", "torque")
        )
        return Follower(entry["name"], _place(body, node), point, force, torque)

    def _link(self, entry: dict[str, Any], places: list[tuple[Any, int]], turns: list[np.ndarray]) -> Link:
        bodies = [self.bodies.get(name) for name in entry["bodies"]]
        ends = [
            self._attached(name, node, np.array(at, dtype=float), turn)
            for name, (at, node), turn in zip(entry["bodies"], places, turns, strict=True)
        ]
        points, axes, carriers = map(list, zip(*ends, strict=True))
        for body, point in zip(bodies, points, strict=True):
            if body is not None:
                body.ends.append(point)
        acting = np.array(entry.get("stiffness", 1.0), dtype=float) != 0
        acting |= np.array(entry.get("damping", 0.0), dtype=float) != 0
        radius = entry["radius"] if entry.get("type") == "rolling_disk" else 0.0
        stiff = np.broadcast_to(acting, 3)
        return Link(entry["name"], entry.get("type", ""), bodies, points, axes, carriers, stiff, radius)


def _place(body: Body, node: int) -> Place:
    """What carries a frame on a body or on one of its nodes."""
    return Place(body.name, () if node < 0 else (node,))


def _moving_frames(mechanism: dict[str, Any]) -> Iterator[MovingFrame]:
    text = json.dumps(mechanism) if mechanism.get("motions") else ""
    for i, entry in enumerate(mechanism.get("motions", [])):
        frame = MovingFrame(entry["name"], np.zeros(3), np.eye(3), text, i, entry.get("input", False))
        (frame.position,), quaternions = frame.poses(np.zeros(1), np.zeros((1, 6)))
        frame.rotation = _rotation({"quaternion": quaternions[0]})
        yield frame


def _body(entry: dict[str, Any], resources: Path) -> Body:
    position = np.array(entry.get("position", (0, 0, 0)), dtype=float)
    R = _rotation(entry.get("orientation", {}))
    spin = R @ np.array(entry.get("angular_velocity", (0, 0, 0)), dtype=float)
    if "flexible" in entry:
        data = json.loads((resources / entry["flexible"]["file"]).read_text(encoding="utf-8"))
        nodes = position + np.array(data["X"], dtype=float) @ R.T
        modes = np.einsum("ij,njf->nif", R, np.array(data.get("Phi", np.zeros((len(nodes), 3, 0))), dtype=float))
        return Body(entry["name"], position, R, nodes.mean(axis=0), 0.0, np.zeros((3, 3)), spin, nodes, modes)
    J = entry["inertia"]
    xy, xz, yz = (J.get(key, 0.0) for key in ("xy", "xz", "yz"))
    inertia = R @ np.array([[J["xx"], xy, xz], [xy, J["yy"], yz], [xz, yz, J["zz"]]]) @ R.T
    return Body(entry["name"], position, R, position, float(entry["mass"]), inertia, spin)


def _rotation(orientation: dict[str, Any]) -> np.ndarray:
    """Rotation matrix of what the file has: a matrix or a quaternion (w, x, y, z)."""
    if "matrix" in orientation:
        return np.array(orientation["matrix"], dtype=float)
    quaternion = np.array(orientation.get("quaternion", (1, 0, 0, 0)), dtype=float)
    w, *vector = quaternion / np.linalg.norm(quaternion)
    u = np.array(vector)
    return (w * w - u @ u) * np.eye(3) + 2 * np.outer(u, u) + 2 * w * np.cross(np.eye(3), u)
