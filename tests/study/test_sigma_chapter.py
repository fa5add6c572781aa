"""The chapter on σ: what its cells measure, and that its report holds every result, failures included."""

import numpy as np
import pytest

from research.measure import INDEX3, STABILIZED, columns, exact
from research.study.sigma import (
    CHAPTER,
    SCANS,
    gyroscope_cell,
    minimum,
    nutation_sigma,
    precession_sigma,
    rotor_orders,
    scan,
    top_cell,
    top_path,
)


def test_closed_forms_of_the_trapezoidal_rule():
    """ρ∞ = 1: 4/3 + 2/(3p) and 2/(3p); a sphere that nutates not at all leaves γ/(3β) = 2/3."""
    for ratio in (0.2, 0.7, 1.0, 1.99):
        assert precession_sigma(1.0, ratio) == pytest.approx(4 / 3 + 2 / (3 * ratio), rel=1e-14)
        assert nutation_sigma(1.0, ratio) == pytest.approx(2 / (3 * ratio), rel=1e-14)


def test_the_minimum_of_a_distance():
    """|b + (σ - 1.3) a| has its square's minimum where b is orthogonal to a."""
    a, b = np.array([1.0, 2.0]), np.array([-2.0, 1.0])
    assert minimum(lambda s: float(np.linalg.norm(b + (s - 1.3) * a)), 1.0) == pytest.approx(1.3, rel=1e-12)


def test_the_reduced_top_is_the_heavy_top():
    """Without errors of momentum and kinematics the reduced model is the exact motion."""
    stop, samples = 0.5, 25
    expected = columns(exact("HeavyTop", stop, samples), "top.position")
    found = top_path(np.linspace(0.0, stop, samples + 1), 0.0, 0.0)
    assert np.abs(found - expected).max() < 1e-9  # DOP853 at 1e-12


def test_gyroscope_cell():
    found = gyroscope_cell(0.4, 0.9)
    for motion in ("precession", "nutation"):
        assert found[motion]["minimum"] == pytest.approx(found[motion]["sigma"], abs=0.01)
        assert found[motion]["order"] == pytest.approx(3.0, abs=0.1)
        assert found[motion]["gain"] > 50
    assert "nutation" not in gyroscope_cell(1.0, 0.9)


@pytest.mark.parametrize(("formulation", "near"), [(INDEX3, 0.1), (STABILIZED, 0.05)])
def test_the_heavy_tops_optimum_is_predicted(formulation, near):
    """Up to the finite rate of its axis, κ = 0.03 to 0.05 of the spin."""
    found = top_cell(formulation, 1.0, 0.9)
    assert found["measured"] == pytest.approx(found["formula"], abs=near)
    assert found["gain"] > (15 if formulation == INDEX3 else 1.0)


def test_rotor_orders():
    found = rotor_orders(0.9, (2e-5, 1e-5), 0.1)["errors"]
    orders = {name: np.log2(coarse / fine) for name, (coarse, fine) in found.items()}
    assert orders.pop("spinOptimal") > 2.7
    assert orders.pop("σ* = 1.692") == pytest.approx(3.0, abs=0.1)
    assert list(orders.values()) == pytest.approx([2.0] * 3, abs=0.1)


def test_a_run_that_fails_has_no_error():
    """A rotation of more than π in a step."""
    found = scan("HighSpeedRotor", INDEX3, 2e-4, 0.02, [0.0, 1.0])
    assert np.isnan(found["errors"]).all()


@pytest.mark.parametrize("failed", [False, True])
def test_report(tmp_path, failed):
    """From made-up results: every figure and table is written, whatever ran."""
    gyroscope = {"sigma": 1.0, "minimum": 1.1, "order": 3.0, "gain": 100.0}
    made_up = {
        "scan": {"sigmas": [0.0, 1.0], "errors": [1e-3, np.nan], "spinOptimal": 1e-4},
        "orders": {"steps": [2e-5, 1e-5], "errors": {"σ = 1": [4e-6, 1e-6]}},
        "gyroscope": {"precession": gyroscope, "nutation": gyroscope},
        "top": {"formula": 1.67, "measured": 1.6, "gain": 17.0},
    }
    results = {
        mechanism: {
            cell.key: {"failed": "a reason"} if failed else made_up[cell.key.split()[0]]
            for cell in CHAPTER.cells(mechanism, quick=True)
        }
        for mechanism in SCANS
    }
    text = CHAPTER.report(results, tmp_path)
    for name in ("sigma_scan", "sigma_gyroscope", "sigma_orders", "sigma_top"):
        assert (tmp_path / f"{name}.csv").is_file()
    for name in ("sigma_scan.png", "sigma_gyroscope.png"):
        assert (tmp_path / name).is_file()
        assert name in text
    assert failed or "4.0e-06 | 1.0e-06 | 2.00" in text
    assert not failed or "fails" in text


def test_keys_are_unique():
    for mechanism in CHAPTER.mechanisms:
        keys = [cell.key for cell in CHAPTER.cells(mechanism, quick=False)]
        assert len(set(keys)) == len(keys)
