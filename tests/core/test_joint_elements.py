"""Friction, stops, armatures and motors in joints: derivatives, power, motion, what is refused."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .clouds import beam, flexible_body
from .helpers import (
    COORDINATES,
    DIFFERENCES,
    GROUND,
    Rotation,
    Type,
    assert_close,
    coordinates,
    derivative,
    frame_pose,
    jacobian,
    make_joint,
    property_test,
    random_body,
    random_frame,
    random_pose,
    random_tree,
    relative_pose,
    rotation_of,
    seeds,
)
from .test_flexible import make_tree
from .test_joint_types import HERE, assert_second_order, body, end, mechanism, solution

TURNING = (
    *(Type.spherical, Type.distance, Type.point_on_line, Type.point_in_plane, Type.free),
    Type.constant_velocity,
)
"""Joints that leave every rotation free, or whose rotation vector tells what they leave free."""

# --- laws, written down a second time --------------------------------------------------------------------------------


def friction_force(d, rate):
    size = d.friction + d.stribeck_friction * np.exp(-((rate / d.stribeck_rate) ** 2))
    return -size * np.tanh(rate / d.creep_rate) - d.viscous_friction * rate


def stop_force(d, value, rate):
    for depth, approach, away in ((value - d.upper, rate, -1), (d.lower - value, -rate, 1)):
        if depth > 0:
            soft = depth**2 / (2 * d.depth) if depth < d.depth else depth - d.depth / 2
            z = d.damping * approach
            return away * d.stiffness * soft * (1 + z / np.sqrt(1 + z * z))
    return 0.0


def stop_energy(d, value):
    depth = max(value - d.upper, d.lower - value, 0.0)
    w = d.depth
    return d.stiffness * (depth**3 / (6 * w) if depth < w else (depth - w / 2) ** 2 / 2 + w**2 / 24)


# --- derivatives and power -------------------------------------------------------------------------------------------


def add_elements(rng, definition, q):
    """One of each kind on every coordinate, with numbers of the order of 1, and motors where bodies turn any way.

    Of the stops of half the coordinates one acts at q, soft or stiff; q is not where they begin or become stiff.
    """
    system = _core.System(definition)
    for j, joint in enumerate(definition.joints):
        for k in range(COORDINATES.get(joint.type, 0)):
            numbers = rng.uniform(0.2, 2.0, 12)
            definition.add(_core.JointFriction(j, *numbers[:3], numbers[3], 0.5 + numbers[4], k))
            value, _ = system.coordinate(q, np.zeros(system.velocity_size), j, k)
            soft, depth = 0.2 + 0.1 * numbers[7], rng.choice([-0.3, 0.5, 1.5])
            upper = rng.random() < 0.5
            low, high = (-9.0, value - depth * soft) if upper else (value + depth * soft, 9.0)
            definition.add(_core.JointStop(j, low, high, *numbers[5:7], soft, k))
            definition.add(_core.JointArmature(j, numbers[8], k))
        if joint.type in TURNING:
            definition.add(_core.RotationMotor(j))


def rigid_tree(seed):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    definition = _core.Multibody()
    definition.gravity = tree.definition.gravity
    for part in (*tree.definition.bodies, *tree.definition.joints):
        definition.add(part)
    add_elements(rng, definition, tree.q)
    return rng, tree.q, _core.System(definition), definition


def flexible_tree(seed):
    rng, tree = make_tree(seed)
    add_elements(rng, tree.definition, tree.q)
    return rng, tree.q, tree.system(), tree.definition


every_tree = pytest.mark.parametrize("make", [rigid_tree, flexible_tree], ids=["rigid", "at nodes"])


@every_tree
@property_test(60, seed=seeds)
def test_matrices_are_derivatives_of_the_residual(make, seed):
    """With velocities and accelerations that no joint allows, in positions where all are closed."""
    rng, q, system, _ = make(seed)
    size = system.velocity_size
    v, vdot = rng.uniform(-1, 1, (2, size))
    multipliers, inputs = rng.uniform(-5, 5, system.constraint_size), rng.uniform(-5, 5, system.input_size)
    mass, damping, stiffness = system.linearization(q, v, multipliers, inputs, vdot)

    def residual(x=0.0, dv=0.0, dvdot=0.0):
        return system.residual(system.compose(q, x + np.zeros(size)), v + dv, vdot + dvdot, multipliers, inputs)

    scale = np.abs(residual()).max()
    assert_close(mass, jacobian(lambda x: residual(dvdot=x), size), DIFFERENCES, scale)
    assert_close(mass, mass.T, 1e-15, np.abs(mass).max())
    # tanh is singular beside the real axis: large high derivatives
    assert_close(damping, jacobian(lambda x: residual(dv=x), size), 1e-8, scale)
    assert_close(stiffness, jacobian(lambda x: residual(x=x), size), 1e-8, scale)


@property_test(100, seed=seeds)
def test_energy_changes_by_the_power_of_inputs_friction_and_stops(seed):
    """dE/dt, E with the armatures' energy and that of the stops, against forces times rates."""
    rng, q, system, definition = rigid_tree(seed)
    v = system.project_velocities(q, rng.uniform(-1, 1, system.velocity_size))
    inputs = rng.uniform(-5, 5, system.input_size)
    vdot, _ = system.accelerations(q, v, inputs)
    energy = derivative(lambda t: system.energy(system.compose(q, t * v), v + t * vdot), 5e-4)
    bodies = len(definition.bodies)
    power = inputs[: 6 * bodies] @ v[: 6 * bodies]
    for j, joint in enumerate(definition.joints):
        for k in range(COORDINATES.get(joint.type, 0)):
            power += inputs[system.motor_index(j, k)] * system.coordinate(q, v, j, k)[1]
    first = system.input_size - sum(COORDINATES.get(joint.type, 0) for joint in definition.joints)
    first -= 3 * len(definition.rotation_motors)
    for motor in definition.rotation_motors:
        joint, spin = definition.joints[motor.joint], np.zeros((2, 3))
        for side, one in enumerate((joint.body1, joint.body2)):
            if one != GROUND:
                spin[side] = rotation_of(q[7 * one : 7 * one + 7]).apply(v[6 * one + 3 : 6 * one + 6])
        axes = joint.frame1.axes
        if joint.body1 != GROUND:
            axes = rotation_of(q[7 * joint.body1 : 7 * joint.body1 + 7]).as_matrix() @ axes
        power += inputs[first : first + 3] @ axes.T @ (spin[1] - spin[0])
        first += 3
    for f in definition.joint_frictions:
        rate = system.coordinate(q, v, f.joint, f.coordinate)[1]
        power += friction_force(f, rate) * rate
    for s in definition.joint_stops:
        value, rate = system.coordinate(q, v, s.joint, s.coordinate)
        power += (stop_force(s, value, rate) - stop_force(s, value, 0.0)) * rate
    size = abs(system.energy(q, v)) + np.abs(vdot).max() + np.abs(inputs).max() * np.abs(v).max()
    assert_close(energy, power, 1e-9, size)


