"""Stiff, heavy, light, thin, far and fast: mechanisms keep the order of the method, or say what stops them."""

import re

import numpy as np
import pytest

from research.mechanisms.linkages import CRANK, CYLINDRICAL, MASSES, planar_four_bar
from research.mechanisms.parts import REVOLUTE, SPHERICAL
from research.reference.linkage_motions import four_bar_motion
from research.robustness import CASES, FORMULATIONS, SteadyTop
from sigmafmu import _core

from .helpers import EPS, FULL, INDEX3, MODIFIED, mass_matrix, simulation

# --- accuracy --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("case", CASES)
def test_errors_are_those_of_truncation(case, formulation):
    """Of second order, and not much larger than those of links of 1 m and 1 kg. A spring gives way by 1e-8."""
    coarse, fine = (CASES[case].error(fineness, **FORMULATIONS[formulation]) for fineness in (1, 2))
    assert coarse <= (1e-3 if "top" in case else 2e-4)
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.05)


LOOPS = {  # masses [kg] of links of a planar four-bar
    "coupler 1e-9 kg": {"coupler": 1e-9},
    "crank 1e6 kg": {"crank": 1e6},
    "crank and rocker 1e-6 kg": {"crank": 1e-6, "rocker": 1e-6},  # lighter, rounding repeats a step of redundant joints
}
CLOSURES = {"redundant": (REVOLUTE,) * 4, "regular": (REVOLUTE, SPHERICAL, CYLINDRICAL, REVOLUTE)}


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("closure", CLOSURES)
@pytest.mark.parametrize("masses", LOOPS)
def test_loops_with_light_and_heavy_links(masses, closure, formulation, monkeypatch):
    """During 0.5 s, against the solution in the crank's angle."""
    for name, mass in LOOPS[masses].items():
        monkeypatch.setitem(MASSES, name, mass)
    theta = four_bar_motion(np.array([0.0, 0.5]))[0][-1]
    expected = CRANK / 2 * np.array([np.cos(theta), np.sin(theta), 0.0])
    errors = []
    for steps in (500, 1000):
        run = simulation(planar_four_bar(CLOSURES[closure]), step_size=0.5 / steps, **FORMULATIONS[formulation])
        run.advance(0.5 / steps, steps)
        assert run.state.counters.retries == 0
        errors.append(np.abs(run.state.q[:3] - expected).max())
    assert errors[0] <= 2e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


# --- noise of multipliers in index 3 ---------------------------------------------------------------------------------


def gain_of_rounding(rho: float) -> float:
    """Standard deviation of h² vdot for positions that are prescribed, but for white noise of 1: Eqs. (11)-(15)."""
    p = _core.AlphaParameters(rho)
    v = a = vdot = before = 0.0
    squares = 0.0
    for position in [1.0] + [0.0] * 2000:
        theta, before = position - before, position
        a_new = (theta - v - (0.5 - p.beta) * a) / p.beta
        v += (1 - p.gamma) * a + p.gamma * a_new
        vdot = ((1 - p.alpha_m) * a_new + p.alpha_m * a - p.alpha_f * vdot) / (1 - p.alpha_f)
        a = a_new
        squares += vdot**2
    return float(np.sqrt(squares))


def noise(multipliers: np.ndarray) -> float:
    """Standard deviation of what alternates from step to step, the largest of all multipliers."""
    return float(np.sqrt((np.diff(multipliers, 8, axis=0) ** 2).mean(axis=0)).max() / 2**8)


@pytest.mark.parametrize("newton", [FULL, MODIFIED], ids=["full", "modified"])
@pytest.mark.parametrize("h", [1e-4, 1e-5])
@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
def test_noise_of_index_3_is_that_of_rounded_positions(model, rho, h, newton):
    """Positions are doubles: their rounding, ε/√12 of them, over h² and times the mass that a joint moves.

    Nothing but a smaller spectral radius or a larger step can make that smaller.
    """
    definition = _core.mechanism(model).multibody
    run = simulation(model, formulation=INDEX3, step_size=h, spectral_radius=rho, newton=newton)
    run.advance(h, 300)
    _, _, _, multipliers = run.trajectory(run.state.time + 1000 * h, 1000)
    q, v = run.state.q, run.state.v
    B = _core.System(definition).constraints(q, v)[2]
    mass = np.linalg.inv(B @ np.linalg.solve(mass_matrix(definition), B.T))
    rounding = EPS / np.sqrt(12) * max(1.0, np.abs(q).max())
    floor = gain_of_rounding(rho) * rounding / h**2 * np.linalg.norm(mass, axis=1).max()
    assert noise(multipliers) <= floor


# --- reasons ---------------------------------------------------------------------------------------------------------


def failure(mechanism: _core.Mechanism, h: float) -> str:
    """Of the first communication step, without retries."""
    mechanism.integrator.step_size, mechanism.integrator.max_halvings = h, 0
    slave = _core.Slave(mechanism)
    slave.start()
    with pytest.raises(RuntimeError) as caught:
        slave.do_step(0.0, h)
    return str(caught.value)


def test_a_spin_that_turns_by_pi_in_a_step():
    text = failure(SteadyTop(spin=1e5).mechanism(), 1e-4)
    assert re.match(
        r"The internal step to t = 0\.0001 s failed even with a step size of 0\.0001 s: body top would turn by 10\.\d* "
        r"rad in it, less than pi is allowed",
        text,
    ), text
