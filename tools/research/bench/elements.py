"""What an element costs in a step: many of it, beside the same bodies without."""

from pathlib import Path
from typing import Any

import numpy as np

from research.bench import Effort, runs
from research.elements import examples
from sigmafmu.markdown import markdown_table

TITLE = "What elements cost"
FILE = "elements.csv"
H = 1e-3  # s
STEPS = 200
COPIES = 20
QUICK = ("revolute", "line_spring", "joint_springs", "gear")
FREE = ("sensors", "motions")
"""Sections of what takes no part in a step."""
CENTER = np.zeros(3)
PACE = {
    "mass": 1.0,
    "inertia": [0.01, 0.02, 0.015],
    "center_of_mass": [-5.0, 0, 0],
    "angular_velocity": [9.0, 20.0, 5.0],
}
"""A body that tumbles, so that Newton's method takes as many iterations with an element as without."""


def measure(effort: Effort) -> list[dict[str, Any]]:
    """A row for each element."""
    rows = []
    for element in examples.elements():
        if element.section in FREE or (effort.quick and element.name not in QUICK):
            continue
        effort.tell(f"{COPIES} of {element.name}")
        found = _times(element, effort.rounds, to_ground=False)
        row = {"section": element.section, "element": element.name, **found}
        if element.section == "forces" and element.on_two_bodies and row["bodies"] > 1:
            row["to_ground"] = _times(element, effort.rounds, to_ground=True)["ns"]
        rows.append(row)
    return rows


def _times(element: examples.Element, rounds: int, to_ground: bool) -> dict[str, Any]:
    """Of one element: its bodies; iterations per step; ns per iteration of its bodies without it, and of itself."""
    mechanisms = {}
    for present in (False, True):
        content = examples.mechanism(element, present, COPIES, to_ground)
        content["bodies"]["pace"] = PACE
        mechanisms[present] = examples.load(content).mechanism
    candidates = {
        present: lambda mechanism=mechanism: runs.core(mechanism, H, STEPS, CENTER)
        for present, mechanism in mechanisms.items()
    }
    found = runs.fastest(candidates, rounds)
    per_iteration = {present: run.seconds / run.iterations for present, run in found.items()}
    return {
        "bodies": (len(mechanisms[True].multibody.bodies) - 1) / COPIES,
        "iterations": found[True].iterations,
        "iterations_without": found[False].iterations,
        "ns_without": 1e9 * per_iteration[False] / COPIES,
        "ns": 1e9 * (per_iteration[True] - per_iteration[False]) / COPIES,
    }


def report(rows: list[dict[str, Any]], _: Path) -> str:
    """One table, and what a body costs beside it."""
    table = markdown_table(
        ("element", "ns", "to the ground", "bodies of it", "ns of these without it", "iterations"),
        [
            [
                f"`{row['element']}`",
                f"{row['ns']:.0f}",
                f"{row['to_ground']:.0f}" if "to_ground" in row else "",
                f"{row['bodies']:.0f}",
                f"{row['ns_without']:.0f}",
                f"{row['iterations']:.2f}",
            ]
            for row in rows
        ],
    )
    return (
        "Nanoseconds for each element and iteration of Newton's method, with Jacobian and elimination: the difference "
        f"between steps of mechanisms with {COPIES} of it and with none, whose bodies are the same. Joints tie a free "
        "body to the ground, `fixed` one to another. Forces act between two free bodies, which puts blocks between "
        "them into the matrix, or *to the ground*, which does not; planes are those of the ground. What acts "
        "on coordinates, couplings and drives are on hinges. Sensors cost nothing until they are read, and what a "
        f"mechanism does not have costs nothing.\n\n{table}"
    )
