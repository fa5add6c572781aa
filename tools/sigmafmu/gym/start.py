"""How episodes start: parameters and initial values, some of them drawn anew by each reset."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from sigmafmu.fmu import Fmu
from sigmafmu.sweeps.plan import one_real
from sigmafmu.sweeps.sampling import Distribution, at, distribution
from sigmafmu.variables import SettingValue, parse_settings

Start = SettingValue | Distribution
"""A constant, or what is drawn: a distribution of SciPy, or text such as `U(-0.1,0.1)` or `N(0,0.01)`."""


class Starts:
    """Checked constants, and distributions with the generator's numbers as their shares."""

    def __init__(self, fmu: Fmu, parameters: Mapping[str, Start]):
        self.constants: dict[str, Any] = {}
        self._drawn: dict[str, Distribution] = {}
        for name, value in parameters.items():
            if isinstance(value, str) and re.fullmatch(r"\s*[A-Z]+\(.*\)\s*", value):
                value = distribution(value, "gym")
            if hasattr(value, "ppf"):
                self._drawn[one_real(fmu, name)] = value
            else:
                parse_settings(fmu, {name: value})
                self.constants[name] = value

    def draw(self, generator: np.random.Generator) -> dict[str, float]:
        """One value of each distribution."""
        if not self._drawn:
            return {}
        shares = generator.random((1, len(self._drawn)))
        return {name: column.item() for name, column in at(self._drawn, shares).items()}
