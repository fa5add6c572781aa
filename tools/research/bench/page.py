"""The page of all measurements."""

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from research.bench import Effort, growth, machine, robots, runs, solvers, steps, work
from sigmafmu import SigmafmuError

SECTIONS = (steps, growth, robots, work, solvers)
NEEDED = ("exudyn", "mujoco", "pinocchio", "kvxopt")
INTRODUCTION = """\
# What steps cost

Written by `make bench`; the folder `{folder}` beside this page has the tables as CSV files, and the figures. Times are
processor times of one core. All candidates of a table run in turn, {rounds} times; each keeps its fastest run, so that
another load on the machine disturbs least. It still makes all of them slower: compare times of one table, as ratios.

{machine}.
"""


def write(output: Path, quick: bool, rounds: int, tell: Callable[[str], None]) -> None:
    """Measure everything; the page, and a folder of its name with CSV files and figures.

    SigmafmuError: a package is missing or Exudyn's fast module cannot be loaded.
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise SigmafmuError(f"the benchmark needs {', '.join(missing)}; `make bench` installs what it needs")
    runs.start_exudyn()
    folder = output.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    effort = Effort(quick, rounds, tell)
    parts = [INTRODUCTION.format(folder=folder.name, rounds=rounds, machine=machine())]
    for section in SECTIONS:
        parts.append(f"\n## {section.TITLE}\n\n{section.report(section.measure(effort), folder)}")
    output.write_text("".join(parts), encoding="utf-8")
