"""Screws, constant-velocity joints and points in planes in motion, against closed forms."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import GROUND, Rotation, Type, rotation_of
from .test_drives import METHODS, every_method
from .test_joint_types import HERE, assert_second_order, body, end, mechanism

PITCH = 0.02


def nut(pitch=PITCH, *parts, gravity=(0, 0, 0)):
    """A body on a screw along z of W."""
    joint = _core.Joint("thread", Type.screw, GROUND, HERE, 0, HERE, pitch=pitch)
    return mechanism(body("nut", 2.0, (0.1, 0.1, 0.03)), joint, *parts, gravity=gravity)


@pytest.mark.parametrize("pitch", [PITCH, -0.5])
def test_a_nut_turns_and_moves_as_its_weight_says(pitch):
    """(J + m l^2) angle'' = -m g l with l = pitch/(2 pi): many turns, from anywhere on the thread."""
    lead, start, weight = pitch / (2 * np.pi), 0.3, 2.0 * 9.81
    rate, acceleration = 40.0, -weight * lead / (0.03 + 2.0 * lead**2)
    names = ["thread.displacement", "thread.angularRate", "thread.rate", "thread.angularAcceleration",
             "thread.reactionForce[3]", "thread.reactionTorque[3]", "thread.angle"]  # fmt: skip
    initial = {"thread.initialDisplacement": start, "thread.initialAngularRate": rate}
    found = end(nut(pitch, gravity=(0, 0, -9.81)), 1e-3, 1.0, initial, names)
    turned = rate + acceleration / 2
    force, torque = 2.0 * lead * acceleration + weight, 0.03 * acceleration
    expected = [start + lead * turned, rate + acceleration, lead * (rate + acceleration), acceleration, force, torque]
    assert found[:-1] == pytest.approx(expected, rel=1e-9)
    turns = (found[-1] - start / lead - turned) / (2 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-8)


def test_a_nut_on_a_spring_swings():
    """Order 2; the spring along the axis is that of an angle too."""
    lead, k, start = PITCH / (2 * np.pi), 3e4, 0.004
    w = np.sqrt(k * lead**2 / (0.03 + 2.0 * lead**2))
    expected = [start * np.cos(w), -start * w * np.sin(w), start / lead * np.cos(w)]
    names = ["thread.displacement", "thread.rate", "thread.angle"]
    initial = {"thread.initialDisplacement": start}
    assert_second_order(lambda: nut(PITCH, _core.JointSpring(0, k, coordinate=1)), initial, names, expected, 1.0, 1e-2)


def bent_shafts(joint, bend, *parts):
    """A shaft about z on a hinge, and one that is bent from it about y, whose far end stays on its axis."""
    tilt = Rotation.from_rotvec([0, bend, 0])
    axes = tilt.as_matrix()
    far = _core.Frame(np.array([0, 0, 0.5]), np.eye(3))
    return mechanism(
        body("one", 1.0, (0.1, 0.1, 0.02), (0, 0, -0.3)),
        body("two", 1.0, (0.1, 0.1, 0.03), tilt.apply([0, 0, 0.5]), tilt.as_rotvec()),
        _core.Joint("hinge", Type.revolute, GROUND, _core.Frame(np.array([0, 0, -0.3]), np.eye(3)), 0, HERE),
        _core.Joint("cross", joint, 0, _core.Frame(np.array([0, 0, 0.3]), np.eye(3)), 1,
                    _core.Frame(np.array([0, 0, -0.5]), np.eye(3))),
        _core.Joint("guide", Type.point_on_line, GROUND, _core.Frame(np.zeros(3), axes), 1, far),
        *parts,
    )  # fmt: skip


@pytest.mark.parametrize("bend", [0.0, 0.7, 1.5])
def test_both_shafts_turn_equally_fast(bend):
    """A torque accelerates J1 + J2 evenly, over turns; a universal joint would make the second one swing."""
    names = ["hinge.angularRate", "two.angularVelocity[3]", "hinge.angle"]
    rate = 20.0 / 0.05
    found = end(bent_shafts(Type.constant_velocity, bend), 2e-4, 0.2, {"hinge.motorTorque": 20.0}, names)
    assert found == pytest.approx([0.2 * rate, 0.2 * rate, 0.02 * rate], rel=1e-8)
    if bend > 0:
        other = end(bent_shafts(Type.universal, bend), 2e-4, 0.2, {"hinge.motorTorque": 20.0}, names)
        assert abs(other[1] / other[0] - 1) > 0.01


def test_a_bent_shaft_swings_against_a_spring():
    w = np.sqrt(2.0 / 0.05)
    names = ["hinge.angle", "hinge.angularRate", "two.angularVelocity[3]"]
    expected = np.array([np.cos(w), -w * np.sin(w), -w * np.sin(w)])
    spring = _core.JointSpring(0, 2.0)
    make = lambda: bent_shafts(Type.constant_velocity, 0.7, spring)  # noqa: E731
    assert_second_order(make, {"hinge.initialAngle": 1.0}, names, expected, 1.0, 1e-3)


@every_method
def test_every_method_keeps_to_them(method):
    """A nut under its weight and a bent shaft against a spring, in every formulation."""
    lead = PITCH / (2 * np.pi)
    fall = -0.5 * 2.0 * 9.81 * lead**2 / (0.03 + 2.0 * lead**2)
    swing = np.cos(np.sqrt(2.0 / 0.05))
    cases = [
        (nut(gravity=(0, 0, -9.81)), {}, "thread.displacement", fall, 1e-9),
        (
            bent_shafts(Type.constant_velocity, 0.7, _core.JointSpring(0, 2.0)),
            {"hinge.initialAngle": 1.0},
            "hinge.angle",
            swing,
            1e-4,
        ),
    ]
    for m, initial, name, expected, tolerance in cases:
        for setting, chosen in METHODS[method].items():
            setattr(m.integrator, setting, chosen)
        found = end(m, 1e-3, 1.0, initial, [name, "constraint.positionResidual", "constraint.velocityResidual"])
        assert found[0] == pytest.approx(expected, abs=tolerance)
        assert found[1:] == pytest.approx(np.zeros(2), abs=1e-4)


def test_the_rotation_vector_of_a_constant_velocity_joint_tells_how_it_is_bent():
    found = end(bent_shafts(Type.constant_velocity, 0.7, _core.RotationMotor(1)), 1e-3, 0.1, {"hinge.motorTorque": 5.0},
                [*(f"cross.rotationVector[{i}]" for i in (1, 2, 3)), "hinge.angle"])  # fmt: skip
    angle = found[3]  # the first frame has turned by it
    assert found[:3] == pytest.approx([0.7 * np.sin(angle), 0.7 * np.cos(angle), 0.0], abs=1e-9)


def test_a_point_in_a_plane_swings_on_two_springs():
    axes = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()
    start, w = np.array([0.4, -0.2]), np.sqrt(np.array([30.0, 50.0]) / 1.5)

    def make():
        ball = body("ball", 1.5, (0.2, 0.2, 0.2), [1, 2, 3])
        ball.initial_angular_velocity = np.array([1.0, 2.0, -1.0])
        joint = _core.Joint("table", Type.point_in_plane, GROUND, _core.Frame(np.array([1.0, 2, 3]), axes), 0, HERE)
        return mechanism(ball, joint, _core.JointSpring(0, 30.0), _core.JointSpring(0, 50.0, coordinate=1))

    names = ["table.displacement1", "table.displacement2", "table.rate1", "table.rate2"]
    initial = dict(zip(("table.initialDisplacement1", "table.initialDisplacement2"), start, strict=True))
    expected = np.concatenate([start * np.cos(w), -start * w * np.sin(w)])
    assert_second_order(make, initial, names, expected)
    m = make()
    m.integrator.step_size = 1e-3
    slave = _core.Slave(m)
    slave.start()
    for i in range(100):
        slave.do_step(i * 1e-3, 1e-3)
    q = np.array([slave.get(f"ball.quaternion[{i}]") for i in (1, 2, 3, 4)])
    turned = rotation_of(np.append(np.zeros(3), q)).as_rotvec()
    assert turned == pytest.approx(0.1 * np.array([1.0, 2.0, -1.0]), rel=1e-9)  # nothing holds its rotation


@pytest.mark.parametrize(
    ("kind", "pitch", "message"),
    [
        (Type.screw, np.nan, "j is a screw without a pitch; it must have one."),
        (Type.screw, 0.0, "j.pitch is 0 m; it must be finite, and not 0."),
        (Type.screw, np.inf, "j.pitch is inf m; it must be finite, and not 0."),
        (Type.fixed, 1.0, "j has the pitch 1 m; joints of its type must have none."),
    ],
)
def test_pitches_that_make_no_sense_are_refused(kind, pitch, message):
    m = mechanism(body("b"), _core.Joint("j", kind, GROUND, HERE, 0, HERE, pitch=pitch))
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        m.validate()


def test_half_a_turn_from_the_thread_is_not_on_it():
    turned = body("nut", 2.0, (0.1, 0.1, 0.03), turn=(0, 0, np.pi))
    m = mechanism(turned, _core.Joint("thread", Type.screw, GROUND, HERE, 0, HERE, pitch=PITCH))
    with pytest.raises(RuntimeError, match="thread"):
        _core.Slave(m).start()


def test_pitch_and_reaction_are_in_files_and_the_fmu():
    where = _core.Reaction(_core.ReactionAt.frame1, np.array([0.1, 0, 0]), _core.ReactionAxes.frame2)
    joint = _core.Joint("thread", Type.screw, GROUND, HERE, 0, HERE, pitch=PITCH, reaction=where)
    m = mechanism(body("nut"), joint)
    text = _core.to_json(m)
    again = _core.from_json(text)
    assert _core.to_json(again) == text
    assert again.multibody.joints[0].reaction.at == _core.ReactionAt.frame1
    slave = _core.Slave(m)
    slave.set("thread.pitch", 2 * PITCH)
    slave.set("thread.initialDisplacement", 2 * PITCH / 8)
    slave.start()
    assert slave.get("thread.angle") == pytest.approx(np.pi / 4, rel=1e-12)
