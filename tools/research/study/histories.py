"""Motion over time as in Figs. 2, 6 and 9 of the paper: index 3, σ = 1, beside the independent solution."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from research.measure import INDEX3
from research.reference import History
from research.reference.minimal_coordinates import solve
from research.study import cases, runs
from research.study.cases import CASES
from research.study.chapter import Cell, Results
from research.study.output import figure, write_csv
from sigmafmu.markdown import markdown_table

FIGURES = {"HeavyTop": "Fig. 2", "HighSpeedRotor": "Fig. 6", "SliderCrank": "Fig. 9"}
STOP_TIMES = {"HeavyTop": (1.0, 2.5e-5), "HighSpeedRotor": (2.5, 1e-5), "SliderCrank": (5.0, 1e-5)}
"""End and step in s: the paper's, and a whole precession of the rotor."""
QUICK = {"HeavyTop": (1.0, 1e-3), "HighSpeedRotor": (0.25, 1e-5), "SliderCrank": (5.0, 1e-3)}
SAMPLES = 500
LABELS = {
    "HeavyTop": [*(f"{c} [m]" for c in "xyz"), *(f"v{c} [m/s]" for c in "xyz")],
    "HighSpeedRotor": [*(f"p1{c} [m]" for c in "xyz"), *(f"ω{c} [rad/s]" for c in "xyz")],
    "SliderCrank": ["s [m]", "θ [rad]"],
}
"""What is shown, as in the paper."""


def history(mechanism: str, stop_time: float, h: float) -> dict[str, Any]:
    """Time, the columns of `LABELS` from our run and from the independent solution."""
    run = runs.simulation(mechanism, h, **cases.settings(mechanism, INDEX3, sigma=1.0))
    times = np.linspace(0.0, stop_time, SAMPLES + 1)
    stride = round(stop_time / h / SAMPLES)
    states = []
    for i, t in enumerate(times):
        run.run(t, stride if i else 0)
        states.append(np.concatenate([run.state.q[:7], run.state.v[:6], run.state.q[-7:-4], run.state.turned]))
    return {
        "time": times,
        "ours": _from_states(mechanism, np.array(states)),
        "exact": _from_history(mechanism, solve(mechanism, times)),
    }


def _from_states(mechanism: str, states: np.ndarray) -> np.ndarray:
    """Rows: q and v of the first body, position of the last, coordinates of the joints."""
    q, v, last, turned = states[:, :7], states[:, 7:13], states[:, 13:16], states[:, 16:]
    if mechanism == "HeavyTop":
        return np.hstack([q[:, :3], v[:, :3]])
    if mechanism == "HighSpeedRotor":
        return np.hstack([q[:, :3] + runs.rotations(q[:, 3:]).apply(LEFT_BEARING), v[:, 3:]])
    return np.column_stack([last[:, 0], turned[:, 0]])


LEFT_BEARING = np.array([-0.11, 0.0, 0.0])  # m in B: p1 of the paper


def _from_history(mechanism: str, exact: History) -> np.ndarray:
    names = {
        "HeavyTop": ("top.position", "top.velocity"),
        "HighSpeedRotor": ("leftSupport.position", "rotor.angularVelocity"),
    }
    if mechanism == "SliderCrank":
        return np.column_stack([exact["guide.displacement"], exact["crankPivot.angle"]])
    return np.hstack([runs.columns(exact, name) for name in names[mechanism]])


class Histories:
    """Figs. 2, 6, 9."""

    name = "histories"
    title = "Time histories"
    mechanisms = tuple(CASES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One run."""
        return [Cell("index 3", history, (mechanism, *(QUICK if quick else STOP_TIMES)[mechanism]))]

    def report(self, results: Results, folder: Path) -> str:
        """A figure for each mechanism, and the distance at the end."""
        rows, images = [], []
        for mechanism, cells in results.items():
            found = {name: np.array(values) for name, values in cells["index 3"].items()}
            labels = LABELS[mechanism]
            columns = np.column_stack([found["time"], found["ours"], found["exact"]])
            header = ["time", *labels, *(f"exact {label}" for label in labels)]
            lines = (dict(zip(header, map(float, line), strict=True)) for line in columns)
            write_csv(folder / f"histories_{mechanism}.csv", lines, header)
            image = f"histories_{mechanism}.png"
            with figure(folder / image, (9, 3.3)) as result:
                DRAW[mechanism](result.subplots(1, 2), found)
            images.append(f"![{mechanism}: motion over time]({image})\n")
            distance = np.abs(found["ours"] - found["exact"])[-1]
            paper = PAPER.get(mechanism, "")
            deviation = ", ".join(f"{label}: {d:.1e}" for label, d in zip(labels, distance, strict=True))
            rows.append([mechanism, FIGURES[mechanism], f"{found['time'][-1]:g} s", deviation, paper])
        text = (
            "Lines: index 3, residual form, σ = 1, the paper's ρ∞; dots: the independent solution. The paper compares "
            "with RecurDyn and with a solution from the IFToMM library; the distance to the latter is the largest by "
            "far, and not ours.\n"
        )
        header = ["mechanism", "paper", "end", "distance at the end", "distance in the paper"]
        return "\n".join([text, *images, markdown_table(header, rows)])


PAPER = {
    "HeavyTop": "1e-5 m, 1e-5 m/s at 1 s (to RecurDyn)",
    "SliderCrank": "s: 8.6e-3 m at 5 s (to the IFToMM library)",
}


def _draw_columns(axes: Axes, found: Mapping[str, np.ndarray], first: int, names: str, ylabel: str) -> None:
    for i, name in enumerate(names, start=first):
        (line,) = axes.plot(found["time"], found["ours"][:, i], label=name, linewidth=1)
        axes.plot(found["time"][::20], found["exact"][::20, i], "o", color=line.get_color(), markersize=2.5)
    axes.set(xlabel="t in s", ylabel=ylabel)
    if len(names) > 1:
        axes.legend(ncols=len(names), loc="lower left", bbox_to_anchor=(0, 1))


def _draw_heavy_top(axes: Any, found: Mapping[str, np.ndarray]) -> None:
    _draw_columns(axes[0], found, 0, "xyz", "centre of mass in m")
    _draw_columns(axes[1], found, 3, "xyz", "its velocity in m/s")


def _draw_rotor(axes: Any, found: Mapping[str, np.ndarray]) -> None:
    scaled = {"time": found["time"], "ours": 1e3 * found["ours"], "exact": 1e3 * found["exact"]}
    axes[0].plot(scaled["ours"][:, 1], scaled["ours"][:, 2], linewidth=1)
    axes[0].plot(scaled["exact"][::20, 1], scaled["exact"][::20, 2], "o", markersize=2.5)
    axes[0].set(xlabel="y of the left bearing in mm", ylabel="z in mm", aspect="equal")
    _draw_columns(axes[1], scaled, 1, "yz", "left bearing in mm")


def _draw_slider_crank(axes: Any, found: Mapping[str, np.ndarray]) -> None:
    _draw_columns(axes[0], found, 0, "s", "slider position in m")
    _draw_columns(axes[1], found, 1, "θ", "crank angle in rad")


DRAW = {"HeavyTop": _draw_heavy_top, "HighSpeedRotor": _draw_rotor, "SliderCrank": _draw_slider_crank}

CHAPTER = Histories()
