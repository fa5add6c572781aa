"""Long runs: what drifts, what fails, and the energy balance behind it."""

import numpy as np
import pytest

from research.measure import INCREMENTAL, INDEX2, INDEX3, RESIDUAL, STABILIZED
from research.study import long_runs
from research.study.long_runs import SAMPLES, long_run
from research.study.runs import simulation
from sigmafmu import _core


def largest(cell, name, part=slice(None)):
    return max(cell[name][part])


@pytest.mark.parametrize("corrector", [RESIDUAL, INCREMENTAL])
@pytest.mark.parametrize("mechanism", ["HeavyTop", "SliderCrank"])
def test_index_3_without_dissipation_fails(mechanism, corrector):
    cell = long_run(mechanism, INDEX3, corrector, 1.0, 4.0)
    assert "failed" in cell
    assert len(cell["time"]) < SAMPLES


@pytest.mark.parametrize("rho", [1.0, 0.9])
@pytest.mark.parametrize("mechanism", ["HeavyTop", "SliderCrank"])
def test_the_stabilized_form_stays_on_the_constraints(mechanism, rho):
    """Positions to rounding, velocities to Newton's tolerance; the energy error is that of order 2."""
    cell = long_run(mechanism, STABILIZED, RESIDUAL, rho, 4.0)
    assert "failed" not in cell
    assert cell["retries"] == 0
    assert len(cell["time"]) == SAMPLES
    assert largest(cell, "phi") < 1e-14
    assert largest(cell, "phidot") < 1e-10
    assert largest(cell, "energy") < 1e-3


def test_what_the_other_formulations_leave():
    """Index 3 does not see the velocities, index 2 not the positions, which drift."""
    index3, index2 = (long_run("HeavyTop", f, RESIDUAL, 0.9, 10.0) for f in (INDEX3, INDEX2))
    assert largest(index3, "phi") < 1e-14
    assert largest(index3, "phidot") > 1e-4
    assert largest(index2, "phidot") < 1e-10
    assert largest(index2, "phi", slice(-50, None)) > largest(index2, "phi", slice(None, 50)) > 1e-5


def test_dissipation_costs_energy():
    strong, weak = (long_run("HeavyTop", STABILIZED, RESIDUAL, rho, 10.0) for rho in (0.5, 0.9))
    assert largest(strong, "energy", slice(-50, None)) > 10 * largest(weak, "energy", slice(-50, None))


def test_power_of_the_rotor():
    """dE/dt along the equations of motion, by central differences: truncation δ² and rounding of E = 3e5 J."""
    run = simulation("HighSpeedRotor", 1e-5)
    run.run(0.01, 1000)
    q, v = run.state.q, run.state.v + np.array([0.3, -0.2, 0.1, 0.0, 5.0, -3.0])
    system = _core.System(_core.mechanism("HighSpeedRotor").multibody)
    vdot, _ = system.accelerations(q, v, np.zeros(system.input_size))
    delta = 1e-7
    there, back = (system.energy(system.compose(q, s * delta * v), v + s * delta * vdot) for s in (1, -1))
    assert long_runs._rotor_power(q[None], v[None])[0] == pytest.approx((there - back) / (2 * delta), rel=1e-2)


def test_energy_balance_of_the_rotor():
    """The torque does 0.65 J of work in 0.4 s, known to 1e-5 of it: rounding of 3e5 J of spin alone is 1e-7 J."""
    run = simulation("HighSpeedRotor", 2e-5)
    balance = long_runs._Balance("HighSpeedRotor", run.state)
    before = balance.expected
    error = balance.errors(*run.trajectory(0.4, 20_000)[:3])[0] * balance.scale
    work = balance.expected - before
    assert work > 0.5
    assert error < 1e-5 * work


def test_a_run_whose_energy_grows_counts_as_failed(monkeypatch):
    monkeypatch.setattr(long_runs, "largest_kinetic_energy", lambda mechanism: 1e-12)
    cell = long_run("HeavyTop", STABILIZED, RESIDUAL, 0.9, 4.0)
    assert cell["failed"].startswith("energy has doubled")
    assert cell["time"] == []


def test_report(tmp_path):
    cells = long_runs.CHAPTER.cells("HeavyTop", quick=True)
    time = np.linspace(0.01, 4.0, SAMPLES).tolist()
    good = {"time": time, "energy": [1e-5] * 400 + [2e-5] * 100, "phi": [1e-15] * SAMPLES, "phidot": [1e-3] * SAMPLES}
    found = {cell.key: {**good, "retries": 0} for cell in cells}
    none = {"time": [], "energy": [], "phi": [], "phidot": [], "retries": 10, "failed": "step failed at t = 0.001"}
    found["index 3/residual/1"] = none
    text = long_runs.CHAPTER.report({"HeavyTop": found}, tmp_path)
    assert "| index 3 | residual | 1 | step failed at t = 0.001 | – | – | – | 10 |" in text
    assert "| index 2 | residual | 1 | 1.0e-05 | 2.0e-05 | 1.0e-15 | 1.0e-03 | 0 |" in text
    lines = (tmp_path / "long_runs-HeavyTop.csv").read_text().splitlines()
    assert len(lines) == 1 + (len(cells) - 1) * SAMPLES // long_runs.DRAWN
    assert (tmp_path / "long_runs-HeavyTop.png").stat().st_size < 150_000
