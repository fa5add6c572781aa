"""Springs and dampers on coordinates of joints, and the joint that has two: variables, motion, what is refused."""

import json

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import GROUND, STABILIZED, property_test, seeds

Type = _core.JointType
AXIS = np.array([0.0, 0.0, 1.0])


def wheel(kind=Type.revolute, **spring):
    """A wheel on its axis, and a spring on each coordinate; the same keywords for all."""
    mechanism = _core.Mechanism("Wheel")
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = "wheel", 3.0, np.array([0.3, 0.2, 0.5])
    mechanism.multibody.add(body)
    mechanism.multibody.gravity = np.zeros(3)
    frame = _core.Frame(np.zeros(3), _core.axes_with_z(AXIS))
    mechanism.multibody.add(_core.Joint("axle", kind, GROUND, frame, 0, frame))
    for coordinate in range(2 if kind == Type.cylindrical else 1):
        mechanism.multibody.add(_core.JointSpring(0, coordinate=coordinate, **spring))
    return mechanism


def oscillation(t, start, rate, stiffness, damping, inertia):
    """x of inertia x'' + damping x' + stiffness x = 0, underdamped."""
    decay = damping / (2 * inertia)
    frequency = np.sqrt(stiffness / inertia - decay**2)
    return np.exp(-decay * t) * (
        start * np.cos(frequency * t) + (rate + decay * start) / frequency * np.sin(frequency * t)
    )


@pytest.mark.parametrize("h", [2e-3, 1e-3])
def test_a_torsion_spring_that_is_wound_up_by_turns(h):
    """Its rest is three turns away: the angle is counted, and the wheel swings through whole turns as one."""
    rest = 6 * np.pi
    mechanism = wheel(stiffness=2.0, damping=0.1, rest=rest)
    mechanism.integrator.step_size = h
    slave = _core.Slave(mechanism)
    slave.start()
    assert slave.get("axle.springTorque") == pytest.approx(2.0 * rest, rel=1e-14)
    steps = round(1.5 / h)
    for i in range(steps):
        slave.do_step(i * h, h)
    expected = rest + oscillation(steps * h, -rest, 0.0, 2.0, 0.1, 0.5)
    assert slave.get("axle.angle") > 4 * np.pi
    assert slave.get("axle.angle") == pytest.approx(expected, abs=2.0 * h**2 * rest)  # error: O(h²) of the amplitude
    torque = -2.0 * (slave.get("axle.angle") - rest) - 0.1 * slave.get("axle.angularRate")
    assert slave.get("axle.springTorque") == pytest.approx(torque, rel=1e-12)


def test_energy_of_a_torsion_spring_is_kept():
    mechanism = wheel(stiffness=5.0, rest=0.3)
    slave = _core.Slave(mechanism)
    slave.set("axle.initialAngularRate", 40.0)
    slave.start()
    energy = slave.get("energy.total")
    assert energy == pytest.approx(0.5 * 0.5 * 40.0**2 + 0.5 * 5.0 * 0.3**2, rel=1e-14)
    for i in range(500):
        slave.do_step(i * 1e-3, 1e-3)
    assert slave.get("axle.angle") > 2 * np.pi  # beyond a turn
    assert slave.get("energy.total") == pytest.approx(energy, rel=1e-5)


def test_a_cylindrical_joint_swings_about_and_along_its_axis():
    """Two oscillators that do not know of each other."""
    mechanism = wheel(Type.cylindrical, stiffness=4.0, damping=0.2)
    mechanism.integrator.formulation = STABILIZED
    slave = _core.Slave(mechanism)
    slave.set("axle.initialAngle", 0.5)
    slave.set("axle.initialRate", 2.0)
    slave.start()
    for i in range(1000):
        slave.do_step(i * 1e-3, 1e-3)
    assert slave.get("axle.angle") == pytest.approx(oscillation(1.0, 0.5, 0.0, 4.0, 0.2, 0.5), abs=1e-6)
    assert slave.get("axle.displacement") == pytest.approx(oscillation(1.0, 0.0, 2.0, 4.0, 0.2, 3.0), abs=1e-6)
    assert slave.get("wheel.position[3]") == pytest.approx(slave.get("axle.displacement"), abs=1e-14)
    assert abs(slave.get("constraint.positionResidual")) < 1e-13


def test_variables_of_a_cylindrical_joint():
    names = [name for name in _core.Slave(wheel(Type.cylindrical)).names if name.startswith("axle.")]
    of_angle = "angle angularRate angularAcceleration motorTorque power initialAngle initialAngularRate"
    of_spring = "springTorque springEnergy springPower stiffness damping rest"
    of_displacement = "displacement rate acceleration actuatorForce displacementPower initialDisplacement initialRate"
    second = "displacementSpringForce displacementSpringEnergy displacementSpringPower "
    second += "displacementStiffness displacementDamping displacementRest"
    vectors = [f"{vector}[{i}]" for vector in ("reactionForce", "reactionTorque") for i in (1, 2, 3)]
    expected = [*of_angle.split(), *of_spring.split(), *of_displacement.split(), *second.split(), *vectors]
    assert sorted(names) == sorted(f"axle.{name}" for name in expected)


