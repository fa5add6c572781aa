"""Flexible bodies: against the sums over their nodes, against rigid bodies, derivatives, energy, projections.

A flexible body has nodes at r_i = x + R (X_i + Phi_i ζ); q and v have ζ and ζ' of all flexible bodies at their ends.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .clouds import FLOATING, beam, flexible_body, random_cloud
from .helpers import (
    COORDINATES,
    DIFFERENCES,
    EPS,
    EQUATIONS,
    GROUND,
    JOINT_TYPES,
    Rotation,
    assert_close,
    coordinates,
    derivative,
    frame_pose,
    jacobian,
    make_joint,
    null_space,
    pose,
    property_test,
    random_body,
    random_frame,
    random_pose,
    relative_pose,
    rotation_of,
    second_derivative,
    seeds,
    to_touching_point,
)

Type = _core.JointType
FRAME = _core.Frame(np.zeros(3), np.eye(3))


# --- one body ---------------------------------------------------------------------------------------------------------


def split(q, v):
    """R, w, ζ, ζ' of a system of one flexible body."""
    return rotation_of(q).as_matrix(), v[3:6], q[7:], v[6:]


def random_state(rng, cloud, speed=2.0):
    q = np.concatenate([coordinates(random_pose(rng)), rng.uniform(-0.5, 0.5, cloud.modes)])
    return q, rng.uniform(-speed, speed, 6 + cloud.modes)


def one_body(rng, cloud, gravity, as_matrix=True):
    definition = _core.Multibody()
    definition.gravity = gravity
    definition.add(flexible_body(cloud, as_matrix=as_matrix))
    return _core.System(definition)


@property_test(50, seed=seeds)
def test_accelerations_of_the_nodes_of_the_model_beside(seed):
    """The NumPy model itself: J_i vdot + bias is the second derivative of r_i along a motion."""
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng)
    q, v = random_state(rng, cloud, 1.0)
    vdot = rng.uniform(-1, 1, len(v))
    turn, w, zeta, zetadot = split(q, v)
    system = one_body(rng, cloud, np.zeros(3))

    def places(t):
        at = system.compose(q, t * v + 0.5 * t * t * vdot)
        return at[:3] + cloud.places(at[7:]) @ rotation_of(at).as_matrix().T

    expected = cloud.jacobians(turn, zeta) @ vdot + cloud.bias(turn, w, zeta, zetadot)
    assert_close(second_derivative(places), expected, 1e-9)
    assert_close(derivative(places), cloud.jacobians(turn, zeta) @ v, DIFFERENCES)


@property_test(100, seed=seeds)
def test_mass_matrix_residual_and_energy_are_sums_over_the_nodes(seed):
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng, modes=int(rng.integers(0, 6)))
    gravity = rng.uniform(-10, 10, 3)
    system = one_body(rng, cloud, gravity)
    q, v = random_state(rng, cloud)
    vdot, inputs = rng.uniform(-2, 2, len(v)), rng.uniform(-5, 5, 6)
    turn, w, zeta, zetadot = split(q, v)

    mass, _, _ = system.linearization(q, v, np.zeros(0), inputs, vdot)
    assert_close(mass, cloud.mass_matrix(turn, zeta), 32 * EPS)
    expected = cloud.inertial_force(turn, w, zeta, zetadot, vdot, gravity)
    expected[6:] += cloud.stiffness @ zeta + cloud.damping @ zetadot
    expected[:6] -= inputs
    assert_close(system.residual(q, v, vdot, np.zeros(0), inputs), expected, 64 * EPS, 10.0)

    velocities = cloud.jacobians(turn, zeta) @ v
    places = q[:3] + cloud.places(zeta) @ turn.T
    energy = 0.5 * np.einsum("ij,ik,jk", cloud.mass, velocities, velocities) + 0.5 * zeta @ cloud.stiffness @ zeta
    energy -= cloud.mass.sum(axis=0) @ places @ gravity
    assert_close(system.energy(q, v), energy, 64 * EPS, 10.0)
    for node in range(len(cloud.nodes)):
        assert_close(system.node_position(q, 0, node), places[node], 8 * EPS)


