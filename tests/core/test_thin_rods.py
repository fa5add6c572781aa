"""Bodies without inertia about one axis, and links without any."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import GROUND, Rotation, Type
from .test_joint_types import HERE, G, assert_second_order, body, mechanism, solution

MASS, LENGTH, J = 0.8, 0.6, 0.024  # J about the middle: m L²/12


def rod(name="rod", turn=(0, 0, 0), end=(0, 0, 0)):
    """Along its z axis, hanging from `end`, turned."""
    rotation = Rotation.from_rotvec(turn)
    middle = np.array(end) + rotation.apply([0, 0, -LENGTH / 2])
    return body(name, MASS, (J, J, 0.0), middle, turn)


TOP = _core.Frame(np.array([0, 0, LENGTH / 2]), np.eye(3))


def test_a_thin_rod_on_a_universal_joint_is_a_spherical_pendulum():
    """I = J + m L²/4 about every axis across it and nothing along it: I θ'' = I sin θ cos θ φ'² - m g L/2 sin θ."""
    inertia, arm = J + MASS * LENGTH**2 / 4, LENGTH / 2

    def equations(_, y):
        theta, _, dtheta, dphi = y
        swing = np.sin(theta) * np.cos(theta) * dphi**2 - MASS * G * arm * np.sin(theta) / inertia
        return [dtheta, dphi, swing, -2 * dtheta * dphi / np.tan(theta)]

    theta, spin = 0.7, 3.0

    def make():
        part = rod(turn=(0, -theta, 0))  # into the xz plane
        velocity = np.array([0, spin * arm * np.sin(theta), 0])
        part.initial_velocity = velocity
        # w across the rod: e × v/arm, e from the pivot to the middle
        e = np.array([np.sin(theta), 0, -np.cos(theta)])
        part.initial_angular_velocity = Rotation.from_rotvec([0, -theta, 0]).inv().apply(np.cross(e, velocity) / arm)
        return mechanism(part, _core.Joint("pivot", Type.universal, GROUND, HERE, 0, TOP), gravity=(0, 0, -G))

    end = solution(equations, [theta, 0.0, 0.0, spin], 1.0)
    direction = [np.sin(end[0]) * np.cos(end[1]), np.sin(end[0]) * np.sin(end[1]), -np.cos(end[0])]
    names = [f"rod.position[{i}]" for i in (1, 2, 3)]
    assert_second_order(make, {}, names, arm * np.array(direction), h=4e-3)


def test_reactions_of_a_thin_rod():
    """A rod that is let go from the horizontal: θ'' = -m g L/2 / I, the pivot bears a quarter of its weight."""
    part = rod(turn=(0, -np.pi / 2, 0))
    slave = _core.Slave(mechanism(part, _core.Joint("pivot", Type.universal, GROUND, HERE, 0, TOP), gravity=(0, 0, -G)))
    slave.start()
    assert slave.get("pivot.reactionForce[3]") == pytest.approx(MASS * G / 4, rel=1e-8)
    assert slave.get("rod.acceleration[3]") == pytest.approx(-0.75 * G, rel=1e-8)


def test_a_rod_that_may_spin_is_refused_by_name():
    ball = _core.Joint("ball", Type.spherical, GROUND, HERE, 0, TOP)
    message = "rod has no inertia about an axis about which its joints let it turn; it must have some."
    with pytest.raises(RuntimeError, match=f"^{re.escape(message)}$"):
        _core.Simulation(mechanism(rod(), ball))


def test_a_link_without_mass_is_told_what_to_do():
    """As robot descriptions have them: frames that are written as links."""
    nothing = body("tool", 0.0, (0, 0, 0))
    weld = _core.Joint("flange", Type.fixed, 0, HERE, 1, HERE)
    message = (
        "tool.mass is 0 kg; it must be positive and finite; flange fixes it to arm: "
        "leave it out and attach to arm what it carries."
    )
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        mechanism(body("arm"), nothing, weld).validate()
    with pytest.raises(ValueError, match=r"^tool\.mass is 0 kg; it must be positive and finite\.$"):
        mechanism(nothing).validate()
