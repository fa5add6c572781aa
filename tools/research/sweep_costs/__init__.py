"""What sweeps cost: beside FMPy's ways, ten thousand runs with a kill, and a simulation of many workers."""

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass

import psutil

MODEL = "SliderCrank"
STOP_TIME, SHORT, STEP_SIZE = 0.5, 0.05, 0.01  # s
SETTINGS = {"integrator.stepSize": 1e-3}
OUTPUTS = ("guide.displacement", "crankPivot.reactionForce")
OUTPUT_SCALARS = ("guide.displacement", *(f"crankPivot.reactionForce[{i}]" for i in (1, 2, 3)))
PEAK = "max(crankPivot.reactionForce)"
LOW, HIGH = 0.1, 0.3
"""Of the crank's mass [kg]."""
SEED = 1


@dataclass(frozen=True)
class Use:
    """What a process has used."""

    seconds: float
    """Of processors."""
    memory: float
    """Resident [MB]."""


def used_by(process: psutil.Process) -> Mapping[int, Use]:
    """By the number of the process, for it and all that it has started and that live."""
    found = {}
    for one in (process, *_children(process)):
        with suppress(psutil.Error):
            with one.oneshot():
                times, memory = one.cpu_times(), one.memory_info()
            found[one.pid] = Use(times.user + times.system, memory.rss / 1e6)
    return found


def own_seconds() -> float:
    """Of processors, that this process and those that it has started and that live have used."""
    return sum(use.seconds for use in used_by(psutil.Process(os.getpid())).values())


def _children(process: psutil.Process) -> Iterator[psutil.Process]:
    with suppress(psutil.Error):
        yield from process.children(recursive=True)