@property_test(20, seed=seeds)
def test_lumped_masses_are_a_diagonal_mass_matrix(seed):
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng, lumped=True)
    q, v = random_state(rng, cloud)
    vdot, gravity = rng.uniform(-2, 2, len(v)), rng.uniform(-10, 10, 3)
    one, other = (one_body(rng, cloud, gravity, as_matrix) for as_matrix in (True, False))
    arguments = (q, v, vdot, np.zeros(0), np.zeros(6))
    assert_close(one.residual(*arguments), other.residual(*arguments), 16 * EPS)


def test_rayleigh_damping():
    rng = np.random.default_rng(3)
    cloud = random_cloud(rng)
    q, v = random_state(rng, cloud)
    zero = np.zeros(len(v))
    definition = _core.Multibody()
    definition.add(flexible_body(cloud))
    before = _core.System(definition).residual(q, v, zero, np.zeros(0), np.zeros(6))
    definition.body(0).modal.mass_damping, definition.body(0).modal.stiffness_damping = 0.3, 0.02
    after = _core.System(definition).residual(q, v, zero, np.zeros(0), np.zeros(6))
    modal_mass = cloud.mass_matrix(np.eye(3), q[7:])[6:, 6:]
    expected = np.zeros(len(v))
    expected[6:] = (0.3 * modal_mass + 0.02 * cloud.stiffness) @ v[6:]
    assert_close(after - before, expected, 32 * EPS, 10.0)


# --- beside rigid bodies ----------------------------------------------------------------------------------------------


def rigid_of(cloud, zeta):
    """The rigid body of the cloud in a deformed shape, its centre of mass in the cloud's frame."""
    masses, places = cloud.mass.sum(axis=0), cloud.places(zeta)
    centre = masses @ places / masses.sum()
    moments = np.einsum("ij,ik,jl->kl", cloud.mass, places - centre, places - centre)
    inertia = np.trace(moments) * np.eye(3) - moments
    body = _core.RigidBody()
    body.name, body.mass = "rigid", masses.sum()
    body.inertia, body.inertia_products = np.diag(inertia), inertia[[0, 0, 1], [1, 2, 2]]
    return body, centre


@property_test(50, seed=seeds)
def test_a_body_without_modes_moves_as_the_rigid_body(seed):
    """Steiner's theorem: the same motion and reaction, seen from the frame and from the centre of mass."""
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng, modes=0)
    body, centre = rigid_of(cloud, np.zeros(0))
    ground, at, gravity = random_frame(rng), random_frame(rng), rng.uniform(-10, 10, 3)
    kind = JOINT_TYPES[rng.integers(len(JOINT_TYPES))]
    from_centre = _core.Frame(at.origin - centre, at.axes)
    systems = []
    for part, frame in ((flexible_body(cloud), at), (body, from_centre)):
        definition = _core.Multibody()
        definition.gravity = gravity
        definition.add(part)
        definition.add(make_joint("joint", kind, GROUND, ground, 0, frame))
        systems.append(_core.System(definition))
    placed = frame_pose(ground) @ relative_pose(kind, rng.uniform(-1, 1, 3)) @ np.linalg.inv(frame_pose(at))
    turn = placed[:3, :3]
    q = coordinates(placed)
    q_rigid = coordinates(placed @ pose(centre, np.eye(3)))
    v = systems[0].project_velocities(q, rng.uniform(-2, 2, 6))
    v_rigid = np.concatenate([v[:3] + turn @ np.cross(v[3:], centre), v[3:]])
    inputs = np.zeros(systems[0].input_size)
    force, torque = rng.uniform(-5, 5, (2, 3))  # at the frame's origin, in W and in B
    inputs[:6] = np.concatenate([force, torque])
    inputs_rigid = inputs.copy()
    inputs_rigid[3:6] += np.cross(-centre, turn.T @ force)

    vdot, multipliers = systems[0].accelerations(q, v, inputs)
    expected, their_multipliers = systems[1].accelerations(q_rigid, v_rigid, inputs_rigid)
    w, wdot = v[3:], vdot[3:]
    moved = vdot[:3] + turn @ (np.cross(wdot, centre) + np.cross(w, np.cross(w, centre)))
    scale = 1 + np.abs(multipliers).max(initial=0)
    assert_close(np.concatenate([moved, wdot]), expected, 1e-11, scale)
    assert_close(multipliers, their_multipliers, 1e-11, scale)
    assert_close(systems[0].energy(q, v), systems[1].energy(q_rigid, v_rigid), 64 * EPS, 10.0)


