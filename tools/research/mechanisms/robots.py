"""An arm of seven revolute joints, and robots from URDF files."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from research.mechanisms.parts import GROUND, REVOLUTE, add_body, add_joint
from sigmafmu import SigmafmuError, _core

if TYPE_CHECKING:
    import pinocchio

GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s2, in W


def revolute_arm7() -> _core.Mechanism:
    """An arm with hinges about z and y of its links in turn, as large as a light industrial robot; it falls from rest.

    Links are rods of 0.2 m of 4 kg to 1 kg, bent by 0.3, 0.6 and 0.9 rad in turn.
    """
    mechanism = _core.Mechanism("RevoluteArm7")
    multibody = mechanism.multibody
    multibody.gravity = GRAVITY
    mechanism.integrator.step_size = 1e-3
    length, radius = 0.2, 0.05
    turn, start = Rotation.identity(), np.zeros(3)
    for i in range(7):
        axis = "zyzyzyz"[i]
        joint_axis = turn.apply(np.eye(3)["xyz".index(axis)])
        turn = turn * Rotation.from_euler(axis, 0.3 * (1 + i % 3))
        along = turn.apply([0.0, 0.0, length])
        mass = 4.0 - 0.5 * i
        across = mass * (length**2 / 12 + radius**2 / 4)
        inertia = np.array([across, across, mass * radius**2 / 2])
        add_body(multibody, f"link{i + 1}", mass, inertia, start + 0.5 * along, turn)
        add_joint(multibody, f"joint{i + 1}", REVOLUTE, i - 1 if i else GROUND, i, start, joint_axis)
        start = start + along
    return mechanism


def example_urdf(name: str) -> Path:
    """A file of the package example-robot-data. SigmafmuError: the package is missing, or has no such file."""
    try:
        (found,) = (f for f in files("example-robot-data") or () if f.name == name)
    except (PackageNotFoundError, ValueError) as error:
        raise SigmafmuError(f"{name} is in the package example-robot-data; `make bench` installs it") from error
    return Path(str(found.locate()))


def humanoid_model(free: bool = True) -> pinocchio.Model:
    """A humanoid with 29 hinges in Pinocchio, its pelvis free or fixed."""
    path = str(example_urdf("simple_humanoid.urdf"))
    import pinocchio

    base = [pinocchio.JointModelFreeFlyer()] if free else []
    return pinocchio.buildModelFromUrdf(path, *base)


def humanoid() -> _core.Mechanism:
    """The humanoid with a free base, bent and moving a little, in free fall."""
    model = humanoid_model()
    import pinocchio

    rng = np.random.default_rng(1)
    q, v = pinocchio.neutral(model), np.zeros(model.nv)
    q[7:], v[6:] = rng.uniform(-0.3, 0.3, model.nq - 7), rng.uniform(-1, 1, model.nv - 6)
    return from_pinocchio(model, q, v, "Humanoid")


def from_pinocchio(model: pinocchio.Model, q: np.ndarray, v: np.ndarray, name: str) -> _core.Mechanism:
    """Pinocchio's model of revolute joints, and perhaps a free base, as a mechanism of ours at (q, v).

    A body per joint, with the inertia that Pinocchio has merged into it, at its center of mass and in the joint's axes.
    SigmafmuError: another joint.
    """
    import pinocchio

    data = model.createData()
    pinocchio.forwardKinematics(model, data, q, v)
    mechanism = _core.Mechanism(name)
    mechanism.integrator.step_size = 1e-3
    multibody = mechanism.multibody
    multibody.gravity = np.array(model.gravity.linear)
    for i in range(1, model.njoints):
        kind = model.joints[i].shortname()
        place, inertia, velocity = data.oMi[i], model.inertias[i], data.v[i]
        R, lever = place.rotation, inertia.lever
        body = _core.RigidBody()
        body.name, body.mass = model.names[i], inertia.mass
        body.inertia, J = np.diag(inertia.inertia).copy(), inertia.inertia
        body.inertia_products = np.array([J[0, 1], J[0, 2], J[1, 2]])
        body.initial_position = place.translation + R @ lever
        body.initial_quaternion = Rotation.from_matrix(R).as_quat(scalar_first=True)
        body.initial_velocity = R @ (velocity.linear + np.cross(velocity.angular, lever))
        body.initial_angular_velocity = np.array(velocity.angular)
        multibody.add(body)
        if kind == "JointModelFreeFlyer":
            continue
        axis = _axis(model, i, kind)
        parent = model.parents[i] - 1
        parent_lever = model.inertias[parent + 1].lever if parent >= 0 else np.zeros(3)
        fixed = model.jointPlacements[i]  # of the joint's axes in those of its parent
        axes = _core.axes_with_z(axis)
        sides = (
            parent if parent >= 0 else GROUND,
            _core.Frame(fixed.translation - parent_lever, fixed.rotation @ axes),
            i - 1,
            _core.Frame(-lever, axes),
        )
        multibody.add(_core.Joint(f"{model.names[i]}Joint", REVOLUTE, *sides))
    return mechanism


def _axis(model: pinocchio.Model, joint: int, kind: str) -> np.ndarray:
    """Of a revolute joint, in its own axes."""
    letters = {"JointModelRX": 0, "JointModelRY": 1, "JointModelRZ": 2}
    if kind in letters:
        return np.eye(3)[letters[kind]]
    if kind == "JointModelRevoluteUnaligned":
        return np.array(model.joints[joint].extract().axis)
    raise SigmafmuError(f"joint {model.names[joint]} is {kind}; it must be a revolute joint or a free base")
