"""The study: its machinery, the runs its chapters share, and what must hold of the results."""

import json
import re
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from research.measure import FORMULATION_NAMES, columns
from research.reference.minimal_coordinates import solve
from research.study import (
    CHAPTERS,
    algorithm1,
    cases,
    convergence,
    iterations,
    load,
    orderings,
    runner,
    runs,
    work_precision,
)
from research.study.cases import CASES
from research.study.chapter import Cell
from research.study.cli import study
from research.study.runs import INDEX3
from sigmafmu import SigmafmuError

EPS = float(np.finfo(float).eps)
every_mechanism = pytest.mark.parametrize("mechanism", CASES)


# --- the runner ------------------------------------------------------------------------------------------------------


@pytest.fixture
def work(monkeypatch):
    """Functions for cells, in a module that worker processes find too."""
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return import_module("study_work")


@dataclass
class Dummy:
    """A chapter with the given cells."""

    work: list[Cell]
    name: str = "dummy"
    title: str = "Dummy"
    mechanisms: tuple[str, ...] = ("HeavyTop",)

    def cells(self, mechanism, quick):
        return self.work


def run(cells, folder, mechanisms=("HeavyTop",)):
    advanced = []
    chapter = Dummy(cells)
    results = runner.run(runner.jobs([chapter], mechanisms, False), folder, 2, lambda: advanced.append(1))
    assert len(advanced) == len(cells)
    return results["dummy"]["HeavyTop"]


def calls(log):
    return log.read_text().count("called") if log.exists() else 0


def test_results_come_in_the_order_of_the_cells_as_plain_values(tmp_path, work):
    log = tmp_path / "log"
    cells = [Cell(f"{i}", work.count, (str(log), i), alone=i % 2 == 0) for i in range(4)]
    found = run(cells, tmp_path / "study")
    assert list(found) == ["0", "1", "2", "3"]
    assert [found[key]["value"] for key in found] == [0, 1, 2, 3]
    assert found["0"]["array"] == [0, 1, 2]
    assert np.isnan(found["0"]["missing"])
    assert calls(log) == 4


def test_finished_work_is_not_done_again(tmp_path, work):
    """But when an argument changed or the file is damaged, it is."""
    log, folder = tmp_path / "log", tmp_path / "study"
    first = run([Cell("a/b σ", work.count, (str(log), 1.0))], folder)
    again = run([Cell("a/b σ", work.count, (str(log), 1.0))], folder)
    assert calls(log) == 1
    assert again["a/b σ"]["array"] == first["a/b σ"]["array"]
    changed = run([Cell("a/b σ", work.count, (str(log), 2.0))], folder)
    assert (calls(log), changed["a/b σ"]["value"]) == (2, 2.0)
    (kept,) = folder.rglob("*.json")
    kept.write_text(kept.read_text()[:20])
    run([Cell("a/b σ", work.count, (str(log), 2.0))], folder)
    assert calls(log) == 3


def test_the_fastest_pass_counts(tmp_path, work):
    """Of what is timed; a study that has done some passes does those that are missing."""
    log, folder = tmp_path / "log", tmp_path / "study"
    cells = [Cell("timed", work.timed, (str(log),), alone=True), Cell("other", work.count, (str(log) + "2", 1.0))]
    for passes, expected in ((1, 3.0), (2, 2.0), (2, 2.0), (3, 2.0)):
        advanced = []
        found = runner.run(
            runner.jobs([Dummy(cells)], ["HeavyTop"], False), folder, 2, lambda to=advanced: to.append(1), passes
        )
        assert found["dummy"]["HeavyTop"]["timed"] == {"runs": [{"seconds": expected, "call": 1}]}
        assert len(advanced) == passes + 1
        assert calls(log) == passes


