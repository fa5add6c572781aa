"""Chapter: what a floating frame with linear modes can and cannot do: SpinUpBeam beside a chain of rigid segments.

Linear modes have no geometric stiffening. A beam that turns at Ω has the stiffness K − Ω² M in the plane of rotation,
where a real one has K + Ω² (G − M) with G from the centrifugal stretching. The chain has it without being told, and no
modes: rigid segments with rotational springs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import eigh

from research.reference import rotating_beam
from research.reference.clouds import SpinUp, cantilever_root
from research.reference.segments import spin_up_deflection
from research.study.chapter import Cell, Results
from research.study.flexible_runs import CASES, point, states
from research.study.output import figure, write_csv
from research.study.runs import rotations
from sigmafmu import _core
from sigmafmu.markdown import markdown_table
from sigmafmu.plots import COLORS

NAME = "SpinUpBeam"
SPEEDS, QUICK_SPEEDS = (0.5, 1.0, 2.0, 2.5, 6.0), (0.5, 6.0)
"""Ω_s, rad/s."""
SEGMENTS = (4, 8)
"""Of two chains, for Richardson's extrapolation: their error falls with 1/segments²."""
STOP_TIME, SAMPLE_STEP, STEP = 20.0, 0.1, 1e-2  # s
RISE = (6.0, 9.0)
"""Half way of the rise, s: means over it leave out most of the swinging."""
TURNING = np.linspace(0.0, 6.0, 61)  # rad/s
FREQUENCIES = {
    "modes": "linear modes, K − Ω² M",
    "stiffened": "with geometric stiffening",
}


def modes_deflection(final_speed: float) -> dict[str, Any]:
    """Tip across the frame's x axis with our floating frame, m; it ends where the run fails."""
    times = _times()
    spin_up, index = replace(SpinUp(), final_speed=final_speed), CASES[NAME].index
    try:
        q, _, _ = states(NAME, STEP, times, spin_up)
    except RuntimeError as error:
        return {"failed": str(error)}
    frame = q[:, 7 * index : 7 * index + 7]
    arm = rotations(frame[:, 3:]).inv().apply(point(NAME, q) - frame[:, :3])
    return {"time": times, "deflection": arm[:, 1]}


def chain_deflection(final_speed: float, segments: Sequence[int]) -> dict[str, Any]:
    """The same of a chain, extrapolated from two."""
    times, spin_up = _times(), replace(SpinUp(), final_speed=final_speed)
    coarse, fine = (spin_up_deflection(spin_up, n, times) for n in segments)
    ratio = (segments[1] / segments[0]) ** 2
    return {"time": times, "deflection": (ratio * fine - coarse) / (ratio - 1.0)}


def turning_frequencies() -> dict[str, Any]:
    """Squares of the first eigenfrequency in the plane over Ω, (rad/s)²: of our modal data, and of the beam, exact."""
    spin_up = SpinUp()
    modal = _core.mechanism(NAME).multibody.body(CASES[NAME].index).modal
    stiffness, mass = np.array(modal.stiffness), spin_up.cloud.modal_mass
    scale = np.sqrt(spin_up.bending / (spin_up.mass * spin_up.length**3))
    return {
        "modes": [eigh(stiffness - speed**2 * mass, mass, eigvals_only=True)[0] for speed in TURNING],
        "stiffened": [rotating_beam.frequencies(s / scale, in_plane=True)[0] * scale**2 for s in TURNING],
    }


def excess(final_speed: float) -> float:
    """y_modes / y_chain − 1 half way of the rise, by formula: (ω_1² + (c − 1) Ω²) / (ω_1² − Ω²) − 1."""
    spin_up = replace(SpinUp(), final_speed=final_speed)
    first = cantilever_root(1) ** 4 * spin_up.bending / (spin_up.mass * spin_up.length**3)
    square = float(spin_up.speed(np.array(np.mean(RISE)))) ** 2
    return (first + (rotating_beam.southwell(0) - 1.0) * square) / (first - square) - 1.0


def measured_excess(modes: Mapping[str, Any], chain: Mapping[str, Any]) -> float:
    """The same, from two histories."""
    times = np.array(modes["time"])
    half_way = (times >= RISE[0]) & (times <= RISE[1])
    return np.array(modes["deflection"])[half_way].mean() / np.array(chain["deflection"])[half_way].mean() - 1.0


def _times() -> np.ndarray:
    return np.linspace(0.0, STOP_TIME, round(STOP_TIME / SAMPLE_STEP) + 1)


