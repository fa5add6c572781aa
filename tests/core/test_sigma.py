"""The spin-optimal σ: its closed form, what it does to the order, how spinOptimal decides, and that it never harms.

The closed forms are derived in docs/sigma.md. Here they are checked against the exact linear solution of the discrete
equations in 50 digits, written down from Eqs. (11)-(16) and not from the derivation, and against runs.
"""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import strategies as st

from research.study.sigma import (
    axis_error,
    exact_axis,
    gyro_time,
    gyroscope,
    momentum_error,
    nutating,
    precessing,
)
from sigmafmu import _core
from sigmafmu.spin_sigma import coefficients, nutation_sigma, precession_sigma, unsymmetric_sigma

from .helpers import (
    EPS,
    FORMULATIONS,
    INCREMENTAL,
    INDEX3,
    MODELS,
    MODIFIED,
    TANGENT_FREE,
    Rotation,
    assert_bitwise,
    columns,
    copy,
    errors,
    property_test,
    reference,
    rotation_of,
    simulation,
)

FIXED, SPIN_OPTIMAL = 1, 2
TIGHT = {"relative_tolerance": 1e-11}
every_rho = pytest.mark.parametrize("rho", [1.0, 0.9, 0.65])
ratios = st.floats(0.2, 1.99)
radii = st.floats(0.0, 1.0)


# --- closed forms ----------------------------------------------------------------------------------------------------


def discrete_rates(rho, ratio, phi, sigma, kappa):
    """Exact factors of one step of h Ω = φ for a transverse angular velocity w ~ exp(i (κ - 1) Ω t), in 50 digits.

    Returns the error of the tilt per step relative to the velocity, and that of the velocity under a given moment. The
    transverse parts of (11)-(16) are linear; y z⁻ⁿ is what a quantity y has grown to.
    """
    rho, p, phi, sigma, kappa = (mp.mpf(x) for x in (rho, ratio, phi, sigma, kappa))
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = mp.mpf(1) / 2 + af - am
    beta = (gamma + mp.mpf(1) / 2) ** 2 / 4
    z = mp.expj((kappa - 1) * phi)
    a = (z - 1) / (1 - gamma + gamma * z)  # (14): h a_n of w_n = 1
    vdot = a * ((1 - am) * z + am) / ((1 - af) * z + af)  # (15): h v̇_n
    # (12), (13), (16) for θ_t of w_n = 1: θ̇_t T₀ + (1 - T₀) θ_t / h = z, with T₀ = T(φ e) across e
    t0 = (1 - mp.expj(-phi)) / (1j * phi)
    s = sigma * beta / gamma
    # θ = 1 + (1/2 - β) a + β z a + s (θ̇ - z) with θ̇ = (z - (1 - T₀) θ)/T₀, in units of h
    theta = (1 + (mp.mpf(1) / 2 - beta + beta * z) * a + s * (z / t0 - z)) / (1 + s * (1 - t0) / t0)
    tilt = theta * (mp.expj(phi) - 1) / (1j * phi)
    k = kappa * phi
    exact_tilt = (mp.expj(k) - 1) / (1j * k) if k else mp.mpf(1)
    nutation = 1j * (p - 1) * phi
    velocity = (1j * (kappa - 1) * phi - nutation) / (vdot - nutation)
    return tilt / exact_tilt - 1, velocity - 1


@property_test(50, rho=radii, ratio=ratios, kappa=st.floats(-0.3, 0.15))
def test_slow_precession_is_exact_to_third_order(rho, ratio, kappa):
    """Tilt error + velocity error is O(φ³) at σ*(κ), and only there: halving φ twice."""
    sigma = precession_sigma(rho, ratio, kappa)

    def error(phi, shift=0.0):
        tilt, velocity = discrete_rates(rho, ratio, phi, sigma + shift, kappa)
        return abs((1 + tilt) * (1 + velocity) - 1)

    phi = 1e-4
    scale = 1 + abs(sigma) ** 3 + 1 / ratio  # of the coefficient of φ³
    assert error(phi) < 10 * scale * phi**3
    if kappa == 0.0 or abs(kappa) > 1e-6:
        assert error(phi, 0.1) > 0.1 * phi**2 / 4 * coefficients(rho)[0] ** -1 * abs(1 - kappa) * 0.9


