"""Many workers, simulated: one process after the other gives chunks away and takes them back; workers wait for it."""

import heapq

import numpy as np

WORKERS = (1, 2, 10, 100, 1000)
CHUNKS_EACH = 30
SPREAD = 0.2
"""Of the time of a chunk, to both sides."""


def efficiency(workers: int, chunk_time: float, overhead: float) -> float:
    """Share of the time in which workers compute, if each chunk takes `overhead` seconds of the one process.

    Events in time order: a worker that is free asks; the process serves one after the other; then the worker computes.
    """
    random = np.random.default_rng(0)
    asking = [(0.0, worker) for worker in range(workers)]
    free, computed, end = 0.0, 0.0, 0.0
    for _ in range(CHUNKS_EACH * workers):
        asked, worker = heapq.heappop(asking)
        free = max(free, asked) + overhead
        work = chunk_time * random.uniform(1 - SPREAD, 1 + SPREAD)
        computed += work
        end = max(end, free + work)
        heapq.heappush(asking, (free + work, worker))
    return computed / (workers * end)
