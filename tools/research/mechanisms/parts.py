"""Bodies and joints placed in W, of which the mechanisms of this package are made. SI units."""

import numpy as np
from scipy.spatial.transform import Rotation

from sigmafmu import _core

GROUND = _core.GROUND
REVOLUTE, SPHERICAL = _core.JointType.revolute, _core.JointType.spherical
Z = np.array([0.0, 0.0, 1.0])
MANY = 100
"""Bodies beyond which `expose_ends` is what an FMU needs."""


def add_body(
    multibody: _core.Multibody,
    name: str,
    mass: float,
    inertia: np.ndarray,
    position: np.ndarray,
    rotation: Rotation | None = None,
    velocity: np.ndarray | None = None,
    angular_velocity: np.ndarray | None = None,
) -> int:
    """A rigid body at its center of mass: principal moments in its axes, velocity in W, angular velocity in its axes.

    Returns its number.
    """
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = name, mass, inertia
    body.initial_position = position
    if rotation is not None:
        body.initial_quaternion = rotation.as_quat(scalar_first=True)
    if velocity is not None:
        body.initial_velocity = velocity
    if angular_velocity is not None:
        body.initial_angular_velocity = angular_velocity
    return multibody.add(body)


def add_bar(
    multibody: _core.Multibody, name: str, ends: np.ndarray, mass: float, inertia: np.ndarray, velocity: np.ndarray
) -> int:
    """A bar in the xy plane with its mass at its middle, body x from end to end, whose ends have these velocities."""
    along = ends[1] - ends[0]
    length_squared = along @ along
    return add_body(
        multibody,
        name,
        mass,
        inertia,
        ends.mean(axis=0),
        Rotation.from_rotvec(np.arctan2(along[1], along[0]) * Z),
        velocity.mean(axis=0),
        np.cross(along, velocity[1] - velocity[0]) / length_squared,
    )


def add_joint(
    multibody: _core.Multibody,
    name: str,
    kind: _core.JointType,
    body1: int,
    body2: int,
    point: np.ndarray,
    axis: np.ndarray = Z,
) -> int:
    """A joint at a point of W whose z is an axis there. Returns its number."""
    sides = []
    for body in (body1, body2):
        position, turn = np.zeros(3), Rotation.identity()
        if body != GROUND:
            place = multibody.body(body)
            position, turn = place.initial_position, Rotation.from_quat(place.initial_quaternion, scalar_first=True)
        R = turn.as_matrix()
        sides += [body, _core.Frame(R.T @ (point - position), R.T @ _core.axes_with_z(axis))]
    return multibody.add(_core.Joint(name, kind, *sides))


def expose_ends(mechanism: _core.Mechanism) -> None:
    """Leave a large FMU the variables of its first joint and last body, energies and settings."""
    last, first = mechanism.multibody.bodies[-1].name, mechanism.multibody.joints[0].name
    exposure = _core.Exposure()
    exposure.inputs = [f"{last}.force*", f"{first}.motor*"]
    exposure.outputs = [f"{last}.*", f"{first}.*", "energy.*", "constraint.*"]
    exposure.parameters = ["gravity*", "integrator.*"]
    mechanism.expose = exposure
