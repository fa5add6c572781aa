"""The sigma-modified generalized-alpha method: its parameters and the equations that a step solves.

Equation numbers are those of Holzinger, Arnold, Gerstmayr (2025).
"""

import numpy as np
import pytest
from hypothesis import strategies as st

from sigmafmu import _core
from sigmafmu._core import lie

from .helpers import (
    EPS,
    GROUND,
    INCREMENTAL,
    INDEX2,
    INDEX3,
    RESIDUAL,
    STABILIZED,
    assert_close,
    block_diag,
    copy,
    derivative,
    mass_matrix,
    property_test,
    rotation_of,
    simulation,
)
from .runs import STEPS, TIGHT, every_formulation, every_model

# --- parameters -------------------------------------------------------------------------------------------------------


@property_test(100, rho=st.one_of(st.sampled_from([0.0, 0.5, 0.9, 1.0]), st.floats(0.0, 1.0)))
def test_parameters(rho):
    """Chung and Hulbert (1993), Eqs. (22)-(25) there: second order, and unconditionally stable."""
    p = _core.AlphaParameters(rho)
    expected = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    np.testing.assert_allclose([p.alpha_m, p.alpha_f], expected, rtol=4 * EPS, atol=2 * EPS)
    assert p.gamma == pytest.approx(0.5 - p.alpha_m + p.alpha_f, rel=4 * EPS)
    assert p.beta == pytest.approx((1 - p.alpha_m + p.alpha_f) ** 2 / 4, rel=4 * EPS)
    assert p.alpha_m <= p.alpha_f + EPS <= 0.5 + 2 * EPS
    assert p.beta >= 0.25 + (p.alpha_f - p.alpha_m) / 2 - EPS


def test_parameters_of_the_trapezoidal_rule():
    p = _core.AlphaParameters(1.0)
    assert (p.alpha_m, p.alpha_f, p.beta, p.gamma) == (0.5, 0.5, 0.25, 0.5)


def oscillator(stiffness, **settings):
    """A mass of 1 kg on a spring."""
    mechanism = _core.Mechanism()
    body = _core.RigidBody()
    body.name = "mass"
    mechanism.multibody.add(body)
    zero = np.zeros(3)
    mechanism.multibody.add(_core.SpringDamper("spring", GROUND, zero, 0, zero, np.full(3, stiffness), zero))
    return simulation(mechanism, **settings)


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.5, 0.65, 0.8, 0.9, 1.0])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0, 1e5])
def test_amplification_of_an_oscillator(rho, ratio):
    """One step is linear in (x, v, v', a): its spectral radius never exceeds 1 and tends to ρ∞ for hω → ∞."""
    h = 1e-2
    mass = oscillator((ratio / h) ** 2, spectral_radius=rho, step_size=h, **TIGHT)
    size = np.array([1.0, ratio / h, (ratio / h) ** 2, (ratio / h) ** 2])  # of x, v, v', a in an oscillation
    step = []
    for x, v, vdot, a in np.diag(size):
        mass.state.time, mass.state.q = 0.0, np.array([x, 0, 0, 1, 0, 0, 0])
        mass.state.v, mass.state.vdot, mass.state.a = (np.array([y, 0, 0, 0, 0, 0]) for y in (v, vdot, a))
        mass.run(h, 1)
        new = mass.state
        step.append(np.array([new.q[0], new.v[0], new.vdot[0], new.a[0]]) / size)
    radius = np.abs(np.linalg.eigvals(np.array(step))).max()
    assert radius <= 1 + 1e-4  # the threefold eigenvalue at infinity: ε^(1/3)
    if ratio == 1e5:
        assert radius == pytest.approx(rho, abs=1e-2)
    if rho == 1.0:
        assert radius == pytest.approx(1.0, abs=1e-4)


# --- the equations of the method --------------------------------------------------------------------------------------


def increments(q0, q1):
    """θ of every body with q1 = q0 ∘ exp(θ)."""
    parts = []
    for one, two in zip(q0.reshape(-1, 7), q1.reshape(-1, 7), strict=True):
        parts += [*(two[:3] - one[:3]), *(rotation_of(one).inv() * rotation_of(two)).as_rotvec()]
    return np.array(parts)


def by_body(operator, theta):
    """block_diag(I, operator(θ_r)) over all bodies."""
    return block_diag(*(part for rotation in theta.reshape(-1, 6)[:, 3:] for part in (np.eye(3), operator(rotation))))


