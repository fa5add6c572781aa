"""The assembled equations of motion: derivatives, accelerations, energy, projections, messages."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    COORDINATES,
    DIFFERENCES,
    EPS,
    GROUND,
    MODELS,
    Rotation,
    assert_close,
    derivative,
    jacobian,
    mass_matrix,
    null_space,
    property_test,
    random_body,
    random_coordinates,
    random_frame,
    random_tree,
    rotation_of,
    seeds,
)

Type = _core.JointType


def bodies_of(definition):
    return len(definition.bodies)


# --- M, C, K ---------------------------------------------------------------------------------------------------------


def check_linearization(definition, q, v, rng, force):
    """M, C, K against differences of the residual, with multipliers and inputs of size `force`."""
    system = _core.System(definition)
    size = system.velocity_size
    vdot = rng.uniform(-1, 1, size)
    multipliers = force * rng.uniform(-1, 1, system.constraint_size)
    inputs = force * rng.uniform(-1, 1, system.input_size)
    mass, damping, stiffness = system.linearization(q, v, multipliers, inputs)

    def residual(x=0.0, dv=0.0, dvdot=0.0):
        return system.residual(system.compose(q, x + np.zeros(size)), v + dv, vdot + dvdot, multipliers, inputs)

    scale = np.abs(residual()).max()
    assert_close(mass, mass_matrix(definition), 4 * EPS)
    assert_close(mass, jacobian(lambda x: residual(dvdot=x), size), DIFFERENCES, scale)
    assert_close(damping, jacobian(lambda x: residual(dv=x), size), DIFFERENCES, scale)
    assert_close(stiffness, jacobian(lambda x: residual(x=x), size), DIFFERENCES, scale)


@pytest.mark.parametrize("model", MODELS)
@property_test(50, seed=seeds)
def test_linearization_of_the_mechanisms(model, seed):
    """In any configuration, assembled or not, at moderate velocities and at the initial ones."""
    rng = np.random.default_rng(seed)
    definition = _core.mechanism(model).multibody
    count = bodies_of(definition)
    q = random_coordinates(rng, count)
    check_linearization(definition, q, rng.uniform(-1, 1, 6 * count), rng, 10.0)
    start = [[*body.initial_velocity, *body.initial_angular_velocity] for body in definition.bodies]
    check_linearization(definition, q, np.concatenate(start), rng, 10.0)


def anywhere(rng, tree):
    """Any q, but for disks that nearly lie flat: there derivatives of high order are large."""
    disks = [sides for kind, *sides in tree.joints if kind == Type.rolling_disk]
    while True:
        q = random_coordinates(rng, bodies_of(tree.definition))
        if all(tilt(q, *sides) > 0.3 for sides in disks):
            return q


def tilt(q, body1, frame1, body2, frame2):
    """Sine of the angle between a disk and its plane."""
    axes = []
    for body, frame in ((body1, frame1), (body2, frame2)):
        turn = np.eye(3) if body == GROUND else rotation_of(q[7 * body : 7 * body + 7]).as_matrix()
        axes.append(turn @ frame.axes[:, 2])
    return np.linalg.norm(np.cross(*axes))


@property_test(100, seed=seeds)
def test_linearization_of_random_mechanisms(seed):
    """Springs and joints between two bodies, loads and all inputs; away from the configuration of the joints, where
    angles mean nothing, and in it."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, 1 + seed % 4 if seed % 4 else 2)
    count = bodies_of(tree.definition)
    check_linearization(tree.definition, tree.q, rng.uniform(-1, 1, 6 * count), rng, 10.0)
    tree = random_tree(rng, 1 + seed % 4 if seed % 4 else 2, joint_springs=False)
    check_linearization(tree.definition, anywhere(rng, tree), rng.uniform(-1, 1, 6 * count), rng, 10.0)


# --- accelerations and energy ----------------------------------------------------------------------------------------