class FlexibleLimits:
    """Deflection and eigenfrequencies of a turning beam."""

    name = "flexible_limits"
    title = "Flexible bodies: what linear modes can and cannot do"
    mechanisms = (NAME,)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """Two for each final speed: the floating frame and the chain."""
        speeds = QUICK_SPEEDS if quick else SPEEDS
        result = [Cell(f"modes/{speed:g}", modes_deflection, (speed,)) for speed in speeds]
        chained = speeds[:1] if quick else speeds
        result += [Cell(f"chain/{speed:g}", chain_deflection, (speed, SEGMENTS)) for speed in chained]
        return [*result, Cell("frequencies", turning_frequencies, ())]

    def report(self, results: Results, folder: Path) -> str:
        """A figure, a table and two CSV files."""
        cells = results[NAME]
        frequencies = cells["frequencies"]
        limit = float(np.sqrt(frequencies["modes"][0]))
        write_csv(folder / f"{self.name}_frequencies.csv", _frequency_rows(frequencies), ("speed", *FREQUENCIES))
        write_csv(folder / f"{self.name}_deflection.csv", _rows(cells), ("speed", "model", "time", "deflection"))
        _draw(folder / f"{self.name}.png", cells, limit)
        return (
            f"{__doc__.split(chr(10) * 2, 1)[1].strip()}\n\nSpinUpBeam is spun up within 15 s. Its first "
            f"eigenfrequency at rest is {limit:.2f} rad/s: below it linear modes bend too far, above it they diverge."
            "\n\n"
            f"![Deflection and eigenfrequency]({self.name}.png)\n\nLast panel: from the modal data, and (grey) exact "
            "for a beam with stiffening.\n\nHow much further than the chain the tip bends half "
            f"way of the rise (means from {RISE[0]:g} to {RISE[1]:g} s), and by formula, Ω = Ω_s/2, c = "
            f"{rotating_beam.southwell(0):.3f}: (ω₁² + (c − 1) Ω²) / (ω₁² − Ω²) − 1.\n\n{_table(cells, limit)}"
        )


def _speeds(cells: Mapping[str, Any]) -> list[float]:
    return [float(key.split("/")[1]) for key in cells if key.startswith("modes/")]


def _rows(cells: Mapping[str, Any]) -> list[dict[str, Any]]:
    rows = []
    for key, cell in cells.items():
        if "deflection" in cell:
            model, speed = key.split("/")
            own = {"speed": float(speed), "model": model}
            pairs = zip(cell["time"], cell["deflection"], strict=True)
            rows += [{**own, "time": t, "deflection": y} for t, y in pairs]
    return rows


def _frequency_rows(frequencies: Mapping[str, Any]) -> list[dict[str, float]]:
    """Squares, because they become negative."""
    return [{"speed": speed, **{name: frequencies[name][i] for name in FREQUENCIES}} for i, speed in enumerate(TURNING)]


def _table(cells: Mapping[str, Any], limit: float) -> str:
    rows = []
    for speed in _speeds(cells):
        modes, chain = cells[f"modes/{speed:g}"], cells.get(f"chain/{speed:g}")
        bent = f"{np.abs(chain['deflection']).max():.3g}" if chain else "–"
        if speed > limit:
            rows.append([f"{speed:g}", "diverges", bent, "–", "–"])
        else:
            compared = [f"{100 * value:.1f} %" for value in (measured_excess(modes, chain), excess(speed))]
            rows.append([f"{speed:g}", f"{np.abs(modes['deflection']).max():.3g}", bent, *compared])
    header = ["Ω_s, rad/s", "modes: largest, m", "chain: largest, m", "half way: modes bend further by", "formula"]
    return markdown_table(header, rows)


def _draw(path: Path, cells: Mapping[str, Any], limit: float) -> None:
    """Deflection over time for up to three speeds, and the eigenfrequency over Ω."""
    speeds = [s for s in _speeds(cells) if s in (SPEEDS[0], SPEEDS[2], SPEEDS[-1])]
    with figure(path, (3.2 * (len(speeds) + 1), 3.6)) as result:
        row = result.subplots(1, len(speeds) + 1)
        for axes, speed in zip(row, speeds, strict=False):
            modes, chain = cells[f"modes/{speed:g}"], cells.get(f"chain/{speed:g}")
            if chain:
                axes.plot(chain["time"], chain["deflection"], color="0.5", linewidth=3, label="chain of rigid segments")
            if "failed" not in modes:
                axes.plot(modes["time"], modes["deflection"], color=COLORS[0], label="floating frame, linear modes")
            axes.set(title=f"Ω_s = {speed:g} rad/s", xlabel="time in s")
            if speed > limit:
                shown = np.abs(chain["deflection"]).max() if chain else 1.0
                axes.set_ylim(-3 * shown, 0.5 * shown)
        row[0].set_ylabel("tip deflection in m")
        axes, frequencies = row[-1], cells["frequencies"]
        for name, color, width in (("stiffened", "0.5", 3), ("modes", COLORS[0], 1.2)):
            squares = np.array(frequencies[name])
            axes.plot(TURNING, np.sqrt(np.where(squares >= 0, squares, np.nan)), color=color, linewidth=width)
        axes.axvspan(limit, TURNING[-1], color=COLORS[1], alpha=0.12, linewidth=0)
        axes.text(0.5 * (limit + TURNING[-1]), 0.4, "linear modes\ndiverge", color=COLORS[1], ha="center")
        axes.set(title="first eigenfrequency", xlabel="Ω in rad/s", ylabel="rad/s, in the plane", ylim=(0, None))
        result.legend(*row[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)


CHAPTER = FlexibleLimits()
