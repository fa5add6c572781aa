"""Figures of simulation results: one designed for each mechanism, and a general one for every other model."""

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from sigmafmu import SigmafmuError
from sigmafmu.compare import Reference, distance
from sigmafmu.result import NotRecordedError, Result
from sigmafmu.variables import split_element

COLORS = ("#1f5fa8", "#d1495b", "#2a9d6f", "#e39c1c", "#7b4fa3", "#4d4d4d", "#17a2b8", "#9c6b30")
STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.prop_cycle": mpl.cycler(color=COLORS),
    "grid.alpha": 0.3,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "figure.dpi": 130,
}
XYZ = ("x", "y", "z")
MAX_PANELS = 12
RESIDUAL_FLOOR = 1e-18
"""Residuals below this are drawn here: exact zeros have no place on a logarithmic axis."""


def plot(result: Result, path: Path | str, reference: Reference | None = None) -> None:
    """Draw the figure of `result.model`, or the general one if a variable that it needs was not recorded."""
    with mpl.rc_context(STYLE):
        try:
            figure = FIGURES.get(result.model, general)(result, reference)
        except NotRecordedError:
            figure = general(result)
        FigureCanvasAgg(figure)
        save(figure, path)


def save(figure: Figure, path: Path | str) -> None:
    """Write the figure; SigmafmuError if the file cannot be written or matplotlib does not know its type."""
    try:
        figure.savefig(path)
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error
    except ValueError as error:
        raise SigmafmuError(f"cannot write {path}: {error}") from error


def heavy_top(result: Result, reference: Reference | None) -> Figure:
    """Path of the centre of mass in space, its coordinates, energy error and error against the reference."""
    position = result["top.position"]
    figure = _figure("Heavy top", result, (12, 7))
    grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1))
    _trajectory(figure, figure.add_subplot(grid[:, 0], projection="3d"), result.time, position)

    axes = figure.add_subplot(grid[0, 1])
    for label, coordinate in zip(XYZ, position.T, strict=True):
        axes.plot(result.time, coordinate, label=label)
    _finish(axes, "Position of the centre of mass", "m", legend=3)
    _energy_error(figure.add_subplot(grid[1, 1]), result)
    _accuracy(figure.add_subplot(grid[2, 1]), result, reference, "top.position")
    return figure


def slider_crank(result: Result, reference: Reference | None) -> Figure:
    """Motion, joint reactions, energies and errors of the slider-crank."""
    figure = _figure("Slider-crank", result, (12, 8))
    axes = figure.subplots(3, 2)
    t = result.time

    axes[0, 0].plot(t, 1e3 * result["guide.displacement"])
    _finish(axes[0, 0], "Slider displacement", "mm")
    axes[0, 1].plot(t, result["crankPivot.angle"] / (2 * np.pi), color=COLORS[1])
    _finish(axes[0, 1], "Crank angle", "turns")

    for joint in _owners(result, "reactionForce"):
        axes[1, 0].plot(t, np.linalg.norm(result[f"{joint}.reactionForce"], axis=1), label=joint, linewidth=1)
    _finish(axes[1, 0], "Joint reaction forces", "N", legend=4)
    for kind in ("kinetic", "potential", "total"):
        axes[1, 1].plot(t, result[f"energy.{kind}"], label=kind)
    _finish(axes[1, 1], "Energy", "J", legend=3)

    _energy_error(axes[2, 0], result)
    _accuracy(axes[2, 1], result, reference, "slider.position")
    return figure


