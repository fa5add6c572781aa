"""Every joint between every pair of bodies and the ground: its equations and all their derivatives against differences,
its free motions, its motor and its reaction."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import strategies as st

from sigmafmu import _core

from .helpers import (
    COORDINATES,
    DIFFERENCES,
    EPS,
    EQUATIONS,
    GROUND,
    JOINT_TYPES,
    LEAD,
    LENGTH,
    VELOCITY_EQUATIONS,
    assert_close,
    coordinates,
    derivative,
    frame_pose,
    jacobian,
    make_joint,
    null_space,
    property_test,
    random_body,
    random_coordinates,
    random_frame,
    random_pose,
    relative_pose,
    rotation_of,
    second_derivative,
    seeds,
    to_touching_point,
)

Type = _core.JointType
PAIRS = {"ground-body": (GROUND, 0), "body-ground": (0, GROUND), "body-body": (0, 1), "body-body, turned": (1, 0)}
X, Y, Z = np.eye(3)
ROUNDING = 40 * EPS  # products of three or four rotations, arms of length 1


@dataclass
class Case:
    """One joint of random frames, and its System without gravity or springs."""

    type: _core.JointType
    pair: tuple[int, int]
    frames: tuple[_core.Frame, _core.Frame]
    system: _core.System
    rng: np.random.Generator

    @property
    def bodies(self):
        return 1 if GROUND in self.pair else 2

    def motion(self):
        return self.rng.uniform(-1, 1, 6 * self.bodies)

    def assembled(self, relative):
        """q with frame 2 at the pose `relative` in frame 1, otherwise random."""
        one, two = (frame_pose(frame) for frame in self.frames)
        if self.pair[0] == GROUND:
            first = np.eye(4)
        elif self.pair[1] == GROUND:  # frame 2 is fixed: X_1 = F_2 relative⁻¹ F_1⁻¹
            return coordinates(two @ np.linalg.inv(relative) @ np.linalg.inv(one))
        else:
            first = random_pose(self.rng)
        second = first @ one @ relative @ np.linalg.inv(two)
        placed = {self.pair[0]: first, self.pair[1]: second}
        return coordinates(*(placed[i] for i in range(self.bodies)))

    def anywhere(self):
        """Any q, but for disks that nearly lie flat."""
        while True:
            q = random_coordinates(self.rng, self.bodies)
            tilt = np.linalg.norm(np.cross(self.axes(q, 0)[:, 2], self.axes(q, 1)[:, 2]))
            if self.type != Type.rolling_disk or tilt > 0.3:
                return q

    def acting_point(self, q):
        """Where the reaction acts on body 2, in W: its origin, or the point of contact of a disk."""
        centre = self.origin(q, 1)
        if self.type != Type.rolling_disk:
            return centre
        return centre + to_touching_point(self.axes(q, 0), self.axes(q, 1))

    def axes(self, q, side):
        """Axes (columns) of the joint's frame of body 1 or 2 (side 0, 1), in W."""
        body = self.pair[side]
        turn = np.eye(3) if body == GROUND else rotation_of(q[7 * body : 7 * body + 7]).as_matrix()
        return turn @ self.frames[side].axes

    def origin(self, q, side):
        body = self.pair[side]
        point = self.frames[side].origin
        return point if body == GROUND else q[7 * body : 7 * body + 3] + rotation_of(q[7 * body :][:7]).apply(point)

    def twist(self, q, body, velocity, angular, point):
        """v of a body alone that turns with `angular` (W) about `point` (W), which moves with `velocity`."""
        v = np.zeros(6 * self.bodies)
        if body != GROUND:
            place = q[7 * body : 7 * body + 7]
            v[6 * body : 6 * body + 3] = velocity + np.cross(angular, place[:3] - point)
            v[6 * body + 3 : 6 * body + 6] = rotation_of(place).inv().apply(angular)
        return v


def make(kind, pair, seed, reaction=None):
    rng = np.random.default_rng(seed)
    definition = _core.Multibody()
    definition.add(random_body(rng, "one"))
    if GROUND not in pair:
        definition.add(random_body(rng, "two"))
    frames = random_frame(rng), random_frame(rng)
    joint = make_joint("joint", kind, pair[0], frames[0], pair[1], frames[1])
    if reaction is not None:
        joint.reaction = reaction
    definition.add(joint)
    return Case(kind, pair, frames, _core.System(definition), rng)


every_joint = pytest.mark.parametrize("kind", JOINT_TYPES, ids=lambda t: t.name)
every_pair = pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)


