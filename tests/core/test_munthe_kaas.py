"""The Munthe-Kaas methods alone: exactness, projection, and the error control of rkmk54.

Their observed orders are in test_methods.py.
"""

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import EPS, assert_bitwise, copy, rotation_of, simulation
from .methods import FIXED_STEPS, PROBLEMS, RKMK4, RKMK54, SAMPLES, lgt, run_errors

every_group = pytest.mark.parametrize("chosen", lgt().values(), ids=lgt())
every_method = pytest.mark.parametrize("method", [RKMK4, RKMK54], ids=["rkmk4", "rkmk54"])


def adaptive(problem: str, tolerance: float, **settings) -> _core.Simulation:
    chosen = {"relative_tolerance": tolerance, "absolute_tolerance": tolerance, **settings}
    return simulation(PROBLEMS[problem].make(), method=RKMK54, **chosen)


# --- both methods ----------------------------------------------------------------------------------------------------


@every_method
@pytest.mark.parametrize("group", ["R3xSO3 exp", "SE3 exp"])
def test_a_constant_spin_is_exact(method, group):
    """exp makes it a straight line, for any step below half a turn."""
    mechanism = _core.Mechanism()
    body = _core.RigidBody()
    body.name, body.inertia = "wheel", np.array([1.0, 1.0, 1.5])
    body.initial_angular_velocity = np.array([0.0, 0.0, 3.0])
    mechanism.multibody.add(body)
    run = simulation(mechanism, method=method, step_size=1.0, **lgt()[group], **FIXED_STEPS)
    run.run(20.0, 20)
    turn = rotation_of(run.state.q).as_rotvec()
    expected = np.array([0.0, 0.0, 60.0 - 2 * np.pi * round(60.0 / (2 * np.pi))])
    np.testing.assert_allclose(turn, expected, rtol=0, atol=20 * 4 * EPS)
    np.testing.assert_array_equal(run.state.v, [0, 0, 0, 0, 0, 3.0])


@every_method
@every_group
@pytest.mark.parametrize(("model", "h", "steps"), [("HeavyTop", 2e-3, 500), ("SliderCrank", 5e-3, 400)])
def test_constraints_hold_to_rounding_at_both_levels(model, h, steps, method, chosen):
    """After every step, large as it is: the projection iterates to rounding."""
    run = simulation(model, method=method, step_size=h, **chosen, **FIXED_STEPS)
    _, q, v, _ = run.trajectory(steps * h, steps)
    system = _core.System(_core.mechanism(model).multibody)
    worst = np.zeros(2)
    for row in zip(q, v, strict=True):
        phi, rate, _, _ = system.constraints(*row)
        worst = np.maximum(worst, [np.abs(phi).max(), np.abs(rate).max()])
    assert worst[0] <= 16 * EPS
    assert worst[1] <= 16 * EPS * np.abs(v).max()


@every_method
def test_multipliers_and_accelerations_belong_to_the_state(method):
    """They are those of the index-1 form at the projected end of the step."""
    run = simulation("SliderCrank", method=method, step_size=1e-3, **FIXED_STEPS)
    run.run(0.1, 100)
    system, state = _core.System(_core.mechanism("SliderCrank").multibody), run.state
    vdot, multipliers = system.accelerations(state.q, state.v, np.zeros(system.input_size))
    np.testing.assert_allclose(state.vdot, vdot, rtol=0, atol=1e-12 * np.abs(vdot).max())
    np.testing.assert_allclose(state.lambda_, multipliers, rtol=0, atol=1e-12 * np.abs(multipliers).max())


