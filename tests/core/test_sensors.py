"""Sensors of motion and inertia, momenta and powers: against places and sums over nodes, and what is refused."""

import json
import re

import numpy as np
import pytest

from sigmafmu import _core

from .clouds import FLOATING, beam, flexible_body
from .helpers import (
    GROUND,
    Rotation,
    assert_close,
    derivative,
    frame_pose,
    mass_matrix,
    property_test,
    random_frame,
    random_tree,
    rotation_of,
    second_derivative,
    seeds,
)
from .test_flexible import make_tree

Axes, Kind = _core.SensorAxes, _core.SensorType
FRAME = _core.Frame(np.zeros(3), np.eye(3))


def random_end(rng, tree):
    """A body, rigid or flexible, or the ground, and a frame there."""
    body = int(rng.integers(-1, len(tree.definition.bodies)))
    frame = random_frame(rng)
    frame.node = int(rng.integers(-1, 6)) if body in tree.clouds else FLOATING
    return body, frame


def outputs_of(definition, *sensors):
    mechanism = _core.Mechanism("Sensors")
    mechanism.multibody = definition
    for sensor in sensors:
        mechanism.add(sensor)
    return _core.Outputs(mechanism)


class Values:
    """Outputs at one point, by name."""

    def __init__(self, outputs, q, v, u):
        self.values = dict(zip(outputs.names, outputs.values(q, v, u), strict=True))

    def __call__(self, name):
        if name in self.values:
            return self.values[name]
        return np.array([self.values[f"{name}[{i}]"] for i in (1, 2, 3)])


def moving(seed):
    """A tree of rigid and flexible bodies, velocities that its joints allow, inputs, accelerations."""
    rng, tree = make_tree(seed)
    system = tree.system()
    v = system.project_velocities(tree.q, rng.uniform(-1, 1, system.velocity_size))
    u = rng.uniform(-5, 5, system.input_size)
    vdot, multipliers = system.accelerations(tree.q, v, u)
    return rng, tree, system, v, u, vdot, multipliers


def pose_along(tree, system, v, vdot, body, frame):
    """Of a frame in W as a function of time."""

    def pose(t):
        q = system.compose(tree.q, t * v + 0.5 * t * t * vdot)
        return tree.frame(system, q, body, frame.node) @ frame_pose(frame)

    return pose


@property_test(60, seed=seeds)
def test_motion_seen_from_another_frame(seed):
    """In the reference frame's axes velocity and acceleration are derivatives of the position's components; other axes
    turn these vectors. Rates of the rotation matrix give those of rotation."""
    rng, tree, system, v, u, vdot, _ = moving(seed)
    (body, frame), (reference, reference_frame) = (random_end(rng, tree) for _ in range(2))
    sensors = [
        _core.Sensor(f"in_{axes.name}", Kind.motion, body, frame, reference, reference_frame, axes) for axes in Axes
    ]
    value = Values(outputs_of(tree.definition, *sensors), tree.q, v, u)
    point, observer = (pose_along(tree, system, v, vdot, *end) for end in ((body, frame), (reference, reference_frame)))

    def relative(t):
        return np.linalg.inv(observer(t)) @ point(t)

    at = relative(0.0)
    turn, rate, second = at[:3, :3], derivative(relative, 5e-4), second_derivative(relative, 3e-3)
    size = 1.0 + np.abs(vdot).max()
    assert_close(value("in_reference.position"), at[:3, 3], 1e-14)
    assert_close(value("in_reference.velocity"), rate[:3, 3], 1e-10)
    assert_close(value("in_reference.acceleration"), second[:3, 3], 1e-8, size)
    spin = rate[:3, :3] @ turn.T
    spin_rate = second[:3, :3] @ turn.T + rate[:3, :3] @ rate[:3, :3].T
    for name, matrix, tolerance in (("angularVelocity", spin, 1e-10), ("angularAcceleration", spin_rate, 1e-8)):
        assert_close(value(f"in_reference.{name}"), matrix[[2, 0, 1], [1, 2, 0]], tolerance, size)
    names = ("position", "velocity", "acceleration", "angularVelocity", "angularAcceleration")
    to_ground, to_sensor = observer(0.0)[:3, :3], turn.T
    for name in names:
        seen = value(f"in_reference.{name}")
        assert_close(value(f"in_ground.{name}"), to_ground @ seen, 1e-13, size)
        assert_close(value(f"in_sensor.{name}"), to_sensor @ seen, 1e-13, size)
    for axes in Axes:
        got = Rotation.from_rotvec(value(f"in_{axes.name}.rotationVector")).as_matrix()
        assert_close(got, turn, 1e-14)