free_coordinates = st.tuples(*[st.one_of(st.sampled_from([0.0, np.pi / 2, -np.pi / 2]), st.floats(-3.1, 3.1))] * 3)


# --- derivatives -----------------------------------------------------------------------------------------------------


@every_joint
@every_pair
def test_number_of_equations(kind, pair):
    assert make(kind, pair, 0).system.constraint_size == EQUATIONS[kind]


@every_joint
@every_pair
@property_test(25, seed=seeds)
def test_derivatives_of_the_constraint(kind, pair, seed):
    """B = dΦ/d(motion), Φ' = B v = dΦ/dt, Z = dΦ'/d(motion), anywhere: the joint need not be assembled."""
    case = make(kind, pair, seed)
    system, q, v = case.system, case.anywhere(), case.motion()
    phi, rate, gradient, rate_gradient = system.constraints(q, v)
    size, of_positions = 6 * case.bodies, EQUATIONS[kind] - VELOCITY_EQUATIONS.get(kind, 0)
    by_motion = jacobian(lambda x: system.constraints(system.compose(q, x), v)[0], size)
    by_time = derivative(lambda t: system.constraints(system.compose(q, t * v), v)[0])
    assert_close(gradient[:of_positions], by_motion[:of_positions], DIFFERENCES)
    assert_close(rate_gradient, jacobian(lambda x: system.constraints(system.compose(q, x), v)[1], size), DIFFERENCES)
    assert_close(rate, gradient @ v, 8 * EPS)
    assert_close(rate[:of_positions], by_time[:of_positions], DIFFERENCES)
    assert not phi[of_positions:].any()  # what is of velocities alone has no Φ
    assert system.velocity_equations == list(range(of_positions, EQUATIONS[kind]))


@every_joint
@every_pair
@property_test(25, seed=seeds)
def test_second_time_derivative_of_the_constraint(kind, pair, seed):
    """Φ'' = B v' + Z v along a motion q ∘ exp(t v + t²/2 v'), whose velocity is v + t v' + O(t²)."""
    case = make(kind, pair, seed)
    system, q, v, vdot = case.system, case.anywhere(), case.motion(), case.motion()
    _, _, gradient, rate_gradient = system.constraints(q, v)
    h = 4e-3 if kind in (Type.screw, Type.rolling_disk) else 1e-2  # a thread makes waves along its axis
    second = second_derivative(lambda t: system.constraints(system.compose(q, t * v + 0.5 * t * t * vdot), v)[0], h)
    last = EQUATIONS[kind] - VELOCITY_EQUATIONS.get(kind, 0)
    second[last:] = derivative(  # that of Φ' is all they have
        lambda t: system.constraints(system.compose(q, t * v + 0.5 * t * t * vdot), v + t * vdot)[1]
    )[last:]
    assert_close(gradient @ vdot + rate_gradient @ v, second, 1e-9)  # rounding, see second_derivative


@every_joint
@every_pair
@property_test(25, seed=seeds)
def test_stiffness_of_the_reaction_and_of_the_motor(kind, pair, seed):
    """K = d(Bᵀλ - motor force)/d(motion) as part of the residual; C has the gyroscopic term alone."""
    case = make(kind, pair, seed)
    system, q, v, vdot = case.system, case.anywhere(), case.motion(), case.motion()
    multipliers = case.rng.uniform(-10, 10, system.constraint_size)
    inputs = case.rng.uniform(-10, 10, system.input_size)
    _, damping, stiffness = system.linearization(q, v, multipliers, inputs)

    def residual(x=0.0, dv=0.0):
        return system.residual(system.compose(q, x + np.zeros_like(v)), v + dv, vdot, multipliers, inputs)

    size = 6 * case.bodies
    assert_close(stiffness, jacobian(lambda x: residual(x=x), size), DIFFERENCES, scale=10)
    assert_close(damping, jacobian(lambda dv: residual(dv=dv), size), DIFFERENCES, scale=10)


@every_joint
@every_pair
@property_test(25, seed=seeds)
def test_multipliers_act_through_the_gradient(kind, pair, seed):
    """The multipliers' share of the residual is Bᵀλ."""
    case = make(kind, pair, seed)
    system, q, v = case.system, case.anywhere(), case.motion()
    zero, inputs = np.zeros(6 * case.bodies), np.zeros(system.input_size)
    multipliers = case.rng.uniform(-10, 10, system.constraint_size)
    share = system.residual(q, v, zero, multipliers, inputs) - system.residual(q, v, zero, 0 * multipliers, inputs)
    assert_close(share, system.constraints(q, v)[2].T @ multipliers, 32 * EPS, scale=10)


