"""Contact and friction: bouncing balls against SciPy, blocks that stick, slide and roll on a slope, step control."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .helpers import GROUND, Rotation

RADIUS, MASS, MODULUS, GRAVITY = 0.1, 1.0, 1e6, 9.81
HERTZ = 4 / 3 * MODULUS * np.sqrt(RADIUS)
FLOOR = _core.Frame(np.zeros(3), np.eye(3))
TIGHT = {"relative_tolerance": 1e-12, "absolute_tolerance": 1e-12}


def body(name, position, velocity=(0.0, 0.0, 0.0)):
    result = _core.RigidBody()
    result.name, result.mass, result.inertia = name, MASS, 0.4 * MASS * RADIUS**2 * np.ones(3)
    result.initial_position, result.initial_velocity = np.array(position, float), np.array(velocity, float)
    return result


def ball(surface, height=0.6, velocity=(0.0, 0.0, 0.0), gravity=(0.0, 0.0, -GRAVITY)):
    """A ball above a floor."""
    mechanism = _core.Mechanism("Ball")
    mechanism.multibody.add(body("ball", (0, 0, height), velocity))
    mechanism.multibody.gravity = np.array(gravity, float)
    mechanism.multibody.add(_core.PlaneContact("floor", GROUND, FLOOR, 0, np.zeros(3), RADIUS, surface))
    return mechanism


def bounces(dissipation, stop):
    """Height and velocity at times of a ball that drops from 0.6 m."""

    def rate(_, y):
        depth = RADIUS - y[0]
        normal = HERTZ * depth**1.5 * (1 - 1.5 * dissipation * y[1]) if depth > 0 else 0.0
        return [y[1], max(normal, 0.0) / MASS - GRAVITY]

    return solve_ivp(rate, (0.0, stop), [0.6, 0.0], "DOP853", rtol=1e-12, atol=1e-14, max_step=1e-3).y[:, -1]


@pytest.mark.parametrize("dissipation", [0.05, 0.5], ids=["springs back", "would stick"])
def test_a_bouncing_ball(dissipation):
    """Three impacts and more in 2 s, of 15 ms each: second order as long as steps resolve them."""
    expected = bounces(dissipation, 2.0)
    errors = []
    for h in (5e-4, 1.25e-4):
        run = _core.Simulation(ball(_core.ContactSurface(MODULUS, dissipation)))
        run.advance(h, round(2.0 / h))
        errors.append(np.abs(np.array([run.state.q[2], run.state.v[2]]) - expected).max())
        assert run.state.counters.retries == 0
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] > 10  # of 16


@pytest.mark.parametrize(("tolerance", "error", "steps"), [(1e-5, 1e-4, 350), (1e-7, 1e-5, 1000)])
def test_step_control_finds_the_impacts(tolerance, error, steps):
    """From steps of 20 ms in flight to what an impact needs and back; of fixed ones 16 000 leave 5e-6 m."""
    mechanism = ball(_core.ContactSurface(MODULUS, 0.05))
    mechanism.integrator.step_control, mechanism.integrator.error_tolerance = 2, tolerance
    mechanism.integrator.step_size = 0.02
    slave = _core.Slave(mechanism)
    slave.start()
    for i in range(100):
        slave.do_step(i * 0.02, 0.02)
    assert slave.get("ball.position[3]") == pytest.approx(bounces(0.05, 2.0)[0], abs=error)
    assert slave.get("integrator.steps") < steps


@pytest.mark.parametrize("speed", [0.2, 1.0])
def test_restitution_of_small_impacts(speed):
    """(1 - c v) v, to first order in c v."""
    dissipation = 0.05
    run = _core.Simulation(ball(_core.ContactSurface(MODULUS, dissipation), RADIUS + 1e-4, (0, 0, -speed), (0, 0, 0)))
    run.advance(5e-5, round(0.1 / 5e-5))
    assert run.state.v[2] == pytest.approx(
        speed * (1 - dissipation * speed), abs=2 * speed * (dissipation * speed) ** 2
    )


def test_a_ball_that_rests_on_the_floor():
    """It stays where the force is the weight, and nothing of it moves."""
    depth = (MASS * GRAVITY / HERTZ) ** (2 / 3)
    mechanism = ball(_core.ContactSurface(MODULUS, 0.1, 0.5), RADIUS - depth)
    slave = _core.Slave(mechanism)
    slave.start()
    for i in range(100):
        slave.do_step(i * 1e-2, 1e-2)
    assert slave.get("floor.gap") == pytest.approx(-depth, rel=1e-9)
    assert slave.get("floor.normalForce") == pytest.approx(MASS * GRAVITY, rel=1e-9)
    assert slave.get("floor.energy") == pytest.approx(0.4 * HERTZ * depth**2.5, rel=1e-9)
    assert slave.get("floor.power") == pytest.approx(0.0, abs=1e-9)


def test_two_balls_collide():
    """Head on: the relative motion of Hertz with the reduced mass; momentum is kept to rounding."""
    radii, dissipation, speed = (0.1, 0.06), 0.1, 2.0
    stiffness = 4 / 3 * MODULUS * np.sqrt(radii[0] * radii[1] / sum(radii))
    way = np.array([2.0, -1.0, 2.0]) / 3

    def rate(_, y):
        depth = max(sum(radii) - y[0], 0.0)
        normal = max(stiffness * depth**1.5 * (1 - 1.5 * dissipation * y[1]), 0.0)
        return [y[1], normal * (1 / 1.0 + 1 / 2.5)]

    start = [sum(radii) + 0.01, -speed]
    expected = solve_ivp(rate, (0, 0.03), start, "DOP853", rtol=1e-12, atol=1e-14, max_step=1e-4).y[:, -1]
    mechanism = _core.Mechanism("Balls")
    for name, mass, place, velocity in (("one", 1.0, 0.0, 0.5), ("two", 2.5, start[0], 0.5 - speed)):
        one = body(name, place * way, velocity * way)
        one.mass = mass
        mechanism.multibody.add(one)
    mechanism.multibody.gravity = np.zeros(3)
    zero = np.zeros(3)
    surface = _core.ContactSurface(MODULUS, dissipation, 0.3)
    mechanism.multibody.add(_core.SphereContact("hit", 0, zero, radii[0], 1, zero, radii[1], surface))
    for name, value in TIGHT.items():
        setattr(mechanism.integrator, name, value)
    run = _core.Simulation(mechanism)
    run.advance(2e-5, 1500)
    one, two = run.state.q.reshape(2, 7)[:, :3]
    assert (two - one) @ way == pytest.approx(expected[0], abs=1e-6)
    v = run.state.v.reshape(2, 6)
    assert (v[1, :3] - v[0, :3]) @ way == pytest.approx(expected[1], abs=1e-4)
    momentum = 1.0 * v[0, :3] + 2.5 * v[1, :3]
    np.testing.assert_allclose(momentum, (0.5 + 2.5 * (0.5 - speed)) * way, rtol=0, atol=1e-12)


# --- on a slope ------------------------------------------------------------------------------------------------------

SLOPE = np.radians(20.0)
DOWN = np.array([np.cos(SLOPE), 0.0, -np.sin(SLOPE)])
UP = Rotation.from_rotvec([0.0, SLOPE, 0.0])


def on_slope(friction, slip_velocity, feet=True):
    """A block on three feet that touch the slope below its centre of mass, without tilting it; or a ball."""
    mechanism = _core.Mechanism("Slope")
    depth = (MASS * GRAVITY * np.cos(SLOPE) / (3 if feet else 1) / HERTZ) ** (2 / 3)
    normal = UP.apply([0.0, 0.0, 1.0])
    height = (0.0 if feet else RADIUS) - depth
    block = body("block", height * normal)
    block.initial_quaternion = UP.as_quat(scalar_first=True)
    mechanism.multibody.add(block)
    mechanism.multibody.gravity = np.array([0.0, 0.0, -GRAVITY])
    slope = _core.Frame(np.zeros(3), UP.as_matrix())
    surface = _core.ContactSurface(MODULUS, 0.3, friction, slip_velocity)
    angles = np.radians([0.0, 120.0, 240.0])
    places = [[0.3 * np.cos(a), 0.3 * np.sin(a), RADIUS] for a in angles] if feet else [[0.0, 0.0, 0.0]]
    for i, place in enumerate(places):
        foot = _core.PlaneContact(f"foot{i}", GROUND, slope, 0, np.array(place), RADIUS, surface)
        mechanism.multibody.add(foot)
    return mechanism


def test_a_block_sticks_on_a_slope_but_for_its_creep():
    """mu > tan(slope): friction carries it at the velocity where s = tan(slope) / mu."""
    friction, slip = 0.5, 1e-3
    run = _core.Simulation(on_slope(friction, slip))
    run.advance(1e-4, 20000)
    sine = np.tan(SLOPE) / friction
    assert run.state.v[:3] @ DOWN == pytest.approx(slip * sine / np.sqrt(1 - sine**2), rel=1e-6)
    assert np.linalg.norm(run.state.v[3:]) < 1e-9


def test_a_block_slides_down_a_slope():
    """mu < tan(slope): g (sin - mu cos s(v)), integrated beside it."""
    friction, slip = 0.2, 1e-2

    def rate(_, y):
        held = friction * np.cos(SLOPE) * y[1] / np.hypot(y[1], slip)
        return [y[1], GRAVITY * (np.sin(SLOPE) - held)]

    expected = solve_ivp(rate, (0, 1.0), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    run = _core.Simulation(on_slope(friction, slip))
    run.advance(1e-4, 10000)
    assert run.state.q[:3] @ DOWN == pytest.approx(expected[0], abs=1e-6)
    assert run.state.v[:3] @ DOWN == pytest.approx(expected[1], abs=1e-5)


def test_a_cloud_of_points_is_as_many_contacts():
    """The same block on one element with three points, thrown onto the slope so that each of them bounces."""
    one = on_slope(0.4, 1e-2)
    feet, block = one.multibody.plane_contacts, one.multibody.bodies[0]
    block.initial_position = block.initial_position + UP.apply([0.0, 0.0, 0.05])
    block.initial_angular_velocity = np.array([1.0, -2.0, 0.5])
    both = []
    for cloud in (False, True):
        mechanism = _core.Mechanism("Throw")
        mechanism.multibody.add(block)
        mechanism.multibody.gravity = one.multibody.gravity
        if cloud:
            points = [foot.point2 for foot in feet]
            hull = _core.CloudContact("hull", GROUND, feet[0].frame1, 0, points, RADIUS, feet[0].surface)
            mechanism.multibody.add(hull)
        else:
            for foot in feet:
                mechanism.multibody.add(foot)
        run = _core.Simulation(mechanism)
        run.advance(2e-4, 2000)
        both.append(run.state)
        assert np.abs(run.state.v[3:]).max() > 0.1
    np.testing.assert_allclose(both[1].q, both[0].q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(both[1].v, both[0].v, rtol=0, atol=1e-8)


def test_a_ball_rolls_down_a_slope():
    """With 5/7 of the acceleration of a block without friction; it slips at the velocity that friction asks for."""
    slip = 1e-3
    run = _core.Simulation(on_slope(0.5, slip, feet=False))
    run.advance(1e-4, 10000)
    assert run.state.vdot[:3] @ DOWN == pytest.approx(5 / 7 * GRAVITY * np.sin(SLOPE), rel=1e-6)
    sine = 2 / 7 * np.tan(SLOPE) / 0.5
    rolling = run.state.v[:3] @ DOWN - RADIUS * run.state.v[4]
    assert rolling == pytest.approx(slip * sine / np.sqrt(1 - sine**2), rel=1e-4)
