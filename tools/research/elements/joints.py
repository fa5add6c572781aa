"""Joints, what acts on their coordinates and couplings beside those of Exudyn and MuJoCo."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from research.bench.trees import mujoco_model, text
from research.elements import Case, Peer
from research.elements.parts import AXES, add_first, frame_in, frame_markers, mechanism
from research.mechanisms.parts import GROUND, add_body, add_joint
from research.reference.exudyn_models import Model
from sigmafmu import _core

Type = _core.JointType
PLACE = np.array([0.3, 0.0, 0.1])
"""Of a joint's frame 1, in W."""
EXUDYN_AXES = {
    Type.spherical: [1, 1, 1, 0, 0, 0],
    Type.revolute: [1, 1, 1, 1, 1, 0],
    Type.prismatic: [1, 1, 0, 1, 1, 1],
    Type.cylindrical: [1, 1, 0, 1, 1, 0],
    Type.planar: [0, 0, 1, 1, 1, 0],
    Type.point_on_line: [1, 1, 0, 0, 0, 0],
}
"""What a generic joint of Exudyn holds: displacements along and rotations about the axes of its first marker."""
MUJOCO_JOINTS = {
    Type.spherical: (("ball", None),),
    Type.revolute: (("hinge", 2),),
    Type.universal: (("hinge", 1), ("hinge", 0)),
    Type.prismatic: (("slide", 2),),
    Type.cylindrical: (("slide", 2), ("hinge", 2)),
    Type.planar: (("slide", 0), ("slide", 1), ("hinge", 2)),
    Type.point_on_line: (("slide", 2), ("ball", None)),
}
"""Of a body on the ground, from the ground on: type, and axis of the joint's frame."""


def on_joint(kind: _core.JointType) -> _core.Mechanism:
    """A body on the ground that moves in the joint, its velocity what the joint leaves of an arbitrary one."""
    m = mechanism()
    body = add_first(m)
    sides = []
    for number in (GROUND, body):
        sides += [number, frame_in(m.multibody, number, PLACE, AXES)]
    if kind == Type.distance:  # a rod of 0.5 m
        sides[1] = _core.Frame(PLACE + 0.5 * AXES[:, 0], AXES)
    m.multibody.add(_core.Joint("joint", kind, *sides))
    return m


def _exudyn_joint(model: Model, d: _core.Multibody) -> None:
    (joint,) = d.joints
    markers, items = frame_markers(model, joint), model.exu.itemInterface
    if joint.type == Type.distance:
        model.mbs.AddObject(items.ObjectConnectorDistance(markerNumbers=markers, distance=0.5))
    elif joint.type == Type.universal:
        # Its third rotation, held alone, makes x of the first marker perpendicular to y of the second
        model.joint(markers[1], markers[0], [1, 1, 1, 0, 0, 1])
    else:
        model.joint(*markers, EXUDYN_AXES[joint.type])


def _mujoco_joint(d: _core.Multibody) -> Any:
    import mujoco as mj

    (joint,) = d.joints
    (body,) = d.bodies
    q, v = _core.assemble(d)
    turn = Rotation.from_quat(q[3:], scalar_first=True)
    root = ElementTree.Element("mujoco")
    ElementTree.SubElement(root, "option", gravity=text(d.gravity))
    world = ElementTree.SubElement(root, "worldbody")
    element = ElementTree.SubElement(world, "body", name=body.name, pos=text(q[:3]), quat=text(q[3:]))
    ElementTree.SubElement(element, "inertial", pos="0 0 0", mass=repr(body.mass), diaginertia=text(body.inertia))
    system, rates = _core.System(d), []
    found: dict[str, list[float]] = {"hinge": [], "slide": []}
    for k, turns in enumerate(system.kinds_of_coordinates()[0]):
        found["hinge" if turns else "slide"].append(system.coordinate(q, v, 0, k)[1])
    for kind, axis in MUJOCO_JOINTS[joint.type]:
        place = {"type": kind, "pos": text(joint.frame2.origin)}
        if kind == "ball":
            rates += [*v[3:]]
        else:
            place["axis"] = text(turn.inv().apply(joint.frame1.axes[:, axis]))
            rates.append(found[kind].pop(0))
        ElementTree.SubElement(element, "joint", place)
    return mj.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode")), np.array(rates)


