"""Groups, coordinate maps and absolute coordinates: what the study says of them holds, in a small version."""

from itertools import pairwise

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from research.study import (
    LGT_CHAPTERS,
    lgt,
    lgt_accuracy,
    lgt_constraints,
    lgt_cost,
    lgt_rkmk54,
    lgt_stiff,
    lgt_top,
    lgt_vector_space,
    load,
)
from research.study.cli import study
from research.study.lgt import ABSOLUTE, COMBINATIONS, Combination

EPS = float(np.finfo(float).eps)
EVERY = [Combination(c.group, c.map, a) for a in ABSOLUTE for c in COMBINATIONS]
every_combination = pytest.mark.parametrize("combination", EVERY, ids=lambda c: f"{c.group}-{c.map}-{c.absolute}")
every_map_and_group = pytest.mark.parametrize("combination", COMBINATIONS, ids=lambda c: f"{c.group}-{c.map}")


def converge(mechanism, method, group, coordinate_map, steps, stop_time):
    return lgt_accuracy.converge(mechanism, method, group, coordinate_map, steps, stop_time)


def test_table_1_is_complete():
    """Eight of the twelve combinations are the paper's, the others have its remark's second-order Cayley map."""
    places = [c.table1 for c in EVERY]
    assert sorted(p for p in places if p != "–") == [f"{i}.{x}" for i in (1, 2) for x in "abcd"]
    assert {c.map for c, p in zip(EVERY, places, strict=True) if p == "–"} == {"cayley2"}


# --- accuracy --------------------------------------------------------------------------------------------------------


@every_map_and_group
@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [
        ("generalizedAlpha", 2, (2.5e-4, 1.25e-4)),
        ("generalizedAlpha, index 2", 2, (2.5e-4, 1.25e-4)),
        ("bliedf2", 2, (2.5e-4, 1.25e-4)),
        ("rkmk4", 4, (5e-4, 2.5e-4)),
        ("rkmk54", 5, (1e-3, 5e-4)),
    ],
)
def test_orders_and_absolute_coordinates(combination, method, order, steps):
    """Every method has its order on every group and map; rotation vectors give the quaternions' result to rounding."""
    cell = converge("HeavyTop", method, combination.group, combination.map, steps, 0.25)
    for quantity in ("position", "velocity", "rotation"):
        coarse, fine = lgt_accuracy.values(cell, quantity)
        assert np.log2(coarse / fine) == pytest.approx(order, abs=0.15)
    assert cell["difference"] < 1e4 * EPS  # 2000 steps, each with a few roundings


@pytest.mark.parametrize("method", lgt.METHODS)
def test_se3_loses_on_the_heavy_top(method):
    """By an order of magnitude with every method; lgt_top tells why."""
    on = {
        group: lgt_accuracy.values(converge("HeavyTop", method, group, "exp", (1e-3, 5e-4), 0.25), "position")
        for group in lgt.GROUPS
    }
    assert (on["SE3"] > 10 * on["R3xSO3"]).all()


@pytest.mark.parametrize("coordinate_map", ["cayley", "cayley2"])
def test_the_lag_of_a_spin(coordinate_map):
    """Of Cayley, (hω)³/12 in every step; a quarter of it with the second-order map; none with exp."""
    measured = lgt_accuracy.spin("bliedf2", coordinate_map)["measured"]
    predicted = [lgt_accuracy.lag(coordinate_map, h) for h in lgt_accuracy.SPIN_STEPS]
    assert measured == pytest.approx(predicted, rel=0.01)  # nutation is not in the prediction
    share = {"cayley": 12, "cayley2": 48}[coordinate_map]
    angle = lgt_accuracy.Rotor().spin * lgt_accuracy.SPIN_STEPS[-1]
    assert predicted[-1] == pytest.approx(
        angle**3 / share * lgt_accuracy.SPIN_TIME / lgt_accuracy.SPIN_STEPS[-1], rel=angle**2
    )
    assert max(lgt_accuracy.spin("bliedf2", "exp")["measured"]) < 1e-4 * min(measured)


def test_order_is_taken_between_floor_and_ceiling():
    steps = [8.0, 4.0, 2.0, 1.0]
    assert lgt.order(steps, [5.0, 16.0, 4.0, 1.0], 0.5, 20) == pytest.approx(2.0)
    assert lgt.order(steps, [64.0, 16.0, 4.0, 3.9], 3.95, 100) == pytest.approx(2.0)
    assert np.isnan(lgt.order(steps, [np.nan, 100.0, 4.0, 0.1], 0.5, 20))


# --- what decides between the groups ---------------------------------------------------------------------------------


