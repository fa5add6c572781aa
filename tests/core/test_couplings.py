"""Coordinates of joints coupled by polynomials: equations, power, gears and their kin in motion, what is refused."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    COORDINATES,
    EPS,
    GROUND,
    Type,
    assert_close,
    jacobian,
    property_test,
    random_tree,
    seeds,
)
from .test_flexible import make_tree
from .test_joint_types import HERE, assert_second_order, body, mechanism, solution


def coordinates_of(definition):
    return [(j, k) for j, d in enumerate(definition.joints) for k in range(COORDINATES.get(d.type, 0))]


def coupled(rng, definition, q):
    """One coupling of up to three coordinates by random cubics, meshing at q; None where there are no coordinates."""
    at = coordinates_of(definition)
    if not at:
        return None
    chosen = [at[i] for i in rng.permutation(len(at))[:3]]
    polynomials = [list(rng.uniform(-1, 1, 4)) for _ in chosen]
    terms = [_core.CouplingTerm(j, p, k) for (j, k), p in zip(chosen, polynomials, strict=True)]
    definition.add(_core.Coupling("gear", terms))
    system = _core.System(definition)
    start = system.start
    start.turned = system.coordinates(q, np.zeros(system.velocity_size))[0]
    values = [system.coordinate(q, np.zeros(system.velocity_size), *place)[0] for place in chosen]
    start.x = np.array([sum(np.polyval(p[::-1], x) for p, x in zip(polynomials, values, strict=True))])
    system.start = start
    return system


def rigid(seed):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    return rng, tree.q, coupled(rng, tree.definition, tree.q)


def flexible(seed):
    rng, tree = make_tree(seed)
    return rng, tree.q, coupled(rng, tree.definition, tree.q)


every_tree = pytest.mark.parametrize("make", [rigid, flexible], ids=["rigid", "at nodes"])


@every_tree
@property_test(60, seed=seeds)
def test_equation_and_its_derivatives(make, seed):
    """Where joints are closed: Φ = 0, B, Z and the geometric stiffness against differences."""
    rng, q, system = make(seed)
    if system is None:
        return
    size = system.velocity_size
    v, vdot = rng.uniform(-1, 1, (2, size))
    phi, rate, gradient, rate_gradient = (x[-1:] for x in system.constraints(q, v))
    assert_close(phi, np.zeros(1), 100 * EPS, 10)
    assert_close(rate, gradient @ v, 100 * EPS, 10)
    assert_close(gradient, jacobian(lambda x: system.constraints(system.compose(q, x), v)[0][-1:], size), 1e-9)
    assert_close(rate_gradient, jacobian(lambda x: system.constraints(system.compose(q, x), v)[1][-1:], size), 1e-9)
    multipliers, inputs = np.zeros(system.constraint_size), np.zeros(system.input_size)
    multipliers[-1] = 7.0
    shares = [system.linearization(q, v, factor * multipliers, inputs, vdot)[2] for factor in (1, 0)]

    def residual(x):
        at = system.compose(q, x)
        return system.residual(at, v, vdot, multipliers, inputs) - system.residual(at, v, vdot, 0 * multipliers, inputs)

    assert_close(shares[0] - shares[1], jacobian(residual, size), 1e-9, 10)


@every_tree
@property_test(40, seed=seeds)
def test_a_coupling_does_no_work(make, seed):
    rng, q, system = make(seed)
    if system is None:
        return
    v = system.project_velocities(q, rng.uniform(-1, 1, system.velocity_size))
    phi, _, gradient, rate_gradient = system.constraints(q, v)
    assert_close(gradient[-1] @ v, 0.0, 1e-12, 1 + np.abs(v).max())
    vdot, _ = system.accelerations(q, v, np.zeros(system.input_size))
    assert_close(gradient @ vdot + rate_gradient @ v, 0 * phi, 1e-11, 1 + np.abs(vdot).max())


# --- runs ------------------------------------------------------------------------------------------------------------


def wheels(*moments):
    """Wheels on hinges about W z, side by side: joint i is that of body i."""
    parts = []
    for i, moment in enumerate(moments):
        frame = _core.Frame(np.array([0.3 * i, 0, 0]), np.eye(3))
        parts.append(body(f"wheel{i}", 1.0, (moment, moment, moment), (0.3 * i, 0, 0)))
        parts.append(_core.Joint(f"axle{i}", Type.revolute, GROUND, frame, i, HERE))
    return parts


def run(m, steps=1000, h=1e-3, **start):
    slave = _core.Slave(m)
    for name, value in start.items():
        slave.set(name.replace("__", "."), value)
    slave.start()
    for i in range(steps):
        slave.do_step(i * h, h)
    return slave


@pytest.mark.parametrize("ratio", [-2.5, 0.4])
@pytest.mark.parametrize("start", [0.0, 10.0, -2.0])
def test_a_gear_turns_both_wheels_however_far(ratio, start):
    """Constant acceleration τ/(J1 + r² J2) over many turns; whole turns of a start move nothing."""
    slave = run(mechanism(*wheels(0.3, 0.2), _core.gear("gear", 0, 1, ratio)), axle0__initialAngle=start,
                axle0__motorTorque=40.0)  # fmt: skip
    acceleration = 40.0 / (0.3 + ratio**2 * 0.2)
    moved = slave.get("axle0.angle") - start
    assert moved == pytest.approx(0.5 * acceleration, rel=1e-12)
    assert abs(moved) > 2 * np.pi
    turn = 2 * np.pi  # the second angle is counted from the start on
    turns = (slave.get("axle1.angle") - ratio * (np.fmod(start, turn) + moved)) / turn
    assert turns == pytest.approx(np.round(turns), abs=1e-11)
    assert abs(slave.get("axle1.angle") - ratio * moved) < np.pi + 1e-9
    assert slave.get("axle1.angularRate") == pytest.approx(ratio * slave.get("axle0.angularRate"), rel=1e-12)
    assert slave.get("gear.torque2") == pytest.approx(0.2 * ratio * acceleration, rel=1e-10)
    assert slave.get("gear.torque1") == pytest.approx(-ratio * slave.get("gear.torque2"), rel=1e-12)


def test_a_rack_moves_with_its_pinion():
    slide = _core.Joint("rail", Type.prismatic, GROUND, HERE, 1, HERE)
    pinion = body("pinion", 1.0, (0.1, 0.1, 0.1)), _core.Joint("axle", Type.revolute, GROUND, HERE, 0, HERE)
    m = mechanism(pinion[0], body("rack", 2.0), pinion[1], slide, _core.rack_and_pinion("mesh", 0, 1, 0.05))
    slave = run(m, axle__motorTorque=3.0)
    acceleration = 3.0 / (0.1 + 2.0 * 0.05**2)
    assert slave.get("rail.displacement") == pytest.approx(0.05 * 0.5 * acceleration, rel=1e-11)
    assert slave.get("mesh.force2") == pytest.approx(2.0 * 0.05 * acceleration, rel=1e-10)


def test_a_differential_shares_the_torque_of_its_carrier():
    """Inertias Jc, Jl, Jr; c = (l + r)/2 gives (Jl + Jc/4) l'' + Jc/4 r'' = τ/2 + τl and the like of r."""
    Jc, Jl, Jr, torque, left = 0.5, 0.2, 0.3, 4.0, 1.0
    m = mechanism(*wheels(Jc, Jl, Jr), _core.differential("differential", 0, 1, 2))
    slave = run(m, axle0__motorTorque=torque, axle1__motorTorque=left)
    matrix = np.array([[Jl + Jc / 4, Jc / 4], [Jc / 4, Jr + Jc / 4]])
    sides = np.linalg.solve(matrix, [torque / 2 + left, torque / 2])
    found = [slave.get(f"axle{i}.angle") for i in range(3)]
    assert found == pytest.approx(0.5 * np.array([sides.mean(), *sides]), rel=1e-11)
    torques = [slave.get(f"differential.torque{i}") for i in (2, 3)]
    assert torques[0] == pytest.approx(torques[1], rel=1e-12)  # what makes it a differential


def test_a_planet_turns_between_sun_and_carrier():
    """Three coordinates, two of them of the carrier; teeth of planet and sun mesh on the carrier."""
    Js, Jc, m, R, Jp, k, torque = 0.2, 0.1, 0.6, 0.4, 0.05, 2.0, 1.5
    hub = _core.Frame(np.array([R, 0, 0]), np.eye(3))
    terms = [_core.CouplingTerm(2, [0, 1.0]), _core.CouplingTerm(0, [0, k]), _core.CouplingTerm(1, [0, -k])]
    planetary = mechanism(
        body("sun", 1.0, (Js,) * 3), body("carrier", 1.0, (Jc,) * 3), body("planet", m, (Jp,) * 3, (R, 0, 0)),
        _core.Joint("sunAxle", Type.revolute, GROUND, HERE, 0, HERE),
        _core.Joint("carrierAxle", Type.revolute, GROUND, HERE, 1, HERE),
        _core.Joint("planetAxle", Type.revolute, 1, hub, 2, HERE),
        _core.Coupling("teeth", terms),
    )  # fmt: skip
    # p' = -k (s' - c'); T = Js s'²/2 + (Jc + m R²) c'²/2 + Jp (c' + p')²/2 with c' + p' = (1 + k) c' - k s'
    matrix = np.array([[Js + Jp * k**2, -Jp * k * (1 + k)], [-Jp * k * (1 + k), Jc + m * R**2 + Jp * (1 + k) ** 2]])
    sun, carrier = np.linalg.solve(matrix, [torque, 0.0])

    slave = run(planetary, sunAxle__motorTorque=torque)
    angles = 0.5 * np.array([sun, carrier, -k * (sun - carrier)])
    names = ["sunAxle.angle", "carrierAxle.angle", "planetAxle.angle"]
    assert [slave.get(name) for name in names] == pytest.approx(angles, rel=1e-5)  # the planet's path is curved


def test_a_mimic_joint_follows_a_polynomial():
    """s = 0.1 + 0.3 θ + 0.2 θ² of a sledge and a wheel: (J + m p'²) θ'' + m p' p'' θ'² = τ; second order."""
    J, m, torque = 0.1, 0.5, 0.8

    def equations(_, y):
        slope, bend = 0.3 + 0.4 * y[0], 0.4
        return [y[1], (torque - m * slope * bend * y[1] ** 2) / (J + m * slope**2)]

    def make():
        sledge = body("sledge", m, position=(0, 0, 0.1))
        parts = [
            body("wheel", 1.0, (J,) * 3), sledge,
            _core.Joint("axle", Type.revolute, GROUND, HERE, 0, HERE),
            _core.Joint("rail", Type.prismatic, GROUND, HERE, 1, HERE),
            _core.mimic("cam", 1, 0, [0.1, 0.3, 0.2]),
        ]  # fmt: skip
        return mechanism(*parts)

    theta, rate = solution(equations, [0.0, 0.5], 1.0)
    expected = [theta, 0.1 + 0.3 * theta + 0.2 * theta**2, rate, (0.3 + 0.4 * theta) * rate]
    names = ["axle.angle", "rail.displacement", "axle.angularRate", "rail.rate"]
    initial = {"axle.initialAngularRate": 0.5, "axle.motorTorque": torque}
    assert_second_order(make, initial, names, expected, 1.0, 1e-2)


def test_ratio_radius_and_polynomial_are_parameters():
    """Set before the start, they are as if the mechanism had been made with them; later they are refused."""
    slide = _core.Joint("rail", Type.prismatic, GROUND, HERE, 2, HERE)
    parts = [*wheels(0.1, 0.2), body("rack", 2.0), slide]

    def slave(ratio, second, **start):
        m = mechanism(*parts, _core.gear("gear", 0, 1, ratio), second)
        return run(m, 50, axle0__motorTorque=3.0, **start)

    def cam(*polynomial):
        return _core.mimic("cam", 2, 1, [0.0, *polynomial])

    def rack(radius):
        return _core.rack_and_pinion("cam", 1, 2, radius)

    names = ["axle0.angle", "axle1.angularRate", "rail.displacement", "cam.force1"]
    polynomial = {"cam__polynomial[2]": 0.3, "cam__polynomial[3]": 0.2}
    made, changed = slave(1.5, cam(0.3, 0.2)), slave(-2.0, cam(1.0, 1.0), gear__ratio=1.5, **polynomial)
    assert [made.get(name) for name in names] == [changed.get(name) for name in names]
    with pytest.raises(RuntimeError, match=r"gear\.ratio is a fixed parameter"):
        changed.set("gear.ratio", 1.0)
    names[-1] = "cam.force2"
    made, changed = slave(1.0, rack(0.07)), slave(1.0, rack(0.02), cam__radius=0.07)
    assert [made.get(name) for name in names] == [changed.get(name) for name in names]


def test_degrees_of_freedom_count_couplings():
    m = mechanism(*wheels(0.1, 0.1, 0.1), _core.gear("a", 0, 1, 2.0), _core.gear("b", 1, 2, 3.0))
    assert (_core.freedom(m.multibody).degrees, _core.freedom(m.multibody).independent) == (1, 17)


def test_a_circle_of_gears_that_turns_is_redundant_and_one_that_does_not_stands():
    for last, degrees in ((1 / 6, 1), (1.0, 0)):
        gears = _core.gear("a", 0, 1, 2.0), _core.gear("b", 1, 2, 3.0), _core.gear("c", 2, 0, last)
        assert _core.freedom(mechanism(*wheels(0.1, 0.1, 0.1), *gears).multibody).degrees == degrees


# --- definitions -----------------------------------------------------------------------------------------------------


def test_written_and_read_they_are_the_same():
    m = mechanism(*wheels(0.1, 0.2), _core.mimic("cam", 1, 0, [0.1, 0.3, 0.2]), _core.gear("gear", 0, 1, -2.0))
    text = _core.to_json(m)
    again = _core.from_json(text)
    assert _core.to_json(again) == text
    assert [t.polynomial for t in again.multibody.couplings[0].terms] == [[0, -1], [0.1, 0.3, 0.2]]
    assert [c.type.name for c in again.multibody.couplings] == ["mimic", "gear"]
    assert again.multibody.couplings[0].offset == 0
    assert np.isnan(again.multibody.couplings[1].offset)


Term = _core.CouplingTerm
REFUSED = {
    "no terms": ([], "c couples no coordinates; there must be at least one."),
    "no joint": ([Term(4, [0, 1])], "c acts on joint 4; allowed are 0 to 1."),
    "constant": ([Term(0, [3.0])], "c does not depend on axle0; a coefficient from the second on must not be zero."),
    "twice": ([Term(0, [0, 1]), Term(0, [0, 2])], "c has two terms of the same coordinate of axle0; one is allowed."),
    "nan": ([Term(0, [0, np.nan])], "Coefficient 1 of axle0 in c is nan; it must be finite."),
}


def test_types_have_the_terms_that_their_parameters_are_in():
    text = _core.to_json(mechanism(*wheels(0.1, 0.2), _core.gear("gear", 0, 1, -2.0)))
    changed = _core.from_json(text.replace("[0.0, -1.0]", "[0.0, 1.0]"))
    message = "gear is of type gear; it must have two terms of first degree, the second one with the polynomial 0, -1."
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        changed.validate()


@pytest.mark.parametrize(("terms", "message"), REFUSED.values(), ids=REFUSED)
def test_couplings_that_make_no_sense_are_refused(terms, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        mechanism(*wheels(0.1, 0.1), _core.Coupling("c", terms)).validate()