@property_test(40, seed=seeds)
def test_an_inertial_sensor(seed):
    """The second derivative of its place less gravity, and its angular velocity, both in its axes."""
    rng, tree, system, v, u, vdot, _ = moving(seed)
    body, frame = random_end(rng, tree)
    value = Values(outputs_of(tree.definition, _core.Sensor("imu", Kind.imu, body, frame)), tree.q, v, u)
    pose = pose_along(tree, system, v, vdot, body, frame)
    turn = pose(0.0)[:3, :3]
    force = turn.T @ (second_derivative(pose, 3e-3)[:3, 3] - tree.definition.gravity)
    assert_close(value("imu.specificForce"), force, 1e-8, 1.0 + np.abs(vdot).max())
    spin = turn.T @ derivative(pose, 5e-4)[:3, :3]
    assert_close(value("imu.angularVelocity"), spin[[2, 0, 1], [1, 2, 0]], 1e-10)


def test_what_an_inertial_sensor_feels_where_one_knows_it():
    """Nothing in free fall, the support at rest, and on a spinning body the way to its axis."""
    mechanism = _core.Mechanism("Fall")
    body = _core.RigidBody()
    body.name, body.inertia = "stone", np.array([1.0, 1.0, 1.5])
    body.initial_angular_velocity = np.array([0.0, 0.0, 3.0])
    mechanism.multibody.add(body)
    mechanism.multibody.gravity = np.array([0.0, 0.0, -9.81])
    turned = _core.Frame(np.array([0.5, 0.0, 0.0]), Rotation.from_euler("z", 90, degrees=True).as_matrix())
    for name, where, frame in (("middle", 0, FRAME), ("rim", 0, turned), ("wall", GROUND, turned)):
        mechanism.add(_core.Sensor(name, Kind.imu, where, frame))
    slave = _core.Slave(mechanism)
    slave.start()
    for i in range(10):
        slave.do_step(i * 1e-2, 1e-2)

    def vector(name):
        return [slave.get(f"{name}[{i}]") for i in (1, 2, 3)]

    np.testing.assert_allclose(vector("middle.specificForce"), [0, 0, 0], atol=1e-13)
    np.testing.assert_allclose(vector("rim.specificForce"), [0, 0.5 * 9.0, 0], atol=1e-13)
    np.testing.assert_allclose(vector("rim.angularVelocity"), [0, 0, 3.0], atol=1e-14)
    np.testing.assert_allclose(vector("wall.specificForce"), [0, 0, 9.81], atol=1e-15)


@property_test(20, seed=seeds)
def test_rate_of_an_orientation_that_may_jump(seed):
    rng, tree, system, v, *_ = moving(seed)
    ends = random_end(rng, tree), random_end(rng, tree)
    outputs = outputs_of(tree.definition, _core.Sensor("eye", Kind.motion, *ends[0], *ends[1], Axes.sensor))
    places = [pose_along(tree, system, v, 0 * v, *end) for end in ends]

    def vector(t):
        return Rotation.from_matrix(places[1](t)[:3, :3].T @ places[0](t)[:3, :3]).as_rotvec()

    if np.linalg.norm(vector(0.0)) > 2.8:
        return
    jumping = [outputs.names[i] for i in outputs.jumping]
    rates = dict(zip(jumping, outputs.rates(tree.q, v), strict=True))
    assert_close([rates[f"eye.rotationVector[{i}]"] for i in (1, 2, 3)], derivative(vector), 1e-9)


# --- momenta ---------------------------------------------------------------------------------------------------------


@property_test(40, seed=seeds)
def test_momenta_are_sums_over_bodies_and_nodes(seed):
    _, tree, system, v, u, *_ = moving(seed)
    value = Values(outputs_of(tree.definition), tree.q, v, u)
    total, first, linear, angular = 0.0, np.zeros(3), np.zeros(3), np.zeros(3)
    for i, body in enumerate(tree.definition.bodies):
        place, twist = tree.q[7 * i : 7 * i + 7], v[6 * i : 6 * i + 6]
        turn = rotation_of(place).as_matrix()
        if i not in tree.clouds:
            inertia = np.diag(body.inertia)
            inertia[[0, 0, 1], [1, 2, 2]] = inertia[[1, 2, 2], [0, 0, 1]] = body.inertia_products
            total += body.mass
            first = first + body.mass * place[:3]
            linear = linear + body.mass * twist[:3]
            angular = angular + np.cross(place[:3], body.mass * twist[:3]) + turn @ inertia @ twist[3:]
            continue
        cloud, zeta = tree.clouds[i], tree.zeta(system, tree.q, i)
        start = 6 * len(tree.definition.bodies) + system.modal_index(i)
        rates = np.concatenate([twist, v[start : start + cloud.modes]])
        places = place[:3] + cloud.places(zeta) @ turn.T
        velocities = cloud.jacobians(turn, zeta) @ rates
        total += cloud.mass.sum()
        first = first + cloud.mass.sum(axis=0) @ places
        linear = linear + cloud.mass.sum(axis=0) @ velocities
        angular = angular + np.cross(places, cloud.mass @ velocities).sum(axis=0)
    assert_close(value("centerOfMass"), first / total, 1e-14)
    assert_close(value("momentum"), linear, 1e-13)
    assert_close(value("angularMomentum"), angular, 1e-13)


