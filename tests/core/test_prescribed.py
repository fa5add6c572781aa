"""Drives by tables and by inputs of the FMU, frames of the ground that move: against SciPy and formulas."""

import re

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

from sigmafmu import _core

from .helpers import (
    COORDINATES,
    EPS,
    GROUND,
    JOINT_TYPES,
    Rotation,
    Type,
    assert_close,
    coordinates,
    derivative,
    frame_pose,
    make_joint,
    property_test,
    random_body,
    random_frame,
    relative_pose,
    seeds,
)
from .test_drives import METHODS
from .test_joint_types import HERE, assert_second_order, body, mechanism, solution

Motion = _core.Motion
TIMES = [-0.2, 0.1, 0.35, 0.5, 0.9, 1.3]
VALUES = [0.3, -0.2, 0.5, 1.1, 0.4, 0.9]


def hinge(*elements, moment=0.5):
    return mechanism(
        body("wheel", 2.0, (moment,) * 3), _core.Joint("axle", Type.revolute, GROUND, HERE, 0, HERE), *elements
    )


def run(m, stop, h=1e-3, method="stabilizedIndex2"):
    for name, chosen in METHODS[method].items():
        setattr(m.integrator, name, chosen)
    m.integrator.step_size = h
    slave = _core.Slave(m)
    slave.start()
    yield slave
    for i in range(round(stop / h)):
        slave.do_step(i * h, h)
        yield slave


def spline_and_its_integrals(order):
    """Natural, straight beyond its ends; and its integrals from 0 on."""
    inner = CubicSpline(TIMES, VALUES, bc_type="natural")
    slopes = inner(TIMES[0], 1), inner(TIMES[-1], 1)
    ends = [TIMES[0] - 10, *TIMES, TIMES[-1] + 10]
    values = [VALUES[0] - 10 * slopes[0], *VALUES, VALUES[-1] + 10 * slopes[1]]
    # a straight line has the curvature zero of the natural ends: the spline with clamped slopes goes through them
    whole = CubicSpline(ends, values, bc_type=((1, slopes[0]), (1, slopes[1])))
    for _ in range(order):
        whole = whole.antiderivative()
    value, slope = whole(0.0) * (order > 0), whole(0.0, 1) * (order == 2)

    def from_zero(t, k=0):
        return whole(t, k) - (value + slope * t if k == 0 else slope if k == 1 else 0.0)

    return from_zero


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("motion", [Motion.position, Motion.rate, Motion.acceleration], ids=lambda m: m.name)
def test_a_drive_follows_a_table_and_goes_on_straight(motion, method):
    order = [Motion.position, Motion.rate, Motion.acceleration].index(motion)
    table = spline_and_its_integrals(order)
    m = hinge(_core.Drive(0, motion, table=_core.Table(TIMES, VALUES)))
    tolerance = 2e-4 if method == "index2" else 1e-10  # of second order: others hold positions, or rates, exactly
    for i, slave in enumerate(run(m, 1.6, 4e-3, method)):
        if i % 40:
            continue
        t = i * 4e-3
        assert slave.get("axle.angle") == pytest.approx(table(t), abs=tolerance)
        assert slave.get("axle.angularRate") == pytest.approx(table(t, 1), abs=1e-3 if method == "index3" else 1e-9)
        assert slave.get("axle.driveTorque") == pytest.approx(0.5 * table(t, 2), abs=1e-9)


WAVE = 3.0


def wave(t, k):
    """The k-th derivative of 0.4 sin(WAVE t)."""
    return 0.4 * WAVE**k * np.sin(WAVE * t + k * np.pi / 2)


