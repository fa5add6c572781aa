"""Where bodies are and how they move at the start: as the file says, by the joints that hold them, or at the origin."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.structures import Record
from sigmafmu.mechanism_file.table.ends import GROUND
from sigmafmu.mechanism_file.table.joints import JOINT_TYPES

ZERO = np.zeros(3)


@dataclass
class Pose:
    """A body at the start. Its frame in the file has the same axes, with the centre of mass at `offset`."""

    quaternion: np.ndarray = field(default_factory=rotations.IDENTITY.copy)
    """Of R_WB."""
    position: np.ndarray = field(default_factory=ZERO.copy)
    """Of the centre of mass in W [m]; of a flexible body: of its frame."""
    velocity: np.ndarray = field(default_factory=ZERO.copy)
    """Of the same point, in W [m/s]."""
    angular_velocity: np.ndarray = field(default_factory=ZERO.copy)
    """In the body's axes [rad/s]."""
    offset: np.ndarray = field(default_factory=ZERO.copy)
    """Of the centre of mass in the body's frame of the file [m]."""
    nodes: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    """Of a flexible body, in its frame [m]."""
    placed_by: str = ""
    """A joint; empty: by the file, or at the origin."""

    @property
    def R(self) -> np.ndarray:
        """R_WB."""
        return rotations.matrix(self.quaternion)

    @property
    def spin(self) -> np.ndarray:
        """Angular velocity in W [rad/s]."""
        return self.R @ self.angular_velocity

    def velocity_at(self, point: np.ndarray) -> np.ndarray:
        """Of the body's point that is at `point` of W [m/s]."""
        return self.velocity + np.cross(self.spin, point - self.position)

    def to_body(self, point: np.ndarray) -> np.ndarray:
        """A point of W from the centre of mass, in the body's axes [m]."""
        return self.R.T @ (point - self.position)


@dataclass(frozen=True)
class Frame:
    """A frame of a body, in its axes."""

    origin: np.ndarray
    """From the centre of mass, or from the node that the frame belongs to [m]."""
    axes: np.ndarray
    node: int | None
    place: np.ndarray
    """From the centre of mass, of an undeformed body; on the ground in W, where motions are zero [m]."""
    directions: np.ndarray
    """Axes, where `place` is."""


def frame_in_body(frame: Mapping | None, pose: Pose) -> Frame:
    """A frame that the file gives in the body's frame."""
    frame = frame or {}
    origin, node = np.array(frame.get("position", ZERO)), frame.get("node")
    axes = rotations.matrix(rotations.of_orientation(frame.get("orientation")))
    if node is None:
        origin = origin - pose.offset
        return Frame(origin, axes, None, origin, axes)
    return Frame(origin, axes, node, origin + (pose.nodes[node] if node < len(pose.nodes) else ZERO), axes)