def moving(seed, bodies=3):
    """A random tree with velocities that its joints allow, and inputs."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, bodies)
    system = _core.System(tree.definition)
    v = system.project_velocities(tree.q, rng.uniform(-1, 1, system.velocity_size))
    return rng, tree, system, v, rng.uniform(-5, 5, system.input_size)


KKT = 1e-11
"""Accuracy of a solution of the KKT system of a random tree: its condition is below 1e4, with a reserve of 10."""


@property_test(100, seed=seeds)
def test_accelerations_satisfy_the_equations_of_motion(seed):
    _, tree, system, v, inputs = moving(seed)
    vdot, multipliers = system.accelerations(tree.q, v, inputs)
    phi, rate, gradient, rate_gradient = system.constraints(tree.q, v)
    assert_close(phi, np.zeros_like(phi), 100 * EPS)
    assert_close(rate, np.zeros_like(phi), 100 * EPS)
    force = np.abs(gradient.T @ multipliers).max(initial=1.0)
    assert_close(system.residual(tree.q, v, vdot, multipliers, inputs), np.zeros_like(v), KKT, force)
    assert_close(gradient @ vdot, -rate_gradient @ v, KKT, force)


@pytest.mark.parametrize("model", MODELS)
def test_accelerations_of_the_mechanisms_at_their_start(model):
    simulation = _core.Simulation(_core.mechanism(model))
    system = _core.System(_core.mechanism(model).multibody)
    state, inputs = simulation.state, np.zeros(system.input_size)
    vdot, multipliers = system.accelerations(state.q, state.v, inputs)
    np.testing.assert_array_equal(vdot, state.vdot)
    np.testing.assert_array_equal(multipliers, state.lambda_)
    force = np.abs(mass_matrix(_core.mechanism(model).multibody) @ vdot).max(initial=1.0)
    assert_close(system.residual(state.q, state.v, vdot, multipliers, inputs), np.zeros_like(vdot), 1e-12, force)


@property_test(100, seed=seeds)
def test_gauss_principle(seed):
    """Of all accelerations with Φ'' = 0 the true one is nearest to the free one in the mass metric."""
    rng, tree, system, v, inputs = moving(seed)
    mass = mass_matrix(tree.definition)
    vdot, _ = system.accelerations(tree.q, v, inputs)
    zero = np.zeros(system.constraint_size)
    free = np.linalg.solve(mass, -system.residual(tree.q, v, np.zeros_like(v), zero, inputs))
    allowed = null_space(system.constraints(tree.q, v)[2])
    assert_close(allowed.T @ mass @ (vdot - free), np.zeros(allowed.shape[1]), KKT, np.abs(free).max())

    def constraint(candidate):
        return (candidate - free) @ mass @ (candidate - free)

    for _ in range(5):
        other = vdot + allowed @ rng.normal(size=allowed.shape[1])
        assert allowed.shape[1] == 0 or constraint(other) > constraint(vdot)


def point_velocity(q, v, body, point):
    """Place and velocity of a body's point, in W."""
    if body == GROUND:
        return point, np.zeros(3)
    place, twist = q[7 * body : 7 * body + 7], v[6 * body : 6 * body + 6]
    turn = rotation_of(place)
    return place[:3] + turn.apply(point), twist[:3] + turn.apply(np.cross(twist[3:], point))