@pytest.mark.parametrize("halvings", [1, 3, 10])
def test_a_step_that_turns_too_far_is_halved(halvings):
    """rkmk4: 9 rad in a step asks for two halvings at least."""
    run = simulation("HeavyTop", method=RKMK4, step_size=0.06, max_halvings=halvings)
    if halvings == 1:
        with pytest.raises(RuntimeError, match="step failed at t = "):
            run.run(0.06, 1)
        assert (run.state.time, run.state.counters.steps, run.state.counters.retries) == (0.0, 0, 1)
    else:
        run.run(0.06, 1)
        assert run.state.time == 0.06
        assert run.state.counters.steps >= 4
        assert run.state.counters.retries >= 2


# --- the error control of rkmk54 -------------------------------------------------------------------------------------

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
CONTROLLED = {"FreeBody": 3.0, "HeavyTop": 0.1, "SliderCrank": 0.8}  # s


@pytest.mark.parametrize("problem", CONTROLLED)
@every_group
def test_error_goes_with_the_tolerance(problem, chosen):
    """It is a tolerance on the velocities of each step. Those of the whole motion stay within 150 times it (90 for
    FreeBody, which amplifies them e-fold every third of a second) and shrink with it: a step's error in θ/h is of
    fourth order, the motion's of fifth, hence with tolerance^(5/4), or ^1 where V decides."""
    stop = CONTROLLED[problem]
    truth, found, steps = PROBLEMS[problem].solution(stop, SAMPLES), [], []
    for tolerance in TOLERANCES:
        run = adaptive(problem, tolerance, step_size=stop / SAMPLES, **chosen)
        _, q, v, multipliers = run.trajectory(stop, SAMPLES)
        error = PROBLEMS[problem].errors(truth, q, v, multipliers)
        found.append(max(error["velocity"], error["angularVelocity"]))
        steps.append(run.state.counters.steps)
        assert found[-1] <= 150 * tolerance
    slopes = np.log10(np.array(found[1:-1]) / found[2:]) / 2
    assert ((slopes >= 0.85) & (slopes <= 1.5)).all()
    assert (np.diff(steps) > 0).all()
    np.testing.assert_allclose(np.log10(steps[-1] / steps[-2]) / 2, 0.225, rtol=0, atol=0.035)  # 1/5 to 1/4


