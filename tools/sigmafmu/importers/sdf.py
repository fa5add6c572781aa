"""Reads SDF: http://sdformat.org/spec. A link with two parents closes a loop, which stays one."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from sigmafmu.importers.inertia import Inertia, Pose
from sigmafmu.importers.meshes import Meshes
from sigmafmu.importers.robot import GROUND, Body, Coupling, Joint, Robot, Shape, start_within_limits
from sigmafmu.importers.shapes import shape_keys
from sigmafmu.importers.xml import Element, axes_with_z, color_of, pose_of_rpy
from sigmafmu.mechanism_file import rotations
from sigmafmu.mechanism_file.kinds import nearest

WORLD, MODEL = "world", "__model__"
TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "ball": "spherical",
    "universal": "universal",
    "screw": "cylindrical",
}
"""Type of SDF → type of a mechanism file."""
UNLIMITED = 1e15
"""Limits of SDF that are none."""


def read_sdf(root: Element, meshes: Meshes) -> Robot:
    """The robot of a file with one model, alone or in a world."""
    world = root.child("world")
    models = [*root.children("model"), *(world.children("model") if world else ())]
    moving = [model for model in models if not _is_true(model, "static")] or models
    if len(moving) != 1:
        raise root.error(f"there are {len(moving)} models that may move; it must be one")
    robot = Robot(moving[0].get("name"), root.path.name)
    if world is not None:
        if (gravity := world.child("gravity")) is not None:
            robot.gravity = gravity.parsed(gravity.text(), 3, "gravity").tolist()
        physics = world.child("physics")
        if physics is not None and (step := physics.child("max_step_size")) is not None:
            robot.step_size = float(step.parsed(step.text(), 1, "max_step_size")[0])
    _Model(moving[0], robot, meshes).read()
    if len(models) > 1:
        robot.tell(f"static models: {', '.join(model.get('name') for model in models if model is not moving[0])}")
    for text in meshes.tell():
        robot.tell(text)
    return robot


def _is_true(element: Element, tag: str) -> bool:
    child = element.child(tag)
    return child is not None and child.text() in ("1", "true")


def _value(element: Element, tag: str, count: int, default: str) -> np.ndarray:
    """Numbers of an element below."""
    child = element.child(tag)
    return (child or element).parsed(child.text() if child is not None else default, count, f"<{tag}>")


class _Model:
    """A model while it is read: its frames by their names, each in that to which it is relative."""

    def __init__(self, element: Element, robot: Robot, meshes: Meshes):
        self.element, self.robot, self.meshes = element, robot, meshes
        self.links: dict[str, Element] = {}
        self.frames: dict[str, tuple[str, Pose, Element]] = {}

    def read(self) -> None:
        """Everything."""
        place = _pose(self.element)[1]
        for tag in ("link", "frame", "joint"):
            for element in self.element.children(tag):
                name = element.get("name")
                if name in self.frames:
                    raise element.error(f"the name {name} is there twice; names must differ")
                relative, pose = _pose(element)
                default = {"frame": element.node.get("attached_to") or MODEL, "link": MODEL}
                if tag == "joint":
                    default["joint"] = self._end(element, "child")
                self.frames[name] = (relative or default[tag], pose, element)
                if tag == "link":
                    self.links[name] = element
        if not self.links:
            raise self.element.error("there is no link; a model has at least one")
        for name, element in self.links.items():
            self.robot.bodies[name] = self._link(name, element)
        self._tree([self._joint(element) for element in self.element.children("joint") if self._known(element)], place)
        self._mimics()
        for tag, what in (("plugin", "plugins"), ("include", "included models"), ("model", "models inside the model")):
            if self.element.child(tag) is not None:
                self.robot.tell(what)
        if any(link.child("sensor") is not None for link in self.links.values()):
            self.robot.tell("sensors")
        if any(link.child("collision") is not None for link in self.links.values()):
            self.robot.tell("shapes for collision")

    def _end(self, joint: Element, tag: str) -> str:
        end = joint.child(tag)
        if end is None:
            raise joint.error(f"joint {joint.get('name')} has no <{tag}>; it must have one")
        return end.text()

    def _in_model(self, name: str, element: Element) -> Pose:
        """A frame's pose in the model's frame."""
        pose, seen = Pose(), {MODEL}
        while name != MODEL:
            if name not in self.frames:
                raise element.error(f"there is no frame {name}; {nearest(name, self.frames)}")
            if name in seen:
                raise element.error(f"the frame {name} is relative to itself; frames must end at the model")
            seen.add(name)
            name, relative, element = self.frames[name]
            pose = relative @ pose
        return pose

    def _link_of(self, name: str, element: Element) -> str:
        """The link to which a frame is attached; empty: the world."""
        seen: set[str] = set()
        while name != WORLD and name not in self.links:
            if name not in self.frames or name in seen:
                raise element.error(f"there is no link {name}; {nearest(name, self.links)}")
            seen.add(name)
            at = self.frames[name][2]
            name = self._end(at, "child") if at.tag == "joint" else at.get("attached_to", next(iter(self.links)))
        return "" if name == WORLD else name

    def _link(self, name: str, element: Element) -> Body:
        body = Body(name)
        mass, J, pose = 1.0, np.eye(3), Pose()  # what SDF says of a link without them
        if (inertial := element.child("inertial")) is not None:
            pose = _pose(inertial)[1]
            mass = float(_value(inertial, "mass", 1, "1")[0])
            if (inertia := inertial.child("inertia")) is not None:
                for i, j, tag in (
                    (0, 0, "ixx"),
                    (1, 1, "iyy"),
                    (2, 2, "izz"),
                    (0, 1, "ixy"),
                    (0, 2, "ixz"),
                    (1, 2, "iyz"),
                ):
                    J[i, j] = J[j, i] = _value(inertia, tag, 1, "1" if i == j else "0")[0]
        else:
            self.robot.tell(f"{name}: says no mass; SDF gives it 1 kg and moments of 1 kg m²")
        body.inertia = Inertia(mass, np.zeros(3), J).seen_from(pose)
        body.inertia_axes = pose if np.any(np.eye(3) != pose.R) else None
        body.shapes = list(self._shapes(element))
        return body

    def _shapes(self, link: Element) -> Iterator[Shape]:
        """What is seen; of a link without that, what it collides with."""
        for element in [*link.children("visual")] or [*link.children("collision")]:
            geometry = element.child("geometry")
            form = next(geometry.children(), None) if geometry is not None else None
            if form is None:
                continue
            uri = form.child("uri") if form.tag == "mesh" else None
            keys = shape_keys(form, uri.text() if uri else "", _value, self.meshes, self.robot, link.get("name"))
            if keys is None:
                continue
            material = element.child("material")
            if material is not None and (color := material.child("diffuse")) is not None:
                keys["color"] = color_of(color.parsed(color.text(), 4, "<diffuse>"))
            yield Shape(keys, _pose(element)[1])

    def _known(self, element: Element) -> bool:
        """Whether there is a joint for it; a wrong type is an error."""
        name, kind = element.get("name"), element.get("type")
        if kind in TYPES and not (kind == "screw" and element.child("screw_thread_pitch") is None):
            return True
        if kind not in (*TYPES, "gearbox", "revolute2"):
            raise element.error(f"the type of joint {name} is {kind}; {nearest(kind, TYPES)}")
        self.robot.tell(f"{name}: a joint of the kind {kind}")
        return False

    def _joint(self, element: Element) -> Joint:
        name, kind = element.get("name"), element.get("type")
        ends = [self._link_of(self._end(element, tag), element) for tag in ("parent", "child")]
        if ends[0] == ends[1]:
            raise element.error(f"joint {name} has {ends[0] or WORLD} on both sides; they must differ")
        at = self._in_model(name, element)
        axes, comment, keys = np.eye(3), "", {}
        if TYPES[kind] not in ("fixed", "spherical"):
            axes = self._axes(element, kind, at)
            axis = at.R.T @ axes[:, 1 if kind == "universal" else 2]
            comment = f"axis [{', '.join(f'{x:.6g}' for x in axis + 0.0)}] of the joint"
            for tag, number in (("axis", "1"), ("axis2", "2")) if kind == "universal" else (("axis", ""),):
                keys |= {key + number: value for key, value in self._acting(element.child(tag), name, kind).items()}
        frame = Pose(at.p, axes)
        frames = [self._in_model(end, element).inverse() @ frame if end else frame for end in ends]
        if kind == "screw":
            pitch = float(_value(element, "screw_thread_pitch", 1, "0")[0]) / (2 * math.pi)
            joints = [f"{name}\0angle", f"{name}\0displacement"]
            self.robot.couplings.append(Coupling(f"{name}_thread", "rack_and_pinion", joints, {"radius": pitch}))
        return Joint(name, TYPES[kind], (ends[0] or GROUND, ends[1] or GROUND), (frames[0], frames[1]), keys, comment)

    def _axes(self, element: Element, kind: str, at: Pose) -> np.ndarray:
        """Of a joint, in the model's axes: z is the axis; of a universal joint y is the first and x the second."""
        found = []
        for tag in ("axis", "axis2") if kind == "universal" else ("axis",):
            axis = element.child(tag)
            if axis is None:
                raise element.error(f"joint {element.get('name')} has no <{tag}>; it must have one")
            xyz, frame = axis.child("xyz"), at
            value = xyz.parsed(xyz.text(), 3, "<xyz>") if xyz is not None else np.array([0.0, 0.0, 1.0])
            if xyz is not None and (expressed := xyz.get("expressed_in", "")):
                frame = self._in_model(expressed, xyz)
            if not np.linalg.norm(value) > 1e-9:
                raise axis.error(f"the axis of joint {element.get('name')} is (0, 0, 0); it must have a length above 0")
            found.append(frame.R @ value / np.linalg.norm(value))
        if kind != "universal":
            return at.R @ axes_with_z(at.R.T @ found[0])
        y, x = found
        if abs(x @ y) > 1e-6:
            raise element.error(f"the axes of joint {element.get('name')} are not perpendicular; they must be")
        x = x - (x @ y) * y
        x /= np.linalg.norm(x)
        return np.column_stack([x, y, np.cross(x, y)])

    def _acting(self, axis: Element | None, name: str, kind: str) -> dict[str, Any]:
        """Springs, dampers, friction and limits of an axis."""
        keys: dict[str, Any] = {}
        if axis is None:
            return keys
        if (dynamics := axis.child("dynamics")) is not None:
            names = {"damping": "damping", "friction": "friction", "spring_stiffness": "stiffness"}
            for tag, key in names.items():
                if value := float(_value(dynamics, tag, 1, "0")[0]):
                    keys[key] = value
            if "stiffness" in keys and (rest := float(_value(dynamics, "spring_reference", 1, "0")[0])):
                keys["rest"] = rest
        if (limit := axis.child("limit")) is not None and kind != "continuous":
            low, high = (_limit(limit, tag, sign) for tag, sign in (("lower", -1), ("upper", 1)))
            if not low < high:
                self.robot.tell(f"{name}: limits from {low:g} to {high:g} leave it no room")
            elif max(-low, high) < UNLIMITED:
                keys["limits"] = [low, high]
                start_within_limits(self.robot, name, keys)
            elif min(-low, high) < UNLIMITED:
                self.robot.tell("limits of one side")
            if limit.child("effort") is not None or limit.child("velocity") is not None:
                self.robot.tell("largest efforts and velocities of joints")
        return keys

    def _tree(self, joints: list[Joint], place: Pose) -> None:
        """Joints carry links from the roots on; what comes to a link that is carried closes a loop."""
        carried = {joint.bodies[1] for joint in joints}
        roots = [name for name in self.links if name not in carried] or [next(iter(self.links))]
        reached, left = {GROUND, *roots}, list(joints)
        ordered: list[Joint] = []
        while left:
            following = next((joint for joint in left if joint.bodies[0] in reached), left[0])
            left.remove(following)
            if following.bodies[0] not in reached:  # a ring that hangs on nothing
                roots.append(following.bodies[0])
                reached.add(following.bodies[0])
            following.closes = following.bodies[1] in reached
            reached.add(following.bodies[1])
            ordered.append(following)
        self.robot.joints = {j.name: j for j in sorted(ordered, key=lambda joint: joint.closes)}
        for name in roots:
            self.robot.bodies[name].start = place @ self._in_model(name, self.links[name])
        on_ground = [joint for joint in self.robot.joints.values() if GROUND in joint.bodies]
        for joint in on_ground:  # frames of the world, where the model is
            joint.frames = tuple(  # type: ignore[assignment]
                place @ frame if body == GROUND else frame
                for body, frame in zip(joint.bodies, joint.frames, strict=True)
            )

    def _mimics(self) -> None:
        for element in self.element.children("joint"):
            axis = element.child("axis")
            mimic = axis.child("mimic") if axis is not None else None
            if mimic is None:
                continue
            name, leader = element.get("name"), mimic.get("joint")
            if leader not in self.robot.joints or name not in self.robot.joints:
                raise mimic.error(f"joint {name} mimics {leader}, which is none; {nearest(leader, self.robot.joints)}")
            factor, offset, reference = (
                float(_value(mimic, t, 1, d)[0]) for t, d in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
            )
            polynomial = [offset - factor * reference, factor]
            self.robot.couplings.append(Coupling(f"{name}_mimic", "mimic", [name, leader], {"polynomial": polynomial}))


def _limit(limit: Element, tag: str, sign: int) -> float:
    child = limit.child(tag)
    text = child.text() if child is not None else ""
    if not text or "inf" in text.lower():
        return sign * 2 * UNLIMITED
    return float(limit.parsed(text, 1, f"<{tag}>")[0])


def _pose(element: Element) -> tuple[str, Pose]:
    """To what a pose is relative, and the pose; without one it is none."""
    pose = element.child("pose")
    if pose is None or not pose.text():
        return (pose.get("relative_to", "") if pose is not None else ""), Pose()
    relative = pose.get("relative_to", "")
    if pose.get("rotation_format", "euler_rpy") == "quat_xyzw":
        x = pose.parsed(pose.text(), 7, "<pose>")
        q = x[[6, 3, 4, 5]]
        if not np.linalg.norm(q) > 1e-6:
            raise pose.error("the quaternion of <pose> is zero; its length must be 1")
        return relative, Pose(x[:3], rotations.matrix(q / np.linalg.norm(q)))
    x = pose.parsed(pose.text(), 6, "<pose>")
    rpy = np.radians(x[3:]) if pose.get("degrees", "false") in ("1", "true") else x[3:]
    return relative, pose_of_rpy(x[:3], rpy)
