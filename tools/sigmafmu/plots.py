"""Figures of simulation results: those designed for a mechanism, and an overview of every other model.

None has more than `MAX_PANELS` panels.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from sigmafmu import SigmafmuError
from sigmafmu.compare import Reference, distance
from sigmafmu.result import NotRecordedError, Result
from sigmafmu.variables import vectors

COLORS = ("#1f5fa8", "#d1495b", "#2a9d6f", "#e39c1c", "#7b4fa3", "#4d4d4d", "#17a2b8", "#9c6b30")
STYLE: Any = {
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
MAX_PANELS = 6
MAX_CURVES = 6
"""In a panel of an overview."""
FLAT = 1e-3
"""Of the largest extent of a motion: what moves less along an axis, does not move along it."""
RESIDUAL_FLOOR = 1e-18
"""Residuals below this are drawn here: exact zeros have no place on a logarithmic axis."""


def figure(result: Result, reference: Reference | None = None, *, named: bool = False) -> Figure:
    """What matters of `result`; with `named` all that was recorded, since a user asked for just that."""
    with mpl.rc_context(STYLE):
        try:
            drawn = (by_unit if named else FIGURES.get(result.model, overview))(result, reference)
        except NotRecordedError:
            drawn = by_unit(result)
    FigureCanvasAgg(drawn)
    return drawn


def phase_portraits(result: Result) -> Figure:
    """The rate of each coordinate over the coordinate, for those that were recorded with their rates."""
    pairs = _moving_pairs(result, JOINT_RATES) or _moving_pairs(result, {"velocity": ("position",)})
    if not pairs:
        raise SigmafmuError(f"the run of {result.model} has recorded no coordinate that moves together with its rate")
    shown = pairs[:MAX_PANELS]
    columns = min(len(shown), 3)
    rows = -(-len(shown) // columns)
    with mpl.rc_context(STYLE):
        left_out = f" (without {len(pairs) - len(shown)} of the coordinates)" if len(pairs) > len(shown) else ""
        drawn = _figure(result.model + left_out, result, (4.0 * columns + 0.5, 3.4 * rows + 0.5))
        for axes, (coordinate, rate) in zip(drawn.subplots(rows, columns, squeeze=False).flat, shown, strict=False):
            x, y = result[coordinate], result[rate]
            axes.plot(x, y, linewidth=1)
            axes.plot(x[0], y[0], "o", color=COLORS[2], markersize=4, label="start")
            axes.plot(x[-1], y[-1], "s", color=COLORS[1], markersize=4, label="end")
            axes.set_xlabel(f"{coordinate} in {result.units.get(coordinate, '')}")
            _finish(axes, "", f"{rate} in {result.units.get(rate, '')}", legend=2, over_time=False)
        for unused in drawn.axes[len(shown) :]:
            unused.remove()
    FigureCanvasAgg(drawn)
    return drawn


JOINT_RATES = {"angularRate": ("angle",), "rate": ("displacement", "length"), "modalRate": ("modal",)}
"""End of the name of a rate → ends of the names of its coordinate, by importance."""


def _moving_pairs(result: Result, rates: Mapping[str, Iterable[str]]) -> list[tuple[str, str]]:
    """Coordinates and their rates, without coordinates that hardly move beside others of the same unit."""
    recorded = vectors(result.names)
    pairs = [
        pair
        for rate, coordinates in rates.items()
        for base in recorded
        if (match := re.fullmatch(rf"(.+)\.{rate}(\d*)", base))
        for coordinate in coordinates
        for pair in zip(recorded.get(f"{match[1]}.{coordinate}{match[2]}", ()), recorded[base], strict=False)
    ]
    largest: dict[str, float] = {}
    for coordinate, _ in pairs:
        unit = result.units.get(coordinate, "")
        largest[unit] = max(largest.get(unit, 0.0), np.ptp(result[coordinate]))
    return [p for p in pairs if np.ptp(result[p[0]]) > FLAT * largest[result.units.get(p[0], "")]]


def save(drawn: Figure, path: Path | str) -> None:
    """Write the figure; SigmafmuError if the file cannot be written or matplotlib does not know its type."""
    try:
        with mpl.rc_context(STYLE):  # the resolution
            drawn.savefig(path)
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
    """Paths in space, motion, joint reactions, energies and errors of the slider-crank."""
    figure = _figure("Slider-crank", result, (12, 7.5))
    grid = figure.add_gridspec(2, 3)
    _paths(figure, grid[0, 0], {body: result[f"{body}.position"] for body in ("crank", "rod", "slider")})
    _displacement(figure.add_subplot(grid[0, 1]), result)
    _angle(figure.add_subplot(grid[0, 2]), result)
    _forces(figure.add_subplot(grid[1, 0]), result)
    _energy(figure.add_subplot(grid[1, 1]), result)
    _accuracy(figure.add_subplot(grid[1, 2]), result, reference, "slider.position")
    return figure


def high_speed_rotor(result: Result, _reference: Reference | None = None) -> Figure:
    """Orbits of both support points seen along the axis, their excursion over time and the velocity."""
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
    for i, velocity in enumerate(scale * result["rotor.velocity"].T[1:], start=1):
        lower_right.plot(result.time, velocity, label=XYZ[i], color=COLORS[i + 1])
    _finish(lower_right, "Velocity of the centre of mass", f"{unit}/s", legend=2)
    return figure


def overview(result: Result, _reference: Reference | None = None) -> Figure:
    """The first panels of `OVERVIEW` that the model has something for."""
    paths = _moving(result)
    panels = [draw for suffix, draw in OVERVIEW if _owners(result, suffix)][: MAX_PANELS - bool(paths)]
    figure = _figure(result.model, result, (12, 7.5))
    grid = figure.add_gridspec(2, 3)
    cells = [grid[i // 3, i % 3] for i in range(MAX_PANELS)]
    if paths:
        _paths(figure, cells.pop(0), paths)
    for cell, draw in zip(cells, panels, strict=False):
        draw(figure.add_subplot(cell), result)
    return figure


def by_unit(result: Result, _reference: Reference | None = None) -> Figure:
    """A panel for each unit; a vector has one colour and its elements different line styles."""
    every = _panels(result)
    panels = every[:MAX_PANELS]
    columns = 1 if len(panels) == 1 else 2
    rows = -(-len(panels) // columns)
    left_out = sum(len(quantities) for _, quantities in every[MAX_PANELS:])
    title = result.model + (f" (without {left_out} of the quantities)" if left_out else "")
    figure = _figure(title, result, (12, max(4.0, 2.6 * rows)))
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, (unit, quantities) in zip(axes, panels, strict=False):
        if len(quantities) == 1:  # a colour for each element instead
            quantities = [(name, [name]) for name in quantities[0][1]]
        for i, (base, names) in enumerate(quantities):
            for k, name in enumerate(names):
                label = None if k else base if len(names) == 1 else f"{base}[1..{len(names)}]"
                style = ("-", "--", ":", "-.")[k % 4]
                panel.plot(result.time, result[name], style, color=COLORS[i % len(COLORS)], label=label, linewidth=1)
        _finish(panel, "", "" if unit == "1" else unit)
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7)
    for unused in axes[len(panels) :]:
        unused.remove()
    return figure


def _angle(axes: Axes, result: Result) -> None:
    angles = _columns(result, "angle")
    turns = max(np.ptp(angle) for angle in angles.values()) > 4 * np.pi
    shown = {label: angle / (2 * np.pi) if turns else np.degrees(angle) for label, angle in angles.items()}
    _curves(axes, result, shown, "Joint angle", "turns" if turns else "deg")


def _displacement(axes: Axes, result: Result) -> None:
    _lengths(axes, result, "displacement", "Joint displacement")


def _length(axes: Axes, result: Result) -> None:
    _lengths(axes, result, "length", "Length")


def _deflection(axes: Axes, result: Result) -> None:
    _lengths(axes, result, "deflection", "Deflection")


def _lengths(axes: Axes, result: Result, quantity: str, title: str) -> None:
    """Scalars, or the components of vectors, in a readable unit."""
    columns = _columns(result, quantity)
    factor, unit = _length_scale(max(np.abs(values).max() for values in columns.values()))
    shown = {
        label or owner: factor * component
        for owner, values in columns.items()
        for label, component in _components(owner if len(columns) > 1 else "", values)
    }
    _curves(axes, result, shown, title, unit)


def _angular_rate(axes: Axes, result: Result) -> None:
    _curves(axes, result, _columns(result, "angularRate"), "Rate of the joint angle", "rad/s")


def _rate(axes: Axes, result: Result) -> None:
    _curves(axes, result, _columns(result, "rate"), "Rate", "m/s")


def _angular_velocity(axes: Axes, result: Result) -> None:
    velocities = _columns(result, "angularVelocity")
    if len(velocities) == 1:
        (velocity,) = velocities.values()
        _curves(axes, result, dict(_components("", velocity)), "Angular velocity", "rad/s")
    else:
        _curves(axes, result, _sizes(velocities), "Angular speed", "rad/s")


def _modal(axes: Axes, result: Result) -> None:
    for coordinates in _columns(result, "modal").values():
        for i, coordinate in enumerate(coordinates.T, start=1):
            axes.plot(result.time, coordinate, label=f"{i}")
    _finish(axes, "Modes", "m", legend=4)


def _forces(axes: Axes, result: Result) -> None:
    _curves(axes, result, _sizes(_columns(result, "reactionForce")), "Reaction force", "N")


def _support_forces(axes: Axes, result: Result) -> None:
    _curves(axes, result, _sizes(_columns(result, "force")), "Force", "N")


def _joint_forces(axes: Axes, result: Result) -> None:
    _curves(axes, result, _columns(result, "springForce"), "Spring force in the joint", "N")


def _joint_torques(axes: Axes, result: Result) -> None:
    _curves(axes, result, _columns(result, "springTorque"), "Spring torque in the joint", "N m")


def _energy(axes: Axes, result: Result) -> None:
    for kind in ("kinetic", "potential", "total"):
        axes.plot(result.time, result[f"energy.{kind}"], label=kind)
    _finish(axes, "Energy", "J", legend=3)


def _residuals(axes: Axes, result: Result) -> None:
    for i, kind in enumerate(("position", "velocity")):
        residual = result[f"constraint.{kind}Residual"]
        axes.semilogy(result.time, np.maximum(residual, RESIDUAL_FLOOR), label=kind, color=COLORS[i], linewidth=0.9)
    _finish(axes, "Residuals", "SI", legend=2)


OVERVIEW: tuple[tuple[str, Callable[[Axes, Result], None]], ...] = (
    ("angle", _angle),
    ("displacement", _displacement),
    ("deflection", _deflection),
    ("kinetic", _energy),
    ("reactionForce", _forces),
    ("force", _support_forces),
    ("length", _length),
    ("springForce", _joint_forces),
    ("springTorque", _joint_torques),
    ("angularRate", _angular_rate),
    ("rate", _rate),
    ("angularVelocity", _angular_velocity),
    ("modal", _modal),
    ("positionResidual", _residuals),
)
"""Panels by importance, each with the end of the names that it needs."""

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
    """Title, labels and, with `legend` columns, a legend where no curve runs: above the panel, or beside a long one."""
    axes.set_title(title)
    axes.set_ylabel(unit)
    if over_time:
        axes.set_xlabel("time in s")
        axes.margins(x=0)
        axes.set_xlim(left=0)
    if legend and len(axes.get_legend_handles_labels()[0]) > legend:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7, handlelength=1.2)
    elif legend:
        axes.legend(
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=legend,
            borderpad=0.2,
            handlelength=1,
            columnspacing=1,
            fontsize=8,
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
        axes.axhline(stated, color=COLORS[5], linestyle="--", linewidth=1, label="the reference's")
        _finish(axes, f"Error of {name}", "m", legend=1)
        return
    _residuals(axes, result)


def _owners(result: Result, quantity: str) -> dict[str, str]:
    """Names of the recorded scalars and vectors `….quantity`, or with a number `….quantity2`, by labels for them."""
    found = {}
    for base in vectors(result.names):
        if match := re.fullmatch(rf"(.+)\.{quantity}(\d*)", base):
            found[f"{match[1]} {match[2]}".strip()] = base
    return found


def _columns(result: Result, quantity: str) -> dict[str, np.ndarray]:
    """What `_owners` names."""
    return {label: result[base] for label, base in _owners(result, quantity).items()}


def _sizes(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Lengths of vectors; scalars as they are."""
    return {k: np.linalg.norm(v, axis=1) if v.ndim > 1 else v for k, v in columns.items()}


