"""Chapter: the bent centre lines of the pendulum's beam and of the connecting rod, from node positions."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from mpl_toolkits.mplot3d import Axes3D

from research.reference import CRANK_CENTRE
from research.study.chapter import Cell, Results
from research.study.flexible_runs import CASES, centre_line, states
from research.study.output import figure, write_csv
from research.study.runs import rotations
from sigmafmu import _core
from sigmafmu.markdown import markdown_table


@dataclass(frozen=True)
class Scene:
    """What is drawn of one mechanism."""

    title: str
    times: tuple[float, ...]  # s
    step: float  # s
    magnified: float
    """How many times the deformation is drawn."""
    view: tuple[float, float]
    """Elevation and azimuth, degrees."""


def _instants(count: int, distance: float) -> tuple[float, ...]:
    return tuple(round(i * distance, 9) for i in range(count))


SCENES = {
    "FlexiblePendulum": Scene("Beam of the pendulum", _instants(8, 0.06), 2e-4, 5.0, (28.0, -70.0)),
    "FlexibleSliderCrank": Scene("Rod of the slider-crank", _instants(8, 0.1), 2e-4, 50.0, (14.0, -60.0)),
}
LENGTHS = {"FlexiblePendulum": 1.0, "FlexibleSliderCrank": 0.3}  # m
HEADER = ("mechanism", "time", "section", *(f"{line}.{axis}" for line in ("bent", "straight") for axis in "xyz"))


def centre_lines(mechanism: str) -> dict[str, Any]:
    """A cell: the centre line and the frame's x axis below it in W at the times of the scene; deflection in B; m."""
    scene, index = SCENES[mechanism], CASES[mechanism].index
    q, _, _ = states(mechanism, scene.step, np.array(scene.times))
    nodes = np.array(_core.mechanism(mechanism).multibody.body(index).modal.nodes)
    axis = nodes.reshape(-1, 4, 3).mean(axis=1)
    frames = q[:, 7 * index : 7 * index + 7]
    turns = [rotations(frame[None, 3:])[0] for frame in frames]
    straight = np.array([frame[:3] + turn.apply(axis) for frame, turn in zip(frames, turns, strict=True)])
    bent = np.array([centre_line(mechanism, row) for row in q])
    deflection = [turn.inv().apply(u) for turn, u in zip(turns, bent - straight, strict=True)]
    return {"time": scene.times, "x": axis[:, 0], "bent": bent, "straight": straight, "deflection": deflection}


def draw(path: Path, found: Mapping[str, Mapping[str, Any]]) -> None:
    """The scenes, and below the deflections as they are; colour: time."""
    with figure(path, (5.2 * max(len(found), 1), 6.8)) as result:
        grid = result.add_gridspec(2, len(found), height_ratios=(2.2, 1))
        for column, (mechanism, lines) in enumerate(found.items()):
            scene = SCENES[mechanism]
            axes = result.add_subplot(grid[0, column], projection="3d")
            below = result.add_subplot(grid[1, column])
            colors = colormaps["viridis"](np.linspace(0.0, 0.92, len(scene.times)))
            for i, (time, color) in enumerate(zip(scene.times, colors, strict=True)):
                _draw_line(axes, mechanism, np.array(lines["bent"][i]), np.array(lines["straight"][i]), color)
                y, z = 1e3 * np.array(lines["deflection"][i])[:, 1:].T
                below.plot(lines["x"], y, color=color, label=f"{time:g} s")
                below.plot(lines["x"], z, "--", color=color)
            axes.set(xlabel="x in m", ylabel="y in m", zlabel="z in m")
            axes.set_title(f"{scene.title}, bending drawn {scene.magnified:g} times")
            limits = (axes.get_xlim3d(), axes.get_ylim3d(), axes.get_zlim3d())
            axes.set_box_aspect(np.ptp(limits, axis=1), zoom=1.3)  # one scale along all axes
            axes.view_init(*scene.view)
            axes.locator_params(nbins=4)
            axes.locator_params(axis="y", nbins=3)
            below.set(xlabel="x in the floating frame in m", ylabel="deflection in mm")
            below.set_title("solid: in y, dashed: in z", fontsize=8, fontweight="normal")
            below.legend(fontsize=7, ncols=2, loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.2)


def _draw_line(axes: Axes3D, mechanism: str, bent: np.ndarray, straight: np.ndarray, color: Any) -> None:
    """The bent line, the straight one dashed; the crank and the slider of the slider-crank."""
    line = straight + SCENES[mechanism].magnified * (bent - straight)
    axes.plot(*straight.T, "--", color="0.7", linewidth=0.8)
    axes.plot(*line.T, color=color, linewidth=1.8)
    if mechanism == "FlexibleSliderCrank":
        axes.plot(*np.array([CRANK_CENTRE, straight[0]]).T, color="0.5", linewidth=1.2)
        axes.plot(*straight[-1:].T, "s", color=color, markersize=4)
    axes.plot(*straight[:1].T, "o", color="0.3", markersize=3)


class FlexibleBending:
    """Two pictures."""

    name = "flexible_bending"
    title = "Flexible bodies: the bending"
    mechanisms = tuple(SCENES)

    def cells(self, mechanism: str, quick: bool) -> list[Cell]:
        """One for each mechanism."""
        return [Cell("centre lines", centre_lines, (mechanism,))]

    def report(self, results: Results, folder: Path) -> str:
        """The figure and a table of the largest deflections."""
        found = {mechanism: cells["centre lines"] for mechanism, cells in results.items()}
        write_csv(folder / f"{self.name}.csv", _rows(found), HEADER)
        draw(folder / f"{self.name}.png", found)
        rows = []
        for mechanism, lines in found.items():
            bending = np.linalg.norm(np.array(lines["bent"]) - np.array(lines["straight"]), axis=2).max()
            magnified = SCENES[mechanism].magnified
            rows.append(
                [mechanism, f"{1e3 * bending:.3g}", f"{100 * bending / LENGTHS[mechanism]:.2g} %", f"{magnified:g}"]
            )
        return (
            "Middles of the sections, from the positions of four nodes each, at equidistant times; dashed: the x axis "
            "of the floating frame. The bending is magnified, positions are not.\n\n"
            f"![Bent beam and rod]({self.name}.png)\n\n"
            + markdown_table(["mechanism", "largest deflection, mm", "of the length", "drawn, times"], rows)
        )


def _rows(found: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    rows = []
    for mechanism, lines in found.items():
        for time, bent, straight in zip(lines["time"], lines["bent"], lines["straight"], strict=True):
            for section, values in enumerate(zip(bent, straight, strict=True)):
                places = dict(zip(HEADER[3:], np.concatenate(values), strict=True))
                rows.append({"mechanism": mechanism, "time": time, "section": section, **places})
    return rows


CHAPTER = FlexibleBending()
