"""Chains of links on spherical joints against a solution in minimal velocities: accuracy and order at any length."""

from functools import cache

import numpy as np
import pytest

from research.mechanisms.chains import X, spherical_chain
from research.reference.chain import tip

from .helpers import Rotation, simulation

LENGTHS = (1, 2, 5, 10)


@cache
def tip_error(links, h):
    run = simulation(spherical_chain(links), step_size=h)
    run.run(1.0, round(1.0 / h))
    q = run.state.q[7 * (links - 1) :]
    end = q[:3] + Rotation.from_quat(q[3:7], scalar_first=True).apply(0.5 * X)
    return np.linalg.norm(end - tip(links, 1.0))


@pytest.mark.parametrize("links", LENGTHS)
def test_the_tip_is_where_it_belongs(links):
    assert tip_error(links, 2.5e-4) <= 5e-6


@pytest.mark.parametrize("links", LENGTHS)
def test_the_error_is_of_second_order(links):
    assert np.log2(tip_error(links, 5e-4) / tip_error(links, 2.5e-4)) == pytest.approx(2.0, abs=0.1)
