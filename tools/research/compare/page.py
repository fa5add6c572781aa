"""Writes what was measured into its part of docs/compare.md."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.ticker import NullFormatter

from research.bench import machine, runs
from research.bench.page import read_rows
from research.bench.work import milliseconds_to
from research.compare import measure
from research.compare.problems import PROBLEMS
from research.page import check, put
from research.study.output import figure, write_csv
from sigmafmu.markdown import markdown_table

COMMAND = "python -m research compare"
TARGETS = (1e-4, 1e-6)
BUDGET = 1.5
"""Seconds of the longest run of a method on a problem."""
FIGURE = "work.png"
MACHINE = "machine.txt"
Rows = list[dict[str, Any]]


def write(page: Path, rounds: int, tell: Callable[[str], None]) -> None:
    """Measure, and put tables and figure into the page; CSV files and the figure into the folder of its name."""
    check(page, COMMAND)
    runs.start_exudyn()
    rows = measure.measure(rounds, BUDGET, tell)
    tell("errors and forces with the same steps")
    tables = {"work": rows, "errors": measure.errors(), "forces": measure.forces()}
    folder = page.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        write_csv(folder / f"{name}.csv", table, list(table[0]))
    (folder / MACHINE).write_text(f"{machine()}; mean load {os.getloadavg()[1]:.0f}\n", encoding="utf-8")
    redraw(page)


def redraw(page: Path) -> None:
    """Tables and figure from the CSV files."""
    folder = page.with_suffix("")
    rows, errors, forces = (read_rows(folder / f"{name}.csv") for name in ("work", "errors", "forces"))
    _draw(rows, folder / FIGURE)
    measured_on = (folder / MACHINE).read_text(encoding="utf-8").strip()
    put(page, COMMAND, "\n\n".join(_parts(rows, errors, forces, measured_on, folder.name)))


def _parts(rows: Rows, errors: Rows, forces: Rows, measured_on: str, folder: str) -> list[str]:
    labels = list(dict.fromkeys(row["method"] for row in rows))
    return [
        _filled(
            f"{measured_on}. Processor times, medians of {1 + max(row['round'] for row in rows)} rounds of all codes "
            "in turn; a ratio is the median of the rounds' ratios. Absolute times are those of that machine."
        ),
        f"![Error over time]({folder}/{FIGURE})",
        _filled(
            f"Errors with the same step, the first one of a problem divided by {measure.SAME}, as parts of the size of "
            "what moves; a dash: the run does not come to the end."
        ),
        _errors(errors, labels).rstrip(),
        _filled(
            f"Time to an error, from runs with steps that are halved until they take {BUDGET:g} s: milliseconds of our "
            "default, and how many times as long others take. “<”: their first run is better; “≈”: beyond the last run "
            "by the order of the method; a dash: the run does not come to the end, or its errors do not fall."
        ),
        *(part for target in TARGETS for part in _times(rows, labels, target)),
        _verdict(rows),
        _filled("Force in one joint at the end, with the same steps [N]:"),
        _forces(forces).rstrip(),
    ]


def _errors(rows: Rows, labels: list[str]) -> str:
    lines = []
    for problem in PROBLEMS:
        mine = {row["method"]: row for row in rows if row["problem"] == problem.name}
        cells = []
        for label in labels:
            error = float(mine[label].get("error", np.nan)) if label in mine else np.nan
            cells.append(_missing(problem.mujoco, label) if np.isnan(error) else f"{error:.1e}")
        lines.append([_name(problem), f"{mine[measure.OURS]['h']:g}", *cells])
    return markdown_table(("problem", "h [s]", *labels), lines)


def _ratios(rows: Rows, label: str, target: float) -> dict[str, float]:
    """By problem: how many times as long a method takes as our default, where it reaches the error."""
    found = {}
    for problem in PROBLEMS:
        ratios = [
            milliseconds_to(_series(rows, problem.name, label, i), target)[1]
            / milliseconds_to(_series(rows, problem.name, measure.OURS, i), target)[1]
            for i in range(1 + max(row["round"] for row in rows))
        ]
        if np.isfinite(np.median(ratios)):
            found[problem.name] = float(np.median(ratios))
    return found


def _verdict(rows: Rows) -> str:
    target = TARGETS[0]
    exudyn = [_ratios(rows, f"Exudyn, index {i}", target) for i in (2, 3)]
    best = [min(found[name] for found in exudyn if name in found) for name in {**exudyn[0], **exudyn[1]}]
    mujoco = _ratios(rows, "MuJoCo, RK4", target)
    faster = [name for name, ratio in mujoco.items() if ratio < 1]
    slower = [
        f"{ratio:.1f} times as long on {name}"
        for name, ratio in mujoco.items()
        if ratio > 1 and milliseconds_to(_series(rows, name, "MuJoCo, RK4", 0), target)[0] != "< "
    ]
    late = [name for name, ratio in _ratios(rows, "ours, rkmk4", target).items() if ratio > 1.5]
    return _filled(
        f"To {target:.0e} the better of Exudyn's methods takes {min(best):.1f} to {max(best):.1f} times as long as our "
        f"default. MuJoCo is faster on {', '.join(faster) or 'none'}; it takes {', '.join(slower) or 'no longer'}. "
        "Methods of order 4 are the better choice for more accuracy, but where springs are stiff "
        f"({', '.join(late) or 'nowhere here'}): there explicit steps must be short whatever accuracy is wanted."
    )


def _number(x: float) -> str:
    return f"{x:.0f}" if x >= 10 else f"{x:.2g}"


def _times(rows: Rows, labels: list[str], target: float) -> list[str]:
    lines = []
    for problem in PROBLEMS:
        rounds = range(1 + max(row["round"] for row in rows))
        of = {
            label: [milliseconds_to(_series(rows, problem.name, label, i), target) for i in rounds] for label in labels
        }
        how, first = of[measure.OURS][0][0], np.array([ms for _, ms in of[measure.OURS]])
        cells = [_name(problem), f"{how}{_number(np.median(first))}"]
        for label in labels[1:]:
            how, ratio = of[label][0][0], np.median(np.array([ms for _, ms in of[label]]) / first)
            cells.append(_missing(problem.mujoco, label) if np.isnan(ratio) else f"{how}{_number(ratio)}")
        lines.append(cells)
    header = (f"to {target:.0e}", f"{labels[0]} [ms]", *(f"{label} [×]" for label in labels[1:]))
    return [markdown_table(header, lines).rstrip()]


def _forces(forces: Rows) -> str:
    lines = []
    for row, problem in zip(forces, PROBLEMS, strict=True):
        values = [float(row.get(key, np.nan)) for key in ("exact", "ours", "Exudyn", "MuJoCo")]
        joint = f"`{row['joint']}`" + ("" if row["unique"] else ", not unique")
        lines.append([_name(problem), joint, *("" if np.isnan(x) else f"{x:.6g}" for x in values)])
    return markdown_table(("problem", "joint", "independent", "ours, default", "Exudyn, index 3", "MuJoCo, RK4"), lines)


def _series(rows: Rows, problem: str, label: str, number: int) -> Rows:
    return [r for r in rows if (r["problem"], r["method"], r["round"]) == (problem, label, number)]


def _missing(told: bool, label: str) -> str:
    return "" if label.startswith("MuJoCo") and not told else "–"


def _name(problem: Any) -> str:
    return f"{problem.name}, {problem.title}" if problem.name[0] == "A" else problem.title


def _filled(text: str) -> str:
    return fill(" ".join(text.split()), 120, break_on_hyphens=False)


def _draw(rows: Rows, path: Path) -> None:
    labels = list(dict.fromkeys(row["method"] for row in rows))
    with figure(path, (11.0, 6.4)) as drawing:
        every = drawing.subplots(2, 3)
        for axes, problem in zip(every.flat, PROBLEMS, strict=True):
            for i, label in enumerate(labels):
                mine = [row for row in rows if (row["problem"], row["method"]) == (problem.name, label)]
                steps = sorted({row["h"] for row in mine}, reverse=True)
                times = [np.median([row["ms"] for row in mine if row["h"] == h]) for h in steps]
                errors = [next(row["error"] for row in mine if row["h"] == h) for h in steps]
                style = "o-" if label.startswith("ours") else "s--"
                axes.loglog(times, errors, style, color=f"C{i}", markersize=3, label=label)
            axes.set(title=_name(problem))
            axes.xaxis.set_minor_formatter(NullFormatter())
        for axes in every[-1]:
            axes.set_xlabel("ms")
        for axes in every[:, 0]:
            axes.set_ylabel("error")
        every.flat[0].legend(fontsize=7)
