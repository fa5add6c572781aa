"""Dependent joints are found whatever their geometry, named, and told apart from what else stops a mechanism."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .closed_chains import (
    FIXED,
    PRISMATIC,
    REVOLUTE,
    SPHERICAL,
    UNIVERSAL,
    JointPlace,
    bricard,
    direction,
    door,
    independent_chain,
    mechanism,
    planar_four_bar,
)
from .helpers import GROUND, Rotation, exact, mass_matrix, mp, rounded

DEPENDENT = {  # what is built, and how many of how many equations follow from others
    "door on hinge and ball": (door, 3, 8),
    "RRRR": (lambda rng, size: planar_four_bar(rng, REVOLUTE, size), 3, 20),
    "RRUR": (lambda rng, size: planar_four_bar(rng, UNIVERSAL, size), 2, 19),
    "RRSR": (lambda rng, size: planar_four_bar(rng, SPHERICAL, size), 1, 18),
    "Bricard": (bricard, 1, 30),
}


def refusal(chain: _core.Mechanism) -> str:
    with pytest.raises(RuntimeError) as caught:
        _core.Simulation(chain)
    return str(caught.value)


def disturbed(rng: np.random.Generator, chain: _core.Mechanism, distance: float) -> _core.Mechanism:
    """The same with initial positions that have few digits."""
    for i in range(len(chain.multibody.bodies)):
        body = chain.multibody.body(i)
        body.initial_position = body.initial_position + distance * rng.normal(size=3)
        body.initial_quaternion = body.initial_quaternion + distance * rng.normal(size=4)
    return chain


@pytest.mark.parametrize(("build", "dependent", "equations"), DEPENDENT.values(), ids=DEPENDENT)
@pytest.mark.parametrize("distance", [0.0, 1e-3], ids=["exact", "three digits"])
@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0], ids=lambda size: f"{size:g} m")
def test_dependent_joints_are_named(build, dependent, equations, distance, size):
    """100 geometries each: the same sentence for all, at the start."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        chain = disturbed(rng, build(rng, size), distance * min(size, 1.0))
        names = [joint.name for joint in chain.multibody.joints]
        verb = "follows" if dependent == 1 else "follow"
        slave = _core.Slave(chain)
        slave.start()
        assert slave.messages == [
            f"Joint equations are dependent: {dependent} of the {equations} equations of joints "
            f"{', '.join(names[:-1])} and {names[-1]} {verb} from the others; the reactions of these joints are one "
            "choice of many that fit the motion."
        ], seed
        assert slave.get("joints.redundant") == dependent


@pytest.mark.parametrize("closed", [False, True], ids=["tree", "loop"])
def test_independent_joints_raise_no_alarm(closed):
    """Any joints and directions, links of 0.1 mm to 1 km, bodies of 1e-3 to 1e3 kg."""
    for seed in range(200):
        chain = independent_chain(np.random.default_rng(seed), closed)
        found = _core.freedom(chain.multibody)
        assert found.groups == [], seed
        assert found.independent == found.equations
        _core.assemble(chain.multibody)


def test_groups_of_dependent_joints_are_told_apart():
    """A door, a body on a spherical joint and a pair of hinges on one axis in one mechanism."""
    rng = np.random.default_rng(3)
    axis, height = np.array([0.0, 0, 1]), np.array([0.0, 0, 0.7])
    places = [
        JointPlace(REVOLUTE, GROUND, 0, np.zeros(3), axis),
        JointPlace(SPHERICAL, 0, 1, np.array([1.0, 0, 0]), axis),
        JointPlace(REVOLUTE, 1, 2, np.array([2.0, 0, 0]), axis),
        JointPlace(SPHERICAL, GROUND, 0, height, axis),
        JointPlace(REVOLUTE, 2, 1, np.array([2.0, 0, 0]) + height, axis),
    ]
    found = _core.freedom(mechanism(rng, 3, places).multibody)
    assert [(g.joints, g.equations, g.dependent) for g in found.groups] == [([0, 3], 8, 3), ([2, 4], 10, 5)]
    assert (found.degrees, found.velocities, found.equations, found.independent) == (5, 18, 21, 13)
    assert str(found) == "5 (18 velocities, 13 independent joint equations, 8 dependent ones)"


