"""Flexible bodies as clouds of nodes at r_i = x + R (X_i + Phi_i ζ), random ones and beams."""

from dataclasses import dataclass

import numpy as np

from sigmafmu import _core

from .helpers import Rotation, pose

FLOATING = -1


@dataclass
class Cloud:
    """A flexible body as it is described: n nodes and f modes. Everything here is a sum over the nodes."""

    nodes: np.ndarray  # X, n x 3
    mass: np.ndarray  # n x n
    shapes: np.ndarray  # Phi, n x 3 x f
    rotations: np.ndarray  # Psi, n x 3 x f
    stiffness: np.ndarray
    damping: np.ndarray

    @property
    def modes(self):
        return self.shapes.shape[2]

    def places(self, zeta):
        """s_i in B."""
        return self.nodes + self.shapes @ zeta

    def frame(self, node, zeta):
        """Pose of a node's frame in B."""
        return pose(self.places(zeta)[node], Rotation.from_rotvec(self.rotations[node] @ zeta).as_matrix())

    def jacobians(self, turn, zeta):
        """J_i with r_i' = J_i (v, w, ζ'), n x 3 x (6 + f)."""
        result = np.zeros((len(self.nodes), 3, 6 + self.modes))
        for i, s in enumerate(self.places(zeta)):
            result[i] = np.hstack([np.eye(3), -turn @ hat(s), turn @ self.shapes[i]])
        return result

    def bias(self, turn, w, zeta, zetadot):
        """Accelerations of the nodes when vdot, wdot and ζ'' are zero: centripetal and Coriolis."""
        return (np.cross(w, np.cross(w, self.places(zeta))) + 2 * np.cross(w, self.shapes @ zetadot)) @ turn.T

    def mass_matrix(self, turn, zeta):
        j = self.jacobians(turn, zeta)
        return np.einsum("ij,ika,jkb->ab", self.mass, j, j)

    def inertial_force(self, turn, w, zeta, zetadot, vdot, gravity):
        """Virtual work of M (r'' - g): sum_ij M_ij J_i' (r_j'' - g)."""
        j = self.jacobians(turn, zeta)
        acceleration = j @ vdot + self.bias(turn, w, zeta, zetadot) - gravity
        return np.einsum("ij,ika,jk->a", self.mass, j, acceleration)


def hat(w):
    return np.cross(np.eye(3), w)


def semidefinite(rng, size, scale):
    root = rng.uniform(-1, 1, (size, size))
    return scale * root @ root.T


def random_cloud(rng, modes=3, lumped=None):
    """Six nodes; a mass matrix, if not lumped, that couples them as finite elements do."""
    count = 6
    masses = np.diag(rng.uniform(0.1, 0.5, count))
    if not (rng.random() < 0.5 if lumped is None else lumped):
        masses += semidefinite(rng, count, 0.02)
    return Cloud(
        nodes=rng.uniform(-0.5, 0.5, (count, 3)) + rng.uniform(-0.3, 0.3, 3),  # the frame is not in the centre of mass
        mass=masses,
        shapes=rng.uniform(-0.5, 0.5, (count, 3, modes)),
        rotations=rng.uniform(-0.5, 0.5, (count, 3, modes)),
        stiffness=semidefinite(rng, modes, 20.0),
        damping=semidefinite(rng, modes, 0.5),
    )


def flexible_body(cloud, name="body", as_matrix=True):
    body = _core.RigidBody()
    body.name = name
    modal = _core.Modal()
    modal.nodes = cloud.nodes
    if as_matrix:
        modal.mass_matrix = cloud.mass
    else:
        modal.masses = np.diag(cloud.mass)
    modal.set_shapes(np.ascontiguousarray(cloud.shapes))
    modal.set_rotations(np.ascontiguousarray(cloud.rotations))
    modal.stiffness, modal.damping = cloud.stiffness, cloud.damping
    body.modal = modal
    return body


def beam(length, mass, width, terms, stiffness):
    """A beam along x of 11 sections with four nodes each. `terms`: (w(xi), w'(xi)) of the bending modes, the same in y
    and in z, xi = x / length; the sections stay plane and normal to the axis."""
    xi = np.linspace(0.0, 1.0, 11)
    nodes, masses, shapes, rotations = [], [], [], []
    for k, s in enumerate(xi):
        for y in (width, -width):
            for z in (width, -width):
                nodes.append([s * length, y, z])
                masses.append(mass / (20 if k in (0, 10) else 10) / 4)
                w, slope = np.array([[f(s), d(s) / length] for f, d in terms]).T
                none = np.zeros_like(w)
                shapes.append([np.r_[-y * slope, -z * slope], np.r_[w, none], np.r_[none, w]])
                rotations.append([np.r_[none, none], np.r_[none, -slope], np.r_[slope, none]])
    shape = np.array(shapes)
    zero = np.zeros_like(stiffness)
    return Cloud(np.array(nodes), np.diag(masses), shape, np.array(rotations), stiffness, zero)