@pytest.mark.parametrize("problem", CONTROLLED)
def test_the_largest_step_does_not_matter_when_the_tolerance_rules(problem):
    """integrator.stepSize is an upper limit: 8, 16 or 32 of them make the same number of steps and the same error."""
    stop = CONTROLLED[problem]
    truth, found, steps = PROBLEMS[problem].solution(stop, SAMPLES), [], []
    for count in (8, 16, 32):
        run = adaptive(problem, 1e-10, step_size=stop / count, group=2)
        _, q, v, multipliers = run.trajectory(stop, count)
        at = slice(None, None, count // SAMPLES)
        found.append(PROBLEMS[problem].errors(truth, q[at], v[at], multipliers[at]))
        steps.append(run.state.counters.steps)
    assert max(steps) <= 1.1 * min(steps) + 32
    for kind, error in found[0].items():
        assert max(f[kind] for f in found) <= 2 * error, kind


@pytest.mark.parametrize("problem", PROBLEMS)
def test_it_makes_reference_solutions(problem):
    """To eleven digits and more, on either group."""
    stop, _ = PROBLEMS[problem].ranges[RKMK54]
    truth = PROBLEMS[problem].solution(stop, SAMPLES)
    for group in (1, 2):
        run = adaptive(problem, 1e-12, step_size=stop / SAMPLES, group=group)
        _, q, v, multipliers = run.trajectory(stop, SAMPLES)
        error = PROBLEMS[problem].errors(truth, q, v, multipliers)
        assert max(error["position"], error["orientation"]) <= 1e-11
        assert max(error["velocity"], error["angularVelocity"]) <= 1e-11 * (1 + np.abs(v).max())


def test_fixed_steps_are_those_that_are_asked_for():
    """When nothing exceeds the tolerance: seven stages each, none repeated."""
    coarse = run_errors(PROBLEMS["FreeBody"], 1.0, 8, method=RKMK54, **FIXED_STEPS)
    fine = run_errors(PROBLEMS["FreeBody"], 1.0, 80, method=RKMK54, **FIXED_STEPS)
    assert coarse["orientation"] > 1e4 * fine["orientation"]
    for method, stages in ((RKMK4, 4), (RKMK54, 7)):
        run = simulation(PROBLEMS["FreeBody"].make(), method=method, step_size=0.1, **FIXED_STEPS)
        run.run(1.0, 10)
        counters = run.state.counters
        assert (counters.steps, counters.retries, counters.newton_iterations) == (10, 0, 0)
        assert counters.jacobian_evaluations == 10 * stages


def test_rejected_steps_are_counted():
    """A first step of half a second is far too long. A rejected step costs six stages, an accepted one seven."""
    run = adaptive("FreeBody", 1e-9, step_size=0.5)
    run.run(2.0, 4)
    counters = run.state.counters
    assert counters.retries >= 2
    assert counters.steps > 20
    assert counters.jacobian_evaluations == 7 * counters.steps + 6 * counters.retries
    rejected = counters.retries
    run.run(2.5, 1)  # the step size is known now
    assert run.state.counters.retries <= rejected + 1


def test_a_tolerance_that_cannot_be_met_fails():
    """Rounding alone is larger. The step size goes down to 2⁻¹⁰ of the interval, and the state stays where it was."""
    run = simulation("HeavyTop", method=RKMK54, step_size=1e-3, relative_tolerance=0.0, absolute_tolerance=1e-18)
    before = copy(run.state)
    with pytest.raises(RuntimeError, match="step failed at t = "):
        run.run(1e-3, 1)
    for name in ("time", "q", "v", "vdot", "lambda_", "turned"):
        np.testing.assert_array_equal(getattr(run.state, name), getattr(before, name))
    counters = run.state.counters
    assert counters.steps == 0
    assert 1 <= counters.retries <= 10  # each divides by 5 at most


def test_retries_are_limited_by_max_halvings():
    for halvings in (0, 3):
        run = adaptive("HeavyTop", 1e-18, step_size=1e-3, max_halvings=halvings)
        with pytest.raises(RuntimeError, match="step failed"):
            run.run(1e-3, 1)
        assert run.state.counters.retries <= halvings
    assert run.state.counters.retries > 0


@pytest.mark.parametrize("cut", [0.0123, 0.05, 0.0999])
def test_the_next_step_size_is_in_the_state(cut):
    """A run that is interrupted and goes on in another instance, wherever it has been cut, is one run."""
    one, two = (adaptive("HeavyTop", 1e-9, step_size=0.1, group=2) for _ in range(2))
    one.run(cut, 1)
    saved = copy(one.state)
    one.run(0.2, 1)
    two.run(0.03, 7)  # has a step size of its own in mind
    two.state = copy(saved)
    two.run(0.2, 1)
    assert_bitwise(two.state, one.state)
    forgetful = adaptive("HeavyTop", 1e-9, step_size=0.1, group=2)
    for name in ("time", "q", "v", "vdot", "lambda_"):
        setattr(forgetful.state, name, getattr(saved, name))
    forgetful.run(0.2, 1)
    assert forgetful.state.counters.retries > one.state.counters.retries - saved.counters.retries


def test_steps_follow_the_motion():
    """A top that spins four times as fast asks for steps about a quarter as long."""
    counts = []
    for spin in (50.0, 200.0):
        mechanism = _core.mechanism("HeavyTop")
        body = mechanism.multibody.body(0)
        body.initial_angular_velocity = np.array([0.0, spin, -4.61538])
        run = simulation(mechanism, method=RKMK54, group=2, step_size=0.2, relative_tolerance=1e-7)
        run.run(0.2, 1)
        counts.append(run.state.counters.steps)
    assert 2 <= counts[1] / counts[0] <= 8
