"""Transients of the starting values: their orders are what theory says."""

import numpy as np
import pytest

from research.measure import INDEX2, INDEX3, MULTIPLIERS, STABILIZED
from research.study import start
from research.study.start import PLAIN, SHIFTED, VELOCITY, first_velocity, largest_multipliers, order, transient

JOINTED = pytest.mark.parametrize("mechanism", [m for m in start.LARGEST_STEPS if MULTIPLIERS[m]])
NEAR = 0.1  # of an order, for what the next power of h still adds


def run(mechanism, formulation, rho, kind):
    smallest = start.LARGEST_STEPS[mechanism] / 16
    return transient(mechanism, formulation, rho, kind, (2 * smallest, smallest))


@JOINTED
@pytest.mark.parametrize("formulation", [INDEX2, STABILIZED])
@pytest.mark.parametrize(("kind", "multipliers", "velocity"), [(PLAIN, 1, 2), (SHIFTED, 2, 3)])
def test_orders_on_velocity_level(mechanism, formulation, kind, multipliers, velocity):
    cell = run(mechanism, formulation, 0.5, kind)
    assert order(largest_multipliers(cell)) == pytest.approx(multipliers, abs=NEAR)
    assert order(first_velocity(cell)) == pytest.approx(velocity, abs=NEAR)


@JOINTED
@pytest.mark.parametrize(("kind", "expected"), [(PLAIN, 1), (SHIFTED, 1), (VELOCITY, 2)])
def test_index_3_needs_another_velocity_too(mechanism, kind, expected):
    """The shift alone does not help; with the scheme's own velocity across the constraints the transient is gone."""
    assert order(largest_multipliers(run(mechanism, INDEX3, 0.9, kind))) == pytest.approx(expected, abs=NEAR)


@pytest.mark.parametrize(("kind", "expected"), [(PLAIN, 2), (SHIFTED, 3)])
def test_orders_without_joints(kind, expected):
    cell = run("HighSpeedRotor", INDEX3, 0.5, kind)
    assert order(first_velocity(cell)) == pytest.approx(expected, abs=NEAR)
    assert largest_multipliers(cell).size == 0


def test_dissipation_ends_the_transient():
    """After 40 steps at ρ∞ = 0.5 both starts have the same error, to the last digit that the transient left."""
    plain, shifted = (np.array(run("HeavyTop", STABILIZED, 0.5, kind)["multipliers"]) for kind in (PLAIN, SHIFTED))
    assert plain[-1, 0] > 10 * shifted[-1, 0]
    assert plain[-1, -1] == pytest.approx(shifted[-1, -1], rel=0.01)


def test_report(tmp_path):
    cells = start.CHAPTER.cells("HeavyTop", quick=True)
    h = list(cells[0].arguments[-1])
    errors = np.outer(np.square(h), np.ones(start.STEPS)).tolist()
    found = {cell.key: {"h": h, "velocity": errors, "multipliers": errors} for cell in cells}
    text = start.CHAPTER.report({"HeavyTop": found}, tmp_path)
    assert f"| index 3 | 0.9 | {PLAIN} | {h[-1] ** 2:.1e} | 2.00 | {h[-1] ** 2:.1e} | 2.00 |" in text
    assert len((tmp_path / "start-HeavyTop.csv").read_text().splitlines()) == 1 + len(cells) * len(h) * start.STEPS
    assert (tmp_path / "start-HeavyTop.png").stat().st_size < 150_000