@pytest.mark.parametrize("method", lgt_top.STEPS)
def test_errors_mix_in_the_mass_metric(method):
    """R³×SO(3): (1 − f) times the rotation's error plus f times the translation's; SE(3): the rotation's, for all f."""
    cell = lgt_top.shares(method, (0.1, 0.5, lgt_top.PAPER_SHARE))
    assert np.ptp(cell["SE3"]) < 1e-6 * max(cell["SE3"])
    assert max(cell["deviation"]) < 0.05  # to first order in the error
    assert list(cell["R3xSO3"]) == sorted(cell["R3xSO3"], reverse=True)
    assert cell["R3xSO3"][0] == pytest.approx(0.9 * cell["SE3"][0], rel=0.05)


def test_on_se3_the_top_is_a_rotation_about_its_pivot():
    distance = lgt_top.twin()
    assert distance["SE3"] < 1e4 * EPS  # 500 steps
    assert distance["R3xSO3"] > 1e-5


# --- joints ----------------------------------------------------------------------------------------------------------


@every_map_and_group
@pytest.mark.parametrize("method", lgt_constraints.INDEX2_METHODS)
def test_lower_pairs_to_the_ground_are_kept_on_se3(combination, method):
    names = (method, combination.group, combination.map, 0.4)
    top, crank = (lgt_constraints.drift(m, *names) for m in ("HeavyTop", "SliderCrank"))
    residuals = {**lgt_constraints.largest(top), **lgt_constraints.largest(crank)}
    vectors = {**top["rotationVector"], **crank["rotationVector"]}
    kept = {"guide"} | ({"pivot", "crankPivot"} if combination.group == "SE3" else set())
    for found in (residuals, vectors):
        for joint, residual in found.items():
            if joint in kept:
                assert residual < 1e-11, joint  # rounding of 400 steps
            else:
                assert residual > 1e-7, joint


@every_map_and_group
def test_projection_has_nothing_to_do_on_se3(combination):
    found = lgt_constraints.projections("HeavyTop", combination.group, combination.map, 0.1)["iterations"]
    assert found == 0 if combination.group == "SE3" else found >= 1


# --- section 6.3, and rkmk54 -----------------------------------------------------------------------------------------


@every_combination
@pytest.mark.parametrize("mechanism", lgt_vector_space.SETUPS)
def test_rkmk4_is_the_classical_method_on_the_local_model(mechanism, combination):
    found = lgt_vector_space.twin(mechanism, combination.group, combination.map, combination.absolute, 20)
    assert found["position"] < 100 * EPS  # m, of up to 1 m
    assert found["velocity"] < 100 * EPS


@every_combination
@pytest.mark.parametrize("mechanism", lgt_vector_space.SETUPS)
def test_a_black_box_gives_the_same_motion_on_all_combinations(mechanism, combination):
    names = (combination.group, combination.map, combination.absolute)
    found = lgt_vector_space.black_box(mechanism, "DOP853", *names, 2)
    assert found["position"] < 1e-12  # m, its rtol
    assert found["rkmk54"] < 1e-11  # the tolerance of rkmk54 is one of velocities
    assert found["drift"] < 1e-12


@every_map_and_group
def test_rkmk54_follows_its_tolerance(combination):
    tolerances = (1e-4, 1e-6, 1e-8)
    cell = lgt_rkmk54.tolerance_runs("HeavyTop", combination.group, combination.map, tolerances, 0.5, 1)
    found = lgt_rkmk54.errors(cell)
    assert all(coarse > 10 * fine for coarse, fine in pairwise(found))
    assert (found < 100 * np.array(tolerances)).all()
    assert all(run["seconds"] > 0 and run["steps"] > 50 for run in cell["runs"])


# --- cost ------------------------------------------------------------------------------------------------------------


def test_costs():
    """Times are not judged here; evaluations are: 4 and 7 in a step without joints, whatever the coordinates."""
    found = lgt_cost.step_costs("HighSpeedRotor", 20, 1)
    assert list(found) == lgt.methods(constrained=False)
    assert found["rkmk4"]["jacobians"] == pytest.approx([4] * len(EVERY), abs=0.3)  # the last one starts the next step
    assert found["rkmk54"]["jacobians"] == pytest.approx([7] * len(EVERY), abs=0.3)
    assert lgt_cost.ratio(found, "generalizedAlpha", 0) == 1.0
    assert all(t > 0 for m in found.values() for t in m["microseconds"])


