"""Coordinates that states are made of: named, physical, and the same from one time to the next.

A coordinate is given by its rate η = L(q) v, a linear function of the velocities. The coordinates of joints, modal
coordinates and positions in W are integrals of their rates. Rotations have none: they are small, measured from the
point, and so are displacements in body axes.

Candidates are taken in a fixed order (joints, modes, rotations, positions; each in the order of the definition), if
they are independent of those before. So a set changes only where one of its members stops to describe the motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sigmafmu import SigmafmuError, _core
from sigmafmu.linear.differences import RELATIVE_STEP, derivative

FRAMES = ("world", "body")
WORDS = ("angle", "displacement"), ("angularRate", "rate")
INDEPENDENT = 0.01
"""Part of a coordinate's motion that those before must leave to it."""


@dataclass(frozen=True)
class Coordinate:
    """A coordinate and its rate, as states."""

    name: str
    rate: str
    unit: str
    rate_unit: str
    integral: bool = True  # whether it is the integral of its rate; if not, it is zero at the point


class Coordinates:
    """Every coordinate that a mechanism offers; rotations and displacements of bodies in axes of W or of the body."""

    def __init__(self, mechanism: "_core.Mechanism", system: "_core.System", frame: str):
        if frame not in FRAMES:
            raise SigmafmuError(f"the frame must be {' or '.join(FRAMES)}, not '{frame}'")
        self._system = system
        self._in_body = frame == "body"
        multibody = mechanism.multibody
        self._bodies = range(len(multibody.bodies))
        self._modes = slice(6 * len(multibody.bodies), system.velocity_size)
        turns, self._joints = system.kinds_of_coordinates()
        self._turns = np.array(turns, dtype=bool)
        self.all = [*self._of_joints(multibody), *self._of_modes(multibody), *self._of_bodies(multibody)]
        self._first_body = len(self.all) - 6 * len(multibody.bodies)

    def _of_joints(self, multibody: "_core.Multibody") -> list[Coordinate]:
        result: list[Coordinate] = []
        for turns, j, first in zip(self._turns, self._joints, np.searchsorted(self._joints, self._joints), strict=True):
            joint, unit = multibody.joints[j], "rad" if turns else "m"
            name, rate = (f"{joint.name}.{joint.word(len(result) - first, *words)}" for words in WORDS)
            result.append(Coordinate(name, rate, unit, f"{unit}/s"))
        return result

    def _of_modes(self, multibody: "_core.Multibody") -> list[Coordinate]:
        flexible = [(i, body) for i, body in enumerate(multibody.bodies) if body.modal is not None]
        return [
            Coordinate(f"{body.name}.modal[{k + 1}]", f"{body.name}.modalRate[{k + 1}]", "m", "m/s")
            for i, body in flexible
            for k in range(self._system.modes(i))
        ]

    def _of_bodies(self, multibody: "_core.Multibody") -> list[Coordinate]:
        """Three of position and three of rotation for each body."""
        if self._in_body:
            kinds = (("displacementB", "velocityB", "m", False), ("rotationB", "angularVelocity", "rad", False))
        else:
            kinds = (("position", "velocity", "m", True), ("rotationW", "angularVelocityW", "rad", False))
        return [
            Coordinate(f"{body.name}.{name}[{i}]", f"{body.name}.{rate}[{i}]", unit, f"{unit}/s", integral)
            for body in multibody.bodies
            for name, rate, unit, integral in kinds
            for i in (1, 2, 3)
        ]

    @property
    def order(self) -> list[int]:
        """Indices in the order of preference."""
        bodies = [self._first_body + 6 * i for i in self._bodies]
        rotations = [first + 3 + c for first in bodies for c in range(3)]
        positions = [first + c for first in bodies for c in range(3)]
        return [*range(self._first_body), *rotations, *positions]

    def values(self, q: np.ndarray, near: np.ndarray) -> np.ndarray:
        """Coordinates at a point; those that are no integrals are zero there. `near`: near those of the joints."""
        joints = self.turned(q, near)
        bodies = np.zeros((len(self._bodies), 6))
        if not self._in_body:
            for i in self._bodies:
                bodies[i, :3] = q[7 * i : 7 * i + 3]
        return np.concatenate([joints, q[7 * len(self._bodies) :], bodies.ravel()])

    def rates(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """L(q) v."""
        joints = self._system.coordinates(q, v)[1]
        return np.concatenate([joints, v[self._modes], *(self._rates_of_body(i, q, v) for i in self._bodies)])

    def _rates_of_body(self, i: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        velocity, spin = v[6 * i : 6 * i + 3], v[6 * i + 3 : 6 * i + 6]
        rotation = _core.lie.rotation_matrix(q[7 * i + 3 : 7 * i + 7])
        return np.concatenate([rotation.T @ velocity, spin] if self._in_body else [velocity, rotation @ spin])

    def accelerations(self, q: np.ndarray, v: np.ndarray, vdot: np.ndarray, time: float) -> np.ndarray:
        """Time derivatives of the rates, L v̇ + L̇ v; `time` [s] is short against the motion."""
        result = self.rates(q, vdot)
        joints = len(self._joints)
        if joints:
            result[:joints] += derivative(
                lambda s: self._system.coordinates(self._system.compose(q, s * v), v)[1], time
            )
        if self._in_body:
            for i in self._bodies:
                first = self._first_body + 6 * i
                rotation = _core.lie.rotation_matrix(q[7 * i + 3 : 7 * i + 7])
                result[first : first + 3] -= np.cross(v[6 * i + 3 : 6 * i + 6], rotation.T @ v[6 * i : 6 * i + 3])
        return result

    def gradient(self, q: np.ndarray) -> np.ndarray:
        """L(q)."""
        return np.column_stack([self.rates(q, unit) for unit in np.eye(self._system.velocity_size)])

    def turned(self, q: np.ndarray, near: np.ndarray) -> np.ndarray:
        """Coordinates of joints, angles with the turns that bring them closest to `near`."""
        values = self._system.coordinates(q, np.zeros(self._system.velocity_size))[0]
        return values + self._turns * 2 * np.pi * np.round((near - values) / (2 * np.pi))


def sizes(mechanism: "_core.Mechanism", system: "_core.System") -> np.ndarray:
    """What counts as a large change of each velocity's position: the mechanism's size, 1 rad, a mode as large."""
    multibody = mechanism.multibody
    reach = [
        float(np.linalg.norm(frame.origin)) for joint in multibody.joints for frame in (joint.frame1, joint.frame2)
    ]
    length = max(reach, default=0.0) or 1.0
    result = np.tile([length] * 3 + [1.0] * 3, len(multibody.bodies))
    modal = np.ones(system.modal_count)
    for i, body in enumerate(multibody.bodies):
        if body.modal is not None:
            first = system.modal_index(i)
            shapes = np.asarray(body.modal.shapes).reshape(-1, 3, system.modes(i))
            modal[first : first + system.modes(i)] = length / np.linalg.norm(shapes, axis=1).max(axis=0)
    return np.concatenate([result, modal])


@dataclass(frozen=True, eq=False)
class Selection:
    """Independent coordinates: their indices, gradient L and motions E with L E = 1."""

    indices: list[int]
    gradient: np.ndarray
    motions: np.ndarray


def select(
    coordinates: Coordinates,
    q: np.ndarray,
    constraint: np.ndarray,
    size: np.ndarray,
    wanted: Sequence[int],
    among: Sequence[int] | None = None,
) -> Selection:
    """As many independent coordinates as there are motions that satisfy the constraints, `wanted` ones first.

    `among`: the only ones that may be taken; default: all.
    """
    motions = size[:, None] * _null_space(constraint * size)
    gradient = coordinates.gradient(q)
    scaled = gradient * size
    rows = (gradient @ motions) / np.linalg.norm(scaled, axis=1)[:, None]
    if among is not None:
        rows[np.setdiff1d(np.arange(len(rows)), among)] = 0.0
    freedom = motions.shape[1]
    chosen: list[int] = []

    def take(i: int) -> None:
        nonlocal rows
        direction = rows[i] / np.linalg.norm(rows[i])
        rows = rows - np.outer(rows @ direction, direction)
        chosen.append(i)

    for i in wanted:
        if np.linalg.norm(rows[i]) < INDEPENDENT:
            raise SigmafmuError(
                f"'{coordinates.all[i].name}' cannot be a state here: it stands still or depends on the others"
            )
        take(i)
    for i in coordinates.order:
        if len(chosen) < freedom and np.linalg.norm(rows[i]) > INDEPENDENT:
            take(i)
    while len(chosen) < freedom:  # close to a singular position
        take(int(np.argmax(np.linalg.norm(rows, axis=1))))
    chosen.sort()
    kept = gradient[chosen]
    return Selection(chosen, kept, motions @ np.linalg.inv(kept @ motions))


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal basis, rank decided at 1e-10 of the largest singular value."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, singular, right = np.linalg.svd(matrix)
    rank = int(np.sum(singular > 1e-10 * singular[0]))
    return right[rank:].T


def difference_time(v: np.ndarray, size: np.ndarray) -> float:
    """A time [s] in which the mechanism moves by a small part of its size."""
    return RELATIVE_STEP / max(1.0, float(np.abs(v / size).max()))
