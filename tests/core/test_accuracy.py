"""Accuracy of the generalized-alpha method on the mechanisms, and energy over long runs.

Errors are differences to `research.reference.minimal_coordinates`.
"""

from functools import cache

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import (
    INDEX2,
    INDEX3,
    STABILIZED,
    columns,
    reference,
    rotation_of,
    simulation,
)

# --- accuracy ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("formulation", "allowed"), [(STABILIZED, 4e-5), (INDEX3, 2e-4)], ids=["stabilizedIndex2", "index3"]
)
def test_heavy_top_position_at_1_s(formulation, allowed):
    """Residual form, ρ∞ = 0.9, σ = 1, h = 2.5e-4: 3.3e-5 m and 1.7e-4 m."""
    run = simulation("HeavyTop", formulation=formulation, spectral_radius=0.9, sigma=1.0, step_size=2.5e-4)
    run.run(1.0, 4000)
    truth = columns(reference("HeavyTop", 1.0, 1), "top.position")[-1]
    assert np.linalg.norm(run.state.q[:3] - truth) <= allowed


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.5, 0.65, 0.8, 0.9, 1.0])
def test_heavy_top_converges_for_every_spectral_radius(rho):
    """Stabilized index 2 over 1 s, hω from 0.6 down to 0.04: each halving divides the error by 3 at least, the last by
    3.7; no step is repeated."""
    truth = columns(reference("HeavyTop", 1.0, 1), "top.position")[-1]
    found = []
    for h in (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4):
        run = simulation("HeavyTop", spectral_radius=rho, step_size=h)
        run.run(1.0, round(1 / h))
        assert run.state.counters.retries == 0
        found.append(np.linalg.norm(run.state.q[:3] - truth))
    ratios = np.array(found[:-1]) / found[1:]
    assert np.isfinite(found).all()
    assert (ratios > 3.0).all()
    assert ratios[-1] > 3.7


@cache
def rotor_error(sigma, h, rho=0.9):
    """Larger distance of the two bearing points to the reference at 0.2 s."""
    run = simulation("HighSpeedRotor", sigma=sigma, step_size=h, spectral_radius=rho)
    run.run(0.2, round(0.2 / h))
    truth, turn = reference("HighSpeedRotor", 0.2, 1), rotation_of(run.state.q)
    distances = []
    for support, x in (("leftSupport", -0.11), ("rightSupport", 0.09)):
        ours = run.state.q[:3] + turn.apply([x, 0.0, 0.0])
        distances.append(np.linalg.norm(ours - columns(truth, f"{support}.position")[-1]))
    return max(distances)


def test_rotor_bearing_positions_at_200_ms():
    """h = 5e-6: 7.1e-8 m for σ = 1, 1.7e-7 m for σ = 0, 4.6e-9 m for σ = 1.7."""
    assert rotor_error(1.0, 5e-6) <= 8e-8
    assert rotor_error(1.0, 5e-6) <= rotor_error(0.0, 5e-6) / 2
    assert rotor_error(1.7, 5e-6) <= rotor_error(0.0, 5e-6) / 20


@pytest.mark.parametrize("rho", [1.0, 0.9, 0.65])
def test_spin_optimal_sigma_is_of_third_order(rho):
    """For a body that spins fast the leading errors are multiples of one vector, and one σ cancels them: with
    p = J_polar/J_transverse σ* = (4γ/β) (1/12 - C + η/p), C = (1 - 6β - 3(α_m - α_f))/6,
    η = (γ(1 - γ) + α_f(1 - α_f) - α_m(1 - α_m))/2 - 1/24."""
    a = _core.AlphaParameters(rho)
    c = (1 - 6 * a.beta - 3 * (a.alpha_m - a.alpha_f)) / 6
    eta = (a.gamma * (1 - a.gamma) + a.alpha_f * (1 - a.alpha_f) - a.alpha_m * (1 - a.alpha_m)) / 2 - 1 / 24
    best = 4 * a.gamma / a.beta * (1 / 12 - c + eta / (0.001541 / 0.000812))
    assert np.log2(rotor_error(best, 2e-5, rho) / rotor_error(best, 1e-5, rho)) > 2.8
    assert rotor_error(best, 1e-5, rho) < rotor_error(1.0, 1e-5, rho) / 5


@cache
def slider_crank_5_s():
    """Stabilized index 2, ρ∞ = 0.9, σ = 1, h = 1e-4, every step."""
    run = simulation("SliderCrank", spectral_radius=0.9, sigma=1.0, step_size=1e-4)
    return (*run.trajectory(5.0, 50_000), run.state)


def test_slider_position():
    """1.2e-7 m over 2 s and 1.3e-6 m over 5 s at most."""
    _, q, _, _, _ = slider_crank_5_s()
    truth = reference("SliderCrank", 5.0, 1000)["guide.displacement"]
    error = np.abs(q[::50, 14] - truth)
    assert error[:401].max() <= 1e-6
    assert error.max() <= 1e-5


