"""Runs of the generalized-alpha method: inputs and determinism."""

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    BODIES,
    EPS,
    GROUND,
    INCREMENTAL,
    INDEX3,
    MODIFIED,
    TANGENT_FREE,
    Rotation,
    assert_bitwise,
    copy,
    simulation,
)
from .methods import BLIEDF2, GENERALIZED_ALPHA
from .runs import STEPS, every_model

# --- inputs -----------------------------------------------------------------------------------------------------------


def test_constant_force_is_integrated_exactly():
    """A free body: x = ½ f/m t², v = f/m t."""
    mechanism = _core.Mechanism()
    body = _core.RigidBody()
    body.name, body.mass = "mass", 2.0
    mechanism.multibody.add(body)
    run = simulation(mechanism, step_size=0.01)
    run.set_input(np.array([3.0, -1.0, 0.5, 0, 0, 0]), np.zeros(6), 0.0)
    run.start()
    run.run(1.0, 100)
    acceleration = np.array([1.5, -0.5, 0.25])
    np.testing.assert_allclose(run.state.q[:3], acceleration / 2, rtol=1e-13)
    np.testing.assert_allclose(run.state.v[:3], acceleration, rtol=1e-13)
    np.testing.assert_allclose(run.state.vdot[:3], acceleration, rtol=1e-13)


def wheel() -> _core.Mechanism:
    """On an axle, with a moment of inertia of 0.5 kg m²."""
    mechanism = _core.Mechanism()
    body = _core.RigidBody()
    body.name, body.inertia = "wheel", np.array([1.0, 1.0, 0.5])
    mechanism.multibody.add(body)
    frame = _core.Frame(np.zeros(3), np.eye(3))
    mechanism.multibody.add(_core.Joint("axle", _core.JointType.revolute, GROUND, frame, 0, frame))
    return mechanism


@pytest.mark.parametrize("rho", [1.0, 0.5])
def test_growing_torque_is_integrated_to_second_order(rho):
    """About a principal axis, J φ'' = k t from rest: φ = k t³ / (6 J), over several turns."""
    found = []
    for steps in (50, 100, 200):
        mechanism = wheel()
        run = simulation(mechanism, spectral_radius=rho, step_size=2 / steps)
        slope = np.zeros(7)
        slope[_core.System(mechanism.multibody).motor_index(0)] = 9.0
        run.set_input(0 * slope, slope, 0.0)
        run.start()
        run.run(2.0, steps)
        found.append(abs(run.state.turned[0] - 9.0 * 2.0**3 / 6 / 0.5))
    np.testing.assert_allclose(np.log2(np.array(found[:-1]) / found[1:]), 2.0, atol=0.1)


@pytest.mark.parametrize("method", [GENERALIZED_ALPHA, BLIEDF2])
def test_inputs_may_jump_in_mid_run(method):
    """A wheel on an axle: its torque jumps at 0.5 s; J φ'' = τ."""
    found = []
    for steps in (20, 40, 80):
        mechanism = wheel()
        mechanism.multibody.add(_core.SpringDamper("s", GROUND, np.ones(3), 0, np.ones(3), np.full(3, 5.0), np.ones(3)))
        run = simulation(mechanism, step_size=0.5 / steps, method=method)
        u = np.zeros(_core.System(mechanism.multibody).input_size)
        run.run(0.5, steps)
        u[_core.System(mechanism.multibody).motor_index(0)] = 3.0
        run.set_input(u, 0 * u, 0.5)
        run.run(1.0, steps)
        found.append(run.state.turned[0])
    differences = np.abs(np.diff(found))
    assert np.log2(differences[0] / differences[1]) == pytest.approx(2.0, abs=0.25)


def test_input_of_wrong_size_is_refused():
    run = simulation("HeavyTop")
    with pytest.raises(ValueError, match="wrong size"):
        run.set_input(np.zeros(5), np.zeros(6), 0.0)


# --- determinism ------------------------------------------------------------------------------------------------------

VARIANTS = {
    "default": {},
    "index 3, modified": {"formulation": INDEX3, "newton": MODIFIED},
    "incremental": {"corrector": INCREMENTAL, "sigma": 0.7},
    "sigma 0, tangent-free": {"sigma": 0.0, "jacobian": TANGENT_FREE},
    "modified": {"newton": MODIFIED},
}
every_variant = pytest.mark.parametrize("chosen", VARIANTS.values(), ids=VARIANTS)


@every_model
@every_variant
def test_the_same_run_gives_the_same_bits(model, chosen):
    h, _ = STEPS[model]
    one, two = (simulation(model, step_size=h, **chosen) for _ in range(2))
    one.advance(h, 100)
    for _ in range(100):  # step by step
        two.advance(h, 1)
    assert_bitwise(one.state, two.state)


@every_model
@every_variant
def test_rollback_is_bitwise(model, chosen):
    """Save, 100 steps, restore, 100 steps, also into another instance. Modified Newton's matrix is in the state."""
    h, before = STEPS[model]
    one, two = (simulation(model, step_size=h, **chosen) for _ in range(2))
    one.run(before * h, before)
    saved = copy(one.state)
    one.run((before + 100) * h, 100)
    first = copy(one.state)
    for run in (one, two):
        run.state = copy(saved)
        assert_bitwise(run.state, saved)
        run.run((before + 100) * h, 100)
        assert_bitwise(run.state, first)


def test_a_failed_step_leaves_no_trace():
    """The same bits after a step that was refused."""
    one, two = (simulation("HeavyTop", step_size=1e-3) for _ in range(2))
    one.run(0.05, 50)
    two.run(0.05, 50)
    saved = copy(two.state)
    with pytest.raises(RuntimeError, match="step failed"):
        two.run(100.0, 1)
    two.state = saved
    one.run(0.1, 50)
    two.run(0.1, 50)
    assert_bitwise(one.state, two.state)


@every_model
def test_quaternions_stay_unit(model):
    h, _ = STEPS[model]
    run = simulation(model, step_size=h)
    run.run(2000 * h, 2000)
    lengths = np.linalg.norm(run.state.q.reshape(-1, 7)[:, 3:], axis=1)
    np.testing.assert_allclose(lengths, np.ones(len(BODIES[model])), rtol=0, atol=2 * EPS)
    assert Rotation.from_quat(run.state.q[3:7], scalar_first=True).magnitude() <= np.pi