# --- free motions ----------------------------------------------------------------------------------------------------


@every_joint
@every_pair
@property_test(50, seed=seeds, free=free_coordinates)
def test_assembled_joint_satisfies_its_equations(kind, pair, seed, free):
    """Any finite free motion: e.g. a revolute joint turned about its z axis."""
    case = make(kind, pair, seed)
    q = case.assembled(relative_pose(kind, free))
    phi = case.system.constraints(q, np.zeros(6 * case.bodies))[0]
    assert_close(phi, np.zeros(EQUATIONS[kind]), ROUNDING)


def free_motions(case, q):
    """Basis of all velocities that the joint allows, made from what the joint is: rows."""
    one, two = case.axes(q, 0), case.axes(q, 1)
    at = case.acting_point(q)
    zero = np.zeros(3)
    turns = [(zero, X), (zero, Y), (zero, Z)]
    free = {
        Type.spherical: turns,
        Type.revolute: [(zero, one[:, 2])],
        Type.universal: [(zero, one[:, 1]), (zero, two[:, 0])],
        Type.prismatic: [(one[:, 2], zero)],
        Type.fixed: [],
        Type.cylindrical: [(zero, one[:, 2]), (one[:, 2], zero)],
        Type.planar: [(zero, one[:, 2]), (one[:, 0], zero), (one[:, 1], zero)],
        Type.distance: [*turns, *((e, zero) for e in null_space([at - case.origin(q, 0)]).T)],
        Type.point_on_line: [*turns, (one[:, 2], zero)],
        Type.free: [*turns, (X, zero), (Y, zero), (Z, zero)],
        Type.screw: [(LEAD * one[:, 2], one[:, 2])],
        Type.constant_velocity: [(zero, e) for e in null_space([one[:, 2] + two[:, 2]]).T],
        Type.point_in_plane: [*turns, (one[:, 0], zero), (one[:, 1], zero)],
        Type.rolling_disk: turns,
    }[case.type]
    moving = case.pair[1] if case.pair[1] != GROUND else case.pair[0]
    relative = [case.twist(q, moving, velocity, angular, at) for velocity, angular in free]
    together = []
    if case.bodies == 2:
        rigid = [(e, zero) for e in np.eye(3)] + [(zero, e) for e in np.eye(3)]
        together = [sum(case.twist(q, body, *motion, at) for body in (0, 1)) for motion in rigid]
    return np.array(relative + together).reshape(-1, 6 * case.bodies)


@every_joint
@every_pair
@property_test(50, seed=seeds, free=free_coordinates)
def test_free_motions_are_those_of_the_joint_and_no_others(kind, pair, seed, free):
    """B n = 0 for each of them, and as many independent ones as B leaves free."""
    case = make(kind, pair, seed)
    q = case.assembled(relative_pose(kind, free))
    gradient = case.system.constraints(q, np.zeros(6 * case.bodies))[2]
    motions = free_motions(case, q)
    assert len(motions) == 6 * case.bodies - EQUATIONS[kind]
    assert_close(gradient @ motions.T, np.zeros((EQUATIONS[kind], len(motions))), ROUNDING)
    assert min(np.linalg.svd(gradient, compute_uv=False), default=1) > 0.1  # the equations are independent
    # y1 and x2, the axes of the cross, are perpendicular: the free motions are independent as well
    assert np.linalg.matrix_rank(motions) == len(motions)


# --- coordinate and motor --------------------------------------------------------------------------------------------

every_measured_joint = pytest.mark.parametrize("kind", COORDINATES, ids=lambda t: t.name)


@every_measured_joint
@every_pair
@property_test(50, seed=seeds, value=st.one_of(st.sampled_from([0.0, 3.14159, -3.14159]), st.floats(-3.14, 3.14)))
def test_coordinate_is_angle_or_displacement(kind, pair, seed, value):
    case = make(kind, pair, seed)
    expected = np.array([value, 0.5 * value, -0.7 * value])
    q = case.assembled(relative_pose(kind, expected))
    found = [case.system.coordinate(q, np.zeros(6 * case.bodies), 0, k)[0] for k in range(COORDINATES[kind])]
    assert found == pytest.approx(expected[: COORDINATES[kind]], abs=ROUNDING)


