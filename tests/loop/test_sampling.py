"""The sampled speed loop of the slider-crank against plant and continuous law as one ODE, and its energy balance."""

import numpy as np
import pytest

from research.reference.minimal_coordinates import SliderCrank
from sigmafmu.loop import sampling, studies
from sigmafmu.loop.energy import Bond
from sigmafmu.loop.gauss_seidel import EXTRAPOLATED, HOLD, ITERATED, LINEAR, MEAN, SCHEMES, run

SIZES = (2e-3, 1e-3, 5e-4)
ORDERS = {HOLD: 1.0, EXTRAPOLATED: 2.0, LINEAR: 2.0, MEAN: 2.0}


@pytest.fixture(scope="module")
def runs() -> dict[str, list[studies.SamplingRun]]:
    found = studies.sampling_runs(SIZES, stop_time=0.25)
    return {scheme: [r for r in found if r.scheme == scheme] for scheme in SCHEMES}


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.divide(errors[:-1], errors[1:]))


# --- reference -------------------------------------------------------------------------------------------------------


def test_reference_obeys_newton_and_euler():
    """Lagrange's equation of the reference against SliderCrank.acceleration, which projects Newton's and Euler's.

    The rate is differentiated by central differences, extrapolated once: δ⁴ and 1e-12 / δ, with δ = 1e-3 s.
    """
    exact, times, step = sampling.monolithic(0.5), np.linspace(0.05, 0.45, 9), 1e-3

    def slope(d: float) -> np.ndarray:
        return (exact(times + d)["rate"] - exact(times - d)["rate"]) / (2 * d)

    acceleration = (4 * slope(step / 2) - slope(step)) / 3
    fine = np.linspace(0.0, 0.5, 4001)
    rate = exact(fine)["rate"]
    angle = np.array([np.trapezoid(rate[fine <= t], fine[fine <= t]) for t in times])
    mechanism, now = SliderCrank(angle), exact(times)
    mass = 2 * (mechanism.energy(np.ones(9)) - mechanism.energy(np.zeros(9)))
    expected = mechanism.acceleration(now["rate"]) + now["torque"] / mass
    np.testing.assert_allclose(acceleration, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


def test_reference_balances_its_energy():
    """Gain of energy = work of the torque, by Gauss quadrature on short intervals."""
    exact = sampling.monolithic(0.5)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    starts, span = np.linspace(0.0, 0.5, 50, endpoint=False), 0.01
    now = exact((starts[:, None] + span / 2 * (1 + nodes)).ravel())
    work = span / 2 * np.sum(np.tile(weights, 50) * now["torque"] * now["rate"])
    energy = exact(np.array([0.0, 0.5]))["energy"]
    assert work == pytest.approx(energy[1] - energy[0], abs=1e-9)


# --- accuracy --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SCHEMES)
def test_error_falls_with_the_order_of_the_hold(runs, scheme):
    found = orders([r.error for r in runs[scheme]])
    assert found[-1] == pytest.approx(ORDERS[scheme], abs=0.1)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_energy_gained_tends_to_that_of_the_reference(runs, scheme):
    assert orders([r.gain_error for r in runs[scheme]])[-1] == pytest.approx(ORDERS[scheme], abs=0.2)


def test_iteration_allows_steps_that_a_guess_does_not(fmu):
    """H = 8 ms: the extrapolated torque overshoots more and more, the iterated one is off by a hundredth."""

    def error(scheme: str) -> float:
        H, steps = 8e-3, 100
        with sampling.speed_loop(fmu("SliderCrank"), H, H / 16) as loop:
            rates: list[float] = []
            run(loop, H, steps, scheme, observe=lambda t: rates.append(loop.rate[-1]))
        return np.abs(rates - sampling.monolithic(0.8)(H * np.arange(1, steps + 1))["rate"]).max()

    assert error(EXTRAPOLATED) > sampling.SET_POINT
    assert error(LINEAR) < 0.015 * sampling.SET_POINT


def test_trial_steps_do_not_count_for_the_law(fmu):
    """Its integral is the trapezoidal sum over the accepted samples."""
    H = 4e-3
    with sampling.speed_loop(fmu("SliderCrank"), H, H / 8) as loop:
        rates = [loop.plant.outputs()[0]]
        counts = run(loop, H, 50, LINEAR, observe=lambda t: rates.append(loop.plant.outputs()[0]))
        demand = loop.demand
    assert counts.min() > 1
    error = sampling.SET_POINT - np.array(rates)
    integral = sampling.GAINS["integralGain"] * np.trapezoid(error, dx=H)
    expected = sampling.GAINS["proportionalGain"] * error[-1] + integral
    assert demand == pytest.approx(expected, abs=1e-13)  # 50 sums of numbers below 1, rounded


# --- energy ----------------------------------------------------------------------------------------------------------


def test_bond_integrates_cubics_exactly():
    t = np.linspace(0.0, 0.5, 9)
    one = np.ones_like(t)
    bond = Bond(0.5, effort=(t**3, 2 * t**3), flow=(one, 3 * one))
    assert bond.work() == pytest.approx(0.5**4 / 4, rel=1e-14)
    assert bond.residual() == pytest.approx(5 * 0.5**4 / 4, rel=1e-14)
    assert bond.mismatch() == pytest.approx(5 * 0.5**3, rel=1e-14)
    with pytest.raises(ValueError, match="even number of intervals to be integrated, not 1"):
        Bond(0.5, effort=(one[:2], one[:2]), flow=(one[:2], one[:2])).work()


@pytest.mark.parametrize("scheme", ITERATED)
def test_work_of_the_torque_is_the_gain_of_energy(scheme):
    """At a fixed H the difference is the integrator's, and falls with h²."""
    found = [
        studies.sampling_runs([4e-3], stop_time=0.2, refinement=n, schemes=[scheme])[0].balance for n in (16, 32, 64)
    ]
    assert orders(found) == pytest.approx([2.0, 2.0], abs=0.1)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_residual_energy_falls_with_the_order_of_the_hold(runs, scheme):
    assert orders([r.residual for r in runs[scheme]]) == pytest.approx([ORDERS[scheme]] * 2, abs=0.15)


def test_iteration_leaves_no_power_at_the_communication_points(runs):
    """Torque asked for and torque given agree to the tolerance of the iteration, 1e-8 of the torque (or of 1 N m)."""
    largest_rate, largest_torque = 14.0, 3.0
    for r in runs[LINEAR]:
        assert r.mismatch < 1e-8 * largest_torque * largest_rate
    assert orders([r.mismatch for r in runs[HOLD]])[-1] == pytest.approx(1.0, abs=0.1)
    assert orders([r.mismatch for r in runs[EXTRAPOLATED]])[-1] == pytest.approx(2.0, abs=0.15)
