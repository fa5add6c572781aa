"""Figures of the closed loops: with the controller and without."""

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sigmafmu.loop.controllers.axis_attitude import AxisAttitude
from sigmafmu.loop.controllers.magnetic_bearings import MagneticBearings
from sigmafmu.loop.controllers.speed_pi import SpeedPI
from sigmafmu.loop.performance import axis_error, whirl
from sigmafmu.plots import COLORS, STYLE, save
from sigmafmu.result import Result

ON, OFF, WANTED = COLORS[0], COLORS[1], COLORS[5]
SMALLEST_RADIUS = 1e-9
"""m; a radius below this is drawn here: zero has no place on a logarithmic axis."""


def plot(closed: Result, uncontrolled: Result, law: SpeedPI | MagneticBearings | AxisAttitude, path: Path) -> None:
    """Draw the loop of `closed.model`; `law` is the controller with its parameters."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10, 6), layout="constrained")
        FigureCanvasAgg(figure)
        FIGURES[closed.model](figure, closed, uncontrolled, law)
        save(figure, path)


def _speed(figure: Figure, closed: Result, uncontrolled: Result, law: SpeedPI) -> None:
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    above.plot(uncontrolled.time, uncontrolled["crankPivot.angularRate"], color=OFF, linewidth=0.9, label="motor off")
    above.plot(closed.time, closed["crankPivot.angularRate"], color=ON, label="controlled")
    wanted = [law.set_point(t) for t in closed.time]
    above.plot(closed.time, wanted, "--", color=WANTED, linewidth=0.9, label="set point")
    _finish(above, "Crank speed", "rad/s", legend=3)
    below.step(closed.time, closed["crankPivot.motorTorque"], where="post", color=ON)
    _finish(below, "Motor torque", "N m")
    below.set_xlabel("time in s")


def _bearings(figure: Figure, closed: Result, uncontrolled: Result, law: MagneticBearings) -> None:
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.2))
    orbit = figure.add_subplot(grid[:, 0])
    for result, color, label in ((uncontrolled, OFF, "supports alone"), (closed, ON, "with magnetic bearings")):
        y, z = (1e6 * result[f"leftSupport.position[{i}]"] for i in (2, 3))
        orbit.plot(y, z, color=color, linewidth=0.7, label=label)
    orbit.set_aspect("equal", adjustable="datalim")
    orbit.set_xlabel("y in µm")
    _finish(orbit, "Orbit of the left support", "z in µm")
    orbit.legend(loc="best")

    above, below = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    for result, color in ((uncontrolled, OFF), (closed, ON)):
        above.semilogy(
            result.time, 1e6 * np.maximum(whirl(result, "rotor"), SMALLEST_RADIUS), color=color, linewidth=0.9
        )
    above.set_ylim(bottom=0.1)
    above.margins(x=0)
    _finish(above, "Orbit radius of the centre of mass", "µm")
    for side, color in (("left", COLORS[2]), ("right", COLORS[3])):
        below.plot(closed.time, whirl(closed, f"{side}Support", "actuatorForce"), color=color, label=side)
    below.margins(x=0)
    _finish(below, "Bearing force", "N", legend=2)
    below.set_xlabel("time in s")


def _attitude(figure: Figure, closed: Result, uncontrolled: Result, law: AxisAttitude) -> None:
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.2))
    path = figure.add_subplot(grid[:, 0], projection="3d")
    for result, color in ((uncontrolled, OFF), (closed, ON)):
        path.plot(*result["top.position"].T, color=color, linewidth=1)
    path.scatter(*closed["top.position"][0], color="black", s=20, label="start")
    target = np.array([law.values[f"target[{i}]"] for i in (1, 2, 3)])
    path.scatter(*(target / np.linalg.norm(target)), color=WANTED, marker="x", s=40, label="target")
    ticks = (-1, 0, 1)
    path.set(xlabel="x in m", ylabel="y in m", zlabel="z in m", xticks=ticks, yticks=ticks, zticks=ticks)
    path.set_box_aspect((1, 1, 1), zoom=0.9)
    path.set_title("Path of the centre of mass")
    path.legend(loc="upper right")

    above, below = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    for result, color, label in ((uncontrolled, OFF, "torque off"), (closed, ON, "controlled")):
        above.plot(result.time, axis_error(result, law), color=color, label=label)
    _finish(above, "Angle from the target", "°", legend=2)
    for i, (label, torque) in enumerate(zip("xyz", closed["top.torque"].T, strict=True)):
        below.step(closed.time, torque, where="post", color=COLORS[i + 2], label=label)
    _finish(below, "Torque in B, which spins", "N m", legend=3)
    below.set_xlabel("time in s")


FIGURES: dict[str, Callable] = {"SliderCrank": _speed, "HighSpeedRotor": _bearings, "HeavyTop": _attitude}


def _finish(axes: Axes, title: str, unit: str, *, legend: int = 0) -> None:
    """Title, unit and, with `legend` columns, a legend above the panel."""
    axes.set_title(title)
    axes.set_ylabel(unit)
    if legend:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=legend, borderpad=0.2, handlelength=1.5)
