"""What the chapters on local-global transition maps compare: Table 1 of Müller (2022), and the methods on top of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from research.measure import INDEX2, STABILIZED
from sigmafmu.plots import COLORS

GROUPS = {"R3xSO3": 1, "SE3": 2}
MAPS = {"exp": 1, "cayley": 2, "cayley2": 3}
ABSOLUTE = {"quaternion": 1, "rotationVector": 2}
METHODS: dict[str, dict[str, float]] = {
    "generalizedAlpha": {"method": 1, "formulation": STABILIZED},
    "generalizedAlpha, index 2": {"method": 1, "formulation": INDEX2},
    "bliedf2": {"method": 4, "formulation": STABILIZED},
    "rkmk4": {"method": 2},
    "rkmk54": {"method": 3},
}
"""Methods and their settings; the first formulation is the FMUs' default."""
ORDERS = {"generalizedAlpha": 2, "bliedf2": 2, "rkmk4": 4, "rkmk54": 5}
"""What each method promises."""
FIXED_STEPS = {"relative_tolerance": 1e9, "absolute_tolerance": 1e9}
"""Tolerances with which rkmk54 accepts every step."""

_ROWS = {("SE3", "exp"): "a", ("R3xSO3", "exp"): "b", ("R3xSO3", "cayley"): "c", ("SE3", "cayley"): "d"}
_LINES = {"exp": ("-", "o"), "cayley": ("--", "s"), "cayley2": (":", "^")}


@dataclass(frozen=True)
class Combination:
    """A group with a coordinate map on it, and the absolute coordinates that are updated."""

    group: str
    map: str
    absolute: str = "quaternion"

    @property
    def settings(self) -> dict[str, float]:
        """Attributes of `_core.IntegratorSettings`."""
        return {
            "group": GROUPS[self.group],
            "local_coordinates": MAPS[self.map],
            "absolute_coordinates": ABSOLUTE[self.absolute],
        }

    @property
    def name(self) -> str:
        """For tables and legends, without the absolute coordinates."""
        return f"{'R³×SO(3)' if self.group == 'R3xSO3' else 'SE(3)'}, {self.map}"

    @property
    def table1(self) -> str:
        """Its place in Table 1; the second-order Cayley map has none."""
        letter = _ROWS.get((self.group, self.map))
        return f"{ABSOLUTE[self.absolute]}.{letter}" if letter else "–"

    @property
    def core(self) -> str:
        """Its name in `_core.lie`."""
        return f"{self.group}_{self.map}".lower()

    @property
    def style(self) -> dict[str, object]:
        """Colour: the group; line and marker: the map."""
        line, marker = _LINES[self.map]
        color = COLORS[list(GROUPS).index(self.group)]
        return {"color": color, "linestyle": line, "marker": marker, "markersize": 3}


COMBINATIONS = [Combination(*names) for names in product(GROUPS, MAPS)]
"""Of groups and maps, with quaternions."""
DEFAULT = COMBINATIONS[0]


def methods(constrained: bool) -> list[str]:
    """Without constraints all formulations are one."""
    return [name for name in METHODS if constrained or "index" not in name]


def order(steps: Sequence[float], errors: Sequence[float], floor: float, ceiling: float) -> float:
    """Observed order: slope over the (up to three) smallest steps whose errors lie between floor and ceiling."""
    used = [(h, e) for h, e in zip(steps, errors, strict=True) if floor < e < ceiling][-3:]
    if len(used) < 2:
        return np.nan
    h, e = np.log(np.array(used)).T
    return float(np.polyfit(h, e, 1)[0])


def number(value: float, digits: str = ".1e") -> str:
    """For tables; a run that failed has NaN."""
    return "fails" if np.isnan(value) else f"{value:{digits}}"


def legend_handles() -> list[Line2D]:
    """One line for each group and map."""
    return [Line2D([], [], label=c.name, **c.style) for c in COMBINATIONS]


def step_axis(axes: Axes, steps: Sequence[float]) -> None:
    """Logarithmic, every third step labelled."""
    axes.set_xscale("log")
    axes.set_xticks(list(steps[::3]), [f"{h:.2g}" for h in steps[::3]])
    axes.set_xticks([h for h in steps if h not in steps[::3]], [], minor=True)
