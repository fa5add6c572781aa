"""Reads URDF as urdfdom does: http://wiki.ros.org/urdf/XML."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from sigmafmu.importers.inertia import Inertia, Pose
from sigmafmu.importers.meshes import Meshes
from sigmafmu.importers.robot import GROUND, Body, Coupling, Joint, Robot, Shape, start_within_limits
from sigmafmu.importers.shapes import shape_keys
from sigmafmu.importers.xml import Element, axes_with_z, color_of, pose_of_rpy
from sigmafmu.mechanism_file.kinds import nearest

TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "free",
    "planar": "planar",
}
"""Type of URDF → type of a mechanism file."""
HAS_AXIS = ("revolute", "continuous", "prismatic", "planar")
HAS_LIMITS = ("revolute", "prismatic")
WORLD = "world"
"""A root of this name is the ground."""


def read_urdf(root: Element, meshes: Meshes, base: str | None) -> Robot:
    """The robot of a file; `base` is `fixed` or `free` for its root, else it is fixed if it has no mass."""
    if any("xacro" in (node.prefix or "") for node in root.node.iter("*")):
        raise root.error("this is a xacro file; make URDF of it with xacro first")
    robot = Robot(root.get("name", root.path.stem), root.path.name)
    colors = {m.get("name", ""): color for m in root.children("material") if (color := _color(m, {}))}
    robot.bodies = _links(root, robot, meshes, colors)
    robot.joints = {}
    for element in root.children("joint"):
        joint = _joint(element, robot)
        if joint.name in robot.joints:
            raise element.error(f"the joint {joint.name} is there twice; names must differ")
        robot.joints[joint.name] = joint
    root_link = _root_of(root, robot)
    _in_order(root, robot, root_link)
    _mimics(root, robot)
    _place_root(robot, root_link, base)
    _floating(robot)
    _tell_rest(root, robot)
    for text in meshes.tell():
        robot.tell(text)
    return robot


def _origin(element: Element | None) -> Pose:
    origin = element.child("origin") if element is not None else None
    if origin is None:
        return Pose()
    return pose_of_rpy(origin.numbers("xyz", 3, "0 0 0"), origin.numbers("rpy", 3, "0 0 0"))


def _links(root: Element, robot: Robot, meshes: Meshes, colors: dict[str, str]) -> dict[str, Body]:
    bodies: dict[str, Body] = {}
    for element in root.children("link"):
        name = element.get("name")
        if name in bodies:
            raise element.error(f"the link {name} is there twice; names must differ")
        body = bodies[name] = Body(name)
        body.shapes = list(_shapes(element, robot, meshes, colors))
        if (inertial := element.child("inertial")) is not None:
            body.inertia, body.inertia_axes = _inertia(inertial)
            if body.inertia.mass == 0 and np.any(body.inertia.J):
                robot.tell(f"{name}: has an inertia without mass, which counts where it is fixed to another link")
    if not bodies:
        raise root.error("there is no link; a robot has at least one")
    return bodies


def _inertia(inertial: Element) -> tuple[Inertia, Pose | None]:
    """In the link's frame, and the axes in which it is given if they are others."""
    pose, mass, J = _origin(inertial), 0.0, np.zeros((3, 3))
    if (element := inertial.child("mass")) is not None:
        mass = element.number("value")
        if mass < 0:
            raise element.error(f"mass is {mass:g} kg; it must be at least 0")
    if (element := inertial.child("inertia")) is not None:
        for i, j, name in ((0, 0, "ixx"), (1, 1, "iyy"), (2, 2, "izz"), (0, 1, "ixy"), (0, 2, "ixz"), (1, 2, "iyz")):
            J[i, j] = J[j, i] = element.number(name, "0")
    turned = np.any(np.eye(3) != pose.R)
    return Inertia(mass, np.zeros(3), J).seen_from(pose), pose if turned else None


def _shapes(link: Element, robot: Robot, meshes: Meshes, colors: dict[str, str]) -> Iterator[Shape]:
    """What is seen; of a link without that, what it collides with."""
    for element in [*link.children("visual")] or [*link.children("collision")]:
        geometry = element.child("geometry")
        form = next(geometry.children(), None) if geometry is not None else None
        if form is None:
            continue
        uri = form.get("filename") if form.tag == "mesh" else ""
        keys = shape_keys(form, uri, Element.numbers, meshes, robot, link.get("name"))
        if keys is None:
            continue
        material = element.child("material")
        if material is not None and (color := _color(material, colors)):
            keys["color"] = color
        yield Shape(keys, _origin(element))


def _color(material: Element, known: dict[str, str]) -> str:
    if (color := material.child("color")) is not None:
        return color_of(color.numbers("rgba", 4))
    return known.get(material.get("name", ""), "")


def _joint(element: Element, robot: Robot) -> Joint:
    name, kind = element.get("name"), element.get("type")
    if kind not in TYPES:
        raise element.error(f"the type of joint {name} is {kind}; {nearest(kind, TYPES)}")
    bodies = []
    for tag in ("parent", "child"):
        end = element.child(tag)
        if end is None:
            raise element.error(f"joint {name} has no <{tag}>; it must have one")
        link = end.get("link")
        if link not in robot.bodies:
            raise end.error(f"joint {name}: there is no link {link}; {nearest(link, robot.bodies)}")
        bodies.append(link)
    pose, axes, comment = _origin(element), np.eye(3), ""
    if kind in HAS_AXIS:
        axis = np.array([1.0, 0.0, 0.0])
        if (given := element.child("axis")) is not None:
            axis = given.numbers("xyz", 3)
            if not np.linalg.norm(axis) > 1e-9:
                raise given.error(f"the axis of joint {name} is (0, 0, 0); it must have a length above 0")
        axes, comment = axes_with_z(axis), f"axis {_shown(axis)} of {bodies[1]}"
    joint = Joint(name, TYPES[kind], (bodies[0], bodies[1]), (pose @ Pose(R=axes), Pose(R=axes)), comment=comment)
    if kind in HAS_AXIS and kind != "planar":
        joint.keys = _acting(element, name, kind, robot)
    return joint


