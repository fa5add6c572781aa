"""Writes models/resources/<Model>/<body>.json, the modal data of the flexible mechanisms.

    .venv/bin/python tools/make_modal_data.py

The first two are what `sigmafmu modes shapes` writes; the third has the eigenmodes of a cantilever as shape functions.
"""

import sys
from pathlib import Path

from research.reference.clouds import SpinUp
from sigmafmu.modes.data import ModalData
from sigmafmu.modes.file import write
from sigmafmu.modes.shapes import shape_modes

RESOURCES = Path(__file__).resolve().parents[1] / "models" / "resources"


def spin_up_beam() -> ModalData:
    """Three eigenmodes of the cantilever, bending in y."""
    spin_up = SpinUp()
    cloud = spin_up.cloud
    return ModalData(
        X=cloud.nodes,
        mass=cloud.masses,
        Phi=cloud.modes,
        K=cloud.stiffness,
        names=tuple(f"y cantilever mode {n + 1}" for n in range(spin_up.modes)),
        note=f"cantilever of Wu and Haug (1988), its first {spin_up.modes} eigenmodes, 41 sections of 4 nodes",
    )


DATA = {
    "FlexiblePendulum/beam.json": lambda: shape_modes("polynomial", 1.0, 1.0, EI=(8.0, 12.0), half_size=(0.02, 0.02)),
    "FlexibleSliderCrank/rod.json": lambda: shape_modes("sine", 0.3, 0.5, EI=(4.0, 6.0), half_size=(0.02, 0.02)),
    "SpinUpBeam/beam.json": spin_up_beam,
}
"""File below models/resources → its data."""


if __name__ == "__main__":
    for name, make in DATA.items():
        path = RESOURCES / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write(make(), path)
        sys.stdout.write(f"wrote {path.relative_to(RESOURCES.parents[1])}\n")
