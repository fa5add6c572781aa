"""Mode shapes, each in the plane of the body's longest axis and the mode's main direction."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sigmafmu.modes.checks import labels_of
from sigmafmu.modes.data import ModalData
from sigmafmu.plots import COLORS, STYLE, XYZ, save

MAX_MODES = 12
AMPLITUDE = 0.12
"""Largest displacement drawn, in parts of the body's length."""


def draw(data: ModalData, path: Path | str) -> None:
    """Draw the first modes, twelve at most."""
    count = min(data.modes, MAX_MODES)
    columns = min(count, 2 if count <= 4 else 3)
    rows = -(-count // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.2 * columns, 2.3 * rows + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        left_out = f", the first {count} of {data.modes} modes" if count < data.modes else ""
        figure.suptitle(data.note + left_out, x=0.01, ha="left", fontsize=11)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for j in range(count):
            _panel(axes[j], data, j)
        for unused in axes[count:]:
            unused.remove()
        save(figure, path)


def _panel(axes: Axes, data: ModalData, j: int) -> None:
    along = int(np.argmax(np.ptp(data.X, axis=0)))
    across = _main_direction(data, j, along)
    length = np.ptp(data.X[:, along])
    u = data.Phi[:, :, j]
    moved = data.X + u * AMPLITUDE * length / np.linalg.norm(u, axis=1).max()
    size = 10 if len(data.X) < 1000 else 3
    axes.scatter(data.X[:, along], data.X[:, across], s=size / 2, color="#bbbbbb", linewidths=0)
    axes.scatter(moved[:, along], moved[:, across], s=size, c=np.linalg.norm(u, axis=1), cmap="viridis", linewidths=0)
    axes.set_title(f"{labels_of(data)[j]}: {data.frequencies[j]:.4g} Hz", color=COLORS[5])
    axes.set(xlabel=f"{XYZ[along]} in m", ylabel=f"{XYZ[across]} in m")
    axes.set_aspect("equal", adjustable="datalim")


def _main_direction(data: ModalData, j: int, along: int) -> int:
    """The axis other than `along` in which the mode moves most; if it moves in neither, in which the body is wider."""
    others = [axis for axis in range(3) if axis != along]
    motion = np.linalg.norm(data.Phi[:, others, j], axis=0)
    if motion.max() < 1e-9 * np.linalg.norm(data.Phi[:, :, j]):
        motion = np.ptp(data.X[:, others], axis=0)
    return others[int(np.argmax(motion > 0.999 * motion.max()))]