@property_test(50, rho=radii, ratio=ratios.filter(lambda p: p != 1.0))  # what turns alike about all axes cannot nutate
def test_free_nutation_keeps_the_angular_momentum_to_third_order(rho, ratio):
    """Its frequency shifts by η(hν)², whatever σ; the tilt of a whole nutation must follow the shifted one."""
    gamma_beta, _, eta = coefficients(rho)
    phi = mp.mpf(1) / 10**4
    shifted = 1 - eta * ((ratio - 1) * phi) ** 2  # of ν = (p - 1) Ω
    kappa = 1 + (ratio - 1) * shifted
    tilt, _ = discrete_rates(rho, ratio, phi, nutation_sigma(rho, ratio), kappa)
    # L across = J w + J_polar Ω × tilt: constant if tilt per velocity is that of κ = p
    offset = (1 + tilt) * ratio / kappa - 1
    assert abs(offset) < 10 * (1 + abs(nutation_sigma(rho, ratio)) ** 3) * phi**3
    assert gamma_beta > 0


@property_test(50, rho=radii, ratio=ratios)
def test_the_integrator_uses_the_closed_form(rho, ratio):
    """For each axis as spin axis and both directions of the spin."""
    for axis in range(3):
        moments = np.roll([ratio, 1.0, 1.0], axis)
        w, tau = np.roll([50.0, 0.0, 0.0], axis), np.roll([0.0, 1.0, -2.0], axis)
        for spin in (w, -w):
            precession = np.cross(spin, tau) / (ratio * 50.0**2)
            assert chosen(moments, spin + precession, tau, rho) == pytest.approx(
                precession_sigma(rho, ratio), rel=32 * EPS * (1 + 1 / ratio)
            )


@property_test(50, rho=radii, seed=st.integers(0, 2**32 - 1))
def test_the_integrator_uses_the_closed_form_for_unequal_moments_and_turned_axes(rho, seed):
    rng = np.random.default_rng(seed)
    j1 = rng.uniform(0.9, 1.1)
    moments = np.array([rng.uniform(0.3, 1.2), j1, j1 * rng.uniform(0.97, 1.03)])
    spin, tau = np.array([80.0, 0.0, 0.0]), np.array([0.0, *rng.normal(size=2)])
    w = spin + np.cross(spin, tau) / (moments[0] * 80.0**2)
    turn = Rotation.random(rng=rng).as_matrix()
    found = chosen(moments, w, tau, rho, turn)
    middle, difference = moments[1:].mean(), abs(moments[1] - moments[2])
    near_the_middle_axis = difference > abs(moments[0] - middle)
    assert found == pytest.approx(1.0 if near_the_middle_axis else unsymmetric_sigma(rho, moments), rel=1e-10)
    equal = [moments[0], j1, j1]
    assert unsymmetric_sigma(rho, equal) == pytest.approx(precession_sigma(rho, moments[0] / j1), rel=1e3 * EPS)


def chosen(moments, w, tau, rho=0.9, turn=None, h=1e-3, **settings):
    """σ that spinOptimal takes for a body with these principal moments, axes turned by `turn`, under a moment tau."""
    turn = np.eye(3) if turn is None else turn
    moments = np.asarray(moments, dtype=float)
    inertia = turn @ np.diag(moments) @ turn.T
    mechanism = gyroscope(np.diag(inertia), np.zeros(3), (0.0, 0.0))
    mechanism.multibody.body(0).inertia_products = inertia[[0, 0, 1], [1, 2, 2]]
    mechanism.integrator.spectral_radius = rho
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    wdot = (tau - np.cross(w, moments * w)) / moments
    return _core.spin_sigma(mechanism.multibody, mechanism.integrator, 0, turn @ w, turn @ wdot, h)


# --- scans and orders ------------------------------------------------------------------------------------------------


@every_rho
def test_third_order_on_the_rotor(rho):
    """Orders at σ*, with σ = 1 and in spinOptimal mode, where σ* is reached once the nutation has died away."""
    stop, steps = 0.1, (2e-5, 1e-5)
    exact = columns(reference("HighSpeedRotor", stop, 1), "rightSupport.position")[-1]

    def error(h, **chosen):
        run = simulation("HighSpeedRotor", step_size=h, spectral_radius=rho, **TIGHT, **chosen)
        run.run(stop, round(stop / h))
        q = run.state.q
        return np.linalg.norm(q[:3] + rotation_of(q).apply([0.09, 0.0, 0.0]) - exact)

    def order(**chosen):
        return np.log2(error(steps[0], **chosen) / error(steps[1], **chosen))

    inertia = _core.mechanism("HighSpeedRotor").multibody.bodies[0].inertia
    best = precession_sigma(rho, inertia[0] / inertia[1])
    assert order(sigma=best) == pytest.approx(3.0, abs=0.1)
    assert order(sigma=1.0) == pytest.approx(2.0, abs=0.1)
    assert error(steps[1], sigma_mode=SPIN_OPTIMAL) < 0.2 * error(steps[1], sigma=1.0)