def test_motors_of_both_coordinates():
    slave = _core.Slave(wheel(Type.cylindrical))
    slave.set("axle.motorTorque", 1.5)
    slave.set("axle.actuatorForce", -6.0)
    slave.start()
    for i in range(1000):
        slave.do_step(i * 1e-3, 1e-3)
    assert slave.get("axle.angularRate") == pytest.approx(1.5 / 0.5, rel=1e-12)
    assert slave.get("axle.rate") == pytest.approx(-6.0 / 3.0, rel=1e-12)


@pytest.mark.parametrize("name", ["axle.initialAngle", "axle.initialDisplacement"])
def test_initial_coordinates_of_a_cylindrical_joint_are_kept(name):
    slave = _core.Slave(wheel(Type.cylindrical))
    slave.set(name, 9.0)
    slave.start()
    assert slave.get(name.replace("initialA", "a").replace("initialD", "d")) == pytest.approx(9.0, abs=1e-14)


def test_tuning_a_spring_in_mid_run_absorbs_the_jump():
    """Stiffer from 0.5 s on: as if started there, of second order."""
    slave = _core.Slave(wheel(stiffness=2.0, rest=1.0))
    slave.start()
    for i in range(500):
        slave.do_step(i * 1e-3, 1e-3)
    start, rate = slave.get("axle.angle") - 1.0, slave.get("axle.angularRate")
    slave.set("axle.stiffness", 8.0)
    for i in range(500, 1000):
        slave.do_step(i * 1e-3, 1e-3)
    assert slave.get("axle.angle") == pytest.approx(1.0 + oscillation(0.5, start, rate, 8.0, 0.0, 0.5), abs=2e-6)


# --- definitions -----------------------------------------------------------------------------------------------------


@property_test(25, seed=seeds)
def test_written_and_read_it_is_the_same(seed):
    rng = np.random.default_rng(seed)
    mechanism = wheel(Type.cylindrical, stiffness=rng.uniform(), damping=rng.uniform(), rest=rng.normal())
    mechanism.multibody.add(_core.Drive(0, _core.Motion.rate, rng.normal(), 1))
    exposure = _core.Exposure()
    exposure.outputs = ["axle.*"]
    mechanism.expose = exposure
    text = _core.to_json(mechanism)
    again = _core.from_json(text)
    assert _core.to_json(again) == text
    assert json.loads(text)["joint_springs"][1]["joint"] == "axle"
    springs = [
        [(s.joint, s.coordinate, s.stiffness, s.damping, s.rest) for s in m.multibody.joint_springs]
        for m in (mechanism, again)
    ]
    assert springs[0] == springs[1]


@pytest.mark.parametrize(
    ("spring", "message"),
    [
        (_core.JointSpring(3), "A joint spring acts on joint 3; allowed are 0 to 0."),
        (_core.JointSpring(0, coordinate=1), "A joint spring acts on coordinate 1 of axle; joints of its type have 1,"),
        (_core.JointSpring(0), "axle has two springs on the same coordinate; one is allowed."),
    ],
)
def test_springs_of_what_is_not_there_are_refused(spring, message):
    mechanism = wheel()
    mechanism.multibody.add(spring)
    with pytest.raises(ValueError, match=f"^{message}"):
        mechanism.validate()


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        (Type.revolute, {"stiffness": -1.0}, "axle.stiffness is -1 N.m/rad; it must not be negative."),
        (Type.prismatic, {"damping": -1.0}, "axle.damping is -1 N.s/m; it must not be negative."),
        (Type.revolute, {"rest": np.nan}, "axle.rest is nan rad; it must be finite."),
    ],
)
def test_bad_values_are_refused(kind, values, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        wheel(kind, **values).validate()


# --- exposure --------------------------------------------------------------------------------------------------------


def test_only_what_is_exposed_is_a_variable():
    mechanism = wheel(stiffness=1.0)
    exposure = _core.Exposure()
    exposure.inputs, exposure.parameters = ["*.motorTorque"], ["axle.[dr]*", "gravity"]
    exposure.outputs = ["axle.angle", "wheel.position[3]", "energy.*", "*Residual"]
    mechanism.expose = exposure
    assert sorted(_core.Slave(mechanism).names) == sorted(
        ["axle.angle", "axle.motorTorque", "axle.damping", "axle.rest", "wheel.position[3]"]
        + [f"energy.{kind}" for kind in ("kinetic", "potential", "total")]
        + [f"constraint.{kind}Residual" for kind in ("position", "velocity")]
        + [f"gravity[{i}]" for i in (1, 2, 3)]
    )
    mechanism.set("axle.stiffness", 3.0)  # whether it is exposed or not
    assert mechanism.multibody.joint_springs[0].stiffness == 3.0


@pytest.mark.parametrize(("bodies", "all_of_them"), [(20, True), (21, False)])
def test_of_many_bodies_the_joints_are_exposed(bodies, all_of_them):
    mechanism = wheel()
    frame = _core.Frame(np.zeros(3), _core.axes_with_z(AXIS))
    for i in range(1, bodies):
        body = _core.RigidBody()
        body.name = f"body{i}"
        mechanism.multibody.add(body)
        mechanism.multibody.add(_core.Joint(f"joint{i}", Type.revolute, i - 1, frame, i, frame))
    names = _core.Slave(mechanism).names
    assert ("body3.position[1]" in names) == all_of_them
    assert {"joint3.angle", "joint3.motorTorque", "energy.total", "integrator.stepSize", "axle.stiffness"} <= set(names)