def moving(case, free):
    """An assembled joint that moves as it may: q, v."""
    q = case.assembled(relative_pose(case.type, free))
    motions = free_motions(case, q)
    return q, case.rng.uniform(-1, 1, len(motions)) @ motions


@every_measured_joint
@every_pair
@property_test(50, seed=seeds, value=st.floats(-3.0, 3.0))
def test_coordinate_rate(kind, pair, seed, value):
    """Against the difference of the coordinate along a motion that the joint allows."""
    case = make(kind, pair, seed)
    q, v = moving(case, (value, 0, 0))
    assert_close(case.system.constraints(q, v)[1], np.zeros(EQUATIONS[kind]), ROUNDING)
    for k in range(COORDINATES[kind]):
        expected = derivative(lambda t, k=k: case.system.coordinate(case.system.compose(q, t * v), v, 0, k)[0])
        assert_close(case.system.coordinate(q, v, 0, k)[1], expected, DIFFERENCES)


@every_measured_joint
@every_pair
@property_test(25, seed=seeds)
def test_coordinate_acceleration(kind, pair, seed):
    """The derivative of the rate along a motion with these accelerations, anywhere."""
    case = make(kind, pair, seed)
    system, q, v, vdot = case.system, random_coordinates(case.rng, case.bodies), case.motion(), case.motion()
    for k in range(COORDINATES[kind]):
        expected = derivative(
            lambda t, k=k: system.coordinate(system.compose(q, t * v + 0.5 * t * t * vdot), v + t * vdot, 0, k)[1]
        )
        assert_close(system.coordinate_acceleration(q, v, vdot, 0, k), expected, DIFFERENCES)


@every_pair
@property_test(25, seed=seeds)
def test_displacement_rate_anywhere(pair, seed):
    """The displacement is a smooth function of any configuration."""
    case = make(Type.prismatic, pair, seed)
    q, v = random_coordinates(case.rng, case.bodies), case.motion()
    expected = derivative(lambda t: case.system.coordinate(case.system.compose(q, t * v), v, 0)[0])
    assert_close(case.system.coordinate(q, v, 0)[1], expected, DIFFERENCES)


@every_measured_joint
@every_pair
@property_test(50, seed=seeds, value=st.floats(-3.0, 3.0))
def test_motor_power_is_force_times_rate(kind, pair, seed, value):
    """Virtual work: what the motors add to the bodies is their torque (force) times the rate of the coordinate."""
    case = make(kind, pair, seed)
    q, v = moving(case, (value, 0, 0))
    system, zero = case.system, np.zeros(6 * case.bodies)
    multipliers, inputs = np.zeros(system.constraint_size), np.zeros(system.input_size)
    without = system.residual(q, v, zero, multipliers, inputs)
    for k in range(COORDINATES[kind]):
        inputs[:] = 0.0
        inputs[system.motor_index(0, k)] = 7.0
        force = without - system.residual(q, v, zero, multipliers, inputs)
        assert_close(force @ v, 7.0 * system.coordinate(q, v, 0, k)[1], ROUNDING, scale=10)


@every_joint
def test_every_coordinate_has_a_motor(kind):
    system = make(kind, (GROUND, 0), 1).system
    assert [system.motor_index(0, k) >= 0 for k in range(3)] == [k < COORDINATES.get(kind, 0) for k in range(3)]
    assert system.input_size == 6 + COORDINATES.get(kind, 0)


# --- reaction --------------------------------------------------------------------------------------------------------


