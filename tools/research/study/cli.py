"""The command `python -m research study`."""

import shlex
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from sigmafmu import SigmafmuError
from sigmafmu.console import err, out, progress_bar

MECHANISMS = {"heavy-top": "HeavyTop", "rotor": "HighSpeedRotor", "slider-crank": "SliderCrank"}
SUBJECTS = (*MECHANISMS, "lgt", "flexible", "all")
TIMED_PASSES = 2
Subject = Enum("Subject", {name: name for name in SUBJECTS}, type=str)


def study(
    subject: Annotated[
        Subject,
        typer.Argument(
            metavar="|".join(SUBJECTS),
            help="The mechanism; lgt: groups and coordinate maps on all of them; flexible: flexible bodies; or all.",
        ),
    ],
    output: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the results.")] = Path("build/study"),
    quick: Annotated[bool, typer.Option("--quick", help="A small version, for a few minutes.")] = False,
    chapter: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Only this chapter (repeatable); default: all.")
    ] = None,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Run nothing: draw figures anew from the CSV files that are in DIR.")
    ] = False,
    workers: Annotated[int, typer.Option(min=1, help="Processes that work side by side.")] = 2,
) -> None:
    """Measure the integrator beside the σ paper and Exudyn: CSV, figures, README.md.

    Work that is done already is not done again: an interrupted study goes on where it was.
    """
    from research.reference import FLEXIBLE_MODELS
    from research.reference.exudyn_models import load_exudyn
    from research.study import CHAPTERS, FLEXIBLE_CHAPTERS, LGT_CHAPTERS, load, orderings, runner

    load_exudyn()
    known = {"lgt": LGT_CHAPTERS, "flexible": FLEXIBLE_CHAPTERS}.get(subject.value, CHAPTERS)
    for name in chapter or ():
        if name not in known:
            raise SigmafmuError(f"there is no chapter {name}; there are {', '.join(known)}")
    chapters = load(tuple(name for name in known if not chapter or name in chapter))
    if redraw:
        for path in (path for c in chapters if hasattr(c, "redraw") for path in c.redraw(output)):
            out.print(f"wrote {path}", soft_wrap=True)
        return
    every = [*MECHANISMS.values(), *FLEXIBLE_MODELS]
    mechanisms = [MECHANISMS[subject.value]] if subject.value in MECHANISMS else every
    work = runner.jobs(chapters, mechanisms, quick)
    passes = 1 if quick else TIMED_PASSES
    total = sum(runner.rounds(job, passes) for job in work)
    with progress_bar(err, f"study {subject.value}", total, unit="cells") as move_to:
        done = iter(range(1, total + 1))
        results = runner.run(work, output, workers, lambda: move_to(next(done)), passes)
    words = ["python", "-m", "research", "study", subject.value, *(["--quick"] if quick else [])]
    words += [word for name in chapter or () for word in ("--chapter", name)]
    out.print(f"wrote {runner.write_report(chapters, results, output, shlex.join(words))}", soft_wrap=True)
    broken = orderings.violations(results.get(orderings.CHAPTER.name, {}))
    if broken:
        raise SigmafmuError("these do not hold: " + "; ".join(broken))
