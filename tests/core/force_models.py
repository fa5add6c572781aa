"""Every force element in NumPy, from its definition alone: random ones, forces, lost power. And systems that have them.

A model has `make` (a random element between two ends), `wrench` (force on body 2 at the second end and torque, in W,
with the inputs u; the opposite acts on body 1 at the same place) and `lost` (what it dissipates, in W).
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PchipInterpolator

from sigmafmu import _core

from .clouds import FLOATING, flexible_body, hat, random_cloud
from .helpers import (
    GROUND,
    Rotation,
    coordinates,
    frame_pose,
    pose,
    random_body,
    random_pose,
    rotation_of,
)


@dataclass
class End:
    """Where an element attaches: body, node, and a frame seen from there."""

    body: int
    node: int = FLOATING
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    def frame(self):
        return _core.Frame(self.origin, self.axes, self.node)


@dataclass
class Motion:
    """Of a frame, in W."""

    o: np.ndarray
    axes: np.ndarray
    velocity: np.ndarray
    w: np.ndarray
    origin: np.ndarray | None = None
    """Where it is in its body or node."""


def rigid_motion(place, twist, end):
    """Of a frame of a rigid body with seven coordinates and (v in W, w in B); of the ground: None."""
    if end.body == GROUND:
        return Motion(end.origin, end.axes, np.zeros(3), np.zeros(3), end.origin)
    turn = rotation_of(place).as_matrix()
    lever, w = turn @ end.origin, turn @ twist[3:]
    return Motion(place[:3] + lever, turn @ end.axes, twist[:3] + np.cross(w, lever), w, end.origin)


TENTH = {1: 5 / 6, 2: -5 / 21, 3: 5 / 84, 4: -5 / 504, 5: 1 / 1260}


def sharp_derivative(f, h=5e-3):
    """f'(0) of order ten: truncation h¹⁰ f⁽¹¹⁾/2772, about 4e-27 f⁽¹¹⁾, and rounding ε/h, about 5e-14 |f|."""
    return sum(c * (np.asarray(f(k * h)) - f(-k * h)) for k, c in TENTH.items()) / h


# --- the elements ----------------------------------------------------------------------------------------------------


class LineSpring:
    kind, inputs, frames, key = _core.LineSpring, 1, False, "line_springs"
    single = False

    @staticmethod
    def make(rng, name, one, two, a, b):
        stiffness, damping = rng.uniform(5, 20, 2)
        free = np.linalg.norm(b.o - a.o) * rng.uniform(0.5, 1.5)
        ends = (one.body, one.origin, two.body, two.origin)
        return _core.LineSpring(name, *ends, stiffness, damping, free, one.node, two.node)

    @staticmethod
    def tension(d, length, rate):
        return d.stiffness * (length - d.free_length) + d.damping * rate

    @classmethod
    def wrench(cls, d, a, b, u):
        length, rate, e = line(a, b)
        return -(cls.tension(d, length, rate) + u[0]) * e, np.zeros(3)

    @classmethod
    def lost(cls, d, a, b):
        length, rate, _ = line(a, b)
        return (cls.tension(d, length, rate) - cls.tension(d, length, 0.0)) * rate


def line(a, b):
    x = b.o - a.o
    length = np.linalg.norm(x)
    return length, x @ (b.velocity - a.velocity) / length, x / length


class TableSpring(LineSpring):
    kind, key = _core.TableSpring, "table_springs"

    @staticmethod
    def make(rng, name, one, two, a, b):
        # The points are far from where the element is, so that differences see one cubic.
        length, rate, _ = line(a, b)
        x = length * np.array([0.4, 0.8, 1.3, 1.9, 2.5])
        y = rate + np.array([-6.0, -2.5, 2.0, 5.0])
        ends = (one.body, one.origin, two.body, two.origin)
        tables = (x.tolist(), rng.uniform(-5, 5, 5).tolist(), y.tolist(), np.cumsum(rng.uniform(1, 9, 4)).tolist())
        return _core.TableSpring(name, *ends, *tables, one.node, two.node)

    @staticmethod
    def tension(d, length, rate):
        return PchipInterpolator(d.length, d.force)(length) + PchipInterpolator(d.rate, d.rate_force)(rate)

    @classmethod
    def lost(cls, d, a, b):
        _, rate, _ = line(a, b)
        return PchipInterpolator(d.rate, d.rate_force)(rate) * rate


