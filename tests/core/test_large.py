"""Large mechanisms: chains and random trees of joints of any types start and step at a cost that grows as they do."""

from time import perf_counter

import numpy as np
import pytest

from sigmafmu import _core

from .test_elimination import grown


def seconds(shape: str, bodies: int) -> float:
    """To build, assemble and initialise, and for one step; the fastest of five."""
    mechanism = _core.Mechanism()
    mechanism.name = "Large"
    mechanism.multibody = grown(shape, bodies)
    times = []
    for _ in range(5):
        start = perf_counter()
        _core.Simulation(mechanism).advance(1e-2, 1)
        times.append(perf_counter() - start)
    return min(times)


@pytest.mark.parametrize("shape", ["chain", "tree"])
def test_start_and_step_grow_with_the_number_of_bodies(shape):
    bodies = np.array([99, 198, 396, 792, 1584])
    times = [seconds(shape, n) for n in bodies.tolist()]
    # About 1.2, or more on a busy machine: large mechanisms leave the processor's caches. Cubic work would be near 3.
    assert np.polyfit(np.log(bodies), np.log(times), 1)[0] < 2


@pytest.mark.parametrize("shape", ["chain", "tree"])
def test_a_large_tree_has_independent_equations(shape):
    found = _core.freedom(grown(shape, 1584))
    assert found.groups == []
    assert found.independent == found.equations