def test_momenta_of_a_free_mechanism_are_kept():
    """Two bodies with a torsion spring and a bushing between them, without gravity."""
    mechanism = _core.Mechanism("Free")
    rng = np.random.default_rng(4)
    for i in range(2):
        body = _core.RigidBody()
        body.name, body.inertia = f"body{i}", np.array([1.0, 1.2, 0.9])
        body.initial_position = np.array([float(i), 0.0, 0.0])
        body.initial_velocity, body.initial_angular_velocity = rng.uniform(-1, 1, (2, 3))
        mechanism.multibody.add(body)
    mechanism.multibody.gravity = np.zeros(3)
    ends = (0, _core.Frame(np.array([0.5, 0, 0]), np.eye(3)), 1, _core.Frame(np.array([-0.5, 0, 0]), np.eye(3)))
    stiff = np.array([50.0, 60.0, 70.0])
    mechanism.multibody.add(_core.Bushing("pad", *ends, stiff, 0.01 * stiff, stiff, 0.01 * stiff))
    mechanism.multibody.add(_core.TorsionSpring("coil", *ends, 5.0))
    slave = _core.Slave(mechanism)
    slave.start()
    names = [f"{name}[{i}]" for name in ("momentum", "angularMomentum") for i in (1, 2, 3)]
    before = [slave.get(name) for name in names]
    middle = np.array([slave.get(f"centerOfMass[{i}]") for i in (1, 2, 3)])
    for i in range(500):
        slave.do_step(i * 2e-3, 2e-3)
    after = [slave.get(name) for name in names]
    np.testing.assert_allclose(after[:3], before[:3], atol=1e-10)
    np.testing.assert_allclose(after[3:], before[3:], atol=2e-5)  # to second order in the step
    moved = np.array([slave.get(f"centerOfMass[{i}]") for i in (1, 2, 3)]) - middle
    np.testing.assert_allclose(moved, np.array(before[:3]) / 2.0, atol=1e-6)


# --- powers ----------------------------------------------------------------------------------------------------------


