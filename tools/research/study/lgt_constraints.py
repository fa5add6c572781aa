"""Chapter: which joints are kept by the group alone, when the constraints are fulfilled for velocities only."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from research.measure import INDEX2
from research.study import lgt, runs
from research.study.chapter import Cell, Results
from research.study.lgt import ABSOLUTE, COMBINATIONS, METHODS, Combination
from research.study.output import figure, write_csv
from sigmafmu import _core
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import RESIDUAL_FLOOR

INDEX2_METHODS = {
    "generalizedAlpha": METHODS["generalizedAlpha, index 2"],
    "bliedf2": {**METHODS["bliedf2"], "formulation": INDEX2},
}
"""Nothing but the velocities is kept on the constraints."""
ROWS = {
    _core.JointType.spherical: 3,
    _core.JointType.revolute: 5,
    _core.JointType.universal: 4,
    _core.JointType.prismatic: 5,
}
"""Constraint equations of a joint."""
STEPS = {"HeavyTop": 1e-3, "SliderCrank": 1e-3}  # s
STOP_TIMES = {"HeavyTop": 10.0, "SliderCrank": 10.0}  # s
QUICK_TIME = 1.0  # s
SAMPLES = 200
KEPT = 1e-10
"""Residuals up to here are rounding, which adds up over the steps; a method's error is far above."""


def drift(mechanism: str, method: str, group: str, coordinate_map: str, stop_time: float) -> dict[str, Any]:
    """Residual |Φ| of every joint at SAMPLES times, and its largest value with rotation vectors."""
    h = STEPS[mechanism]
    history = {
        absolute: _residuals(
            mechanism, h, stop_time, INDEX2_METHODS[method], Combination(group, coordinate_map, absolute)
        )
        for absolute in ABSOLUTE
    }
    return {
        "time": np.linspace(0.0, stop_time, SAMPLES + 1),
        "residuals": history["quaternion"],
        "rotationVector": {joint: max(values) for joint, values in history["rotationVector"].items()},
    }


def projections(mechanism: str, group: str, coordinate_map: str, stop_time: float) -> dict[str, Any]:
    """Newton iterations per step that rkmk4 takes to bring positions back onto the constraints."""
    h = STEPS[mechanism]
    run = runs.simulation(mechanism, h, **METHODS["rkmk4"], **Combination(group, coordinate_map).settings)
    run.run(stop_time, round(stop_time / h))
    return {"iterations": run.state.counters.newton_iterations / run.state.counters.steps}


def _residuals(
    mechanism: str, h: float, stop_time: float, method: Mapping[str, float], combination: Combination
) -> dict[str, list[float]]:
    multibody = _core.mechanism(mechanism).multibody
    system = _core.System(multibody)
    run = runs.simulation(mechanism, h, **method, **combination.settings)
    result: dict[str, list[float]] = {joint.name: [] for joint in multibody.joints}
    for i in range(SAMPLES + 1):
        run.run(stop_time * i / SAMPLES, round(stop_time / SAMPLES / h) if i else 0)
        phi, *_ = system.constraints(run.state.q, run.state.v)
        first = 0
        for joint in multibody.joints:
            rows = ROWS[joint.type]
            result[joint.name].append(float(np.linalg.norm(phi[first : first + rows])))
            first += rows
    return result


