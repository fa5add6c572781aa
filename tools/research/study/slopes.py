"""Triangles that show an order in a figure of errors over step sizes."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

GAP = 2.5
"""Factor between a triangle and the next curve."""


def above(axes: Axes, steps: Sequence[float], curves: Sequence[np.ndarray], order: int, at: int = -3) -> None:
    """A triangle of slope `order` above all `curves`, between the steps number `at` and the next smaller one."""
    near = np.array([errors[at : at + 3 or None] for errors in curves])
    if np.isfinite(near).any():
        right, left = steps[at], steps[at + 1]
        foot = GAP * np.nanmax(near)
        head = foot * (right / left) ** order
        _triangle(axes, [(left, foot), (right, head), (left, head)], order)


def below(axes: Axes, steps: Sequence[float], errors: np.ndarray, order: int, at: int = -3) -> None:
    """A triangle of slope `order` under a curve, between the steps number `at` and the next smaller one."""
    right, left = steps[at], steps[at + 1]
    if np.isfinite(errors[at + 1]):
        foot = errors[at + 1] / GAP
        _triangle(axes, [(left, foot), (right, foot), (right, foot * (right / left) ** order)], order)


def _triangle(axes: Axes, corners: list[tuple[float, float]], order: int) -> None:
    axes.add_patch(Polygon(corners, closed=True, fill=False, edgecolor="0.35", linewidth=0.9))
    x, y = np.exp(np.log(corners).mean(axis=0))
    axes.annotate(f"{order}", (x, y), fontsize=7, ha="center", va="center", color="0.2")