@pytest.mark.parametrize("ratio", [0.2, 0.5, 1.0, 1.5, 1.99])
@pytest.mark.parametrize("rho", [1.0, 0.65])
def test_the_minimum_of_the_scan_is_at_the_closed_form(ratio, rho):
    """Error² is a parabola in σ; three points give its minimum, up to the third order: O(hΩ)."""
    h = 2e-4  # hΩ = 0.02
    slow, free = precessing((ratio, 1.0, 1.0)), nutating(ratio)
    end = gyro_time((ratio, 1.0, 1.0))
    exact = exact_axis(slow, end)
    scans = [(precession_sigma(rho, ratio), lambda s: axis_error(slow, exact, end, h, sigma=s, spectral_radius=rho))]
    if ratio != 1.0:  # a sphere does not nutate
        scans.append((nutation_sigma(rho, ratio), lambda s: momentum_error(free, h, sigma=s, spectral_radius=rho)))
    for formula, error in scans:
        sigmas = formula + np.array([-0.5, 0.0, 0.5])
        a, b, _ = np.polyfit(sigmas - formula, [error(s) ** 2 for s in sigmas], 2)
        assert a > 0
        assert abs(b / (2 * a)) < 0.02


def test_unequal_moments():
    """A body with three different moments precesses to third order at its σ*, on average over its wobble."""
    moments = (0.7, 1.0, 1.1)
    body = precessing(moments)
    exact = exact_axis(body, 2.0)
    at_best = axis_error(body, exact, 2.0, 2e-4, sigma=unsymmetric_sigma(0.9, moments))
    assert at_best < 0.1 * axis_error(body, exact, 2.0, 2e-4, sigma=1.0)


# --- decisions -------------------------------------------------------------------------------------------------------

DISK = (1.6, 1.0, 1.0)
SPIN = np.array([100.0, 0.0, 0.0])
MOMENT = np.array([0.0, 0.0, -16.0])
PRECESSING = SPIN + np.cross(SPIN, MOMENT) / (1.6 * 100.0**2)


def test_it_falls_back_to_the_given_sigma():
    given = {"sigma": 0.7}
    full = precession_sigma(0.9, 1.6)
    assert chosen(DISK, PRECESSING, MOMENT, **given) == pytest.approx(full, rel=1e-12)
    cases = {
        "rest": (np.zeros(3), MOMENT, {}),
        "no moment": (SPIN, np.zeros(3), {}),
        "free nutation": (SPIN + np.array([0.0, 0.1, 0.0]), np.zeros(3), {}),
        "released from rest": (SPIN, MOMENT, {}),
        "tumbling": (SPIN + np.array([0.0, 30.0, 0.0]), MOMENT, {}),
        "spin not resolved": (PRECESSING, MOMENT, {"h": 0.0101}),
        "incremental form": (PRECESSING, MOMENT, {"corrector": INCREMENTAL}),
    }
    for name, (w, tau, changed) in cases.items():
        assert chosen(DISK, w, tau, **changed, **given) == 0.7, name
    # a thin rod that tumbles, and a middle axis: neither precesses steadily
    for moments in ((1.0, 0.05, 0.98), (1.0, 0.9, 1.1)):
        assert chosen(moments, SPIN + np.cross(SPIN, MOMENT) / 1e4, MOMENT, **given) == 0.7
    # a lamina's two equal moments: the limit of the triangle inequality
    assert chosen((2.0, 1.0, 1.0), SPIN + np.cross(SPIN, MOMENT) / 2e4, MOMENT) == pytest.approx(
        precession_sigma(0.9, 2.0), rel=1e-12
    )


def test_it_decides_continuously():
    """No jump of σ larger than its slope explains, along paths from full weight to none."""
    paths = {
        "spin": lambda x: (SPIN + np.cross(SPIN, 1e2 * x * MOMENT) / (1.6 * 100.0**2), 1e2 * x * MOMENT, 1e-3),
        "driven": lambda x: (PRECESSING + np.array([0.0, 0.0, 0.06 * x]), MOMENT, 1e-3),
        "resolved": lambda x: (PRECESSING, MOMENT, 1e-3 + 1e-2 * x),
    }
    for name, path in paths.items():
        x = np.linspace(1e-3, 1.0, 401)
        sigma = np.array([chosen(DISK, w, tau, h=h) for w, tau, h in map(path, x)])
        assert sigma[0] == pytest.approx(precession_sigma(0.9, 1.6), rel=1e-9), name
        assert sigma[-1] == 1.0, name
        assert np.abs(np.diff(sigma)).max() < 0.02, name
        assert np.all(np.diff(sigma) <= 1e-12), name


