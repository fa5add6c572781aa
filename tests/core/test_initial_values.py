"""Initial values of mechanisms built in Python: what is set is held, also in chains with many ways to give way."""

from time import perf_counter

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import EPS

GROUND, Type = _core.GROUND, _core.JointType
Z = np.eye(3)


def chain(kinds):
    """Links of 1 m along x, each joint's axis z; starts stretched out."""
    mechanism = _core.Mechanism()
    for i, kind in enumerate(kinds):
        body = _core.RigidBody()
        body.name = f"link{i + 1}"
        body.mass = 1.0 + i
        body.inertia = np.array([0.1, 0.2, 0.25])
        body.initial_position = np.array([i + 0.5, 0, 0])
        body.initial_angular_velocity = np.array([0, 0, 0.5])
        body.initial_velocity = np.array([0, 0.5 * (i + 0.5), 0])
        mechanism.multibody.add(body)
        inner = _core.Frame(np.array([0.5 if i else 0.0, 0, 0]), Z)
        outer = _core.Frame(np.array([-0.5, 0, 0]), Z)
        mechanism.multibody.add(_core.Joint(f"joint{i + 1}", kind, i - 1, inner, i, outer))
    return mechanism


def coordinates(mechanism):
    simulation, system = _core.Simulation(mechanism), _core.System(mechanism.multibody)
    q, v = simulation.state.q, simulation.state.v
    phi, phidot, _, _ = system.constraints(q, v)
    assert np.abs(phi).max() <= 1e-14
    assert np.abs(phidot).max() <= 1e-14
    return [system.coordinate(q, v, j) for j in range(len(mechanism.multibody.joints))], simulation.state


def test_joints_that_are_not_set_keep_their_angles():
    """One angle of a chain is set: the links beyond it turn along, their angles and rates stay."""
    mechanism = chain([Type.revolute] * 3)
    mechanism.set("joint1.initialAngle", 0.75)
    mechanism.set("joint2.initialAngularRate", -2.0)
    found, state = coordinates(mechanism)
    np.testing.assert_allclose(found, [(0.75, 0.5), (0, -2.0), (0, 0)], rtol=0, atol=16 * EPS)
    assert state.turned[0] == pytest.approx(0.75, rel=4 * EPS)


def test_turns_are_counted_by_the_simulation():
    mechanism = chain([Type.revolute])
    mechanism.set("joint1.initialAngle", -30.0)
    assert _core.Simulation(mechanism).state.turned[0] == pytest.approx(-30.0, rel=4 * EPS)


def test_orientations_that_are_not_set_stay_where_joints_allow_it():
    """On spherical joints a turned link moves the next one, which does not turn."""
    mechanism = chain([Type.spherical] * 2)
    mechanism.set("link1.initialQuaternion[4]", 1.0)  # a quarter turn about z
    _, state = coordinates(mechanism)
    one, two = state.q.reshape(2, 7)
    np.testing.assert_allclose(one, [0, 0.5, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)], rtol=0, atol=4 * EPS)
    np.testing.assert_allclose(two, [0.5, 1, 0, 1, 0, 0, 0], rtol=0, atol=4 * EPS)
    np.testing.assert_allclose(state.v.reshape(2, 6)[:, 3:], [[0, 0, 0.5]] * 2, rtol=0, atol=4 * EPS)


def test_translations_share_a_change_by_their_masses():
    """Two sliders in a row that are free to move: the set distance moves both, the centre of mass stays."""
    mechanism = _core.Mechanism()
    for i, mass in enumerate((1.0, 3.0)):
        body = _core.RigidBody()
        body.name, body.mass = f"body{i + 1}", mass
        mechanism.multibody.add(body)
    frame = _core.Frame(np.zeros(3), Z)
    mechanism.multibody.add(_core.Joint("slide", Type.prismatic, 0, frame, 1, frame))
    mechanism.set("slide.initialDisplacement", 0.8)
    mechanism.set("slide.initialRate", -0.4)
    found, state = coordinates(mechanism)
    assert found[0] == pytest.approx((0.8, -0.4), rel=4 * EPS)
    np.testing.assert_allclose(state.q[[2, 9]], [-0.6, 0.2], rtol=0, atol=4 * EPS)
    np.testing.assert_allclose(state.v[[2, 8]], [0.3, -0.1], rtol=0, atol=4 * EPS)


