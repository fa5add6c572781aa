"""What `make bench` measures: all codes run the same mechanisms, all solvers the same equations; how it is told."""

import re
import shutil
import stat
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse

from research.bench import Effort, growth, limits, machine, page, robots, runs, solvers, steps, trees, work
from research.mechanisms import FAMILIES, MECHANISMS, linkages, named
from sigmafmu import SigmafmuError, _core

ROOT = Path(__file__).resolve().parents[2]
CENTER = np.zeros(3)
RKMK4 = 2
TREES = ("RevoluteArm7", "Chain5", "RevoluteChain5", "RandomTree12")


# --- all codes run the same mechanism --------------------------------------------------------------------------------


def finely(name: str, h: float, count: int) -> np.ndarray:
    """Our fourth-order method."""
    tight = {"absolute_tolerance": 1e-13, "relative_tolerance": 1e-13}
    return runs.core(named(name), h, count, CENTER, method=RKMK4, **tight).position


@pytest.mark.parametrize("name", [*TREES, "FreeBody"])
def test_mujoco_moves_as_we_do(name):
    """Two methods of order four: 1e-8 m after 0.2 s, of which the links move some 0.1 m."""
    pytest.importorskip("mujoco", reason="needs MuJoCo; `make bench` installs it")
    run = runs.mujoco(named(name).multibody, 1e-3, 200, CENTER, "RK4")
    assert np.abs(run.position - finely(name, 1e-3, 200)).max() <= 1e-8


@pytest.mark.parametrize("name", TREES)
def test_pinocchio_moves_as_we_do(name):
    pytest.importorskip("pinocchio", reason="needs Pinocchio; `make bench` installs it")
    run = runs.pinocchio_rk4(named(name).multibody, 1e-3, 200, CENTER, aba=1e-6)
    assert np.abs(run.position - finely(name, 1e-3, 200)).max() <= 1e-8
    assert run.seconds == 4e-6


def test_a_free_base_has_no_runge_kutta_steps_in_pinocchio():
    pytest.importorskip("pinocchio", reason="needs Pinocchio; `make bench` installs it")
    with pytest.raises(SigmafmuError, match="body body has a free joint"):
        runs.pinocchio_rk4(named("FreeBody").multibody, 1e-3, 1, CENTER, aba=1e-6)


@pytest.mark.exudyn
@pytest.mark.parametrize("name", ["RevoluteArm7", "Chain5", "RevoluteChain5", "PlanarFourBar", "Bricard"])
@pytest.mark.parametrize("dense", [True, False], ids=["dense", "sparse"])
def test_exudyn_moves_as_we_do(name, dense):
    """A method of order two: halving the step brings it four times nearer."""
    linkage = {"PlanarFourBar": linkages.planar_four_bar, "Bricard": linkages.bricard}.get(name)
    mechanism = linkage(linkages.REGULAR[linkage]) if linkage else named(name)
    exact = finely(name, 1e-3, 200)
    errors = [
        np.abs(runs.exudyn(mechanism.multibody, 0.2 / n, n, CENTER, sparse=not dense).position - exact).max()
        for n in (100, 200)
    ]
    assert errors[1] <= 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.25)


@pytest.mark.parametrize("tree", [linkages.planar_four_bar(), linkages.door()], ids=lambda m: m.name)
def test_loops_are_no_trees(tree):
    with pytest.raises(
        SigmafmuError, match="a body is the second one of two joints, or the ground is; that makes no tree"
    ):
        trees.links(tree.multibody)


@pytest.mark.exudyn
def test_exudyn_gets_nothing_it_does_not_have():
    from research.reference.exudyn_models import of_definition

    with pytest.raises(SigmafmuError, match="the mechanism has wristPin, guide; Exudyn gets"):
        of_definition(_core.mechanism("SliderCrank").multibody)


def test_the_fastest_run_is_kept():
    seconds = {"a": iter([3.0, 1.0, 2.0]), "b": iter([1.0, 2.0, 3.0])}
    order = []

    def candidate(key: str) -> runs.Run:
        order.append(key)
        return runs.Run(next(seconds[key]), 0.0, CENTER)

    found = runs.fastest({key: partial(candidate, key) for key in "ab"}, 3)
    assert {key: run.seconds for key, run in found.items()} == {"a": 1.0, "b": 1.0}
    assert "".join(order) == "ababab"


