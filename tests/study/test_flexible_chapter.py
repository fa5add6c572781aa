"""Flexible bodies: what the study and the page on them say holds, in a small version."""

from pathlib import Path

import numpy as np
import pytest

from research.reference import rotating_beam, vector_columns
from research.reference.clouds import SpinUp
from research.study import FLEXIBLE_CHAPTERS, flexible_bending, flexible_limits, load
from research.study.flexible_accuracy import RIGID, Curve, ways
from research.study.flexible_runs import (
    CASES,
    ERRORS,
    OTHERS,
    PEERS,
    centre_line,
    errors,
    exact,
    explicit,
    generalized_alpha,
    ours,
    peer,
    point,
    rigid_steps,
    states,
)
from research.study.flexible_work import work_tolerances
from sigmafmu.compare import read_reference

EPS = float(np.finfo(float).eps)
REFERENCES = Path(__file__).resolve().parents[1] / "references"
SPANS = {"FlexiblePendulum": 0.05, "FlexibleSliderCrank": 0.025, "SpinUpBeam": 2.0}  # s
STEPS = {"FlexiblePendulum": 1.25e-4, "FlexibleSliderCrank": 6.25e-5, "SpinUpBeam": 1e-2}  # s, asymptotic
every_mechanism = pytest.mark.parametrize("mechanism", CASES)


def run(mechanism, factor=1, **settings):
    return ours(mechanism, factor * STEPS[mechanism], SPANS[mechanism], **settings)


# --- the runs --------------------------------------------------------------------------------------------------------


@every_mechanism
def test_errors_are_those_against_the_reference_files(mechanism):
    """The study solves the equations again, at its own times; where they meet those of the file both are the same."""
    header, file = read_reference(REFERENCES / f"{mechanism}.csv")
    assert header["model"] == mechanism
    case, span = CASES[mechanism], max(SPANS[mechanism], 0.05)
    solution = exact(mechanism, span)
    _, rows, at = np.intersect1d(file["time"].round(9), solution["time"].round(9), return_indices=True)
    assert len(rows) >= 5
    for name, size in ((f"{case.point}.position", 3), (f"{case.body}.modal", case.modes)):
        for column in vector_columns(name, size):
            np.testing.assert_allclose(solution[column][at], file[column][rows], atol=1e-12)


def test_an_error_is_noticed():
    """The solution itself has none; one modal coordinate at one time is enough."""
    span = SPANS["FlexiblePendulum"]
    wrong = {name: values.copy() for name, values in exact("FlexiblePendulum", span).items()}
    assert set(errors("FlexiblePendulum", wrong, span).values()) == {0.0}
    wrong["beam.modal[3]"][7] += 1e-9
    assert errors("FlexiblePendulum", wrong, span) == pytest.approx(
        {"position": 0.0, "modal": 1e-9, "angularVelocity": 0.0}, rel=1e-6
    )
    wrong["beam.modal[3]"] += 10
    assert "diverged" in errors("FlexiblePendulum", wrong, span)["failed"]


def test_a_step_that_is_no_part_of_the_samples_is_refused():
    with pytest.raises(ValueError, match="no multiple"):
        states("FlexiblePendulum", 3e-4, np.array([0.0, 1e-3]))


@pytest.mark.parametrize("mechanism", flexible_bending.SCENES)
def test_followed_point_is_on_the_centre_line(mechanism):
    q, _, _ = states(mechanism, 1e-3, np.array([0.0, 0.02]))
    lines = np.array([centre_line(mechanism, row) for row in q])
    assert lines.shape == (2, 11, 3)
    np.testing.assert_array_equal(point(mechanism, q), lines[:, CASES[mechanism].section])


