"""The problems that docs/compare.md measures: every code gets the same mechanism."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from research.bench import runs
from research.compare import measure, page
from research.compare.problems import PROBLEMS
from research.page import END, put
from sigmafmu import SigmafmuError, _core

DOCS = Path(__file__).resolve().parents[2] / "docs"
PART, STEPS = 1 / 200, 50
"""Of a problem's time, and steps in it."""


def place(problem, method):
    """Where the point is after a small part of the time; explicit methods need smaller steps on stiff springs."""
    h = problem.stop_time * PART / STEPS / (20 if problem.stiff else 1)
    return method.run(h, STEPS).position


@pytest.mark.exudyn
@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
def test_all_codes_move_alike_at_the_start(problem):
    """Within what their steps and MuJoCo's soft loops leave of the motion."""
    pytest.importorskip("mujoco")
    start = runs.core(problem.mechanism(), 1e-9, 1, np.zeros(3), body=problem.body).position
    methods = {method.label: method for method in measure.methods(problem)}
    expected = place(problem, methods["ours, rkmk4"])
    moved = np.linalg.norm(expected - start)
    assert moved > 1e-6 * problem.size
    for label, method in methods.items():
        error = np.linalg.norm(place(problem, method) - expected)
        assert error < 0.01 * moved, (label, error, moved)


def test_independent_solutions_are_where_rkmk4_goes():
    """Of the pendulum and the slider-crank, which take no time; tests of the library have the others."""
    for problem in PROBLEMS[0], PROBLEMS[-1]:
        steps = round(64 * problem.stop_time / problem.largest)
        h = problem.stop_time / steps
        found = runs.core(problem.mechanism(), h, steps, np.zeros(3), body=problem.body, method=2)
        assert np.linalg.norm(found.position - problem.exact()) < 1e-7 * problem.size


def test_the_pendulums_force_is_that_of_the_core():
    problem = PROBLEMS[0]
    mechanism = problem.mechanism()
    mechanism.integrator.method, mechanism.integrator.step_size = 2, 1e-3
    slave = _core.Slave(mechanism)
    slave.start()
    slave.do_step(0.0, problem.stop_time)
    force = np.linalg.norm([slave.get(f"hinge.reactionForce[{i}]") for i in (1, 2, 3)])
    assert force == pytest.approx(problem.force(), rel=1e-8)


def rows(label, times, errors):
    return [
        {"problem": "A01", "round": 0, "method": label, "order": 2, "h": 0.01 / 2**i, "ms": ms, "error": error}
        for i, (ms, error) in enumerate(zip(times, errors, strict=True))
    ]


def test_ratios_are_those_of_times_to_the_same_error():
    found = rows(measure.OURS, [1.0, 2.0], [2e-4, 5e-5]) + rows("Exudyn, index 3", [6.0, 12.0], [2e-4, 5e-5])
    (table,) = page._times(found, [measure.OURS, "Exudyn, index 3"], 1e-4)
    row = next(line for line in table.splitlines() if line.startswith("| A01"))
    assert row == "| A01, simple pendulum | 1.4 | 6 |"


def test_a_part_of_a_page_is_replaced(tmp_path):
    text = f"before\n<!-- measured: x -->\nold\n{END}\nafter\n"
    (tmp_path / "page.md").write_text(text, encoding="utf-8")
    put(tmp_path / "page.md", "x", "new\n")
    assert (tmp_path / "page.md").read_text("utf-8") == text.replace("old", "\nnew\n")
    with pytest.raises(SigmafmuError, match="has no place for what is measured: <!-- measured: y -->"):
        put(tmp_path / "page.md", "y", "new")


def test_the_page_is_that_of_its_csv_files(tmp_path):
    """`--redraw` changes nothing."""
    shutil.copytree(DOCS / "compare", tmp_path / "compare")
    shutil.copy(DOCS / "compare.md", tmp_path)
    page.redraw(tmp_path / "compare.md")
    assert (tmp_path / "compare.md").read_text("utf-8") == (DOCS / "compare.md").read_text("utf-8")