class TorsionSpring:
    kind, inputs, frames, key = _core.TorsionSpring, 1, True, "torsion_springs"
    single = False

    @staticmethod
    def make(rng, name, one, two, a, b):
        return _core.TorsionSpring(name, one.body, one.frame(), two.body, two.frame(), *rng.uniform(1, 10, 2), 0.3)

    @staticmethod
    def twist(a, b):
        """Angle of the turn about z that is left when the shortest turn has aligned the axes, and its gradient, by the
        quaternion."""
        x, y, z, w = Rotation.from_matrix(a.axes.T @ b.axes).as_quat()
        n = w * w + z * z
        gradient = np.array([(w * y + x * z) / n, (y * z - w * x) / n, 1.0])
        angle = 2 * np.arctan2(z, w)
        return (angle + np.pi) % (2 * np.pi) - np.pi, a.axes @ gradient

    @classmethod
    def wrench(cls, d, a, b, u):
        angle, axis = cls.twist(a, b)
        return np.zeros(3), (-d.stiffness * (angle - d.rest) - d.damping * axis @ (b.w - a.w) + u[0]) * axis

    @classmethod
    def lost(cls, d, a, b):
        return d.damping * (cls.twist(a, b)[1] @ (b.w - a.w)) ** 2


class Bushing:
    kind, inputs, frames, key = _core.Bushing, 0, True, "bushings"
    single = False

    @staticmethod
    def make(rng, name, one, two, a, b):
        d = _core.Bushing(name, one.body, one.frame(), two.body, two.frame(), *rng.uniform(5, 20, (4, 3)))
        for which in ("stiffness_coupling", "damping_coupling"):
            coupling = rng.uniform(-0.5, 0.5, (6, 6))
            setattr(d, which, coupling + coupling.T - 2 * np.diag(np.diag(coupling)))
        return d

    @staticmethod
    def deformation(a, b):
        """x, x' and L of x' = L (d', w), in the axes of the first frame, by differences of rotation vectors."""
        turn = Rotation.from_matrix(a.axes.T @ b.axes)
        gap = a.axes.T @ (b.o - a.o)
        w = a.axes.T @ (b.w - a.w)
        rate = a.axes.T @ (b.velocity - a.velocity) - np.cross(a.axes.T @ a.w, gap)
        x = np.concatenate([gap, turn.as_rotvec()])
        L = np.eye(6)
        L[3:, 3:] = np.column_stack(
            [sharp_derivative(lambda t, e=e: (Rotation.from_rotvec(t * e) * turn).as_rotvec(), 0.02) for e in np.eye(3)]
        )
        return x, L @ np.concatenate([rate, w]), L

    @staticmethod
    def matrices(d):
        stiffness = np.diag([*d.stiffness, *d.torsional_stiffness]) + d.stiffness_coupling
        return stiffness, np.diag([*d.damping, *d.torsional_damping]) + d.damping_coupling

    @classmethod
    def wrench(cls, d, a, b, u):
        x, rate, L = cls.deformation(a, b)
        stiffness, damping = cls.matrices(d)
        load = -L.T @ (stiffness @ x + damping @ rate)
        return a.axes @ load[:3], a.axes @ load[3:]

    @classmethod
    def lost(cls, d, a, b):
        _, rate, _ = cls.deformation(a, b)
        return rate @ cls.matrices(d)[1] @ rate