@property_test(50, seed=seeds)
def test_frozen_modes_leave_the_rigid_body_of_the_deformed_shape(seed):
    """ζ' = ζ'' = 0: power of the residual's frame rows in any motion is that of the rigid body."""
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng)
    gravity = rng.uniform(-10, 10, 3)
    system = one_body(rng, cloud, gravity)
    q, v = random_state(rng, cloud)
    vdot = rng.uniform(-2, 2, len(v))
    v[6:], vdot[6:] = 0, 0
    body, centre = rigid_of(cloud, q[7:])
    definition = _core.Multibody()
    definition.gravity = gravity
    definition.add(body)
    turn, w = rotation_of(q).as_matrix(), v[3:6]

    def at_centre(twist, bias=0.0):
        return np.concatenate([twist[:3] + turn @ (np.cross(twist[3:6], centre) + bias), twist[3:6]])

    rigid = _core.System(definition).residual(
        np.concatenate([q[:3] + turn @ centre, q[3:7]]),
        at_centre(v),
        at_centre(vdot, np.cross(w, np.cross(w, centre))),
        np.zeros(0),
        np.zeros(6),
    )
    flexible = system.residual(q, v, vdot, np.zeros(0), np.zeros(6))
    for motion in np.eye(6):
        assert_close(flexible[:6] @ motion, rigid @ at_centre(motion), 128 * EPS, 10.0)


# --- mechanisms -------------------------------------------------------------------------------------------------------


@dataclass
class Tree:
    """Rigid and flexible bodies in a configuration q that satisfies the joints' equations."""

    definition: _core.Multibody
    clouds: dict  # body → Cloud
    q: np.ndarray
    springs: list  # ((body, node, point), (body, node, point), stiffness, damping)
    loads: list  # (body, force, torque)

    def system(self):
        return _core.System(self.definition)

    def zeta(self, system, q, body):
        start = 7 * len(self.definition.bodies) + system.modal_index(body)
        return q[start : start + system.modes(body)]

    def frame(self, system, q, body, node):
        """Pose in W of a body, of one of its nodes or of the ground."""
        if body == GROUND:
            return np.eye(4)
        place = q[7 * body : 7 * body + 7]
        result = pose(place[:3], rotation_of(place).as_matrix())
        return result if node == FLOATING else result @ self.clouds[body].frame(node, self.zeta(system, q, body))