def high_speed_rotor(result: Result, reference: Reference | None) -> Figure:
    """Orbits of both support points seen along the axis, their excursion over time and the velocity or error."""
    supports = ("leftSupport", "rightSupport")
    offsets = [result[f"{support}.position"][:, 1:] for support in supports]
    scale, unit = _length_scale(max(np.abs(offset).max() for offset in offsets))
    figure = _figure("High-speed rotor", result, (12, 9))
    grid = figure.add_gridspec(2, 2, height_ratios=(1.8, 1))
    over_time = figure.add_subplot(grid[1, 0])
    for i, (support, offset) in enumerate(zip(supports, offsets, strict=True)):
        y, z = scale * offset.T
        orbit = figure.add_subplot(grid[0, i])
        orbit.plot(y, z, color=COLORS[i], linewidth=0.8)
        orbit.plot(y[-1], z[-1], "o", color=COLORS[i], markersize=5, label=f"at {result.time[-1]:g} s")
        orbit.set_aspect("equal", adjustable="datalim")
        orbit.set_xlabel(f"y in {unit}")
        _finish(orbit, f"Orbit of {support}", f"z in {unit}", legend=1, over_time=False)
        side = support.removesuffix("Support")
        over_time.plot(result.time, y, "-", color=COLORS[i], label=f"{side} y")
        over_time.plot(result.time, z, "--", color=COLORS[i], label=f"{side} z")
    _finish(over_time, "Support points", unit, legend=4)
    lower_right = figure.add_subplot(grid[1, 1])
    if reference:
        _accuracy(lower_right, result, reference, "leftSupport.position")
        return figure
    for i, velocity in enumerate(scale * result["rotor.velocity"].T[1:], start=1):
        lower_right.plot(result.time, velocity, label=XYZ[i], color=COLORS[i + 1])
    _finish(lower_right, "Velocity of the centre of mass", f"{unit}/s", legend=2)
    return figure


def general(result: Result, _reference: Reference | None = None) -> Figure:
    """One panel for each unit; a vector has one colour and its elements different line styles."""
    panels = _panels(result)
    columns = 1 if len(panels) == 1 else 2
    rows = -(-len(panels) // columns)
    figure = _figure(result.model, result, (12, max(4.0, 2.6 * rows)))
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, (unit, vectors) in zip(axes, panels, strict=False):
        if len(vectors) == 1:  # a colour for each element instead
            vectors = [(name, [name]) for name in vectors[0][1]]
        for i, (base, names) in enumerate(vectors):
            for k, name in enumerate(names):
                label = None if k else base if len(names) == 1 else f"{base}[1..{len(names)}]"
                style = ("-", "--", ":", "-.")[k % 4]
                panel.plot(result.time, result[name], style, color=COLORS[i % len(COLORS)], label=label, linewidth=1)
        _finish(panel, "", "" if unit == "1" else unit)
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7)
    for unused in axes[len(panels) :]:
        unused.remove()
    return figure


FIGURES: dict[str, Callable[[Result, Reference | None], Figure]] = {
    "HeavyTop": heavy_top,
    "SliderCrank": slider_crank,
    "HighSpeedRotor": high_speed_rotor,
}


def _figure(title: str, result: Result, size: tuple[float, float]) -> Figure:
    figure = Figure(figsize=size, layout="constrained")
    s = result.statistics
    details = f"{result.time[-1]:g} s"
    if s.steps:
        details += f", {s.steps} internal steps of {s.simulated_time / s.steps:.3g} s"
    figure.suptitle(f"{title}: {details}", x=0.01, ha="left", fontsize=12)
    return figure


def _finish(axes: Axes, title: str, unit: str, *, legend: int = 0, over_time: bool = True) -> None:
    """Title, labels and, with `legend` columns, a legend above the panel where no curve runs."""
    axes.set_title(title)
    axes.set_ylabel(unit)
    if over_time:
        axes.set_xlabel("time in s")
        axes.margins(x=0)
        axes.set_xlim(left=0)
    if legend:
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=legend, borderpad=0.2, handlelength=1.5, columnspacing=1
        )