class Bearing:
    kind, inputs, frames, key = _core.Bearing, 0, True, "bearings"
    single = False

    @staticmethod
    def make(rng, name, one, two, a, b):
        constants = (*rng.uniform(5, 20, (2, 3)), *rng.uniform(-3, 3, (2, 2)))
        return _core.Bearing(name, one.body, one.frame(), two.body, two.frame(), *constants)

    @staticmethod
    def state(d, a, b):
        """Displacement, its rate, K and C, in the axes of the first frame."""
        gap = a.axes.T @ (b.o - a.o)
        rate = a.axes.T @ (b.velocity - a.velocity) - np.cross(a.axes.T @ a.w, gap)
        matrices = []
        for diagonal, (xy, yx) in ((d.stiffness, d.cross_stiffness), (d.damping, d.cross_damping)):
            matrices.append(np.diag(diagonal) + np.array([[0, xy, 0], [yx, 0, 0], [0, 0, 0]]))
        return gap, rate, *matrices

    @classmethod
    def wrench(cls, d, a, b, u):
        gap, rate, stiffness, damping = cls.state(d, a, b)
        return a.axes @ -(stiffness @ gap + damping @ rate), np.zeros(3)

    @classmethod
    def lost(cls, d, a, b):
        gap, rate, stiffness, damping = cls.state(d, a, b)
        return rate @ damping @ rate + rate @ (stiffness - stiffness.T) @ gap / 2


class FollowerForce:
    kind, inputs, frames, key = _core.FollowerForce, 6, False, "follower_forces"
    single = True

    @staticmethod
    def make(rng, name, one, two, a, b):
        return _core.FollowerForce(name, two.body, two.origin, *rng.uniform(-5, 5, (2, 3)), two.node)

    @staticmethod
    def wrench(d, a, b, u):
        return b.axes @ (d.force + u[:3]), b.axes @ (d.torque + u[3:])

    @classmethod
    def lost(cls, d, a, b):
        force, torque = cls.wrench(d, a, b, np.zeros(6))
        return -(force @ b.velocity + torque @ b.w)


class Drag:
    kind, inputs, frames, key = _core.Drag, 0, False, "drags"
    single = True

    @staticmethod
    def make(rng, name, one, two, a, b):
        return _core.Drag(name, two.body, two.origin, *rng.uniform(0, 3, (2, 3)), rng.uniform(-1, 1, 3), two.node)

    @staticmethod
    def wrench(d, a, b, u):
        against, w = b.velocity - d.flow, b.w
        force = -np.linalg.norm(against) * b.axes @ (d.coefficient * (b.axes.T @ against))
        return force, -np.linalg.norm(w) * b.axes @ (d.rotational * (b.axes.T @ w))

    @classmethod
    def lost(cls, d, a, b):
        force, torque = cls.wrench(d, a, b, ())
        return -(force @ b.velocity + torque @ b.w)


class PlaneContact:
    kind, inputs, frames, key = _core.PlaneContact, 0, True, "plane_contacts"
    single = False
    surface = (300.0, 0.05, 0.4, 0.3)

    @classmethod
    def make(cls, rng, name, one, two, a, b):
        above = a.axes[:, 2] @ (b.o - a.o)
        surface = _core.ContactSurface(*cls.surface)
        return _core.PlaneContact(
            name, one.body, one.frame(), two.body, two.origin, above + rng.uniform(0.5, 0.7), surface, two.node
        )

    @staticmethod
    def geometry(d, a, b):
        """Penetration, normal, radius of curvature and of body 2."""
        normal = a.axes[:, 2]
        return d.radius - normal @ (b.o - a.o), normal, d.radius, d.radius

    @classmethod
    def contact(cls, d, a, b):
        """Normal force, its elastic part, friction, normal, point of contact from the centre, and velocity there."""
        depth, n, curvature, radius = cls.geometry(d, a, b)
        point = -radius * n
        velocity = b.velocity + np.cross(b.w, point) - (a.velocity + np.cross(a.w, b.o + point - a.o))
        elastic = 4 / 3 * d.surface.modulus * np.sqrt(curvature) * max(depth, 0.0) ** 1.5
        normal = max(elastic * (1 - 1.5 * d.surface.dissipation * n @ velocity), 0.0)
        slip = velocity - n * (n @ velocity)
        friction = -d.surface.friction * normal * slip / np.sqrt(slip @ slip + d.surface.slip_velocity**2)
        return normal, elastic, friction, n, point, velocity

    @classmethod
    def wrench(cls, d, a, b, u):
        normal, _, friction, n, point, _ = cls.contact(d, a, b)
        force = normal * n + friction
        return force, np.cross(point, force)

    @classmethod
    def lost(cls, d, a, b):
        normal, elastic, friction, n, _, velocity = cls.contact(d, a, b)
        return -(normal - elastic) * (n @ velocity) - friction @ velocity