DISK_RADIUS = 0.3


def rolling_disk() -> _core.Mechanism:
    """A disk about x of its body that leans and rolls on the ground."""
    m = mechanism()
    turn = Rotation.from_euler("ZY", [0.4, 0.3])
    spin = np.array([6.0, 0.5, 1.5])
    place = np.array([0.1, -0.2, DISK_RADIUS * np.cos(0.3)])
    velocity = np.cross(turn.apply(spin), turn.apply([0, 0, DISK_RADIUS]))
    body = add_body(m.multibody, "a", 2.0, np.array([0.09, 0.05, 0.05]), place, turn, velocity, spin)
    across = Rotation.from_euler("y", np.pi / 2).as_matrix()  # z along x
    frames = _core.Frame(np.zeros(3), np.eye(3)), _core.Frame(np.zeros(3), across)
    m.multibody.add(_core.Joint("joint", Type.rolling_disk, GROUND, frames[0], body, frames[1], radius=DISK_RADIUS))
    return m


def _exudyn_disk(model: Model, d: _core.Multibody) -> None:
    markers = [model.marker(body, np.zeros(3)) for body in (model.add_ground(), model.bodies["a"])]
    item = model.exu.itemInterface.ObjectJointRollingDisc
    axes = {"discAxis": [1.0, 0.0, 0.0], "planeNormal": [0.0, 0.0, 1.0]}
    model.mbs.AddObject(item(markerNumbers=markers, discRadius=DISK_RADIUS, constrainedAxes=[1, 1, 1], **axes))


EXUDYN_NAMES = {Type.spherical: "JointSpherical", Type.distance: "DistanceConstraint"}


def _joint_case(kind: _core.JointType) -> Case:
    there = MUJOCO_JOINTS.get(kind)
    return Case(
        kind.name,
        lambda: on_joint(kind),
        exudyn=Peer(EXUDYN_NAMES.get(kind, "JointGeneric"), _exudyn_joint, 2),
        mujoco=Peer(" + ".join(word for word, _ in there), _mujoco_joint, 4) if there else None,
    )


# --- on coordinates --------------------------------------------------------------------------------------------------


def arm(*elements: Any) -> _core.Mechanism:
    """Two links on hinges about inclined axes, with elements on their coordinates."""
    m = mechanism()
    d = m.multibody
    add_body(d, "a", 2.0, np.array([0.03, 0.04, 0.02]), np.array([0.2, 0.0, 0.0]))
    add_body(d, "b", 1.0, np.array([0.02, 0.015, 0.01]), np.array([0.5, 0.1, 0.0]))
    add_joint(d, "hinge1", Type.revolute, GROUND, 0, np.zeros(3), np.array([0.2, 1.0, 0.1]))
    add_joint(d, "hinge2", Type.revolute, 0, 1, np.array([0.4, 0.0, 0.0]), np.array([0.3, -0.2, 1.0]))
    for element in elements:
        d.add(element)
    return m


SPRINGS = (_core.JointSpring(0, 20.0, 0.5, -0.3), _core.JointSpring(1, 5.0, 0.2, 0.4))
ARMATURES = (_core.JointArmature(0, 0.3), _core.JointArmature(1, 0.1))
FRICTIONS = ((0.8, 0.05), (0.3, 0.02))
"""Coulomb's and viscous friction of both hinges."""
CREEP = 0.1
"""Rate at which it has 76 % [rad/s]: that of a smooth law."""


def friction() -> list[_core.JointFriction]:
    """Of both hinges."""
    return [
        _core.JointFriction(joint, coulomb, viscous_friction=viscous, creep_rate=CREEP)
        for joint, (coulomb, viscous) in enumerate(FRICTIONS)
    ]


