"""Tendons: derivatives, power, closed forms, what is refused."""

import re

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import COORDINATES, DIFFERENCES, assert_close, derivative, jacobian, property_test, random_tree, seeds
from .test_couplings import coordinates_of, run, wheels
from .test_flexible import make_tree
from .test_joint_types import assert_second_order, mechanism

Term = _core.TendonTerm


def with_tendon(rng, definition):
    """A tendon over up to three coordinates; None where there are none."""
    at = coordinates_of(definition)
    if not at:
        return None
    chosen = [at[i] for i in rng.permutation(len(at))[:3]]
    terms = [Term(j, rng.uniform(0.2, 1.0) * rng.choice([-1, 1]), k) for j, k in chosen]
    tendon = _core.Tendon("tendon", terms, *rng.uniform(1, 5, 3))
    definition.add(tendon)
    return tendon


def rigid(seed):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, joint_springs=False)
    return rng, tree, with_tendon(rng, tree.definition)


def flexible(seed):
    rng, tree = make_tree(seed)
    return rng, tree, with_tendon(rng, tree.definition)


every_tree = pytest.mark.parametrize("make", [rigid, flexible], ids=["rigid", "at nodes"])


@every_tree
@property_test(40, seed=seeds)
def test_matrices_are_derivatives_of_the_residual(make, seed):
    rng, tree, tendon = make(seed)
    if tendon is None:
        return
    system, q = _core.System(tree.definition), tree.q
    size = system.velocity_size
    v, vdot = rng.uniform(-1, 1, (2, size))
    multipliers, inputs = np.zeros(system.constraint_size), rng.uniform(-5, 5, system.input_size)
    _, damping, stiffness = system.linearization(q, v, multipliers, inputs, vdot)

    def residual(x=0.0, dv=0.0):
        return system.residual(system.compose(q, x + np.zeros(size)), v + dv, vdot, multipliers, inputs)

    scale = np.abs(residual()).max()
    assert_close(damping, jacobian(lambda x: residual(dv=x), size), DIFFERENCES, scale)
    assert_close(stiffness, jacobian(lambda x: residual(x=x), size), 10 * DIFFERENCES, scale)


@every_tree
@property_test(40, seed=seeds)
def test_its_share_is_its_tension_along_every_coordinate(make, seed):
    """Virtual work: the forces it adds do -N c_i x_i', N = k (L - L0) + d L' + input, and E' is that of k alone."""
    rng, tree, tendon = make(seed)
    if tendon is None:
        return
    system, q = _core.System(tree.definition), tree.q
    v = system.project_velocities(q, rng.uniform(-1, 1, system.velocity_size))
    zero, multipliers = np.zeros(system.velocity_size), np.zeros(system.constraint_size)
    inputs = np.zeros(system.input_size)
    motors = sum(COORDINATES.get(joint.type, 0) for joint in tree.definition.joints)
    own = system.input_size - motors - 1 - 3 * len(tree.definition.rotation_motors)
    inputs[own] = 3.0
    values = [system.coordinate(q, v, t.joint, t.coordinate) for t in tendon.terms]
    length, rate = (sum(t.coefficient * x[i] for t, x in zip(tendon.terms, values, strict=True)) for i in (0, 1))
    tension = tendon.stiffness * (length - tendon.free_length) + tendon.damping * rate + 3.0

    def forces(stiffness, damping, force):
        tendon.stiffness, tendon.damping, inputs[own] = stiffness, damping, force
        changed = _without(tree)
        changed.add(tendon)
        return _core.System(changed), _core.System(changed).residual(q, v, zero, multipliers, inputs)

    k, d = tendon.stiffness, tendon.damping
    pulling, with_it = forces(k, d, 3.0)
    _, without = forces(0.0, 0.0, 0.0)
    assert_close((with_it - without) @ v, tension * rate, 1e-12, 10 + np.abs(v).max() * abs(tension))
    systems = pulling, _core.System(_without(tree))
    energy = [derivative(lambda t, s=s: s.energy(s.compose(q, t * v), v), 5e-4) for s in systems]
    stored = k * (length - tendon.free_length) * rate
    assert_close(energy[0] - energy[1], stored, 1e-8, 10)