def test_work_finished_before_an_error_is_kept(tmp_path, work):
    log, folder = tmp_path / "log", tmp_path / "study"
    good, bad = Cell("good", work.count, (str(log), 1.0)), Cell("bad", work.raise_error, (), alone=True)
    with pytest.raises(RuntimeError, match="study, dummy, HeavyTop, bad: a bug"):
        run([good, bad], folder)
    run([good], folder)
    assert calls(log) == 1


def test_results_of_another_core_are_stale(tmp_path, work, monkeypatch):
    log, folder = tmp_path / "log", tmp_path / "study"
    run([Cell("a", work.count, (str(log), 1.0))], folder)
    monkeypatch.setattr(runner, "_environment", lambda: "another core")
    run([Cell("a", work.count, (str(log), 1.0))], folder)
    assert calls(log) == 2


def test_keys_must_differ(work):
    cell = Cell("a", work.raise_error, ())
    with pytest.raises(ValueError, match="dummy, HeavyTop: two cells have the same key"):
        runner.jobs([Dummy([cell, cell])], ["HeavyTop"], False)


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(SigmafmuError, match="cannot write"):
        run([], file)


@every_mechanism
@pytest.mark.parametrize("quick", [False, True])
def test_every_chapter_has_cells_that_can_be_kept(mechanism, quick):
    """Keys differ, arguments and functions survive the way to a worker and back."""
    for chapter in load():
        if mechanism in chapter.mechanisms:
            found = runner.jobs([chapter], [mechanism], quick)
            assert found
            assert len({runner.fingerprint(cell) for _, _, cell in found}) == len(found)


# --- the command -----------------------------------------------------------------------------------------------------


def command(*arguments):
    app = typer.Typer()
    app.callback()(lambda: None)
    app.command()(study)
    return CliRunner().invoke(app, ["study", *arguments])


def test_command_writes_the_report(tmp_path):
    result = command("rotor", "--quick", "--chapter", "histories", "--output", str(tmp_path))
    assert result.exit_code == 0, result.output
    text = (tmp_path / "README.md").read_text()
    assert "`python -m research study rotor --quick --chapter histories`" in text
    images = re.findall(r"!\[[^]]+\]\(([^)]+)\)", text)
    assert images == ["histories_HighSpeedRotor.png"]
    for image in images:
        assert (tmp_path / image).read_bytes().startswith(b"\x89PNG")
    lines = (tmp_path / "histories_HighSpeedRotor.csv").read_text().splitlines()
    assert len(lines) == 502


def test_unknown_chapter_is_named(tmp_path):
    result = command("rotor", "--chapter", "nonsense", "--output", str(tmp_path))
    assert isinstance(result.exception, SigmafmuError)
    assert str(result.exception) == f"there is no chapter nonsense; there are {', '.join(CHAPTERS)}"


def test_command_fails_when_an_ordering_does_not_hold(tmp_path, monkeypatch):
    monkeypatch.setattr(orderings, "violations", lambda _: ["geom1 is better"])
    result = command("rotor", "--quick", "--chapter", "histories", "--output", str(tmp_path))
    assert isinstance(result.exception, SigmafmuError)
    assert "geom1 is better" in str(result.exception)


# --- runs ------------------------------------------------------------------------------------------------------------


@every_mechanism
def test_velocity_of_the_followed_point_is_the_rate_of_its_position(mechanism):
    """By central differences of the independent solution; their error is h²/6 times the third derivative."""
    dt = {"HeavyTop": 1e-4, "HighSpeedRotor": 1e-6, "SliderCrank": 1e-4}[mechanism]
    history = solve(mechanism, np.array([0.0, 0.01, 0.01 + dt, 0.01 + 2 * dt]))
    position, velocity = runs.point_motion(mechanism, history)
    rate = (position[3] - position[1]) / (2 * dt)
    np.testing.assert_allclose(rate, velocity[2], rtol=0, atol=1e-3 * np.linalg.norm(velocity[2]))


