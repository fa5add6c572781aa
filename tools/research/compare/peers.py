"""The problems in Exudyn and MuJoCo, from our definitions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree

import numpy as np

from research.bench.trees import mujoco_model, text
from research.compare.problems import Problem
from research.elements.joints import EXUDYN_AXES
from research.elements.parts import frame_markers, point_markers
from research.reference.exudyn_models import BUILDERS, Model, of_definition
from sigmafmu import _core

SOFT = 2.0
"""Time constant of MuJoCo's constraints in steps: the smallest that it takes."""


def split(definition: _core.Multibody) -> tuple[list[_core.Joint], list[_core.Joint]]:
    """Joints that make a tree, each the first that holds its second body, and those that close loops."""
    tree, closing, held = [], [], {_core.GROUND}
    for joint in definition.joints:
        (closing if joint.body2 in held else tree).append(joint)
        held.add(joint.body2)
    return tree, closing


def bodies_alone(definition: _core.Multibody) -> _core.Multibody:
    """The bodies where and as they start."""
    result = _core.Multibody()
    result.gravity = definition.gravity
    q, v = _core.assemble(definition)
    for body, pose, rates in zip(definition.bodies, q.reshape(-1, 7), v.reshape(-1, 6), strict=True):
        body.initial_position, body.initial_quaternion = pose[:3], pose[3:]
        body.initial_velocity, body.initial_angular_velocity = rates[:3], rates[3:]
        result.add(body)
    return result


def exudyn(problem: Problem) -> Callable[[Model], None]:
    """What builds it, with the force that is compared under `<joint>.force`."""
    if problem.exudyn:
        return BUILDERS[problem.exudyn]
    if problem.planar:
        return _planar(problem)
    definition = problem.mechanism().multibody
    _, closing = split(definition)
    closing_names = {joint.name for joint in closing}

    def build(model: Model) -> None:
        of_definition(bodies_alone(definition))(model)
        items = model.exu.itemInterface
        for joint in definition.joints:
            axes = EXUDYN_AXES[joint.type]
            if joint.name in closing_names:  # a sleeve says nothing twice
                axes = EXUDYN_AXES[_core.JointType.cylindrical]
            number = model.joint(*frame_markers(model, joint), axes)
            if joint.name == problem.joint:
                model.forces.append((f"{joint.name}.force", number, "ForceLocal", 1.0, None))
        for spring in definition.line_springs:
            constants = {"stiffness": spring.stiffness, "damping": spring.damping}
            ends = point_markers(model, spring)
            model.mbs.AddObject(
                items.ObjectConnectorSpringDamper(markerNumbers=ends, referenceLength=spring.free_length, **constants)
            )

    return build


def _planar(problem: Problem) -> Callable[[Model], None]:
    """With Exudyn's bodies and hinges of a plane, three coordinates and two equations each."""
    definition = bodies_alone(problem.mechanism().multibody)
    whole = problem.mechanism().multibody

    def build(model: Model) -> None:
        items, ground = model.exu.itemInterface, model.add_ground()

        def marker(body: int, point: np.ndarray) -> Any:
            number = ground if body == _core.GROUND else [*model.bodies.values()][body]
            return model.mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=number, localPosition=list(point)))

        for i, body in enumerate(definition.bodies):
            x, y, _ = body.initial_position
            w, _, _, z = body.initial_quaternion
            vx, vy, _ = body.initial_velocity
            node = items.NodeRigidBody2D(
                referenceCoordinates=[x, y, 2.0 * np.arctan2(z, w)],
                initialVelocities=[vx, vy, body.initial_angular_velocity[2]],
            )
            one = items.ObjectRigidBody2D(nodeNumber=model.mbs.AddNode(node), mass=body.mass, inertia=body.inertia[2])
            model.bodies[body.name] = model.mbs.AddObject(one)
            weight = list(body.mass * definition.gravity)
            model.mbs.AddLoad(items.LoadForceVector(markerNumber=marker(i, np.zeros(3)), loadVector=weight))
        for joint in whole.joints:
            ends = [marker(joint.body1, joint.frame1.origin), marker(joint.body2, joint.frame2.origin)]
            number = model.mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))
            if joint.name == problem.joint:
                model.forces.append((f"{joint.name}.force", number, "Force", 1.0, None))
        for spring in whole.line_springs:
            ends = [marker(spring.body1, spring.point1), marker(spring.body2, spring.point2)]
            constants = {"stiffness": spring.stiffness, "damping": spring.damping}
            model.mbs.AddObject(
                items.ObjectConnectorSpringDamper(markerNumbers=ends, referenceLength=spring.free_length, **constants)
            )
        for load in whole.loads:
            rigid = items.MarkerBodyRigid(bodyNumber=[*model.bodies.values()][load.body], localPosition=[0, 0, 0])
            torque = items.LoadTorqueVector(markerNumber=model.mbs.AddMarker(rigid), loadVector=list(load.torque))
            model.mbs.AddLoad(torque)

    return build


