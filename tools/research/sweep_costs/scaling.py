"""Many workers, simulated: one process after the other gives chunks away and takes them back; workers wait for it."""

import heapq
import os
import time

import numpy as np
import psutil

import sigmafmu
from research.sweep_costs import MODEL, OUTPUTS, STEP_SIZE, STOP_TIME, used_by
from research.sweep_costs.endurance import CHUNK
from sigmafmu.sweeps.cluster import connected

WORKERS = (1, 2, 10, 100, 1000)
CHUNKS_EACH = 30
SPREAD = 0.2
"""Of the time of a chunk, to both sides."""
QUICK = {"integrator.stepSize": 1e-2}
"""Runs that cost little, with results of the usual size."""
IDLE = 5.0  # s


def overhead(chunks: int) -> float:
    """Seconds of processors that client and scheduler take for a chunk, beyond what they take while nothing happens."""
    with connected(None, 2) as client:
        workers = set(client.run(os.getpid).values())
        marks = []

        def mark(finished: int, runs: int, _failed: int) -> None:
            if finished in (CHUNK, runs):  # the first chunk brings imports, and the file comes after the last
                marks.append((time.perf_counter(), _both(workers)))

        mark(CHUNK, 0, 0)
        time.sleep(IDLE)
        mark(CHUNK, 0, 0)
        sigmafmu.sweep(
            MODEL,
            {"crank.mass": np.linspace(0.1, 0.3, (chunks + 1) * CHUNK), **QUICK},
            outputs=OUTPUTS,
            stop_time=STOP_TIME,
            step_size=STEP_SIZE,
            scheduler=client,
            chunk=CHUNK,
            on_progress=mark,
        )
        (rest, rested), (busy, worked) = (np.subtract(marks[i + 1], marks[i]) for i in (0, 2))
        return (worked - rested / rest * busy) / chunks


def _both(workers: set[int]) -> float:
    """Seconds of processors of the client and the scheduler."""
    uses = used_by(psutil.Process(os.getpid()))
    return sum(use.seconds for pid, use in uses.items() if pid not in workers)


def efficiency(workers: int, chunk_time: float, price: float) -> float:
    """Share of the time in which workers compute, if each chunk takes `price` seconds of the one process.

    Events in time order: a worker that is free asks; the process serves one after the other; then the worker computes.
    """
    random = np.random.default_rng(0)
    asking = [(0.0, worker) for worker in range(workers)]
    free, computed, end = 0.0, 0.0, 0.0
    for _ in range(CHUNKS_EACH * workers):
        asked, worker = heapq.heappop(asking)
        free = max(free, asked) + price
        work = chunk_time * random.uniform(1 - SPREAD, 1 + SPREAD)
        computed += work
        end = max(end, free + work)
        heapq.heappush(asking, (free + work, worker))
    return computed / (workers * end)
