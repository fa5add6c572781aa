"""The programs of docs/uncertainty.md, where the answer is known. test_examples.py runs them as they stand there."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm, uniform

from ..docs.pages import blocks

FREE_BODY = Path(__file__).parents[2] / "models" / "library" / "FreeBody.yaml"


@pytest.fixture(scope="module")
def indices():
    """The function of the page."""
    (block,) = [b for b in blocks() if b.page == "uncertainty.md" and "def indices(" in b.text]
    variables = {}
    exec(compile(block.text.partition("\nfound = ")[0], block.name, "exec"), variables)
    return variables["indices"]


def test_sobol_indices_of_a_body_that_flies(indices):
    """At T the height is z + v T, so the indices are the shares of its variance."""
    T = 0.5
    z, v = norm(0.0, 0.1), uniform(1.0, 1.0)
    names = {"body.initialPosition[3]": z, "body.initialVelocity[3]": v}
    options = {"stop_time": T, "step_size": T, "workers": 1, "constants": {"integrator.stepSize": 0.1}}
    found = indices(FREE_BODY, names, "final(body.position[3])", n=256, **options)
    shares = np.array([z.var(), T**2 * v.var()]) / (z.var() + T**2 * v.var())
    np.testing.assert_allclose(found.first_order, shares, atol=0.03)
    np.testing.assert_allclose(found.total_order, shares, atol=0.03)