@property_test(60, seed=seeds)
def test_forces_are_equal_and_opposite(seed):
    """What elements of a joint between two bodies do has no resultant: no power where both move as one."""
    rng = np.random.default_rng(seed)
    definition = _core.Multibody()
    kind = list(COORDINATES)[seed % len(COORDINATES)] if seed % 3 else Type.spherical
    for name in ("one", "two"):
        definition.add(random_body(rng, name))
    one, two = random_frame(rng), random_frame(rng)
    definition.add(make_joint("joint", kind, 0, one, 1, two))
    first = random_pose(rng)
    relative = relative_pose(kind, rng.uniform(-1, 1, 3))
    q = coordinates(first, first @ frame_pose(one) @ relative @ np.linalg.inv(frame_pose(two)))
    definition.gravity = np.zeros(3)
    systems = [_core.System(definition)]
    add_elements(rng, definition, q)
    systems.append(_core.System(definition))
    v, vdot = rng.uniform(-1, 1, (2, 12))
    share = np.zeros(12)
    for sign, system in zip((-1, 1), systems, strict=True):
        inputs = np.append(np.zeros(12), rng.uniform(-5, 5, system.input_size - 12) * (sign > 0))
        share += sign * system.residual(q, v, vdot, np.zeros(system.constraint_size), inputs)
    assert np.abs(share).max() > 1e-3
    for velocity, spin in [(e, 0 * e) for e in np.eye(3)] + [(0 * e, e) for e in np.eye(3)]:
        motion = [(velocity + np.cross(spin, p[:3]), rotation_of(p).inv().apply(spin)) for p in (q[:7], q[7:])]
        assert_close(share @ np.ravel(motion), 0.0, 1e-14, 10 * np.abs(share).max())