@property_test(300, rho=radii, ratio=st.floats(0.1, 2.0), kappa=st.floats(-2.0, 2.0))
def test_no_moment_makes_it_worse_than_one(rho, ratio, kappa):
    """A moment that turns at κΩ in W, with the answer it has in the steady state: |σ - σ(κ)| <= |1 - σ(κ)|."""
    if abs(ratio - kappa) < 1e-3:
        return  # resonance with the nutation
    moments = np.array([ratio, 1.0, 1.0])
    # across the axis, as complex numbers y + i z: w = i τ/(Ω (p - κ)) for J_t = 1
    tau = 1e-3 * 100.0**2 * ratio
    answer = 1j * tau / (100.0 * (ratio - kappa))
    w = np.array([100.0, answer.real, answer.imag])
    found = chosen(moments, w, np.array([0.0, tau, 0.0]), rho, h=1e-4)
    best = precession_sigma(rho, ratio, kappa)
    assert abs(found - best) <= abs(1.0 - best) * (1 + 1e-12)


def test_bodies_with_joints_keep_the_given_sigma():
    """The heavy top starts in slow precession, which would give 1.67 in index 3."""
    run = simulation("HeavyTop")
    mechanism = _core.mechanism("HeavyTop")
    for formulation in FORMULATIONS.values():
        mechanism.integrator.formulation = formulation
        rates = run.state.v[3:], run.state.vdot[3:]
        assert _core.spin_sigma(mechanism.multibody, mechanism.integrator, 0, *rates, 1e-4) == 1.0


# --- runs in spinOptimal mode ----------------------------------------------------------------------------------------

RUNS = {"HeavyTop": (0.5, (1e-3, 2.5e-4)), "HighSpeedRotor": (0.02, (2e-5, 5e-6)), "SliderCrank": (0.5, (1e-3, 2.5e-4))}