def motion(kind: str, x: list[float], rate: list[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of frame 2 from frame 1 with coordinates x: rotation matrix, displacement, angular velocity, velocity.

    The last three are in the axes of frame 1. What a joint leaves free without a coordinate is zero.
    """
    turn, shift, spin, velocity = np.eye(3), ZERO.copy(), ZERO.copy(), ZERO.copy()
    for c, value, change in zip(JOINT_TYPES[kind].coordinates, x, rate, strict=True):
        axis = np.eye(3)[c.axis]
        if c.turns:
            spin = spin + change * turn @ axis
            turn = turn @ rotations.matrix(rotations.of_vector(value * axis))
        else:
            shift, velocity = shift + value * axis, velocity + change * axis
    return turn, shift, spin, velocity


def coordinates(joint: Record) -> tuple[list[float], list[float]]:
    """Coordinates and rates at the start, zero where the file has none."""
    kinds = JOINT_TYPES[joint["type"]].coordinates
    x, rates = ([joint.get(c.key(word)) for c in kinds] for word in ("coordinate", "rate"))
    if "pitch" in joint:  # a screw turns and moves together
        lead = joint["pitch"] / (2 * np.pi)
        x, rates = (_on_thread(lead, *pair) for pair in (x, rates))
    return [value or 0.0 for value in x], [value or 0.0 for value in rates]


def _on_thread(lead: float, angle: float | None, displacement: float | None) -> list[float | None]:
    """What is not said of angle and displacement follows from the other; `lead` in m/rad."""
    if angle is None and displacement is not None:
        return [displacement / lead, displacement]
    if displacement is None and angle is not None:
        return [angle, lead * angle]
    return [angle, displacement]


def _places(joint: Record) -> bool:
    """Whether it says where one body is to the other."""
    return JOINT_TYPES[joint["type"]].places and ("frame1" in joint or "frame2" in joint)


class Placement:
    """Poses of all bodies by their names, the ground among them."""

    def __init__(
        self,
        bodies: Mapping[str, Record],
        joints: Mapping[str, Record],
        nodes: Mapping[str, np.ndarray],
        motions: Mapping[str, Record],
    ):
        self.poses = {GROUND: Pose()}
        self._bodies, self._nodes, self._motions = bodies, nodes, motions
        # those that place a body: joints with frames; geometry in W says nothing of where bodies are
        by_frames = [(name, joint) for name, joint in joints.items() if _places(joint)]
        for name, body in bodies.items():
            if "position" in body:
                self._begin(name, body)
        # nothing holds these to what is placed, but they may hold others: first those that are drawn in W
        drawn = {body for joint in joints.values() if not _places(joint) for body in joint["bodies"]}
        for name in sorted(bodies, key=lambda name: name not in drawn):
            self._hang(by_frames)
            if name not in self.poses:
                self._begin(name, bodies[name])

    def __getitem__(self, body: str) -> Pose:
        return self.poses[body]

    def frame(self, body: str, frame: Mapping | None) -> Frame:
        """A frame that the file gives in a body."""
        found = frame_in_body(frame, self.poses[body])
        if not frame or "motion" not in frame:
            return found
        motion = self._motions[frame["motion"]]  # a node of the ground
        R = rotations.matrix(rotations.of_orientation(motion.get("orientation")))
        place = np.array(motion.get("position", ZERO)) + R @ found.origin
        return replace(found, node=list(self._motions).index(frame["motion"]), place=place, directions=R @ found.axes)

    def _begin(self, name: str, body: Record) -> None:
        """A body where the file says, or at the origin of W."""
        pose = self._start(name)
        pose.position = np.array(body.get("position", ZERO)) + pose.R @ pose.offset
        pose.velocity = np.array(body.get("velocity", ZERO))
        pose.angular_velocity = np.array(body.get("angular_velocity", ZERO))
        self.poses[name] = pose

    def _hang(self, joints: list[tuple[str, Record]]) -> None:
        """Bodies on those that are placed, by the first joint in the file's order, until no joint does."""
        while True:
            # those between placed bodies have nothing to place
            joints[:] = [entry for entry in joints if not all(body in self.poses for body in entry[1]["bodies"])]
            placing = next((entry for entry in joints if any(body in self.poses for body in entry[1]["bodies"])), None)
            if placing is None:
                return
            name, joint = placing
            self._place(name, joint, forward=joint["bodies"][0] in self.poses)

    def _place(self, name: str, joint: Record, *, forward: bool) -> None:
        """The second body on the first, or the first on the second."""
        parent, child = joint["bodies"] if forward else reversed(joint["bodies"])
        body, known = self._bodies[child], self.poses[parent]
        pose = self._start(child)
        pose.placed_by = name
        keys = ("frame1", "frame2") if forward else ("frame2", "frame1")
        on_known, on_new = self.frame(parent, joint.get(keys[0])), frame_in_body(joint.get(keys[1]), pose)
        turn, shift, spin, velocity = motion(joint["type"], *coordinates(joint))

        known_axes, known_origin = known.R @ on_known.directions, known.position + known.R @ on_known.place
        first_axes = known_axes if forward else known_axes @ turn.T  # of frame 1, in W
        new_axes = known_axes @ turn if forward else first_axes
        new_origin = known_origin + first_axes @ shift if forward else known_origin - first_axes @ shift
        if "orientation" not in body:
            pose.quaternion = rotations.quaternion(new_axes @ on_new.axes.T)
        pose.position = new_origin - pose.R @ on_new.place

        # w2 = w1 + spin, v2 = v1 + w1 x (origin 2 - origin 1) + velocity, from the known side to the new one
        sign = 1 if forward else -1
        pose.angular_velocity = pose.R.T @ (known.spin + sign * first_axes @ spin)
        if "angular_velocity" in body:
            pose.angular_velocity = np.array(body["angular_velocity"])
        first = known if forward else pose
        at_origin = known.velocity_at(known_origin) + np.cross(first.spin, new_origin - known_origin)
        at_origin = at_origin + sign * first_axes @ velocity
        pose.velocity = at_origin + np.cross(pose.spin, pose.position - new_origin)
        if "velocity" in body:
            pose.velocity = np.array(body["velocity"])
        self.poses[child] = pose

    def _start(self, name: str) -> Pose:
        """A body's pose before anything is known but its own data."""
        body = self._bodies[name]
        nodes = self._nodes.get(name, np.zeros((0, 3)))
        offset = np.array(body.get("center_of_mass", ZERO))
        return Pose(rotations.of_orientation(body.get("orientation")), offset=offset, nodes=nodes)
