"""The study: what the integrator does beside Holzinger, Arnold, Gerstmayr (2025), Müller (2022) and Exudyn.

A chapter is a module with a `CHAPTER` (see `chapter`). `runner` does the work of the chosen chapters, `cli` is the
command `python -m research study`.
"""

from importlib import import_module

from research.study.chapter import Chapter

LGT_CHAPTERS = (
    "lgt_accuracy",
    "lgt_top",
    "lgt_constraints",
    "lgt_cost",
    "lgt_work",
    "lgt_stiff",
    "lgt_vector_space",
    "lgt_rkmk54",
)
"""Those on the local-global transition maps of Müller (2022)."""
FLEXIBLE_CHAPTERS = ("flexible_accuracy", "flexible_work", "flexible_limits", "flexible_bending")
"""Those on flexible bodies."""
CHAPTERS = (
    "histories",
    "convergence",
    "work_precision",
    "iterations",
    "algorithm1",
    "stability",
    "sigma",
    "start",
    "conditioning",
    "long_runs",
    *LGT_CHAPTERS,
    *FLEXIBLE_CHAPTERS,
    "orderings",
)
"""Modules of this package with a chapter each, in the order of the report."""


def load(names: tuple[str, ...] = CHAPTERS) -> list[Chapter]:
    """The chapters in the modules `names`."""
    return [import_module(f"research.study.{name}").CHAPTER for name in names]
