"""Derivatives by differences, for functions that are smooth and cheap."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

LEVELS = 4
RELATIVE_STEP = 0.04
"""Largest step as part of the motion's size (1 rad): far above rounding, and extrapolation takes care of the rest."""


def derivative(function: Callable[[float], np.ndarray], step: float) -> np.ndarray:
    """f'(0): central differences with steps h, h/2, h/4, h/8, extrapolated to order 8."""
    table = [(function(h) - function(-h)) / (2 * h) for h in (step / 2**i for i in range(LEVELS))]
    for order in range(1, LEVELS):
        weight = 4**order
        table = [(weight * fine - coarse) / (weight - 1) for coarse, fine in pairwise(table)]
    return table[0]
