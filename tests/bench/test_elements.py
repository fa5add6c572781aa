"""What docs/comparison.md says: elements and an arm move as in other codes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from research.bench import Effort
from research.bench import elements as cost
from research.elements import POINT, Case, compare, examples, forces, joints, ours, robot, run_mujoco, sensors
from research.elements.page import CASES, all_elements, compared, not_compared
from sigmafmu import _core

SLOW = "PCHIP"
"""In the name of what Exudyn takes seconds for."""


def of(code: str) -> list[Case]:
    """Cases with this code alone."""
    alone = [replace(case, **dict.fromkeys({"exudyn", "mujoco"} - {code})) for case in CASES]
    return [case for case in alone if (peer := getattr(case, code)) and SLOW not in peer.name]


def name(case: Case) -> str:
    return f"{case.element}-{(case.exudyn or case.mujoco).name}"


@pytest.mark.exudyn
@pytest.mark.parametrize("case", [case for case in of("exudyn") if not case.exudyn.note], ids=name)
def test_exudyn_moves_as_we_do(case):
    """With order 2, and extrapolated a hundred times nearer."""
    (row,) = compare(case)
    if case.contact:  # begins and ends within steps
        assert row["fine"] < 1e-6
        return
    assert row["coarse"] < 1e-4
    if row["coarse"] > 1e-12:  # a mere fall is exact
        assert np.log2(row["coarse"] / row["fine"]) == pytest.approx(2, abs=0.05)
        assert row["limit"] < 0.01 * row["coarse"]


@pytest.mark.parametrize("case", of("mujoco"), ids=name)
def test_mujoco_moves_as_we_do(case):
    pytest.importorskip("mujoco", reason="needs MuJoCo; `make bench` installs it")
    (row,) = compare(case)
    assert row["fine"] < (1e-2 if case.mujoco.note else 1e-10)


@pytest.mark.exudyn
@pytest.mark.parametrize("peer", forces.BUSHINGS)
def test_bushings_differ_by_the_square_of_the_rotation(peer):
    rows = [compare(case)[0] for case in of("exudyn") if case.exudyn.name == peer and "bushing" in case.element]
    assert rows[0]["limit"] / rows[1]["limit"] == pytest.approx(100, rel=0.1)


@pytest.mark.exudyn
def test_levers_of_friction_differ_by_a_part_of_the_penetration():
    """Which goes with the modulus to the power of -2/5."""
    rows = [compare(case)[0] for case in of("exudyn") if case.exudyn.note == forces.LEVER]
    assert rows[1]["fine"] / rows[0]["fine"] == pytest.approx(10**-0.4, rel=0.05)


def test_stiffer_equations_of_mujoco_are_nearer():
    """What ties coordinates there is a spring: twice as stiff, half as far."""
    pytest.importorskip("mujoco", reason="needs MuJoCo; `make bench` installs it")
    (case,) = (case for case in of("mujoco") if case.element == "mimic")
    found = [case.mujoco.build(case.mechanism().multibody) for _ in range(2)]
    ends = []
    for stiffness, (model, rates, controls) in zip((1e5, 2e5), found, strict=True):
        model.eq_solref[0] = -stiffness, -600
        data = run_mujoco(model, rates, controls, case.stop, 4 * case.steps)
        ends.append(np.abs(data.xpos[2] + data.xmat[2].reshape(3, 3) @ POINT - ours(case, case.steps)).max())
    assert ends[0] / ends[1] == pytest.approx(2, rel=0.1)


def test_sensors_tell_what_mujoco_tells():
    pytest.importorskip("mujoco", reason="needs MuJoCo; `make bench` installs it")
    for row in sensors.compare():
        assert row["difference"] < 1e-13, row
        assert row["size"] > 0.1


@pytest.mark.parametrize("name", robot.ARMS)
def test_an_arm_accelerates_as_in_pinocchio(name):
    pytest.importorskip("pinocchio", reason="needs Pinocchio; `make bench` installs it")
    assert robot.accelerations(name) < 1e-12


def test_an_arm_falls_as_in_mujoco():
    pytest.importorskip("pinocchio", reason="needs Pinocchio; `make bench` installs it")
    pytest.importorskip("mujoco", reason="needs MuJoCo; `make bench` installs it")
    ends = robot.trajectory()
    assert ends["rkmk4"] < 1e-9
    assert np.log2(ends["coarse"] / ends["fine"]) == pytest.approx(2, abs=0.05)
    assert ends["coarse"] < 1e-6


@pytest.mark.parametrize("element", examples.elements(), ids=lambda element: element.id)
def test_every_element_has_an_example(element):
    """Which starts and moves, also beside others of its kind."""
    simulation = _core.Simulation(examples.load(examples.mechanism(element, copies=2)).mechanism)
    simulation.advance(1e-3, 2)
    assert np.isfinite(simulation.state.q).all()


def test_the_cost_of_an_element():
    rows = cost.measure(Effort(quick=True, rounds=1, tell=lambda what: None))
    assert [row["element"] for row in rows] == ["revolute", "joint_springs", "line_spring", "gear"]
    for row in rows:
        assert row["iterations"] == row["iterations_without"] == 2
        assert row["ns"] > 0
        assert row["ns_without"] > 0
    assert "| `gear` |" in cost.report(rows, Path())


def test_every_element_is_compared_or_listed():
    assert compared() <= {*all_elements()}, "what is compared has the names of files"
    assert compared() | not_compared().keys() == {*all_elements()}
    assert {kind.name for kind in joints.MUJOCO_JOINTS} <= compared()