@pytest.mark.parametrize("model", _core.mechanisms())
def test_benchmark_mechanisms_are_independent(model):
    found = _core.freedom(_core.mechanism(model).multibody)
    assert found.independent == found.equations
    assert found.margin > 0.05


# --- other reasons ---------------------------------------------------------------------------------------------------


def slider_crank(rng: np.random.Generator, crank: float, rod: float, angle: float) -> _core.Mechanism:
    """In the plane, with joints (R, S, U, P) that leave it one freedom; the slider moves along x."""
    pin = crank * np.array([np.cos(angle), np.sin(angle), 0])
    slider = np.array([pin[0] + np.sqrt(rod**2 - pin[1] ** 2), 0, 0])
    z, x = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])
    places = [
        JointPlace(REVOLUTE, GROUND, 0, np.zeros(3), z),
        JointPlace(SPHERICAL, 0, 1, pin, z),
        JointPlace(UNIVERSAL, 1, 2, slider, z),
        JointPlace(PRISMATIC, GROUND, 2, slider, x),
    ]
    return mechanism(rng, 3, places)


def test_a_change_point_is_a_singular_position():
    """Crank and rod of equal length, upright and folded: the slider may stay while the crank turns, or move."""
    rng = np.random.default_rng(2)
    text = refusal(slider_crank(rng, 0.5, 0.5, np.pi / 2))
    assert re.fullmatch(
        r"The position is singular: 1 of the 17 equations of joints joint1, joint2, joint3 and joint4 follows from the "
        r"others in it alone; choose a start at some distance from it, or velocities that lead through it\.",
        text,
    )
    _core.Simulation(slider_crank(rng, 0.5, 0.5, np.pi / 2 - 0.05))
    _core.Simulation(slider_crank(rng, 0.5, 0.6, np.pi / 2))


def test_too_small_an_inertia_is_called_that():
    """A point mass on a joint whose equations are independent; along an axis of W digits would suffice."""
    top = _core.mechanism("HeavyTop")
    turn = Rotation.from_rotvec([0.3, 0.7, -0.2])
    body = top.multibody.body(0)
    body.inertia = np.full(3, 1e-15)
    body.initial_position = turn.apply(body.initial_position)
    body.initial_quaternion = turn.as_quat(scalar_first=True)
    assert re.fullmatch(
        r"The mass or inertia of body top is too small for this mechanism: 15 kg and at least 1e-15 kg\.m2, where "
        r"joints act at up to [\d.]* m and the heaviest body has 15 kg; digits to tell them apart are missing\.",
        refusal(top),
    )


def test_joints_that_do_not_reach_are_called_that():
    """A link of 1 m between points that are 3 m apart."""
    rng = np.random.default_rng(4)
    ends = [np.zeros(3), np.array([1.0, 0, 0])]
    places = [JointPlace(SPHERICAL, GROUND, 0, end, np.array([0.0, 0, 1])) for end in ends]
    near = mechanism(rng, 1, places).multibody
    far = _core.Mechanism()
    far.multibody.add(near.bodies[0])
    far.multibody.add(near.joints[0])
    second = near.joints[1]
    moved = _core.Frame(np.array([3.0, 0, 0]), second.frame1.axes)
    far.multibody.add(_core.Joint(second.name, SPHERICAL, GROUND, moved, 0, second.frame2))
    assert re.fullmatch(
        r"The mechanism cannot be assembled from its initial positions: joints joint1 and joint2 cannot be closed "
        r"together, they miss by 2 m\.",
        refusal(far),
    )


def test_a_mechanism_that_cannot_move_has_no_freedom():
    rng = np.random.default_rng(5)
    places = [JointPlace(FIXED, GROUND, 0, np.ones(3), np.array([0.0, 0, 1]))]
    found = _core.freedom(mechanism(rng, 1, places).multibody)
    assert (found.degrees, str(found)) == (0, "0 (6 velocities, 6 independent joint equations)")


# --- accelerations of light bodies -----------------------------------------------------------------------------------


