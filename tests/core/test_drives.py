"""Drives: prescribed coordinates of joints, whose equations depend on time."""

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    COORDINATES,
    EPS,
    GROUND,
    INDEX3,
    STABILIZED,
    Rotation,
    assert_close,
    derivative,
    property_test,
    random_tree,
    rotation_of,
    seeds,
)

Type, Motion = _core.JointType, _core.Motion


def driven_tree(seed):
    """A random tree, each of whose coordinates is driven with probability one half, and velocities that fit.

    Of a screw one alone: the other follows it.
    """
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    driven = []
    for i, (kind, *_) in enumerate(tree.joints):
        for k in range(COORDINATES.get(kind, 0)):
            if rng.random() < 0.5 and not (kind == Type.screw and (i, 0) in driven):
                driven.append((i, k))
                tree.definition.add(_core.Drive(i, Motion.acceleration, rng.uniform(-3, 3), k))
    system = _core.System(tree.definition)
    start, rest = system.start, np.zeros(system.velocity_size)
    start.x = np.array([system.coordinate(tree.q, rest, *at)[0] for at in driven])
    start.xdot = rng.uniform(-2, 2, system.drive_count)
    system.start = start
    v = system.project_velocities(tree.q, rng.uniform(-1, 1, system.velocity_size))
    return rng, tree, system, v


@property_test(100, seed=seeds)
def test_equations_and_their_derivatives(seed):
    """Φ = 0 at the start, Φ' = Bv - x', Φ'' = B v̇ + Z v + W = 0 with W = -x''."""
    rng, tree, system, v = driven_tree(seed)
    phi, rate, gradient, rate_gradient = system.constraints(tree.q, v)
    assert_close(phi, np.zeros_like(phi), 100 * EPS)
    assert_close(rate, np.zeros_like(phi), 100 * EPS)
    explicit = system.explicit_rate(tree.q, v)
    joints = system.constraint_size - system.drive_count
    assert_close(gradient @ v, np.concatenate([np.zeros(joints), system.start.xdot]), 100 * EPS, 10)
    np.testing.assert_array_equal(explicit, np.concatenate([np.zeros(joints), -system.start.xddot]))
    vdot, _ = system.accelerations(tree.q, v, rng.uniform(-5, 5, system.input_size))
    assert_close(gradient @ vdot + rate_gradient @ v + explicit, np.zeros_like(phi), 1e-11, np.abs(vdot).max())
    w = rng.uniform(-1, 1, len(v))
    moved = derivative(lambda t: system.constraints(system.compose(tree.q, t * w), v)[0])
    of_positions = np.setdiff1d(np.arange(len(phi)), system.velocity_equations)
    assert_close((gradient @ w)[of_positions], moved[of_positions], 1e-8, 1.0)


@property_test(100, seed=seeds)
def test_the_power_of_drives_completes_the_balance_of_energy(seed):
    """Energy changes by the power of all else and by -λ x' of every drive: that of the gradient's rows."""
    _, tree, system, v = driven_tree(seed)
    inputs = np.zeros(system.input_size)
    vdot, multipliers = system.accelerations(tree.q, v, inputs)
    energy = derivative(lambda t: system.energy(system.compose(tree.q, t * v), v + t * vdot))
    drives = multipliers[system.constraint_size - system.drive_count :]
    power = -drives @ system.start.xdot
    for body, force, torque in tree.loads:
        turn = rotation_of(tree.q[7 * body : 7 * body + 7])
        power += force @ v[6 * body : 6 * body + 3] + torque @ turn.apply(v[6 * body + 3 : 6 * body + 6])
    for i, k, _, damping, _ in tree.joint_springs:
        power -= damping * system.coordinate(tree.q, v, i, k)[1] ** 2
    for one, point1, two, point2, _, damping in tree.springs:
        rate = np.zeros(3)
        for body, point, sign in ((one, point1, -1), (two, point2, 1)):
            if body != GROUND:
                turn, twist = rotation_of(tree.q[7 * body : 7 * body + 7]), v[6 * body : 6 * body + 6]
                rate += sign * (twist[:3] + turn.apply(np.cross(twist[3:], point)))
        power -= damping @ rate**2
    size = abs(system.energy(tree.q, v)) + np.abs(vdot).max() ** 2
    assert_close(energy, power, 1e-10, size)


# --- runs ------------------------------------------------------------------------------------------------------------

METHODS = {
    "index3": {"formulation": INDEX3},
    "index2": {"formulation": 2},
    "stabilizedIndex2": {"formulation": STABILIZED},
    "bliedf2": {"method": 4, "formulation": STABILIZED},
    "rkmk4": {"method": 2},
}
every_method = pytest.mark.parametrize("method", METHODS)


def slider_crank(motion, value, method, h):
    """The benchmark with a driven crank; its motion is that of closed chains, whatever the masses."""
    mechanism = _core.mechanism("SliderCrank")
    mechanism.multibody.add(_core.Drive(0, motion, value))
    mechanism.integrator.step_size = h
    for name, chosen in METHODS[method].items():
        setattr(mechanism.integrator, name, chosen)
    return mechanism


def slider_position(angle):
    """From the geometry: crank 0.08 about W x at (0, 0.1, 0.12), rod 0.3, slider on the x axis."""
    y, z = 0.1 - 0.08 * np.sin(angle), 0.12 + 0.08 * np.cos(angle)
    return np.sqrt(0.3**2 - y**2 - z**2)


