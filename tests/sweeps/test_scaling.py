"""The simulation of many workers, where its result is known."""

import pytest

from research.sweep_costs.scaling import CHUNKS_EACH, SPREAD, efficiency


def test_one_worker_waits_for_each_chunk():
    assert efficiency(1, 3.0, 1.0) == pytest.approx(0.75, abs=0.02)


def test_without_a_price_workers_wait_for_the_last_alone():
    assert efficiency(1, 1.0, 0.0) == 1
    assert 1 - (1 + SPREAD) / CHUNKS_EACH < efficiency(100, 1.0, 0.0) < 1


def test_a_busy_process_sets_the_rate():
    """It serves 10 chunks in a second, which is the work of 10 workers of 100."""
    assert efficiency(100, 1.0, 0.1) == pytest.approx(0.1, rel=0.02)