def random_tree(rng, kinds, flexible):
    """Each body hangs on one before it or on the ground, by joints of the given kinds; `flexible`: which bodies are."""
    count = len(kinds)
    tree = Tree(_core.Multibody(), {}, np.zeros(0), [], [])
    tree.definition.gravity = rng.uniform(-10, 10, 3)
    poses, zetas = {GROUND: np.eye(4)}, {}
    for i in range(count):
        if i in flexible:
            tree.clouds[i] = random_cloud(rng, modes=int(rng.integers(1, 4)))
            zetas[i] = rng.uniform(-0.5, 0.5, tree.clouds[i].modes)
            tree.definition.add(flexible_body(tree.clouds[i], f"body{i}"))
        else:
            tree.definition.add(random_body(rng, f"body{i}"))

    def end(body):
        node = int(rng.integers(-1, 6)) if body in tree.clouds else FLOATING
        frame = random_frame(rng)
        in_body = np.eye(4) if node == FLOATING else tree.clouds[body].frame(node, zetas[body])
        return _core.Frame(frame.origin, frame.axes, node), in_body @ frame_pose(frame)

    for i, kind in enumerate(kinds):
        parent = int(rng.integers(-1, i))
        (one, place1), (two, place2) = end(parent), end(i)
        relative = relative_pose(kind, rng.uniform(-1, 1, 3))
        joint = (parent, one, i, two)
        poses[i] = poses[parent] @ place1 @ relative @ np.linalg.inv(place2)
        if rng.random() < 0.5:  # the other way round
            joint = (i, two, parent, one)
            poses[i] = poses[parent] @ place1 @ np.linalg.inv(relative) @ np.linalg.inv(place2)
        tree.definition.add(make_joint(f"joint{i}", kind, *joint))
    tree.q = np.concatenate([coordinates(*(poses[i] for i in range(count))), *zetas.values()])
    for i in range(3):
        ends = []
        for body in rng.choice(range(-1, count), 2, replace=False):
            node = int(rng.integers(-1, 6)) if body in tree.clouds else FLOATING
            ends.append((int(body), node, rng.uniform(-0.5, 0.5, 3)))
        (one, node1, point1), (two, node2, point2) = ends
        constants = rng.uniform(0, 20, (2, 3))
        tree.springs.append((*ends, *constants))
        tree.definition.add(_core.SpringDamper(f"spring{i}", one, point1, two, point2, *constants, node1, node2))
    for i in range(2):
        tree.loads.append((int(rng.integers(count)), *rng.uniform(-5, 5, (2, 3))))
        tree.definition.add(_core.Load(f"load{i}", *tree.loads[-1]))
    for i, kind in enumerate(kinds):
        for k in range(COORDINATES.get(kind, 0)):
            if rng.random() < 0.5:
                tree.definition.add(_core.JointSpring(i, *rng.uniform(0, 5, 3), k))
    return tree


SETS = {"one": {0}, "first": {0, 1}, "last": {2}, "all": {0, 1, 2}}


def make_tree(seed, kind=None, flexible=None):
    rng = np.random.default_rng(seed)
    chosen = list(SETS.values())[seed % len(SETS)] if flexible is None else flexible
    kinds = [JOINT_TYPES[rng.integers(len(JOINT_TYPES))] if kind is None else kind for _ in range(3)]
    return rng, random_tree(rng, kinds, chosen)


@pytest.mark.parametrize("kind", JOINT_TYPES, ids=lambda t: t.name)
@property_test(25, seed=seeds)
def test_derivatives_of_constraints_at_nodes(kind, seed):
    """B = dΦ/d(motion), Φ' = B v, Z = dΦ'/d(motion), Φ'' = B v' + Z v, assembled or not."""
    rng, tree = make_tree(seed, kind)
    system = tree.system()
    size = system.velocity_size
    q = system.compose(tree.q, 0.2 * rng.uniform(-1, 1, size))
    v, vdot = rng.uniform(-1, 1, (2, size))
    _, rate, gradient, rate_gradient = system.constraints(q, v)
    assert_close(system.constraints(tree.q, v)[0], np.zeros(system.constraint_size), 100 * EPS)
    of_velocities = system.velocity_equations  # alone: they have no Φ
    of_positions = np.setdiff1d(np.arange(system.constraint_size), of_velocities)
    by_motion = jacobian(lambda x: system.constraints(system.compose(q, x), v)[0], size)
    assert_close(gradient[of_positions], by_motion[of_positions], DIFFERENCES)
    assert_close(rate_gradient, jacobian(lambda x: system.constraints(system.compose(q, x), v)[1], size), DIFFERENCES)
    assert_close(rate, gradient @ v, 32 * EPS)
    moved = lambda t: (system.compose(q, t * v + 0.5 * t * t * vdot), v + t * vdot)  # noqa: E731
    second = second_derivative(lambda t: system.constraints(*moved(t))[0])
    second[of_velocities] = derivative(lambda t: system.constraints(*moved(t))[1])[of_velocities]
    assert_close(gradient @ vdot + rate_gradient @ v, second, 1e-9)


