"""From a mechanism file to an FMU: what the loader hands to what packs FMUs."""

from pathlib import Path

from sigmafmu import SigmafmuError
from sigmafmu.mechanism_file.load import MechanismFile, folder_of


def build_fmu(file: MechanismFile, path: Path) -> None:
    """Write the FMU of a mechanism to `path`; raises SigmafmuError."""
    try:
        from sigmafmu.packing import build_fmu as pack
    except ModuleNotFoundError as error:
        raise SigmafmuError(f"cannot write {path}: this installation has nothing to pack FMUs with") from error
    with folder_of(file.resources) as folder:
        pack(file.definition, path, resources=folder, source=file.path)