def test_every_mechanism_is_timed():
    names = {case.name for case in steps.CASES}
    assert set(MECHANISMS) | set(_core.mechanisms()) <= names
    for family in FAMILIES:
        assert any(name.startswith(family) for name in names)


# --- the linear solver -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["RevoluteArm7", "Chain5", "RandomTree12", "HeavyTop"])
def test_sparse_blocks_are_those_of_the_dense_ones(name):
    mechanism = _core.mechanism(name) if name == "HeavyTop" else named(name)
    system = _core.System(mechanism.multibody)
    rng = np.random.default_rng(1)
    q, _ = _core.assemble(mechanism.multibody)
    v, multipliers = rng.normal(size=system.velocity_size), rng.normal(size=system.constraint_size)
    found = system.entries(q, v, multipliers)
    expected = (
        *system.linearization(q, v, multipliers, np.zeros(system.input_size)),
        *system.constraints(q, v)[2:],
    )
    for entries, b in zip(found, expected, strict=True):
        assert np.array_equal(sparse.coo_matrix(entries, b.shape).toarray(), b)


@pytest.mark.parametrize("form", solvers.FORMS)
@pytest.mark.parametrize("name", ["Chain5", "RevoluteChain5"])
def test_every_solver_solves_the_same_equations(name, form):
    e = solvers.newton_matrices(named(name))[form]
    exact = np.linalg.solve(e.A.toarray(), e.b)
    libraries = {"SuperLU": solvers.superlu}
    if solvers.EIGEN.exists():
        libraries["Eigen"] = solvers.eigen
    try:
        import kvxopt  # noqa: F401

        libraries |= {"KLU": solvers.klu, "UMFPACK": solvers.umfpack}
    except ImportError:
        pass
    for x, seconds in (solvers.ours(named(name), solvers.FORMS[form], e), *(solve(e) for solve in libraries.values())):
        assert np.abs(x - exact).max() <= 1e-10 * np.abs(exact).max()
        assert seconds > 0


def test_a_matrix_must_fit_the_solver():
    solver = _core.KktSolver(named("Chain5").multibody, _core.Kkt.newton)
    size = 5 * 9
    for A, b, repeats in (
        (sparse.eye(size + 1), np.ones(size), 1),
        (sparse.eye(size), np.ones(size - 1), 1),
        (sparse.eye(size), np.ones(size), 0),
    ):
        with pytest.raises(ValueError, match="A or b has the wrong size, or repeats is below 1"):
            solver.timed(A.tocsc(), b, repeats)
    with pytest.raises(ValueError, match="A has entries outside the pattern"):
        solver.timed(sparse.csc_matrix(np.ones((size, size))), np.ones(size), 1)
    with pytest.raises(RuntimeError, match="singular"):
        solver.timed(sparse.csc_matrix((size, size)), np.ones(size), 1)


# --- limit kernels ---------------------------------------------------------------------------------------------------


@pytest.fixture
def kernels(tmp_path, monkeypatch):
    """Programs that print these lines."""

    def write(**lines: str) -> None:
        for program, text in lines.items():
            path = tmp_path / program
            path.write_text(f"#!/bin/sh\ncat <<'END'\n{text}\nEND\n", encoding="utf-8")
            path.chmod(path.stat().st_mode | stat.S_IXUSR)

    monkeypatch.setenv(limits.VARIABLE, str(tmp_path))
    limits._output.cache_clear()
    yield write
    limits._output.cache_clear()


def test_limit_kernels_are_read(kernels):
    kernels(
        rotor_base="O2  DROP=0 rotor full     tol   h=1.0e-05 min 319.1 med 330.9 ns/step it 1.00  x=0",
        chain_base="O2 N=  10 block6 LU       min     4.65 med     4.76 us/step  it 1.84  min  252.7 ns/body/it",
    )
    assert limits.seconds_per_step("HighSpeedRotor") == pytest.approx(319.1e-9)
    assert limits.chains() == {10: (pytest.approx(4.65e-6), pytest.approx(252.7e-9))}
    assert limits.seconds_per_step("Bricard") is None


def test_limit_kernels_that_are_not_there(kernels):
    with pytest.raises(SigmafmuError, match=r"SIGMAFMU_LIMITS is .*; there is no program top_base in it"):
        limits.seconds_per_step("HeavyTop")
    kernels(top_base="nothing of use")
    with pytest.raises(SigmafmuError, match="top_base does not print the line"):
        limits.seconds_per_step("HeavyTop")