def _curves(axes: Axes, result: Result, columns: Mapping[str, np.ndarray], title: str, unit: str) -> None:
    """Curves over time; of many those that change most."""
    largest = sorted(columns, key=lambda label: -np.ptp(columns[label]))[:MAX_CURVES]
    for label in columns:
        if label in largest:
            axes.plot(result.time, columns[label], label=label, linewidth=1)
    if len(columns) > len(largest):
        title += f" ({len(largest)} of {len(columns)})"
    _finish(axes, title, unit, legend=3)


def _components(owner: str, values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """A scalar under its owner's name, the components of a vector with their axes."""
    if values.ndim == 1:
        return [(owner, values)]
    return [(f"{owner} {axis}".strip(), component) for axis, component in zip(XYZ, values.T, strict=True)]


def _moving(result: Result) -> dict[str, np.ndarray]:
    """Paths of the points that move in a plane or in space; of a flexible body's points those with a name."""
    paths = {name: path for name, path in _columns(result, "position").items() if ".station" not in name}
    largest = max((np.ptp(path, axis=0).max() for path in paths.values()), default=0.0)
    paths = {name: path for name, path in paths.items() if largest and np.ptp(path, axis=0).max() > FLAT * largest}
    return paths if paths and len(_moving_axes(paths)) > 1 else {}


def _moving_axes(paths: Mapping[str, np.ndarray]) -> list[int]:
    extents = np.max([np.ptp(path, axis=0) for path in paths.values()], axis=0)
    return [i for i in range(3) if extents[i] > FLAT * extents.max()]


def _paths(figure: Figure, cell: SubplotSpec, paths: Mapping[str, np.ndarray]) -> None:
    """The longest paths in space, or in the plane in which all points move; a dot marks the end."""
    moving = _moving_axes(paths)
    longest = sorted(paths, key=lambda name: -np.ptp(paths[name], axis=0).max())[:MAX_CURVES]
    if len(moving) == 2:
        axes = figure.add_subplot(cell)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel=f"{XYZ[moving[0]]} in m", ylabel=f"{XYZ[moving[1]]} in m")
    else:
        moving = [0, 1, 2]
        axes = figure.add_subplot(cell, projection="3d")
        axes.set(xlabel="x in m", ylabel="y in m", zlabel="z in m")
        axes.tick_params(labelsize=7)
        axes.locator_params(nbins=4)
    for i, name in enumerate(name for name in paths if name in longest):
        columns = paths[name][:, moving].T
        axes.plot(*columns, color=COLORS[i % len(COLORS)], label=name, linewidth=1)
        axes.plot(*columns[:, -1:], "o", color=COLORS[i % len(COLORS)], markersize=4)
    if len(moving) == 3:
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_box_aspect((1, 1, 1), zoom=0.85)  # the labels have to stay inside
    axes.set_title("Paths" + (f" ({len(longest)} of {len(paths)})" if len(paths) > len(longest) else ""), loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(-0.05, 1.0), fontsize=8, handlelength=1.5)


def _length_scale(largest: float) -> tuple[float, str]:
    """Factor and unit that make lengths up to `largest` metres readable."""
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm")):
        if largest * factor >= 1:
            return factor, unit
    return 1e9, "nm"


def _panels(result: Result) -> list[tuple[str, list[tuple[str, list[str]]]]]:
    """Recorded names as vectors by unit, at most as many vectors in a panel as there are colours."""
    by_unit: dict[str, list[str]] = {}
    for name in result.names:
        by_unit.setdefault(result.units.get(name, ""), []).append(name)
    panels = []
    for unit, names in by_unit.items():
        items = list(vectors(names).items())
        panels += [(unit, items[i : i + len(COLORS)]) for i in range(0, len(items), len(COLORS))]
    return panels
