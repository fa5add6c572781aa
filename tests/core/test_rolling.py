"""Disks that roll without slip: closed forms, order, what every formulation keeps, freedom, start, what is refused."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .helpers import (
    FORMULATIONS,
    GROUND,
    Rotation,
    Type,
    assert_bitwise,
    assert_close,
    copy,
    rotation_of,
    simulation,
)
from .methods import BLIEDF2, RKMK4, RKMK54, TIGHT
from .test_joint_types import HERE, body, mechanism

RADIUS, MASS, GRAVITY = 0.1, 1.3, 9.81
AXIAL, ACROSS = 0.5 * MASS * RADIUS**2, 0.25 * MASS * RADIUS**2
X, Y, Z = np.eye(3)
METHODS = {
    **{name: {"formulation": value} for name, value in FORMULATIONS.items()},
    "modified": {"newton": 2},
    "incremental": {"corrector": 2},
    "incremental index3": {"corrector": 2, "formulation": 1},
    "bliedf2": {"method": BLIEDF2},
    "bliedf2 index3": {"method": BLIEDF2, "formulation": 1},
    "SE3": {"group": 2},
    "SE3 index3": {"group": 2, "formulation": 1},
    "rkmk4": {"method": RKMK4},
}
every_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


def coin(lean, spin, *parts, plane=HERE, second="coin", radius=RADIUS):
    """A disk on the plane z = 0 of frame `plane` of the ground, its axis z at the angle `lean` to the normal.

    `spin`: angular velocity in axes of the disk, x along the track; it rolls.
    """
    turn = plane.axes @ Rotation.from_rotvec(lean * X).as_matrix()
    place = plane.origin + radius * np.sin(lean) * plane.axes[:, 2]
    disk = body(second, MASS, (ACROSS, ACROSS, AXIAL), place, Rotation.from_matrix(turn).as_rotvec())
    spin = np.asarray(spin, dtype=float)
    disk.initial_angular_velocity = spin
    disk.initial_velocity = -turn @ np.cross(spin, [0, -radius, 0])  # the lowest point is at -y of the disk
    joint = _core.Joint("table", Type.rolling_disk, GROUND, plane, 0, HERE, radius=radius)
    return mechanism(disk, joint, *parts, gravity=tuple(-GRAVITY * plane.axes[:, 2]))


def steady(lean, precession):
    """Spin in axes of the disk with which it goes round with a constant lean.

    (C + m r^2) w W s - A W^2 s c + m g r c = 0: of the moment about the centre, with the force m (v' + g), s and c of
    the lean, the precession W about the normal and w about the axis.
    """
    s, c = np.sin(lean), np.cos(lean)
    about_axis = (ACROSS * precession**2 * s * c - MASS * GRAVITY * RADIUS * c) / (
        (AXIAL + MASS * RADIUS**2) * precession * s
    )
    return np.array([0.0, precession * s, about_axis])


@every_method
def test_a_coin_goes_round_with_a_constant_lean(method):
    """On a circle, with the force that its way takes; a turn of 0.6 s is 600 steps."""
    lean, precession = 1.0, 10.0
    spin = steady(lean, precession)
    m = coin(lean, spin)
    for name, value in method.items():
        setattr(m.integrator, name, value)
    m.integrator.step_size = 1e-3
    slave = _core.Slave(m)
    slave.start()
    get = lambda name: np.array([slave.get(f"{name}[{i}]") for i in (1, 2, 3)])  # noqa: E731
    start, velocity = get("coin.position"), get("coin.velocity")
    T = 0.6
    slave.do_step(0, T)
    speed = -RADIUS * spin[2]
    assert velocity == pytest.approx([speed, 0, 0], abs=1e-12)
    way = speed / precession * np.array([np.sin(precession * T), 1 - np.cos(precession * T), 0])
    assert get("coin.position") - start == pytest.approx(way, abs=2e-4)
    inward = speed * precession * np.array([-np.sin(precession * T), np.cos(precession * T), 0])
    assert get("table.reactionForce") == pytest.approx(MASS * (inward + GRAVITY * Z), abs=0.03)
    assert get("table.reactionTorque") == pytest.approx(np.zeros(3), abs=0)
    turned = Rotation.from_rotvec(precession * T * Z)
    assert get("table.contactPoint") == pytest.approx(
        start * [1, 1, 0] + way - turned.apply([0, RADIUS * np.cos(lean), 0]), abs=5e-4
    )
    assert slave.get("constraint.positionResidual") < 1e-6
    assert slave.get("constraint.velocityResidual") < 1e-4


def motion(lean, spin, times):
    """Centre and orientation of a disk by its heading, lean and turn, with Euler's equations in axes that follow the
    first two, x along the track:

    w = (lean', heading' s, heading' c + turn'), v = -w x d with the constant d = (0, -r, 0) to the point of contact,
    J w' + W x J w = d x m (v' + g n), W the angular velocity of the axes, n the normal. By DOP853.
    """
    J = np.diag([ACROSS, ACROSS, AXIAL])
    d = -RADIUS * Y
    hat = np.array([[0, 0, -RADIUS], [0, 0, 0], [RADIUS, 0, 0]])  # d x

    def rhs(_, y):
        heading, lean, w = y[0], y[1], y[5:]
        s, c = np.sin(lean), np.cos(lean)
        axes = np.array([w[0], w[1], w[1] * c / s])
        weight = MASS * GRAVITY * np.cross(d, [0, s, c])
        carried = np.cross(axes, J @ w) + MASS * np.cross(d, np.cross(axes, np.cross(w, d)))
        wdot = np.linalg.solve(J - MASS * hat @ hat, weight - carried)
        velocity = -np.cross(w, d)
        R = Rotation.from_rotvec(heading * Z) * Rotation.from_rotvec(lean * X)
        return [w[1] / s, w[0], w[2] - axes[2], *R.apply(velocity)[:2], *wdot]

    found = solve_ivp(rhs, (0, times[-1]), [0, lean, 0, 0, 0, *spin], "DOP853", times, rtol=1e-12, atol=1e-13)
    heading, lean, turn, x, y = found.y[:5]
    R = (
        Rotation.from_rotvec(np.outer(heading, Z))
        * Rotation.from_rotvec(np.outer(lean, X))
        * Rotation.from_rotvec(np.outer(turn, Z))
    )
    return np.column_stack([x, y, RADIUS * np.sin(lean)]), R


GENERAL = (1.1, np.array([1.5, 4.0, 9.0]))


def error_of(make, truth, steps, T, **settings):
    x, R = truth
    run = simulation(make(), step_size=T / steps, **settings)
    run.run(T, steps)
    place, turn = run.state.q[:3], rotation_of(run.state.q[:7])
    return np.linalg.norm(place - x[-1]) / RADIUS + (turn.inv() * R[-1]).magnitude()


@every_method
def test_a_wobbling_coin_is_integrated_to_second_order(method):
    T = 0.5
    truth = motion(*GENERAL, np.array([0.0, T]))
    order, first = (4, 400) if method.get("method") == RKMK4 else (2, 200)
    found = [error_of(lambda: coin(*GENERAL), truth, n * first, T, **method) for n in (1, 2, 4)]
    assert found[-1] < 5e-3
    np.testing.assert_allclose(np.log2(np.array(found[:-1]) / found[1:]), order, atol=0.1)


def test_rkmk54_reaches_its_tolerance():
    T = 0.5
    truth = motion(*GENERAL, np.array([0.0, T]))
    error = error_of(
        lambda: coin(*GENERAL), truth, 50, T, method=RKMK54, relative_tolerance=1e-10, absolute_tolerance=1e-10
    )
    assert error < 1e-8


@every_method
def test_energy_is_kept(method):
    run = simulation(coin(*GENERAL), step_size=5e-4, **method)
    system = _core.System(coin(*GENERAL).multibody)
    run.start()
    first = system.energy(run.state.q, run.state.v)
    run.run(1.0, 2000)
    assert abs(system.energy(run.state.q, run.state.v) - first) < 2e-3 * abs(first)


def test_an_inclined_plane_makes_no_difference():
    """The plane, gravity and the motion turned together."""
    axes = Rotation.from_rotvec([0.4, -0.8, 0.3]).as_matrix()
    plane = _core.Frame(np.array([1.0, -2.0, 0.5]), axes)
    ends = []
    for at in (HERE, plane):
        run = simulation(coin(*GENERAL, plane=at), step_size=1e-3, **TIGHT)
        run.run(0.5, 500)
        ends.append(run.state.q)
    assert_close(ends[1][:3], plane.origin + axes @ ends[0][:3], 1e-9)


def test_newton_converges_quadratically():
    """Full matrix: the rows of velocities are exact in every formulation."""
    for formulation in FORMULATIONS.values():
        run = simulation(coin(*GENERAL), step_size=5e-3, formulation=formulation, **TIGHT)
        run.run(0.5, 100)
        assert run.state.counters.newton_iterations / 100 <= 4.5


def test_rollback_is_bitwise():
    run = simulation(coin(*GENERAL), step_size=1e-3)
    run.run(0.1, 100)
    before = copy(run.state)
    run.run(0.2, 100)
    first = copy(run.state)
    run.state = before
    run.run(0.2, 100)
    assert_bitwise(run.state, first)


def test_velocities_and_positions_have_freedoms_of_their_own():
    found = _core.freedom(coin(*GENERAL).multibody)
    assert (found.degrees, found.degrees_of_positions, found.equations) == (3, 5, 3)
    assert str(found) == "3 of velocities, 5 of positions (6 velocities, 3 independent joint equations)"


def test_a_start_off_the_plane_is_moved_onto_it_and_slip_taken_out():
    m = coin(*GENERAL)
    disk = m.multibody.body(0)
    disk.initial_position = disk.initial_position + np.array([0.3, 0.2, 0.05])
    disk.initial_velocity = disk.initial_velocity + np.array([0.1, -0.2, 0.3])
    q, v = _core.assemble(m.multibody)
    system = _core.System(m.multibody)
    phi, rate, *_ = system.constraints(q, v)
    assert_close(phi, np.zeros(3), 1e-12)
    assert_close(rate, np.zeros(3), 1e-12)


@pytest.mark.parametrize("held", [(0.7, -0.3), (0.0, 5.0)])
def test_a_place_that_is_set_is_where_it_starts_and_nothing_turns_for_it(held):
    """Velocities hold no positions: the disk need not roll there."""
    m = coin(*GENERAL)
    slave = _core.Slave(m)
    for i, value in enumerate(held, 1):
        slave.set(f"coin.initialPosition[{i}]", value)
    slave.start()
    assert [slave.get(f"coin.position[{i}]") for i in (1, 2)] == pytest.approx(held, abs=1e-12)
    turn = [slave.get(f"coin.quaternion[{i}]") for i in (1, 2, 3, 4)]
    assert turn == pytest.approx(m.multibody.body(0).initial_quaternion, abs=1e-9)
    assert slave.get("constraint.velocityResidual") < 1e-12


FLAT = "lies flat: with its axis normal to its plane it touches that in no single point."


def test_a_disk_that_lies_flat_is_refused():
    m = coin(0.0, np.zeros(3))
    with pytest.raises(RuntimeError, match=f"The disk of joint table {re.escape(FLAT)}$"):
        _core.Slave(m).start()


def test_a_disk_that_falls_flat_stops_with_the_reason():
    """From rest, straight down: nothing makes it roll away."""
    slave = _core.Slave(coin(0.3, np.zeros(3)))
    slave.start()
    with pytest.raises(RuntimeError, match=re.escape(FLAT)):
        slave.do_step(0, 0.2)


@pytest.mark.parametrize(
    ("kind", "radius", "message"),
    [
        (Type.rolling_disk, np.nan, "j is a rolling disk without a radius; it must have one."),
        (Type.rolling_disk, -1.0, "j.radius is -1 m; it must be finite, above 0."),
        (Type.rolling_disk, np.inf, "j.radius is inf m; it must be finite, above 0."),
        (Type.fixed, 1.0, "j has the radius 1 m; joints of its type must have none."),
    ],
)
def test_radii_that_make_no_sense_are_refused(kind, radius, message):
    m = mechanism(body("b"), _core.Joint("j", kind, GROUND, HERE, 0, HERE, radius=radius))
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        m.validate()


def test_four_wheels_share_the_load():
    """A cart on four wheels: equations depend on each other, and it rolls on all the same."""
    wheel = np.column_stack([X, -Z, Y])  # z of the frame along y
    parts, joints = [], []
    cart = body("cart", 10.0, (1.0, 2.0, 2.5), (0, 0, 0.3))
    cart.initial_velocity = 2.0 * X
    for i, (x, y) in enumerate([(0.5, 0.3), (0.5, -0.3), (-0.5, 0.3), (-0.5, -0.3)]):
        place = np.array([x, y, 0.2])
        part = body(f"wheel{i}", 1.0, (0.01, 0.02, 0.01), place)
        part.initial_velocity, part.initial_angular_velocity = 2.0 * X, 10.0 * Y
        parts.append(part)
        joints.append(
            _core.Joint(
                f"hub{i}",
                Type.revolute,
                0,
                _core.Frame(place - [0, 0, 0.3], wheel),
                i + 1,
                _core.Frame(np.zeros(3), wheel),
            )
        )
        joints.append(
            _core.Joint(
                f"contact{i}", Type.rolling_disk, GROUND, HERE, i + 1, _core.Frame(np.zeros(3), wheel), radius=0.2
            )
        )
    for formulation in FORMULATIONS.values():
        m = mechanism(cart, *parts, *joints, gravity=(0, 0, -GRAVITY))
        m.integrator.formulation = formulation
        assert _core.freedom(m.multibody).degrees == 1
        slave = _core.Slave(m)
        slave.set("cart.force[1]", 7.0)
        slave.start()
        slave.do_step(0, 0.5)
        moved = 7.0 / (14.0 + 4 * 0.02 / 0.2**2)
        assert slave.get("cart.velocity[1]") == pytest.approx(2.0 + 0.5 * moved, abs=1e-7)
        assert slave.get("cart.position[1]") == pytest.approx(1.0 + 0.125 * moved, abs=1e-6)
        assert sum(slave.get(f"contact{i}.reactionForce[3]") for i in range(4)) == pytest.approx(14 * GRAVITY, abs=1e-5)
