"""The page of all measurements."""

import csv
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from textwrap import fill
from typing import Any

from research.bench import Effort, elements, growth, machine, robots, runs, solvers, steps, work
from research.study.output import write_csv
from sigmafmu import SigmafmuError

SECTIONS = {"steps": steps, "growth": growth, "robots": robots, "work": work, "solvers": solvers, "elements": elements}

MACHINE = "machine.txt"
"""Rounds, and the machine of the last measurement."""
WIDTH = 120
NEEDED = ("exudyn", "mujoco", "pinocchio", "kvxopt")
INTRODUCTION = """\
# What steps cost

Written by `make bench`; the folder `{folder}` beside this page has the tables as CSV files, and the figures. Times are
processor times of one core. All candidates of a table run in turn, {rounds} times; each keeps its fastest run, so that
another load on the machine disturbs least. It still makes all of them slower: compare times of one table, as ratios.

{machine}.
"""


def write(output: Path, only: Iterable[str] | None, effort: Effort) -> None:
    """The page, and a folder of its name with CSV files and figures; sections not in `only` from their CSV files.

    SigmafmuError: a section is not known or has no CSV file, a package is missing, Exudyn's fast module does not load.
    """
    chosen = set(SECTIONS if only is None else only)
    if chosen - set(SECTIONS):
        unknown = ", ".join(sorted(chosen - set(SECTIONS)))
        raise SigmafmuError(f"no such section: {unknown}; there are {', '.join(SECTIONS)}")
    missing = [name for name in NEEDED if chosen and find_spec(name) is None]
    if missing:
        raise SigmafmuError(f"the benchmark needs {', '.join(missing)}; `make bench` installs what it needs")
    folder = output.with_suffix("")
    files = [folder / section.FILE for name, section in SECTIONS.items() if name not in chosen]
    if absent := [str(path) for path in files if not path.exists()]:
        raise SigmafmuError(f"there is no {', no '.join(absent)}; measure these sections first")
    if chosen:
        runs.start_exudyn()
    folder.mkdir(parents=True, exist_ok=True)
    if chosen:
        (folder / MACHINE).write_text(f"{effort.rounds}\n{machine()}\n", encoding="utf-8")
    rounds, measured_on = (folder / MACHINE).read_text(encoding="utf-8").splitlines()
    parts = [INTRODUCTION.format(folder=folder.name, rounds=rounds, machine=measured_on)]
    for name, section in SECTIONS.items():
        if name in chosen:
            rows = section.measure(effort)
            write_csv(folder / section.FILE, rows, [*dict.fromkeys(key for row in rows for key in row)])
        rows = read_rows(folder / section.FILE)
        parts.append(f"\n## {section.TITLE}\n\n{section.report(rows, folder)}")
    output.write_text(_wrapped("".join(parts)), encoding="utf-8")


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Rows of a CSV file; numbers as such, empty cells left out."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return [{key: _number(text) for key, text in row.items() if text} for row in rows]


def _number(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _wrapped(text: str) -> str:
    """Paragraphs in lines of 120 characters."""
    keep = ("|", "#", "!")
    return "".join(
        line if line.startswith(keep) or len(line) <= WIDTH else f"{fill(line, WIDTH, break_on_hyphens=False)}\n"
        for line in text.splitlines(keepends=True)
    )