class SphereContact(PlaneContact):
    kind, frames, key = _core.SphereContact, False, "sphere_contacts"

    @classmethod
    def make(cls, rng, name, one, two, a, b):
        apart = np.linalg.norm(b.o - a.o)
        radii = apart * np.array([0.3, 0.7]) + rng.uniform(0.25, 0.35, 2)
        surface = _core.ContactSurface(*cls.surface)
        ends = (one.body, one.origin, radii[0], two.body, two.origin, radii[1])
        return _core.SphereContact(name, *ends, surface, one.node, two.node)

    @staticmethod
    def geometry(d, a, b):
        x = b.o - a.o
        apart = np.linalg.norm(x)
        return d.radius1 + d.radius2 - apart, x / apart, 1 / (1 / d.radius1 + 1 / d.radius2), d.radius2


class CloudContact(PlaneContact):
    kind, key = _core.CloudContact, "cloud_contacts"
    surface = (20.0, 0.05, 0.4, 0.3)

    @classmethod
    def make(cls, rng, name, one, two, a, b):
        above = a.axes[:, 2] @ (b.o - a.o)
        points = [two.origin + x for x in rng.uniform(-0.3, 0.3, (4, 3))]
        surface = _core.ContactSurface(*cls.surface)
        ends = (one.body, one.frame(), two.body, points, above + rng.uniform(1.1, 1.3))
        return _core.CloudContact(name, *ends, surface, two.node)

    @classmethod
    def parts(cls, d, a, b):
        """A plane contact for each point, and where its centre is."""
        for point in d.points2:
            lever = b.axes @ (point - b.origin)
            at = Motion(b.o + lever, b.axes, b.velocity + np.cross(b.w, lever), b.w)
            yield PlaneContact.contact(d, a, at), lever, at

    @classmethod
    def wrench(cls, d, a, b, u):
        force, torque = np.zeros(3), np.zeros(3)
        for (normal, _, friction, n, point, _), lever, _ in cls.parts(d, a, b):
            part = normal * n + friction
            force = force + part
            torque = torque + np.cross(lever + point, part)
        return force, torque

    @classmethod
    def lost(cls, d, a, b):
        return sum(PlaneContact.lost(d, a, at) for _, _, at in cls.parts(d, a, b))


ELEMENTS = {
    model.kind.__name__: model
    for model in (
        LineSpring,
        TableSpring,
        TorsionSpring,
        Bushing,
        Bearing,
        FollowerForce,
        Drag,
        PlaneContact,
        SphereContact,
        CloudContact,
    )
}


# --- systems ---------------------------------------------------------------------------------------------------------


@dataclass
class World:
    """Bodies without joints, some flexible, with one element between two ends of them."""

    model: type
    definition: _core.Multibody
    without: _core.Multibody
    element: object
    ends: tuple
    clouds: dict
    q: np.ndarray
    v: np.ndarray

    def __post_init__(self):
        self.system, self.bare = _core.System(self.definition), _core.System(self.without)

    @property
    def count(self):
        return len(self.definition.bodies)

    def pose(self, q, end):
        return pose_of(self.system, self.clouds, q, end)

    def motion(self, q, v, end):
        """Exact for a rigid body, else by differences."""
        if end.body == GROUND or end.body not in self.clouds:
            return rigid_motion(q[7 * end.body :][:7], v[6 * end.body :][:6], end)
        return moved(lambda t: self.pose(self.system.compose(q, t * v), end), end.origin)

    def motions(self, q, v):
        return [self.motion(q, v, end) for end in self.ends]

    def inputs(self, own):
        return np.concatenate([np.zeros(self.bare.input_size), own])

    def forces(self, q, v, own):
        """Generalized forces of the element alone."""
        zero = np.zeros_like(v)
        none = np.zeros(self.bare.input_size)
        with_it = self.system.residual(q, v, zero, np.zeros(0), self.inputs(own))
        return self.bare.residual(q, v, zero, np.zeros(0), none) - with_it