@every_method
@pytest.mark.parametrize(("motion", "value"), [(Motion.rate, 6.0), (Motion.rate, -20.0), (Motion.acceleration, 8.0)])
def test_a_driven_crank_moves_the_slider_as_geometry_says(method, motion, value):
    """No degree of freedom is left: in the position forms there is no error but that of the solution."""
    simulation = _core.Simulation(slider_crank(motion, value, method, 1e-3))
    start = 6.0 if motion == Motion.acceleration else value
    acceleration = value if motion == Motion.acceleration else 0.0
    assert simulation.state.v[3] == pytest.approx(start, abs=1e-12)  # whatever the initial values say
    for t in (0.0, 0.25, 0.5, 1.0):
        if t > 0:
            simulation.run(t, 250 if t < 1 else 500)
        angle = start * t + 0.5 * acceleration * t**2
        # index 2 holds rates alone: positions drift with the error of the integration, of second order
        tolerance = 1e-4 if method == "index2" else 1e-11
        assert simulation.state.turned[0] == pytest.approx(angle, abs=tolerance)
        assert simulation.state.q[14] == pytest.approx(slider_position(angle), abs=tolerance)


def pendulum(motion, value, tilt=0.0):
    """A bar of 2 kg on a driven hinge about W y, its centre 0.5 m away; gravity."""
    definition = _core.Multibody()
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = "bar", 2.0, np.array([0.02, 0.2, 0.2])
    body.initial_position = Rotation.from_rotvec([0, tilt, 0]).apply([0.5, 0, 0])
    body.initial_quaternion = Rotation.from_rotvec([0, tilt, 0]).as_quat(scalar_first=True)
    definition.add(body)
    axes = _core.axes_with_z(np.array([0.0, 1, 0]))
    definition.gravity = np.array([0, 0, -9.81])
    ends = _core.Frame(np.zeros(3), axes), _core.Frame(np.array([-0.5, 0, 0]), axes)
    hinge = _core.Joint("hinge", Type.revolute, GROUND, ends[0], 0, ends[1])
    definition.add(hinge)
    definition.add(_core.Drive(0, motion, value))
    mechanism = _core.Mechanism("Pendulum")
    mechanism.multibody = definition
    return mechanism


def motor_torque(angle, acceleration):
    """About W y, by Newton's law: J = 0.2 + 2·0.5²."""
    return 0.7 * acceleration - 2 * 9.81 * 0.5 * np.cos(angle)


@every_method
def test_the_torque_of_a_drive_is_of_second_order(method):
    """An accelerated hinge: -λ against Newton's law; what the paper's λ has of order 2 in the formulations."""
    errors = []
    for h in (2e-3, 1e-3):
        mechanism = pendulum(Motion.acceleration, 3.0)
        for name, chosen in METHODS[method].items():
            setattr(mechanism.integrator, name, chosen)
        simulation = _core.Simulation(mechanism)
        simulation.run(1.5, round(1.5 / h))
        angle = 0.5 * 3.0 * 1.5**2
        errors.append(abs(-simulation.state.lambda_[5] - motor_torque(angle, 3.0)))
    assert errors[1] < 1e-9 or np.log2(errors[0] / errors[1]) > 1.9
    assert errors[1] < 1e-5 * abs(motor_torque(angle, 3.0)) + 1e-9


def test_a_position_that_is_held():
    """The bar is assembled at 0.7 rad from where it was drawn, and stays there; the drive bears its weight."""
    simulation = _core.Simulation(pendulum(Motion.position, 0.7))
    simulation.run(1.0, 100)
    assert simulation.state.turned[0] == pytest.approx(0.7, abs=1e-13)
    assert np.abs(simulation.state.v).max() < 1e-12
    assert -simulation.state.lambda_[5] == pytest.approx(motor_torque(0.7, 0.0), abs=1e-10)


def test_turns_of_a_driven_joint_are_counted():
    simulation = _core.Simulation(pendulum(Motion.rate, 50.0, tilt=2.0))
    simulation.run(2.0, 2000)
    assert simulation.state.turned[0] == pytest.approx(2.0 + 100.0, abs=1e-11)


def test_degrees_of_freedom_count_drives():
    freedom = _core.freedom(pendulum(Motion.rate, 1.0).multibody)
    assert (freedom.degrees, freedom.independent) == (0, 6)


def test_two_drives_of_one_coordinate_are_refused():
    mechanism = pendulum(Motion.rate, 1.0)
    mechanism.multibody.add(_core.Drive(0, Motion.position, 0.0))
    with pytest.raises(ValueError, match="hinge has two drives on the same coordinate"):
        _core.Simulation(mechanism)


@pytest.mark.parametrize(("joint", "coordinate"), [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_a_drive_of_what_is_not_there_is_refused(joint, coordinate):
    mechanism = pendulum(Motion.rate, 1.0)
    mechanism.multibody.add(_core.Drive(joint, Motion.rate, 1.0, coordinate))
    with pytest.raises(ValueError, match=r"^A drive acts on (joint|coordinate)"):
        mechanism.validate()


def test_a_drive_against_a_joint_is_told_by_name():
    """A welded bar that is to turn."""
    mechanism = pendulum(Motion.position, 0.5)
    frame = _core.Frame(np.array([0.5, 0, 0]), np.eye(3))
    mechanism.multibody.add(_core.Joint("weld", Type.fixed, GROUND, frame, 0, _core.Frame(np.zeros(3), np.eye(3))))
    with pytest.raises(RuntimeError, match="weld"):
        _core.Simulation(mechanism)