def position_error(model, h, stop, **chosen):
    run = simulation(model, step_size=h, **TIGHT, **chosen)
    samples = 25
    rows = run.trajectory(stop, round(stop / h))[1:]
    return errors(model, reference(model, stop, samples), *(x[:: (len(x) - 1) // samples] for x in rows))


@pytest.mark.parametrize("rho", [1.0, 0.9, 0.5, 0.0])
def test_never_worse_than_one_on_the_rotor(rho):
    """Largest errors over the run; 1e-3 for what the weight's changes do."""
    stop, steps = RUNS["HighSpeedRotor"]
    for h in (*steps, 5e-5):
        one = position_error("HighSpeedRotor", h, stop, spectral_radius=rho)
        optimal = position_error("HighSpeedRotor", h, stop, spectral_radius=rho, sigma_mode=SPIN_OPTIMAL)
        for kind, error in one.items():
            assert optimal[kind] <= error * (1 + 1e-3), (h, kind)


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
@pytest.mark.parametrize("formulation", FORMULATIONS.values(), ids=FORMULATIONS)
def test_never_worse_than_one_on_mechanisms_with_joints(model, formulation):
    """Every body falls back, bit for bit."""
    h = RUNS[model][1][0]
    runs = [simulation(model, step_size=h, formulation=formulation, sigma_mode=m) for m in (FIXED, SPIN_OPTIMAL)]
    for run in runs:
        run.run(100 * h, 100)
    assert_bitwise(*(run.state for run in runs))


def random_body(rng):
    """A body that spins about a principal axis under a constant moment in W, with more or less nutation."""
    d = rng.uniform(0.05, 0.5, 3)
    if rng.random() < 0.5:
        d[1] = d[2]
    moments = d.sum() - d
    moment = rng.normal(size=3)
    moment *= 10 ** rng.uniform(-4, -2) * moments[0] * 100.0**2 / np.linalg.norm(moment)
    precession = np.cross([1.0, 0.0, 0.0], moment) / (moments[0] * 100.0)
    mix = rng.choice([0.0, 0.1, 0.3, 1.0, 3.0])
    transverse = precession[1:] + mix * np.linalg.norm(precession) * rng.normal(size=2)
    return gyroscope(moments, moment, transverse)


@pytest.mark.parametrize("seed", range(12))
def test_never_worse_than_one_on_random_bodies(seed):
    rng = np.random.default_rng(seed)
    mechanism, rho, h = random_body(rng), rng.choice([1.0, 0.9, 0.65, 0.3, 0.0]), rng.choice([1e-3, 3e-3, 8e-3])
    exact = exact_axis(mechanism, 2.0)
    one = axis_error(mechanism, exact, 2.0, h, spectral_radius=rho)
    optimal = axis_error(mechanism, exact, 2.0, h, sigma_mode=SPIN_OPTIMAL, spectral_radius=rho)
    assert optimal <= one * (1 + 1e-3)


def test_a_changing_sigma_keeps_second_order():
    """The rotor's weight rises from 0 to 1 while its nutation dies away; σ = 5 is far from everything."""
    stop = 0.02
    found = [
        position_error("HighSpeedRotor", h, stop, sigma=5.0, sigma_mode=SPIN_OPTIMAL)["orientation"]
        for h in (1e-5, 5e-6, 2.5e-6)
    ]
    assert np.log2(found[0] / found[1]) > 1.9
    assert np.log2(found[1] / found[2]) > 1.9


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("newton", [1, MODIFIED])
def test_rollback_is_bitwise(model, newton):
    """In spinOptimal mode too, everything that a later step depends on is in the state."""
    h = RUNS[model][1][0]
    settings = {"sigma_mode": SPIN_OPTIMAL, "formulation": INDEX3, "newton": newton}
    run = simulation(model, step_size=h, **settings)
    run.run(20 * h, 20)
    saved = copy(run.state)
    run.run(40 * h, 20)
    first = copy(run.state)
    run.state = saved
    run.run(40 * h, 20)
    assert_bitwise(first, run.state)
    other = simulation(model, step_size=h, **settings)  # another instance, in another history
    other.run(7.3 * h, 3)
    other.state = copy(saved)
    other.run(40 * h, 20)
    assert_bitwise(first, other.state)


def test_each_body_has_its_own_sigma():
    """Two gyroscopes that do not touch each other move as each does alone."""
    alone = [precessing((1.6, 1.0, 1.0)), precessing((0.5, 1.0, 1.0))]
    both = _core.Mechanism()
    both.multibody.gravity = np.zeros(3)
    for i, mechanism in enumerate(alone):
        body = mechanism.multibody.bodies[0]
        body.name = f"body{i}"
        both.multibody.add(body)
        moment = np.array([0.0, 0.0, -mechanism.multibody.bodies[0].inertia[0] * 100.0 * 0.01])
        both.multibody.add(_core.Load(f"moment{i}", i, np.zeros(3), moment))
    settings = {"step_size": 1e-3, "sigma_mode": SPIN_OPTIMAL, "relative_tolerance": 1e-13}
    together = simulation(both, **settings)
    together.run(1.0, 1000)
    for i, mechanism in enumerate(alone):
        run = simulation(mechanism, **settings)
        run.run(1.0, 1000)
        turn = rotation_of(together.state.q[7 * i : 7 * i + 7]).inv() * rotation_of(run.state.q)
        assert turn.magnitude() < 1e-10  # Newton's tolerance, 1e-13 · 100 rad/s per step of 1e-3 s, 1000 steps


# --- the start of the iterations --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
@pytest.mark.parametrize("formulation", FORMULATIONS.values(), ids=FORMULATIONS)
@pytest.mark.parametrize("sigma_mode", [FIXED, SPIN_OPTIMAL])
def test_multipliers_that_a_step_starts_from_do_not_change_the_result(model, formulation, sigma_mode):
    """To Newton's tolerance, 1e-12 of the velocities, times 1000 for what 50 steps make of it."""
    h = RUNS[model][1][0]

    def end(start, **settings):
        run = simulation(
            model, step_size=h, formulation=formulation, sigma_mode=sigma_mode, relative_tolerance=1e-12, **settings
        )
        for i in range(1, 51):
            run.state.lambda_ = start * run.state.lambda_
            run.run(i * h, 1)
        return run.state

    expected = end(1.0)
    for settings in ({}, {"jacobian": TANGENT_FREE}, {"newton": MODIFIED}):
        for start in (0.0, 2.0):
            found = end(start, **settings)
            np.testing.assert_allclose(found.q, expected.q, rtol=0, atol=1e-9)
            assert np.abs(found.v - expected.v).max() < 1e-9 * np.abs(expected.v).max()