def power(tree, system, q, v, inputs):
    """Power of loads and inputs less what the dampers take, from the definition of each element."""
    total = sum(inputs[6 * i : 6 * i + 6] @ v[6 * i : 6 * i + 6] for i in range(len(q) // 7))
    for body, force, torque in tree.loads:
        angular = rotation_of(q[7 * body : 7 * body + 7]).apply(v[6 * body + 3 : 6 * body + 6])
        total += force @ v[6 * body : 6 * body + 3] + torque @ angular
    for i, (one, point1, two, point2, _, damping) in enumerate(tree.springs):
        rate = point_velocity(q, v, two, point2)[1] - point_velocity(q, v, one, point1)[1]
        actuator = inputs[system.actuator_index(i) : system.actuator_index(i) + 3]
        total += actuator @ rate - damping @ rate**2
    for i, (kind, *_) in enumerate(tree.joints):
        for k in range(COORDINATES.get(kind, 0)):
            total += inputs[system.motor_index(i, k)] * system.coordinate(q, v, i, k)[1]
    for i, k, _, damping, _ in tree.joint_springs:
        total -= damping * system.coordinate(q, v, i, k)[1] ** 2
    return total


@property_test(100, seed=seeds)
def test_energy_changes_by_the_power_of_inputs_loads_and_dampers(seed):
    """Along the true motion, to first order in time: joints do no work, springs and gravity keep the energy."""
    _, tree, system, v, inputs = moving(seed)
    vdot, _ = system.accelerations(tree.q, v, inputs)
    rate = derivative(lambda t: system.energy(system.compose(tree.q, t * v), v + t * vdot))
    size = abs(system.energy(tree.q, v)) + np.abs(vdot).max() ** 2  # what is differentiated
    assert_close(rate, power(tree, system, tree.q, v, inputs), 1e-10, size)


@property_test(50, seed=seeds)
def test_energy_is_kinetic_plus_potential(seed):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    v = rng.uniform(-1, 1, 18)
    expected = 0.5 * v @ mass_matrix(tree.definition) @ v
    for i, body in enumerate(tree.definition.bodies):
        expected -= body.mass * tree.definition.gravity @ tree.q[7 * i : 7 * i + 3]
    for one, point1, two, point2, stiffness, _ in tree.springs:
        gap = point_velocity(tree.q, v, two, point2)[0] - point_velocity(tree.q, v, one, point1)[0]
        expected += 0.5 * stiffness @ gap**2
    for i, k, stiffness, _, rest in tree.joint_springs:
        expected += 0.5 * stiffness * (_core.System(tree.definition).coordinate(tree.q, v, i, k)[0] - rest) ** 2
    assert_close(_core.System(tree.definition).energy(tree.q, v), expected, 32 * EPS, 100.0)


def test_dependent_constraints_share_a_load():
    """The same joint twice: six equations for three, and accelerations as with one of them."""
    rng = np.random.default_rng(5)
    frame, body = random_frame(rng), random_body(rng, "body")
    found = []
    for names in (("one",), ("one", "two")):
        definition = _core.Multibody()
        definition.gravity = rng.uniform(-10, 10, 3) if not found else found[0][0]
        definition.add(body)
        for name in names:
            definition.add(_core.Joint(name, Type.spherical, GROUND, frame, 0, frame))
        system = _core.System(definition)
        q = np.array([0.0, 0, 0, 1, 0, 0, 0])
        found.append((definition.gravity, *system.accelerations(q, np.zeros(6), np.zeros(system.input_size))))
    (_, vdot, multipliers), (_, vdot_of_two, of_two) = found
    assert_close(vdot_of_two, vdot, 1e-11)
    assert_close(of_two, np.tile(multipliers / 2, 2), 1e-8)  # rounding over the compliance, 1e-5 of 1/mass


def test_arrays_of_wrong_size_are_refused():
    system = _core.System(_core.mechanism("HeavyTop").multibody)
    q, v, multipliers, inputs = np.zeros(7), np.zeros(6), np.zeros(3), np.zeros(6)
    for arguments in (
        (q[:6], v, v, multipliers, inputs),
        (q, v[:5], v, multipliers, inputs),
        (q, v, v[:5], multipliers, inputs),
        (q, v, v, multipliers[:2], inputs),
        (q, v, v, multipliers, inputs[:5]),
    ):
        with pytest.raises(ValueError, match="wrong size"):
            system.residual(*arguments)


FRAME = _core.Frame(np.zeros(3), np.eye(3))

# --- projections -----------------------------------------------------------------------------------------------------


@property_test(100, seed=seeds)
def test_projected_velocities(seed):
    """B v = 0, the change is orthogonal to all free motions in the mass metric, and nothing changes the second time."""
    rng, tree, system, _, _ = moving(seed)
    before = rng.uniform(-1, 1, system.velocity_size)
    after = system.project_velocities(tree.q, before)
    gradient = system.constraints(tree.q, after)[2]
    allowed = null_space(gradient)
    assert_close(gradient @ after, np.zeros(len(gradient)), 32 * EPS)
    change = allowed.T @ mass_matrix(tree.definition) @ (after - before)
    assert_close(change, np.zeros(len(change)), KKT)
    assert_close(system.project_velocities(tree.q, after), after, 32 * EPS)


@property_test(100, seed=seeds)
def test_projected_positions(seed):
    """From a place nearby: Φ = 0; to first order the change is orthogonal to all free motions in the mass metric."""
    rng, tree, system, _, _ = moving(seed)
    size = 1e-4
    before = system.compose(tree.q, size * rng.uniform(-1, 1, system.velocity_size))
    after = system.project_positions(before)
    phi, _, gradient, _ = system.constraints(after, np.zeros(system.velocity_size))
    assert np.abs(phi).max() <= 1e-14 * (1 + np.abs(after).max())
    change = []
    for one, two in zip(before.reshape(-1, 7), after.reshape(-1, 7), strict=True):
        change += [*(two[:3] - one[:3]), *(rotation_of(one).inv() * rotation_of(two)).as_rotvec()]
    allowed = null_space(gradient)
    work = allowed.T @ mass_matrix(tree.definition) @ change
    assert np.abs(work).max(initial=0.0) <= 100 * size**2
    np.testing.assert_allclose(system.project_positions(after), after, rtol=0, atol=1e-14 * (1 + np.abs(after).max()))


@property_test(100, seed=seeds)
def test_positions_far_off_are_assembled(seed):
    """0.2 m and 0.2 rad away."""
    rng, tree, system, _, _ = moving(seed)
    q = system.project_positions(system.compose(tree.q, 0.2 * rng.uniform(-1, 1, system.velocity_size)))
    assert np.abs(system.constraints(q, np.zeros(18))[0]).max() <= 1e-12 * (1 + np.abs(q).max())
    np.testing.assert_allclose(np.linalg.norm(q.reshape(-1, 7)[:, 3:], axis=1), 1.0, rtol=0, atol=2 * EPS)


def two_pendulum_ends(distance):
    """A body of length 1 between two ground points: possible only when they are 1 apart."""
    mechanism = _core.Mechanism()
    body = random_body(np.random.default_rng(0), "rod")
    mechanism.multibody.add(body)
    for name, x in (("left", 0.0), ("right", distance)):
        ground = _core.Frame(np.array([x, 0, 0]), np.eye(3))
        end = _core.Frame(np.array([np.sign(x) - 0.5 if x else -0.5, 0, 0]), np.eye(3))
        mechanism.multibody.add(_core.Joint(name, Type.spherical, GROUND, ground, 0, end))
    return mechanism


def test_a_mechanism_that_cannot_be_assembled_is_refused():
    with pytest.raises(
        RuntimeError,
        match=r"^The mechanism cannot be assembled from its initial positions: joints left and right cannot be closed "
        r"together, they miss by 0\.5 m\.$",
    ):
        _core.Simulation(two_pendulum_ends(1.5))
    with pytest.raises(RuntimeError, match="cannot be assembled"):
        _core.System(two_pendulum_ends(1.5).multibody).project_positions(np.array([0.1, 0.2, 0.3, 1, 0, 0, 0]))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("index", range(3))
def test_positions_that_are_not_finite_are_not_assembled(index, value):
    q = np.array([0.0, 1, 0, 1, 0, 0, 0])
    q[index] = value
    with pytest.raises(RuntimeError, match="cannot be assembled"):
        _core.System(_core.mechanism("HeavyTop").multibody).project_positions(q)


@pytest.mark.parametrize("kind", [Type.revolute, Type.prismatic, Type.fixed], ids=lambda t: t.name)
@pytest.mark.parametrize("axis", range(3))
def test_opposite_axes_are_refused(kind, axis):
    """A half turn satisfies the equations of parallel axes, but it is not the joint's configuration."""
    mechanism = _core.Mechanism()
    body = random_body(np.random.default_rng(1), "slide")
    turn = Rotation.from_rotvec(np.pi * np.eye(3)[axis])
    body.initial_quaternion = turn.as_quat(scalar_first=True)
    mechanism.multibody.add(body)
    mechanism.multibody.add(_core.Joint("guide", kind, GROUND, FRAME, 0, FRAME))
    if kind == Type.revolute and axis == 2:  # half a turn about the joint's axis is a fair start
        assert abs(_core.Simulation(mechanism).state.turned[0]) == pytest.approx(np.pi)
        return
    with pytest.raises(
        RuntimeError,
        match=r"^The mechanism cannot be assembled from its initial positions: the axes of joint guide point in "
        r"opposite directions; turn the initial quaternions of its bodies\.$",
    ):
        _core.Simulation(mechanism)


def test_initial_values_are_moved_onto_the_constraints():
    """A mechanism given with five digits starts at its joints, its quaternion normalized."""
    mechanism = _core.mechanism("SliderCrank")
    rod = mechanism.multibody.body(1)
    rod.initial_quaternion = np.round(3.0 * rod.initial_quaternion, 4)
    rod.initial_velocity = rod.initial_velocity + 1e-4
    simulation = _core.Simulation(mechanism)
    phi, rate, _, _ = _core.System(mechanism.multibody).constraints(simulation.state.q, simulation.state.v)
    assert np.abs(phi).max() <= 1e-14
    assert np.abs(rate).max() <= 1e-14
    assert simulation.state.q[14] == pytest.approx(0.2, abs=1e-3)
    np.testing.assert_allclose(np.linalg.norm(simulation.state.q.reshape(-1, 7)[:, 3:], axis=1), 1, atol=2 * EPS)


# --- definitions that no mechanism can have --------------------------------------------------------------------------


def pendulum():
    definition = _core.Multibody()
    for name in ("rod", "bob"):
        body = _core.RigidBody()
        body.name = name
        definition.add(body)
    definition.add(_core.Joint("hinge", Type.revolute, GROUND, FRAME, 0, FRAME))
    definition.add(_core.SpringDamper("spring", 0, np.zeros(3), 1, np.zeros(3), np.ones(3), np.ones(3)))
    definition.add(_core.Load("weight", 1, np.ones(3), np.zeros(3)))
    return definition


def with_body(**values):
    def change(definition):
        for name, value in values.items():
            setattr(definition.body(1), name, np.array(value) if isinstance(value, list) else value)

    return change


def with_joint(*arguments):
    return lambda definition: definition.add(_core.Joint("pin", Type.spherical, *arguments))


def with_spring(one, two, stiffness=(1.0, 1.0, 1.0), damping=(1.0, 1.0, 1.0)):
    def change(definition):
        points = np.zeros((2, 3))
        constants = np.array([stiffness, damping])
        definition.add(_core.SpringDamper("bumper", one, points[0], two, points[1], *constants))

    return change


def with_load(body, force=(0.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0)):
    return lambda definition: definition.add(_core.Load("push", body, np.array(force), np.array(torque)))


def with_gravity(*gravity):
    return lambda definition: setattr(definition, "gravity", np.array(gravity))


LEFT_HANDED = _core.Frame(np.zeros(3), np.diag([1.0, 1.0, -1.0]))
SCALED = _core.Frame(np.zeros(3), 1.001 * np.eye(3))
SKEW = _core.Frame(np.zeros(3), np.array([[1.0, 1e-6, 0], [0, 1, 0], [0, 0, 1]]))
NOT_FINITE = _core.Frame(np.zeros(3), np.full((3, 3), np.nan))
INERTIA = "bob.inertia has the principal moments "
POSITIVE = "they must be positive, or one of them zero (a thin rod)."
ORTHONORMAL = "; they must be orthonormal and right-handed."

REFUSED = {
    "no mass": (with_body(mass=0.0), "bob.mass is 0 kg; it must be positive and finite."),
    "negative mass": (with_body(mass=-1.5), "bob.mass is -1.5 kg; it must be positive and finite."),
    "mass nan": (with_body(mass=np.nan), "bob.mass is nan kg; it must be positive and finite."),
    "infinite mass": (with_body(mass=np.inf), "bob.mass is inf kg; it must be positive and finite."),
    "negative inertia": (
        with_body(inertia=[1.0, -2.0, 1.0]),
        INERTIA + "-2, 1, 1 kg.m2; " + POSITIVE,
    ),
    "no inertia": (with_body(inertia=[0.0, 0.0, 0.0]), INERTIA + "0, 0, 0 kg.m2; " + POSITIVE),
    "inertia nan": (with_body(inertia=[1.0, np.nan, 1.0]), "bob.inertia.yy is nan kg.m2; it must be finite."),
    "infinite product of inertia": (
        with_body(inertia_products=[0.0, -np.inf, 0.0]),
        "bob.inertia.xz is -inf kg.m2; it must be finite.",
    ),
    "not positive definite": (
        with_body(inertia_products=[0.0, 0.0, 2.0]),
        INERTIA + "-1, 1, 3 kg.m2; " + POSITIVE,
    ),
    "triangle inequality": (
        with_body(inertia=[1.0, 2.0, 3.5]),
        INERTIA + "1, 2, 3.5 kg.m2; none may exceed the sum of the other two (triangle inequality).",
    ),
    "triangle inequality, turned": (
        with_body(inertia=[2.0, 2.0, 1.0], inertia_products=[1.5, 0.0, 0.0]),
        INERTIA + "0.5, 1, 3.5 kg.m2; none may exceed the sum of the other two (triangle inequality).",
    ),
    "zero quaternion": (
        with_body(initial_quaternion=[0.0, 0.0, 0.0, 0.0]),
        "bob.initialQuaternion has the length 0; it must be finite and at least 1e-6 (it is normalized).",
    ),
    "quaternion nan": (
        with_body(initial_quaternion=[np.nan, 0.0, 0.0, 1.0]),
        "bob.initialQuaternion has the length nan; it must be finite and at least 1e-6 (it is normalized).",
    ),
    "infinite quaternion": (
        with_body(initial_quaternion=[np.inf, 0.0, 0.0, 1.0]),
        "bob.initialQuaternion has the length inf; it must be finite and at least 1e-6 (it is normalized).",
    ),
    "joint to no body": (
        with_joint(0, FRAME, 2, FRAME),
        "pin refers to body 2; allowed are -1 (ground) to 1.",
    ),
    "joint below the ground": (with_joint(-2, FRAME, 0, FRAME), "pin refers to body -2; allowed are -1 (ground) to 1."),
    "joint to itself": (
        with_joint(1, FRAME, 1, FRAME),
        "pin connects bob with itself; it must connect two bodies.",
    ),
    "joint from ground to ground": (
        with_joint(GROUND, FRAME, GROUND, FRAME),
        "pin connects the ground with itself; it must connect two bodies.",
    ),
    "left-handed axes": (
        with_joint(0, LEFT_HANDED, 1, FRAME),
        "pin.frame1.axes are (1, 0, 0), (0, 1, 0), (0, 0, -1)" + ORTHONORMAL,
    ),
    "scaled axes": (
        with_joint(0, FRAME, 1, SCALED),
        "pin.frame2.axes are (1.0009999999999999, 0, 0), (0, 1.0009999999999999, 0), (0, 0, 1.0009999999999999)"
        + ORTHONORMAL,
    ),
    "skew axes": (
        with_joint(0, FRAME, 1, SKEW),
        "pin.frame2.axes are (1, 0, 0), (9.9999999999999995e-07, 1, 0), (0, 0, 1)" + ORTHONORMAL,
    ),
    "axes nan": (
        with_joint(0, NOT_FINITE, 1, FRAME),
        "pin.frame1.axes are (nan, nan, nan), (nan, nan, nan), (nan, nan, nan)" + ORTHONORMAL,
    ),
    "spring to no body": (with_spring(5, 0), "bumper refers to body 5; allowed are -1 (ground) to 1."),
    "spring to itself": (with_spring(0, 0), "bumper connects rod with itself; it must connect two bodies."),
    "negative stiffness": (
        with_spring(0, 1, stiffness=(1.0, -2.5, 1.0)),
        "bumper.stiffness[2] is -2.5 N/m; it must not be negative.",
    ),
    "stiffness nan": (
        with_spring(0, 1, stiffness=(1.0, 1.0, np.nan)),
        "bumper.stiffness[3] is nan N/m; it must be finite.",
    ),
    "negative damping": (
        with_spring(0, 1, damping=(-0.1, 0.0, 0.0)),
        "bumper.damping[1] is -0.10000000000000001 N.s/m; it must not be negative.",
    ),
    "infinite stiffness": (
        with_spring(0, 1, stiffness=(np.inf, 1.0, 1.0)),
        "bumper.stiffness[1] is inf N/m; it must be finite.",
    ),
    "damping nan": (
        with_spring(0, 1, damping=(0.0, np.nan, 0.0)),
        "bumper.damping[2] is nan N.s/m; it must be finite.",
    ),
    "gravity nan": (with_gravity(0.0, 0.0, np.nan), "gravity[3] is nan m/s2; it must be finite."),
    "position nan": (
        with_body(initial_position=[0.0, np.nan, 0.0]),
        "bob.initialPosition[2] is nan m; it must be finite.",
    ),
    "infinite velocity": (
        with_body(initial_velocity=[-np.inf, 0.0, 0.0]),
        "bob.initialVelocity[1] is -inf m/s; it must be finite.",
    ),
    "angular velocity nan": (
        with_body(initial_angular_velocity=[0.0, 0.0, np.nan]),
        "bob.initialAngularVelocity[3] is nan rad/s; it must be finite.",
    ),
    "origin nan": (
        with_joint(0, FRAME, 1, _core.Frame(np.array([0, np.nan, 0]), np.eye(3))),
        "pin.frame2.origin[2] is nan m; it must be finite.",
    ),
    "infinite force": (with_load(1, force=[0.0, np.inf, 0.0]), "push.force[2] is inf N; it must be finite."),
    "torque nan": (with_load(1, torque=[np.nan, 0.0, 0.0]), "push.torque[1] is nan N.m; it must be finite."),
    "load on no body": (with_load(2), "push acts on body 2; allowed are 0 to 1."),
    "load on the ground": (with_load(GROUND), "push acts on body -1; allowed are 0 to 1."),
}


def test_the_definition_that_the_next_tests_spoil_is_good():
    pendulum().validate()


@pytest.mark.parametrize(("spoil", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_definitions_are_refused_with_one_sentence(spoil, message):
    """Name, value, and what is allowed; by validate(), System and Simulation alike."""
    definition = pendulum()
    spoil(definition)
    mechanism = _core.Mechanism()
    mechanism.multibody = definition
    for use in (definition.validate, lambda: _core.System(definition), lambda: _core.Simulation(mechanism)):
        with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
            use()


def test_a_mechanism_without_bodies_is_refused():
    with pytest.raises(ValueError, match=r"^The mechanism has no bodies; it must have at least one\.$"):
        _core.Multibody().validate()


@pytest.mark.parametrize("inertia", [[1.0, 2.0, 3.0], [1e-9, 1.0, 1.0], [0.1, 0.2, 0.1 + 0.2]])
def test_laminae_and_thin_rods_are_bodies(inertia):
    """On the boundary of the triangle inequality, however their axes are turned."""
    definition = pendulum()
    body = definition.body(1)
    for turn in (Rotation.identity(), Rotation.from_rotvec([0.3, -1.0, 2.0])):
        matrix = turn.as_matrix() @ np.diag(inertia) @ turn.as_matrix().T
        body.inertia, body.inertia_products = np.diag(matrix), matrix[[0, 0, 1], [1, 2, 2]]
        definition.validate()


@pytest.mark.parametrize("model", MODELS)
def test_the_mechanisms_are_good(model):
    _core.mechanism(model).multibody.validate()


def test_unknown_mechanism():
    with pytest.raises(ValueError, match="unknown mechanism Pendulum"):
        _core.mechanism("Pendulum")
