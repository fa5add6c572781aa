"""What a body of modal data is, as a short text."""

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

from sigmafmu.modes.checks import labels_of
from sigmafmu.modes.data import ModalData


def summary(data: ModalData) -> str:
    """Two lines: sizes, mass, centre of mass and extent."""
    low, high = data.X.min(axis=0), data.X.max(axis=0)
    extent = " × ".join(f"{x:.4g}" for x in high - low)
    center = ", ".join(f"{0.0 if abs(x) < 1e-12 * np.ptp(data.X) else x:.4g}" for x in data.center_of_mass)
    return (
        f"{data.note}\n{len(data.X)} nodes, {data.modes} modes, {data.total_mass:.6g} kg, "
        f"centre of mass ({center}) m, extent {extent} m"
    ).lstrip("\n")


def table(data: ModalData) -> Table:
    """A row for each mode."""
    result = Table(box=box.SIMPLE_HEAD)
    result.add_column("mode")
    for title in ("frequency [Hz]", "modal mass [kg]", "largest displacement [m]", "damping ratio"):
        result.add_column(escape(title), justify="right")
    mass, stiffness = np.diag(data.modal_mass), np.diag(data.K)
    largest = np.linalg.norm(data.Phi, axis=1).max(axis=0)
    damping = np.zeros(data.modes) if data.D is None else np.diag(data.D)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = damping / (2 * np.sqrt(stiffness * mass))
    for j, name in enumerate(labels_of(data)):
        cells = (data.frequencies[j], mass[j], largest[j])
        shown = f"{ratio[j]:.3g}" if np.isfinite(ratio[j]) else ""
        result.add_row(name, *(f"{x:.5g}" for x in cells), shown)
    return result