@pytest.mark.parametrize("kind", COORDINATES, ids=lambda t: t.name)
@property_test(10, seed=seeds)
def test_accelerations_of_coordinates_at_nodes(kind, seed):
    """Derivatives of their rates along a motion with these accelerations."""
    rng, tree = make_tree(seed, kind)
    system = tree.system()
    v, vdot = rng.uniform(-1, 1, (2, system.velocity_size))
    for joint in range(3):
        for k in range(COORDINATES[kind]):
            expected = derivative(
                lambda t, at=(joint, k): system.coordinate(
                    system.compose(tree.q, t * v + 0.5 * t * t * vdot), v + t * vdot, *at
                )[1]
            )
            assert_close(system.coordinate_acceleration(tree.q, v, vdot, joint, k), expected, DIFFERENCES)


@pytest.mark.parametrize("kind", JOINT_TYPES, ids=lambda t: t.name)
@property_test(25, seed=seeds)
def test_mass_damping_and_stiffness_are_derivatives_of_the_residual(kind, seed):
    """With motors, actuators, springs, loads and gravity; K holds d(M vdot)/d(motion)."""
    rng, tree = make_tree(seed, kind)
    system = tree.system()
    size = system.velocity_size
    # Angles of joints, on which springs act, mean something where the joints' equations hold.
    q = tree.q if tree.definition.joint_springs else system.compose(tree.q, 0.2 * rng.uniform(-1, 1, size))
    v, vdot = rng.uniform(-1, 1, (2, size))
    multipliers = rng.uniform(-10, 10, system.constraint_size)
    inputs = rng.uniform(-10, 10, system.input_size)
    mass, damping, stiffness = system.linearization(q, v, multipliers, inputs, vdot)

    def residual(x=0.0, dv=0.0, dvdot=0.0):
        return system.residual(system.compose(q, x + np.zeros(size)), v + dv, vdot + dvdot, multipliers, inputs)

    scale = np.abs(residual()).max()
    assert_close(mass, mass.T, 4 * EPS)
    assert_close(mass, jacobian(lambda x: residual(dvdot=x), size), DIFFERENCES, scale)
    assert_close(damping, jacobian(lambda x: residual(dv=x), size), DIFFERENCES, scale)
    assert_close(stiffness, jacobian(lambda x: residual(x=x), size), DIFFERENCES, scale)


def test_the_linearization_of_flexible_bodies_needs_accelerations():
    _, tree = make_tree(0)
    system = tree.system()
    zero = np.zeros(system.velocity_size)
    with pytest.raises(ValueError, match="needs vdot"):
        system.linearization(tree.q, zero, np.zeros(system.constraint_size), np.zeros(system.input_size))


def moving(seed):
    """A tree with velocities that its joints allow, and inputs."""
    rng, tree = make_tree(seed)
    system = tree.system()
    v = system.project_velocities(tree.q, rng.uniform(-1, 1, system.velocity_size))
    return rng, tree, system, v, rng.uniform(-5, 5, system.input_size)


KKT = 1e-10
"""Accuracy of a solution of the KKT system of a random tree: its condition is below 1e5, with a reserve of 10."""


@property_test(100, seed=seeds)
def test_accelerations_satisfy_the_equations_of_motion(seed):
    _, tree, system, v, inputs = moving(seed)
    vdot, multipliers = system.accelerations(tree.q, v, inputs)
    _, rate, gradient, rate_gradient = system.constraints(tree.q, v)
    assert_close(rate, np.zeros_like(rate), 100 * EPS)
    force = np.abs(gradient.T @ multipliers).max(initial=1.0) + np.abs(vdot).max()
    assert_close(system.residual(tree.q, v, vdot, multipliers, inputs), np.zeros_like(v), KKT, force)
    assert_close(gradient @ vdot, -rate_gradient @ v, KKT, force)


