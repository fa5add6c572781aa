"""`sigmafmu sigma`: σ* by the closed form, and the σ that a scan finds, against what is known of the mechanisms."""

import re
import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

from sigmafmu import SigmafmuError
from sigmafmu.cli import app
from sigmafmu.model import Model
from sigmafmu.sigma import Advice, Scan, Spin, _spin, advise, figure, runs, sentences
from sigmafmu.spin_sigma import is_nearly_symmetric, mean_ratio, precession_sigma, unsymmetric_sigma


@pytest.fixture(scope="module")
def top(fmu):
    return advise(Model(fmu("HeavyTop")), {}, stop_time=1.0)


def test_the_heavy_tops_optimum_is_that_of_the_study(top):
    """docs/study/sigma_top.csv: 1.6 in index 3 (predicted 1.67), 1.03 in the stabilized form, at the end of 1 s."""
    (spin,) = top.spins
    assert (spin.body, spin.rate) == ("top", pytest.approx(150.0))
    assert spin.ratio == pytest.approx(2.0)
    assert spin.sigma == pytest.approx(precession_sigma(0.9, 2.0))
    index3, _, stabilized = top.scans
    assert index3.best == pytest.approx(1.6, abs=0.06)
    assert index3.gain > 10
    assert stabilized.best == pytest.approx(1.03, abs=0.1)
    assert "index3: σ = " in sentences(top)[0]
    assert "keep σ = 1" in sentences(top)[2]
    assert "--set integrator.formulation=index3" in sentences(top)[-1]


def test_the_rotors_optimum_is_the_closed_form(fmu):
    advice = advise(Model(fmu("HighSpeedRotor")), {"integrator.stepSize": 1e-5}, stop_time=0.05)
    (spin,), (scan,) = advice.spins, advice.scans
    assert scan.best == pytest.approx(spin.sigma, abs=0.02)
    assert scan.gain > 5


def test_what_is_set_counts(fmu):
    """ρ∞ moves σ*, an inertia moves p."""
    settings = {"integrator.spectralRadius": 1.0, "rotor.inertia.xx": 1e-3, "integrator.stepSize": 2e-5}
    advice = advise(Model(fmu("HighSpeedRotor")), settings, stop_time=0.002)
    (spin,) = advice.spins
    start = float(fmu("HighSpeedRotor").variables["rotor.inertia.yy"].start)
    assert spin.ratio == pytest.approx(1e-3 / start)
    assert spin.sigma == pytest.approx(4 / 3 + 2 / (3 * spin.ratio))
    with pytest.raises(SigmafmuError, match=r"'integrator.sigma' cannot be set here"):
        advise(Model(fmu("HighSpeedRotor")), {"integrator.sigma": 1.5})


def test_a_mechanism_at_rest_is_told(fmu):
    with pytest.raises(SigmafmuError, match=r"SpinUpBeam does not move in 0\.1 s; set an input"):
        advise(Model(fmu("SpinUpBeam")), {}, stop_time=0.1)


def test_progress_counts_every_run(fmu):
    count = []
    advise(Model(fmu("HighSpeedRotor")), {}, stop_time=0.001, advance=lambda: count.append(1))
    assert len(count) == runs(Model(fmu("HighSpeedRotor")))


@pytest.mark.parametrize("moments", [(0.2, 0.1, 0.1), (0.1, 0.1, 0.1), (0.05, 0.1, 0.1)])
def test_equal_transverse_moments_give_p(moments):
    ratio = moments[0] / moments[1]
    assert mean_ratio(moments) == pytest.approx(ratio)
    assert unsymmetric_sigma(0.9, moments) == pytest.approx(precession_sigma(0.9, ratio))


def test_nearly_equal_ones_are_close_to_that():
    assert mean_ratio((0.15, 0.1, 0.1 + 1e-9)) == pytest.approx(1.5)
    assert is_nearly_symmetric((0.15, 0.1, 0.105))
    assert not is_nearly_symmetric((0.11, 0.1, 0.13)), "the middle axis"


def test_spin_about_tilted_principal_axes():
    rotation, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    inertia = rotation @ np.diag([2.0, 1.3, 1.3]) @ rotation.T
    spin = _spin("body", inertia, 7.0 * rotation[:, 0] + 0.1 * rotation[:, 1], 0.9)
    assert spin.rate == pytest.approx(7.0)
    assert spin.sigma == pytest.approx(precession_sigma(0.9, 2.0 / 1.3))
    assert _spin("body", inertia, np.zeros(3), 0.9) == Spin("body", 0.0, None, None)


def test_the_default_is_kept_where_nothing_is_gained():
    flat = np.full(13, 1e-6)
    scans = [Scan(name, flat, 1e-6, 0.5, 0.9e-6, 1e-6) for name in ("index3", "index2", "stabilizedIndex2")]
    advice = Advice("M", 1e-3, 1.0, 0.9, [], scans)
    assert [s.split(";")[0] for s in sentences(advice)[:3]] == [f"{scan.formulation}: keep σ = 1" for scan in scans]
    assert "formulation=stabilizedIndex2 --set integrator.sigma=1" in sentences(advice)[-1]


def test_figure_has_a_curve_for_every_formulation(top):
    axes = figure(top).axes[0]
    labels = {text.get_text() for text in axes.get_legend().get_texts()}
    assert {"index3", "index2", "stabilizedIndex2", "σ* of top"} <= labels


def test_command(tmp_path):
    command = f"sigma HighSpeedRotor --stop-time 0.01 --plot {tmp_path / 's.png'}"
    result = CliRunner().invoke(app, shlex.split(command), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    assert re.search(r"rotor +2\.094e\+04 +0\.1 +1\.9 +1\.692", result.stdout)
    assert "all formulations" in result.stdout
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")