def _exudyn_hinges(model: Model, d: _core.Multibody) -> list[list[Any]]:
    markers = [frame_markers(model, joint) for joint in d.joints]
    for pair in markers:
        model.hinge(*pair)
    return markers


def _exudyn_joint_spring(model: Model, d: _core.Multibody) -> None:
    item = model.exu.itemInterface.ObjectConnectorTorsionalSpringDamper
    for s, markers in zip(d.joint_springs, _exudyn_hinges(model, d), strict=True):
        constants = {"stiffness": s.stiffness, "damping": s.damping, "offset": s.rest}
        model.mbs.AddObject(item(markerNumbers=markers, **constants))


def _exudyn_friction(model: Model, d: _core.Multibody) -> None:
    item = model.exu.itemInterface.ObjectConnectorTorsionalSpringDamper
    for (coulomb, viscous), markers in zip(FRICTIONS, _exudyn_hinges(model, d), strict=True):

        def law(mbs, t, number, angle, rate, k, damping, offset, coulomb=coulomb, viscous=viscous):
            return coulomb * np.tanh(rate / CREEP) + viscous * rate

        model.mbs.AddObject(item(markerNumbers=markers, springTorqueUserFunction=law))


STOPS = {"lower": -0.05, "upper": 0.08, "stiffness": 2e3, "damping": 0.3, "depth": 0.02}
"""Of the first hinge, which falls into the lower one and bounces."""


def _exudyn_stop(model: Model, d: _core.Multibody) -> None:
    markers, *_ = _exudyn_hinges(model, d)
    stiffness, damping, depth = STOPS["stiffness"], STOPS["damping"], STOPS["depth"]

    def push(p: float, rate: float) -> float:
        if p <= 0:
            return 0.0
        z = damping * rate
        return stiffness * (p**2 / (2 * depth) if p < depth else p - depth / 2) * (1 + z / np.sqrt(1 + z**2))

    def law(mbs, t, number, angle, rate, k, damper, offset):
        return push(angle - STOPS["upper"], rate) - push(STOPS["lower"] - angle, -rate)

    item = model.exu.itemInterface.ObjectConnectorTorsionalSpringDamper
    model.mbs.AddObject(item(markerNumbers=markers, springTorqueUserFunction=law))


TORQUE = np.array([1.0, -2.0, 0.5])
"""Of the motor in a ball, in the axes of its first frame, which is the ground's [N m]."""


def motor() -> _core.Mechanism:
    """A body in a ball that a motor turns."""
    m = on_joint(Type.spherical)
    m.multibody.add(_core.RotationMotor(0))
    return m


def _exudyn_motor(model: Model, d: _core.Multibody) -> None:
    _exudyn_joint(model, d)
    marker = model.marker(model.bodies["a"], np.zeros(3))
    torque = list(AXES @ TORQUE)
    model.mbs.AddLoad(model.exu.itemInterface.LoadTorqueVector(markerNumber=marker, loadVector=torque))


def _mujoco_motor(d: _core.Multibody) -> Any:
    """Its axes are those of the body where all joint coordinates are zero, here at the start."""
    turn = Rotation.from_quat(_core.assemble(d)[0][3:], scalar_first=True)

    def edit(root: ElementTree.Element) -> None:
        gear = text([*turn.inv().apply(AXES @ TORQUE), 0.0, 0.0, 0.0])
        actuator = ElementTree.SubElement(root, "actuator")
        ElementTree.SubElement(actuator, "motor", jointinparent="a", gear=gear)

    return *mujoco_model(d, edit), np.ones(1)


def _mujoco_hinges(attributes: list[dict[str, float]]) -> Any:
    def build(d: _core.Multibody) -> Any:
        def edit(root: ElementTree.Element) -> None:
            for hinge, values in zip(root.iter("joint"), attributes, strict=True):
                hinge.attrib |= {key: repr(value) for key, value in values.items()}

        return mujoco_model(d, edit)

    return build


# --- couplings -------------------------------------------------------------------------------------------------------

RATIO, POLYNOMIAL = -2.5, [0.0, 0.3, 0.2]


