"""The figure of a Campbell diagram."""

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sigmafmu.linear.campbell import PLANE, Campbell
from sigmafmu.plots import COLORS, STYLE

KINDS = (("forward", COLORS[0]), ("backward", COLORS[1]), ("in a plane, or no whirl", COLORS[5]))

CLOSE = 0.02
"""Of the axis: critical speeds that are closer have one number."""


def figure(campbell: Campbell) -> Figure:
    """Above frequencies with the line of the unbalance and critical speeds, below the growth of the modes."""
    frequencies, speeds = campbell.frequencies(), campbell.speeds
    kind = np.where(np.abs(campbell.whirl) < PLANE, 2, np.where(campbell.whirl > 0, 0, 1))
    if speeds[0] == 0:  # no direction, but those of the modes that begin there
        kind[0] = kind[1]
    with mpl.rc_context(STYLE):
        result = Figure(figsize=(8.0, 7.0), layout="constrained")
        FigureCanvasAgg(result)
        above, below = result.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        for i, (label, color) in enumerate(KINDS):
            for k in range(frequencies.shape[1]):
                chosen = np.isfinite(frequencies[:, k]) & (kind[:, k] == i)
                if chosen.any():
                    above.plot(speeds, np.where(chosen, frequencies[:, k], np.nan), ".-", markersize=3, color=color)
                    below.plot(speeds, np.where(chosen, campbell.poles[:, k].real, np.nan), color=color)
            if (np.isfinite(frequencies) & (kind == i)).any():
                above.plot([], [], color=color, label=label)
        above.plot(speeds, speeds, "--", color=COLORS[3], linewidth=1, label="once per turn")
        told = -np.inf
        for speed in (critical.speed for critical in campbell.critical):
            above.plot(speed, speed, "o", color="black", markersize=5, markerfacecolor="none")
            if speed - told > CLOSE * speeds[-1]:
                above.annotate(f"{speed:.4g}", (speed, speed), (6, -10), textcoords="offset points")
                told = speed
        above.set_title(f"{campbell.model}: frequencies over {campbell.rate}")
        above.set_ylabel("frequency in rad/s")
        above.set_ylim(0, 1.05 * max(np.nanmax(frequencies, initial=0.0), 1e-300))
        above.legend()
        below.axhline(0, color=COLORS[5], linewidth=0.8)
        below.set(xlabel="speed in rad/s", ylabel="growth in 1/s")
        below.set_xlim(speeds[0], speeds[-1])
    return result