def power(tree, system, q, v, inputs):
    """Power of loads and inputs less what the dampers take: rates are differences of places, taken from the clouds."""
    count = len(tree.definition.bodies)
    total = inputs[: 6 * count] @ v[: 6 * count]
    for body, force, torque in tree.loads:
        total += force @ v[6 * body : 6 * body + 3]
        total += torque @ rotation_of(q[7 * body : 7 * body + 7]).apply(v[6 * body + 3 : 6 * body + 6])
    for body, cloud in tree.clouds.items():
        start = 6 * count + system.modal_index(body)
        rates = v[start : start + cloud.modes]
        total -= rates @ cloud.damping @ rates
    for i, (one, two, _, damping) in enumerate(tree.springs):

        def gap(t, one=one, two=two):
            at = system.compose(q, t * v)
            ends = [(tree.frame(system, at, body, node) @ [*point, 1.0])[:3] for body, node, point in (one, two)]
            return ends[1] - ends[0]

        rate = derivative(gap)
        actuator = inputs[system.actuator_index(i) : system.actuator_index(i) + 3]
        total += actuator @ rate - damping @ rate**2
    for i, joint in enumerate(tree.definition.joints):
        for k in range(COORDINATES.get(joint.type, 0)):
            rate = derivative(lambda t, i=i, k=k: system.coordinate(system.compose(q, t * v), v, i, k)[0])
            total += inputs[system.motor_index(i, k)] * rate
            for spring in tree.definition.joint_springs:
                if (spring.joint, spring.coordinate) == (i, k):
                    total -= spring.damping * rate**2
    return total


@property_test(100, seed=seeds)
def test_energy_changes_by_the_power_of_inputs_loads_and_dampers(seed):
    _, tree, system, v, inputs = moving(seed)
    vdot, _ = system.accelerations(tree.q, v, inputs)
    rate = derivative(lambda t: system.energy(system.compose(tree.q, t * v), v + t * vdot))
    size = abs(system.energy(tree.q, v)) + np.abs(vdot).max() ** 2  # what is differentiated
    assert_close(rate, power(tree, system, tree.q, v, inputs), 1e-10, size)


@property_test(50, seed=seeds)
def test_reaction_is_the_force_on_the_node(seed):
    """Its power in a motion of body 2 alone is -(B v)ᵀλ, the motion of the joint's point taken from the clouds."""
    rng, tree, system, v, _ = moving(seed)
    multipliers = rng.uniform(-10, 10, system.constraint_size)
    gradient = system.constraints(tree.q, v)[2]
    count = len(tree.definition.bodies)
    row = 0
    for i, joint in enumerate(tree.definition.joints):
        rows = EQUATIONS[joint.type]
        share = np.zeros_like(multipliers)
        share[row : row + rows] = multipliers[row : row + rows]
        row += rows
        if joint.body2 == GROUND:
            continue
        motion = np.zeros(system.velocity_size)
        motion[6 * joint.body2 : 6 * joint.body2 + 6] = rng.uniform(-1, 1, 6)
        if joint.body2 in tree.clouds:
            start = 6 * count + system.modal_index(joint.body2)
            motion[start : start + system.modes(joint.body2)] = rng.uniform(-1, 1, system.modes(joint.body2))

        def at(t, motion=motion, joint=joint):
            frame = tree.frame(system, system.compose(tree.q, t * motion), joint.body2, joint.frame2.node)
            return frame @ frame_pose(joint.frame2)

        velocity = derivative(lambda t: at(t)[:3, 3])
        spin = derivative(lambda t: at(t)[:3, :3]) @ at(0.0)[:3, :3].T
        angular = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        if joint.type == Type.rolling_disk:  # where that acts
            frame1 = tree.frame(system, tree.q, joint.body1, joint.frame1.node) @ frame_pose(joint.frame1)
            velocity = velocity + np.cross(angular, to_touching_point(frame1[:3, :3], at(0.0)[:3, :3]))
        force, torque = system.reaction(tree.q, v, multipliers, i)
        assert_close(force @ velocity + torque @ angular, -share @ gradient @ motion, 1e-10, 10.0)