def wheels(coupling: Any) -> _core.Mechanism:
    """Two coupled wheels, of which a load turns the second."""
    m = mechanism()
    d = m.multibody
    for i, name in enumerate("ab"):
        add_body(d, name, 1.0, np.full(3, (0.3, 0.2)[i]), np.array([0.5 * i, 0, 0]))
        add_joint(d, f"axle{i + 1}", Type.revolute, GROUND, i, np.array([0.5 * i, 0, 0]))
    d.add(_core.Load("motor", 1, np.zeros(3), np.array([0.0, 0.0, 4.0])))
    d.add(coupling)
    return m


def _mujoco_equality(coefficients: list[float]) -> Any:
    """As stiff as it may be: `solref` of minus stiffness and damping, which MuJoCo divides by the masses."""

    def build(d: _core.Multibody) -> Any:
        def edit(root: ElementTree.Element) -> None:
            joint = ElementTree.SubElement(ElementTree.SubElement(root, "equality"), "joint")
            joint.attrib |= {
                "joint1": "b",
                "joint2": "a",
                "polycoef": text([*coefficients, 0.0, 0.0, 0.0, 0.0][:5]),
                "solref": "-1e5 -600",
                "solimp": "0.9999 0.9999 0.001",
            }
            actuator = ElementTree.SubElement(root, "actuator")
            ElementTree.SubElement(actuator, "motor", joint="b")

        return *mujoco_model(d, edit), np.full(1, 4.0)

    return build


CASES = (
    *(_joint_case(kind) for kind in (*EXUDYN_AXES, Type.universal, Type.distance)),
    Case("rolling_disk", rolling_disk, exudyn=Peer("JointRollingDisc", _exudyn_disk, 2)),
    Case(
        "joint_springs",
        lambda: arm(*SPRINGS),
        exudyn=Peer("TorsionalSpringDamper", _exudyn_joint_spring, 2),
        mujoco=Peer(
            "stiffness, damping",
            _mujoco_hinges([{"stiffness": s.stiffness, "damping": s.damping, "springref": s.rest} for s in SPRINGS]),
            4,
        ),
    ),
    Case(
        "joint_armatures",
        lambda: arm(*ARMATURES),
        mujoco=Peer("armature", _mujoco_hinges([{"armature": s.armature} for s in ARMATURES]), 4),
    ),
    Case(
        "joint_frictions",
        lambda: arm(*friction()),
        exudyn=Peer("TorsionalSpringDamper with our law as user function", _exudyn_friction, 2),
        mujoco=Peer(
            "frictionloss, damping",
            _mujoco_hinges([{"frictionloss": coulomb, "damping": viscous} for coulomb, viscous in FRICTIONS]),
            4,
            "Full friction at any rate, and a soft constraint that holds what stands still. Ours is smooth, and "
            "creeps. With the same law, as Exudyn has it here, the motion is the same.",
        ),
    ),
    Case(
        "joint_stops",
        lambda: arm(_core.JointStop(0, **STOPS)),
        exudyn=Peer("TorsionalSpringDamper with our law as user function", _exudyn_stop, 2),
    ),
    Case(
        "motor",
        motor,
        inputs={f"joint.motorTorque[{i + 1}]": value for i, value in enumerate(TORQUE)},
        exudyn=Peer("LoadTorqueVector", _exudyn_motor, 2),
        mujoco=Peer("motor of a ball, in its parent", _mujoco_motor, 4),
    ),
    *(
        Case(
            name,
            lambda coupling=coupling: wheels(coupling),
            mujoco=Peer(
                "equality of joints",
                _mujoco_equality(polynomial),
                4,
                "An equation is a spring with a damper there, here of 1e5/s² for each kg m².",
            ),
        )
        for name, coupling, polynomial in (
            ("gear", _core.gear("coupling", 0, 1, RATIO), [0.0, RATIO]),
            ("mimic", _core.mimic("coupling", 1, 0, POLYNOMIAL), POLYNOMIAL),
        )
    ),
)