def exact_accelerations(definition: _core.Multibody, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(vdot, lambda) of M vdot + g + Bᵀ lambda = 0, B vdot + Z v = 0, solved in 50 digits."""
    system = _core.System(definition)
    n, m = system.velocity_size, system.constraint_size
    forces = system.residual(q, v, np.zeros(n), np.zeros(m), np.zeros(system.input_size))
    _, _, B, Z = system.constraints(q, v)
    matrix = np.block([[mass_matrix(definition), B.T], [B, np.zeros((m, m))]])
    right = exact(-np.concatenate([forces, np.zeros(m)]))
    right[n:, 0] = -exact(Z) * exact(v)
    return rounded(mp.lu_solve(exact(matrix), right))


@pytest.mark.parametrize("light", [1.0, 1e-3, 1e-9, 1e-12, 1e-14], ids=lambda mass: f"{mass:g} kg")
def test_a_light_link_costs_no_digits(light):
    """Between two bodies of 1 kg, on hinges of any direction."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        points = np.cumsum([direction(rng) for _ in range(3)], axis=0)
        places = [JointPlace(REVOLUTE, i - 1, i, points[i], direction(rng)) for i in range(3)]
        chain = mechanism(rng, 3, places, [1.0, light, 1.0]).multibody
        chain.gravity = np.array([0, 0, -9.81])
        for i in range(3):
            chain.body(i).initial_angular_velocity = rng.normal(size=3)
        q, v = _core.assemble(chain)
        system = _core.System(chain)
        found = system.accelerations(q, v, np.zeros(system.input_size))
        expected = exact_accelerations(chain, q, v)
        parts = (expected[: len(v)], expected[len(v) :])
        for value, part in zip(found, parts, strict=True):
            assert np.abs(value - part).max() <= 1e-10 * np.abs(part).max(), seed


# --- too many equations ----------------------------------------------------------------------------------------------


def tilted(chain: _core.Mechanism, joint: int, angle: float) -> _core.Mechanism:
    """The same with the axis of one hinge turned in both bodies: it still closes."""
    m = _core.Mechanism()
    for body in chain.multibody.bodies:
        m.multibody.add(body)
    for k, j in enumerate(chain.multibody.joints):
        frames = [j.frame1, j.frame2]
        if k == joint:
            turn = _core.lie.exp(angle * np.array([0.6, 0.8, 0.0]))  # about an axis of the joint's frames
            R = Rotation.from_quat(turn, scalar_first=True).as_matrix()
            frames = [_core.Frame(f.origin, f.axes @ R) for f in frames]
        m.multibody.add(_core.Joint(j.name, j.type, j.body1, frames[0], j.body2, frames[1]))
    return m


@pytest.mark.parametrize("angle", [0.1, 1e-3, 1e-5])
def test_a_tilted_hinge_locks_a_four_bar(angle):
    """Redundant joints that fit move; with an axis out of the plane's normal they fit in that position alone."""
    chain = tilted(planar_four_bar(np.random.default_rng(1)), 2, angle)
    found = _core.freedom(chain.multibody)
    assert (found.degrees, found.equations, found.independent) == (0, 20, 18)
    _core.Simulation(chain)  # at rest, a frame like any other
    chain.multibody.body(0).initial_angular_velocity = np.array([0.0, 0, 1.0])
    assert refusal(chain) == (
        "The mechanism cannot move, but its bodies have initial velocities: joints joint1, joint2, joint3 and joint4 "
        "hold all of them; degrees of freedom: 0 (18 velocities, 18 independent joint equations, 2 dependent ones)."
    )


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-6])
def test_a_link_of_wrong_length_is_told_from_redundant_joints(gap):
    """A second hinge on a door, on its axis but at another height of the door than of the wall: that much is missing,
    however little it is."""
    rng = np.random.default_rng(6)
    axis = np.array([0.0, 0, 1])
    places = [JointPlace(REVOLUTE, GROUND, 0, height * axis, axis) for height in (0.0, 2.0)]
    fit = mechanism(rng, 1, places).multibody
    off = _core.Mechanism()
    off.multibody.add(fit.bodies[0])
    off.multibody.add(fit.joints[0])
    second = fit.joints[1]
    raised = _core.Frame(second.frame1.origin + gap * axis, second.frame1.axes)
    off.multibody.add(_core.Joint("upper", REVOLUTE, GROUND, raised, 0, second.frame2))
    text = refusal(off)
    found = re.fullmatch(
        r"The mechanism cannot be assembled from its initial positions: joints joint1 and upper cannot be closed "
        r"together, they miss by (\S+) m\.",
        text,
    )
    assert found, text
    assert float(found[1]) == pytest.approx(gap, rel=1e-3)