def in_order(definition: _core.Multibody) -> _core.Multibody:
    """The same with bodies behind those that carry them, and without the joints that close loops."""
    tree, _ = split(definition)
    alone = bodies_alone(definition)
    carried = {joint.body2: joint.body1 for joint in tree}
    order: list[int] = []
    while len(order) < len(alone.bodies):
        order += [i for i in range(len(alone.bodies)) if i not in order and carried.get(i, -1) in (-1, *order)]
    result = _core.Multibody()
    result.gravity = definition.gravity
    for i in order:
        result.add(alone.bodies[i])
    place = {old: new for new, old in enumerate(order)} | {_core.GROUND: _core.GROUND}
    for joint in tree:
        result.add(
            _core.Joint(joint.name, joint.type, place[joint.body1], joint.frame1, place[joint.body2], joint.frame2)
        )
    return result


class InMujoco:
    """A problem in MuJoCo: a tree of hinges and slides, loops closed by soft constraints at points of hinges' axes.

    It is integrated by the Runge-Kutta method of order 4.
    """

    def __init__(self, problem: Problem, h: float):
        import mujoco as mj

        definition = problem.mechanism().multibody
        _, closing = split(definition)
        names = [body.name for body in definition.bodies]

        def edit(root: ElementTree.Element) -> None:
            equality = ElementTree.SubElement(root, "equality")
            for joint in closing:
                origin, along = joint.frame1.origin, joint.frame1.axes[:, 2]
                for shift in (0.0,) if problem.planar else (-0.5, 0.5):
                    anchor = text(origin + shift * along)
                    other = {} if joint.body2 == _core.GROUND else {"body2": names[joint.body2]}
                    solver = {"solref": f"{SOFT * h!r} 1", "solimp": "0.9999 0.9999 0.001 0.5 2"}
                    ElementTree.SubElement(
                        equality, "connect", body1=names[joint.body1], anchor=anchor, **other, **solver
                    )
            for spring in definition.line_springs:
                tendon = ElementTree.SubElement(_child(root, "tendon"), "spatial")
                constants = {"stiffness": spring.stiffness, "damping": spring.damping}
                tendon.attrib.update({key: repr(value) for key, value in constants.items()})
                tendon.set("springlength", repr(spring.free_length))
                for side in (1, 2):
                    number, point = getattr(spring, f"body{side}"), getattr(spring, f"point{side}")
                    holder = root.find("worldbody")
                    if number != _core.GROUND:
                        holder = root.find(f".//body[@name='{names[number]}']")
                    site = f"{spring.name}{side}"
                    ElementTree.SubElement(holder, "site", name=site, pos=text(point))
                    ElementTree.SubElement(tendon, "site", site=site)

        mj.set_mju_user_warning(lambda _: None)  # a run that explodes is an error to us, not a log file
        self.model, self._rates = mujoco_model(in_order(definition), edit)
        self.model.opt.timestep, self.model.opt.integrator = h, mj.mjtIntegrator.mjINT_RK4
        self.model.opt.tolerance, self.model.opt.iterations = 0.0, 100
        self._torques = np.zeros(self.model.nv)
        for load in definition.loads:  # on a hinge about z of W
            number = mj.mj_name2id(self.model, mj.mjtObj.mjOBJ_BODY, names[load.body])
            self._torques[self.model.body_dofadr[number]] = load.torque[2]
        carried = next(joint.body2 for joint in definition.joints if joint.name == problem.joint)
        self._carried = mj.mj_name2id(self.model, mj.mjtObj.mjOBJ_BODY, names[carried])
        self._mj, self._body = mj, mj.mj_name2id(self.model, mj.mjtObj.mjOBJ_BODY, names[problem.body])

    def start(self) -> Any:
        """Data before the first step."""
        data = self._mj.MjData(self.model)
        data.qvel[:], data.qfrc_applied[:] = self._rates, self._torques
        return data

    def step(self, data: Any, steps: int) -> None:
        """All in one call of its C code."""
        self._mj.mj_step(self.model, data, nstep=steps)

    def force(self, data: Any) -> float:
        """Size of the force in the joint that is compared; springs at the body that it carries count as part of it."""
        self._mj.mj_forward(self.model, data)
        self._mj.mj_rnePostConstraint(self.model, data)
        return float(np.linalg.norm(data.cfrc_int[self._carried][3:]))

    def point(self, data: Any) -> np.ndarray:
        """Of the problem, now."""
        self._mj.mj_kinematics(self.model, data)
        return data.xpos[self._body].copy()


def _child(root: ElementTree.Element, name: str) -> ElementTree.Element:
    found = root.find(name)
    return ElementTree.SubElement(root, name) if found is None else found