def test_stiff_dampers():
    """Within the stability limit all run; beyond it rkmk4 is lost, rkmk54 takes more steps, implicit methods do not."""
    slow, fast = (lgt_stiff.stiff(damping, 1) for damping in (1e3, 1e5))
    asked = lgt_stiff.SAMPLES
    assert lgt_stiff.ratio(1e3) < 1 < 10 < lgt_stiff.ratio(1e5)
    for method, run in slow.items():
        assert run["error"] < 0.2, method
        assert run["steps"] < 1.2 * asked, method
    assert fast["rkmk4"].get("error", np.inf) > 1e3
    assert fast["rkmk54"]["error"] < 1e-4
    assert fast["rkmk54"]["steps"] > 5 * asked
    for method in ("generalizedAlpha", "bliedf2"):
        assert fast[method]["steps"] == asked
        assert fast[method]["error"] < 0.2


# --- reports ---------------------------------------------------------------------------------------------------------


def _made_up(chapter, mechanism, cell):
    """A result of the right form; the first run fails."""
    steps = (1e-3, 5e-4, 2.5e-4)
    runs = [
        {"h": h, "tolerance": h, "failed": "a reason"}
        if i == 0
        else {
            "h": h,
            "tolerance": h,
            "seconds": 1e-6 / h,
            "steps": 10,
            "retries": 1,
            **dict.fromkeys(("position", "velocity", "rotation", "multipliers"), h**2),
        }
        for i, h in enumerate(steps)
    ]
    joints = {"HeavyTop": ["pivot"], "SliderCrank": ["crankPivot", "guide"]}.get(mechanism, [])
    time = np.linspace(0, 1, lgt_constraints.SAMPLES + 1)
    return {
        "lgt_accuracy": lambda: (
            {"measured": [1e-1, 1e-2, np.nan]}
            if cell.key.startswith("spin")
            else {
                "runs": dict.fromkeys(ABSOLUTE, runs),
                "difference": 1e-15,
                "motion": dict.fromkeys(lgt_accuracy.QUANTITIES, 1.0),
            }
        ),
        "lgt_top": lambda: (
            {"SE3": 1e-14, "R3xSO3": 1e-4}
            if cell.key == "twin"
            else {
                "share": [0.1, 0.9],
                "SE3": [1.0, 1.0],
                "R3xSO3": [0.9, 0.1],
                "deviation": [0.01, 0.0],
                "theory": np.linspace(1, 0, len(lgt_top.THEORY_SHARES)),
            }
        ),
        "lgt_constraints": lambda: (
            {"iterations": 1.0}
            if cell.key.startswith("rkmk4")
            else {
                "time": time,
                "residuals": {j: list(1e-3 * time) for j in joints},
                "rotationVector": dict.fromkeys(joints, 1e-3),
            }
        ),
        "lgt_cost": lambda: {
            method: {name: [1.0] * len(EVERY) for name in lgt_cost.MEASURED}
            for method in lgt.methods(mechanism != "HighSpeedRotor")
        },
        "lgt_work": lambda: {"sigma": 1.0, "runs": runs},
        "lgt_stiff": lambda: {
            **{method: {"error": 1e-5, "steps": 10} for method in lgt.methods(constrained=False)},
            "rkmk4": {"failed": "a reason"},
        },
        "lgt_vector_space": lambda: dict.fromkeys(("position", "velocity", "rkmk54", "calls", "drift"), 1e-13),
        "lgt_rkmk54": lambda: {"runs": runs},
    }[chapter.name]()


@pytest.mark.parametrize("chapter", load(LGT_CHAPTERS), ids=lambda c: c.name)
def test_reports(tmp_path, chapter):
    """Every figure that the text shows is written, whatever ran."""
    results = {
        mechanism: {cell.key: _made_up(chapter, mechanism, cell) for cell in chapter.cells(mechanism, quick=True)}
        for mechanism in chapter.mechanisms
    }
    text = chapter.report(results, tmp_path)
    images = [part.split(")")[0] for part in text.split("](")[1:]]
    assert images or chapter.name == "lgt_vector_space"
    for image in images:
        assert (tmp_path / image).stat().st_size < 150_000
    assert list(tmp_path.glob(f"{chapter.name}*.csv"))


def test_command(tmp_path):
    """`study lgt` knows only chapters of its own."""
    app = typer.Typer()
    app.callback()(lambda: None)
    app.command()(study)
    result = CliRunner().invoke(app, ["study", "lgt", "--quick", "--chapter", "lgt_top", "--output", str(tmp_path)])
    assert result.exit_code == 0, result.output
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "`python -m research study lgt --quick --chapter lgt_top`" in text
    assert f"## {lgt_top.CHAPTER.title}" in text
    result = CliRunner().invoke(app, ["study", "lgt", "--chapter", "convergence", "--output", str(tmp_path)])
    assert str(result.exception) == f"there is no chapter convergence; there are {', '.join(LGT_CHAPTERS)}"