@every_model
@every_formulation
@pytest.mark.parametrize("sigma", [1.0, 0.0, 0.7, 1.6, -0.5])
@pytest.mark.parametrize("rho", [0.9, 0.5, 0.0])
def test_residual_corrector_solves_the_equations_of_the_method(model, formulation, sigma, rho):
    """Eqs. (11)-(20) for the state before and after a step, with T from the closed form."""
    h, before = STEPS[model]
    run = simulation(
        model, formulation=formulation, sigma=sigma, spectral_radius=rho, step_size=h, corrector=RESIDUAL, **TIGHT
    )
    run.run(before * h, before)
    old = copy(run.state)
    run.run((before + 1) * h, 1)
    new = run.state
    definition = _core.mechanism(model).multibody
    system, p = _core.System(definition), _core.AlphaParameters(rho)
    acceleration = np.abs(new.a).max()

    assert_close(new.v, old.v + h * ((1 - p.gamma) * old.a + p.gamma * new.a), 1e-13)  # (14)
    assert_close(  # (15)
        (1 - p.alpha_m) * new.a + p.alpha_m * old.a,
        (1 - p.alpha_f) * new.vdot + p.alpha_f * old.vdot,
        1e-13,
        acceleration,
    )
    theta = increments(old.q, new.q)  # (11)
    theta_dot = by_body(lie.tangent_inverse, theta) @ new.v  # (16)
    eta = (  # (12) with (13): what is left is h T⁻¹ B(q_n)ᵀ η
        h * old.v
        + sigma * h * p.beta / p.gamma * (theta_dot - new.v)
        + h * h * ((0.5 - p.beta) * old.a + p.beta * new.a)
        - theta
    )
    gradient = system.constraints(old.q, old.v)[2]
    allowed = 1e-14 + 8 * EPS * np.abs(old.q).max() + 1e-13 * h * np.abs(new.v).max()
    if formulation == STABILIZED and len(gradient):
        eta = by_body(lie.tangent, theta) @ eta
        eta = eta - gradient.T @ np.linalg.lstsq(gradient.T, eta)[0]
    assert np.abs(eta).max() <= allowed  # (20)

    inputs = np.zeros(system.input_size)
    residual = system.residual(new.q, new.v, new.vdot, new.lambda_, inputs)  # (17)
    force = np.abs(mass_matrix(definition) @ new.vdot).max() + np.abs(new.lambda_).max(initial=0.0)
    # Newton's last increment of the velocities, at most 1e-13 |v|, times β'/γ' M
    assert np.abs(residual).max() <= 1e-11 * (force + np.abs(new.v).max() / h)
    phi, rate, _, _ = system.constraints(new.q, new.v)
    if formulation != INDEX2:
        assert np.abs(phi).max(initial=0.0) <= 1e-14  # (18)
    if formulation != INDEX3:
        assert np.abs(rate).max(initial=0.0) <= 1e-13 * (1 + np.abs(new.v).max())  # (19)


