"""Writes what was measured into its part of docs/sweep.md."""

import os
from collections.abc import Callable
from pathlib import Path

from research.bench import machine
from research.page import check, put
from research.sweep_costs import OUTPUT_SCALARS, SHORT, STEP_SIZE, STOP_TIME
from research.sweep_costs.compare import Measured, compare
from research.sweep_costs.endurance import CHUNK, Endurance, Stretch, endure, plain
from research.sweep_costs.scaling import WORKERS, efficiency, overhead
from sigmafmu.markdown import markdown_table

COMMAND = "python -m research sweeps"
RUN_TIMES = (0.1, 1.0)
"""Seconds of a run, beside the measured one, whose efficiency is simulated."""


def write(page: Path, runs: int, tell: Callable[[str], None]) -> None:
    """Measure with so many runs, and put it into the page."""
    check(page, COMMAND)
    tell("beside FMPy")
    ways = compare(min(1000, runs), min(50, runs))
    tell(f"{runs // 5} runs on 1 and on 2 workers")
    alone, both = (plain(runs // 5, workers) for workers in (1, 2))
    tell(f"{runs} runs, killed in the middle")
    whole = endure(runs, 2)
    tell("what a chunk costs")
    scaling = _scaling(overhead(200), whole.before.cost("workers"))
    put(page, COMMAND, "\n".join((_where(), _beside_fmpy(ways), _endurance(whole, alone, both), scaling)))


def _where() -> str:
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[2]
    return f"""\
Measured on {machine().partition(",")[0]}, {cores} cores,
with a mean load of {load:.0f}: other programs ran too. So times of the clock are long, and seconds of processors
are what to compare; runs/s per core are runs for each of these.
"""


def _beside_fmpy(ways: list[Measured]) -> str:
    names = list(dict.fromkeys((w.way, w.processes) for w in ways))
    rows = []
    for name, processes in names:
        row = [name, str(processes)]
        for stop_time in (STOP_TIME, SHORT):
            (one,) = [w for w in ways if (w.way, w.processes, w.stop_time) == (name, processes, stop_time)]
            ours = next(w for w in reversed(ways) if w.stop_time == stop_time)
            row += [f"{1e3 * one.cpu / one.runs:.3g}", f"{one.per_core:.3g}", f"{ours.per_core / one.per_core:.2g}"]
        rows.append(row)
    head = ["way", "processes"]
    head += [f"{t:g} s: {what}" for t in (STOP_TIME, SHORT) for what in ("ms", "runs/s", "`sweep` gains")]
    return f"""\
### Beside FMPy

{ways[-1].runs} runs of {STOP_TIME:g} s, and as many of {SHORT:g} s, of the slider-crank with H = {STEP_SIZE:g} s,
h = 1 ms, {len(OUTPUT_SCALARS)} outputs; {ways[0].runs} where each opens the file. Each way has its processes, and what
it keeps, before the clock starts. All agree to rounding. ms are those of all processes together for a run, runs/s those
of a core; `sweep` also keeps its runs on the disk, and writes the file.

{markdown_table(head, rows)}
What counts is what is kept. A master that opens the FMU for each run spends its time there; one that keeps an instance,
as FMPy's example does with code that is written for each study, and as `sweep` does, spends it on the mechanism. What
`sweep` takes more is for the scheduler, finished runs on the disk, names and units, and the file.
"""


def _endurance(whole: Endurance, alone: Stretch, both: Stretch) -> str:
    rows = [
        ("1 worker", *_row(alone)),
        ("2 workers", *_row(both)),
        ("2 workers, before the kill", *_row(whole.before)),
        ("2 workers, after it", *_row(whole.after)),
    ]
    head = (
        "",
        "runs",
        "runs/s",
        "start in s",
        "ms: workers",
        "client",
        "scheduler",
        "MB: workers",
        "client",
        "scheduler",
    )
    return f"""\
### {whole.runs} runs, killed in the middle

`sigmafmu sweep` of {whole.runs} such runs with a scalar, in chunks of {CHUNK}, on 2 workers. The command was killed
(SIGKILL) after {whole.before.ended[1]} runs. Its cluster was gone {whole.gone:.1f} s later; `--resume` found
{"all" if not whole.lost else f"all but {whole.lost}"} of these, and did the others. {whole.failed} runs failed.
The file has {whole.size:.1f} MB for {whole.raw:.1f} MB of numbers; it took {whole.after.close:.1f} s, with the end of
the cluster. ms are those of processors per run, MB the largest memory (of all workers together).

{markdown_table(head, rows)}
By the clock, on cores that others used too, two workers were {both.rate / alone.rate:.2f} times as fast as one;
by seconds of processors per run, {2 * alone.cost("workers") / both.cost("workers"):.2f} times.
"""


def _row(stretch: Stretch) -> tuple[str, ...]:
    roles = ("workers", "client", "scheduler")
    costs = (f"{1e3 * stretch.cost(role):.3g}" for role in roles)
    memory = (f"{stretch.peak[role]:.0f}" for role in roles)
    return str(stretch.runs), f"{stretch.rate:.3g}", f"{stretch.start:.1f}", *costs, *memory


def _scaling(price: float, run: float) -> str:
    rows = []
    for chunk, seconds in ((1, run), (CHUNK, run), *((CHUNK, t) for t in RUN_TIMES), (1, 60.0)):
        shares = (f"{efficiency(workers, chunk * seconds, price):.0%}" for workers in WORKERS)
        rows.append((f"{seconds:.2g} s" if seconds > run else f"{1e3 * run:.2g} ms", str(chunk), *shares))
    return f"""\
### Up to 1000 workers: simulated

Workers depend on each other only through the client and the scheduler, which took {1e3 * price:.2g} ms of
processors for each chunk of {CHUNK} runs when measured alone. The table is **simulated, not measured**: if one
process serves all chunks, one after the other, at that price, what share of their time do workers compute? The network
and the heartbeats of 1000 workers are not in it.

{markdown_table(("a run takes", "runs in a chunk", *(f"{w} worker{'s' * (w > 1)}" for w in WORKERS)), rows)}
So a chunk should take longer than {1e3 * price:.2g} ms times the number of workers; `--chunk` sets its size.
"""