@property_test(50, seed=seeds)
def test_projections(seed):
    """Onto the constraints, and the change is orthogonal to all free motions in the metric of M(q)."""
    rng, tree, system, _, inputs = moving(seed)
    size = system.velocity_size
    zero = np.zeros(size)
    before = rng.uniform(-1, 1, size)
    after = system.project_velocities(tree.q, before)
    gradient = system.constraints(tree.q, after)[2]
    mass = system.linearization(tree.q, zero, np.zeros(system.constraint_size), inputs, zero)[0]
    allowed = null_space(gradient)
    assert_close(gradient @ after, np.zeros(len(gradient)), 64 * EPS)
    assert_close(allowed.T @ mass @ (after - before), np.zeros(allowed.shape[1]), KKT)
    q = system.project_positions(system.compose(tree.q, 0.05 * rng.uniform(-1, 1, size)))
    assert np.abs(system.constraints(q, zero)[0]).max() <= 1e-12 * (1 + np.abs(q).max())

    moved = 1e-4 * rng.uniform(-1, 1, size)
    q = system.project_positions(system.compose(tree.q, moved))
    count = len(tree.definition.bodies)
    change = []
    for one, two in zip(tree.q[: 7 * count].reshape(-1, 7), q[: 7 * count].reshape(-1, 7), strict=True):
        change += [*(two[:3] - one[:3]), *(rotation_of(one).inv() * rotation_of(two)).as_rotvec()]
    change = np.concatenate([change, q[7 * count :] - tree.q[7 * count :]]) - moved
    work = allowed.T @ mass @ change
    assert np.abs(work).max(initial=0.0) <= 1000 * 1e-8  # of second order in the displacement


@property_test(25, seed=seeds)
def test_jerk_is_the_rate_of_the_accelerations(seed):
    _, tree, system, v, inputs = moving(seed)
    vdot, _ = system.accelerations(tree.q, v, inputs)

    def accelerations(t):
        return system.accelerations(system.compose(tree.q, t * v + 0.5 * t * t * vdot), v + t * vdot, inputs)[0]

    expected = derivative(accelerations, 2e-4)
    assert_close(system.jerk(tree.q, v, inputs), expected, 1e-6, np.abs(vdot).max())


@property_test(25, seed=seeds)
def test_initial_values_are_assembled(seed):
    """A start near the constraints is moved onto them; one on them is kept, modal coordinates and rates included."""
    rng, tree, system, v, _ = moving(seed)
    definition = tree.definition

    def start_at(q, v):
        for i in range(3):
            body = definition.body(i)
            body.initial_position, body.initial_quaternion = q[7 * i : 7 * i + 3], q[7 * i + 3 : 7 * i + 7]
            body.initial_velocity, body.initial_angular_velocity = v[6 * i : 6 * i + 3], v[6 * i + 3 : 6 * i + 6]
            if i in tree.clouds:
                body.modal.initial_coordinates = tree.zeta(system, q, i)
                first = 18 + system.modal_index(i)
                body.modal.initial_rates = v[first : first + system.modes(i)]
        return _core.assemble(definition)

    q, u = start_at(tree.q, v)
    assert_close(q, tree.q, 1e-13)
    assert_close(u, v, 1e-12)
    size = system.velocity_size
    q, u = start_at(system.compose(tree.q, 0.02 * rng.uniform(-1, 1, size)), v)
    phi, rate, _, _ = system.constraints(q, u)
    assert np.abs(phi).max() <= 1e-12 * (1 + np.abs(q).max())
    assert_close(rate, np.zeros_like(rate), 100 * EPS)


