"""How steps, start and memory grow with the number of bodies."""

import ctypes
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from research.bench import Effort, limits, runs
from research.mechanisms import FAMILIES, named
from research.study.output import figure
from sigmafmu import _core
from sigmafmu.markdown import markdown_table

TITLE = "Growth with the number of bodies"
FILE = "growth.csv"
FIGURE = "growth.png"
H = 1e-3  # s
SIZES = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
QUICK_SIZES = (1, 5, 20)
EXUDYN = ("Chain", "RevoluteChain")
EXUDYN_LARGEST = 500
BODY_STEPS = 4000
"""Bodies times steps in a run, at least; 10 steps at least."""
EXUDYN_STEPS = 30
LONGEST_START = 0.5
"""Seconds; a family ends with the first mechanism that needs more to start."""
PER_BODY = "ns_per_body_and_iteration"
CENTER = np.zeros(3)
LABELS = {"Chain": "spherical chain", "RevoluteChain": "revolute chain", "RandomTree": "random tree"} | {
    "FourBarRow": "row of four-bars"
}


def measure(effort: Effort) -> list[dict[str, Any]]:
    """A row for each family, code and size."""
    rows = []
    families = list(FAMILIES)
    for size in QUICK_SIZES if effort.quick else SIZES:
        effort.tell(f"chains, trees and rows of {size}")
        candidates = {}
        for family in families:
            name = f"{family}{size}"
            bodies = len(named(name).multibody.bodies)
            steps = max(10, BODY_STEPS // bodies)
            candidates[family, "ours"] = lambda name=name, steps=steps: runs.core(named(name), H, steps, CENTER)
            if family in EXUDYN and size <= EXUDYN_LARGEST:
                for modified in (False, True):
                    candidates[family, f"Exudyn {modified}"] = partial(
                        runs.exudyn,
                        named(name).multibody,
                        H,
                        max(EXUDYN_STEPS, steps // 8),
                        CENTER,
                        modified=modified,
                        sparse=size >= 5,
                    )
        found = runs.fastest(candidates, effort.rounds if size < 500 else min(2, effort.rounds))
        for family in list(families):
            mechanism = named(f"{family}{size}")
            bodies = len(mechanism.multibody.bodies)
            seconds, memory = _start(mechanism)
            rows.append(_row(family, "ours", size, bodies, found[family, "ours"]))
            rows[-1] |= {"start_ms": 1e3 * seconds, "bytes_per_body": memory / bodies}
            if seconds > LONGEST_START:
                families.remove(family)
            peers = [run for (which, code), run in found.items() if which == family and code != "ours"]
            if peers:
                rows.append(_row(family, "Exudyn", size, bodies, min(peers, key=lambda run: run.seconds)))
    for size, (seconds, per_iteration) in limits.chains().items():
        if size in SIZES:
            run = runs.Run(seconds, seconds / size / per_iteration, CENTER)
            rows.append(_row("Chain", "limit", size, size, run))
    return rows


def _row(family: str, code: str, size: int, bodies: int, run: runs.Run) -> dict[str, Any]:
    return {
        "family": family,
        "code": code,
        "size": size,
        "bodies": bodies,
        "us_per_step": 1e6 * run.seconds,
        "iterations": run.iterations,
        PER_BODY: 1e9 * run.seconds / bodies / run.iterations,
    }


def _start(mechanism: _core.Mechanism) -> tuple[float, float]:
    """Seconds to build, assemble and initialize, and bytes that a simulation holds after a step."""
    before, start = _allocated(), process_time()
    simulation = _core.Simulation(mechanism)
    seconds = process_time() - start
    simulation.advance(H, 1)
    return seconds, _allocated() - before


class _MallocInfo(ctypes.Structure):
    """`struct mallinfo2` of the C library."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in [
            "arena",
            "ordblks",
            "smblks",
            "hblks",
            "hblkhd",
            "usmblks",
            "fsmblks",
            "uordblks",
            "fordblks",
            "keepcost",
        ]
    )


def _allocated() -> float:
    """Bytes that this process has from malloc; nan: the C library does not tell (glibc before 2.33, others)."""
    try:
        mallinfo = ctypes.CDLL(None).mallinfo2
    except AttributeError:
        return np.nan
    mallinfo.restype = _MallocInfo
    info = mallinfo()
    return info.uordblks + info.hblkhd


def report(rows: list[dict[str, Any]], folder: Path) -> str:
    """Figure and table."""
    _draw(rows, folder / FIGURE)
    sizes = sorted({row["size"] for row in rows})
    parts = [
        f"h = {H:g} s, default settings; Exudyn with its faster Newton method. Per body and iteration a step costs the "
        "same at any size if its work grows as the mechanism does.\n\n"
        f"![Time per step]({folder.name}/{FIGURE})\n\n"
    ]
    of = {(row["family"], row["code"], row["size"]): row for row in rows}
    lines = []
    for family, code in dict.fromkeys((row["family"], row["code"]) for row in rows):
        mine = [of.get((family, code, size)) for size in sizes]
        cells = ["" if row is None else f"{row[PER_BODY]:.0f}" for row in mine]
        lines.append([_label(family, code), *cells])
    parts.append(markdown_table(("ns per body and iteration, N =", *map(str, sizes)), lines))
    ours = {family: {s: of[family, "ours", s] for s in sizes if (family, "ours", s) in of} for family in FAMILIES}
    starts = []
    for family, mine in ours.items():
        cells = [f"{mine[size]['start_ms']:.3g}" if size in mine else "" for size in sizes]
        starts.append([LABELS[family], *cells, f"{1e-3 * mine[max(mine)]['bytes_per_body']:.1f}"])
    parts.append("\n" + markdown_table(("start in ms, N =", *map(str, sizes), "kB per body, largest N"), starts))
    ratios = [
        f"{LABELS[family]} {mine[1000][PER_BODY] / mine[100][PER_BODY]:.2f}"
        for family, mine in ours.items()
        if {100, 1000} <= set(mine)
    ]
    if ratios:
        parts.append(f"\nPer body and iteration, N = 1000 beside N = 100: {', '.join(ratios)}.\n")
    ended = [f"{LABELS[family]} at N = {max(mine)}" for family, mine in ours.items() if max(mine) < sizes[-1]]
    if ended:
        parts.append(f"\nA start of more than {LONGEST_START:g} s ended: {', '.join(ended)}.\n")
    parts.append(
        "\nA row of N four-bars has 2 N + 1 bodies and 3 N dependent equations. Start is building, assembling and "
        "initializing; memory is all that a simulation holds, the plans of its solvers included.\n"
    )
    return "".join(parts)


def _label(family: str, code: str) -> str:
    return f"{'' if code == 'ours' else f'{code}, '}{LABELS[family]}"


def _draw(rows: list[dict[str, Any]], path: Path) -> None:
    with figure(path, (7.5, 4.5)) as drawing:
        axes = drawing.add_subplot()
        for family, code in dict.fromkeys((row["family"], row["code"]) for row in rows):
            mine = [row for row in rows if (row["family"], row["code"]) == (family, code)]
            axes.loglog(
                [row["bodies"] for row in mine],
                [row["us_per_step"] for row in mine],
                {"ours": "o-", "Exudyn": "s--", "limit": ":"}[code],
                color=f"C{list(LABELS).index(family)}",
                markersize=4,
                label=_label(family, code),
            )
        axes.set(xlabel="bodies", ylabel="µs per step", title="Time per step")
        axes.legend(loc="upper left")