def test_followed_point_of_the_rotor_is_its_right_bearing():
    history = solve("HighSpeedRotor", np.array([0.0, 0.01]))
    position, _ = runs.point_motion("HighSpeedRotor", history)
    np.testing.assert_allclose(position, columns(history, "rightSupport.position"), rtol=0, atol=4 * EPS)


@every_mechanism
def test_geom1_of_ours_and_of_exudyn_are_one_method(mechanism):
    """Two codes, one scheme: errors agree to the tolerance of Newton's method, here a hundredth of them."""
    h, stop_time = {"HeavyTop": (1e-3, 0.2), "HighSpeedRotor": (2e-5, 0.01), "SliderCrank": (2.5e-3, 0.5)}[mechanism]
    one = runs.ours(mechanism, h, stop_time, **cases.settings(mechanism, INDEX3, sigma=0.0))
    two = runs.exudyn(mechanism, h, stop_time, **cases.peer_settings(mechanism, INDEX3, "geom1"))
    for error in CASES[mechanism].errors:
        if error != "multipliers":  # Exudyn starts with others
            assert one[error] == pytest.approx(two[error], rel=1e-2)


def test_a_run_that_fails_says_why():
    found = runs.ours("HeavyTop", 0.05, 2.5)  # 7.5 rad in a step
    assert found["h"] == 0.05
    assert "step failed" in found["failed"]
    found = runs.exudyn("HeavyTop", 1e-3, 1.0, **cases.peer_settings("HeavyTop", INDEX3, "Tait-Bryan"))
    assert found["failed"]


def test_stop_time_must_fit_the_samples():
    with pytest.raises(ValueError, match="no multiple of 50 steps"):
        runs.ours("HeavyTop", 3e-4, 1.0)


# --- chapters --------------------------------------------------------------------------------------------------------


def test_best_sigma_is_the_minimum_of_a_scan():
    settings = cases.settings("HeavyTop", INDEX3)
    best = convergence.best_sigma("HeavyTop", 5e-4, 0.25, settings)
    scan = np.linspace(1.0, 2.4, 29)
    errors = [runs.ours("HeavyTop", 5e-4, 0.25, sigma=sigma, **settings)["position"] for sigma in scan]
    assert best == pytest.approx(scan[np.argmin(errors)], abs=0.06)  # a step of the scan and the search's tolerance


@every_mechanism
def test_residual_form_converges_with_order_two(mechanism):
    case = CASES[mechanism]
    for formulation, rho in cases.formulations(mechanism).items():
        settings = cases.settings(mechanism, formulation)
        cell = convergence.converge(mechanism, case.steps(True), case.time(True), cases.sigma_of("1", rho), settings)
        curve = convergence.Curve(mechanism, f"{FORMULATION_NAMES[formulation]}/residual/1", json_round_trip(cell))
        assert curve.order("position") == pytest.approx(2.0, abs=0.1)


def json_round_trip(cell):
    return json.loads(json.dumps(cell, default=runner._plain))


@every_mechanism
def test_algorithm_1_written_twice_is_one(mechanism):
    """The core's incremental form and the lines of the paper in NumPy, both iterated to rounding.

    On the slider-crank Newton's method ends above it, since the constraints' λ is 1e4 times stiffer than the motion.
    """
    h, stop_time = {"HeavyTop": (1e-3, 0.1), "HighSpeedRotor": (2e-5, 0.002), "SliderCrank": (2.5e-3, 0.25)}[mechanism]
    found = algorithm1.by_hand(mechanism, h, stop_time, 0.9, "hβ/γ")
    assert found["difference"] <= {"HeavyTop": 1e-12, "HighSpeedRotor": 1e-14, "SliderCrank": 1e-10}[mechanism]
    assert found["position"] > 1e3 * found["difference"]


