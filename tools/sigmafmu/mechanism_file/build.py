"""From a mechanism file to an FMU: what the loader hands to what packs FMUs."""

from pathlib import Path

from sigmafmu import packing
from sigmafmu.mechanism_file.drawing import shapes_of
from sigmafmu.mechanism_file.load import MechanismFile, folder_of


def build_fmu(file: MechanismFile, path: Path) -> None:
    """Write the FMU of a mechanism to `path`; raises SigmafmuError."""
    with folder_of(file.resources) as folder:
        packing.build_fmu(file.definition, path, resources=folder, source=file.path, shapes=shapes_of(file))
