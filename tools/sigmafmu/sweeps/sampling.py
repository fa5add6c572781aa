"""Samples of distributions: plain random, Latin hypercube, or Sobol points, from a seed."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from sigmafmu import SigmafmuError, extras


class Distribution(Protocol):
    """What is needed of a frozen distribution of scipy.stats."""

    def ppf(self, q: np.ndarray) -> np.ndarray:
        """Values below which the shares `q` lie."""
        ...


SAMPLINGS = ("random", "latin", "sobol")


@dataclass(frozen=True)
class _Family:
    size: int
    """How many numbers it has."""
    valid: Callable[..., bool]
    make: Callable[..., Any]
    """From scipy.stats and the numbers."""


_FAMILIES = {
    "N": _Family(2, lambda mean, deviation: deviation > 0, lambda s, mean, deviation: s.norm(mean, deviation)),
    "U": _Family(2, lambda low, high: low < high, lambda s, low, high: s.uniform(low, high - low)),
    "T": _Family(
        3,
        lambda low, mode, high: low <= mode <= high and low < high,
        lambda s, low, mode, high: s.triang((mode - low) / (high - low), low, high - low),
    ),
    "LN": _Family(2, lambda median, sigma: min(median, sigma) > 0, lambda s, m, sigma: s.lognorm(sigma, scale=m)),
}
"""By the letters that name them."""


def distribution(text: str, extra: str = "sweep") -> Distribution:
    """`N(mean,deviation)`, `U(low,high)`, `T(low,mode,high)` (triangle) or `LN(median,sigma)` (log-normal).

    `extra` is what brings SciPy to whoever asks. Raises SigmafmuError.
    """
    match = re.fullmatch(r"\s*([A-Z]+)\(([^()]*)\)\s*", text)
    try:
        family = _FAMILIES[match[1]] if match else None
        numbers = [float(part) for part in match[2].split(",")] if match else []
    except (KeyError, ValueError):
        family = None
    if family is None or len(numbers) != family.size:
        known = "N(mean,deviation), U(low,high), T(low,mode,high) or LN(median,sigma)"
        raise SigmafmuError(f"'{text}' is no distribution; write {known}")
    if not (np.isfinite(numbers).all() and family.valid(*numbers)):
        raise SigmafmuError(f"'{text}' has no spread, or its numbers are in the wrong order")
    return family.make(extras.need("scipy.stats", extra), *numbers)


def sample(distributions: Mapping[str, Distribution], runs: int, sampling: str, seed: int) -> dict[str, np.ndarray]:
    """(runs,) samples of each; the same for the same seed, and names in the same order."""
    if runs < 1:
        raise SigmafmuError(f"the number of runs must be 1 or more, not {runs}")
    return at(distributions, _shares(len(distributions), runs, sampling, seed))


def at(distributions: Mapping[str, Distribution], shares: np.ndarray) -> dict[str, np.ndarray]:
    """(runs,) values of each, below which the (runs, distributions) `shares` lie; raises SigmafmuError."""
    inside = np.clip(shares, np.finfo(float).eps, 1 - np.finfo(float).eps)  # a normal distribution has no end
    columns = {name: np.asarray(d.ppf(inside[:, i]), dtype=float) for i, (name, d) in enumerate(distributions.items())}
    if bad := next((name for name, column in columns.items() if not np.isfinite(column).all()), None):
        raise SigmafmuError(f"the distribution of '{bad}' gives values that are not finite")
    return columns


def _shares(dimensions: int, runs: int, sampling: str, seed: int) -> np.ndarray:
    """(runs, dimensions) in [0, 1)."""
    if sampling == "random":
        return np.random.default_rng(seed).random((runs, dimensions))
    qmc = extras.need("scipy.stats.qmc", "sweep")
    if sampling == "latin":
        return qmc.LatinHypercube(dimensions, rng=seed).random(runs)
    if sampling == "sobol":
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="The balance properties")  # a page tells it
            return qmc.Sobol(dimensions, rng=seed).random(runs)
    raise SigmafmuError(f"there is no sampling '{sampling}'; choose one of {', '.join(SAMPLINGS)}")