def moved(pose_at, origin):
    """Motion of a frame from its pose as a function of time."""
    at = pose_at(0.0)
    rate = sharp_derivative(pose_at)
    turning = rate[:3, :3] @ at[:3, :3].T
    return Motion(at[:3, 3], at[:3, :3], rate[:3, 3], np.array([turning[2, 1], turning[0, 2], turning[1, 0]]), origin)


def pose_of(system, clouds, q, end):
    """Of a frame in W."""
    at = np.eye(4)
    if end.body != GROUND:
        place = q[7 * end.body : 7 * end.body + 7]
        at = pose(place[:3], rotation_of(place).as_matrix())
    if end.node != FLOATING:
        start = 7 * (len(q) - system.modal_count) // 7 + system.modal_index(end.body)
        at = at @ clouds[end.body].frame(end.node, q[start : start + system.modes(end.body)])
    return at @ frame_pose(end.frame())


BETWEEN = {
    "two bodies": ((0, FLOATING), (1, FLOATING)),
    "ground and body": ((GROUND, FLOATING), (0, FLOATING)),
    "body and ground": ((0, FLOATING), (GROUND, FLOATING)),
    "node and body": ((0, 2), (1, FLOATING)),
    "two nodes": ((0, 2), (1, 4)),
    "ground and node": ((GROUND, FLOATING), (0, 3)),
}


def make_world(rng, model, between, speed=1.0):
    """Two bodies at random places; those with nodes are flexible."""
    definition, without, clouds = _core.Multibody(), _core.Multibody(), {}
    ends = BETWEEN[between]
    if model.single and ends[1][0] == GROUND:
        ends = ends[::-1]
    zetas = []
    for i in range(2):
        if (i, FLOATING) in ends or i not in (ends[0][0], ends[1][0]):
            body = random_body(rng, f"body{i}")
        else:
            clouds[i] = random_cloud(rng, modes=int(rng.integers(1, 4)))
            zetas.append(rng.uniform(-0.3, 0.3, clouds[i].modes))
            body = flexible_body(clouds[i], f"body{i}")
        definition.add(body), without.add(body)
    q = np.concatenate([coordinates(random_pose(rng), random_pose(rng)), *zetas])
    bare = _core.System(without)
    v = rng.uniform(-speed, speed, bare.velocity_size)
    turns = [Rotation.random(rng=rng).as_matrix() if model.frames else np.eye(3) for _ in range(2)]
    if model.kind in (_core.PlaneContact, _core.CloudContact):
        turns[1] = np.eye(3)
    ends = [End(*end, rng.uniform(-0.5, 0.5, 3), turn) for end, turn in zip(ends, turns, strict=True)]
    poses = [pose_of(bare, clouds, q, end) for end in ends]
    apart = poses[1][:3, 3] - poses[0][:3, 3]
    if np.linalg.norm(apart) < 0.4:  # near the singularity of what needs a direction
        return make_world(rng, model, between, speed)
    if model.kind in (_core.PlaneContact, _core.CloudContact) and poses[0][:3, 2] @ apart < 0.2:
        return make_world(rng, model, between, speed)
    relative = Rotation.from_matrix(poses[0][:3, :3].T @ poses[1][:3, :3])
    if model.kind in (_core.TorsionSpring, _core.Bushing) and relative.magnitude() > 2.6:
        return make_world(rng, model, between, speed)
    world = World(model, without, without, None, tuple(ends), clouds, q, v)
    element = model.make(rng, "element", *ends, *world.motions(q, v))
    definition.add(element)
    return World(model, definition, without, element, tuple(ends), clouds, q, v)


__all__ = [
    "BETWEEN",
    "ELEMENTS",
    "GROUND",
    "End",
    "Motion",
    "World",
    "hat",
    "make_world",
    "rigid_motion",
    "sharp_derivative",
]