def follow(name, first, h, orders, stop=1.0):
    """The wheel under a wave at the input, of which the master gives `orders` derivatives at every communication."""
    m = hinge(_core.Drive(0, [Motion.position, Motion.rate, Motion.acceleration][first], input=True))
    m.integrator.step_size = h
    slave = _core.Slave(m)

    def tell(t):
        slave.set(name, wave(t, first))
        for k in range(1, orders + 1):
            slave.set_input_derivative(name, k, wave(t, first + k))

    tell(0.0)
    if first == 2:
        slave.set("axle.initialAngularRate", wave(0.0, 1))
    slave.start()
    steps = round(stop / h)
    for i in range(steps):
        tell(i * h)
        slave.do_step(i * h, h)
    return slave


@pytest.mark.parametrize(("name", "first"), [("drivenAngle", 0), ("drivenRate", 1), ("drivenAcceleration", 2)])
def test_an_input_drives_a_joint_with_the_derivatives_that_the_master_gives(name, first):
    """Of third order in the communication step with two of them: Taylor's remainder."""
    errors = []
    for h in (1e-2, 5e-3):
        slave = follow(f"axle.{name}", first, h, 2)
        errors.append(abs(slave.get("axle.angle") - wave(1.0, 0)))
        assert slave.get("axle.driveTorque") == pytest.approx(0.5 * wave(1.0, 2), abs=20 * h)
    assert errors[1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 2.8


def test_an_input_without_derivatives_is_held():
    """A position jumps at the communication points and rests between them."""
    slave = follow("axle.drivenAngle", 0, 1e-2, 0)
    assert slave.get("axle.angle") == pytest.approx(wave(0.99, 0), abs=1e-12)
    assert slave.get("axle.angularRate") == pytest.approx(0.0, abs=1e-12)
    slave = follow("axle.drivenRate", 1, 1e-2, 0)
    assert slave.get("axle.angularRate") == pytest.approx(wave(0.99, 1), abs=1e-12)
    assert slave.get("axle.angle") == pytest.approx(1e-2 * sum(wave(1e-2 * i, 1) for i in range(100)), abs=1e-11)


def test_a_jump_of_a_rate_is_an_impact():
    """A driven wheel and a bob that hangs on it: positions stay, velocities change by the least impulses."""
    m = mechanism(
        body("wheel", 2.0, (0.5,) * 3), body("bob", 1.0, (0.1,) * 3, (0.5, 0, 0)),
        _core.Joint("axle", Type.revolute, GROUND, HERE, 0, HERE),
        _core.Joint("pin", Type.revolute, 0, _core.Frame(np.array([0.3, 0, 0]), np.eye(3)), 1,
                    _core.Frame(np.array([-0.2, 0, 0]), np.eye(3))),
        _core.Drive(0, Motion.rate, input=True),
    )  # fmt: skip
    slave = _core.Slave(m)
    slave.start()
    slave.do_step(0.0, 1e-3)
    slave.set("axle.drivenRate", 2.0)
    slave.do_step(1e-3, 1e-9)
    # the bob's pin is dragged along at 0.6 m/s across it: m v = P, J w = -0.2 P, v + ... = the pin's velocity
    impulse = 0.6 / (1 / 1.0 + 0.2**2 / 0.1)
    assert slave.get("bob.velocity[2]") == pytest.approx(impulse / 1.0, rel=1e-6)
    assert slave.get("bob.angularVelocity[3]") == pytest.approx(-0.2 * impulse / 0.1, rel=1e-6)
    assert slave.get("axle.angularRate") == pytest.approx(2.0, abs=1e-12)


def test_inputs_of_drives_have_the_names_and_starts_of_the_contract():
    joint = _core.Joint("axle", Type.cylindrical, GROUND, HERE, 0, HERE)
    drives = _core.Drive(0, Motion.position, 0.3, input=True), _core.Drive(0, Motion.rate, 0.2, 1, input=True)
    slave = _core.Slave(mechanism(body("wheel"), joint, *drives))
    assert slave.get("axle.drivenAngle") == 0.3
    assert slave.get("axle.displacementDrivenRate") == 0.2
    slave.set("axle.drivenAngle", 1.1)
    slave.start()
    assert slave.get("axle.angle") == pytest.approx(1.1, abs=1e-14)
    assert slave.get("axle.rate") == pytest.approx(0.2, abs=1e-14)


def test_directional_derivatives_by_what_is_prescribed():
    """The torque follows an acceleration; the derivatives of a position are its own affair."""
    slave = _core.Slave(hinge(_core.Drive(0, Motion.acceleration, 2.0, input=True)))
    slave.start()
    slave.do_step(0.0, 1e-2)
    assert slave.directional_derivative("axle.driveTorque", "axle.drivenAcceleration") == pytest.approx(0.5, rel=1e-12)
    assert slave.directional_derivative("axle.driveTorque", "axle.motorTorque") == pytest.approx(-1.0, rel=1e-12)


# --- frames of the ground that move ----------------------------------------------------------------------------------


def moving_joint(kind, seed, turned):
    """A body on a moving frame by a joint, at a time in the middle of its tables; velocities that fit."""
    rng = np.random.default_rng(seed)
    place = random_frame(rng)
    times = list(np.linspace(-1, 1, 5))
    tables = [_core.Table(times, list(rng.uniform(-0.5, 0.5, 5))) for _ in range(6)]
    definition = _core.Multibody()
    definition.add(random_body(rng, "body"))
    definition.add(_core.FrameMotion("deck", place.origin, place.axes, tables=tables))
    one, two = random_frame(rng), random_frame(rng)
    one = _core.Frame(one.origin, one.axes, 0)
    joint = (0, two, GROUND, one) if turned else (GROUND, one, 0, two)
    definition.add(make_joint("joint", kind, *joint))
    system = _core.System(definition)
    start = system.start
    start.time = rng.choice([-1, 1]) * rng.uniform(0.1, 0.4)  # not where pieces of the spline meet
    system.start = start
    functions = [CubicSpline(t.times, t.values, bc_type="natural") for t in tables]

    def deck(t):
        at = np.array([f(t) for f in functions])
        result = np.eye(4)
        result[:3, :3] = place.axes @ Rotation.from_rotvec(at[3:]).as_matrix()
        result[:3, 3] = place.origin + at[:3]
        return result

    relative = relative_pose(kind, rng.uniform(-1, 1, 3))
    if turned:
        relative = np.linalg.inv(relative)
    q = coordinates(deck(start.time) @ frame_pose(one) @ relative @ np.linalg.inv(frame_pose(two)))
    return rng, system, q


def at_time(system, time):
    start = system.start
    start.time = time
    system.start = start


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", JOINT_TYPES, ids=lambda t: t.name)
@property_test(15, seed=seeds)
def test_joints_of_moving_frames(kind, turned, seed):
    """Φ = 0, Φ' and Φ'' along a motion with its time, every joint, either way round."""
    rng, system, q = moving_joint(kind, seed, turned)
    time, size = system.start.time, system.velocity_size
    assert_close(system.constraints(q, np.zeros(size))[0], np.zeros(system.constraint_size), 100 * EPS)
    v, vdot = rng.uniform(-1, 1, (2, size))
    _, rate, gradient, rate_gradient = system.constraints(q, v)
    explicit = system.explicit_rate(q, v)

    def moved(t, what):
        at_time(system, time + t)
        result = system.constraints(system.compose(q, t * v + 0.5 * t * t * vdot), v + t * vdot)[what]
        at_time(system, time)
        return result

    of_positions = np.delete(np.arange(system.constraint_size), system.velocity_equations)
    assert_close(rate[of_positions], derivative(lambda t: moved(t, 0))[of_positions], 1e-8)
    assert_close(gradient @ vdot + rate_gradient @ v + explicit, derivative(lambda t: moved(t, 1)), 1e-8)
    for k in range(COORDINATES.get(kind, 0)):

        def coordinate_rate(t, k=k):
            at_time(system, time + t)
            at = system.compose(q, t * v + 0.5 * t * t * vdot)
            result = system.coordinate(at, v + t * vdot, 0, k)[1]
            at_time(system, time)
            return result

        found = system.coordinate_acceleration(q, v, vdot, 0, k)
        assert_close(found, derivative(coordinate_rate), 1e-8)


def test_a_pendulum_on_a_shaker():
    """A point on a rod whose upper end shakes sideways: θ'' = -(g sin θ + a cos θ)/L."""
    length, g, times = 0.5, 9.81, np.linspace(0, 1.2, 25)
    shake = 0.05 * np.sin(7 * times)
    spline = CubicSpline(times, shake, bc_type="natural")
    table = _core.Table(list(times), list(shake))

    def equations(t, y):
        return [y[1], -(g * np.sin(y[0]) + spline(t, 2) * np.cos(y[0])) / length]

    def make():
        parts = [
            body("bob", 1.0, position=(0, 0, -length)),
            _core.FrameMotion("shaker", tables=[table, None, None, None, None, None]),
            _core.Joint("rod", Type.distance, GROUND, _core.Frame(np.zeros(3), np.eye(3), 0), 0, HERE, length=length),
        ]
        return mechanism(*parts, gravity=(0, 0, -g))

    angle, _ = solution(equations, [0.0, -spline(0.0, 1) / length], 1.0)  # the bob starts at rest
    expected = [spline(1.0) + length * np.sin(angle), -length * np.cos(angle)]
    assert_second_order(make, {}, ["bob.position[1]", "bob.position[3]"], expected, 1.0, 4e-3)


def test_a_deck_that_the_master_moves():
    """A crate fixed on a deck: its place is the deck's, its reaction what Newton's law says."""
    weld = _core.Joint("weld", Type.fixed, GROUND, _core.Frame(np.zeros(3), np.eye(3), 0), 0, HERE)
    m = mechanism(body("crate", 2.0), _core.FrameMotion("deck", input=True), weld)
    m.integrator.step_size = 1e-2
    slave = _core.Slave(m)
    slave.start()
    for i in range(100):
        t = i * 1e-2
        for k, axis in ((0, "displacement[3]"), (1, "rotation[1]")):
            values = [wave(t + k, order) for order in range(3)]
            slave.set(f"deck.{axis}", values[0] if i else 0.0 if k else values[0])
            if i == 0 and k:
                continue
            for order in (1, 2):
                slave.set_input_derivative(f"deck.{axis}", order, values[order])
        slave.do_step(t, 1e-2)
    assert slave.get("crate.position[3]") == pytest.approx(wave(1.0, 0), abs=1e-5)
    assert slave.get("crate.rotationVector[1]") == pytest.approx(wave(2.0, 0), abs=1e-5)
    assert slave.get("weld.reactionForce[3]") == pytest.approx(2.0 * wave(1.0, 2), abs=0.3)


def test_what_it_takes_to_move_a_deck():
    """Newton and Euler of a crate off the deck's origin, and what a spring and a rotor hold against it."""
    up, turn = _core.Table([0.0, 0.4, 1.0], [0.0, 0.3, 0.1]), _core.Table([0.0, 0.5, 1.0], [0.0, 0.4, 1.0])
    at = _core.Frame(np.array([0.5, 0, 0]), np.eye(3), 0)
    parts = [
        body("crate", 2.0, (0.1, 0.2, 0.3), (0.5, 0, 0)), body("wheel", 1.0, (0.05,) * 3),
        _core.FrameMotion("deck", tables=[None, None, up, None, None, turn]),
        _core.Joint("weld", Type.fixed, GROUND, at, 0, HERE),
        _core.Joint("axle", Type.revolute, GROUND, _core.Frame(np.zeros(3), np.eye(3), 0), 1, HERE),
        _core.JointSpring(1, 3.0), _core.JointArmature(1, 0.4),
        _core.SpringDamper("spring", GROUND, np.zeros(3), 0, np.zeros(3), np.full(3, 40.0), np.zeros(3)),
    ]  # fmt: skip
    m = mechanism(*parts, gravity=(0, 0, -9.81))
    energies, powers = [], []
    for slave in run(m, 0.9, 1e-3):
        energies.append(slave.get("energy.total"))
        powers.append(slave.get("deck.power"))
    vdot = np.array([slave.get(f"crate.acceleration[{i}]") for i in (1, 2, 3)])
    place = np.array([slave.get(f"crate.position[{i}]") for i in (1, 2, 3)])
    # the wheel is held by the spring and, by its armature, by a c'' of the hinge
    axle = 3.0 * slave.get("axle.angle") + 0.4 * slave.get("axle.angularAcceleration")
    pull = 2.0 * (vdot + np.array([0, 0, 9.81])) + 40.0 * place
    deck = np.array([0, 0, place[2]])
    wheel = np.array([0, 0, 1.0 * (9.81 + slave.get("wheel.acceleration[3]"))])
    spin = np.array([0, 0, 0.3 * slave.get("crate.angularAcceleration[3]")])
    force, torque = ([slave.get(f"deck.{n}[{i}]") for i in (1, 2, 3)] for n in ("force", "torque"))
    assert force == pytest.approx(pull + wheel, rel=1e-9, abs=1e-9)
    assert torque == pytest.approx(np.cross(place - deck, pull) + spin - [0, 0, axle], rel=1e-9, abs=1e-9)
    # the table's curvature has kinks, so that the rule of Simpson is of order 3: 1e-3 s
    assert energies[-1] - energies[0] == pytest.approx(simpson(powers, dx=1e-3), rel=1e-5)


# --- definitions -----------------------------------------------------------------------------------------------------


def test_written_and_read_they_are_the_same():
    table = _core.Table(TIMES, VALUES)
    motion = _core.FrameMotion("deck", np.array([1.0, 2, 3]), tables=[None, table, None, None, None, table])
    m = hinge(_core.Drive(0, Motion.rate, table=table), motion, _core.FrameMotion("road", input=True))
    text = _core.to_json(m)
    again = _core.from_json(text)
    assert _core.to_json(again) == text
    assert again.multibody.drives[0].table.values == VALUES
    assert [t is not None for t in again.multibody.motions[0].tables] == [False, True, False, False, False, True]
    assert again.multibody.motions[1].input


REFUSED = {
    "one point": (_core.Table([0.0], [1.0]), "has a table of 1 times and 1 values; it must have as many of both"),
    "not as many": (_core.Table([0.0, 1.0], [1.0]), "has a table of 2 times and 1 values; it must have as many"),
    "back": (_core.Table([0.0, 1.0, 0.5], [0.0] * 3), "are 1 s and 0.5 s; they must ascend."),
    "nan": (_core.Table([0.0, 1.0], [0.0, np.nan]), "is nan at 1 s; both must be finite."),
}


@pytest.mark.parametrize(("table", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_tables_are_refused(table, message):
    for element in (_core.Drive(0, Motion.rate, table=table), _core.FrameMotion("deck", tables=[table] + [None] * 5)):
        with pytest.raises(ValueError, match=re.escape(message)):
            hinge(element).validate()


def test_moving_frames_that_are_not_there_are_refused():
    joint = _core.Joint("weld", Type.fixed, GROUND, _core.Frame(np.zeros(3), np.eye(3), 1), 0, HERE)
    m = mechanism(body("crate"), _core.FrameMotion("deck", input=True), joint)
    with pytest.raises(ValueError, match=r"^weld attaches to moving frame 1 of the ground; allowed are -1 "):
        m.validate()
    rod = _core.Joint("rod", Type.distance, GROUND, _core.Frame(np.zeros(3), np.eye(3), 0), 0, HERE)
    m = mechanism(body("crate"), _core.FrameMotion("deck", input=True), rod)
    with pytest.raises(ValueError, match=r"^rod holds to a moving frame of the ground; its length must be set"):
        m.validate()
