"""Our trees of bodies on balls, hinges and slides in MuJoCo and Pinocchio, which know joint coordinates alone.

All joint coordinates are zero at the start.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from sigmafmu import SigmafmuError, _core

if TYPE_CHECKING:
    import mujoco
    import pinocchio

REVOLUTE, SPHERICAL = _core.JointType.revolute, _core.JointType.spherical
PRISMATIC = _core.JointType.prismatic


@dataclass(frozen=True)
class Link:
    """A body and what holds it; points and axes in the body's frame unless told otherwise."""

    name: str
    mass: float
    inertia: np.ndarray  # 3 x 3, about the center of mass
    parent: int  # -1: the ground
    kind: _core.JointType | None  # None: free
    point: np.ndarray  # of the joint
    axis: np.ndarray  # of a hinge, along a slide
    position: np.ndarray  # of the center of mass, in W
    rotation: np.ndarray  # R_WB
    rates: np.ndarray  # of the joint's coordinates; of a free body velocity in W, then angular velocity


def links(definition: _core.Multibody) -> list[Link]:
    """SigmafmuError: the definition is no such tree, or a joint's second body does not come after its first."""
    poses, velocities = (x.reshape(len(definition.bodies), -1) for x in _core.assemble(definition))
    joints = {joint.body2: joint for joint in definition.joints}
    if len(joints) < len(definition.joints) or _core.GROUND in joints:
        raise SigmafmuError("a body is the second one of two joints, or the ground is; that makes no tree")
    result = []
    for i, (body, pose, v) in enumerate(zip(definition.bodies, poses, velocities, strict=True)):
        R = Rotation.from_quat(pose[3:], scalar_first=True).as_matrix()
        inertia = np.diag(body.inertia)
        inertia[np.triu_indices(3, 1)] = inertia.T[np.triu_indices(3, 1)] = body.inertia_products
        joint = joints.get(i)
        if joint is None:
            parent, kind, point, axis, rates = -1, None, np.zeros(3), np.zeros(3), v
        else:
            if joint.body1 >= i or joint.type not in (REVOLUTE, SPHERICAL, PRISMATIC):
                raise SigmafmuError(
                    f"joint {joint.name} is not a spherical, revolute or prismatic one from a body before"
                )
            parent, kind, point, axis = joint.body1, joint.type, joint.frame2.origin, joint.frame2.axes[:, 2]
            before = result[parent].rotation @ velocities[parent, 3:] if parent >= 0 else np.zeros(3)
            spin = v[3:] - R.T @ before
            rates = spin if kind == SPHERICAL else np.array([axis @ spin])
            if kind == PRISMATIC:
                carried = velocities[parent, :3] + np.cross(before, pose[:3] - result[parent].position)
                rates = np.array([axis @ (R.T @ (v[:3] - (carried if parent >= 0 else 0.0)))])
        result.append(Link(body.name, body.mass, inertia, parent, kind, point, axis, pose[:3], R, rates))
    return result


def text(x: Iterable[float]) -> str:
    """Numbers as attributes have them, exactly."""
    return " ".join(repr(float(value)) for value in x)


def mujoco_tree(definition: _core.Multibody, tree: list[Link]) -> ElementTree.Element:
    """The XML of MuJoCo's model, whose bodies have our names, hinges and balls those of the bodies they carry."""
    root = ElementTree.Element("mujoco")
    ElementTree.SubElement(root, "compiler", angle="radian")
    ElementTree.SubElement(root, "option", gravity=text(definition.gravity))
    elements = [ElementTree.SubElement(root, "worldbody")]
    for link in tree:
        R, origin = (tree[link.parent].rotation, tree[link.parent].position) if link.parent >= 0 else (np.eye(3), 0.0)
        turn = Rotation.from_matrix(R.T @ link.rotation).as_quat(scalar_first=True)
        place = {"pos": text(R.T @ (link.position - origin)), "quat": text(turn)}
        body = ElementTree.SubElement(elements[link.parent + 1], "body", name=link.name, **place)
        full = text(np.concatenate([np.diag(link.inertia), link.inertia[np.triu_indices(3, 1)]]))
        ElementTree.SubElement(body, "inertial", pos="0 0 0", mass=repr(link.mass), fullinertia=full)
        if link.kind is None:
            ElementTree.SubElement(body, "freejoint")
        elif link.kind == SPHERICAL:
            ElementTree.SubElement(body, "joint", name=link.name, type="ball", pos=text(link.point))
        else:
            kind = "hinge" if link.kind == REVOLUTE else "slide"
            place = {"name": link.name, "type": kind, "pos": text(link.point), "axis": text(link.axis)}
            ElementTree.SubElement(body, "joint", place)
        elements.append(body)
    return root


def mujoco_model(
    definition: _core.Multibody, edit: Callable[[ElementTree.Element], None] = lambda _: None
) -> tuple[mujoco.MjModel, np.ndarray]:
    """MuJoCo's model without contacts, its XML changed by `edit`, and the initial joint rates."""
    import mujoco as mj

    tree = links(definition)
    root = mujoco_tree(definition, tree)
    edit(root)
    model = mj.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    order = [mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, link.name) for link in tree]
    rates = np.zeros(model.nv)
    for number, link in zip(order, tree, strict=True):
        first = model.body_dofadr[number]
        rates[first : first + len(link.rates)] = link.rates
    return model, rates


def pinocchio_model(definition: _core.Multibody) -> tuple[pinocchio.Model, np.ndarray]:
    """Pinocchio's model, and the initial joint rates; joint i + 1 carries body i."""
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = definition.gravity
    places, rates = [pin.SE3.Identity()], []
    for link in links(definition):
        here = pin.SE3(link.rotation, link.position + link.rotation @ link.point)
        if link.kind is None:
            joint = pin.JointModelFreeFlyer()
            rates.append(np.concatenate([link.rotation.T @ link.rates[:3], link.rates[3:]]))
        else:
            joint = {
                SPHERICAL: lambda _: pin.JointModelSpherical(),
                REVOLUTE: pin.JointModelRevoluteUnaligned,
                PRISMATIC: pin.JointModelPrismaticUnaligned,
            }[link.kind](link.axis)
            rates.append(link.rates)
        number = model.addJoint(link.parent + 1, joint, places[link.parent + 1].actInv(here), link.name)
        model.appendBodyToJoint(number, pin.Inertia(link.mass, -link.point, link.inertia), pin.SE3.Identity())
        places.append(here)
    v = np.zeros(model.nv)
    for joint, values in zip(list(model.joints)[1:], rates, strict=True):
        v[joint.idx_v : joint.idx_v + joint.nv] = values
    return model, v