def printed_algorithm(system, mass, state, h, rho, sigma, stabilized, iterations):
    """Algorithm 1 (σ = 1), 2 (σ ≠ 1) or 3 (stabilized index 2, σ = 1) as printed, dense, without any scaling.

    Line 6 has hβ/γ; D.2's third column is made of B(q_n)ᵀ, as lines 15 and 16 of Algorithm 3.
    """
    p = _core.AlphaParameters(rho)
    beta_prime = (1 - p.alpha_m) / (h * h * p.beta * (1 - p.alpha_f))
    gamma_prime = p.gamma / (h * p.beta)
    epsilon_prime = (1 - p.alpha_m) / (h * p.gamma * (1 - p.alpha_f))
    n, m = system.velocity_size, system.constraint_size
    inputs, multipliers, vdot = np.zeros(system.input_size), np.zeros(m), np.zeros(n)
    start = system.constraints(state.q, state.v)[2]
    a = (p.alpha_f * state.vdot - p.alpha_m * state.a) / (1 - p.alpha_m)
    v = state.v + h * (1 - p.gamma) * state.a + h * p.gamma * a
    theta = h * state.v + h * h * ((0.5 - p.beta) * state.a + p.beta * a)
    hat = block_diag(*(block_diag(np.zeros((3, 3)), lie.hat(w)) for w in v.reshape(-1, 6)[:, 3:]))
    theta = theta - sigma * h * p.beta / p.gamma * hat @ theta
    q = system.compose(state.q, theta)

    def inverse_of_p(theta):
        return np.linalg.inv(sigma * np.eye(n) + (1 - sigma) * by_body(lie.tangent, theta))

    for _ in range(iterations):
        phi, rate, gradient, rate_gradient = system.constraints(q, v)
        _, damping, stiffness = system.linearization(q, v, multipliers, inputs)
        star = beta_prime * mass + gamma_prime * damping
        zero = np.zeros((m, m))
        right = [system.residual(q, v, vdot, multipliers, inputs), phi]
        if stabilized:
            matrix = [
                [star + stiffness, gradient.T, star @ start.T / gamma_prime],
                [gradient, zero, zero],
                [rate_gradient + gamma_prime * gradient, zero, gradient @ start.T],
            ]
            right.append(rate)
        else:
            matrix = [[star @ inverse_of_p(theta) + stiffness, gradient.T], [gradient, zero]]
        x = -np.linalg.solve(np.block(matrix), np.concatenate(right))
        dq, multipliers = x[:n], multipliers + x[n : n + m]
        if sigma == 1.0:
            q, scale = system.compose(q, dq), np.eye(n)
        else:
            theta = theta + by_body(lie.tangent_inverse, theta) @ dq
            q, scale = system.compose(state.q, theta), inverse_of_p(theta)
        v, vdot = v + gamma_prime * scale @ dq, vdot + beta_prime * scale @ dq
        if stabilized:
            v, vdot = v + start.T @ x[n + m :], vdot + epsilon_prime * start.T @ x[n + m :]
    return q, v, vdot, a + (1 - p.alpha_f) / (1 - p.alpha_m) * vdot, multipliers


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
@pytest.mark.parametrize(
    ("formulation", "sigma"), [(INDEX3, 1.0), (INDEX3, 0.7), (STABILIZED, 1.0)], ids=["Alg. 1", "Alg. 2", "Alg. 3"]
)
@pytest.mark.parametrize("rho", [0.9, 0.6])
def test_incremental_corrector_is_the_printed_algorithm(model, formulation, sigma, rho):
    """The same number of iterations of a dense copy; they may differ by a matrix that is kept for the last of them."""
    h, before = STEPS[model]
    chosen = {"formulation": formulation, "sigma": sigma, "spectral_radius": rho, "step_size": h}
    run = simulation(model, corrector=INCREMENTAL, **chosen, **TIGHT)
    run.run(before * h, before)
    definition = _core.mechanism(model).multibody
    system, mass = _core.System(definition), mass_matrix(definition)
    old, spent = copy(run.state), run.state.counters.newton_iterations
    run.run((before + 1) * h, 1)
    new, iterations = run.state, run.state.counters.newton_iterations - spent
    q, v, vdot, a, multipliers = printed_algorithm(
        system, mass, old, h, rho, sigma, formulation == STABILIZED, iterations
    )
    assert_close(new.q, q, 1e-11)
    assert_close(new.v, v, 1e-9)
    assert_close(new.vdot, vdot, 1e-7)
    assert_close(new.a, a, 1e-7)
    assert_close(new.lambda_, multipliers, 1e-7)


@every_model
@pytest.mark.parametrize("rho", [1.0, 0.9, 0.3])
def test_initial_algorithmic_acceleration(model, rho):
    """a_0 = v'(t_0 + (α_m - α_f) h) to first order, with v'' from the index-1 equations along the true motion."""
    h, _ = STEPS[model]
    run = simulation(model, spectral_radius=rho, step_size=h)
    system, p, state = _core.System(_core.mechanism(model).multibody), _core.AlphaParameters(rho), run.state
    inputs = np.zeros(system.input_size)

    def acceleration(t):  # q to second order in t, which is enough for the derivative at 0
        q = system.compose(state.q, t * state.v + 0.5 * t * t * state.vdot)
        return system.accelerations(q, state.v + t * state.vdot, inputs)[0]

    jerk = derivative(acceleration, h=1e-3 / max(1.0, np.abs(state.v).max()))
    expected = state.vdot + (p.alpha_m - p.alpha_f) * h * jerk
    assert_close(state.a, expected, 1e-7, np.abs(state.vdot).max())
    assert_close(acceleration(0.0), state.vdot, 1e-13, np.abs(state.vdot).max())


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
@pytest.mark.parametrize("formulation", [INDEX2, STABILIZED], ids=["index2", "stabilizedIndex2"])
def test_small_steps_do_not_spoil_the_multipliers(model, formulation):
    """The Newton system is scaled with βh²: down to a nanosecond the multipliers keep seven digits.

    In index 3 they are a second difference of positions, with an error of ε/h² that no scaling can remove.
    """
    system = _core.System(_core.mechanism(model).multibody)
    for h in (1e-6, 1e-7, 1e-8, 1e-9):
        run = simulation(model, formulation=formulation, step_size=h)
        run.run(50 * h, 50)
        state = run.state
        assert state.counters.newton_iterations <= 2 * 50
        assert state.counters.retries == 0
        exact = system.accelerations(state.q, state.v, np.zeros(system.input_size))[1]
        assert_close(state.lambda_, exact, 1e-7, 0.0)