# --- convergence -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("mechanism", "name"), [(mechanism, name) for mechanism in CASES for name in ways(mechanism)])
def test_orders(mechanism, name):
    """2 in positions, modal coordinates and angular velocity; 4 of rkmk4, 5 of rkmk54 above rounding."""
    settings = ways(mechanism)[name]
    order = {2: 4, 3: 5}.get(settings.get("method"), 2)
    larger = 4 if explicit(settings) else 1  # far from rounding
    coarse, fine = (run(mechanism, factor, **settings) for factor in (2 * larger, larger))
    for quantity in ERRORS:
        assert np.log2(coarse[quantity] / fine[quantity]) == pytest.approx(order, abs=0.25 if order == 5 else 0.1)


@every_mechanism
@pytest.mark.parametrize("formulation", [1, 2, 3])
def test_sigma_makes_no_difference(mechanism, formulation):
    """0.1 % in the modal coordinates and the angular velocity; the tip of the pendulum gains 10 %."""
    geom1, *others = (run(mechanism, formulation=formulation, sigma=sigma) for sigma in (0.0, 1.0, 0.69))
    for other in others:
        assert other["modal"] == pytest.approx(geom1["modal"], rel=1e-3)
        assert other["angularVelocity"] == pytest.approx(geom1["angularVelocity"], rel=1e-3)
        assert other["position"] == pytest.approx(geom1["position"], rel=0.1)


def test_sigma_makes_one_for_the_rigid_beam():
    """Bending hides it: the same nodes as a rigid body have an eighth of the error, and σ = 1 a third of that."""
    rigid = rigid_steps((STEPS["FlexiblePendulum"],), SPANS["FlexiblePendulum"])
    geom1, one = (rigid[f"stabilized index 2, {name}"][0] for name in ("geom1 (σ = 0)", "σ = 1"))
    assert one < 0.5 * geom1
    assert geom1 < 0.5 * run("FlexiblePendulum", sigma=0.0)["position"]


@every_mechanism
def test_formulations_and_groups_agree(mechanism):
    """With these steps the bending makes the errors, whatever is done to the joints: within 5 %."""
    base = run(mechanism)
    for settings in ({"formulation": 1}, {"formulation": 2}, {"group": 2}):
        other = run(mechanism, **settings)
        for quantity in ERRORS:
            assert other[quantity] == pytest.approx(base[quantity], rel=0.05)


