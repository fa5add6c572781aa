"""The study: what the integrator does beside what Holzinger, Arnold, Gerstmayr (2025) print and beside Exudyn.

A chapter is a module with a `CHAPTER` (see `chapter`). `runner` does the work of the chosen chapters, `cli` is the
command `sigmafmu study`.
"""

from importlib import import_module

from sigmafmu.study.chapter import Chapter

CHAPTERS = (
    "histories",
    "convergence",
    "work_precision",
    "iterations",
    "predictor",
    "stability",
    "sigma",
    "start",
    "conditioning",
    "long_runs",
    "orderings",
)
"""Modules of this package with a chapter each, in the order of the report."""


def load(names: tuple[str, ...] = CHAPTERS) -> list[Chapter]:
    """The chapters in the modules `names`."""
    return [import_module(f"sigmafmu.study.{name}").CHAPTER for name in names]