def _trajectory(figure: Figure, axes: Axes, time: np.ndarray, position: np.ndarray) -> None:
    segments = np.stack((position[:-1], position[1:]), axis=1)
    lines = Line3DCollection(segments, cmap="viridis", linewidth=1.8)
    lines.set_array(time[1:])
    lines.set_clim(0, time[-1])
    axes.add_collection3d(lines)
    axes.plot(*np.column_stack((np.zeros(3), position[0])), color="#999999", linewidth=1)
    axes.scatter(0, 0, 0, color="black", s=25, depthshade=False)
    axes.text(0, 0, 0.06, "pivot")
    axes.scatter(*position[0], color=COLORS[1], s=25, depthshade=False)
    axes.text(*(position[0] + (0, 0, 0.08)), "start")

    radius = np.linalg.norm(position[0])
    u, v = np.mgrid[0 : 2 * np.pi : 25j, 0 : np.pi : 13j]
    sphere = radius * np.array((np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)))
    axes.plot_wireframe(*sphere, color="#999999", linewidth=0.3, alpha=0.5)

    ticks = np.round(radius * np.array((-1, -0.5, 0, 0.5, 1)), 2)
    axes.set(xlabel="x in m", ylabel="y in m", zlabel="z in m", xticks=ticks, yticks=ticks, zticks=ticks)
    axes.set_title("Path of the centre of mass")
    axes.set_box_aspect((1, 1, 1), zoom=0.98)
    axes.view_init(elev=22, azim=-50)
    figure.colorbar(lines, ax=axes, orientation="horizontal", shrink=0.5, pad=0.0, aspect=40, label="time in s")


def _energy_error(axes: Axes, result: Result) -> None:
    total = result["energy.total"]
    error = (total - total[0]) / (np.abs(result["energy.kinetic"]).max() or 1.0)
    largest = np.abs(error).max()
    exponent = int(np.floor(np.log10(largest))) if largest > 0 else 0
    axes.plot(result.time, error / 10.0**exponent, color=COLORS[4])
    _finish(axes, "Energy error, relative to the largest kinetic energy", f"$10^{{{exponent}}}$")


def _accuracy(axes: Axes, result: Result, reference: Reference | None, name: str) -> None:
    """Distance from the reference if there is one, else the constraint residuals; logarithmic."""
    if reference:
        time, error = distance(result, reference.history, name)
        drawn = error > 1e-6 * error.max()  # not the start, where both are the same but for rounding
        axes.semilogy(time, np.where(drawn, error, np.nan), color=COLORS[1])
        stated = float(reference.stated_position_error.split()[0])
        axes.axhline(stated, color=COLORS[5], linestyle="--", linewidth=1, label="error of the reference")
        _finish(axes, f"Error of {name}", "m", legend=1)
        return
    for i, kind in enumerate(("position", "velocity")):
        residual = result[f"constraint.{kind}Residual"]
        axes.semilogy(result.time, np.maximum(residual, RESIDUAL_FLOOR), label=kind, color=COLORS[i], linewidth=0.9)
    _finish(axes, "Constraint residuals", "SI", legend=2)


def _owners(result: Result, quantity: str) -> list[str]:
    """Names before the dot of the recorded vectors `….quantity`."""
    bases = dict.fromkeys(element[0] for name in result.names if (element := split_element(name)))
    return [base.removesuffix(f".{quantity}") for base in bases if base.endswith(f".{quantity}")]


def _length_scale(largest: float) -> tuple[float, str]:
    """Factor and unit that make lengths up to `largest` metres readable."""
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm")):
        if largest * factor >= 1:
            return factor, unit
    return 1e9, "nm"


def _panels(result: Result) -> list[tuple[str, list[tuple[str, list[str]]]]]:
    """Recorded names as vectors by unit, at most as many vectors in a panel as there are colours."""
    by_unit: dict[str, dict[str, list[str]]] = {}
    for name in result.names:
        element = split_element(name)
        vectors = by_unit.setdefault(result.units.get(name, ""), {})
        vectors.setdefault(element[0] if element else name, []).append(name)
    panels = []
    for unit, vectors in by_unit.items():
        items = list(vectors.items())
        panels += [(unit, items[i : i + len(COLORS)]) for i in range(0, len(items), len(COLORS))]
    return panels[:MAX_PANELS]
