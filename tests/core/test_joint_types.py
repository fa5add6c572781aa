"""Each type of joint moves as equations in its own coordinates say: SciPy on formulas written down here."""

import json
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .helpers import (
    COORDINATES,
    GROUND,
    JOINT_TYPES,
    STABILIZED,
    Rotation,
    Type,
    assert_close,
    frame_pose,
    make_joint,
    pose,
    property_test,
    random_tree,
    rotation_of,
    seeds,
    to_touching_point,
)

HERE = _core.Frame(np.zeros(3), np.eye(3))
G = 9.81


def body(name, mass=1.0, inertia=(0.1, 0.2, 0.25), position=(0, 0, 0), turn=(0, 0, 0)):
    result = _core.RigidBody()
    result.name, result.mass, result.inertia = name, mass, np.array(inertia)
    result.initial_position = np.array(position, dtype=float)
    result.initial_quaternion = Rotation.from_rotvec(turn).as_quat(scalar_first=True)
    return result


def mechanism(*parts, gravity=(0, 0, 0)):
    result = _core.Mechanism("Joints")
    result.multibody.gravity = np.array(gravity, dtype=float)
    for part in parts:
        result.multibody.add(part)
    result.integrator.formulation = STABILIZED
    return result


def end(mechanism, h, stop, initial, names):
    """Values at the end of a run with steps of h, from initial values by the joints' names."""
    mechanism.integrator.step_size = h
    slave = _core.Slave(mechanism)
    for name, value in initial.items():
        slave.set(name, value)
    slave.start()
    steps = round(stop / h)
    for i in range(steps):
        slave.do_step(i * h, h)
    return np.array([slave.get(name) for name in names])


