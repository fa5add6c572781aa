"""From a mechanism file to an FMU: the seam between the loader and what packs FMUs."""

from pathlib import Path

from sigmafmu import SigmafmuError
from sigmafmu.mechanism_file.load import MechanismFile


def build_fmu(file: MechanismFile, path: Path) -> None:
    """Write the FMU of a mechanism to `path`.

    `file.definition` becomes resources/mechanism.json, `file.resources` the files beside it. Raises SigmafmuError.
    """
    raise SigmafmuError(f"cannot write {path}: this version checks and runs mechanism files, but packs no FMUs of them")
