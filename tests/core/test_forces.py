"""Every force element against its model in NumPy: forces, derivatives, balance of forces, moments and power."""

import numpy as np
import pytest

from sigmafmu import _core

from .force_models import BETWEEN, ELEMENTS, GROUND, make_world, sharp_derivative
from .helpers import DIFFERENCES, assert_close, property_test, rotation_of, seeds

every_element = pytest.mark.parametrize("element", ELEMENTS)
everywhere = pytest.mark.parametrize("between", BETWEEN)


def world_of(seed, element, between):
    rng = np.random.default_rng(seed)
    return rng, make_world(rng, ELEMENTS[element], between)


@every_element
@everywhere
@property_test(15, seed=seeds)
def test_forces_are_those_of_the_definition(element, between, seed):
    """Virtual power of the generalized forces for any velocity: that of force and torque on what they act on."""
    rng, world = world_of(seed, element, between)
    own = rng.uniform(-5, 5, world.model.inputs)
    a, b = world.motions(world.q, world.v)
    force, torque = world.model.wrench(world.element, a, b, own)
    forces = world.forces(world.q, world.v, own)
    powers = []
    for velocity in np.eye(len(world.v)):
        one, two = world.motions(world.q, velocity)
        if world.model.single:
            powers.append(force @ two.velocity + torque @ two.w)
            continue
        at_second = one.velocity + np.cross(one.w, b.o - a.o)
        powers.append(force @ (two.velocity - at_second) + torque @ (two.w - one.w))
    assert_close(forces, np.array(powers), 1e-11, np.linalg.norm(force) + np.linalg.norm(torque) + 1)


@every_element
@everywhere
@property_test(15, seed=seeds)
def test_derivatives(element, between, seed):
    """C and K, on rigid bodies, the ground and nodes, against differences of order ten."""
    rng, world = world_of(seed, element, between)
    size = len(world.v)
    own = rng.uniform(-5, 5, world.model.inputs)
    vdot = np.zeros(size)
    system, inputs = world.system, world.inputs(own)
    _, damping, stiffness = system.linearization(world.q, world.v, np.zeros(0), inputs, vdot)

    def residual(x=0.0, dv=0.0):
        return system.residual(system.compose(world.q, x + np.zeros(size)), world.v + dv, vdot, np.zeros(0), inputs)

    scale = np.abs(residual()).max()

    def sharp_jacobian(f):
        return np.column_stack([sharp_derivative(lambda s, e=e: f(s * e), 2e-3) for e in np.eye(size)])

    assert_close(damping, sharp_jacobian(lambda x: residual(dv=x)), DIFFERENCES, scale)
    assert_close(stiffness, sharp_jacobian(lambda x: residual(x=x)), DIFFERENCES, scale)


@every_element
@property_test(50, seed=seeds)
def test_forces_and_moments_on_both_bodies_are_opposite(element, seed):
    if ELEMENTS[element].single:
        return  # which acts on one body
    rng, world = world_of(seed, element, "two bodies")
    forces = world.forces(world.q, world.v, rng.uniform(-5, 5, world.model.inputs)).reshape(2, 6)
    assert np.abs(forces).max() > 0
    places = world.q.reshape(2, 7)
    moments = [np.cross(q[:3], f[:3]) + rotation_of(q).apply(f[3:]) for q, f in zip(places, forces, strict=True)]
    size = np.abs(forces).max() + np.abs(moments).max()
    assert_close(forces[0, :3], -forces[1, :3], 1e-14, size)
    assert_close(moments[0], -moments[1], 1e-14, size)


@every_element
@everywhere
@property_test(25, seed=seeds)
def test_power_is_what_energy_and_losses_leave(element, between, seed):
    """The rate of the stored energy, the lost power and the element's power on its bodies add up to nothing."""
    _, world = world_of(seed, element, between)
    own = np.zeros(world.model.inputs)
    power = world.forces(world.q, world.v, own) @ world.v
    system, still = world.system, np.zeros_like(world.v)

    def stored(t):
        q = system.compose(world.q, t * world.v)
        return system.energy(q, still) - world.bare.energy(q, still)

    lost = world.model.lost(world.element, *world.motions(world.q, world.v))
    size = abs(power) + abs(lost) + abs(stored(0.0)) + np.abs(world.forces(world.q, world.v, own)).max()
    assert_close(sharp_derivative(stored) + lost, -power, 1e-12, size)
    may_drive = element in ("FollowerForce", "TableSpring", "Bearing", "Drag")  # cross-coupling, a medium that flows
    assert lost >= -1e-12 * size or may_drive


