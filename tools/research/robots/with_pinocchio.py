"""URDF files beside Pinocchio: its articulated-body algorithm, and mimic joints eliminated from its matrices."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from research.robots import STATES, Compared, Json, State, center_of_mass, compared, damping, without_one_sided
from sigmafmu import SigmafmuError
from sigmafmu.importers.convert import convert
from sigmafmu.importers.robot import Robot


def compare(path: Path, package: str, states: int = STATES) -> Compared:
    """A URDF file at random states; SigmafmuError: it has something that this comparison does not know."""
    text, robot = convert(path, Path())
    content = without_one_sided(text)
    return compared(path, package, robot, content, Reference(path, robot, content), states)


class Reference:
    """Pinocchio's model of the same file."""

    def __init__(self, path: Path, robot: Robot, content: Json):
        import pinocchio

        self.robot, self.content = robot, content
        self.base = next((name for name, body in robot.bodies.items() if body.start is not None), None)
        root = [pinocchio.JointModelFreeFlyer()] if self.base else []
        model = pinocchio.buildModelFromUrdf(str(path), *root)
        first = 2 if self.base else 1
        gone = [i for i in range(first, model.njoints) if model.names[i] not in robot.coordinates]
        if gone:  # without mass at the end of a branch: there the matrix is singular
            model = pinocchio.buildReducedModel(model, gone, pinocchio.neutral(model))
        self.model, self.data = model, model.createData()
        self.names = [robot.coordinates[name] for name in list(model.names)[first:]]
        wrong = [model.names[i] for i in range(first, model.njoints) if model.joints[i].nv != 1]
        if wrong:
            raise SigmafmuError(f"{path.name}: {wrong[0]} has more than one coordinate")
        self._take_changed_bodies(first)
        self.follow, self.constant = self._mimics()

    def _take_changed_bodies(self, first: int) -> None:
        """Bodies that no body can be have the inertia of the mechanism file."""
        import pinocchio

        carriers = {joint.bodies[1]: name for name, joint in self.robot.joints.items()}
        for name in self.robot.changed:
            i = 1 if name == self.base else first + self.names.index(carriers[name])
            inertia = self.robot.bodies[name].inertia
            self.model.inertias[i] = pinocchio.Inertia(inertia.mass, inertia.center, inertia.J)
        self.data = self.model.createData()

    def _mimics(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocities = follow @ independent ones; coordinates of joints have the constant beside."""
        n, at = len(self.names), self.model.nv - len(self.names)
        full, constant = np.eye(self.model.nv), np.zeros(n)
        leaders: dict[int, tuple[int, float, float]] = {}
        for coupling in self.robot.couplings:
            if coupling.type == "mimic":
                follower, leader = (self.names.index(name) for name in coupling.joints)
                leaders[follower] = (leader, *map(float, coupling.keys["polynomial"]))
            else:
                leaders[self.names.index(coupling.joints[0])] = (-1, float(coupling.keys["offset"]), 0.0)
        for i in range(n):
            chain, factor, offset = i, 1.0, 0.0
            while chain in leaders:
                chain, constant_part, ratio = leaders[chain]
                offset, factor = offset + factor * constant_part, factor * ratio
            if i in leaders:
                full[at + i] = 0
                constant[i] = offset
                if chain >= 0:
                    full[at + i, at + chain] = factor
        independent = [k for k in range(self.model.nv) if k < at or k - at not in leaders]
        return full[:, independent], constant

    def at_random(self, rng: np.random.Generator) -> tuple[State, np.ndarray]:
        """A state and its accelerations."""
        import pinocchio

        model, data = self.model, self.data
        free = self.follow.shape[1]
        shift = self.follow @ rng.uniform(-1, 1, free)
        shift[model.nv - len(self.names) :] += self.constant
        v = self.follow @ rng.uniform(-1, 1, free)
        q = pinocchio.integrate(model, pinocchio.neutral(model), shift)
        at = model.nv - len(self.names)
        tau = np.zeros(model.nv)
        tau[at:] = [-damping(self.content, name) * rate for name, rate in zip(self.names, v[at:], strict=True)]
        if free == model.nv:
            a = pinocchio.aba(model, data, q, v, tau)
        else:
            M = pinocchio.crba(model, data, q)
            M = np.triu(M) + np.triu(M, 1).T
            bias = pinocchio.nonLinearEffects(model, data, q, v)
            a = self.follow @ np.linalg.solve(self.follow.T @ M @ self.follow, self.follow.T @ (tau - bias))
        state = State({name: (float(x), float(r)) for name, x, r in zip(self.names, shift[at:], v[at:], strict=True)})
        expected = [a[at:]]
        if self.base:
            pinocchio.forwardKinematics(model, data, q, v)
            keys, acceleration = self._base(q, v, a, data)
            state.bodies[self.base] = keys
            expected.append(acceleration)
        return state, np.concatenate(expected)

    def _base(self, q: np.ndarray, v: np.ndarray, a: np.ndarray, data: Any) -> tuple[Json, np.ndarray]:
        R, c = data.oMi[1].rotation, center_of_mass(self.content, self.base or "")
        w, velocity, turning = v[3:6], v[:3], a[3:6]
        keys = {
            "position": data.oMi[1].translation.tolist(),
            "orientation": {"quaternion": Rotation.from_matrix(R).as_quat(scalar_first=True).tolist()},
            "velocity": (R @ (velocity + np.cross(w, c))).tolist(),
            "angular_velocity": w.tolist(),
        }
        at_center = a[:3] + np.cross(w, velocity) + np.cross(turning, c) + np.cross(w, np.cross(w, c))
        return keys, np.concatenate([R @ at_center, turning])