class Constraints:
    """Residuals over time."""

    name = "lgt_constraints"
    title = "Local-global transition maps: joints kept by the group"
    mechanisms = tuple(STEPS)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each method, group and map."""
        stop_time = QUICK_TIME if quick else STOP_TIMES[mechanism]
        result = [
            Cell(f"{method}/{c.group}/{c.map}", drift, (mechanism, method, c.group, c.map, stop_time))
            for method in INDEX2_METHODS
            for c in COMBINATIONS
        ]
        result += [
            Cell(f"rkmk4/{c.group}/{c.map}", projections, (mechanism, c.group, c.map, stop_time)) for c in COMBINATIONS
        ]
        return result

    def report(self, results: Results, folder: Path) -> str:
        """A figure and a table for each mechanism."""
        parts = [
            "Index 2: the constraints are fulfilled for velocities, B(q) v = 0, and nothing brings positions back. On "
            "SE(3) a lower pair to the ground (spherical, revolute, prismatic, cylindrical joint) is kept all the "
            "same: the twists V that it allows are a subalgebra, the same one at all times in body axes; the local "
            "coordinates of a step are a sum of such V, τ maps them into the subgroup, and q stays where the joint "
            "has it. This holds for every map, since Cayley of a subalgebra is in the subgroup as well, and for the "
            "stages of Runge-Kutta methods. On R³×SO(3) rotations about a pivot are no subgroup, translations are: "
            "only the prismatic joint is kept there. Between two bodies that both move, the joint restricts the "
            "difference of two twists in different axes: no subgroup, no such gift on either group. A universal joint "
            "is no lower pair.\n"
        ]
        for mechanism, found in results.items():
            histories = {tuple(k.split("/")): c for k, c in found.items() if not k.startswith("rkmk4")}
            write_csv(
                folder / f"lgt_constraints_{mechanism}.csv",
                _rows(histories),
                ("method", "group", "map", "joint", "time", "residual"),
            )
            image = f"lgt_constraints_{mechanism}.png"
            _draw(folder / image, mechanism, histories)
            parts.append(f"### {mechanism}\n\n![{mechanism}: residuals over time]({image})\n")
            parts.append(_table(mechanism, found))
        return "\n".join(parts)


def largest(cell: Mapping[str, Any]) -> dict[str, float]:
    """By joint, over the run."""
    return {joint: max(values) for joint, values in cell["residuals"].items()}


def _rows(histories: Mapping[tuple[str, ...], Mapping[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"method": method, "group": group, "map": name, "joint": joint, "time": t, "residual": value}
        for (method, group, name), cell in histories.items()
        for joint, values in cell["residuals"].items()
        for t, value in list(zip(cell["time"], values, strict=True))[:: SAMPLES // 20]
    ]


def _draw(path: Path, mechanism: str, histories: Mapping[tuple[str, ...], Mapping[str, Any]]) -> None:
    """Joints across, generalized-α."""
    joints = list(next(iter(histories.values()))["residuals"])
    with figure(path, (max(5.0, 2.9 * len(joints)), 3.8)) as result:
        row = result.subplots(1, len(joints), squeeze=False, sharey=True)[0]
        for axes, joint in zip(row, joints, strict=True):
            for c in COMBINATIONS:
                cell = histories["generalizedAlpha", c.group, c.map]
                residuals = np.maximum(cell["residuals"][joint], RESIDUAL_FLOOR)
                axes.plot(cell["time"][1:], residuals[1:], **{**c.style, "marker": None})
            axes.set(yscale="log", xlabel="t in s", title=joint)
        row[0].set_ylabel("|Φ| in m or 1")
        result.legend(
            handles=lgt.legend_handles(), loc="outside lower center", ncols=6 if len(joints) > 2 else 3, fontsize=8
        )


def _table(mechanism: str, found: Mapping[str, Mapping[str, Any]]) -> str:
    rows, apart = [], 0.0
    joints = list(largest(found["generalizedAlpha/SE3/exp"]))
    kept = {c: set(joints) for c in COMBINATIONS}
    for c in COMBINATIONS:
        row = [c.table1, c.name]
        for method in INDEX2_METHODS:
            cell = found[f"{method}/{c.group}/{c.map}"]
            values = largest(cell)
            row += [f"{values[joint]:.0e}" for joint in joints]
            kept[c] -= {joint for joint in joints if max(values[joint], cell["rotationVector"][joint]) > KEPT}
            apart = max(apart, *(abs(values[j] - cell["rotationVector"][j]) for j in joints))
        rows.append([*row, f"{found[f'rkmk4/{c.group}/{c.map}']['iterations']:.2f}"])
    header = ["Table 1", "group, map", *(f"{joint}, {m}" for m in INDEX2_METHODS for joint in joints)]
    stop_time = found["generalizedAlpha/SE3/exp"]["time"][-1]
    verdict = "; ".join(f"{c.name}: {', '.join(sorted(names)) or 'none'}" for c, names in kept.items())
    return (
        f"Largest |Φ| (m, or the cosine of an angle) within {stop_time:g} s, h = {STEPS[mechanism]:g} s; last column: "
        "iterations per step with which rkmk4 brings positions back onto all joints, 0 where none is needed.\n\n"
        + markdown_table([*header, "rkmk4"], rows)
        + f"\nKept to rounding (below {KEPT:.0e}, both methods, both absolute coordinates): {verdict}. With rotation "
        f"vectors the largest residuals differ by {apart:.0e} at most.\n"
    )


CHAPTER = Constraints()
