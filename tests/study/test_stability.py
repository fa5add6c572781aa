"""The stability maps: what counts as running, and some cells of which both are known."""

import numpy as np
import pytest

from research.measure import exact
from research.study import stability
from research.study.stability import SAMPLES, STOP_TIMES, Panel, assess, failures, number_of_steps, panels, run

every_mechanism = pytest.mark.parametrize("mechanism", STOP_TIMES)
DEFAULT = Panel("1", "residual", "stabilizedIndex2")
GEOM1 = Panel("0", "residual", "index3")


def exact_samples(mechanism):
    return stability._of_history(mechanism, exact(mechanism, STOP_TIMES[mechanism], SAMPLES))


@every_mechanism
def test_the_exact_motion_runs_without_error(mechanism):
    assert assess(mechanism, *exact_samples(mechanism)) == ("runs", 0.0, "")


@every_mechanism
def test_an_error_is_relative_to_the_size_of_the_motion(mechanism):
    position, velocity = exact_samples(mechanism)
    size = np.linalg.norm(position - position[0], axis=1).max()
    position = position + 0.5 * size * np.array([0.6, 0.0, 0.8])
    outcome, error, _ = assess(mechanism, position, velocity)
    assert outcome == "runs"
    assert error == pytest.approx(0.5, rel=1e-6)  # rounding of the rotor's 1e-4 m


@every_mechanism
@pytest.mark.parametrize(
    ("spoilt", "reason"),
    [("nan", "not finite"), ("energy", "kinetic energy"), ("position", "times the motion")],
)
def test_divergence(mechanism, spoilt, reason):
    position, velocity = (x.copy() for x in exact_samples(mechanism))
    if spoilt == "nan":
        velocity[-1, 0] = np.nan
    elif spoilt == "energy":
        velocity[-1] *= 10.0  # at a sample that may have far less than the largest energy
    else:
        position[3] += 11.0 * np.linalg.norm(position - position[0], axis=1).max()
    outcome, error, found = assess(mechanism, position, velocity)
    assert outcome == "diverges"
    assert np.isnan(error)
    assert reason in found


@every_mechanism
@pytest.mark.parametrize("h_omega", stability.H_OMEGA)
def test_steps_are_what_was_asked_for(mechanism, h_omega):
    steps = number_of_steps(mechanism, h_omega)
    assert steps % SAMPLES == 0
    rounding = 0.5 * SAMPLES / steps  # half of SAMPLES steps
    found = STOP_TIMES[mechanism] * stability.angular_velocity(mechanism) / steps
    assert found == pytest.approx(h_omega, rel=1.01 * rounding)


def test_largest_angular_velocities():
    """The heavy top begins with its largest but for 3 % of precession; nothing accelerates the rotor."""
    assert stability.angular_velocity("HeavyTop") == pytest.approx(np.hypot(150.0, 4.61538), rel=0.03)
    assert stability.angular_velocity("HighSpeedRotor") == pytest.approx(20944.0, rel=1e-6)


def test_a_stable_and_an_unstable_cell():
    """Index 3 without dissipation: geom1 fails at once where the default has an error of second order."""
    outcome, _, reason = run("HeavyTop", GEOM1, 1.0, number_of_steps("HeavyTop", 0.3))
    assert outcome == "stops"
    assert reason.startswith("step failed at t = ")
    outcomes, errors, _ = zip(*(run("HeavyTop", DEFAULT, 1.0, steps) for steps in (1000, 2000, 4000)), strict=True)
    assert set(outcomes) == {"runs"}
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.1)


@every_mechanism
def test_the_default_runs_wherever_steps_are_not_too_large(mechanism):
    cells = stability.run_panel(mechanism, DEFAULT, (0.0, 0.9, 1.0), (stability.SAFE_H_OMEGA,))["cells"]
    assert len(cells) == 3
    assert failures(cells, stability.SAFE_H_OMEGA) == []


def test_failures_are_those_up_to_the_limit():
    cells = [{"hOmega": x, "outcome": o} for x in (0.3, 0.6) for o in ("runs", "stops", "diverges")]
    assert [(c["hOmega"], c["outcome"]) for c in failures(cells, 0.3)] == [(0.3, "stops"), (0.3, "diverges")]
    assert len(failures(cells, 0.6)) == 4


def test_without_joints_the_formulations_are_one():
    assert {panel.formulation for panel in panels("HighSpeedRotor")} == {"index3"}
    assert {panel.formulation for panel in panels("HeavyTop")} == set(stability.FORMULATIONS)


@pytest.mark.exudyn
def test_exudyn_geom1_is_ours():
    """The same scheme in another code: same errors, to what Newton's tolerances leave, and the same failure."""
    peer = Panel("geom1", "Exudyn", "index3")
    for rho in (0.6, 0.9):
        ours, theirs = (run("HeavyTop", panel, rho, 1000) for panel in (GEOM1, peer))
        assert ours[0] == theirs[0] == "runs"
        assert theirs[1] == pytest.approx(ours[1], rel=0.01)
    assert run("HeavyTop", peer, 1.0, 1000)[0] == "stops"


@pytest.mark.exudyn
def test_exudyn_sigma_modified_fails_at_its_default():
    assert run("HeavyTop", Panel("modified", "Exudyn", "index3"), 0.9, 1000)[0] in ("stops", "diverges")


@pytest.mark.exudyn
def test_report(tmp_path):
    maps = {
        panel.key: {"cells": [{"rho": 1.0, "hOmega": 0.3, "h": 2e-3, "outcome": outcome, "error": 0.01, "reason": ""}]}
        for panel, outcome in zip(panels("HeavyTop"), ["runs", "stops", "diverges"] * 10, strict=False)
    }
    text = stability.CHAPTER.report({"HeavyTop": maps}, tmp_path)
    assert "| residual, σ = 0 | index 3 | 1 of 1 | 1 of 1 | 0 | 0 |" in text
    assert "| residual, σ = γ/(3β) | index 3 | 0 of 1 | 0 of 1 | 1 | 0 |" in text
    lines = (tmp_path / "stability-HeavyTop.csv").read_text().splitlines()
    assert lines[0] == "corrector,sigma,formulation,rho,hOmega,h,outcome,error,reason"
    assert len(lines) == 1 + len(maps)
    assert (tmp_path / "stability-HeavyTop.png").stat().st_size < 150_000