@pytest.mark.parametrize("mechanism", ["HeavyTop", "HighSpeedRotor"])
def test_exudyn_takes_half_the_factor_of_line_6(mechanism):
    """Its error is that of Algorithm 1 with hβ/(2γ) within 3 %, and not that of the printed one.

    The bodies of the slider-crank turn too slowly to tell the two apart.
    """
    h, stop_time = algorithm1.STEPS[mechanism], algorithm1.QUICK_TIMES[mechanism]
    rho = CASES[mechanism].rho_inf[INDEX3]
    printed, halved = (
        algorithm1.by_hand(mechanism, h, stop_time, rho, line6)["position"] for line6 in ("hβ/γ", "hβ/(2γ)")
    )
    peer = runs.exudyn(mechanism, h, stop_time, **cases.peer_settings(mechanism, INDEX3, "σ-modified"))["position"]
    assert peer == pytest.approx(halved, rel=0.03)
    assert peer != pytest.approx(printed, rel=0.03)


@every_mechanism
def test_residual_form_depends_on_no_path(mechanism):
    """To Newton's tolerance, here 1e-5 of the discretization error, with every matrix."""
    h, stop_time = algorithm1.STEPS[mechanism], algorithm1.QUICK_TIMES[mechanism]
    exact, _ = runs.point_motion(mechanism, runs.exact(mechanism, stop_time))
    for formulation in cases.formulations(mechanism):
        settings = cases.settings(mechanism, formulation) | algorithm1.TIGHT
        first, *others = (
            runs.point_motion(mechanism, runs.trajectory(mechanism, h, stop_time, **settings, **newton)[0])[0]
            for newton in iterations.VARIANTS.values()
        )
        assert len(others) == 2
        error = np.linalg.norm(first - exact, axis=1).max()
        assert max(np.linalg.norm(other - first, axis=1).max() for other in others) <= 1e-5 * error


def test_figures_of_the_paper_are_for_schemes_of_the_table():
    for mechanism, figures in iterations.PAPER.items():
        for formulation, label in figures:
            assert formulation in CASES[mechanism].rho_inf
            assert label in (*cases.SIGMAS, *cases.PEERS)


def test_time_to_an_accuracy_is_interpolated_in_logarithms():
    """error = 1/t²: 1e-4 takes 100 s; what the largest step reaches has a bound, what none reaches is unknown."""
    runs_of = [{"h": 1 / t, "position": t**-2.0, "seconds": t} for t in (10.0, 30.0, 500.0)]
    runs_of.insert(0, {"h": 1.0, "failed": "diverged"})
    curve = work_precision.Curve("index 3/sigmafmu/full/1", {"sigma": 1.0, "runs": runs_of})
    assert curve.time_to(1e-4) == pytest.approx(100.0, rel=8 * EPS)
    assert curve.milliseconds(1e-4) == "1e+05"
    assert curve.milliseconds(0.1) == "≤ 1e+04"
    assert curve.milliseconds(1e-8) == "–"


@every_mechanism
def test_orderings_hold(mechanism):
    """Residual σ = 1 beats geom1 by 2 (slider-crank: no worse); stabilized index 2 runs up to hω = 0.3."""
    cells = orderings.CHAPTER.cells(mechanism, quick=True)
    found = {cell.key: json_round_trip(cell.function(*cell.arguments)) for cell in cells}
    assert len([key for key in found if key.startswith("stability")]) == 3
    assert orderings.violations({mechanism: found}) == []


def test_orderings_that_do_not_hold_are_found():
    runs_map = {
        "cells": [{"rho": 0.9, "hOmega": 0.3, "outcome": "diverges"}, {"rho": 0.9, "hOmega": 0.6, "outcome": "stops"}]
    }
    found = {"gain/index 3": {"gain": 1.9}, "gain/index 2": {"failed": "no"}, "stability/1": runs_map}
    assert orderings.violations({"HeavyTop": found}) == [
        "HeavyTop, index 3: σ = 1 gains 1.9, not 2",
        "HeavyTop, index 2: σ = 1 gains 0, not 2",
        "HeavyTop, σ = 1, ρ∞ = 0.9, hω = 0.3: diverges",
    ]