def test_slider_crank_turns_are_counted():
    """Five seconds are several turns; the angle is not wrapped."""
    state = slider_crank_5_s()[-1]
    truth = reference("SliderCrank", 5.0, 1000)["crankPivot.angle"][-1]
    assert truth > 4 * np.pi
    assert state.turned[0] == pytest.approx(truth, abs=1e-4)


def test_slider_crank_keeps_its_constraints():
    """Position and velocity level, at every step: 1e-10 is asked for, rounding is what there is."""
    _, q, v, _, _ = slider_crank_5_s()
    system = _core.System(_core.mechanism("SliderCrank").multibody)
    worst = np.zeros(2)
    for row in zip(q, v, strict=True):
        phi, rate, _, _ = system.constraints(*row)
        worst = np.maximum(worst, [np.abs(phi).max(), np.abs(rate).max()])
    assert (worst <= 1e-10).all()
    assert worst[0] <= 1e-14
    assert worst[1] <= 1e-12


def test_slider_crank_reactions():
    """Every joint's force, relative to its largest."""
    _, q, v, multipliers, _ = slider_crank_5_s()
    truth = reference("SliderCrank", 5.0, 1000)
    system = _core.System(_core.mechanism("SliderCrank").multibody)
    for j, joint in enumerate(("crankPivot", "crankPin", "wristPin", "guide")):
        expected = columns(truth, f"{joint}.reactionForce")
        ours = np.array([system.reaction(q[i], v[i], multipliers[i], j)[0] for i in range(0, 50_001, 50)])
        assert np.abs(ours - expected).max() <= 1e-3 * np.abs(expected).max()


# --- energy -----------------------------------------------------------------------------------------------------------

ENERGY_STEPS = {"HeavyTop": 1e-3, "SliderCrank": 2e-3}


@cache
def energy_errors(model, formulation, rho, h, stop=20.0):
    """E(t) - E(0) at every step."""
    run = simulation(model, formulation=formulation, spectral_radius=rho, step_size=h)
    _, q, v, _ = run.trajectory(stop, round(stop / h))
    system = _core.System(_core.mechanism(model).multibody)
    energy = np.array([system.energy(*row) for row in zip(q, v, strict=True)])
    return energy - energy[0]


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
@pytest.mark.parametrize(
    ("formulation", "rho"),
    [(STABILIZED, 1.0), (STABILIZED, 0.9), (INDEX2, 1.0), (INDEX2, 0.9), (INDEX3, 0.9)],
    ids=["stabilizedIndex2, 1", "stabilizedIndex2, 0.9", "index2, 1", "index2, 0.9", "index3, 0.9"],
)
def test_energy_over_20_s(model, formulation, rho):
    """No blow-up: the error is small, its mean drifts in the second half no faster than in the first (10 % and a tenth
    of the oscillation allowed; in index 2, where the positions drift off, three times: quadratically), and all of it is
    truncation error: half the step leaves at most a third."""
    h = ENERGY_STEPS[model]
    error = energy_errors(model, formulation, rho, h)
    kinetic = {"HeavyTop": 5436.0, "SliderCrank": 0.77}[model]  # J, at the start
    assert np.abs(error).max() <= 2e-3 * kinetic
    parts = np.array_split(error, 10)
    means, swing = np.array([part.mean() for part in parts]), max(np.ptp(part) for part in parts)
    growth = 3.0 if formulation == INDEX2 else 1.1
    assert abs(means[-1] - means[5]) <= growth * abs(means[4] - means[0]) + 0.1 * swing
    finer = energy_errors(model, formulation, rho, h / 2)
    assert np.abs(finer).max() <= np.abs(error).max() / 3


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
def test_index_3_without_damping_is_not_for_long_runs(model):
    """ρ∞ = 1 in index 3 is only marginally stable: the multipliers' error alternates from step to step, undamped, and
    in the end grows. The steps still satisfy every equation of the method (see above), and the failure is reported."""
    run = simulation(model, formulation=INDEX3, spectral_radius=1.0, step_size=1e-3)
    system = _core.System(_core.mechanism(model).multibody)
    signs = []
    for i in range(200):
        run.run((i + 1) * 1e-3, 1)
        state = run.state
        exact = system.accelerations(state.q, state.v, np.zeros(system.input_size))[1]
        signs.append(state.lambda_ - exact)
    signs = np.array(signs)[100:]
    largest = np.abs(signs).max(axis=0).argmax()
    assert (np.sign(signs[1:, largest]) == -np.sign(signs[:-1, largest])).mean() > 0.95
    with pytest.raises(RuntimeError, match="step failed at t = "):
        run.run(20.0, 19_800)
    assert np.isfinite(run.state.q).all()