@every_joint
@every_pair
@property_test(50, seed=seeds, free=free_coordinates)
def test_reaction_is_the_force_on_body_2_and_does_no_work(kind, pair, seed, free):
    """Force and torque about the joint's origin, in W: their power in any motion of body 2 is -(B v)ᵀλ, the
    opposite acts on body 1, and they leave alone what is free."""
    case = make(kind, pair, seed)
    q, v = moving(case, free)
    system = case.system
    multipliers = case.rng.uniform(-10, 10, system.constraint_size)
    force, torque = system.reaction(q, v, multipliers, 0)
    gradient = system.constraints(q, v)[2]
    assert_close(multipliers @ gradient @ v, 0.0, ROUNDING, scale=10)
    velocity, angular = case.rng.uniform(-1, 1, (2, 3))
    for body, sign in zip(pair, (-1, 1), strict=True):  # the opposite acts on body 1
        if body != GROUND:
            twist = case.twist(q, body, velocity, angular, case.acting_point(q))
            power = sign * (force @ velocity + torque @ angular)
            assert_close(power, -multipliers @ gradient @ twist, ROUNDING, scale=10)
    one, two = case.axes(q, 0), case.axes(q, 1)
    if kind == Type.spherical:
        assert_close(torque, np.zeros(3), ROUNDING, scale=10)
    if kind == Type.revolute:
        assert_close(torque @ one[:, 2], 0.0, ROUNDING, scale=10)
    if kind == Type.universal:
        assert_close(torque @ np.column_stack([one[:, 1], two[:, 0]]), np.zeros(2), ROUNDING, scale=10)
    if kind == Type.prismatic:
        assert_close(force @ one[:, 2], 0.0, ROUNDING, scale=10)
    if kind == Type.cylindrical:
        assert_close([force @ one[:, 2], torque @ one[:, 2]], np.zeros(2), ROUNDING, scale=10)
    if kind == Type.planar:
        assert_close([*(force @ one[:, :2]), torque @ one[:, 2]], np.zeros(3), ROUNDING, scale=10)
    if kind == Type.distance:
        rod = case.origin(q, 1) - case.origin(q, 0)
        assert_close([*np.cross(force, rod), *torque], np.zeros(6), ROUNDING, scale=10)
        assert_close(multipliers[0], -force @ rod / LENGTH, ROUNDING, scale=10)  # that of a rod under tension
    if kind == Type.point_on_line:
        assert_close([force @ one[:, 2], *torque], np.zeros(4), ROUNDING, scale=10)
    if kind == Type.screw:
        assert_close(torque @ one[:, 2] + LEAD * force @ one[:, 2], 0.0, ROUNDING, scale=10)
    if kind == Type.constant_velocity:
        assert_close(np.cross(torque, one[:, 2] + two[:, 2]), np.zeros(3), ROUNDING, scale=10)
    if kind == Type.point_in_plane:
        assert_close([*(force @ one[:, :2]), *torque], np.zeros(5), ROUNDING, scale=10)
    if kind == Type.rolling_disk:
        assert_close(torque, np.zeros(3), ROUNDING, scale=10)
        assert_close(multipliers, -one[:, [2, 0, 1]].T @ force, ROUNDING, scale=10)
    if kind == Type.free:
        assert_close([*force, *torque], np.zeros(6), ROUNDING)


@every_joint
@every_pair
@property_test(10, seed=seeds, free=free_coordinates)
def test_reaction_about_another_point_in_other_axes(kind, pair, seed, free):
    """The same pair of force and torque, moved and turned."""
    At, Axes = _core.ReactionAt, _core.ReactionAxes
    case = make(kind, pair, seed)
    q, v = moving(case, free)
    multipliers = case.rng.uniform(-10, 10, case.system.constraint_size)
    force, torque = case.system.reaction(q, v, multipliers, 0)
    for side, at in enumerate((At.frame1, At.frame2)):
        for axes in (Axes.ground, Axes.frame1, Axes.frame2):
            point = case.rng.uniform(-1, 1, 3)
            told = make(kind, pair, seed, _core.Reaction(at, point, axes)).system.reaction(q, v, multipliers, 0)
            place = case.origin(q, side) + case.axes(q, side) @ point
            R = np.eye(3) if axes == Axes.ground else case.axes(q, 0 if axes == Axes.frame1 else 1)
            assert_close(told[0], R.T @ force, ROUNDING, scale=10)
            assert_close(told[1], R.T @ (torque + np.cross(case.acting_point(q) - place, force)), ROUNDING, scale=50)


# --- frames ----------------------------------------------------------------------------------------------------------


@property_test(100, seed=seeds)
def test_axes_with_z(seed):
    z = np.random.default_rng(seed).normal(size=3)
    axes = _core.axes_with_z(3.0 * z)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), rtol=0, atol=8 * EPS)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=8 * EPS)
    np.testing.assert_allclose(axes[:, 2], z / np.linalg.norm(z), rtol=0, atol=4 * EPS)
    np.testing.assert_array_equal(_core.axes_with_z(3.0 * z), axes)


@pytest.mark.parametrize("z", [X, Y, Z, -X, -Y, -Z, X + Y, X + Y + Z])
def test_axes_with_z_along_the_axes_of_the_world(z):
    axes = _core.axes_with_z(z)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), rtol=0, atol=4 * EPS)
    np.testing.assert_allclose(axes[:, 2], z / np.linalg.norm(z), rtol=0, atol=2 * EPS)
    assert np.linalg.det(axes) > 0