@every_mechanism
@pytest.mark.parametrize("settings", [{}, {"formulation": 1}, {"group": 2}, {"method": 4}], ids=str)
def test_newton_needs_two_iterations(mechanism, settings):
    """The Jacobian is exact: the second iteration converges quadratically, with one matrix for both."""
    found = run(mechanism, **settings)
    assert found["iterations"] == pytest.approx(2.0, abs=0.05)
    assert found["jacobians"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.exudyn
@every_mechanism
def test_exudyn_has_the_same_errors(mechanism):
    """geom1 in index 3 is one method in two codes. SpinUpBeam turns about one axis, where Euler parameters are the same
    method, and starts from rest, where Exudyn's rotation vectors lose turns below 1e-7 rad a step.
    """
    way = PEERS["index 3, Euler parameters" if mechanism == "SpinUpBeam" else "index 3, geom1"]
    theirs = peer(mechanism, STEPS[mechanism], SPANS[mechanism], **way, relative_tolerance=1e-11)
    found = run(mechanism, formulation=1, sigma=0.0)
    for quantity in ERRORS:
        assert theirs[quantity] == pytest.approx(found[quantity], rel=0.02)


def test_rkmk54_obeys_its_tolerance():
    """Steps are longer than the tolerance allows and are cut, and the error falls with it."""
    coarse, fine = work_tolerances("FlexiblePendulum", 1e-2, 0.5, 1, (1e-5, 1e-9))["runs"]
    assert fine["position"] < 1e-3 * coarse["position"] < 1e-8
    assert fine["steps"] > coarse["steps"] > 50
    assert min(fine["seconds"], coarse["seconds"]) > 0


# --- limits ----------------------------------------------------------------------------------------------------------


def test_linear_modes_bend_as_far_as_the_formula_says():
    """1 % more than the chain at 0.5 rad/s; the swinging about the mean is a fifth of that difference."""
    modes = flexible_limits.modes_deflection(0.5)
    chain = flexible_limits.chain_deflection(0.5, (6, 12))
    found = flexible_limits.measured_excess(modes, chain)
    assert found == pytest.approx(flexible_limits.excess(0.5), rel=0.25)
    assert found > 0.005


def test_linear_modes_diverge_above_the_first_eigenfrequency():
    """The published manoeuvre, to 6 rad/s: the beam is 8 m long."""
    run = flexible_limits.modes_deflection(6.0)
    assert "failed" in run or np.abs(run["deflection"]).max() > 8.0


def test_turning_softens_modes_and_stiffens_a_beam():
    """The square of the first frequency falls to zero where Ω meets it, and on by Ω² to about 1 %."""
    frequencies = flexible_limits.turning_frequencies()
    modes, stiffened = (np.array(frequencies[name]) for name in ("modes", "stiffened"))
    np.testing.assert_allclose(modes, modes[0] - flexible_limits.TURNING**2, atol=1e-9)
    assert (np.diff(stiffened) > 0).all()
    assert stiffened[0] == pytest.approx(modes[0], rel=2e-3)  # 40 lumped sections with rotary inertia
    beam = SpinUp()
    scale = beam.bending / (beam.mass * beam.length**3)
    expected = stiffened[0] + (rotating_beam.southwell(0) - 1.0) * flexible_limits.TURNING[5] ** 2
    assert stiffened[5] == pytest.approx(expected, rel=1e-3)
    assert stiffened[0] == pytest.approx(rotating_beam.frequencies(0.0, in_plane=True)[0] * scale, rel=EPS * 100)


# --- the chapters ----------------------------------------------------------------------------------------------------


def test_bent_lines_start_straight_and_keep_their_held_ends():
    lines = flexible_bending.centre_lines("FlexibleSliderCrank")
    bent, straight = (np.array(lines[name]) for name in ("bent", "straight"))
    np.testing.assert_allclose(bent[0], straight[0], atol=10 * EPS)
    np.testing.assert_allclose(bent[:, [0, -1]], straight[:, [0, -1]], atol=10 * EPS)  # sin 0, sin π
    assert np.abs(bent - straight).max() > 1e-3
    np.testing.assert_allclose(np.array(lines["deflection"])[:, :, 0], 0.0, atol=10 * EPS)  # sections turn, not stretch


def test_reports(tmp_path):
    """Text and files from results that take little to make."""
    small = {
        "FlexiblePendulum": {f"sigmafmu/{name}": _falling(4.0) for name in ways("FlexiblePendulum")}
        | {f"Exudyn/{name}": _falling(4.0) for name in PEERS}
        | {RIGID: {name: [1e-8] for name in generalized_alpha()}}
    }
    accuracy, work, limits, bending = load(FLEXIBLE_CHAPTERS)
    text = accuracy.report(small, tmp_path)
    assert text.count("2.00") == 3 * (3 + len(OTHERS) + len(PEERS))
    assert (tmp_path / "flexible_accuracy_FlexiblePendulum.png").stat().st_size > 1000
    assert not {chapter.name for chapter in (accuracy, work, limits, bending)} - set(FLEXIBLE_CHAPTERS)
    for chapter in (accuracy, work, limits, bending):
        for mechanism in chapter.mechanisms:
            for quick in (True, False):
                keys = [cell.key for cell in chapter.cells(mechanism, quick)]
                assert len(set(keys)) == len(keys) > 0


def _falling(ratio):
    """Runs whose errors fall by `ratio` with each halved step."""
    return {"runs": [{"h": 1e-3 / 2**i, **dict.fromkeys(ERRORS, 1e-4 / ratio**i)} for i in range(3)]}


def test_a_curve_leaves_out_what_fails():
    curve = Curve([{"h": 4e-3, "failed": "why"}, *_falling(4.0)["runs"]])
    assert np.isnan(curve.errors("modal")[0])
    assert curve.order("modal") == pytest.approx(2.0)