@every_element
@property_test(25, seed=seeds)
def test_outputs(element, seed):
    """Energy and power, and what is seen of the force, beside the forces themselves."""
    rng, world = world_of(seed, element, "two bodies")
    mechanism = _core.Mechanism("Outputs")
    mechanism.multibody = world.definition
    outputs = _core.Outputs(mechanism)
    own = rng.uniform(-5, 5, world.model.inputs)
    u = np.zeros(len(outputs.inputs))
    u[[outputs.inputs.index(name) for name in outputs.inputs if name.startswith("element.")]] = own
    values = dict(zip(outputs.names, outputs.values(world.q, world.v, u), strict=True))
    forces = world.forces(world.q, world.v, own)
    size = np.abs(forces).max()
    assert_close(values["element.power"], forces @ world.v, 1e-13, size)
    still = np.zeros_like(world.v)
    stored = world.system.energy(world.q, still) - world.bare.energy(world.q, still)
    if not world.model.single:
        assert_close(values["element.energy"], stored, 1e-14, abs(stored) + 1)
    a, b = world.motions(world.q, world.v)
    force, torque = world.model.wrench(world.element, a, b, np.zeros(world.model.inputs))

    def vector(name):
        return np.array([values[f"element.{name}[{i}]"] for i in (1, 2, 3)])

    gap = b.o - a.o
    if element in ("LineSpring", "TableSpring"):
        length = np.linalg.norm(gap)
        assert_close(values["element.length"], length, 1e-15)
        assert_close(values["element.rate"], gap @ (b.velocity - a.velocity) / length, 1e-14)
        assert_close(values["element.force"], -force @ gap / length, 1e-13, size)
    elif element == "TorsionSpring":
        angle, axis = world.model.twist(a, b)
        assert_close(values["element.angle"], angle, 1e-14)
        assert_close(values["element.angularRate"], axis @ (b.w - a.w), 1e-13)
        assert_close(values["element.torque"], torque @ axis / (axis @ axis), 1e-12, size)
    elif element == "Bushing":
        x, _, _ = world.model.deformation(a, b)
        assert_close(vector("displacement"), x[:3], 1e-14)
        assert_close(vector("rotation"), x[3:], 1e-14)
        assert_close(vector("force"), a.axes.T @ force, 1e-11, size)
        assert_close(vector("torque"), a.axes.T @ torque, 1e-11, size)
    elif element == "Bearing":
        assert_close(vector("displacement"), a.axes.T @ gap, 1e-14)
        assert_close(vector("force"), a.axes.T @ force, 1e-13, size)
    elif element == "FollowerForce":
        assert_close(vector("position"), b.o, 1e-15)
    elif element == "Drag":
        assert_close(vector("force"), force, 1e-13, size)
    elif element == "CloudContact":
        depths = [world.model.geometry(world.element, a, at)[0] for _, _, at in world.model.parts(world.element, a, b)]
        assert_close(values["element.gap"], -max(depths), 1e-14)
        assert_close(values["element.normalForce"], force @ a.axes[:, 2], 1e-12, size)
        assert_close(vector("force"), force, 1e-12, size)
    else:
        depth, normal, *_ = world.model.geometry(world.element, a, b)
        assert_close(values["element.gap"], -depth, 1e-14)
        assert_close(values["element.normalForce"], force @ normal, 1e-12, size)
        assert_close(vector("force"), force, 1e-12, size)


@every_element
@property_test(10, seed=seeds)
def test_newton_and_euler_of_bodies_in_joints(element, seed):
    """Each body's momentum changes by the reactions of its joint, the element and gravity."""
    rng, world = world_of(seed, element, "two bodies")
    definition = world.definition
    definition.gravity = rng.uniform(-10, 10, 3)
    kind = _core.JointType.spherical
    for i in range(2):  # each hangs on the ground where it is
        point = rng.uniform(-0.5, 0.5, 3)
        place = world.q[7 * i : 7 * i + 3] + rotation_of(world.q[7 * i : 7 * i + 7]).apply(point)
        ends = (GROUND, _core.Frame(place, np.eye(3)), i, _core.Frame(point, np.eye(3)))
        definition.add(_core.Joint(f"joint{i}", kind, *ends))
    system = _core.System(definition)
    v = system.project_velocities(world.q, world.v)
    own = rng.uniform(-5, 5, world.model.inputs)
    u = np.zeros(system.input_size)
    u[world.bare.input_size :][: len(own)] = own
    vdot, multipliers = system.accelerations(world.q, v, u)
    a, b = world.motions(world.q, v)
    force, torque = world.model.wrench(world.element, a, b, own)
    for i, body in enumerate(definition.bodies):
        turn = rotation_of(world.q[7 * i : 7 * i + 7])
        w, wdot = v[6 * i + 3 : 6 * i + 6], vdot[6 * i + 3 : 6 * i + 6]
        inertia = np.diag(body.inertia)
        inertia[[0, 0, 1], [1, 2, 2]] = inertia[[1, 2, 2], [0, 0, 1]] = body.inertia_products
        reaction, moment = system.reaction(world.q, v, multipliers, i)
        joint = turn.apply(definition.joints[i].frame2.origin)
        forces = reaction + body.mass * definition.gravity
        moments = moment + np.cross(joint, reaction)
        sign = 1.0 if i == 1 else 0.0 if world.model.single else -1.0
        forces = forces + sign * force
        moments = moments + sign * (torque + np.cross(b.o - world.q[7 * i : 7 * i + 3], force))
        size = np.abs(multipliers).max() + np.linalg.norm(force) + np.linalg.norm(torque)
        assert_close(body.mass * vdot[6 * i : 6 * i + 3], forces, 1e-11, size)
        assert_close(turn.apply(inertia @ wdot + np.cross(w, inertia @ w)), moments, 1e-11, size)