def solution(equations, initial, stop):
    return solve_ivp(equations, (0, stop), initial, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def assert_second_order(make, initial, names, expected, stop=1.0, h=4e-3):
    errors = [np.abs(end(make(), step, stop, initial, names) - expected).max() for step in (h, h / 2)]
    assert errors[1] < 1e-4 * max(1, np.abs(expected).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


# --- runs ------------------------------------------------------------------------------------------------------------


def springs(stiffness):
    return [_core.JointSpring(0, k, 0.0, 0.0, i) for i, k in enumerate(stiffness)]


def test_planar_joint_slides_and_turns():
    """Three oscillators in a plane that is anywhere."""
    axes = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()
    start, stiffness, inertia = np.array([0.4, -0.2, 0.3]), np.array([2.0, 30.0, 50.0]), np.array([0.25, 1.5, 1.5])

    def make():
        joint = _core.Joint("table", Type.planar, GROUND, _core.Frame(np.array([1.0, 2, 3]), axes), 0, HERE)
        place = body("puck", 1.5, (0.1, 0.2, 0.25), [1, 2, 3], Rotation.from_matrix(axes).as_rotvec())
        return mechanism(place, joint, *springs(stiffness))

    w = np.sqrt(stiffness / inertia)
    initial = dict(zip(("initialAngle", "initialDisplacement1", "initialDisplacement2"), start, strict=True))
    names = ["table.angle", "table.displacement1", "table.displacement2"]
    rates = ["table.angularRate", "table.rate1", "table.rate2"]
    accelerations = ["table.angularAcceleration", "table.acceleration1", "table.acceleration2"]
    expected = np.concatenate([start * np.cos(w), -start * w * np.sin(w), -start * w**2 * np.cos(w)])
    initial = {f"table.{name}": value for name, value in initial.items()}
    assert_second_order(make, initial, [*names, *rates, *accelerations], expected)


def test_universal_joint_counts_both_angles():
    """A gimbal: T = (Jx β'² + (Jy cos²β + Jz sin²β) α'²)/2 with a spring on each axis."""
    J, k = (0.1, 0.2, 0.25), (1.5, 0.8)

    def equations(_, y):
        a, b, da, db = y
        s, c = np.sin(b), np.cos(b)
        inertia = J[1] * c * c + J[2] * s * s
        return [da, db, (-k[0] * a - 2 * (J[2] - J[1]) * s * c * db * da) / inertia,
                ((J[2] - J[1]) * s * c * da**2 - k[1] * b) / J[0]]  # fmt: skip

    def make():
        cross = _core.Joint("cross", Type.universal, GROUND, HERE, 0, HERE)
        return mechanism(body("rotor", 1.0, J), cross, *springs(k))

    start = [0.5, 1.2, 9.0, -12.0]
    names = ["cross.angle1", "cross.angle2", "cross.angularRate1", "cross.angularRate2"]
    initial = {re.sub(r"\.a", ".initialA", name): value for name, value in zip(names, start, strict=True)}
    expected = solution(equations, start, 1.0)
    assert np.abs(expected[:2]).max() < np.pi
    assert_second_order(make, initial, names, expected)


@pytest.mark.parametrize("number", [1, 2])
def test_angles_of_a_universal_joint_count_turns(number):
    slave = _core.Slave(mechanism(body("rotor"), _core.Joint("cross", Type.universal, GROUND, HERE, 0, HERE)))
    slave.set(f"cross.motorTorque{number}", 2.0)
    slave.start()
    for i in range(4000):
        slave.do_step(i * 1e-3, 1e-3)
    inertia = {1: 0.2, 2: 0.1}[number]  # the body's y, then its x
    assert slave.get(f"cross.angle{number}") == pytest.approx(0.5 * 2.0 / inertia * 16, rel=1e-5)
    assert slave.get(f"cross.angularAcceleration{number}") == pytest.approx(2.0 / inertia, rel=1e-12)


def test_rod_carries_a_pendulum():
    """A body's centre on a rigid rod: θ'' = -g/L sin θ; the rod's force from Newton's law."""
    length, theta = 0.7, 1.1

    def make():
        ball = body("ball", 2.0, position=length * np.array([np.sin(theta), 0, -np.cos(theta)]))
        return mechanism(ball, _core.Joint("rod", Type.distance, GROUND, HERE, 0, HERE), gravity=(0, 0, -G))

    angle, rate = solution(lambda _, y: [y[1], -G / length * np.sin(y[0])], [theta, 0], 1.0)
    down = length * np.array([np.sin(angle), 0, -np.cos(angle)])
    tension = 2.0 * (length * rate**2 + G * np.cos(angle))
    names = [f"{n}[{i}]" for n in ("ball.position", "rod.reactionForce") for i in (1, 2, 3)]
    expected = np.concatenate([down, -tension * down / length])
    assert_second_order(make, {}, names, expected, h=2e-3)
    slave = _core.Slave(make())
    assert slave.get("rod.length") == pytest.approx(length, abs=1e-12)


def test_a_rod_of_another_length_pulls_its_body_there():
    rod = _core.Joint("rod", Type.distance, GROUND, HERE, 0, HERE, length=2.0)
    for length in (2.0, 2.5):
        slave = _core.Slave(mechanism(body("ball", position=(3.0, 0, 0)), rod))
        slave.set("rod.length", length)
        slave.start()
        assert slave.get("ball.position[1]") == pytest.approx(length, abs=1e-14)


def test_bead_on_a_swinging_line():
    """T = (J θ'² + m (s'² + s² θ'²))/2 of a line that turns about y and a bead on it, V = -m g s cos θ."""
    J, m, start = 0.2, 0.5, [0.9, 0.3, -2.0, 0.4]  # θ, s and rates; the line hangs down at θ = 0
    down = _core.Frame(np.zeros(3), Rotation.from_rotvec([np.pi, 0, 0]).as_matrix())

    def equations(_, y):
        theta, s, dtheta, ds = y
        force = -m * G * s * np.sin(theta) - 2 * m * s * ds * dtheta
        return [dtheta, ds, force / (J + m * s * s), s * dtheta**2 + G * np.cos(theta)]

    def make():
        # the hinge turns about -y, so that θ swings the line from -z towards x
        pin = _core.Frame(np.zeros(3), _core.axes_with_z(np.array([0.0, -1, 0])))
        return mechanism(
            body("line", 3.0, (0.1, J, 0.1)),
            body("bead", m, position=(0, 0, -0.3)),
            _core.Joint("hinge", Type.revolute, GROUND, pin, 0, pin),
            _core.Joint("wire", Type.point_on_line, 0, down, 1, HERE),
            gravity=(0, 0, -G),
        )

    names = ["hinge.angle", "wire.displacement", "hinge.angularRate", "wire.rate"]
    initial = {re.sub(r"\.(.)", lambda f: ".initial" + f[1].upper(), n): x for n, x in zip(names, start, strict=True)}
    assert_second_order(make, initial, names, solution(equations, start, 1.0), h=2e-3)


def test_free_joint_measures_and_acts():
    """Displacements of a body that nothing else holds, in axes that are turned."""
    axes = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()
    joint = _core.Joint("probe", Type.free, GROUND, _core.Frame(np.array([1.0, 0, 0]), axes), 0, HERE)
    slave = _core.Slave(mechanism(body("ship", 2.0), joint))
    for i, force in enumerate((1.0, -2.0, 0.5)):
        slave.set(f"probe.actuatorForce{i + 1}", force)
    slave.start()
    assert not any(name.startswith("probe.reaction") for name in slave.names)
    for i in range(100):
        slave.do_step(i * 1e-2, 1e-2)
    acceleration = np.array([1.0, -2.0, 0.5]) / 2.0
    place = axes.T @ [-1, 0, 0] + 0.5 * acceleration
    assert [slave.get(f"probe.displacement{i}") for i in (1, 2, 3)] == pytest.approx(place, abs=1e-12)
    assert [slave.get(f"probe.acceleration{i}") for i in (1, 2, 3)] == pytest.approx(acceleration, abs=1e-12)


# --- reactions -------------------------------------------------------------------------------------------------------


@property_test(50, seed=seeds)
def test_reactions_move_every_body_as_newton_and_euler_say(seed):
    """Trees of all joints: the reactions of its joints, gravity and motors are all that acts on a body."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, 4, joint_springs=False)
    definition = _core.Multibody()
    definition.gravity = tree.definition.gravity
    for part in (*tree.definition.bodies, *tree.definition.joints):
        definition.add(part)
    system = _core.System(definition)
    v = system.project_velocities(tree.q, rng.uniform(-1, 1, system.velocity_size))
    vdot, multipliers = system.accelerations(tree.q, v, np.zeros(system.input_size))
    forces, torques = np.zeros((2, 5, 3))  # of W, about W's origin; the last body is the ground
    placed = [*(pose(x[:3], rotation_of(x).as_matrix()) for x in tree.q.reshape(-1, 7)), np.eye(4)]
    for j, (kind, one, frame1, two, frame2) in enumerate(tree.joints):
        force, torque = system.reaction(tree.q, v, multipliers, j)
        first, second = placed[one] @ frame_pose(frame1), placed[two] @ frame_pose(frame2)
        at = second[:3, 3]
        if kind == Type.rolling_disk:
            at = at + to_touching_point(first[:3, :3], second[:3, :3])
        for sign, side in ((1, two), (-1, one)):
            forces[side] += sign * force
            torques[side] += sign * (torque + np.cross(at, force))
    for i, part in enumerate(definition.bodies):
        inertia = np.diag(part.inertia)
        inertia[[0, 0, 1], [1, 2, 2]] = inertia[[1, 2, 2], [0, 0, 1]] = part.inertia_products
        turn, w, place = rotation_of(tree.q[7 * i : 7 * i + 7]), v[6 * i + 3 : 6 * i + 6], tree.q[7 * i : 7 * i + 3]
        force = part.mass * (vdot[6 * i : 6 * i + 3] - definition.gravity)
        torque = turn.apply(inertia @ vdot[6 * i + 3 : 6 * i + 6] + np.cross(w, inertia @ w)) + np.cross(place, force)
        size = np.abs(multipliers).max(initial=10)
        assert_close(forces[i], force, 1e-12, size)
        assert_close(torques[i], torque, 1e-12, size)


# --- definitions -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", JOINT_TYPES, ids=lambda t: t.name)
def test_coordinates_have_names_in_the_fmu_and_in_files(kind):
    upright = _core.Frame(np.zeros(3), np.eye(3)[[1, 2, 0]])  # a disk must not lie flat
    joint = make_joint("j", kind, GROUND, HERE, 0, upright if kind == Type.rolling_disk else HERE)
    count = COORDINATES.get(kind, 0)
    joint.initial_coordinates = [0.1 * k if k < count else np.nan for k in range(3)]
    joint.initial_rates = [0.2 * k if k < count else np.nan for k in range(3)]
    m = mechanism(body("b", position=(1.0, 0, 0)), joint)
    text = _core.to_json(m)
    assert _core.to_json(_core.from_json(text)) == text
    keys = {"name", "type", "bodies", "frame1", "frame2", "length", "pitch", "radius"}
    assert len(set(json.loads(text)["joints"][0]) - keys) == 2 * count
    names = _core.Slave(m).names
    values = [name for name in names if re.fullmatch(r"j\.(angle|displacement)\d?", name)]
    assert len(values) == count
    for name in values:
        rate = name.replace("angle", "angularRate").replace("displacement", "rate")
        acceleration = name.replace("angle", "angularAcceleration").replace("displacement", "acceleration")
        motor = name.replace("angle", "motorTorque").replace("displacement", "actuatorForce")
        assert {rate, acceleration, motor} <= set(names)


@pytest.mark.parametrize(
    ("kind", "length", "message"),
    [
        (Type.distance, -1.0, "j.length is -1 m; it must be finite, above 0."),
        (Type.distance, np.inf, "j.length is inf m; it must be finite, above 0."),
        (Type.distance, np.nan, "j keeps points apart that coincide at the start; they must have a distance."),
        (Type.fixed, 1.0, "j has the length 1 m; joints of its type must have none."),
    ],
)
def test_lengths_that_make_no_sense_are_refused(kind, length, message):
    m = mechanism(body("b"), _core.Joint("j", kind, GROUND, HERE, 0, HERE, length=length))
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        m.validate()