# --- runs ------------------------------------------------------------------------------------------------------------


def sledge(*elements, mass=1.5, rate=0.0, gravity=(0, 0, 0)):
    """A body on a rail along W z."""
    moving = body("sledge", mass)
    moving.initial_velocity = np.array([0, 0, rate])
    return mechanism(moving, _core.Joint("rail", Type.prismatic, GROUND, HERE, 0, HERE), *elements, gravity=gravity)


def test_friction_stops_a_sledge():
    """m v' = -F tanh(v/v0): sinh(v/v0) falls as exp(-F t/(m v0))."""
    force, creep, rate, mass, stop = 2.0, 0.5, 2.0, 1.5, 2.0
    expected = creep * np.arcsinh(np.sinh(rate / creep) * np.exp(-force * stop / (mass * creep)))
    assert_second_order(
        lambda: sledge(_core.JointFriction(0, force, creep_rate=creep), mass=mass, rate=rate),
        {}, ["rail.rate"], [expected], stop, 2e-2,
    )  # fmt: skip


@pytest.mark.parametrize("part", [0.1, 0.5, 0.95])
def test_a_load_that_friction_holds_creeps_at_the_rate_that_is_said(part):
    """v0 atanh(load/(F + S)), where v0 is small against vS: an incline."""
    weight = part * 3.0
    friction = _core.JointFriction(0, 2.0, stribeck_friction=1.0, stribeck_rate=0.5, creep_rate=1e-3)
    m = sledge(friction, mass=1.0, gravity=(0, 0, -weight))
    slave = _core.Slave(m)
    slave.start()
    for i in range(500):
        slave.do_step(i * 1e-3, 1e-3)
    assert slave.get("rail.rate") == pytest.approx(-1e-3 * np.arctanh(part), rel=2e-3)
    assert slave.get("rail.frictionForce") == pytest.approx(weight, rel=1e-6)
    slave.set("rail.friction", 0.0)  # and now it slides
    slave.set("rail.stribeckFriction", 0.0)
    slave.do_step(0.5, 1e-3)
    assert slave.get("rail.acceleration") == pytest.approx(-weight, rel=1e-12)


@pytest.mark.parametrize("damping", [0.0, 0.4])
def test_a_sledge_bounces_off_its_stops(damping):
    stop = _core.JointStop(0, lower=-0.1, upper=0.2, stiffness=300.0, damping=damping, depth=0.05)

    def equations(_, y):
        return [y[1], stop_force(stop, *y) / 1.5]

    expected = solution(equations, [0.0, 1.0], 1.0)
    assert_second_order(lambda: sledge(stop, rate=1.0), {}, ["rail.displacement", "rail.rate"], expected, 1.0, 2e-3)
    energy = 0.5 * 1.5 * expected[1] ** 2 + stop_energy(stop, expected[0])
    assert energy == pytest.approx(0.75, rel=1e-9) if damping == 0 else energy < 0.7