def test_nothing_is_known_without_limit_kernels(monkeypatch):
    monkeypatch.delenv(limits.VARIABLE, raising=False)
    limits._output.cache_clear()
    assert limits.seconds_per_step("HeavyTop") is None
    assert limits.chains() == {}


# --- what is told ----------------------------------------------------------------------------------------------------


def series(order: int, *points: tuple[float, float]) -> list[dict]:
    return [{"order": order, "ms": ms, "error": error} for ms, error in points]


def test_time_to_an_error():
    second = series(2, (1, 1e-3), (2, 2.5e-4), (4, 6.25e-5))
    assert work.time_to(second, 1e-2) == "< 1"
    assert work.time_to(second, 2.5e-4) == "2"
    assert work.time_to(second, 1.25e-4) == f"{2 * 2**0.5:.2g}"
    assert work.time_to(second, 6.25e-7) == "≈ 40"  # ten times as many steps
    stagnating = series(4, (1, 1e-6), (2, 1e-7), (4, 0.9e-7))
    assert work.time_to(stagnating, 1e-8) == "–"
    assert work.time_to(series(2, (1, 1e-3)), 1e-6) == "–"


def test_a_work_report_has_a_row_for_each_method(tmp_path):
    rows = [
        {"mechanism": "HeavyTop", "method": method, "h": 1e-3, **row}
        for method in ("ours, default", "other")
        for row in series(2, (1, 1e-3), (2, 2.5e-4))
    ]
    text = work.report(rows, tmp_path)
    assert "| ours, default | ≈ 3.2 |" in text
    assert "| other |" in text
    assert (tmp_path / work.FIGURE).stat().st_size > 1000


def test_robots_are_told_honestly(tmp_path):
    row = dict.fromkeys(robots.HEADER, 1e3) | {"mechanism": "Arm", "bodies": 7, "pinocchio_aba": 250.0}
    assert "No explicit code was faster than ours" in robots.report([row], tmp_path)
    assert "is faster than ours on Arm:" in robots.report([row | {"mujoco_rk4": 500.0}], tmp_path)


def test_growth_of_some_sizes(tmp_path, monkeypatch):
    """Without Exudyn: our step, start and memory."""
    monkeypatch.setattr(growth, "EXUDYN", ())
    monkeypatch.setattr(growth, "QUICK_SIZES", (1, 3))
    monkeypatch.setattr(growth, "BODY_STEPS", 30)
    monkeypatch.delenv(limits.VARIABLE, raising=False)
    limits._output.cache_clear()
    rows = growth.measure(Effort(quick=True, rounds=1, tell=lambda what: None))
    assert [(row["family"], row["size"]) for row in rows] == [(f, n) for n in (1, 3) for f in FAMILIES]
    assert [row["bodies"] for row in rows if row["family"] == "FourBarRow"] == [3, 7]
    for row in rows:
        assert row["us_per_step"] > 0
        assert row["start_ms"] > 0
        assert np.isnan(row["bytes_per_body"]) or 1e3 < row["bytes_per_body"] < 1e6
    text = growth.report(rows, tmp_path)
    assert "| row of four-bars |" in text
    assert (tmp_path / growth.FIGURE).stat().st_size > 1000


def test_a_page_from_csv_files(tmp_path):
    """Of rows that were measured before; nothing else is run."""
    output, folder = tmp_path / "speed.md", tmp_path / "speed"
    effort = Effort(quick=True, rounds=3, tell=lambda what: pytest.fail(f"{what} is measured"))
    with pytest.raises(SigmafmuError, match=r"there is no .*steps\.csv, no .*; measure these sections first"):
        page.write(output, (), effort)
    folder.mkdir()
    for name in (page.MACHINE, *(section.FILE for section in page.SECTIONS.values())):
        shutil.copy(ROOT / "docs" / "speed" / name, folder)
    page.write(output, (), effort)
    text = output.read_text(encoding="utf-8")
    assert [f"## {section.TITLE}" for section in page.SECTIONS.values()] == re.findall("^## .*", text, re.MULTILINE)
    assert text == (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    with pytest.raises(SigmafmuError, match="no such section: nothing; there are steps, growth"):
        page.write(output, ("nothing",), effort)


def test_machine_names_what_was_compared():
    assert "sigmafmu" in machine()
    assert "Exudyn" in machine()
