"""An arm and a humanoid beside codes in joint coordinates, for which open trees are the easiest mechanisms."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from research.bench import Effort, runs
from research.mechanisms import named
from sigmafmu.markdown import markdown_table

TITLE = "Open trees beside explicit codes"
FILE = "robots.csv"
H = 1e-3  # s
STEPS = 200
MECHANISMS = ("RevoluteArm7", "Humanoid", "Chain10", "RevoluteChain10", "RandomTree100")
QUICK = ("RevoluteArm7", "Humanoid")
CENTER = np.zeros(3)


def measure(effort: Effort) -> list[dict[str, Any]]:
    """A row for each mechanism: nanoseconds per step of every code."""
    rows = []
    for name in QUICK if effort.quick else MECHANISMS:
        effort.tell(f"{name} beside MuJoCo and Pinocchio")
        tree = named(name).multibody
        candidates = {
            "ours": lambda name=name: runs.core(named(name), H, STEPS, CENTER),
            "ours_index3": lambda name=name: runs.core(named(name), H, STEPS, CENTER, formulation=1),
            "exudyn": partial(runs.exudyn, tree, H, STEPS, CENTER, modified=True, sparse=True),
            "mujoco_euler": partial(runs.mujoco, tree, H, STEPS, CENTER, "EULER"),
            "mujoco_rk4": partial(runs.mujoco, tree, H, STEPS, CENTER, "RK4"),
            "pinocchio_aba": lambda tree=tree: runs.Run(runs.pinocchio_aba(tree), 0.0, CENTER),
        }
        found = runs.fastest(candidates, effort.rounds)
        row = {key: 1e9 * run.seconds for key, run in found.items()}
        row["pinocchio_rk4"] = 4 * row["pinocchio_aba"]
        rows.append({"mechanism": name, "bodies": len(tree.bodies), **row})
    return rows


HEADER = {
    "ours": "ours",
    "ours_index3": "ours, index 3",
    "exudyn": "Exudyn",
    "mujoco_euler": "MuJoCo, Euler",
    "mujoco_rk4": "MuJoCo, RK4",
    "pinocchio_rk4": "Pinocchio, RK4",
}


def report(rows: list[dict[str, Any]], _: Path) -> str:
    """One table, and who is faster."""
    table = markdown_table(
        ("µs per step", "bodies", *HEADER.values(), "Exudyn / ours", "ours / MuJoCo, RK4", "ours / Pinocchio, RK4"),
        [
            [
                row["mechanism"],
                str(row["bodies"]),
                *(f"{1e-3 * row[key]:.2f}" for key in HEADER),
                f"{row['exudyn'] / row['ours']:.1f}",
                f"{row['ours'] / row['mujoco_rk4']:.1f}",
                f"{row['ours'] / row['pinocchio_rk4']:.1f}",
            ]
            for row in rows
        ],
    )
    slower = [row["mechanism"] for row in rows if row["ours"] > min(row["mujoco_rk4"], row["pinocchio_rk4"])]
    verdict = (
        f"An explicit step in joint coordinates is faster than ours on {', '.join(slower)}: there a tree has no "
        "equations for its joints, and nothing is solved again. Such codes need other means for loops, stiff supports "
        "and reaction forces."
        if slower
        else "No explicit code was faster than ours on these trees."
    )
    return (
        f"h = {H:g} s, default settings of ours, Exudyn with modified Newton and its sparse solver. MuJoCo takes all "
        "steps in one call, without contacts; its Euler method is of first order. Pinocchio integrates nothing by "
        "itself: a Runge-Kutta step counts as four accelerations by its articulated-body algorithm, timed in batches "
        f"without Python, which is less than it takes.\n\n{table}\n{verdict}\n"
    )