def test_initial_modal_values_are_zero_unless_given():
    definition, _ = flexible_pendulum()
    q, v = _core.assemble(definition)
    np.testing.assert_array_equal(q, [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(v, [0, 0, 0, 2, -3, 6, 0, 0, 0, 0])


def test_layout_of_positions_and_velocities():
    _, tree = make_tree(1, flexible={0, 2})
    system = tree.system()
    modes = [tree.clouds[i].modes if i in tree.clouds else 0 for i in range(3)]
    assert [system.modes(i) for i in range(3)] == modes
    assert [system.modal_index(i) for i in range(3)] == [0, -1, modes[0]]
    assert system.modal_count == sum(modes)
    assert (system.position_size, system.velocity_size) == (21 + sum(modes), 18 + sum(modes))


# --- a pendulum -------------------------------------------------------------------------------------------------------


def flexible_pendulum():
    """A beam of 1 m and 1 kg on a spherical joint at its end; bending in y and z with xi² and xi³."""
    terms = [(lambda s: s**2, lambda s: 2 * s), (lambda s: s**3, lambda s: 3 * s**2)]
    plane = np.array([[4.0, 6.0], [6.0, 12.0]])
    stiffness = np.block([[8 * plane, np.zeros((2, 2))], [np.zeros((2, 2)), 12 * plane]])
    cloud = beam(1.0, 1.0, 0.02, terms, stiffness)
    definition = _core.Multibody()
    definition.gravity = np.array([0.0, 0.0, -9.81])
    body = flexible_body(cloud)
    body.initial_angular_velocity = np.array([2.0, -3.0, 6.0])
    definition.add(body)
    definition.add(_core.Joint("pivot", Type.spherical, GROUND, FRAME, 0, FRAME))
    return definition, cloud


def quaternion_rate(quaternion, w):
    q0, vector = quaternion[0], quaternion[1:]
    return 0.5 * np.concatenate([[-vector @ w], q0 * w + np.cross(vector, w)])


def test_pendulum_against_sums_over_the_nodes():
    """Its accelerations, integrated by SciPy, keep the energy and end where the nodes' equations for (w, ζ) end."""
    definition, cloud = flexible_pendulum()
    system = _core.System(definition)
    gravity = definition.gravity
    inputs = np.zeros(system.input_size)
    stop, accuracy = 0.3, {"rtol": 1e-11, "atol": 1e-11, "method": "DOP853"}

    def ours(_, x):
        q, v = x[:11], x[11:]
        vdot, _ = system.accelerations(q, v, inputs)
        return np.concatenate([v[:3], quaternion_rate(q[3:7], v[3:6]), v[6:], vdot])

    def nodal(_, x):
        quaternion, zeta, w, zetadot = x[:4], x[4:8], x[8:11], x[11:]
        turn = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
        j = cloud.jacobians(turn, zeta)[:, :, 3:]
        masses = np.diag(cloud.mass)
        mass = np.einsum("i,ika,ikb->ab", masses, j, j)
        force = np.einsum("i,ika,ik->a", masses, j, gravity - cloud.bias(turn, w, zeta, zetadot))
        force[3:] -= cloud.stiffness @ zeta
        return np.concatenate([quaternion_rate(quaternion, w), zetadot, np.linalg.solve(mass, force)])

    turning = np.array([1.0, 0, 0, 0, 0, 0, 0, 0, 2.0, -3.0, 6.0, 0, 0, 0, 0])  # quaternion, ζ, w, ζ'
    still = np.zeros(3)
    start = np.concatenate([still, turning[:8], still, turning[8:]])
    x = solve_ivp(ours, (0, stop), start, **accuracy).y[:, -1]
    expected = solve_ivp(nodal, (0, stop), turning, **accuracy).y[:, -1]
    at = np.concatenate([x[3:11], x[14:]])
    assert np.abs(at[4:8]).max() > 0.01  # it bends
    assert_close(at, expected, 1e-8)
    assert_close(system.energy(x[:11], x[11:]), system.energy(start[:11], start[11:]), 1e-9)