def _without(tree):
    """The same without its tendon."""
    changed = _core.Multibody()
    changed.gravity = tree.definition.gravity
    for name in ("bodies", "joints", "spring_dampers", "loads", "joint_springs"):
        for part in getattr(tree.definition, name):
            changed.add(part)
    return changed


# --- runs ------------------------------------------------------------------------------------------------------------


def belt(*moments, **numbers):
    terms = [Term(0, 0.1), Term(1, -0.2)]
    return mechanism(*wheels(*moments), _core.Tendon("belt", terms, **numbers))


def test_a_belt_between_two_wheels():
    """x = L: x'' = -(k x + d x') (r1^2/J1 + r2^2/J2), over more than a turn of both."""
    k, d, J = 300.0, 1.0, (0.05, 0.1)
    compliance = 0.1**2 / J[0] + 0.2**2 / J[1]
    w, decay = np.sqrt(k * compliance), d * compliance / 2
    wd, start = np.sqrt(w**2 - decay**2), 10.0
    x = 0.1 * start / wd * np.exp(-decay) * np.sin(wd)
    rate = 0.1 * start / wd * np.exp(-decay) * (wd * np.cos(wd) - decay * np.sin(wd))
    # J1 w1/r1 + J2 w2/r2 is kept
    kept = J[0] * start / 0.1
    one = (rate + 0.2**2 / J[1] * kept) / (0.1 + 0.1 * (0.2**2 / J[1]) * (J[0] / 0.1**2))
    names = ["belt.length", "belt.rate", "axle0.angularRate", "belt.force", "belt.energy", "belt.power"]
    tension = k * x + d * rate
    expected = [x, rate, one, tension, k * x * x / 2, -tension * rate]
    make = lambda: belt(*J, stiffness=k, damping=d)  # noqa: E731
    assert_second_order(make, {"axle0.initialAngularRate": start}, names, expected, 1.0, 1e-3)


def test_an_actuator_pulls_both_wheels():
    slave = run(belt(0.05, 0.1), 1000, 1e-3, belt__actuatorForce=20.0)
    assert slave.get("axle0.angle") == pytest.approx(-0.5 * 20 * 0.1 / 0.05, rel=1e-10)
    assert slave.get("axle1.angle") == pytest.approx(0.5 * 20 * 0.2 / 0.1, rel=1e-10)
    assert slave.get("belt.power") == pytest.approx(-20 * slave.get("belt.rate"), rel=1e-12)
    slave.set("belt.stiffness", 10.0)
    slave.set("belt.freeLength", slave.get("belt.length") - 1)
    slave.set("belt.actuatorForce", 0.0)
    assert slave.get("belt.force") == pytest.approx(10.0, rel=1e-12)
    slave.set("belt.coefficient[2]", 0.1)
    wound = 0.1 * slave.get("axle0.angle") + 0.1 * slave.get("axle1.angle")
    assert slave.get("belt.length") == pytest.approx(wound, rel=1e-12)


# --- definitions -----------------------------------------------------------------------------------------------------


def test_written_and_read_they_are_the_same():
    text = _core.to_json(belt(0.1, 0.2, stiffness=3.0, free_length=-0.5))
    again = _core.from_json(text)
    assert _core.to_json(again) == text
    assert [t.coefficient for t in again.multibody.tendons[0].terms] == [0.1, -0.2]


REFUSED = {
    "no terms": ([], "t runs over no coordinates; there must be at least one."),
    "no joint": ([Term(4)], "t acts on joint 4; allowed are 0 to 1."),
    "zero": ([Term(0, 0.0)], "Coefficient 1 of t is 0; it must be finite, and not 0."),
    "nan": ([Term(0), Term(1, np.nan)], "Coefficient 2 of t is nan; it must be finite, and not 0."),
    "twice": ([Term(0), Term(0, 2.0)], "t has two terms of the same coordinate of axle0; one is allowed."),
}


@pytest.mark.parametrize(("terms", "message"), REFUSED.values(), ids=REFUSED)
def test_tendons_that_make_no_sense_are_refused(terms, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        mechanism(*wheels(0.1, 0.1), _core.Tendon("t", terms)).validate()