def test_armature_of_a_hinge_and_a_slide():
    """T = (J + A + m s²) θ'²/2 + (m + a) s'²/2 of a sledge on an arm that turns, a torque on the arm."""
    J, m, A, a, torque = 0.2, 0.5, 0.3, 0.7, 1.2
    out = _core.Frame(np.zeros(3), _core.axes_with_z(np.array([1.0, 0, 0])))

    def equations(_, y):
        _, s, dtheta, ds = y
        return [dtheta, ds, (torque - 2 * m * s * ds * dtheta) / (J + A + m * s * s), m * s * dtheta**2 / (m + a)]

    def make():
        sledge = body("sledge", m, (1e-9, 1e-9, 1e-9), position=(0.3, 0, 0))
        parts = [
            body("arm", 1.0, (0.15, 0.15, J)),
            sledge,
            _core.Joint("hinge", Type.revolute, GROUND, HERE, 0, HERE),
            _core.Joint("slide", Type.prismatic, 0, out, 1, out),
            _core.JointArmature(0, A),
            _core.JointArmature(1, a),
            _core.JointFriction(0),
        ]
        return mechanism(*parts)

    names = ["hinge.angle", "slide.displacement", "hinge.angularRate", "slide.rate"]
    start = [0.0, 0.3, 2.0, -0.5]
    initial = {"hinge.initialAngularRate": 2.0, "slide.initialRate": -0.5, "hinge.motorTorque": torque}
    assert_second_order(make, initial, names, solution(equations, start, 1.0))


@property_test(40, seed=seeds)
def test_armatures_at_nodes_have_their_kinetic_energy(seed):
    """Their share of the residual does c' a c'' in any motion, which is the rate of a c'²/2, and M has the same."""
    rng, tree = make_tree(seed)
    system, q = _core.System(tree.definition), tree.q
    size = system.velocity_size
    v, vdot = rng.uniform(-1, 1, (2, size))
    armatures = [(j, k, rng.uniform(0.2, 2)) for j, d in enumerate(tree.definition.joints)
                 for k in range(COORDINATES.get(d.type, 0))]  # fmt: skip
    energy = work = 0.0
    for j, k, a in armatures:
        rate = system.coordinate(q, v, j, k)[1]
        energy += a * rate**2 / 2
        work += a * rate * system.coordinate_acceleration(q, v, vdot, j, k)
        tree.definition.add(_core.JointArmature(j, a, k))
    with_them = _core.System(tree.definition)
    arguments = q, v, vdot, np.zeros(system.constraint_size), np.zeros(system.input_size)
    share = with_them.residual(*arguments) - system.residual(*arguments)
    assert_close(share @ v, work, 1e-11, 10 + np.abs(share).max())
    masses = [s.linearization(q, v, *arguments[3:], vdot)[0] for s in (with_them, system)]
    assert_close(v @ (masses[0] - masses[1]) @ v / 2, energy, 1e-11, 10)
    assert_close(with_them.energy(q, v) - system.energy(q, v), energy, 1e-11, 10)


def test_an_armature_at_the_node_of_a_beam_is_a_disc_between_beam_and_hinge():
    """The same motion, but for errors of the steps, which are of order 2."""
    J, torque, width = 0.3, 4.0, 0.02
    place = _core.Frame(np.array([0, -width, -width]), np.eye(3), 0)  # on the axis, where the beam turns as it bends
    terms = [(lambda s: s - s * s, lambda s: 1 - 2 * s), (lambda s: s**3, lambda s: 3 * s * s)]
    stiffness = np.diag([40.0, 60.0, 50.0, 70.0])

    def run(disc, h):
        parts = [flexible_body(beam(1.0, 0.5, width, terms, stiffness), "beam")]
        if disc:
            parts += [body("disc", 1.0, (0.2, 0.2, J)), _core.Joint("hinge", Type.revolute, GROUND, HERE, 1, HERE),
                      _core.Joint("weld", Type.fixed, 1, HERE, 0, place)]  # fmt: skip
        else:
            parts += [_core.Joint("hinge", Type.revolute, GROUND, HERE, 0, place), _core.JointArmature(0, J)]
        m = mechanism(*parts, gravity=(0, -9.81, 0))
        names = ["hinge.angle", "hinge.angularRate", "hinge.angularAcceleration", "beam.modal[1]", "beam.modalRate[2]"]
        return end(m, h, 0.2, {"hinge.motorTorque": torque}, names)

    differences = [np.abs(run(True, h) - run(False, h)).max() for h in (4e-4, 2e-4)]
    assert differences[1] < 1e-8
    assert np.log2(differences[0] / differences[1]) == pytest.approx(2.0, abs=0.1)


