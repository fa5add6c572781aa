"""Newton's method in a step: the result does not depend on it; modified Newton; steps that fail."""

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    FULL,
    GROUND,
    INCREMENTAL,
    INDEX3,
    MODIFIED,
    RESIDUAL,
    STABILIZED,
    TANGENT_FREE,
    assert_close,
    columns,
    copy,
    reference,
    simulation,
)
from .runs import ITERATIONS, STEPS, TIGHT, every_formulation, every_model

# --- the result does not depend on the iteration ----------------------------------------------------------------------


@every_model
@every_formulation
@pytest.mark.parametrize("sigma", [1.0, 0.0, 1.6])
@pytest.mark.parametrize("iteration", ITERATIONS.values(), ids=ITERATIONS)
def test_residual_corrector_does_not_depend_on_its_iteration(model, formulation, sigma, iteration):
    """200 steps, Newton's tolerance 1e-8 and 1e-12 relative to the velocity.

    A linearly convergent iteration stops on an estimate of its rate and may keep a few tolerances in every step; the
    multipliers see them through 1/h.
    """
    h, _ = STEPS[model]
    for tolerance, allowed in ((1e-8, 1e-7), (1e-12, 1e-9)):
        ends = []
        for chosen in ({}, iteration):
            run = simulation(
                model, formulation=formulation, sigma=sigma, step_size=h, relative_tolerance=tolerance,
                absolute_tolerance=1e-2 * tolerance, **chosen,
            )  # fmt: skip
            run.run(200 * h, 200)
            assert run.state.counters.retries == 0
            ends.append(copy(run.state))
        assert_close(ends[1].q, ends[0].q, allowed)
        assert_close(ends[1].v, ends[0].v, allowed)
        assert_close(ends[1].lambda_, ends[0].lambda_, 30 * allowed)


def test_newton_converges_quadratically():
    """Full matrix, a large step (hω = 0.6): to rounding within 4 iterations; tangent-free it takes more."""
    counts = []
    for jacobian in (FULL, TANGENT_FREE):
        run = simulation("HeavyTop", step_size=4e-3, jacobian=jacobian, **TIGHT)
        run.run(0.4, 100)
        counts.append(run.state.counters.newton_iterations / 100)
    assert counts[0] <= 4.0
    assert counts[1] >= counts[0] + 1


def test_incremental_geom1_approaches_residual_geom1():
    """σ = 0, index 3: both are geom1 but for Eq. (74), T(θ_new) T⁻¹(θ_old) = I, in the printed increments. What it
    leaves is of fourth order, three orders of magnitude below the truncation error."""
    truth = columns(reference("HeavyTop", 0.2, 40), "top.position")[-1]
    distances = []
    for h in (2.5e-4, 1.25e-4, 6.25e-5):
        ends = []
        for corrector in (RESIDUAL, INCREMENTAL):
            run = simulation("HeavyTop", formulation=INDEX3, sigma=0.0, step_size=h, corrector=corrector, **TIGHT)
            run.run(0.2, round(0.2 / h))
            ends.append(run.state.q)
        distances.append(np.abs(ends[0] - ends[1]).max())
        assert distances[-1] <= 1e-3 * np.abs(ends[0][:3] - truth).max()
    np.testing.assert_allclose(np.log2(np.array(distances[:-1]) / distances[1:]), 4.0, rtol=0, atol=0.2)


def test_incremental_corrector_differs_from_the_residual_form():
    """As printed it behaves like σ ≈ 2: less accurate here in stabilized index 2, but of the same order."""
    truth = columns(reference("HeavyTop", 1.0, 1), "top.position")[-1]
    found = []
    for corrector in (RESIDUAL, INCREMENTAL):
        run = simulation("HeavyTop", corrector=corrector, step_size=2.5e-4)
        run.run(1.0, 4000)
        found.append(np.linalg.norm(run.state.q[:3] - truth))
    assert 5 < found[1] / found[0] < 12