@property_test(40, seed=seeds)
def test_kinetic_energy_changes_by_the_powers_of_all_elements(seed):
    """Motors, springs on joints and between bodies as the FMU tells them, with gravity, loads and inputs on bodies."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    definition = tree.definition
    bodies = len(definition.bodies)
    outputs = outputs_of(definition)
    system = _core.System(definition)
    v = system.project_velocities(tree.q, rng.uniform(-1, 1, system.velocity_size))
    u = rng.uniform(-5, 5, system.input_size)
    vdot, _ = system.accelerations(tree.q, v, u)
    value = Values(outputs, tree.q, v, u)
    told = [name for name in outputs.names if re.search(r"\.(\w+P|p)ower\d*$", name)]
    assert len([name for name in told if name.startswith("spring")]) == len(tree.springs)
    powers = sum(value(name) for name in told) + u[: 6 * bodies] @ v
    for i, body in enumerate(definition.bodies):
        powers += body.mass * definition.gravity @ v[6 * i : 6 * i + 3]
    for body, force, torque in tree.loads:
        powers += force @ v[6 * body : 6 * body + 3]
        powers += torque @ rotation_of(tree.q[7 * body : 7 * body + 7]).apply(v[6 * body + 3 : 6 * body + 6])
    rate = v @ mass_matrix(definition) @ vdot
    assert_close(rate, powers, 1e-11, np.abs(vdot).max() + 100.0)


def test_power_of_a_drive():
    """It lifts a pendulum at a constant rate: all of its power goes into the height."""
    mechanism = _core.Mechanism("Crane")
    arm = _core.RigidBody()
    arm.name, arm.mass = "arm", 2.0
    arm.initial_position = np.array([1.0, 0.0, 0.0])
    mechanism.multibody.add(arm)
    mechanism.multibody.gravity = np.array([0.0, -9.81, 0.0])
    ends = (GROUND, FRAME, 0, _core.Frame(np.array([-1.0, 0.0, 0.0]), np.eye(3)))
    mechanism.multibody.add(_core.Joint("axle", _core.JointType.revolute, *ends))
    mechanism.multibody.add(_core.Drive(0, _core.Motion.rate, 0.7))
    slave = _core.Slave(mechanism)
    slave.set("axle.motorTorque", 1.5)  # which the drive holds against
    slave.start()
    for i in range(100):
        slave.do_step(i * 1e-2, 1e-2)
    assert slave.get("axle.power") == pytest.approx(2.0 * 9.81 * np.cos(0.7) * 0.7, rel=1e-9)
    assert slave.get("axle.driveTorque") == pytest.approx(2.0 * 9.81 * np.cos(0.7) - 1.5, rel=1e-9)


# --- definitions -----------------------------------------------------------------------------------------------------


def bar(*sensors):
    """A rigid and a flexible body."""
    mechanism = _core.Mechanism("Bar")
    body = _core.RigidBody()
    body.name = "bob"
    mechanism.multibody.add(body)
    cloud = beam(1.0, 1.0, 0.02, [(lambda s: s**2, lambda s: 2 * s)], np.eye(2))
    mechanism.multibody.add(flexible_body(cloud, "beam"))
    for sensor in sensors:
        mechanism.add(sensor)
    return mechanism


def test_written_and_read_it_is_the_same():
    mechanism = _core.Mechanism("Eyes")
    body = _core.RigidBody()
    body.name = "bob"
    mechanism.multibody.add(body)
    frame = random_frame(np.random.default_rng(2))
    mechanism.add(_core.Sensor("eye", Kind.motion, 0, frame, GROUND, frame, Axes.sensor))
    mechanism.add(_core.Sensor("ear", Kind.imu, 0, frame))
    mechanism.sensors[0].description = "what it sees"
    text = _core.to_json(mechanism)
    assert _core.to_json(_core.from_json(text)) == text
    eye, ear = json.loads(text)["sensors"]
    assert set(eye) == {"name", "type", "description", "body", "frame", "reference", "reference_frame", "axes"}
    assert set(ear) == {"name", "type", "description", "body", "frame"}
    assert (eye["reference"], eye["axes"], ear["type"]) == ("ground", "sensor", "imu")
    data = json.loads(text)
    data["sensors"] = [{"name": "eye", "type": "motion", "body": "bob"}]
    (short,) = _core.from_json(json.dumps(data)).sensors
    assert (short.reference, short.axes) == (GROUND, Axes.reference)


def test_variables():
    names = _core.Slave(bar(_core.Sensor("eye", Kind.motion, 0), _core.Sensor("ear", Kind.imu, 1))).names
    motion = "position rotationVector velocity angularVelocity acceleration angularAcceleration"
    for owner, words in (("eye", motion), ("ear", "specificForce angularVelocity")):
        expected = [f"{owner}.{word}[{i}]" for word in words.split() for i in (1, 2, 3)]
        assert [name for name in names if name.startswith(owner + ".")] == expected


SKEW = _core.Frame(np.zeros(3), np.diag([1.0, 1.0, -1.0]))
REFUSED = {
    "body": (_core.Sensor("eye", Kind.imu, 5), "eye refers to body 5; allowed are -1 (ground) to 1."),
    "reference": (
        _core.Sensor("eye", Kind.motion, 0, FRAME, -7),
        "eye refers to body -7; allowed are -1 (ground) to 1.",
    ),
    "node of a rigid body": (
        _core.Sensor("eye", Kind.imu, 0, _core.Frame(np.zeros(3), np.eye(3), 2)),
        "eye attaches to node 2 of bob, which is not flexible; allowed is -1 (no node).",
    ),
    "node": (
        _core.Sensor("eye", Kind.imu, 1, _core.Frame(np.zeros(3), np.eye(3), 200)),
        "eye attaches to node 200 of beam; allowed are -1 (floating frame) to 43.",
    ),
    "axes": (
        _core.Sensor("eye", Kind.imu, 0, SKEW),
        "eye.frame.axes are (1, 0, 0), (0, 1, 0), (0, 0, -1); they must be orthonormal and right-handed.",
    ),
    "axes of the reference": (
        _core.Sensor("eye", Kind.motion, 0, FRAME, 1, SKEW),
        "eye.referenceFrame.axes are (1, 0, 0), (0, 1, 0), (0, 0, -1); they must be orthonormal and right-handed.",
    ),
    "name": (
        _core.Sensor("bob", Kind.imu, 0),
        "bob is the name of a body and of a sensor; every element needs its own.",
    ),
    "reserved name": (
        _core.Sensor("momentum.eye", Kind.imu, 0),
        "momentum.eye is the name of a sensor; momentum is reserved for what every mechanism has.",
    ),
}


@pytest.mark.parametrize(("sensor", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_sensors_are_refused_with_one_sentence(sensor, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        bar(sensor).validate()