def _shown(axis: np.ndarray) -> str:
    return f"[{', '.join(f'{x:.6g}' for x in axis + 0.0)}]"


def _acting(element: Element, name: str, kind: str, robot: Robot) -> dict[str, Any]:
    """Damping, friction and limits."""
    keys: dict[str, Any] = {}
    if (dynamics := element.child("dynamics")) is not None:
        for key in ("damping", "friction"):
            value = dynamics.number(key, "0")
            if value < 0:
                raise dynamics.error(f"{key} of joint {name} is {value:g}; it must be at least 0")
            if value > 0:
                keys[key] = value
    limit = element.child("limit")
    if kind in HAS_LIMITS:
        if limit is None:
            raise element.error(f"joint {name} is {kind} and has no <limit>; it must have one, or be continuous")
        lower, upper = limit.number("lower", "0"), limit.number("upper", "0")
        if lower < upper:
            keys["limits"] = [lower, upper]
            start_within_limits(robot, name, keys)
        else:
            robot.tell(f"{name}: limits from {lower:g} to {upper:g} leave it no room")
    if limit is not None and (limit.number("effort", "0") > 0 or limit.number("velocity", "0") > 0):
        robot.tell("largest efforts and velocities of joints")
    return keys


def _root_of(root: Element, robot: Robot) -> str:
    """The only link without a parent."""
    carried: dict[str, str] = {}
    for joint in robot.joints.values():
        child = joint.bodies[1]
        if child in carried:
            raise root.error(f"the link {child} is the child of {carried[child]} and of {joint.name}; one may carry it")
        carried[child] = joint.name
    roots = [name for name in robot.bodies if name not in carried]
    if len(roots) != 1:
        text = f"the links {', '.join(roots[:5])} have no parent" if roots else "every link has a parent"
        raise root.error(f"{text}; exactly one must be the root")
    return roots[0]


def _in_order(root: Element, robot: Robot, root_link: str) -> None:
    """Joints and links from the root on: a loop of them would be left over."""
    by_parent: dict[str, list[Joint]] = {}
    for joint in robot.joints.values():
        by_parent.setdefault(joint.bodies[0], []).append(joint)
    ordered, stack = {}, list(reversed(by_parent.get(root_link, [])))
    while stack:
        joint = stack.pop()
        ordered[joint.name] = joint
        stack += reversed(by_parent.get(joint.bodies[1], []))
    left = [name for name in robot.joints if name not in ordered]
    if left:
        raise root.error(f"the joints {', '.join(left[:5])} carry each other in a ring; one link must be the root")
    robot.joints = ordered
    robot.bodies = {name: robot.bodies[name] for name in (root_link, *(j.bodies[1] for j in ordered.values()))}


def _mimics(root: Element, robot: Robot) -> None:
    for element in root.children("joint"):
        mimic = element.child("mimic")
        if mimic is None:
            continue
        name, leader = element.get("name"), mimic.get("joint")
        if leader not in robot.joints:
            robot.tell(f"{name}: mimics {leader}, which is none")
            continue
        polynomial = [mimic.number("offset", "0"), mimic.number("multiplier", "1")]
        robot.couplings.append(Coupling(f"{name}_mimic", "mimic", [name, leader], {"polynomial": polynomial}))


def _place_root(robot: Robot, name: str, base: str | None) -> None:
    """The root becomes the ground, or is free."""
    body = robot.bodies[name]
    if base == "free" or (base is None and name != WORLD and body.inertia.mass > 0):
        body.start = Pose()
        if base is None:
            robot.tell(f"{name}: the root, has mass and is free; --base fixed ties it to the ground")
        return
    if base is None and name != WORLD:
        robot.tell(f"{name}: the root, has no mass and is the ground; --base free lets it move")
    joint = Joint("\0root", "fixed", (GROUND, name), (Pose(), Pose()))
    robot.joints = {joint.name: joint} | robot.joints


def _floating(robot: Robot) -> None:
    """A floating joint at a root that is the ground leaves its link free: it needs no joint."""
    ground = {joint.bodies[1] for joint in robot.joints.values() if joint.name == "\0root"} | {GROUND}
    for joint in [joint for joint in robot.joints.values() if joint.type == "free"]:
        if joint.bodies[0] in ground:
            robot.bodies[joint.bodies[1]].start = joint.frames[0] @ joint.frames[1].inverse()
            del robot.joints[joint.name]


def _tell_rest(root: Element, robot: Robot) -> None:
    """What a mechanism file has nothing for."""
    if any(link.child("collision") is not None for link in root.children("link")):
        robot.tell("shapes for collision")
    for tag, what in (
        ("transmission", "transmissions: every hinge and slide has an input for its motor"),
        ("gazebo", "elements for Gazebo"),
    ):
        if root.child(tag) is not None:
            robot.tell(what)
    for tag in ("safety_controller", "calibration"):
        if any(joint.child(tag) is not None for joint in root.children("joint")):
            robot.tell(f"{tag.replace('_', ' ')}s of joints")