# --- modified Newton --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("formulation", [INDEX3, STABILIZED], ids=["index3", "stabilizedIndex2"])
def test_modified_newton_needs_one_matrix_for_a_slow_motion(formulation):
    """A pendulum that swings by 1e-3 rad, and the rotor, whose matrix does not change."""
    mechanism = _core.Mechanism()
    mechanism.multibody.gravity = np.array([0.0, 0.0, -9.81])
    body = _core.RigidBody()
    body.name, body.initial_position = "bob", np.array([0.0, 0.0, -1.0])
    body.initial_velocity, body.initial_angular_velocity = np.array([3e-3, 0, 0]), np.array([0.0, -3e-3, 0.0])
    mechanism.multibody.add(body)
    pin = _core.Frame(np.zeros(3), _core.axes_with_z(np.array([0.0, 1.0, 0.0])))
    arm = _core.Frame(np.array([0.0, 0.0, 1.0]), pin.axes)
    mechanism.multibody.add(_core.Joint("pin", _core.JointType.revolute, GROUND, pin, 0, arm))
    for slow, h in ((mechanism, 1e-2), ("HighSpeedRotor", 1e-5)):
        run = simulation(slow, newton=MODIFIED, formulation=formulation, step_size=h)
        run.run(500 * h, 500)
        assert run.state.counters.jacobian_evaluations == 1
        assert run.state.counters.newton_iterations <= 3 * 500


def test_modified_newton_makes_fewer_matrices():
    """And more iterations; a change of the step size asks for a new matrix."""
    counts = []
    for newton in (FULL, MODIFIED):
        run = simulation("SliderCrank", newton=newton, step_size=1e-3)
        run.run(0.5, 500)
        counts.append(copy(run.state).counters)
    assert counts[0].jacobian_evaluations >= 500
    assert counts[1].jacobian_evaluations <= 250
    assert counts[1].newton_iterations > counts[0].newton_iterations
    before = run.state.counters.jacobian_evaluations
    run.run(0.5005, 1)
    assert run.state.counters.jacobian_evaluations == before + 1


# --- failure ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("h", "retries"), [(0.03, 1), (0.06, 2)])
def test_a_step_that_is_too_large_is_repeated_with_halves(h, retries):
    """hω = 4.5 and 9: the rotation in one step exceeds π and would be ambiguous."""
    run = simulation("HeavyTop", step_size=h)
    run.run(h, 1)
    state = run.state
    assert state.time == h
    assert state.counters.retries >= retries
    assert state.counters.steps >= 2**retries
    truth = columns(reference("HeavyTop", h, 1), "top.position")[-1]
    assert np.linalg.norm(state.q[:3] - truth) < 0.2
    run.run(2 * h, 200)
    assert np.isfinite(state.q).all()


def test_a_step_that_fails_for_good_leaves_the_state_alone():
    """Ten halvings of 100 s still turn the top by more than π."""
    run = simulation("HeavyTop", step_size=100.0)
    before = copy(run.state)
    with pytest.raises(RuntimeError, match="step failed at t = "):
        run.run(100.0, 1)
    for name in ("q", "v", "vdot", "a", "lambda_", "turned"):
        np.testing.assert_array_equal(getattr(run.state, name), getattr(before, name))
    assert run.state.time == 0.0
    assert run.state.counters.steps == 0
    assert run.state.counters.retries == 10


def test_motion_that_is_not_finite_is_not_committed():
    """A force of 1e308 N on one of two free bodies: the other's finite motion must not hide it."""
    mechanism = _core.Mechanism()
    for name in ("pushed", "free"):
        body = _core.RigidBody()
        body.name = name
        mechanism.multibody.add(body)
    run = simulation(mechanism, step_size=10.0)
    force = np.zeros(12)
    force[0] = 1e308
    run.set_input(force, 0 * force, 0.0)
    with pytest.raises(RuntimeError, match="step failed"):
        run.run(1e6, 1)
    assert np.isfinite(run.state.q).all()