def test_a_motor_turns_a_ball_any_way():
    """Euler's equations under a torque that is constant in the axes of the ground's frame."""
    J, torque = np.array([0.1, 0.2, 0.25]), np.array([0.3, -0.2, 0.5])
    axes = Rotation.from_rotvec([0.4, 0.3, -0.8])

    def equations(_, y):
        turn, w = Rotation.from_quat(y[:4], scalar_first=True), y[4:]
        w0, u = y[0], y[1:4]
        return [*(0.5 * np.array([-u @ w, *(w0 * w + np.cross(u, w))])),
                *((turn.inv().apply(axes.apply(torque)) - np.cross(w, J * w)) / J)]  # fmt: skip

    def make():
        ball = _core.Joint("ball", Type.spherical, GROUND, _core.Frame(np.zeros(3), axes.as_matrix()), 0, HERE)
        return mechanism(body("body", 1.0, J), ball, _core.RotationMotor(0))

    expected = solution(equations, [1, 0, 0, 0, 0, 0, 0], 1.0)
    psi = (axes.inv() * Rotation.from_quat(expected[:4], scalar_first=True)).as_rotvec()
    w = axes.inv().apply(Rotation.from_quat(expected[:4], scalar_first=True).apply(expected[4:]))
    names = [f"ball.{n}[{i}]" for n in ("rotationVector", "relativeAngularVelocity") for i in (1, 2, 3)]
    initial = {f"ball.motorTorque[{i + 1}]": torque[i] for i in range(3)}
    assert_second_order(make, initial, names, np.concatenate([psi, w]))


# --- definitions -----------------------------------------------------------------------------------------------------


def test_written_and_read_they_are_the_same():
    _, _, _, definition = rigid_tree(5)
    m = _core.Mechanism("Elements")
    m.multibody = definition
    text = _core.to_json(m)
    assert _core.to_json(_core.from_json(text)) == text
    for name in ("joint_frictions", "joint_stops", "joint_armatures"):
        assert len(getattr(_core.from_json(text).multibody, name)) == len(getattr(definition, name)) > 0


REFUSED = {
    "friction": ([_core.JointFriction(0, -1.0)], "rail.friction is -1 N; it must not be negative."),
    "creep": ([_core.JointFriction(0, creep_rate=0.0)], "rail.creepRate is 0 m/s; it must be at least 1e-12."),
    "two": ([_core.JointFriction(0)] * 2, "rail has two frictions on the same coordinate; one is allowed."),
    "stops": (
        [_core.JointStop(0, 1.0, 0.5)],
        "rail.lowerStop is 1 m and rail.upperStop 0.5 m; the lower one must not be above the upper one.",
    ),
    "depth": ([_core.JointStop(0, depth=-1.0)], "rail.stopDepth is -1 m; it must be at least 1e-12."),
    "armature": ([_core.JointArmature(0, np.inf)], "rail.armature is inf kg; it must be finite."),
    "coordinate": (
        [_core.JointArmature(0, 1.0, 1)],
        "An armature acts on coordinate 1 of rail; joints of its type have 1, counted from 0.",
    ),
    "motor": (
        [_core.RotationMotor(0)],
        "rail has a rotation motor; its type must be spherical, distance, point_on_line, point_in_plane, "
        "constant_velocity or free.",
    ),
    "joint": ([_core.RotationMotor(3)], "A rotation motor acts on joint 3; allowed are 0 to 0."),
}


@pytest.mark.parametrize(("elements", "message"), REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused(elements, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        sledge(*elements).validate()
