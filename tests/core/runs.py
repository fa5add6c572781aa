"""What the tests of the generalized-alpha method share: which runs they make of every mechanism."""

import pytest

from .helpers import FORMULATIONS, MODELS, MODIFIED, TANGENT_FREE

every_model = pytest.mark.parametrize("model", MODELS)
every_formulation = pytest.mark.parametrize("formulation", FORMULATIONS.values(), ids=FORMULATIONS)
TIGHT = {"relative_tolerance": 1e-13, "absolute_tolerance": 1e-13}  # Newton's method to rounding
# Steps and the number of them before the one that is examined.
STEPS = {"HeavyTop": (1e-3, 20), "HighSpeedRotor": (1e-5, 20), "SliderCrank": (2e-3, 50)}
ITERATIONS = {
    "tangent-free": {"jacobian": TANGENT_FREE},
    "modified": {"newton": MODIFIED},
    "modified, tangent-free": {"newton": MODIFIED, "jacobian": TANGENT_FREE},
}