@pytest.mark.parametrize("kinds", [[Type.revolute], [Type.revolute, Type.prismatic, Type.cylindrical, Type.fixed]])
def test_links_of_a_long_chain_are_found_as_those_of_a_short_one(kinds):
    """Hundreds of links: by the sparse solver, in a time that grows with them and not with their cube."""
    times = []
    for links in (48, 192, 768):
        mechanism = chain([kinds[i % len(kinds)] for i in range(links)])
        mechanism.set("joint1.initialAngle", 0.75)
        mechanism.set("joint1.initialAngularRate", -2.0)
        start = perf_counter()
        simulation = _core.Simulation(mechanism)
        times.append(perf_counter() - start)
        q, v = simulation.state.q.reshape(-1, 7), simulation.state.v.reshape(-1, 6)
        centers = np.arange(links) + 0.5  # along a straight line
        along = np.array([np.cos(0.75), np.sin(0.75), 0])
        np.testing.assert_allclose(q[:, :3], np.outer(centers, along), rtol=0, atol=1e-12 * links)
        np.testing.assert_allclose(v[:, 5], -2.0, rtol=0, atol=1e-12 * links)
        np.testing.assert_allclose(v[:, 2], 0, rtol=0, atol=1e-12 * links)
    assert times[-1] <= 64 * times[0] + 0.1  # 16 times as many links; a cube would take 4096 times as long


def test_changing_a_definition_in_place_sets_nothing():
    """Its author's values give way as ever, by the least change in the mass metric."""
    mechanism = _core.mechanism("HeavyTop")
    mechanism.multibody.body(0).initial_velocity = np.array([1.0, 0, 0])
    speed = _core.Simulation(mechanism).state.v[0]
    assert 1.0 < speed < 4.61538


def test_setting_is_undone_by_the_first_value():
    mechanism, untouched = _core.mechanism("SliderCrank"), _core.mechanism("SliderCrank")
    for value in (3.0, 5.0, 6.0):
        mechanism.set("crankPivot.initialAngularRate", value)
    one, other = _core.Simulation(mechanism), _core.Simulation(untouched)
    assert one.state.q.tobytes() == other.state.q.tobytes()
    assert one.state.v.tobytes() == other.state.v.tobytes()


def test_contradictions_are_named():
    mechanism = chain([Type.revolute, Type.revolute])
    mechanism.set("link2.initialAngularVelocity[1]", 0.25)
    with pytest.raises(
        RuntimeError,
        match=r"^link2\.initialAngularVelocity\[1\] = 0\.25 rad/s contradicts joints joint1 and "
        r"joint2 by 0\.25 rad/s\.$",
    ):
        _core.Simulation(mechanism)


def test_dependent_joints_are_told_from_a_mechanism_that_cannot_be_closed():
    """A door on a hinge and a ball on its axis closes, though its equations are dependent."""
    door = chain([Type.revolute])
    ball = _core.Frame(np.array([0, 0, 1.0]), Z), _core.Frame(np.array([-0.5, 0, 1.0]), Z)
    door.multibody.add(_core.Joint("ball", Type.spherical, GROUND, ball[0], 0, ball[1]))
    assert _core.freedom(door.multibody).groups[0].dependent == 3
    _core.Simulation(door)
    too_far = chain([Type.revolute])
    off = _core.Frame(np.array([-0.5, 0, 1.25]), Z)
    too_far.multibody.add(_core.Joint("ball", Type.spherical, GROUND, ball[0], 0, off))
    with pytest.raises(
        RuntimeError, match=r"joints joint1 and ball cannot be closed together, they miss by 0\.25 m\.$"
    ):
        _core.Simulation(too_far)
